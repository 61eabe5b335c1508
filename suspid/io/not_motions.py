"""Columns that measure no motion: what counts rows, a magnitude, a single number, a time."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from suspid.io.column_plan import ColumnPlan
from suspid.io.epochs import SINCE_A_DATE
from suspid.io.names import (
    TEMPERATURES,
    UNNAMED_COLUMN,
    counts_rows,
    is_abscissa,
    is_count,
    is_nth_count,
    may_be_time,
    unit_in_name,
)
from suspid.io.time_units import FEW_STAMPS, late_by, runs_beside
from suspid.units import RealArray, Second
from suspid.words import LeftOut, Remark

# Rows in which a column of any name rises by one in each, or repeats the time: in fewer, a motion may.
MANY_ROWS = 50
# Share of a step by which what changes evenly with the time is off it at most: stamps are rounded. Any sensor is more.
OFF_EVEN = 0.05
# Share by which the clock of another machine, or of a message, gains or loses against the time at most.
ANOTHER_PACE = 0.01
# Share of the time for which a clock is held at most.
MOST_HELD = 0.5
# How many units of one clock make one of another: of ns, us, ms and s.
CLOCK_UNITS = tuple(10.0**k for k in (0, 3, 6, 9, -3, -6, -9))
# Word in the name of a time of a message, beside those for time.
OF_STAMP = re.compile(r"stamp(?![a-z])", re.IGNORECASE)
# Parts of a second are written with three digits at least [s].
OF_A_SECOND: Second = 1e-3


def counters_of(plan: ColumnPlan, columns: Mapping[str, RealArray]) -> list[str]:
    """Return the channels that count the rows: those that rise by one, or by the same whole number, in each.

    What a sensor measures does not rise so from each row to the next. Of a first column without a name, a few rows are
    enough, and by their names of other columns.
    """
    counters = [
        name
        for name in plan.channels
        if counts_rows(name, columns[name]) or (columns[name].size >= MANY_ROWS and is_nth_count(columns[name]))
    ]
    first = next(iter(plan.followers), "")
    unnamed = is_abscissa(first) and not first.endswith("]") and first not in counters
    # In a matrix, the column before the time counts the rows.
    unnamed |= first.endswith("[1]") and plan.time == f"{first.removesuffix('[1]')}[2]"
    if unnamed and columns[first].size >= FEW_STAMPS and is_count(columns[first]):
        counters.append(first)
    return [] if len(counters) == len(plan.channels) else counters


def _counts(name: str, column: RealArray) -> bool:
    """Return whether a column counts the rows, by its name or, where these are many, by its numbers alone."""
    return counts_rows(name, column) or (column.size >= MANY_ROWS and is_count(column))


def temperatures(plan: ColumnPlan, units: Mapping[str, str]) -> dict[str, Remark]:
    """Return the channels in a unit of temperature, where others are in none: they drift beside a motion.

    Examples
    --------
    >>> plan = ColumnPlan(channels=("seat [mm]", "oil"), time=None, clocks={}, rate=None, left_out={})
    >>> print(temperatures(plan, {"oil": "°C"})["oil"], temperatures(plan, {}))
    is a temperature, not a motion {}
    """
    of = {name: units.get(name, "") or unit_in_name(name) for name in plan.channels}
    found = [name for name, unit in of.items() if unit.replace(" ", "").lower() in TEMPERATURES]
    return dict.fromkeys(found, Remark(LeftOut.TEMPERATURE)) if len(found) < len(of) else {}


def magnitudes(plan: ColumnPlan, columns: Mapping[str, RealArray]) -> dict[str, Remark]:
    """Return the channels that are the magnitude of the three before them, as telephones add it: not linear in them.

    Most rows must tell so.

    Examples
    --------
    >>> x, y, z = np.random.default_rng(1).standard_normal((3, 50))
    >>> plan = ColumnPlan(channels=("x", "y", "z", "all"), time=None, clocks={}, rate=None, left_out={})
    >>> columns = {"x": x, "y": y, "z": z, "all": np.sqrt(x**2 + y**2 + z**2)}
    >>> [list(magnitudes(plan, columns | {"y": each})) for each in (y, np.full(50, np.nan))]
    [['all'], []]
    """
    found: dict[str, Remark] = {}
    for k in range(3, len(plan.channels)):
        name, axes = plan.channels[k], plan.channels[k - 3 : k]
        values = columns[name]
        # One that does not move is dead, which is said of it.
        if any(columns[axis].size != values.size for axis in axes) or not np.any(values > 0) or not np.ptp(values) > 0:
            continue
        apart = np.abs(np.sqrt(np.sum([columns[axis] ** 2 for axis in axes], axis=0)) - values)
        known = np.isfinite(apart)
        # Largest error of a magnitude that was computed from axes with more digits than the file has, relative to its
        # largest: half a unit of the last of three digits.
        if 2 * np.sum(known) > values.size and np.max(apart[known]) <= 5e-3 * float(np.nanmax(values)):
            found[name] = Remark(LeftOut.MAGNITUDE, {"axes": axes})
    return found


def single_numbers(plan: ColumnPlan, columns: Mapping[str, RealArray]) -> dict[str, Remark]:
    """Return the columns that hold a number in their first row alone, as some write a rate beside the samples."""
    some = {name: columns[name] for name in plan.channels if columns[name].size >= FEW_STAMPS}
    single = [name for name, values in some.items() if np.isfinite(values[0]) and not np.any(np.isfinite(values[1:]))]
    return dict.fromkeys(single, Remark(LeftOut.NUMBER)) if len(single) < len(plan.channels) else {}


def parts_of_seconds(plan: ColumnPlan, columns: Mapping[str, RealArray], stamps: RealArray) -> dict[str, Remark]:
    """Return the channels that hold the parts of a second beside the time: together with its stamps whole seconds.

    In a few rows a motion may be as much.

    Examples
    --------
    >>> stamps = 1_405_617_736 + np.arange(400) / 128
    >>> plan = ColumnPlan(channels=("seat", "fraction"), time="t", clocks={}, rate=None, left_out={})
    >>> list(parts_of_seconds(plan, {"seat": np.cos(stamps), "fraction": stamps % 1}, stamps))
    ['fraction']
    """
    found: dict[str, Remark] = {}
    for name in plan.followers:
        values = columns[name]
        if values.size != stamps.size or values.size < MANY_ROWS:
            continue
        lowest, highest = float(np.min(values)), float(np.max(values))
        if not 0 <= lowest <= highest < 1 or highest - lowest < 0.5 or np.ptp(stamps) < 1:
            continue
        whole = stamps - values
        if np.all(np.abs(whole - np.round(whole)) < OF_A_SECOND):
            found[name] = Remark(LeftOut.PARTS, {"other": plan.time or ""})
    return found if len(found) < len(plan.channels) else {}


def repeated_times(plan: ColumnPlan, columns: Mapping[str, RealArray]) -> dict[str, Remark]:
    """Return the channels that repeat the column of time number by number, as files with a time for each test do.

    One without a name may also run beside it, by less than half a sample more or less: the time of a second sensor.
    What rises in proportion to the time, to a small share of a sample, is a clock in another unit, or an axis. The
    stamp of a message may also jitter, or be held.
    """
    if plan.time is None or columns[plan.time].size < MANY_ROWS:
        return {}
    stamps = columns[plan.time]
    step = float(np.nanmedian(np.abs(np.diff(stamps))))
    same = [
        name
        for name in plan.followers
        if _is_same(columns[name], stamps)
        or (UNNAMED_COLUMN.fullmatch(name) and runs_beside(columns[name], stamps, 0.5 * step))
    ]
    others = [name for name in plan.followers if name not in same and not _counts(name, columns[name])]
    even = [
        name
        for name in others
        if _is_even(columns[name], stamps, OFF_EVEN * step) or _runs_on(name, columns[name], stamps)
    ]
    if len(same) + len(even) == len(plan.channels):
        return {}
    said = {name: Remark(LeftOut.SAME_TIME, {"other": plan.time, **late_by(stamps, columns[name])}) for name in same}
    return said | dict.fromkeys(even, Remark(LeftOut.EVEN))


def _is_same(column: RealArray, stamps: RealArray) -> bool:
    """Return whether a column repeats the time number by number, as a few of them tell of most that do not."""
    every = (slice(None, None, max(1, stamps.size // 16)), slice(None))
    return all(np.array_equal(column[some], stamps[some], equal_nan=True) for some in every)


def _is_even(column: RealArray, stamps: RealArray, most: float) -> bool:
    """Return whether a column changes in proportion to the time, to within a part of a sample.

    Examples
    --------
    >>> clock = np.array([0.0, 1.0, 2.0, 3.0])
    >>> _is_even(50 + 4 * clock, clock, 0.5), _is_even(clock**2, clock, 0.5)
    (True, False)
    """
    known = np.flatnonzero(np.isfinite(column) & np.isfinite(stamps))
    if known.size < 2 or column[known[0]] == column[known[-1]]:
        return False
    first, last = known[0], known[-1]
    # Most columns are none, as a few of their samples tell.
    few = known[:: max(1, known.size // 16)]
    # Next to the least number, a rise is no pace.
    with np.errstate(over="ignore", invalid="ignore"):
        pace = (stamps[last] - stamps[first]) / (column[last] - column[first])
        return runs_beside(column[few] * pace, stamps[few], most) and runs_beside(
            column[first:] * pace, stamps[first:], most
        )


def _runs_on(name: str, column: RealArray, stamps: RealArray) -> bool:
    """Return whether a column is a clock that runs beside the time: at its pace, but for jitter and holding.

    It counts from a date, or has a word of time in its name: a carriage that is driven at 1 m/s runs so as well.

    Examples
    --------
    >>> rows = np.arange(3000) / 100
    >>> clock = np.floor(rows)
    >>> [_runs_on(name, column, rows) for name, column in (("a", 1.7e9 + clock), ("stamp", clock), ("a", clock))]
    [True, True, False]
    """
    # Of most columns the name and a look at their largest number tell that they are none.
    named = OF_STAMP.search(name) is not None or may_be_time(name)
    if not named and not float(np.fmax.reduce(column, initial=0.0)) > SINCE_A_DATE:
        return False
    known = np.isfinite(column) & np.isfinite(stamps)
    clock, times = column[known], stamps[known]
    if clock.size < FEW_STAMPS or not (named or clock[0] > SINCE_A_DATE):
        return False
    length, rise = float(times[-1] - times[0]), float(clock[-1] - clock[0])
    if not 0 < length < np.inf or not 0 < rise < np.inf or not np.all(clock[1:] >= clock[:-1]):
        return False
    # In the unit of the time, or in another.
    unit = min(CLOCK_UNITS, key=lambda per: abs(np.log(rise / per / length)))
    held = float(np.max(np.diff(clock))) / unit
    apart = np.abs((clock - clock[0]) / unit - (times - times[0]))
    return held < MOST_HELD * length and bool(np.all(apart <= ANOTHER_PACE * length + held))
