"""Test whether two poles share one shape, from their amplitudes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.identification.covariance import LEAST_VARIANCE, amplitude_errors
from suspid.identification.likelihood import DecayFit
from suspid.units import ComplexArray, Ratio

# Level of the test: two poles of one motion are called two modes with this probability. A smaller level merges more
# close modes that few channels see.
SHAPE_LEVEL = 1e-2


def same_shape(fit: DecayFit, one: int, other: int, *, colour: Ratio) -> bool:
    """Return whether two free poles (pairs, then reals) could be one mode that is not quite linear: ``phi f(t)``.

    Amplitudes a and b of poles p and q have a common shape phi if all ``(a_c b_r - b_c a_r) (p - q)`` vanish, r the
    channel where both are strongest; unlike the shapes, these stay smooth where the poles meet. Their Wald statistic,
    with the joint covariance of amplitudes and poles, is chi-square with two degrees of freedom a channel less two.

    ``colour`` is the power of the residual near the poles over that of white noise.
    """
    which = np.array([one, other])
    std = np.sqrt(fit.squares / fit.freedom + 1e-300)
    a, b = fit.amplitudes[fit.poles.rows[which]] / std
    if len(a) < 2:
        return True
    strongest = int(np.argmax(np.abs(a) ** 2 / np.vdot(a, a).real + np.abs(b) ** 2 / np.vdot(b, b).real))
    others = np.delete(np.arange(len(a)), strongest)
    p, q = fit.poles.every[which]
    minors = a[others] * b[strongest] - b[others] * a[strongest]
    # Derivatives by Re and Im of both amplitudes in every channel (that by Im is j times that by Re), and by the poles.
    slopes = np.zeros((len(others), len(a), 2), complex)
    at = np.arange(len(others))
    slopes[at, others, 0], slopes[at, others, 1] = b[strongest], -a[strongest]
    slopes[at, strongest, 0], slopes[at, strongest, 1] = -b[others], a[others]
    slopes *= (p - q) / std[:, None]
    by_amplitudes = np.stack([slopes, 1j * slopes], axis=-1).reshape(len(others), -1)
    chart = fit.poles.chart[fit.poles.rows[which]]
    by_poles = minors[:, None] * (chart[0] - chart[1])
    return _vanishes(fit, which, minors * (p - q), (by_amplitudes, by_poles), colour=colour)


def within_shapes(fit: DecayFit, one: int, others: tuple[int, int], *, colour: Ratio) -> bool:
    """Return whether the shape of a free pole could be a sum of those of two others, which are near each other.

    What is known of two such poles is the plane of their shapes; within it, each shape may be anything. The Wald
    statistic of what is left of the amplitudes of one beside that plane is compared as in `same_shape`.
    """
    which = np.array([one, *others])
    std = np.sqrt(fit.squares / fit.freedom + 1e-300)
    amplitudes = fit.amplitudes[fit.poles.rows[which]] / std
    channels = len(std)
    if channels < 3:
        return True
    plane = amplitudes[1:].T
    beside = np.linalg.qr(plane, mode="complete")[0][:, 2:].conj().T
    weights = np.concatenate([[1.0], -np.linalg.lstsq(plane, amplitudes[0], rcond=None)[0]])
    slopes = np.zeros((channels, channels, len(which)), complex)
    at = np.arange(channels)
    slopes[at, at] = weights / std[:, None]
    by_amplitudes = beside @ np.stack([slopes, 1j * slopes], axis=-1).reshape(channels, -1)
    by_poles = np.zeros((len(beside), fit.poles.chart.shape[1]), complex)
    return _vanishes(fit, which, beside @ amplitudes[0], (by_amplitudes, by_poles), colour=colour)


def _vanishes(
    fit: DecayFit,
    which: NDArray[np.intp],
    value: ComplexArray,
    slopes: tuple[ComplexArray, ComplexArray],
    *,
    colour: Ratio,
) -> bool:
    """Return whether a function of the amplitudes of some poles could be 0, by its Wald statistic.

    ``slopes`` are its derivatives by Re and Im of the amplitudes, and what it changes besides by the poles.
    """
    from scipy.special import chdtri

    noise, dragged = amplitude_errors(fit, which)
    by_amplitudes, by_poles = slopes
    parts = (value, by_amplitudes, by_amplitudes @ dragged + by_poles)
    both, own, turned = (np.concatenate([each.real, each.imag]) for each in parts)
    covariance = own @ noise @ own.T + turned @ fit.of_poles @ turned.T
    scale = np.sqrt(np.maximum(covariance.diagonal(), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    # Of real poles, half of the parts are none.
    sure = values > LEAST_VARIANCE
    statistic = np.sum((vectors.T @ (both / scale))[sure] ** 2 / values[sure])
    return bool(statistic / colour < chdtri(int(sure.sum()), SHAPE_LEVEL))
