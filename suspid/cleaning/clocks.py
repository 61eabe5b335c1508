"""Clocks: from the stamps of a file, rounded, repeated, swapped or irregular, to one uniform grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.ordering import LATEST, ordered, stamped
from suspid.cleaning.stamps import (
    FEW,
    HOLE,
    Indices,
    exact,
    is_uniform,
    line,
    mean,
    resolution,
    rounded_line,
    share_followed,
)
from suspid.errors import RecordError
from suspid.signals import JITTER
from suspid.units import Hertz, RealArray, Second
from suspid.words import Defect, Number

# How far two clocks may differ and still be meant to be one; over a long record, half a sample at most.
DRIFT = 1e-4
# How far a stated rate and that of irregular stamps may lie apart: the grid is the stated one.
APART = 0.02
# A stamp that lies further off its place in the grid than this, in steps, is not there by rounding or by jitter.
OFF = 0.5
# No step is shorter [s].
SHORTEST = 1e-12
# No hole has more rows, so that they can be counted.
LONGEST_HOLE = float(1 << 31)
# Samples that follow irregular stamps at least this far, and by so many standard deviations, were taken at them.
FOLLOWED, SIGNIFICANT = 0.3, 4.0
# Steps between samples above which nothing is interpolated, and how much of the time such holes may take.
WIDE, HOLLOW = 2.5, 0.2
# How many times the rows that are there a grid may hold.
MOST_ROWS = 20


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Clock:
    """Where the rows of a file stand in time.

    Parameters
    ----------
    timepts : ndarray (sample,)
        The uniform grid [s].
    rows : ndarray (row,)
        Rows of the file that are used, in order of time.
    stamps : ndarray (row,)
        Time of each of these rows [s].
    places : ndarray (row,) or None
        Sample of the grid that each of these rows is; None where the grid lies between the rows.
    findings : tuple of Finding
        What was met.
    """

    timepts: RealArray
    rows: Indices
    stamps: RealArray
    places: Indices | None
    findings: tuple[Finding, ...]

    @property
    def step(self) -> Second:
        """Step of the grid [s]."""
        return float(self.timepts[-1] - self.timepts[0]) / (self.timepts.size - 1)


def read_clock(stamps: RealArray, values: RealArray, *, rate: Hertz | None = None) -> Clock:
    """Return the uniform clock that stamps stand for.

    Tried in this order; the first that explains every stamp is taken, and said in the findings:
    stamps that are uniform already, which stay as they are; the grid of a rate that is known; a
    regular clock with rounded stamps; the same with a few rows doubled, swapped, wrongly stamped or
    missing; a regular clock with stamps that jitter, or irregular sampling with stamps that are
    right. The last two differ in which the samples follow more smoothly, the grid or the stamps.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times [s] as the file has them.
    values : ndarray (channel, row)
        The samples; NaN where missing.
    rate : float, optional
        The rate that the file or the user states [Hz].

    Raises
    ------
    RecordError
        If there are fewer than two usable stamps, the clock restarts, the stamps are at odds with
        the rate, or they are too irregular for any grid.

    Examples
    --------
    >>> stamps = np.round(np.arange(2000) / 333, 3)
    >>> clock = read_clock(stamps, np.zeros((1, 2000)))
    >>> f"{1 / clock.step:.2f} Hz", clock.findings[0].kind.value
    ('333.00 Hz', 'rounded stamps')
    """
    if rate is not None and not 1 / LATEST < rate < 1 / SHORTEST:
        raise RecordError(
            f"fs = {rate:g} Hz and the {stamps.size} stamps of the column of time disagree: they run at "
            f"{(stamps.size - 1) / max(SHORTEST, abs(float(stamps[-1]) - float(stamps[0]))):.9g} Hz"
        )
    rows, findings = stamped(stamps)
    whole = _plain(stamps[rows], rate)
    if whole is not None:
        timepts, further = whole
        return Clock(
            timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=(*findings, *further)
        )
    times, rows, further = ordered(stamps, values, rows)
    findings += further
    if further and rows.size > 1:
        whole = _plain(times, rate)
        if whole is not None:
            timepts, more = whole
            findings = (*findings, *more)
            return Clock(timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=findings)
    return _gridded(times, values[:, rows], rows, rate, findings)


def _plain(stamps: RealArray, rate: Hertz | None) -> tuple[RealArray, tuple[Finding, ...]] | None:
    """Return the grid of stamps in which every row is one sample and none is missing, or None."""
    index = np.arange(stamps.size)
    uniform = is_uniform(stamps)
    if rate is None:
        if uniform:
            return stamps, ()
        grid_of = rounded_line(index, stamps)
        if grid_of is None:
            return None
        start, step, std = grid_of
        grid = np.asarray(start + step * index)
        return grid, (found(Defect.ROUNDED_STAMPS, grid, stamps.size, _rounding(stamps, step, std)),)
    grid = np.asarray(stamps[0] + index / rate)
    off = np.abs(stamps - grid)
    if np.max(off) <= 8 * np.spacing(np.max(np.abs(grid))):
        return stamps, ()
    allowed = JITTER / rate + (0.0 if uniform else resolution(stamps))
    allowed = allowed + np.minimum(OFF / rate, DRIFT * np.abs(grid - grid[0]))
    if np.all(off <= allowed):
        worst = float(np.max(off))
        said = found(Defect.ROUNDED_STAMPS, grid, stamps.size, _stated(worst, rate))
        return grid, (said,) if worst > JITTER / rate else ()
    if uniform:
        _check_rate(rate, (stamps.size - 1) / float(stamps[-1] - stamps[0]), 0.0, stamps, off - allowed)
    return None


def _check_rate(rate: Hertz, mean: Hertz, allowed: float, stamps: RealArray, off: RealArray) -> None:
    """Refuse a rate that is further than the share allowed from that of the stamps."""
    if abs(mean - rate) <= allowed * rate:
        return
    worst = int(np.argmax(off))
    raise RecordError(
        f"fs = {rate:.9g} Hz and the column of time disagree: the stamps run at {mean:.9g} Hz on average, and "
        f"stamp {worst + 1}, {stamps[worst]:.9g} s, lies {abs(stamps[worst] - stamps[0] - worst / rate) * rate:.3g} "
        f"samples off"
    )


def _gridded(
    times: RealArray, values: RealArray, rows: Indices, rate: Hertz | None, findings: tuple[Finding, ...]
) -> Clock:
    """Return the clock of increasing stamps, of which some may be missing or that may be irregular."""
    usual = float(np.median(np.diff(times)))
    if not 0 < times[-1] - times[0] <= MOST_ROWS * times.size * usual or usual < SHORTEST:
        raise RecordError(_hollow(np.diff(times), WIDE * usual))
    places, start, step = _regular(times)
    span = float(times[-1] - times[0])
    if rate is not None:
        off = np.abs(times - times[0] - places / rate)
        _check_rate(rate, 1 / step, APART, times, off)
        places = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(np.diff(times) * rate)))]).astype(np.intp)
        step = 1 / rate
        start = float(np.median(times - step * places))
    off = times - (start + step * places)
    rounding, worst = resolution(times), float(np.max(np.abs(off)))
    kind: Defect | None = None
    numbers: dict[str, Number] = {}
    if worst > JITTER * step:
        grid_of = rounded_line(places, times) if rate is None else None
        if grid_of is not None:
            start, step, std = grid_of
            kind, numbers = Defect.ROUNDED_STAMPS, _rounding(times, step, std)
        elif rate is not None and worst <= 0.5 * rounding + DRIFT * span and worst <= OFF * step:
            kind, numbers = Defect.ROUNDED_STAMPS, _stated(worst, rate)
        elif worst <= step and np.mean(np.abs(off) > OFF * step) <= FEW:
            kind, numbers = _jitter(values, places, step, off)
        else:
            kind, numbers = Defect.IRREGULAR_STAMPS, {"largest": worst / step}
    if kind is Defect.IRREGULAR_STAMPS:
        return _irregular(times, rows, rate, findings, numbers)
    if places[-1] >= MOST_ROWS * times.size:
        raise RecordError(_hollow(np.diff(times), WIDE * usual))
    timepts = np.asarray(start + step * np.arange(places[-1] + 1))
    findings += (found(kind, times, times.size, numbers),) if kind else ()
    lost = int(timepts.size - places.size)
    if lost:
        holes = np.flatnonzero(np.diff(places) > 1)
        numbers = {"rows": timepts.size, "places": holes.size}
        findings += (found(Defect.MISSING_ROWS, times[np.append(holes, holes[-1] + 1)], lost, numbers),)
    return Clock(timepts=timepts, rows=rows, stamps=timepts[places], places=places, findings=findings)


def _regular(times: RealArray) -> tuple[Indices, Second, Second]:
    """Return the place of each stamp on the regular grid nearest to all, and its start and step."""
    steps = np.diff(times)
    rounding = 0.0 if exact(steps) else resolution(times)
    step = float(np.median(steps))
    for _ in range(8):
        better = float(np.mean(steps[steps <= HOLE * step + 0.5 * rounding]))
        if abs(better - step) <= 1e-12 * step:
            break
        step = better
    if step < SHORTEST:
        raise RecordError(_hollow(steps, HOLE * step))
    holes = np.clip(np.round(steps / step), 2, LONGEST_HOLE)
    jumps = np.where(steps <= HOLE * step + 0.5 * rounding, 1, holes).astype(np.intp)
    places = np.concatenate([[0], np.cumsum(jumps)])
    for _ in range(4):
        start, step, _ = line(places, times)
        # A hole is counted anew with the better step: a long one holds many.
        again = np.concatenate(
            [[0], np.cumsum(np.where(jumps > 1, np.clip(np.round(steps / step), 1, LONGEST_HOLE), 1))]
        )
        if np.array_equal(again, places):
            break
        places = again.astype(np.intp)
    # Jitter makes long steps too: what puts the stamps nearer to a grid is taken.
    candidates = [(places, start, step)]
    plain = np.arange(times.size)
    begin, even, _ = line(plain, times)
    if even > 0:
        candidates.append((plain, begin, even))
    followed = _tracked(times)
    if followed is not None:
        candidates.append(followed)
    return min(candidates, key=lambda fit: float(np.sum((times - fit[1] - fit[2] * fit[0]) ** 2)))


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


def _rounding(stamps: RealArray, step: Second, std: Second) -> dict[str, Number]:
    return {"resolution": resolution(stamps), "rate": 1 / step, "rate_std": max(std, 1e-15) / step**2}


def _stated(off: Second, rate: Hertz) -> dict[str, Number]:
    return {"off": off, "off_samples": off * rate, "rate": rate}


def _jitter(values: RealArray, places: Indices, step: Second, off: RealArray) -> tuple[Defect, dict[str, Number]]:
    """Return whether stamps that stray by less than half a step are wrong or the samples irregular, and why."""
    share, std = share_followed(values, off / step, places)
    sigma = float(np.sqrt(np.mean(off**2)))
    largest = float(np.max(np.abs(off)))
    numbers: dict[str, Number] = {"followed": share, "followed_std": std}
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return Defect.IRREGULAR_STAMPS, {**numbers, "largest": largest / step}
    pace = np.diff(values, axis=1)
    speed = np.sqrt(mean(pace**2, np.isfinite(pace), axis=1)) / step * sigma
    there = np.isfinite(values)
    about = values - mean(values, there, axis=1)[:, None]
    motion = np.sqrt(mean(about**2, there, axis=1))
    error = float(np.max(speed / np.where(motion > 0, motion, np.inf)))
    return Defect.JITTERING_STAMPS, {**numbers, "largest": largest, "rms": sigma, "rate": 1 / step, "error": error}


def _irregular(
    times: RealArray, rows: Indices, rate: Hertz | None, findings: tuple[Finding, ...], numbers: dict[str, Number]
) -> Clock:
    steps = np.diff(times)
    usual = float(np.median(steps))
    step = float(np.mean(steps[steps <= WIDE * usual])) if rate is None else 1 / rate
    if np.sum(steps[steps > WIDE * step]) > HOLLOW * (times[-1] - times[0]):
        raise RecordError(_hollow(steps, WIDE * step))
    count = int(np.floor((times[-1] - times[0]) / step * (1 + 1e-12))) + 1
    said = found(Defect.IRREGULAR_STAMPS, times, times.size, {**numbers, "rate": 1 / step})
    timepts = np.asarray(times[0] + step * np.arange(count))
    return Clock(timepts=timepts, rows=rows, stamps=times, places=None, findings=(*findings, said))


def _hollow(steps: RealArray, wide: Second) -> str:
    share = 100 * float(np.sum(steps[steps > wide])) / max(float(np.sum(steps)), SHORTEST)
    longest = int(np.argmax(steps))
    return (
        f"the time stamps are too irregular for a uniform record: half of the steps are below "
        f"{np.median(steps):.3g} s, but {share:.2g} % of the time lies in steps above {wide:.3g} s, the longest "
        f"{steps[longest]:.3g} s after row {longest + 1}; record at a constant rate, or take a stretch without such "
        f"holes (start, stop)"
    )
