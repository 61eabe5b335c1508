"""Marks between thousands that would be read as decimal signs, such as ``1.234`` beside ``987``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.errors import RecordError
from suspid.io.text.dialects import Dialect, shortened

# Whole numbers below a thousand, and others whose thousands have a mark.
BELOW_THOUSAND = re.compile(r"[+-]?\d{1,3}", re.A)
MARKED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.A)
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
    rows = [cells for line in lines if len(cells := dialect.cells(line)) == len(names)]
    for name, column in zip(names, zip(*rows, strict=True), strict=False):
        small, marked = set[str](), ""
        # The names stand in the first rows, gaps between others.
        for cell in (cell for cell in column if any(map(str.isdecimal, cell))):
            if BELOW_THOUSAND.fullmatch(cell):
                small.add(cell)
            elif MARKED.fullmatch(cell):
                marked = marked or cell
            else:
                break
        else:
            small -= {"0", "-0", "+0"}
            if marked and len(small) >= LEAST_SMALL:
                raise RecordError(
                    f"{name!r} contains {shortened(marked)} beside {shortened(min(small))}: the "
                    f"{'comma' if dialect.comma else 'point'} seems to separate thousands; write numbers without a "
                    f"mark between the thousands, or decimals with all their digits"
                )
