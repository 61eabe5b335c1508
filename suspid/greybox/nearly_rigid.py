"""Covariance of the unknowns of a drive whose mounts are nearly rigid: the likelihood has no parabola there.

A delay and a mount differ by the squares of both times, so with the relaxation tau of a mount the residual moves as
``a tau + b tau^2``: the deviation ``w(tau)`` of a fit with tau held, whose square is the rise of chi-square, is steeper
at the best tau than at a rigid mount. The curvature at the best fit would make intervals too short on the side of the
rigid mount, by a factor of two where b alone counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.noise_levels import Levels
from suspid.greybox.settling import Point, descended
from suspid.levels import EXACT, NORMAL_95
from suspid.units import Ratio, RealArray

LEAST_APART = 0.2  # deviations of a rigid mount, below which rounding counts in them


def share_to_rigid(deviations: float, steepness: Ratio) -> Ratio:
    """Return the share of tau by which a mount is stiffer where the fit is less likely by `NORMAL_95` deviations.

    ``deviations`` are those of the rigid mount, ``steepness`` the slope of w at the best tau over that of the chord to
    the rigid mount. With ``w = deviations ((2 - steepness) x + (steepness - 1) x^2)`` of the share x of tau, both are
    met.

    Examples
    --------
    A parabola of chi-square, and a fourth power, at twice the deviations that are asked:

    >>> [round(share_to_rigid(2 * NORMAL_95, steepness), 3) for steepness in (1.0, 2.0)]
    [0.5, 0.293]
    """
    if deviations <= NORMAL_95:
        return 1.0
    bent = min(max(steepness, 1.0), 2.0) - 1
    left = 1 - NORMAL_95 / deviations
    root = np.sqrt((1 - bent) ** 2 + 4 * bent * left)
    return float(1 - 2 * left / (1 - bent + root))


def toward_rigid(
    problem: WheelProblem, found: Point, levels: Sequence[Levels], covariance: RealArray, *, curvature: RealArray
) -> RealArray:
    """Return the covariance that gives the intervals of the profile of the likelihood toward rigid mounts.

    For each mount that is not rigid at the best fit, the best fit with this mount rigid shows how unlikely that is, and
    where the other unknowns are then. What is known of these at a given tau stays as it is. ``curvature`` is the
    covariance by the curvature of chi-square alone: as much as the lines scatter more, a rise of chi-square is less.
    """
    first = len(problem.unknowns)
    for at in range(first, first + len(problem.extras.mounts)):
        tau = float(found.z[at])
        if tau <= EXACT:
            continue
        upper = problem.extras.upper.copy()
        upper[at - first] = EXACT
        rigid = descended(problem, found.z, levels, extras=(problem.extras.lower, upper))
        rise = (rigid.cost - found.cost) * curvature[at, at] / covariance[at, at]
        apart = float(np.sqrt(max(rise, 0.0)))
        if apart < LEAST_APART:
            continue
        std = np.sqrt(covariance[at, at])
        share = share_to_rigid(apart, tau / (std * apart))
        along = covariance[:, at] / std**2
        rest = covariance - np.outer(along, along) * std**2
        along = along + ((found.z - rigid.z) / tau - along) * share
        along[at] = 1.0
        wide = max(std, tau * share / min(apart, NORMAL_95))
        covariance = rest + np.outer(along, along) * wide**2
    return covariance
