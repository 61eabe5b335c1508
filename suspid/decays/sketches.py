"""Quick upper bound of how much of a stretch damped exponentials can explain."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

# Number of exponentials, more than a decay has. Fewer refuse decays of several modes; more follow driven motion too.
ORDER = 20
# First looks at a stretch go over this many blocks. More cost time; fewer do not tell driven motion from a decay.
LOOK_BLOCKS = 300
# A channel is driven if its residual exceeds this share of its motion, root mean square, and correlates by this much
# from block to block. Lower limits refuse noisy or slightly nonlinear decays.
LEFT, CORRELATED = 0.2, 0.3


def clearly_driven(values: RealArray, *, size: int) -> bool:
    """Return whether 20 damped exponentials fail to follow a stretch in at least half of its channels.

    The exponentials come from the shift of the signal subspace (ESPRIT); growing ones are reflected to decaying ones.
    They follow a free decay down to its noise in all channels, but not driven motion. The samples are averaged in
    blocks of ``size``, see `suspid.decays.trials.block_size`.

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
    count = min(values.shape[1] // size, LOOK_BLOCKS)
    means = values[:, : count * size].reshape(len(values), count, size).mean(axis=2)
    left, motion = _left(means - means.mean(axis=1, keepdims=True))
    power = np.sum(left**2, axis=1)
    share = np.sqrt(power / np.maximum(np.sum(motion**2, axis=1), 1e-300))
    together = np.abs(np.sum(left[:, 1:] * left[:, :-1], axis=1)) / np.maximum(power, 1e-300)
    return bool(np.sum((together > CORRELATED) & (share > LEFT)) >= 0.5 * len(values))


def _left(about: RealArray) -> tuple[RealArray, RealArray]:
    """Return the residual of the exponentials over the first third of the blocks, and that third, (channel, block)."""
    channels, count = about.shape
    scaled = about / np.maximum(np.sqrt(np.mean(about**2, axis=1, keepdims=True)), 1e-300)
    rows = min(count // 3, 10 + 2 * ORDER // channels)
    lagged = np.concatenate([scaled[:, lag : lag + count - rows] for lag in range(rows + 1)])
    # Products of lags lose half of the digits, which shows in no share that counts, and take half the time.
    space = np.linalg.eigh(lagged @ lagged.T)[1][:, -ORDER:]
    turn = np.linalg.lstsq(space[:-channels], space[channels:], rcond=None)[0]
    # Of a pair, either spans both real exponentials.
    poles = np.linalg.eigvals(turn)
    poles = poles[poles.imag >= 0]
    size = np.maximum(np.abs(poles), 1e-12)
    poles = np.where(size > 1, poles / size**2, poles)
    # Products are twenty times as fast as powers of complex numbers.
    powers = np.column_stack([np.vander(poles, count, increasing=True).T, np.ones(count)])
    basis, weights, _ = np.linalg.svd(np.column_stack([powers.real, powers.imag]), full_matrices=False)
    # Exponentials that are equal to rounding make no further direction.
    basis = basis[:, weights > 1e-10 * weights[0]]
    early = max(1, count // 3)
    return (scaled.T - basis @ (basis.T @ scaled.T))[:early].T, scaled[:, :early]
