"""Speeds that a logger holds: satellites and buses send one value now and then, and faster loggers repeat it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.recordings import RawChannel
from suspid.units import Ratio

# Runs of equal values that are compared: chance makes fewer of them alike.
FEWEST_RUNS = 10
SHORTEST_RUN = 1.5  # samples: values that are not repeated are not held
# Share of the runs that are shorter than the period or as long: the others hold a value that was sent several times.
SHORT_RUNS: Ratio = 0.2
# Deviation of runs from multiples of the period, and share of runs that keep to it: a clock jitters by a few percent,
# and of runs that rounding makes a fifth would keep to it.
HELD_JITTER: Ratio = 0.1
REGULAR_SHARE: Ratio = 0.9


def released(channel: RawChannel) -> RawChannel:
    """Return a channel with each value that was held once, when it came; one that holds none as it is.

    The mean of a held value over the time that it is held is late by half of it, and changes in steps.

    Examples
    --------
    >>> t = np.arange(0, 20, 0.1)
    >>> held = RawChannel(name="speed", unit="m/s", timepts=t, values=np.floor(t + 1e-9), rate=None)
    >>> released(held).timepts[:4].round(6).tolist(), released(held).values[:4].tolist()
    ([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0])
    """
    good = np.flatnonzero(np.isfinite(channel.timepts) & np.isfinite(channel.values))
    good = good[np.argsort(channel.timepts[good], kind="stable")]
    t, v = channel.timepts[good], channel.values[good]
    starts = np.flatnonzero(np.diff(v, prepend=np.nan) != 0)
    if len(starts) <= FEWEST_RUNS:
        return channel
    runs = np.diff(t[starts])
    period = float(np.quantile(runs, SHORT_RUNS))
    if not period > SHORTEST_RUN * float(np.median(np.diff(t))):
        return channel
    sent = np.maximum(np.rint(runs / period), 1)
    if np.mean(np.abs(runs / period - sent) <= HELD_JITTER) < REGULAR_SHARE:
        return channel
    many = sent.astype(int)
    within = np.arange(np.sum(many)) - np.repeat(np.cumsum(many) - many, many)
    times = np.repeat(t[starts[:-1]], many) + within * np.repeat(runs / many, many)
    return replace(
        channel,
        timepts=np.append(times, t[starts[-1]]),
        values=np.append(np.repeat(v[starts[:-1]], many), v[starts[-1]]),
    )
