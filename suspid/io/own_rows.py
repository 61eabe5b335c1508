"""Rows of a channel's own: where several loggers write into one table, each fills some and leaves the others blank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.recordings import RawChannel
from suspid.units import Flags, RealArray

# Share of the steps between filled rows that are alike, and how far from the usual one they may be: those between rows
# that a logger lost at random are not.
REGULAR, ALIKE_STEPS = 0.9, 0.25
# Usual step between filled rows in those between all rows, from which on blanks are no gaps: 2 for every second row.
SPARSE = 1.5
# Filled rows from which on their steps say something.
FEW_FILLED = 12


def with_own_rows(channels: Sequence[RawChannel]) -> list[RawChannel]:
    """Return channels of one table, those that fill rows at a slower pace of their own without the others.

    Examples
    --------
    >>> t = np.arange(100) / 100
    >>> every_second = np.where(np.arange(100) % 2, np.nan, t)
    >>> slow = RawChannel(name="seat", unit="m", timepts=t, values=every_second, rate=None)
    >>> with_own_rows([slow])[0].timepts[:3]
    array([0.  , 0.02, 0.04])
    """
    stamps: dict[tuple[int, bytes], RealArray] = {}
    out = []
    for channel in channels:
        filled = ~np.isnan(channel.values)
        if channel.values.size != channel.timepts.size or not _slower(channel.timepts, filled):
            out.append(channel)
            continue
        # Channels of one logger keep one array of stamps, by which they are known to be of one clock.
        key = id(channel.timepts), np.packbits(filled).tobytes()
        if key not in stamps:
            stamps[key] = channel.timepts[filled]
            stamps[key].flags.writeable = False
        rate = None if channel.rate is None else channel.rate * float(np.mean(filled))
        out.append(replace(channel, timepts=stamps[key], values=channel.values[filled], rate=rate))
    return out


def _slower(times: RealArray, filled: Flags) -> bool:
    """Return whether the filled rows of a table follow each other regularly, and clearly slower than all rows."""
    if not FEW_FILLED <= np.count_nonzero(filled) <= filled.size / SPARSE:
        return False
    steps, every = np.diff(times[filled]), float(np.median(np.diff(times)))
    usual = float(np.median(steps))
    alike = np.mean(np.abs(steps - usual) <= ALIKE_STEPS * usual)
    return bool(usual >= SPARSE * every and alike >= REGULAR)
