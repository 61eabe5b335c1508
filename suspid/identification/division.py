"""Test whether one fitted pair represents two close poles: a screen, and two starting poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.candidates import CANDIDATES_TRIED, Candidate
from suspid.identification.covariance import widened
from suspid.identification.exponentials import power_sums, project
from suspid.identification.fitting import BENT, Fit, Problem
from suspid.identification.neighbours import neighbours
from suspid.identification.noise import shared_noise
from suspid.identification.poles import Poles
from suspid.identification.refinement import Rejected
from suspid.levels import EXACT, LEVEL, UNLIKELY
from suspid.units import ComplexArray, RealArray
from suspid.words import Reason, Remark


def divided(problem: Problem, fit: Fit) -> Fit | None:
    """Return the fit with one pair divided in two of different shapes, None if none decreases BIC."""
    penalty = problem.penalty(real=False)
    promised = apart(fit)
    for which in np.argsort(-promised.gains, kind="stable")[:CANDIDATES_TRIED].tolist():
        if promised.gains[which] < penalty:
            break
        trial = problem.fitted(promised.with_two(which))
        if trial is not None and fit.loss - trial.loss > penalty and not trial.splits.any():
            return trial
    return None


def unresolved(problem: Problem, fit: Fit) -> tuple[RealArray, NDArray[np.bool_], Rejected]:
    """Return by how much the variances of each pair are widened where one more may be close to it, (pair,), and those.

    Between them, whether the residual of each pair bends beyond chance, (pair,).

    Where a further pair close to one of them gains more than chance gives to any of them at `LEVEL`, though not enough
    for a mode, the record leaves open whether there is one. Then the intervals of all pairs hold what the fit with one
    more says of them, with its own uncertainty; its poles are matched to the pairs. The variances are widened by 0
    where each pair suffices. A further pair is named where its gain is significant at `UNLIKELY`.
    """
    from scipy.special import chdtri

    pairs, penalty = len(fit.poles.pairs), problem.penalty(real=False)
    freedom = 2 + 2 * problem.blocks.channels
    needed = float(chdtri(freedom, UNLIKELY))
    # Noise that is not white, or that channels share, gives more by chance.
    loud = fit.beside[:pairs] * shared_noise(fit.residual, np.sqrt(problem.noise.least))
    leaves_open = loud * float(chdtri(freedom, (1 - LEVEL) / max(pairs, 1)))
    widening, partners = np.zeros(pairs), list[tuple[Candidate, Remark]]()
    promised, beside = apart(fit), neighbours(fit)
    bends = promised.gains > needed
    leaves_open[bends] = np.minimum(leaves_open[bends], needed)
    for which in np.flatnonzero(bends | (beside.gains > leaves_open)).tolist():
        pole = fit.poles.pairs[which]
        both = np.array([pole, beside.theta[which]])
        trial = problem.fitted(promised.with_two(which) if bends[which] else fit.poles.with_two(which, both))
        if trial is None:
            continue
        trial = problem.from_samples(problem.settled(trial))
        # Which pole of the larger fit is which pair: on the way to the optimum they may have changed places.
        places, last = _matched(fit.poles.pairs, trial.poles.pairs)
        gain, two = fit.loss - trial.loss, trial.poles.pairs[[places[which], last]]
        near = np.abs(two - pole) < BENT * np.abs(pole.real)
        if not near.any() or gain <= leaves_open[which]:
            continue
        # Wherever the other lies, the neighbours of a weak mode that is left out bend.
        widening = np.maximum(widening, widened(fit.solution, trial.solution, places))
        known = any(abs(two[1] - c.theta) < abs(two[1].real) for c, _ in partners)
        if gain > needed and (near.all() or not (known or gain > penalty)):
            reason = Reason.UNRESOLVED if near.all() else Reason.TOO_WEAK
            remark = Remark(reason, {"gain": gain, "needed": penalty})
            partners.append((Candidate(theta=complex(two[1]), real=False, gain=gain), remark))
    return widening, bends, tuple(partners)


def _matched(pairs: ComplexArray, more: ComplexArray) -> tuple[NDArray[np.intp], int]:
    """Return the place of each pair among one more, all of them as near as can be in decay rates; and the one left."""
    from scipy.optimize import linear_sum_assignment

    distances = np.abs(pairs[:, None] - more) / np.maximum(np.abs(pairs.real), 1e-300)[:, None]
    places = linear_sum_assignment(distances)[1]
    return places, int(np.setdiff1d(np.arange(len(more)), places)[0])


def apart(fit: Fit) -> Apart:
    """Return for each pair what a second pole close to it promises in twice the log likelihood.

    Two poles ``p + u`` and ``p + v`` with amplitudes d and e are ``(a + b t + c t^2 + …) exp(p t)``, with
    ``a = d + e``, ``b = d u + e v``, ``2 c = d u^2 + e v^2``. The promise is the energy of b and c at fixed poles over
    the noise.
    """
    pairs, count = len(fit.poles.pairs), fit.residual.shape[1]
    solution, theta = fit.solution, fit.poles.pairs
    if not pairs:
        return Apart(fit=fit, gains=np.zeros(0), bends=np.zeros((0, 4, len(fit.variance)), complex), changes=[])
    # What bends a pair and its conjugate: their products with time and its square, over the record.
    own = np.stack([np.arange(pairs), pairs + np.arange(pairs)], axis=1)
    crossed = np.moveaxis(np.concatenate([solution.tilt[:, own], solution.bend[:, own]], axis=2), 1, 0)
    fixed = np.linalg.solve(solution.gram, crossed)
    products = _bend_products(theta, count)
    beside = products - crossed.conj().swapaxes(1, 2) @ fixed
    _, first, second = project(fit.residual, theta, orders=3)
    amounts = np.stack([first, first.conj(), second, second.conj()], axis=1)
    # Directions that rounding of the inner products leaves open promise nothing.
    scale = 1 / np.sqrt(np.einsum("pii->pi", products).real)
    values, vectors = np.linalg.eigh(beside * (scale[:, :, None] * scale[:, None, :]))
    least = max(EXACT, 10 * float(np.max(solution.rounding / fit.problem.blocks.energy)))
    inverse = np.where(values > least, 1 / np.maximum(values, least), 0.0)
    turned = vectors.conj().swapaxes(1, 2) @ (scale[:, :, None] * amounts)
    bends = scale[:, :, None] * (vectors @ (inverse[:, :, None] * turned))
    gains = np.sum(inverse[:, :, None] * np.abs(turned) ** 2 / fit.variance, axis=(1, 2))
    return Apart(fit=fit, gains=gains, bends=bends, changes=[-fixed[k][k] @ bends[k] for k in range(pairs)])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Apart:
    """What a second pole close to each pair promises."""

    fit: Fit
    gains: RealArray  # (pair,): in twice the log likelihood
    bends: ComplexArray  # (pair, 4, channel): amplitudes of t and t^2 times the pair and its conjugate
    changes: list[ComplexArray]  # (channel,) for each pair: change of its amplitude

    def two(self, which: int) -> ComplexArray:
        """Return two poles to start from in place of one: ``2 c = (u + v) b - u v a`` in every channel."""
        std = np.sqrt(self.fit.variance)
        a = self.fit.solution.amplitudes[which] + self.changes[which]
        b, c = self.bends[which, 0], self.bends[which, 2]
        total, product = np.linalg.lstsq(np.stack([b, -a], axis=1) / std[:, None], 2 * c / std, rcond=1e-6)[0]
        roots = np.roots([1.0, -total, product]) / self.fit.residual.shape[1]
        return np.asarray(self.fit.poles.pairs[which] + roots, complex)

    def with_two(self, which: int) -> Poles:
        """Return the poles with two pairs in place of one, within bounds."""
        both = self.fit.poles.with_two(which, self.two(which))
        return both.moved_within(np.zeros(both.free), self.fit.residual.shape[1])


def _bend_products(theta: ComplexArray, count: int) -> ComplexArray:
    """Return the inner products of t and t^2 times each pair and its conjugate, (pair, 4, 4), t over the record."""
    pairs = len(theta)
    sums = power_sums(np.concatenate([2 * theta.real + 0j, 2 * theta.conj()]), count, order=4)
    same, crossed = (np.array(sums)[2:, part] for part in (slice(pairs), slice(pairs, None)))
    out = np.empty((pairs, 2, 2, 2, 2), complex)
    for one, other in np.ndindex(2, 2):
        out[:, one, 0, other, 0] = out[:, one, 1, other, 1] = same[one + other]
        out[:, one, 0, other, 1], out[:, one, 1, other, 0] = crossed[one + other], crossed[one + other].conj()
    return out.reshape(pairs, 4, 4)
