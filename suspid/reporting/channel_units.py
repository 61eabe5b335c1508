"""Units of the channels of an estimate, from what they measure in its car."""

from __future__ import annotations

from suspid.errors import InputError
from suspid.model import FORCE, Suspension, output_weights
from suspid.performance import ANGLES

# What an order of derivative adds to the unit.
PER_ORDER = ("", "/s", "/s²")


def channel_unit(car: Suspension, channel: str) -> str:
    """Return the unit of a channel; "SI" of one that the car does not know.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> [channel_unit(car, name) for name in ("chassis", "tire_velocity", "tire_acceleration", "speed")]
    ['m', 'm/s', 'm/s²', 'SI']
    """
    try:
        order, weights, _ = output_weights(car, channel)
    except InputError:
        return "SI"
    moved = [name for name, weight in zip(car.coordinates, weights.tolist(), strict=True) if weight]
    turns = bool(moved) and all(name in ANGLES for name in moved)
    return ("rad" if turns else "m") + PER_ORDER[order]


def gain_unit(car: Suspension, channel: str, cause: str) -> str:
    """Return the unit of the response of a channel to a cause: a force, a road or another channel.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> [gain_unit(car, "chassis_acceleration", cause) for cause in ("tire_acceleration", "road", "tire_force")]
    ['1', '(m/s²)/m', '(m/s²)/N']
    """
    above, below = (channel_unit(car, name) for name in (channel, cause))
    below = "N" if cause.endswith(FORCE) else below
    return "1" if above == below else "/".join(f"({unit})" if "/" in unit else unit for unit in (above, below))
