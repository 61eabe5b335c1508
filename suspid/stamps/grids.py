"""Grids: the uniform clock behind stamps whose rounding is not small beside the step, with rows missing or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.signals import JITTER
from suspid.stamps.rounding import Indices, line, resolution
from suspid.units import RealArray, Second

# Width that the band of residuals may have beyond the rounding, in steps, tried in this order. One row missing
# in the middle of a record widens the narrowest band by half a step: gaps are looked for before more is allowed.
JITTERS = ((0.0, 0.2, 0.4), (0.8,))
# Points that a line must fit before anything is concluded from it; fewer fit by chance.
FEWEST = 12
# Points looked at beyond the fitted ones, as a share of these: the step is known well enough for that.
AHEAD = 0.25
# Points before a jump among which the row that was missing is looked for.
NEARBY = 1000
# Gaps a row: above this share, it is not the rows that are missing, but the step that is wrong.
MOST_GAPS = 0.1
# Where the usual step is the resolution itself, a longer step is either a missing row or the beat of another rate with
# the rounding. One or two say nothing about that, and rows are taken to be missing. Of more, a line of another rate
# explains about half if they are random; it must explain all but a quarter to be preferred.
FEW_HOLES, UNEXPLAINED = 2, 0.25


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Grid:
    """A uniform clock that rounds to given stamps.

    Parameters
    ----------
    start, step : float
        Time of the first row, and sampling step [s].
    step_std : float
        Standard deviation of the step [s]: that of a uniform distribution over all steps that round to the stamps.
    places : ndarray (row,)
        Sample of the clock that each row is; the first is 0.
    resolution : float
        Step to which the stamps are rounded [s].
    jitter : float
        Share of the step by which the stamps stray beyond their rounding, from end to end; 0 where rounding
        explains them all.
    """

    start: Second
    step: Second
    step_std: Second
    places: Indices
    resolution: Second
    jitter: float


def grid_of(stamps: RealArray) -> Grid | None:
    """Return the uniform clock with the fewest missing rows that rounds to the stamps, or None if there is none.

    A straight line is fitted first; only rows that lie off it by more than the rounding are a gap. Where several
    rows share a stamp, the first of each says the time to within one step; the others say nothing more.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times that do not decrease [s].

    Examples
    --------
    >>> rows = np.delete(np.arange(4000), [1000, 1001, 1002])
    >>> grid = grid_of(np.round(rows / 887.14, 3))
    >>> f"{1 / grid.step:.2f} Hz", bool(np.all(grid.places == rows))
    ('887.14 Hz', True)
    """
    steps = np.diff(stamps)
    if stamps.size < FEWEST or np.any(steps < 0) or not stamps[-1] > stamps[0]:
        return None
    changed = np.flatnonzero(steps > 0) + 1
    quantum = _quantum(stamps, steps[changed - 1])
    points = np.arange(stamps.size) if changed.size == steps.size else changed
    if points.size < FEWEST or quantum <= JITTER * float(np.median(steps[changed - 1])):
        return None
    rows, times = points.astype(float), stamps[points]
    holes = _holes(steps, quantum)
    if holes is not None:
        missing = _missing(rows, times, quantum, 0.0)
        beats = missing is not None and _gaps(missing) <= UNEXPLAINED * _gaps(holes) and _gaps(holes) > FEW_HOLES
        return _grid(stamps, points, missing if beats and missing is not None else holes, quantum, 0.0)
    for jitters in JITTERS:
        for jitter in jitters:
            if _line(rows, times, quantum, jitter) is not None:
                return _grid(stamps, points, np.zeros(rows.size), quantum, jitter)
        for jitter in jitters:
            missing = _missing(rows, times, quantum, jitter)
            grid = None if missing is None else _grid(stamps, points, missing, quantum, jitter)
            if grid is not None:
                return grid
    return None


def _gaps(missing: RealArray) -> int:
    return int(np.sum(np.diff(missing) > 0))


def _holes(steps: RealArray, quantum: Second) -> RealArray | None:
    """Return how many rows are missing before each, if the step is the resolution itself but for a few holes."""
    ratio = np.round(steps / quantum)
    if np.any(ratio < 1) or np.mean(ratio > 1) > MOST_GAPS:
        return None
    return np.concatenate([[0.0], np.cumsum(ratio - 1)])


def _quantum(stamps: RealArray, steps: RealArray) -> Second:
    """Return the step to which stamps are rounded, from zero or from the first one, decimal or not."""
    quantum = max(resolution(stamps), resolution(stamps - stamps[0]))
    least = float(np.min(steps))
    ticks = steps / least
    if steps.size < 0.5 * stamps.size and np.all(np.abs(ticks - np.round(ticks)) < JITTER):
        return max(quantum, least)
    return quantum


def _missing(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> RealArray | None:
    """Return how many rows are missing before each point, or None if gaps do not explain the stamps."""
    first, after = _longest(rows, times, quantum, jitter)
    if after - first < FEWEST:
        return None
    right = _follow(rows[first:], times[first:], after - first, quantum, jitter)
    left = _follow(-rows[:after][::-1], -times[:after][::-1], after - first, quantum, jitter)
    if right is None or left is None:
        return None
    missing = np.concatenate([-left[after - first :][::-1], right])
    return np.asarray(missing - missing[0])


def _band(step: Second, quantum: Second, jitter: float, times: RealArray) -> Second:
    """Return the width of the band in which the residuals of a clock of that step lie."""
    return 1.01 * min(quantum, step) + jitter * step + 8 * float(np.spacing(np.max(np.abs(times))))


def _line(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> tuple[Second, Second] | None:
    """Return centre and step of the narrowest band that holds all points, or None if it is wider than allowed."""
    span = float(rows[-1] - rows[0])
    step = line(rows, times)[1]
    if step <= 0:
        return None
    reach = 2 * (min(quantum, step) + jitter * step) / span
    off = times - step * rows
    if np.ptp(off) > _band(step, quantum, jitter, times) + reach * span:
        return None
    low, high = step - reach, step + reach
    # Golden sections to a thousandth of the interval.
    for _ in range(16):
        left, right = low + 0.382 * (high - low), low + 0.618 * (high - low)
        low, high = (low, right) if np.ptp(times - left * rows) < np.ptp(times - right * rows) else (left, high)
    step = (low + high) / 2
    off = times - step * rows
    if np.ptp(off) > _band(step, quantum, jitter, times):
        return None
    return float(np.max(off) + np.min(off)) / 2, step


def _longest(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> tuple[int, int]:
    """Return the first point, and the one after the last, of the longest stretch that one line explains."""
    best, first = (0, 0), 0
    while rows.size - first > best[1] - best[0]:
        size = FEWEST
        while first + size < rows.size and _fits(rows, times, first, first + size, quantum, jitter):
            size *= 2
        fits, fails = size // 2, min(size, rows.size - first + 1)
        while fails - fits > 1:
            middle = (fits + fails) // 2
            if _fits(rows, times, first, first + middle, quantum, jitter):
                fits = middle
            else:
                fails = middle
        if fits > best[1] - best[0]:
            best = (first, first + fits)
        first += max(fits, 1)
    return best


def _fits(rows: RealArray, times: RealArray, first: int, after: int, quantum: Second, jitter: float) -> bool:
    part = slice(first, after)
    return _line(rows[part], times[part], quantum, jitter) is not None


def _follow(rows: RealArray, times: RealArray, known: int, quantum: Second, jitter: float) -> RealArray | None:
    """Return how many rows are missing before each point, where none is before the first ``known`` ones."""
    missing = np.zeros(rows.size)
    since = known
    while True:
        fitted = _line(rows[:known] + missing[:known], times[:known], quantum, jitter)
        if fitted is None:
            return None
        centre, step = fitted
        if known == rows.size:
            return missing
        ahead = min(rows.size, known + max(FEWEST, int(AHEAD * known)))
        reach = 0.5 * _band(step, quantum, jitter, times) + 0.25 * min(quantum, step)
        at = known
        while True:
            off = times[at:ahead] - centre - step * (rows[at:ahead] + missing[at:ahead])
            if np.any(off < -reach) and not np.any(off[: int(np.argmax(off < -reach))] > reach):
                return None
            if not np.any(off > reach):
                break
            k = int(np.argmax(off > reach))
            # The fewest rows: if there are more, the points that follow say so.
            jump = max(1.0, float(np.ceil((off[k] - reach) / step)))
            at += k
            # The residuals of the rows before the jump may already be nearer to those after it.
            low = max(since, at - NEARBY)
            back = times[low:at] - centre - step * (rows[low:at] + missing[low:at]) - 0.5 * jump * step
            nearer = np.cumsum(back[::-1])
            earlier = int(np.argmax(nearer)) + 1 if back.size and np.max(nearer) > 0 else 0
            missing[at - earlier :] += jump
            since = at
        known = ahead


def _merge(before: RealArray, stamps: RealArray, step: Second, lowest: Second, quantum: Second) -> None:
    """Join gaps, given as rows missing before each row, that can as well be one."""
    lowest = lowest - max(0.0, quantum - step)
    places = np.arange(stamps.size) + np.cumsum(before)
    gaps = np.flatnonzero(before)
    for one, other in zip(gaps[:-1][::-1], gaps[1:][::-1], strict=True):
        between = slice(one, other)
        if np.min(stamps[between] - step * (places[between] + before[other])) >= lowest:
            places[between] += before[other]
            before[one] += before[other]
            before[other] = 0.0


def _grid(stamps: RealArray, points: Indices, missing: RealArray, quantum: Second, jitter: float) -> Grid | None:
    """Return the grid of points of which it is known how many rows are missing before each."""
    rows = points + missing
    times = stamps[points]
    fitted = _line(rows, times, quantum, jitter)
    if fitted is None:
        return None
    step = fitted[1]
    ends = []
    for side in (-1, 1):
        inside, outside = step, step + side * 4 * (min(quantum, step) + jitter * step) / float(rows[-1] - rows[0])
        for _ in range(14):
            middle = (inside + outside) / 2
            fits = np.ptp(times - middle * rows) <= _band(middle, quantum, jitter, times)
            inside, outside = (middle, outside) if fits else (inside, middle)
        ends.append(inside)
    step = (ends[0] + ends[1]) / 2
    before = np.zeros(stamps.size)
    before[points] = np.diff(missing, prepend=0.0)
    _merge(before, stamps, step, fitted[0] - 0.5 * _band(step, quantum, jitter, times), quantum)
    if np.sum(before > 0) > max(FEW_HOLES, MOST_GAPS * points.size):
        return None
    places = (np.arange(stamps.size) + np.cumsum(before)).astype(np.intp)
    off = stamps - step * places
    start = float(np.max(off) + np.min(off)) / 2
    if np.max(np.abs(off - off[0])) <= 0.505 * quantum:
        start = float(off[0])
    return Grid(
        start=start,
        step=step,
        step_std=(ends[1] - ends[0]) / np.sqrt(12),
        places=places,
        resolution=quantum,
        jitter=jitter,
    )
