"""Fit structures to a record: modes and the forces that follow their motion, all together.

Feedback of the measured motion takes the forces as known. Here they follow the motion of the model itself, so that a
mass may be held by friction, and a force changes speeds, not positions: that leaves it half as many free gains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from suspid.identification.noise import degrees_of_freedom
from suspid.identification.nonlinear.feedback import Record
from suspid.identification.nonlinear.forces import OF_SPEED, Force, ForceKind
from suspid.identification.nonlinear.motion import Motion, Structures, motion_of
from suspid.identification.nonlinear.patience import note_steps
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real

# Share of the largest speeds by which a unit of force within a radian of the fastest mode may change positions, in
# standard deviations of 1. A smaller share slows the fit down, a larger one frees the gains.
JUMP = 3e-5
# Relative change of each parameter for derivatives.
CHANGE = 1e-6
# A mass slides all the time where the mean of the sign of its speed is beyond this.
SLIDES = 1 - 1e-9


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Nearby:
    """Structures with one parameter changed each, for derivatives."""

    structures: Structures
    motion: Motion
    steps: RealArray  # (parameter,)
    apart: RealArray  # (parameter, channel, sample): what that changes

    def slopes(self, of: StructureFit) -> RealArray:
        """Return derivatives over standard deviations, (parameter, sample of any channel, then jump)."""
        count, steps = len(self.steps), self.steps[:, None, None]
        weighted = self.apart / np.sqrt(of.variance)[:, None] / steps
        jumps = (jumps_of(self.structures) - jumps_of(of.structures)) / least_jumps(of.structures) / steps
        return np.concatenate([weighted.reshape(count, -1), jumps.reshape(count, -1)], axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class StructureFit:
    """A structure and how it fits a record."""

    record: Record
    order: int  # the channels are displacements (0), speeds (1) or accelerations (2)
    structures: Structures  # one
    motion: Motion
    residual: RealArray  # (channel, sample)
    nearby: Nearby
    others: tuple[StructureFit, ...] = ()  # with friction elsewhere, which the record does not rule out

    @property
    def theta(self) -> ComplexArray:
        """Exponents per sample, of the motion without the forces, (pole,)."""
        return np.asarray(self.structures.theta[0])

    @property
    def forces(self) -> tuple[Force, ...]:
        """The forces."""
        return self.structures.forces

    @property
    def amplitudes(self) -> ComplexArray:
        """Complex amplitudes of the states, (pole, channel)."""
        return np.asarray(self.structures.shapes[0] * self.theta[:, None] ** self.order)

    @property
    def free(self) -> int:
        """Number of real parameters of poles and forces."""
        poles, channels = self.amplitudes.shape
        return int(2 * poles + len(self.forces) * (2 * poles - min(poles, channels)))

    @cached_property
    def squares(self) -> RealArray:
        """Residual sum of squares, (channel,); inf where a motion that runs away is out of the range of numbers."""
        with np.errstate(over="ignore"):
            return np.asarray(np.sum(self.residual**2, axis=1))

    @property
    def variance(self) -> RealArray:
        """Variance of the residual, at least the least of the noise, (channel,)."""
        return self.record.noise.variance(self.squares, self.residual.shape[1])

    @property
    def loss(self) -> float:
        """Minus twice the log likelihood less a constant."""
        return self.record.noise.loss(self.squares, self.residual.shape[1])

    @property
    def bic(self) -> float:
        """Loss and ``log(samples)`` for each parameter."""
        poles, channels = self.amplitudes.shape
        linear = channels * (2 * poles + len(self.record.nuisances))
        return float(self.loss + (self.free + linear) * np.log(self.residual.size))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the residual of one channel."""
        (poles, channels), count = self.amplitudes.shape, self.residual.shape[1]
        amplitudes = 2 * poles + len(self.record.nuisances)
        return degrees_of_freedom(count, amplitudes=amplitudes, poles=self.free, channels=channels)

    def with_record(self, record: Record) -> StructureFit:
        """Return the same structure beside another record."""
        return evaluated(record, self.structures, self.order)

    def with_structures(self, structures: Structures) -> StructureFit:
        """Return another structure beside the same record."""
        return evaluated(self.record, structures, self.order)

    @cached_property
    def covariance(self) -> RealArray:
        """Covariance of the parameters, (parameter, parameter). A motion that runs away has none: `LinAlgError`."""
        slopes = self.nearby.slopes(self)
        if not np.all(np.isfinite(slopes)):
            raise np.linalg.LinAlgError("the motion runs away within a step of a derivative")
        scale = 1 / np.maximum(np.linalg.norm(slopes, axis=1), 1e-300)
        unit = slopes * scale[:, None]
        inverse = np.linalg.pinv(unit @ unit.T, rcond=1e-12, hermitian=True)
        return np.asarray(inverse * np.outer(scale, scale) * (self.residual.shape[1] / self.freedom))


def structure_of(
    record: Record, theta: ComplexArray, amplitudes: ComplexArray, forces: tuple[Force, ...], order: int
) -> StructureFit:
    """Return the structure with given poles and amplitudes (pole, channel) on which no force acts yet."""
    shapes = amplitudes * theta[:, None] ** -order
    plain = Structures(
        theta=theta[None],
        shapes=shapes[None],
        gains=np.zeros((1, len(theta), len(forces)), complex),
        forces=forces,
        scales=np.ones(len(forces)),
    )
    powers = np.exp(np.outer(theta, np.arange(record.values.shape[1])))
    follows = plain.places[0] * (theta[:, None] if plain.kind in OF_SPEED else 1.0)
    scales = np.max(np.abs(np.einsum("kj,kn->jn", follows, powers).real), axis=1) + 1e-300
    return evaluated(record, replace(plain, scales=scales), order)


def with_parameters(of: Structures, parameters: RealArray) -> Structures:
    """Return structures with other parameters, (structure, parameter)."""
    every = parameters[:, ::2] + 1j * parameters[:, 1::2]
    poles, shapes = of.theta.shape[1], of.shapes[0].size
    return replace(
        of,
        theta=every[:, :poles],
        shapes=every[:, poles : poles + shapes].reshape(-1, *of.shapes.shape[1:]),
        gains=every[:, poles + shapes :].reshape(-1, *of.gains.shape[1:]),
    )


def evaluated(record: Record, structures: Structures, order: int) -> StructureFit:
    """Return the structure with its motion and what that leaves of a record."""
    at, count = parameters_of(structures)[0], record.values.shape[1]
    note_steps(count)
    steps = np.maximum(CHANGE * np.repeat(np.abs(at[::2] + 1j * at[1::2]), 2), CHANGE**1.5)
    # A step costs about as much for all of them as for one.
    every = with_parameters(structures, at + np.vstack([np.zeros(len(at)), np.diag(steps)]))
    with np.errstate(over="ignore", invalid="ignore"):
        motion = motion_of(every, count)
        observed = _observed(record, every, motion, order)
        left = _less_nuisances(record, record.values) - observed[0]
        apart = observed[1:] - observed[0]
    return StructureFit(
        record=record,
        order=order,
        structures=structures,
        motion=Motion(states=motion.states[:1], acting=motion.acting[:1]),
        residual=np.asarray(left),
        nearby=Nearby(
            structures=replace(every, theta=every.theta[1:], shapes=every.shapes[1:], gains=every.gains[1:]),
            motion=Motion(states=motion.states[1:], acting=motion.acting[1:]),
            steps=steps,
            apart=apart,
        ),
    )


def parameters_of(of: Structures) -> RealArray:
    """Return real and imaginary parts of the exponents, shapes and gains, (structure, parameter)."""
    every = np.concatenate([part.reshape(len(of.theta), -1) for part in (of.theta, of.shapes, of.gains)], axis=1)
    return np.stack([every.real, every.imag], axis=2).reshape(len(every), -1)


def gains_of(theta: ComplexArray, shapes: ComplexArray, slowed: RealArray) -> ComplexArray:
    """Return the gains (…, pole, force) of forces that slow masses by accelerations (…, channel, force), and move none.

    Exponents are (…, pole), displacements (…, pole, channel), per sample.
    """
    rows = np.concatenate([np.swapaxes(each, -2, -1) for each in (shapes, shapes * theta[..., None])], axis=-2)
    changes = np.concatenate([np.zeros_like(slowed), -slowed], axis=-2)
    parts = np.linalg.pinv(np.concatenate([rows.real, -rows.imag], axis=-1)) @ changes
    poles = theta.shape[-1]
    return np.asarray(parts[..., :poles, :] + 1j * parts[..., poles:, :])


def _observed(record: Record, structures: Structures, motion: Motion, order: int) -> RealArray:
    """Return the channels less offset and drift, (structure, channel, sample)."""
    amplitudes = structures.shapes * structures.theta[:, :, None] ** order
    out = np.matmul(np.swapaxes(amplitudes, 1, 2), motion.states).real
    if order == 2:
        # A force shows in the accelerations at once.
        at_once = np.einsum("pkc,pkj->pcj", structures.shapes * structures.theta[:, :, None], structures.gains).real
        about = motion.acting
        if structures.kind is ForceKind.FRICTION:
            before = np.concatenate([about[:, :, :1], about[:, :, :-1]], axis=2)
            about = 0.5 * (before + about)
        if structures.turns:
            left = _less_nuisances(record, record.values - out[0] - at_once[0] @ about[0])
            about = _with_turns(about, motion.acting[0], at_once[0], left)
        out = out + np.matmul(at_once, about)
    return _less_nuisances(record, np.asarray(out))


def _with_turns(about: RealArray, acting: RealArray, through: RealArray, left: RealArray) -> RealArray:
    """Return forces at the samples ``about`` which they have means, (structure, force, sample), as a record tells them.

    At samples next to those between which friction turns, stops a mass or lets it go, it is what explains best what
    means have ``left`` of accelerations, (channel, sample), between what it is about them: when it turns is not known
    to a part of a sample. It acts on them ``through`` a matrix (channel, force).
    """
    count = acting.shape[1]
    near = np.stack([np.pad(acting, ((0, 0), (2, 1)), mode="edge")[:, k : k + count] for k in range(4)])
    turns = np.any(np.abs(near) > SLIDES, axis=0) & (np.ptp(near, axis=0) > 1 - SLIDES)
    least, most = np.min(near, axis=0), np.max(near, axis=0)
    found = about[0].copy()
    rest = left
    even = ~np.any(turns, axis=0)
    weights = 1 / (np.mean(rest**2, axis=1, where=even) + 1e-300) if np.any(even) else np.ones(len(rest))
    for j, push in enumerate(through.T):
        apart = (push * weights) @ rest / (np.sum(push**2 * weights) + 1e-300)
        told = np.where(turns[j], np.clip(found[j] + apart, least[j], most[j]), found[j])
        rest, found[j] = rest - push[:, None] * (told - found[j]), told
    return np.where(turns, found, about)


def _less_nuisances(record: Record, values: RealArray) -> RealArray:
    """Return values (…, sample) less the offset and drift nearest to them."""
    basis = _basis(values.shape[-1], tuple(record.nuisances))
    return np.asarray(values - (values @ basis) @ basis.T)


# A fit has one record, and its derivatives the same.
@lru_cache(maxsize=4)
def _basis(count: int, nuisances: tuple[float, ...]) -> RealArray:
    """Return orthonormal columns of the offset and drift, (sample, nuisance)."""
    return frozen_real(np.linalg.qr(np.exp(np.outer(np.arange(count), nuisances)))[0])


def jumps_of(structures: Structures) -> RealArray:
    """Return the change of each displacement by each force at once: no force moves a mass at once."""
    return np.asarray(np.einsum("pkc,pkj->pcj", structures.shapes, structures.gains).real)


def least_jumps(structures: Structures) -> RealArray:
    """Return the standard deviations of the jumps, (channel, 1)."""
    speeds = np.abs(structures.shapes[0] * structures.theta[0, :, None])
    return np.asarray(JUMP * np.sum(speeds, axis=0)[:, None])
