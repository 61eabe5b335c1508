"""A decay between two rests: a mass that was held and let go, and that friction stops."""

from __future__ import annotations

import numpy as np

from suspid.decays.decay import Decay
from suspid.errors import SuspidError
from suspid.identification import Identification, identify
from suspid.levels import ROUNDING
from suspid.samples import as_samples, held
from suspid.signals import Signal, as_signal
from suspid.units import Decibel, Ratio, RealArray
from suspid.words import DecayDoubt, Remark

# A rest is of at least this many samples; it is left where two in a row are this many standard deviations from its
# mean. The motion that follows is this many times as large as they. A motion that begins with the first sample is never
# as far from its own mean.
FEWEST_OF_REST, FAR_FROM_REST, MUCH_FURTHER = 12, 5.0, 30.0
# Starts that are tried after the first sample that has left a rest, in samples: the first ones may be of it still.
STARTS_AFTER_REST = (0, 2, 4)
# Samples without which a rest is looked for, one after the other.
LEFT_OUT = (0, 20, 40)
# The rest is compared without this share of its end; its variance is at most this many times that of white noise with
# the same steps between samples: smooth motion has more.
LOOKED_BACK, NOISE_ALONE, NEAR_REST = 0.6, 2.0, 2.0


def decay_between(part: Signal, first: int, last: int, *, level: Decibel) -> Decay | None:
    """Return the decay between two samples (the last excluded) if `identify` explains it by nonlinear forces.

    Few cycles that friction stops follow no damped exponentials, so that quick fits refuse them.
    """
    try:
        found = identify(as_samples(part.timepts_of(first, last), part.values[:, first:last], part.channels))
    except SuspidError:
        return None
    if not found.forces:
        return None
    return as_decay(found, part, (first, last), level=level)


def rests_until(values: RealArray, *, most: Ratio = 0.5) -> int:
    """Return the first sample (channel, sample) that has left a rest at the start, within noise; 0 without such a rest.

    A rest takes at most a share of the samples. There a channel is far from the mean of all samples before, and so is
    the next one; then it moves much further.

    Examples
    --------
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(400)
    >>> held = np.where(np.arange(400) < 150, 1.0, np.cos(0.1 * (np.arange(400) - 150)))
    >>> rests_until((held + noise)[None]), rests_until((held + noise)[None, 150:])
    (151, 0)
    """
    first = values[:, : int(most * values.shape[1])]
    if first.shape[1] <= FEWEST_OF_REST:
        return 0
    about = first - first[:, :1]
    # What is compared with the samples before leaves the last of these out: they may have begun to move.
    before = np.maximum(np.arange(1, about.shape[1]) * LOOKED_BACK, 2.0).astype(np.intp)
    means, squares, roughness = (
        np.cumsum(each, axis=1)[:, before - 1] / before
        for each in (about, about**2, 0.5 * np.diff(about, axis=1, prepend=0.0) ** 2)
    )
    # Samples that are equal but for rounding rest as those do that are equal.
    rounding = ROUNDING * np.max(np.abs(values), axis=1, keepdims=True)
    spread = np.sqrt(np.maximum(squares - means**2, rounding**2))
    noise = spread**2 < NOISE_ALONE * np.maximum(roughness, rounding**2)
    away = noise & (np.abs(about[:, 1:] - means) > FAR_FROM_REST * spread)
    both = away[:, :-1] & away[:, 1:]
    # Of fewer samples none tell a spread.
    both[:, : FEWEST_OF_REST // 2] = False
    channel, sample = np.nonzero(both)
    if not sample.size or np.min(sample) < FEWEST_OF_REST - 1:
        return 0
    at = int(np.argmin(sample))
    start, row = int(sample[at]) + 1, channel[at]
    size = spread[row, start - 1]
    if np.ptp(values[row]) <= MUCH_FURTHER * size:
        return 0
    # It begins to move with the square of time: from where it was last as near to its rest as noise mostly is.
    near = np.flatnonzero(np.abs(about[row, :start] - means[row, start - 1]) < NEAR_REST * size)
    left = int(near[-1]) + 1 if near.size else start
    return max(1, left - int((start - left) / (np.sqrt(FAR_FROM_REST / NEAR_REST) - 1)))


def rest_of(values: RealArray, *, most: Ratio = 0.5) -> int:
    """Return the first sample that has left a rest at the start, also where some of the first are far off by chance.

    Of few samples of a rest, two that follow may be far from the others: then it is looked for without them.

    Examples
    --------
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(400)
    >>> noise[8:10] += 0.1
    >>> held = np.where(np.arange(400) < 150, 1.0, np.cos(0.1 * (np.arange(400) - 150)))
    >>> rests_until((held + noise)[None]), rest_of((held + noise)[None])
    (0, 151)
    """
    for left_out in LEFT_OUT:
        rest = rests_until(values[:, left_out:], most=most)
        if rest:
            return left_out + rest
    return 0


def stops_at(values: RealArray, *, most: Ratio) -> int:
    """Return the sample from which on all channels rest within their noise; the number of samples where they do not.

    Examples
    --------
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(400)
    >>> stopped = np.cos(0.1 * np.minimum(np.arange(400), 250))
    >>> abs(stops_at((stopped + noise)[None], most=0.97) - 250) < 20, stops_at(np.cos(np.arange(400))[None], most=0.97)
    (True, 400)
    """
    return int(values.shape[1]) - rest_of(values[:, ::-1], most=most)


def as_decay(
    found: Identification, part: Signal, samples: tuple[int, int], *, level: Decibel, doubts: tuple[Remark, ...] = ()
) -> Decay:
    """Return the decay between two samples (the last excluded) as it was identified; forces in it are a doubt."""
    first, last = samples
    motion, left = as_signal(held(found, "fitted")).values, as_signal(held(found, "residual")).values
    energy = np.sum((motion - motion.mean(axis=1, keepdims=True)) ** 2, axis=1)
    cycles = float(np.max(found.modes.wn)) * part.step * (last - first) / (2 * np.pi)
    strength = float(np.sum(energy / np.maximum(found.noise_std**2, 1e-300))) * cycles**2
    share = float(np.sqrt(np.max(np.sum(left**2, axis=1) / np.maximum(energy, 1e-300))))
    return Decay(
        start=part.start + part.step * first,
        stop=part.start + part.step * (last - 1),
        rank=0,
        kind=None,
        level=level,
        cycles=cycles,
        strength=float(10 * np.log10(strength)),
        wn=found.modes.wn,
        zeta=found.modes.zeta,
        doubts=(*((Remark(DecayDoubt.NONLINEAR, {"share": share}),) if found.forces else ()), *doubts),
    )
