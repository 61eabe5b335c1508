"""Noise that channels share."""

from __future__ import annotations

import numpy as np

from suspid.identification.exponentials import inner_products
from suspid.identification.noise.colour import correlated
from suspid.identification.noise.quantisation import ABOVE_RESOLUTION
from suspid.units import RealArray


def shared_noise(residual: RealArray, resolution: RealArray | float = 0.0) -> float:
    """Return the factor by which noise that channels share widens variances: 1 where they share none.

    The fit treats the noise of the channels as independent. If their correlation matrix is R, no variance is larger
    than that of independent noise times the largest eigenvalue of R: twice for a channel that is given twice. Channels
    in which nothing but rounding is left, of standard deviation ``resolution``, share none.

    Examples
    --------
    >>> noise = np.random.default_rng(1).standard_normal((2, 1000))
    >>> shared_noise(noise), round(shared_noise(noise[[0, 0]]), 6)
    (1.0, 2.0)
    """
    size = np.sqrt(inner_products(residual, residual) / residual.shape[1])
    above = size > ABOVE_RESOLUTION * resolution
    together = noise_correlation(residual if above.all() else residual[above])
    apart = together[~np.eye(len(together), dtype=bool)]
    # Chance passes 6 standard deviations with probability 2e-9. A correlation below 0.2 does not matter: it would widen
    # variances by a fifth.
    if not np.any(correlated(apart, residual.shape[1], sigmas=6.0) & (np.abs(apart) > 0.2)):
        return 1.0
    return float(np.linalg.eigvalsh(together)[-1])


def noise_correlation(residual: RealArray) -> RealArray:
    """Return the correlation of the residuals of the channels with each other, (channel, channel)."""
    together = residual @ residual.T
    norm = np.sqrt(together.diagonal())
    norm = np.where(norm > 0, norm, 1.0)
    together = together / norm[:, None] / norm
    np.fill_diagonal(together, 1.0)
    return np.asarray(together)


def most_shared(residual: RealArray) -> tuple[int, int, float]:
    """Return the two channels whose noise is most correlated, and their correlation (without its sign)."""
    together = np.abs(noise_correlation(residual) - np.eye(len(residual)))
    # Rounding makes one of the two places of a pair the larger.
    one, other = sorted(map(int, np.unravel_index(int(np.argmax(together)), together.shape)))
    return one, other, float(together[one, other])
