"""Stamps: how they are rounded, the grids that they round, and whether samples follow them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import RecordError
from suspid.signals import JITTER, uniform_step
from suspid.units import RealArray, Second

Indices: TypeAlias = NDArray[np.intp]

# Stamps further than this many steps apart have rows missing between them.
HOLE = 1.5
# Stamps that stand twice in a clock that is exact, as a share of all.
FEW = 0.01
# Rows that may share a stamp for being rounded.
COARSE = 20


def resolution(stamps: RealArray) -> Second:
    """Return the decimal or binary step to which the stamps are rounded [s].

    Examples
    --------
    >>> resolution(np.array([0.0, 0.003, 0.005])), resolution(np.array([0.0, 0.25, 0.45]))
    (0.001, 0.05)
    """
    largest = float(np.max(np.abs(stamps)))
    slack = max(1e-12, 4 * float(np.spacing(largest)))
    some = stamps[:: max(1, stamps.size // 4096)]
    decimal = 0.0
    for quantum in (m * 10.0**-k for k in range(10) for m in (1, 0.5, 0.2)):
        for part in (some, stamps):
            if not np.all(np.abs(part - np.round(part / quantum) * quantum) <= slack):
                break
        else:
            decimal = quantum
            break
    with np.errstate(over="ignore"):
        single = bool(np.all(stamps == stamps.astype(np.float32)))
    return max(decimal, float(np.spacing(np.float32(largest))) if single else 0.0, 2 * float(np.spacing(largest)))


def is_uniform(stamps: RealArray) -> bool:
    """Return whether stamps are a uniform grid already."""
    try:
        uniform_step(stamps)
    except RecordError:
        return False
    return True


def exact(steps: RealArray) -> bool:
    """Return whether all steps are whole multiples of one, nearly always one of it: nothing but rows is missing."""
    usual = float(np.median(steps))
    if usual <= 0 or np.mean(steps == 0) > FEW:
        return False
    ratio = steps / usual
    return bool(np.all(np.abs(ratio - np.round(ratio)) < JITTER) and np.mean(steps <= HOLE * usual) > 0.9)


def line(index: Indices, times: RealArray) -> tuple[Second, Second, Second]:
    """Return start, step and the std of the step of the line through the stamps, outliers left out."""
    kept = np.ones(times.size, bool)
    start = step = std = 0.0
    for _ in range(4):
        centre = np.mean(index[kept])
        power = float(np.sum((index[kept] - centre) ** 2))
        step = float(np.sum((index[kept] - centre) * times[kept]) / power)
        start = float(np.mean(times[kept]) - step * centre)
        off = np.abs(times - (start + step * index))
        std = float(np.sqrt(np.mean(off[kept] ** 2) / power))
        inside = off <= 8 * np.median(off) + 1e-12 * abs(step)
        if np.array_equal(inside, kept) or np.sum(inside) < 0.9 * times.size:
            break
        kept = inside
    return start, step, std


def rounded_line(index: Indices, stamps: RealArray) -> tuple[Second, Second, Second] | None:
    """Return start, step and std of the step of all grids that round to the stamps, or None if there is none.

    A grid rounds to the stamps if none lies further off than half their resolution. Its step then lies in an
    interval; the middle is returned, and the std of a uniform distribution over it. (The errors of rounding are
    no noise: they beat against the grid, and the spread about a line through them says too little.)
    """
    quantum = resolution(stamps)
    if exact(np.diff(stamps)):
        return None
    step = line(index, stamps)[1]
    if not 1e-6 * step < quantum < COARSE * step:
        return None
    span = float(index[-1] - index[0])

    def width(step: Second) -> Second:
        off = stamps - step * index
        return float(np.max(off) - np.min(off)) - 1.01 * quantum - 8 * float(np.spacing(np.max(np.abs(stamps))))

    low, high = step - 2 * quantum / span, step + 2 * quantum / span
    # Golden sections to a thousandth of the interval; where doubles are coarser than that, it would never be reached.
    for _ in range(18):
        left, right = low + 0.382 * (high - low), low + 0.618 * (high - low)
        low, high = (low, right) if width(left) < width(right) else (left, high)
    best = (low + high) / 2
    if width(best) > 0:
        return None
    ends = []
    for side in (-1, 1):
        inside, outside = best, best + side * 2 * quantum / span
        for _ in range(14):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if width(middle) <= 0 else (inside, middle)
        ends.append(inside)
    step = (ends[0] + ends[1]) / 2
    off = stamps - step * index
    start = float(np.max(off) + np.min(off)) / 2
    if np.max(np.abs(off - off[0])) <= 0.505 * quantum:
        start = float(off[0])
    return start, step, (ends[1] - ends[0]) / np.sqrt(12)


def share_followed(values: RealArray, off: RealArray, places: Indices) -> tuple[float, float]:
    """Return how far the samples follow the stamps off the grid, 0 not at all and 1 all the way, and its std.

    The cubic through two neighbours on each side misses a sample of a smooth motion by its slope times
    how far its time lies off those of its neighbours: the regression on that is the share. In noise it tends
    to zero.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    off : ndarray (row,)
        Stamps less their places in the grid [steps].
    places : ndarray (row,)
        Places in the grid; only where five follow each other is anything counted.
    """
    whole = np.flatnonzero(places[4:] - places[:-4] == 4)
    whole = whole[:: max(1, whole.size // 200_000)]
    before, last, now, after, second = (values[:, whole + k] for k in range(5))
    missed = now - (4 * (last + after) - before - second) / 6
    slope = (8 * (after - last) - (second - before)) / 12
    lead = off[whole + 2] - (4 * (off[whole + 1] + off[whole + 3]) - off[whole] - off[whole + 4]) / 6
    known = np.isfinite(missed)
    size = np.sqrt(mean(missed**2, known, axis=1))[:, None]
    usable = known & (size > 0)
    missed = np.where(usable, missed, 0.0) / np.where(size > 0, size, 1.0)
    expected = np.where(usable, slope * lead, 0.0) / np.where(size > 0, size, 1.0)
    power = float(np.sum(expected**2))
    if not power > 0:
        return 0.0, np.inf
    share = float(np.sum(missed * expected)) / power
    # Neighbouring misses share samples, which counts twice at most.
    return share, float(np.sqrt(2 * np.sum((expected * (missed - share * expected)) ** 2))) / power


def mean(values: RealArray, known: NDArray[np.bool_], *, axis: int) -> RealArray:
    """Return the mean of what is known; 0 where nothing is."""
    return np.asarray(np.where(known, values, 0.0).sum(axis=axis) / np.maximum(known.sum(axis=axis), 1))
