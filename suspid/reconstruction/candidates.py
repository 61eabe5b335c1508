"""The suspensions that may have the modes: where the descents from all starts end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from suspid.errors import ReconstructionError
from suspid.reconstruction.alternatives import distinct, even_starts, spectral_minima
from suspid.reconstruction.descent import bounded_step
from suspid.reconstruction.problem import DATA_AGAINST_PRIOR, LARGEST, Problem
from suspid.units import RealArray


@dataclass(frozen=True, slots=True)
class Collected:
    """Minima with the norms of their residuals, and the descents that failed."""

    problem: Problem
    points: list[RealArray] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)
    failures: list[ReconstructionError] = field(default_factory=list)

    def enter(self, find: Callable[[], RealArray]) -> None:
        """Keep what a search finds, or why it fails."""
        try:
            x = self.problem.unknowns.settled(find())
        except ReconstructionError as error:
            self.failures.append(error)
            return
        self.points.append(x)
        self.costs.append(self.problem.cost(x))

    def descend(self, x: RealArray, *, by_poles: bool = False) -> None:
        """Keep the minimum near x, by way of that of the poles alone if asked."""
        problem = self.problem
        self.enter(lambda: problem.descend(problem.descend(x, by_poles=True) if by_poles else x))

    @property
    def met(self) -> bool:
        """Whether one is so good that no other start is needed."""
        return bool(self.costs) and min(self.costs) <= self.problem.enough


def candidates(problem: Problem, *, search: bool) -> tuple[list[RealArray], list[float]]:
    """Return the distinct suspensions, as unknowns, that may have the modes, and the norms of their residuals."""
    found = _unconstrained(problem, search=search)
    if problem.wishes is not None:
        within = Collected(problem, failures=found.failures)
        for x in [*found.points, problem.unknowns.nominal]:
            within.enter(lambda x=x: problem.answer(problem.feasible(x)).x)  # type: ignore[misc]
        found = within
    if not found.points:
        raise found.failures[0]
    kept = distinct(found.points, found.costs, problem.unknowns)
    return [found.points[i] for i in kept], [found.costs[i] for i in kept]


def _unconstrained(problem: Problem, *, search: bool) -> Collected:
    """Return the minima between the bounds."""
    found, nominal = Collected(problem), problem.unknowns.nominal
    if problem.full and _by_shapes(found):
        return found
    if not (search and problem.enough_poles) or problem.unique:
        found.descend(nominal, by_poles=True)
        if problem.unique and search:
            # The solution is unique, but a descent from a rough start may end in a local minimum.
            _retry(found, [nominal, *even_starts(problem.unknowns, 12)])
        if problem.unique or (not search and found.costs and found.costs[-1] <= problem.enough):
            return found
    if problem.enough_poles:
        for x in spectral_minima(problem.tests, problem.unknowns, reach=problem.reach)[:12]:
            found.descend(x)
        if not found.met:
            found.descend(nominal, by_poles=True)
        return found
    found.descend(nominal)
    # The poles alone are too few to search by them.
    for x in even_starts(problem.unknowns, 24):
        found.descend(x, by_poles=True)
    return found


def _by_shapes(found: Collected) -> bool:
    """Start from the linear least squares of poles and shapes; return whether that is all that is needed."""
    problem = found.problem
    unknowns, (residual, slope) = problem.unknowns, problem.linear
    prior, pull = unknowns.prior(np.zeros(len(unknowns)))
    rows, target = np.vstack([slope, pull / DATA_AGAINST_PRIOR]), -np.append(residual, prior / DATA_AGAINST_PRIOR)
    start = bounded_step(rows, target, unknowns.lower, np.minimum(unknowns.upper, LARGEST))
    exact = replace(problem, wishes=None).exact(start)
    if exact:
        found.enter(lambda: start)
    else:
        found.descend(start)
    return problem.unique and bool(found.costs) and (exact or found.costs[0] <= problem.enough)


def _retry(found: Collected, starts: Sequence[RealArray]) -> None:
    """Descend from one start after the other until one minimum is good enough."""
    for number, x in enumerate(starts):
        if found.met:
            return
        found.descend(x, by_poles=number > 0)
