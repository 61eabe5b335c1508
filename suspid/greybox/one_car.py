"""Whether several records are of one car: what a car of its own would leave of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.fits import Fit
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
# Relative difference from a joint value beyond which it is that of none of the cars: more than load and temperature do.
MOST_APART = 0.1
# Relative difference below which a value is that of one car: steps of simulations and rounding of samples move it by
# 1e-8 to 1e-5, the load and temperature of a car that stays the same by 1e-3.
LEAST_OTHER_CAR = 1e-4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Alone:
    """A record that is fitted alone."""

    x: RealArray
    gain: float  # of twice the log likelihood
    goes: Ratio  # share of the power of the residual of a channel that goes, where most does
    white: bool  # whether noise is left


def not_one_car_in_time(
    problem: Problem, x: RealArray, noise: Sequence[RealArray], errors: Sequence[OutputError]
) -> tuple[Check, ...]:
    """Return what speaks against one car in all records, given their fit.

    A gain that is no chance counts where cars of their own leave white noise; colour raises it too.
    """
    if len(problem.trials) < 2:
        return ()
    found = [_alone(problem, i, x, noise[i], error) for i, error in enumerate(errors)]
    chi_square, freedom = sum(one.gain for one in found), (len(found) - 1) * len(x)
    each = all(one.white for one in found)
    differ = max(one.goes for one in found) > MOST_GOES
    if likely(chi_square, freedom) or not (differ or each):
        return ()
    worst = int(np.argmax([one.goes for one in found]))
    own, (_, slope) = found[worst].x, problem.compressed(errors[worst], noise[worst])
    # Of the unknowns that differ the one that moves the record most.
    moved = int(np.argmax(np.abs(own - x) * np.linalg.norm(slope, axis=0)))
    change = _change(own[moved], x[moved])
    if change is not None and abs(change) < LEAST_OTHER_CAR:
        return ()
    numbers: dict[str, Number] = {
        "record": worst + 1,
        "share": found[worst].goes,
        "name": problem.unknowns.labels[moved],
        "change": change,
        "chi_square": chi_square,
        "freedom": freedom,
        "each": each,
    }
    return (Check(Remark(EstimateCheck.NOT_ONE_CAR, numbers), Level.DOUBTFUL if differ else Level.CARE),)


def not_one_car_in_drives(joint: Fit, alone: Mapping[int, Fit], labels: Sequence[str]) -> tuple[Check, ...]:
    """Return what fits of the records of each logger, by the number of its first record, say against one car in all.

    ``sum (x_i - m)^T C_i^-1 (x_i - m)`` with the weighted mean m is a chi-square, of as many degrees of freedom as
    there are unknowns of the car in all fits but one.
    """
    if len(alone) < 2:
        return ()
    n, fits = len(labels), list(alone.values())
    x = np.array([fit.x[:n] for fit in fits])
    weights = np.array([np.linalg.pinv(fit.covariance[:n, :n], hermitian=True) for fit in fits])
    mean = np.linalg.pinv(weights.sum(axis=0), hermitian=True) @ np.einsum("kij,kj->i", weights, x)
    chi_square = float(np.einsum("ki,kij,kj->", x - mean, weights, x - mean))
    freedom = (len(fits) - 1) * n
    if likely(chi_square, freedom):
        return ()
    std = np.sqrt([np.diag(fit.covariance)[:n] for fit in fits])
    sizes = np.abs(x - joint.x[:n]) / np.where(std > 0, std, np.inf)
    worst, moved = (int(i) for i in np.unravel_index(int(np.argmax(sizes)), sizes.shape))
    change = _change(x[worst, moved], joint.x[moved])
    numbers: dict[str, Number] = {
        "record": list(alone)[worst] + 1,
        "name": labels[moved],
        "change": change,
        "chi_square": chi_square,
        "freedom": freedom,
        "each": all(fit.explains for fit in fits),
    }
    level = Level.CARE if change is not None and abs(change) <= MOST_APART else Level.DOUBTFUL
    return (Check(Remark(EstimateCheck.NOT_ONE_CAR, numbers), level),)


def _change(own: float, joint: float) -> float | None:
    """Return the relative change from a joint value; None from a damper that is zero there."""
    return float(own / joint - 1) if joint else None


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
