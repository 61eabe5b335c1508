"""The colour of a residual, and its power near each pole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.identification.exponentials import inner_products, project
from suspid.units import ComplexArray, RealArray

# A residual is coloured if its correlation over one sample is this many standard deviations from zero. A smaller number
# judges white residuals by their estimated spectrum, which is more scattered.
COLOURED = 4.0
# Order of the autoregression that describes a coloured residual. A higher order follows chance in short records.
COLOUR_ORDER = 8
# Power near a pole that counts as excess over a white residual: the mean of 8 independent exponential variables
# exceeds it with probability 8e-4. A lower value widens intervals that are right.
LOUD = 2.5


def lag_one(residual: RealArray, power: RealArray | None = None) -> RealArray:
    """Return the correlation of each residual with itself one sample later [1], (channel,): 0 for white noise.

    The sum of products is divided by ``power``, by default the sum of squares.
    """
    power = inner_products(residual, residual) if power is None else power
    products = inner_products(residual[:, 1:], residual[:, :-1])
    return np.asarray(products / np.where(power > 0, power, 1.0))


def correlated(correlation: RealArray, count: int, *, sigmas: float) -> NDArray[np.bool_]:
    """Return whether correlations over ``count`` samples are more than ``sigmas`` standard deviations from 0.

    The correlation of two white series over n samples is normal with standard deviation ``1 / sqrt(n)``.

    Examples
    --------
    >>> correlated(np.array([0.019, 0.021]), 10000, sigmas=2.0)
    array([False,  True])
    """
    return np.asarray(np.abs(correlation) > sigmas / np.sqrt(count))


def noise_colour(residual: RealArray, omega: RealArray) -> RealArray:
    """Return the power density of a residual over that of white noise of its variance, (channel, frequency).

    From an autoregression of order `COLOUR_ORDER` (Yule-Walker): ``1 / |1 - sum_k a_k exp(-j omega k)|^2`` over
    its mean, at angular frequencies per sample.
    """
    from scipy.linalg import solve_toeplitz

    lags = [
        inner_products(residual[:, lag:], residual[:, : residual.shape[1] - lag]) for lag in range(COLOUR_ORDER + 1)
    ]
    turns = np.exp(-1j * np.arange(1, COLOUR_ORDER + 1)[:, None] * omega)
    # A trace of white noise keeps the equations regular.
    ridge = np.array([1.0 + 1e-9, *np.ones(COLOUR_ORDER - 1)])
    density = np.ones((len(residual), len(omega)))
    for channel, correlation in enumerate(np.array(lags).T):
        if correlation[0] > 0:
            coefficients = solve_toeplitz(correlation[:-1] * ridge, correlation[1:])
            innovation = 1 - float(coefficients @ correlation[1:]) / correlation[0]
            density[channel] = innovation / np.abs(1 - coefficients @ turns) ** 2
    return density


def power_near(residual: RealArray, variance: RealArray, theta: ComplexArray) -> RealArray:
    """Return the power of a residual near each pole over that of white noise of its variance, (channel, pole).

    The residual is weighted by the decay of each pole.
    """
    count = residual.shape[1]
    decay = np.maximum(-theta.real, 0.25 / count)
    # The power near a pole is the mean over these offsets, in linewidths; the pole's own line is left out.
    offsets = (decay + np.pi / count)[:, None] * np.array([-8.0, -6.0, -4.0, -2.0, 2.0, 4.0, 6.0, 8.0])
    omega = np.minimum(np.maximum(np.abs(theta.imag[:, None] + offsets), np.pi / count), np.pi)
    spread = project(residual, (1j * omega - decay[:, None]).ravel())[0].T
    expected = np.expm1(-2 * decay * count) / np.expm1(-2 * decay)
    power = np.mean(np.abs(spread.reshape(len(variance), *omega.shape)) ** 2, axis=2)
    return np.asarray(power / expected / variance[:, None])


def loudness(
    residual: RealArray, variance: RealArray, theta: ComplexArray, *, beside: RealArray, weights: RealArray
) -> RealArray:
    """Return the power of a residual near each pole over that of white noise, (pole,): 1 where they agree.

    ``beside`` is from `power_near`; ``weights`` are the shares of the channels in what is known of each pole, both
    (channel, pole).
    """
    # In a white residual the power near a pole is mostly chance. In a coloured one it underestimates the noise
    # where the spectrum peaks at the pole itself.
    correlation = lag_one(residual, variance * residual.shape[1])
    if not np.any(correlated(correlation, residual.shape[1], sigmas=COLOURED)):
        ratio = over_channels(beside, weights)
        return np.where(ratio > LOUD, ratio, 1.0)
    ratio = over_channels(np.maximum(beside, noise_colour(residual, np.abs(theta.imag))), weights)
    return np.where(ratio > 1.0, ratio, 1.0)


def over_channels(values: RealArray, weights: RealArray) -> RealArray:
    """Return the weighted mean over channels of values (channel, pole), (pole,)."""
    return np.asarray(np.sum(weights * values, axis=0) / np.sum(weights, axis=0))
