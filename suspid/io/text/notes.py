"""Notes behind the rows of a text file, in a last column that other rows lack: comments, or events of a logger."""

from __future__ import annotations

import re
from collections.abc import Mapping

from suspid.io.names import plain
from suspid.io.text.columns import REMARKS
from suspid.io.text.dialects import DELIMITERS
from suspid.words import LeftOut, Remark

# What rows of numbers are made of.
ROW_BYTES = b"0123456789.,;+- \t\n"
# Every name of such a column has one of these in it.
STEMS = [word.encode() for word in sorted(REMARKS) if not any(other in word for other in REMARKS - {word})]


# Lines that are looked at first.
FIRST_LINES = 1000
# What the first cell of a row of numbers begins with.
ROW_STARTS = b"0123456789+-."
# What a word begins with.
LETTERS = rb"A-Za-z_\x80-\xff"


def without_notes(text: bytes, *, within: int) -> tuple[bytes, Mapping[str, Remark]]:
    r"""Return a text without the notes behind its rows, and the name of their column.

    LabVIEW names a last column of comments and writes a cell of it only where there is one, mostly behind the first
    row. Loggers write their events so, sometimes several. The names are looked for in the first ``within`` bytes.

    Examples
    --------
    >>> without_notes(b"X_Value,seat,Comment\n0,1.5,cold day\n0.5,2\n", within=100)[0]
    b'X_Value,seat,Comment\n0,1.5\n0.5,2\n'
    >>> without_notes(b"t,seat,Events\n0,1.5,Start\n1,2\n2,2\n3,2,Pause,Stop\n", within=100)[0]
    b't,seat\n0,1.5\n1,2\n2,2\n3,2\n'
    """
    # Deleting what rows are made of is faster than to look for words in them.
    lowered = text[:within].translate(None, ROW_BYTES).lower()
    if not any(word in lowered for word in STEMS):
        return _without_events(text, within)
    lines = text[:within].split(b"\n")
    for number, line in enumerate(lines[:-1]):
        mark = _mark(line)
        name = plain(line.rpartition(mark)[2].decode().strip().strip('"'))
        if name.lower() not in REMARKS:
            continue
        width = line.count(mark)
        counts = [row.count(mark) for row in lines[number + 1 : -1] if row.strip()]
        if width and width in counts and width - 1 in counts and set(counts) <= {width, width - 1}:
            start = sum(len(above) + 1 for above in lines[: number + 1])
            cell = rb"[^%b\n]*" % re.escape(mark)
            noted = rb"(?m)^(%b(?:%b%b){%d})%b[^\n]*$" % (cell, re.escape(mark), cell, width - 1, re.escape(mark))
            return text[:start] + re.sub(noted, rb"\1", text[start:]), {name: Remark(LeftOut.TEXT)}
    return _without_events(text, within)


def _mark(line: bytes) -> bytes:
    """Return what separates the cells of a line of names."""
    return next((known.encode() for known in DELIMITERS if known.encode() in line), b"\t")


def _without_events(text: bytes, within: int) -> tuple[bytes, Mapping[str, Remark]]:
    """Return a text whose names are one more than the cells of its rows, without the words behind some of them."""
    # Nearly all files are none of these, which the first lines tell.
    lines = text[:within].split(b"\n", FIRST_LINES)
    rows = (k for k, line in enumerate(lines) if k and line.strip()[:1] and line.strip()[:1] in ROW_STARTS)
    first = next(rows, 0)
    above = lines[first - 1] if first else b""
    mark = re.escape(_mark(above))
    width = len(re.findall(mark, above))
    cell = rb"[^%b\n]*" % mark
    row = rb"%b(?:%b%b){%d}" % (cell, mark, cell, max(width - 1, 0))
    words = rb"(?:%b[ \t]*(?:[%b][^%b\n]*)?)*" % (mark, LETTERS, mark)
    name = above.rpartition(_mark(above))[2].strip()
    named = re.fullmatch(rb"[%b][^%b\n]*" % (LETTERS, mark), name) is not None and b'"' not in text[:within]
    # Without a row of words, the names may be one too many for another reason.
    some = rb"(?m)^%b%b[ \t]*[%b]" % (row, mark, LETTERS)
    noted = re.compile(row + words)
    filled = (line for line in lines[first:-1] if line.strip())
    if width < 2 or mark == rb"\ " or not named or not all(noted.fullmatch(line) for line in filled):
        return text, {}
    lines = text[:within].split(b"\n")
    known = [line for line in lines[first:-1] if line.strip()]
    if not all(noted.fullmatch(line) for line in known):
        return text, {}
    start = sum(len(line) + 1 for line in lines[:first])
    plain_rows = sum(re.fullmatch(row, line) is not None for line in known)
    if 2 * plain_rows < len(known) or not re.search(some, text[start:]):
        return text, {}
    header = text[: start - 1].rpartition(_mark(above))[0]
    body = re.sub(rb"(?m)^(%b)%b$" % (row, words), rb"\1", text[start:])
    return header + b"\n" + body, {plain(name.decode()): Remark(LeftOut.TEXT)}
