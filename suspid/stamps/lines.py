"""Lines: straight lines through rounded stamps, and the rows that are missing between stretches of one."""

from __future__ import annotations

import numpy as np

from suspid.stamps.rounding import line
from suspid.units import RealArray, Second

# Points that a line must fit before anything is concluded from it; fewer fit by chance.
FEWEST_POINTS = 12


def band(step: Second, quantum: Second, jitter: float, times: RealArray) -> Second:
    """Return the width of the band in which the residuals of a clock of that step lie."""
    return 1.01 * min(quantum, step) + jitter * step + 8 * float(np.spacing(np.max(np.abs(times))))


def narrowest_line(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> tuple[Second, Second] | None:
    """Return centre and step of the narrowest band that holds all points, or None if it is wider than allowed."""
    span = float(rows[-1] - rows[0])
    step = line(rows, times)[1]
    if step <= 0:
        return None
    reach = 2 * (min(quantum, step) + jitter * step) / span
    off = times - step * rows
    if np.ptp(off) > band(step, quantum, jitter, times) + reach * span:
        return None
    low, high = step - reach, step + reach
    # Golden sections to a thousandth of the interval.
    for _ in range(16):
        left, right = low + 0.382 * (high - low), low + 0.618 * (high - low)
        low, high = (low, right) if np.ptp(times - left * rows) < np.ptp(times - right * rows) else (left, high)
    step = (low + high) / 2
    off = times - step * rows
    if np.ptp(off) > band(step, quantum, jitter, times):
        return None
    return float(np.max(off) + np.min(off)) / 2, step


def missing_rows(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> RealArray | None:
    """Return how many rows are missing before each point, or None if gaps do not explain the stamps."""
    first, after = _longest(rows, times, quantum, jitter)
    if after - first < FEWEST_POINTS:
        return None
    right = _follow(rows[first:], times[first:], after - first, quantum, jitter)
    left = _follow(-rows[:after][::-1], -times[:after][::-1], after - first, quantum, jitter)
    if right is None or left is None:
        return None
    missing = np.concatenate([-left[after - first :][::-1], right])
    return np.asarray(missing - missing[0])


def _longest(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> tuple[int, int]:
    """Return the first point, and the one after the last, of the longest stretch that one line explains."""
    best, first = (0, 0), 0
    while rows.size - first > best[1] - best[0]:
        size = FEWEST_POINTS
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
    return narrowest_line(rows[part], times[part], quantum, jitter) is not None


def _follow(rows: RealArray, times: RealArray, known: int, quantum: Second, jitter: float) -> RealArray | None:
    """Return how many rows are missing before each point, where none is before the first ``known`` ones."""
    missing = np.zeros(rows.size)
    since = known
    while True:
        fitted = narrowest_line(rows[:known] + missing[:known], times[:known], quantum, jitter)
        if fitted is None:
            return None
        centre, step = fitted
        if known == rows.size:
            return missing
        # The fitted points know the step well enough for a quarter as many beyond them.
        ahead = min(rows.size, known + max(FEWEST_POINTS, int(0.25 * known)))
        reach = 0.5 * band(step, quantum, jitter, times) + 0.25 * min(quantum, step)
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
            # The row that was missing is looked for among these points before the jump.
            low = max(since, at - 1000)
            back = times[low:at] - centre - step * (rows[low:at] + missing[low:at]) - 0.5 * jump * step
            nearer = np.cumsum(back[::-1])
            earlier = int(np.argmax(nearer)) + 1 if back.size and np.max(nearer) > 0 else 0
            missing[at - earlier :] += jump
            since = at
        known = ahead
