"""Whether several records are of one car: what a car of its own would leave of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.further import FurtherUnknowns
from suspid.greybox.problem import Problem
from suspid.greybox.responses import OutputError
from suspid.greybox.search import descended
from suspid.greybox.whiteness import portmanteau
from suspid.levels import likely
from suspid.units import Ratio, RealArray
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck

# Share of the power of a residual that goes with a car of its own, from which on the records are not of one car. Noise
# and what the car lacks in all records stay; k that differ by 1 % leave a tenth at 40 dB.
MOST_GOES = 0.5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Alone:
    """A record that is fitted alone."""

    x: RealArray
    gain: float  # of twice the log likelihood
    goes: Ratio  # share of the power of the residual of a channel that goes, where most does
    white: bool  # whether noise is left


def one_car(problem: Problem, x: RealArray, noise: Sequence[RealArray], errors: Sequence[OutputError]) -> Check | None:
    """Return what speaks against one car in all records, given their fit; None where nothing does.

    A gain that is no chance counts where cars of their own leave white noise; colour raises it too.
    """
    count = len(problem.trials)
    if count < 2:
        return None
    found = [_alone(problem, i, x, noise[i], error) for i, error in enumerate(errors)]
    chi_square, freedom = sum(one.gain for one in found), (count - 1) * len(x)
    each = all(one.white for one in found)
    differ = max(one.goes for one in found) > MOST_GOES
    if likely(chi_square, freedom) or not (differ or each):
        return None
    worst = int(np.argmax([one.goes for one in found]))
    own, (_, slope) = found[worst].x, problem.compressed(errors[worst], noise[worst])
    # Of the unknowns that differ the one that moves the record most.
    moved = int(np.argmax(np.abs(own - x) * np.linalg.norm(slope, axis=0)))
    numbers: dict[str, Number] = {
        "record": worst + 1,
        "share": found[worst].goes,
        "name": problem.unknowns.labels[moved],
        "change": float(own[moved] / x[moved] - 1),
        "chi_square": chi_square,
        "freedom": freedom,
        "each": each,
    }
    return Check(Remark(EstimateCheck.NOT_ONE_CAR, numbers), Level.DOUBTFUL if differ else Level.CARE)


def _alone(problem: Problem, i: int, x: RealArray, noise: RealArray, error: OutputError) -> _Alone:
    """Return the fit of one record alone, from that of all."""
    u = problem.unknowns
    if isinstance(u, FurtherUnknowns):
        here, elsewhere = 0, -1
        gains, delays = (
            tuple((here if owner == i else elsewhere, channel) for owner, channel in places)
            for places in (u.gains, u.delays)
        )
        u = replace(u, gains=gains, delays=delays)
    single = replace(problem, trials=(problem.trials[i],), holds=(problem.holds[i],), unknowns=u)
    (level,) = single.noise(x, [noise])
    end = descended(single, x, [level])
    (own,) = single.errors(end.x, end.noise, slopes=False)
    statistics, lags = portmanteau(own.residual)
    before, after = np.sum(error.residual**2, axis=1), np.sum(own.residual**2, axis=1)
    return _Alone(
        x=end.x,
        gain=single.loss([level]) - single.loss(end.noise),
        white=all(likely(float(statistic), lags) for statistic in statistics),
        goes=float(np.max(1 - after / np.where(before > 0, before, 1.0), initial=0.0, where=before > 0)),
    )
