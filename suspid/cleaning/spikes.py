"""Spikes: single samples that no motion reaches, and single samples off the motion around them."""

from __future__ import annotations

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.stamps import Indices
from suspid.units import RealArray
from suspid.words import Defect, Number

# Single samples that lie this many times as far from the median as this share of all, while their neighbours are within
# the second number: spikes, if there are as many. Fewer may be blows; a lower factor takes blows that are sampled once.
SPIKE_OVER, BESIDE_SPIKE, WITHIN, FEWEST_SPIKES = 1000.0, 30.0, 0.95, 3
# Samples that tell the spread of a channel within a factor of two.
SAMPLES_LOOKED_AT = 4096
# Samples of a block, and the share of them whose distance from the mean of their neighbours is at most the level of
# the block. Two spikes in a block, and their neighbours, are fewer than the rest.
A_BLOCK, LEVEL_SHARE = 64, 0.9
# A sample is off the motion around it by this many levels; without it, its neighbours are off by no more than the
# second number. White noise is hardly ever off by more than four.
OFF_BY, WITHOUT_IT = 6.0, 2.0
# The motion around it spreads by this many levels, by no more than this factor less before than behind it or the other
# way round, and by no more than this many times its own distance: a blow that is sampled once sets motion off, and a
# channel of blows has none. Spreads are between the last numbers, which leave out other spikes.
SPREADS, AS_BEFORE, SMALL_BESIDE, BUT_OTHERS = 5.0, 3.0, 5.0, (0.05, 0.95)
# Share of samples that are spikes at most: more are another signal.
MOST_SPIKES = 0.02


def without_spikes(name: str, times: RealArray, values: RealArray) -> tuple[RealArray, list[Finding]]:
    """Return the samples with NaN for single ones that no motion reaches, and the finding that names them.

    A counter that wraps round leaves them in the speed that is computed from it. Both neighbours of each lie among the
    others: the first sample of a blow is followed by more.
    """
    at = _off_the_motion(values)
    if at.size:
        left, right = values[at - 1], values[at + 1]
        numbers: dict[str, Number] = {"off": float(np.min(np.abs(values[at] - 0.5 * (left + right))))}
        return _without(at, values), [found(Defect.SPIKES, times[at], at.size, numbers, channel=name)]
    if not np.any(np.isfinite(values)) or _keeps_within(values):
        return values, []
    about = np.abs(values - np.nanmedian(values))
    within = float(np.nanquantile(about, WITHIN))
    far = np.nan_to_num(about) > SPIKE_OVER * within
    if not within or np.sum(far) < FEWEST_SPIKES:
        return values, []
    beside = np.zeros(len(values), bool)
    near = np.nan_to_num(about) > BESIDE_SPIKE * within
    beside[1:] |= near[:-1]
    beside[:-1] |= near[1:]
    at = np.flatnonzero(far & ~beside)
    if at.size < FEWEST_SPIKES or at.size < np.sum(far):
        return values, []
    numbers = {"least": float(np.min(np.abs(values[at]))), "within": within, "share": 100 * WITHIN}
    return _without(at, values), [found(Defect.SPIKES, times[at], at.size, numbers, channel=name)]


def _without(at: Indices, values: RealArray) -> RealArray:
    spiked = values.copy()
    spiked[at] = np.nan
    return spiked


def _keeps_within(values: RealArray) -> bool:
    """Return whether some of the samples show that none is a spike: a look at all of them takes long."""
    some = values[:: max(1, values.size // SAMPLES_LOOKED_AT)]
    some = some[~np.isnan(some)]
    middle = float(np.median(some)) if some.size else 0.0
    within = float(np.quantile(np.abs(some - middle), WITHIN)) if some.size else 0.0
    return max(float(np.nanmax(values)) - middle, middle - float(np.nanmin(values))) < 0.5 * SPIKE_OVER * within


def _off_the_motion(values: RealArray) -> Indices:
    """Return the single samples that lie off the motion around them: none, or `FEWEST_SPIKES` and more.

    Each is compared with the cubic through two samples to either side, and with how far the samples near it lie from
    the mean of their neighbours.
    """
    none = np.zeros(0, np.intp)
    if len(values) < 3 * A_BLOCK or np.isnan(values).any():
        return none
    off = np.zeros(len(values))
    off[1:-1] = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    steps = np.abs(np.diff(values))
    level = np.maximum(_levels(off), np.min(steps, where=steps > 0, initial=np.inf))
    inner = len(level) * A_BLOCK
    largest = np.max(off[:inner].reshape(-1, A_BLOCK), axis=1)
    at = np.flatnonzero(np.repeat(largest > OFF_BY * level, A_BLOCK))
    at = np.concatenate([at, np.arange(inner, len(values))])
    level = level[np.minimum(at // A_BLOCK, len(level) - 1)]
    stands = (off[at] > OFF_BY * level) & (at > 1) & (at < len(values) - 2)
    at, level = at[stands], level[stands]
    stands = (off[at] >= off[at - 1]) & (off[at] >= off[at + 1])
    at, level = at[stands], level[stands]
    if not FEWEST_SPIKES <= at.size <= MOST_SPIKES * len(values):
        return none
    left, right = values[at - 1], values[at + 1]
    cubic = (4 * (left + right) - values[at - 2] - values[at + 2]) / 6
    spike = np.abs(values[at] - cubic)
    beside = [
        cubic - 0.5 * (left + right),
        left - 0.5 * (values[at - 2] + cubic),
        right - 0.5 * (values[at + 2] + cubic),
    ]
    single = (np.max(np.abs(beside), axis=0) < WITHOUT_IT * level) & (spike > OFF_BY * level)
    around = np.arange(1, A_BLOCK + 1)
    sides = (values[np.clip(at[:, None] + side * around, 0, len(values) - 1)] for side in (-1, 1))
    spreads = [np.ptp(np.quantile(side, BUT_OTHERS, axis=1), axis=0) for side in sides]
    less, more = np.min(spreads, axis=0), np.max(spreads, axis=0)
    plain = single & (less > SPREADS * level) & (more < AS_BEFORE * less) & (spike > less / SMALL_BESIDE)
    if np.sum(plain) < FEWEST_SPIKES:
        return none
    return np.asarray(at[single & (spike > 0.5 * np.min(spike[plain]))])


def _levels(off: RealArray) -> RealArray:
    """Return how far samples lie from their neighbours in each block, or in those beside it, (block,)."""
    blocks = len(off) // A_BLOCK
    place = round(LEVEL_SHARE * (A_BLOCK - 1))
    own = np.partition(off[: blocks * A_BLOCK].reshape(blocks, A_BLOCK), place, axis=1)[:, place]
    levels = own.copy()
    np.maximum(levels[1:], own[:-1], out=levels[1:])
    np.maximum(levels[:-1], own[1:], out=levels[:-1])
    return levels
