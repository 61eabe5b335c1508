"""Forced motion at the beginning of a record that a few exponentials fit as well."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from suspid.identification.halves import disagreement
from suspid.identification.selection import Selection
from suspid.levels import UNLIKELY
from suspid.units import RealArray
from suspid.words import Reason

# Motions of single poles cancel each other where their energies add up to this many times that of their sum, or where
# the modes have less than its inverse: modes of a decay have about 1, close and heavily damped ones up to 1.5. A
# smaller number rejects those, a larger one takes the beginning of a pulse for a decay.
CANCELLING = 2.0
# Pairs that are seen together in fewer samples than this number for each of their unknowns follow any motion: with one
# for each they follow it exactly. A larger number rejects wheel modes of cars that are sampled slowly.
SAMPLES_PER_UNKNOWN = 2.0
# Poles of these reasons follow motion that is not free yet.
FORCED = frozenset({Reason.A_FEW_SAMPLES, Reason.BEGINNING})
# One or two pairs are known by their gain alone.
FEWEST_TOGETHER = 3


def without_pulse(selection: Selection, values: RealArray) -> Selection:
    """Return the poles of a record, of which none is a mode where they follow a pulse of force rather than a decay.

    It is called one where nothing but the fit supports a mode (no mode is seen in each half of its decay, all channels
    move alike) and the fit holds together by cancellation: it has to follow a motion that begins slowly.
    """
    modes = selection.modes
    if not len(modes) or not (cancelling(selection) and one_shape(values - selection.residual, *_noise(selection))):
        return selection
    fit, noise_std = selection.fit, _noise(selection)[0]
    pairs = modes[modes < len(fit.poles.pairs)]
    if any(np.isfinite(disagreement(values, fit.poles, int(k), noise_std)) for k in pairs):
        return selection
    reasons = [Reason.PULSE if reason is None else reason for reason in selection.reasons]
    return replace(selection, reasons=tuple(reasons))


def without_beginning(selection: Selection) -> Selection:
    """Return the poles of a record, of which those are no modes that only follow its first samples together.

    Motion that is not free yet, after a release or a contact, is followed by several pairs that die at once.
    """
    fit, pairs = selection.fit, len(selection.fit.poles.pairs)
    falls = -fit.poles.pairs.real
    amplitudes = np.max(2 * np.abs(fit.amplitudes[:pairs]) / (_noise(selection)[0] + 1e-300), axis=1)
    free = [reason is None or reason in FORCED for reason in selection.reasons[:pairs]]
    # Samples until each meets the noise, but at least those of its time constant.
    lasts = np.log(np.maximum(amplitudes, math.e)) / np.where(falls > 0, falls, 1e-300)
    order = np.array([k for k in np.argsort(lasts).tolist() if free[k]], np.intp)
    channels = fit.amplitudes.shape[1]
    unknowns = 2 * (1 + channels) * np.arange(1, len(order) + 1)
    together = np.flatnonzero(SAMPLES_PER_UNKNOWN * unknowns > channels * lasts[order]) + 1
    if not together.size or together[-1] < FEWEST_TOGETHER:
        return selection
    reasons = list(selection.reasons)
    for k in order[: together[-1]].tolist():
        reasons[k] = Reason.BEGINNING
    return replace(selection, reasons=tuple(reasons))


def one_shape(motion: RealArray, noise_std: RealArray, unknowns: int) -> bool:
    """Return whether all channels of a fitted motion (channel, sample) move alike.

    What moves beside the principal direction is then noise: as much as the ``unknowns`` of each channel take up.
    """
    from scipy.special import chdtri

    scaled = motion / np.where(noise_std > 0, noise_std, 1.0)[:, None]
    sizes = np.linalg.svd(scaled - scaled.mean(axis=1, keepdims=True), compute_uv=False)
    return len(sizes) < 2 or bool(np.sum(sizes[1:] ** 2) < chdtri(unknowns * (len(sizes) - 1), UNLIKELY))


def cancelling(selection: Selection) -> bool:
    """Return whether the motions of single poles cancel each other, see `CANCELLING`; tones and drifts aside."""
    fit, pairs = selection.fit, len(selection.fit.poles.pairs)
    aside = (Reason.TONE, Reason.DRIFT)
    free = np.flatnonzero([reason not in aside for reason in selection.reasons])

    # Products of the motions of two exponentials over the noise, of all channels.
    shares = (fit.gram * ((fit.amplitudes.conj() / (fit.squares + 1e-300)) @ fit.amplitudes.T)).real

    def energy(which: NDArray[np.intp]) -> float:
        rows = np.concatenate([fit.poles.rows[which], which[which < pairs] + pairs])
        return float(shares[rows[:, None], rows].sum())

    together = energy(free)
    alone = sum(energy(free[k : k + 1]) for k in range(len(free)))
    return alone > CANCELLING * together or energy(selection.modes) < together / CANCELLING


def _noise(selection: Selection) -> tuple[RealArray, int]:
    """Return the standard deviation of the noise, (channel,), and the number of unknowns of each channel."""
    fit = selection.fit
    return np.sqrt(fit.squares / fit.freedom), 2 * len(fit.poles.every)
