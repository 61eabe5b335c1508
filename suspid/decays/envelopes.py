"""Power of each octave band above its background."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification import UNIFORM_STD, resolution
from suspid.levels import UNLIKELY
from suspid.signals import Signal
from suspid.units import Decibel, RealArray, Second
from suspid.values import frozen_real

# Width of a band [octaves], a Gaussian over the logarithm of frequency. Wider bands mix modes; narrower bands blur the
# onset in time.
OCTAVES = 0.4
# The lowest band makes this many cycles in the record. With fewer cycles its background cannot be estimated.
LOWEST_BAND = 8.0
# Within this many periods of either end a band shows the mirrored signal. Fewer periods give false events at the ends.
FOLD = 1.5
# The background estimate of a band scatters by as much again when it rests on this many cycles; its levels are lowered
# accordingly. A smaller number gives false events at low frequencies.
UNCERTAIN_CYCLES = 24.0
# The quiet part of a recording is this quantile of its power: of a band, converted to the mean of exponentially
# distributed power (noise). A higher one fails where decays fill most of the record; a lower one scatters more.
QUIET_QUANTILE = 0.25
# An event begins at this factor in power above the threshold that Gaussian noise alone is `UNLIKELY` to pass anywhere
# in the record. It allows for noise that is not Gaussian, such as rolling on a road.
MARGIN = 4.0
# Length of the transform of a band, in points of the envelope: of a longer one, samples apart are enough. Half as long,
# it has no sample at the points.
POINTS_FOLDED = 4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Envelopes:
    """Power of octave bands over the background, maximum over the channels."""

    timepts: RealArray  # (point,): times [s]
    centres: RealArray  # (band,): centre frequencies of the bands [Hz], descending
    levels: RealArray  # (band, point): power over background [dB]
    threshold: Decibel  # level that noise does not reach [dB]

    @property
    def level(self) -> RealArray:
        """Maximum over the bands [dB], (point,)."""
        return np.asarray(np.max(self.levels, axis=0))

    @property
    def step(self) -> Second:
        """Distance of the points [s]."""
        return float(self.timepts[1] - self.timepts[0])


def envelopes(signal: Signal, quantum: RealArray | None = None) -> Envelopes:
    """Return the power of each octave band above its background.

    The record is mirrored at its end so that its Fourier transform sees no jump. Each band is the transform of its own
    bins alone, so low bands cost little. The channels are taken one by one, because of a long record each copy counts.
    The ``quantum`` of each channel is that of `finest`, if it is known already.

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
    count = signal.values.shape[1]
    # Longest envelope [points]. It bounds time and memory for long recordings, and limits the resolution in time there.
    points = min(count, 2**17)
    centres = _centres(signal)
    # Positions of the points, in samples.
    at = (np.arange(points) + 0.5) * (count / points) - 0.5
    levels = np.full((len(centres), points), -np.inf)
    for samples, least in zip(signal.values, finest(signal.values) if quantum is None else quantum, strict=True):
        spectrum = _mirrored(samples)
        for band, centre in enumerate(centres):
            low, window, length = _window(2 * count * centre * signal.step, count)
            # Of many samples between two points, every ``apart``-th tells as much.
            folded = POINTS_FOLDED * points
            apart = -(-length // folded)
            length = folded * apart if apart > 1 else length
            white = 2 * count * float(window @ window) / length**2
            place = (at + 0.5) * (length / (2 * count) / apart)
            before = np.minimum(place.astype(int), length // (2 * apart) - 1)
            power = _power(spectrum[low : low + len(window)], window, length, apart)
            floor = max(background(power), white * least**2, 1e-300)
            here = power[before] + (place - before) * (power[before + 1] - power[before])
            np.maximum(levels[band], 10 * np.log10(np.maximum(here / floor, 1e-9)), out=levels[band])
    for band, centre in enumerate(centres):
        edge = int(np.ceil(FOLD / (centre * signal.step) * points / count))
        levels[band, :edge] = levels[band, edge]
        levels[band, points - edge :] = levels[band, points - edge - 1]
        levels[band] -= 10 * np.log10(1 + UNCERTAIN_CYCLES / (centre * signal.duration))
    chances = count * len(signal.values) / UNLIKELY
    return Envelopes(
        timepts=frozen_real(signal.start + signal.step * at),
        centres=frozen_real(centres),
        levels=frozen_real(levels),
        threshold=float(10 * np.log10(MARGIN * np.log(chances))),
    )


def background(power: RealArray) -> float:
    """Return the mean power of the noise in a band, from a low quantile of its power.

    The power of Gaussian noise in a band is exponentially distributed with mean m: its quantile q is
    ``-m log(1 - q)``.

    Examples
    --------
    >>> round(background(np.random.default_rng(1).exponential(2.0, 100_000)), 1)
    2.0
    """
    quiet = np.quantile(power, QUIET_QUANTILE) / -np.log1p(-QUIET_QUANTILE)
    # The background is at least this share of the greatest power of its band (-70 dB), because no sensor is quieter.
    return max(float(quiet), 1e-7 * float(np.max(power)))


def spectrum_and_noise(about: RealArray, finest: RealArray) -> tuple[RealArray, RealArray]:
    """Return the power of each channel under a Hann window, (channel, line), and that of white noise in it, (channel,).

    White noise is that of the upper half of the spectrum, where a sensor that is fast enough shows little else, and at
    least that of rounding; the median of exponentially distributed power is ``log(2)`` of its mean.

    Examples
    --------
    >>> power, noise = spectrum_and_noise(np.random.default_rng(1).standard_normal((1, 20_000)), np.zeros(1))
    >>> bool(np.isclose(noise[0], np.mean(power), rtol=0.05))
    True
    """
    window = np.hanning(about.shape[1])
    power = np.abs(np.fft.rfft(about * window, axis=1)) ** 2
    white = np.median(power[:, power.shape[1] // 2 :], axis=1) / np.log(2.0)
    return power, np.maximum(white, finest**2 * float(window @ window))


def finest(values: RealArray) -> RealArray:
    """Return the standard deviation of the rounding and quantisation error of each channel.

    A quantised signal that was resampled shows its steps only where it is constant: the smallest distance between the
    values that it holds is taken as its step. The largest and the smallest value may be limits at which it is clipped.

    Examples
    --------
    >>> cut_off = np.clip(np.sin(np.arange(200.0)), -0.5, 0.5)[None]
    >>> bool(finest(cut_off)[0] < 1e-6)
    True
    """
    out = resolution(values)
    for channel, samples in enumerate(values):
        held = samples[1:][np.diff(samples) == 0]
        held = held[(held > np.min(samples)) & (held < np.max(samples))]
        # A sensor that changes this often between values that it holds is taken to be quantised. Fewer changes are
        # chance.
        if np.sum(np.diff(held) != 0) < 8:
            continue
        gaps = np.diff(np.unique(held))
        gaps = gaps[gaps > 1e-6 * np.max(np.abs(samples - np.median(samples)))]
        out[channel] = max(out[channel], float(np.min(gaps)) * UNIFORM_STD) if gaps.size else out[channel]
    return out


def _centres(signal: Signal) -> RealArray:
    top, bottom = 0.25 / signal.step, LOWEST_BAND / signal.duration
    return np.asarray(top / 2.0 ** np.arange(max(1, int(np.floor(np.log2(top / bottom))) + 1)))


def _mirrored(samples: RealArray) -> RealArray:
    """Return the Fourier transform of a mirrored channel without its line, (bin,), up to its phases.

    It is a cosine transform of type II, half as long.
    """
    from scipy.fft import dct

    trend, about = np.linspace(-1.0, 1.0, len(samples)), samples - samples.mean()
    slope = float(about @ trend) / float(trend @ trend)
    trend *= slope
    about -= trend
    return np.asarray(dct(about, overwrite_x=True))


def _window(centre: float, count: int) -> tuple[int, RealArray, int]:
    """Return the first bin of a band, the Gaussian over its bins, and the length of the transform that it needs.

    The Gaussian is cut two octaves from its centre, at 4e-6 of its peak.
    """
    from scipy.fft import next_fast_len

    low, high = int(np.ceil(centre / 4)), min(int(np.floor(centre * 4)), count - 1)
    window = np.arange(low, high + 1, dtype=float)
    window /= centre
    np.log2(window, out=window)
    window /= OCTAVES
    np.square(window, out=window)
    window *= -0.5
    np.exp(window, out=window)
    return low, window, 2 * int(next_fast_len(len(window), real=True))


def _power(bins: RealArray, window: RealArray, length: int, apart: int) -> RealArray:
    """Return the squared envelope of a band at the rate that it needs, or samples of it that many ``apart``.

    The envelope of a mirrored record is even in time, so a real transform gives all of it. That of bins folded over
    a part of the length gives samples that lie apart.
    """
    from scipy.fft import rfft

    size = length // apart
    band = np.zeros(size)
    for first in range(0, len(window), size):
        part = slice(first, min(first + size, len(window)))
        band[: part.stop - first] += bins[part] * window[part]
    # In place: of a long record each copy counts.
    envelope = rfft(band, overwrite_x=True)
    del band
    real, imag = envelope.real, envelope.imag
    real *= real
    imag *= imag
    real += imag
    return np.asarray(real / length**2)
