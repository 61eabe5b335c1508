"""Tables: named columns of numbers as files hold them, before anyone says which is time."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from suspid.errors import RecordError
from suspid.files import read_text
from suspid.units import Hertz, RealArray, Second
from suspid.values import frozen_real, nearest_names

# How many of each unit of time make a second.
PER_SECOND = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds"), 1e3),
    **dict.fromkeys(("us", "usec", "µs", "μs", "microsecond", "microseconds"), 1e6),
    **dict.fromkeys(("ns", "nsec", "nanosecond", "nanoseconds"), 1e9),
    **dict.fromkeys(("min", "minute", "minutes"), 1 / 60),
}
TIME_NAMES = {"t", "time", "timepts", "timestamp", "timestamps", "timedomain", "timevector", "elapsed", "elapsedtime"}
TIME_NAMES |= {"zeit", "temps", "tiempo"} | {name for name in PER_SECOND if len(name) > 2 and name != "min"}
# A name and, in brackets behind it, its unit.
BRACKETED = re.compile(r"(.*\S)\s*[\[(]\s*([^\[\]()]*(?:\([^\[\]()]*\))?[^\[\]()]*)[\])]")
DELIMITERS = ("\t", ";", ",")


@dataclass(frozen=True, kw_only=True, slots=True)
class Clock:
    """When the samples of a column were taken.

    Parameters
    ----------
    name : str
        Name of the clock, such as that of the group of channels that share it.
    start : float
        Time of the first sample [s], where there are no stamps.
    rate : float or None
        Sampling rate that the file states [Hz]; None: only the stamps tell.
    stamps : callable, optional
        Returns the stamps [s] as they stand in the file. Default: ``start + arange(sample) / rate``.
    """

    name: str
    start: Second = 0.0
    rate: Hertz | None = None
    stamps: Callable[[], RealArray] | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Table:
    """Columns that may be time or channels; their numbers are read when asked for.

    Parameters
    ----------
    sizes : mapping of str to int
        Number of samples by column, in the order of the file.
    columns : callable
        Returns the numbers of the named columns, one read-only array each, NaN where one is missing; refuses
        text cells.
    unusable : mapping of str to str
        What else the file holds, and why it cannot be a column, as a predicate: ``"is text"``.
    rates : mapping of str to float
        Sampling rates that the file states [Hz], by the name under which they stand; they hold for every
        column without a clock.
    units : mapping of str to str
        Units by column as the file states them; a column without one may be absent.
    clocks : mapping of str to Clock
        Clocks by column. Columns of one clock share one `Clock`. Without one, time is the column named
        like a time, or follows from the rate.
    title : str
        What the file calls its content; empty: the name of the file stands for it.
    """

    sizes: Mapping[str, int]
    columns: Callable[[Sequence[str]], list[RealArray]]
    unusable: Mapping[str, str]
    rates: Mapping[str, Hertz]
    units: Mapping[str, str] = field(default_factory=dict)
    clocks: Mapping[str, Clock] = field(default_factory=dict)
    title: str = ""

    def check(self, name: str, *, what: str) -> None:
        """Refuse a column that is not there."""
        if name in self.unusable:
            raise RecordError(f"{what} {name!r} {self.unusable[name]}")
        if name not in self.sizes:
            raise RecordError(f"there is no {what} {name!r}.{nearest_names(name, self.sizes)}")

    def full_name(self, name: str, *, what: str) -> str:
        """Return the column of that name, or the only one of that name before its unit."""
        short = [column for column in self.sizes if bare_name(column) == name]
        if name not in self.sizes and name not in self.unusable and len(short) == 1:
            return short[0]
        self.check(name, what=what)
        return name


def bare_name(name: str) -> str:
    """Return the name without the unit in brackets behind it.

    Examples
    --------
    >>> bare_name("seat [mm]"), bare_name("a_seat_m/s2")
    ('seat', 'a_seat_m/s2')
    """
    found = BRACKETED.fullmatch(name.strip())
    return found[1].strip() if found else name.strip()


def bracketed_unit(name: str) -> str:
    """Return the unit in brackets behind a name; empty if there is none.

    Examples
    --------
    >>> bracketed_unit("seat [mm]"), bracketed_unit("acc (m/s^2)"), bracketed_unit("a_seat_m/s2")
    ('mm', 'm/s^2', '')
    """
    found = BRACKETED.fullmatch(name.strip())
    return found[2].strip() if found else ""


def split_unit(name: str) -> tuple[str, str]:
    """Return the bare name in lower case and the unit that follows it, if any.

    Examples
    --------
    >>> split_unit("Time [ms]"), split_unit("t_s"), split_unit("Time_domain")
    (('time', 'ms'), ('t', 's'), ('timedomain', ''))
    """
    lowered = name.strip().lower()
    bracketed = re.fullmatch(r"(.*?)[\s_,/]*[\[(]\s*(.*?)\s*[\])]", lowered)
    suffixed = re.fullmatch(r"(.*?)[\s_,/]+([^\s_,/]+)", lowered)
    stem, unit = lowered, ""
    if bracketed:
        stem, unit = bracketed[1], bracketed[2]
    elif suffixed and (suffixed[2] in PER_SECOND or suffixed[2] == "hz"):
        stem, unit = suffixed[1], suffixed[2]
    bare = re.sub(r"[\s_\-.]", "", stem)
    return bare, unit or (bare if bare in PER_SECOND else "")


def is_time(name: str) -> bool:
    """Whether a column of that name holds time in a unit that is known."""
    stem, unit = split_unit(name)
    return stem in TIME_NAMES and (not unit or unit in PER_SECOND)


def read_delimited(path: Path) -> Table:
    """Return the table of a text file: comma, semicolon or tab between cells, with or without header."""
    lines = read_text(path, error=RecordError).split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    if len(lines) < 2:
        raise RecordError(f"has {len(lines)} lines of text; a record needs at least 2 samples, one a line")
    delimiter = next((d for d in DELIMITERS if len(_cells(lines[1], d)) > 1), ",")
    first = [cell.strip() for cell in _cells(lines[0], delimiter)]
    first[:1] = [cell.removeprefix("# ") for cell in first[:1]]
    numeric = [_is_number(cell) for cell in first]
    header = not any(numeric) or (not all(numeric) and any(is_time(cell) for cell in first))
    if not header and not all(numeric):
        k = numeric.index(False)
        raise RecordError(
            f"line 1 is neither a header nor data: cell {k + 1} is {first[k]!r}, but "
            f"cell {numeric.index(True) + 1} is a number"
        )
    names = [cell or f"column {k + 1}" for k, cell in enumerate(first)]
    names = names if header else [f"column {k + 1}" for k in range(len(first))]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise RecordError(f"the header names {names.count(twice)} columns {twice!r}; names must differ")
    for number, line in enumerate(lines, start=1):
        # Counting is 20 times faster than parsing, and as good where nothing is quoted.
        width = len(_cells(line, delimiter)) if '"' in line else line.count(delimiter) + 1
        if width != len(names) or not line.strip():
            found = f"has {width} cells" if line.strip() else "is empty"
            raise RecordError(f"line {number} {found}, line 1 has {len(names)}{_separated_by(delimiter)}")
    body = lines[header:]

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        use = [names.index(name) for name in wanted]
        try:
            numbers = np.loadtxt(body, delimiter=delimiter, comments=None, quotechar='"', usecols=use, ndmin=2)
        except ValueError:
            numbers = None
        # A text that only one of the two parsers takes for a number is none.
        if numbers is None or len(numbers) != len(body):
            raise _text_cell(body, delimiter, {names[k]: k for k in use}, 1 + header)
        return [frozen_real(column) for column in numbers.T]

    units = {name: bracketed_unit(name) for name in names if bracketed_unit(name)}
    return Table(sizes=dict.fromkeys(names, len(body)), columns=columns, unusable={}, rates={}, units=units)


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter), [""])
    except csv.Error as refusal:
        raise RecordError(f"is not delimited text: {refusal}") from None


def _separated_by(delimiter: str) -> str:
    return f" (separated by {dict(zip(DELIMITERS, ('tabs', 'semicolons', 'commas'), strict=True))[delimiter]})"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _text_cell(body: Sequence[str], delimiter: str, used: Mapping[str, int], first_line: int) -> RecordError:
    """Return the error that names the first used cell that is no number."""
    for number, line in enumerate(body, start=first_line):
        cells = _cells(line, delimiter)
        for name, k in used.items():
            if not _is_number(cells[k]):
                text = cells[k].strip()
                hint = "; write decimals with a point" if re.fullmatch(r"[+-]?\d*,\d+(e[+-]?\d+)?", text, re.I) else ""
                found = f"{text!r} is not a number" if text else "the cell is empty"
                return RecordError(f"line {number}, column {name!r}: {found}{hint}")
    return RecordError(f"columns {', '.join(map(repr, used))} hold cells that are not numbers")
