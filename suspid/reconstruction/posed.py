"""The problem as posed: tests, suspension and wishes checked and made dimensionless."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.errors import InputError, ReconstructionError
from suspid.model import Suspension, pole_distances
from suspid.reconstruction.asked import Bounds, unknowns_of
from suspid.reconstruction.contradictions import contradiction
from suspid.reconstruction.convexity import Maker
from suspid.reconstruction.equations import Observed, all_poles
from suspid.reconstruction.observations import ModalTest, observe, printed, unweighted
from suspid.reconstruction.problem import Problem
from suspid.reconstruction.unknowns import Unknowns
from suspid.reconstruction.wishes import Constraints, Wishes, wishes_of
from suspid.units import Ratio
from suspid.words import ReconstructionNote, Remark

PRINTED = 5e-3  # of a pole's modulus: what printed modes are known to, if nothing else is said


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Asked:
    """What the user asks for beside modes and suspension; see `reconstruct`."""

    fixed: Sequence[str] = ()
    bounds: Bounds | None = None
    ties: Sequence[Sequence[str]] = ()
    nominal_std: Ratio | Mapping[str, Ratio] | None = None
    free_masses: Sequence[str] = ()
    tolerance: Ratio | None = None
    constraints: Constraints | None = None
    penalty: Maker | None = None


def posed(tests: Sequence[ModalTest], suspension: Suspension, asked: Asked) -> tuple[Problem, list[Remark]]:
    """Return the checked, dimensionless problem, and remarks on it.

    Raises
    ------
    InputError
        If a name is unknown, wishes contradict each other, or modes cannot be used.
    ReconstructionError
        If there are fewer equations than unknowns.
    """
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
        known_to = PRINTED
    problem = Problem(tests=tuple(seen), unknowns=unknowns, known_to=known_to, wishes=wishes)
    usable = [_without_meeting(one, unknowns) for one in seen]
    if any(a is not b for a, b in zip(usable, seen, strict=True)):
        notes.append(Remark(ReconstructionNote.POLES_MEET))
        problem = replace(problem, tests=tuple(usable))
    return problem, notes


def _consistent(wishes: Wishes | None, unknowns: Unknowns) -> Wishes | None:
    """Return the wishes, if some suspension between the bounds keeps to them."""
    if wishes is None or wishes.violation(unknowns.nominal) <= 0:
        return wishes
    against = contradiction(wishes, unknowns.lower, unknowns.upper)
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
        f"{sum(len(one.poles) for one in seen)} modes: add modes, or shapes at more coordinates, or hold at least "
        f"{lack} with fixed=…, such as fixed=[{unknowns.names[-1]!r}]",
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
