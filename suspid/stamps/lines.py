"""Lines: straight lines through rounded stamps, and the rows that are missing between stretches of one."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from suspid.stamps.rounding import line
from suspid.units import RealArray, Second

# Points that a line must fit before anything is concluded from it; fewer fit by chance.
FEWEST_POINTS = 12
# Points from which lines are sought in one step, and the most points of those lines: more take memory.
LINES_AT_ONCE, LONGEST_LOOK = 1000, 48


def band(step: Second, quantum: Second, jitter: float, times: RealArray) -> Second:
    """Return the width of the band in which the residuals of a clock of that step lie."""
    return float(_bands(np.asarray(step), quantum, jitter, times))


def _bands(step: RealArray, quantum: Second, jitter: float, times: RealArray) -> RealArray:
    return np.asarray(1.01 * np.minimum(quantum, step) + jitter * step + 8 * np.spacing(np.max(np.abs(times))))


def _reach(step: RealArray, span: RealArray, quantum: Second, jitter: float) -> RealArray:
    """Return how far from the step of least squares through that span of rows, that of the narrowest band is sought."""
    return np.asarray(2 * (np.minimum(quantum, step) + jitter * step) / span)


def narrowest_line(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> tuple[Second, Second] | None:
    """Return centre and step of the narrowest band that holds all points, or None if it is wider than allowed."""
    span = float(rows[-1] - rows[0])
    step = line(rows, times)[1]
    if step <= 0:
        return None
    reach = float(_reach(np.asarray(step), np.asarray(span), quantum, jitter))
    off = times - step * rows
    if np.ptp(off) > band(step, quantum, jitter, times) + reach * span:
        return None
    step = float(_narrowest(rows, times, np.asarray(step), np.asarray(reach)))
    off = times - step * rows
    if np.ptp(off) > band(step, quantum, jitter, times):
        return None
    return float(np.max(off) + np.min(off)) / 2, step


def _narrowest(rows: RealArray, times: RealArray, step: RealArray, reach: RealArray) -> RealArray:
    """Return the steps, within reach, of the narrowest bands that hold all points: rows and times (point, …)."""
    low, high = step - reach, step + reach
    # Golden sections to a thousandth of the interval.
    for _ in range(16):
        left, right = low + 0.382 * (high - low), low + 0.618 * (high - low)
        lower = _width(times - left * rows) < _width(times - right * rows)
        low, high = np.where(lower, low, left), np.where(lower, right, high)
    return np.asarray((low + high) / 2)


def _width(off: RealArray) -> RealArray:
    """Return the range of residuals (point, …); np.ptp takes twice the time for a few points."""
    return np.asarray(off.max(axis=0) - off.min(axis=0))


def _is_bent(rows: RealArray, times: RealArray, quantum: Second, jitter: float) -> NDArray[np.bool_]:
    """Return whether some points lie further off the chord of two others than any line allows: (point, …).

    A band of vertical width w holds no point further than w from a chord of two points that it holds.
    """
    size = rows.shape[0]
    x, y = rows - rows[:1], times - times[:1]
    span, width = x[-1], 1.01 * quantum + 8 * np.spacing(np.max(np.abs(times), initial=0.0))
    # The steepest line has a step that is larger than that of the chord by two widths over the span.
    steepest = (y[-1] + 2 * width) / np.maximum(span - 2 * jitter, 0.1 * span)
    widest = (1 + 1e-9) * _bands(steepest, quantum, jitter, times)
    bent = np.zeros(rows.shape[1:], bool)
    for apart in ((size - 1) // 2, size // 4, size // 8, 1):
        last = size - 2 * apart
        if apart < 1 or last < 1:
            continue
        # A few triples of each length: all of them would cost as much as the line.
        some = slice(0, last, max(1, apart // 2))
        left, right = slice(some.start, last, some.step), slice(2 * apart, 2 * apart + last, some.step)
        middle = slice(apart, apart + last, some.step)
        slope = (y[right] - y[left]) / (x[right] - x[left])
        off = np.abs(y[middle] - y[left] - slope * (x[middle] - x[left]))
        bent |= off.max(axis=0) > widest
    return bent


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
    for begin in range(0, rows.size - FEWEST_POINTS + 1, LINES_AT_ONCE):
        starts, known = np.zeros(0, np.intp), 0
        while first < begin + LINES_AT_ONCE:
            longer = max(FEWEST_POINTS, best[1] - best[0] + 1)
            # Only what may be longer than the longest is followed to its end.
            size = min(longer, LONGEST_LOOK)
            if size != known:
                part = slice(max(first, begin), begin + LINES_AT_ONCE + size - 1)
                starts = np.flatnonzero(_fits_each(rows[part], times[part], size, quantum, jitter)) + part.start
                known = size
            starts = starts[starts >= first]
            if starts.size == 0 or rows.size - starts[0] < longer:
                break
            first, after = int(starts[0]), _end(rows, times, int(starts[0]), size, quantum, jitter)
            best, first = max(best, (first, after), key=lambda each: each[1] - each[0]), after
    return best


def _fits_each(rows: RealArray, times: RealArray, size: int, quantum: Second, jitter: float) -> NDArray[np.bool_]:
    """Return whether a line is narrow enough for that number of points from each on, (point,) but the last ones."""
    if rows.size < size:
        return np.zeros(0, bool)
    x, y = (sliding_window_view(each, size).T for each in (rows, times))
    near = ~_is_bent(x, y, quantum, jitter)
    if not np.any(near):
        return near
    x, y = x[:, near], y[:, near]
    x, y = x - np.mean(x, axis=0), y - np.mean(y, axis=0)
    step = np.sum(x * y, axis=0) / np.sum(x * x, axis=0)
    reach = _reach(step, x[-1] - x[0], quantum, jitter)
    off = y - step * x
    fits = _width(off) <= _bands(step, quantum, jitter, times)
    # All points lie within half of the width from the centre of a band: the line of least squares is no further off.
    open_ = ~fits & (4 * np.mean(off**2, axis=0) <= _bands(step + reach, quantum, jitter, times) ** 2)
    x, y = x[:, open_], y[:, open_]
    step = _narrowest(x, y, step[open_], reach[open_])
    fits[open_] = _width(y - step * x) <= _bands(step, quantum, jitter, times)
    near[near] = fits
    return np.asarray(near)


def _end(rows: RealArray, times: RealArray, first: int, fits: int, quantum: Second, jitter: float) -> int:
    """Return the point after the last one of a stretch that one line explains, of whose points the first ones fit.

    The steps whose bands hold the points up to one are an interval within that of the point before: the steps that
    reach furthest are looked for between fewer and fewer others.
    """
    x, y = rows[first:] - rows[first], times[first:] - times[first]
    step = float(np.polynomial.polynomial.polyfit(x[:fits], y[:fits], 1)[1])
    reach = float(_reach(np.asarray(step), x[fits - 1], quantum, jitter))
    low, high, ahead = step - reach, step + reach, fits
    while fits == ahead < x.size:
        ahead = min(2 * ahead, x.size)
        for _ in range(4):
            steps = np.linspace(low, high, 17)[:, None]
            off = y[:ahead] - steps * x[:ahead]
            width = np.maximum.accumulate(off, axis=1) - np.minimum.accumulate(off, axis=1)
            reached = np.sum(width <= _bands(steps, quantum, jitter, times[first : first + ahead]), axis=1)
            furthest = np.flatnonzero(reached == np.max(reached))
            low, high = float(steps[max(furthest[0] - 1, 0), 0]), float(steps[min(furthest[-1] + 1, 16), 0])
            fits = max(fits, int(np.max(reached)))
    return first + fits


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
