"""Other suspensions with the same modes: where to look for them, and what would tell them apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.equations import Observed, partners, pole_distances, spectral
from suspid.modes import eigenmodes
from suspid.suspension import Suspension
from suspid.units import Ratio, RealArray
from suspid.unknowns import Unknowns

STARTS_PER_UNKNOWN = 16
STEPS = 80
DECADES = 1.0  # springs and masses from a tenth to ten times nominal
FARTHEST = 1e4  # times nominal, where the search turns back
SAME = 1e-3  # relative difference of parameters below which two suspensions are one
ROUNDING = 1e-11  # costs below it are equal
ADDED_SHARE = 0.3  # of a coordinate's mass, in the test that is proposed


def even_starts(unknowns: Unknowns, count: int) -> RealArray:
    """Return points that fill the surroundings of the nominal values evenly, the same ones each time, (start, unknown).

    An additive recurrence by powers of the root of ``g^(d+1) = g + 1``: springs and masses within a decade of nominal,
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

    All starts move at once, by damped Gauss-Newton steps on the characteristic polynomial, kept between bounds.
    Minima further from the poles than ``reach`` are left out, but for the nearest.
    """
    arms, positive = unknowns.arms, unknowns.positive

    def equations(x: RealArray) -> tuple[RealArray, RealArray]:
        p = unknowns.parameters(x)
        parts = [spectral(test, arms, p) for test in tests]
        return np.concatenate([r for r, _ in parts], axis=-1), np.concatenate([s for _, s in parts], axis=-2) @ spread

    spread, upper = unknowns.spread, np.minimum(unknowns.upper, FARTHEST)
    x = even_starts(unknowns, STARTS_PER_UNKNOWN * len(unknowns))
    residual, slope = equations(x)
    cost, damping = np.sum(residual**2, axis=1), np.full(len(x), 1e-2)
    ends: list[RealArray] = []
    costs: list[float] = []
    for _ in range(STEPS):
        size = np.where(positive, x, 1.0)
        scaled = slope * size[:, None, :]
        gradient = np.einsum("bru,br->bu", scaled, residual)
        stuck = ((x <= unknowns.lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0))
        scaled = np.where(stuck[:, None, :], 0.0, scaled)
        normal = scaled.swapaxes(1, 2) @ scaled
        diagonal = np.einsum("buu->bu", normal)
        largest = np.max(diagonal, axis=1, keepdims=True)
        weight = damping[:, None] * np.maximum(diagonal, 1e-6 * largest) + np.where(largest > 0, 0.0, 1.0)
        step = np.linalg.solve(
            normal + weight[:, :, None] * np.eye(x.shape[1]), -np.where(stuck, 0.0, gradient)[..., None]
        )[..., 0]
        step = np.clip(step, -1.0, 1.0)
        trial = np.where(positive, x * np.exp(np.where(positive, step, 0.0)), x + step)
        trial = np.clip(trial, unknowns.lower, upper)
        trial_residual, trial_slope = equations(trial)
        trial_cost = np.sum(trial_residual**2, axis=1)
        better = trial_cost < cost
        done = (cost < 1e-20) | (better & (cost - trial_cost < 1e-9 * cost)) | (damping > 1e8)
        x = np.where(better[:, None], trial, x)
        residual = np.where(better[:, None], trial_residual, residual)
        slope = np.where(better[:, None, None], trial_slope, slope)
        cost = np.where(better, trial_cost, cost)
        damping = np.where(better, damping / 5, 4 * damping)
        ends.extend(x[done])
        costs.extend(cost[done].tolist())
        x, residual, slope, cost, damping = (a[~done] for a in (x, residual, slope, cost, damping))
        if not len(x):
            break
    ends, costs = [*ends, *x], [*costs, *cost.tolist()]
    near = max(reach**2, min(costs))
    kept = [i for i, reached in enumerate(costs) if reached <= near]
    return distinct([ends[i] for i in kept], [costs[i] for i in kept], unknowns)


def distinct(points: Sequence[RealArray], costs: Sequence[float], unknowns: Unknowns) -> list[RealArray]:
    """Return the points that are not the same as one of lower cost, by ascending cost; of equals the first."""
    kept: list[RealArray] = []
    for i in np.argsort(np.maximum(costs, ROUNDING), kind="stable"):
        if not any(same(points[i], other, unknowns) for other in kept):
            kept.append(points[i])
    return kept


def same(a: RealArray, b: RealArray, unknowns: Unknowns) -> bool:
    """Return whether two points are one suspension: springs and masses relative, dampers to the strongest."""
    strongest = np.max(np.where(unknowns.positive, 0.0, np.maximum(a, b)), initial=1e-3)
    return bool(np.all(np.abs(a - b) <= SAME * np.where(unknowns.positive, np.maximum(a, b), strongest)))


def farness(x: RealArray, unknowns: Unknowns) -> float:
    """Return how far x is from nominal: root mean square over the unknowns of ``2 |a - b| / (a + b)``, at most 2."""
    total = x + unknowns.nominal
    return float(np.sqrt(np.mean((2 * (x - unknowns.nominal) / np.where(total > 0, total, 1.0)) ** 2)))


def told_apart(car: Suspension, other: Suspension, observed: Sequence[str]) -> str:
    """Return, in words, the two sensors and the added mass that show the difference of two suspensions best.

    Parameters
    ----------
    car, other : Suspension
        Two suspensions of one topology.
    observed : sequence of str
        Coordinates whose ratio is known already; other pairs are proposed.
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
    shift, where, load = 0.0, "", 0.0
    for name, mass in car.masses.items():
        loaded = [c.with_parameters(masses={name: m + ADDED_SHARE * mass}) for c, m in _masses(car, other, name)]
        one, two = (eigenmodes(c).poles for c in loaded)
        apart = pole_distances(one, two)
        moved = float(np.max(np.min(apart, axis=1)))
        if moved > shift:
            shift, where, load = moved, name, ADDED_SHARE * mass
    if shift > 0:
        said.append(f"a test with {load:.2g} kg added to {where} (a pole differs by {shift:.2%})")
    return " or ".join(said)


def _masses(car: Suspension, other: Suspension, name: str) -> list[tuple[Suspension, float]]:
    return [(c, c.masses[name]) for c in (car, other)]
