"""Motion of modes under forces that follow it, in steps.

Friction may hold a mass; between its events the motion is in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.nonlinear.bent_motion import BentSteps
from suspid.identification.nonlinear.forces import OF_SPEED, Force, ForceKind, size_of
from suspid.identification.nonlinear.rubbed_motion import AHEAD, RubbedSteps
from suspid.units import ComplexArray, RealArray

# Angle by which the fastest mode turns in a step, at most [rad]. Forces have their mean within a step.
TURN = 0.25


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Structures:
    """Structures side by side: each has modes ``z' = theta z + sum_j gain_j f_j``, which begin with 1.

    Displacements are ``Re sum_k shape_ck z_k``.
    """

    theta: ComplexArray  # (structure, pole): exponents per sample
    shapes: ComplexArray  # (structure, pole, channel): displacements
    gains: ComplexArray  # (structure, pole, force)
    forces: tuple[Force, ...]
    scales: RealArray  # (force,): largest speeds or displacements that the forces follow; all forces are of one kind
    turns: bool = False  # accelerations tell what friction is at samples about which it turns; else it has its mean

    @property
    def kind(self) -> ForceKind:
        """Kind of the forces."""
        return self.forces[0].kind

    @property
    def places(self) -> ComplexArray:
        """Displacements that the forces follow, (structure, pole, force)."""
        out = self.shapes[:, :, [force.channel for force in self.forces]]
        for j, force in enumerate(self.forces):
            if force.other is not None:
                out[:, :, j] -= self.shapes[:, :, force.other]
        return out


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Motion:
    """States (structure, pole, sample) and the mean of each force from a sample to the next, (…, force, sample)."""

    states: ComplexArray
    acting: RealArray


def steps_of(theta: ComplexArray, count: int, kind: ForceKind) -> int:
    """Return the steps that a number of samples take."""
    each, apart = _pace(theta, kind)
    return -(-((count - 1) * each) // apart)


def _pace(theta: ComplexArray, kind: ForceKind) -> tuple[int, int]:
    """Return into how many steps a sample is divided, and how many samples a step takes: one of both is 1.

    Friction changes at once, within any sample.
    """
    turn = float(np.max(np.abs(theta)))
    return max(1, int(np.ceil(turn / TURN))), 1 if kind is ForceKind.FRICTION else max(1, int(TURN / turn))


def motion_of(of: Structures, count: int) -> Motion:
    """Return the motion of structures over a number of samples."""
    each, apart = _pace(of.theta, of.kind)
    total = steps_of(of.theta, count, of.kind)
    if of.kind is ForceKind.FRICTION:
        states, acting = _rubbed(of, total, each)
    else:
        states, acting = _bent(of, total, each / apart)
    if apart > 1:
        return _between(of, states, acting, apart, count)
    means = acting[:, :, :-1].reshape(*acting.shape[:2], count - 1, each).mean(axis=3)
    return Motion(states=states[:, :, ::each], acting=np.concatenate([means, acting[:, :, -1:]], axis=2))


def _between(of: Structures, states: ComplexArray, acting: RealArray, apart: int, count: int) -> Motion:
    """Return the motion at every sample from that at every ``apart``-th sample."""
    turns = of.theta[:, :, None] * np.arange(apart)
    answers = (np.expm1(turns) / of.theta[:, :, None])[:, :, None]
    pushes = of.gains @ acting
    whole = np.exp(turns)[:, :, None] * states[..., None] + answers * pushes[..., None]
    return Motion(
        states=np.asarray(whole.reshape(*states.shape[:2], -1)[:, :, :count]),
        acting=np.repeat(acting, apart, axis=2)[:, :, :count],
    )


def _rubbed(of: Structures, total: int, steps: int) -> tuple[ComplexArray, RealArray]:
    """Return the states at a number of steps, and friction between them (structure, force, step)."""
    turn, slope = of.theta / steps, of.places * of.theta[:, :, None]
    held = (np.expm1(turn) / of.theta)[:, :, None] * of.gains
    stepper = RubbedSteps.of(turn, held=held, slope=slope, scales=of.scales)
    z = np.ones(of.theta.shape, complex)
    states = np.empty((*z.shape, total + 1), complex)
    acting = np.zeros((len(z), len(of.forces), total + 1))
    states[:, :, 0], done = z, 0
    holds = rested = False
    while done < total:
        # What is held mostly stays so.
        taken = 0
        if not holds:
            ahead, signs, taken = stepper.sliding(z)
            taken = min(taken, total - done)
        if taken:
            states[:, :, done + 1 : done + taken + 1] = ahead[:, :, :taken]
            acting[:, :, done : done + taken] = signs[:, :, None]
            z, done = ahead[:, :, taken - 1], done + taken
        # Then a mass stops, is held or breaks loose.
        if done < total and taken < AHEAD:
            z, acting[:, :, done] = stepper.after(z, acting[:, :, max(done - 1, 0)])
            # What turns slides on.
            holds = not taken and bool((np.abs(acting[:, :, done]) < 1).any())
            done += 1
            states[:, :, done] = z
            # In the step in which the last mass stops, friction has another mean than from then on.
            if rested:
                states[:, :, done:], acting[:, :, done:] = z[:, :, None], acting[:, :, done - 1 : done]
                break
            rested = holds and stepper.rests(z, acting[:, :, done - 1])
    acting[:, :, -1] = acting[:, :, max(total - 1, 0)]
    return states, acting


def _bent(of: Structures, total: int, steps: float) -> tuple[ComplexArray, RealArray]:
    """Return the states at a number of steps, and other forces than friction between them (structure, force, step).

    A sample has ``steps``.

    Each has the mean of those at the start of a step and at its end, where the force at the start would bring it.
    """
    place = of.places * (of.theta[:, :, None] if of.kind in OF_SPEED else 1.0) / of.scales
    turn, poles = of.theta / steps, of.theta.shape[1]
    held = np.swapaxes((np.expm1(turn) / of.theta)[:, :, None] * of.gains, 1, 2)
    taken = BentSteps.of(of.kind, powers=np.exp(turn), held=held, place=place)
    start = np.repeat([1.0, 0.0], poles)
    states = taken.states(start, total)
    states = taken.one_by_one(start, total) if states is None else states
    _, acting, followed, _ = taken.acting(states)
    acting[:, -1] = size_of(of.kind, followed[:, -1], followed[:, -1])
    return np.moveaxis(states[..., :poles] + 1j * states[..., poles:], 1, 2), np.moveaxis(acting, 1, 2)
