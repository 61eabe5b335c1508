"""Encoders that write a row whenever they count on: their motion between the rows, on a uniform clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.cleaning.nearest import mean_step
from suspid.recordings import RawChannel
from suspid.values import frozen_real
from suspid.words import Defect, Number

# Rows from which on an encoder is told from a sensor whose samples change by chance.
FEWEST_COUNTS = 100
# Every row is one count from the last, but for this share: counts that were lost. Counts are whole to a share of one.
LOST, WHOLE = 0.01, 0.02
# Rows come at the pace of the motion: the longest twentieth of the steps is this many times the shortest, at least.
UNEVEN = 4.0


def evenly(channels: Sequence[RawChannel]) -> tuple[list[RawChannel], list[Finding]]:
    """Return channels with those that were written on change on a uniform clock, and the findings that say so.

    A row says when an angle passes the boundary between two counts, and until the next row it lies between the
    boundaries of its count: it is interpolated within them.

    Examples
    --------
    >>> fine = np.arange(0, 6, 1e-5)
    >>> counts = np.round(40 * np.exp(-0.3 * fine) * np.cos(8 * fine))
    >>> rows = np.flatnonzero(np.diff(counts, prepend=counts[0]))
    >>> arm = RawChannel(name="arm", unit="", timepts=fine[rows], values=counts[rows], rate=None)
    >>> (even,), (finding,) = evenly([arm])
    >>> off = even.values - 40 * np.exp(-0.3 * even.timepts) * np.cos(8 * even.timepts)
    >>> finding.kind.value, bool(np.max(np.abs(off)) < 0.5), bool(np.sqrt(np.mean(off**2)) < 0.1)
    ('written on change', True, True)
    """
    shared = Counter(id(channel.timepts) for channel in channels)
    out, findings = [], []
    for channel in channels:
        count = None if shared[id(channel.timepts)] > 1 or channel.rate is not None else _count(channel)
        if count is None:
            out.append(channel)
            continue
        even = _evenly(channel, count)
        numbers: dict[str, Number] = {"count": count, "rate": 1 / float(even.timepts[1] - even.timepts[0])}
        findings.append(found(Defect.ON_CHANGE, channel.timepts, channel.values.size, numbers, channel=channel.name))
        out.append(even)
    return out, findings


def _count(channel: RawChannel) -> float | None:
    """Return what a row is from the next where each is one count on or back, and rows come unevenly; else None."""
    times, values = channel.timepts, channel.values
    if values.size < FEWEST_COUNTS or not (np.all(np.isfinite(values)) and np.all(np.diff(times) > 0)):
        return None
    changes = np.abs(np.diff(values))
    count = float(np.median(changes))
    if not count > 0 or np.min(changes) < (1 - WHOLE) * count:
        return None
    counts = changes / count
    lost = counts > 1 + WHOLE
    short, long = np.quantile(np.diff(times), (0.05, 0.95))
    whole = np.max(np.abs(counts - np.round(counts))) < WHOLE
    return count if whole and np.mean(lost) <= LOST and long > UNEVEN * short else None


def _evenly(channel: RawChannel, count: float) -> RawChannel:
    """Return a channel on a uniform clock: it passes the boundaries of its counts when its rows say."""
    from scipy.interpolate import Akima1DInterpolator

    times, values = channel.timepts, channel.values
    step = mean_step(np.diff(times))
    even = times[1] + step * np.arange(int((times[-1] - times[1]) / step) + 1)
    passed = 0.5 * (values[1:] + values[:-1])
    held = values[np.searchsorted(times, even, side="right") - 1]
    between = np.asarray(Akima1DInterpolator(times[1:], passed, method="makima")(even))
    return replace(
        channel, timepts=frozen_real(even), values=frozen_real(np.clip(between, held - count / 2, held + count / 2))
    )
