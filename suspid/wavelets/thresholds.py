"""Thresholds for wavelet coefficients, and the rules that shrink them."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from suspid.units import Ratio, RealArray

ThresholdName: TypeAlias = Literal["sure", "universal", "bayes", "minimax"]
RuleName: TypeAlias = Literal["garrote", "soft", "hard"]

# Coefficients from which on a histogram of 4096 bins saves more than it takes: fewer are sorted as fast. Fewer bins
# exclude less, more take longer.
FEWEST_BINNED, BINS = 20_000, 4096


def threshold_of(details: RealArray, *, threshold: ThresholdName, rule: RuleName, count: int) -> Ratio:
    """Return the threshold for coefficients in units of their noise."""
    match threshold:
        case "universal":
            return universal_threshold(count)
        case "minimax":
            return minimax_threshold(count)
        case "bayes":
            return bayes_threshold(details)
        case "sure":
            return sure_threshold(details, rule=rule)


def universal_threshold(count: int) -> Ratio:
    """Return ``sqrt(2 log n)`` [noise deviations], which the largest of n noise coefficients seldom exceeds."""
    return float(np.sqrt(2 * np.log(count)))


def minimax_threshold(count: int) -> Ratio:
    """Return the threshold of least worst-case risk relative to that of an oracle [noise deviations].

    The root of ``(n + 1) r(t) = 1 + t^2`` with ``r(t) = 2 ((1 + t^2) Phi(-t) - t phi(t))`` the risk of
    soft thresholding without signal, and ``1 + t^2`` its risk for large signal.
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    def excess(t: float) -> float:
        density = np.exp(-(t**2) / 2) / np.sqrt(2 * np.pi)
        return float(2 * (count + 1) * ((1 + t**2) * ndtr(-t) - t * density) - 1 - t**2)

    return float(brentq(excess, 0.0, universal_threshold(count) + 1.0, xtol=1e-12))


def sure_threshold(details: RealArray, *, rule: RuleName = "soft") -> Ratio:
    """Return the threshold of least Stein risk, at most ``sqrt(2 log n)`` [noise deviations].

    The unbiased estimate of the risk is ``sum(x^2 - 1)`` over the removed coefficients, plus, over those kept,
    ``sum(1 + t^2)`` for the soft rule and ``sum(1 + t^4 / x^2 + 2 t^2 / x^2)`` for the garrote. It increases between
    the coefficients, so its minimum is at one of them or at zero. The hard rule is discontinuous and has no such
    estimate; it uses the threshold of the garrote, which also keeps large coefficients.
    """
    size = np.abs(details)
    low, high = _around_least_risk(size, soft=rule == "soft")
    below, within = size[size < low], np.sort(size[(size >= low) & (size <= high)])
    taken_out = np.sum(below**2 - 1) + np.cumsum(within**2 - 1)
    kept = size.size - below.size - np.arange(1, within.size + 1)
    if rule == "soft":
        risk = taken_out + kept * (1 + within**2)
    else:
        inverse = np.append(_inverse_squares(within), np.sum(_inverse_squares(size[size > high])))
        risk = taken_out + kept + (within**4 + 2 * within**2) * np.cumsum(inverse[::-1])[-2::-1]
    # Where nothing is removed, the risk is that of the noise.
    least = int(np.argmin(risk)) if within.size else 0
    return float(within[least]) if within.size and risk[least] < size.size else 0.0


def _around_least_risk(size: RealArray, *, soft: bool) -> tuple[Ratio, Ratio]:
    """Return bounds of the threshold of least Stein risk, if it is not zero: few of many coefficients lie between them.

    Within a bin of a histogram the risk is no lower than with all coefficients at its lower edge of which as many are
    removed, and as few kept, as makes it least. That excludes most bins.
    """
    top = universal_threshold(size.size)
    if size.size < FEWEST_BINNED:
        return 0.0, top
    # What is beyond the largest threshold falls into one more bin.
    place = np.minimum(size * (BINS / top), BINS).astype(np.intp)
    count = np.bincount(place, minlength=BINS + 1)
    square = np.bincount(place, size**2, BINS + 1)[:-1]
    weight = count if soft else np.bincount(place, _inverse_squares(size), BINS + 1)
    behind, count = np.cumsum(weight[::-1])[-2::-1], count[:-1]
    edges = np.linspace(0.0, top, BINS + 1)
    price = edges**2 if soft else edges**4 + 2 * edges**2
    # Risk without the price of what is kept, at each edge.
    others = size.size + np.cumsum(np.append(0.0, square - 2 * count))
    lowest = others[:-1] + np.minimum(0.0, count * (edges[:-1] ** 2 - 2)) + price[:-1] * behind
    highest = np.where(count > 0, others[1:] + price[1:] * behind, np.inf)
    # A coefficient at an edge may stand in either bin.
    left = np.flatnonzero((count > 0) & (lowest <= np.min(highest) + 1e-6 * size.size))
    if not left.size:
        return 0.0, top
    return float(edges[max(left[0] - 1, 0)]), float(edges[min(left[-1] + 2, BINS)])


def _inverse_squares(size: RealArray) -> RealArray:
    """Return ``1 / x^2``, 0 at 0."""
    with np.errstate(divide="ignore"):
        inverse = 1 / size**2
    inverse[size == 0] = 0.0
    return inverse


def bayes_threshold(details: RealArray) -> Ratio:
    """Return ``1 / sqrt(mean(x^2) - 1)`` [noise deviations], or the largest coefficient if there is only noise."""
    excess = float(np.mean(details**2)) - 1
    return 1 / np.sqrt(excess) if excess > 0 else float(np.max(np.abs(details)))


def shrink(details: RealArray, limit: Ratio, *, rule: RuleName) -> RealArray:
    """Return 0 for ``|x| <= t``; beyond, x (hard), ``x - t sign(x)`` (soft) or ``x - t^2 / x`` (garrote)."""
    size = np.abs(details)
    kept = size > limit
    if rule == "hard":
        return np.where(kept, details, 0.0)
    if rule == "soft":
        return np.where(kept, details - limit * np.sign(details), 0.0)
    return np.where(kept, details - limit**2 / np.where(kept, details, 1.0), 0.0)
