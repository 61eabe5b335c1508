"""Intervals of parameters at or near a bound: profile of the likelihood within the bounds.

To first order minus twice the logarithm of the likelihood is ``(p - u)' S^-1 (p - u)``, with u the parameters of least
misfit if there were no bounds. An interval holds all values of a parameter for which some car within the bounds is
less likely than the most likely one by ``reach^2`` at most, a little more beside a bound, see `widened`. Where another
parameter is at its bound, as a mount that is as good as rigid, that is the half of the interval without bounds that
cars have, and likelihood ratios are mixtures of chi-squares (S. G. Self and K.-Y. Liang, J. Am. Stat. Assoc. 82 (1987)
605-610).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from suspid.levels import EXACT, MOST_BOUNDS
from suspid.units import Flags, Ratio, RealArray

RAY_DIRECTIONS = 240  # over which a likelihood ratio is averaged: its share beyond the reach then is exact to a percent
STEPS_TO_REACH = 4  # to the reach, in the logarithm of that share, which is nearly straight


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
    if not near:
        whole = reach * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return center - whole, center + whole
    std = np.sqrt(np.diag(covariance))
    at = list(dict.fromkeys(bound.at for bound in near))
    alike = np.abs(covariance[:, at]) / np.maximum(np.outer(std, std[at]), np.finfo(float).tiny)
    alike[at, range(len(at))] = 0.0
    return _profile_ends(center, covariance, near, widened(reach, np.max(alike, axis=1)))


def widened(reach: Ratio, correlations: RealArray) -> RealArray:
    """Return the reach whose interval holds a parameter as often as ``reach`` does where no bound is near.

    ``correlations`` are those with a parameter whose true value is at its bound. The likelihood ratio then is that of a
    ray in a half plane, at an angle of that cosine: over all directions it is ``r^2 h(direction)``, where the square of
    a normal deviation r in the plane exceeds ``q / h`` with a probability of ``exp(-q / 2 h)``.

    Examples
    --------
    >>> widened(1.96, np.array([0.0, 0.9, 1.0])).round(2).tolist()
    [1.96, 1.98, 2.06]
    """
    from scipy.special import log_ndtr

    ray = np.arccos(np.clip(correlations, 0.0, 1.0))[:, None]
    way = (np.arange(RAY_DIRECTIONS) + 0.5) * 2 * np.pi / RAY_DIRECTIONS
    off_ray = np.where(np.cos(way - ray) > 0, np.sin(way - ray) ** 2, 1.0)
    h = np.maximum(off_ray - np.where(way > np.pi, np.sin(way) ** 2, 0.0), EXACT)
    asked, q = np.log(2) + log_ndtr(-reach), np.full(len(correlations), reach**2)
    for _ in range(STEPS_TO_REACH):
        beyond = np.exp(-q[:, None] / (2 * h))
        missed = np.mean(beyond, axis=1)
        q = q + (np.log(missed) - asked) * missed / np.mean(beyond / (2 * h), axis=1)
    return np.asarray(np.sqrt(np.maximum(q, reach**2)))


def _profile_ends(
    center: RealArray, covariance: RealArray, near: list[_Bound], reach: RealArray
) -> tuple[RealArray, RealArray]:
    """Return the ends between which a car within the bounds is less likely by the square of ``reach`` at most."""
    slices = list(_slices(center, covariance, near))
    inside = [part.misfit for part in slices if _all_inside(part.middle[:, None], near, covariance)[0]]
    least = min(inside, default=0.0)
    low, high = np.full(len(center), np.inf), np.full(len(center), -np.inf)
    for part in slices:
        room = least + reach**2 - part.misfit
        std = np.sqrt(np.maximum(np.diag(part.covariance), 0.0))
        toward = part.covariance * (np.sqrt(np.maximum(room, 0.0)) / np.where(std > 0, std, 1.0))
        for sign in (-1.0, 1.0):
            points = part.middle[:, None] + sign * toward
            end = np.diag(points)
            kept = _all_inside(points, near, covariance) & (room >= 0)
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
