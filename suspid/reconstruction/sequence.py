"""Sequences of convex programs: each linearises the equations where the one before it ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.reconstruction.descent import LARGEST_STEP, NEGLIGIBLE_SHARE, Equations, next_radius
from suspid.reconstruction.programs import FARTHEST, Limits, Optimum, least_squares, solve
from suspid.reconstruction.wishes import Wishes
from suspid.units import RealArray

# From matrix, target, units of the step, bounds of the step and the point to the best step.
Step: TypeAlias = Callable[[RealArray, RealArray, RealArray, Limits, RealArray], Optimum]


def converged(
    equations: Equations,
    x: RealArray,
    *,
    positive: NDArray[np.bool_],
    lower: RealArray,
    upper: RealArray,
    wishes: Wishes | None = None,
) -> Optimum:
    """Return the minimum near x of the squared norm of the equations plus the penalty; the last program proves it.

    The start keeps to the constraints. What is ``positive`` is scaled by its own value. The ``left`` of the result is
    the share of the objective that the last program still promised.
    """
    radius = LARGEST_STEP
    residual, slope = equations(x)
    objective = float(residual @ residual) + _penalty(wishes, x)
    # From a minimum that a descent has found, one or two programs are needed.
    for _ in range(60):
        unit = np.where(positive, x, 1.0)
        low, high = np.maximum((lower - x) / unit, -radius), np.minimum((upper - x) / unit, radius)
        step = _best_step(slope * unit, -residual, low, high, unit, x, objective, wishes)
        trial = np.clip(x + unit * step.x, lower, upper)
        promised = float(np.sum((residual + slope @ (unit * step.x)) ** 2)) + _penalty(wishes, trial)
        trial_residual, trial_slope = equations(trial)
        before, expected = objective, objective - promised
        reached = float(trial_residual @ trial_residual) + _penalty(wishes, trial)
        gained = before - reached
        if gained > 0:
            x, residual, slope, objective = trial, trial_residual, trial_slope, reached
        largest = float(np.max(np.abs(step.x)))
        arrived = expected <= NEGLIGIBLE_SHARE * before or largest < 1e-13
        # Steps below it that gain nothing are rounding: the squared residual has a flat minimum.
        if arrived or (gained <= 0 and largest < 1e-6):
            break
        radius = next_radius(radius, gained, expected)
    return Optimum(x=x, left=max(expected, 0.0) / max(before, 1e-300), free=step.free)


def feasible(x: RealArray, lower: RealArray, upper: RealArray, wishes: Wishes) -> RealArray:
    """Return the point nearest to x, relative to its size, that keeps to bounds and constraints."""
    if wishes.violation(x) <= 0 and np.all((x >= lower) & (x <= upper)):
        return x
    unit = np.maximum(np.abs(x), 0.1)
    limits = _limits((lower - x) / unit, np.minimum((upper - x) / unit, FARTHEST), unit, x, wishes)
    for_nearest = np.eye(len(x)), np.zeros(len(x))
    if not wishes.curved:
        step = least_squares(*for_nearest, limits, smallest=1.0)
    else:
        numbers = {"A": for_nearest[0], "b": for_nearest[1], **limits.scaled(1.0), **_parameters(wishes, x, unit)}
        step = solve(wishes.nearest, numbers)
    return np.clip(x + unit * step.x, lower, upper)


def _best_step(
    A: RealArray,
    b: RealArray,
    low: RealArray,
    high: RealArray,
    unit: RealArray,
    x: RealArray,
    objective: float,
    wishes: Wishes | None,
) -> Optimum:
    """Return the best step in units, of least ``|A y - b|^2`` plus the penalty, within bounds and constraints."""
    limits = _limits(low, high, unit, x, wishes)
    if wishes is None or wishes.linear:
        return least_squares(A, b, limits)
    # The penalty has no scale of its own, so the program keeps the units of the objective.
    largest = max(float(np.max(np.abs(A))), 1e-300)
    size = float(np.clip(max(np.sqrt(objective), np.max(np.abs(b))) / largest, 1e-6, 1.0))
    R = np.zeros((A.shape[1], A.shape[1] + 1))
    triangle = np.linalg.qr(np.column_stack([A * size, b]), mode="r")[: A.shape[1]]
    R[: len(triangle)] = triangle
    for _ in range(3):
        numbers = {"A": R[:, :-1], "b": R[:, -1], **limits.scaled(size), **_parameters(wishes, x, unit * size)}
        found = solve(wishes.program, numbers)
        if np.max(np.abs(found.x)) < 0.99 * FARTHEST or size >= 1.0:
            break
        R[:, :-1], size = R[:, :-1] * FARTHEST, size * FARTHEST
    return Optimum(x=np.clip(found.x * size, low, high), left=found.left, free=found.free)


def _limits(low: RealArray, high: RealArray, unit: RealArray, x: RealArray, wishes: Wishes | None) -> Limits:
    """Return the limits of a step from x, in units of its own."""
    if wishes is None:
        return Limits(low=low, high=high)
    rows, left = wishes.matrix * unit, wishes.limit - wishes.matrix @ x
    equal = wishes.equal
    return Limits(low=low, high=high, E=rows[equal], e=left[equal], F=rows[~equal], f=left[~equal])


def _parameters(wishes: Wishes, x: RealArray, unit: RealArray) -> dict[str, RealArray]:
    """Return the parameters of the suspension as a function of the step."""
    return {"at": wishes.unknowns.parameters(x), "gain": wishes.unknowns.spread * unit}


def _penalty(wishes: Wishes | None, x: RealArray) -> float:
    return 0.0 if wishes is None else wishes.penalised(x)
