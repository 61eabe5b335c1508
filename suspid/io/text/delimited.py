"""Delimited text, as loggers, spreadsheets and telephones write it, as a table.

The lines are looked at once to find those that are no rows, and read in pieces when columns are asked for: fast
where a piece holds plain numbers, cell by cell where it does not.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from suspid.errors import RecordError
from suspid.files import read_bytes
from suspid.io.tables import Table, TimeBase, is_time
from suspid.io.text.cells import COMMA_NUMBER, kind_of, number, seconds
from suspid.io.text.dialects import Dialect, parted_by, shortened
from suspid.io.text.encodings import decoded
from suspid.io.text.layouts import Layout, find_layout
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

PIECE = 1 << 22
HEAD_LINES, HEAD_BYTES = 1000, 1 << 18
LONGEST_LINE = 1 << 20
MOST_FOOTER = 20
# A piece with more rows that are not of plain numbers is read cell by cell.
MOST_PARTS = 2000
# What numbers are written with.
NUMERALS = b"0123456789+-.eE "
# What a row of numbers may begin with; lines that begin with anything else are looked at one by one.
PLAIN = np.isin(np.arange(256), np.frombuffer(b"0123456789+-.", np.uint8))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Rows:
    """The rows of a text file below its header.

    Parameters
    ----------
    body : bytes
        The lines from the first row on, as UTF-8, each ended by a newline.
    first : int
        Number of the first line of the body in the file.
    layout : Layout
        What the header says of them.
    skipped : frozenset of int
        Numbers of the lines that are no rows.
    size : int
        Number of rows.
    """

    body: bytes
    first: int
    layout: Layout
    skipped: frozenset[int]
    size: int

    def pieces(self) -> Iterator[tuple[list[int], list[str]]]:
        """Yield the rows piece by piece, with the numbers of their lines."""
        line = self.first
        for piece in _pieces(self.body):
            rows = piece.decode().split("\n")[:-1]
            numbers = list(range(line, line + len(rows)))
            line += len(rows)
            if not self.skipped.isdisjoint(numbers):
                kept = [k for k, n in enumerate(numbers) if n not in self.skipped]
                numbers, rows = [numbers[k] for k in kept], [rows[k] for k in kept]
            if rows:
                yield numbers, rows

    def columns(self, wanted: Sequence[str]) -> list[RealArray]:
        """Return the numbers of the named columns, NaN where there is none."""
        use = [self.layout.names.index(name) for name in wanted]
        values = np.empty((len(use), self.size))
        done = 0
        for lines, rows in self.pieces() if use else ():
            values[:, done : done + len(rows)] = _numbers(lines, rows, use, self.layout)
            done += len(rows)
        values.flags.writeable = False
        return list(values)

    def cells(self, name: str) -> Iterator[str]:
        """Yield the cells of a column."""
        k, dialect = self.layout.names.index(name), self.layout.dialect
        for _, rows in self.pieces():
            for row in rows:
                yield dialect.cells(row)[k]


def read_delimited(path: Path) -> Table:
    """Return the table of a text file: what parts its cells and what stands above its rows is found out.

    Raises
    ------
    RecordError
        If the file is not text, holds no rows of numbers, or a line in their midst is no row.
    """
    text, left_out = decoded(read_bytes(path, error=RecordError))
    head = text[:HEAD_BYTES].split(b"\n", HEAD_LINES)
    if len(text) > HEAD_BYTES or len(head) > HEAD_LINES:
        head.pop()
        middle = text[len(text) // 2 : len(text) // 2 + HEAD_BYTES // 4].split(b"\n", 300)[1:-1]
    else:
        middle = []
    if not head or max(map(len, head)) > LONGEST_LINE:
        raise RecordError(f"line 1 is longer than {HEAD_BYTES} bytes; a record has one sample a line")
    top = [line.decode() for line in head]
    layout = find_layout(top, [line for line in (*top, *(row.decode() for row in middle)) if line.strip()])
    offset = sum(len(line) + 1 for line in head[: layout.first])
    body = text[offset:]
    del text
    rows, odd = _rows(body, layout)
    left_out |= {**layout.left_out, **odd}
    names = [name for name in layout.names if name]
    counter = _counter(layout, top)
    left_out |= dict.fromkeys(counter, Remark(LeftOut.ROW_COUNTER))
    numeric = [name for name in names if layout.kinds[name] in ("number", "missing") and name not in counter]
    clocks, others = _clocks(rows, numeric)
    left_out |= {name: reason for name, reason in others.items() if name in names}
    return Table(
        sizes=dict.fromkeys(numeric, rows.size),
        columns=rows.columns,
        unusable=left_out,
        rates=layout.rates,
        units=layout.units,
        clocks=clocks,
    )


def _counter(layout: Layout, top: Sequence[str]) -> list[str]:
    """Return the first column where only the others have a name and it counts from 0 or 1, as pandas writes it."""
    names = layout.names
    if names[0] != "column 1" or len(names) < 2 or names[1] == "column 2":
        return []
    rows = [layout.dialect.cells(line)[0] for line in top[layout.first :] if line.strip()]
    return ["column 1"] if any(rows == [str(k + start) for k in range(len(rows))] for start in (0, 1)) else []


def _pieces(body: bytes) -> Iterator[bytes]:
    """Yield a text in pieces of whole lines."""
    start = 0
    while start < len(body):
        stop = body.find(b"\n", start + PIECE) + 1 or len(body)
        yield body[start:stop]
        start = stop


def _rows(body: bytes, layout: Layout) -> tuple[Rows, dict[str, Remark]]:
    """Return the rows, and which lines among and below them are none."""
    first = layout.first + 1
    blank: list[int] = []
    odd: dict[int, str] = {}
    line = first
    for piece in _pieces(body):
        count = piece.count(b"\n")
        suspects = [] if _is_plain(piece, count, layout) else _suspects(piece, layout).tolist()
        rows = piece.split(b"\n") if suspects else []
        for k in suspects:
            text = rows[k].decode()
            if not text.strip():
                blank.append(line + k)
            elif not _is_row(text, layout):
                odd[line + k] = text
        line += count
    last = line - 1
    skipped = {*blank, *odd}
    while last in skipped:
        last -= 1
    told = {f"line {n}": _why(text, layout, n, last) for n, text in odd.items()}
    if sum(n > last for n in odd) > MOST_FOOTER:
        n = next(n for n in odd if n > last)
        raise RecordError(f"the rows end at line {last}, but {line - n} lines follow: {shortened(odd[n])}")
    inner = [n for n in blank if n < last]
    if inner:
        told[f"line {inner[0]}"] = Remark(LeftOut.BLANK, {"more": len(inner) - 1})
    return Rows(
        body=body, first=first, layout=layout, skipped=frozenset(skipped), size=line - first - len(skipped)
    ), told


def _is_plain(piece: bytes, count: int, layout: Layout) -> bool:
    """Whether all lines are surely rows: without the characters of numbers, only the delimiters of each are left."""
    delimiter, width = layout.dialect.delimiter, len(layout.names)
    if delimiter == " " or width == 1:
        return False
    mark = delimiter.encode()
    for letter in (b"e", b"E"):
        # An exponent has digits behind it; letters alone are words.
        if letter in piece and (letter + mark in piece or letter + b"\n" in piece):
            return False
    if not layout.names[-1] and piece.count(mark + b"\n") < count:
        return False
    left = piece.translate(None, NUMERALS + b"," if layout.dialect.comma and mark != b"," else NUMERALS)
    return left == (mark * (width - 1) + b"\n") * count


def _suspects(piece: bytes, layout: Layout) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the indices of the lines that are perhaps no rows: in doubt, too many."""
    width, delimiter = len(layout.names), layout.dialect.delimiter
    if delimiter == " ":
        return np.array([k for k, row in enumerate(piece.split(b"\n")[:-1]) if len(row.split()) != width], np.intp)
    codes = np.frombuffer(piece, np.uint8)
    ends = np.flatnonzero(codes == ord("\n"))
    starts = np.concatenate([[0], ends[:-1] + 1])
    before = np.concatenate([[0], np.cumsum(codes == ord(delimiter), dtype=np.int32)])
    suspect = before[ends] - before[starts] != width - 1
    if width == 1:
        suspect |= ~PLAIN[codes[starts]]
    suspect |= np.isin(codes[starts], np.frombuffer(b"#%/", np.uint8))
    if b'"' in piece:
        quotes = np.concatenate([[0], np.cumsum(codes == ord('"'), dtype=np.int32)])
        suspect |= quotes[ends] > quotes[starts]
    letters = np.concatenate([[0], np.cumsum(codes >= ord("A"), dtype=np.int32)])
    digits = np.concatenate([[0], np.cumsum((codes >= ord("0")) & (codes <= ord("9")), dtype=np.int32)])
    # Words alone: perhaps a header once more.
    suspect |= (letters[ends] > letters[starts]) & (digits[ends] == digits[starts])
    if not layout.names[-1]:
        suspect |= codes[ends - 1] != ord(delimiter)
    return np.flatnonzero(suspect)


def _is_row(text: str, layout: Layout) -> bool:
    if layout.dialect.is_comment(text):
        return False
    cells = layout.dialect.cells(text)
    kinds = [kind_of(cell, comma=layout.dialect.comma) for cell in cells]
    if not layout.names[-1]:
        # The rows end with a delimiter; one may lack it, but nothing may stand behind it.
        return len(cells) == len(layout.names) - 1 or (len(cells) == len(layout.names) and not cells[-1])
    return len(cells) == len(layout.names) and not set(kinds) <= {"text", "date"}


def _why(text: str, layout: Layout, line: int, last: int) -> Remark:
    """Return why a line is left out; refuse one that cannot be."""
    if layout.dialect.is_comment(text):
        return Remark(LeftOut.COMMENT, {"line": shortened(text)})
    cells = layout.dialect.cells(text)
    width = len(layout.names)
    samples = kind_of(cells[0], comma=layout.dialect.comma) in ("number", "stamp")
    if line < last or (samples and len(cells) > width):
        found = f"has {len(cells)} cells, the rows above have {width}{parted_by(layout.dialect)}"
        found = found if len(cells) != width else "holds no number"
        raise RecordError(f"line {line} {found}: {shortened(text)}; correct it, or take it out if it is no sample")
    if samples and len(cells) < width:
        return Remark(LeftOut.CUT_SHORT, {"cells": len(cells), "width": width})
    return Remark(LeftOut.FOOTER, {"line": shortened(text)})


def _clocks(rows: Rows, numeric: Sequence[str]) -> tuple[dict[str, TimeBase], dict[str, Remark]]:
    """Return the clock that a column of dates or times of day gives, and why other columns are no channels."""
    kinds = rows.layout.kinds
    reasons = {name: Remark(LeftOut.TEXT) for name, kind in kinds.items() if kind == "text"}
    reasons |= {name: Remark(LeftOut.DATES) for name, kind in kinds.items() if kind == "date"}
    stamps = [name for name, kind in kinds.items() if kind == "stamp"]
    named = [name for name in stamps if is_time(name)]
    chosen = named[:1] if len(named) == 1 else stamps[:1] if len(stamps) == 1 else []
    reasons |= dict.fromkeys(stamps, Remark(LeftOut.SEVERAL_TIMES))
    clocks: dict[str, TimeBase] = {}
    for name in chosen:
        if any(is_time(other) for other in numeric):
            reasons[name] = Remark(LeftOut.SPARE_TIMES)
            continue
        start = next(rows.cells(name), "")
        reasons[name] = Remark(LeftOut.TIME, {"start": start})
        clock = TimeBase(name=name, stamps=lambda name=name: seconds(lambda: rows.cells(name)))  # type: ignore[misc]
        clocks = dict.fromkeys(numeric, clock)
    return clocks, reasons


def _numbers(lines: Sequence[int], rows: Sequence[str], use: Sequence[int], layout: Layout) -> RealArray:
    """Return the numbers of some columns (column, row)."""
    dialect = layout.dialect
    delimiter = None if dialect.delimiter == " " else dialect.delimiter
    whole = "\n".join(rows) if dialect.comma else ""
    # A point beside decimal commas is a thousand, and is refused below.
    if not dialect.comma or ("." not in whole and delimiter != ","):
        plain = whole.replace(",", ".").split("\n") if dialect.comma else rows
        parts: list[RealArray] = []
        start = 0
        while start < len(rows) and len(parts) < MOST_PARTS:
            stop = _first_odd(plain[start:], delimiter, use, parts)
            if stop is None:
                return np.concatenate(parts, axis=1)
            odd = slice(start + stop, start + stop + 1)
            parts.append(_cell_by_cell(lines[odd], rows[odd], use, layout))
            start = odd.stop
        if start == len(rows):
            return np.concatenate(parts, axis=1)
        lines, rows = lines[start:], rows[start:]
        return np.concatenate([*parts, _cell_by_cell(lines, rows, use, layout)], axis=1)
    return _cell_by_cell(lines, rows, use, layout)


def _first_odd(rows: Sequence[str], delimiter: str | None, use: Sequence[int], parts: list[RealArray]) -> int | None:
    """Add the numbers of the rows up to the first that is not of plain numbers, and return its index, if any."""
    odd: int | None = None
    stop = len(rows)
    for _ in range(2):
        try:
            values = np.loadtxt(rows[:stop], delimiter=delimiter, comments=None, quotechar='"', usecols=use, ndmin=2)
        except ValueError as refusal:
            found = re.search(r"at row (\d+)", str(refusal))
            # Where it stands is told by the parser, by some releases counted from one.
            odd = stop = max(int(found[1]) - 1, 0) if found else 0
        else:
            if len(values) == stop:
                parts.append(values.T)
                return odd
            odd = stop = 0
        if not stop:
            break
    return 0


def _cell_by_cell(lines: Sequence[int], rows: Sequence[str], use: Sequence[int], layout: Layout) -> RealArray:
    names = {layout.names[k]: k for k in use}
    return np.array([_row(line, row, names, layout.dialect) for line, row in zip(lines, rows, strict=True)]).T


def _row(line: int, row: str, names: Mapping[str, int], dialect: Dialect) -> list[float]:
    """Return the numbers of a row, or refuse the first cell that is neither number nor missing."""
    cells = dialect.cells(row)
    values = []
    for name, k in names.items():
        try:
            values.append(number(cells[k], comma=dialect.comma))
        except ValueError:
            hint = "; write decimals with a point" if COMMA_NUMBER.fullmatch(cells[k]) else ""
            hint = "; decimals have a comma here, and thousands are not parted" if dialect.comma else hint
            raise RecordError(f"line {line}, column {name!r}: {cells[k]!r} is not a number{hint}") from None
    return values
