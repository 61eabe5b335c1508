"""From a drive to tires and wheel masses, in two steps: the suspension without a road, then the rest with its model.

What a model of the road says of the suspension is not used: springs and dampers are those of the first step, and their
covariance is carried into the second.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from suspid.errors import InputError
from suspid.greybox.axle_data import Behind
from suspid.greybox.fits import Fit
from suspid.greybox.frequency_domain import fit_in_frequency
from suspid.greybox.measured_causes import WheelProblem
from suspid.greybox.road_model import road_model
from suspid.greybox.roads import RoadEstimate, road_estimate
from suspid.greybox.rolling import Rolling
from suspid.greybox.tire_fit import TireFit, TireProblem, fit_tires
from suspid.greybox.trials import Trial
from suspid.greybox.two_axles import Followed, followed
from suspid.greybox.wheel_power import tracks_of
from suspid.greybox.wheel_problem import band_of, wheel_problem
from suspid.reconstruction import QUANTITIES, Unknowns
from suspid.units import Hertz, Ratio, RealArray, Second
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck

# Standard deviation of a tire's damping, where none is stated: of nominal, or, where nominal is 0, of its critical one.
# The record hardly tells it from that of the suspension; left out, a wheel's mass is 3 to 4 % too small.
TIRE_DAMPING_STD: Ratio = 0.5
TIRE_DAMPING_RATIO: Ratio = 0.01


ROADS = ("iso8608",)


def check_road(trials: Sequence[Trial], *, road: str | None, rolling: Mapping[str, object]) -> None:
    """Refuse a model of the road that is unknown or has no wheels, and what is given for such a model without one.

    Raises
    ------
    InputError
        Saying which.
    """
    if road is None:
        given = next((name for name, one in rolling.items() if one is not None), None)
        if given is not None:
            raise InputError(
                Argument(given), " belongs to a model of the road; give ", Argument("road", "'iso8608'"), " too"
            )
        return
    if road not in ROADS:
        raise InputError(
            Argument("road", repr(road)), f" is not a model of a road; give {' or '.join(map(repr, ROADS))}"
        )
    if not all(trial.wheels for trial in trials):
        raise InputError(
            Argument("road"), ": its model is for drives in which the motion of the wheels is measured; give them too"
        )


def fit_with_road(
    unknowns: Unknowns,
    trials: Sequence[Trial],
    rolling: Rolling,
    *,
    beyond: Sequence[str],
    gains: Sequence[str] | None,
    delays: Sequence[str] | None,
    mounts: Sequence[str] | None,
    band: tuple[Hertz, Hertz] | None,
    stretch: Second | None,
    behind: Sequence[Behind] = (),
) -> Fit:
    """Return the best car; ``beyond`` are the struts between given motion and road.

    Raises
    ------
    InputError
        If nothing is unknown beyond the given motion, or of the suspension, or one is tied to the other.
    """
    first, second = _parts(unknowns, trials, beyond)
    problem = wheel_problem(
        unknowns.car, trials, _part(unknowns, first), gains=gains, delays=delays, mounts=mounts, band=band,
        stretch=stretch,
    )  # fmt: skip
    found = fit_in_frequency(problem)
    x = unknowns.nominal.copy()
    x[first] = found.x
    at = replace(unknowns, nominal=x)
    tires = _with_tire_damping(_part(at, second))
    z = np.concatenate([found.x, found.extra_values / found.extra_scale])
    rows = problem.unknowns.rows

    def posed(x: RealArray) -> TireProblem:
        limits = band_of(tires.suspension(x)) if band is None else band
        models = [
            road_model(track, radius=rolling.radius)
            for i, levels in enumerate(found.levels)
            for track in tracks_of(problem, z, i, levels, trials, speeds=rolling.speeds, band=limits)
        ]
        return TireProblem(
            models=tuple(models),
            trials=tuple(source.trial for source in problem.sources),
            unknowns=tires,
            physics=tuple(problem.physics(z, i) for i in range(len(problem.sources))),
            mounts=problem.extras.mounts,
        )

    # Once more in the band of the car that was found: that of a nominal one may end at the wheel's mode.
    whole = posed(tires.nominal)
    fit = fit_tires(whole, rows)
    if band is None:
        whole = posed(fit.state.x)
        fit = fit_tires(whole, rows, start=fit.state.x)
    x[second] = fit.state.x
    # How the fit moves with the unknowns of the first step.
    carried = fit.by_suspension @ _by_unknown(problem)
    every = fit.covariance + carried @ found.covariance @ carried.T
    roads, checks = _roads(whole, fit, every), list[Check]()
    count, size = len(second), len(unknowns) + len(found.extras)
    rest = np.array(second, int)
    place = np.array([*first, *range(len(unknowns), size)], int)
    covariance = np.zeros((size, size))
    own, moved = every[:count, :count], carried[:count]
    across = moved @ found.covariance
    if behind and rolling.speeds is not None:
        both = followed(
            problem, found, z, whole, fit.state, trials, rolling.speeds, behind=behind, radius=rolling.radius
        )
        if isinstance(both, Followed):
            x[second], own, across, moved = both.x, both.covariance, both.across, both.by_found
        checks += both.checks if isinstance(both, Followed) else both
    covariance[np.ix_(place, place)] = found.covariance
    covariance[np.ix_(rest, place)] = across
    covariance[np.ix_(place, rest)] = across.T
    covariance[np.ix_(rest, rest)] = own
    pull = np.zeros(size)
    if found.pull is not None:
        pull[place], pull[rest] = found.pull, moved @ found.pull
    return replace(
        found,
        x=x,
        pull=pull,
        covariance=covariance,
        roads=roads,
        checks=(*found.checks, *_checks(whole, roads, rolling), *checks),
    )


def _by_unknown(problem: WheelProblem) -> RealArray:
    """Return how the parameters of the suspension, and relaxations, follow from the unknowns of the first step."""
    u, extras = problem.unknowns, problem.extras
    made = np.zeros((len(u.rows) + len(extras.mounts), len(u) + len(extras.names)))
    made[: len(u.rows), : len(u)] = u.spread[u.rows]
    for i in range(len(extras.mounts)):
        made[len(u.rows) + i, len(u) + i] = extras.scale[i]
    return made


def _roads(problem: TireProblem, fit: TireFit, covariance: RealArray) -> tuple[RoadEstimate, ...]:
    """Return the road of every track; ``covariance`` is that of all unknowns."""
    u, roads = problem.unknowns, []
    natural = np.append(u.per_step(fit.state.x), np.ones(len(covariance) - len(u)))
    stepped, at = covariance / np.outer(natural, natural), len(u)
    for i, model in enumerate(problem.models):
        place = [*range(len(u)), *range(at, at + model.count)]
        at += model.count
        roads.append(
            road_estimate(
                model,
                fit.state.roads[i],
                fit.state.levels[i],
                fit.scores[i],
                stepped[np.ix_(place, place)],
                wheel=u.car.coordinates[model.track.wheel],
                step=problem.trials[model.track.source].step,
            )
        )
    return tuple(roads)


def _checks(problem: TireProblem, roads: Sequence[RoadEstimate], rolling: Rolling) -> list[Check]:
    """Return what the model of the road decided, and what it could not hold."""
    u = problem.unknowns
    widest = max(roads, key=lambda road: road.exponent_std)
    numbers: dict[str, Number] = {"names": u.names, "exponent": widest.exponent, "std": widest.exponent_std}
    checks = [Check(Remark(EstimateCheck.ROAD, numbers), Level.NOTE)]
    dampers = tuple(name for name in u.names if name.endswith(".damping"))
    if dampers:
        checks.append(Check(Remark(EstimateCheck.TIRE_DAMPING, {"names": dampers}), Level.NOTE))
    if rolling.speeds is None:
        checks.append(Check(Remark(EstimateCheck.NO_SPEED), Level.CARE))
    elif rolling.radius is None:
        checks.append(Check(Remark(EstimateCheck.NO_RADIUS), Level.CARE))
    return checks


def _parts(unknowns: Unknowns, trials: Sequence[Trial], beyond: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return which unknowns the given motion determines, and which only the road does."""
    u = unknowns
    wheels = {u.car.coordinates[i] for trial in trials for i in trial.wheels}
    far = {f"{name}.{q}" for name in beyond for q in QUANTITIES} | {f"{name}.mass" for name in wheels}
    first = sorted({c for name, c in zip(u.names, u.column, strict=True) if name not in far})
    second = sorted({c for name, c in zip(u.names, u.column, strict=True) if name in far})
    both = [u.labels[c] for c in first if c in second]
    if both:
        raise InputError(
            Argument("ties"),
            f": {both[0]} ties the suspension to parameters that only a road model determines; use separate ties",
        )
    if not second:
        raise InputError(
            Argument("road"),
            ": ",
            Argument("fixed"),
            " contains all tires and no wheel's mass is free; leave out ",
            Argument("road"),
            ", or free one",
        )
    if not first:
        raise InputError(
            Argument("road"),
            ": ",
            Argument("fixed"),
            " contains every strut of the suspension; at least one must be free",
        )
    return first, second


def _part(unknowns: Unknowns, columns: Sequence[int]) -> Unknowns:
    """Return some of the unknowns; the others stay at their nominal values."""
    u, keep = unknowns, list(columns)
    inside = [i for i, c in enumerate(u.column) if c in keep]
    others = np.where(np.isin(np.arange(len(u)), keep), 0.0, u.nominal)
    by_unknown = ("scale", "nominal", "positive", "lower", "upper", "prior_std")
    changed: dict[str, Any] = {name: getattr(u, name)[keep] for name in by_unknown}
    changed |= {
        "car": u.suspension(u.nominal),
        "names": tuple(u.names[i] for i in inside),
        "rows": [u.rows[i] for i in inside],
        "column": [keep.index(u.column[i]) for i in inside],
        "base": u.base + others @ u.spread.T,
        "spread": u.spread[:, keep],
        "arms": u.arms,
    }
    assert set(changed) == {field.name for field in fields(Unknowns)}
    return Unknowns(**changed)


def _with_tire_damping(unknowns: Unknowns) -> Unknowns:
    """Return the unknowns with what is known of the damping of tires where nothing is stated."""
    u, struts = unknowns, len(unknowns.car.struts)
    std: RealArray = u.prior_std.copy()
    for row, c in zip(u.rows, u.column, strict=True):
        if struts <= row < 2 * struts and not np.isfinite(std[c]):
            strut = u.car.struts[row - struts]
            mass = sum(u.car.masses.get(name, 0.0) for name in strut.arms)
            critical = 2 * float(np.sqrt(strut.stiffness * mass))
            share = TIRE_DAMPING_STD * strut.damping if strut.damping > 0 else TIRE_DAMPING_RATIO * critical
            std[c] = share / u.scale[c]
    return replace(u, prior_std=std)
