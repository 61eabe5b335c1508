"""Fit of tires and wheel masses to the power of the wheels' motion, with the road's unknowns (Whittle's likelihood).

``sum log S + P / S`` over stretches and lines is minimised by Fisher scoring. The levels of the stretches are
eliminated from every step. The suspension is as found before; its covariance is carried through.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.greybox.reach import Reach, reach
from suspid.greybox.road_model import Expected, RoadModel
from suspid.greybox.transfers import Physics
from suspid.greybox.trials import Trial
from suspid.greybox.wheel_power import SPAN
from suspid.levels import NEGLIGIBLE_GAIN
from suspid.reconstruction import LARGEST_STEP, Unknowns
from suspid.units import Ratio, RealArray

FIRST_FACTORS = (0.5, 0.7, 1.0, 1.4, 2.0)  # of springs and masses, where the search begins
OVERLAP = 2 * SPAN  # lines over which scores are taken together: the tapers correlate seven, three to either side
# Share of their variance that such sums show: powers 0 to 4 lines apart correlate by 1, 0.684, 0.381, 0.097 and 0; a
# pair counts in the sums with both, which are 12, 11, 10 and 9 of 12.
SHOWN: Ratio = 0.9128


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class TireProblem:
    """The wheels' spectra, and what is unknown of tires, wheel masses and roads."""

    models: tuple[RoadModel, ...]
    trials: tuple[Trial, ...]  # by logger, the first
    unknowns: Unknowns  # tires and wheel masses; all else as found
    physics: tuple[Physics, ...]  # by logger, of which stiffness, damping and masses are replaced
    mounts: tuple[int, ...]

    def reach(self, x: RealArray, model: RoadModel, rows: Sequence[int], mounts: Sequence[int] = ()) -> Reach:
        """Return how the road moves the channel of a track at unknowns x."""
        u, track = self.unknowns, model.track
        struts, p, trial = len(u.car.struts), u.parameters(x), self.trials[track.source]
        return reach(
            u.car,
            trial,
            replace(
                self.physics[track.source],
                stiffness=p[:struts],
                damping=p[struts : 2 * struts],
                masses=p[2 * struts :] + trial.added,
            ),
            np.asarray(2j * np.pi * track.wide, complex),
            channel=track.channel,
            wheel=track.wheel,
            rows=rows,
            mounts=mounts,
        )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class State:
    """A point of the search: unknowns of the car, of each road, and levels."""

    x: RealArray
    roads: tuple[RealArray, ...]  # by track
    levels: tuple[RealArray, ...]  # by track, (stretch,)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Scores:
    """Derivatives of all cells of one track, less what the levels of the stretches explain."""

    cells: RealArray  # (stretch, line, unknown): of the logarithm of the expected power, car's unknowns first
    excess: RealArray  # (stretch, line): measured over expected power, less one
    level_slope: RealArray  # (stretch, unknown): change of each level per unknown
    level_step: RealArray  # (stretch,): best change of each level
    level_weight: RealArray  # (stretch,): information on each level


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class TireFit:
    """The best tires, wheel masses and roads."""

    state: State
    covariance: RealArray  # (unknown, unknown): x, then each road's unknowns; the suspension as known
    by_suspension: RealArray  # (unknown, parameter): change of the unknowns with the suspension's parameters
    scores: tuple[Scores, ...]


def fit_tires(problem: TireProblem, rows: Sequence[int], *, start: RealArray | None = None) -> TireFit:
    """Return the best fit, and how it changes with the suspension's parameters ``rows`` and relaxations.

    The search begins at tires and wheel masses ``start``, or at the best of some multiples of the nominal ones.
    """
    state = _descended(problem, _first(problem) if start is None else _at(problem, start))
    u, count = problem.unknowns, len(problem.unknowns)
    scores = [_scores(problem, state, i) for i in range(len(problem.models))]
    size = count + sum(m.count for m in problem.models)
    information = _prior_information(problem, state)
    together: dict[int, RealArray] = {}
    mixed = np.zeros((size, len(rows) + len(problem.mounts)))
    at = count
    for model, one, own, levels in zip(problem.models, scores, state.roads, state.levels, strict=True):
        place = [*range(count), *range(at, at + model.count)]
        at += model.count
        flat = one.cells.reshape(-1, len(place))
        information[np.ix_(place, place)] += flat.T @ flat
        # Wheels of one drive roll over one road, perhaps one after the other: their scores are not independent.
        shared = together.setdefault(model.track.source, np.zeros((*one.excess.shape, size)))
        shared[:, :, place] += one.cells * one.excess[:, :, None]
        moved = problem.reach(state.x, model, rows, problem.mounts)
        by_suspension = model.expected(own, levels, moved).by_car
        mixed[place] += flat.T @ by_suspension.reshape(len(flat), -1)
    spread = sum((scatter(shared) for shared in together.values()), _prior_information(problem, state))
    inverse = np.linalg.inv(information)
    natural = np.append(u.per_step(state.x), np.ones(size - count))
    return TireFit(
        state=state,
        covariance=natural[:, None] * (inverse @ spread @ inverse) * natural,
        by_suspension=-natural[:, None] * (inverse @ mixed),
        scores=tuple(scores),
    )


def scatter(scores: RealArray) -> RealArray:
    """Return the covariance of the sum of scores (stretch, line, unknown), which neighbouring lines share."""
    around = np.pad(np.cumsum(scores, axis=1), ((0, 0), (OVERLAP, 0), (0, 0)))
    around = np.concatenate([around, np.repeat(around[:, -1:], OVERLAP, axis=1)], axis=1)
    together = (around[:, OVERLAP:] - around[:, :-OVERLAP]).reshape(-1, scores.shape[2])
    return np.asarray(together.T @ together / (OVERLAP * SHOWN))


def _first(problem: TireProblem) -> State:
    """Return the best of some starts: the nominal tires and wheel masses times some factors."""
    u = problem.unknowns
    springs = np.array([row < len(u.car.struts) for row in u.rows])
    of_spring = np.zeros(len(u), bool)
    of_spring[[c for c, one in zip(u.column, springs, strict=True) if one]] = True
    starts = []
    for k in FIRST_FACTORS:
        for m in FIRST_FACTORS if np.any(u.positive & ~of_spring) else FIRST_FACTORS[2:3]:
            x = np.clip(u.nominal * np.where(of_spring, k, np.where(u.positive, m, 1.0)), u.lower, u.upper)
            starts.append(_at(problem, x))
    return min(starts, key=lambda start: _value(problem, start))


def _at(problem: TireProblem, x: RealArray) -> State:
    """Return where the search begins at tires and wheel masses x."""
    roads = tuple(model.prior.mean for model in problem.models)
    levels = tuple(_levels(problem, x, model, own) for model, own in zip(problem.models, roads, strict=True))
    return State(x=x, roads=roads, levels=levels)


def _levels(problem: TireProblem, x: RealArray, model: RoadModel, own: RealArray) -> RealArray:
    """Return levels to begin with: those of the mean of the power over that of a road alone."""
    unit = model.power(own, np.zeros(len(model.track.power)), problem.reach(x, model, ()))
    return np.asarray(np.mean(np.log(np.maximum(model.track.power, 1e-300) / unit), axis=1))


def _value(problem: TireProblem, state: State) -> float:
    """Return minus the logarithm of the likelihood and of what is known before."""
    prior = problem.unknowns.prior(state.x)[0]
    value = float(prior @ prior) / 2
    for model, own, levels in zip(problem.models, state.roads, state.levels, strict=True):
        S = model.power(own, levels, problem.reach(state.x, model, ()))
        value += float(np.sum(np.log(S) + model.track.power / S))
        value += float(np.sum(((own - model.prior.mean) / model.prior.std) ** 2)) / 2
    return value


def _scores(problem: TireProblem, state: State, number: int) -> Scores:
    """Return the derivatives of one track at a point of the search, with the levels eliminated."""
    u, model = problem.unknowns, problem.models[number]
    made: Expected = model.expected(state.roads[number], state.levels[number], problem.reach(state.x, model, u.rows))
    by_unknown = made.by_car @ (u.spread[u.rows] * u.per_step(state.x))
    cells, excess = np.concatenate([by_unknown, made.by_road], axis=2), model.track.power / made.power - 1
    weight = np.sum(made.share**2, axis=1)
    slope = -np.einsum("jl,jli->ji", made.share, cells) / weight[:, None]
    return Scores(
        cells=cells + made.share[:, :, None] * slope[:, None],
        excess=excess,
        level_slope=slope,
        level_step=np.sum(made.share * excess, axis=1) / weight,
        level_weight=weight,
    )


def _prior_information(problem: TireProblem, state: State) -> RealArray:
    """Return the information that is known before the records are asked."""
    u = problem.unknowns
    slope = u.prior(state.x)[1] * u.per_step(state.x)
    size = len(u) + sum(m.count for m in problem.models)
    known = np.zeros((size, size))
    known[: len(u), : len(u)] = slope.T @ slope
    at = len(u)
    for model in problem.models:
        own = np.arange(at, at + model.count)
        known[own, own] = model.prior.std**-2.0
        at += model.count
    return known


def _descended(problem: TireProblem, state: State) -> State:
    """Return the most likely point near a start."""
    u, count = problem.unknowns, len(problem.unknowns)
    value, damping = _value(problem, state), 1e-3
    # 5 to 15 steps are needed.
    for _ in range(60):
        scores = [_scores(problem, state, i) for i in range(len(problem.models))]
        away, slope = u.prior(state.x)
        information = _prior_information(problem, state)
        gradient = np.zeros(len(information))
        gradient[:count] = -(slope * u.per_step(state.x)).T @ away
        at = count
        for model, one, own in zip(problem.models, scores, state.roads, strict=True):
            place = [*range(count), *range(at, at + model.count)]
            flat = one.cells.reshape(-1, len(place))
            information[np.ix_(place, place)] += flat.T @ flat
            gradient[place] += flat.T @ one.excess.ravel()
            gradient[at : at + model.count] -= (own - model.prior.mean) / model.prior.std**2
            at += model.count
        low, high = state.x <= u.lower, state.x >= u.upper
        stuck = np.flatnonzero((low & (gradient[:count] < 0)) | (high & (gradient[:count] > 0)))
        gradient[stuck] = 0.0
        information[stuck] = information[:, stuck] = 0.0
        information[stuck, stuck] = 1.0
        while damping < 1e8:
            scaled = information + damping * np.diag(np.diag(information))
            trial = _moved(problem, state, scores, np.asarray(np.linalg.solve(scaled, gradient)))
            new = _value(problem, trial)
            if new <= value:
                break
            damping *= 10
        else:
            break
        gained, state, value, damping = value - new, trial, new, damping / 10
        if gained < NEGLIGIBLE_GAIN:
            break
    return state


def _moved(problem: TireProblem, state: State, scores: Sequence[Scores], step: RealArray) -> State:
    """Return a point one step on; levels follow."""
    u, count = problem.unknowns, len(problem.unknowns)
    step = np.clip(step, -LARGEST_STEP, LARGEST_STEP)
    x = np.where(u.positive, state.x * np.exp(np.where(u.positive, step[:count], 0.0)), state.x + step[:count])
    roads, levels, at = [], [], count
    for model, one, own, level in zip(problem.models, scores, state.roads, state.levels, strict=True):
        place = [*range(count), *range(at, at + model.count)]
        roads.append(own + step[at : at + model.count])
        change = one.level_step + one.level_slope @ step[place]
        levels.append(level + np.clip(change, -2 * LARGEST_STEP, 2 * LARGEST_STEP))
        at += model.count
    return State(x=np.clip(x, u.lower, u.upper), roads=tuple(roads), levels=tuple(levels))
