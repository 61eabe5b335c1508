"""Epochs: stamps since a date long ago are counted from the first one, as dates are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.recordings import RawChannel
from suspid.units import RealArray, Second
from suspid.words import LeftOut, Remark

# Stamps above this count from a date, such as 1970: no machine has run for three years [s]. Of such numbers a message
# with six digits does not tell one stamp from the next.
SINCE_A_DATE = 1e8


def counted_from_first(
    channels: Sequence[RawChannel], time: str | None
) -> tuple[tuple[RawChannel, ...], dict[str, Remark]]:
    """Return the channels with their stamps counted from the first of all, where these are seconds since a date.

    Channels keep their distance in time, and those of one clock one array. ``time`` names the clock in what is said.

    Examples
    --------
    >>> stamps = 1.7e9 + np.array([0.5, 0.75, 1.0])
    >>> raw = RawChannel(name="seat", unit="m", timepts=stamps, values=np.ones(3), rate=None)
    >>> (counted,), said = counted_from_first([raw], "t")
    >>> counted.timepts, [f"{name} {why}" for name, why in said.items()]
    (array([0.  , 0.25, 0.5 ]), ["start of 't' is 1700000000.500000 s; times are counted from there"])
    """
    arrays = {id(channel.timepts): channel.timepts for channel in channels}
    starts = [_start(stamps) for stamps in arrays.values()]
    if not starts or not min(starts) > SINCE_A_DATE:
        return tuple(channels), {}
    start = min(starts)
    counted = {key: _from(start, stamps) for key, stamps in arrays.items()}
    shifted = tuple(replace(channel, timepts=counted[id(channel.timepts)]) for channel in channels)
    return shifted, {f"start of {time or 'time'!r}": Remark(LeftOut.SINCE_A_DATE, {"start": start})}


def _start(stamps: RealArray) -> Second:
    """Return the first stamp that is a number and no outlier; minus infinity if stamps do not count from a date."""
    # Of most clocks the largest stamp tells.
    known = stamps[np.isfinite(stamps)] if np.any(stamps > SINCE_A_DATE) else stamps[:0]
    if not known.size or not float(np.median(known)) > SINCE_A_DATE:
        return -np.inf
    return float(known[known > SINCE_A_DATE][0])


def _from(start: Second, stamps: RealArray) -> RealArray:
    """Return stamps counted from a start, with the decimals that their size has left."""
    decimals = int(np.floor(-np.log10(4 * np.spacing(start))))
    counted = np.round(stamps - start, decimals)
    counted.flags.writeable = False
    return np.asarray(counted)
