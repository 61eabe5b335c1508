"""Grids: the uniform clock behind coarsely rounded stamps, with or without missing rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.signals import JITTER
from suspid.stamps.digits import least_excess, line_within, resolutions
from suspid.stamps.lines import FEWEST_POINTS, band, missing_rows, narrowest_line
from suspid.stamps.rounding import FEW, Indices, resolution
from suspid.units import RealArray, Second

# Width that the band of residuals may have beyond the rounding, in steps, tried in this order. One row missing
# in the middle of a record widens the narrowest band by half a step: gaps are looked for before more is allowed.
JITTERS = ((0.0, 0.2, 0.4), (0.8,))
# Samples that a grid may hold for each row that is there: a wrong stamp must not ask for all the memory.
MOST_PER_ROW = 20
# Largest number of gaps per row. Where there are more, the step is wrong, not the rows missing.
MOST_GAPS = 0.1
# Where the usual step is the resolution itself, a longer step is either a missing row or the beat of another rate with
# the rounding. One or two say nothing about that, and rows are taken to be missing. Of more, a line of another rate
# explains about half if they are random; it must explain all but a quarter to be preferred.
FEW_HOLES, UNEXPLAINED = 2, 0.25
# Stamps of few significant digits are rounded to this many steps at least where rows share them, and to this many
# times as much as the least where the resolution grows.
SHARED, GROWS = 2.0, 5.0


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


def grid_of(stamps: RealArray, index: Indices | None = None) -> Grid | None:
    """Return the uniform clock with the fewest missing rows that rounds to the stamps, or None if there is none.

    A straight line is fitted first; only rows that lie off it by more than the rounding are a gap. Where several
    rows share a stamp, the first of each says the time to within one step; the others say nothing more.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times that do not decrease [s].
    index : ndarray (row,), optional
        Increasing numbers of the rows, where some are known to be missing. Default: 0, 1, 2, ….

    Examples
    --------
    >>> rows = np.delete(np.arange(4000), [1000, 1001, 1002])
    >>> grid = grid_of(np.round(rows / 887.14, 3))
    >>> f"{1 / grid.step:.2f} Hz", bool(np.all(grid.places == rows))
    ('887.14 Hz', True)
    """
    steps = np.diff(stamps)
    if stamps.size < FEWEST_POINTS or np.any(steps < 0) or not stamps[-1] > stamps[0]:
        return None
    even = _evenly_rounded(stamps, index)
    whole = even is not None and even.jitter == 0
    if whole and even is not None and int(even.places[-1]) == stamps.size - 1:
        return even
    coarse = _mostly_rounded(stamps, index) if whole else None
    if coarse is not None:
        return coarse
    digits = _of_digits(stamps, steps, index)
    # Rows that share a stamp in the last decade, and not in the first, show that the resolution grows: else they would
    # pass for missing ones. Where every row has its stamp, rows that are missing show.
    grows = digits is not None and digits.resolution >= SHARED * digits.step
    return (digits if grows or not whole else even) or even


def _of_digits(stamps: RealArray, steps: RealArray, index: Indices | None) -> Grid | None:
    """Return the clock without missing rows that rounds to stamps of the same few significant digits."""
    in_a_row = index is None or int(index[-1] - index[0]) == stamps.size - 1
    wide = resolutions(stamps) if in_a_row else None
    if wide is None or np.max(wide) <= JITTER * float(np.mean(steps)) or np.max(wide) < GROWS * np.min(wide[wide > 0]):
        return None
    # The bound is found in no time: the step is near the mean of the steps.
    if 2 * least_excess(stamps, wide) > 2 * JITTERS[0][1] * float(np.mean(steps)):
        return None
    start, step, std, excess = line_within(stamps, wide)
    jitter = 2 * excess / step
    if not jitter <= JITTERS[0][1]:
        return None
    return Grid(
        start=start,
        step=step,
        step_std=std,
        places=np.arange(stamps.size),
        resolution=float(np.max(wide)),
        jitter=jitter if jitter > JITTER else 0.0,
    )


def _mostly_rounded(stamps: RealArray, index: Indices | None) -> Grid | None:
    """Return the clock without missing rows of stamps of which all but few are rounded to the same step.

    Programs that write three decimals, and numbers below 0.001 with an exponent, seem to lose rows where these end.
    """
    for quantum in (m * 10.0**-k for k in range(1, 7) for m in (1, 0.5)):
        rounded = np.round(stamps / quantum) * quantum
        off = np.abs(stamps - rounded) > 1e-6 * quantum
        if np.mean(off) <= FEW:
            shared = quantum >= SHARED * (stamps[-1] - stamps[0]) / (stamps.size - 1)
            grid = _evenly_rounded(np.where(off, rounded, stamps), index) if shared and np.any(off) else None
            none_missing = grid is not None and int(grid.places[-1]) == stamps.size - 1
            return grid if grid is not None and none_missing and grid.jitter == 0 else None
    return None


def _evenly_rounded(stamps: RealArray, index: Indices | None) -> Grid | None:
    """Return the clock of stamps that are all rounded to the same step."""
    steps = np.diff(stamps)
    changed = np.flatnonzero(steps > 0) + 1
    quantum = _quantum(stamps, steps[changed - 1])
    points = np.arange(stamps.size) if changed.size == steps.size else changed
    if points.size < _fewest(stamps.size / points.size) or quantum <= JITTER * float(np.median(steps[changed - 1])):
        return None
    if index is None:
        index = np.arange(stamps.size)
    index = index - index[0]
    rows, times = index[points].astype(float), stamps[points]
    holes = _holes(steps, quantum, np.diff(index))
    if holes is not None:
        missing = missing_rows(rows, times, quantum, 0.0)
        beats = missing is not None and _gaps(missing) <= UNEXPLAINED * _gaps(holes) and _gaps(holes) > FEW_HOLES
        return _grid(stamps, index, points, missing if beats and missing is not None else holes, quantum, 0.0)
    for jitters in JITTERS:
        for jitter in jitters:
            if narrowest_line(rows, times, quantum, jitter) is not None:
                return _grid(stamps, index, points, np.zeros(rows.size), quantum, jitter)
        for jitter in jitters:
            missing = missing_rows(rows, times, quantum, jitter)
            grid = None if missing is None else _grid(stamps, index, points, missing, quantum, jitter)
            if grid is not None:
                return grid
    return None


def _fewest(shared: float) -> int:
    """Return how many points a line must fit where ``shared`` rows have one stamp; each point is exact to a row."""
    return FEWEST_POINTS if shared < 2 else max(5, 2 + int(np.ceil((FEWEST_POINTS - 2) / np.log2(shared))))


def _gaps(missing: RealArray) -> int:
    return int(np.sum(np.diff(missing) > 0))


def _holes(steps: RealArray, quantum: Second, apart: Indices) -> RealArray | None:
    """Return how many rows are missing before each, if the step is the resolution itself but for a few holes.

    Rows that are known to be missing make a row and the next one more than one ``apart``.
    """
    lost = np.round(steps / quantum) - apart
    if np.any(lost < 0) or np.mean(lost > 0) > MOST_GAPS:
        return None
    return np.concatenate([[0.0], np.cumsum(lost)])


def _quantum(stamps: RealArray, steps: RealArray) -> Second:
    """Return the step to which stamps are rounded, from zero or from the first one, decimal or not."""
    quantum = max(resolution(stamps), resolution(stamps - stamps[0]))
    least = float(np.min(steps))
    ticks = steps / least
    if steps.size < 0.5 * stamps.size and np.all(np.abs(ticks - np.round(ticks)) < JITTER):
        return max(quantum, least)
    return quantum


def _merged(before: RealArray, stamps: RealArray, index: Indices, step: Second, lowest: Second) -> RealArray:
    """Return the rows missing before each row, with neighbouring gaps joined if no residual falls below the lowest."""
    before = before.copy()
    places = index + np.cumsum(before)
    gaps = np.flatnonzero(before)
    for one, other in zip(gaps[:-1][::-1], gaps[1:][::-1], strict=True):
        between = slice(one, other)
        if np.min(stamps[between] - step * (places[between] + before[other])) >= lowest:
            places[between] += before[other]
            before[one] += before[other]
            before[other] = 0.0
    return before


def _grid(
    stamps: RealArray, index: Indices, points: Indices, missing: RealArray, quantum: Second, jitter: float
) -> Grid | None:
    """Return the grid of points of which it is known how many rows are missing before each."""
    rows = index[points] + missing
    times = stamps[points]
    fitted = narrowest_line(rows, times, quantum, jitter)
    if fitted is None:
        return None
    step = fitted[1]
    ends = []
    for side in (-1, 1):
        inside, outside = step, step + side * 4 * (min(quantum, step) + jitter * step) / float(rows[-1] - rows[0])
        for _ in range(14):
            middle = (inside + outside) / 2
            fits = np.ptp(times - middle * rows) <= band(middle, quantum, jitter, times)
            inside, outside = (middle, outside) if fits else (inside, middle)
        ends.append(inside)
    step = (ends[0] + ends[1]) / 2
    before = np.zeros(stamps.size)
    before[points] = np.diff(missing, prepend=0.0)
    lowest = fitted[0] - 0.5 * band(step, quantum, jitter, times) - max(0.0, quantum - step)
    before = _merged(before, stamps, index, step, lowest)
    if np.sum(before > 0) > max(FEW_HOLES, MOST_GAPS * points.size):
        return None
    places = (index + np.cumsum(before)).astype(np.intp)
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
