"""Test whether a damper is viscous."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.greybox.curve_fit import CurveFit, Shape
from suspid.units import Ratio

# Ranges of velocity on each side whose rates the test compares.
LINE_RANGES = 4


@dataclass(frozen=True, kw_only=True, slots=True)
class LineTest:
    """The test whether a damper is viscous: all forces in proportion to the velocity, and no friction.

    Parameters
    ----------
    statistic : float
        Hotelling's statistic as F.
    freedom, residual_freedom : int
        Its degrees of freedom.
    p_value : float
        Probability of as large a statistic where the damper is viscous.
    level : float
        Share of viscous dampers that are rejected.

    Examples
    --------
    >>> test = LineTest(statistic=1.2, freedom=5, residual_freedom=200, p_value=0.31, level=0.05)
    >>> test.accepted, bool(test)
    (True, True)
    """

    statistic: float
    freedom: int
    residual_freedom: int
    p_value: float
    level: Ratio

    @property
    def accepted(self) -> bool:
        """Whether a line is not rejected.

        Examples
        --------
        >>> from suspid import LineTest
        >>> LineTest(statistic=9.0, freedom=5, residual_freedom=200, p_value=1e-7, level=0.05).accepted
        False
        """
        return self.p_value >= self.level

    def __bool__(self) -> bool:
        return self.accepted


def line_test(shape: Shape, fit: CurveFit, level: Ratio) -> LineTest:
    """Return Hotelling's test that the rates in all ranges of velocity are equal, and there is no friction.

    The rate of a range is ``sum(v F) / sum(v^2)`` over its nodes. Single nodes would ask for more blocks than a short
    record has.
    """
    from scipy.stats import f

    v, covariance = shape.moving, fit.covariance[1:, 1:]
    sides = [np.flatnonzero(v < 0), np.flatnonzero(v > 0)]
    ranges = [part for side in sides for part in np.array_split(side, min(LINE_RANGES, len(side)))]
    rates = np.zeros((len(ranges), len(covariance)))
    for row, part in zip(rates, ranges, strict=True):
        row[part] = v[part] / np.sum(v[part] ** 2)
    contrasts = np.diff(rates, axis=0)
    if shape.friction:
        contrasts = np.vstack([contrasts, np.eye(len(covariance))[-1]])
    off = contrasts @ fit.theta[1:]
    count, blocks = len(off), sum(len(part.scores) for part in fit.records)
    square = float(off @ np.linalg.solve(contrasts @ covariance @ contrasts.T, off))
    # The covariance comes from as many scores as blocks, less the unknowns.
    rest = max(blocks - len(fit.theta), count + 1)
    residual = rest - count + 1
    statistic = square * residual / (count * rest)
    return LineTest(
        statistic=statistic,
        freedom=count,
        residual_freedom=residual,
        p_value=float(f.sf(statistic, count, residual)),
        level=level,
    )
