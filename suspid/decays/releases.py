"""Releases in a record that is driven between them: a car that is pushed and let go, again and again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from suspid.decays.envelopes import spectrum_and_noise
from suspid.decays.tails import free_since
from suspid.signals import Signal
from suspid.units import Decibel, RealArray
from suspid.values import frozen_real

# The motion falls by this much between two pushes, or after the last one. Pushing itself goes on at about one level; a
# smaller fall takes beating modes for releases.
FALL: Decibel = 10.0
# A decay is over within this much of the lowest level of a valley; half its length is kept after that.
FLOOR: Decibel = 3.0
KEPT = 0.5
# Starts that are tried, in each period of the motion, and at most. Fewer lose the first part of a decay.
STARTS_A_PERIOD, MOST_STARTS = 12, 48
# Starts in a row before the free ones that are not free, after which none is tried: half a period.
PATIENCE = STARTS_A_PERIOD // 2
# Releases that are looked at, the deepest falls first, at most and at least. Each costs half a second.
MOST_RELEASES = 8
FEWEST_RELEASES = 2
# Of the rates of channels, only what has this many times the power of their noise counts.
RATES_ABOVE = 20.0
# Without a release among as many, no more are looked at: the motion is driven throughout.
NONE_FREE = 4


@dataclass(frozen=True, kw_only=True, slots=True)
class Valley:
    """Samples over which the motion falls from a peak."""

    first: int  # after the release before
    peak: int
    stop: int  # before the next push
    over: int  # the level is next to the lowest from here on
    fall: Decibel


def releases(signal: Signal, finest: RealArray) -> tuple[list[tuple[int, int]], int]:
    """Return the samples between which a record decays freely after its peaks, and the number of peaks looked at.

    The last sample is excluded.

    Parameters
    ----------
    signal : Signal
        The recording.
    finest : ndarray (channel,)
        Standard deviation of the rounding and quantisation error of each channel.

    Examples
    --------
    A mass is pushed three times and let go, twice:

    >>> from scipy.signal import lfilter
    >>> pushes = np.zeros(3000)
    >>> for first in (200, 1500):
    ...     for push in range(3):
    ...         pushes[first + 100 * push : first + 100 * push + 50] = np.sin(np.pi * np.arange(50) / 50)
    >>> motion = lfilter([1e-3], [1.0, -1.96, 0.9639], pushes) + 1e-3 * np.random.default_rng(1).standard_normal(3000)
    >>> found, looked = releases(Signal(start=0.0, step=0.01, values=motion[None], channels=("body",)), np.zeros(1))
    >>> [first // 25 for first, last in found], looked
    ([17, 69], 2)
    """
    found = list[tuple[int, int]]()
    scaled = _over_noise(signal.values, finest)
    for period in _periods(scaled):
        deepest = sorted(_valleys(scaled, period), key=lambda valley: -valley.fall)[:MOST_RELEASES]
        if len(deepest) >= FEWEST_RELEASES:
            break
    else:
        # Of a single one, the free end is looked for.
        return [], 0
    looked = 0
    for looked, valley in enumerate(deepest, 1):
        if not found and looked > NONE_FREE:
            break
        early = max(valley.first, valley.peak - period)
        apart = max(1, period // STARTS_A_PERIOD, (valley.over - early) // MOST_STARTS)
        places = list(range(valley.over, early - 1, -apart))
        last = min(valley.stop, valley.over + max(period, int(KEPT * (valley.over - valley.peak))))
        part = replace(signal, values=frozen_real(signal.values[:, :last]))
        begin = free_since(part, finest, places, last, reach=period // 2, patience=PATIENCE)
        if begin is not None:
            found.append((begin, last))
    return sorted(found), looked


def _over_noise(values: RealArray, finest: RealArray) -> RealArray:
    """Return the channels less their means, over their noise: a quiet channel counts as much as the others."""
    about = values - values.mean(axis=1, keepdims=True)
    white = spectrum_and_noise(about, finest)[1] / float(np.sum(np.hanning(values.shape[1]) ** 2))
    return np.asarray(about / np.sqrt(np.maximum(white, 1e-300))[:, None])


def _periods(scaled: RealArray) -> list[int]:
    """Return the samples of a period of the strongest line of all channels.

    Then of that of their rates, if the first may be as few pushes as are looked at: what is pushed slowly, and held,
    moves furthest at the frequency at which that is repeated.
    """
    channels, count = scaled.shape
    window = np.hanning(count)
    power = np.sum(np.abs(np.fft.rfft(scaled * window, axis=1)) ** 2, axis=0)
    # What makes fewer cycles is drift.
    power[:3] = 0.0
    rates = np.maximum(power - RATES_ABOVE * channels * np.sum(window**2), 0.0) * np.arange(len(power)) ** 2
    lines = [max(int(np.argmax(each)), 1) for each in (power, rates)]
    return [int(max(4, round(count / line))) for line in lines[: 2 if lines[0] <= MOST_RELEASES else 1]]


def _valleys(scaled: RealArray, period: int) -> Iterator[Valley]:
    """Yield the falls of the level, means over a period and all channels, between its peaks and after the last."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import find_peaks

    about = scaled - uniform_filter1d(scaled, period, axis=1, mode="nearest")
    # Running sums may round below zero.
    power = np.maximum(uniform_filter1d(np.sum(about**2, axis=0), period, mode="nearest"), 1e-12)
    level = 10 * np.log10(power)
    peaks = find_peaks(np.r_[-np.inf, level, -np.inf], prominence=FALL)[0] - 1
    first = 0
    for peak, following in zip(peaks.tolist(), [*peaks[1:].tolist(), len(level)], strict=True):
        lowest = peak + int(np.argmin(level[peak:following]))
        low = peak + np.flatnonzero(level[peak:following] < level[lowest] + FLOOR)
        # A mean over a period rises half a period before the next push.
        stop = following if following == len(level) else max(int(low[-1]) - period // 2, lowest - period)
        fall = float(level[peak] - level[lowest])
        if fall > FALL and stop > peak:
            yield Valley(first=first, peak=peak, stop=stop, over=min(int(low[0]), stop), fall=fall)
        first = stop
