"""Intervals of estimated parameters within their bounds, and which parameters differ from nominal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from suspid.greybox.within_bounds import ends_within
from suspid.levels import LEVEL, beyond_chance, normal_reach
from suspid.model import Suspension, value_in
from suspid.units import Flags, Ratio, RealArray

# Parameters that are positive and have intervals of a ratio; the others may be zero.
POSITIVE = ("stiffness", "mass", "gain")


def ends_of(parameters: Sequence[str], values: RealArray, std: RealArray, level: Ratio) -> tuple[RealArray, RealArray]:
    """Return the ends of the intervals of parameters, before any bounds."""
    reach = normal_reach(level) * std
    ratio = _of_ratio(parameters, values)
    with np.errstate(divide="ignore", over="ignore"):
        factor = np.exp(np.where(ratio, reach / np.where(values > 0, values, 1.0), 0.0))
    return np.where(ratio, values / factor, values - reach), np.where(ratio, values * factor, values + reach)


def _of_ratio(parameters: Sequence[str], values: RealArray) -> Flags:
    """Return which parameters have intervals of a ratio."""
    return np.array([name.rpartition(".")[2] in POSITIVE for name in parameters], bool) & (values > 0)


class Spread(NamedTuple):
    """Parameters and how far they are known."""

    parameters: Sequence[str]
    values: RealArray
    covariance: RealArray
    unbounded: RealArray  # values of least misfit without bounds
    ranges: RealArray  # (parameter, 2)
    explained: bool  # else the covariance is of what the car lacks, and no likelihood tells what bounds exclude


def bounded_ends(found: Spread, level: Ratio) -> list[RealArray]:
    """Return the lower and upper ends of the intervals of parameters within their bounds."""
    values, reach = found.values, normal_reach(level)
    if not found.explained:
        plain = ends_of(found.parameters, values, np.sqrt(np.diag(found.covariance)), level)
        return [np.clip(end, found.ranges[:, 0], found.ranges[:, 1]) for end in plain]
    ratio = _of_ratio(found.parameters, values)
    size = np.where(ratio, values, 1.0)
    with np.errstate(divide="ignore", over="ignore"):
        bounds = [np.where(ratio, np.log(np.maximum(end, 0.0) / size), end - values) for end in found.ranges.T]
        ends = ends_within(
            (found.unbounded - values) / size, found.covariance / np.outer(size, size), bounds[0], bounds[1], reach
        )
        whole = [np.where(ratio, values * np.exp(np.where(ratio, end, 0.0)), values + end) for end in ends]
    return [np.clip(end, found.ranges[:, 0], found.ranges[:, 1]) for end in whole]


def changed(nominal: Suspension, found: Spread, level: Ratio = LEVEL) -> frozenset[str]:
    """Return which parameters differ from nominal: none of them by chance, with probability ``level``."""
    every = {name: value_in(nominal, name) for name in found.parameters}
    count = sum(value is not None for value in every.values())

    def outside(level: Ratio) -> list[str]:
        low, high = bounded_ends(found, level)
        rows = zip(every.items(), low, high, strict=True)
        return [name for (name, old), a, b in rows if old is not None and not a <= old <= b]

    return beyond_chance(outside, count, level)
