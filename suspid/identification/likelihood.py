"""Fit damped exponentials to all channels by maximum likelihood and variable projection.

Every channel is a sum of the same damped exponentials, with its own amplitudes, and noise (`noise.WhiteNoise`). The
amplitudes are linear and eliminated exactly. The poles are found by damped Gauss-Newton steps, at each of which the
noise variances take their most likely values.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.exponentials import Blocks, gram_sums, real_powers
from suspid.identification.noise import ROUNDING_OF_SAMPLES, WhiteNoise, degrees_of_freedom
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray

# Exponentials of unit norm of which less than this is orthogonal to the others are not fitted together: the rounding of
# their amplitudes grows with its inverse square.
LEAST_PIVOT = 1e-5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DecayFit:
    """Poles, the amplitudes that fit a record best at these poles, and what a Gauss-Newton step needs."""

    poles: Poles  # the exponents
    count: int  # samples per channel
    # (exponent, channel): complex amplitudes at the first sample; conjugate for conjugate exponents.
    amplitudes: ComplexArray
    squares: RealArray  # (channel,): residual sum of squares
    rounding: RealArray  # (channel,): rounding error of that sum; `squares` is not less
    # (parameter, parameter): fisher information of the poles' real parameters (Re and Im per sample), with unknown
    # amplitudes.
    information: RealArray
    gradient: RealArray  # (parameter,): gradient of the log likelihood by the poles' real parameters
    gram: ComplexArray  # (exponent, exponent): inner products of the exponentials
    tilt: ComplexArray  # (exponent, exponent): inner products of the exponentials with their derivatives
    bend: ComplexArray  # (exponent, exponent): inner products of the exponentials with their second derivatives
    # (exponent, exponent): inner products of the parts of the derivatives that are orthogonal to the exponentials.
    sharpness: ComplexArray

    @property
    def strengths(self) -> RealArray:
        """Squared amplitude of each free pole over what the fit leaves, all channels together, (pole,)."""
        return np.asarray(np.sum(np.abs(self.amplitudes[self.poles.rows]) ** 2 / (self.squares + 1e-300), axis=1))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the residual of one channel."""
        return degrees_of_freedom(
            self.count, amplitudes=len(self.poles), poles=self.poles.free, channels=len(self.squares)
        )


def evaluate(blocks: Blocks, poles: Poles, noise: WhiteNoise) -> DecayFit | None:
    """Return the fit at given poles, or None where their exponentials are linearly dependent."""
    from scipy.linalg.lapack import zpotrf, ztrtri

    count, pairs = blocks.count, len(poles.pairs)
    gram, tilt, bend = gram_sums(poles.pairs, np.concatenate([poles.reals, poles.nuisances]), count)
    # The pivots of the Gram matrix of unit vectors are the parts of each that are orthogonal to those before it.
    norm = 1 / np.sqrt(gram.diagonal().real)
    lower, failed = zpotrf(gram * (norm[:, None] * norm), lower=1, clean=1)
    if failed:
        return None
    pivot = float(lower.diagonal().real.min())
    if not pivot >= LEAST_PIVOT:
        return None
    inverse = ztrtri(lower, lower=1)[0] * norm
    inverse = inverse.conj().T @ inverse
    # For a real record the inner products with conjugate exponentials are conjugate.
    half, fixed = blocks.project(poles.every), blocks.project(poles.nuisances.astype(complex))
    zeroth, first = np.concatenate([half[:, :pairs], half[:, :pairs].conj(), half[:, pairs:], fixed], axis=1)
    amplitudes = inverse @ zeroth
    explained = np.einsum("ic,ic->c", zeroth.conj(), amplitudes).real
    # The inverse magnifies the rounding of the explained energy; a residual below that is meaningless.
    # Relative rounding error of inner products.
    rounding = 4e-15 / pivot**2 * blocks.energy
    return _weighed(
        poles,
        noise,
        count=count,
        amplitudes=amplitudes,
        squares=blocks.energy - explained,
        rounding=rounding,
        pull=first - tilt @ amplitudes,
        gram=gram,
        tilt=tilt,
        bend=bend,
        sharpness=bend - tilt @ inverse @ tilt,
    )


def evaluate_samples(values: RealArray, poles: Poles, noise: WhiteNoise) -> DecayFit | None:
    """Return the fit at given poles from the samples themselves, (channel, sample).

    Its rounding grows with the inverse of the smallest pivot, that of `evaluate` with its square; it takes longer.
    """
    count = values.shape[1]
    powers, turn = real_powers(poles.exponents, len(poles.pairs), count)
    size = np.linalg.norm(powers, axis=0)
    # Both parts of a pair on one scale: a slow pole has hardly an imaginary part.
    size = np.sqrt(np.abs(turn.conj().T) ** 2 @ (np.abs(turn) ** 2 @ size**2))
    basis, triangle = np.linalg.qr(powers / size)
    if not np.abs(triangle.diagonal()).min() >= LEAST_PIVOT:
        return None
    amounts = np.linalg.solve(triangle, basis.T @ values.T) / size[:, None]
    amplitudes, left = turn @ amounts, values.T - powers @ amounts
    bent = powers * (np.arange(count)[:, None] / count)
    beside = bent - basis @ (basis.T @ bent)
    gram, tilt, bend = gram_sums(poles.pairs, np.concatenate([poles.reals, poles.nuisances]), count)
    return _weighed(
        poles,
        noise,
        count=count,
        amplitudes=amplitudes,
        squares=np.sum(left**2, axis=0),
        rounding=ROUNDING_OF_SAMPLES * np.sum(values**2, axis=1),
        pull=turn @ (beside.T @ left),
        gram=gram,
        tilt=tilt,
        bend=bend,
        sharpness=turn @ (beside.T @ beside) @ turn.conj().T,
    )


def _weighed(
    poles: Poles,
    noise: WhiteNoise,
    *,
    count: int,
    amplitudes: ComplexArray,
    squares: RealArray,
    rounding: RealArray,
    pull: ComplexArray,
    gram: ComplexArray,
    tilt: ComplexArray,
    bend: ComplexArray,
    sharpness: ComplexArray,
) -> DecayFit | None:
    """Return the fit with its channels weighed by the noise, None where that has no variance.

    ``pull`` are the inner products of the residual with the parts of the derivatives that are orthogonal to the
    exponentials, (exponent, channel).
    """
    squares = np.maximum(squares, rounding)
    variance = noise.variance(squares, count)
    if not 0 < variance.min() < np.inf:
        return None
    weighted = amplitudes.conj() / variance
    slope = (weighted * pull).sum(axis=1)
    return DecayFit(
        poles=poles,
        count=count,
        amplitudes=amplitudes,
        squares=squares,
        rounding=rounding,
        information=_information(poles, sharpness * (weighted @ amplitudes.T), count),
        gradient=(poles.chart.conj().T @ slope).real * count,
        gram=gram,
        tilt=tilt,
        bend=bend,
        sharpness=sharpness,
    )


def reweighed(fit: DecayFit, noise: WhiteNoise, squares: RealArray) -> DecayFit:
    """Return the fit with residual sums of squares (channel,) that were computed more accurately, from samples."""
    squares = np.maximum(squares, fit.rounding)
    variance = noise.variance(squares, fit.count)
    curvature = fit.sharpness * ((fit.amplitudes.conj() / variance) @ fit.amplitudes.T)
    information = _information(fit.poles, curvature, fit.count)
    return replace(fit, squares=squares, information=information)


def _information(poles: Poles, curvature: ComplexArray, count: int) -> RealArray:
    """Return the information on the real parameters of poles from that on their exponents."""
    chart = poles.chart
    return np.asarray((chart.conj().T @ curvature @ chart).real * count**2)


def bic_penalty(channels: int, samples: int, *, real: bool = False) -> float:
    """Return the BIC penalty of a pair, or of a real pole, in twice the log likelihood: ``log(samples)`` per parameter.

    The parameters of a pair are frequency, decay rate, and amplitude and phase in each channel; a real pole has half
    as many. The samples are those of all channels together.
    """
    return (1 if real else 2) * (1 + channels) * float(np.log(samples))
