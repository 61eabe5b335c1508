"""Response of all channels to roads and forces on wheels, with derivatives by every parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.transfers import Physics
from suspid.greybox.trials import Trial
from suspid.model import Suspension
from suspid.units import ComplexArray, RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reach:
    """Power transfer from all roads, and from a force, to one channel, and derivatives of its logarithm.

    Roads count as incoherent and alike: their powers add up.
    """

    road: RealArray  # (line,)
    force: RealArray  # (line,)
    by_road: RealArray  # (line, parameter): of the logarithm
    by_force: RealArray


def reach(
    car: Suspension,
    trial: Trial,
    physics: Physics,
    s: ComplexArray,
    *,
    channel: int,
    wheel: int,
    rows: Sequence[int],
    mounts: Sequence[int],
) -> Reach:
    """Return how roads and a force on ``wheel`` reach a channel at the lines s.

    ``D(s) q = -A^T b(s) A_r r + f`` with A the arms of the struts, so a strut changes q by
    ``-D^-1 a db (a q + a_r r)``. Parameters are the ``rows`` of k, c and masses, then the relaxations of ``mounts``.
    """
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    struts, size = arms.shape
    rate = s[:, None] / (1 + physics.relaxation * s[:, None])
    b = physics.stiffness + physics.damping * rate
    D = np.einsum("lj,ja,jb->lab", b, arms, arms)
    D[:, np.arange(size), np.arange(size)] += s[:, None] ** 2 * physics.masses
    inverse = np.linalg.inv(D)
    unit = np.zeros((struts, 1))
    pushed = np.concatenate([road_arms, unit], axis=1)  # elongation of struts by roads, and by the force
    push = -np.einsum("lj,ja,jr->lar", b, arms, pushed)
    push[:, wheel, -1] = 1.0
    moved = inverse @ push
    derive = s ** trial.orders[channel] * physics.gains[channel]
    left = derive[:, None] * np.einsum("a,lab->lb", trial.weights[channel], inverse)
    shown = derive[:, None] * np.einsum("a,lar->lr", trial.weights[channel], moved)
    stretched = arms @ moved + pushed
    per_strut = left @ arms.T
    slopes = []
    for row in rows:
        j = row % struts if row < 2 * struts else row - 2 * struts
        if row < 2 * struts:
            factor = per_strut[:, j] * (rate[:, j] if row >= struts else 1.0)
            slopes.append(-factor[:, None] * stretched[:, j])
        else:
            slopes.append(-(left[:, j] * s**2)[:, None] * moved[:, j])
    by_relaxation = per_strut * physics.damping * rate**2
    slopes += [by_relaxation[:, j, None] * stretched[:, j] for j in mounts]
    every = np.array(slopes).reshape(len(slopes), *shown.shape).swapaxes(0, 1)
    change = 2 * (every * shown.conj()[:, None]).real
    power = np.abs(shown) ** 2
    road, force = power[:, :-1].sum(axis=1), power[:, -1]
    return Reach(
        road=road,
        force=force,
        by_road=change[:, :, :-1].sum(axis=2) / road[:, None],
        by_force=change[:, :, -1] / force[:, None],
    )
