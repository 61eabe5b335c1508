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
                f"{'comma' if dialect.comma else 'point'} seems to separate thousands; write numbers without a "
                f"mark between the thousands, or decimals with all their digits"
            )
