"""Possible causes of the motion of a car in a record, the likeliest first."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from suspid.errors import InputError
from suspid.greybox.car_records import record_of_car
from suspid.greybox.record_test import RecordTest
from suspid.greybox.trials import given_names
from suspid.greybox.wheels import wheels_missing
from suspid.greybox.whiteness import portmanteau
from suspid.levels import likely
from suspid.model import FORCE, Suspension, force_weights
from suspid.records import inputs_of
from suspid.signals import as_signal
from suspid.units import RealArray


def dies_down(values: RealArray) -> bool:
    """Return whether the last third of a channel (channel, sample) moves less than half as much as the first."""
    first, last = _thirds(values)
    return bool(np.any(last < 0.5 * first))


def swells(values: RealArray) -> bool:
    """Return whether the last third of a channel (channel, sample) moves more than twice as much as the first."""
    first, last = _thirds(values)
    return bool(np.any(last > 2 * first))


def _thirds(values: RealArray) -> tuple[RealArray, RealArray]:
    """Return how much channels move in the first and the last third, as root mean squares."""
    third = max(values.shape[1] // 3, 1)
    moved = values - np.mean(values, axis=1, keepdims=True)
    first, last = (np.sqrt(np.mean(part**2, axis=1)) for part in (moved[:, :third], moved[:, -third:]))
    return first, last


def _known(test: RecordTest, car: Suspension) -> dict[str, RealArray]:
    """Return inputs and channels of a test by name."""
    record = record_of_car(test.record, car)
    signal = as_signal(record)
    return {**inputs_of(record), **dict(zip(signal.channels, signal.values, strict=True))}


def _moves(values: RealArray) -> bool:
    """Return whether a measured cause moves by more than a sensor's noise, which is white."""
    rest = values - np.mean(values)
    statistics, lags = portmanteau(rest[None])
    return bool(np.ptp(values) > 0) and not likely(float(statistics[0]), lags)


def likely_causes(tests: Sequence[RecordTest], suspension: Suspension) -> list[tuple[str, ...]]:
    """Return what `estimate` may take as given, the likeliest first; ``()`` is a free decay.

    Roads and forces that were measured come first if they move: what follows a road that moves is no free decay. One
    that stands still is no cause. Of several tests those without them are free decays; see `under`. A free decay comes
    next, but is none of them where the motion does not die down and other causes were measured.

    Examples
    --------
    >>> from suspid import quarter_car, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> times = np.arange(0, 10, 0.005)
    >>> drive = simulate(car, times, {"road": 0.01 * np.sin(9 * times)}, outputs=["chassis", "tire"])
    >>> likely_causes([RecordTest(record=drive)], car)
    [('road',), ('tire',)]
    """
    known = [_known(test, suspension) for test in tests]
    signals = [as_signal(record_of_car(test.record, suspension)) for test in tests]
    decays = [dies_down(signal.values) for signal in signals]

    def measured(names: Sequence[str]) -> bool:
        """Return whether the tests hold all of some causes; where they hold none, the motion must die down."""
        held = [[name in own for name in names] for own in known]
        return any(map(all, held)) and all(all(one) or (decays[i] and not any(one)) for i, one in enumerate(held))

    roads = suspension.roads if suspension.roads and measured(suspension.roads) else ()
    names = dict.fromkeys(name for own in known for name in own if _is_force(suspension, name))
    forces = tuple(name for name in names if measured([name]))
    exact = [(*roads, *forces)] if forces else []
    exact += [roads] if roads else []
    exact = [cause for cause in exact if any(np.ptp(own[name]) > 0 for own in known for name in cause if name in own)]
    first = [cause for cause in exact if any(_moves(own[name]) for own in known for name in cause if name in own)]
    found = [cause for cause in exact if cause not in first]
    if all(not wheels_missing(suspension, signal.channels) for signal in signals):
        found.append(given_names(("wheels",), suspension))
    free = not (first or found) or any(decays)
    return [*first, *([()] if free else []), *found]


def under(test: RecordTest, cause: Sequence[str], suspension: Suspension) -> RecordTest:
    """Return a test under what it holds of roads and forces; without any of them it is a free decay."""
    known = _known(test, suspension)
    return test if {*cause} & {*suspension.coordinates} else replace(test, given=[n for n in cause if n in known])


def _is_force(car: Suspension, name: str) -> bool:
    """Return whether a channel is named as a force on the car."""
    with suppress(InputError):
        return name.endswith(FORCE) and bool(np.any(force_weights(car, name)))
    return False
