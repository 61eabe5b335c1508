"""Which constraints and bounds contradict each other."""

from __future__ import annotations

from typing import Any

import numpy as np

from suspid.errors import ReconstructionError
from suspid.reconstruction.programs import SOLVER
from suspid.reconstruction.wishes import Wishes
from suspid.units import RealArray


def contradiction(wishes: Wishes, lower: RealArray, upper: RealArray) -> list[str]:
    """Return, in words, constraints and bounds that cannot all hold and none of which can be missed; else nothing."""
    labels = wishes.unknowns.labels
    items: list[tuple[str, int]] = [("constraint", i) for i in range(len(wishes.labels))]
    items += [("low", i) for i in range(len(lower))] + [
        ("high", i) for i in np.flatnonzero(np.isfinite(upper)).tolist()
    ]
    if not _impossible(wishes, items, lower, upper):
        return []
    for item in list(items)[::-1]:
        rest = [other for other in items if other != item]
        if _impossible(wishes, rest, lower, upper):
            items = rest
    words = []
    for kind, i in items:
        end = {"low": lower, "high": upper}.get(kind)
        if end is None:
            words.append(f'"{wishes.labels[i]}"')
        else:
            value = end[i] * wishes.unknowns.scale[i]
            words.append(f"{labels[i]} {'>=' if kind == 'low' else '<='} {value:.6g}")
    return words


def _impossible(wishes: Wishes, items: list[tuple[str, int]], lower: RealArray, upper: RealArray) -> bool:
    """Return whether these constraints and bounds cannot all hold: the least largest violation is not zero."""
    import cvxpy

    cp: Any = cvxpy
    x, worst = cp.Variable(len(lower)), cp.Variable(nonneg=True)
    chosen = {i for kind, i in items if kind == "constraint"}
    limits = [x[i] >= lower[i] - worst for kind, i in items if kind == "low"]
    limits += [x[i] <= upper[i] + worst for kind, i in items if kind == "high"]
    for row, limit, equal, owner in zip(wishes.matrix, wishes.limit, wishes.equal, wishes.owner, strict=True):
        if owner in chosen:
            off = row @ x - limit
            limits += [off <= worst, -off <= worst] if equal else [off <= worst]
    limits += wishes.terms(wishes.unknowns.base + wishes.unknowns.spread @ x, chosen)[0]
    problem = cp.Problem(cp.Minimize(worst), limits)
    try:
        problem.solve(solver=SOLVER)
    except cp.error.SolverError as error:
        raise ReconstructionError(
            f"whether the constraints contradict each other could not be found: {error}"
        ) from None
    return worst.value is None or float(worst.value) > 1e-6
