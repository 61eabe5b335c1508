"""Long recordings on uniform clocks, with what is missing left open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.findings import Finding
from suspid.cleaning.gaps import fill
from suspid.cleaning.joining import by_clock, one_clock, placed
from suspid.errors import RecordError
from suspid.recordings import RawChannel
from suspid.units import RealArray, Second

# A pause of the logger this long parts a recording [s]: no stretch goes over it, and the clocks on both sides need not
# agree.
PAUSE: Second = 5.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Aligned:
    """A part of a recording on one uniform clock.

    Parameters
    ----------
    timepts : ndarray (sample,)
        The clock [s].
    step : float
        Its step [s].
    channels : tuple of str
        Names of the channels.
    values : ndarray (channel, sample)
        Samples, those of short gaps interpolated; NaN where more is missing.
    filled : ndarray (channel, sample)
        Which samples were interpolated.
    findings : tuple of Finding
        Defects of stamps and channels.
    """

    timepts: RealArray
    step: Second
    channels: tuple[str, ...]
    values: RealArray
    filled: NDArray[np.bool_]
    findings: tuple[Finding, ...]


def aligned(channels: Sequence[RawChannel]) -> Aligned:
    """Return channels on the fastest of their clocks, without refusing what is missing.

    As `clean`, but gaps that are too long to fill stay NaN, and nothing is cut off or left out.

    Raises
    ------
    RecordError
        If the stamps make no clock, or the channels share no time.

    Examples
    --------
    >>> t = np.arange(300) / 100
    >>> values = np.sin(12 * t)
    >>> values[40], values[100:200] = np.nan, np.nan
    >>> part = aligned([RawChannel(name="seat", unit="m", timepts=t, values=values, rate=None)])
    >>> bool(abs(part.values[0, 40] - np.sin(12 * 0.4)) < 0.01), int(np.sum(np.isnan(part.values)))
    (True, 100)
    """
    whole, findings = one_clock([placed(group, None) for group in by_clock(list(channels))], by_name=True)
    order = [whole.names.index(channel.name) for channel in channels]
    values, filled = whole.values[order], np.zeros((len(order), whole.timepts.size), bool)
    if np.any(np.isnan(values)):
        better = [fill(c.name, whole.timepts, row) for c, row in zip(channels, values, strict=True)]
        filled = np.array([np.isnan(row) & ~np.isnan(b.values) for row, b in zip(values, better, strict=True)])
        values = np.array([b.values for b in better])
        findings = [*findings, *(finding for b in better for finding in b.findings)]
    return Aligned(
        timepts=whole.timepts,
        step=whole.step,
        channels=tuple(channel.name for channel in channels),
        values=values,
        filled=filled,
        findings=tuple(findings),
    )


def parts_of(channels: Sequence[RawChannel]) -> list[list[RawChannel]]:
    """Return the channels in parts between pauses of the logger.

    Examples
    --------
    >>> t = np.concatenate([np.arange(100), np.arange(2000, 2100)]) / 100
    >>> [len(part[0].values) for part in parts_of([RawChannel(name="a", unit="", timepts=t, values=t, rate=None)])]
    [100, 100]
    """
    most = max(channels, key=lambda channel: channel.timepts.size)
    stamps = np.sort(most.timepts[np.isfinite(most.timepts)])
    if not stamps.size:
        raise RecordError(f"channel {most.name!r} has no time stamps")
    at = np.flatnonzero(np.diff(stamps) > PAUSE)
    if not at.size:
        return [list(channels)]
    ends = [-np.inf, *(0.5 * (stamps[at] + stamps[at + 1])), np.inf]
    parts = []
    for low, high in pairwise(ends):
        # One array of stamps stays one array, so that the channels of a clock are known to be of one.
        stamps_of: dict[int, tuple[RealArray, NDArray[np.bool_]]] = {}
        part = []
        for channel in channels:
            if id(channel.timepts) not in stamps_of:
                inside = (channel.timepts > low) & (channel.timepts <= high)
                stamps_of[id(channel.timepts)] = channel.timepts[inside], inside
            times, inside = stamps_of[id(channel.timepts)]
            part.append(replace(channel, timepts=times, values=channel.values[inside]))
        parts.append(part)
    return parts
