"""Where a sensor is out of range: clipped at a rail, or stuck at one value."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.clipping import BESIDE, CLIPPED
from suspid.cleaning.gaps import runs
from suspid.cleaning.sentinels import possible, without_sentinels
from suspid.levels import UNLIKELY
from suspid.recordings import RawChannel
from suspid.signals import roughness
from suspid.units import Flags, RealArray, Second

# A rail: values within this share of the range of the channel from its end, for electronics that add noise to it.
RAIL = 0.01
# A crest that is smooth to its top enters the rail by steps that follow from how long it stays there; a clipped one
# enters by larger ones. Twice as large: a crest of which only the third derivative matters comes to 1.5.
STEEPER = 2.0
# Steps of noise that occur once in ten thousand, over its standard deviation (root two times 3.9), and the spread over
# the converter's step up to which samples are alike.
THROWN, FLAT = 5.5, 3.0
# Median step beside a run, in those of the converter, below which repeats say nothing.
COARSE = 2.0
# Share of the values that last as many samples as the others, give or take one, in a channel that holds each of them.
# The runs of a coarse converter are long at a crest and short beside it.
ALIKE_LONG = 0.9


def clipped_times(channel: RawChannel) -> RealArray:
    """Return the stamps of all samples on a rail at which a channel is clipped [s]."""
    return np.asarray(channel.timepts[on_rail(unmarked(channel))])


def unmarked(channel: RawChannel) -> RealArray:
    """Return the samples of a channel, with NaN for those that a logger marks as missing by an impossible value.

    In another unit the marks would not be known any more.

    Examples
    --------
    >>> t = np.arange(50) / 10
    >>> values = np.where(t == 2.0, -9999.0, np.sin(t))
    >>> int(np.flatnonzero(np.isnan(unmarked(RawChannel(name="a", unit="g", timepts=t, values=values, rate=None))))[0])
    20
    """
    return without_sentinels(channel.name, channel.timepts, possible(channel.values))[0]


def stuck_times(channel: RawChannel, least: Second) -> RealArray:
    """Return the stamps of all samples at which a channel is stuck at one value [s].

    It is, in runs of one value that last ``least`` [s], and in shorter ones that chance does not explain: motion that
    goes on by some steps of the converter a sample repeats a value seldom. Channels that hold each value for some
    samples, as those of a slower bus do, are judged by the time alone.

    Examples
    --------
    >>> t = np.arange(6.0)
    >>> stuck_times(RawChannel(name="a", unit="", timepts=t, values=np.array([1.0, 2, 2, 2, 3, 4]), rate=None), 2.0)
    array([1., 2., 3.])
    """
    values = channel.values
    equal = np.diff(values) == 0
    first, after = runs(equal)
    if not first.size:
        return np.empty(0)
    long = channel.timepts[np.minimum(after, values.size - 1)] - channel.timepts[first] >= least
    if 2 * np.sum(equal) < values.size:
        steps = np.abs(np.diff(values))
        moved = steps[steps > 0]
        quantum = float(np.min(moved)) if moved.size else 0.0
        for i in np.flatnonzero(~long & (after - first >= 2)):
            long[i] = _beyond_chance(steps, int(first[i]), int(after[i]), quantum)
    inside = np.zeros(values.size, bool)
    for a, b in zip(first[long], after[long], strict=True):
        inside[a : b + 1] = True
    return np.asarray(channel.timepts[inside])


def _beyond_chance(steps: RealArray, first: int, after: int, quantum: float) -> bool:
    """Return whether a run of no steps is improbable beside steps as near it, in all of a record.

    Of normal steps whose median size is m, the share ``0.27 q / m`` is rounded to none by a converter of step q.
    """
    wide = max(BESIDE, after - first)
    near = np.concatenate([steps[max(0, first - wide) : first], steps[after : after + wide]])
    near = near[np.isfinite(near)]
    pace = float(np.median(near)) if near.size else 0.0
    if pace <= COARSE * quantum:
        return False
    return bool(steps.size * (0.27 * quantum / pace) ** (after - first) < UNLIKELY)


def on_rail(values: RealArray) -> Flags:
    """Return which samples of a channel lie on a rail at which it is clipped.

    A parabola whose depth changes by w over the n samples next to its top is entered by steps of up to
    ``4 w / n (1 + 1 / n)``. A rail is a zone at the end of the range that is entered or left by larger steps, in at
    least one run of three samples or more. The step of the converter and noise are allowed for. Where a slower bus
    holds each value for some samples, these count as one.

    Parameters
    ----------
    values : ndarray (sample,)
        The samples; NaN where missing.

    Examples
    --------
    >>> t = np.arange(4000) / 200
    >>> motion = np.sin(20 * t) * (1 + 0.3 * np.sin(3 * t))
    >>> int(np.sum(on_rail(motion))), bool(np.sum(on_rail(np.clip(motion, -9, 0.8))) > 500)
    (0, True)
    """
    firsts = _held_values(values)
    if firsts.size < values.size:
        return np.repeat(on_rail(values[firsts]), np.diff(firsts, append=values.size))
    found = np.zeros(values.size, bool)
    finite = values[np.isfinite(values)]
    reach = float(np.ptp(finite)) if finite.size >= CLIPPED else 0.0
    if not reach > 0:
        return found
    steps = np.abs(np.diff(finite))
    quantum = float(np.min(steps[steps > 0]))
    noise = THROWN * roughness(finite) if finite.size > CLIPPED else 0.0
    for depth in (float(np.max(finite)) - values, values - float(np.min(finite))):
        near: NDArray[np.bool_] = depth <= RAIL * reach  # False where missing
        first, after = runs(near)
        long = (after - first >= CLIPPED) & (first > 0) & (after < values.size)
        first, after = first[long], after[long]
        count = after - first
        width = np.array([np.ptp(depth[a:b]) for a, b in zip(first, after, strict=True)]) + quantum
        smooth = STEEPER * 4 * width / count * (1 + 1 / count) + quantum
        # Noise throws the samples of a crest in and out of the zone; samples that are alike are held by a rail.
        held = np.array([np.sum(depth[a:b] <= FLAT * quantum) for a, b in zip(first, after, strict=True)])
        smooth += np.where(held < CLIPPED, noise, 0.0)
        jumps = np.fmax(depth[first - 1] - depth[first], depth[after % values.size] - depth[after - 1])
        if np.any(jumps > np.maximum(smooth, RAIL * reach)):
            found |= near
    return found


def _held_values(values: RealArray) -> NDArray[np.intp]:
    """Return the samples with which the values of a channel begin, all of them where it does not hold its values.

    One that lasts longer than most begins again and again.
    """
    every = np.arange(values.size)
    begins = np.flatnonzero(np.diff(values, prepend=np.nan) != 0)
    lasts = np.diff(begins, append=values.size)
    usual = int(np.median(lasts)) if lasts.size else 1
    if usual < 2 or np.mean(np.abs(lasts - usual) <= 1) < ALIKE_LONG:
        return every
    since = every - np.repeat(begins, lasts)
    left = np.repeat(begins + lasts, lasts) - every
    return np.flatnonzero((since % usual == 0) & ((since == 0) | (left > usual // 2)))
