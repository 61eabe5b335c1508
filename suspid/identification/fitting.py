"""Intermediate fits of pole selection: each with its residual, loss and the gain of each pole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from suspid.identification.ascent import Evaluated, maximize, settled
from suspid.identification.classification import MOST_DECAY
from suspid.identification.exponentials import Blocks, inner_products, synthesize
from suspid.identification.likelihood import DecayFit, bic_penalty, evaluate, evaluate_samples
from suspid.identification.noise import KnownNoise, WhiteNoise, loss_growth, loudness, over_channels, power_near
from suspid.identification.poles import Poles
from suspid.identification.shapes import same_shape, within_shapes
from suspid.units import ComplexArray, Ratio, RealArray

# Power near a pole over that of white noise from which on the gain of the pole is divided by it. The mean of 8
# independent exponential variables exceeds it with probability 9 %.
COLOUR_BEGINS = 1.5
# Poles nearer than this, in linewidths (geometric mean of the two decay rates) and in the ratio of their natural
# frequencies, may be one mode that is not quite linear: friction and nonlinear springs bend a mode by less.
BENT, OTHER_FREQUENCY = 2.0, 1.35
# Relative rounding error of the residual energy above which it is summed over samples: the weights of the channels
# follow from it, and the poles from those, to about as many standard deviations. Records of up to this many samples,
# and fits of up to this many exponents, go by samples then; more cost time, with the square of the exponents.
ROUNDED, MOST_BY_SAMPLES, MOST_EXPONENTS = 1e-8, 20_000, 25
# The same until all poles are found. Beyond it, which pole is added next would follow from rounding; less costs time.
ROUNDED_ROUGHLY = 1e-4
# A refit regains at most this many times what a Gauss-Newton step promises. A lower number may take another order of
# removal; a higher one costs refits.
MISJUDGED = 3.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Problem:
    """A record to fit."""

    values: RealArray  # (channel, sample): the record less its mean
    blocks: Blocks  # the record cut into blocks
    noise: WhiteNoise  # the noise model

    @property
    def _inner_noise(self) -> WhiteNoise:
        """The noise model with the rounding of differences of energies."""
        return self.noise.rounded(self.blocks.energy, self.blocks.count, of_energies=True)

    def fitted(self, start: Poles | DecayFit, *, rough: bool = False) -> Fit | None:
        """Return the fit of greatest likelihood near given poles, or None if they are linearly dependent."""
        evaluated = self._closely(ROUNDED_ROUGHLY if rough else ROUNDED)
        if isinstance(start, DecayFit) and self._few(start.poles) and _coarse(start, ROUNDED):
            start = start.poles
        if rough:
            # Until all poles are found, they are fitted to a twentieth of their standard deviations, in at most 20
            # steps: a pole that exists comes near in fewer. A smaller share costs time.
            solution = maximize(self.blocks, start, self.noise, steps=20, negligible=0.05**2, evaluated=evaluated)
        else:
            solution = maximize(self.blocks, start, self.noise, evaluated=evaluated)
        return None if solution is None else Fit(problem=self, solution=solution)

    def settled(self, fit: Fit) -> Fit:
        """Return the fit after the last steps, which move its poles by shares of a standard deviation."""
        closely, start = self._closely(ROUNDED, fit), fit.solution
        solution = closely(fit.poles) if _coarse(start, ROUNDED) else start
        solution = solution and settled(solution, closely)
        return fit if solution is None or solution is fit.solution else Fit(problem=self, solution=solution)

    def from_samples(self, fit: Fit) -> Fit:
        """Return the fit with what a Gauss-Newton step needs from samples, where they are few enough.

        Where poles nearly coincide, the information is a difference of nearly equal numbers.
        """
        solution = evaluate_samples(self.values, fit.poles, self.noise) if self._few(fit.poles) else None
        return fit if solution is None else Fit(problem=self, solution=solution)

    def _closely(self, limit: float, near: Fit | None = None) -> Evaluated:
        """Return what evaluates fits: few by their samples where the rounding of energies is beyond a limit.

        Of more than `MOST_BY_SAMPLES`, those near a given fit have its weights: those from differences of energies
        would move the poles by their rounding.
        """
        noise = self._inner_noise
        if self.blocks.count > MOST_BY_SAMPLES and near is not None and _coarse(near.solution, limit):
            noise = KnownNoise(least=near.variance)

        def evaluated(poles: Poles) -> DecayFit | None:
            solution = evaluate(self.blocks, poles, noise)
            if self._few(poles) and (solution is None or _coarse(solution, limit)):
                return evaluate_samples(self.values, poles, self.noise)
            return solution

        return evaluated

    def _few(self, poles: Poles) -> bool:
        """Return whether samples and exponents are few enough for a fit from samples."""
        return self.blocks.count <= MOST_BY_SAMPLES and len(poles) <= MOST_EXPONENTS

    def polished(self, fit: Fit) -> Fit:
        """Return the fit after further steps, or itself if it has converged."""
        better = self.fitted(fit.solution)
        return fit if better is None or better.solution is fit.solution else better

    def worths(self, fit: Fit) -> tuple[RealArray, RealArray]:
        """Return the cost of leaving each pole out while the others stay: in twice the log likelihood, and in energy.

        At fixed poles the sum of squares grows by ``a^H (G^-1)^-1 a`` with a the amplitudes left out and G^-1
        their block of the inverse Gram matrix. The energy is in units of the noise variance.
        """
        solution, count, pairs = fit.solution, self.blocks.count, len(fit.poles.pairs)
        inverse = solution.inverse_gram
        # The blocks of conjugate exponents are [[a, b], [b*, a]], and so are their inverses.
        first = np.arange(pairs)
        a, b = inverse[first, first].real, inverse[first, first + pairs]
        squared, crossed = np.abs(solution.amplitudes[:pairs]) ** 2, solution.amplitudes[:pairs] ** 2
        of_pairs = 2 * (a[:, None] * squared - (b[:, None] * crossed.conj()).real) / (a**2 - np.abs(b) ** 2)[:, None]
        real = fit.poles.rows[pairs:]
        of_reals = np.abs(solution.amplitudes[real]) ** 2 / inverse[real, real].real[:, None]
        more = np.concatenate([of_pairs, of_reals]) / (count * fit.variance)
        return loss_growth(np.maximum(more, 0.0).T, count), count * more.sum(axis=1)

    def gains(self, fit: Fit, *, fixed: RealArray | None = None, known: Mapping[int, float] | None = None) -> RealArray:
        """Return the gain of each pole in twice the log likelihood, (pole,); some may be ``known``.

        Where a pole costs little at ``fixed`` poles (by default `worths`), the others are refitted without it.
        """
        gains = self.worths(fit)[0] if fixed is None else fixed.copy()
        for index in np.flatnonzero(self.weak(fit, gains)).tolist():
            if known is not None and index in known:
                gains[index] = known[index]
                continue
            refitted = self.without(fit, index)
            gains[index] = gains[index] if refitted is None else refitted.loss - fit.loss
        return gains

    def weak(self, fit: Fit, gains: RealArray) -> NDArray[np.bool_]:
        """Return whether each pole costs so little at fixed poles that the others are refitted without it, (pole,)."""
        return np.asarray(gains < 3 * self.penalties(fit.poles))

    def without(self, fit: Fit, index: int) -> Fit | None:
        """Return the fit of the other poles, refitted, or None if they are linearly dependent."""
        return self.fitted(fit.poles.without(index), rough=True)

    def regained(self, fit: Fit, index: int) -> float:
        """Return what the other poles may regain by a refit without one of them, in twice the log likelihood.

        It is `MISJUDGED` times what a Gauss-Newton step promises, or infinite where there is none.
        """
        others = fit.poles.without(index)
        if not others.free:
            return 0.0
        trial = evaluate(self.blocks, others, self._inner_noise)
        diagonal = np.zeros(1) if trial is None else trial.information.diagonal()
        if trial is None or not (np.isfinite(trial.information.sum()) and np.all(diagonal > 0)):
            return np.inf
        # Far below the largest, the information of a pole is rounding.
        scale = np.sqrt(np.maximum(diagonal, 1e-12 * np.max(diagonal)))
        slope = trial.gradient / scale
        unit = trial.information / (scale[:, None] * scale)
        return float(MISJUDGED * slope @ np.linalg.lstsq(unit, slope, rcond=1e-9)[0])

    def penalty(self, *, real: bool) -> float:
        """Return the BIC penalty of a pair or a real pole."""
        return bic_penalty(self.blocks.channels, self.blocks.channels * self.blocks.count, real=real)

    def penalties(self, poles: Poles) -> RealArray:
        """Return the BIC penalty of every free pole, (pole,)."""
        pairs, reals = self.penalty(real=False), self.penalty(real=True)
        return np.array([pairs] * len(poles.pairs) + [reals] * len(poles.reals))


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A fit and its residual, each quantity computed when first asked for."""

    problem: Problem  # the record
    solution: DecayFit  # poles and amplitudes

    @property
    def poles(self) -> Poles:
        """The poles."""
        return self.solution.poles

    @cached_property
    def residual(self) -> RealArray:
        """The record less the fitted motion, (channel, sample)."""
        motion = synthesize(self.poles.exponents, self.solution.amplitudes, self.problem.blocks.count)
        return np.subtract(self.problem.values, motion, out=motion)

    @cached_property
    def squares(self) -> RealArray:
        """Residual sum of squares, from the samples, (channel,)."""
        return inner_products(self.residual, self.residual)

    @cached_property
    def variance(self) -> RealArray:
        """Variance of the residual, at least the least of the noise, (channel,)."""
        return self.problem.noise.variance(self.squares, self.problem.blocks.count)

    @cached_property
    def loss(self) -> float:
        """Minus twice the log likelihood less a constant."""
        return self.problem.noise.loss(self.squares, self.problem.blocks.count)

    @property
    def explained(self) -> Ratio:
        """Share of the energy of the best channel that is fitted."""
        return 1 - float(np.min(self.squares / np.maximum(self.problem.blocks.energy, 1e-300)))

    @cached_property
    def splits(self) -> NDArray[np.bool_]:
        """Whether each pole is part of another mode: near to it and of the same shape, (pole,)."""
        every = self.poles.every
        wn = np.log(np.abs(every) + 1e-300)
        apart = linewidths_apart(every)
        apart[np.abs(wn[:, None] - wn) > np.log(OTHER_FREQUENCY)] = np.inf
        # What has gone within a few samples is no mode, whether one or two.
        apart[-every.real > MOST_DECAY] = np.inf
        split, nearest = np.zeros(len(every), bool), np.argmin(apart, axis=1) if len(every) else np.zeros(0, int)
        near = np.flatnonzero(np.min(apart, axis=1, initial=np.inf) < BENT).tolist()
        # Of two that are next to each other, each is the other's nearest.
        for one, other in sorted({tuple(sorted((one, int(nearest[one])))) for one in near}):
            if not (split[one] and split[other]):
                split[[one, other]] |= self._is_one_mode(one, other, nearest)
        return split

    def _is_one_mode(self, one: int, other: int, nearest: NDArray[np.intp]) -> bool:
        """Return whether two poles, of which one is the nearest of the other, could be one mode."""
        colour = max(self.beside[one], self.beside[other])
        if not same_shape(self.solution, one, other, colour=colour):
            return False
        mine, third = (one, nearest[other]) if nearest[other] != one else (other, nearest[one])
        # Of a pole that has a nearer one, a shape of its own is hardly known: the plane of both is.
        pair = (one + other - mine, int(third))
        return third == mine or within_shapes(self.solution, mine, pair, colour=colour)

    @cached_property
    def loudness(self) -> RealArray:
        """Power of the residual near each pole over that of the noise, (pole,); 1 where they agree."""
        return loudness(self.residual, self.variance, self.poles.every, beside=self._power_near, weights=self._weights)

    @cached_property
    def beside(self) -> RealArray:
        """Power of the residual near each pole over that of the noise, (pole,)."""
        ratio = over_channels(self._power_near, self._weights)
        return np.where(ratio > COLOUR_BEGINS, ratio, 1.0)

    @cached_property
    def _power_near(self) -> RealArray:
        return power_near(self.residual, self.variance, self.poles.every)

    @property
    def _weights(self) -> RealArray:
        amplitudes = self.solution.amplitudes[self.poles.rows]
        return np.asarray(np.abs(amplitudes).T ** 2 / self.variance[:, None] + 1e-300)


def _coarse(solution: DecayFit, limit: float) -> bool:
    """Return whether the rounding error of the energy that a fit leaves is beyond a share of it in any channel."""
    return bool((solution.rounding > limit * solution.squares).any())


def linewidths_apart(every: ComplexArray) -> RealArray:
    """Return the distances of poles in linewidths, geometric means of the two decay rates; inf on the diagonal."""
    decay = every.real
    linewidth = np.sqrt(np.maximum(decay[:, None] * decay, 1e-24))
    apart = np.abs(every[:, None] - every) / linewidth
    np.fill_diagonal(apart, np.inf)
    return np.asarray(apart)
