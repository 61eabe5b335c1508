"""Steady tones in a record, from engines and wheels."""

from __future__ import annotations

import numpy as np

from suspid.levels import UNLIKELY
from suspid.units import ComplexArray, Ratio, RealArray

# Mean square of a Hann window, and mean of its fourth power over the square of that: lines are so much wider.
HANN_SQUARE, HANN_LINES = 3 / 8, 35 / 18
# A tone under a Hann window fills two lines on either side of its largest; what is farther tells what is beside it.
TONE, LINES_BESIDE = np.arange(-2, 3), np.arange(4, 12)
# No resonance of a metal structure, let alone of a car, has a smaller damping ratio; what is narrower is a tone.
NARROWEST_RESONANCE: Ratio = 0.01
# Lines on either side from which a tone is taken off: beyond, a Hann window lets less than 1e-10 of it through.
REACH_OF_TONE = 64
# Engines and wheels have tones with some harmonics; a record of more is no vibration with tones.
MOST_TONES = 50


def steady_tones(samples: RealArray) -> tuple[RealArray, RealArray, RealArray]:
    """Return samples without their steady tones, the mean square of each tone and that of a line beside it.

    A tone is a line that stands out of its neighbours by more than chance and than the sharpest resonance explain.

    Examples
    --------
    >>> t = np.arange(0, 20, 0.005)
    >>> noise = np.random.default_rng(1).standard_normal(len(t))
    >>> left, squares, beside = steady_tones(noise + 2 * np.sin(2 * np.pi * 13.7 * t))
    >>> squares.round(1).tolist(), float(np.std(left).round(1))
    ([2.0], 1.0)
    """
    count = len(samples)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    # One-sided, so that the sum of its squares is the mean square.
    spectrum = np.fft.rfft(samples * window)[1:] * (2 / HANN_SQUARE) ** 0.5 / count
    tones: list[float] = []
    places: list[int] = []
    rest = np.array(samples)
    least = _least_excess(len(spectrum)) * _sharpest(len(spectrum))
    while len(tones) < MOST_TONES:
        power = np.abs(spectrum) ** 2
        around = _around(power)
        excess = np.divide(power, around * least, out=np.zeros(len(power)), where=around > 0)
        best = int(np.argmax(excess))
        if excess[best] < 1:
            break
        line, size = _taken_off(spectrum, best)
        # A tone's lines hold 3 / 2 of the square of the largest.
        tones.append(1.5 * abs(size) ** 2)
        places.append(best)
        turn = np.exp(2j * np.pi * line / count * np.arange(count))
        rest -= 3**0.5 * (size * turn).real
    return rest, np.array(tones), _around(np.abs(spectrum) ** 2)[places]


def _least_excess(count: int) -> float:
    """Return how many times its neighbours the largest of some lines of noise is, which is improbable: F(2, 2 n)."""
    n = 2 * len(LINES_BESIDE) / HANN_LINES
    return float(n * ((UNLIKELY / count) ** (-1 / n) - 1))


def _sharpest(count: int) -> RealArray:
    """Return how many times its neighbours each line is in the middle of the narrowest resonance, (line,)."""
    width = NARROWEST_RESONANCE * np.arange(1, count + 1)
    return np.asarray(1 / np.mean(1 / (1 + (LINES_BESIDE / width[:, None]) ** 2), axis=1))


def _around(power: RealArray) -> RealArray:
    """Return the mean of the lines on both sides of each; 0 where these do not all exist."""
    far = int(LINES_BESIDE[-1])
    around = np.zeros(len(power))
    if len(power) > 2 * far:
        kernel = np.zeros(2 * far + 1)
        kernel[far + LINES_BESIDE] = kernel[far - LINES_BESIDE] = 1 / (2 * len(LINES_BESIDE))
        around[far:-far] = np.convolve(power, kernel, "valid")
    return around


def _taken_off(spectrum: ComplexArray, best: int) -> tuple[float, complex]:
    """Take the tone at a line off the spectrum, at the frequency that leaves least; return its line and size."""
    from scipy.optimize import minimize_scalar

    near = best + TONE
    tone = TONE.astype(float)

    def left(about: float) -> float:
        shape = _tone(tone - about)
        return -float(np.abs(np.vdot(shape, spectrum[near])) ** 2 / np.vdot(shape, shape).real)

    about = float(minimize_scalar(left, bounds=(-1, 1), method="bounded", options={"xatol": 1e-9}).x)
    shape = _tone(tone - about)
    size = complex(np.vdot(shape, spectrum[near]) / np.vdot(shape, shape))
    far = np.arange(max(best - REACH_OF_TONE, 0), min(best + REACH_OF_TONE + 1, len(spectrum)))
    spectrum[far] -= size * _tone((far - best).astype(float) - about)
    return best + 1 + about, size


def _tone(lines: RealArray) -> ComplexArray:
    """Return the spectrum of a tone under a Hann window at lines from its own, 1 there."""
    return np.asarray(np.exp(-1j * np.pi * lines) * (np.sinc(lines) + np.sinc(lines - 1) / 2 + np.sinc(lines + 1) / 2))
