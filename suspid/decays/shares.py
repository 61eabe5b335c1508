"""How much of the motion of a recording is in its decays: where that is little, it may be driven throughout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.decays.decay import GRAVE, Decay
from suspid.decays.trials import block_means, block_size
from suspid.signals import Signal
from suspid.words import DecayDoubt, Remark

# Doubts of a quick fit to a decay, that it is long enough for its modes, and that it is more than a coincidence.
FIT = frozenset(
    {DecayDoubt.FORCED, DecayDoubt.DRIVEN, DecayDoubt.NONLINEAR, DecayDoubt.GROWING, DecayDoubt.HIGH_RESIDUAL}
)
LITTLE = frozenset({DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT, DecayDoubt.FEW_SAMPLES})
BY_CHANCE = frozenset({DecayDoubt.COMPANY, DecayDoubt.SMALL_PART})
# Decays with the same modes that have less than this share of the power of the speeds of a recording are a small part
# of it. A larger share doubts one push of several, a smaller one believes what looks like a decay by chance.
SMALL = 0.1
# A body that is let go again and again shows the same mode, to within this share of its frequency: five standard
# deviations after two cycles. In a wider band, modes of different stretches of a drive agree by chance.
SAME_MODE = 0.1
# Decays have the same modes if each mode of the one that has fewer is in the other to within this share of its
# frequency. Resonances that noise excites scatter by more.
SAME_MODES = 0.03


def with_doubt_of_share(signal: Signal, decays: Sequence[Decay]) -> list[Decay]:
    """Return decays; those in doubt are doubted more where most of the motion is in none that has the same modes.

    Where a fit to one does not hold, others that have its modes do not speak for it.
    """
    shares = [_share(signal, decay) for decay in decays]
    out = []
    for decay, share in zip(decays, shares, strict=True):
        alike = [other is decay or same_modes(decay, other) for other in decays]
        together = sum(one for one, same in zip(shares, alike, strict=True) if same)
        codes = {doubt.code for doubt in decay.doubts}
        small = share < SMALL and bool(codes) and (together < SMALL or bool(codes & FIT))
        doubt = (Remark(DecayDoubt.SMALL_PART, {"share": share, "together": together}),) if small else ()
        out.append(replace(decay, doubts=(*decay.doubts, *doubt)))
    return out


def by_chance(decay: Decay) -> bool:
    """Return whether a stretch looks like a decay by chance: most events are none, and it says little of its modes."""
    codes = {doubt.code for doubt in decay.doubts if not _in_others(doubt)}
    return bool(codes & BY_CHANCE) and bool(codes & (GRAVE - BY_CHANCE | LITTLE))


def _in_others(doubt: Remark) -> bool:
    """Return whether decays with the modes of a small part are no small part."""
    together = doubt.numbers.get("together")
    return isinstance(together, float) and together >= SMALL


def shares_a_mode(decay: Decay, others: Sequence[Decay]) -> bool:
    """Return whether a mode of a decay is one of another, too."""
    wn = np.concatenate([other.wn for other in others if other is not decay] or [np.zeros(0)])
    return bool(np.any(np.abs(decay.wn[:, None] / wn - 1) < SAME_MODE))


def same_modes(one: Decay, other: Decay) -> bool:
    """Return whether all modes of one of two decays are modes of the other."""
    fewer, more = sorted((one.wn, other.wn), key=len)
    return bool(len(fewer)) and bool(np.all(np.min(np.abs(fewer[:, None] / more - 1), axis=1) < SAME_MODES))


def _share(signal: Signal, decay: Decay) -> float:
    """Return the share of the power of the speeds of a recording that is within a decay, the most of any channel."""
    size = block_size(signal.step, float(np.max(decay.wn, initial=0.0)) / (2 * np.pi) or np.inf)
    power = np.diff(block_means(signal.values, size), axis=1) ** 2
    times = signal.start + signal.step * size * (1 + np.arange(power.shape[1]))
    inside = (times >= decay.start) & (times <= decay.stop)
    return float(np.max(np.sum(power[:, inside], axis=1) / np.maximum(np.sum(power, axis=1), 1e-300)))
