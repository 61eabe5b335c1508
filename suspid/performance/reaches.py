"""How far figures reach where parameters are uncertain and none of them can be negative.

The parameters lie with a probability in an ellipsoid about their values, ``d' S^-1 d <= r^2``. A mount that is as good
as rigid has a relaxation at its bound of zero: the half of the ellipsoid beyond it holds no car. The interval of a
figure with derivatives a is from the least to the largest ``a' d`` on the rest of the ellipsoid.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from suspid.levels import NORMAL_95
from suspid.units import Ratio, RealArray

# Bounds that are looked at together, the nearest ones: a full car has four mounts; each doubles the time.
MOST_BOUNDS = 8
# A parameter beyond its bound by less than this share of its standard deviation is at it: rounding.
AT_ZERO = 1e-9


def reaches(slopes: RealArray, covariance: RealArray, values: RealArray, reach: Ratio) -> tuple[RealArray, RealArray]:
    """Return how far figures reach below and above their values, (figure,); NaN where a derivative is.

    ``slopes`` are derivatives, (parameter, figure), ``values`` those of the parameters, which cannot be negative, and
    ``reach`` is in standard deviations.

    Examples
    --------
    A figure that is a parameter at its bound reaches upward only, one that does not depend on it both ways:

    >>> low, high = reaches(np.eye(2), np.eye(2), np.array([0.0, 9.0]), 2.0)
    >>> low.tolist(), high.tolist()
    ([0.0, 2.0], [2.0, 2.0])
    """
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    near = [i for i in np.argsort(values / np.maximum(std, np.finfo(float).tiny)) if values[i] < reach * std[i]]
    near = near[:MOST_BOUNDS]
    low, high = (_largest(sign * slopes, covariance, values, near, reach) for sign in (-1.0, 1.0))
    return low, high


def spreads(slopes: RealArray, covariance: RealArray, values: RealArray) -> RealArray:
    """Return standard deviations of figures, (figure,): half the width of intervals of 95 % over 1.96."""
    low, high = reaches(slopes, covariance, values, NORMAL_95)
    return (low + high) / (2 * NORMAL_95)


def _largest(a: RealArray, S: RealArray, values: RealArray, near: list[int], reach: Ratio) -> RealArray:
    """Return the largest ``a' d`` on the ellipsoid within bounds: the largest with some held there that is inside."""
    edge = -values[near] - AT_ZERO * np.sqrt(np.diag(S)[near])
    best = np.full(a.shape[1], -np.inf)
    for size in range(len(near) + 1):
        for held in map(list, combinations(near, size)):
            inverse = np.linalg.pinv(S[np.ix_(held, held)])
            left = reach**2 - float(values[held] @ inverse @ values[held])
            if left < 0:
                continue
            middle = -S[:, held] @ inverse @ values[held]
            toward = (S - S[:, held] @ inverse @ S[held]) @ a
            variance = np.maximum(np.sum(a * toward, axis=0), 0.0)
            d = middle[:, None] + toward * (left**0.5 / np.sqrt(np.maximum(variance, np.finfo(float).tiny)))
            inside = np.all(d[near] >= edge[:, None], axis=0)
            best = np.where(inside, np.maximum(best, np.sum(a * d, axis=0)), best)
    return np.where(np.isfinite(best), best, np.nan)
