"""Wavelet transforms of other libraries, and one skeleton fit for all of them."""

from __future__ import annotations

import importlib
from collections.abc import Callable

import numpy as np

from suspid.units import ComplexArray, Hertz, RadianPerSecond, RealArray

RATE: Hertz = 500.0
# The wavelet exp(2 pi j t) exp(-t^2 / N), the same for every library.
BANDWIDTH = 10.0
ROWS = 33
# A frequency without a mode near it; the noise of the other rows is estimated here.
NOISE_ROW: RadianPerSecond = 600.0

# Pairs of natural frequency [rad/s] and damping ratio [1].
Estimates = list[tuple[float, float]]


def pywt_skeleton(samples: RealArray, near: RealArray) -> Estimates:
    """Skeletons of PyWavelets' transform."""
    pywt = importlib.import_module("pywt")

    def rows(low: float, high: float) -> tuple[RealArray, ComplexArray]:
        omega = np.geomspace(low, high, ROWS)
        scales = 2 * np.pi * RATE / omega
        coefficients, _ = pywt.cwt(samples, scales, f"cmor{BANDWIDTH}-1.0", method="fft")
        return omega, np.asarray(coefficients / np.sqrt(scales)[:, None])

    return _skeletons(rows, near)


def ssqueezepy_skeleton(samples: RealArray, near: RealArray) -> Estimates:
    """Skeletons of ssqueezepy's transform."""
    package = importlib.import_module("ssqueezepy")
    mu = 2 * np.pi * np.sqrt(BANDWIDTH / 2)

    def rows(low: float, high: float) -> tuple[RealArray, ComplexArray]:
        omega = np.geomspace(high, low, ROWS)
        wavelet = package.Wavelet(("morlet", {"mu": mu, "dtype": "float64"}))
        coefficients, _ = package.cwt(samples, wavelet, scales=mu * RATE / omega)
        return omega, np.asarray(coefficients)

    return _skeletons(rows, near)


def fcwt_skeleton(samples: RealArray, near: RealArray) -> Estimates:
    """Skeletons of fCWT's transform."""
    package = importlib.import_module("fcwt")
    wavelet = package.Morlet(float(np.sqrt(BANDWIDTH / 2)))
    transform = package.FCWT(wavelet, 1, False, True)
    single = samples.astype(np.float32)

    def rows(low: float, high: float) -> tuple[RealArray, ComplexArray]:
        scales = package.Scales(wavelet, package.FCWT_LINFREQS, int(RATE), low / (2 * np.pi), high / (2 * np.pi), ROWS)
        coefficients, hertz = np.zeros((ROWS, len(single)), np.complex64), np.zeros(ROWS, np.float32)
        transform.cwt(single, scales, coefficients)
        scales.getFrequencies(hertz)
        return 2 * np.pi * hertz.astype(float), coefficients.astype(complex)

    return _skeletons(rows, near)


def _skeletons(rows: Callable[[float, float], tuple[RealArray, ComplexArray]], near: RealArray) -> Estimates:
    """Return modes from lines through phase and log modulus of the strongest row near each frequency.

    ``rows`` gives angular frequencies between two limits and the transform there, of modulus proportional to the
    amplitude of a cosine. White noise in it grows with the root of the frequency. A line runs from two envelopes after
    the start until the modulus is thrice the noise, or two envelopes before the end, and is weighted by the square of
    the modulus.
    """
    omega, quiet = rows(0.98 * NOISE_ROW, 1.02 * NOISE_ROW)
    noise = np.sqrt(np.mean(np.abs(quiet) ** 2 / omega[:, None]))
    time = np.arange(quiet.shape[1]) / RATE
    found = []
    for guess in near:
        omega, transformed = rows(0.92 * guess, 1.08 * guess)
        edges = 2 * (2 * np.pi / omega) * np.sqrt(BANDWIDTH)
        strongest = int(np.argmax(np.sum(np.abs(transformed[:, time > edges.max()]) ** 2, axis=1)))
        skeleton, edge = transformed[strongest], edges[strongest]
        inside = (time >= edge) & (time <= time[-1] - edge)
        below = np.flatnonzero(inside & (np.abs(skeleton) < 3 * noise * np.sqrt(omega[strongest])))
        chosen = inside & (time < (time[below[0]] if below.size else np.inf))
        if np.sum(chosen) < 10:
            continue
        modulus, phase = np.abs(skeleton[chosen]), np.unwrap(np.angle(skeleton[chosen]))
        (fall, turn), _ = np.polyfit(time[chosen], np.stack([np.log(modulus), phase], axis=1), 1, w=modulus)
        wn = float(np.hypot(fall, turn))
        found.append((wn, float(-fall / wn)))
    return found
