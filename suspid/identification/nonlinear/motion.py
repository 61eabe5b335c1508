"""Motion of modes under forces that follow it, step by step; friction may hold a mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.nonlinear.forces import Force, ForceKind, size_of
from suspid.units import ComplexArray, RealArray

# Angle by which the fastest mode turns in a step, at most [rad]. Forces run straight within a step.
TURN = 0.25
# Speeds below this share of the scale of a force are rest.
STILL = 1e-9


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Structures:
    """Structures side by side: each has modes ``z' = theta z + sum_j gain_j f_j``, which begin with 1.

    Displacements are ``Re sum_k shape_ck z_k``.
    """

    theta: ComplexArray  # (structure, pole): exponents per sample
    shapes: ComplexArray  # (structure, pole, channel): displacements
    gains: ComplexArray  # (structure, pole, force)
    forces: tuple[Force, ...]
    scales: RealArray  # (2, force): displacement and speed at which a force is 1

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


def steps_of(theta: ComplexArray) -> int:
    """Return the steps that a sample takes."""
    return max(1, int(np.ceil(np.max(np.abs(theta)) / TURN)))


def motion_of(of: Structures, count: int) -> Motion:
    """Return the motion of structures over a number of samples."""
    steps = steps_of(of.theta)
    stepper = _stepper(of, steps)
    z = np.ones(of.theta.shape, complex)
    states, acting = np.empty((*z.shape, count), complex), np.zeros((len(z), len(of.forces), count))
    states[:, :, 0] = z
    forces = np.zeros((len(z), len(of.forces)))
    for sample in range(1, count):
        for _ in range(steps):
            z, forces = stepper.after(z, forces)
            acting[:, :, sample - 1] += forces
        states[:, :, sample] = z
    acting[:, :, -1] = forces * steps
    return Motion(states=states, acting=acting / steps)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Stepper:
    """What a step of the motion needs; matrices take states (structure, 1, pole) or forces (structure, 1, force)."""

    kinds: tuple[ForceKind, ...]
    scales: RealArray  # (2, force)
    powers: ComplexArray  # (structure, pole)
    held: ComplexArray  # (structure, force, pole): answer of the states to a force over a step
    answers: RealArray  # (structure, force, force): and of each speed that a force follows, the last index
    place: ComplexArray  # (structure, pole, force)
    slope: ComplexArray  # (structure, pole, force)
    frictions: tuple[int, ...]
    smooth: tuple[int, ...]

    def after(self, z: ComplexArray, before: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return the states after a step, and the mean of the forces over it, from those of the step before."""
        free, acting = self.powers * z, before.copy()
        begun = self._smooth(z)
        for j in self.smooth:
            acting[:, j] = begun[j]
        if self.frictions:
            self._rub(z, free, acting)
        if self.smooth:
            ended = self._smooth(free + (acting[:, None] @ self.held)[:, 0])
            for j in self.smooth:
                acting[:, j] = 0.5 * (begun[j] + ended[j])
        return free + (acting[:, None] @ self.held)[:, 0], acting

    def _rub(self, z: ComplexArray, free: ComplexArray, acting: RealArray) -> None:
        """Set the friction of a step, given what it was before."""
        speed = (z[:, None] @ self.slope)[:, 0].real
        plain = (free[:, None] @ self.slope)[:, 0].real
        rubbed = list(self.frictions)
        signs = np.sign(speed[:, rubbed])
        acting[:, rubbed] = signs
        ends = plain[:, rubbed] + (acting[:, None] @ self.answers)[:, 0][:, rubbed]
        if np.all(ends * signs > STILL * self.scales[1, rubbed]):
            return
        # The second sweep has the friction of this step at the other places.
        for _ in range(min(2, len(rubbed))):
            for j in rubbed:
                own = self.answers[:, j, j]
                rest = plain[:, j] + np.sum(self.answers[:, :, j] * acting, axis=1) - own * acting[:, j]
                acting[:, j] = friction(speed[:, j], rest, own, still=STILL * float(self.scales[1, j]))

    def _smooth(self, z: ComplexArray) -> dict[int, RealArray]:
        """Return the forces other than friction."""
        out = dict[int, RealArray]()
        for j in self.smooth:
            d, v = ((z * each[:, :, j]).sum(axis=1).real / scale[j] for each, scale in zip(
                (self.place, self.slope), self.scales, strict=True
            ))  # fmt: skip
            out[j] = size_of(self.kinds[j], d, v)
        return out


def _stepper(of: Structures, steps: int) -> _Stepper:
    turn, place = of.theta / steps, of.places
    held = (np.expm1(turn) / of.theta)[:, :, None] * of.gains
    slope, kinds = place * of.theta[:, :, None], tuple(force.kind for force in of.forces)
    return _Stepper(
        kinds=kinds,
        scales=of.scales,
        powers=np.exp(turn),
        held=np.ascontiguousarray(np.swapaxes(held, 1, 2)),
        answers=np.einsum("pkj,pki->pij", slope, held).real.copy(),
        place=place,
        slope=slope,
        frictions=tuple(j for j, kind in enumerate(kinds) if kind is ForceKind.FRICTION),
        smooth=tuple(j for j, kind in enumerate(kinds) if kind is not ForceKind.FRICTION),
    )


def friction(speed: RealArray, rest: RealArray, answer: RealArray, *, still: float) -> RealArray:
    """Return the mean of the sign of a speed over a step, or what holds the mass, between -1 and 1.

    The speed at the start of the step, that at its end without friction, and what the sign of 1 changes that by.

    Examples
    --------
    A mass that slips on, one that turns back, one that is held from its stop on, and one that stays held:

    >>> speed, rest = np.array([1.0, 0.25, 0.1, 0.0]), np.array([0.9, -0.5, 0.0, 0.2])
    >>> friction(speed, rest, np.full(4, -0.25), still=1e-9)
    array([ 1. , -0.5,  0. ,  0.8])
    """
    sign = np.sign(speed)
    slipped = rest + answer * sign
    against = np.where(answer < 0, answer, -np.inf)
    holds = np.clip(-rest / against, -1.0, 1.0)
    stuck = np.abs(speed) <= still
    turned = (slipped * sign < 0) & ~stuck
    share = speed / np.where(turned, speed - slipped, 1.0)
    back = np.where(np.abs(rest - speed) <= -against, holds, sign * (2 * share - 1))
    return np.where(stuck, holds, np.where(turned, back, sign))
