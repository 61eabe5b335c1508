"""Candidates for the next pole: maxima of the gain over a grid of frequency and decay rate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from suspid.identification.exponentials import cross_sums
from suspid.identification.likelihood import DecayFit, bic_penalty
from suspid.identification.noise import loss_growth
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray

Exponents = TypeVar("Exponents", RealArray, ComplexArray)

# Local maxima whose gain is computed exactly, beyond the points near fitted poles. More cost time.
LOCAL_MAXIMA = 48
# The largest number of candidates, and of those that are fitted before the search ends.
MOST_CANDIDATES, CANDIDATES_TRIED = 12, 3
# Bins of a spectrum whose largest tells whether one of them may be among the largest maxima.
BINS_OF_BLOCK = 64
# Samples up to which a row more makes a Fourier transform of three rows faster.
LONGEST_IN_FOURS = 1 << 18


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Candidate:
    """A pole worth trying: exponent per sample, and what it would gain in twice the log likelihood."""

    theta: complex
    real: bool
    gain: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Points:
    """Grid points where the residual of a fit is large."""

    theta: ComplexArray  # (point,): exponents per sample, the first ones real
    inner: ComplexArray  # (channel, point): inner products with the residual
    reals: int  # number of real exponents
    fit: DecayFit  # the fit
    cross: ComplexArray  # (exponent, point): inner products with the exponentials of the fit

    def beside(self, fit: DecayFit) -> tuple[ComplexArray, ComplexArray]:
        """Return inner products with the exponentials of a fit, (exponent, point), and with its residual."""
        if fit is self.fit:
            return self.cross, self.inner
        cross = cross_sums(fit.poles.exponents.conj(), self.theta, fit.count)
        record = self.inner + self.fit.amplitudes.T @ self.cross.conj()
        return cross, record - fit.amplitudes.T @ cross.conj()


def searched(fit: DecayFit, residual: RealArray, variance: RealArray) -> Points:
    """Return the grid points where the residual of a fit is large."""
    count, known = residual.shape[1], fit.poles.exponents
    noise = np.sqrt(variance)[:, None]
    # Single precision suffices to choose points, for a residual of unit variance.
    scaled = np.divide(residual, noise, out=np.empty(residual.shape, np.float32), casting="same_kind")
    theta, inner = _largest_points(scaled, known[known.imag >= 0])
    cross = cross_sums(known.conj(), theta, count)
    return Points(theta=theta, inner=inner * noise, reals=len(_layout(count)), fit=fit, cross=cross)


def ranked(fit: DecayFit, variance: RealArray, points: Points) -> list[Candidate]:
    """Return grid points in order of gain less BIC penalty, no two within a linewidth of each other.

    A gain counts the part orthogonal to the poles fitted so far.
    """
    theta, count, reals, channels = points.theta, fit.count, points.reals, len(variance)
    cross, inner = points.beside(fit)
    solved = fit.inverse_gram @ cross
    share = np.empty((channels, len(theta)))
    share[:, :reals] = _real_gain(theta[:reals], inner[:, :reals], cross[:, :reals], solved[:, :reals], count)
    share[:, reals:] = _pair_gain(
        fit.poles, theta[reals:], inner[:, reals:], cross[:, reals:], solved[:, reals:], count
    )
    share /= variance[:, None] * count
    gains = -loss_growth(-np.minimum(np.maximum(share, 0.0), 1 - 1e-12), count)
    samples = channels * count
    is_real = np.arange(len(theta)) < reals
    net = gains - np.where(is_real, bic_penalty(channels, samples, real=True), bic_penalty(channels, samples))
    reach = 2 * np.abs(theta.real) + 2 * np.pi / count
    distinct: list[Candidate] = []
    for _ in range(MOST_CANDIDATES):
        best = int(net.argmax())
        if net[best] == -np.inf or (net[best] < 0 and len(distinct) >= CANDIDATES_TRIED):
            break
        distinct.append(Candidate(theta=complex(theta[best]), real=best < reals, gain=float(gains[best])))
        near = np.abs(theta.imag - theta[best].imag) <= np.maximum(reach, reach[best])
        net[near & (is_real == is_real[best])] = -np.inf
    return distinct


@lru_cache(maxsize=64)
def _layout(count: int) -> tuple[tuple[float, int, int, float], ...]:
    """Return decay rate, samples in use, length of the transform and squared norm, for each decay rate of the grid."""
    from scipy.fft import next_fast_len

    layout = []
    # Neighbouring decay rates differ by a factor of 4, from one e-folding over the record to one per sample. Midway
    # between two rates a pole still shows 89 % of its energy; a pole that does not decay shows 92 % at the first rate.
    for decay in np.geomspace(1.0 / count, 1.0, 1 + int(np.ceil(np.log(count) / np.log(4.0)))).tolist():
        # After 9 e-foldings a pole has decayed to 1e-4. With 3 e-foldings its line is wider than a Fourier bin.
        used = min(count, int(np.ceil(9.0 / decay)))
        length = next_fast_len(used if decay * count > 3.0 else 2 * used, real=True)
        layout.append((decay, used, length, float(np.expm1(-2 * decay * used) / np.expm1(-2 * decay))))
    return tuple(layout)


def _largest_points(scaled: NDArray[np.float32], known: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return exponents, (point,), and a residual's inner products with them, (channel, point).

    The first are real, one for each decay rate. The others are the largest of the local maxima along frequency at
    each decay rate, and points near the fitted poles.
    """
    count = scaled.shape[1]
    layout = _layout(count)
    decay, per_bin = np.array([p[0] for p in layout]), 2 * np.pi / np.array([p[2] for p in layout])
    reach = 4 * np.maximum(np.maximum(decay[:, None], -known.real), np.pi / count)
    low = np.maximum(np.ceil((known.imag - reach) / per_bin[:, None]), 1).astype(int)
    high = np.minimum((known.imag + reach) / per_bin[:, None], np.pi / per_bin[:, None] - 1).astype(int)
    fast = np.maximum(-known.real, 1 / count)
    alike = (known.imag == 0) | ((decay[:, None] >= fast / 8.0) & (decay[:, None] <= fast * 32.0))
    # 13 points near each fitted pole, at decay rates from an eighth of its own to 32 times that.
    between = low[..., None] + (high - low)[..., None] * np.arange(13) // 12
    theta, heights = [-decay + 0j], [np.full(len(layout), np.inf)]
    inner: list[NDArray[np.complexfloating]] = [np.empty((len(scaled), len(layout)), complex)]
    for k, (rate, used, length, norm) in enumerate(layout):
        spectrum = _spectrum(scaled[:, :used] * _decay(rate, used), length)
        parts = spectrum.view(np.float32)
        squares = np.einsum("ck,ck->k", parts, parts)
        gain = squares[::2] + squares[1::2]
        peaks = _largest_peaks(gain)
        beside = between[k][alike[k] & (high[k] >= low[k])].ravel()
        bins = np.concatenate([peaks, beside])
        inner[0][:, k] = spectrum[:, 0]
        inner.append(spectrum[:, bins])
        theta.append(-rate + 1j * per_bin[k] * bins)
        heights.append(np.concatenate([gain[peaks] / norm, np.full(len(beside), np.inf)]))
    height = np.concatenate(heights)
    ranked = np.sort(height[height < np.inf])[-LOCAL_MAXIMA:]
    keep = np.flatnonzero(height >= (ranked[0] if len(ranked) else 0.0))
    return np.concatenate(theta)[keep], np.asarray(np.concatenate(inner, axis=1)[:, keep], complex)


def _largest_peaks(gain: NDArray[np.float32]) -> NDArray[np.intp]:
    """Return the bins of the largest local maxima, at most `LOCAL_MAXIMA` of them, without the first bin and the last.

    In long spectra only bins above the largest of most blocks are looked at, if enough of them are maxima.
    """
    blocks = (len(gain) - 2) // BINS_OF_BLOCK
    if blocks >= 8 * LOCAL_MAXIMA:
        tops = np.max(gain[1 : 1 + blocks * BINS_OF_BLOCK].reshape(blocks, -1), axis=1)
        high = np.flatnonzero(gain[1:-1] >= np.partition(tops, -2 * LOCAL_MAXIMA)[-2 * LOCAL_MAXIMA]) + 1
        peaks = high[(gain[high] >= gain[high - 1]) & (gain[high] >= gain[high + 1])]
    if blocks < 8 * LOCAL_MAXIMA or len(peaks) < LOCAL_MAXIMA:
        peaks = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] >= gain[2:])) + 1
    if len(peaks) <= LOCAL_MAXIMA:
        return peaks
    return np.asarray(peaks[np.argpartition(gain[peaks], -LOCAL_MAXIMA)[-LOCAL_MAXIMA:]])


def _spectrum(scaled: NDArray[np.float32], length: int) -> NDArray[np.complex64]:
    """Return the Fourier transform of each channel, with zeros up to a length."""
    from scipy.fft import rfft

    channels = len(scaled)
    # Four rows are transformed at once, in less time than three one by one, unless they exceed the processor's cache.
    if channels % 4 == 3 and length <= LONGEST_IN_FOURS:
        scaled = np.concatenate([scaled, np.zeros_like(scaled[:1])])
    spectrum: NDArray[np.complex64] = rfft(scaled, n=length, axis=1)[:channels]
    return spectrum


def _decay(rate: float, count: int) -> NDArray[np.float32]:
    """Return ``exp(-rate k)``; cached for records that are not long."""
    if count <= 2**16:
        return _short_decay(rate, count)
    # A product of two powers takes a fifth of the time of an exponential.
    size = int(np.sqrt(count))
    first, within = (np.exp(-rate * np.arange(0, stop, step)) for stop, step in ((count, size), (size, 1)))
    decay: NDArray[np.float32] = np.multiply.outer(first, within).ravel()[:count].astype(np.float32)
    return decay


@lru_cache(maxsize=32)
def _short_decay(rate: float, count: int) -> NDArray[np.float32]:
    decay: NDArray[np.float32] = np.exp(-rate * np.arange(count)).astype(np.float32)
    return decay


def _pair_gain(
    poles: Poles, theta: ComplexArray, inner: ComplexArray, cross: ComplexArray, solved: ComplexArray, count: int
) -> RealArray:
    """Return the square of the part of the residual along ``exp(theta k)`` and its conjugate, (channel, point)."""
    own, own_conjugate = _own(2 * theta.real, count), _own(2 * theta.conj(), count)
    s0 = own - _product(cross, solved).real
    s1 = own_conjugate - _product(cross, solved[_twins(len(poles.pairs), len(poles))].conj())
    determinant = s0**2 - np.abs(s1) ** 2
    sound = (s0 > 1e-6 * own) & (determinant > 1e-6 * s0**2)
    gain = 2 * (s0 * (inner.real**2 + inner.imag**2) - (inner.conj() ** 2 * s1).real)
    return np.where(sound, gain / np.where(sound, determinant, 1.0), 0.0)


def _real_gain(
    theta: ComplexArray, inner: ComplexArray, cross: ComplexArray, solved: ComplexArray, count: int
) -> RealArray:
    """Return the square of the part of the residual along ``exp(theta k)``, theta real, (channel, point)."""
    own = _own(2 * theta.real, count)
    left = own - _product(cross, solved).real
    sound = left > 1e-6 * own
    return np.where(sound, inner.real**2 / np.where(sound, left, 1.0), 0.0)


def _own(phi: Exponents, count: int) -> Exponents:
    """Return ``sum_k exp(phi k)`` for exponents that are not near 0."""
    return np.asarray(np.expm1(count * phi) / np.expm1(phi))


def _product(left: ComplexArray, right: ComplexArray) -> ComplexArray:
    return np.asarray((left.conj() * right).sum(axis=0))


@lru_cache(maxsize=256)
def _twins(pairs: int, exponents: int) -> NDArray[np.intp]:
    """Return the index of the conjugate of each exponent."""
    return np.concatenate([np.arange(pairs) + pairs, np.arange(pairs), np.arange(2 * pairs, exponents)])
