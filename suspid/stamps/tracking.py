"""Tracking: the regular clock nearest to stamps that jitter, and what stamps say about rate and gaps."""

from __future__ import annotations

import numpy as np

from suspid.signals import JITTER
from suspid.stamps.grids import FEW_HOLES, grid_of
from suspid.stamps.rounding import FEW, HOLE, Indices, exact, is_uniform, line, resolution
from suspid.units import Hertz, RealArray, Second

# Below this step [s] doubles cannot tell the rows of a long record apart.
SHORTEST = 1e-12
# Rows in one hole beyond which they are not counted: places must stay integers that doubles hold.
LONGEST_HOLE = float(1 << 31)
# Long steps that are a beat with the rounding: at least as many, whose distances scatter by less than this share of
# their mean. Fewer are alike by chance; chance alone scatters by about their mean.
FEWEST_BEATS, EVEN_BEATS = 20, 0.3


def nearest_grid(times: RealArray) -> tuple[Indices, Second, Second] | None:
    """Return places, start [s] and step [s] of the regular clock nearest to increasing stamps, or None.

    Three readings are compared: rows are missing where a step is long, no row is missing, and the clock that is
    followed from the first rows on. A reading pays for each hole (Bayesian information criterion), and none is
    better than the rounding of the stamps.
    """
    steps = np.diff(times)
    rounding = 0.0 if exact(steps) else resolution(times)
    step = float(np.median(steps))
    for _ in range(8):
        better = float(np.mean(steps[steps <= HOLE * step + 0.5 * rounding]))
        if abs(better - step) <= 1e-12 * step:
            break
        step = better
    if step < SHORTEST:
        return None
    beats = _beats(steps, resolution(times))
    candidates = [] if beats else [_with_holes(times, step, 0.5 * rounding)]
    plain = np.arange(times.size)
    begin, even, _ = line(plain, times)
    if even > 0:
        candidates.append((plain, begin, even))
    followed = None if beats else _tracked(times)
    if followed is not None:
        candidates.append(followed)
    floor = times.size * resolution(times) ** 2 / 12
    return min(candidates, key=lambda fit: _price(times, fit, floor))


def _beats(steps: RealArray, rounding: Second) -> bool:
    """Return whether long steps come as regularly as the beat of a slower clock with the rounding of its stamps.

    Rows that are lost by chance lie as far apart as their distances scatter.
    """
    ticks = np.round(steps / rounding)
    long = np.flatnonzero(ticks > 1)
    if long.size < FEWEST_BEATS or np.median(ticks) != 1 or np.any(ticks[long] > 2):
        return False
    apart = np.diff(long)
    return bool(np.std(apart) < EVEN_BEATS * np.mean(apart))


def _price(times: RealArray, fit: tuple[Indices, Second, Second], floor: float) -> float:
    places, start, step = fit
    misfit = max(floor, float(np.sum((times - start - step * places) ** 2)))
    holes = int(np.sum(np.diff(places) > 1))
    return 0.5 * times.size * float(np.log(misfit)) + holes * float(np.log(times.size))


def _with_holes(times: RealArray, step: Second, slack: Second) -> tuple[Indices, Second, Second]:
    """Return places, start and step where rows are missing in every long step."""
    steps = np.diff(times)
    holes = np.clip(np.round(steps / step), 2, LONGEST_HOLE)
    jumps = np.where(steps <= HOLE * step + slack, 1, holes).astype(np.intp)
    places = np.concatenate([[0], np.cumsum(jumps)])
    start = float(times[0])
    for _ in range(4):
        start, step, _ = line(places, times)
        # The missing rows of each gap are counted again with the better step, which matters for long gaps.
        again = np.where(jumps > 1, np.clip(np.round(steps / step), 1, LONGEST_HOLE), 1)
        counted = np.concatenate([[0], np.cumsum(again)]).astype(np.intp)
        if np.array_equal(counted, places):
            break
        places = counted
    return places, start, step


def _tracked(times: RealArray) -> tuple[Indices, Second, Second] | None:
    """Return places, start and step of the grid that is followed from the first rows on, or None if it is lost.

    The step is known from the rows so far well enough to count a quarter further.
    """
    count, step = min(16, times.size), float(np.median(np.diff(times)))
    start = float(np.median(times[:count] - step * np.arange(count)))
    while True:
        places = np.round((times[:count] - start) / step).astype(np.intp)
        for k in np.flatnonzero(np.diff(places) == 0)[: int(FEW * times.size) + 1]:
            # Two in one place: one of them strayed by more than half a step, towards where there is no other.
            free = k == 0 or places[k] - places[k - 1] > 1
            places[k + (not free)] += -1 if free else 1
        if np.any(np.diff(places) < 1):
            return None
        start, step, _ = line(places, times[:count])
        if step < SHORTEST:
            return None
        if count == times.size:
            # Stamps at random lie 0.29 steps off.
            lost = np.mean((times - start - step * places) ** 2) > (0.2 * step) ** 2
            return None if lost else (places - places[0], start + step * places[0], step)
        count = min(count + count // 4, times.size)


def rate_and_gaps(stamps: RealArray) -> tuple[Hertz, int]:
    """Return the sampling rate [Hz] that stamps state, and the number of gaps in them; NaN and 0 if they state none.

    Stamps that are no numbers are left out, and the others put in order.

    Examples
    --------
    >>> rate, gaps = rate_and_gaps(np.round(np.delete(np.arange(4000), [100, 101, 900]) / 887.14, 3))
    >>> f"{rate:.2f} Hz, {gaps} gaps"
    '887.14 Hz, 2 gaps'
    """
    times = np.sort(stamps[np.isfinite(stamps)])
    if times.size < 2 or not times[-1] > times[0]:
        return float("nan"), 0
    if is_uniform(times):
        return (times.size - 1) / float(times[-1] - times[0]), 0
    grid = grid_of(times)
    if grid is not None:
        return 1 / grid.step, int(np.sum(np.diff(grid.places) > 1))
    twice = np.append(False, np.diff(times) == 0)
    if np.mean(twice) > FEW:
        return float("nan"), 0
    times = times[~twice]
    # One or two holes in stamps that are otherwise exact are missing rows, not a slower clock rounded to its own step.
    ticks = np.diff(times) / float(np.min(np.diff(times), initial=np.inf))
    holes = int(np.sum(np.round(ticks) > 1))
    if times.size > 2 * holes + 1 and holes <= FEW_HOLES and np.all(np.abs(ticks - np.round(ticks)) < JITTER):
        return float(np.sum(np.round(ticks)) / (times[-1] - times[0])), holes
    near = nearest_grid(times) if times.size > 2 else None
    if near is None:
        return 1 / float(np.median(np.diff(times))), 0
    return 1 / near[2], int(np.sum(np.diff(near[0]) > 1))
