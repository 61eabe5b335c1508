"""Gains and delays of channels, and mounts, that nobody asked for and the records need."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from suspid.errors import EstimationError
from suspid.greybox.causes import dies_down
from suspid.greybox.fits import Fit
from suspid.greybox.further import RIGID, SENSOR_KINDS, label
from suspid.greybox.problem import Problem, default_holds
from suspid.greybox.search import descended
from suspid.greybox.sensors_asked import Names, possible, with_sensors
from suspid.greybox.time_domain import fit_in_time
from suspid.greybox.trials import Trial
from suspid.levels import LEVEL, likely, normal_reach
from suspid.reconstruction import Unknowns
from suspid.units import RealArray
from suspid.words import Check, Level, Remark
from suspid.words.greybox import EstimateCheck

NOTHING_LEFT = (EstimateCheck.ROUNDING, EstimateCheck.NEARLY_EXACT)


def with_needed(fit: Fit, problem: Problem, bare: Unknowns, asked: Names, free: Sequence[str]) -> tuple[Fit, Problem]:
    """Return the fit with what the records need besides what was asked for, if it explains them; and its problem.

    What is not asked for is added one by one: what explains most of the residual, until nothing explains more of it
    than chance. ``bare`` are the unknowns of the car alone, ``free`` the kinds of `SENSOR_KINDS` that may be added.
    """
    if not leaves_something(fit) or not free:
        return fit, problem
    if not fit.explains and not all(len(trial.inputs) or dies_down(trial.values) for trial in problem.trials):
        return fit, problem
    default = default_holds(problem.trials)
    # A late channel looks like an input that is held: how inputs move is asked again with what is added.
    for holds in dict.fromkeys((fit.holds,) if fit.explains else (default, fit.holds)):
        chosen = _needed(fit, replace(problem, holds=holds), bare, asked, free)
        if chosen == asked:
            continue
        with suppress(EstimationError):
            found, wider, _ = fit_beside(problem.trials, bare, chosen, asked)
            if found.explains:
                return said_so(found, wider, problem.unknowns), wider
    return fit, problem


def fit_beside(trials: Sequence[Trial], bare: Unknowns, chosen: Names, asked: Names) -> tuple[Fit, Problem, Names]:
    """Return the fit with what was chosen, its problem, and what is left of what was chosen.

    What looked like a mount is none where a rigid one does beside all that was added later, unless
    it was ``asked`` for.

    Raises
    ------
    EstimationError
        If the records do not determine it.
    """
    unknowns, cut = with_sensors(bare, [trial.whole for trial in trials], **chosen)
    problem = Problem(trials=cut, holds=default_holds(cut), unknowns=unknowns)
    fit = fit_in_time(problem)
    least = unknowns.lower + normal_reach(LEVEL) * np.sqrt(np.diag(fit.covariance))
    soft = dict(zip(unknowns.labels, (fit.x > least).tolist(), strict=True))
    kept = tuple(one for one in chosen["mounts"] if one in asked["mounts"] or soft[f"{one}.relaxation"])
    if not fit.explains or kept == chosen["mounts"]:
        return fit, problem, chosen
    with suppress(EstimationError):
        fewer = fit_beside(trials, bare, {**chosen, "mounts": kept}, asked)
        if fewer[0].explains:
            return fewer
    return fit, problem, chosen


def leaves_something(fit: Fit) -> bool:
    """Return whether a fit leaves more of the records than rounding."""
    return not any(check.remark.code in NOTHING_LEFT for check in fit.checks)


def said_so(fit: Fit, problem: Problem, before: Unknowns) -> Fit:
    """Return a fit that says which unknowns there were not ``before``."""
    names = tuple(name for name in problem.unknowns.names if name not in before.names)
    others = tuple(check for check in fit.checks if check.remark.code is not EstimateCheck.NEEDED)
    # Without a known input several sets of sensors explain a decay nearly as well: which one is a guess.
    level = Level.NOTE if all(len(trial.inputs) for trial in problem.trials) else Level.CARE
    return replace(fit, checks=(*others, Check(Remark(EstimateCheck.NEEDED, {"names": names}), level)))


def _needed(fit: Fit, problem: Problem, bare: Unknowns, asked: Names, free: Sequence[str]) -> Names:
    """Return what was asked for, and what explains more of a residual than chance does, step by step."""
    here, x, noise, chosen = problem, fit.x, list(fit.noise), asked
    if problem.holds != fit.holds:
        found = descended(problem, x, noise, rounds=3)
        x, noise = found.x, list(found.noise)
    for _ in range(len(free) * len(bare.car.struts) + 2 * max(len(trial.channels) for trial in problem.trials)):
        more = _best(here, bare, chosen, free, x, noise)
        if more is None:
            break
        wider, before = _problem(here, bare, more), dict(zip(here.unknowns.labels, x, strict=True))
        u = wider.unknowns
        start = np.array([before.get(name, value) for name, value in zip(u.labels, u.nominal, strict=True)])
        found = descended(wider, np.clip(start, u.lower, u.upper), noise, rounds=3)
        here, x, noise, chosen = wider, found.x, list(found.noise), more
    return chosen


def _best(
    problem: Problem, bare: Unknowns, chosen: Names, free: Sequence[str], x: RealArray, noise: Sequence[RealArray]
) -> Names | None:
    """Return what is chosen and what explains most of the residual beside it; None if chance explains as much."""
    every = possible(problem.trials, bare, chosen, free)
    whole, before = _problem(problem, bare, every), dict(zip(problem.unknowns.labels, x, strict=True))
    u = whole.unknowns
    none = np.where(np.array([name.endswith(".relaxation") for name in u.labels]), RIGID, u.nominal)
    at = np.array([before.get(name, value) for name, value in zip(u.labels, none, strict=True)])
    residual, slope = whole.equations(at, noise)
    return most_telling(residual, slope, u.labels, tuple(before), problem.trials, chosen, every)


def most_telling(
    residual: RealArray,
    slope: RealArray,
    labels: Sequence[str],
    before: Sequence[str],
    trials: Sequence[Trial],
    chosen: Names,
    every: Names,
) -> Names | None:
    """Return what is chosen and which one of ``every`` explains most of a residual; None if chance explains as much.

    ``slope`` are the derivatives of the residual by the unknowns ``labels``, of which those ``before`` are fitted.
    """
    q, _ = np.linalg.qr(slope[:, [i for i, name in enumerate(labels) if name in before]])
    residual = residual - q @ (q.T @ residual)
    best, found = 0.0, None
    for kind, name, more in _added(trials, chosen, every):
        own = _labels(kind, name, len(trials))
        new = slope[:, [i for i, one in enumerate(labels) if one in own]]
        new = new - q @ (q.T @ new)
        step = np.linalg.lstsq(new, -residual, rcond=None)[0]
        drop = float(residual @ residual - np.sum((residual + new @ step) ** 2))
        # No mount is softer than none.
        if not (kind == "mounts" and step[0] <= 0) and not likely(drop, new.shape[1]) and drop > best:
            best, found = drop, more
    return found


def _added(trials: Sequence[Trial], chosen: Names, every: Names) -> Iterator[tuple[str, str, Names]]:
    """Yield what may be added to what is chosen: its kind, its name and both together."""
    for kind in SENSOR_KINDS:
        for name in every[kind]:
            more = {**chosen, kind: (*chosen[kind], name)}
            # Of all channels of a free decay only ratios of gains, and differences of delays, can be found.
            all_of_them = kind != "mounts" and any(
                not len(trial.inputs) and set(trial.channels) <= set(more[kind]) for trial in trials
            )
            if name not in chosen[kind] and not all_of_them:
                yield kind, name, more


def _labels(kind: str, name: str, tests: int) -> tuple[str, ...]:
    ending = {"mounts": "relaxation", "gains": "gain", "delays": "delay"}[kind]
    return (f"{name}.{ending}", *(f"{label(name, i, tests)}.{ending}" for i in range(tests)))


def _problem(problem: Problem, bare: Unknowns, chosen: Names) -> Problem:
    """Return the problem with other unknowns of sensors and mounts."""
    unknowns, trials = with_sensors(bare, [trial.whole for trial in problem.trials], **chosen)
    return replace(problem, trials=trials, unknowns=unknowns)
