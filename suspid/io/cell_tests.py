"""Cell arrays of MATLAB that hold one test a cell: its time in one array, its channels in others."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from suspid.io.labels import Group, Value, Variable
from suspid.io.names import PER_SECOND, may_be_time, split_unit

# What the vector of time of a test is called, and its only array.
TIME_OF_CELL, DATA_OF_CELL = "time", "data"


def with_paired_cells(group: Group) -> Group:
    """Return variables with cell arrays of times and those of as many cells as long as these as tests, a group each.

    Cells that fit the times of several arrays stay as they are, and so do times without any.

    Examples
    --------
    >>> import numpy as np
    >>> long, short = (Variable(shape=(size, 1), read=lambda size=size: np.zeros((size, 1))) for size in (9, 7))
    >>> found = with_paired_cells({"Time_id": {"[1]": long, "[2]": short}, "Y": {"[1]": long, "[2]": short}})
    >>> list(found), list(found["Y[2]"])
    (['Y[1]', 'Y[2]'], ['time', 'data'])
    """
    cells = {name: found for name, value in group.items() if len(found := _cells(value)) > 1}
    times = {name: each for name, each in cells.items() if may_be_time(name) and all(v.is_vector for v in each)}
    fits = {
        name: [time for time, stamps in times.items() if _fit(each, stamps)]
        for name, each in cells.items()
        if name not in times
    }
    channels = {time: [name for name, of in fits.items() if of == [time]] for time in times}
    paired = {name for time, names in channels.items() if names for name in (time, *names)}
    tests: dict[str, Value] = {}
    for time, names in channels.items():
        called = names[0] if len(names) == 1 else time
        for k, each in enumerate(times[time] if names else []):
            stamps = replace(each, unit=each.unit or _unit_in(time))
            held = {DATA_OF_CELL if len(names) == 1 else name: cells[name][k] for name in names}
            tests[f"{called}[{k + 1}]"] = {TIME_OF_CELL: stamps, **held}
    return {name: value for name, value in group.items() if name not in paired} | tests


def _cells(value: Value) -> list[Variable]:
    """Return the arrays of a cell array, see `labels.of_cells`; none if it holds anything else."""
    if not isinstance(value, Mapping) or list(value) != [f"[{k + 1}]" for k in range(len(value))]:
        return []
    held = [
        one[DATA_OF_CELL] if isinstance(one, Mapping) and set(one) == {DATA_OF_CELL} else one for one in value.values()
    ]
    arrays = [one for one in held if isinstance(one, Variable)]
    return arrays if len(arrays) == len(held) else []


def _fit(cells: list[Variable], stamps: list[Variable]) -> bool:
    """Return whether the longer side of each array is as long as the vector of time of the same number."""
    return len(cells) == len(stamps) and all(
        time.size == max(one.shape) for one, time in zip(cells, stamps, strict=True)
    )


def _unit_in(name: str) -> str:
    """Return the unit that the name of a time ends with, as ``Time_ms``; nothing if none.

    Examples
    --------
    >>> _unit_in("Time_ms"), _unit_in("t [us]"), _unit_in("Time_id")
    ('ms', 'us', '')
    """
    last = re.split(r"[\W_]+", name.lower())[-1]
    return split_unit(name)[1] or (last if last in PER_SECOND else "")
