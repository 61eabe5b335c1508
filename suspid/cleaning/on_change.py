"""Encoders that write a row whenever they count on: their motion between the rows, on a uniform clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.nearest import mean_step
from suspid.recordings import RawChannel
from suspid.stamps import SHORTEST
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import Defect, Number

# Rows and levels from which on an encoder is told from a sensor whose samples change by chance, and from a switch.
FEWEST_COUNTS, FEWEST_LEVELS = 100, 10
# Nearly every row is one count from the last: this share may be further away, where counts were lost, and this share
# may repeat it, as a heartbeat does. Counts are whole to a share of one: angles are written with few digits.
LOST, AGAIN, WHOLE = 0.01, 0.05, 0.15
# Rows come at the pace of the motion: the longest twentieth of the steps is this many times the shortest, at least.
UNEVEN = 2.0
# Rows this near to each other, in samples of the uniform clock, are none of a motion.
CLOSEST = 1e-9
# Counts that pass from one sample of the uniform clock to the next, on average: those within have errors of their own.
COUNTS_A_SAMPLE = 4
# Samples of the uniform clock for each row, at most: with a rest far longer than the motion, stamps stay irregular.
MOST_FOR_A_ROW = 10


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Passed:
    """When an angle passes the boundaries between counts."""

    count: float
    timepts: RealArray  # (boundary,)
    angles: RealArray  # (boundary,)
    after: RealArray  # (boundary,): the count after each
    step: float  # between the samples of a uniform clock [s]


def evenly(channels: Sequence[RawChannel]) -> tuple[list[RawChannel], list[Finding]]:
    """Return channels with those that were written on change on a uniform clock, and the findings that say so.

    A row says when an angle passes the boundary between two counts, and until the next row it lies between the
    boundaries of its count: it is interpolated within them.

    Examples
    --------
    >>> fine = np.arange(0, 6, 1e-5)
    >>> counts = np.round(40 * np.exp(-0.3 * fine) * np.cos(8 * fine))
    >>> rows = np.flatnonzero(np.diff(counts, prepend=counts[0]))
    >>> arm = RawChannel(name="arm", unit="", timepts=fine[rows], values=counts[rows], rate=None)
    >>> (even,), (finding,) = evenly([arm])
    >>> off = even.values - 40 * np.exp(-0.3 * even.timepts) * np.cos(8 * even.timepts)
    >>> finding.kind.value, bool(np.max(np.abs(off)) < 0.5), bool(np.sqrt(np.mean(off**2)) < 0.1)
    ('written on change', True, True)
    """
    shared = Counter(id(channel.timepts) for channel in channels)
    out, findings = [], []
    for channel in channels:
        passed = None if shared[id(channel.timepts)] > 1 or channel.rate is not None else _passed(channel)
        if passed is None:
            out.append(channel)
            continue
        numbers: dict[str, Number] = {"count": passed.count, "rate": 1 / passed.step}
        findings.append(found(Defect.ON_CHANGE, channel.timepts, channel.values.size, numbers, channel=channel.name))
        out.append(_evenly(channel, passed))
    return out, findings


# Numbers near the largest and the least that there are, are no counts.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _passed(channel: RawChannel) -> _Passed | None:
    """Return the boundaries that a channel passes where each row is one count on or back, and rows come unevenly."""
    times, values = channel.timepts, channel.values
    if values.size < FEWEST_COUNTS or not (np.all(np.isfinite([times, values])) and np.all(np.diff(times) >= 0)):
        return None
    changes = np.diff(values)
    moves = np.flatnonzero(changes)
    if moves.size < (1 - AGAIN) * changes.size or np.unique(values).size < FEWEST_LEVELS:
        return None
    count = float(np.median(np.abs(changes[moves])))
    counts = np.abs(changes[moves]) / count
    whole = np.all(np.abs(counts - np.maximum(np.round(counts), 1.0)) <= WHOLE)
    # More counts than rows are not lost at once.
    if not whole or np.mean(counts > 1 + WHOLE) > LOST or np.max(counts) > values.size:
        return None
    # Several counts may pass in one tick of the clock: their mean does.
    at, first = np.unique(times[moves + 1], return_index=True)
    several = np.diff(np.append(first, moves.size))
    passed = np.add.reduceat(0.5 * values[moves + 1] + 0.5 * values[moves], first) / several
    short, long = np.quantile(np.diff(at) / several[1:], (0.05, 0.95))
    step = COUNTS_A_SAMPLE * mean_step(np.diff(at)) * at.size / moves.size
    if not long > UNEVEN * short or not SHORTEST < step < at[-1] - at[0] < MOST_FOR_A_ROW * values.size * step:
        return None
    if not np.min(np.diff(at)) > CLOSEST * step:
        return None
    return _Passed(count=count, timepts=at, angles=passed, after=values[moves + 1][first + several - 1], step=step)


def _evenly(channel: RawChannel, passed: _Passed) -> RawChannel:
    """Return a channel on a uniform clock: it passes the boundaries of its counts when its rows say."""
    from scipy.interpolate import CubicSpline

    start, step = passed.timepts[0], passed.step
    # In samples and counts, whatever the units are.
    at = (passed.timepts - start) / step
    even = np.arange(int(at[-1]) + 1)
    held = passed.after[np.searchsorted(at, even, side="right") - 1] / passed.count
    # Turns are round. Where nothing counts for long, what a spline swings on is cut off.
    within = np.clip(CubicSpline(at, passed.angles / passed.count)(even), held - 0.5, held + 0.5)
    return replace(channel, timepts=frozen_real(start + step * even), values=frozen_real(passed.count * within))
