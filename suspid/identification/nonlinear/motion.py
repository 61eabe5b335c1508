"""Motion of modes under forces that follow it, in steps.

Friction may hold a mass; between its events the motion is in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.nonlinear.bent_motion import BentSteps
from suspid.identification.nonlinear.forces import OF_SPEED, Force, ForceKind, size_of
from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray

# Angle by which the fastest mode turns in a step, at most [rad]. Forces have their mean within a step.
TURN = 0.25
# Steps that are taken at once where no mass stops: more are thrown away at the next event, fewer cost more calls.
AHEAD = 12
# Sweeps over places at which masses turn or are held in the same step, at most, and the change that ends them.
SWEEPS, SETTLED_FRICTION = 6, 1e-9


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
    stepper = _stepper(of, steps)
    z = np.ones(of.theta.shape, complex)
    states = np.empty((*z.shape, total + 1), complex)
    acting = np.zeros((len(z), len(of.forces), total + 1))
    states[:, :, 0], done = z, 0
    holds = False
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


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Stepper:
    """What a step of the motion needs; matrices take states (structure, 1, pole) or forces (structure, 1, force)."""

    powers: ComplexArray  # (structure, pole, step): of one step, two and so on
    still: RealArray  # (force,): speeds below these are rest
    held: ComplexArray  # (structure, force, pole): answer of the states to a force over a step
    centres: ComplexArray  # (structure, force, pole): and states at which it holds them
    answers: RealArray  # (structure, force, force): and of each speed that a force follows, the last index
    own: RealArray  # (structure, force): the same of its own speed
    slope: ComplexArray  # (structure, pole, force)
    speeds: ComplexArray  # (structure, pole, twice the forces): now, and after a step without forces
    across: ComplexArray  # (structure, force, pole): as the slope

    def sliding(self, z: ComplexArray) -> tuple[ComplexArray, RealArray, int]:
        """Return the states after steps (structure, pole, step), the signs, and in how many steps every mass slides."""
        signs = np.sign((z[:, None] @ self.slope).real)
        centre = (signs @ self.centres)[:, 0]
        ahead = self.powers * (z - centre)[:, :, None]
        ahead += centre[:, :, None]
        signs = signs[:, 0]
        ends = (self.across @ ahead).real * signs[:, :, None]
        slides = np.logical_and.reduce(ends > self.still[:, None], axis=(0, 1))
        first = int(slides.argmin())
        return ahead, signs, len(slides) if slides[first] else first

    def after(self, z: ComplexArray, before: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return the states after a step, and the mean of the forces over it, from those of the step before."""
        acting = self._rub(z, before)
        return self.powers[:, :, 0] * z + (acting[:, None] @ self.held)[:, 0], acting

    def _rub(self, z: ComplexArray, before: RealArray) -> RealArray:
        """Return the friction of a step: the sign of each speed, unless a mass turns or is held.

        There it is what it is beside the friction elsewhere: each sweep has what the one before found at other places,
        the first what has held masses so far.
        """
        count = len(self.still)
        both = (z[:, None] @ self.speeds)[:, 0].real
        speed, plain = both[:, :count], both[:, count:]
        signs = np.sign(speed)
        stuck = np.abs(speed) <= self.still
        acting = np.where(stuck, before, signs)
        rest, events = self._beside(acting, plain, signs, stuck)
        found, held = set[int](), np.zeros(acting.shape, bool)
        for _ in range(SWEEPS):
            last = acting.copy()
            for j in range(count):
                if events[j] or j in found:
                    acting[:, j], held[:, j] = friction(
                        speed[:, j], rest[:, j], self.own[:, j], still=float(self.still[j])
                    )
                    found.add(j)
                    rest, events = self._beside(acting, plain, signs, stuck)
            alone = len(found) < 2 and not any(events[j] for j in range(count) if j not in found)
            if alone or np.max(np.abs(acting - last)) < SETTLED_FRICTION:
                break
        return self._together(acting, plain, held) if len(found) > 1 else acting

    def _together(self, acting: RealArray, plain: RealArray, held: NDArray[np.bool_]) -> RealArray:
        """Return friction with what holds several masses at once, to the last digit: sweeps come near to that only.

        What they leave would shake what is at rest, and that is all that accelerometers show of it.
        """
        several = np.sum(held, axis=1) > 1
        if not several.any():
            return acting
        equations = np.where(held[:, :, None], np.swapaxes(self.answers, 1, 2), np.eye(held.shape[1]))
        try:
            every = np.linalg.solve(equations, np.where(held, -plain, acting)[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            return acting
        holds = several & np.logical_and.reduce(np.abs(every) <= 1, axis=1)
        return np.where(holds[:, None], every, acting)

    def _beside(
        self, acting: RealArray, plain: RealArray, signs: RealArray, stuck: NDArray[np.bool_]
    ) -> tuple[RealArray, NDArray[np.bool_]]:
        """Return the speeds after a step beside the friction elsewhere, and where one turns or rests, (force,)."""
        rest = plain + (acting[:, None] @ self.answers)[:, 0] - self.own * acting
        turned = (rest + self.own * signs) * signs < 0
        return rest, np.logical_or.reduce(turned | stuck, axis=0)


def _stepper(of: Structures, steps: int) -> _Stepper:
    turn, place = of.theta / steps, of.places
    held = (np.expm1(turn) / of.theta)[:, :, None] * of.gains
    slope = place * of.theta[:, :, None]
    powers = np.exp(turn[:, :, None] * np.arange(1, AHEAD + 1))
    answers = np.einsum("pkj,pki->pij", slope, held).real.copy()
    across = np.ascontiguousarray(np.swapaxes(held, 1, 2))
    return _Stepper(
        powers=powers,
        still=EXACT * of.scales,
        held=across,
        centres=across / (1 - powers[:, None, :, 0]),
        answers=answers,
        own=np.diagonal(answers, axis1=1, axis2=2).copy(),
        slope=slope,
        speeds=np.concatenate([slope, slope * powers[:, :, :1]], axis=2),
        across=np.ascontiguousarray(np.swapaxes(slope, 1, 2)),
    )


def friction(
    speed: RealArray, rest: RealArray, answer: RealArray, *, still: float
) -> tuple[RealArray, NDArray[np.bool_]]:
    """Return the mean of the sign of a speed over a step, or what holds the mass, between -1 and 1; and where it holds.

    The speed at the start of the step, that at its end without friction, and what the sign of 1 changes that by.

    Examples
    --------
    A mass that slips on, one that turns back, one that is held from its stop on, and one that stays held:

    >>> speed, rest = np.array([1.0, 0.25, 0.1, 0.0]), np.array([0.9, -0.5, 0.0, 0.2])
    >>> mean, held = friction(speed, rest, np.full(4, -0.25), still=1e-9)
    >>> mean, held
    (array([ 1. , -0.5,  0. ,  0.8]), array([False, False,  True,  True]))
    """
    sign = np.sign(speed)
    slipped = rest + answer * sign
    stuck = np.abs(speed) <= still
    turned = slipped * sign < 0
    # Mostly every mass slips on.
    if not (turned | stuck).any():
        return sign, stuck
    against = np.where(answer < 0, answer, -np.inf)
    holds = np.minimum(np.maximum(-rest / against, -1.0), 1.0)
    turned &= ~stuck
    share = speed / np.where(turned, speed - slipped, 1.0)
    held = stuck | (turned & (np.abs(rest - speed) <= -against))
    return np.where(held, holds, np.where(turned, sign * (2 * share - 1), sign)), held
