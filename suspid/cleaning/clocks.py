"""Clocks: from the stamps of a file, rounded, repeated, swapped or irregular, to one uniform grid."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from suspid.cleaning.clock import DRIFT, OFF, Clock, check_rate, on_grid, stated
from suspid.cleaning.findings import Finding, found
from suspid.cleaning.following import late_or_irregular, rows_are_missing
from suspid.cleaning.nearest import dispersed, nearest_clock, packed
from suspid.cleaning.ordering import LATEST, numbered, ordered, stamped, unrepeated
from suspid.errors import RecordError
from suspid.signals import JITTER
from suspid.stamps import FEW, SHORTEST, Grid, Indices, continued, grid_of, is_uniform, multiples_of, rate_and_gaps
from suspid.stamps import resolution as resolution_of
from suspid.units import Hertz, RealArray, Second
from suspid.wording import Argument
from suspid.words import Defect, Number


def read_clock(stamps: RealArray, values: RealArray, *, rate: Hertz | None = None, override: bool = False) -> Clock:
    """Return the uniform clock that stamps stand for.

    The first of these readings that explains every stamp is taken: uniform stamps, which stay as they are; the grid
    of a stated rate; a uniform clock whose stamps are rounded, with rows missing only where they lie off its line;
    the same after doubled, swapped or wrongly stamped rows were put in order; a regular clock whose stamps jitter, or
    irregular sampling with right stamps; one of these after the clock was set back by a few samples. A regular clock
    and irregular sampling differ in which of them the samples follow.

    Parameters
    ----------
    stamps : ndarray (row,)
        Times [s] as the file has them.
    values : ndarray (channel, row)
        The samples; NaN where missing.
    rate : float, optional
        The rate that the file or the user states [Hz].
    override : bool
        Whether the rate replaces stamps that are at odds with it, whatever the reason, instead of being refused. All
        rows are kept in the order of the file, and a finding says how far rate and stamps disagree.

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
            Argument("fs", f"{rate:g}"),
            f" Hz and the {stamps.size} time stamps disagree: they run at "
            f"{(stamps.size - 1) / max(SHORTEST, abs(float(stamps[-1]) - float(stamps[0]))):.9g} Hz",
        )
    if rate is not None and override:
        # Stamps that agree with the rate still tell which rows are missing; only others are replaced.
        try:
            return _read(stamps, values, rate, distinct=True)
        except RecordError:
            return _overridden(stamps, rate)
    return _read(stamps, values, rate)


def _read(stamps: RealArray, values: RealArray, rate: Hertz | None, *, distinct: bool = False) -> Clock:
    """Return the clock; with ``distinct``, rows count as doubled only where the other stamps differ."""
    rows, findings = stamped(stamps)
    lost = np.delete(np.arange(stamps.size), rows)
    clock, repeated = _as_they_are(stamps, values, rows, lost, rate, distinct=distinct)
    if clock is not None:
        return replace(clock, findings=(*findings, *repeated, *clock.findings))
    try:
        times, rows, further = ordered(stamps, values, rows, lost)
    except RecordError:
        rows, repeated = unrepeated(stamps, values, rows, most=FEW, distinct=True)
        times, index = stamps[rows], numbered(rows, lost)
        clock = dispersed(times, values[:, rows], rows, index) or packed(times, values[:, rows], rows, index)
        clock = clock or _set_back(times, values, rows, index)
        if clock is None or rate is not None:
            raise
        return replace(clock, findings=(*findings, *repeated, *clock.findings))
    clock = _regular_clock(times, values, rows, numbered(rows, lost), rate) if further else None
    if clock is None:
        clock = nearest_clock(times, values[:, rows], rows, rate)
    return replace(clock, findings=(*findings, *further, *clock.findings))


def _set_back(times: RealArray, values: RealArray, rows: Indices, index: Indices) -> Clock | None:
    """Return the clock of stamps that fall by a few samples where it was set back and the motion goes on, or None."""
    onward, after = continued(times)
    if not after.size:
        return None
    with np.errstate(invalid="ignore", over="ignore"):
        changes = np.abs(np.diff(values[:, rows], axis=1))
    changes[np.isnan(changes)] = 0.0
    # Between two recordings, the motion jumps.
    if np.any(changes[:, after] > np.max(np.delete(changes, after, axis=1), axis=1)[:, None]):
        return None
    clock = _regular_clock(onward, values, rows, index, None)
    clock = nearest_clock(onward, values[:, rows], rows, None) if clock is None else clock
    first = int(after[0])
    back = float(onward[first + 1] - times[first + 1])
    numbers: dict[str, Number] = {"back": back, "back_samples": back / clock.step, "row": int(rows[first]) + 1}
    said = found(Defect.SET_BACK, onward[after], after.size, numbers)
    return replace(clock, findings=(said, *clock.findings))


def _as_they_are(
    stamps: RealArray, values: RealArray, rows: Indices, lost: Indices, rate: Hertz | None, *, distinct: bool
) -> tuple[Clock | None, tuple[Finding, ...]]:
    """Return the regular clock of rows in the order of the file, without doubled ones where it needs that, or None.

    Where all rows are those of one rounded clock, samples that repeat within a stamp are samples.
    """
    index = numbered(rows, lost)
    single, repeated = unrepeated(stamps, values, rows, most=FEW, distinct=distinct)
    if repeated and (is_uniform(stamps[single]) or not _are_rounded(stamps[rows], index)):
        clock = _regular_clock(stamps[single], values, single, numbered(single, lost), rate)
        if clock is not None:
            return clock, repeated
    return _regular_clock(stamps[rows], values, rows, index, rate), ()


def _are_rounded(times: RealArray, index: Indices) -> bool:
    """Whether all rows are those of one clock, none missing, whose stamps are rounded and do not stray."""
    grid = grid_of(times, index)
    return grid is not None and grid.jitter == 0 and np.array_equal(grid.places, index)


def _overridden(stamps: RealArray, rate: Hertz) -> Clock:
    """Return all rows in the order of the file, at the rate."""
    usable = stamps[np.abs(stamps) < LATEST]
    start = float(usable[0]) if usable.size else 0.0
    timepts = np.asarray(start + np.arange(stamps.size) / rate)
    numbers: dict[str, Number] = {"rate": rate, "stamps_rate": rate_and_gaps(usable)[0]}
    if usable.size:
        numbers["apart"] = float(usable[-1] - usable[0]) - (stamps.size - 1) / rate
        exact = multiples_of(usable)
        if exact is not None:
            numbers["stamps_rate"] = 1 / exact.step
        step = 1 / rate
        same = abs(cast("float", numbers["stamps_rate"]) - rate) <= DRIFT * rate
        if same and cast("float", numbers["apart"]) > OFF * step:
            numbers["missing"] = round(cast("float", numbers["apart"]) / step)
    said = found(Defect.OVERRIDDEN_STAMPS, timepts, stamps.size, numbers, repaired="missing" not in numbers)
    rows = np.arange(stamps.size)
    return Clock(timepts=timepts, rows=rows, stamps=timepts, places=rows, findings=(said,))


def _regular_clock(
    times: RealArray, values: RealArray, rows: Indices, index: Indices, rate: Hertz | None
) -> Clock | None:
    """Return the clock of numbered stamps that are uniform but for their rounding and missing rows, or None."""
    in_a_row = index.size == 0 or bool(index[-1] == index.size - 1)
    whole = _uniform(times, rate) if in_a_row or is_uniform(times) else None
    if whole is not None:
        timepts, findings = whole
        return Clock(timepts=timepts, rows=rows, stamps=timepts, places=np.arange(rows.size), findings=findings)
    grid = grid_of(times, index)
    if grid is None and not in_a_row:
        grid = grid_of(times)
    if grid is None:
        return None
    exact = multiples_of(times)
    doubt: tuple[Finding, ...] = ()
    if exact is not None and not np.array_equal(exact.places, grid.places):
        if rate is not None:
            follows = abs(1 / exact.step - rate) < abs(1 / grid.step - rate)
        else:
            follows, doubt = rows_are_missing(times, values[:, rows], grid, exact)
        grid = exact if follows else grid
    start, step = grid.start, grid.step
    if rate is not None:
        if abs(1 / step - rate) > DRIFT * rate + 2 * grid.step_std / step**2:
            return None
        step = 1 / rate
        start = float(np.median(times - step * grid.places))
    kind, numbers = _why_off(times, values[:, rows], grid, start, step, rate)
    if kind is Defect.IRREGULAR_STAMPS:
        return None
    clock = on_grid(start, step, grid.places, rows, times, kind, numbers)
    return replace(clock, findings=(*clock.findings, *doubt))


def _why_off(
    times: RealArray, values: RealArray, grid: Grid, start: Second, step: Second, rate: Hertz | None
) -> tuple[Defect | None, dict[str, Number]]:
    """Return why stamps lie off their places in a grid, and the numbers of it."""
    off = times - start - step * grid.places
    worst = float(np.max(np.abs(off)))
    if worst <= JITTER * step:
        return None, {}
    if rate is not None:
        return Defect.ROUNDED_STAMPS, stated(worst, rate)
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
        said = found(Defect.ROUNDED_STAMPS, grid, stamps.size, stated(worst, rate))
        return grid, (said,) if worst > JITTER / rate else ()
    if uniform:
        check_rate(rate, (stamps.size - 1) / float(stamps[-1] - stamps[0]), 0.0, stamps, off - allowed)
    return None
