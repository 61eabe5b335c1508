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


def halfway(decay: float, count: int) -> int:
    """Return the sample before which half of the information on a pole lies, for a decay rate per sample.

    The information of sample k goes as ``k^2 exp(-2 decay k)``.
    """
    k = np.arange(count)
    information = np.cumsum(k**2.0 * np.exp(-2 * decay * k))
    return int(np.searchsorted(information, information[-1] / 2))


def disagreement(values: RealArray, poles: Poles, which: int, noise_std: RealArray) -> float:
    """Return the distance of a pair in the two halves of the decay over its standard deviation.

    It is the root mean square of real and imaginary part, NaN where a half does not determine the pair. The poles are
    fitted to the whole record; ``noise_std`` is that of each channel.
    """
    decay = max(0.0, -float(poles.pairs[which].real))
    cut = halfway(decay, values.shape[1])
    found, variance = [], []
    for part in (values[:, :cut], values[:, cut:]):
        if part.shape[1] < FEWEST_SAMPLES:
            return float("nan")
        blocks = blocks_of(part - part.mean(axis=1, keepdims=True))
        fit = maximize(blocks, poles, WhiteNoise(least=noise_std**2).rounded(blocks.energy, blocks.count), steps=12)
        # A fit that leads further off than the decay rate, or knows it no better than to a third, is not of this pair.
        if fit is None or abs(fit.poles.pairs[which] - poles.pairs[which]) >= decay:
            return float("nan")
        try:
            spread = np.linalg.inv(fit.information).diagonal()[2 * which : 2 * which + 2]
        except np.linalg.LinAlgError:
            return float("nan")
        if not np.all((spread > 0) & (spread < (decay / 3) ** 2)):
            return float("nan")
        found.append(fit.poles.pairs[which])
        variance.append(spread)
    apart = found[0] - found[1]
    return float(np.sqrt(np.mean(np.array([apart.real, apart.imag]) ** 2 / (variance[0] + variance[1]))))
