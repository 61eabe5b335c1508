"""How much of a stretch damped exponentials could follow at best: a quick look before any fit."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

# So many exponentials over so many blocks, from lagged copies of the channels.
ORDER, MOST_BLOCKS = 20, 300
# Directions of the exponentials that are smaller than this are none.
INDEPENDENT = 1e-10
# A channel is driven where more than this share of its motion is left over, root mean square, and what is left is no
# white noise, by its correlation from block to block.
LEFT, COLOURED = 0.2, 0.3


def clearly_driven(values: RealArray, *, size: int) -> bool:
    """Return whether not even many exponentials follow half the channels of a stretch, from its first sample on.

    The shift of the signal subspace (ESPRIT) gives more exponentials than a decay has; those that grow are turned
    into decaying ones. A free decay is followed to its noise, in all channels that take part; what is driven is not.

    Parameters
    ----------
    values : ndarray (channel, sample)
        The stretch.
    size : int
        Samples per block, see `suspid.decays.trials.block_size`.

    Examples
    --------
    >>> time, rng = np.arange(600), np.random.default_rng(1)
    >>> decay = np.exp(-0.01 * time) * np.cos(0.3 * time) + 0.1 * rng.standard_normal((2, 600))
    >>> clearly_driven(decay, size=1)
    False
    >>> from scipy.signal import lfilter
    >>> rolling = lfilter([1.0], [1.0, -1.85, 0.94], rng.standard_normal((2, 600)))
    >>> clearly_driven(rolling, size=1)
    True
    """
    count = min(values.shape[1] // size, MOST_BLOCKS)
    means = values[:, : count * size].reshape(len(values), count, size).mean(axis=2)
    left, motion = _left(means - means.mean(axis=1, keepdims=True))
    power = np.sum(left**2, axis=1)
    share = np.sqrt(power / np.maximum(np.sum(motion**2, axis=1), 1e-300))
    together = np.abs(np.sum(left[:, 1:] * left[:, :-1], axis=1)) / np.maximum(power, 1e-300)
    return bool(np.sum((together > COLOURED) & (share > LEFT)) >= 0.5 * len(values))


def _left(about: RealArray) -> tuple[RealArray, RealArray]:
    """Return what exponentials leave of the first third of blocks, and that third, (channel, block)."""
    channels, count = about.shape
    scaled = about / np.maximum(np.sqrt(np.mean(about**2, axis=1, keepdims=True)), 1e-300)
    rows = min(count // 3, 10 + 2 * ORDER // channels)
    lagged = np.concatenate([scaled[:, lag : lag + count - rows] for lag in range(rows + 1)])
    space = np.linalg.svd(lagged, full_matrices=False)[0][:, :ORDER]
    turn = np.linalg.lstsq(space[:-channels], space[channels:], rcond=None)[0]
    poles = np.linalg.eigvals(turn)
    size = np.maximum(np.abs(poles), 1e-12)
    poles = np.where(size > 1, poles / size**2, poles)
    powers = np.column_stack([poles ** np.arange(count)[:, None], np.ones(count)])
    basis, weights, _ = np.linalg.svd(np.column_stack([powers.real, powers.imag]), full_matrices=False)
    basis = basis[:, weights > INDEPENDENT * weights[0]]
    early = max(1, count // 3)
    return (scaled.T - basis @ (basis.T @ scaled.T))[:early].T, scaled[:, :early]
