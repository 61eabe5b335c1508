"""Labels in the lines above text: pairs of label and value over each channel, and a unit of time among names."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.io.names import DATE_PARTS, PER_SECOND, is_time, stated_rate
from suspid.io.text.cells import number
from suspid.io.text.columns import Columns
from suspid.units import Hertz

# Labels of a line of names and of one of units; that of a line of steps may mean anything elsewhere.
NAME_LABEL, UNIT_LABELS, STEP_LABEL = re.compile(r"(?i)(.*\W)?(names?|channel|signal)"), {"unit", "units"}, "interval"
# What a column is called that has a label for a name, where a line states its step.
TIME = "Time"
# A column of time has one of these for a name where its own name stands above.
ALONE = PER_SECOND.keys() - DATE_PARTS


def without_labels(above: Sequence[str], columns: Columns) -> tuple[list[str], dict[str, Hertz]]:
    """Return the lines above the data with no labels in the lines of names and units, and the rate that one states.

    LabVIEW writes a time before each channel, and ``Channel name,Force`` and ``Unit,V`` above both. Where a line
    ``Interval,0.001`` states the step, the columns below the labels are times.

    Examples
    --------
    >>> from suspid.io.text.dialects import COMMAS
    >>> lines = ["Interval,0.5,Interval,0.5", "Name,Force,Name,Travel", "Unit,N,Unit,mm"]
    >>> without_labels(lines, Columns(COMMAS, ("number",) * 4))
    (['Interval,0.5,Interval,0.5', 'Time,Force,Time (2),Travel', ',N,,mm'], {'Interval': 2.0})
    """
    lines, dialect = list(above), columns.dialect
    units_at = next((k for k, line in enumerate(lines) if line.lstrip('" ')[:4].lower() == "unit"), 0)
    if not units_at or dialect.delimiter == " ":
        return lines, {}
    *others, names, units = (dialect.cells(line) for line in lines[: units_at + 1])
    pairs = [_is_pairs(cells, len(columns.kinds)) for cells in (names, units)]
    if not all(pairs) or units[0].lower() not in UNIT_LABELS or not NAME_LABEL.fullmatch(names[0]):
        return lines, {}
    stated = {cells[0]: _rates(cells, columns) for cells in others if _is_pairs(cells, len(columns.kinds))}
    known = {label: rates for label, rates in stated.items() if rates}
    lines[units_at - 1] = _joined(names, TIME if known else "", dialect.delimiter)
    lines[units_at] = _joined(units, "", dialect.delimiter)
    return lines, {label: next(iter(rates)) for label, rates in known.items() if len(rates) == 1}


def named_above(lines: Sequence[str], names: Sequence[str], columns: Columns) -> tuple[int, str] | None:
    """Return which column has a unit of time for a name, and its name in the last of the lines above; None if none has.

    Servo drives write ``Time,Analog 1`` above ``ms,Torque``.

    Examples
    --------
    >>> from suspid.io.text.dialects import COMMAS
    >>> named_above(["Time,Analog 1"], ["ms", "Torque"], Columns(COMMAS, ("number",) * 2))
    (0, 'Time')
    """
    units = [k for k, name in enumerate(names) if name.lower() in ALONE]
    line = next((line for line in reversed(lines) if line.strip()), "")
    titles = columns.titles(line) if units and columns.may_be_named_by(line) else []
    times = [(k, titles[k]) for k in units if titles and is_time(titles[k]) and titles[k] not in names]
    return times[0] if len(times) == 1 else None


def _is_pairs(cells: Sequence[str], width: int) -> bool:
    """Whether the cells of a line are the same label before each value."""
    return len(cells) == width and width % 2 == 0 and len({*cells[::2]}) == 1


def _rates(cells: Sequence[str], columns: Columns) -> set[Hertz]:
    """Return the rates that the pairs of a line state; none if one of them states none."""
    label = "dt" if cells[0].lower() == STEP_LABEL else cells[0]
    rates = [stated_rate(label, number(cell, comma=columns.dialect.comma) or 0.0) for cell in cells[1::2]]
    return {rate for rate in rates if rate is not None} if None not in rates else set()


def _joined(cells: Sequence[str], label: str, delimiter: str) -> str:
    """Return a line of the values of pairs, each behind what its column is called in place of the label."""
    called = [label] + [label and f"{label} ({k})" for k in range(2, len(cells) // 2 + 1)]
    quoted = ['"' + cell.replace('"', '""') + '"' for cell in cells[1::2]]
    values = [
        each if delimiter in cell or '"' in cell else cell for cell, each in zip(cells[1::2], quoted, strict=True)
    ]
    return delimiter.join(cell for pair in zip(called, values, strict=True) for cell in pair)
