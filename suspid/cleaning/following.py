"""Following: whether samples follow stamps that stray, or were taken regularly and stamped late."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.stamps import Indices
from suspid.units import RealArray, Second
from suspid.words import Defect, Number

# Share of the way that samples must follow their stamps to count as taken then, and the number of standard deviations
# by which it must differ from none. Between 0 (late stamps) and 1 (irregular sampling) the first leans towards
# irregular sampling, whose repair costs little; the second keeps noise from deciding.
FOLLOWED, SIGNIFICANT = 0.3, 4.0
# Samples used at most; more would not change the decision.
ENOUGH = 200_000


def late_or_irregular(
    values: RealArray, places: Indices, step: Second, off: RealArray
) -> tuple[Defect, dict[str, Number]]:
    """Return whether stamps that stray by less than half a step are late or the samples irregular, with numbers.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    places : ndarray (row,)
        Places of the rows in the grid.
    step : float
        Step of the grid [s].
    off : ndarray (row,)
        Stamps less their times in the grid [s].
    """
    share, std = share_followed(values, off / step, places)
    sigma = float(np.sqrt(np.mean(off**2)))
    largest = float(np.max(np.abs(off)))
    numbers: dict[str, Number] = {"followed": share, "followed_std": std}
    if share > max(SIGNIFICANT * std, FOLLOWED):
        return Defect.IRREGULAR_STAMPS, {**numbers, "largest": largest / step}
    pace = np.diff(values, axis=1)
    speed = np.sqrt(_mean(pace**2, np.isfinite(pace), axis=1)) / step * sigma
    there = np.isfinite(values)
    about = values - _mean(values, there, axis=1)[:, None]
    motion = np.sqrt(_mean(about**2, there, axis=1))
    error = float(np.max(speed / np.where(motion > 0, motion, np.inf)))
    return Defect.JITTERING_STAMPS, {**numbers, "largest": largest, "rms": sigma, "rate": 1 / step, "error": error}


def share_followed(values: RealArray, off: RealArray, places: Indices) -> tuple[float, float]:
    """Return how far the samples follow the stamps off the grid, 0 not at all and 1 all the way, and its std.

    The cubic through two neighbours on each side misses a sample of a smooth motion by its slope times the distance
    of its time from those of its neighbours; the regression on that distance is the share. In noise it tends to zero.

    Parameters
    ----------
    values : ndarray (channel, row)
        The samples.
    off : ndarray (row,)
        Stamps less their places in the grid [steps].
    places : ndarray (row,)
        Places in the grid; only where five follow each other is anything counted.
    """
    whole = np.flatnonzero(places[4:] - places[:-4] == 4)
    whole = whole[:: max(1, whole.size // ENOUGH)]
    before, last, now, after, second = (values[:, whole + k] for k in range(5))
    missed = now - (4 * (last + after) - before - second) / 6
    slope = (8 * (after - last) - (second - before)) / 12
    lead = off[whole + 2] - (4 * (off[whole + 1] + off[whole + 3]) - off[whole] - off[whole + 4]) / 6
    known = np.isfinite(missed)
    size = np.sqrt(_mean(missed**2, known, axis=1))[:, None]
    usable = known & (size > 0)
    missed = np.where(usable, missed, 0.0) / np.where(size > 0, size, 1.0)
    expected = np.where(usable, slope * lead, 0.0) / np.where(size > 0, size, 1.0)
    power = float(np.sum(expected**2))
    if not power > 0:
        return 0.0, np.inf
    share = float(np.sum(missed * expected)) / power
    # Neighbouring misses share samples, which counts twice at most.
    return share, float(np.sqrt(2 * np.sum((expected * (missed - share * expected)) ** 2))) / power


def _mean(values: RealArray, known: NDArray[np.bool_], *, axis: int) -> RealArray:
    """Return the mean of what is known; 0 where nothing is."""
    return np.asarray(np.where(known, values, 0.0).sum(axis=axis) / np.maximum(known.sum(axis=axis), 1))
