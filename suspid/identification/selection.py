"""Selection of the poles: they are added while BIC decreases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.candidates import CANDIDATES_TRIED, Candidate, Points, ranked, searched
from suspid.identification.classification import ambiguous, reasons_of
from suspid.identification.division import divided, unresolved
from suspid.identification.exponentials import blocks_of, inner_products, project
from suspid.identification.fitting import OTHER_FREQUENCY, Fit, Problem, linewidths_apart
from suspid.identification.likelihood import DecayFit, evaluate, reweighed
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.identification.refinement import Rejected, about_the_axis, paired, single, straightened, thinned, unbent
from suspid.units import RealArray
from suspid.words import Reason, Remark

# The largest number of pairs: a bound on time and memory for records that no number of poles explains.
MOST_PAIRS = 50
# From `MANY_PAIRS` on, more are tried only while the first half of the residual has `DYING` times as much of what would
# decay as the second, read backwards, has. Coloured noise and driven motion, which pairs without end follow, have as
# much in both.
MANY_PAIRS, DYING = 16, 2.0
# With fewer samples to each unknown, the best of many candidates is large in the first half by choice: there the energy
# of the residual decides.
ROOM_FOR_CHOICE = 10
# Candidates whose gain is the first number times the BIC penalty and which lie the second number of linewidths apart
# are fitted together; this saves searches. They stay where each then gains `STRONG_GAIN` times the penalty. So strong a
# candidate is also accepted from the previous search.
TOGETHER_GAIN, TOGETHER_APART, STRONG_GAIN = 3.0, 4.0, 10.0
# Poles whose modulus over the record is below the first number are replaced by a parabola while poles are added; below
# the second number, when all are found.
STILL, CREEPING = 0.3, 3.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Selection:
    """The poles of a record."""

    fit: DecayFit  # all poles: modes, other motions and nuisances
    reasons: tuple[Reason | None, ...]  # why each free pole (pairs, then reals) is no mode; None for a mode
    # (pole,): its gain in twice the log likelihood: the loss without it, less the loss with it.
    gains: RealArray
    loudness: RealArray  # (pole,): power of the residual near each pole over that of the noise; 1 where they agree
    residual: RealArray  # (channel, sample): the record less the fitted motion
    # (pole,): factor of its variances by which its interval holds what a fit with one more pole says of it; 0 where the
    # record leaves no further pole open
    widening: RealArray
    bends: NDArray[np.bool_]  # (pole,): whether the residual shows beyond chance that each pair is not quite linear
    rejected: Rejected  # poles that were tried and not kept, and why

    @property
    def modes(self) -> NDArray[np.intp]:
        """Which of the free poles are modes, (mode,)."""
        return np.flatnonzero([reason is None for reason in self.reasons])

    @property
    def modes_by_wn(self) -> NDArray[np.intp]:
        """The modes by their natural frequency, as sets of modes have them, (mode,)."""
        kept = self.modes
        return kept[np.argsort(np.abs(self.fit.poles.every[kept]), kind="stable")]


def select(
    values: RealArray,
    *,
    noise: WhiteNoise,
    modes: int | None = None,
    band: tuple[float, float] = (0.0, np.pi),
    most: int | None = None,
    intervals: bool = True,
) -> Selection:
    """Return the poles of a record, added one after another while BIC decreases.

    The next pole is that of largest gain over a grid of frequency and decay rate, orthogonal to the poles
    fitted so far. Then all poles are refitted together. A pole stays if its gain exceeds its BIC penalty times the
    loudness of the residual near it.

    The values are the record less its mean. With a number of modes, the strongest are kept, and the record is fitted
    anew without what lies beside them. The band holds the angular frequencies per sample between which a pole can be a
    mode. The search ends with ``most`` pairs, by default `MOST_PAIRS`. Without ``intervals``
    none is widened, which saves a quarter of the time.
    """
    blocks = blocks_of(values)
    problem = Problem(values=values, blocks=blocks, noise=noise.rounded(blocks.energy, blocks.count))
    fit, rejected = _found(problem, most or MOST_PAIRS)
    fit, gains, pair_gains, lost = _refined(problem, fit)
    if modes is not None:
        fit, gains, dropped = _alone(problem, fit, gains, band, modes)
        pair_gains = pair_gains if not dropped else np.full(len(fit.poles.reals), -np.inf)
        lost += dropped
    fit = problem.settled(fit)
    # Sums of squares from samples are more accurate than differences of energies.
    solution = reweighed(fit.solution, problem.noise, fit.squares)
    pairs = len(solution.poles.pairs)
    widening, bends, open_ones = unresolved(problem, fit) if intervals else (np.zeros(pairs), np.zeros(pairs, bool), ())
    reasons = list(reasons_of(solution, band, fit.loudness, fit.explained))
    for index in pairs + np.flatnonzero(ambiguous(gains[pairs:], pair_gains, channels=blocks.channels)):
        reasons[index] = reasons[index] or Reason.REAL_OR_PAIR
    kept = [index for index in np.argsort(-gains) if reasons[index] is None]
    for index in kept[modes:] if modes is not None else []:
        reasons[index] = Reason.BEYOND
    return Selection(
        fit=solution,
        reasons=tuple(reasons),
        gains=gains,
        loudness=fit.loudness,
        residual=fit.residual,
        widening=np.concatenate([widening, np.zeros(len(fit.poles.reals))]),
        bends=np.concatenate([bends, np.zeros(len(fit.poles.reals), bool)]),
        rejected=rejected + lost + open_ones,
    )


def _alone(
    problem: Problem, fit: Fit, gains: RealArray, band: tuple[float, float], modes: int
) -> tuple[Fit, RealArray, Rejected]:
    """Return the fit without poles close to the strongest modes of their number, the gains, and the poles left out.

    Parts of a mode that is not quite linear, tones and drifts near a mode would bend it.
    """
    solution = reweighed(fit.solution, problem.noise, fit.squares)
    reasons = reasons_of(solution, band, fit.loudness, fit.explained)
    kept = [index for index in np.argsort(-gains) if reasons[index] is None][:modes]
    size = np.abs(fit.poles.every)
    beside = [
        index
        for index in range(len(fit.poles.pairs))
        if index not in kept and np.any(np.abs(np.log(size[index] / size[kept])) < np.log(OTHER_FREQUENCY))
    ]
    poles = fit.poles
    for index in reversed(beside):
        poles = poles.without(index)
    again = problem.fitted(poles) if beside else None
    if again is None:
        return fit, gains, ()
    remark = Remark(Reason.BEYOND)
    dropped = tuple(
        (Candidate(theta=complex(fit.poles.pairs[index]), real=False, gain=float(gains[index])), remark)
        for index in beside
    )
    return again, problem.gains(again), dropped


def _found(problem: Problem, most: int) -> tuple[Fit, Rejected]:
    """Return the fit with all poles that decrease BIC when added, and the candidates that do not."""
    none = Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1))
    offset = evaluate(problem.blocks, none, problem.noise)
    assert offset is not None
    fit, rejected = Fit(problem=problem, solution=offset), Rejected()
    seen: Points | None = None
    while _may_grow(fit, most) and np.any(fit.variance > problem.noise.least):
        # Points of the previous search may stand out now that stronger poles are fitted; if not, search anew.
        found = [] if seen is None else ranked(fit.solution, fit.variance, seen)
        again = bool(found) and found[0].gain > STRONG_GAIN * problem.penalty(real=False)
        if not again:
            seen = searched(fit.solution, fit.residual, fit.variance)
            found = ranked(fit.solution, fit.variance, seen)
        if fit.poles.free >= 2 * MANY_PAIRS and not _dies_away(problem, fit, found):
            break
        better, lost = _extended(problem, fit, found, most)
        rejected += lost
        better = divided(problem, fit) if better is None else better
        if better is None:
            break
        fit, lost = straightened(problem, about_the_axis(problem, better, CREEPING), STILL)
        rejected, seen = rejected + lost, None if again else seen
    return fit, rejected + (_beyond(problem, fit) if len(fit.poles.pairs) >= MOST_PAIRS else ())


def _beyond(problem: Problem, fit: Fit) -> Rejected:
    """Return the best of the candidates that would gain more than their penalty, where no more pairs are fitted."""
    found = ranked(fit.solution, fit.variance, searched(fit.solution, fit.residual, fit.variance))
    penalty = problem.penalty(real=False)
    best = next((c for c in found if not c.real and c.gain > penalty), None)
    if best is None:
        return ()
    return ((best, Remark(Reason.TOO_MANY, {"most": MOST_PAIRS, "gain": best.gain, "needed": penalty})),)


def _may_grow(fit: Fit, most: int) -> bool:
    """Return whether there may be more pairs: one must leave more samples than there are unknowns.

    As many are followed exactly, whatever they are.
    """
    channels, count = fit.residual.shape
    return _unknowns(fit) + 2 * (channels + 1) < channels * count and fit.poles.free < 2 * most


def _unknowns(fit: Fit) -> int:
    """Return the number of real parameters of poles and amplitudes."""
    return fit.poles.free + len(fit.residual) * len(fit.poles)


def _dies_away(problem: Problem, fit: Fit, found: Sequence[Candidate]) -> bool:
    """Return whether the residual dies away as those candidates do that would gain more than their penalty.

    A residual that does not has as much of them from its end backwards.
    """
    half = fit.residual.shape[1] // 2
    halves = (fit.residual[:, :half], fit.residual[:, : -half - 1 : -1])
    if fit.residual.size < ROOM_FOR_CHOICE * _unknowns(fit):
        first, second = (np.sum(inner_products(part, part) / fit.variance) for part in halves)
        return bool(first > DYING * second)
    likely = np.array([c.theta for c in found if c.gain > problem.penalty(real=False)])
    if not likely.size:
        return True
    # What lasts for a few samples is drowned by the noise of a half, unless late samples count less.
    first, second = (np.sum(np.abs(project(part, likely)[0]) ** 2 / fit.variance) for part in halves)
    return bool(first > DYING * second)


def _refined(problem: Problem, fit: Fit) -> tuple[Fit, RealArray, RealArray, Rejected]:
    """Return the fit after drifts, insignificant poles and doubtful pairs are settled.

    Also return the worth of each pole, what a pair would gain in place of each real pole, and the poles removed.
    """
    fit = problem.polished(fit)
    straight, rejected = straightened(problem, single(problem, fit), CREEPING)
    fit = unbent(problem, fit if straight is fit else problem.polished(straight))
    fit, gains, lost = thinned(problem, fit)
    fit, pair_gains = paired(problem, single(problem, problem.polished(fit)))
    if len(pair_gains) or len(gains) != len(fit.poles.every):
        gains = problem.gains(fit)
    return fit, gains, pair_gains, rejected + lost


def _extended(problem: Problem, fit: Fit, found: list[Candidate], most: int) -> tuple[Fit | None, Rejected]:
    """Return the fit with one more pole or several, None if no candidate decreases BIC; and those rejected."""
    together = _together(problem, fit, found, most)
    if together is not None:
        return together, ()
    rejected: Rejected = ()
    # Among many modes, broad poles stand for several at first: what is next to one of them is then no part of it.
    for candidate in found[: CANDIDATES_TRIED if fit.poles.free < 2 * MANY_PAIRS else None]:
        penalty = problem.penalty(real=candidate.real)
        # Refitting the other poles adds less than the rest. A lower share costs time.
        if candidate.gain < 0.7 * penalty:
            break
        theta, poles = candidate.theta, fit.poles
        trial = problem.fitted(poles.with_real(theta.real) if candidate.real else poles.with_pair(theta), rough=True)
        if trial is None:
            continue
        index = -1 if candidate.real else len(trial.poles.pairs) - 1
        if trial.splits[index]:
            trial = problem.polished(trial)
        gain = fit.loss - trial.loss
        if trial.splits[index]:
            near = float(linewidths_apart(trial.poles.every)[index].min())
            rejected += ((candidate, Remark(Reason.SPLIT, {"linewidths": near})),)
        elif gain > penalty:
            return trial, rejected
        else:
            rejected += ((candidate, Remark(Reason.TOO_WEAK, {"gain": gain, "needed": penalty})),)
    return None, rejected


def _together(problem: Problem, fit: Fit, found: list[Candidate], most: int) -> Fit | None:
    """Return the fit with several strong pairs that lie far apart, up to ``most``, or None if there are no two."""
    penalty = problem.penalty(real=False)
    strong = [c for c in found if not c.real and c.gain > TOGETHER_GAIN * penalty]
    reach = [TOGETHER_APART * (2 * abs(c.theta.real) + 2 * np.pi / problem.blocks.count) for c in strong]
    taken = [
        c.theta
        for i, c in enumerate(strong)
        if all(abs(c.theta.imag - strong[j].theta.imag) > max(reach[i], reach[j]) for j in range(i))
    ][: most - len(fit.poles.pairs)]
    if len(taken) < 2:
        return None
    while taken:
        poles = fit.poles
        for theta in taken:
            poles = poles.with_pair(theta)
        trial = problem.fitted(poles, rough=True)
        if trial is None:
            return None
        gains, _ = problem.worths(trial)
        added = slice(len(fit.poles.pairs), len(trial.poles.pairs))
        stays = (gains[added] > STRONG_GAIN * penalty) & ~trial.splits[added]
        if stays.all():
            return trial
        taken = [theta for theta, stay in zip(taken, stays, strict=True) if stay]
    return None
