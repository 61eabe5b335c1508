"""White noise of unknown variance in every channel: its likelihood and degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.noise.quantisation import resolution
from suspid.units import RealArray

# Relative rounding error of a residual's mean square that is computed from samples.
ROUNDING_OF_SAMPLES = 1e-28


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class WhiteNoise:
    """Independent white Gaussian noise in every channel, each of unknown variance above a known least.

    Parameters
    ----------
    least : ndarray (channel,)
        Least variance: rounding and quantisation. Without it the likelihood of an exact record is unbounded.
    """

    least: RealArray

    def variance(self, squares: RealArray, count: float) -> RealArray:
        """Return the most likely variance given residual sums of squares over ``count`` samples, (channel,).

        Given degrees of freedom instead of samples, return the unbiased estimate.
        """
        return np.asarray(np.maximum(squares / count, self.least))

    def loss(self, squares: RealArray, count: int) -> float:
        """Return minus twice the log likelihood less a constant: ``n sum_c log variance_c`` at the best variance."""
        return float(count * np.log(self.variance(squares, count)).sum())

    def cost(self, squares: RealArray, count: int) -> float:
        """Return what a fit makes least: the loss, and below the least variance, where it is flat, the squares.

        Minus twice the log likelihood of channels of which the least variance is known, less a constant.

        Examples
        --------
        >>> noise = WhiteNoise(least=np.ones(1))
        >>> [round(noise.cost(np.array([squares]), 10), 3) for squares in (20.0, 10.0, 5.0)]
        [6.931, 0.0, -5.0]
        """
        below = np.minimum(squares / (self.least * count), 1.0) - 1.0
        return self.loss(squares, count) + float(count * below.sum())

    def at_least(self, variance: RealArray) -> WhiteNoise:
        """Return the noise with the least variance of each channel raised to a given one."""
        return WhiteNoise(least=np.maximum(self.least, variance))

    def of_means(self, size: int) -> WhiteNoise:
        """Return the noise of means over ``size`` samples each."""
        return replace(self, least=self.least / size)

    def rounded(self, energy: RealArray, count: int, *, of_energies: bool = False) -> WhiteNoise:
        """Return the noise with the least variance raised to the rounding errors of a residual.

        They are those of a record of given energy (channel,), where residual sums of squares are sums over samples or
        differences of energies.
        """
        # As energy less explained energy.
        share = 1e-15 if of_energies else ROUNDING_OF_SAMPLES
        return self.at_least(share * energy / count)


class KnownNoise(WhiteNoise):
    """Independent white Gaussian noise whose variance is known in every channel: the ``least`` variance."""

    def variance(self, squares: RealArray, count: float) -> RealArray:  # noqa: ARG002 - those of `WhiteNoise`
        """Return the known variance, (channel,)."""
        return self.least

    def loss(self, squares: RealArray, count: int) -> float:  # noqa: ARG002 - those of `WhiteNoise`
        """Return minus twice the log likelihood less a constant."""
        return float((squares / self.least).sum())

    def at_least(self, variance: RealArray) -> KnownNoise:
        """Return the noise with the variance of each channel raised to a given one."""
        return KnownNoise(least=np.maximum(self.least, variance))


def noise_of(values: RealArray) -> WhiteNoise:
    """Return the noise model of a record (channel, sample): not less than its resolution."""
    return WhiteNoise(least=resolution(values) ** 2)


def loss_growth(more: RealArray, count: int) -> RealArray:
    """Return by how much the loss rises where the residual energy of each channel grows by a share, (…).

    ``n sum_c log(1 + more_c)`` with ``more`` (channel, …): `WhiteNoise.loss` far above the least variance. The fall of
    the loss where a share s of the residual is explained is ``-loss_growth(-s, n)``.
    """
    return np.asarray(count * np.log1p(more).sum(axis=0))


def degrees_of_freedom(samples: int, *, amplitudes: int, poles: int, channels: int) -> float:
    """Return the degrees of freedom of the residual of one channel, at least 1.

    The real amplitudes are fitted in every channel; the real parameters of the poles are shared by all channels.
    """
    return max(samples - amplitudes - poles / channels, 1.0)
