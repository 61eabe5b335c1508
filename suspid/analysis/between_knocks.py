"""What lies between knocks: a sensor that is handled before it swings, and caught after it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import level_of
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.used import Used
from suspid.identification import FEWEST_SAMPLES, Identification, Repeats
from suspid.records import cut
from suspid.signals import Signal, as_signal
from suspid.units import Second
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control

# Parts of a record whose roughness is compared, of at least the second number of samples.
ROUGH_PARTS, ROUGH_SAMPLES = 40, 8
# A part is a knock where second differences are this many times (rms) those of the median part. Beats and the first
# swings of a decay are less; a smaller number cuts these off.
KNOCK = 6.0
# What lies between knocks is this share of a record at least.
MOST_BETWEEN = 1 / 3
# What a knock makes decay is larger than this times what moves between knocks: what rests there moves far less.
AS_MUCH = 0.1


def between_knocks(signal: Signal) -> tuple[Second, Second] | None:
    """Return from when to when no channel is knocked; None where none is, or never for long.

    Examples
    --------
    >>> t = np.arange(1000) / 100
    >>> knock = np.where(t > 8, np.random.default_rng(1).standard_normal(1000), 0.0)
    >>> values = (np.sin(3 * t) * np.exp(-0.1 * t) + knock)[None]
    >>> between_knocks(Signal(start=0.0, step=0.01, values=values, channels=("phone",)))
    (0.0, 7.97)
    """
    bends = np.diff(signal.values, 2)
    parts = min(ROUGH_PARTS, bends.shape[1] // ROUGH_SAMPLES)
    if parts < ROUGH_SAMPLES:
        return None
    edges = np.linspace(0, bends.shape[1], parts + 1).astype(int)
    sums = np.add.reduceat(bends**2, edges[:-1], axis=1)
    rough = np.sqrt(sums / np.diff(edges))
    knocked = np.any(rough > KNOCK * np.median(rough, axis=1, keepdims=True), axis=0)
    ends = np.flatnonzero(np.diff(np.concatenate([[True], knocked, [True]]).astype(int)))
    lengths = np.diff(ends)[::2]
    if not knocked.any() or not lengths.size or np.max(lengths) < MOST_BETWEEN * parts:
        return None
    longest = 2 * int(np.argmax(lengths))
    first, last = edges[ends[longest]], edges[ends[longest + 1]]
    # Second differences reach one sample further on either side.
    first, last = (first + 2 if first else 0), (last - 1 if last < bends.shape[1] else last + 1)
    return signal.start + signal.step * int(first), signal.start + signal.step * int(last)


def without_knocks(
    record: control.TimeResponseData,
    found: Identification,
    stretch: Used,
    settings: Settings,
    again: Callable[[control.TimeResponseData], tuple[Identification, Repeats | None, Used]],
) -> tuple[Identification, Used] | None:
    """Return what is found ``again`` between knocks where that is beyond doubt; None if what was found stays.

    That stays if it is beyond doubt itself, unless it is of a knock, and as much moves between.
    """
    if not questioned(found, settings):
        return None
    between = between_knocks(as_signal(record))
    if between is None or (between[1] - between[0]) / as_signal(record).step < FEWEST_SAMPLES:
        return None
    sure = level_of(found, stretch.used, stretch.decays) > Level.DOUBTFUL
    if sure and not _of_a_knock(as_signal(stretch.record), as_signal(record), between):
        return None
    other, repeats, used = again(cut(record, start=between[0], stop=between[1]))
    if repeats is not None or level_of(other, used.used, used.decays) <= Level.DOUBTFUL:
        return None
    note = Remark(Note.BETWEEN_KNOCKS, {"start": between[0], "stop": between[1]})
    return other, replace(used, notes=(note, *used.notes))


def _of_a_knock(part: Signal, record: Signal, between: tuple[Second, Second]) -> bool:
    """Return whether a part of a record lies before or after what is between knocks, and that moves as much."""
    if part.timepts[0] < between[1] and part.timepts[-1] > between[0]:
        return False
    inside = record.values[:, (record.timepts >= between[0]) & (record.timepts <= between[1])]
    rows = [record.channels.index(name) for name in part.channels]
    return bool(np.any(np.ptp(inside[rows], axis=1) > AS_MUCH * np.ptp(part.values, axis=1)))
