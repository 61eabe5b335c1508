"""Clocks: from the stamps of a file, rounded, repeated, swapped or irregular, to one uniform grid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.following import late_or_irregular
from suspid.cleaning.ordering import LATEST, ordered, stamped, unrepeated
from suspid.errors import RecordError
from suspid.signals import JITTER
from suspid.stamps import FEW, HOLE, SHORTEST, Grid, Indices, grid_of, is_uniform, line, nearest_grid, rate_and_gaps
from suspid.stamps import resolution as resolution_of
from suspid.units import Hertz, RealArray, Second
from suspid.words import Defect, Number

# Relative difference of two clocks that are meant to be one: that of cheap crystals. Larger values accept a wrong
# stated rate, smaller ones refuse a right one.
DRIFT = 1e-4
# Relative difference between a stated rate and that of irregular stamps up to which the stated one is taken.
APART = 0.02
# A stamp further from its place in the grid than this, in steps, belongs to another place.
OFF = 0.5
# Steps between samples above which nothing is interpolated, and share of the time that such holes may take. Wider
# holes would be filled with what the record does not say.
WIDE, HOLLOW = 2.5, 0.2
# Samples that a grid may hold for each row that is there; a wrong stamp must not ask for all the memory.
MOST_ROWS = 20


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Clock:
    """The rows of a file on a uniform clock.

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
        Defects of the stamps.
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


def read_clock(stamps: RealArray, values: RealArray, *, rate: Hertz | None = None, override: bool = False) -> Clock:
    """Return the uniform clock that stamps stand for.

    The first of these readings that explains every stamp is taken: uniform stamps, which stay as they are; the grid
    of a stated rate; a uniform clock whose stamps are rounded, with rows missing only where they lie off its line;
    the same after doubled, swapped or wrongly stamped rows were put in order; a regular clock whose stamps jitter, or
    irregular sampling with right stamps. The last two differ in which of them the samples follow.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times [s] as the file has them.
    values : ndarray (channel, row)
        The samples; NaN where missing.
    rate : float, optional
        The rate that the file or the user states [Hz].
    override : bool
        Whether the rate replaces stamps that are at odds with it, instead of being refused.

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
            f"fs = {rate:g} Hz and the {stamps.size} time stamps disagree: they run at "
            f"{(stamps.size - 1) / max(SHORTEST, abs(float(stamps[-1]) - float(stamps[0]))):.9g} Hz"
        )
    try:
        return _read(stamps, values, rate)
    except RecordError:
        if rate is None or not override:
            raise
        return _overridden(stamps, rate)


def _read(stamps: RealArray, values: RealArray, rate: Hertz | None) -> Clock:
    rows, findings = stamped(stamps)
    rows, repeated = unrepeated(stamps, values, rows, most=FEW)
    findings += repeated
    times = stamps[rows]
    clock = _regular_clock(times, values, rows, rate)
    if clock is None:
        try:
            times, rows, further = ordered(stamps, values, rows)
        except RecordError:
            clock = _dispersed(times, values[:, rows], rows) if rate is None else None
            if clock is None:
                raise
            return replace(clock, findings=(*findings, *clock.findings))
        findings += further
        clock = _regular_clock(times, values, rows, rate) if further else None
    if clock is None:
        clock = _nearest_clock(times, values[:, rows], rows, rate)
    return replace(clock, findings=(*findings, *clock.findings))


def _overridden(stamps: RealArray, rate: Hertz) -> Clock:
    """Return all rows in the order of the file, at the rate."""
    usable = stamps[np.abs(stamps) < LATEST]
    start = float(usable[0]) if usable.size else 0.0
    timepts = np.asarray(start + np.arange(stamps.size) / rate)
    numbers: dict[str, Number] = {"rate": rate, "stamps_rate": rate_and_gaps(usable)[0]}
    if usable.size:
        numbers["apart"] = float(usable[-1] - usable[0]) - (stamps.size - 1) / rate
    said = found(Defect.OVERRIDDEN_STAMPS, timepts, stamps.size, numbers)
    rows = np.arange(stamps.size)
    return Clock(timepts=timepts, rows=rows, stamps=timepts, places=rows, findings=(said,))


def _regular_clock(times: RealArray, values: RealArray, rows: Indices, rate: Hertz | None) -> Clock | None:
    """Return the clock of stamps that are uniform but for their rounding and missing rows, or None."""
    whole = _uniform(times, rate)
    if whole is not None:
        timepts, findings = whole
        return Clock(timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=findings)
    grid = grid_of(times)
    if grid is None:
        return None
    start, step = grid.start, grid.step
    if rate is not None:
        if abs(1 / step - rate) > DRIFT * rate + 2 * grid.step_std / step**2:
            return None
        step = 1 / rate
        start = float(np.median(times - step * grid.places))
    kind, numbers = _why_off(times, values[:, rows], grid, start, step, rate)
    if kind is Defect.IRREGULAR_STAMPS:
        return None
    return _on_grid(start, step, grid.places, rows, times, kind, numbers)


def _why_off(
    times: RealArray, values: RealArray, grid: Grid, start: Second, step: Second, rate: Hertz | None
) -> tuple[Defect | None, dict[str, Number]]:
    """Return why stamps lie off their places in a grid, and the numbers of it."""
    off = times - start - step * grid.places
    worst = float(np.max(np.abs(off)))
    if worst <= JITTER * step:
        return None, {}
    if rate is not None:
        return Defect.ROUNDED_STAMPS, _stated(worst, rate)
    if grid.jitter and grid.resolution < step and np.all(np.diff(times) > 0):
        return late_or_irregular(values, grid.places, step, off)
    numbers: dict[str, Number] = {
        "resolution": grid.resolution,
        "rate": 1 / step,
        "rate_std": max(grid.step_std, 1e-15) / step**2,
    }
    return Defect.ROUNDED_STAMPS, numbers


def _uniform(stamps: RealArray, rate: Hertz | None) -> tuple[RealArray, tuple[Finding, ...]] | None:
    """Return the grid of stamps that are uniform, or agree with the stated rate, row by row; else None."""
    uniform = is_uniform(stamps)
    if rate is None:
        return (stamps, ()) if uniform else None
    grid = np.asarray(stamps[0] + np.arange(stamps.size) / rate)
    off = np.abs(stamps - grid)
    worst = float(np.max(off))
    if worst <= 8 * np.spacing(np.max(np.abs(grid))):
        return stamps, ()
    allowed = JITTER / rate + (0.0 if uniform else resolution_of(stamps))
    allowed = allowed + np.minimum(OFF / rate, DRIFT * np.abs(grid - grid[0]))
    if np.all(off <= allowed):
        said = found(Defect.ROUNDED_STAMPS, grid, stamps.size, _stated(worst, rate))
        return grid, (said,) if worst > JITTER / rate else ()
    if uniform:
        _check_rate(rate, (stamps.size - 1) / float(stamps[-1] - stamps[0]), 0.0, stamps, off - allowed)
    return None


def _stated(off: Second, rate: Hertz) -> dict[str, Number]:
    return {"off": off, "off_samples": off * rate, "rate": rate}


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


def _nearest_clock(times: RealArray, values: RealArray, rows: Indices, rate: Hertz | None) -> Clock:
    """Return the clock of increasing stamps that jitter or are irregular, of which some may be missing."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    hollow = not 0 < times[-1] - times[0] <= MOST_ROWS * times.size * usual or usual < SHORTEST
    near = None if hollow else nearest_grid(times)
    if near is None:
        raise RecordError(_hollow(steps, (WIDE if hollow else HOLE) * usual))
    places, start, step = near
    if rate is not None:
        _check_rate(rate, 1 / step, APART, times, np.abs(times - times[0] - places / rate))
        places = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(steps * rate)))]).astype(np.intp)
        step = 1 / rate
        start = float(np.median(times - step * places))
    off = times - (start + step * places)
    worst = float(np.max(np.abs(off)))
    within = 0.5 * resolution_of(times) + DRIFT * float(times[-1] - times[0])
    kind: Defect | None = None
    numbers: dict[str, Number] = {}
    if worst > JITTER * step:
        if rate is not None and worst <= min(within, OFF * step):
            kind, numbers = Defect.ROUNDED_STAMPS, _stated(worst, rate)
        elif worst <= step and np.mean(np.abs(off) > OFF * step) <= FEW:
            kind, numbers = late_or_irregular(values, places, step, off)
        else:
            kind, numbers = Defect.IRREGULAR_STAMPS, {"largest": worst / step}
    if kind is Defect.IRREGULAR_STAMPS:
        return _irregular(times, rows, rate, numbers)
    if places[-1] >= MOST_ROWS * times.size:
        raise RecordError(_hollow(steps, WIDE * usual))
    return _on_grid(start, step, places, rows, times, kind, numbers)


def _dispersed(times: RealArray, values: RealArray, rows: Indices) -> Clock | None:
    """Return the clock of rows in order whose stamps jitter so far that some repeat or run backwards, or None."""
    places = np.arange(times.size)
    start, step, _ = line(places, times)
    off = times - start - step * places
    slack = 0.5 * resolution_of(times)
    if step < SHORTEST or np.max(np.abs(off)) > slack + step or np.mean(np.abs(off) > slack + OFF * step) > FEW:
        return None
    _, numbers = late_or_irregular(values, places, step, off)
    return _on_grid(start, step, places, rows, times, Defect.JITTERING_STAMPS, numbers)


def _on_grid(
    start: Second,
    step: Second,
    places: Indices,
    rows: Indices,
    times: RealArray,
    kind: Defect | None,
    numbers: dict[str, Number],
) -> Clock:
    """Return the clock of rows of which it is known which samples they are."""
    timepts = np.asarray(start + step * np.arange(places[-1] + 1))
    findings: tuple[Finding, ...] = (found(kind, times, times.size, numbers),) if kind else ()
    lost = int(timepts.size - places.size)
    if lost:
        holes = np.flatnonzero(np.diff(places) > 1)
        counts: dict[str, Number] = {"rows": timepts.size, "places": holes.size}
        findings += (found(Defect.MISSING_ROWS, times[np.append(holes, holes[-1] + 1)], lost, counts),)
    return Clock(timepts=timepts, rows=rows, stamps=timepts[places], places=places, findings=findings)


def _irregular(times: RealArray, rows: Indices, rate: Hertz | None, numbers: dict[str, Number]) -> Clock:
    """Return a uniform grid between irregular stamps."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    step = float(np.mean(steps[steps <= WIDE * usual])) if rate is None else 1 / rate
    if np.sum(steps[steps > WIDE * step]) > HOLLOW * (times[-1] - times[0]):
        raise RecordError(_hollow(steps, WIDE * step))
    count = int(np.floor((times[-1] - times[0]) / step * (1 + 1e-12))) + 1
    said = found(Defect.IRREGULAR_STAMPS, times, times.size, {**numbers, "rate": 1 / step})
    timepts = np.asarray(times[0] + step * np.arange(count))
    return Clock(timepts=timepts, rows=rows, stamps=times, places=None, findings=(said,))


def _hollow(steps: RealArray, wide: Second) -> str:
    share = 100 * float(np.sum(steps[steps > wide])) / max(float(np.sum(steps)), SHORTEST)
    longest = int(np.argmax(steps))
    return (
        f"the time stamps are too irregular for a uniform record: half of the steps are below "
        f"{np.median(steps):.3g} s, but {share:.2g} % of the time is in steps above {wide:.3g} s, the longest "
        f"{steps[longest]:.3g} s after row {longest + 1}; record at a constant rate, or take a stretch without such "
        f"holes (start, stop)"
    )
