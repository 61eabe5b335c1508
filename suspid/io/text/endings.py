"""The last line of a text file: whether it was cut off within a number.

A line without its end may be whole, since some programs end none of the last ones, or the rest of a longer one. Where
all numbers above it have the same number of characters behind the decimal sign, that number tells.
"""

from __future__ import annotations

from collections.abc import Sequence

from suspid.io.text.cells import kind_of
from suspid.io.text.layouts import Layout
from suspid.words import LeftOut, Remark

# What may be followed by more of a number.
OPEN = b"0123456789.,+-eEdD"
# Rows above the last one that are looked at, and the fewest that show a format.
ROWS_ABOVE, FEWEST = 200, 8


def is_open(content: bytes) -> bool:
    r"""Whether a text ends neither in a line feed nor in anything else that ends a number.

    Examples
    --------
    >>> is_open(b"0.1,2.5\n"), is_open(b"0.1,2.5"), is_open(b"0.1,2.5;")
    (False, True, False)
    """
    # Text of UTF-16 has zero bytes, that of DOS the mark of its end.
    return content[-8:].rstrip(b"\0\x1a")[-1:] in [bytes([mark]) for mark in OPEN]


def cut_number(above: Sequence[str], last: str, layout: Layout) -> Remark | None:
    """Return what is to be said of a last row without an end; None where its last number is whole.

    `LeftOut.CUT_NUMBER`: the number lacks characters. `LeftOut.NO_END`: that cannot be told.
    """
    cell = layout.dialect.cells(last)[-1]
    kind = kind_of(cell, comma=layout.dialect.comma)
    if kind != "number":
        # Words and dates end where they end; the beginning of a number is none.
        # A word for what is missing ("---", "-nan", "-1.#IND") begins like one as well, but is whole.
        begun = {
            "missing": cell in ("+", "-", ".", ",", "+.", "-.", "+,", "-,"),
            "text": cell[:1] in ("+", "-", ".", ",") or cell[:1].isdecimal(),
        }
        return Remark(LeftOut.CUT_CELL, {"cell": cell}) if begun.get(kind, False) else None
    lengths = {
        length
        for row in above[-ROWS_ABOVE:]
        if (length := _behind_sign(layout.dialect.cells(row)[-1], layout)) is not None
    }
    own = _behind_sign(cell, layout)
    if len(above) < FEWEST or len(lengths) != 1 or own is None or lengths == {0}:
        return Remark(LeftOut.NO_END, {"cell": cell})
    usual = lengths.pop()
    if own < usual:
        return Remark(LeftOut.CUT_NUMBER, {"cell": cell, "digits": own, "usual": usual})
    return None


def _behind_sign(cell: str, layout: Layout) -> int | None:
    """Return how many characters follow the decimal sign of a number; None for what is no finite number."""
    if kind_of(cell, comma=layout.dialect.comma) != "number" or not any(c.isdecimal() for c in cell):
        return None
    return len(cell.partition("," if layout.dialect.comma else ".")[2])
