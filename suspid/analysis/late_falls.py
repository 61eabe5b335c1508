"""Swings that fall more later on than at first, or grow again: of what is driven by less and less, and of a beat."""

from __future__ import annotations

import numpy as np

from suspid.analysis.shrinking import TURNS_ABOVE_NOISE, noise_of_samples
from suspid.analysis.swings import AT_REST, turns_of
from suspid.identification import Identification
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import RealArray

# Swings that are needed, from the largest on, and the largest share of it that the last may have: where less is seen to
# fall, drifts decide.
FEWEST_SWINGS, MUCH_LEFT = 9, 0.5
# How much more the swings may fall in the middle or in the last third of them than in the first: friction lets them
# fall alike, and by a third more where it grows as a mass slows down. How much larger than before they may be.
FALLS_LATER, GROWS_AGAIN = 1.6, 1.5


def falls_late(found: Identification) -> bool:
    """Return whether the swings of a single mode fall more later on than at first, or grow, in its clearest channel.

    Those of a free motion fall most at first, or by the same amount each time where Coulomb friction alone acts.

    Examples
    --------
    >>> from suspid import identify
    >>> from suspid.records import as_response
    >>> t = np.arange(0, 10, 0.01)
    >>> free, beat = np.exp(-0.2 * t) * np.sin(9 * t), np.cos(0.15 * t) * np.sin(9 * t)
    >>> [falls_late(identify(as_response(t, y[None], ["seat"]))) for y in (free, beat)]
    [False, True]
    """
    if len(found.modes) != 1 or not found.modes.poles[0].imag:
        return False
    values = as_signal(held(found, "response")).values
    return _falls_late(values[int(np.argmax(found.explained))])


def _falls_late(samples: RealArray) -> bool:
    turns = turns_of(samples, max(AT_REST * float(np.ptp(samples)), TURNS_ABOVE_NOISE * noise_of_samples(samples)))
    sizes = np.abs(np.diff(samples[turns]))
    sizes = sizes[int(np.argmax(sizes)) :] if sizes.size else sizes
    if len(sizes) < FEWEST_SWINGS:
        return False
    third = len(sizes) // 3
    near = max(2, third // 4)
    starts = (0, third - near // 2, 2 * third - near // 2, len(sizes) - near)
    borders = np.array([sizes[start : start + near].mean() for start in starts])
    if np.any(borders[1:] > GROWS_AGAIN * borders[:-1]):
        return True
    if borders[-1] > MUCH_LEFT * borders[0]:
        return False
    first, *later = (-np.diff(borders)).tolist()
    return bool(max(later) > FALLS_LATER * first)
