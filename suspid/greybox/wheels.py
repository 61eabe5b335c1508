"""The wheels of a car, and the channels that measure them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension, output_weights
from suspid.units import RealArray


def wheels_of(car: Suspension) -> tuple[str, ...]:
    """Return the coordinates that stand on roads.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> wheels_of(quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                       tire_stiffness=200e3, chassis_damping=1500))
    ('tire',)
    """
    on_road = np.any(car.arms(car.roads) != 0, axis=1)
    stands = np.any(car.arms(car.coordinates)[on_road] != 0, axis=0)
    return tuple(name for name, one in zip(car.coordinates, stands, strict=True) if one)


def shown_by(car: Suspension, channels: Sequence[str]) -> dict[str, tuple[RealArray, RealArray]]:
    """Return what each channel that measures the car shows: weights of the wheels, and of the other coordinates."""
    wheel = np.array([name in wheels_of(car) for name in car.coordinates])
    found = {}
    for channel in channels:
        try:
            weights = output_weights(car, channel)[1]
        except InputError:
            continue
        found[channel] = (weights[wheel], weights[~wheel])
    return found


def wheels_missing(car: Suspension, channels: Sequence[str]) -> tuple[str, ...]:
    """Return the wheels whose motion channels do not show; all of them if other channels would not be left."""
    wheels, seen = wheels_of(car), shown_by(car, channels)
    if not wheels or not seen:
        return wheels
    table = np.array([on_wheels for on_wheels, _ in seen.values()])
    unseen = tuple(name for name, column in zip(wheels, table.T, strict=True) if not np.any(column))
    enough = np.linalg.matrix_rank(table) == len(wheels) and len(seen) > len(wheels)
    return unseen or (() if enough else wheels)


def body_channels(car: Suspension, channels: Sequence[str]) -> tuple[str, ...]:
    """Return the channels that show no wheel."""
    return tuple(name for name, (on_wheels, _) in shown_by(car, channels).items() if not np.any(on_wheels))
