"""Sequences of convex programs: each linearises the equations where the one before it ended."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.reconstruction.descent import NEGLIGIBLE_SHARE, Equations
from suspid.reconstruction.programs import Optimum, least_squares
from suspid.units import RealArray

LARGEST_STEP = 0.5  # of springs and masses relative to themselves, of dampers to their scale: first trust region
ROUNDING = 1e-6  # steps below it that gain nothing are rounding: the squared residual has a flat minimum
PROGRAMS = 60  # at most; from a minimum that a descent has found, one or two are needed


def converged(
    equations: Equations,
    x: RealArray,
    *,
    positive: NDArray[np.bool_],
    lower: RealArray,
    upper: RealArray,
    negligible: float = 0.0,
) -> Optimum:
    """Return the minimum near x of the norm of the equations between bounds; the last program proves it.

    Parameters
    ----------
    equations : callable
        From unknowns to residual and Jacobian.
    x : ndarray (unknown,)
        Where to start.
    positive : ndarray (unknown,)
        Which unknowns are scaled by their own value.
    lower, upper : ndarray (unknown,)
        Bounds.
    negligible : float
        Gain of the squared norm that is not worth a step.

    Raises
    ------
    ReconstructionError
        If the solver finds no optimum of one of the programs.
    """
    radius = LARGEST_STEP
    residual, slope = equations(x)
    for _ in range(PROGRAMS):
        unit = np.where(positive, x, 1.0)
        low, high = np.maximum((lower - x) / unit, -radius), np.minimum((upper - x) / unit, radius)
        step = least_squares(slope * unit, -residual, low, high)
        expected = float(residual @ residual - np.sum((residual + slope * unit @ step.x) ** 2))
        trial = np.clip(x + unit * step.x, lower, upper)
        trial_residual, trial_slope = equations(trial)
        before, gained = float(residual @ residual), float(residual @ residual - trial_residual @ trial_residual)
        if gained > 0:
            x, residual, slope = trial, trial_residual, trial_slope
        largest = float(np.max(np.abs(step.x)))
        arrived = expected <= max(NEGLIGIBLE_SHARE * before, negligible) or largest < 1e-13
        if arrived or (gained <= 0 and largest < ROUNDING):
            return Optimum(x=x, left=max(expected, 0.0) / max(before, 1e-300), free=step.free)
        radius = min(2 * radius, 4.0) if gained > 0.75 * expected else radius if gained > 0.1 * expected else radius / 4
    return Optimum(x=x, left=max(expected, 0.0) / max(before, 1e-300), free=step.free)
