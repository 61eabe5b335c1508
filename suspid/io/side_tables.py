"""Tables in the same rows as the record, over an axis of their own, such as a spectrum over its frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.io.clock_numbers import filled
from suspid.io.time_units import FEW_STAMPS
from suspid.levels import SEVEN_DIGITS
from suspid.units import RealArray
from suspid.words import LeftOut, Remark


def of_side_tables(names: Sequence[str], columns: Mapping[str, RealArray]) -> dict[str, Remark]:
    """Return the columns of tables beside the records: an axis, and what ends with it.

    An axis rises in even steps to seven digits and ends before the longest column. No sensor does both.

    Examples
    --------
    >>> seat = np.cos(np.arange(50.0))
    >>> axis, level = (np.append(each, np.full(25, np.nan)) for each in (np.arange(25) / 5, seat[:25]))
    >>> for name, why in of_side_tables(["seat", "f", "FFT"], {"seat": seat, "f": axis, "FFT": level}).items():
    ...     print(name, why)
    f rises in even steps and ends before the record does: an axis of its own
    FFT ends with 'f', which is no time
    """
    ends = {name: filled(columns[name]) for name in names}
    last, found = max(ends.values(), default=0), dict[str, Remark]()
    for axis, end in ends.items():
        if axis not in found and FEW_STAMPS <= end < last and _rises_evenly(columns[axis][:end]):
            over = Remark(LeftOut.OVER_AXIS, {"axis": axis})
            found |= {name: over for name in names if ends[name] == end and name not in found}
            found[axis] = Remark(LeftOut.AXIS)
    return found


def _rises_evenly(numbers: RealArray) -> bool:
    """Whether numbers rise in even steps; one that is missing has none."""
    steps = np.diff(numbers)
    rise = numbers[-1] - numbers[0]
    return bool(np.all(steps > 0) and np.ptp(steps) <= SEVEN_DIGITS * rise)
