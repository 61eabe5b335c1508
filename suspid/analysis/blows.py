"""Blows: what a channel measures of a hammer, or of another force that lasts for a moment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.units import RealArray

# A channel of blows is above this share of its largest value in one of this many samples, at most: a longer pulse may
# be a motion that is damped before it swings.
OF_LARGEST, ONE_OF = 0.1, 100
# A motion goes both ways, a force pushes one way: the other way by this share of its largest value at most. A mode that
# goes no further is damped by more than 0.59.
OTHER_WAY = 0.1
# What a blow sets in motion is that large for this many times as many samples.
LASTS = 10
# A hammer that bounces hits again. More pulses are a motion that is small beside its noise, or traffic.
MOST_BLOWS = 4


def blows_of(values: RealArray) -> NDArray[np.intp]:
    """Return how many blows each channel measures, (channel,); 0 where it is a motion.

    A force that acts for a moment says nothing of the modes that it excites. Some other channel must go on.

    Examples
    --------
    >>> t = np.arange(2000) / 1000
    >>> force = np.where(t < 0.004, 50.0, 0.0)
    >>> blows_of(np.stack([np.exp(-3 * t) * np.sin(40 * t), force]))
    array([0, 1])
    """
    about = values - np.median(values, axis=1, keepdims=True)
    most, least = np.max(about, axis=1), -np.min(about, axis=1)
    largest, other = np.maximum(most, least), np.minimum(most, least)
    above = np.abs(about) > OF_LARGEST * largest[:, None]
    times = np.sum(above, axis=1)
    number = np.sum(np.diff(above, axis=1, prepend=False) & above, axis=1)
    rare = (times * ONE_OF <= values.shape[1]) & (times * LASTS <= np.max(times, initial=0))
    return np.where(rare & (number > 0) & (number <= MOST_BLOWS) & (other <= OTHER_WAY * largest), number, 0)
