"""An estimate as JSON: what ``suspid estimate --json`` writes.

Every field is described with its unit in ``suspid/reporting/schemas/estimate.schema.json`` (JSON Schema, draft
2020-12), which `json_schema` returns. The modes in it are those of `suspid identify`.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from suspid.greybox import nominal_value, parameter_unit
from suspid.identification import modes_to_dict, to_json
from suspid.levels import LEVEL
from suspid.model import Suspension
from suspid.reconstruction import parameter_values
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.greybox import Estimate


def estimate_to_dict(found: Estimate, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return an estimate as plain lists and numbers, every bit kept; numbers that are not finite are None.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> found = estimate(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
    >>> estimate_to_dict(found)["masses"]
    [{'name': 'chassis', 'value': 400.0, 'unit': 'kg'}, {'name': 'tire', 'value': 40.0, 'unit': 'kg'}]
    """
    from importlib.metadata import version

    fields = {
        "format": "suspid estimate 1",
        "verdict": found.verdict.to_dict(),
        "level": level,
        "parameters": _parameters(found, level),
        "covariance": found.covariance.tolist(),
        "held": [{"name": n, "value": nominal_value(found.nominal, n), "unit": parameter_unit(n)} for n in found.held],
        "masses": [{"name": name, "value": mass, "unit": "kg"} for name, mass in found.suspension.masses.items()],
        "modes": modes_to_dict(found.modes),
        "records": _records(found),
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "explains": found.explains,
        "alternatives": [_values(found, car) for car in found.alternatives],
        "suspid": version("suspid"),
    }
    plain: dict[str, object] = json.loads(to_json(fields))
    return plain


def _parameters(found: Estimate, level: Ratio) -> list[dict[str, object]]:
    ends, rows = found.interval(level), []
    for name, value, std in zip(found.parameters, found.values.tolist(), found.std.tolist(), strict=True):
        nominal = nominal_value(found.nominal, name)
        low, high = ends[name]
        rows.append(
            {
                "name": name,
                "value": value,
                "unit": parameter_unit(name),
                "std": std,
                "lower": low,
                "upper": high,
                "nominal": nominal,
                "change": value / nominal - 1 if nominal else None,
                "significant": None if nominal is None else not low <= nominal <= high,
            }
        )
    return rows


def _records(found: Estimate) -> list[dict[str, object]]:
    rows = []
    for residual, noise, white in zip(found.residual, found.noise_std, found.whiteness, strict=True):
        signal = as_signal(residual)
        rows.append(
            {
                "samples": signal.values.shape[1],
                "step_s": signal.step,
                "start_s": signal.start,
                "channels": [
                    {"name": name, "noise_std": std, "lag_1_correlation": correlation}
                    for name, std, correlation in zip(signal.channels, noise.tolist(), white.tolist(), strict=True)
                ],
            }
        )
    return rows


def _values(found: Estimate, car: Suspension) -> dict[str, float]:
    values = parameter_values(car)
    return {name: values[name] for name in found.parameters if name in values}
