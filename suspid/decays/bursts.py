"""Where a record stands out of its own background: band envelopes of all channels at once."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from suspid.identification import UNIFORM_STD, resolution
from suspid.signals import Signal
from suspid.units import ComplexArray, Decibel, Hertz, RealArray, Second
from suspid.values import frozen_real

# A band is a Gaussian in the logarithm of frequency: of this width, out to this distance from its centre [octaves].
# Smooth on both scales, it smears neither far into other bands nor far in time.
OCTAVES, REACH = 0.4, 2.0
# The lowest centre makes this many cycles in the record.
LEAST_CYCLES = 8.0
# The record is mirrored at its ends; within so many periods of them a band shows the fold, not the motion.
FOLD = 1.5
UNSEEN: Decibel = -100.0
# A background known from few cycles may be too low by much: levels count for less below about so many.
FEW_CYCLES = 24.0
# The background of a band is taken from this quantile of its power, where noise has this share of its mean.
QUANTILE = 0.25
QUIET = -np.log1p(-QUANTILE)
# A background this far below the greatest power of its band counts as that: nothing measured is quieter.
DYNAMIC = 1e-7
# Power of Gaussian noise passes the threshold in the whole record with this probability; bursts stand this factor
# above it, because what rolls is not quite Gaussian.
CHANCE = 1e-3
MARGIN = 4.0
# A new burst begins where the level rises by so much before the last one is gone.
RISE: Decibel = 8.0
# A burst is over where it is so far below the threshold; half as much again is kept of what follows.
OVER: Decibel = 8.0
AFTERWARDS = 0.5
# A band rings where it passes the threshold so many of its periods after the onset, early and late.
RINGS = (1.5, 4.0)
MOST_POINTS = 2**17
# A sensor that changes so often between values that it holds is quantised.
FEWEST_CHANGES = 8


@dataclass(frozen=True, kw_only=True, slots=True)
class Burst:
    """A stretch that stands out.

    Parameters
    ----------
    onset, peak, stop : float
        When it begins, is strongest, and is over or the next one begins [s].
    level : float
        Its power above that of the background, in the band and channel where it stands out most [dB].
    top : float
        Centre of the highest band that rings on after the onset [Hz].
    width : float
        How far the onset may be off: one period of the highest band that stands out [s].
    cut : bool
        Whether the next burst begins before this one is over.
    again : tuple of float
        When a band of it rises again, while others have not yet sunk [s].
    """

    onset: Second
    peak: Second
    stop: Second
    level: Decibel
    top: Hertz
    width: Second
    cut: bool
    again: tuple[Second, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Envelopes:
    """Power in octave bands over that of the background, of the channel that stands out most.

    Parameters
    ----------
    timepts : ndarray (point,)
        Times [s].
    centres : ndarray (band,)
        Centres of the bands [Hz], descending.
    levels : ndarray (band, point)
        Power over background [dB].
    threshold : float
        Level that noise does not reach [dB].
    """

    timepts: RealArray
    centres: RealArray
    levels: RealArray
    threshold: Decibel

    @property
    def level(self) -> RealArray:
        """Greatest level over the bands [dB], (point,)."""
        return np.asarray(np.max(self.levels, axis=0))


def envelopes(signal: Signal) -> Envelopes:
    """Return how far each octave band stands above its background.

    The record is mirrored at its end, so that its Fourier transform sees no jump; a band is the inverse transform of
    its own bins only, so that low bands cost little.

    Parameters
    ----------
    signal : Signal
        The record.

    Examples
    --------
    >>> import numpy as np
    >>> values = np.random.default_rng(1).standard_normal((1, 5000))
    >>> values[0, 3000:3020] += 30.0
    >>> signal = Signal(start=0.0, step=0.01, values=values, channels=("seat",))
    >>> found = envelopes(signal)
    >>> float(found.timepts[np.argmax(found.level)].round())
    30.0
    """
    from scipy.fft import rfft

    count = signal.values.shape[1]
    points = min(count, MOST_POINTS)
    centres = _centres(signal)
    # Where the points lie, in samples.
    at = (np.arange(points) + 0.5) * (count / points) - 0.5
    levels = np.full((len(centres), points), -np.inf)
    trend = np.linspace(-1.0, 1.0, count)
    for samples, least in zip(signal.values, finest(signal.values), strict=True):
        about = samples - samples.mean()
        about = about - trend * (float(about @ trend) / float(trend @ trend))
        spectrum = rfft(np.concatenate([about, about[::-1]]))
        for band, centre in enumerate(centres):
            power, white = _band_power(spectrum, 2 * count * centre * signal.step, 2 * count)
            quiet = np.quantile(power[: len(power) // 2 + 1], QUANTILE) / QUIET
            floor = max(quiet, DYNAMIC * float(np.max(power)), white * least**2, 1e-300)
            here = np.interp((at + 0.5) * (len(power) / (2 * count)), np.arange(len(power)), power)
            np.maximum(levels[band], 10 * np.log10(np.maximum(here / floor, 1e-9)), out=levels[band])
    for band, centre in enumerate(centres):
        edge = int(np.ceil(FOLD / (centre * signal.step) * points / count))
        levels[band, :edge] = levels[band, edge]
        levels[band, points - edge :] = levels[band, points - edge - 1]
        levels[band] -= 10 * np.log10(1 + FEW_CYCLES / (centre * signal.duration))
    chances = count * len(signal.values) / CHANCE
    return Envelopes(
        timepts=frozen_real(signal.start + signal.step * at),
        centres=frozen_real(centres),
        levels=frozen_real(levels),
        threshold=float(10 * np.log10(MARGIN * np.log(chances))),
    )


def finest(values: RealArray) -> RealArray:
    """Return the standard deviation that rounding and quantisation leave in each channel.

    A quantised sensor that was resampled between its stamps no longer shows its steps, except where it stands still:
    the least distance of the values that it holds and comes back to is its step.
    """
    out = resolution(values)
    for channel, samples in enumerate(values):
        held = samples[1:][np.diff(samples) == 0]
        if np.sum(np.diff(held) != 0) < FEWEST_CHANGES:
            continue
        gaps = np.diff(np.unique(held))
        gaps = gaps[gaps > 1e-6 * np.max(np.abs(samples - np.median(samples)))]
        out[channel] = max(out[channel], float(np.min(gaps)) * UNIFORM_STD) if gaps.size else out[channel]
    return out


def _centres(signal: Signal) -> RealArray:
    top, bottom = 0.25 / signal.step, LEAST_CYCLES / signal.duration
    return np.asarray(top / 2.0 ** np.arange(max(1, int(np.floor(np.log2(top / bottom))) + 1)))


def _band_power(spectrum: ComplexArray, centre: float, count: int) -> tuple[RealArray, float]:
    """Return the squared envelope of a band at the rate that it needs, and its mean for white noise of variance 1."""
    from scipy.fft import ifft, next_fast_len

    low = int(np.ceil(centre * 2.0**-REACH))
    high = min(int(np.floor(centre * 2.0**REACH)), len(spectrum) - 1)
    bins = np.arange(low, high + 1)
    window = np.exp(-0.5 * (np.log2(bins / centre) / OCTAVES) ** 2)
    length = next_fast_len(2 * len(bins))
    padded = np.zeros(length, complex)
    padded[: len(bins)] = spectrum[low : high + 1] * window
    envelope = ifft(padded)
    return np.asarray(envelope.real**2 + envelope.imag**2), count * float(window @ window) / length**2


def find_bursts(found: Envelopes) -> tuple[Burst, ...]:
    """Return the stretches that stand out, in order of time."""
    from scipy.signal import find_peaks

    level, time = found.level, found.timepts
    padded = np.concatenate([[UNSEEN], level, [UNSEEN]])
    peaks = find_peaks(padded, height=found.threshold, prominence=RISE)[0] - 1
    over = np.flatnonzero(level < found.threshold - OVER)
    starts = [_onset(found, int(a), int(b)) for a, b in zip(np.r_[0, peaks][:-1], peaks, strict=True)]
    out = []
    for index, ((onset, band), peak) in enumerate(zip(starts, peaks, strict=True)):
        after = over[np.searchsorted(over, peak) :]
        end = int(after[0]) if after.size else len(level) - 1
        last = min(int(end + AFTERWARDS * (end - onset)), len(level) - 1)
        following = starts[index + 1][0] if index + 1 < len(starts) else len(level)
        out.append(
            Burst(
                onset=float(time[onset]),
                peak=float(time[peak]),
                stop=float(time[max(min(last, following - 1), onset)]),
                level=float(level[peak]),
                top=_ringing(found, onset, band),
                width=float(1 / found.centres[band]),
                cut=bool(following <= end),
                again=_again(found, onset, max(min(last, following - 1), onset)),
            )
        )
    return tuple(out)


def _again(found: Envelopes, begin: int, stop: int) -> tuple[Second, ...]:
    """Return when a band rises again within a burst [s]; the highest band that does knows best."""
    from scipy.signal import find_peaks

    step = float(found.timepts[1] - found.timepts[0])
    out = list[int]()
    for centre, levels in zip(found.centres, found.levels[:, begin : stop + 1], strict=True):
        apart = 2 / (centre * step)
        if len(levels) < 2 * apart:
            break
        tops = find_peaks(np.r_[UNSEEN, levels, UNSEEN], height=found.threshold, prominence=RISE)[0] - 1
        for before, top in pairwise(tops):
            least = before + int(np.argmin(levels[before : top + 1]))
            low = np.flatnonzero(levels[least:top] < 0.5 * (levels[least] + levels[top]))
            onset = least + (int(low[-1]) if low.size else 0)
            if onset > apart and all(abs(onset - other) > apart for other in out):
                out.append(int(onset))
    return tuple(float(found.timepts[begin + onset]) for onset in sorted(out))


def _onset(found: Envelopes, since: int, peak: int) -> tuple[int, int]:
    """Return the point at which a burst begins, and the highest band in which it stands out: that one knows best."""
    step = float(found.timepts[1] - found.timepts[0])
    since += int(np.argmin(found.level[since : peak + 1]))
    for band, centre in enumerate(found.centres):
        period = int(np.ceil(1 / (centre * step)))
        levels = found.levels[band, since : peak + period + 1]
        top = int(np.argmax(levels))
        if levels[top] < found.threshold:
            continue
        least = int(np.argmin(levels[: top + 1]))
        low = max(found.threshold - OVER, 0.5 * (levels[least] + levels[top]))
        below = np.flatnonzero(levels[least:top] < low)
        begin = since + least + (int(below[-1]) + 1 if below.size else 0)
        return begin if begin > FOLD * period else 0, band
    return peak, len(found.centres) - 1


def _ringing(found: Envelopes, onset: int, highest: int) -> Hertz:
    """Return the centre of the highest band that rings on after the onset [Hz]."""
    step = float(found.timepts[1] - found.timepts[0])
    for centre, levels in zip(found.centres[highest:], found.levels[highest:], strict=True):
        early, late = (int(periods / (centre * step)) for periods in RINGS)
        after = levels[onset + early : onset + late + 1]
        if after.size and np.median(after) > found.threshold - 3.0:
            return float(centre)
    return float(found.centres[-1])
