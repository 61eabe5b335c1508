"""Search for a damper's curve over several roads: their figures by its damper rate, and the program for its slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from suspid.model import Suspension, output_rows
from suspid.performance.choices import REACHED
from suspid.performance.figure_plan import Plan
from suspid.performance.road_response import Signals, exact_grid, moments
from suspid.performance.tune import NO_FIGURE
from suspid.simulation import Road
from suspid.units import Ratio, RealArray

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

# Slopes of neighbouring pieces differ by no more than this factor, as those of valves do; a sharper bend makes the
# velocity less Gaussian.
BEND = 2.0
# Weight of the bends of a curve beside the logarithm of the objective: it decides between curves that are equally good.
EVENNESS = 1e-4
# Where a search ends: the mean logarithm no longer changes by this.
SAME_COST = 1e-10


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class OnRoad:
    """Figures of the car on one road, and the rms velocity of the damper, by the logarithm of the damper rate."""

    road: Road
    units: tuple[str, ...]
    figures: CubicSpline  # logarithms, (figure,)
    speed: CubicSpline  # logarithm

    def at(self, rates: RealArray | float) -> RealArray:
        """Return the figures at damper rates, (rate, figure)."""
        return np.asarray(np.exp(self.figures(np.log(rates))), float)


def on_road(car: Suspension, strut: str, plan: Plan, rates: RealArray) -> OnRoad:
    """Compute a car with each damper rate on a road."""
    from scipy.interpolate import CubicSpline

    travel = Signals(rows=output_rows(car, [f"{strut}_travel"]), weightings=(None,), loads=0)
    figures, speeds = [], []
    for rate in rates.tolist():
        one = car.with_parameters(damping={strut: rate})
        grid = exact_grid(one, plan.signals, plan.road)
        figures.append(plan.values(one, grid=grid)[0])
        # The grid of the figures holds their weighting; the velocity has none.
        speeds.append(moments(one, travel, exact_grid(one, travel, plan.road)).rate[0])
    logs = np.log(np.maximum(figures, NO_FIGURE))
    return OnRoad(
        road=plan.road,
        units=tuple(unit for unit, _, _ in plan.formulas.values()),
        figures=CubicSpline(np.log(rates), logs),
        speed=CubicSpline(np.log(rates), 0.5 * np.log(speeds)),
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Search:
    """The program for slopes of a curve, with the damper rates of equal work on the roads as unknowns of their own."""

    places: Sequence[OnRoad]
    knots: RealArray
    low: float
    high: float
    tops: RealArray  # logarithms, (figure,)

    def best(self, starts: Sequence[RealArray]) -> tuple[RealArray | None, RealArray, Ratio]:
        """Return the slopes and the rates of equal work of the best of the searches, and how many of them agree."""
        from scipy.optimize import minimize

        roads, pieces = len(self.places), len(self.knots) + 1
        box = [(np.log(self.low), np.log(self.high))] * (roads + pieces)
        rules: Any = [
            {"type": "eq", "fun": self._work},
            {"type": "ineq", "fun": self._room},
            {"type": "ineq", "fun": self._bends},
        ]
        ends = []
        for start in starts:
            x = np.concatenate([np.log(start), np.full(pieces, np.mean(np.log(start)))])
            ends.append(minimize(self._cost, x, method="SLSQP", bounds=box, constraints=rules, tol=SAME_COST))
        good = [
            end.x for end in ends
            if np.max(np.abs(self._work(end.x))) < REACHED and np.min(self._room(end.x), initial=0.0) > -REACHED
        ]  # fmt: skip
        if not good:
            return None, np.zeros(roads), 0.0
        costs = np.array([self._cost(x) for x in good])
        x = good[int(np.argmin(costs))]
        return np.exp(x[roads:]), np.exp(x[:roads]), float(np.sum(costs < costs.min() + REACHED)) / len(starts)

    def _cost(self, x: RealArray) -> float:
        at = [float(place.figures(c)[0]) for place, c in zip(self.places, x[: len(self.places)], strict=True)]
        return float(np.mean(at) + EVENNESS * np.sum(np.diff(x[len(self.places) :]) ** 2))

    def _work(self, x: RealArray) -> RealArray:
        """Return by how much the work of the curve is off on each road, in logarithms."""
        roads = len(self.places)
        speed = np.exp([float(place.speed(c)) for place, c in zip(self.places, x[:roads], strict=True)])
        return np.asarray(np.log(_shares(self.knots, speed) @ np.exp(x[roads:])) - x[:roads])

    def _room(self, x: RealArray) -> RealArray:
        """Return how far the limits are from the figures on each road, in logarithms."""
        use = np.isfinite(self.tops)
        figures = np.array([place.figures(c) for place, c in zip(self.places, x[: len(self.places)], strict=True)])
        return np.asarray((self.tops - figures)[:, use].ravel())

    def _bends(self, x: RealArray) -> RealArray:
        turned = np.diff(x[len(self.places) :])
        return np.concatenate([np.log(BEND) - turned, np.log(BEND) + turned])


def _shares(knots: RealArray, speed: RealArray) -> RealArray:
    """Return the probability that a Gaussian speed lies between neighbouring knots, (speed, piece)."""
    from scipy.special import erf

    edges = np.concatenate([[0.0], knots])
    below = np.concatenate([erf(edges / (np.sqrt(2) * speed[:, None])), np.ones((len(speed), 1))], axis=1)
    return np.asarray(np.diff(below, axis=1))
