"""Settings beside the columns of text files: names without columns, and their values below them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from suspid.io.names import is_start, is_step, stated_rate
from suspid.io.text.cells import kind_of, number
from suspid.io.text.columns import Columns
from suspid.io.text.dialects import DIALECTS, Dialect
from suspid.units import Hertz, Second


def stated_beside(above: Sequence[str], columns: Columns) -> tuple[list[str], dict[str, Hertz], Second]:
    """Return the lines above the data without settings beside the columns, and the rates and start that these state.

    Oscilloscopes write ``X,CH1,Start,Increment`` above ``Sequence,Volt,-0.5,0.001``, some without the values.

    Examples
    --------
    >>> from suspid.io.text.dialects import COMMAS
    >>> columns = Columns(COMMAS, ("number", "number"))
    >>> stated_beside(["X,CH1,Start,Increment", "Sequence,Volt,-0.5,0.001"], columns)
    (['X,CH1', 'Sequence,Volt'], {'Increment': 1000.0}, -0.5)
    >>> stated_beside(["CH1,CH2,Start,Increment,"], columns)
    (['CH1,CH2'], {}, 0.0)
    >>> stated_beside(["angle_deg;sample_rate", "90;1000"], Columns(COMMAS, ("number",)))
    (['', ''], {'sample_rate': 1000.0}, 0.0)
    """
    lines, rates, start = list(above), dict[str, Hertz](), 0.0
    for dialect, k in itertools.product(_dialects(columns), range(len(lines) - 1)):
        names, below = dialect.cells(lines[k]), dialect.cells(lines[k + 1])
        kinds = [kind_of(cell, comma=dialect.comma) for cell in below]
        if "number" not in kinds[1:] or abs(len(names) - len(below)) > 1 or len(below) <= len(columns.kinds):
            continue
        first = kinds.index("number")
        cells = dict(zip(names[first:], below[first:], strict=False))
        numbers = {name: number(cell, comma=dialect.comma) or 0.0 for name, cell in cells.items()}
        stated = {name: stated_rate(name, value) for name, value in numbers.items()}
        found = {name: rate for name, rate in stated.items() if rate is not None}
        if found:
            rates |= found
            start = next((value for name, value in numbers.items() if is_start(name)), 0.0)
            lines[k], lines[k + 1] = (dialect.delimiter.join(cells[:first]) for cells in (names, below))
    dialect = columns.dialect
    if dialect.delimiter == " ":
        return lines, rates, start
    last = next((k for k in reversed(range(len(lines))) if lines[k].strip()), None)
    width = len(columns.kinds) - columns.trailing
    names = [] if last is None else dialect.cells(lines[last])
    if last is not None and (beside := [name for name in names[width:] if name]):
        settings = all(is_start(name) or is_step(name) for name in beside)
        lines[last] = dialect.delimiter.join(names[:width]) if settings else lines[last]
    return lines, rates, start


def _dialects(columns: Columns) -> list[Dialect]:
    """Return how settings may be written: as the rows are; above a single column, which has no delimiter, as in any."""
    own = columns.dialect
    if len(columns.kinds) > 1:
        return [own] if own.delimiter != " " else []
    others = [one for one in DIALECTS if one.comma == own.comma and one.delimiter != " "]
    return [one for one in others if not (one.comma and one.delimiter == ",")]
