"""Layouts of text files: the lines above the data, with names and units of the columns."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

from suspid.errors import RecordError
from suspid.io.names import bracketed_unit, is_since_last, plain, stated_rate, told_apart
from suspid.io.text.axis_units import axis_unit
from suspid.io.text.beside import stated_beside
from suspid.io.text.cells import Kind, kind_of
from suspid.io.text.columns import Columns
from suspid.io.text.dialects import NUMERIC, Dialect, find_dialect, shapes, shortened
from suspid.io.text.label_columns import UNIT_LABELS, named_above, without_labels
from suspid.io.text.thousands import marks_between, why_no_number
from suspid.units import Hertz, Second
from suspid.words import LeftOut, Remark

# A line drawn below a header.
RULE = re.compile(r"(?=.*(?:-{3}|={3}|_{3}|\*{3}|~{3}|#{3}))[\s\-=_*~#+|]+")
# A column is blank in more rows than this where it holds settings beside the first ones.
MOSTLY = 0.9
KEY_VALUE = re.compile(
    r"\W*([^\W\d][^:=;,\t]*?)\s*(?::=|[:=;,\t])\s*[\"']?([+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*[;,\t]?\s*(\w*(?:/s)?)\W*"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """What the top of a text file says of the rows below it."""

    dialect: Dialect
    # Names of the columns in their order; an empty last one stands for a delimiter at the end of each row.
    names: tuple[str, ...]
    units: Mapping[str, str]
    kinds: Mapping[str, Kind]
    first: int
    # Sampling rates that lines above the data state [Hz].
    rates: Mapping[str, Hertz]
    # Time of the first sample that such a line states beside the step [s].
    start: Second
    # Lines above the data that are neither names nor units, and names that were changed.
    left_out: Mapping[str, Remark]


def find_layout(head: Sequence[str], sample: Sequence[str], *, before: int = 0) -> Layout:
    """Return the layout of a file from its first lines and a sample of lines from all over it.

    Of a part of a file, lines stand ``before`` the first ones.
    """
    columns = _columns(head, sample)
    data = (k for k, line in enumerate(head) if columns.are_data(line))
    counts = list[int]()
    while (first := next(data, None)) is not None and _counts(head, first, columns):
        counts.append(first)
    if first is None:
        raise RecordError(f"{len(head)} lines of header, and no row of numbers below them")
    columns = replace(columns, row=head[first])
    while first and columns.are_missing(head[first - 1]):
        first -= 1
    above, beside, start = stated_beside(head[:first], columns)
    above = ["" if k in counts else line for k, line in enumerate(above)]
    above, of_labels = without_labels(above, columns)
    names_at, units_at = _header(above, columns)
    others = {k + 1 + before: head[k] for k in range(first) if k not in (names_at, units_at) and head[k].strip()}
    names, renamed = _names(columns, "" if names_at is None else above[names_at])
    units = {name: bracketed_unit(name) for name in names if bracketed_unit(name)}
    if units_at is not None:
        stated = zip(names, columns.units(above[units_at]), strict=False)
        units |= {name: unit for name, unit in stated if unit and unit.lower() not in UNIT_LABELS}
    for cells in map(columns.dialect.cells, others.values()):
        # The label stands above the time.
        if cells[0].lower() == "y_unit_label" and len(cells) >= len(names):
            units |= dict(zip(names[1:], cells[1:], strict=False))
            break
    if units_at is None and names_at and (time := named_above(above[:names_at], names, columns)):
        at, name = time
        units |= {name: names[at]}
        names[at] = name
    rates = beside | of_labels | _rates(others.values(), columns.dialect)
    # Oscilloscopes write the time first.
    axis = columns.kinds.index("number") if columns.kinds.count("number") > 1 else None
    if axis is not None and names[axis] not in units and (unit := axis_unit(head, columns, axis, rates.values())):
        units[names[axis]] = unit
    return Layout(
        dialect=columns.dialect,
        names=tuple(names),
        units=units,
        kinds=dict(zip(names, columns.kinds, strict=True)),
        first=first,
        rates=rates,
        start=start,
        left_out={**_listed(others), **renamed},
    )


def _counts(head: Sequence[str], at: int, columns: Columns) -> bool:
    """Return whether a line above the rows numbers the columns from 1, or has the same number of each behind a word.

    Behind numbers of columns a blank line follows. Of each is said how many samples it has, or their step.
    """
    cells = columns.dialect.cells(head[at])
    numbered = cells == [str(k + 1) for k in range(len(cells))] and len(cells) > 1
    word = kind_of(cells[0], comma=columns.dialect.comma) == "text"
    alike = word and len({*cells[1:]}) == 1 < len(cells[1:])
    return alike or (numbered and len(head) > at + 2 and not head[at + 1].strip())


def _columns(head: Sequence[str], sample: Sequence[str]) -> Columns:
    """Return the columns of a sample of lines; refuse one whose cells look like numbers and are not."""
    counted = shapes(sample)
    dialect, width = find_dialect(head, sample, counted)
    # The cells of different shapes are mostly alike.
    kind = cache(partial(kind_of, comma=dialect.comma))
    every = {shape: [kind(cell) for cell in dialect.cells(shape)] for shape in counted}
    rows = {shape: kinds for shape, kinds in every.items() if len(kinds) == width and "number" in kinds}
    often = [counted[shape] for shape in rows]
    every_column = list(zip(*rows.values(), strict=True))
    commonest = _less_settings([_commonest(column, often) for column in every_column], every_column, often)
    lines = [cells for line in sample if len(cells := dialect.cells(line)) == width] if "text" in commonest else []
    lines = [cells for cells in lines if any(kind_of(cell, comma=dialect.comma) == "number" for cell in cells)]
    for column in (k for k, kind in enumerate(commonest) if kind == "text"):
        filled = [cells[column] for cells in lines if cells[column]]
        digits = [cell for cell in filled if NUMERIC.fullmatch(cell)]
        odd = next((cell for cell in digits if kind_of(cell, comma=dialect.comma) != "number"), None)
        if odd is not None and 2 * len(digits) > len(filled):
            raise RecordError(f"cells such as {shortened(odd)} {why_no_number(odd, dialect)}")
    return Columns(dialect, commonest)


def _less_settings(
    commonest: Sequence[Kind], columns: Sequence[Sequence[Kind]], often: Sequence[int]
) -> tuple[Kind, ...]:
    """Return what columns hold, text where they hold settings: words and numbers beside words, in few rows.

    Oscilloscopes write a name and its value beside each of the first rows.
    """
    out = list(commonest)
    blank = [
        sum(itertools.compress(often, (kind == "missing" for kind in column))) > MOSTLY * sum(often)
        for column in columns
    ]
    for k in range(1, len(out)):
        if blank[k - 1] and blank[k] and out[k - 1] == "text" and "text" in columns[k]:
            out[k] = "text"
    return tuple(out)


def _commonest(kinds: Sequence[Kind], often: Sequence[int]) -> Kind:
    """Return what most cells of a column hold, given how often each occurs."""
    counts = Counter[Kind]()
    for kind, times in zip(kinds, often, strict=True):
        counts[kind] += times
    del counts["missing"]
    # One odd cell beside one number is an error to report, not a column of text.
    return max(counts, key=lambda kind: (counts[kind], kind in ("number", "stamp")), default="missing")


def _header(above: Sequence[str], columns: Columns) -> tuple[int | None, int | None]:
    """Return the indices of the lines of names and of units above the data."""
    filled = [k for k, line in enumerate(above) if line.strip(" \t\"'") and not RULE.fullmatch(plain(line))]
    # A comment may hold the names, or stand between them and the data.
    comments = [k for k in filled if columns.dialect.is_comment(above[k])]
    plain_names = any(columns.may_be_named_by(above[k]) for k in filled if k not in comments)
    filled = [k for k in filled if k not in comments or _may_name(above[k], columns, as_wide=plain_names)]
    rows = _naming(above, filled, columns)
    if not rows:
        # A message of the logger may stand between the names and the data.
        wide = [k for k in filled if len(columns.dialect.cells(above[k])) == len(columns.kinds)]
        between = [above[k] for k in filled if wide and k > wide[-1]]
        if between and all(len(columns.dialect.cells(line)) == 1 for line in between):
            rows = _naming(above, wide[-1:], columns)
    if not rows:
        if filled:
            _refuse_misfit(above[filled[-1]], filled[-1] + 1, columns)
        return None, None
    units = [at for at, k in enumerate(rows) if columns.are_units(above[k])]
    units = units or [at for at, k in enumerate(rows) if at and columns.are_units_mostly(above[k])]
    # A single row holds names, whatever it looks like; of comments, one that names steps of time before a later one.
    if not units or len(rows) == 1:
        timed = [k for k in comments if columns.may_be_named_by(above[k]) and _names_steps(above[k], columns)]
        says_none = rows[-1] in comments and not _names_steps(above[rows[-1]], columns)
        return timed[-1] if timed and says_none else rows[-1], None
    return rows[units[-1] - 1] if units[-1] else rows[1], rows[units[-1]]


def _names_steps(line: str, columns: Columns) -> bool:
    """Whether a line has a name for the time since the sample before: no sentence and no list of settings does."""
    return any(map(is_since_last, columns.titles(line)))


def _naming(above: Sequence[str], filled: Sequence[int], columns: Columns) -> list[int]:
    """Return the last of some lines that may name columns, without one between that may not."""
    return list(itertools.takewhile(lambda k: columns.may_be_named_by(above[k]), reversed(filled)))[::-1]


def _may_name(comment: str, columns: Columns, *, as_wide: bool) -> bool:
    """Whether a comment may hold the names of columns; beside other names it has as many cells as a row."""
    wide = len(columns.dialect.cells(comment)) == len(columns.kinds)
    return columns.may_be_named_by(comment) and (wide or not as_wide)


def _refuse_misfit(line: str, number: int, columns: Columns) -> None:
    """Refuse a line above the data that seems to be a header or a row, but does not fit the columns."""
    dialect, width = columns.dialect, len(columns.kinds)
    if dialect.is_comment(line) or dialect.delimiter == " ":
        return
    cells, kinds = dialect.cells(line), dialect.kinds(line)
    if len(cells) == width and "number" in kinds:
        odd = next((k for k, kind in enumerate(kinds) if kind == "text"), 0)
        hint = f"; {hint}" if (hint := marks_between(cells[odd])) else ""
        raise RecordError(
            f"line {number} is neither a header nor data: cell {odd + 1} is {shortened(cells[odd])}, but "
            f"cell {kinds.index('number') + 1} is a number{hint}"
        )
    if 1 < len(cells) != width and set(kinds) <= {"text"} and not re.match(r"[^:=]*[:=]", cells[0]):
        hint = "; if decimals have a comma, separate cells by semicolons or tabs" if dialect.delimiter == "," else ""
        hint += f"; if names are missing, add them to line {number}" if len(cells) < width else ""
        raise RecordError(
            f"line {number} names {len(cells)} columns, but the rows have {width} cells ({dialect}){hint}"
        )


def _names(columns: Columns, line: str) -> tuple[list[str], dict[str, Remark]]:
    """Return a name for each column that no other has, and which were changed."""
    cells = columns.titles(line) if line else [""] * len(columns.kinds)
    names = [name or f"column {k + 1}" for k, name in enumerate(cells)]
    if columns.trailing and not cells[-1]:
        names[-1] = ""
    apart = told_apart(names)
    return apart, {
        f"name of column {k + 1}": Remark(LeftOut.NAME_TWICE, {"name": name, "new": new})
        for k, (name, new) in enumerate(zip(names, apart, strict=True))
        if new != name
    }


def _listed(others: Mapping[int, str]) -> dict[str, Remark]:
    """Return the lines above the data that are neither names nor units, by their numbers."""
    # A few lines above the data are listed one by one.
    if len(others) <= 8:
        return {f"line {n}": Remark(LeftOut.HEADING, {"line": shortened(line)}) for n, line in others.items()}
    numbers = list(others)
    remark = Remark(LeftOut.HEADINGS, {"lines": len(others), "line": shortened(others[numbers[0]])})
    return {f"lines {numbers[0]} to {numbers[-1]}": remark}


def _rates(lines: Iterable[str], dialect: Dialect) -> dict[str, Hertz]:
    """Return the sampling rates that lines such as ``Sample rate: 500 Hz`` state, once or for each channel."""
    found = [match for line in lines if (match := KEY_VALUE.fullmatch(plain(_said_once(line, dialect))))]
    rates = {match[1].strip(): stated_rate(match[1], float(match[2]), match[3]) for match in found}
    return {name: rate for name, rate in rates.items() if rate is not None}


def _said_once(line: str, dialect: Dialect) -> str:
    """Return a line of a name and the same number for each channel, as LabVIEW writes it, with the number once."""
    if dialect.delimiter in (" ", ","):
        return line
    cells = [cell for cell in dialect.cells(line) if cell]
    if len(cells) < 2 or len(set(cells[1:])) > 1:
        return line
    return f"{cells[0]}={cells[1].replace(',', '.') if dialect.comma else cells[1]}"
