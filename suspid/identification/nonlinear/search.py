"""Find the forces, other than linear ones, that explain a decay better than one more pole does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from suspid.identification.classification import LEAST_EXPLAINED
from suspid.identification.harmonics import WEAK
from suspid.identification.likelihood import DecayFit
from suspid.identification.noise import WhiteNoise
from suspid.identification.nonlinear.choice import MOST_MASSES, REDUCTION, out_of_reach
from suspid.identification.nonlinear.driven import DrivenFit, evaluate, maximize
from suspid.identification.nonlinear.feedback import (
    LEAST_FALL,
    ROUGH_STEPS,
    Bent,
    Record,
    motions_of,
    nonlinear_part,
    renewed,
    with_forces,
    without_forces,
)
from suspid.identification.nonlinear.lengthening import at_full_rate, lengthened
from suspid.identification.nonlinear.own import next_poles, repeated
from suspid.identification.nonlinear.patience import counted_steps, is_exhausted, note_in_vain
from suspid.identification.nonlinear.rates import Means, WithoutForces
from suspid.identification.nonlinear.signs import distorted, overtones_alone, rises_again, straight
from suspid.identification.nonlinear.standing import driven_stands, energies, misses
from suspid.identification.selection import Selection
from suspid.units import RealArray

# Forces that explain this share of what a multiple of a mode does are preferred to it: a mode there would be chance.
NEARLY = 0.9
# Where two modes beat, forces of a single one leave more than this multiple of what they leave.
LEFT_FAR_MORE = 2.0
# Modes at most where their number is not given.
MOST_MODES = 6
# Largest number of entries of the derivatives in the search; longer records are thinned to this many samples per cycle
# of the fastest mode, and cut.
MOST_ENTRIES, PER_CYCLE = 4e4, 10.0
# Cycles of a beginning in which forces are sought: in fewer, a shift is not told from a change of phase.
FEWEST_CYCLES = 6
# A structure explains at least this share of the energy of each channel, and so do linear modes where it is sought from
# these. Where a sensor moves in other ways, none does.
EACH_EXPLAINED = 0.9


# Steps that lead nowhere may overflow; what is not finite is refused.
@np.errstate(over="ignore", invalid="ignore")
def find_forces(values: RealArray, *, noise: WhiteNoise, selection: Selection, modes: int | None = None) -> Bent | None:
    """Return the modes and the forces that explain a decay better than one more pole does; None if there are none.

    A linear fit without distortion must have the larger BIC. Within an analysis, structures of several modes are not
    sought in vain forever (see `patience`).
    """
    structures = not is_exhausted(len(values))
    sought = _Sought(values=values, noise=noise, selection=selection, modes=modes, structures=structures)
    bent, in_vain = _found(sought)
    note_in_vain(len(values), in_vain)
    return bent


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Sought:
    """A decay whose forces are sought; one that equals another has the same samples."""

    values: RealArray
    noise: WhiteNoise  # it and the selection follow from the samples
    selection: Selection
    modes: int | None
    structures: bool  # whether those of several modes are sought

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Sought):
            return NotImplemented
        return self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[object, ...]:
        # To the ninth digit: means depend on how samples stand in memory.
        largest = float(np.max(np.abs(self.values)))
        return (
            self.values.shape,
            f"{largest:.8e}",
            np.round(self.values / largest, 9).tobytes(),
            self.modes,
            self.structures,
        )


# A stretch that is verified as a decay is then identified.
@lru_cache(maxsize=2)
def _found(sought: _Sought) -> tuple[Bent | None, int]:
    """Return modes and forces, and the steps of motions in which structures of several modes were sought in vain."""
    linear = WithoutForces.of(sought.selection)
    found = _searched(sought.values, sought.noise, sought.selection.fit, sought.modes)
    with counted_steps() as steps:
        bent = _structure(sought, found, linear) if sought.structures else None
    if bent is not None:
        return bent, 0
    return _measured(sought, found, linear), steps[0]


def _measured(sought: _Sought, found: Bent | None, linear: WithoutForces) -> Bent | None:
    """Return what was found from the motion as it was measured, where that is better than a linear fit."""
    values, selection, modes = sought.values, sought.selection, sought.modes
    bic = linear.bic(sought.noise)
    if found is None or modes is not None or found.fit.bic < bic:
        return found
    if not distorted(selection) or (misses(found.fit) and overtones_alone(selection)):
        return None
    if found.count == 1 and _far_more(found, selection) and rises_again(selection):
        return None
    # Poles that are parts of a mode leave less of it than forces do, but not of a motion that these do not follow.
    followed = _follows(values, np.sum(selection.residual**2, axis=1))
    return found if np.all(_follows(values, found.fit.squares) | ~followed) else None


def _far_more(found: Bent, selection: Selection) -> bool:
    """Return whether a fit with forces leaves far more of a channel than linear modes do."""
    return bool(np.any(found.fit.squares > LEFT_FAR_MORE**2 * np.sum(selection.residual**2, axis=1)))


def _structure(sought: _Sought, found: Bent | None, linear: WithoutForces) -> Bent | None:
    """Return the structure of several modes that explains a record best, if there is one."""
    values, most = sought.values, sought.modes or MOST_MODES
    # Forces act where a motion is measured: at one point of several masses they are not seen.
    if not 1 < len(values) <= MOST_MASSES:
        return None
    record = _record(values, sought.noise, sought.selection.fit)
    if out_of_reach(record):
        return None
    if not len(record.theta):
        alone, _ = _linear_modes(record, 1)
        record = record if alone is None else replace(record, theta=alone.drive.theta, amplitudes=alone.amplitudes)
    means = Means.of(record, found, linear)
    plain, _ = _linear_modes(means.record, most)
    if plain is None:
        return None
    followed = bool(np.all(_follows(means.record.values, plain.squares)))
    try:
        structure = means.structure(plain, most=most, followed=followed, rubs=not straight(sought.selection))
    except np.linalg.LinAlgError:
        # A motion that runs away has no covariance.
        return None
    if structure is None or not np.all(_follows(values, structure.squares)):
        return None
    return Bent(fit=plain, forces=structure.forces, order=structure.order, structure=structure)


def _searched(values: RealArray, noise: WhiteNoise, linear: DecayFit, modes: int | None) -> Bent | None:
    """Return modes and forces; long records are searched by their beginning, thinned where modes are slow."""
    poles, record = linear.poles, _record(values, noise, linear)
    most = int(MOST_ENTRIES / (2 * (1 + len(values)) * len(values)))
    begun = record if values.shape[1] <= most else record.thinned(1, most)
    plain, more = _linear_modes(begun, modes or MOST_MODES)
    if plain is None:
        return None
    if _explained(plain) < LEAST_EXPLAINED:
        return _significant(_shifting(record, float(plain.drive.theta[0].imag), most))
    fastest = float(np.max(np.abs(plain.drive.theta.imag)))
    factor = max(1, int(2 * np.pi / (PER_CYCLE * fastest)))
    most //= len(plain.drive.theta)
    if not len(poles.pairs):
        record = replace(record, theta=plain.drive.theta, amplitudes=plain.amplitudes)
    if values.shape[1] <= most:
        return _significant(_grown(record, plain, more, modes))
    factor = min(factor, -(-values.shape[1] // most))
    short = record.thinned(factor, most)
    start = replace(
        plain.drive,
        theta=plain.drive.theta * factor,
        forces=np.zeros((0, short.values.shape[1])),
        nuisances=short.nuisances,
    )
    again = maximize(short.values, start, noise, steps=ROUGH_STEPS)
    beside = None if again is None else _with_pole(short, again)
    found = None if again is None else _grown(short, again, beside, modes)
    return None if found is None else _significant(_at_full_length(record, found, factor))


def _shifting(record: Record, turn: float, most: int) -> Bent | None:
    """Return a single mode whose frequency shifts too far for a pole to follow it, with its forces; None if none is.

    They are found where a pole explains nearly all, in the beginning, and followed on from there. The frequency of the
    linear fit [rad per sample] lies among those of the mode.
    """
    factor = max(1, int(2 * np.pi / (PER_CYCLE * turn)))
    used = record if factor == 1 else record.thinned(factor, record.values.shape[1])
    count, least = used.values.shape[1], FEWEST_CYCLES * 2 * np.pi / (turn * factor)
    while count <= most and (count := count // 2) > least:
        short = used.begun(count)
        plain, _ = _linear_modes(short, 1)
        # Steps of a fit may go beyond the Nyquist frequency, or to a drift, where no cycles are seen.
        seen = plain is not None and 2 * np.pi * FEWEST_CYCLES / count < plain.drive.theta[0].imag < np.pi
        if plain is not None and seen and _explained(plain) > EACH_EXPLAINED:
            found = lengthened(used, plain)
            found = found if factor == 1 or found is None else at_full_rate(record, found, factor, turn)
            return found if found is not None and _explained(found.fit) > EACH_EXPLAINED else None
    return None


def _explained(fit: DrivenFit) -> float:
    """Return the share of the energy that a fit explains in the best channel."""
    return float(np.max(1 - fit.squares / np.sum(fit.values**2, axis=1)))


def _follows(values: RealArray, squares: RealArray) -> NDArray[np.bool_]:
    """Return in which channels a fit leaves so little of the samples that it follows the motion, (channel,)."""
    return np.asarray(1 - squares / np.sum(values**2, axis=1) >= EACH_EXPLAINED)


def _record(values: RealArray, noise: WhiteNoise, linear: DecayFit) -> Record:
    """Return a record with its motion as a linear fit follows it."""
    poles = linear.poles
    twice = np.where(np.arange(len(poles.every)) < len(poles.pairs), 2.0, 1.0)
    return Record(
        values=values,
        noise=noise,
        theta=poles.every.astype(complex),
        amplitudes=twice[:, None] * linear.amplitudes[poles.rows],
        nuisances=poles.nuisances,
    )


def _significant(bent: Bent | None) -> Bent | None:
    """Return what was found if every mode is one (see `driven_stands`), else None."""
    return bent if bent is not None and np.all(driven_stands(bent.fit)) else None


def _at_full_length(record: Record, found: Bent, factor: int) -> Bent | None:
    """Return the fit to a record of what was found in means over several samples of its beginning."""
    drive, count = found.fit.drive, record.values.shape[1]
    forces = np.repeat(drive.forces, factor, axis=1)[:, :count]
    forces = np.pad(forces, ((0, 0), (0, count - forces.shape[1])))
    full = replace(
        drive, theta=drive.theta / factor, gains=drive.gains / factor, forces=forces, nuisances=record.nuisances
    )
    fit = evaluate(record.values, full, record.noise)
    if fit is None:
        return None
    # The forces go on with the motion; twice, since what is not yet fitted bends them.
    for _ in range(2):
        motions = motions_of(replace(found, fit=fit))
        samples = [nonlinear_part(force.sampled(*motions), fit) for force in found.forces]
        forces = np.array([sample / np.sqrt(np.mean(sample**2)) for sample in samples])
        again = maximize(record.values, fit.drive.with_forces(forces), record.noise, steps=ROUGH_STEPS)
        if again is None:
            return None
        fit = again
    plain = maximize(record.values, without_forces(fit.drive), record.noise, steps=ROUGH_STEPS)
    return None if plain is not None and plain.bic < fit.bic else replace(found, fit=fit)


def _linear_modes(record: Record, most: int) -> tuple[DrivenFit | None, DrivenFit | None]:
    """Return the fit with the strongest poles, as long as each is a mode of its own, and the fit with one more."""
    plain = maximize(record.values, record.empty(), record.noise, steps=0)
    more = None if plain is None else _with_pole(record, plain)
    while plain is not None and more is not None and len(plain.drive.theta) < most:
        if more.bic >= plain.bic or not _own(more):
            break
        plain, more = more, _with_pole(record, more)
    return (plain if plain is not None and len(plain.drive.theta) else None), more


def _grown(record: Record, plain: DrivenFit, more: DrivenFit | None, modes: int | None) -> Bent | None:
    """Return the fit with forces, and beside them with further modes that explain most of the residual.

    With a number of modes given, no more are used, and the forces need only explain more than they cost; without, they
    must explain more than one more pole.
    """
    # A multiple of a mode, or a part of it, is a sign of forces however weak it is.
    fall = 1.0 if more is not None and not _own(more) else LEAST_FALL
    found = with_forces(record, plain, least_fall=fall)
    while len(found.fit.drive.theta) > 1:
        stands = driven_stands(found.fit)
        if found.forces and np.all(stands):
            break
        weakest = plain.drive.without_pole(int(np.argmin(stands if found.forces else energies(plain, plain.states))))
        fewer = maximize(record.values, weakest, record.noise, steps=ROUGH_STEPS)
        less = None if fewer is None else with_forces(record, fewer, least_fall=fall)
        if fewer is None or less is None or not (found.forces or less.fit.bic < found.fit.bic):
            break
        plain, found = fewer, less
    while len(found.fit.drive.theta) < (modes or MOST_MODES) and np.any(
        found.fit.variance > 1.001 * record.noise.least
    ):
        further = _with_pole(record, found.fit)
        if further is None or not _own(further):
            break
        straight = maximize(record.values, without_forces(further.drive), record.noise, steps=ROUGH_STEPS)
        options = [renewed(record, replace(found, fit=further))]
        options += [] if straight is None else [with_forces(record, straight)]
        best = min(options, key=lambda bent: bent.fit.bic)
        reduced = float(np.max(np.sqrt(found.fit.variance / best.fit.variance)))
        if best.fit.bic >= found.fit.bic or not (reduced > REDUCTION or modes is not None):
            break
        if not _own(best.fit) or _significant(best) is None:
            break
        found, more = best, None if straight is None else _with_pole(record, straight)
    if not found.forces:
        return None
    if modes is not None or more is None or found.fit.bic <= more.bic:
        return found
    # What one more pole explains that is no mode of its own, forces need not explain in full.
    nearly = plain.loss - found.fit.loss > NEARLY * (plain.loss - more.loss)
    return found if nearly and not _own(more) and len(found.fit.drive.theta) < len(more.drive.theta) else None


def _with_pole(record: Record, before: DrivenFit) -> DrivenFit | None:
    """Return the fit with one more pole, rather with one that is a mode of its own; None if there is none."""
    fits = [
        maximize(record.values, before.drive.with_pole(theta), record.noise, steps=ROUGH_STEPS)
        for theta in next_poles(before.residual, before.variance, record.noise)
    ]
    better = [fit for fit in fits if fit is not None and fit.bic < before.bic]
    own = [fit for fit in better if _own(fit)]
    return min(own or better, key=lambda fit: fit.bic, default=None)


def _own(fit: DrivenFit) -> bool:
    """Return whether the last pole is a mode of its own: it decays, and is no part or multiple of another mode."""
    theta, amplitudes = fit.drive.theta, fit.amplitudes / np.sqrt(fit.variance)
    # The forces have the harmonics.
    weak = 0.0 if len(fit.drive.forces) else WEAK
    return theta[-1].real <= 0 and not repeated(theta[-1], amplitudes[-1], theta[:-1], amplitudes[:-1], weak=weak)
