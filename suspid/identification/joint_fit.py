"""Fit common poles to several decays by maximum likelihood, and test whether the decays agree on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.errors import IdentificationError
from suspid.identification.ascent import maximize
from suspid.identification.exponentials import Blocks
from suspid.identification.likelihood import DecayFit, evaluate
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.units import RealArray


def maximize_jointly(blocks: list[Blocks], start: list[Poles], noises: list[WhiteNoise]) -> list[DecayFit]:
    """Return the fits of all decays at the poles of greatest joint likelihood, by Gauss-Newton steps.

    The start is the same for all decays except for the nuisances. An `IdentificationError` says that the poles cannot
    be distinguished in one of the records.
    """
    found = _all_fits(blocks, start, noises)
    if found is None:
        raise IdentificationError("the shortest decay is too short to distinguish the poles; leave it out")
    fits, loss = found
    # From poles fitted over the common length, fewer than 10 steps are usual; 40 is a limit against cycling.
    for _ in range(40 if fits[0].poles.free else 0):
        information = np.sum([fit.information for fit in fits], axis=0)
        gradient = np.sum([fit.gradient for fit in fits], axis=0)
        scale = 1 / np.sqrt(np.maximum(information.diagonal(), 1e-300))
        step = scale * np.linalg.lstsq(information * np.outer(scale, scale), scale * gradient, rcond=1e-12)[0]
        # Steps below 3e-4 standard deviations do not matter.
        if float(step @ gradient) < 1e-7:
            break
        better = None
        for halving in range(12):
            better = _all_fits(blocks, [fit.poles.moved(step * 0.5**halving) for fit in fits], noises)
            if better is not None and better[1] <= loss + 1e-13 * sum(b.count for b in blocks):
                break
            better = None
        if better is None:
            break
        fits, loss = better
    return fits


def _all_fits(
    blocks: list[Blocks], poles: list[Poles], noises: list[WhiteNoise]
) -> tuple[list[DecayFit], float] | None:
    """Return the fits of all decays at given poles and the sum of their losses, or None if one fails.

    A pair that has crossed the real axis is none.
    """
    if np.any(poles[0].pairs.imag <= 0):
        return None
    fits: list[DecayFit] = []
    for block, own, noise in zip(blocks, poles, noises, strict=True):
        fit = evaluate(block, own, noise)
        if fit is None:
            return None
        fits.append(fit)
    return fits, sum(noise.loss(fit.squares, fit.count) for fit, noise in zip(fits, noises, strict=True))


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
    held : tuple of int
        The repeats that hold the mode, from 0 on.
    odd : int or None
        The repeat without which the others agree best; None if fewer than three hold the mode.
    without_odd : float
        Chi-square of the others [1].
    """

    chi_square: float
    freedom: int
    probability: float
    widening: float
    held: tuple[int, ...] = ()
    odd: int | None = None
    without_odd: float = float("nan")


def agreement(blocks: list[Blocks], fits: list[DecayFit], noises: list[WhiteNoise], index: int) -> Agreement:
    """Return how well the repeats agree on a pole, each fitted alone with the same number of poles."""
    pairs = len(fits[0].poles.pairs)
    rows = [2 * index, 2 * index + 1] if index < pairs else [pairs + index]
    found, informations, held = [], [], list[int]()
    for number, (block, joint, noise) in enumerate(zip(blocks, fits, noises, strict=True)):
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
            held.append(number)
    return agreement_of(found, informations, held)


def agreement_of(found: list[RealArray], informations: list[RealArray], held: list[int]) -> Agreement:
    """Return how well poles agree, each with its real and imaginary part and their information, of decays by number."""
    from scipy.special import chdtrc

    if len(found) < 2:
        return Agreement(chi_square=0.0, freedom=0, probability=float("nan"), widening=1.0, held=tuple(held))
    chi_square = _distance(found, informations)
    without = [
        _distance(found[:k] + found[k + 1 :], informations[:k] + informations[k + 1 :]) for k in range(len(held))
    ]
    odd = int(np.argmin(without)) if len(held) > 2 else None
    freedom = int(np.linalg.matrix_rank(np.sum(informations, axis=0))) * (len(found) - 1)
    probability = float(chdtrc(freedom, chi_square))
    # Level of the test: decays that agree are called different with probability 0.01. A larger one widens more
    # intervals that are right.
    return Agreement(
        chi_square=chi_square,
        freedom=freedom,
        probability=probability,
        widening=chi_square / freedom if probability < 0.01 else 1.0,
        held=tuple(held),
        odd=None if odd is None else held[odd],
        without_odd=float("nan") if odd is None else without[odd],
    )


def _distance(found: list[RealArray], informations: list[RealArray]) -> float:
    """Return the sum of the squared distances of poles from their mean, weighted by information."""
    weighted = np.sum([i @ p for i, p in zip(informations, found, strict=True)], axis=0)
    mean = np.linalg.pinv(np.sum(informations, axis=0)) @ weighted
    return float(sum((p - mean) @ i @ (p - mean) for i, p in zip(informations, found, strict=True)))
