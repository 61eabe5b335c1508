"""Motion of a suspension whose dampers have friction or piecewise linear curves.

Between two points of every curve such a suspension is linear. The motion is stepped by the exponential of the linear
system that holds, and where a damper passes a point of its curve the step is halved until it ends there. Friction is a
steep piece at rest: its force grows from zero to its full size over a velocity of `CREEP`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from suspid.model import Strut, Suspension, force_weights, slopes
from suspid.units import MetrePerSecond, RealArray, Second

# The piece of each law that holds.
Choice: TypeAlias = tuple[int, ...]
# Velocity up to which friction holds [m/s]: a stuck damper creeps no faster. Less meets the rounding of velocities.
CREEP: MetrePerSecond = 1e-9


@dataclass(frozen=True, kw_only=True, slots=True)
class Pieces:
    """Pieces of a curve: between ``ends`` the output is ``offset + slope * input``; one piece more than ends."""

    ends: RealArray
    offset: RealArray
    slope: RealArray


def law_of(strut: Strut) -> Pieces:
    """Return a damper's force over its velocity, or its velocity over its force where it is on a mount."""
    points = np.array(((0.0, 0.0), (1.0, strut.damping)) if strut.curve is None else strut.curve, float)
    inner, rate = points[1:-1], slopes(points.tolist())
    offset = points[:-1, 1] - rate * points[:-1, 0]
    velocities = inner[:, 0]
    if strut.mount_stiffness is None:
        if not strut.friction:
            return Pieces(ends=velocities, offset=offset, slope=rate)
        ends = np.sort(np.concatenate([velocities[np.abs(velocities) > CREEP], [-CREEP, CREEP]]))
        middle = (np.concatenate([[ends[0] - 1], ends]) + np.concatenate([ends, [ends[-1] + 1]])) / 2
        at = np.clip(np.searchsorted(points[:, 0], middle) - 1, 0, len(rate) - 1)
        held = np.abs(middle) < CREEP
        full = offset[at] + strut.friction * np.sign(middle)
        return Pieces(
            ends=ends, offset=np.where(held, 0.0, full), slope=np.where(held, strut.friction / CREEP, rate[at])
        )
    forces = inner[:, 1]
    forces = forces[np.abs(forces) > 0] if strut.friction else forces
    ends = forces + strut.friction * np.sign(forces)
    if strut.friction:
        ends = np.sort(np.concatenate([ends, [-strut.friction, strut.friction]]))
    middle = (np.concatenate([[ends[:1].sum() - 1], ends]) + np.concatenate([ends, [ends[-1:].sum() + 1]])) / 2
    held = np.abs(middle) < strut.friction
    own = middle - strut.friction * np.sign(middle) * (strut.friction > 0)
    at = np.clip(np.searchsorted(points[:, 1], own) - 1, 0, len(rate) - 1)
    inverse = (own - points[at, 1]) / rate[at] + points[at, 0] - middle / rate[at]
    return Pieces(ends=ends, offset=np.where(held, 0.0, inverse), slope=np.where(held, 0.0, 1 / rate[at]))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Machine:
    """A suspension as one linear system for each choice of pieces.

    The state is that of `suspid.statespace` (coordinates, velocities, dampers on mounts), followed by the inputs with
    their derivatives and a one.
    """

    fixed: RealArray  # generator without the dampers that have pieces, (state, state)
    laws: tuple[Pieces, ...]  # of each damper that has pieces
    sees: RealArray  # what the law of each depends on, (damper, state)
    acts: RealArray  # what the output of each law drives, (damper, state)
    states: int  # of the suspension
    steps: dict[tuple[Choice, Second], RealArray] = field(default_factory=dict)  # exponentials in use
    known: dict[Choice, tuple[RealArray, RealArray, RealArray]] = field(default_factory=dict)

    def generator(self, choice: Choice) -> RealArray:
        """Return the generator of the linear system with the chosen pieces."""
        whole = self.fixed.copy()
        for law, piece, sees, acts in zip(self.laws, choice, self.sees, self.acts, strict=True):
            whole += np.outer(acts, law.slope[piece] * sees)
            whole[:, -1] += acts * law.offset[piece]
        return whole

    def step(self, choice: Choice, span: Second) -> RealArray:
        """Return the exponential of a step with the chosen pieces."""
        from scipy.linalg import expm

        if (choice, span) not in self.steps:
            # Exponentials that are kept; more appear only where times are not uniform.
            if len(self.steps) > 20_000:
                self.steps.clear()
            self.steps[choice, span] = np.asarray(expm(self.generator(choice) * span))
        return self.steps[choice, span]

    def limits(self, choice: Choice) -> tuple[RealArray, RealArray, RealArray]:
        """Return the ends of the chosen pieces, and the rate of what each law depends on, (damper, state)."""
        if choice not in self.known:
            ends = [np.concatenate([[-np.inf], law.ends, [np.inf]]) for law in self.laws]
            low = np.array([one[piece] for one, piece in zip(ends, choice, strict=True)])
            high = np.array([one[piece + 1] for one, piece in zip(ends, choice, strict=True)])
            self.known[choice] = low, high, self.sees @ self.generator(choice)
        return self.known[choice]

    def choice(self, state: RealArray) -> Choice:
        """Return the pieces that hold."""
        return tuple(
            int(np.searchsorted(law.ends, value)) for law, value in zip(self.laws, self.sees @ state, strict=True)
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Driving:
    """What moves a suspension: names of inputs, and how many of their derivatives are states, their values included."""

    roads: tuple[str, ...] = ()
    rates: tuple[str, ...] = ()  # roads whose rate is an input of its own
    forces: tuple[str, ...] = ()
    degrees: int = 2


def state_labels(car: Suspension) -> list[str]:
    """Return the names of the states of a suspension with friction or curves, as `suspid.statespace` names them."""
    motions = [f"{kind}_{c}" for kind in ("z", "v") for c in car.coordinates]
    return [*motions, *(f"d_{car.struts[i].name}" for i in _mounted(car))]


def _mounted(car: Suspension) -> list[int]:
    return [i for i, s in enumerate(car.struts) if s.mount_stiffness is not None and (s.damping or not s.linear)]


def machine_of(car: Suspension, driving: Driving) -> Machine:
    """Return the machine of a suspension; its inputs are roads, rates of roads and forces, each with derivatives."""
    roads, rates, forces, degrees = driving.roads, driving.rates, driving.forces, driving.degrees
    n, struts = len(car.coordinates), car.struts
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    mounted = _mounted(car)
    width = len(roads) + len(rates) + len(forces)
    size = 2 * n + len(mounted)
    total = size + degrees * width + 1
    elongation, rate = np.zeros((len(struts), total)), np.zeros((len(struts), total))
    elongation[:, :n], rate[:, n : 2 * n] = arms, arms
    for i, road in enumerate(roads):
        column = road_arms[:, car.roads.index(road)]
        elongation[:, size + i] = column
        own = size + len(roads) + rates.index(road) if road in rates else size + width + i
        rate[:, own] += column
    inverse_mass = 1 / np.diag(car.M)
    fixed = np.zeros((total, total))
    fixed[:n, n : 2 * n] = np.eye(n)
    fixed[size : size + (degrees - 1) * width, size + width : size + degrees * width] = np.eye((degrees - 1) * width)
    for i, force in enumerate(forces):
        fixed[n : 2 * n, size + len(roads) + len(rates) + i] = inverse_mass * force_weights(car, force)
    laws, sees, acts = [], [], []
    for i, strut in enumerate(struts):
        pull = np.zeros(total)
        pull[n : 2 * n] = -inverse_mass * arms[i]
        fixed += np.outer(pull, strut.stiffness * elongation[i])
        if i not in mounted and strut.linear:
            fixed += np.outer(pull, strut.damping * rate[i])
            continue
        laws.append(law_of(strut))
        if i in mounted:
            stretch = elongation[i].copy()
            stretch[2 * n + mounted.index(i)] -= 1
            fixed += np.outer(pull, float(strut.mount_stiffness or 0.0) * stretch)
            sees.append(float(strut.mount_stiffness or 0.0) * stretch)
            acts.append(np.eye(total)[2 * n + mounted.index(i)])
        else:
            sees.append(rate[i])
            acts.append(pull)
    return Machine(fixed=fixed, laws=tuple(laws), sees=np.array(sees), acts=np.array(acts), states=size)
