"""Thresholds for wavelet coefficients, and the rules that shrink them."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from suspid.units import Ratio, RealArray

ThresholdName: TypeAlias = Literal["sure", "universal", "bayes", "minimax"]
RuleName: TypeAlias = Literal["garrote", "soft", "hard"]


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
    size = np.sort(np.abs(details))
    within = np.searchsorted(size, universal_threshold(size.size), side="right")
    limits = np.concatenate([[0.0], size[:within]])
    taken_out = np.concatenate([[0.0], np.cumsum(size[:within] ** 2 - 1)])
    kept = size.size - np.arange(within + 1)
    if rule != "soft":
        inverse = np.divide(1.0, size**2, out=np.zeros_like(size), where=size > 0)
        tail = np.concatenate([np.cumsum(inverse[::-1])[::-1], [0.0]])[: within + 1]
        risk = taken_out + kept + (limits**4 + 2 * limits**2) * tail
    else:
        risk = taken_out + kept * (1 + limits**2)
    return float(limits[np.argmin(risk)])


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
