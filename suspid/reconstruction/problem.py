"""Tests and unknowns put together: one dimensionless problem, and the suspensions that may solve it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from suspid.errors import ReconstructionError
from suspid.model import Suspension, pole_distances
from suspid.reconstruction.alternatives import distinct, even_starts, spectral_minima
from suspid.reconstruction.descent import bounded_step, descend
from suspid.reconstruction.equations import EXACT, Observed, all_poles, deciding, linear, spectral
from suspid.reconstruction.observations import ModalTest, observe, printed, unweighted
from suspid.reconstruction.programs import Optimum, least_squares
from suspid.reconstruction.sequence import converged
from suspid.reconstruction.unknowns import Bounds, Unknowns, unknowns_of
from suspid.units import Ratio, RealArray

PULL = 0.01  # to the nominal values, beside relative errors of poles that are too few
STARTS = 24  # where the poles alone are too few to search by them
RETRIES = 12  # where a single answer is not reached from the nominal car
POLISHED = 12  # of the minima that the search finds
BLIND = 1e-8  # of the largest singular value: what the data do not see
LARGEST = 1e9  # of the scale of an unknown: where there is no bound
NEGLIGIBLE = 1e-8  # of chi-square: no step is worth so little
UNLIKELY_TWIN = 1e-4  # probability of the rise of chi-square from the best suspension to another
VAGUE = 0.05  # standard deviation of a shape's component above which shapes may not choose one suspension
NEAR_MISS = 5e-3  # relative distance from exact poles at which another suspension is mentioned
PRINTED = 5e-3  # of a pole's modulus: what printed modes are known to, if nothing else is said
DATA_AGAINST_PRIOR = 1e6  # weight of modes without covariance, which are exact, beside a nominal car's


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Tests, the unknowns of the suspension, and what modes without a covariance are known to (0: exact)."""

    tests: tuple[Observed, ...]
    unknowns: Unknowns
    known_to: Ratio = 0.0

    @property
    def weighted(self) -> bool:
        """Whether the modes carry a covariance that is used."""
        return self.tests[0].whiten is not None

    @property
    def shaped(self) -> bool:
        """Whether there are shapes."""
        return any(test.shapes is not None for test in self.tests)

    @cached_property
    def full(self) -> bool:
        """Whether the shapes make the problem linear."""
        if all(test.full for test in self.tests):
            return True
        return any(test.full for test in self.tests) and not len(self.unseen(self.linear[1], self.unknowns.nominal))

    @cached_property
    def unique(self) -> bool:
        """Whether the problem is linear, and its shapes too well known for another suspension within their spread."""
        vague = [1 / np.linalg.svd(t.whiten, compute_uv=False).min() for t in self.tests if t.whiten is not None]
        return self.full and (self.tests[0].poles_alone or bool(max(vague, default=0.0) <= VAGUE))

    @property
    def rows(self) -> int:
        """Number of rows of the deciding residual."""
        return sum(test.rows for test in self.tests) + int(np.sum(self.unknowns.has_prior))

    @property
    def enough_poles(self) -> bool:
        """Whether the poles alone are as many equations as there are unknowns."""
        return sum(test.pole_equations for test in self.tests) >= len(self.unknowns)

    @cached_property
    def enough(self) -> float:
        """Norm of the deciding residual at which no other start is needed."""
        from scipy.special import chdtri

        if not self.weighted:
            return EXACT
        known = int(np.sum(self.unknowns.has_prior))
        return float(np.sqrt(chdtri(max(self.rows - known - len(self.unknowns), 1), UNLIKELY_TWIN)))

    @cached_property
    def reach(self) -> Ratio:
        """Distance from the poles beyond which no minimum by the poles alone can have the modes."""
        if not self.weighted:
            return max(NEAR_MISS, self.known_to)
        return NEAR_MISS + 10 * max(
            float(1 / np.linalg.svd(t.whiten, compute_uv=False).min()) for t in self.tests if t.whiten is not None
        )

    def allowed(self, least: float) -> float:
        """Return the norm of the deciding residual up to which a suspension has the modes, given the least one."""
        from scipy.special import chdtri

        if self.weighted:
            return float(np.sqrt(least**2 + chdtri(1, UNLIKELY_TWIN)))
        return max(EXACT, 1.01 * least, self.known_to)

    def manner(self, x: RealArray) -> str:
        """Return how x was found, in words."""
        if self.full:
            manner = "one convex program on poles and shapes" + ", which has one answer" * self.unique
            return manner + ", refined by a sequence" * (not self.exact(x))
        return "sequence of convex programs on poles" + " and shapes" * self.shaped

    def exact(self, x: RealArray) -> bool:
        """Return whether shapes of all coordinates, taken as exact, leave nothing to improve."""
        if self.weighted or self.unknowns.has_prior.any() or not all(test.full for test in self.tests):
            return False
        residual, slope = self.linear
        return bool(np.linalg.norm(residual + slope @ x) <= EXACT)

    def deciding(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual that judges x, weighted, and its derivatives."""
        p, arms, spread = self.unknowns.parameters(x), self.unknowns.arms, self.unknowns.spread
        parts = [(r, s @ spread) for r, s in (deciding(test, arms, p) for test in self.tests)]
        if self.unknowns.has_prior.any():
            weight = 1.0 if self.weighted else DATA_AGAINST_PRIOR
            parts = [(weight * r, weight * s) for r, s in parts]
            parts.append(self.unknowns.prior(x))
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    def spectral(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the characteristic polynomials at the poles, and their derivatives; a pull to nominal if too few."""
        p, arms, spread = self.unknowns.parameters(x), self.unknowns.arms, self.unknowns.spread
        parts = [(r, s @ spread) for r, s in (spectral(test, arms, p) for test in self.tests)]
        if not self.enough_poles:
            parts.append((PULL * (x - self.unknowns.nominal), PULL * np.eye(len(x))))
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    @cached_property
    def linear(self) -> tuple[RealArray, RealArray]:
        """Return the linear equations of all tests that have them: residual at x = 0 and derivatives."""
        masses = np.diag(self.unknowns.car.M)
        parts = [linear(test, self.unknowns.arms, masses) for test in self.tests if test.full]
        residuals = [r + s @ self.unknowns.base for r, s in parts]
        return np.concatenate(residuals), np.concatenate([s for _, s in parts]) @ self.unknowns.spread

    def unseen(self, slope: RealArray, x: RealArray, least: Ratio = BLIND) -> RealArray:
        """Return the directions of the unknowns, in units of `Unknowns.sizes`, that equations of this slope miss."""
        _, values, directions = np.linalg.svd(slope * self.unknowns.sizes(x))
        values = np.concatenate([values, np.zeros(len(directions) - len(values))])
        return np.asarray(directions[values <= least * values[0]])

    def descend(self, x: RealArray, *, by_poles: bool = False) -> RealArray:
        """Return the minimum near x of the deciding residual, or of the polynomials at the poles."""
        u = self.unknowns
        equations = self.spectral if by_poles else self.deciding
        negligible = NEGLIGIBLE if self.weighted and not by_poles else 0.0
        return descend(equations, x, positive=u.positive, lower=u.lower, upper=u.upper, negligible=negligible)

    def answer(self, x: RealArray) -> Optimum:
        """Return the optimum that the convex program at x gives: of the linear equations if they are exact."""
        u = self.unknowns
        if self.exact(x):
            residual, slope = self.linear
            step = least_squares(slope, -residual - slope @ x, u.lower - x, np.minimum(u.upper, LARGEST) - x)
            return replace(step, x=u.settled(np.clip(x + step.x, u.lower, u.upper)))
        negligible = NEGLIGIBLE if self.weighted else 0.0
        best = converged(self.deciding, x, positive=u.positive, lower=u.lower, upper=u.upper, negligible=negligible)
        return replace(best, x=u.settled(best.x))


def posed(
    tests: Sequence[ModalTest],
    suspension: Suspension,
    fixed: Sequence[str],
    bounds: Bounds | None,
    ties: Sequence[Sequence[str]],
    nominal_std: Ratio | Mapping[str, Ratio] | None,
    free_masses: Sequence[str],
    tolerance: Ratio | None = None,
) -> tuple[Problem, list[str]]:
    """Return the checked, dimensionless problem, and what to tell about it."""
    notes: list[str] = []
    seen: list[Observed] = []
    for test in tests:
        one, said = observe(test, suspension)
        seen.append(one)
        notes += [note for note in said if note not in notes]
    rate = float(np.exp(np.mean(np.log(np.abs(np.concatenate([one.poles for one in seen]))))))
    unknowns = unknowns_of(
        suspension,
        rate=rate,
        fixed=fixed,
        bounds=bounds,
        ties=ties,
        nominal_std=nominal_std,
        free_masses=free_masses,
    )
    known = int(np.sum(unknowns.has_prior))
    equations = sum(one.equations for one in seen)
    if equations + known < len(unknowns):
        lack, names = len(unknowns) - equations - known, unknowns.labels
        raise ReconstructionError(
            f"{len(names)} unknowns ({', '.join(names)}) but {equations} equations from "
            f"{sum(len(one.poles) for one in seen)} modes: add modes, or shapes at more coordinates, or hold at least "
            f"{lack} with fixed=…, such as fixed=[{unknowns.names[-1]!r}]",
            best=suspension,
        )
    weighed = sum(one.pole_equations if one.poles_alone else one.equations for one in seen)
    if tests[0].modes.covariance is not None and weighed + known < len(unknowns):
        notes.append("not weighted: the covariance covers the poles alone, which are too few")
        seen = [unweighted(one) for one in seen]
    known_to = tolerance or 0.0
    if tolerance is None and seen[0].whiten is None and any(printed(test.modes) for test in tests):
        known_to = PRINTED
    problem = Problem(tests=tuple(seen), unknowns=unknowns, known_to=known_to)
    for i, one in enumerate(seen):
        meeting = pole_distances(one.poles, all_poles(one.poles)) < 1e-4
        if one.full and np.sum(meeting) > len(one.poles):
            alone = Problem(tests=(one,), unknowns=unknowns)
            if len(alone.unseen(alone.linear[1], unknowns.nominal, 1e-4)):
                notes.append("shapes not used: poles meet (critical damping), and their shapes with them")
                seen[i] = replace(one, shapes=None, weights=one.weights[:0], orders=one.orders[:0])
                problem = replace(problem, tests=tuple(seen))
    return problem, notes


def candidates(problem: Problem, *, search: bool) -> tuple[list[RealArray], list[float]]:
    """Return the distinct suspensions, as unknowns, that may have the modes, and the norms of their residuals."""
    unknowns = problem.unknowns
    points: list[RealArray] = []
    costs: list[float] = []
    failures: list[ReconstructionError] = []

    def add(x: RealArray) -> None:
        x = unknowns.settled(x)
        points.append(x)
        costs.append(float(np.linalg.norm(problem.deciding(x)[0])))

    def attempt(x: RealArray, *, by_poles: bool = False) -> None:
        try:
            add(problem.descend(problem.descend(x, by_poles=True) if by_poles else x))
        except ReconstructionError as error:
            failures.append(error)

    def told() -> tuple[list[RealArray], list[float]]:
        if not points:
            raise failures[0]
        kept = distinct(points, costs, unknowns)
        return [points[i] for i in kept], [costs[i] for i in kept]

    if problem.full:
        residual, slope = problem.linear
        prior, pull = unknowns.prior(np.zeros(len(unknowns)))
        rows, target = np.vstack([slope, pull / DATA_AGAINST_PRIOR]), -np.append(residual, prior / DATA_AGAINST_PRIOR)
        start = bounded_step(rows, target, unknowns.lower, np.minimum(unknowns.upper, LARGEST))
        exact = problem.exact(start)
        if exact:
            add(start)
        else:
            attempt(start)
        if problem.unique and costs and (exact or costs[0] <= problem.enough):
            return points, costs
    nominal = unknowns.nominal
    if not (search and problem.enough_poles) or problem.unique:
        attempt(nominal, by_poles=True)
        if problem.unique and search:
            # One answer, but the way to it from a rough start may end in a hollow: none is blamed on the car unasked.
            for x in (nominal, *even_starts(unknowns, RETRIES)):
                if costs and min(costs) <= problem.enough:
                    break
                attempt(x, by_poles=x is not nominal)
        if problem.unique or (not search and costs and costs[-1] <= problem.enough):
            return told()
    if problem.enough_poles:
        for x in spectral_minima(problem.tests, unknowns, reach=problem.reach)[:POLISHED]:
            attempt(x)
        if min(costs) > problem.enough:
            attempt(nominal, by_poles=True)
        return told()
    attempt(nominal)
    for x in even_starts(unknowns, STARTS):
        attempt(x, by_poles=True)
    return told()
