"""What may have moved a car: causes that records show, the likeliest first."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from suspid.errors import InputError
from suspid.greybox.car_records import record_of_car
from suspid.greybox.trials import RecordTest, given_names
from suspid.greybox.wheels import wheels_missing
from suspid.model import FORCE, Suspension, force_weights
from suspid.signals import Signal, as_signal
from suspid.units import RealArray


def dies_down(values: RealArray) -> bool:
    """Return whether the last third of a channel (channel, sample) moves less than half as much as the first."""
    third = max(values.shape[1] // 3, 1)
    moved = values - np.mean(values, axis=1, keepdims=True)
    first, last = (np.sqrt(np.mean(part**2, axis=1)) for part in (moved[:, :third], moved[:, -third:]))
    return bool(np.any(last < 0.5 * first))


def _forces(car: Suspension, signals: Sequence[Signal]) -> tuple[str, ...]:
    """Return the channels of all records that are named as forces on the car."""
    found = []
    for name in signals[0].channels:
        if name.endswith(FORCE) and all(name in signal.channels for signal in signals):
            with suppress(InputError):
                force_weights(car, name)
                found.append(name)
    return tuple(found)


def likely_causes(tests: Sequence[RecordTest], suspension: Suspension) -> list[tuple[str, ...]]:
    """Return what `estimate` may take as given, the likeliest first; ``()`` is a free decay.

    A free decay comes first, but is none of them where the motion does not die down and roads or wheels were measured.

    Examples
    --------
    >>> from suspid import quarter_car, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> times, heights = np.arange(0, 10, 0.005), 0.01 * np.random.default_rng(1).standard_normal(2000)
    >>> drive = simulate(car, times, {"road": heights}, outputs=["chassis", "tire"])
    >>> likely_causes([RecordTest(record=drive)], car)
    [('tire',)]
    """
    signals = [as_signal(record_of_car(test.record, suspension)) for test in tests]
    found = []
    forces = _forces(suspension, signals)
    if forces:
        roads = [name for name in suspension.roads if all(name in signal.channels for signal in signals)]
        found.append((*roads, *forces))
    if suspension.roads and all(set(suspension.roads) <= set(signal.channels) for signal in signals):
        found.append(given_names(("roads",), suspension))
    if all(not wheels_missing(suspension, signal.channels) for signal in signals):
        found.append(given_names(("wheels",), suspension))
    return [(), *found] if not found or any(dies_down(signal.values) for signal in signals) else found
