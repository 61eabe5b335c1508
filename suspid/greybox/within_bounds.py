"""Intervals of parameters of which some are at a bound or near one: by the profile of the likelihood within the bounds.

To first order minus twice the logarithm of the likelihood is ``(p - u)' S^-1 (p - u)``, with u the parameters of least
misfit if there were no bounds. An interval holds all values of a parameter for which some car within the bounds is
less likely than the most likely one by ``reach^2`` at most. Where another parameter is at its bound, as a mount that is
as good as rigid, that is the half of the interval without bounds that cars have, and its distribution is half normal
(S. G. Self and K.-Y. Liang, J. Am. Stat. Assoc. 82 (1987) 605-610).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from suspid.levels import EXACT, MOST_BOUNDS
from suspid.units import Flags, Ratio, RealArray


def ends_within(
    center: RealArray, covariance: RealArray, lower: RealArray, upper: RealArray, reach: Ratio
) -> tuple[RealArray, RealArray]:
    """Return the lower and upper ends of all parameters between bounds, ``reach`` in standard deviations.

    Examples
    --------
    A parameter whose mate cannot be negative, and would be by one standard deviation, is known better on one side:

    >>> shared = np.array([[1.0, -0.8], [-0.8, 1.0]])
    >>> ends = ends_within(np.array([0.8, -1.0]), shared, np.array([-np.inf, 0.0]), np.full(2, np.inf), 2.0)
    >>> [end.round(2).tolist() for end in ends]
    [[-1.44, 0.0], [1.2, 1.24]]
    """
    near = _near(center, covariance, lower, upper, reach)
    slices = list(_slices(center, covariance, near))
    inside = [part.misfit for part in slices if _all_inside(part.middle[:, None], near, covariance)[0]]
    least = min(inside, default=0.0)
    low, high = np.full(len(center), np.inf), np.full(len(center), -np.inf)
    for part in slices:
        room = least + reach**2 - part.misfit
        if room < 0:
            continue
        std = np.sqrt(np.maximum(np.diag(part.covariance), 0.0))
        toward = part.covariance * (np.sqrt(room) / np.where(std > 0, std, 1.0))
        for sign in (-1.0, 1.0):
            points = part.middle[:, None] + sign * toward
            end = np.diag(points)
            kept = _all_inside(points, near, covariance)
            low, high = np.where(kept & (end < low), end, low), np.where(kept & (end > high), end, high)
    return low, high


class _Bound(NamedTuple):
    at: int  # parameter
    value: float
    side: float  # +1 for a lower bound


class _Slice(NamedTuple):
    """The parameters with some of them at bounds: the likeliest, how unlikely they are, and the rest's covariance."""

    middle: RealArray
    misfit: float
    covariance: RealArray


def _near(center: RealArray, covariance: RealArray, lower: RealArray, upper: RealArray, reach: Ratio) -> list[_Bound]:
    """Return the bounds that intervals may meet, nearest first."""
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if not np.all(np.isfinite(covariance)):
        return []
    every = [
        (side * (center[i] - ends[i]) / std[i], _Bound(int(i), float(ends[i]), side))
        for ends, side in ((lower, 1.0), (upper, -1.0))
        for i in np.flatnonzero(np.isfinite(ends) & (std > 0))
    ]
    beyond = float(np.sqrt(sum(min(away, 0.0) ** 2 for away, _ in every)))
    close = [(away, bound) for away, bound in every if away < reach + beyond]
    return [bound for _, bound in sorted(close, key=lambda pair: pair[0])][:MOST_BOUNDS]


def _slices(center: RealArray, covariance: RealArray, near: list[_Bound]) -> Iterator[_Slice]:
    """Yield the parameters with any of the bounds that are near held."""
    yield _Slice(center, 0.0, covariance)
    for size in range(1, len(near) + 1):
        for held in combinations(near, size):
            at = [bound.at for bound in held]
            if len(set(at)) < size:
                continue
            inverse = np.linalg.pinv(covariance[np.ix_(at, at)], hermitian=True)
            off = np.array([bound.value for bound in held]) - center[at]
            onto = covariance[:, at] @ inverse
            left = covariance - onto @ covariance[at]
            left[at], left[:, at] = 0.0, 0.0
            middle = center + onto @ off
            middle[at] = [bound.value for bound in held]
            yield _Slice(middle, float(off @ inverse @ off), left)


def _all_inside(points: RealArray, near: list[_Bound], covariance: RealArray) -> Flags:
    """Return which points (parameter, point) are within the bounds that are near, but for rounding."""
    inside = np.ones(points.shape[1], bool)
    for bound in near:
        rounding = EXACT * np.sqrt(covariance[bound.at, bound.at])
        inside &= bound.side * (points[bound.at] - bound.value) >= -rounding
    return inside
