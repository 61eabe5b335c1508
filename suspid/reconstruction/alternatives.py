"""Search for other suspensions with the same modes, and measurements that would distinguish them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.model import Suspension, eigenmodes, pole_distances
from suspid.reconstruction.descent import Equations
from suspid.reconstruction.equations import Observed, partners
from suspid.reconstruction.polynomials import polynomial_of
from suspid.reconstruction.unknowns import Unknowns
from suspid.units import ComplexArray, Ratio, RealArray

ROUNDS = 4  # largest number of rounds of starts
OFTEN = 3  # the search ends when every minimum was reached this often; at 1 rare minima are missed
DECADES = 1.5  # starts lie between 1/30 and 30 times nominal springs and masses, because rare minima are far away
SAME = 1e-3  # relative difference of parameters below which two suspensions count as one
COST_ROUNDING = 1e-11  # costs below it count as equal
ARRIVED = 1e-13  # squared distance from the poles at which a start has converged
ADDED_SHARE = 0.3  # mass added in the proposed test, relative to that of the coordinate


@dataclass(frozen=True, kw_only=True, slots=True)
class Pace:
    """When the descents from many points end."""

    steps: int  # at most
    damping: float  # of the first step
    share: float  # of its cost: a point stops where a step gains less
    firm: float  # largest damping at which that counts
    left: float  # share of the points with which all end: waiting for the slowest costs more than it finds


# Most starts need 10 to 15 steps.
FAST = Pace(steps=40, damping=1e-2, share=1e-3, firm=np.inf, left=0.2)
# From near a minimum steps need next to no damping; a larger one would make every gain small.
FIRM = Pace(steps=60, damping=1e-4, share=1e-6, firm=1e-3, left=0.0)


def even_starts(unknowns: Unknowns, count: int) -> RealArray:
    """Return a fixed low-discrepancy sequence of points around the nominal values, (start, unknown).

    An additive recurrence by powers of the root of ``g^(d+1) = g + 1``: springs and masses within `DECADES` of nominal,
    dampers from none to a strong one.
    """
    dimensions, golden = len(unknowns), 2.0
    for _ in range(60):
        golden = (1 + golden) ** (1 / (1 + dimensions))
    around = np.arange(1, count + 1)[:, None] * golden ** -np.arange(1.0, dimensions + 1) % 1
    nominal = np.where(unknowns.positive, unknowns.nominal, np.maximum(unknowns.nominal, 0.1))
    spread = np.where(unknowns.positive, nominal * 10 ** (DECADES * (2 * around - 1)), 4 * around**2 * nominal)
    return np.clip(spread, unknowns.lower, unknowns.upper)


def spectral_minima(tests: Sequence[Observed], unknowns: Unknowns, *, reach: Ratio) -> list[RealArray]:
    """Return distinct minima of the distance from the poles, nearest first, from starts spread around nominal.

    The nominal values are the first start. Starts are added until every minimum was reached `OFTEN` times or a round
    finds no new one. Minima farther from the poles than ``reach`` are dropped, except the nearest. A minimum that the
    nominal values alone lead to is not asked for again: a symmetric car keeps its symmetry on the way, and may end
    between two others that mirror each other.
    """
    equations = polynomial_equations(tests, unknowns)
    # Starts per unknown, of a quarter car at most and of larger ones. Fewer miss rare minima, more cost time.
    count = len(unknowns) * (12 if len(unknowns) <= 6 else 48)
    starts = np.vstack([unknowns.nominal, even_starts(unknowns, ROUNDS * count)])
    points, costs, before = np.empty((0, len(unknowns))), np.empty(0), 0
    rough: list[RealArray] = []
    for first in range(0, ROUNDS * count, count):
        more, their_costs = descend_together(equations, starts[first : first + count], unknowns)
        points, costs = np.vstack([points, more]), np.append(costs, their_costs)
        minima, met = gathered(points, costs, unknowns, reach)
        if met_often(met):
            break
        # Ends along one flat valley count as many minima until they have reached its lowest point.
        near = np.flatnonzero((costs <= max(reach**2, float(np.min(costs)))) & (costs >= ARRIVED))
        near = near[near >= first]
        if len(near):
            rough += minima
            points[near], costs[near] = descend_together(equations, points[near], unknowns, FIRM)
        minima, met = gathered(points, costs, unknowns, reach)
        if met_often(met) or len(minima) == before:
            break
        before = len(minima)
    if all(test.alone for test in tests):
        return minima
    # Weighted, a valley may have a minimum where the poles alone have none.
    return minima + [x for x in rough if not np.any(same(x, np.array(minima), unknowns))]


def met_often(met: Sequence[int]) -> bool:
    """Return whether every minimum that more than the nominal values lead to was reached `OFTEN` times."""
    return min((times for times in met if times), default=OFTEN) >= OFTEN


def polynomial_equations(tests: Sequence[Observed], unknowns: Unknowns) -> Equations:
    """Return the residual of the poles of all tests, with derivatives, as a function of many points."""
    every = [polynomial_of(test, unknowns) for test in tests]

    def together(x: RealArray) -> tuple[RealArray, RealArray]:
        parts = [one(x) for one in every]
        return np.concatenate([r for r, _ in parts], axis=1), np.concatenate([s for _, s in parts], axis=1)

    return every[0] if len(every) == 1 else together


def descend_together(
    equations: Equations, x: RealArray, unknowns: Unknowns, pace: Pace = FAST
) -> tuple[RealArray, RealArray]:
    """Minimise from many points at once by damped Gauss-Newton steps within bounds; return the ends and their costs.

    A point stops when a step reduces its cost little: the ends are refined later. The slowest points are cut off, at an
    infinite cost.
    """
    x, positive = x.copy(), unknowns.positive
    # No value in the search is larger, times nominal.
    lower, upper = unknowns.lower, np.minimum(unknowns.upper, 1e4)
    own, count = np.arange(x.shape[1]), len(x)
    residual, slope = equations(x)
    cost, damping = np.sum(residual**2, axis=1), np.full(len(x), pace.damping)
    ends, costs, place = x.copy(), np.full(count, np.inf), np.arange(count)
    for _ in range(pace.steps):
        unit = np.where(positive, x, 1.0)
        gradient = (residual[:, None, :] @ slope)[:, 0] * unit
        stuck = ((x <= lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0))
        unit[stuck] = gradient[stuck] = 0.0
        scaled = slope * unit[:, None, :]
        normal = scaled.swapaxes(1, 2) @ scaled
        diagonal = normal[:, own, own]
        largest = diagonal.max(axis=1, keepdims=True)
        # Unknowns without any slope must not make the matrix singular.
        normal[:, own, own] += damping[:, None] * np.maximum(diagonal, 1e-6 * largest) + stuck + (largest <= 0)
        # Longest step, in the logarithm of springs and masses, and in dampers themselves.
        step = np.maximum(np.minimum(_solved(normal, -gradient), 1.5), -1.5)
        trial = x + step
        trial[:, positive] = x[:, positive] * np.exp(step[:, positive])
        trial = np.minimum(np.maximum(trial, lower), upper)
        trial_residual, trial_slope = equations(trial)
        trial_cost = (trial_residual * trial_residual).sum(axis=1)
        better = trial_cost < cost
        little = better & (cost - trial_cost < pace.share * cost) & (damping <= pace.firm)
        # So small a step that gains nothing is rounding.
        rounding = ~better & (np.max(np.abs(step), axis=1) < 1e-8)
        done = (cost < ARRIVED) | little | rounding | (damping > 1e8)
        np.copyto(x, trial, where=better[:, None])
        np.copyto(residual, trial_residual, where=better[:, None])
        np.copyto(slope, trial_slope, where=better[:, None, None])
        cost = np.where(better, trial_cost, cost)
        damping *= np.where(better, 0.2, 4.0)
        if done.any():
            ends[place[done]], costs[place[done]] = x[done], cost[done]
            x, residual, slope, cost, damping, place = (a[~done] for a in (x, residual, slope, cost, damping, place))
            if len(x) <= pace.left * count:
                return ends, costs
    ends[place], costs[place] = x, cost
    return ends, costs


def gathered(
    points: RealArray, costs: RealArray, unknowns: Unknowns, reach: Ratio
) -> tuple[list[RealArray], list[int]]:
    """Return the distinct points within reach, at least the nearest, by ascending cost, and how often each was met.

    What the first point alone has met counts as 0.
    """
    order = np.argsort(np.maximum(costs, COST_ROUNDING**2), kind="stable")
    order = order[costs[order] <= max(reach**2, float(np.min(costs)))]
    left = points[order]
    minima: list[RealArray] = []
    met: list[int] = []
    while len(left):
        one = same(left[0], left, unknowns)
        minima.append(left[0])
        met.append(int(np.sum(one)) if np.any(order[one] > 0) else 0)
        left, order = left[~one], order[~one]
    return minima, met


def distinct(points: Sequence[RealArray], costs: Sequence[float], unknowns: Unknowns) -> list[int]:
    """Return the indices of distinct points by ascending cost; of equal points the first."""
    kept: list[int] = []
    for i in np.argsort(np.maximum(costs, COST_ROUNDING), kind="stable").tolist():
        if not any(same(points[i], points[j], unknowns) for j in kept):
            kept.append(i)
    return kept


def same(a: RealArray, b: RealArray, unknowns: Unknowns) -> NDArray[np.bool_]:
    """Return whether two points (or one and each of many) are the same suspension.

    Springs and masses are compared with themselves, dampers with the strongest damper.
    """
    larger = np.maximum(a, b)
    # Springs and masses below a hundredth of nominal are compared relative to that.
    springs = np.maximum(larger, 1e-2)
    strongest = np.max(np.where(unknowns.positive, 0.0, larger), axis=-1, keepdims=True, initial=1e-3)
    return np.asarray(np.all(np.abs(a - b) <= SAME * np.where(unknowns.positive, springs, strongest), axis=-1))


def farness(x: RealArray, unknowns: Unknowns) -> float:
    """Return the distance of x from nominal: root mean square of ``2 |a - b| / (a + b)``, at most 2."""
    total = x + unknowns.nominal
    return float(np.sqrt(np.mean((2 * (x - unknowns.nominal) / np.where(total > 0, total, 1.0)) ** 2)))


def told_apart(car: Suspension, other: Suspension, observed: Sequence[str]) -> str:
    """Return, in words, the pair of sensors and the added mass that distinguish two suspensions best.

    Pairs of coordinates that are ``observed`` already are not proposed.
    """
    said = []
    ours, theirs = eigenmodes(car), eigenmodes(other)
    if ours.shapes is not None and theirs.shapes is not None and len(ours) == len(theirs):
        partner = partners(ours.poles, theirs.poles)
        a, b = ours.shapes, theirs.shapes[:, partner]
        best = (0.0, 0, 0, 0)
        for i, first in enumerate(car.coordinates):
            for j in range(i + 1, len(car.coordinates)):
                if first in observed and car.coordinates[j] in observed:
                    continue
                pair, twin = a[[i, j]], b[[i, j]]
                across = np.abs(pair[0] * twin[1] - pair[1] * twin[0])
                norms = np.linalg.norm(pair, axis=0) * np.linalg.norm(twin, axis=0)
                visible = np.minimum(np.linalg.norm(pair, axis=0), np.linalg.norm(twin, axis=0))
                angle = visible * across / np.where(norms > 0, norms, 1.0)
                best = max(best, (float(np.max(angle)), i, j, int(np.argmax(angle))))
        if best[0] > SAME:
            names = car.coordinates[best[1]], car.coordinates[best[2]]
            said.append(f"sensors at {names[0]} and {names[1]} (shape of mode {best[3] + 1} differs by {best[0]:.0%})")
    # With a mass added to each coordinate in turn, (coordinate, pole).
    ours_loaded, theirs_loaded = (_loaded_poles(c, ADDED_SHARE * np.diag(car.M)) for c in (car, other))
    moved = [
        float(np.max(np.min(pole_distances(a, b), axis=1))) for a, b in zip(ours_loaded, theirs_loaded, strict=True)
    ]
    most = int(np.argmax(moved))
    if moved[most] > 0:
        name = car.coordinates[most]
        load = ADDED_SHARE * car.masses[name]
        said.append(f"a test with {load:.2g} kg added to {name} (a pole differs by {moved[most]:.2%})")
    return " or ".join(said)


def _loaded_poles(car: Suspension, added: RealArray) -> ComplexArray:
    """Return the poles with the mass added to one coordinate at a time, (coordinate, pole)."""
    n = len(added)
    masses = np.diag(car.M) + np.diag(added)  # (coordinate loaded, coordinate)
    A = np.zeros((n, 2 * n, 2 * n))
    A[:, :n, n:] = np.eye(n)
    A[:, n:, :n], A[:, n:, n:] = -car.K / masses[:, :, None], -car.C / masses[:, :, None]
    return np.asarray(np.linalg.eigvals(A), complex)


def _solved(normal: RealArray, right: RealArray) -> RealArray:
    """Return the solution of each of many systems; where one is singular, the least one of all."""
    try:
        return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        # Poles many powers of ten apart; what leaves the range of floats is no step.
        inverse = np.linalg.pinv(np.nan_to_num(normal), hermitian=True)
        return np.nan_to_num((inverse @ right[..., None])[..., 0])
