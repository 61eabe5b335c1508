"""Intervals of figures for uncertain parameters that cannot be negative.

The parameters lie with a probability in an ellipsoid about their values, ``d' S^-1 d <= r^2``; a figure's interval is
from its least to its largest value there. A mount that is as good as rigid has a relaxation at its bound of zero, and
beyond it there is no car. Then the interval is the union of that of the cars within the bounds and of those with any of
the mounts rigid that the records do not rule out: given a rigid mount, the other parameters are known better. Figures
bend with a relaxation that is as uncertain as it is large, so its second derivatives count.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations

import numpy as np

from suspid.levels import EXACT, MOST_BOUNDS, NORMAL_95
from suspid.model import Suspension
from suspid.performance.uncertain import RELAXATION, Uncertain
from suspid.units import Ratio, RealArray, Second

# Standard deviations from its bound up to which a parameter has second derivatives: intervals of 99.7 % reach it.
BENT_WITHIN = 3.0


def reaches(
    slopes: RealArray, covariance: RealArray, values: RealArray, reach: Ratio, bends: RealArray | None = None
) -> tuple[RealArray, RealArray]:
    """Return how far figures reach below and above their values, (figure,); NaN where a derivative is.

    ``slopes`` are derivatives, (parameter, figure), ``bends`` second ones, (figure, parameter, parameter), ``values``
    those of the parameters, which cannot be negative, and ``reach`` is in standard deviations.

    Examples
    --------
    A figure that is a parameter at its bound reaches upward only, one that does not depend on it both ways:

    >>> low, high = reaches(np.eye(2), np.eye(2), np.array([0.0, 9.0]), 2.0)
    >>> low.tolist(), high.tolist()
    ([0.0, 2.0], [2.0, 2.0])
    """
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    near = _near(values, std, reach)
    sides = [
        _farthest(sign * slopes, covariance, values, near, reach, None if bends is None else sign * bends)
        for sign in (-1.0, 1.0)
    ]
    return sides[0], sides[1]


def spreads(slopes: RealArray, covariance: RealArray, values: RealArray, bends: RealArray | None = None) -> RealArray:
    """Return standard deviations of figures, (figure,): half the width of intervals of 95 % over 1.96."""
    low, high = reaches(slopes, covariance, values, NORMAL_95, bends)
    return (low + high) / (2 * NORMAL_95)


def bends_of(
    about: Uncertain, figures: int, jacobian: Callable[[Suspension, Mapping[str, Second]], RealArray]
) -> RealArray:
    """Return second derivatives of figures, (figure, parameter, parameter), by parameters near their bound; else 0.

    ``jacobian`` returns the first ones, (figure, parameter), of a car with relaxations of mounts; the second ones are
    differences over two standard deviations, as far as there are cars.
    """
    std = np.sqrt(np.maximum(np.diag(about.covariance), 0.0))
    bends = np.zeros((figures, len(std), len(std)))
    bent: dict[int, RealArray] = {}
    for j in _near(about.values, std, BENT_WITHIN):
        # A mount may be rigid; a car without a spring, damper or mass is another one.
        least = 0.0 if about.parameters[j].endswith(RELAXATION) else float(about.values[j]) / 2
        ends = max(float(about.values[j] - std[j]), least), float(about.values[j] + std[j])
        rows = [jacobian(*about.at({about.parameters[j]: value})) for value in ends]
        # What a car at an end lacks, as a least phase, does not bend.
        bent[j] = np.nan_to_num((rows[1] - rows[0]) / (ends[1] - ends[0]))
        bends[:, j], bends[:, :, j] = bent[j], bent[j]
    for j in bent:
        for k in bent:
            bends[:, j, k] = (bent[j][:, k] + bent[k][:, j]) / 2
    return bends


def _near(values: RealArray, std: RealArray, reach: Ratio) -> list[int]:
    """Return which parameters are less than ``reach`` standard deviations above zero, their bound, nearest first."""
    close = np.flatnonzero(values < reach * std)
    return [int(i) for i in close[np.argsort(values[close] / std[close])]][:MOST_BOUNDS]


def _farthest(
    a: RealArray, S: RealArray, values: RealArray, near: list[int], reach: Ratio, bends: RealArray | None
) -> RealArray:
    """Return the largest ``a' d + d' bends d / 2``, (figure,): among the ends with some bounds held those inside."""
    edge = -values[near] - EXACT * np.sqrt(np.diag(S)[near])
    best = np.where(np.isnan(a).any(axis=0), np.nan, 0.0)
    for size in range(len(near) + 1):
        for held in map(list, combinations(near, size)):
            inverse = np.linalg.pinv(S[np.ix_(held, held)])
            left = reach**2 - float(values[held] @ inverse @ values[held])
            if left < 0:
                continue
            middle = -S[:, held] @ inverse @ values[held]
            toward = (S - S[:, held] @ inverse @ S[held]) @ a
            toward[held] = 0.0
            variance = np.sum(a * toward, axis=0)
            # Where nothing is left that moves a figure there is rounding.
            moves = variance > EXACT**2 * np.sum(a * (S @ a), axis=0)
            toward = np.where(moves, toward / np.sqrt(np.where(moves, variance, 1.0)), 0.0)
            # As far as for a car that is known to have these bounds, and as far as the region goes along them.
            for radius in (reach, np.sqrt(left)) if held else (reach,):
                d = middle[:, None] + toward * radius
                moved = _moved(a, bends, d)
                # Of a curved figure the end that is farthest to first order need not be.
                best = np.where(np.all(d[near] >= edge[:, None], axis=0) & (moved > best), moved, best)
    return best


def _moved(a: RealArray, bends: RealArray | None, d: RealArray) -> RealArray:
    """Return how far figures move on the way to an end, at most: one that turns on the way is farthest there."""
    moved = np.asarray(np.sum(a * d, axis=0))
    if bends is None:
        return moved
    bent = np.einsum("pf,fpq,qf->f", d, bends, d) / 2
    turns = -2 * bent > moved
    share = np.where(turns, moved / np.where(turns, -2 * bent, 1.0), 1.0)
    return np.asarray(np.where(moved > 0, share * moved + share**2 * bent, moved + bent))
