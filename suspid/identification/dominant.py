"""Poles that most of a record follows, although no sum of modes explains it down to the noise."""

from __future__ import annotations

import numpy as np

from suspid.identification.candidates import CANDIDATES_TRIED, Candidate, ranked, searched
from suspid.identification.classification import reasons_of
from suspid.identification.exponentials import blocks_of
from suspid.identification.fitting import OTHER_FREQUENCY, Fit, Problem
from suspid.identification.likelihood import evaluate, reweighed
from suspid.identification.noise import WhiteNoise
from suspid.identification.poles import Poles
from suspid.identification.refinement import WORTHWHILE
from suspid.identification.selection import Selection
from suspid.units import RealArray
from suspid.words import Reason, Remark

# Each pole explains at least this many times the energy that all leave (mean over channels). Random walks reach it too,
# but do not fall as a decay does.
CLEAR = 9.0
# Least fall in the record, and largest fall in a cycle [neper]: it makes two cycles or more. A pulse of force falls
# faster, a random walk by less.
LEAST_NEPERS, MOST_A_CYCLE = 2.0, 1.0
# Poles at most.
MOST_CLEAR = 3


def dominant(
    values: RealArray, *, noise: WhiteNoise, band: tuple[float, float], selection: Selection
) -> Selection | None:
    """Return the few poles that most of a record follows, None if there are none.

    A nonlinear decay leaves a residual near its poles that no pole stands out of, see `refinement.WORTHWHILE`. Its
    frequency and damping are still seen where it falls over some cycles and little else moves. The ``selection`` has
    the poles that were rejected. The values are the record less its mean.
    """
    blocks = blocks_of(values)
    problem = Problem(values=values, blocks=blocks, noise=noise.rounded(blocks.energy, blocks.count))
    offset = evaluate(
        blocks, Poles(pairs=np.zeros(0, complex), reals=np.zeros(0), nuisances=np.zeros(1)), problem.noise
    )
    assert offset is not None
    fit: Fit | None = Fit(problem=problem, solution=offset)
    best = None
    for _ in range(MOST_CLEAR):
        fit = None if fit is None else _extended(problem, fit)
        if fit is not None and _clear(problem, fit):
            best = problem.polished(fit)
    if best is None:
        return None
    solution = reweighed(best.solution, problem.noise, best.squares)
    reasons = reasons_of(solution, band, best.loudness, best.explained)
    if any(reason is not None for reason in reasons):
        return None
    poles = len(best.poles.pairs)
    beside = np.maximum(best.beside, best.loudness)
    times = problem.worths(best)[1] / (problem.penalty(real=False) * beside)
    kept = tuple(
        (
            Candidate(theta=complex(theta), real=False, gain=float(gain)),
            Remark(Reason.FOLLOWED, {"times": float(gain), "needed": WORTHWHILE}),
        )
        for theta, gain in zip(best.poles.pairs, times, strict=True)
    )
    return Selection(
        fit=solution,
        reasons=reasons,
        gains=problem.gains(best),
        loudness=best.loudness,
        residual=best.residual,
        widening=np.zeros(poles),
        bends=np.ones(poles, bool),
        rejected=kept + selection.rejected,
    )


def _extended(problem: Problem, fit: Fit) -> Fit | None:
    """Return the best fit with one more pair."""
    found = ranked(fit.solution, fit.variance, searched(fit.solution, fit.residual, fit.variance))
    pairs = [candidate.theta for candidate in found if not candidate.real][:CANDIDATES_TRIED]
    trials = [problem.fitted(fit.poles.with_pair(theta), rough=True) for theta in pairs]
    return min((trial for trial in trials if trial is not None), key=lambda trial: trial.loss, default=None)


def _clear(problem: Problem, fit: Fit) -> bool:
    """Return whether each pole is a mode of its own that falls over some cycles, and explains far more than all leave.

    Two poles near each other follow one mode that changes.
    """
    pairs, count = fit.poles.pairs, problem.blocks.count
    fall, cycles = -pairs.real, pairs.imag / (2 * np.pi)
    falls = (fall * count > LEAST_NEPERS) & (fall < MOST_A_CYCLE * cycles)
    ratio = problem.worths(fit)[1] / (count * problem.blocks.channels)
    near = np.diff(np.log(np.sort(np.abs(pairs)))) < np.log(OTHER_FREQUENCY)
    return bool(np.all(falls & (ratio > CLEAR)) and not np.any(near))
