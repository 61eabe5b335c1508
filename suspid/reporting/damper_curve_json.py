"""A damper's curve as JSON.

Every field is described with its unit in ``suspid/reporting/schemas/damper.schema.json`` (JSON Schema, draft 2020-12),
which `json_schema` returns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from suspid.levels import LEVEL
from suspid.reporting.json_schema import as_plain
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.greybox import DamperCurve


def damper_curve_to_dict(found: DamperCurve, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return a damper's curve as plain lists and numbers, every bit kept; numbers that are not finite are None.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import damper_curve, quarter_car, road_profile, simulate
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300, tire_damping=60)
    >>> t = np.arange(0, 12, 0.005)
    >>> road = road_profile(20 * t, roughness="B", rng=np.random.default_rng(1), wavelengths=(0.5, 100.0))
    >>> record = simulate(car, t, {"road": road}, outputs=["chassis_acceleration", "tire_acceleration"],
    ...                   interpolation="cubic")
    >>> content = damper_curve_to_dict(damper_curve(record, car, strut="chassis", nodes=8))
    >>> content["strut"], len(content["nodes"])
    ('chassis', 9)
    """
    low, high = found.interval(level)
    rows = zip(found.velocities, found.forces, found.std, low, high, found.totals, found.total_std, strict=True)
    names = ("velocity", "force", "std", "lower", "upper", "total", "total_std")
    line = found.linear
    fields = {
        "verdict": found.verdict.to_dict(),
        "level": level,
        "strut": found.name,
        "nodes": [dict(zip(names, map(float, row), strict=True)) for row in rows],
        "friction": {"value": found.friction, "std": found.friction_std, "sought": found.friction_sought},
        "stiffness": {"value": found.stiffness, "std": found.stiffness_std},
        "equivalent_damping": {
            "amplitude": 2**0.5 * found.velocity_std,
            "value": found.equivalent_damping(),
            "std": found.equivalent_damping_std(),
        },
        "covariance": found.covariance.tolist(),
        "linear": {
            "accepted": line.accepted,
            "level": line.level,
            "p_value": line.p_value,
            "statistic": line.statistic,
            "freedom": line.freedom,
            "residual_freedom": line.residual_freedom,
        },
        "velocity_std": found.velocity_std,
        "noise_std": list(found.noise_std),
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "explains": found.explains,
        "masses": [{"name": name, "value": mass, "unit": "kg"} for name, mass in found.suspension.masses.items()],
    }
    return as_plain("suspid damper 1", fields)
