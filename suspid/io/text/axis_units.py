"""Units of the horizontal axis, as oscilloscopes state them above the columns or beside their first rows."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence

from suspid.io.names import FREQUENCY_UNITS, PER_SECOND
from suspid.io.text.cells import number
from suspid.io.text.columns import Columns
from suspid.units import Hertz

# What they call it.
HORIZONTAL_UNIT = ("horizontal units", "horizontal unit")
# A mean step is a stated one to within this share of it.
SAME_STEP = 0.02


def axis_unit(lines: Sequence[str], columns: Columns, axis: int, rates: Collection[Hertz]) -> str:
    """Return the unit of the horizontal axis that a line states, if the numbers of a column rise; else nothing.

    It is one of time or of frequency. Where the numbers are seconds by a rate that is stated, another one is that of
    the scale.

    Examples
    --------
    >>> from suspid.io.text.dialects import COMMAS
    >>> columns = Columns(COMMAS, ("number", "number"))
    >>> axis_unit(["Horizontal Units,S", "TIME,CH1", "0,5", "1,4"], columns, 0, [1.0])
    'S'
    """
    # Of most texts no line does, which is told of all at once.
    if HORIZONTAL_UNIT[1] not in "\n".join(lines).lower():
        return ""
    named = [line for line in lines if line.lstrip('" ')[: len(HORIZONTAL_UNIT[1])].lower() == HORIZONTAL_UNIT[1]]
    stated = [columns.dialect.cells(line) for line in named]
    unit = next((cells[1] for cells in stated if cells[0].lower() in HORIZONTAL_UNIT and len(cells) > 1), "")
    if unit.lower() not in PER_SECOND.keys() | FREQUENCY_UNITS:
        return ""
    rows = [columns.dialect.cells(line)[axis] for line in lines if columns.are_data(line)]
    numbers = [value for cell in rows if (value := number(cell, comma=columns.dialect.comma)) is not None]
    rises = all(a <= b for a, b in itertools.pairwise(numbers)) and numbers[-1] > numbers[0]
    if not rises:
        return ""
    step = (numbers[-1] - numbers[0]) / (len(numbers) - 1)
    are_seconds = any(abs(step * rate - 1) < SAME_STEP for rate in rates)
    return "" if are_seconds and PER_SECOND.get(unit.lower(), 0.0) != 1 else unit
