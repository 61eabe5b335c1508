"""Rides and tunings as JSON: what ``suspid ride --json`` and ``suspid tune --json`` write.

Every field is described with its unit in ``suspid/reporting/schemas/ride.schema.json`` and ``tune.schema.json`` (JSON
Schema, draft 2020-12), which `json_schema` returns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from suspid.levels import LEVEL
from suspid.model import car_to_toml
from suspid.reporting.json_schema import as_plain
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.performance import Ride, Tuning


def ride_to_dict(found: Ride, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return the figures of a ride with their intervals as plain lists and numbers.

    Examples
    --------
    >>> from suspid import quarter_car, ride
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> content = ride_to_dict(ride(car, road="C", speed=20.0))
    >>> content["figures"][1]["figure"], content["figures"][1]["unit"]
    ('chassis_acceleration.Wk', 'm/s2')
    """
    ends = found.interval(level)
    rows = zip(found.figures, found.units, found.values.tolist(), found.std.tolist(), strict=True)
    return as_plain(
        "suspid ride 1",
        {
            "verdict": found.verdict.to_dict(),
            "level": level,
            "duration_s": found.duration,
            "weightings": {channel: list(kinds) for channel, kinds in found.weightings.items()},
            "figures": [
                {
                    "figure": name, "unit": unit, "value": value, "std": std,
                    "lower": ends[name][0], "upper": ends[name][1],
                }
                for name, unit, value, std in rows
            ],
            "parameters": list(found.parameters),
            "jacobian": found.jacobian.tolist(),
            "covariance": found.covariance.tolist(),
        },
    )  # fmt: skip


def tuning_to_dict(found: Tuning) -> dict[str, object]:
    """Return the cars of a tuning with their figures as plain lists and numbers.

    Examples
    --------
    >>> from suspid import quarter_car, tune
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune(car, parameters=["chassis.damping"], objective=["chassis_acceleration.Wk", "tire.load"],
    ...              road="C", speed=20.0, points=3)
    >>> len(tuning_to_dict(found)["cars"])
    3
    """

    def car(figures: list[float], chosen: list[float]) -> dict[str, object]:
        return {
            "figures": dict(zip(found.figures, figures, strict=True)),
            "parameters": dict(zip(found.parameters, chosen, strict=True)),
        }

    pairs = zip(found.values.tolist(), found.choices.tolist(), found.cars, strict=True)
    return as_plain(
        "suspid tune 1",
        {
            "verdict": found.verdict.to_dict(),
            "objectives": list(found.objectives),
            "units": dict(zip(found.figures, found.units, strict=True)),
            "now": car(found.present.tolist(), found.described.tolist()),
            "knee": found.knee + 1,
            "cars": [{**car(figures, chosen), "toml": car_to_toml(one)} for figures, chosen, one in pairs],
        },
    )
