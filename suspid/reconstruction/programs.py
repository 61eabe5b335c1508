"""Convex programs: bounded least squares, compiled once, and sequences of them."""

from __future__ import annotations

import contextlib
import functools
import threading
import warnings
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import ReconstructionError
from suspid.units import RealArray

SOLVER = "CLARABEL"
LARGEST_STEP = 0.5  # in the logarithm of what is positive, and in the others themselves
NEARLY = 1e-7  # slope, of the largest there can be, of an optimum that cannot be sharpened
NOTHING = 1e-13  # share of the squared residual that a step promises, below which a descent ends
STATIONARY = 1e-6  # worth of the step still possible, of the residual's square, at an optimum

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
) -> RealArray:
    """Return a minimum of the norm of the equations between bounds, by convex programs in a box of trust around x.

    Parameters
    ----------
    equations : callable
        From unknowns to residual and Jacobian.
    x : ndarray (unknown,)
        Where to start.
    positive : ndarray (unknown,)
        Which unknowns are stepped in their logarithm.
    lower, upper : ndarray (unknown,)
        Bounds.
    negligible : float
        Gain of the squared norm that is not worth a step.

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
    for _ in range(60):
        per_step = np.where(positive, x, 1.0)
        with np.errstate(divide="ignore"):
            floor = np.where(positive, np.log(np.maximum(lower, 1e-300) / per_step), lower - x)
            ceiling = np.where(positive, np.log(upper / per_step), upper - x)
        low, high = np.minimum(np.maximum(-radius, floor), 0.0), np.maximum(np.minimum(radius, ceiling), 0.0)
        try:
            step = bounded_least_squares(slope * per_step, -residual, low, high)
        except ReconstructionError:
            break  # no way on from a point that sees too little; whoever asked judges where it ends
        expected = residual @ residual - np.sum((residual + slope * per_step @ step) ** 2)
        trial = np.where(positive, x * np.exp(np.where(positive, step, 0.0)), x + step)
        trial = np.clip(trial, lower, upper)
        trial_residual, trial_slope = equations(trial)
        gained = residual @ residual - trial_residual @ trial_residual
        if gained > 0:
            x, residual, slope = trial, trial_residual, trial_slope
        if np.max(np.abs(step)) < 1e-13 or (gained <= 0 and np.max(np.abs(step)) < 1e-9):
            break
        if gained >= 0 and expected <= max(NOTHING * float(residual @ residual), negligible):
            break
        radius = min(2 * radius, 4.0) if gained > 0.75 * expected else radius if gained > 0.1 * expected else radius / 4
    return x


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


def bounded_least_squares(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return the x between bounds of least ``|A x - b|``.

    Where no bound acts, that is no more than least squares; where those that least squares crosses act, and the
    conditions of an optimum prove it, the solver need not be asked.
    """
    x = np.asarray(np.linalg.lstsq(A, b, rcond=None)[0], float)
    below, above = x < low, x > high
    if not np.any(below | above):
        return x
    proven, _ = _sharpened(A, b, low, high, below, above)
    return convex_program(A, b, low, high) if proven is None else proven


def convex_program(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return the x between bounds of least ``|A x - b|``, by the solver, sharpened and tested here.

    The solver says which bounds act; least squares on the others then has all digits. Accepted is what meets the
    conditions of an optimum: no slope along a free unknown, none outward of a bound.
    """
    free_answer = np.linalg.lstsq(A, b, rcond=None)[0]
    size = min(max(float(np.max(np.abs(free_answer))), 1e-150), float(np.max(high)))
    R = np.zeros((A.shape[1], A.shape[1] + 1))  # the same program in as few rows as there are unknowns
    triangle = np.asarray(np.linalg.qr(np.column_stack([A, b / size]), mode="r"))[: A.shape[1]]
    R[: len(triangle)] = triangle / max(float(np.max(np.abs(triangle[:, :-1]))), 1e-300)
    y = _solve(R[:, :-1], R[:, -1], np.maximum(low / size, -1e6), np.minimum(high / size, 1e6))
    x = np.clip(y * size, low, high)
    near = 1e-6 * size
    proven, left = _sharpened(A, b, low, high, x - low < near, high - x < near)
    if proven is None:
        # Where columns depend on each other, which bounds act is not unique; the solver's own point may do.
        gradient = (A.T @ (A @ x - b)) / (np.linalg.norm(A, axis=0) * (np.linalg.norm(b) or 1.0) + 1e-300)
        downhill = np.where(
            x - low < near, np.minimum(gradient, 0), np.where(high - x < near, np.maximum(gradient, 0), gradient)
        )
        left = float(np.max(np.abs(downhill)))
        if left <= NEARLY:
            return x
        raise ReconstructionError(
            f"{SOLVER} left a slope of {left:.1e} at the optimum, which is none; "
            f"check the nominal values and the modes for a slip of units"
        )
    return proven


def _sharpened(
    A: RealArray,
    b: RealArray,
    low: RealArray,
    high: RealArray,
    low_acts: NDArray[np.bool_],
    high_acts: NDArray[np.bool_],
) -> tuple[RealArray | None, float]:
    """Return the optimum, from a guess of the bounds that act, or None if it is not proven; and the slope left."""
    low_acts, high_acts = low_acts.copy(), high_acts.copy()
    lengths = np.linalg.norm(A, axis=0) * (np.linalg.norm(b) or 1.0) + 1e-300
    left = np.inf
    for _ in range(5 * len(low)):
        free = ~(low_acts | high_acts)
        x = np.where(low_acts, low, np.where(high_acts, high, 0.0))
        x[free] = np.linalg.lstsq(A[:, free], b - A @ x, rcond=None)[0]
        beyond = np.maximum(low - x, x - high)
        if np.max(beyond) > 0:
            worst = int(np.argmax(beyond))
            low_acts[worst], high_acts[worst] = x[worst] < low[worst], x[worst] > high[worst]
            continue
        outward = (A.T @ (A @ x - b)) / lengths * np.where(low_acts, -1.0, np.where(high_acts, 1.0, 0.0))
        left = float(np.max(outward))
        if left <= 1e-12:
            return x, left
        worst = int(np.argmax(outward))
        low_acts[worst] = high_acts[worst] = False
    return None, left


def _solve(A: RealArray, b: RealArray, low: RealArray, high: RealArray) -> RealArray:
    """Return what the solver gives for least ``|A x - b|`` between bounds; judged by the caller, not by its status."""
    problem, values, x = compiled(len(low), threading.get_ident())
    for name, value in (("A", A), ("b", b), ("low", low), ("high", high)):
        values[name].value = value
    from cvxpy.error import SolverError

    with warnings.catch_warnings(), contextlib.suppress(SolverError):
        warnings.simplefilter("ignore")
        problem.solve(solver=SOLVER)
        if x.value is not None:
            return np.asarray(x.value, float)
    return np.clip(np.zeros(len(low)), low, high)


@functools.lru_cache(maxsize=64)
def compiled(size: int, thread: int) -> tuple[Any, dict[str, Any], Any]:  # noqa: ARG001 - one program per thread
    """Return the program with its parameters and unknowns, compiled once for each number of unknowns."""
    import cvxpy

    cp: Any = cvxpy  # whose types leave out what it makes at run time
    x = cp.Variable(size)
    values = {"A": cp.Parameter((size, size)), **{name: cp.Parameter(size) for name in ("b", "low", "high")}}
    objective = cp.Minimize(cp.sum_squares(values["A"] @ x - values["b"]))
    problem = cp.Problem(objective, [x >= values["low"], x <= values["high"]])
    if not problem.is_dcp(dpp=True):
        raise AssertionError("the program must be disciplined in its parameters, or it is compiled anew each time")
    return problem, values, x
