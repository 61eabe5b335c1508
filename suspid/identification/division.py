"""Whether one fitted pair stands for two poles close together: a screen, and two poles to start from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.identification.candidates import CANDIDATES_TRIED, Candidate
from suspid.identification.fitting import BENT, Fit, Problem
from suspid.identification.poles import Poles
from suspid.identification.refinement import Rejected
from suspid.levels import UNLIKELY
from suspid.units import ComplexArray, RealArray
from suspid.words import Reason, Remark

# E-foldings after which a pair has gone: its samples to 1e-4.
GONE = 9.0


def divided(problem: Problem, fit: Fit) -> Fit | None:
    """Return the fit with one pair divided in two of different shapes, None if none decreases BIC."""
    penalty = problem.penalty(real=False)
    promised = apart(fit)
    for which in sorted(range(len(promised)), key=lambda k: -promised[k][0])[:CANDIDATES_TRIED]:
        gain, poles = promised[which]
        if gain < penalty:
            break
        trial = problem.fitted(with_two(fit.poles, which, poles))
        if trial is not None and fit.loss - trial.loss > penalty and not trial.splits.any():
            return trial
    return None


def unresolved(problem: Problem, fit: Fit) -> tuple[ComplexArray, NDArray[np.bool_], Rejected]:
    """Return how far each pair lies from the nearer of two that fit better in its place, (pair,), and their partners.

    Between them, whether the residual of each pair bends beyond chance, (pair,).

    The gain of the two is significant at `UNLIKELY`, though not enough for two modes: the record leaves it open. The
    distance is 0 where one pair suffices.
    """
    from scipy.special import chdtri

    channels = problem.blocks.channels
    needed = float(chdtri(2 + 2 * channels, UNLIKELY))
    shifts, partners = np.zeros(len(fit.poles.pairs), complex), list[tuple[Candidate, Remark]]()
    promises = apart(fit)
    bends = np.array([promise > needed for promise, _ in promises], bool)
    for which, (pole, (_, start)) in enumerate(zip(fit.poles.pairs, promises, strict=True)):
        if not bends[which]:
            continue
        trial = problem.fitted(with_two(fit.poles, which, start))
        if trial is None:
            continue
        two, gain = trial.poles.pairs[-2:], fit.loss - trial.loss
        near = np.abs(two - pole) < BENT * np.abs(pole.real)
        if near.all() and gain > needed:
            nearer, other = two[np.argsort(np.abs(two - pole))]
            shifts[which] = nearer - pole
            numbers = {"gain": gain, "needed": problem.penalty(real=False)}
            partners.append(
                (Candidate(theta=complex(other), real=False, gain=gain), Remark(Reason.UNRESOLVED, numbers))
            )
    return shifts, bends, tuple(partners)


def with_two(poles: Poles, which: int, two: ComplexArray) -> Poles:
    """Return the poles with two pairs in place of one."""
    pairs = np.append(np.delete(poles.pairs, which), two.real + 1j * np.abs(two.imag))
    return Poles(pairs=pairs, reals=poles.reals, nuisances=poles.nuisances)


def apart(fit: Fit) -> list[tuple[float, ComplexArray]]:
    """Return for each pair what a second pole beside it promises in twice the log likelihood, and two in its place.

    Two poles ``p + u`` and ``p + v`` with amplitudes d and e are ``(a + b t + c t^2 + …) exp(p t)``, with
    ``a = d + e``, ``b = d u + e v``, ``2 c = d u^2 + e v^2``, hence ``2 c = (u + v) b - u v a`` in every channel: u
    and v by least squares. The promise is the energy of b and c at fixed poles over the noise.
    """
    pairs, samples = fit.poles.pairs, fit.residual.shape[1]
    counts = np.minimum(samples, np.ceil(GONE / np.maximum(-pairs.real, GONE / samples))).astype(int)
    known = _columns(np.concatenate([pairs, fit.poles.reals, fit.poles.nuisances]), samples)
    # Pairs that are seen over the same samples share a factorization of the columns at fixed poles.
    fixed = {count: np.linalg.qr(known[:count]) for count in np.unique(counts).tolist()}
    return [_divided(fit, which, known[: counts[which]], *fixed[counts[which]]) for which in range(len(pairs))]


def _divided(
    fit: Fit, which: int, known: RealArray, basis: RealArray, triangle: RealArray
) -> tuple[float, ComplexArray]:
    """Return promise and two poles for one pair, from the columns at fixed poles and their factors."""
    pole, count = complex(fit.poles.pairs[which]), len(known)
    step = np.arange(count)[:, None] / count
    own, left = known[:, 2 * which : 2 * which + 2], fit.residual[:, :count].T
    bend = np.concatenate([own * step, own * step**2], axis=1)
    if count < known.shape[1] + bend.shape[1]:
        return 0.0, np.full(2, pole)
    inside = basis.T @ bend
    beside = bend - basis @ inside
    # Once more: what is left of nearly dependent columns is not yet orthogonal.
    beside -= basis @ (basis.T @ beside)
    bent, corner = np.linalg.qr(beside)
    amounts = bent.T @ left
    gain = float(np.sum(amounts**2 / fit.variance))
    bends = np.linalg.lstsq(corner, amounts, rcond=1e-12)[0]
    changes = np.linalg.lstsq(triangle, basis.T @ left - inside @ bends, rcond=1e-12)[0]
    b, c = bends[[0, 2]] + 1j * bends[[1, 3]]
    a = 2 * fit.solution.amplitudes[which] + changes[2 * which] + 1j * changes[2 * which + 1]
    std = np.sqrt(fit.variance)
    total, product = np.linalg.lstsq(np.stack([b, -a], axis=1) / std[:, None], 2 * c / std, rcond=1e-6)[0]
    return gain, np.asarray(pole + np.roots([1.0, -total, product]) / count, complex)


def _columns(exponents: ComplexArray, count: int) -> RealArray:
    """Return real and minus imaginary parts of exponentials, one beside the other; of a real one the real part."""
    powers = np.exp(np.asarray(exponents, complex)[:, None] * np.arange(count))
    parts = np.stack([powers.real, -powers.imag], axis=1).reshape(-1, count)
    return np.asarray(parts[np.repeat(np.imag(exponents) != 0, 2) | (np.arange(len(parts)) % 2 == 0)].T, float)
