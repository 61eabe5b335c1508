"""A damper's curve as JSON.

Every field is described with its unit in ``suspid/reporting/schemas/damper.schema.json`` (JSON Schema, draft 2020-12),
which `json_schema` returns. `read_curves` reads the curves of a drive back, with their verdict in words.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import parsed_json, printable, read_text
from suspid.greybox import DamperCurve, LineTest
from suspid.levels import LEVEL
from suspid.model import Suspension, car_from_toml
from suspid.reporting.json_schema import as_plain
from suspid.units import Ratio
from suspid.values import frozen_real
from suspid.words import Check, EstimateCheck, Level, Remark, Verdict


@explained
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
        "following": None if math.isnan(found.following) else found.following,
        "followed": None if math.isnan(found.followed) else found.followed,
        "explains": found.explains,
        "masses": [{"name": name, "value": mass, "unit": "kg"} for name, mass in found.suspension.masses.items()],
    }
    return as_plain("suspid damper 1", fields)


def read_curves(path: str | os.PathLike[str]) -> tuple[DamperCurve, ...]:
    """Return the curves of dampers that ``suspid drive --json`` wrote; none of another file's JSON.

    Raises
    ------
    InputError
        If the file cannot be read or a curve is not complete.
    """
    content = parsed_json(read_text(Path(path)))
    curves, estimate = content.get("curves"), content.get("estimate")
    if not curves or not isinstance(estimate, dict):
        return ()
    try:
        car = car_from_toml(estimate["car"]["nominal"])
        return tuple(_curve(one, car) for one in curves) if isinstance(curves, list) else ()
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"has no complete curve of a damper ({printable(str(error))}); write it again with suspid drive --json"
        ).about(printable(str(path))) from None


def _curve(content: Mapping[str, Any], car: Suspension) -> DamperCurve:
    nodes, line, verdict = content["nodes"], content["linear"], content["verdict"]
    said = [Check(_said(one), Level[one["level"].upper()]) for one in verdict["checks"]]
    covariance = np.array(content["covariance"], float)
    if covariance.shape != (len(nodes) + 2, len(nodes) + 2) or not np.all(np.isfinite(covariance)):
        raise ValueError(f"its covariance has the shape {covariance.shape} for {len(nodes)} nodes")
    return DamperCurve(
        name=content["strut"],
        suspension=car,
        velocities=frozen_real([node["velocity"] for node in nodes]),
        forces=frozen_real([node["force"] for node in nodes]),
        friction=float(content["friction"]["value"]),
        friction_sought=bool(content["friction"]["sought"]),
        stiffness=float(content["stiffness"]["value"]),
        covariance=frozen_real(covariance),
        linear=LineTest(
            **{name: line[name] for name in ("statistic", "freedom", "residual_freedom", "p_value", "level")}
        ),
        velocity_std=float(content["velocity_std"]),
        noise_std=tuple(content["noise_std"]),
        chi_square=float(content["chi_square"]),
        freedom=int(content["freedom"]),
        following=float("nan") if content.get("following") is None else float(content["following"]),
        followed=float("nan") if content.get("followed") is None else float(content["followed"]),
        explains=bool(content["explains"]),
        verdict=Verdict(_said(verdict["headline"]), tuple(said)),
    )


def _said(content: Mapping[str, Any]) -> Remark:
    return Remark(EstimateCheck.SAID, {"text": content["text"]})
