"""Gain of a further pair close to each fitted one: a screen of places around it, without a refit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.exponentials import power_sums, project
from suspid.identification.fitting import Fit
from suspid.identification.likelihood import DecayFit
from suspid.identification.poles import Poles
from suspid.levels import EXACT
from suspid.units import ComplexArray, RealArray

# Where a further pair is tried: this far from a fitted one, in its decay rates, in as many directions. Between them
# a refit finds the way; more places cost time.
RADII, AROUND = (0.5, 1.0), 8
# Size of the arrays of places that are tried at once. Larger ones take more memory and save no time.
AT_ONCE = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Neighbours:
    """The best place for a further pair close to each fitted one."""

    gains: RealArray  # (pair,): what it promises in twice the log likelihood; -inf where there is no place
    theta: ComplexArray  # (pair,): exponent per sample


def neighbours(fit: Fit) -> Neighbours:
    """Return for each pair what a further one close to it promises, and where.

    All amplitudes and all poles answer to the further one by a Gauss-Newton step.
    """
    pairs = fit.poles.pairs
    turns = np.exp(2j * np.pi * np.arange(AROUND) / AROUND)
    theta = pairs[:, None] + np.abs(pairs.real)[:, None] * np.outer(RADII, turns).ravel()
    usable = (theta.imag > 0) & (theta.real < 0)
    gains = np.full(theta.shape, -np.inf)
    if usable.any():
        tried = theta[usable]
        parts = -(-len(tried) * len(fit.poles) ** 2 // AT_ONCE)
        gains[usable] = np.concatenate([_promised(fit, part) for part in np.array_split(tried, parts)])
    best = np.argmax(gains, axis=1) if len(pairs) else np.zeros(0, int)
    one = np.arange(len(pairs))
    return Neighbours(gains=gains[one, best], theta=theta[one, best])


def _promised(fit: Fit, theta: ComplexArray) -> RealArray:
    """Return the gains of a further pair at each of some places, (place,)."""
    solution, variance = fit.solution, fit.variance
    poles, count = solution.poles, solution.count
    pairs = len(poles.pairs)
    known = poles.exponents
    twins = np.concatenate([np.arange(pairs) + pairs, np.arange(pairs), np.arange(2 * pairs, len(known))])
    # The pair (x, its conjugate): inner products with the exponentials, and with their derivatives, (place, e, 2).
    zeroth, first = power_sums(known.conj()[:, None] + theta, count)[:2].transpose(0, 2, 1)
    zeroth = np.stack([zeroth, zeroth[:, twins].conj()], axis=-1)
    first = np.stack([first, first[:, twins].conj()], axis=-1)
    own, crossed = power_sums(np.concatenate([2 * theta.real + 0j, 2 * theta]), count)[0].reshape(2, -1)
    products = np.stack([np.stack([own, crossed.conj()], axis=-1), np.stack([crossed, own], axis=-1)], axis=1)
    # What is left of it beside the exponentials.
    fixed = np.linalg.solve(solution.gram, zeroth)
    products = products - zeroth.conj().swapaxes(1, 2) @ fixed
    first = first - solution.tilt @ fixed
    inverse = np.linalg.inv(products)
    left = project(fit.residual, theta)[0]
    left = np.stack([left, left.conj()], axis=1)
    amounts = inverse @ left
    gains = np.einsum("pic,pic,c->p", left.conj(), amounts, 1 / variance).real
    answer, slope = _answers(solution, variance, first, inverse, amounts)
    return np.asarray(gains + np.einsum("pi,pi->p", slope, np.linalg.solve(answer, slope[..., None])[..., 0]))


def _answers(
    solution: DecayFit, variance: RealArray, first: ComplexArray, inverse: ComplexArray, amounts: ComplexArray
) -> tuple[RealArray, RealArray]:
    """Return information and gradient of the fitted poles beside each further pair, (place, parameter, …)."""
    amplitudes = solution.amplitudes
    weights = (amplitudes.conj() / variance) @ amplitudes.T
    curvature = (solution.sharpness - first @ inverse @ first.conj().swapaxes(1, 2)) * weights
    half = _by_parameters(curvature, solution.poles)
    information = _by_parameters(half.conj().swapaxes(1, 2), solution.poles).real * solution.count**2
    pulled = np.einsum("pec,ec->pe", first @ amounts, amplitudes.conj() / variance)
    slope = solution.gradient - _by_parameters(pulled.conj(), solution.poles).real * solution.count
    # Far below the largest, information is rounding.
    scale = np.einsum("pii->pi", information).clip(1e-300)
    return information + EXACT * scale[:, :, None] * np.eye(len(slope.T)), slope


def _by_parameters(by_exponents: ComplexArray, poles: Poles) -> ComplexArray:
    """Return a quantity by the real parameters of poles, (…, parameter), from one by their exponents: `Poles.chart`."""
    pairs = len(poles.pairs)
    upper, lower = by_exponents[..., :pairs], by_exponents[..., pairs : 2 * pairs]
    both = np.stack([upper + lower, 1j * (upper - lower)], axis=-1)
    reals = by_exponents[..., 2 * pairs : 2 * pairs + len(poles.reals)]
    return np.concatenate([both.reshape(*both.shape[:-2], 2 * pairs), reals], axis=-1)
