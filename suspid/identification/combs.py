"""Combs: steady tones at multiples of one frequency, as engines and shakers make them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.identification.information import inverse_information
from suspid.identification.ongoing import STEADY
from suspid.identification.selection import Selection
from suspid.levels import SURE
from suspid.units import ComplexArray, RealArray, Second
from suspid.words import Reason

# Tones that share a frequency are at its multiples to within this share of the resolution of the record, 2 pi over its
# duration. A larger share takes tones apart for a comb.
OFF_TOOTH = 0.25
# Tones that a comb has at least, the share of all steady tones that are its teeth, and the largest part of all
# frequencies that are near a tooth: fewer tones, and more near teeth, are a comb by chance.
FEWEST_TEETH, MOST_OF_THEM, NEAR_TEETH = 4, 0.7, 0.05
# The lowest tone, and the smallest way between two, are at most this multiple of the shared frequency: engines have
# half orders, and their lowest ones may be missing.
HIGHEST_FIRST = 4
# What falls by less than this many nepers within the record, at a tooth, is driven: what drives it changes by as much.
# A smaller number takes lines of drifting size for modes.
LASTING = 3.0
# Poles that a train of pulses has at least, and how much faster than the median one of them decays: fewer lie at
# multiples by chance, and partials of strings decay several times as fast as each other.
FEWEST_REPEATED, ALIKE_RATES = 6, 1.6
# Multiples of a tone at which a weaker pole is one of its harmonics. Higher ones are met by chance.
OVERTONES = (2, 3)


def without_comb(selection: Selection) -> Selection:
    """Return the poles of a record, of which those that hardly decay, at the teeth of a comb of tones, are no modes.

    What drives a line of a comb may wane within a record. It stays in the fit.
    """
    poles, count = selection.fit.poles.pairs, selection.fit.count
    reasons = list(selection.reasons)
    steady = np.array([reason in STEADY for reason in reasons[: len(poles)]], bool)
    reach = OFF_TOOTH * 2 * np.pi / count
    shared = shared_frequency(poles.imag[steady], reach)
    if shared is None:
        return selection
    driven = (_off(poles.imag, shared) < reach) & (-poles.real * count < LASTING)
    for k in np.flatnonzero(driven).tolist():
        reasons[k] = reasons[k] or Reason.COMB
    return replace(selection, reasons=tuple(reasons))


def without_overtones(selection: Selection) -> Selection:
    """Return the poles of a record, of which those that hardly decay, at multiples of stronger tones, are no modes.

    A pendulum that is seen from the side moves up and down twice in a cycle. If it hardly decays, neither does that.
    Another channel may be of the height alone: there the tone need not be the stronger one, if both decay alike.
    """
    poles, count = selection.fit.poles.pairs, selection.fit.count
    reasons = list(selection.reasons)
    steady = [k for k in range(len(poles)) if reasons[k] in STEADY]
    if not steady:
        return selection
    sizes, strengths = np.abs(selection.fit.amplitudes[: len(poles)]), selection.fit.strengths[: len(poles)]
    spread = np.sqrt(np.diag(inverse_information(selection.fit.information)))[: 2 * len(poles) : 2]
    for k in range(len(poles)):
        if reasons[k] is not None or -poles[k].real * count >= LASTING:
            continue
        for multiple in OVERTONES:
            for j in steady:
                near = abs(multiple * poles[j].imag - poles[k].imag) < OFF_TOOTH * 2 * np.pi / count
                off = abs(multiple * poles[j].real - poles[k].real)
                alike = off < SURE * np.hypot(multiple * spread[j], spread[k])
                if near and (strengths[j] > strengths[k] or (alike and np.any(sizes[j] > sizes[k]))):
                    reasons[k] = Reason.OF_TONE
    return replace(selection, reasons=tuple(reasons))


def repeated_in(modes: ComplexArray, harmonics: ComplexArray, duration: Second) -> float | None:
    """Return the frequency at multiples of which most of many poles lie that decay alike [rad/s], None if none do.

    A train of pulses, each lower than the one before, is the sum of such poles. Partials of a string fade the faster
    the higher they are, and forces that are not linear make harmonics that are weak: not more than one is a mode.
    """
    turning = modes[modes.imag > 0]
    poles = np.append(turning, harmonics[harmonics.imag > 0])
    if len(turning) < 2 or len(poles) < FEWEST_REPEATED:
        return None
    reach = OFF_TOOTH * 2 * np.pi / duration
    shared = shared_frequency(poles.imag, reach)
    if shared is None or np.any(poles.real >= 0):
        return None
    spread = np.abs(np.log(poles.real / np.median(poles.real)))
    alike = (_off(poles.imag, shared) < reach) & (spread < np.log(ALIKE_RATES))
    return shared if np.mean(alike) > MOST_OF_THEM else None


def shared_frequency(tones: RealArray, reach: float) -> float | None:
    """Return the largest frequency of which tones are multiples, None if there is none.

    Examples
    --------
    A shaker at multiples of 10 Hz, with two that are not; four tones that share nothing:

    >>> shared_frequency(np.array([100.0, 120.0, 150.0, 199.99, 250.0, 320.01, 333.0]), 0.02)
    10.0
    >>> shared_frequency(np.array([101.0, 123.3, 157.9, 211.1]), 0.02)
    """
    if len(tones) < FEWEST_TEETH:
        return None
    tones = np.sort(tones)
    firsts = np.concatenate([tones[:2], np.diff(tones)])
    tried = np.unique(np.ravel([firsts / n for n in range(1, HIGHEST_FIRST + 1)]))
    for start in tried[2 * reach < NEAR_TEETH * tried][::-1].tolist():
        teeth = _off(tones, start) < 2 * reach
        numbers = np.round(tones[teeth] / start)
        if np.sum(teeth) < FEWEST_TEETH:
            continue
        nearest = float(numbers @ tones[teeth] / (numbers @ numbers))
        held = int(np.sum(_off(tones, nearest) < reach))
        if held >= FEWEST_TEETH and held > MOST_OF_THEM * len(tones):
            return nearest
    return None


def _off(frequencies: RealArray, shared: float) -> RealArray:
    """Return how far each frequency is from a multiple of another, or from it."""
    return np.asarray(np.abs(frequencies - shared * np.maximum(np.round(frequencies / shared), 1)))
