"""The problem as posed: tests, suspension and wishes checked and made dimensionless."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from suspid.errors import InputError, ReconstructionError
from suspid.model import Suspension, pole_distances
from suspid.reconstruction.asked import Bounds, unknowns_of
from suspid.reconstruction.convexity import Maker
from suspid.reconstruction.equations import Observed, all_poles
from suspid.reconstruction.observations import ModalTest, observe, printed, unweighted
from suspid.reconstruction.problem import Problem
from suspid.reconstruction.programs import SOLVER
from suspid.reconstruction.unknowns import Unknowns
from suspid.reconstruction.wishes import Constraints, Wishes, wishes_of
from suspid.units import Ratio, RealArray
from suspid.wording import Argument, Listed
from suspid.words import ReconstructionNote, Remark


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Asked:
    """What the user asks for besides modes and suspension; see `reconstruct`."""

    fixed: Sequence[str] = ()
    bounds: Bounds | None = None
    ties: Sequence[Sequence[str]] = ()
    nominal_std: Ratio | Mapping[str, Ratio] | None = None
    free_masses: Sequence[str] = ()
    tolerance: Ratio | None = None
    constraints: Constraints | None = None
    penalty: Maker | None = None


def posed(tests: Sequence[ModalTest], suspension: Suspension, asked: Asked) -> tuple[Problem, list[Remark]]:
    """Return the checked, dimensionless problem, and remarks on it."""
    notes: list[Remark] = []
    seen: list[Observed] = []
    for test in tests:
        one, said = observe(test, suspension)
        seen.append(one)
        notes += [note for note in said if note not in notes]
    rate = float(np.exp(np.mean(np.log(np.abs(np.concatenate([one.poles for one in seen]))))))
    unknowns = unknowns_of(
        suspension,
        rate=rate,
        fixed=asked.fixed,
        bounds=asked.bounds,
        ties=asked.ties,
        nominal_std=asked.nominal_std,
        free_masses=asked.free_masses,
    )
    wishes = _consistent(wishes_of(asked.constraints, asked.penalty, unknowns), unknowns)
    known = int(np.sum(unknowns.has_prior)) + (0 if wishes is None else len(wishes.equations))
    if wishes is None or wishes.penalty is None:
        _enough(seen, unknowns, known, suspension)
    weighed = sum(one.pole_equations if one.poles_alone else one.equations for one in seen)
    if tests[0].modes.covariance is not None and weighed + known < len(unknowns):
        notes.append(Remark(ReconstructionNote.NOT_WEIGHTED))
        seen = [unweighted(one) for one in seen]
    known_to = asked.tolerance or 0.0
    if asked.tolerance is None and seen[0].whiten is None and any(printed(test.modes) for test in tests):
        # Printed modes are known to this share of a pole's modulus, if nothing else is said.
        known_to = 5e-3
    problem = Problem(tests=tuple(seen), unknowns=unknowns, known_to=known_to, wishes=wishes)
    usable = [_without_meeting(one, unknowns) for one in seen]
    if any(a is not b for a, b in zip(usable, seen, strict=True)):
        notes.append(Remark(ReconstructionNote.POLES_MEET))
        problem = replace(problem, tests=tuple(usable))
    return problem, notes


def check_asked(suspension: Suspension, asked: Asked) -> None:
    """Refuse what cannot be meant for this suspension, whatever the modes are.

    Raises
    ------
    InputError
        If a name is unknown, wishes contradict each other, or nothing is left to find.
    """
    unknowns = unknowns_of(
        suspension,
        rate=1.0,
        fixed=asked.fixed,
        bounds=asked.bounds,
        ties=asked.ties,
        nominal_std=asked.nominal_std,
        free_masses=asked.free_masses,
    )
    _consistent(wishes_of(asked.constraints, asked.penalty, unknowns), unknowns)


def _consistent(wishes: Wishes | None, unknowns: Unknowns) -> Wishes | None:
    """Return the wishes, if some suspension between the bounds keeps to them."""
    if wishes is None or wishes.violation(unknowns.nominal) <= 0:
        return wishes
    against = _contradiction(wishes, unknowns.lower, unknowns.upper)
    if against:
        raise InputError(f"constraints contradict each other: {', '.join(against)} cannot all hold; drop or relax one")
    return wishes


def _enough(seen: Sequence[Observed], unknowns: Unknowns, known: int, suspension: Suspension) -> None:
    """Raise if there are fewer equations than unknowns."""
    equations = sum(one.equations for one in seen)
    if equations + known >= len(unknowns):
        return
    lack, names = len(unknowns) - equations - known, unknowns.labels
    raise ReconstructionError(
        f"{len(names)} unknowns ({', '.join(names)}) but {equations} equations from "
        f"{sum(len(one.poles) for one in seen)} modes: add modes, or shapes at more coordinates, or fix at least "
        f"{lack} with ",
        Argument("fixed", "…"),
        ", such as ",
        Listed("fixed", tuple(unknowns.names[-lack:])),
        best=suspension,
    )


def _without_meeting(one: Observed, unknowns: Unknowns) -> Observed:
    """Return the modes of a test without their shapes where poles coincide and the shapes then determine nothing."""
    meeting = pole_distances(one.poles, all_poles(one.poles)) < 1e-4
    if not one.full or np.sum(meeting) <= len(one.poles):
        return one
    alone = Problem(tests=(one,), unknowns=unknowns)
    if not len(alone.unseen(alone.linear[1], unknowns.nominal, 1e-4)):
        return one
    return replace(one, shapes=None, weights=one.weights[:0], orders=one.orders[:0])


def _contradiction(wishes: Wishes, lower: RealArray, upper: RealArray) -> list[str]:
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
