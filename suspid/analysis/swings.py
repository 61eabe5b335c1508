"""Swings that are seen in a record between two rests: a body that was held, let go, and came to rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.model import ModalSet
from suspid.signals import as_signal, roughness
from suspid.units import RealArray, Second

if TYPE_CHECKING:
    import control

# A body rests while it moves by less than this share of the range of its motion; smaller swings are not counted.
AT_REST = 0.05
# Periods of rest that are needed after the motion, and before it: what is driven does not stop twice by chance.
RESTS_AFTER, RESTS_BEFORE = 1.0, 0.25
# Swings that each are smaller than the one before. Of as many numbers in any order one in 120 is.
LEAST_SWINGS = 5
# The times of the swings are alike to this share: friction moves the middle of a swing, not its time.
EVEN_SWINGS = 0.15
# A mode makes swings if it takes their time to this share.
SAME_TIME = 0.1
# A swing is larger than this many standard deviations of the noise: in thousands of samples noise turns by seven.
TURNS_ABOVE_NOISE = 8.0


def shown_by_swings(record: control.TimeResponseData, modes: ModalSet) -> NDArray[np.bool_]:
    """Return which modes a record shows by its swings, (mode,): at once, and without a fit.

    A channel rests, swings by less each time, in equal times, and rests again. Friction lets swings fall along a line,
    and may end them away from their middle, which no sum of modes does; their time is that of the mode.

    Examples
    --------
    >>> from suspid.records import as_response
    >>> from suspid.simulation import free_decay
    >>> t = np.arange(0, 12, 0.01)
    >>> s = np.clip(t - 1, 0, 8)
    >>> y = (1 - s / 8) * np.cos(2 * np.pi * s)
    >>> modes = ModalSet.from_wn_zeta(np.array([6.3, 9.0]), np.array([0.05, 0.05]))
    >>> shown_by_swings(as_response(t, y[None], ["seat"]), modes)
    array([ True, False])
    """
    signal = as_signal(record)
    shown = np.zeros(len(modes), bool)
    for samples in signal.values:
        time = _time_of_swings(samples, signal.step)
        if time is not None:
            shown |= np.abs(np.pi / time / np.abs(modes.poles.imag).clip(1e-300) - 1) < SAME_TIME
    return shown


def _time_of_swings(samples: RealArray, step: Second) -> Second | None:
    """Return the time of a swing, half a period, of samples that swing between two rests; None if they do not."""
    least = AT_REST * float(np.ptp(samples))
    if not least > 0:
        return None
    turns = turns_of(samples, least)
    if len(turns) < LEAST_SWINGS:
        return None
    sizes, times = np.abs(np.diff(samples[turns])), np.diff(turns)
    # A body that is let go leaves its place slowly: the first swing begins when it is seen.
    usual = float(np.median(times))
    if len(sizes) < LEAST_SWINGS - 1 or np.any(np.diff(sizes) >= 0) or np.any(np.abs(times / usual - 1) > EVEN_SWINGS):
        return None
    before, after = samples[: max(2, int(2 * usual * RESTS_BEFORE))], samples[-max(2, int(2 * usual * RESTS_AFTER)) :]
    rests = all(np.ptp(part) < least for part in (before, after))
    return usual * step if rests else None


def turns_above_noise(samples: RealArray, size: float) -> NDArray[np.intp]:
    """Return where samples turn back by a share of a size, and by more than noise does.

    Examples
    --------
    >>> t = np.arange(3000) / 1000
    >>> noisy = np.sin(2 * np.pi * t) + 0.05 * np.random.default_rng(1).standard_normal(3000)
    >>> len(turns_of(noisy, AT_REST * 2.0)), len(turns_above_noise(noisy, 2.0))
    (649, 6)
    """
    return turns_of(samples, least_turn(samples, size))


def least_turn(samples: RealArray, size: float) -> float:
    """Return by how much samples turn back at least where that is no noise, and no less than a share of a size.

    Examples
    --------
    >>> least_turn(np.sin(np.arange(1000.0) / 100), 2.0)
    0.1
    """
    return max(AT_REST * size, TURNS_ABOVE_NOISE * roughness(samples))


def turns_of(samples: RealArray, least: float) -> NDArray[np.intp]:
    """Return where samples turn back by a size, up and down in turn.

    Examples
    --------
    >>> turns_of(np.array([0.0, 1.0, 3.0, 2.9, 0.5, 0.6, -1.0, 2.0]), 1.0)
    array([2, 6])

    Of crests of one size, as a coarse step makes them, the first:

    >>> turns_of(np.array([0.0, 3.0, 2.9, 3.0, 0.0]), 1.0)
    array([1])
    """
    from scipy.signal import find_peaks

    # Where a turn rests, its first sample.
    tops, lows = (find_peaks(side * samples, prominence=least, plateau_size=1)[1]["left_edges"] for side in (1.0, -1.0))
    order = np.argsort(np.concatenate([tops, lows]), kind="stable")
    # Turns to one side that follow one another are as far out, and one swing.
    to_other_side = np.diff((order < len(tops)).astype(int), prepend=-1) != 0
    return np.asarray(np.concatenate([tops, lows])[order][to_other_side])
