"""Whiteness of a residual, and the effect of its colour on a covariance."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

LAGS = 20  # of the portmanteau test: a second's tenth at 200 Hz; misfits of modes last longer


def correlations(residual: RealArray, lags: int = LAGS) -> RealArray:
    """Return the correlation of each channel with itself 1 … lags samples later, (channel, lag)."""
    count = residual.shape[1]
    size = 1 << (2 * count - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(residual, size, axis=1)) ** 2
    products = np.fft.irfft(spectrum, size, axis=1)[:, : lags + 1]
    return np.asarray(products[:, 1:] / np.where(products[:, :1] > 0, products[:, :1], 1.0))


def portmanteau(residual: RealArray) -> tuple[RealArray, int]:
    """Return the statistic of Ljung and Box of each channel (channel,), and its degrees of freedom.

    ``Q = n (n + 2) sum_l r_l^2 / (n - l)`` is a chi-square for white noise; G. M. Ljung and G. E. P. Box, Biometrika 65
    (1978) 297-303.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> q, freedom = portmanteau(rng.standard_normal((2, 1000)))
    >>> bool(np.all(q < 45)), freedom
    (True, 20)
    """
    count = residual.shape[1]
    lags = min(LAGS, count // 4)
    r = correlations(residual, lags)
    return np.asarray(count * (count + 2) * np.sum(r**2 / (count - np.arange(1, lags + 1)), axis=1)), lags


def score_power(slope: RealArray, residual: RealArray) -> RealArray:
    """Return the covariance of ``slope^T residual`` for one channel of coloured noise, (unknown, unknown).

    With the spectrum S of the noise, smoothed from that of the residual (sample,), it is ``sum_w S |slope(w)|^2`` over
    the Fourier transforms of the derivatives (sample, unknown).
    """
    count = len(residual)
    size = 2 * count
    width = max(int(np.sqrt(count)), 1)
    power = np.abs(np.fft.fft(residual, size)) ** 2 / count
    kernel = np.fft.fft(np.bincount(np.arange(-width, width + 1) % size, minlength=size) / (2 * width + 1))
    smooth = np.maximum(np.fft.ifft(np.fft.fft(power) * kernel).real, 0.0)
    transformed = np.fft.fft(slope, size, axis=0)
    return np.asarray((transformed.conj().T @ (smooth[:, None] * transformed)).real / size)
