"""Signs in a linear fit that a decay is not linear."""

from __future__ import annotations

import numpy as np

from suspid.identification.harmonics import WEAK
from suspid.identification.nonlinear.own import repeated
from suspid.identification.selection import Selection
from suspid.words import Reason

# A linear fit with none of these multiples of a mode has no higher ones from forces either: those are weaker. A pole at
# four times another is a mode.
FIRST_MULTIPLES = 3
# Poles nearer to each other than this ratio may be parts of one mode that shifts with its amplitude.
PART = 1.1
# Unless its damping ratio is above this: what dies within a cycle belongs to the start of the motion.
RINGS = 0.5
# Samples of an envelope, by how much it rises after its least, and above what a fit leaves, where two modes beat.
ENVELOPE_SAMPLES, RISES_BY, ABOVE_RESIDUAL = 400, 2.0, 5.0


def unlike_linear(selection: Selection) -> bool:
    """Return whether a linear fit leaves signs of a decay that is not linear, so that forces are worth looking for.

    Its poles look like distortion, or poles were rejected as parts of others.
    """
    codes = {remark.code for _, remark in selection.rejected}
    return Reason.SPLIT in codes or distorted(selection) or _swerves(selection)


def _swerves(selection: Selection) -> bool:
    """Return whether the centre of the motion moves with it: a weak real pole beside pairs, and no drift.

    So it does under a damper or a spring that differs in compression and rebound.
    """
    fit, pairs = selection.fit, len(selection.fit.poles.pairs)
    sizes = np.sqrt(fit.strengths)
    sizes[:pairs] *= 2
    moves = np.array([reason not in (Reason.DRIFT, Reason.GROWING) for reason in selection.reasons[pairs:]], bool)
    return bool(pairs and np.any(moves & (sizes[pairs:] < WEAK * np.max(sizes[:pairs]))))


def distorted(selection: Selection) -> bool:
    """Return whether pairs of a linear fit are parts or harmonics of others, or none of them is a mode."""
    fit, pairs = selection.fit, selection.fit.poles.pairs
    if all(reason is not None for reason in selection.reasons[: len(pairs)]):
        return True
    amplitudes = fit.amplitudes[: len(pairs)] / np.sqrt(fit.squares + 1e-300)
    return any(
        repeated(
            complex(pairs[k]),
            amplitudes[k],
            np.delete(pairs, k),
            np.delete(amplitudes, k, axis=0),
            most=FIRST_MULTIPLES if -pairs[k].real < RINGS * abs(pairs[k]) else np.inf,
        )
        for k in range(len(pairs))
    )


def straight(selection: Selection) -> bool:
    """Return whether a linear fit leaves only noise, and its pairs are no parts or multiples: nothing rubs.

    Friction stops what moves, which only many poles follow; an AC-coupled sensor adds a real one.
    """
    split = any(remark.code is Reason.SPLIT for _, remark in selection.rejected)
    modes = selection.modes
    return bool(len(modes)) and not split and not distorted(selection) and bool(np.all(selection.loudness[modes] <= 1))


def rises_again(selection: Selection) -> bool:
    """Return whether what is near the strongest pair sinks, and rises again above the noise: one mode alone does not.

    Parts of a mode whose frequency shifts have a node as well, of what is small beside what they explain.
    """
    fit, pairs = selection.fit, selection.fit.poles.pairs
    amplitudes = np.abs(fit.amplitudes[: len(pairs)])
    energy = np.sum(amplitudes**2 / (fit.squares + 1e-300), axis=1) / -np.minimum(pairs.real, -1e-300)
    strongest = pairs[int(np.argmax(energy))] if len(pairs) else 0j
    near = np.abs(np.log(np.abs(pairs / strongest))) < np.log(PART) if len(pairs) else np.zeros(0, bool)
    if np.sum(near) < 2:
        return False
    samples = np.unique(np.linspace(0, fit.count - 1, ENVELOPE_SAMPLES).astype(int))
    courses = np.exp(np.outer(samples, pairs[near] - 1j * strongest.imag))
    size = 2 * np.abs(courses @ fit.amplitudes[: len(pairs)][near])
    lowest = np.minimum.accumulate(size, axis=0)
    loud = size > ABOVE_RESIDUAL * np.sqrt(fit.squares / fit.count)
    return bool(np.any(loud & (size > RISES_BY * lowest)))


def overtones_alone(selection: Selection) -> bool:
    """Return whether a linear fit leaves only noise and its pairs lie apart: none is a part of another that shifts.

    Multiples, sums and differences of modes beside them tell of forces that change neither frequency nor damping.
    """
    size = np.sort(np.log(np.abs(selection.fit.poles.pairs)))
    apart = bool(np.all(np.diff(size) > np.log(PART)))
    return apart and bool(np.all(selection.loudness[selection.modes] <= 1))
