"""Channels that repeat one value from some time on to their end: the sensor or its logger has stopped."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

# Equal samples at the end, at least, and samples before that tell the noise.
FEWEST_EQUAL, TELL_NOISE = 20, 200
# The noise is this many of the least steps between samples, at least: of one that is held by friction, what rounding
# leaves is smaller. Second differences of noise alone have a correlation of -2/3, those of a smooth motion a positive
# one. Of samples of a noisy channel, this share at most repeats the one before.
STEPS_OF_NOISE, OF_NOISE, REPEAT = 2.0, -0.4, 0.02


def stopped_at(samples: RealArray) -> int:
    """Return the sample from which on a noisy channel repeats one value, the number of samples where none does.

    Examples
    --------
    >>> noise = np.random.default_rng(1).standard_normal(400)
    >>> swing = np.sin(0.1 * np.arange(400))
    >>> frozen = np.where(np.arange(400) < 300, swing + 0.01 * noise, 0.5)
    >>> held = np.where(np.arange(400) < 300, swing.round(2), swing[300].round(2))
    >>> stopped_at(frozen), stopped_at(held), stopped_at(swing)
    (300, 400, 400)
    """
    size = samples.size
    changes = np.flatnonzero(samples[1:] != samples[:-1])
    first = int(changes[-1]) + 1 if changes.size else 0
    if size - first < FEWEST_EQUAL or first < TELL_NOISE // 2 or changes.size < (1 - REPEAT) * first:
        return size
    bends = np.diff(samples[max(0, first - TELL_NOISE) : first], n=2)
    steps = np.abs(np.diff(samples[: first + 1]))
    # Of noise of any size, some steps are far smaller than itself; of that of rounding, none.
    coarse = np.std(bends) / np.sqrt(6) < STEPS_OF_NOISE * np.min(steps[steps > 0])
    return size if coarse or np.corrcoef(bends[1:], bends[:-1])[0, 1] > OF_NOISE else first
