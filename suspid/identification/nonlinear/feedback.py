"""Forces that follow the motion of a record: fitted, pruned, and renewed with the motion that they explain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.driven import Drive, DrivenFit, evaluate, maximize
from suspid.identification.nonlinear.forces import Force, ForceKind, forces_of, means
from suspid.signals import block_means
from suspid.units import ComplexArray, RealArray

if TYPE_CHECKING:
    from suspid.identification.nonlinear.structure import StructureFit

# A force of which less than this share is left beside the others adds nothing that can be told from them.
LEAST_OWN = 0.1
# Least size of the part of a force that is not linear in the states: below it there is rounding.
LEAST_PART = 1e-6
# What forces promise to lower the variance of the residual by, for a fit. A lower factor costs time on records that are
# linear but not free of other motion.
LEAST_FALL = 1.5
# Steps of a fit on the way, kinds of force that are fitted, and renewals of the forces.
ROUGH_STEPS, TRIALS, RENEWALS = 10, 2, 3
# Poles slower than this share of the strongest are drift where displacements are had by integration.
SLOW = 0.3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Bent:
    """Modes of a structure that is not quite linear."""

    fit: DrivenFit
    forces: tuple[Force, ...]
    order: int  # the channels are displacements (0), speeds (1) or accelerations (2)
    structure: StructureFit | None = None  # where it explains more than the fit with the forces as they were measured

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.fit.drive.theta if self.structure is None else self.structure.theta)

    @property
    def bic(self) -> float:
        """Loss and ``log(samples)`` for each parameter."""
        return (self.structure or self.fit).bic

    @property
    def residual(self) -> RealArray:
        """The record less the fitted motion, (channel, sample)."""
        return (self.structure or self.fit).residual

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the residual of one channel."""
        return (self.structure or self.fit).freedom


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Record:
    """A record to fit, and its motion as the linear fit with all its poles follows it."""

    values: RealArray  # (channel, sample)
    noise: WhiteNoise
    theta: ComplexArray  # (pole,): exponents per sample of the linear fit, all pairs and real poles
    amplitudes: ComplexArray  # (pole, channel)
    nuisances: RealArray

    def motions(self, order: int) -> tuple[RealArray, RealArray]:
        """Return displacements and speeds of the channels (channel, sample), if these are of the given order."""
        # Slow poles are drift, which integration would magnify.
        strongest = np.argmax(np.sum(np.abs(self.amplitudes) ** 2, axis=1) * (self.theta.imag > 0))
        fast = np.abs(self.theta) > (SLOW * np.abs(self.theta[strongest]) if order else 0.0)
        theta = self.theta[fast]
        powers = np.asarray(np.exp(np.outer(theta, np.arange(self.values.shape[1]))))
        return _motions(theta, self.amplitudes[fast], powers, order)

    def empty(self) -> Drive:
        """Return a drive without poles and forces."""
        return Drive(
            theta=np.zeros(0, complex),
            gains=np.zeros((0, 0), complex),
            forces=np.zeros((0, self.values.shape[1])),
            nuisances=self.nuisances,
        )

    def begun(self, count: int) -> Record:
        """Return the first samples."""
        return replace(self, values=self.values[:, :count])

    def thinned(self, factor: int, count: int) -> Record:
        """Return means over ``factor`` samples, and of those the first ``count``."""
        return replace(
            self,
            values=block_means(self.values[:, : count * factor], factor),
            theta=self.theta * factor,
            nuisances=self.nuisances * factor,
        )


def with_forces(record: Record, plain: DrivenFit, *, least_fall: float = LEAST_FALL) -> Bent:
    """Return the best fit near that of given poles with forces of one kind or two, while BIC is lower for them.

    Forces are fitted if those of one kind promise to lower the variance of the residual by a factor, less their cost.
    Of a single mode there may be more kinds, each of which lowers the variance by `LEAST_FALL`: beside other modes, a
    force may stand for one.
    """
    best = Bent(fit=plain, forces=(), order=0)
    motions = record.motions(0)
    alone = [trial for kind in ForceKind if (trial := added(record, best, kind, motions)) is not None]
    fall = plain.residual.size * np.log(least_fall)
    if not any(trial.fit.promised < plain.bic - fall for trial in alone):
        return best
    trials = alone + [
        trial
        for order in (1, 2)
        for motions in [record.motions(order)]
        for kind in ForceKind
        for trial in [added(record, replace(best, order=order), kind, motions)]
        if trial is not None
    ]
    return with_further(record, _best(record, best, trials))


def with_further(record: Record, best: Bent) -> Bent:
    """Return a fit with forces of one kind, or a better one with forces of more kinds."""
    # What a further kind must lower the BIC by: the second one anything, more than two only where the mode is single.
    needed = 0.0
    while best.forces and (not needed or best.count == 1):
        motions, present = motions_of(best), {force.kind for force in best.forces}
        more = [added(record, best, kind, motions) for kind in ForceKind if kind not in present]
        further = _best(record, best, [trial for trial in more if trial is not None])
        if further is best or further.fit.bic > best.fit.bic - needed:
            break
        best, needed = further, best.fit.residual.size * np.log(LEAST_FALL)
    return best


def _best(record: Record, before: Bent, trials: list[Bent]) -> Bent:
    """Return the best of those two trials that promise most, refitted, or the fit before them if its BIC is lower."""
    best = before
    for trial in sorted(trials, key=lambda bent: bent.fit.promised)[:TRIALS]:
        fit = maximize(record.values, trial.fit.drive, record.noise, steps=ROUGH_STEPS)
        if fit is not None:
            bent = renewed(record, _pruned(record, replace(trial, fit=fit)))
            best = bent if bent.fit.bic < best.fit.bic else best
    return best


def added(record: Record, bent: Bent, kind: ForceKind, motions: tuple[RealArray, RealArray]) -> Bent | None:
    """Return a fit to start from with forces of one more kind, less those that cannot be told from others."""
    forces, samples = list(bent.forces), list(bent.fit.drive.forces)
    # Forces that are fitted together. More cost time; with 4 channels these are all pairs.
    for force in forces_of(kind, len(record.values), most=10):
        sample = _beside(force.sampled(*motions), bent.fit, samples)
        if sample is not None:
            forces.append(force)
            samples.append(sample)
    if len(forces) == len(bent.forces):
        return None
    old = bent.fit.drive
    gains = np.zeros((len(old.theta), len(forces)), complex)
    gains[:, : len(bent.forces)] = old.gains
    drive = replace(old, forces=np.array(samples), gains=gains, through=bent.order == 2)
    fit = evaluate(record.values, drive, record.noise)
    return None if fit is None else Bent(fit=fit, forces=tuple(forces), order=bent.order)


def _beside(sample: RealArray, fit: DrivenFit, others: list[RealArray]) -> RealArray | None:
    """Return a force less its linear part in the states, of unit size; None if others explain the rest."""
    left = nonlinear_part(sample, fit)
    size = float(np.sqrt(np.mean(left**2)))
    if size < LEAST_PART:
        return None
    if others:
        own = left - np.array(others).T @ np.linalg.lstsq(np.array(others).T, left, rcond=None)[0]
        if np.sqrt(np.mean(own**2)) < LEAST_OWN * size:
            return None
    return np.asarray(left / size)


def nonlinear_part(sample: RealArray, fit: DrivenFit) -> RealArray:
    """Return a force less what is proportional to the states of the modes."""
    columns = means(np.concatenate([fit.states.real, fit.states.imag])).T
    return np.asarray(sample - columns @ np.linalg.lstsq(columns, sample, rcond=None)[0])


def _pruned(record: Record, bent: Bent) -> Bent:
    """Return the fit without the forces that are not worth their parameters."""
    while bent.forces:
        worth = bent.fit.worths
        least = int(np.argmin(worth))
        if worth[least] > 2 * len(bent.fit.drive.theta) * np.log(record.values.size):
            break
        fit = maximize(record.values, bent.fit.drive.without_force(least), record.noise, steps=ROUGH_STEPS)
        if fit is None or fit.bic > bent.fit.bic:
            break
        bent = replace(bent, fit=fit, forces=bent.forces[:least] + bent.forces[least + 1 :])
    return bent


def renewed(record: Record, bent: Bent) -> Bent:
    """Return the fit with the forces of its own motion, as long as that explains more."""
    for _ in range(RENEWALS):
        if not bent.forces:
            break
        motions = motions_of(bent)
        samples = [nonlinear_part(force.sampled(*motions), bent.fit) for force in bent.forces]
        sizes = [float(np.sqrt(np.mean(sample**2))) for sample in samples]
        if min(sizes) < LEAST_PART:
            break
        forces = np.array([sample / size for sample, size in zip(samples, sizes, strict=True)])
        fit = maximize(record.values, bent.fit.drive.with_forces(forces), record.noise, steps=ROUGH_STEPS)
        if fit is None or fit.loss > bent.fit.loss - 0.01:
            break
        bent = Bent(fit=fit, forces=bent.forces, order=bent.order)
    return bent


def motions_of(bent: Bent) -> tuple[RealArray, RealArray]:
    """Return displacements and speeds of the channels (channel, sample) as the fit has them."""
    return _motions(bent.fit.drive.theta, bent.fit.amplitudes, bent.fit.states, bent.order)


def _motions(
    theta: ComplexArray, amplitudes: ComplexArray, states: ComplexArray, order: int
) -> tuple[RealArray, RealArray]:
    """Return displacements and speeds from states (pole, sample) and their amplitudes (pole, channel)."""
    motion = (amplitudes * theta[:, None] ** -order).T @ states
    speed = (amplitudes * theta[:, None] ** (1 - order)).T @ states
    return np.asarray(motion.real), np.asarray(speed.real)


def without_forces(drive: Drive) -> Drive:
    """Return the drive with the same poles and no force."""
    return replace(drive, forces=drive.forces[:0], gains=drive.gains[:, :0], through=False)
