"""Cells that hold a label before their number, as programs for microcontrollers print them: ``Gyro: -0.91,RPM: 13``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.io.text.cells import kind_of

# A label, what separates it from its number, and the number.
LABELLED_CELL = re.compile(rb"[ \t]*([A-Za-z_][^:=]{0,40}?)[ \t]*[:=][ \t]*([^:=]{1,40})")
# Lines above the rows that are looked at, what may separate the cells, and their largest number.
LINES_ABOVE, CELL_MARKS, MOST_CELLS = 20, (b",", b";", b"\t", b"|"), 64


def with_names_above(text: bytes, *, within: int) -> bytes:
    r"""Return a text with labels in a line above its rows, if the rows all have the same before their numbers.

    The first row is looked for in the first ``within`` bytes. The last one may be cut off.

    Examples
    --------
    >>> with_names_above(b"51.9,Gyro: -0.91, RPM:13\n52.1,Gyro: -0.99, RPM:11\n", within=100)
    b',Gyro,RPM\n51.9,-0.91,13\n52.1,-0.99,11\n'
    """
    # Nearly all files have neither sign.
    if b":" not in text[:within] and b"=" not in text[:within]:
        return text
    start = 0
    for line in text[:within].split(b"\n", LINES_ABOVE)[:LINES_ABOVE]:
        for mark in CELL_MARKS:
            labels = _labels(line.split(mark)) if 1 <= line.count(mark) < MOST_CELLS else []
            if 2 * sum(map(bool, labels)) > len(labels) > 1:
                return _named(text, start, mark, labels)
        start += len(line) + 1
    return text


def _labels(cells: Sequence[bytes]) -> list[bytes]:
    """Return the labels before the numbers of some cells, empty where there is none."""
    found = [LABELLED_CELL.fullmatch(cell) for cell in cells]
    whole = [each and kind_of(each[2].decode(errors="replace"), comma=False) in ("number", "missing") for each in found]
    return [each[1] if each and ok else b"" for each, ok in zip(found, whole, strict=True)]


def _named(text: bytes, start: int, mark: bytes, labels: Sequence[bytes]) -> bytes:
    """Return a text with the labels of its rows, which begin at ``start``, in a line above, if all have the same."""
    other = re.escape(mark) + rb"\n"
    before = [rb"[ \t]*%b[ \t]*[:=][ \t]*" % re.escape(label) if label else b"" for label in labels]
    row = re.escape(mark).join(rb"%b([^%b]*)" % (each, other) for each in before)
    rows = text[start:].rstrip(b"\n")
    filled = sum(not line.isspace() and line != b"" for line in rows.split(b"\n"))
    alike = re.compile(rb"(?m)^%b$" % row)
    bare, often = alike.subn(mark.join(rb"\g<%d>" % (k + 1) for k in range(len(labels))), rows)
    last = bare.rfind(b"\n") + 1
    if often < 2 or often < filled - (alike.fullmatch(rows, rows.rfind(b"\n") + 1) is None):
        return text
    if often < filled:
        known = b"|".join(each for each in before if each)
        bare = bare[:last] + re.sub(rb"(?:^|(?<=%b))(?:%b)" % (re.escape(mark), known), b"", bare[last:])
    return text[:start] + mark.join(labels) + b"\n" + bare + b"\n"
