"""Motion of modes under friction: many steps at once while all masses slide, one where a mass turns or is held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray

# Steps that are taken at once where no mass stops: more are thrown away at the next event, fewer cost more calls.
AHEAD = 12
# Sweeps over places at which masses turn or are held in the same step, at most, and the change that ends them.
SWEEPS, SETTLED_FRICTION = 6, 1e-9


class Begun(NamedTuple):
    """How a step begins, each (structure, force)."""

    speed: RealArray  # at its start
    plain: RealArray  # at its end, without friction
    sign: RealArray
    slip: RealArray  # what friction of that sign changes at its own place
    stuck: NDArray[np.bool_] | None  # where masses rest; None where none does


class Beside(NamedTuple):
    """What a step is at each place beside the friction elsewhere, each (structure, force)."""

    rest: RealArray  # speeds at the end without the friction there
    slipped: RealArray  # and with that of the sign at the start
    turned: NDArray[np.bool_]
    events: list[bool]  # (force,): whether a mass turns or rests


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RubbedSteps:
    """Steps of structures side by side under friction.

    Matrices take states (structure, 1, pole) or forces (structure, 1, force).
    """

    powers: ComplexArray  # (structure, pole, step): of one step, two and so on
    still: RealArray  # (force,): speeds below these are rest
    held: ComplexArray  # (structure, force, pole): answer of the states to a force over a step
    centres: ComplexArray  # (structure, force, pole): and states at which it holds them
    answers: RealArray  # (structure, force, force): and of each speed that a force follows, the last index
    own: RealArray  # (structure, force): the same of its own speed
    against: RealArray  # (structure, force): that, where it slows the speed; else -inf
    slope: ComplexArray  # (structure, pole, force)
    speeds: ComplexArray  # (structure, pole, twice the forces): now, and after a step without forces
    across: ComplexArray  # (structure, force, pole): as the slope

    @classmethod
    def of(cls, turn: ComplexArray, *, held: ComplexArray, slope: ComplexArray, scales: RealArray) -> RubbedSteps:
        """Return the steps from the exponents of a step, (structure, pole), and what friction does and follows.

        The answer of the states to a force over a step is ``held``, (structure, pole, force), and the speeds that
        friction follows are ``Re sum_k slope_kj z_k``, at most ``scales``, (force,).
        """
        powers = np.exp(turn[:, :, None] * np.arange(1, AHEAD + 1))
        answers = np.einsum("pkj,pki->pij", slope, held).real.copy()
        own = np.diagonal(answers, axis1=1, axis2=2).copy()
        pushed = np.ascontiguousarray(np.swapaxes(held, 1, 2))
        return cls(
            powers=powers,
            still=EXACT * scales,
            held=pushed,
            centres=pushed / (1 - powers[:, None, :, 0]),
            answers=answers,
            own=own,
            against=np.where(own < 0, own, -np.inf),
            slope=slope,
            speeds=np.concatenate([slope, slope * powers[:, :, :1]], axis=2),
            across=np.ascontiguousarray(np.swapaxes(slope, 1, 2)),
        )

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

    def rests(self, z: ComplexArray, acting: RealArray) -> bool:
        """Return whether friction holds as many places as there are modes for good: nothing moves any more."""
        every = self.slope.shape[1] == len(self.still)
        if not every or not (np.abs(acting) < 1).all():
            return False
        return bool((np.abs((z[:, None] @ self.slope)[:, 0].real) <= self.still).all())

    def _rub(self, z: ComplexArray, before: RealArray) -> RealArray:
        """Return the friction of a step: the sign of each speed, unless a mass turns or is held.

        There it is what it is beside the friction elsewhere: each sweep has what the one before found at other places,
        the first what has held masses so far.
        """
        count = len(self.still)
        both = (z[:, None] @ self.speeds)[:, 0].real
        speed, plain = both[:, :count], both[:, count:]
        sign = np.sign(speed)
        rests = np.abs(speed) <= self.still
        stuck = rests if rests.any() else None
        begun = Begun(speed, plain, sign, self.own * sign, stuck)
        acting = sign.copy() if stuck is None else np.where(stuck, before, sign)
        beside = self._beside(acting, begun)
        found, held = set[int](), np.zeros(acting.shape, bool)
        for _ in range(SWEEPS):
            last = acting.copy()
            for j in range(count):
                if j in found or beside.events[j]:
                    acting[:, j], held[:, j] = friction(j, begun, beside, self.against[:, j])
                    found.add(j)
                    # What is alone changes nothing elsewhere.
                    if count > 1:
                        beside = self._beside(acting, begun)
            alone = len(found) < 2 and not any(beside.events[j] for j in range(count) if j not in found)
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

    def _beside(self, acting: RealArray, begun: Begun) -> Beside:
        """Return what a step is beside the friction elsewhere, of forces (structure, force)."""
        rest = begun.plain + (acting[:, None] @ self.answers)[:, 0] - self.own * acting
        slipped = rest + begun.slip
        turned = slipped * begun.sign < 0
        events = np.logical_or.reduce(turned if begun.stuck is None else turned | begun.stuck, axis=0)
        return Beside(rest, slipped, turned, events.tolist())


def friction(j: int, begun: Begun, beside: Beside, against: RealArray) -> tuple[RealArray, NDArray[np.bool_]]:
    """Return the mean of one force over a step, (structure,), and where it holds the mass.

    The mean is that of the sign of the speed, or what holds the mass, between -1 and 1. A sign of 1 changes the speed
    ``against`` it, (structure,), or not: -inf.

    Examples
    --------
    A mass that slips on, one that turns back, one that is held from its stop on, and one that stays held:

    >>> speed, rest = np.array([[1.0], [0.25], [0.1], [0.0]]), np.array([[0.9], [-0.5], [0.0], [0.2]])
    >>> sign = np.sign(speed)
    >>> begun = Begun(speed, rest, sign, -0.25 * sign, sign == 0)
    >>> beside = Beside(rest, rest + begun.slip, (rest + begun.slip) * sign < 0, [True])
    >>> mean, held = friction(0, begun, beside, np.full(4, -0.25))
    >>> mean, held
    (array([ 1. , -0.5,  0. ,  0.8]), array([False, False,  True,  True]))
    """
    speed, sign, rest, turned = begun.speed[:, j], begun.sign[:, j], beside.rest[:, j], beside.turned[:, j]
    stops = np.abs(rest - speed) <= -against
    if begun.stuck is None:
        held = turned & stops
    else:
        stuck = begun.stuck[:, j]
        turned = turned & ~stuck
        held = stuck | (turned & stops)
    holds = np.minimum(np.maximum(-rest / against, -1.0), 1.0)
    share = speed / np.where(turned, speed - beside.slipped[:, j], 1.0)
    return np.where(held, holds, np.where(turned, sign * (2 * share - 1), sign)), held
