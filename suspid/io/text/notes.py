"""Notes behind the rows of a text file, in a column of comments that other rows lack."""

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


def without_notes(text: bytes, *, within: int) -> tuple[bytes, Mapping[str, Remark]]:
    r"""Return a text without the notes behind its rows, and the name of their column.

    LabVIEW names a last column of comments and writes a cell of it only where there is one, mostly behind the first
    row. The names are looked for in the first ``within`` bytes.

    Examples
    --------
    >>> without_notes(b"X_Value,seat,Comment\n0,1.5,cold day\n0.5,2\n", within=100)[0]
    b'X_Value,seat,Comment\n0,1.5\n0.5,2\n'
    """
    # Deleting what rows are made of is faster than to look for words in them.
    lowered = text[:within].translate(None, ROW_BYTES).lower()
    if not any(word in lowered for word in STEMS):
        return text, {}
    lines = text[:within].split(b"\n")
    for number, line in enumerate(lines[:-1]):
        mark = next((known.encode() for known in DELIMITERS if known.encode() in line), b"\t")
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
    return text, {}
