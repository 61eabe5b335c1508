"""Convex programs: the least squares that give the answer, by cvxpy, sharpened and tested here.

A program is compiled once for each number of unknowns and solved again with new numbers. The solver's verdict is not
trusted: its point is refined by one exact step on the constraints that it found to act, and accepted if it meets the
conditions of an optimum (Karush, Kuhn and Tucker) as computed here from the cone program's own data.
"""

from __future__ import annotations

import functools
import threading
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from suspid.errors import ReconstructionError
from suspid.levels import EXACT
from suspid.reconstruction.cones import cone_of, sharpened
from suspid.units import RealArray

# An interior-point solver that meets tight tolerances and comes with cvxpy.
SOLVER = "CLARABEL"
# Residual of the optimality conditions up to which a solution counts, in a program scaled to 1. Exact steps reach
# 1e-12; a point of the solver itself, where constraints depend on each other, 1e-8. A constraint that is as near acts.
OPTIMAL = 1e-7
FARTHEST = 1e3  # bounds in units of the step: those further away do not act, and would spoil the scaling


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Program:
    """A compiled convex program: least ``|A y - b|`` for y between low and high."""

    problem: Any  # a cvxpy.Problem, disciplined in its parameters
    values: Mapping[str, Any]  # its parameters, by name
    step: Any  # its variable y


# From the parameters of the suspension, an affine expression, to constraints and a penalty or None.
Terms: TypeAlias = Callable[[Any], tuple[list[Any], Any]]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Optimum:
    """The solution of a convex program."""

    x: RealArray
    left: float  # residual of the optimality conditions, in the program scaled to 1
    free: int  # number of directions in which x could move without leaving an active constraint


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Limits:
    """What a solution x has to keep to: bounds, equations ``E x == e`` and inequalities ``F x <= f``."""

    low: RealArray
    high: RealArray
    E: RealArray | None = None
    e: RealArray | None = None
    F: RealArray | None = None
    f: RealArray | None = None

    def scaled(self, size: float) -> dict[str, RealArray]:
        """Return the numbers of a program in ``x = size * y``; what is far away is drawn nearer."""
        numbers = {"low": np.maximum(self.low / size, -FARTHEST), "high": np.minimum(self.high / size, FARTHEST)}
        for matrix, limit, names in ((self.E, self.e, "Ee"), (self.F, self.f, "Ff")):
            if matrix is not None and limit is not None and len(limit):
                lengths = np.maximum(np.linalg.norm(matrix, axis=1), 1e-300)
                nearer = limit / lengths / size
                if names == "Ff":
                    nearer = np.minimum(nearer, FARTHEST * len(self.low))
                numbers |= {names[0]: matrix / lengths[:, None], names[1]: nearer}
        return numbers


def least_squares(A: RealArray, b: RealArray, limits: Limits, *, smallest: float = EXACT) -> Optimum:
    """Return the x within limits of least ``|A x - b|``, by cvxpy.

    Examples
    --------
    >>> found = least_squares(np.eye(2), np.array([3.0, -1.0]), Limits(low=np.zeros(2), high=np.full(2, np.inf)))
    >>> found.x.round(12) + 0.0, found.free
    (array([3., 0.]), 1)
    """
    low, high = limits.low, limits.high
    R, target, size = _reduced(A, b, high, smallest)
    rows = [0 if limit is None else len(limit) for limit in (limits.e, limits.f)]
    program = compiled(len(low), threading.get_ident(), *rows)
    for _ in range(5):
        found = solve(program, {"A": R, "b": target, **limits.scaled(size)})
        if np.max(np.abs(found.x)) < 0.99 * FARTHEST:
            break
        target, size = target / FARTHEST, size * FARTHEST  # the optimum is larger than the one without bounds
    return Optimum(x=np.clip(found.x * size, low, high), left=found.left, free=found.free)


def solve(program: Program, numbers: Mapping[str, RealArray | float]) -> Optimum:
    """Return the solution of a compiled program for these numbers, proven to be the optimum."""
    for name, value in numbers.items():
        program.values[name].value = value
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # cvxpy warns of inaccurate solutions, which are judged below
        data, chain, _ = program.problem.get_problem_data(SOLVER, solver_opts={})
        cone, left = cone_of(data), np.inf
        # Clarabel's own tolerances, in the order in which they are tried. At its default of 1e-8, constraints of small
        # multipliers are not told from idle ones; at 1e-12 it gives up where many bounds hold without a force.
        for tolerance in (1e-12, 1e-8):
            options = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), tolerance)
            raw = chain.solver.solve_via_data(data, warm_start=False, verbose=False, solver_opts=options)
            primal, acting, left = sharpened(cone, np.asarray(raw.x, float), np.asarray(raw.z, float))
            if left <= OPTIMAL:
                break
    if not left <= OPTIMAL:
        raise ReconstructionError(
            f"{SOLVER} ended with a residual of {left:.1e} of the optimality conditions ({OPTIMAL:.0e} allowed); "
            f"check the units of the nominal values and the modes"
        )
    first = data["param_prob"].var_id_to_col[program.step.id]
    free = len(primal) - (int(np.linalg.matrix_rank(cone.A[acting])) if len(acting) else 0)
    return Optimum(x=primal[first : first + program.step.size], left=left, free=free)


def _reduced(A: RealArray, b: RealArray, high: RealArray, smallest: float) -> tuple[RealArray, RealArray, float]:
    """Return the same least squares in as few rows as unknowns and scaled to 1, and the size of x.

    With ``x = size * y``, the y of least ``|R y - target|`` is that of least ``|A x - b|``.
    """
    free_answer = np.linalg.lstsq(A, b, rcond=None)[0]
    size = max(min(float(np.max(np.abs(free_answer))), float(np.max(high))), smallest)
    R = np.zeros((A.shape[1], A.shape[1] + 1))
    triangle = np.asarray(np.linalg.qr(np.column_stack([A, b / size]), mode="r"))[: A.shape[1]]
    R[: len(triangle)] = triangle
    scale = max(float(np.max(np.abs(R[:, :-1]))), float(np.max(np.abs(R[:, -1]))) / FARTHEST, 1e-300)
    return R[:, :-1] / scale, R[:, -1] / scale, size


@functools.lru_cache(maxsize=64)
def compiled(size: int, thread: int, equal: int = 0, below: int = 0) -> Program:  # noqa: ARG001 - one per thread
    """Return the program of least squares with bounds and linear rows, compiled once for each number of them."""
    return build(size, equal, below)


def build(size: int, equal: int = 0, below: int = 0, *, parameters: int = 0, terms: Terms | None = None) -> Program:
    """Return a compiled program: least ``|A y - b|^2`` plus a penalty, under bounds, ``E y == e`` and ``F y <= f``.

    Further ``terms`` are made of the parameters ``p = at + gain @ y`` of the suspension.
    """
    import cvxpy

    cp: Any = cvxpy  # whose types leave out what it makes at run time
    y = cp.Variable(size)
    values = {"A": cp.Parameter((size, size)), **{name: cp.Parameter(size) for name in ("b", "low", "high")}}
    objective = cp.sum_squares(values["A"] @ y - values["b"])
    limits = [y >= values["low"], y <= values["high"]]
    if equal:
        values |= {"E": cp.Parameter((equal, size)), "e": cp.Parameter(equal)}
        limits.append(values["E"] @ y == values["e"])
    if below:
        values |= {"F": cp.Parameter((below, size)), "f": cp.Parameter(below)}
        limits.append(values["F"] @ y <= values["f"])
    if terms is not None:
        values |= {"gain": cp.Parameter((parameters, size)), "at": cp.Parameter(parameters)}
        further, penalty = terms(values["at"] + values["gain"] @ y)
        limits += further
        objective = objective if penalty is None else objective + penalty
    problem = cp.Problem(cp.Minimize(objective), limits)
    if not problem.is_dcp(dpp=True):
        raise AssertionError("the program must be disciplined in its parameters, or it is compiled anew each time")
    return Program(problem=problem, values=values, step=y)
