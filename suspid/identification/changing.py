"""Modes that change over the record: poles near each other that make one motion, which decays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.candidates import Candidate
from suspid.identification.classification import is_tone, reasons_of
from suspid.identification.exponentials import blocks_of, synthesize
from suspid.identification.fitting import Problem
from suspid.identification.information import inverse_information
from suspid.identification.likelihood import reweighed
from suspid.identification.noise import WhiteNoise
from suspid.identification.ongoing import STEADY, lines_of
from suspid.identification.selection import Selection
from suspid.units import RealArray
from suspid.words import Reason, Remark

# The motion of poles near each other decays if the energy of its last third is below this share of that of its first.
# A steady line whose speed wanders beats, which a smaller share keeps apart; with a larger one slow decays are lost.
FALLEN = 0.6
# One pole stands for several if it leaves less than this share of the energy of their motion. A larger share takes two
# modes for one, a smaller one leaves a mode that changes in parts.
LEFT_AS_ONE = 0.1


def with_changing(selection: Selection, values: RealArray, noise: WhiteNoise, band: tuple[float, float]) -> Selection:
    """Return the poles of a record, of which those that make one decaying motion with a steady one are one pole.

    A mode whose frequency or damping changes with its amplitude is fitted by several poles, of which some grow or stay
    by chance. Alone they are a tone and a decay; together they are the mode. The values are the record less its mean.
    """
    groups = _groups(selection)
    if not groups:
        return selection
    blocks = blocks_of(values)
    problem = Problem(values=values, blocks=blocks, noise=noise.rounded(blocks.energy, blocks.count))
    for group in groups:
        one = _as_one(problem, selection, group, band)
        # Others are numbered anew then.
        if one is not None:
            return with_changing(one, values, noise, band)
    return selection


def _groups(selection: Selection) -> list[NDArray[np.intp]]:
    """Return the poles near each other, of which some are steady or grow, whose motion decays."""
    poles, count = selection.fit.poles.pairs, selection.fit.count
    steady = np.array([reason in STEADY for reason in selection.reasons[: len(poles)]], bool)
    line = lines_of(poles, count)
    groups = [np.flatnonzero(line == each) for each in np.unique(line[steady])]
    third = count // 3
    found = []
    for group in groups:
        energy = _motion(selection, group) ** 2 / (selection.fit.squares[:, None] + 1e-300)
        if len(group) > 1 and np.sum(energy[:, -third:]) < FALLEN * np.sum(energy[:, :third]):
            found.append(group)
    return found


def _as_one(
    problem: Problem, selection: Selection, group: NDArray[np.intp], band: tuple[float, float]
) -> Selection | None:
    """Return the selection with one pole in place of a group, None if that is no mode or leaves more than a little."""
    poles = selection.fit.poles
    motion, third = _motion(selection, group), selection.fit.count // 3
    weight = 1 / (selection.fit.squares + 1e-300)
    sizes = [float(weight @ np.sum(part**2, axis=1)) for part in (motion[:, :third], motion[:, -third:])]
    rate = np.log(sizes[0] / max(sizes[1], 1e-300)) / (4 * third)
    energies = np.sum(np.abs(selection.fit.amplitudes[group]) ** 2 * weight, axis=1)
    frequency = float(poles.pairs[group[int(np.argmax(energies))]].imag)
    start = poles
    for index in sorted(group.tolist(), reverse=True):
        start = start.without(index)
    place = len(start.pairs)
    fit = problem.fitted(start.with_pair(complex(-rate, frequency)))
    if fit is None:
        return None
    left = np.sum((fit.residual - selection.residual) ** 2, axis=1)
    solution = reweighed(fit.solution, problem.noise, fit.squares)
    reasons = reasons_of(solution, band, fit.loudness, fit.explained)
    # What one pole leaves of the motion is no white noise, and its rate known no better than that says.
    variance = inverse_information(solution.information)[2 * place, 2 * place] * max(float(fit.loudness[place]), 1.0)
    if is_tone(-float(solution.poles.pairs[place].real), float(np.sqrt(variance)), selection.fit.count):
        return None
    if reasons[place] is not None or weight @ left > LEFT_AS_ONE * (weight @ np.sum(motion**2, axis=1)):
        return None
    parts = tuple(
        (Candidate(theta=complex(poles.pairs[k]), real=False, gain=float(selection.gains[k])), Remark(Reason.SPLIT))
        for k in group.tolist()
    )
    pairs = np.zeros(len(solution.poles.every), bool)
    pairs[place] = True
    return replace(
        selection,
        fit=solution,
        reasons=reasons,
        gains=problem.gains(fit),
        loudness=fit.loudness,
        residual=fit.residual,
        widening=np.zeros(len(pairs)),
        bends=pairs,
        rejected=parts + selection.rejected,
    )


def _motion(selection: Selection, group: NDArray[np.intp]) -> RealArray:
    """Return the motion of some of the pairs, (channel, sample)."""
    fit = selection.fit
    rows = np.concatenate([group, len(fit.poles.pairs) + group])
    return synthesize(fit.poles.exponents[rows], fit.amplitudes[rows], fit.count)
