"""Columns of text files that hold the time from each sample to the next, in place of the time."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from functools import partial

import numpy as np

from suspid.io.names import PER_SECOND, STEP_NAMES, UNNAMED_COLUMN, is_since_last, is_time, split_unit
from suspid.io.tables import TimeBase
from suspid.io.text.rows import Rows
from suspid.io.time_units import FEW_STAMPS
from suspid.stamps import are_even
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

# Steps of telephones are whole milliseconds. In coarser units they would be none of a record of vibrations.
STEP_UNIT = "ms"


def step_clock(rows: Rows, numeric: Sequence[str]) -> tuple[TimeBase | None, dict[str, Remark]]:
    """Return the time base of a column of steps between samples, if there is one and no column of time.

    Loggers on telephones write ``X Y Z step`` without names: the first step is 0, the others are about alike. No
    channel looks so, unless it is constant. The column is sought where nothing else is the time.
    """
    if any(is_time(name) for name in numeric) or rows.layout.rates or rows.size < FEW_STAMPS:
        return None, {}
    for name in (name for name in numeric if _may_be_steps(name)):
        top = [cell.strip() for cell in itertools.islice(rows.cells(name), FEW_STAMPS)]
        named = not name.startswith("column ")
        unit = split_unit(name)[1] or STEP_UNIT
        if unit not in PER_SECOND or not _starts(top, named=named):
            continue
        steps = rows.columns([name])[0]
        if _are_steps(steps[1:], constant=named):
            stamps = np.cumsum(np.concatenate([[0.0], steps[1:]])) / PER_SECOND[unit]
            said = {name: Remark(LeftOut.STEP_CLOCK, {"unit": unit})}
            return TimeBase(name=name, stamps=partial(np.copy, stamps)), said
    return None, {}


def _may_be_steps(name: str) -> bool:
    """Whether a column of that name may hold steps: it has no name, or one for a step of time."""
    stem = split_unit(name)[0]
    return UNNAMED_COLUMN.fullmatch(name) is not None or stem in STEP_NAMES or is_since_last(name)


def _starts(cells: Sequence[str], *, named: bool) -> bool:
    """Whether a column begins as steps do: with 0, unless its name says what it is, and then whole numbers."""
    return (named or not cells[0].strip("0")) and all(re.fullmatch(r"\d+", cell) for cell in cells)


def _are_steps(steps: RealArray, *, constant: bool) -> bool:
    """Whether numbers are the steps of a clock: positive, whole, and most of them alike."""
    if not np.all(np.isfinite(steps)) or not np.all(steps > 0) or not np.all(steps == np.round(steps)):
        return False
    # Numbers that rise from row to row are stamps.
    if np.all(np.diff(steps) > 0):
        return False
    return are_even(steps) and (constant or bool(np.ptp(steps) > 0))
