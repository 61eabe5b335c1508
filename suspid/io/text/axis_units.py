"""Units of the horizontal axis, as oscilloscopes state them above the columns or beside their first rows."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from suspid.io.text.cells import number
from suspid.io.text.columns import Columns

# What they call it.
HORIZONTAL_UNIT = ("horizontal units", "horizontal unit")


def axis_unit(lines: Sequence[str], columns: Columns, axis: int) -> str:
    """Return the unit of the horizontal axis that a line states, if the numbers of a column rise; else nothing.

    Examples
    --------
    >>> from suspid.io.text.dialects import COMMAS
    >>> columns = Columns(COMMAS, ("number", "number"))
    >>> axis_unit(["Horizontal Units,S", "TIME,CH1", "0,5", "1,4"], columns, 0)
    'S'
    """
    named = [line for line in lines if line.lstrip('" ')[: len(HORIZONTAL_UNIT[1])].lower() == HORIZONTAL_UNIT[1]]
    stated = [columns.dialect.cells(line) for line in named]
    unit = next((cells[1] for cells in stated if cells[0].lower() in HORIZONTAL_UNIT and len(cells) > 1), "")
    if not unit:
        return ""
    rows = [columns.dialect.cells(line)[axis] for line in lines if columns.are_data(line)]
    numbers = [value for cell in rows if (value := number(cell, comma=columns.dialect.comma)) is not None]
    rises = all(a <= b for a, b in itertools.pairwise(numbers)) and numbers[-1] > numbers[0]
    return unit if rises else ""
