"""Layouts of text files: where the header ends, and what it says of the rows below it."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from suspid.errors import RecordError
from suspid.io.tables import bracketed_unit, is_time, stated_rate
from suspid.io.text.cells import Kind, kind_of
from suspid.io.text.dialects import COMMENTS, DELIMITERS, NUMERIC, Dialect, find_dialect, parted_by, shapes, shortened
from suspid.units import Hertz
from suspid.words import LeftOut, Remark

# Lines above the data that are told one by one.
MOST_TOLD = 8
REMARKS = {"comment", "comments", "remark", "remarks", "note", "notes", "kommentar"}
# One unit or several joined, such as mm, m/s^2, (kN), µm/m or °/s.
ATOM = (
    r"(?:[kKMGmµμunp]?(?:m|s|g|gn|V|A|Hz|Pa|J|W|N|Nm|rad|bar|Ohm|Ω|strain|eps|ε)"
    r"|min|h|hr|sec|deg|°C?|C|%|1|-|rpm|in|ft|lbf)"
)
UNIT = re.compile(
    rf"{ATOM}(?:\^?-?[0-9²³]|\*\*-?\d|⁻[¹²])?(?:[/*·. ]{ATOM}(?:\^?-?[0-9²³]|\*\*-?\d|⁻[¹²])?)*|hh:mm:ss\S*|[Uu]nits?"
)
KEY_VALUE = re.compile(
    r"\W*([^\W\d][^:=;,\t]*?)\s*[:=;,\t]\s*[\"']?([+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*[;,\t]?\s*(\w*)\W*"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """What the top of a text file says of the rows below it.

    Parameters
    ----------
    dialect : Dialect
        How a row is parted.
    names : tuple of str
        Names of the columns in their order; an empty last one stands for a delimiter that ends each row.
    units : mapping of str to str
        Units by column.
    kinds : mapping of str to str
        What each column holds.
    first : int
        Index of the first line of data.
    rates : mapping of str to float
        Sampling rates that lines above the data state [Hz].
    left_out : mapping of str to Remark
        Lines above the data that are neither names nor units.
    """

    dialect: Dialect
    names: tuple[str, ...]
    units: Mapping[str, str]
    kinds: Mapping[str, Kind]
    first: int
    rates: Mapping[str, Hertz]
    left_out: Mapping[str, Remark]


def find_layout(head: Sequence[str], sample: Sequence[str]) -> Layout:
    """Return the layout of a file from its first lines and a sample of lines from all over it.

    Raises
    ------
    RecordError
        If no line holds numbers, the header does not fit the rows, or two dialects fit.
    """
    counted = shapes(sample)
    dialect, width = find_dialect(head, sample, counted)
    found = {shape: dialect.kinds(shape) for shape in counted}
    rows = {shape: kinds for shape, kinds in found.items() if len(kinds) == width and "number" in kinds}
    columns = [_column_kind(column, [counted[s] for s in rows]) for column in zip(*rows.values(), strict=True)]
    if "text" in columns:
        _refuse_parted_thousands(dialect, [line for line in sample if len(dialect.cells(line)) == width], columns)
    first = next((k for k, line in enumerate(head) if _is_data(dialect.kinds(line), columns)), None)
    if first is None:
        raise RecordError(f"{len(head)} lines of header, and no row of numbers below them")
    names_at, units_at = _header(head[:first], dialect, columns)
    trailing = width > 1 and columns[-1] == "missing"
    cells = [""] * width if names_at is None else _name_cells(head[names_at], dialect, width, trailing=trailing)
    names = [name or f"column {k + 1}" for k, name in enumerate(cells)]
    if trailing and not cells[-1]:
        names[-1] = ""
    left_out = _above(head, [k for k in range(first) if k not in (names_at, units_at) and head[k].strip()])
    for k, name in enumerate(names):
        if name in names[:k]:
            names[k] = next(new for n in itertools.count(2) if (new := f"{name} ({n})") not in names)
            left_out[f"name of column {k + 1}"] = Remark(LeftOut.NAME_TWICE, {"name": name, "new": names[k]})
    stated = (
        []
        if units_at is None
        else [cell.strip("[]() ") for cell in _name_cells(head[units_at], dialect, width, trailing=trailing)]
    )
    units = {name: bracketed_unit(name) for name in names if bracketed_unit(name)}
    units |= {name: unit for name, unit in zip(names, stated, strict=False) if unit}
    others = [k for k in range(first) if k not in (names_at, units_at) and head[k].strip()]
    return Layout(
        dialect=dialect,
        names=tuple(names),
        units=units,
        kinds=dict(zip(names, columns, strict=True)),
        first=first,
        rates=_rates([head[k] for k in others]),
        left_out=left_out,
    )


def _above(head: Sequence[str], others: Sequence[int]) -> dict[str, Remark]:
    """Return which lines above the data are neither names nor units."""
    if len(others) <= MOST_TOLD:
        return {f"line {k + 1}": Remark(LeftOut.HEADING, {"line": shortened(head[k])}) for k in others}
    where = f"lines {others[0] + 1} to {others[-1] + 1}"
    return {where: Remark(LeftOut.HEADINGS, {"lines": len(others), "line": shortened(head[others[0]])})}


def _column_kind(kinds: Sequence[Kind], often: Sequence[int]) -> Kind:
    """Return what most cells of a column hold, each of which stands so often."""
    counts = Counter[Kind]()
    for kind, number in zip(kinds, often, strict=True):
        if kind != "missing":
            counts[kind] += number
    if not counts:
        return "missing"
    # One odd cell among as many numbers is a fault to be named, not a column of text.
    return max(counts, key=lambda kind: (counts[kind], kind in ("number", "stamp")))


def _refuse_parted_thousands(dialect: Dialect, rows: Sequence[str], columns: Sequence[Kind]) -> None:
    """Refuse a column whose cells are made of digits and are still no numbers."""
    samples = [cells for row in rows if "number" in dialect.kinds(row) for cells in [dialect.cells(row)]]
    for k in [k for k, kind in enumerate(columns) if kind == "text"]:
        cells = [row[k] for row in samples if row[k]]
        odd = [cell for cell in cells if NUMERIC.fullmatch(cell)]
        if 2 * len(odd) > len(cells):
            raise RecordError(
                f"cells such as {shortened(odd[0])} are not numbers, where decimals stand behind a "
                f"{'comma' if dialect.comma else 'point'} and cells are parted by {DELIMITERS[dialect.delimiter]}; "
                f"write numbers without a mark between the thousands"
            )


def _is_data(kinds: Sequence[Kind], columns: Sequence[Kind]) -> bool:
    """Whether a line is a row of such columns."""
    if len(kinds) != len(columns) or not ({"number", "stamp"} & set(kinds)):
        return False
    return all(
        kind in (column, "missing") or column in ("text", "missing")
        for kind, column in zip(kinds, columns, strict=True)
    )


def _header(above: Sequence[str], dialect: Dialect, columns: Sequence[Kind]) -> tuple[int | None, int | None]:
    """Return the indices of the lines of names and of units above the data."""
    filled = [k for k, line in enumerate(above) if line.strip()]
    rows: list[int] = []
    for k in reversed(filled):
        if not _may_name(above[k], dialect, len(columns), trailing=columns[-1] == "missing"):
            break
        rows.insert(0, k)
    if rows:
        units = [k for k in rows if _are_units(above[k], dialect)]
        # A single row names, whatever it looks like.
        if units and len(rows) > 1:
            at = rows.index(units[-1])
            return rows[at - 1] if at else rows[1], units[-1]
        return rows[-1], None
    if filled:
        _refuse_misfit(above[filled[-1]], filled[-1] + 1, dialect, columns)
    return None, None


def _name_cells(line: str, dialect: Dialect, width: int, *, trailing: bool) -> list[str]:
    """Return the cells of a header, as many as the rows have where it can be."""
    text = line.strip() if dialect.delimiter == " " else line
    for mark in COMMENTS:
        if text.startswith(mark):
            text = text.removeprefix(mark)
            break
    cells = dialect.cells(text)
    if len(cells) != width and dialect.delimiter == " ":
        wide = [cell.strip().strip('"') for cell in re.split(r"\t|\s{2,}", text.strip())]
        cells = wide if len(wide) == width else cells
    # LabVIEW names a column of comments that its rows leave away.
    if len(cells) == width + 1 and (not cells[-1] or cells[-1].lower() in REMARKS):
        cells = cells[:-1]
    if len(cells) == width - 1 and trailing:
        cells = [*cells, ""]
    return cells


def _may_name(line: str, dialect: Dialect, width: int, *, trailing: bool) -> bool:
    cells = _name_cells(line, dialect, width, trailing=trailing)
    numbers = [kind_of(cell, comma=dialect.comma) in ("number", "stamp") for cell in cells]
    if len(cells) != width or not any(cells) or all(numbers):
        return False
    return not any(numbers) or any(is_time(cell) for cell in cells)


def _are_units(line: str, dialect: Dialect) -> bool:
    cells = [cell.strip("[]() ") for cell in _name_cells(line, dialect, 0, trailing=False)]
    return any(cells) and all(not cell or UNIT.fullmatch(cell) for cell in cells)


def _refuse_misfit(line: str, number: int, dialect: Dialect, columns: Sequence[Kind]) -> None:
    """Refuse a line above the data that is meant to name them, or to be one of them, but does not fit."""
    if dialect.is_comment(line) or dialect.delimiter == " ":
        return
    cells, kinds = dialect.cells(line), dialect.kinds(line)
    if len(cells) == len(columns) and "number" in kinds:
        odd = next((k for k, kind in enumerate(kinds) if kind == "text"), 0)
        hint = "; write numbers without a mark between the thousands" if NUMERIC.fullmatch(cells[odd]) else ""
        raise RecordError(
            f"line {number} is neither a header nor data: cell {odd + 1} is {cells[odd]!r}, but "
            f"cell {kinds.index('number') + 1} is a number{hint}"
        )
    if 1 < len(cells) != len(columns) and set(kinds) <= {"text"} and not re.match(r"[^:=]*[:=]", cells[0]):
        hint = "; if decimals have a comma, let semicolons or tabs part the cells" if dialect.delimiter == "," else ""
        raise RecordError(
            f"line {number} names {len(cells)} columns, but the rows hold {len(columns)} "
            f"cells{parted_by(dialect)}{hint}"
        )


def _rates(lines: Sequence[str]) -> dict[str, Hertz]:
    """Return the sampling rates that lines such as ``Sample rate: 500 Hz`` state."""
    rates = {}
    for line in lines:
        found = KEY_VALUE.fullmatch(line)
        rate = stated_rate(found[1], float(found[2]), found[3]) if found else None
        if found and rate is not None:
            rates[found[1].strip()] = rate
    return rates
