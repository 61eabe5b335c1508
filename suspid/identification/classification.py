"""Why a fitted pole is no mode."""

from __future__ import annotations

import numpy as np

from suspid.identification.information import inverse_information
from suspid.identification.likelihood import DecayFit
from suspid.levels import SURE
from suspid.units import Ratio, RealArray
from suspid.words import Reason

# A pole that decays by less than a quarter of a neper over the record is a tone unless its decay rate is this many
# standard deviations above zero. Real tones drift, which shows as a slight decay or growth.
TONE_SURE = 10.0
# Nepers over the record below which nothing decays, however well a simulation without noise knows it.
LEAST_DECAY_SEEN = 1e-6
# Nepers that a tone may lose over the record by itself: sources of hum vary by less.
LEAST_FADE = 0.05
# Nepers by which a pole grows over the record at least: hum that gets louder by less drives nothing that decays.
LEAST_GROWTH = 0.1
# Share of the energy of the best channel below which most of a record is other motion than the decay: standard
# deviations are then widened by it, and no forces are looked for.
LEAST_EXPLAINED = 0.5
# A pole that decays by more than this per sample has gone before it can be seen to oscillate.
MOST_DECAY = 0.5
# Fewer samples per unknown of a channel than this: the fit follows any motion.
SAMPLES_EACH = 8


def reasons_of(
    fit: DecayFit, band: tuple[float, float], loudness: RealArray, explained: Ratio
) -> tuple[Reason | None, ...]:
    """Return why each free pole (pairs, then reals) is no mode, None for a mode.

    The band holds the angular frequencies per sample between which a pole can be a mode. ``loudness`` (pole,) is the
    power of the residual near each pole over that of white noise, ``explained`` the share of the energy of the best
    channel that is fitted. Where that is little, the residual near a pole is other motion, in which lines decay by
    chance: standard deviations are widened by it.
    """
    spread, pairs = np.sqrt(np.diag(inverse_information(fit.information))), len(fit.poles.pairs)
    other = (loudness > 1) & (explained < LEAST_EXPLAINED)
    of_rates = np.concatenate([spread[: 2 * pairs : 2], spread[2 * pairs :]]) * np.where(other, np.sqrt(loudness), 1.0)
    known = zip(fit.poles.every, of_rates, other, strict=True)
    return tuple(_reason(p, s, bool(o), fit.count, band) for p, s, o in known)


def is_tone(decay: float, spread: float, count: int) -> bool:
    """Return whether a decay rate per sample, known to a standard deviation, is none over a number of samples."""
    return decay * count < (1.0 if decay < SURE * spread else 0.25 if decay < TONE_SURE * spread else LEAST_DECAY_SEEN)


def fading(fit: DecayFit, loudness: RealArray) -> RealArray:
    """Return which share of its amplitude each pair loses over the record, (pair,); 0 where that may be chance."""
    pairs = len(fit.poles.pairs)
    spread = np.sqrt(np.diag(inverse_information(fit.information))[: 2 * pairs : 2] * np.maximum(loudness[:pairs], 1.0))
    decays = -fit.poles.pairs.real
    seen = decays > np.maximum(SURE * spread, LEAST_FADE / fit.count)
    return np.where(seen, -np.expm1(-decays * fit.count), 0.0)


def _reason(theta: complex, spread: float, other: bool, count: int, band: tuple[float, float]) -> Reason | None:
    decay = -theta.real
    if decay < -SURE * spread and -decay * count > LEAST_GROWTH:
        return Reason.GROWING
    if decay > MOST_DECAY:
        return Reason.A_FEW_SAMPLES
    if theta.imag == 0:
        # A drift decays by less than e^-3 over the record. A larger limit takes slow real modes for drifts.
        return Reason.DRIFT if decay * count < 3.0 else None
    if abs(theta.imag) * count < 2 * np.pi:
        return Reason.UNDER_A_CYCLE
    if is_tone(decay, spread, count):
        return Reason.TONE
    if other and decay < TONE_SURE * spread:
        return Reason.UNSURE
    # A sampled motion near the Nyquist frequency cannot be told from a real pole of alternating sign.
    if theta.imag > 0.98 * np.pi or abs(theta) > np.pi:
        return Reason.NEAR_NYQUIST
    if not band[0] <= abs(theta) <= band[1]:
        return Reason.OUTSIDE_THE_BAND
    return None


def ambiguous(gains: RealArray, pair_gains: RealArray, *, channels: int) -> RealArray:
    """Return which real poles could as well be heavily damped pairs, (real,), from what each and such a pair gains.

    By chance a pair gains a chi-square with as many degrees of freedom as it has more parameters.
    """
    from scipy.special import chdtri

    # A real pole is a mode if it raises twice the log likelihood by at least 150, so that a pair would show, and if
    # the pair nearest to it gains no more than chance gives with probability 0.14.
    return np.asarray((pair_gains > chdtri(1 + channels, 0.14)) | (gains < 150.0))
