"""Fit damped exponentials to all channels by maximum likelihood and variable projection.

Every channel is a sum of the same damped exponentials, with its own amplitudes, and noise (`noise.WhiteNoise`). The
amplitudes are linear and eliminated exactly. The poles are found by damped Gauss-Newton steps, at each of which the
noise variances take their most likely values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from suspid.identification.exponentials import Blocks, gram_sums
from suspid.identification.noise import WhiteNoise, degrees_of_freedom
from suspid.identification.poles import Poles
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real

# A Gauss-Newton step is worth about its squared length in standard deviations; iterations end below this. A larger
# value leaves the poles off the optimum by its square root.
NEGLIGIBLE_STEP = 1e-5


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
    # (exponent, exponent): inner products of the parts of the derivatives that are orthogonal to the exponentials.
    sharpness: ComplexArray

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
    # Exponentials of unit norm of which less than this is orthogonal to the others are not fitted together: the
    # rounding of their amplitudes grows with its inverse square.
    if not pivot >= 1e-5:
        return None
    inverse = ztrtri(lower, lower=1)[0] * norm
    inverse = inverse.conj().T @ inverse
    # For a real record the inner products with conjugate exponentials are conjugate.
    distinct = np.concatenate([poles.pairs, poles.reals, poles.nuisances])
    half = blocks.project(distinct).transpose(0, 2, 1)
    zeroth, first = np.concatenate([half[:, :pairs], half[:, :pairs].conj(), half[:, pairs:]], axis=1)
    amplitudes = inverse @ zeroth
    explained = np.einsum("ic,ic->c", zeroth.conj(), amplitudes).real
    # The inverse magnifies the rounding of the explained energy; a residual below that is meaningless.
    # Relative rounding error of inner products.
    rounding = 4e-15 / pivot**2 * blocks.energy
    squares = np.maximum(blocks.energy - explained, rounding)
    variance = noise.variance(squares, count)
    if not 0 < variance.min() < np.inf:
        return None
    sharpness = bend - tilt @ inverse @ tilt
    weighted = amplitudes.conj() / variance
    slope = (weighted * (first - tilt @ amplitudes)).sum(axis=1)
    return DecayFit(
        poles=poles,
        count=count,
        amplitudes=amplitudes,
        squares=squares,
        rounding=rounding,
        information=_information(poles, sharpness, amplitudes, variance, count),
        gradient=(poles.chart.conj().T @ slope).real * count,
        gram=gram,
        tilt=tilt,
        sharpness=sharpness,
    )


def reweighed(fit: DecayFit, noise: WhiteNoise, squares: RealArray) -> DecayFit:
    """Return the fit with residual sums of squares (channel,) that were computed more accurately, from samples."""
    squares = np.maximum(squares, fit.rounding)
    variance = noise.variance(squares, fit.count)
    information = _information(fit.poles, fit.sharpness, fit.amplitudes, variance, fit.count)
    return replace(fit, squares=squares, information=information)


def _information(
    poles: Poles, sharpness: ComplexArray, amplitudes: ComplexArray, variance: RealArray, count: int
) -> RealArray:
    chart = poles.chart
    curvature = sharpness * ((amplitudes.conj() / variance) @ amplitudes.T)
    return np.asarray((chart.conj().T @ curvature @ chart).real * count**2)


def bic_penalty(channels: int, samples: int, *, real: bool = False) -> float:
    """Return the BIC penalty of a pair, or of a real pole, in twice the log likelihood: ``log(samples)`` per parameter.

    The parameters of a pair are frequency, decay rate, and amplitude and phase in each channel; a real pole has half
    as many. The samples are those of all channels together.
    """
    return (1 if real else 2) * (1 + channels) * float(np.log(samples))


def maximize(
    blocks: Blocks,
    start: Poles | DecayFit,
    noise: WhiteNoise,
    *,
    steps: int = 60,
    negligible: float = NEGLIGIBLE_STEP,
) -> DecayFit | None:
    """Return the fit of greatest likelihood near given poles, by damped Gauss-Newton steps.

    A fit to start from must have been evaluated with the same record and noise. The search ends when a step promises
    less than ``negligible`` in twice the log likelihood.
    """
    from scipy.linalg.lapack import dposv

    fit = start if isinstance(start, DecayFit) else evaluate(blocks, start, noise)
    if fit is None or not fit.poles.free:
        return fit
    damping = 1e-3
    rounding = 1e-13 * blocks.count
    for _ in range(steps):
        diagonal = fit.information.diagonal()
        if not (math.isfinite(fit.information.sum()) and diagonal.min() > 0):
            return fit
        scale = np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
        unit = fit.information / (scale[:, None] * scale)
        for _ in range(12):
            _, step, failed = dposv(unit + damping * _unit_matrix(len(unit)), fit.gradient / scale)
            # Without damping, rounding may leave the information indefinite.
            if failed:
                step = np.linalg.solve(unit + damping * _unit_matrix(len(unit)), fit.gradient / scale)
            step = step / scale
            worth = float(step @ fit.gradient)
            if worth < negligible:
                return fit
            trial = evaluate(blocks, fit.poles.moved_within(step, blocks.count), noise)
            if trial is not None:
                # Two fits whose residuals are below the rounding of either are equally good.
                coarse = noise.at_least(np.maximum(fit.rounding, trial.rounding) / blocks.count)
                worse = coarse.loss(trial.squares, blocks.count) - coarse.loss(fit.squares, blocks.count)
                if worse <= rounding:
                    break
            damping = max(10 * damping, 1e-4)
        else:
            return fit
        fit = trial
        damping = damping / 10 if damping > 1e-9 else 0.0
    return fit


@lru_cache(maxsize=64)
def _unit_matrix(size: int) -> RealArray:
    return frozen_real(np.eye(size))
