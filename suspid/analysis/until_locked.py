"""The motion until friction locks one mass to another: from there on fewer modes are left."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import level_of, settled
from suspid.analysis.explained_parts import explains_swings, shortened, used_instead
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.used import Used
from suspid.decays import at_rest_from, finest, releases_before, rest_of
from suspid.identification import FEWEST_SAMPLES, Identification
from suspid.records import of_channels
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.words import Level, Note

if TYPE_CHECKING:
    import control

# What rests, or moves as one, does so at most for this share of a record.
AS_ONE_AFTER = 0.97
# Channels of which each pair is compared, at most: the first ones.
MOST_COMPARED = 6
# What stops moves by this many times as much before as its steps.
MOVED_BEFORE = 30.0


def until_locked(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the motion until a channel stops, or two move as one, if it is explained down to its noise.

    Friction in a strut lets two masses move against each other until it locks them. What goes on is another structure,
    and no fit explains both. ``found`` is what the search for decays led to: nothing else is tried where that leaves
    only noise and begins before the strut is locked. What has fewer modes is not used, nor as many where what begins
    before it is not doubtful.
    """
    if not questioned(found, settings):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal, start = as_signal(record), as_signal(stretch.record).start
    last = min(_stops(signal), default=signal.values.shape[1])
    locked = _time(signal, last)
    if last == signal.values.shape[1] or (settled(found) and start < locked):
        return None
    begins = min((*releases_before(signal, locked), start))
    clear = start < locked and level_of(found, stretch.used, stretch.decays) > Level.DOUBTFUL
    least = max(1, len(found.modes) + clear)
    for part, moved in shortened(record, begins, _time(signal, last - 1), settings):
        if moved is None or len(moved.modes) < least:
            return None
        if explains_swings(moved):
            return used_instead(stretch, part, moved, Note.UNTIL_LOCKED)
    return None


def _stops(signal: Signal) -> Iterator[int]:
    """Yield the samples from which on a channel rests, or two move as one, where each moved much further before."""
    steps = finest(signal.values)
    channels = range(min(len(signal.channels), MOST_COMPARED))
    yield from (_stop(signal.values[k], steps[k]) for k in range(len(signal.channels)))
    yield from (_stop(signal.values[i] - signal.values[k], steps[i] + steps[k]) for i, k in combinations(channels, 2))


def _stop(values: RealArray, step: float) -> int:
    """Return the sample from which on a motion rests within its steps or its noise; the number of samples without."""
    size = len(values)
    within = at_rest_from(values[None], np.array([step]))
    if np.ptp(values) <= MOVED_BEFORE * step:
        return size
    rests = within if size - within > FEWEST_SAMPLES and within > (1 - AS_ONE_AFTER) * size else size
    return min(rests, size - rest_of(values[None, ::-1], most=AS_ONE_AFTER))


def _time(signal: Signal, sample: int) -> Second:
    return signal.start + signal.step * sample
