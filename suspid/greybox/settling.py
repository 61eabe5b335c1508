"""Joint iteration of unknowns and noise levels of drives; mounts or gains that fit only chance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from suspid.greybox.further import TIMES
from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.noise_levels import Levels
from suspid.greybox.whitened import Whitened
from suspid.levels import CHI_SQUARE_95, EXACT
from suspid.reconstruction import descend
from suspid.units import RealArray

NEGLIGIBLE_RISE = 1e-3  # gain of chi-square that ends a descent
ROUGH_RISE = 0.3  # the same where another descent follows, or a decision at a gain of 3.8
SOFT = (0.2, 0.5)  # relaxations from which softer mounts are looked for, of `TIMES`: 2 and 5 ms


class Point(NamedTuple):
    """Unknowns, and what the records leave there at some noise levels."""

    z: RealArray
    every: list[Whitened]
    cost: float  # sum of squares


def point_at(problem: WheelProblem, z: RealArray, levels: Sequence[Levels]) -> Point:
    """Return what the records leave at some unknowns."""
    every = problem.every(z, levels)
    return Point(z, every, float(np.sum(problem.compressed(z, every)[0] ** 2)))


def descended(
    problem: WheelProblem,
    z: RealArray,
    levels: Sequence[Levels],
    *,
    extras: tuple[RealArray, RealArray] | None = None,
    negligible: float = NEGLIGIBLE_RISE,
) -> Point:
    """Return the best unknowns near a start at given noise levels, perhaps with other bounds of the extras."""
    u, more = problem.unknowns, problem.extras
    low, high = (more.lower, more.upper) if extras is None else extras
    lower, upper = np.concatenate([u.lower, low]), np.concatenate([u.upper, high])
    best: list[Point] = []

    def equations(y: RealArray) -> tuple[RealArray, RealArray]:
        every = problem.every(y, levels)
        residual, slope = problem.compressed(y, every)
        here = Point(y, every, float(np.sum(residual**2)))
        if not best or here.cost < best[0].cost:
            best[:] = [here]
        return residual, slope

    descend(
        equations,
        np.clip(z, lower, upper),
        positive=np.concatenate([u.positive, more.positive]),
        lower=lower,
        upper=upper,
        negligible=negligible,
        secant=True,
    )
    return best[0]


def settled(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> tuple[RealArray, list[Levels]]:
    """Return unknowns and noise levels that belong to each other, near a start."""
    # Fits and noise levels in turn: 3 to 6 rounds are needed. The first levels are a guess, which nothing rests on.
    for turn in range(12):
        before = z
        z, every, _ = descended(problem, z, levels, negligible=NEGLIGIBLE_RISE if turn else ROUGH_RISE)
        levels = problem.levels(every, levels)
        # Change of the unknowns, in standard deviations, below which both have settled.
        if sum(float(np.sum((w.rows()[1] @ (z - before)) ** 2)) for w in every) < 0.02**2:
            break
    return z, levels


def released(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> tuple[Point, list[Levels]]:
    """Return the best of the unknowns that were found and those on the other side of the ridge between stiff and soft.

    A mount acts nearly as a negative delay does, so there may be a minimum without a mount beside the right one. The
    softer one is taken if the records rule out the stiffer one.
    """
    extras = problem.extras
    if not extras.mounts:
        return point_at(problem, z, levels), levels
    # Of each point its cost alone is kept: of long stretches a point takes more than the record.
    cost = point_at(problem, z, levels).cost
    count, mounts = len(problem.unknowns), len(extras.mounts)
    best = cost, z
    for soft in SOFT:
        start = z.copy()
        start[count : count + mounts] = soft
        late = np.array([name.endswith(".delay") for name in extras.names])
        start[count:][late] += soft - float(np.mean(z[count : count + mounts]))
        soft_z, _, soft_cost = descended(problem, start, levels, negligible=ROUGH_RISE)
        best = (soft_cost, soft_z) if soft_cost < best[0] else best
    if cost - best[0] >= CHI_SQUARE_95:
        z, levels = settled(problem, best[1], levels)
    return point_at(problem, z, levels), levels


def from_held(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> RealArray:
    """Return how far the unknowns are from those of the best car with gains, delays and mounts as stated.

    What a car lacks passes for a gain of the sensor, a delay or a mount, as far as it can.
    """
    u, extras = problem.unknowns, problem.extras
    stated = extras.start.copy()
    stated[: len(extras.mounts)] = [u.car.struts[j].relaxation / TIMES for j in extras.mounts]
    held = descended(problem, z, levels, extras=(stated - EXACT, stated + EXACT)).z
    positive = np.concatenate([u.positive, extras.positive])
    ratio = np.where(positive, z, 1.0) / np.where(positive, held, 1.0)
    return np.asarray(np.where(positive, z * np.log(ratio), z - held))
