"""Where a sensor is out of range: clipped at a rail, or stuck at one value."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning.clipping import CLIPPED
from suspid.cleaning.gaps import Flags, runs
from suspid.cleaning.inspection import possible, without_sentinels
from suspid.recordings import RawChannel
from suspid.units import RealArray, Second

# A rail: values within this share of the range of the channel from its end, for electronics that add noise to it.
RAIL = 0.01
# A crest that is smooth to its top enters the rail by steps that follow from how long it stays there; a clipped one
# enters by larger ones. Twice as large: a crest of which only the third derivative matters comes to 1.5.
STEEPER = 2.0


def clipped_times(channel: RawChannel) -> RealArray:
    """Return the stamps of all samples on a rail at which a channel is clipped [s]."""
    values = without_sentinels(channel.name, channel.timepts, possible(channel.values))[0]
    return np.asarray(channel.timepts[on_rail(values)])


def stuck_times(channel: RawChannel, least: Second) -> RealArray:
    """Return the stamps of all samples in runs of one value that last some time at least [s].

    Examples
    --------
    >>> t = np.arange(6.0)
    >>> stuck_times(RawChannel(name="a", unit="", timepts=t, values=np.array([1.0, 2, 2, 2, 3, 4]), rate=None), 2.0)
    array([1., 2., 3.])
    """
    first, after = runs(np.diff(channel.values) == 0)
    long = channel.timepts[np.minimum(after, channel.values.size - 1)] - channel.timepts[first] >= least
    inside = np.zeros(channel.values.size, bool)
    for a, b in zip(first[long], after[long], strict=True):
        inside[a : b + 1] = True
    return np.asarray(channel.timepts[inside])


def on_rail(values: RealArray) -> Flags:
    """Return which samples of a channel lie on a rail at which it is clipped.

    A parabola whose depth changes by w over the n samples next to its top is entered by steps of up to
    ``4 w / n (1 + 1 / n)``. A rail is a zone at the end of the range that is entered or left by larger steps, in at
    least one run of three samples or more. The step of the converter is allowed for.

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
    found = np.zeros(values.size, bool)
    finite = values[np.isfinite(values)]
    reach = float(np.ptp(finite)) if finite.size >= CLIPPED else 0.0
    if not reach > 0:
        return found
    steps = np.abs(np.diff(finite))
    quantum = float(np.min(steps[steps > 0]))
    for depth in (float(np.max(finite)) - values, values - float(np.min(finite))):
        near: NDArray[np.bool_] = depth <= RAIL * reach  # False where missing
        first, after = runs(near)
        long = (after - first >= CLIPPED) & (first > 0) & (after < values.size)
        first, after = first[long], after[long]
        count = after - first
        width = np.array([np.ptp(depth[a:b]) for a, b in zip(first, after, strict=True)]) + quantum
        smooth = STEEPER * 4 * width / count * (1 + 1 / count) + quantum
        jumps = np.fmax(depth[first - 1] - depth[first], depth[after % values.size] - depth[after - 1])
        if np.any(jumps > np.maximum(smooth, RAIL * reach)):
            found |= near
    return found
