"""The disagreement of the two halves of a decay on a mode: about 1 if the decay is linear."""

from __future__ import annotations

import numpy as np

from suspid.identification.exponentials import blocks_of
from suspid.identification.likelihood import maximize
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.units import RealArray

# A record or half of one with fewer samples is not fitted.
FEWEST_SAMPLES = 32


def disagreement(values: RealArray, poles: Poles, which: int, noise_std: RealArray) -> float:
    """Return how far two halves of the decay disagree on a pair, see `Identification.halves`."""
    # What a sample says of the pole goes as k^2 exp(-2 decay k).
    decay, count = max(0.0, -float(poles.pairs[which].real)), values.shape[1]
    says = np.cumsum(np.arange(count) ** 2.0 * np.exp(-2 * decay * np.arange(count)))
    cut = int(np.searchsorted(says, says[-1] / 2))
    found, variance = [], []
    for part in (values[:, :cut], values[:, cut:]):
        if part.shape[1] < FEWEST_SAMPLES:
            return float("nan")
        blocks = blocks_of(part - part.mean(axis=1, keepdims=True))
        fit = maximize(blocks, poles, WhiteNoise(least=noise_std**2).rounded(blocks.energy, blocks.count), steps=12)
        try:
            spread = np.linalg.inv(fit.information).diagonal()[2 * which : 2 * which + 2] if fit else np.full(2, -1.0)
        except np.linalg.LinAlgError:
            return float("nan")
        # A part that does not know the decay rate to a third, or leads elsewhere, does not hold the mode.
        held = fit is not None and abs(fit.poles.pairs[which] - poles.pairs[which]) < decay
        if fit is None or not held or not np.all((spread > 0) & (spread < (decay / 3) ** 2)):
            return float("nan")
        found.append(fit.poles.pairs[which])
        variance.append(spread)
    apart = found[0] - found[1]
    return float(np.sqrt(np.mean(np.array([apart.real, apart.imag]) ** 2 / (variance[0] + variance[1]))))
