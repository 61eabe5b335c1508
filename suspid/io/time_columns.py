"""Columns of time: which column of a table is time, and its stamps in seconds."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

import numpy as np

from suspid.errors import RecordError
from suspid.io.tables import KNOWN_UNITS, PER_SECOND, Table, TimeBase, is_count, is_time, split_unit
from suspid.units import Hertz, RealArray
from suspid.words import LeftOut, Remark

# Stamps this near to an even grid, in steps, are a time although nothing names them so; fewer stamps do not show it.
EVEN, FEW_STAMPS = 1e-3, 8
# Least size of a stamp since 1970, by its unit: present ones are near 1.7e12 ms, 1.7e15 us and 1.7e18 ns.
EPOCHS = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))


def time_column(
    table: Table, channels: Sequence[str], clocks: Mapping[str, TimeBase], fs: Hertz | None
) -> tuple[str | None, dict[str, Remark]]:
    """Return the column of time, and other columns of the same time."""
    candidates = [name for name in table.sizes if is_time(name) and name not in channels and name not in clocks]
    if len(candidates) > 1 and len({table.sizes[c] for c in channels}) == 1:
        # Vectors of another length belong to another record.
        candidates = [name for name in candidates if table.sizes[name] == table.sizes[channels[0]]]
    passed_over: dict[str, Remark] = {}
    # Telephones write the time of day beside the time since the start.
    while len(candidates) > 1 and _same_time(table, candidates[0], candidates[1]):
        starts = [abs(in_seconds(table, name, table.columns([name])[0])[0]) for name in candidates[:2]]
        worse = candidates.pop(0 if starts[0] > starts[1] else 1)
        passed_over[worse] = Remark(LeftOut.SAME_TIME, {"other": candidates[0]})
    if len(candidates) > 1:
        also = "" if fs is None else ", even beside fs: it must agree"
        raise RecordError(f"{', '.join(map(repr, candidates))} all read like a time; name one (time){also}")
    if not candidates and fs is None and not (channels or clocks or table.rates):
        return _unnamed_time(table), {}
    return (candidates[0] if candidates else None), passed_over


def _same_time(table: Table, one: str, other: str) -> bool:
    """Whether two columns of time run alike but for their start."""
    if table.sizes[one] != table.sizes[other]:
        return False
    first, second = (in_seconds(table, name, table.columns([name])[0]) for name in (one, other))
    with np.errstate(invalid="ignore"):
        apart = np.abs((first - first[:1]) - (second - second[:1]))
        step = np.median(np.abs(np.diff(second)))
    return bool(step > 0 and np.all(apart <= step / 2))


def increasing(table: Table) -> str:
    """Return a hint at the first column if its numbers increase from row to row."""
    for name in list(table.sizes)[:1]:
        with contextlib.suppress(RecordError):
            if table.sizes[name] > 2 and np.all(np.diff(table.columns([name])[0]) > 0):
                return f"; {name!r} increases as a time does"
    return ""


def _unnamed_time(table: Table) -> str | None:
    """Return the first of several columns without names if it rises evenly and does not merely count the rows."""
    names = list(table.sizes)
    if len(names) < 2 or names != [f"column {k + 1}" for k in range(len(names))] or table.sizes[names[0]] < FEW_STAMPS:
        return None
    stamps = table.columns(names[:1])[0]
    if not np.all(np.isfinite(stamps)):
        return None
    steps = np.diff(stamps)
    step = float(np.mean(steps))
    even = step > 0 and np.all(np.abs(stamps - stamps[0] - step * np.arange(stamps.size)) <= EVEN * step)
    return names[0] if (even and not is_count(stamps)) or _are_rounded(stamps, steps) else None


def _are_rounded(stamps: RealArray, steps: RealArray) -> bool:
    """Whether stamps are an even grid, rounded to a unit by which the steps differ."""
    unit = float(f"{np.ptp(steps):.1g}")
    if not (unit > 0 and np.all(steps >= 0)):
        return False
    counts = stamps / unit
    line = np.polynomial.Polynomial.fit(np.arange(stamps.size), counts, 1)(np.arange(stamps.size))
    return bool(np.all(np.abs(counts - np.round(counts)) < EVEN) and np.all(np.abs(counts - line) <= 1))


def time_unit(table: Table, time: str) -> str:
    """Return the unit of a column of time in lower case, as stated or in its name; empty if there is none."""
    return table.units.get(time, "").strip().lower() or split_unit(time)[1]


def in_seconds(table: Table, time: str, stamps: RealArray) -> RealArray:
    """Return the numbers of a column of time in seconds."""
    unit = time_unit(table, time) or epoch_unit(stamps)
    if unit not in PER_SECOND:
        raise RecordError(unknown_unit(time))
    return np.asarray(stamps / PER_SECOND[unit])


def unknown_unit(time: str) -> str:
    """Return what is wrong with a column of time in an unknown unit."""
    return f"the unit of time in {time!r} is not known; known: {KNOWN_UNITS}; rename it, or ignore it and give fs"


def is_unusually_slow(table: Table, time: str, stamps: RealArray) -> bool:
    """Whether stamps without a unit are whole numbers one or more apart: a counter, or another unit than seconds."""
    some = stamps[np.isfinite(stamps)]
    if time_unit(table, time) or some.size < FEW_STAMPS or epoch_unit(stamps) != "s":
        return False
    return bool(np.all(some == np.round(some)) and np.median(np.diff(some)) >= 1)


def epoch_unit(stamps: RealArray) -> str:
    """Return the unit of stamps without one: s, unless that would be a year beyond 4000.

    The median is compared, so that single wrong stamps do not count.
    """
    sizes = np.abs(stamps[np.isfinite(stamps)])
    size = float(np.median(sizes)) if sizes.size else 0.0
    return next((name for name, least in EPOCHS if size > least), "s")
