"""Cone programs: whether a solution is the optimum, and the exact solution on the constraints that act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from suspid.units import RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Cone:
    """A cone program: least ``x' P x / 2 + c' x``, with the slack ``b - A x`` in a product of cones.

    The first ``zero`` slacks are zero, the next ``nonneg`` are not negative; further ones are in other cones.
    """

    P: RealArray
    c: RealArray
    A: RealArray
    b: RealArray
    zero: int
    nonneg: int


def cone_of(data: Mapping[str, Any]) -> Cone:
    """Return the cone program that cvxpy hands to a solver, with full matrices."""
    c = np.asarray(data["c"], float)
    P = np.zeros((len(c), len(c))) if data["P"] is None else data["P"].toarray()
    dims = data["dims"]
    return Cone(P=P, c=c, A=data["A"].toarray(), b=np.asarray(data["b"]), zero=dims.zero, nonneg=dims.nonneg)


def optimality(cone: Cone, primal: RealArray, dual: RealArray) -> float:
    """Return the largest violation of the optimality conditions of a cone program, relative to its own terms [1].

    Tested are stationarity, equalities, signs of slacks and of duals, and that the two are perpendicular.
    """
    if not (np.all(np.isfinite(primal)) and np.all(np.isfinite(dual))):
        return np.inf
    slack = cone.b - cone.A @ primal
    terms = (cone.P @ primal, cone.c, cone.A.T @ dual)
    largest = max(1.0, *(float(np.max(np.abs(term), initial=0.0)) for term in terms))
    zero, ends = cone.zero, slice(cone.zero, cone.zero + cone.nonneg)
    return float(
        max(
            np.max(np.abs(sum(terms))) / largest,
            np.max(np.abs(slack[:zero]), initial=0.0),
            np.max(-slack[ends], initial=0.0),
            np.max(-dual[ends], initial=0.0) / largest,
            abs(slack[zero:] @ dual[zero:]) / largest,
        )
    )


def sharpened(cone: Cone, primal: RealArray, dual: RealArray) -> tuple[RealArray, list[int], float]:
    """Return the better of a solver's solution and the exact one on the active rows; these rows, and its residual."""
    left, acting = optimality(cone, primal, dual), _acting(cone, primal, dual)
    if cone.zero + cone.nonneg == len(dual) and np.isfinite(left):
        exact = _exact_step(cone, acting)
        exactly_left = optimality(cone, *exact)
        if exactly_left <= left:
            return exact[0], acting, exactly_left
    return primal, acting, left


def _acting(cone: Cone, primal: RealArray, dual: RealArray) -> list[int]:
    """Return which rows hold with equality: equations, and inequalities whose dual exceeds their slack."""
    slack = cone.b - cone.A @ primal
    return [i for i in range(cone.zero + cone.nonneg) if i < cone.zero or dual[i] > slack[i]]


def _exact_step(cone: Cone, acting: list[int]) -> tuple[RealArray, RealArray]:
    """Return primal and dual solution of a quadratic program, given the rows that hold with equality."""
    rows, n = cone.A[acting], len(cone.c)
    matrix = np.block([[cone.P, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    target = np.concatenate([-cone.c, cone.b[acting]])
    inverse = np.linalg.pinv(matrix, rcond=1e-14, hermitian=True)
    both = inverse @ target
    for _ in range(2):  # iterative refinement: the matrix has the squared condition of the least squares
        both = both + inverse @ (target - matrix @ both)
    dual = np.zeros(len(cone.b))
    dual[acting] = both[n:]
    return both[:n], dual
