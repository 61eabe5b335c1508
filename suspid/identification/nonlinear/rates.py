"""Structures of records that are sampled far faster than they move: found in means, then fitted to every sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.beginnings import FIRST
from suspid.identification.nonlinear.choice import WITHIN_REACH, chosen
from suspid.identification.nonlinear.descent import fitted
from suspid.identification.nonlinear.driven import Drive, DrivenFit, maximize
from suspid.identification.nonlinear.feedback import ROUGH_STEPS, Bent, Record
from suspid.identification.nonlinear.forces import OF_SPEED
from suspid.identification.nonlinear.standing import stands
from suspid.identification.nonlinear.structure import StructureFit, evaluated
from suspid.identification.selection import Selection
from suspid.signals import block_means
from suspid.units import RealArray

# Samples that are left in each cycle of the strongest pole of a linear fit, and of its fastest, which may be a multiple
# that forces make. More cost time; in fewer, forces are not told apart, nor a second mode that they hide.
LEFT_OF_STRONGEST, LEFT_OF_POLE = 60.0, 10.0
# A pole counts whose power is at least this share of the largest in a channel: a mode may have a hundredth of the
# amplitude of another, and weaker lines are those of the noise.
LEAST_POWER = 1e-6
# Samples that are left at least: in fewer, many forces explain anything.
FEWEST_LEFT = 300


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class WithoutForces:
    """What a linear fit with all its poles leaves of a record, (channel, sample), and its number of unknowns."""

    residual: RealArray
    unknowns: int

    @classmethod
    def of(cls, selection: Selection) -> WithoutForces:
        """Return that of a linear fit."""
        poles = selection.fit.poles
        return cls(residual=selection.residual, unknowns=poles.free + len(selection.residual) * len(poles))

    def bic(self, noise: WhiteNoise, factor: int = 1) -> float:
        """Return the BIC of the fit beside means over several samples."""
        left = block_means(self.residual, factor)
        return noise.loss(np.sum(left**2, axis=1), left.shape[1]) + self.unknowns * float(np.log(left.size))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Means:
    """Means over several samples of a record, and what is known of them."""

    record: Record
    found: Bent | None  # the fit with forces as they were measured
    highest: float  # BIC of that and of the linear fit, the lower one
    factor: int  # samples of each mean
    whole: Record  # every sample
    whole_highest: float

    @classmethod
    def of(cls, whole: Record, found: Bent | None, linear: WithoutForces) -> Means:
        """Return the means over as many samples as a record can spare, and those fits beside them."""
        factor = _factor(whole)
        highest = _highest(linear.bic(whole.noise), found)
        record = whole
        if factor > 1:
            record = replace(whole.thinned(factor, whole.values.shape[1]), noise=whole.noise.of_means(factor))
        beside = found if found is None or factor == 1 else _with_fit(found, record, factor)
        return cls(
            record=record,
            found=beside,
            highest=_highest(linear.bic(record.noise, factor), beside),
            factor=factor,
            whole=whole,
            whole_highest=highest,
        )

    def structure(self, plain: DrivenFit, *, most: int, followed: bool, rubs: bool) -> StructureFit | None:
        """Return the structure of several modes of least BIC near a linear fit to the means (see `choice.chosen`).

        It is fitted to every sample. None if there is none.
        """
        best = chosen(self.record, plain, self.found, most=most, highest=self.highest, followed=followed, rubs=rubs)
        # The swings of a single mode are described by the forces as they were measured.
        if best is None or len(best.theta) < 2:
            return None
        if self.factor == 1:
            return best
        whole = fitted(at_full_rate(best, self.whole, self.factor), steps=FIRST)
        if whole.bic > self.whole_highest + WITHIN_REACH * whole.residual.size:
            return None
        whole = fitted(whole)
        if whole.bic >= self.whole_highest or not np.all(stands(whole)):
            return None
        return replace(whole, others=tuple(at_full_rate(other, self.whole, self.factor) for other in best.others))


def _highest(bic: float, found: Bent | None) -> float:
    return bic if found is None else min(bic, found.bic)


def at_full_rate(fit: StructureFit, record: Record, factor: int) -> StructureFit:
    """Return a structure of means over several samples beside every sample: it begins at the first of them."""
    of = fit.structures
    theta = of.theta / factor
    earlier = np.exp(-theta * (factor - 1) / 2)
    # The mean of a motion over a block is less than its middle.
    less = np.mean(np.exp(theta[:, :, None] * (np.arange(factor) - (factor - 1) / 2)), axis=2)
    follows = 1 if of.kind in OF_SPEED else 0
    structures = replace(
        of,
        theta=theta,
        shapes=of.shapes * (earlier / less * float(factor) ** fit.order)[:, :, None],
        gains=of.gains / (factor * earlier)[:, :, None],
        scales=of.scales * float(factor) ** (fit.order - follows),
    )
    return evaluated(record, structures, fit.order)


def _factor(record: Record) -> int:
    """Return over how many samples of a record means are taken, at least 1."""
    turning = np.flatnonzero(record.theta.imag > 0)
    if not turning.size:
        return 1
    theta, powers = record.theta[turning].imag, np.abs(record.amplitudes[turning]) ** 2
    shares = np.max(powers / (np.max(powers, axis=0) + 1e-300), axis=1)
    strongest, fastest = theta[int(np.argmax(np.sum(powers, axis=1)))], np.max(theta[shares > LEAST_POWER])
    spared = int(2 * np.pi / max(LEFT_OF_STRONGEST * float(strongest), LEFT_OF_POLE * float(fastest)))
    return max(1, min(spared, int(record.values.shape[1]) // FEWEST_LEFT))


def _with_fit(found: Bent, short: Record, factor: int) -> Bent | None:
    """Return a fit with forces as they were measured beside means; None if it fails."""
    fit = maximize(short.values, _thinned(found.fit.drive, factor), short.noise, steps=ROUGH_STEPS)
    return None if fit is None else replace(found, fit=fit)


def _thinned(drive: Drive, factor: int) -> Drive:
    """Return poles, and how means of forces drive them, beside means over several samples."""
    return replace(
        drive,
        theta=drive.theta * factor,
        gains=drive.gains * factor,
        forces=block_means(drive.forces, factor),
        nuisances=drive.nuisances * factor,
    )
