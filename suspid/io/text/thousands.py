"""Cells of digits and marks that are no numbers, or would be read as others: ``1.234`` beside ``987``, ``1,234.5``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.errors import RecordError
from suspid.io.text.dialects import DELIMITERS, Dialect, shortened

# Whole numbers below a thousand, and others whose thousands have a mark.
BELOW_THOUSAND = re.compile(r"[+-]?\d{1,3}", re.A)
MARKED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.A)
# Numbers whose thousands have marks of any kind.
THOUSANDS = re.compile(
    "[+-]?[1-9]\\d{0,2}([.,' \u2019\xa0\u2009\u202f])\\d{3}(?:\\1\\d{3})*(?:[.,]\\d+)?(?:[eE][+-]?\\d+)?"
)
WITHOUT_MARKS = "write numbers without a mark between the thousands"
# An uncertainty behind a value.
UNCERTAIN = re.compile(r"\d\s*\+-\s*\d")
# Different small numbers that are needed: a program may write a missing sample, or nought, as a whole number.
LEAST_SMALL = 2


def refuse_thousands(lines: Sequence[str], names: Sequence[str], dialect: Dialect) -> None:
    """Refuse a column in which the decimal sign stands where only a mark between thousands does.

    Decimals of three digits end in nought as often as in any other digit: programs that omit it write ``0.5`` and
    ``12.25`` too, others write ``987.000``.

    Raises
    ------
    RecordError
        If all numbers of a column are whole ones below 1000, or have the sign before their last three digits.
    """
    small: dict[int, set[str]] = {k: set() for k in range(len(names))}
    marked: dict[int, str] = {}
    for line in lines:
        # Most columns are settled by the first rows.
        if not small:
            return
        cells = dialect.cells(line)
        if len(cells) != len(names):
            continue
        for k in [*small]:
            # The names stand in the first rows, gaps between others.
            if not any(map(str.isdecimal, cells[k])):
                continue
            if BELOW_THOUSAND.fullmatch(cells[k]):
                small[k].add(cells[k])
            elif MARKED.fullmatch(cells[k]):
                marked.setdefault(k, cells[k])
            else:
                del small[k]
    for k, seen in small.items():
        seen -= {"0", "-0", "+0"}
        if k in marked and len(seen) >= LEAST_SMALL:
            raise RecordError(
                f"{names[k]!r} contains {shortened(marked[k])} beside {shortened(min(seen))}: the "
                f"{'comma' if ',' in marked[k] else 'point'} seems to separate thousands; {WITHOUT_MARKS}, or "
                f"decimals with all their digits"
            )


def marks_between(cell: str) -> str:
    """Return what to write instead of a number whose thousands have marks; nothing of another cell.

    Examples
    --------
    >>> marks_between("1'234.5"), marks_between("2017-2018"), marks_between("-0.015,")
    ('write numbers without a mark between the thousands', '', '')
    """
    return WITHOUT_MARKS if THOUSANDS.fullmatch(cell) else ""


def why_no_number(cell: str, dialect: Dialect) -> str:
    """Return why a cell of digits and marks is no number, and what to write instead.

    Examples
    --------
    >>> print(why_no_number("0.5,", Dialect(delimiter=" ", comma=False)))
    are not numbers but lie between blanks and commas; write numbers alone between commas, and names in a line above
    """
    if UNCERTAIN.search(cell):
        return "hold a value and its uncertainty; write the uncertainty in a column of its own, or leave it out"
    mend = marks_between(cell) or "write one number in each cell, or leave the column out"
    if dialect.delimiter == " " and cell[-1] in ",;":
        marks = DELIMITERS[cell[-1]]
        return (
            f"are not numbers but lie between blanks and {marks}; write numbers alone between {marks}, and names in a "
            f"line above"
        )
    sign = "comma" if dialect.comma else "point"
    return f"are not numbers, where decimals follow a {sign} and cells are {dialect}; {mend}"
