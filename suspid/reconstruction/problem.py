"""One dimensionless problem: the equations of all tests, the unknowns and the wishes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from suspid.reconstruction.descent import Equations, descend, slope_left
from suspid.reconstruction.equations import EXACT_POLE, Observed, deciding, linear
from suspid.reconstruction.polynomials import polynomial_of
from suspid.reconstruction.programs import Limits, Optimum, least_squares
from suspid.reconstruction.sequence import converged, feasible
from suspid.reconstruction.unknowns import Unknowns
from suspid.reconstruction.wishes import Wishes
from suspid.units import Ratio, RealArray
from suspid.values import frozen_real
from suspid.words import ReconstructionNote, Remark

PULL = 0.01  # towards the nominal values, beside relative errors of poles, where there are too few poles
BLIND = 1e-8  # of the largest singular value: what the data do not see
LARGEST = 1e9  # of the scale of an unknown: where there is no bound
UNLIKELY_TWIN = 1e-4  # probability of the rise of chi-square from the best suspension to another
NEAR_MISS = 5e-3  # relative distance from exact poles at which another suspension is mentioned
DATA_AGAINST_PRIOR = 1e6  # weight of modes without covariance, which are exact, beside a nominal car's


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Tests, the unknowns, what modes without a covariance are known to (0: exact), and wishes."""

    tests: tuple[Observed, ...]
    unknowns: Unknowns
    known_to: Ratio = 0.0
    wishes: Wishes | None = None

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
        # Shapes with a component less well known than this may not choose one suspension.
        return self.full and (self.tests[0].poles_alone or bool(max(vague, default=0.0) <= 0.05))

    @property
    def has_nominal(self) -> bool:
        """Whether something besides the modes is weighed against them: nominal values or a penalty."""
        return bool(self.unknowns.has_prior.any()) or (self.wishes is not None and self.wishes.penalty is not None)

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
            return EXACT_POLE
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
        return max(EXACT_POLE, 1.01 * least, self.known_to)

    def manner(self, x: RealArray) -> Remark:
        """Return how x was found."""
        if self.full:
            return Remark(ReconstructionNote.LINEAR, {"unique": self.unique, "exact": self.exact(x)})
        return Remark(ReconstructionNote.SEQUENCE, {"data": "poles" + " and shapes" * self.shaped})

    def exact(self, x: RealArray) -> bool:
        """Return whether shapes of all coordinates, taken as exact, leave nothing to improve."""
        if (
            self.wishes is not None
            or self.weighted
            or self.unknowns.has_prior.any()
            or not all(test.full for test in self.tests)
        ):
            return False
        residual, slope = self.linear
        return bool(np.linalg.norm(residual + slope @ x) <= EXACT_POLE)

    @cached_property
    def deciding(self) -> Equations:
        """The residual that judges x, weighted, with its derivatives; search, fit and checks ask at the same points."""

        @lru_cache(maxsize=64)  # of the last points: all that checks come back to
        def at(point: bytes) -> tuple[RealArray, RealArray]:
            x = np.frombuffer(point)
            parts = [
                self._polynomial(number, x) if test.alone else self._sensitivities(test, x)
                for number, test in enumerate(self.tests)
            ]
            if self.has_nominal:
                weight = 1.0 if self.weighted else DATA_AGAINST_PRIOR
                parts = [(weight * r, weight * s) for r, s in parts]
            if self.unknowns.has_prior.any():
                parts.append(self.unknowns.prior(x))
            return frozen_real(np.concatenate([r for r, _ in parts])), frozen_real(
                np.concatenate([s for _, s in parts])
            )

        return lambda x: at(x.tobytes())

    def spectral(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the characteristic polynomials at the poles, and their derivatives; a pull to nominal if too few."""
        parts = [self._polynomial(number, x) for number in range(len(self.tests))]
        if not self.enough_poles:
            parts.append((PULL * (x - self.unknowns.nominal), PULL * np.eye(len(x))))
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    def _sensitivities(self, test: Observed, x: RealArray) -> tuple[RealArray, RealArray]:
        residual, slope = deciding(test, self.unknowns.arms, self.unknowns.parameters(x))
        return residual, slope @ self.unknowns.spread

    def _polynomial(self, test: int, x: RealArray) -> tuple[RealArray, RealArray]:
        residual, slope = self._polynomials[test](x[None])
        return residual[0], slope[0]

    @cached_property
    def _polynomials(self) -> list[Equations]:
        return [polynomial_of(test, self.unknowns) for test in self.tests]

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
        return descend(equations, x, positive=u.positive, lower=u.lower, upper=u.upper)

    def answer(self, x: RealArray) -> Optimum:
        """Return the optimum that convex programs give: one alone if equations that are linear are exact, else from x.

        A sequence of programs goes on from x to the minimum, however near to it the search has ended.
        """
        u = self.unknowns
        if self.exact(x):
            residual, slope = self.linear
            best = least_squares(slope, -residual, Limits(low=u.lower, high=np.minimum(u.upper, LARGEST)))
            return replace(best, x=u.settled(best.x))
        best = converged(self.deciding, x, positive=u.positive, lower=u.lower, upper=u.upper, wishes=self.wishes)
        return replace(best, x=u.settled(best.x))

    def alternative(self, x: RealArray, cost: float) -> RealArray:
        """Return the minimum at x: x itself if it meets the conditions of an optimum, else that of a program."""
        if self.wishes is not None or cost <= EXACT_POLE:
            return x
        left = slope_left(self.deciding, x, self.unknowns.lower, self.unknowns.upper)
        # An alternative from which a step gains less than 1e-9 of the squared residual needs no program of its own.
        if left <= 1e-9:
            return x
        return self.answer(x).x

    def feasible(self, x: RealArray) -> RealArray:
        """Return the point nearest to x that keeps to the constraints."""
        return x if self.wishes is None else feasible(x, self.unknowns.lower, self.unknowns.upper, self.wishes)

    def cost(self, x: RealArray) -> float:
        """Return the norm of the deciding residual, with the penalty as one more square."""
        penalty = 0.0 if self.wishes is None else self.wishes.penalised(x)
        return float(np.sqrt(np.sum(self.deciding(x)[0] ** 2) + penalty))

    def chi_square(self, x: RealArray) -> float:
        """Return the squared norm of the deciding residual, without the penalty."""
        return float(np.sum(self.deciding(x)[0] ** 2))
