"""Search for the best fit from several starts, each along growing stretches of the records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.problem import Problem
from suspid.greybox.whiteness import correlations
from suspid.levels import CHI_SQUARE_95, NEGLIGIBLE_GAIN
from suspid.model import eigenmodes
from suspid.reconstruction import Unknowns, descend, even_starts
from suspid.units import RealArray

NOISE_ROUNDS = 30  # of fits and noise levels in turn; some 4 are needed, with exact records 10
LOOSE_NOMINAL = 0.5  # standard deviation of nominal values, in the logarithm, while a stretch is short
STRETCH_GROWTH = 3.0  # of the stretch, from one to the next: a mode then is off by less than half a cycle
# Share of a channel's power that is left, and correlation of neighbouring samples of what is left, from which on
# nothing of the channel is explained: more than half of it, and it is motion.
UNMOVED = 0.5
DENSE = 20.0  # samples in a cycle of the fastest mode, twice as many as tell its damping; more are for the noise alone
FIRST_CYCLES = 2.0  # of the fastest mode, in the first stretch
STARTS = 6  # at most
SAME_FIT = 1.0  # difference of minus twice the log likelihood up to which two fits count as one


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Found:
    """A minimum."""

    x: RealArray
    noise: tuple[RealArray, ...]  # by test, (channel,)
    loss: float
    lost: bool = False  # whether it explains nothing


def descended(problem: Problem, x: RealArray, noise: Sequence[RealArray], *, rounds: int = NOISE_ROUNDS) -> Found:
    """Return the most likely unknowns and noise levels near a start."""
    u, levels, lost = problem.unknowns, list(noise), False
    for _ in range(rounds):
        x = descend(
            lambda z, at=tuple(levels): problem.equations(z, at),  # type: ignore[misc]
            x, positive=u.positive, lower=u.lower, upper=u.upper, negligible=NEGLIGIBLE_GAIN,
        )  # fmt: skip
        before, levels = levels, problem.noise(x, levels)
        change = max(float(np.max(np.abs(np.log(a / b)))) for a, b in zip(levels, before, strict=True))
        lost = _unmoved(problem, x, levels)
        # Relative change of noise levels below which they have settled; where nothing is explained, none need to.
        if change < 1e-3 or lost:
            break
    prior = problem.unknowns.prior(x)[0]
    return Found(x=x, noise=tuple(levels), loss=problem.loss(levels) + float(prior @ prior), lost=lost)


def search(problem: Problem) -> tuple[Found, list[Found]]:
    """Return the best fit, and the ends of all starts.

    Of decays that are sampled densely few samples are searched; the ends are refined with all of them.
    """
    u = problem.unknowns
    searched = _thinned(problem)
    ends: list[Found] = []
    for start in starts_of(u):
        ends.append(_along(searched, start))
        best = min(ends, key=lambda end: end.loss)
        # Two starts that end in one place are enough, and two that lead nowhere.
        agreed = sum(end.loss < best.loss + SAME_FIT for end in ends)
        if max(agreed, len(ends) * all(end.lost for end in ends)) >= 2:
            break
    return (best, ends) if searched is problem else _refined(problem, best, ends)


def _thinned(problem: Problem) -> Problem:
    """Return the problem with every n-th sample of decays alone, where these are dense; known inputs need all."""
    u = problem.unknowns
    fastest = float(np.max(eigenmodes(u.suspension(u.nominal)).wn))
    steps = [int(2 * np.pi / (fastest * DENSE * trial.step)) for trial in problem.trials]
    if max(steps) < 2 or any(len(trial.inputs) for trial in problem.trials):
        return problem
    thin = tuple(
        replace(t, step=t.step * max(n, 1), values=t.values[:, :: max(n, 1)], inputs=t.inputs[:, :: max(n, 1)])
        for t, n in zip(problem.trials, steps, strict=True)
    )
    return replace(problem, trials=thin)


def _refined(problem: Problem, best: Found, ends: Sequence[Found]) -> tuple[Found, list[Found]]:
    """Return the best fit and all ends with all samples; those far from the best one stay as far as they are."""
    fine = [
        descended(problem, end.x, end.noise) if end is best or SAME_FIT <= end.loss - best.loss < CHI_SQUARE_95 else end
        for end in ends
    ]
    whole = fine[ends.index(best)]
    moved = [
        whole if end.loss < best.loss + SAME_FIT
        else one if one is not end
        else replace(end, loss=whole.loss + end.loss - best.loss)
        for end, one in zip(ends, fine, strict=True)
    ]  # fmt: skip
    return min(moved, key=lambda end: end.loss), moved


def starts_of(unknowns: Unknowns) -> list[RealArray]:
    """Return the nominal values, and a fixed sequence of points within a factor of about 1.5 of them."""
    u = unknowns
    spread = even_starts(u, STARTS - 1)
    nominal = np.where(u.positive, u.nominal, 1.0)
    near = np.where(u.positive, nominal * (spread / nominal) ** 0.12, 0.5 * (u.nominal + spread))
    return [u.nominal, *np.clip(near, u.lower, u.upper)]


def _along(problem: Problem, x: RealArray) -> Found:
    """Return the fit from one start: to the first cycles of the fastest mode, then to ever longer stretches."""
    u = problem.unknowns
    fastest = float(np.max(eigenmodes(u.suspension(x)).wn))
    longest = max(trial.count * trial.step for trial in problem.trials)
    length = FIRST_CYCLES * 2 * np.pi / fastest
    told = u.has_prior
    loose = np.where(u.positive, LOOSE_NOMINAL * u.nominal, LOOSE_NOMINAL * np.maximum(u.nominal, 0.1))
    guided = replace(u, prior_std=np.where(told, np.minimum(u.prior_std, loose), loose))
    while length < longest / STRETCH_GROWTH:
        cut = tuple(t.first(max(8, min(t.count, int(length / t.step)))) for t in problem.trials)
        stage = replace(problem, trials=cut, unknowns=guided)
        x = descended(stage, x, _first_noise(stage, x), rounds=3).x
        length *= STRETCH_GROWTH
    return descended(problem, x, _first_noise(problem, x))


def _unmoved(problem: Problem, x: RealArray, noise: Sequence[RealArray]) -> bool:
    """Return whether unknowns leave most channels nearly as they are, by a residual that is no noise."""
    power = [np.var(trial.values, axis=1) for trial in problem.trials]
    share = [
        std**2 / np.maximum(own, trial.noise.least)
        for std, own, trial in zip(noise, power, problem.trials, strict=True)
    ]
    if np.median(np.concatenate(share)) < UNMOVED:
        return False
    alike = [correlations(error.residual, 1)[:, 0] for error in problem.errors(x, noise, slopes=False)]
    return bool(np.median(np.concatenate(alike)) > UNMOVED)


def _first_noise(problem: Problem, x: RealArray) -> list[RealArray]:
    """Return the residual at a start, with channels weighted by their size, as noise."""
    size = [np.sqrt(np.maximum(np.mean(t.values**2, axis=1), t.noise.least)) for t in problem.trials]
    return problem.noise(x, size)
