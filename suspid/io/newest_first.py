"""Rows that are written newest first, as data bases list them: from the last to the first, in order of time."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.io.tables import TimeBase
from suspid.io.time_units import FEW_STAMPS
from suspid.recordings import RawChannel
from suspid.stamps import FEW
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

# Times that are left until an end fall from row to row as well.
UNTIL_THE_END = re.compile(r"remain|left|count_?down|to[\W_]?go|until", re.IGNORECASE)


def is_newest_first(name: str, stamps: RealArray) -> bool:
    """Return whether the stamps of a column of time fall from row to row but for a few, between recordings.

    Examples
    --------
    >>> rows = np.arange(500.0)
    >>> [is_newest_first("t", stamps) for stamps in (-rows, np.append(-rows, -rows), rows, rows % 2)]
    [True, True, False, False]
    >>> is_newest_first("time left", -rows)
    False
    """
    # Of most columns the rows that rise tell that they are none.
    rises = int(np.count_nonzero(stamps[1:] > stamps[:-1]))
    if rises > FEW * stamps.size:
        return False
    falls = int(np.count_nonzero(stamps[1:] < stamps[:-1]))
    return falls >= FEW_STAMPS and rises <= FEW * falls and not UNTIL_THE_END.search(name)


def oldest_first(
    columns: Mapping[str, RealArray], time: str, followers: Sequence[str]
) -> tuple[dict[str, RealArray], dict[str, Remark]]:
    """Return the columns with those of a time that is newest first turned round, and what is said of that.

    Examples
    --------
    >>> turned, said = oldest_first({"t": -np.arange(100.0), "seat": np.arange(100.0)}, "t", ["seat"])
    >>> float(turned["t"][0]), float(turned["seat"][0]), list(said)
    (-99.0, 99.0, ["order of 't'"])
    """
    if not is_newest_first(time, columns[time]):
        return dict(columns), {}
    return {**columns, **{name: columns[name][::-1] for name in (time, *followers)}}, _said(time)


def in_order(
    channels: Sequence[RawChannel], clocks: Mapping[str, TimeBase]
) -> tuple[list[RawChannel], dict[str, Remark]]:
    """Return the channels with those whose clock is newest first turned round, and what is said of that.

    Examples
    --------
    >>> raw = RawChannel(name="seat", unit="m", timepts=-np.arange(100.0), values=np.arange(100.0), rate=None)
    >>> (turned,), said = in_order([raw], {"seat": TimeBase(name="date", stamps=lambda: raw.timepts)})
    >>> float(turned.timepts[0]), float(turned.values[0]), list(said)
    (-99.0, 99.0, ["order of 'date'"])
    """
    said: dict[str, Remark] = {}
    turned: dict[int, RealArray] = {}
    for channel in channels:
        clock, stamps = clocks.get(channel.name), channel.timepts
        read = clock is not None and clock.stamps is not None and id(stamps) not in turned
        if clock is not None and read and is_newest_first(clock.name, stamps):
            turned[id(stamps)] = stamps[::-1]
            said |= _said(clock.name)
    whole = [
        replace(one, timepts=turned[id(one.timepts)], values=one.values[::-1]) if id(one.timepts) in turned else one
        for one in channels
    ]
    return whole, said


def _said(time: str) -> dict[str, Remark]:
    return {f"order of {time!r}": Remark(LeftOut.NEWEST_FIRST)}
