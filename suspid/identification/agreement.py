"""Agreement of several decays on a mode: a chi-square test of their poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.exponentials import Blocks
from suspid.identification.likelihood import DecayFit, maximize
from suspid.identification.noise import WhiteNoise

# Level of the test: decays that agree are called different with this probability. A larger value widens more intervals
# that are right.
DISAGREE = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Agreement:
    """How well the repeats agree on one mode.

    Parameters
    ----------
    chi_square : float
        Sum over the repeats of the squared distance of their poles from the mean weighted by their information, in
        the metric of their own covariances [1].
    freedom : int
        Degrees of freedom: two less than two for each repeat that holds the mode.
    probability : float
        Of a chi-square as large by chance [1]; NaN if fewer than two repeats hold the mode.
    widening : float
        Factor by which the variances of the mode were widened for it [1]: chi-square over degrees of freedom where
        the probability is below 1 %, else 1.
    """

    chi_square: float
    freedom: int
    probability: float
    widening: float


def agreement(blocks: list[Blocks], fits: list[DecayFit], noises: list[WhiteNoise], index: int) -> Agreement:
    """Return how well the repeats agree on a pole, each fitted alone with the same number of poles."""
    from scipy.special import chdtrc

    pairs = len(fits[0].poles.pairs)
    rows = [2 * index, 2 * index + 1] if index < pairs else [pairs + index]
    found, informations = [], []
    for block, joint, noise in zip(blocks, fits, noises, strict=True):
        own = maximize(block, joint, noise, steps=20)
        if own is None:
            continue
        try:
            covariance = np.linalg.inv(own.information)[np.ix_(rows, rows)] * (own.count / own.freedom)
            information = np.linalg.inv(covariance)
        except np.linalg.LinAlgError:
            continue
        before, after = (
            fit.poles.pairs[index] if index < pairs else fit.poles.reals[index - pairs] for fit in (joint, own)
        )
        decay = abs(complex(before).real)
        # A repeat that does not know the decay rate to a third, or leads elsewhere, does not hold the mode.
        if abs(after - before) < decay and np.all(
            (covariance.diagonal() > 0) & (covariance.diagonal() < (decay / 3) ** 2)
        ):
            found.append(np.array([complex(after).real, complex(after).imag])[: len(rows)])
            informations.append(information)
    if len(found) < 2:
        return Agreement(chi_square=0.0, freedom=0, probability=float("nan"), widening=1.0)
    mean = np.linalg.solve(
        np.sum(informations, axis=0), np.sum([i @ p for i, p in zip(informations, found, strict=True)], axis=0)
    )
    chi_square = float(sum((p - mean) @ i @ (p - mean) for i, p in zip(informations, found, strict=True)))
    freedom = len(rows) * (len(found) - 1)
    probability = float(chdtrc(freedom, chi_square))
    return Agreement(
        chi_square=chi_square,
        freedom=freedom,
        probability=probability,
        widening=chi_square / freedom if probability < DISAGREE else 1.0,
    )
