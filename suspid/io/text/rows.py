"""Rows of text files: found by one scan of the lines, and read when their numbers are asked for.

Numbers are read in pieces (`numbers`); rows of pieces that are refused are read cell by cell. (`pandas.read_csv` fills
rows that are too short with NaN, so that it needs the same scan, and its import takes as long as reading 500 000 rows
here.)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import RecordError
from suspid.io.text.cells import COMMA_NUMBER, kind_of, number
from suspid.io.text.dialects import shortened
from suspid.io.text.encodings import PIECE
from suspid.io.text.endings import cut_number
from suspid.io.text.layouts import Layout
from suspid.io.text.numbers import every_number, loaded, loaded_piece
from suspid.units import RealArray
from suspid.words import LeftOut, Number, Remark

# Lines below the rows up to which they are listed one by one; more are another table if this share of them is alike.
FEW_BELOW, AS_WIDE = 20, 0.9
NUMERALS = b"0123456789+-.eE "
DIGITS = np.isin(np.arange(256), np.frombuffer(b"0123456789", np.uint8))
NUMBER_STARTS = np.isin(np.arange(256), np.frombuffer(b"0123456789+-.", np.uint8))
COMMENT_MARKS = np.isin(np.arange(256), np.frombuffer(b"#%/", np.uint8))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Rows:
    """The rows of a text file below its header."""

    # The text as UTF-8, each line ended by a newline, and where its first row begins; a copy would cost memory.
    text: bytes
    start: int
    # Number of the line of the first row in the file.
    first: int
    layout: Layout
    # Numbers of the lines that are not rows.
    skipped: frozenset[int]
    size: int
    # Numbers of all columns (column, row) of pieces that were read to find their rows, by the number of the first line.
    read: Mapping[int, RealArray]

    def pieces(self) -> Iterator[tuple[list[int], list[str]]]:
        """Yield the rows piece by piece, with the numbers of their lines."""
        line = self.first
        for piece in _pieces(self.text, self.start):
            numbers, rows = self._of(piece, line)
            line += _lines(piece)
            if rows:
                yield numbers, rows

    def _of(self, piece: bytes, line: int) -> tuple[list[int], list[str]]:
        """Return the rows of a piece whose first line has this number, with the numbers of their lines."""
        rows = piece.decode().split("\n")[:-1]
        numbers = list(range(line, line + len(rows)))
        if self.skipped.isdisjoint(numbers):
            return numbers, rows
        kept = [k for k, n in enumerate(numbers) if n not in self.skipped]
        return [numbers[k] for k in kept], [rows[k] for k in kept]

    def columns(self, wanted: Sequence[str]) -> list[RealArray]:
        """Return the numbers of the named columns, NaN where one is missing."""
        place = {name: k for k, name in enumerate(self.layout.names)}
        use = [place[name] for name in wanted]
        values = np.empty((len(use), self.size))
        done, line = 0, self.first
        for piece in _pieces(self.text, self.start) if use else ():
            count = _lines(piece)
            whole = self._whole(piece, line, count, use)
            for part in _numbers(*self._of(piece, line), use, self.layout) if whole is None else (whole,):
                values[:, done : done + part.shape[1]] = part
                done += part.shape[1]
            line += count
        values.flags.writeable = False
        return list(values)

    def _whole(self, piece: bytes, line: int, count: int, use: Sequence[int]) -> RealArray | None:
        """Return the numbers of a piece all of whose lines are rows, (column, row); None if it has others."""
        if line in self.read:
            # The last row may be left out, because it is cut off.
            return self.read[line][use, : count - (line + count - 1 in self.skipped)]
        # A quote may hold the end of a line.
        if b'"' in piece or any(line <= n < line + count for n in self.skipped):
            return None
        return loaded_piece(piece, count, use, self.layout, size=len(self.text))

    def top(self) -> dict[str, str]:
        """Return the cells of the first line by the names of their columns."""
        line = self.text[self.start : self.text.find(b"\n", self.start)].decode()
        return dict(zip(self.layout.names, self.layout.dialect.cells(line), strict=False))

    def cells(self, name: str) -> Iterator[str]:
        """Yield the cells of a column."""
        k, dialect = self.layout.names.index(name), self.layout.dialect
        return (dialect.cells(row)[k] for _, rows in self.pieces() for row in rows)


def _pieces(text: bytes, start: int) -> Iterator[bytes]:
    """Yield a text from ``start`` on in pieces of whole lines."""
    while start < len(text):
        stop = text.find(b"\n", start + PIECE) + 1 or len(text)
        yield text[start:stop]
        start = stop


def _lines(piece: bytes) -> int:
    """Return the number of lines of a text; `bytes.count` takes three times as long."""
    return int(np.count_nonzero(np.frombuffer(piece, np.uint8) == ord("\n")))


def find_rows(
    text: bytes, start: int, layout: Layout, *, is_open: bool = False, inserted: int = 0
) -> tuple[Rows, dict[str, Remark]]:
    """Return the rows of a text from ``start`` on, and the lines between and below them that are not rows.

    ``is_open`` tells that the text ends within a line; a row there whose last number is cut short is left out.
    ``inserted`` is the number of lines above the rows that the file has not.
    """
    blank: list[int] = []
    odd: dict[int, str] = {}
    read: dict[int, RealArray] = {}
    first = layout.first + 1 - inserted
    line = first
    for piece in _pieces(text, start):
        count = _lines(piece)
        whole, known = every_number(piece, count, layout, size=len(text)), len(blank) + len(odd)
        # Lines with numbers are rows: a look for others takes a third of the time in which numbers are read. A line
        # without any may be blank.
        sure = whole is not None and not np.isnan(whole).all(axis=0).any()
        suspects = [] if sure else _suspects(piece, layout)
        lines = piece.decode().split("\n") if suspects else []
        for k in suspects:
            if not lines[k].strip():
                blank.append(line + k)
            elif not is_row(lines[k], layout):
                odd[line + k] = lines[k]
        if whole is not None and len(blank) + len(odd) == known:
            read[line] = whole
        line += count
    skipped = frozenset({*blank, *odd})
    last = next(n for n in range(line - 1, -1, -1) if n not in skipped)
    ending = (
        _ending(text[max(start, len(text) - PIECE // 4) :], line, layout, skipped)
        if is_open and last == line - 1 > first
        else None
    )
    if ending is not None and ending.code is not LeftOut.NO_END:
        skipped |= {last}
    below = [n for n in odd if n > last]
    other = len(below) > FEW_BELOW and _are_table([odd[n] for n in below], layout)
    if len(below) > FEW_BELOW and not other:
        raise RecordError(
            f"the rows end at line {last}, but {line - 1 - last} lines follow: {shortened(odd[below[0]])}"
        )
    again = next((n for n, row in odd.items() if n < last and names_again(row, layout)), None)
    if again is not None:
        raise RecordError(
            f"the names of the columns stand again on line {again}: the file holds several recordings, one below the "
            f"other; save each in a file of its own"
        )
    said = {f"line {n}": _why(row, layout, n, last) for n, row in odd.items() if n < last or not other}
    if other:
        numbers: dict[str, Number] = {"lines": len(below), "line": shortened(odd[below[0]])}
        said[f"lines {below[0]} to {below[-1]}"] = Remark(LeftOut.OTHER_TABLE, numbers)
    inner = [n for n in blank if n < last]
    if inner:
        said[f"line {inner[0]}"] = Remark(LeftOut.BLANK, {"more": len(inner) - 1})
    said |= {} if ending is None else {f"line {line - 1}": ending}
    size = line - first - len(skipped)
    return Rows(text=text, start=start, first=first, layout=layout, skipped=skipped, size=size, read=read), said


def names_again(text: str, layout: Layout) -> bool:
    """Return whether a line has the names of the columns, perhaps with their units, and perhaps those of blank ones."""
    cells, names = layout.dialect.cells(text), layout.names
    return len(cells) >= len(names) and all(
        cell.startswith(name) for cell, name in zip(cells, names, strict=False) if name
    )


def _are_table(lines: Sequence[str], layout: Layout) -> bool:
    """Whether most of the lines below the rows are those of another table: of numbers, in one number of cells."""
    dialect, width = layout.dialect, len(layout.names)
    cells = [dialect.cells(line) for line in lines]
    widths = Counter(len(some) for some in cells if kind_of(some[0], comma=dialect.comma) == "number")
    (usual, often), *_ = [*widths.most_common(1), (width, 0)]
    return usual != width and AS_WIDE * len(lines) < often


def _ending(below: bytes, line: int, layout: Layout, skipped: frozenset[int]) -> Remark | None:
    """Return what is to be said of the last of some rows, which has no end; ``line`` is the number behind its own."""
    lines = below.decode(errors="replace").split("\n")[:-1]
    # The first one may be the end of a longer one.
    above = [text for k, text in enumerate(lines[:-1], start=line - len(lines)) if k not in skipped][1:]
    return cut_number(above, lines[-1], layout)


def _suspects(piece: bytes, layout: Layout) -> list[int]:
    """Return the indices of the lines that are perhaps not rows; rather too many than too few."""
    delimiter, width = layout.dialect.delimiter, len(layout.names)
    if delimiter == " ":
        lines = piece.split(b"\n")[:-1]
        # Quotes and blanks that are no ASCII make other cells than bytes do.
        return [k for k, row in enumerate(lines) if len(row.split()) != width or b'"' in row or not row.isascii()]
    mark, trailing = delimiter.encode(), not layout.names[-1]
    # Without the characters of numbers, a row of numbers is its delimiters.
    left = piece.translate(None, NUMERALS + b"," if layout.dialect.comma and delimiter != "," else NUMERALS)
    plain = left == (mark * (width - 1) + b"\n") * (len(left) // width)
    if plain and width > 1 and (not trailing or piece.count(mark + b"\n") == len(left) // width):
        return []
    codes = np.frombuffer(piece, np.uint8)
    ends = np.flatnonzero(codes == ord("\n"))
    starts = np.concatenate([[0], ends[:-1] + 1])

    def found(which: np.ndarray[tuple[int], np.dtype[np.bool]]) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
        return np.add.reduceat(which, starts, dtype=np.int32)

    suspect = (found(codes == ord(delimiter)) != width - 1) | (found(DIGITS[codes]) == 0) | COMMENT_MARKS[codes[starts]]
    if width == 1:
        suspect |= ~NUMBER_STARTS[codes[starts]]
    if b'"' in piece:
        suspect |= found(codes == ord('"')) > 0
    if trailing:
        suspect |= codes[ends - 1] != ord(delimiter)
    return [int(k) for k in np.flatnonzero(suspect)]


def is_row(text: str, layout: Layout) -> bool:
    """Return whether a line has the cells of a row, with a number among them."""
    if layout.dialect.is_comment(text):
        return False
    cells, width = layout.dialect.cells(text), len(layout.names)
    if not layout.names[-1]:
        # The delimiter at the end of a row may be absent, but no value may follow it.
        return len(cells) == width - 1 or (len(cells) == width and layout.dialect.kinds(text)[-1] == "missing")
    # Empty cells behind the last column of a row are dropped.
    if not any(cells[width:]):
        cells = cells[:width]
    kinds = {kind_of(cell, comma=layout.dialect.comma) for cell in cells}
    return len(cells) == width and not kinds <= {"text", "date"}


def _why(text: str, layout: Layout, line: int, last: int) -> Remark:
    """Return why a line is left out; refuse one that may be a sample."""
    dialect, width = layout.dialect, len(layout.names)
    if dialect.is_comment(text):
        return Remark(LeftOut.COMMENT, {"line": shortened(text)})
    cells = dialect.cells(text)
    # A number may be cut off behind its decimal sign.
    samples = kind_of(cells[0].rstrip(",."), comma=dialect.comma) in ("number", "stamp")
    if line < last or (samples and len(cells) > width):
        found = f"has {len(cells)} cells, the rows above have {width} ({dialect})"
        found = found if len(cells) != width else "contains no number"
        raise RecordError(f"line {line} {found}: {shortened(text)}; correct it, or remove it if it is not a sample")
    if samples and len(cells) < width:
        return Remark(LeftOut.CUT_SHORT, {"cells": len(cells), "width": width})
    return Remark(LeftOut.FOOTER, {"line": shortened(text)})


def _numbers(lines: Sequence[int], rows: Sequence[str], use: Sequence[int], layout: Layout) -> Iterator[RealArray]:
    """Yield the numbers of some columns (column, row) by blocks of rows."""
    if not rows:
        return
    values = loaded(rows, len(rows), use, layout)
    if values is not None:
        yield values
    # So few rows are read cell by cell as soon as numpy refuses one of them.
    elif len(rows) <= 16:
        yield np.array([_row(line, row, use, layout) for line, row in zip(lines, rows, strict=True)]).T
    else:
        middle = len(rows) // 2
        yield from _numbers(lines[:middle], rows[:middle], use, layout)
        yield from _numbers(lines[middle:], rows[middle:], use, layout)


def _row(line: int, row: str, use: Sequence[int], layout: Layout) -> list[float]:
    """Return the numbers of a row, or refuse the first cell that is neither a number nor missing."""
    cells, comma = layout.dialect.cells(row), layout.dialect.comma
    values = []
    for k in use:
        value = number(cells[k], comma=comma)
        if value is None:
            hint = "; write decimals with a point" if COMMA_NUMBER.fullmatch(cells[k]) else ""
            hint = "; decimals have a comma here, and thousands have no mark" if comma else hint
            raise RecordError(f"line {line}, column {layout.names[k]!r}: {shortened(cells[k])} is not a number{hint}")
        values.append(value)
    return values
