"""Fit damped exponentials to all channels by maximum likelihood and variable projection.

Every channel is a sum of the same damped exponentials, with its own amplitudes, and noise (`noise.WhiteNoise`). The
amplitudes are linear and eliminated exactly. The poles are found by damped Gauss-Newton steps, at each of which the
noise variances take their most likely values.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from suspid.identification.exponentials import ROOT_2, Blocks, gram_sums, real_powers, turn_of
from suspid.identification.information import inverse_information
from suspid.identification.noise import ROUNDING_OF_SAMPLES, WhiteNoise, degrees_of_freedom
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray

# Exponentials of unit norm of which less than this is orthogonal to the others are not fitted together: the rounding of
# their amplitudes grows with its inverse square.
LEAST_PIVOT = 1e-5


@dataclass(frozen=True, kw_only=True, eq=False)
class DecayFit:
    """Poles, the amplitudes that fit a record best at these poles, and what a Gauss-Newton step needs.

    What is kept is in the real basis of the exponentials (`exponentials.real_powers`), in which a pair takes a quarter
    of the products of complex numbers; what is asked for by exponent is turned.
    """

    poles: Poles  # the exponents
    count: int  # samples per channel
    amounts: RealArray  # (function, channel): amplitudes of the real basis
    squares: RealArray  # (channel,): residual sum of squares
    rounding: RealArray  # (channel,): rounding error of that sum; `squares` is not less
    weighted: RealArray  # (function, channel): these over the variance of the noise
    # (function, channel): inner products of the residual with the parts of the derivatives that are orthogonal to the
    # basis
    pull: RealArray
    # (order, function, function): inner products of the basis with itself, its first and its second derivatives
    products: RealArray
    inverse_products: RealArray  # (function, function): inverse of the first of them
    sampled: RealArray | None = None  # `beside`, where it was computed from samples

    @cached_property
    def beside(self) -> RealArray:
        """Inner products of the parts of the derivatives that are orthogonal to the basis, (function, function)."""
        if self.sampled is not None:
            return self.sampled
        _, tilt, bend = self.products
        return np.asarray(bend - tilt @ self.inverse_products @ tilt)

    @cached_property
    def gradient(self) -> RealArray:
        """Gradient of the log likelihood by the poles' real parameters (Re and Im per sample), (parameter,).

        A pair of amounts (a, b) of its real and imaginary part changes like (a, b) times k by the real part of its
        exponent, and like (b, -a) times k by the imaginary part.
        """
        pairs, reals = len(self.poles.pairs), len(self.poles.reals)
        (a, b, c), (by_a, by_b, by_c) = (
            (each[:pairs], each[pairs : 2 * pairs], each[2 * pairs : 2 * pairs + reals])
            for each in (self.weighted, self.pull)
        )
        out = np.empty(2 * pairs + reals)
        out[: 2 * pairs : 2] = (a * by_a + b * by_b).sum(axis=1)
        out[1 : 2 * pairs : 2] = (b * by_a - a * by_b).sum(axis=1)
        out[2 * pairs :] = (c * by_c).sum(axis=1)
        return np.asarray(out * self.count)

    @cached_property
    def information(self) -> RealArray:
        """Fisher information of the poles' real parameters, with unknown amplitudes, (parameter, parameter)."""
        pairs, reals, beside = len(self.poles.pairs), len(self.poles.reals), self.beside
        both, last = 2 * pairs, 2 * pairs + reals
        # By the parameter (Re, Im), the part of the pair, and the pair: see `gradient`.
        by_parameter, of_weight = (
            np.concatenate([each[:both], each[pairs:both], -each[:pairs]]) for each in (self.amounts, self.weighted)
        )
        out = np.empty((last, last))
        shares = (of_weight @ by_parameter.T).reshape(2, 2, pairs, 2, 2, pairs)
        shares *= beside[:both, :both].reshape(2, pairs, 1, 2, pairs)
        out[:both, :both] = shares.sum(axis=(1, 4)).transpose(1, 0, 3, 2).reshape(both, both)
        if reals:
            mixed = (of_weight @ self.amounts[both:last].T).reshape(2, 2, pairs, reals)
            mixed = (mixed * beside[:both, both:last].reshape(2, pairs, reals)).sum(axis=1)
            out[:both, both:] = mixed.transpose(1, 0, 2).reshape(both, reals)
            out[both:, :both] = out[:both, both:].T
            out[both:, both:] = beside[both:last, both:last] * (self.weighted[both:last] @ self.amounts[both:last].T)
        return np.asarray(out * self.count**2)

    @cached_property
    def amplitudes(self) -> ComplexArray:
        """Complex amplitudes at the first sample, (exponent, channel); conjugate for conjugate exponents."""
        pairs, half = len(self.poles.pairs), np.sqrt(0.5)
        upper = half * (self.amounts[:pairs] - 1j * self.amounts[pairs : 2 * pairs])
        return np.concatenate([upper, upper.conj(), self.amounts[2 * pairs :]])

    @cached_property
    def gram(self) -> ComplexArray:
        """Inner products of the exponentials, (exponent, exponent)."""
        return self._turned(self.products[0])

    @cached_property
    def inverse_gram(self) -> ComplexArray:
        """Inverse of `gram`, (exponent, exponent)."""
        return self._turned(self.inverse_products)

    @cached_property
    def tilt(self) -> ComplexArray:
        """Inner products of the exponentials with their derivatives, (exponent, exponent)."""
        return self._turned(self.products[1])

    @cached_property
    def bend(self) -> ComplexArray:
        """Inner products of the exponentials with their second derivatives, (exponent, exponent)."""
        return self._turned(self.products[2])

    @cached_property
    def sharpness(self) -> ComplexArray:
        """Inner products of the parts of the derivatives that are orthogonal to the exponentials, by exponent."""
        return self._turned(self.beside)

    @cached_property
    def of_poles(self) -> RealArray:
        """Covariance of the poles' real parameters, (parameter, parameter)."""
        return inverse_information(self.information * (self.freedom / self.count))

    def _turned(self, products: RealArray) -> ComplexArray:
        turn = turn_of(len(self.poles.pairs), len(products))
        return np.asarray(turn @ products @ turn.conj().T)

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
    from scipy.linalg.lapack import dpotrf, dtrtri

    count, pairs = blocks.count, len(poles.pairs)
    products = gram_sums(poles.pairs, np.concatenate([poles.reals, poles.nuisances]), count)
    gram, tilt, _ = products
    # The pivots of the Gram matrix of unit vectors are the parts of each that are orthogonal to those before it.
    norm = 1 / np.sqrt(_on_one_scale(gram.diagonal(), pairs))
    lower, failed = dpotrf(gram * (norm[:, None] * norm), lower=1, clean=1)
    if failed:
        return None
    pivot = float(lower.diagonal().min())
    if not pivot >= LEAST_PIVOT:
        return None
    inverse = dtrtri(lower, lower=1)[0] * norm
    inverse = inverse.T @ inverse
    half, fixed = blocks.project(poles.every), blocks.project(poles.nuisances.astype(complex))
    upper = ROOT_2 * half[:, :pairs]
    zeroth, first = np.concatenate([upper.real, -upper.imag, half[:, pairs:].real, fixed.real], axis=1)
    amounts = inverse @ zeroth
    explained = np.einsum("ic,ic->c", zeroth, amounts)
    # The inverse magnifies the rounding of the explained energy; a residual below that is meaningless.
    # Relative rounding error of inner products.
    rounding = 4e-15 / pivot**2 * blocks.energy
    return _weighed(
        poles,
        noise,
        count=count,
        amounts=amounts,
        squares=blocks.energy - explained,
        rounding=rounding,
        pull=first - tilt @ amounts,
        products=products,
        inverse=inverse,
    )


def evaluate_samples(values: RealArray, poles: Poles, noise: WhiteNoise) -> DecayFit | None:
    """Return the fit at given poles from the samples themselves, (channel, sample).

    Its rounding grows with the inverse of the smallest pivot, that of `evaluate` with its square; it takes longer.
    """
    from scipy.linalg.lapack import dtrtri

    count = values.shape[1]
    powers = real_powers(poles.exponents, len(poles.pairs), count)
    size = np.sqrt(_on_one_scale(np.einsum("kf,kf->f", powers, powers), len(poles.pairs)))
    basis, triangle = np.linalg.qr(powers / size)
    if not np.abs(triangle.diagonal()).min() >= LEAST_PIVOT:
        return None
    amounts = np.linalg.solve(triangle, basis.T @ values.T) / size[:, None]
    left = values.T - powers @ amounts
    bent = powers * (np.arange(count)[:, None] / count)
    beside = bent - basis @ (basis.T @ bent)
    inverse = dtrtri(triangle)[0] / size[:, None]
    return _weighed(
        poles,
        noise,
        count=count,
        amounts=amounts,
        squares=np.sum(left**2, axis=0),
        rounding=ROUNDING_OF_SAMPLES * np.sum(values**2, axis=1),
        pull=beside.T @ left,
        products=gram_sums(poles.pairs, np.concatenate([poles.reals, poles.nuisances]), count),
        inverse=inverse @ inverse.T,
        sampled=beside.T @ beside,
    )


def _on_one_scale(squares: RealArray, pairs: int) -> RealArray:
    """Return squared norms of the real basis with both parts of each pair at their mean: a slow pole has hardly one."""
    means = 0.5 * (squares[:pairs] + squares[pairs : 2 * pairs])
    return np.concatenate([means, means, squares[2 * pairs :]])


def _weighed(
    poles: Poles,
    noise: WhiteNoise,
    *,
    count: int,
    amounts: RealArray,
    squares: RealArray,
    rounding: RealArray,
    pull: RealArray,
    products: RealArray,
    inverse: RealArray,
    sampled: RealArray | None = None,
) -> DecayFit | None:
    """Return the fit with its channels weighed by the noise, None where that has no variance."""
    squares = np.maximum(squares, rounding)
    variance = noise.variance(squares, count)
    if not 0 < variance.min() < np.inf:
        return None
    return DecayFit(
        poles=poles,
        count=count,
        amounts=amounts,
        squares=squares,
        rounding=rounding,
        weighted=amounts / variance,
        pull=pull,
        products=products,
        inverse_products=inverse,
        sampled=sampled,
    )


def reweighed(fit: DecayFit, noise: WhiteNoise, squares: RealArray) -> DecayFit:
    """Return the fit with residual sums of squares (channel,) that were computed more accurately, from samples."""
    squares = np.maximum(squares, fit.rounding)
    return replace(fit, squares=squares, weighted=fit.amounts / noise.variance(squares, fit.count))


def bic_penalty(channels: int, samples: int, *, real: bool = False) -> float:
    """Return the BIC penalty of a pair, or of a real pole, in twice the log likelihood: ``log(samples)`` per parameter.

    The parameters of a pair are frequency, decay rate, and amplitude and phase in each channel; a real pole has half
    as many. The samples are those of all channels together.
    """
    return (1 if real else 2) * (1 + channels) * float(np.log(samples))
