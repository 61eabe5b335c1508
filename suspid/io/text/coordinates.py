"""Cells that hold several numbers in brackets, as programs that track a point in a film write its coordinates."""

from __future__ import annotations

import csv
import re

# Two or three numbers in brackets and quotes, as Python prints a tuple or a list.
NUMBER = rb" {0,9}[-+]?[\d.][-+.\deE]{0,40} {0,9}"
CELL = re.compile(rb'"[(\[](%b(?:,%b){1,2})[)\]]"' % (NUMBER, NUMBER))
BEGIN = re.compile(rb'"[(\[]')


def with_coordinates(text: bytes, *, within: int) -> bytes:
    r"""Return a text with a column for each number in cells such as ``"(3, 5)"``, if every row has them.

    The first row is looked for in the first ``within`` bytes, and stands below the names.

    Examples
    --------
    >>> with_coordinates(b'point,t\n"(3, 5)",0.1\n"(4, 5)",0.2\n', within=100)
    b'point[1],point[2],t\n3, 5,0.1\n4, 5,0.2\n'
    """
    # Nearly all files have no quoted bracket, and none before it.
    if b'"' not in text[:within] or not BEGIN.search(text, 0, within) or not (found := CELL.search(text, 0, within)):
        return text
    start = text.rfind(b"\n", 0, found.start()) + 1
    above, rows = text[:start].rstrip(b"\n"), text[start:]
    before, names = above[: above.rfind(b"\n") + 1], _cells(above[above.rfind(b"\n") + 1 :])
    first = _cells(rows[: rows.find(b"\n")])
    numbers = [cell.count(",") + 1 if CELL.fullmatch(f'"{cell}"'.encode()) else 1 for cell in first]
    filled = sum(not row.isspace() and row != b"" for row in rows.split(b"\n"))
    parted = CELL.sub(rb"\1", rows)
    # Each row has as many numbers in each place as the first one.
    places = [rb'"[(\[]%b[)\]]"' % b",".join([NUMBER] * n) if n > 1 else rb'[^",\n]*' for n in numbers]
    alike = re.findall(rb"^%b\r?$" % b",".join(places), rows, re.MULTILINE)
    if len(alike) != filled or len(names) != len(first) or b'"' in parted:
        return text
    titles = [f"{name}[{k + 1}]" if n > 1 else name for name, n in zip(names, numbers, strict=True) for k in range(n)]
    return before + ",".join(titles).encode() + b"\n" * (start - len(above)) + parted


def _cells(line: bytes) -> list[str]:
    """Return the cells of a line; none of one that is no line of cells."""
    try:
        return next(csv.reader([line.decode()]), [])
    except csv.Error:
        return []
