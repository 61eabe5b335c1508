"""Columns of time: which column of a table is time, and its stamps in seconds."""

from __future__ import annotations

import contextlib
import itertools
import re
from collections.abc import Mapping, Sequence

import numpy as np

from suspid.errors import RecordError
from suspid.io.clock_numbers import (
    MANY_STAMPS,
    at_one_pace,
    counts_in_steps,
    filled,
    jitters_at_one_pace,
    keeps_pace,
    never_falls,
    runs_as_clock,
    ticks,
)
from suspid.io.names import (
    FREQUENCY_UNITS,
    NUMBERED_COLUMN,
    PER_SECOND,
    bracketed_unit,
    counts_rows,
    is_abscissa,
    is_count,
    is_counter,
    is_frequency,
    is_time,
    may_be_time,
    test_in_name,
)
from suspid.io.newest_first import is_newest_first
from suspid.io.tables import Table, TimeBase
from suspid.io.time_units import in_seconds, late_by, runs_beside, unit_of_else
from suspid.stamps import MOST_STEPS
from suspid.units import Hertz, RealArray
from suspid.wording import Argument
from suspid.words import LeftOut, Remark

# What to do with a file over frequency.
NO_SPECTRA = "records over time are needed, no spectra or frequency responses; export the time histories"
# Steps that differ by less than this, relative to them, are even but for rounding.
EVEN_TIME = 1e-3
# A column that turns as often as this swings: one that is driven once to and fro turns less often.
TURNS = 10
# Changes of side in two swings, by more than this share of the standard deviation: noise turns more often.
SIDES_OF_TWO, ONE_SIDE = 4, 0.5
# Names of times that have a number each.
NUMBERED_TIME = re.compile(r"(?:t|time|zeit)[\W_]*\d+", re.IGNORECASE)


def time_column(
    table: Table, channels: Sequence[str], clocks: Mapping[str, TimeBase], fs: Hertz | None
) -> tuple[str | None, dict[str, TimeBase], dict[str, Remark]]:
    """Return the column of time, or the times of columns that each have their own, and other columns of time."""
    free = [name for name in table.sizes if name not in channels and name not in clocks]
    candidates = time_names(table, free, given=fs is not None)
    if len(candidates) > 1 and len({table.sizes[c] for c in channels}) == 1:
        # Vectors of another length belong to another record.
        candidates = [name for name in candidates if table.sizes[name] == table.sizes[channels[0]]]
    # Tests side by side may run on the same times, and end one after the other.
    numbered = fs is None and len(candidates) > 1 and all(map(test_in_name, candidates))
    if numbered and (apart := _pairs(table, {name: name for name in candidates})):
        return None, apart, dict.fromkeys(candidates, Remark(LeftOut.GROUP_TIME))
    said = {name: Remark(LeftOut.TAKEN_AS_TIME) for name in candidates if not may_be_time(name) and not is_time(name)}
    # Telephones write the time of day beside the time since the start; others write the time before each channel.
    kept: list[str] = []
    times: dict[str, str] = {}
    for name in candidates:
        same = next((k for k, other in enumerate(kept) if _same_time(table, other, name)), None)
        times[name] = name if same is None else kept[same]
        if same is None:
            kept.append(name)
            continue
        pair = {one: in_seconds(table, one, table.columns([one])[0]) for one in (kept[same], name)}
        better, worse = sorted(pair, key=lambda one: abs(pair[one][0]))
        kept[same] = better
        times = {one: better if of == worse else of for one, of in times.items()} | {name: better}
        said[worse] = Remark(LeftOut.SAME_TIME, {"other": better, **late_by(pair[better], pair[worse])})
    if len(kept) > 1:
        pairs = _pairs(table, times)
        if pairs and fs is None:
            return None, pairs, {**dict.fromkeys(kept, Remark(LeftOut.GROUP_TIME)), **said}
        stamps = {name: in_seconds(table, name, table.columns([name])[0]) for name in kept}
        even = [name for name, its in stamps.items() if runs_as_clock(its) and np.all(np.diff(its[: filled(its)]) > 0)]
        if len(even) == 1:
            said |= {**dict.fromkeys(kept, Remark(LeftOut.LIKE_TIME)), even[0]: Remark(LeftOut.TAKEN_AS_TIME)}
            return even[0], {}, said
        also = "" if fs is None else f", even beside {Argument('fs')}: it must agree"
        raise RecordError(f"{', '.join(map(repr, kept))} all read like a time; name one ({Argument('time')}){also}")
    spare = {name: Remark(LeftOut.LIKE_TIME) for name in _spare(table, free) if name not in times}
    if kept and spare and not is_time(kept[0]):
        said[kept[0]] = Remark(LeftOut.TAKEN_AS_TIME)
    return (kept[0] if kept else None), {}, {**said, **spare}


def _spare(table: Table, free: Sequence[str]) -> list[str]:
    """Return the columns that are named as times and rise in even steps, or in a unit of time and never fall.

    Those that never fall are times of slower sensors.
    """
    named = [name for name in free if may_be_time(name) and table.units.get(name, "").lower() in ("", *PER_SECOND)]
    found: list[str] = []
    with contextlib.suppress(RecordError):
        for name, numbers in zip(named, table.columns(named), strict=True):
            steps = np.diff(numbers[: filled(numbers)])
            lowest, highest = float(np.min(steps, initial=np.inf)), float(np.max(steps, initial=-np.inf))
            even = lowest > 0 and highest - lowest < EVEN_TIME * highest
            if even or (lowest >= 0 and bracketed_unit(name).lower() in PER_SECOND):
                found.append(name)
    return found


def _pairs(table: Table, times: Mapping[str, str]) -> dict[str, TimeBase]:
    """Return the time of each column where every time stands before its columns; none if they do not."""
    names, pairs = list(table.sizes), dict[str, TimeBase]()
    clocks = {time: _clock_of(table, time) for time in set(times.values())}
    if names[0] not in times or any(a in times and b in [*times, ""] for a, b in itertools.pairwise([*names, ""])):
        return {}
    time = names[0]
    for name in names:
        if name in times:
            time = name
        elif table.sizes[name] == table.sizes[time]:
            pairs[name] = clocks[times[time]]
    return pairs


def _clock_of(table: Table, time: str) -> TimeBase:
    def stamps() -> RealArray:
        numbers = table.columns([time])[0]
        return in_seconds(table, time, numbers[: filled(numbers)])

    return TimeBase(name=time, stamps=stamps, cut=True)


def _same_time(table: Table, one: str, other: str) -> bool:
    """Whether two columns of time run alike but for their start."""
    if table.sizes[one] != table.sizes[other]:
        return False
    first, second = (in_seconds(table, name, table.columns([name])[0]) for name in (one, other))
    with np.errstate(invalid="ignore"):
        step = float(np.median(np.abs(np.diff(second))))
        return step > 0 and runs_beside(first, second, step / 2)


def increasing(table: Table) -> str:
    """Return a hint at the first column if its numbers increase, or count the rows, else at the last, or another.

    Without one, it is at the only column that falls throughout.
    """
    for name in dict.fromkeys([*list(table.sizes)[:1], *list(table.sizes)[-1:], *table.sizes]):
        if unit_of_else(table, name):
            continue
        with contextlib.suppress(RecordError):
            if over_frequency(table, name):
                return f"; {name!r} holds frequencies: {NO_SPECTRA}"
            if counts_rows(name, table.columns([name])[0]):
                return f"; {name!r} counts the rows and is not a time"
            steps = np.diff(table.columns([name])[0])
            # The clock of a small board may step back a little now and then; a motion, and parts of a second, fall as
            # far as they rise.
            if steps.size > 1 and np.sum(steps) > 0 and np.sum(steps) >= MOST_STEPS * np.sum(np.abs(steps)):
                if len(table.sizes) == 1:
                    return f"; {name!r} increases like a time, and no other column is a channel"
                return f"; {name!r} increases like a time: if it is one, give {Argument('time', repr(name))}"
    with contextlib.suppress(RecordError):
        columns = zip(table.sizes, table.columns(list(table.sizes)), strict=True)
        falling = [name for name, its in columns if is_newest_first(name, its) and not is_counter(name)]
        if len(falling) == 1 < len(table.sizes):
            (name,) = falling
            return f"; {name!r} falls like a time, newest first: if it is one, give {Argument('time', repr(name))}"
    return ""


def over_frequency(table: Table, name: str) -> bool:
    """Whether a column holds the frequencies of a spectrum, by its name, or by its unit where it never falls."""
    in_hertz = table.units.get(name, "").lower() in FREQUENCY_UNITS
    return is_frequency(name) or (in_hertz and never_falls(table.columns([name])[0]))


def time_names(table: Table, among: Sequence[str] | None = None, *, given: bool = False) -> list[str]:
    """Return the columns that are named as times, or else those that may be one and run as a clock does.

    Where a rate is ``given``, a column named x is a channel.
    """
    every = list(table.sizes) if among is None else among
    free = [name for name in every if table.units.get(name, "").lower() not in FREQUENCY_UNITS]
    if times := [name for name in free if is_time(name)]:
        return times
    named = [name for name in free if may_be_time(name)]
    if not named and len(table.sizes) > 1:
        # The first column of a table, and of each matrix beside others.
        matrices = {name.removesuffix("[1]") for name in free if name.endswith("[1]")}
        firsts = {_first(table), *(_of_matrix(table, name) for name in matrices if f"{name}[2]" in table.sizes)}
        named = [name for name in free if name in firsts and is_abscissa(name, rate_known=bool(table.rates) or given)]
    # Oscilloscopes call the time x, or after the trace, and write its unit above or below.
    of_time = {name for name in free if table.units.get(name, "").lower() in PER_SECOND}
    named = named or [name for name in free if name in of_time]
    with contextlib.suppress(RecordError):
        columns = zip(named, table.columns(named), strict=True)
        clocks = [name for name, its in columns if runs_as_clock(its) or (name in of_time and never_falls(its))]
        return clocks or _numbered_times(table, named) or ([] if given or table.rates else _unnamed_clock(table, free))
    return []


def _numbered_times(table: Table, named: Sequence[str]) -> list[str]:
    """Return the times of tests side by side, T1, S1, T2, S2, …: of unsteady loggers, each with its number."""
    if len(named) < 2 or not all(NUMBERED_TIME.fullmatch(name) for name in named):
        return []
    columns = [numbers[: filled(numbers)] for numbers in table.columns(named)]
    steady = all(never_falls(its) and at_one_pace(np.diff(its)) for its in columns)
    return list(named) if steady and _pairs(table, {name: name for name in named}) else []


def _unnamed_clock(table: Table, free: Sequence[str]) -> list[str]:
    """Return the one column of columns without names that runs as a clock: small loggers write the time last.

    They may be numbered. Other numbers that rise evenly may be a displacement that is driven: it does not jitter, and
    nothing swings beside it. The first of two that rises unevenly, or in whole milliseconds, is one if the other
    swings.
    """
    numbers_of = [NUMBERED_COLUMN.fullmatch(name) for name in table.sizes]
    if len(free) < 2 or [match and int(match[1]) for match in numbers_of] != list(range(1, len(numbers_of) + 1)):
        return []
    columns = dict(zip(free, table.columns(list(free)), strict=True))
    if len(table.sizes) == 2 == len(free):
        first, second = columns.values()
        finite = first.size >= MANY_STAMPS and np.all(np.isfinite(first)) and np.all(np.isfinite(second))
        if finite and ((keeps_pace(first) and _turns(second)) or (counts_in_steps(first) and _swings(second))):
            return [free[0]]
    running = [name for name, numbers in columns.items() if ticks(numbers)]
    if not running and len(table.sizes) == len(free) > 2:
        running = [name for name, numbers in columns.items() if jitters_at_one_pace(numbers)]
        others = [numbers for name, numbers in columns.items() if name not in running]
        running = running if all(map(_turns, others)) and any(map(_swings, others)) else []
    return running if len(running) == 1 else []


def _turns(numbers: RealArray) -> bool:
    return bool(np.sum(np.diff(np.sign(np.diff(numbers[np.isfinite(numbers)]))) != 0) >= TURNS)


def _swings(numbers: RealArray) -> bool:
    """Whether numbers go from one side of their median to the other and back again, and again.

    A loop of force does so once, the peaks of a spectrum lie on one side.
    """
    known = numbers[np.isfinite(numbers)]
    off = known - np.median(known)
    sides = np.sign(off[np.abs(off) > ONE_SIDE * np.std(off)])
    return bool(np.sum(np.diff(sides) != 0) >= SIDES_OF_TWO)


def _first(table: Table) -> str:
    """Return the first column, or the second of columns without names where the first counts the rows."""
    name, second, *_ = [*table.sizes, ""]
    if name == "column 1" and second == "column 2" and len(table.sizes) > 2 and is_count(table.columns([name])[0]):
        return second
    return name


def _of_matrix(table: Table, name: str) -> str:
    """Return the first column of a matrix, or the second where the first counts the rows and others follow."""
    first, second, third = (f"{name}[{k}]" for k in (1, 2, 3))
    return second if third in table.sizes and is_count(table.columns([first])[0]) else first
