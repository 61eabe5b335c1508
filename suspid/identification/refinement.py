"""Changes of the set of fitted poles, once all are found: removal, drift, and real poles against pairs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from suspid.identification.candidates import Candidate
from suspid.identification.classification import LEAST_EXPLAINED
from suspid.identification.fitting import Fit, Problem
from suspid.identification.noise import LOUD
from suspid.identification.poles import Poles
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import Reason, Remark

Rejected: TypeAlias = tuple[tuple[Candidate, Remark], ...]

# Where the residual near a pole is louder than `noise.LOUD`, the model is wrong by more than the noise. There the
# energy of a pole must exceed its BIC penalty this many times the loudness. A lower value splits modes that friction
# bends; a higher one loses weak modes near strong ones.
WORTHWHILE = 20.0
# A pair whose damped frequency is below the first number times its decay rate is tried as two real poles. They begin at
# that rate times and over the second number; two real poles whose rates differ by less are tried as a pair. Higher
# numbers cost fits.
NEAR_REAL, APART = 0.3, 2.0
# At most this many times poles cross the axis after one was added. More cost fits.
MOST_CROSSINGS = 4


def thinned(problem: Problem, fit: Fit) -> tuple[Fit, RealArray, Rejected]:
    """Return the fit without insignificant poles, the worth of each remaining pole, and those removed.

    The least significant pole is removed and the others are refitted, until all are significant.
    """
    rejected: Rejected = ()
    bounds: dict[int, float] = {}
    while fit.poles.free:
        limits = _Limits.of(problem, fit, bounds)
        index, shorter = _weakest(problem, fit, limits)
        split = bool(fit.splits[index])
        leaves = split or limits.worth(index, limits.gains[index]) < 1
        shorter = shorter or (problem.without(fit, index) if leaves else None)
        if shorter is None or not leaves:
            return fit, problem.gains(fit, fixed=limits.gains, known=limits.refitted), rejected
        reason = Remark(Reason.SPLIT if split else Reason.NOT_NEEDED)
        if not split and limits.gains[index] >= limits.penalties[index]:
            times = limits.energies[index] / (limits.penalties[index] * limits.loud[index])
            reason = Remark(Reason.NOT_SIGNIFICANT, {"times": float(times), "needed": WORTHWHILE})
        rejected += ((_candidate(fit.poles, index, gain=float(limits.gains[index])), reason),)
        # Without one pole the others are needed no less than before, in units of a noise that is no smaller.
        quieter = float(np.min(fit.variance / shorter.variance))
        bounds |= {k: bound * quieter for k, bound in (bounds | limits.refitted).items()}
        bounds = {k - (k > index): bound for k, bound in bounds.items() if k != index}
        fit = shorter
    return fit, np.zeros(0), rejected


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Limits:
    """What each pole of a fit must be worth, and is."""

    gains: RealArray  # (pole,): what it costs to leave each out, in twice the log likelihood; refitted where known
    energies: RealArray  # (pole,): the same in energy over noise variance
    penalties: RealArray  # (pole,): BIC penalties
    beside: RealArray  # (pole,): power of the residual beside each over that of the noise
    bounds: Mapping[int, float]  # lower bounds of gains, from fits with more poles
    refitted: dict[int, float]  # gains for which the other poles were refitted

    @classmethod
    def of(cls, problem: Problem, fit: Fit, bounds: Mapping[int, float]) -> _Limits:
        gains, energies = problem.worths(fit)
        beside = fit.beside
        if fit.explained < LEAST_EXPLAINED:
            beside = np.maximum(beside, fit.loudness)
        penalties = problem.penalties(fit.poles)
        return cls(gains=gains, energies=energies, penalties=penalties, beside=beside, bounds=bounds, refitted={})

    @property
    def loud(self) -> RealArray:
        """Power of the residual near each pole where it is no noise, else 1, (pole,)."""
        return np.asarray(np.where(self.beside > LOUD, self.beside, 1.0))

    def worth(self, index: int, gain: float) -> float:
        """Return the gain of a pole over what is required."""
        beside = float(self.beside[index])
        # Where the residual is not noise, energy counts instead of likelihood. Coloured noise has its power there.
        worth = min(float(self.energies[index]) / (WORTHWHILE * beside), gain) if beside > LOUD else gain / beside
        return worth / float(self.penalties[index])


def _weakest(problem: Problem, fit: Fit, limits: _Limits) -> tuple[int, Fit | None]:
    """Return the pole of least gain, and the fit without it where the others were refitted.

    A gain in ``limits`` is then that of the refit. Poles far apart when they were added may have approached each other:
    the weaker of two goes first. Only where a pole could be the weakest, the others are refitted.
    """
    weak = problem.weak(fit, limits.gains)

    def lowest(index: int) -> float:
        """Return a lower bound of the worth of a pole."""
        if not weak[index]:
            return limits.worth(index, limits.gains[index])
        if index in limits.bounds:
            return limits.worth(index, limits.bounds[index])
        # The steps of two poles that are near each other promise nothing.
        return -np.inf if fit.splits[index] else limits.worth(index, limits.gains[index] - problem.regained(fit, index))

    candidates = np.flatnonzero(fit.splits) if fit.splits.any() else np.arange(len(limits.gains))
    least = {index: lowest(index) for index in candidates.tolist()}
    best, found, shorter = np.inf, -1, None
    for index in sorted(least, key=lambda index: least[index]):
        if least[index] >= best:
            break
        trial = problem.without(fit, index) if weak[index] else None
        if trial is not None:
            limits.gains[index] = limits.refitted[index] = trial.loss - fit.loss
        worth = limits.worth(index, limits.gains[index])
        if worth < best:
            best, found, shorter = worth, index, trial
    return found, shorter


def straightened(problem: Problem, fit: Fit, reach: float) -> tuple[Fit, Rejected]:
    """Return the fit with slow poles replaced by a parabola, if that fits as well, and the poles replaced.

    Poles are slow whose modulus over the record is below ``reach``.
    """
    count, poles = problem.blocks.count, fit.poles
    slow = np.flatnonzero(np.abs(poles.every) * count < reach)
    if not slow.size or len(poles.nuisances) > 1:
        return fit, ()
    for index in slow[::-1]:
        poles = poles.without(int(index))
    # Exponents over the record of the nuisances that replace slow poles: offset, slope and bend, to 1e-4 of a drift.
    trial = problem.fitted(
        Poles(pairs=poles.pairs, reals=poles.reals, nuisances=frozen_real([0.0, -0.3, 0.3]) / count), rough=True
    )
    if trial is None or trial.loss > fit.loss + problem.penalty(real=True):
        return fit, ()
    return trial, tuple((_candidate(fit.poles, int(i), gain=0.0), Remark(Reason.BENT)) for i in slow)


def unbent(problem: Problem, fit: Fit) -> Fit:
    """Return the fit with an offset instead of a parabola where slope and bend are not significant."""
    if len(fit.poles.nuisances) == 1:
        return fit
    trial = problem.fitted(Poles(pairs=fit.poles.pairs, reals=fit.poles.reals, nuisances=np.zeros(1)))
    return trial if trial is not None and trial.loss - fit.loss < 2 * problem.penalty(real=True) else fit


def single(problem: Problem, fit: Fit) -> Fit:
    """Return the fit with heavily damped pairs replaced by one real pole where BIC is lower for it."""
    saved = problem.penalty(real=False) - problem.penalty(real=True)
    index = 0
    while index < len(fit.poles.pairs):
        theta = fit.poles.pairs[index]
        if abs(theta.imag) < -theta.real:
            trial = problem.fitted(fit.poles.without(index).with_real(theta.real))
            if trial is not None and trial.loss - fit.loss < saved and not trial.poles.meet:
                fit, index = trial, 0
                continue
        index += 1
    return fit


def about_the_axis(problem: Problem, fit: Fit, least: float) -> Fit:
    """Return the fit with pairs near the real axis as two real poles, or two real poles as a pair, if that fits better.

    Two real poles that meet leave the axis as a pair, and a pair that meets it parts along it. Steps in frequency and
    decay rate do not lead over the axis. Poles whose modulus over the record is below ``least`` are left as they are: a
    drift does not tell.
    """
    for _ in range(MOST_CROSSINGS):
        for poles in _crossings(fit.poles, least / problem.blocks.count):
            trial = problem.fitted(poles, rough=True)
            # Two real poles that have met have no optimum: a pair is no worse.
            needed = 0.0 if fit.poles.meet and len(poles.pairs) > len(fit.poles.pairs) else problem.penalty(real=True)
            if trial is not None and fit.loss - trial.loss > needed:
                fit = trial
                break
        else:
            break
    return fit


def _crossings(poles: Poles, least: float) -> Iterator[Poles]:
    """Yield the poles with each pair near the axis parted, and with each two neighbours on it joined."""
    for index, theta in enumerate(poles.pairs):
        if abs(theta.imag) < NEAR_REAL * -theta.real and abs(theta) >= least:
            yield poles.without(index).with_real(APART * theta.real).with_real(theta.real / APART)
    pairs, order = len(poles.pairs), np.argsort(poles.reals)
    for one, other in pairwise(order.tolist()):
        slow, fast = -poles.reals[other], -poles.reals[one]
        if least <= slow and fast < APART * slow:
            middle = (slow + fast) / 2
            rest = poles.without(pairs + max(one, other)).without(pairs + min(one, other))
            yield rest.with_pair(complex(-middle, middle / APART))


def paired(problem: Problem, fit: Fit) -> tuple[Fit, RealArray]:
    """Return the fit with real poles replaced by pairs where those fit better, and what a pair gains at the others."""
    # Least gain per parameter, between AIC (2) and BIC (about 8): a real pole is not simpler a priori, since a pair of
    # large damping is usual in a car.
    enough = 3.5 * (1 + problem.blocks.channels)
    index, extra = 0, list[float]()
    while index < len(fit.poles.reals):
        theta = fit.poles.reals[index]
        pair = fit.poles.without(len(fit.poles.pairs) + index).with_pair(theta + 0.7j * abs(theta))
        trial = problem.fitted(pair)
        more = -np.inf if trial is None else fit.loss - trial.loss
        if trial is not None and more > enough:
            fit, index, extra = trial, 0, []
            continue
        extra.append(more)
        index += 1
    return fit, np.array(extra)


def _candidate(poles: Poles, index: int, *, gain: float) -> Candidate:
    return Candidate(theta=complex(poles.every[index]), real=index >= len(poles.pairs), gain=gain)
