"""Cells: what one cell of a text file says: a number, nothing, a time, or words."""

from __future__ import annotations

import datetime
import functools
import re
from collections.abc import Callable, Iterable
from typing import Literal, TypeAlias

import numpy as np

from suspid.errors import RecordError
from suspid.units import RealArray

Kind: TypeAlias = Literal["number", "missing", "stamp", "date", "text"]

# What loggers, spreadsheets and C libraries print where there is no number.
MISSING = {
    "",
    "nan",
    "na",
    "n/a",
    "#n/a",
    "#na",
    "#nv",
    "null",
    "none",
    "nil",
    "-",
    "--",
    "---",
    "----",
    "?",
    "*",
    "***",
}
MISSING |= {"nan(ind)", "nan(snan)", "1.#qnan", "1.#ind", "1.#snan", "#value!", "#wert!", "#div/0!", "#num!", "#zahl!"}
POINT_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|[+-]?inf(?:inity)?", re.I | re.A)
COMMA_NUMBER = re.compile(r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eEdD][+-]?\d+)?|[+-]?inf(?:inity)?", re.I | re.A)
TIME = (
    r"(?:(?P<hour>\d{1,2}):)?(?P<minute>\d\d?):(?P<second>\d\d)"
    r"(?:[.,](?P<fraction>\d+))?(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
)
DATE = r"(?P<date>\d{4}[-/.]\d\d?[-/.]\d\d?|\d\d?[-/.]\d\d?[-/.]\d{4})"
STAMP = re.compile(rf"(?:{DATE}(?:[T\s]|,\s*))?\s*{TIME}\s*(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?", re.A)
DATE_ALONE = re.compile(DATE, re.A)
NANO = 10**9
DAY = 86400 * NANO
# Nanoseconds since 1970 in 64 bits end in 2262.
YEARS = range(1700, 2260)
MISSING_NANOS = -(1 << 63)
UNIX_DAY = datetime.date(1970, 1, 1).toordinal()


def kind_of(cell: str, *, comma: bool) -> Kind:
    """Return what a cell holds, by its look, where decimals stand behind a comma or a point.

    Examples
    --------
    >>> [kind_of(cell, comma=True) for cell in ("1,5", "1.5", "-nan", "12:34:56,7", "03.05.2024", "seat")]
    ['number', 'text', 'missing', 'stamp', 'date', 'text']
    """
    text = cell.strip()
    if (COMMA_NUMBER if comma else POINT_NUMBER).fullmatch(text):
        return "number"
    if text.lower().lstrip("+-") in MISSING or text in MISSING:
        return "missing"
    found = STAMP.fullmatch(text)
    if found and (found["hour"] or found["fraction"]):
        return "stamp"
    return "date" if DATE_ALONE.fullmatch(text) else "text"


def number(cell: str, *, comma: bool) -> float:
    """Return the number in a cell, NaN where there is none.

    Raises
    ------
    ValueError
        If the cell holds anything else.
    """
    text = cell.strip()
    if not (COMMA_NUMBER if comma else POINT_NUMBER).fullmatch(text):
        if kind_of(text, comma=comma) == "missing":
            return float("nan")
        raise ValueError(text)
    text = text.replace(",", ".") if comma else text
    return float(text if text[-1] in "fyFY" else text.replace("D", "e").replace("d", "e"))


def seconds(cells: Callable[[], Iterable[str]]) -> RealArray:
    """Return dates and times of day [s] from the first of them on, exact to the nanosecond; NaN where one is missing.

    Times of day without a date go on after midnight.

    Parameters
    ----------
    cells : callable
        Returns the cells; called a second time where months stand before days.

    Raises
    ------
    RecordError
        If a date does not exist, or day and month cannot be told apart.

    Examples
    --------
    >>> stamps = ["23:59:59.5", "", "00:00:00.25"]
    >>> seconds(lambda: stamps)
    array([0.  ,  nan, 0.75])
    """
    dates: set[str] = set()
    nanos = np.fromiter((_nanos(cell, True, dates) for cell in cells()), np.int64)
    if not _day_first(dates):
        nanos = np.fromiter((_nanos(cell, False, dates) for cell in cells()), np.int64)
    there = nanos != MISSING_NANOS
    found = nanos[there]
    if found.size and not dates:
        # A time of day that falls by more than half a day has passed midnight.
        found[1:] += DAY * np.cumsum(np.diff(found) < -DAY // 2)
    stamps = np.full(nanos.size, np.nan)
    stamps[there] = (found - found[:1]) / NANO
    return stamps


def _nanos(cell: str, day_first: bool, dates: set[str]) -> int:
    """Return a time [ns] since 1970 or midnight, and keep its date."""
    match = STAMP.fullmatch(cell.strip())
    if match is None:
        return MISSING_NANOS
    date, hour, minute, second, fraction, half, zone = match.group(
        "date", "hour", "minute", "second", "fraction", "half", "zone"
    )
    hours = int(hour or 0)
    if half:
        hours = hours % 12 + 12 * (half in "pP")
    total = (hours * 3600 + int(minute) * 60 + int(second)) * NANO
    if fraction:
        total += int((fraction + "00000000")[:9])
    if zone and zone[0] in "+-":
        minutes = int(zone[1:3]) * 60 + int(zone[-2:])
        total -= (minutes if zone[0] == "+" else -minutes) * 60 * NANO
    if date:
        dates.add(date)
        total += (_day(date, day_first) or 0) * DAY
    return total


@functools.lru_cache(maxsize=1024)
def _day(text: str, day_first: bool) -> int | None:
    """Return the days since 1970, or None if there is no such day."""
    parts = [int(part) for part in re.split(r"[-/.]", text)]
    if parts[0] < 1000:
        parts = [parts[2], parts[1], parts[0]] if day_first else [parts[2], parts[0], parts[1]]
    try:
        return datetime.date(*parts).toordinal() - UNIX_DAY if parts[0] in YEARS else None
    except ValueError:
        return None


def _day_first(dates: set[str]) -> bool:
    """Return whether the day stands before the month, where the year is last."""
    first = [all(_day(date, order) is not None for date in dates) for order in (True, False)]
    if not any(first):
        text = next(date for date in sorted(dates) if _day(date, True) is None)
        raise RecordError(f"there is no date {text!r}")
    slashed = {date for date in dates if re.match(r"\d\d?[-/]", date)}
    if all(first) and len(slashed) > 1 and any(_day(d, True) != _day(d, False) for d in slashed):
        one, two = sorted(slashed)[:2]
        raise RecordError(
            f"in the dates {one!r} and {two!r} day and month cannot be told apart; write them as year-month-day"
        )
    return first[0]
