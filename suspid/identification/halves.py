"""The disagreement of the two halves of a decay on a mode: about 1 if the decay is linear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from suspid.identification.ascent import Evaluated, Known, maximize, settled
from suspid.identification.exponentials import Blocks, blocks_of
from suspid.identification.information import inverse_information
from suspid.identification.likelihood import DecayFit, evaluate, evaluate_samples
from suspid.identification.noise import KnownNoise, WhiteNoise
from suspid.identification.poles import Poles
from suspid.levels import FEWEST_SAMPLES
from suspid.units import RealArray

# Rounding error of the residual energy over the energy of the noise above which a half is fitted by its samples.
MOST_ROUNDING = 1e-6
# Information on a pole, in units of its own size, that knows it to a third; and to itself: a half that begins with less
# is not fitted, since no fit nearby knows nine times as much.
KNOWN_TO_A_THIRD, KNOWN_TO_ITSELF = 3.0**2, 1.0
HELD = 1e-3  # of its own size: a pole that moves less than this stays where it is


def halfway(decay: float, count: int) -> int:
    """Return the sample before which half of the information on a pole lies, for a decay rate per sample.

    The information of sample k goes as ``k^2 exp(-2 decay k)``.
    """
    k = np.arange(count)
    information = np.cumsum(k**2.0 * np.exp(-2 * decay * k))
    return int(np.searchsorted(information, information[-1] / 2))


def disagreement(values: RealArray, poles: Poles, which: int, noise_std: RealArray) -> float:
    """Return the distance of a pair in the two halves of the decay over its standard deviation.

    It is the root mean square of real and imaginary part, NaN where a half does not determine the pair. The poles are
    fitted to the whole record; ``noise_std`` is that of each channel. In each half all poles are fitted, each known
    beforehand to a standard deviation of its own size over the record: what a half does not show stays where it is.
    """
    decay = max(0.0, -float(poles.pairs[which].real))
    cut = halfway(decay, values.shape[1])
    std = np.maximum(np.abs(np.concatenate([poles.pairs.real.repeat(2), poles.reals])), 1 / values.shape[1])
    known = Known(poles=poles, std=std)
    parts = values[:, :cut], values[:, cut:]
    if min(part.shape[1] for part in parts) < FEWEST_SAMPLES:
        return float("nan")

    def variance(fit: DecayFit) -> RealArray:
        """Return the variances of the real and imaginary part of the pair."""
        return inverse_information(fit.information + np.diag(1 / std**2)).diagonal()[2 * which : 2 * which + 2]

    begun = []
    for part in parts:
        half = _begun(part - part.mean(axis=1, keepdims=True), poles, noise_std)
        if half is None or np.any(variance(half.start) > decay**2 / (KNOWN_TO_ITSELF + 1)):
            return float("nan")
        begun.append(half)
    found, spread = [], []
    for half in begun:
        fit = half.fitted(known)
        # A fit that leads further off than the decay rate, or knows it no better than to a third, is not of this pair.
        if fit is None or abs(fit.poles.pairs[which] - poles.pairs[which]) >= decay:
            return float("nan")
        # Known to a third by the half alone: together with what was known beforehand, variances add inversely.
        if not np.all(variance(fit) < decay**2 / (KNOWN_TO_A_THIRD + 1)):
            return float("nan")
        found.append(fit.poles.pairs[which])
        spread.append(variance(fit))
    apart = found[0] - found[1]
    return float(np.sqrt(np.mean(np.array([apart.real, apart.imag]) ** 2 / (spread[0] + spread[1]))))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Half:
    """A part of a record at the poles of the whole."""

    blocks: Blocks
    noise: WhiteNoise
    evaluated: Evaluated  # the fit at given poles
    start: DecayFit  # that at the poles of the whole

    def fitted(self, known: Known) -> DecayFit | None:
        """Return the most probable fit."""
        known = _with_unseen_held(self.start, known)
        fit = maximize(self.blocks, self.start, self.noise, known=known, evaluated=self.evaluated)
        return fit and settled(fit, self.evaluated, known=known)


def _begun(values: RealArray, poles: Poles, noise_std: RealArray) -> _Half | None:
    """Return a part of a record, less its mean, at poles; None where these are linearly dependent."""
    blocks = blocks_of(values)
    noise = KnownNoise(least=noise_std**2).rounded(blocks.energy, blocks.count, of_energies=True)
    evaluated: Evaluated = partial(evaluate, blocks, noise=noise)
    start = evaluated(poles)
    if start is not None and np.any(start.rounding > MOST_ROUNDING * noise.least * blocks.count):
        # Over a few samples slow poles are nearly alike.
        evaluated = partial(evaluate_samples, values, noise=noise)
        start = evaluated(poles)
    return None if start is None else _Half(blocks=blocks, noise=noise, evaluated=evaluated, start=start)


def _with_unseen_held(start: DecayFit, known: Known) -> Known:
    """Return the known poles; those that the record does not determine to a third are fixed.

    Their amplitudes are noise there, and a fit would take many steps between equally likely poles.
    """
    pairs = len(known.poles.pairs)
    pole = np.concatenate([np.arange(pairs).repeat(2), np.arange(pairs, pairs + len(known.poles.reals))])
    worth = start.information.diagonal() * known.std**2
    seen = np.bincount(pole, weights=worth < KNOWN_TO_A_THIRD) == 0
    return Known(poles=known.poles, std=np.where(seen[pole], known.std, HELD * known.std))
