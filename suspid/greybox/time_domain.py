"""Estimates in the time domain: free decays, and records of exactly known roads and forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from suspid.errors import ReconstructionError
from suspid.greybox.caused_residual import caused_share
from suspid.greybox.causes import dies_down
from suspid.greybox.fits import Fit
from suspid.greybox.identifiability import blind, check_determined, names_in, shares_of
from suspid.greybox.one_car import not_one_car_in_time
from suspid.greybox.problem import Problem
from suspid.greybox.responses import OutputError
from suspid.greybox.search import SAME_FIT, Found, descended, search
from suspid.greybox.trials import HOLDS, signal_of
from suspid.greybox.whiteness import portmanteau, score_power
from suspid.identification import ABOVE_RESOLUTION
from suspid.levels import CHI_SQUARE_95, likely
from suspid.model import ModalSet, Suspension, eigenmodes
from suspid.reconstruction import QUANTITIES, reconstruct
from suspid.units import Ratio, RealArray
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck

# Share of a channel's power beyond which a residual that is not white is no mere colour of the noise: 10 dB below it.
MOST_COLOURED = 0.1
# Share of a channel's motion (root mean square) that may be left of it and follow a known road or force. No noise does;
# sensors and inputs are known to a few hundredths.
MOST_CAUSED = 0.1
# Share of a channel's power below which a residual says nothing against a car: 1e-4 of the motion. Sensors are linear
# to 1e-3 at best; what is left of simulated motion is that inputs between samples are not known.
LEAST_SEEN = 1e-8


def fit_in_time(problem: Problem) -> Fit:
    """Return the most likely car of free decays and exactly known inputs.

    Raises
    ------
    EstimationError
        If the records do not determine a combination of the unknowns.
    """
    best, ends = search(problem)
    agreed = sum(end.loss < best.loss + SAME_FIT for end in ends)
    rivals = [end for end in ends if SAME_FIT <= end.loss - best.loss < CHI_SQUARE_95]
    asked = problem
    problem, best = _best_holds(problem, best)
    if problem is not asked:
        # Where inputs move otherwise between samples, every fit lies elsewhere.
        rivals = [descended(problem, end.x, end.noise) for end in rivals]
    others = _alternatives(problem, best, rivals)
    noise = problem.noise(best.x, best.noise, fair=True)
    errors = problem.errors(best.x, noise)
    u = problem.unknowns
    rows = [problem.compressed(error, std) for error, std in zip(errors, noise, strict=True)]
    data = np.concatenate([slope for _, slope in rows])
    size = u.sizes(best.x)
    prior = u.prior(best.x)[1]
    whole = np.concatenate([data, prior]) * size
    check_determined(
        whole, u.labels, u.suspension(best.x), relative=shares_of(size, best.x), hint=_perhaps_driven(problem)
    )
    chi_square, freedom, explains, judged = _judged(problem, errors, noise)
    checks = [*not_one_car_in_time(problem, best.x, noise, errors), judged]
    if len(prior) and len(blind(data * size)):
        checks.append(
            Check(Remark(EstimateCheck.BY_NOMINAL, {"names": names_in(blind(data * size), u.labels)}), Level.CARE)
        )
    if agreed < 2:
        numbers = {"count": agreed, "starts": len(ends)}
        checks.append(Check(Remark(EstimateCheck.ONE_START, numbers), Level.CARE))
    if others:
        checks.append(Check(Remark(EstimateCheck.ALTERNATIVES, {"count": len(others)}), Level.CARE))
    return Fit(
        x=best.x,
        covariance=_covariance(problem, errors, noise, prior),
        fitted=tuple(
            replace(signal_of(t), values=t.values - e.residual) for t, e in zip(problem.trials, errors, strict=True)
        ),
        residual=tuple(replace(signal_of(t), values=e.residual) for t, e in zip(problem.trials, errors, strict=True)),
        noise=tuple(noise),
        chi_square=chi_square,
        freedom=freedom,
        explains=explains,
        alternatives=tuple(u.suspension(other.x) for other in others),
        checks=tuple(checks),
        holds=problem.holds,
    )


def _best_holds(problem: Problem, best: Found) -> tuple[Problem, Found]:
    """Return the problem with inputs that move between samples as explains each record best, and its fit."""
    for i, trial in enumerate(problem.trials):
        for hold in HOLDS[1:] if np.any(np.ptp(trial.inputs, axis=1)) else ():
            tried = replace(problem, holds=(*problem.holds[:i], hold, *problem.holds[i + 1 :]))
            if _least(tried, best) > _least(problem, best):
                continue
            end = descended(tried, best.x, best.noise, rounds=2)
            if end.loss < best.loss:
                problem, best = tried, descended(tried, end.x, end.noise)
    return problem, best


def _least(problem: Problem, found: Found) -> float:
    """Return the squared residual that the best step from a fit would leave, to first order."""
    residual, slope = problem.equations(found.x, found.noise)
    return float(np.sum((residual - slope @ np.linalg.lstsq(slope, residual, rcond=None)[0]) ** 2))


def _alternatives(problem: Problem, best: Found, ends: list[Found]) -> list[Found]:
    """Return other cars that are as likely: ends of other starts, and those with the same modes as seen."""
    u = problem.unknowns
    points = [end for end in ends if end.loss - best.loss >= SAME_FIT]
    points += [descended(problem, x, best.noise) for x in _twins(problem, best)]
    kept: list[Found] = []
    for point in points:
        apart = [np.max(np.abs(np.log((point.x + 1e-3) / (other.x + 1e-3)))) for other in (best, *kept)]
        # Nearer than a hundredth, two ends of one descent.
        if point.loss - best.loss < CHI_SQUARE_95 and min(apart) > 0.01 and not np.any(np.isnan(u.parameters(point.x))):
            kept.append(point)
    return kept


def _twins(problem: Problem, best: Found) -> Iterator[RealArray]:
    """Yield unknowns of other cars with the poles, and the shapes at the channels, of the best one."""
    u = problem.unknowns
    seen = np.concatenate([trial.weights for trial in problem.trials])
    blind_to_some = np.linalg.matrix_rank(seen) < seen.shape[1]
    sprung = any(s.mount_stiffness is not None for s in u.suspension(best.x).struts)
    if sprung or not blind_to_some or any(len(trial.inputs) or np.any(trial.added) for trial in problem.trials):
        return
    car = u.suspension(best.x)
    modes = eigenmodes(car)
    assert modes.shapes is not None
    watched = [i for i in range(seen.shape[1]) if np.any(seen[:, i])]
    names = [modes.channels[i] for i in watched]
    asked = ModalSet(poles=modes.poles, shapes=modes.shapes[watched], channels=names)
    held = [name for name in _strut_parameters(u.car) if name not in u.names]
    try:
        found = reconstruct(asked, car, fixed=held)
    except ReconstructionError:
        return
    for other in found.alternatives:
        p = np.array([*(s.stiffness for s in other.struts), *(s.damping for s in other.struts)])
        x = best.x.copy()
        for row, column in zip(u.rows, u.column, strict=True):
            if row < len(p):
                x[column] = p[row] / u.scale[column]
        yield np.clip(x, u.lower, u.upper)


def _perhaps_driven(problem: Problem) -> tuple[str | Argument, ...]:
    """Return what is said where a record counts as a free decay and does not die down."""
    moved = any(np.any(np.ptp(trial.values, axis=1) > 0) for trial in problem.trials)
    if not moved or any(len(trial.inputs) or dies_down(trial.values) for trial in problem.trials):
        return ()
    return (
        "the motion does not die down; if wheels, roads or forces moved the car, name them in ",
        Argument("given"),
        ". As a free decay ",
    )


def _strut_parameters(car: Suspension) -> list[str]:
    return [f"{s.name}.{quantity}" for quantity, s in product(QUANTITIES, car.struts)]


def _judged(problem: Problem, errors: list[OutputError], noise: list[RealArray]) -> tuple[float, int, bool, Check]:
    """Return the statistic of whiteness of all channels that stand above their rounding, and what it says."""
    total, freedom, worst, where = 0.0, 0, 0.0, ""
    for i, (trial, error, std) in enumerate(zip(problem.trials, errors, noise, strict=True)):
        above = std > ABOVE_RESOLUTION * np.sqrt(trial.noise.least)
        statistics, lags = portmanteau(error.residual)
        for channel, statistic, counts in zip(trial.channels, statistics, above, strict=True):
            if counts:
                total, freedom = total + float(statistic), freedom + lags
                if statistic > worst:
                    worst, where = float(statistic), channel + f" of record {i + 1}" * (len(errors) > 1)
    numbers: dict[str, Number] = {"chi_square": total, "freedom": freedom, "channel": where}
    known = tuple(dict.fromkeys(name for trial in problem.trials for name in trial.known))
    numbers |= {"inputs": known} if known else {}
    if not freedom:
        return total, freedom, True, Check(Remark(EstimateCheck.ROUNDING), Level.SOUND)
    if likely(total, freedom):
        return total, freedom, True, Check(Remark(EstimateCheck.EXPLAINS, numbers), Level.SOUND)
    share = _largest_share(problem, errors)
    if share < LEAST_SEEN:
        exact = Remark(EstimateCheck.NEARLY_EXACT, {**numbers, "share": float(np.sqrt(share))})
        return total, freedom, True, Check(exact, Level.SOUND)
    caused, follower = _caused(problem, errors)
    if caused > MOST_CAUSED:
        numbers |= {"caused": caused, "follower": follower}
    level = Level.DOUBTFUL if share > MOST_COLOURED or caused > MOST_CAUSED else Level.CARE
    return total, freedom, False, Check(Remark(EstimateCheck.UNEXPLAINED, numbers), level)


def _caused(problem: Problem, errors: list[OutputError]) -> tuple[Ratio, str]:
    """Return how much of the motion of a channel is left of it and follows known roads and forces, and the channel."""
    found = []
    for trial, error in zip(problem.trials, errors, strict=True):
        share = caused_share(error.residual, trial.values, trial.inputs_beside)
        worst = int(np.argmax(share))
        found.append((float(np.sqrt(max(share[worst], 0.0))), trial.channels[worst]))
    return max(found)


def _largest_share(problem: Problem, errors: list[OutputError]) -> float:
    """Return the share of a channel's power that is left of it, where most is left."""
    return max(
        float(np.max(np.sum(e.residual**2, axis=1) / np.maximum(t.count * np.var(t.values, axis=1), t.noise.least)))
        for t, e in zip(problem.trials, errors, strict=True)
    )


def _covariance(problem: Problem, errors: list[OutputError], noise: list[RealArray], prior: RealArray) -> RealArray:
    """Return the covariance of the unknowns, which allows for the colour of residuals that are not white."""
    u = problem.unknowns
    size = u.sizes(np.ones(len(u)))
    information = prior.T @ prior
    scores = prior.T @ prior
    for trial, error, std in zip(problem.trials, errors, noise, strict=True):
        slope = error.slope / std[:, None, None] @ u.spread[u.rows]
        statistics, lags = portmanteau(error.residual)
        for channel in range(len(trial.channels)):
            own = slope[channel].T @ slope[channel]
            information = information + own
            coloured = not likely(float(statistics[channel]), lags)
            loud = std[channel] > ABOVE_RESOLUTION * np.sqrt(trial.noise.least[channel])
            if coloured and loud:
                own = score_power(slope[channel], error.residual[channel] / std[channel])
            scores = scores + own
    scale = np.sqrt(np.diag(information)) * size
    inverse = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    return np.asarray(inverse @ scores @ inverse)
