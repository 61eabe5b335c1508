"""What the other decays of a recording and the rest of its motion say of a decay: it may be driven throughout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.decays.decay import FIT, Decay
from suspid.decays.doubts import doubts_of_company
from suspid.decays.trials import block_size
from suspid.signals import Signal, block_means
from suspid.units import Decibel, Ratio, RealArray
from suspid.words import DecayDoubt, Remark

# Decays that have less than this share of the power of the speeds of a recording are a small part of it. A larger share
# doubts one push of several, a smaller one believes what looks like a decay by chance.
SMALL = 0.1
# A body that is let go again and again shows the same mode, to within this share of its frequency: five standard
# deviations after two cycles. In a wider band, modes of different stretches of a drive agree by chance.
SAME_MODE = 0.1
# Decays have the same modes if each mode of the one that has fewer is in the other to within this share of its
# frequency. Resonances that noise excites scatter by more.
SAME_MODES = 0.03
# Decays this far below another are no company for it: what moves a tenth as much is noise or a knock beside it. With a
# smaller number bursts of driven motion, which are unlike in size, do not tell of each other.
FAR_WEAKER: Decibel = 20.0


def with_doubts_of_others(signal: Signal, decays: Sequence[Decay]) -> list[Decay]:
    """Return decays; those in doubt are doubted more where most others have other modes.

    So is one that no quick fit explains where most of the motion is elsewhere: forces may explain any short stretch.
    """
    out = []
    for decay in decays:
        codes = {doubt.code for doubt in decay.doubts}
        share = share_of(signal, decay) if codes & FIT else 1.0
        doubts: tuple[Remark, ...] = (Remark(DecayDoubt.SMALL_PART, {"share": share}),) if share < SMALL else ()
        if codes and DecayDoubt.COMPANY not in codes:
            beside = not_far_weaker(decay, decays)
            unlike = sum(other is not decay and not same_modes(decay, other) for other in beside)
            doubts += doubts_of_company(unlike, len(beside))
        out.append(replace(decay, doubts=(*decay.doubts, *doubts)))
    return out


def not_far_weaker(decay: Decay, others: Sequence[Decay]) -> list[Decay]:
    """Return the decays that can tell whether one is of driven motion: those that are not `FAR_WEAKER`."""
    return [other for other in others if other.level > decay.level - FAR_WEAKER]


def shares_a_mode(decay: Decay, others: Sequence[Decay]) -> bool:
    """Return whether a mode of a decay is one of another, too."""
    wn = np.concatenate([other.wn for other in others if other is not decay] or [np.zeros(0)])
    return in_common(decay.wn, wn, within=SAME_MODE)


def in_common(one: RealArray, other: RealArray, *, within: Ratio = SAME_MODES) -> bool:
    """Return whether a natural frequency is one of others too, to within a share of it.

    Examples
    --------
    >>> in_common(np.array([10.0, 20.0]), np.array([19.9, 50.0])), in_common(np.array([10.0]), np.array([11.0]))
    (True, False)
    """
    return bool(np.any(np.abs(one[:, None] / other - 1) < within))


def same_modes(one: Decay, other: Decay) -> bool:
    """Return whether all modes of one of two decays are modes of the other."""
    fewer, more = sorted((one.wn, other.wn), key=len)
    return bool(len(fewer)) and bool(np.all(np.min(np.abs(fewer[:, None] / more - 1), axis=1) < SAME_MODES))


def share_of(signal: Signal, decay: Decay) -> Ratio:
    """Return the share of the power of the speeds of a recording that is within a decay, the most of any channel."""
    size = block_size(signal.step, float(np.max(decay.wn, initial=0.0)) / (2 * np.pi) or np.inf)
    power = np.diff(block_means(signal.values, size), axis=1) ** 2
    times = signal.start + signal.step * size * (1 + np.arange(power.shape[1]))
    inside = (times >= decay.start) & (times <= decay.stop)
    return float(np.max(np.sum(power[:, inside], axis=1) / np.maximum(np.sum(power, axis=1), 1e-300)))
