"""Descents by bounded Gauss-Newton steps: from a start to the minimum near it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.units import RealArray

LARGEST_STEP = 0.5  # in the logarithm of what is positive, and in the others themselves; larger steps overshoot
NEGLIGIBLE_SHARE = 1e-13  # of the squared residual: a descent ends where a step promises less, near rounding

# Residual and its derivatives by the unknowns, at the unknowns.
Equations: TypeAlias = Callable[[RealArray], tuple[RealArray, RealArray]]


def descend(
    equations: Equations,
    x: RealArray,
    *,
    positive: NDArray[np.bool_],
    lower: RealArray,
    upper: RealArray,
    negligible: float = 0.0,
    secant: bool = False,
) -> RealArray:
    """Return a minimum of the norm of the equations between bounds, by Gauss-Newton steps in a trust region.

    What is ``positive`` is stepped in its logarithm; a gain of the squared norm up to ``negligible`` ends the descent.
    With ``secant``, curvature that Gauss-Newton does not see is taken from how the gradient changed along the last
    step: along a curved valley steps overshoot again and again without it.

    Examples
    --------
    >>> def circle(x):
    ...     return np.array([x @ x - 2.0, x[0] - x[1]]), np.array([2 * x, [1.0, -1.0]])
    >>> free = {"lower": np.zeros(2), "upper": np.full(2, np.inf)}
    >>> descend(circle, np.array([3.0, 0.1]), positive=np.array([True, False]), **free).round(6)
    array([1., 1.])
    """
    radius = LARGEST_STEP
    residual, slope = equations(x)
    bent = np.zeros((0, len(x)))  # row of further curvature, in steps
    for _ in range(60):
        per_step = np.where(positive, x, 1.0)
        with np.errstate(divide="ignore"):
            floor = np.where(positive, np.log(np.maximum(lower, 1e-300) / per_step), lower - x)
            ceiling = np.where(positive, np.log(upper / per_step), upper - x)
        low, high = np.minimum(np.maximum(-radius, floor), 0.0), np.maximum(np.minimum(radius, ceiling), 0.0)
        step = bounded_step(
            np.concatenate([slope * per_step, bent]), np.append(-residual, np.zeros(len(bent))), low, high
        )
        expected = float(residual @ residual - np.sum((residual + slope * per_step @ step) ** 2))
        expected -= float(np.sum((bent @ step) ** 2))
        trial = np.where(positive, x * np.exp(np.where(positive, step, 0.0)), x + step)
        trial = np.clip(trial, lower, upper)
        trial_residual, trial_slope = equations(trial)
        gained = float(residual @ residual - trial_residual @ trial_residual)
        if secant:
            per_trial = np.where(positive, trial, 1.0)
            turned = (trial_slope * per_trial).T @ trial_residual - (slope * per_step).T @ residual
            more = float(step @ turned - np.sum((trial_slope * per_trial @ step) ** 2))
            if more > 0:
                bent = (np.sqrt(more) / (step @ step) * step)[None]
        if gained > 0:
            x, residual, slope = trial, trial_residual, trial_slope
        if np.max(np.abs(step)) < 1e-13 or (gained <= 0 and np.max(np.abs(step)) < 1e-9):
            break
        if gained >= 0 and expected <= max(NEGLIGIBLE_SHARE * float(residual @ residual), negligible):
            break
        radius = next_radius(radius, gained, expected)
    return x


def next_radius(radius: float, gained: float, expected: float) -> float:
    """Return the radius of a trust region after a step that gained this much of what the linear model promised."""
    if gained > 0.75 * expected:
        return min(2 * radius, 4.0)
    return radius if gained > 0.1 * expected else radius / 4


def bounded_step(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return the x between bounds of least ``|A x - b|``, by SciPy where a guess of the bounds that it meets fails."""
    x = np.asarray(np.linalg.lstsq(A, b, rcond=None)[0], float)
    if np.all((x >= low) & (x <= high)):
        return x
    held = (x < low) | (x > high)
    at: RealArray = np.clip(x, low, high)
    free = ~held
    at[free], _, rank, _ = np.linalg.lstsq(A[:, free], b - A[:, held] @ at[held], rcond=None)
    # The problem is convex: what is within bounds, and would leave them from those it is at, is its minimum.
    rise = A[:, held].T @ (A @ at - b)
    inside = rank == np.sum(free) and np.all((at >= low) & (at <= high))
    if inside and np.all(np.where(at[held] == low[held], rise, -rise) > 0):
        return at
    from scipy.optimize import lsq_linear

    return np.asarray(lsq_linear(A, b, (low, high), method="bvls", tol=1e-14).x, float)


def slope_left(equations: Equations, x: RealArray, lower: RealArray, upper: RealArray) -> float:
    """Return the KKT residual of a minimum between bounds: what the best step to first order would still gain.

    It is a share of the squared norm of the residual [1]; steps out of the bounds do not count.
    """
    residual, slope = equations(x)
    gradient = slope.T @ residual
    size = np.maximum(np.abs(x), 1e-3)
    free = ~((x <= lower + 1e-9 * size) & (gradient > 0)) & ~((x >= upper - 1e-9 * size) & (gradient < 0))
    step = np.linalg.lstsq(slope[:, free] * size[free], -residual, rcond=1e-12)[0]
    before = float(residual @ residual)
    gain = before - float(np.sum((residual + slope[:, free] * size[free] @ step) ** 2))
    return max(gain, 0.0) / max(before, 1e-300)
