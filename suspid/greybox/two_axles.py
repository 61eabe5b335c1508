"""Tires and wheel masses from two axles that roll over one track, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.axle_data import STANDING, Behind, axle_record
from suspid.greybox.axle_fit import AxleFit, AxleProblem, first_state, fit_axles
from suspid.greybox.axle_model import LATE_STD, AxleModel, axle_model
from suspid.greybox.fits import Fit
from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.road_maps import MapProblem
from suspid.greybox.road_model import road_model
from suspid.greybox.tire_fit import State, TireProblem
from suspid.greybox.trials import Trial
from suspid.greybox.wheel_power import MOMENTS
from suspid.units import Metre, Ratio, RealArray
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck

# Stretches of all records, at least: the scatter of fewer says little of the intervals.
FEWEST_BEHIND = 6
# Coherence of the two roads, median over the lines, from which on they count as one track. With the rear wheel 3 cm
# beside the front's track, which is 0.976, only 92 % of the intervals held in 30 drives; errors were 1.3 times stated.
ONE_TRACK = 0.99
NO_TRACK = 0.5  # the same before the fit, with tires as each axle found them: the fit of two roads has no end


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Followed:
    """What two axles on one track say of tires and wheel masses."""

    x: RealArray
    covariance: RealArray  # (unknown, unknown)
    across: RealArray  # (unknown, unknown of the first step): covariance with them
    by_found: RealArray  # (unknown, unknown of the first step): change with them
    checks: tuple[Check, ...]


def followed(
    problem: WheelProblem,
    found: Fit,
    z: RealArray,
    whole: TireProblem,
    alone: State,
    trials: Sequence[Trial],
    speeds: Sequence[RealArray],
    *,
    behind: Sequence[Behind],
    radius: Metre | None,
) -> Followed | tuple[Check, ...]:
    """Return what both axles say, from the fits of each ``alone``; checks where nothing comes of it."""
    slowest = STANDING * float(np.median(np.concatenate(list(speeds))))
    models, first = [], []
    for number, levels in enumerate(found.levels):
        source = problem.sources[number]
        track = next(m.track for m in whole.models if m.track.source == number)
        band = (float(track.hertz[0]), float(track.hertz[-1]))
        records = [
            axle_record(problem, z, number, levels, trials[i], speed=speeds[i], band=band, slowest=slowest)
            for i in source.numbers
        ]
        cut = [speeds[i][a : a + track.samples] for i, r in zip(source.numbers, records, strict=True) for a in r.starts]
        if not cut:
            continue
        moments = ((np.arange(MOMENTS) + 0.5) / MOMENTS * track.samples).astype(int)
        own = replace(track, power=np.zeros((len(cut), len(track.hertz))), speeds=np.array(cut)[:, moments])
        road = road_model(own, radius=radius)
        by_wheel = {
            m.track.wheel: one for m, one in zip(whole.models, alone.roads, strict=True) if m.track.source == number
        }
        for pair in behind:
            roads = (pair.front, pair.rear)
            others = (i for i in range(len(whole.unknowns.car.roads)) if i not in roads)
            maps = MapProblem(problem=problem, number=number, tires=whole.unknowns, roads=(*roads, *others))
            models.append(axle_model(pair, maps, z, levels, records, road))
            first.append(models[-1].first(*(by_wheel[wheel] for wheel in pair.wheels)))
    count = sum(model.stretches for model in models) // len(behind)
    if count < FEWEST_BEHIND:
        return (Check(Remark(EstimateCheck.FEW_BEHIND, {"count": count, "fewest": FEWEST_BEHIND}), Level.CARE),)
    values, vectors = np.linalg.eigh(found.covariance)
    # What the first step knows to rounding, such as a mount on its bound, stays.
    keep = values > 1e-12 * values[-1]
    spread = vectors[:, keep] * np.sqrt(values[keep])
    free = z if found.pull is None else z + found.pull
    asked = AxleProblem(models=tuple(models), unknowns=whole.unknowns, found=free, spread=spread)
    start, in_phase = first_state(asked, alone.x, first)
    apart = _apart(asked, behind, _by_pair(models, behind, in_phase), NO_TRACK)
    if apart:
        return apart
    fit = fit_axles(asked, start)
    shared = [m.shared(own) for m, own in zip(models, fit.state.own, strict=True)]
    coherence = _by_pair(models, behind, shared)
    apart = _apart(asked, behind, coherence, ONE_TRACK)
    if apart:
        return apart
    return Followed(
        x=fit.state.x,
        covariance=fit.covariance,
        across=fit.by_found @ spread.T,
        by_found=fit.by_found @ np.linalg.pinv(spread),
        checks=tuple(_together(asked, fit, pair, one) for pair, one in zip(behind, coherence, strict=True)),
    )


def _by_pair(models: Sequence[AxleModel], behind: Sequence[Behind], shared: Sequence[RealArray]) -> list[float]:
    """Return the median coherence of the two roads of each pair."""
    every = [[one.ravel() for m, one in zip(models, shared, strict=True) if m.behind is pair] for pair in behind]
    return [float(np.median(np.concatenate(some))) for some in every]


def _names(problem: AxleProblem, pair: Behind, coherence: float) -> dict[str, Number]:
    roads = problem.unknowns.car.roads
    return {"rear": roads[pair.rear], "front": roads[pair.front], "coherence": max(0.0, coherence)}


def _apart(
    problem: AxleProblem, behind: Sequence[Behind], coherence: Sequence[float], least: Ratio
) -> tuple[Check, ...]:
    """Return what is said of the pairs whose roads are not one."""
    return tuple(
        Check(Remark(EstimateCheck.NOT_BEHIND, {**_names(problem, pair, one), "least": ONE_TRACK}), Level.CARE)
        for pair, one in zip(behind, coherence, strict=True)
        if one < least
    )


def _together(problem: AxleProblem, fit: AxleFit, pair: Behind, coherence: float) -> Check:
    """Return what is said of a pair whose roads are one: the way by which the rear one is later at the usual speed."""
    speed = float(np.exp(np.median(np.concatenate([m.road.track.log_speed for m in problem.models]))))
    lag = fit.state.lag(pair)
    slope = np.array([lag.way, speed * LATE_STD])
    std = float(np.sqrt(slope @ fit.lag_covariance @ slope))
    names = {**_names(problem, pair, coherence), "lag": lag.way + speed * lag.time, "std": std}
    return Check(Remark(EstimateCheck.BEHIND, names), Level.NOTE)
