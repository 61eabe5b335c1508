"""Cells of text files: numbers, missing values, times of day, dates and words."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Literal, TypeAlias

import numpy as np

from suspid.errors import RecordError
from suspid.io.names import LONGEST_READ
from suspid.units import RealArray

Kind: TypeAlias = Literal["number", "missing", "stamp", "date", "text"]

# What loggers, spreadsheets and C libraries print in place of a number, without its sign.
MISSING = {"", "nan", "na", "n/a", "#n/a", "#na", "#nv", "null", "none", "nil", "-", "--", "---", "----", "?", "*"}
# Beyond the range of a meter or a converter.
MISSING |= {"ovl", "ol", "o.l.", "overload", "overflow", "overrange", "over", "1.#inf", "1.#j", "invalid", "bad"}
MISSING |= {"***", "nan(ind)", "nan(snan)", "1.#qnan", "1.#ind", "1.#snan"}
MISSING |= {"#value!", "#wert!", "#div/0!", "#num!", "#zahl!"}
POINT_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|[+-]?inf(?:inity)?", re.I | re.A)
COMMA_NUMBER = re.compile(POINT_NUMBER.pattern.replace(r"\d+\.?\d*|\.\d+", r"\d+(?:,\d+)?|,\d+"), re.I | re.A)
TIME_OF_DAY = (
    r"(?:(?P<hour>\d\d?):)?(?P<minute>\d\d?):(?P<second>\d\d)(?:(?:[.,]|:(?=\d{3}))(?P<part>\d+))?"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
)
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
DATE = (
    r"(?P<date>\d{4}[-/.]\d\d?[-/.]\d\d?|\d\d?[-/.]\d\d?[-/.]\d{4}"
    rf"|\d\d?[- ](?i:{'|'.join(MONTHS)})[- ]\d{{4}})"
)
ZONE = r"(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?"
# MATLAB writes stamps between apostrophes.
STAMP = re.compile(rf"'?(?:{DATE}(?:[T\s]|,\s*))?\s*{TIME_OF_DAY}\s*{ZONE}'?", re.A)
DATE_ALONE = re.compile(rf"'?{DATE}'?", re.A)
NANO = 10**9
DAY = 86400 * NANO
# In place of the number of a date.
NO_DATE, NO_STAMP = -1, -2


def kind_of(cell: str, *, comma: bool) -> Kind:
    """Return what a cell holds, with decimals after a comma or a point.

    Examples
    --------
    >>> [kind_of(cell, comma=True) for cell in ("1,5", "1.5", "-nan", "12:34:56,7", "03.05.2024", "seat")]
    ['number', 'text', 'missing', 'stamp', 'date', 'text']
    """
    text = cell.strip()
    if len(text) > LONGEST_READ:
        return "text"
    if (COMMA_NUMBER if comma else POINT_NUMBER).fullmatch(text):
        return "number"
    if text.lower().lstrip("+-") in MISSING or text in MISSING:
        return "missing"
    found = STAMP.fullmatch(text)
    if found and (found["hour"] or found["part"]):
        return "stamp"
    return "date" if DATE_ALONE.fullmatch(text) else "text"


def number(cell: str, *, comma: bool) -> float | None:
    """Return the number in a cell, NaN if it is missing, None if the cell holds anything else."""
    text = cell.strip()
    kind = kind_of(text, comma=comma)
    if kind != "number":
        return float("nan") if kind == "missing" else None
    text = text.replace(",", ".")
    return float(text if text[-1] in "fyFY" else text.replace("D", "e").replace("d", "e"))


def seconds(cells: Iterable[str]) -> RealArray:
    """Return dates and times of day [s] since the first one, exact to the nanosecond; NaN where one is missing.

    Times of day without a date continue after midnight. Dates that do not exist, or whose day and month cannot be told
    apart, are refused.

    Examples
    --------
    >>> seconds(["23:59:59.5", "", "00:00:00.25"])
    array([0.  ,  nan, 0.75])
    """
    dates: dict[str, int] = {}
    nanos, date_of = np.fromiter(_parts(cells, dates), np.dtype((np.int64, 2))).T
    there = date_of > NO_STAMP
    days = np.array([*(_days(list(dates)) if dates else []), 0])
    found = nanos[there] + DAY * days[date_of[there]]
    if not dates:
        # A time of day that falls by more than half a day has passed midnight.
        found += DAY * np.cumsum(np.diff(found, prepend=found[:1]) < -DAY // 2)
    stamps = np.full(nanos.size, np.nan)
    stamps[there] = (found - found[:1]) / NANO
    return stamps


def clock_seconds(cells: Sequence[str]) -> RealArray | None:
    """Return times of day and dates [s] since the first one; None where a cell holds anything else.

    Examples
    --------
    >>> clock_seconds(["12:00:00.5", "", "12:00:01"]), clock_seconds(["12:00:00", "seat"])
    (array([0. , nan, 0.5]), None)
    """
    kinds = [kind_of(cell, comma=False) for cell in cells[:1]]
    if kinds and kinds[0] not in ("stamp", "missing"):
        return None
    kinds = [kind_of(cell, comma=False) for cell in cells]
    return seconds(cells) if set(kinds) <= {"stamp", "missing"} and "stamp" in kinds else None


def _parts(cells: Iterable[str], dates: dict[str, int]) -> Iterator[tuple[int, int]]:
    """Yield the time of day [ns] and the number of the date of each cell, and add new dates to those known."""
    for cell in cells:
        match = STAMP.fullmatch(cell.strip())
        if match is None:
            yield 0, NO_STAMP
        else:
            date = match["date"]
            yield _nanos(match), dates.setdefault(date, len(dates)) if date else NO_DATE


def _nanos(match: re.Match[str]) -> int:
    """Return a time of day [ns] in UTC where a zone is stated."""
    hour, minute, second, part, half, zone = match.group("hour", "minute", "second", "part", "half", "zone")
    hours = int(hour or 0) % 12 + 12 * (half in "pP") if half else int(hour or 0)
    minutes = 60 * hours + int(minute)
    if zone and zone[0] in "+-":
        minutes -= int(f"{zone[0]}1") * (int(zone[1:3]) * 60 + int(zone[-2:]))
    return (60 * minutes + int(second)) * NANO + int(f"{part or 0}00000000"[:9])


def _days(dates: list[str]) -> list[int]:
    """Return the number of each day; the order of day and month must follow from the dates together."""
    orders = [[_day(date, day_first=first) for date in dates] for first in (True, False)]
    possible = [[day for day in days if day is not None] for days in orders if None not in days]
    if not possible:
        odd = min(date for date, day in zip(dates, orders[0], strict=True) if day is None)
        raise RecordError(f"there is no date {odd!r}")
    # Dots stand in dates of countries that write the day first.
    slashed = sorted(date for date in dates if re.match(r"\d\d?[-/]", date))
    if len(possible) == 2 and possible[0] != possible[1] and len(slashed) > 1:
        raise RecordError(
            f"in the dates {slashed[0]!r} and {slashed[1]!r} day and month cannot be distinguished; "
            f"write them as year-month-day"
        )
    return possible[0]


def _day(date: str, *, day_first: bool) -> int | None:
    """Return the number of a day, None if it does not exist."""
    parts = re.split(r"[-/. ]", date)
    if not parts[1].isdecimal():
        parts, day_first = [parts[0], str(MONTHS.index(parts[1].lower()) + 1), parts[2]], True
    one, two, three = map(int, parts)
    year, month, day = (one, two, three) if one >= 1000 else (three, two, one) if day_first else (three, one, two)
    try:
        # Nanoseconds since 1970 overflow 64 bits outside these years.
        return (datetime.date(year, month, day) - datetime.date(1970, 1, 1)).days if 1700 <= year < 2260 else None
    except ValueError:
        return None
