"""Fit of tires and wheel masses to two axles on one track (Whittle's likelihood of the slopes under both wheels).

``sum log det S - 2 log |det M| + tr S^-1 P`` over stretches and lines is minimised by Fisher scoring; P are the slopes
that the map M of the car makes of the records, anew at every step. What the first step found of the suspension and of
the sensors comes in as data with its covariance: it is let go as far as it is uncertain, and returned as it was. The
equations of the scores hold at the truth whatever the speed did; they are of spectra, of which none has to be known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from suspid.greybox.axle_data import Behind, Lag
from suspid.greybox.axle_model import LATE_STD, AxleModel, Expected, Spectral
from suspid.greybox.road_maps import RoadMap
from suspid.greybox.tire_fit import scatter
from suspid.reconstruction import LARGEST_STEP, Unknowns
from suspid.units import ComplexArray, Ratio, RealArray

# Way that is left of tires, masses and the first step, in standard deviations of each: it ends the search. The value
# stalls before the scores are zero: it is that of a constant delay in each stretch, and they are not its derivatives.
WAY_LEFT = 0.03
LAG_STD: Ratio = 0.05  # of the stated distance of the axles, and of the scale of the speed


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AxleProblem:
    """What is unknown: of the first step in its standard deviations, of tires and masses, the lag, and roads."""

    models: tuple[AxleModel, ...]
    unknowns: Unknowns  # of the second step
    found: RealArray  # z of the first step, without bounds: on them its errors have no mean of zero
    spread: RealArray  # (z, component): square root of its covariance

    @property
    def shared(self) -> int:
        """Number of unknowns that all models share."""
        return int(self.spread.shape[1]) + len(self.unknowns) + 2

    def at(self, state: AxleState, model: AxleModel) -> tuple[RealArray, RealArray, RoadMap, Lag]:
        """Return z, x, the maps of a model, and the lag."""
        z = self.found + self.spread @ state.off
        return z, state.x, model.maps.maps(model.s, z, state.x), state.lag(model.behind)

    @property
    def prior_std(self) -> RealArray:
        """Standard deviations of all unknowns but x, which has its own prior; infinite there."""
        u = np.full(len(self.unknowns), np.inf)
        return np.concatenate([np.ones(self.spread.shape[1]), u, [LAG_STD, 1.0], *(m.prior.std for m in self.models)])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AxleState:
    """A point of the search."""

    off: RealArray  # components of the first step
    x: RealArray
    log_lag: float  # over the stated one, of all tracks
    late: float  # time besides, in `LATE_STD`
    own: tuple[RealArray, ...]  # by model
    levels: tuple[RealArray, ...]  # by model, (stretch,)

    def lag(self, behind: Behind) -> Lag:
        """Return how much later the rear wheel of a pair meets the road."""
        return Lag(behind.lag * float(np.exp(self.log_lag)), LATE_STD * self.late)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Cells:
    """Whitened derivatives of one model, less what the levels explain, and the excess of what was measured."""

    slopes: RealArray  # (stretch, cell, unknown): shared ones first
    excess: RealArray  # (stretch, cell)
    level_slope: RealArray  # (stretch, unknown)
    level_step: RealArray  # (stretch,)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AxleFit:
    """The best tires and wheel masses."""

    state: AxleState
    covariance: RealArray  # (unknown, unknown) of x
    by_found: RealArray  # (unknown, component): change of x with what the first step found
    lag_covariance: RealArray  # (2, 2): of the logarithm of the way, and of the time in `LATE_STD`


def fit_axles(problem: AxleProblem, first: AxleState) -> AxleFit:
    """Return the best fit near a start."""
    state = _descended(problem, first)
    power = [_measured(problem, state, model) for model in problem.models]
    information, gradient, every = _equation(problem, state, power)
    stated, _ = _known(problem, state)
    spread = stated.copy()
    together: dict[int, RealArray] = {}
    for number, (model, cells) in enumerate(zip(problem.models, every, strict=True)):
        place = _place(problem, number)
        flat = cells.slopes.reshape(-1, len(place))
        stated[np.ix_(place, place)] += model.taper_loss * flat.T @ flat
        each = cells.slopes * cells.excess[:, :, None]
        by_line = each.reshape(len(each), -1, 4, len(place)).sum(axis=2)
        # Tracks of one drive are two paths over one road: their scores are not independent.
        shared = together.setdefault(model.maps.number, np.zeros((*by_line.shape[:2], len(gradient))))
        shared[:, :, place] += by_line
    spread += sum(map(scatter, together.values()))
    stuck = _stuck(problem, state, gradient)
    stuck = stuck[stuck >= problem.shared]
    hold(information, gradient, stuck)
    for one in (stated, spread):
        one[stuck] = one[:, stuck] = 0.0
    inverse = np.linalg.inv(information)
    whole, seen = inverse @ stated @ inverse, inverse @ spread @ inverse
    # The scatter of what is left after the fit is smaller than before it; where it is larger still, it counts.
    wider = np.sqrt(np.maximum(1.0, np.diag(seen) / np.where(np.diag(whole) > 0, np.diag(whole), 1.0)))
    whole = wider[:, None] * whole * wider
    size, count = problem.spread.shape[1], len(problem.unknowns)
    x = slice(size, size + count)
    natural = problem.unknowns.per_step(state.x)
    return AxleFit(
        state=state,
        covariance=natural[:, None] * whole[x, x] * natural,
        by_found=natural[:, None] * inverse[x, :size],
        lag_covariance=whole[size + count : problem.shared, size + count : problem.shared],
    )


def _place(problem: AxleProblem, number: int) -> list[int]:
    """Return where the unknowns of a model stand among all."""
    at = problem.shared + sum(m.count for m in problem.models[:number])
    return [*range(problem.shared), *range(at, at + problem.models[number].count)]


def _measured(problem: AxleProblem, state: AxleState, model: AxleModel) -> ComplexArray:
    z, x, _, lag = problem.at(state, model)
    return model.measured(z, x, lag)


def first_state(
    problem: AxleProblem, start: RealArray, own: Sequence[RealArray]
) -> tuple[AxleState, tuple[RealArray, ...]]:
    """Return where the search begins, at the lag of greatest coherence, and this by model at the lines.

    It begins from tires and wheel masses ``start`` on, and from each model's own unknowns.
    """
    state = AxleState(
        off=np.zeros(problem.spread.shape[1]),
        x=start,
        log_lag=0.0,
        late=0.0,
        own=tuple(own),
        levels=tuple(np.zeros(m.stretches) for m in problem.models),
    )
    # Within three standard deviations of the stated lag, in steps of a few degrees at the highest line.
    tried = np.linspace(-3 * LAG_STD, 3 * LAG_STD, 61)
    in_phase, levels = [], []
    for model in problem.models:
        power = _measured(problem, state, model)
        late = model.s.imag * (model.behind.lag * np.exp(-model.road.track.log_speed))[:, None]
        scale = np.sqrt(np.mean(power[..., 0, 0].real, axis=0) * np.mean(power[..., 1, 1].real, axis=0))
        turns = np.exp(-1j * late * np.expm1(tried)[:, None, None])
        in_phase.append(np.mean((power[..., 0, 1] * turns).real, axis=1) / scale)
        levels.append(np.mean(np.log((power[..., 0, 0] + power[..., 1, 1]).real / 2), axis=1))
    best = int(np.argmax(np.median(np.concatenate(in_phase, axis=1), axis=1)))
    coherence = tuple(one[best] for one in in_phase)
    return replace(state, log_lag=float(tried[best]), levels=tuple(levels)), coherence


def _value(problem: AxleProblem, state: AxleState) -> tuple[float, list[ComplexArray]]:
    """Return minus the logarithm of the likelihood and of what is known before, and what was measured."""
    prior = problem.unknowns.prior(state.x)[0]
    off = _off(problem, state) / problem.prior_std
    value, every = float(prior @ prior + off @ off) / 2, []
    for number, model in enumerate(problem.models):
        _, _, here, lag = problem.at(state, model)
        S = model.expected(here, state.own[number], state.levels[number], lag).whole
        power = _measured(problem, state, model)
        det = (S[..., 0, 0] * S[..., 1, 1]).real - np.abs(S[..., 0, 1]) ** 2
        trace = (S[..., 1, 1] * power[..., 0, 0] + S[..., 0, 0] * power[..., 1, 1]).real
        trace = trace - 2 * (S[..., 0, 1] * power[..., 1, 0]).real
        value += float(np.sum(np.log(det) + trace / det))
        # All tracks share one map.
        shared = 2 / len(model.maps.roads)
        value -= 2 * shared * model.stretches * float(np.sum(np.linalg.slogdet(here.roads)[1]))
        every.append(power)
    return value, every


def _off(problem: AxleProblem, state: AxleState) -> RealArray:
    """Return all unknowns less their means before the record is asked; 0 for x."""
    own = [own - model.prior.mean for model, own in zip(problem.models, state.own, strict=True)]
    return np.concatenate([state.off, np.zeros(len(state.x)), [state.log_lag, state.late], *own])


def _known(problem: AxleProblem, state: AxleState) -> tuple[RealArray, RealArray]:
    """Return information and gradient of what is known before the record is asked."""
    u, first = problem.unknowns, problem.spread.shape[1]
    information = np.diag(problem.prior_std**-2.0)
    gradient = -_off(problem, state) * np.diag(information)
    away, slope = u.prior(state.x)
    slope = slope * u.per_step(state.x)
    x = slice(first, first + len(u))
    information[x, x] += slope.T @ slope
    gradient[x] -= slope.T @ away
    return information, gradient


def _cells(problem: AxleProblem, state: AxleState, number: int, power: ComplexArray) -> Cells:
    """Return the derivatives of one model at a point of the search."""
    model, u = problem.models[number], problem.unknowns
    z, x, here, lag = problem.at(state, model)
    made: Expected = model.expected(here, state.own[number], state.levels[number], lag)
    nothing_z, nothing_x = np.zeros(len(z)), np.zeros(len(x))
    directions = [(row, nothing_x) for row in problem.spread.T]
    directions += [(nothing_z, row) for row in np.diag(u.per_step(x))]
    columns = model.by_car(here, made, z, x, directions)
    columns += model.by_lag(made, lag)
    columns += model.by_own(here, state.own[number], made)
    root: ComplexArray = np.asarray(np.linalg.inv(np.linalg.cholesky(made.whole)), complex)
    share = _flat(root, made.road)
    slopes, excess = np.stack([_flat(root, one) for one in columns], axis=2), _flat(root, power - made.whole)
    weight = np.sum(share**2, axis=1)
    slope = -np.einsum("jc,jci->ji", share, slopes) / weight[:, None]
    return Cells(
        slopes=slopes + share[:, :, None] * slope[:, None],
        excess=excess,
        level_slope=slope,
        level_step=np.sum(share * excess, axis=1) / weight,
    )


def _flat(root: Spectral, matrix: Spectral) -> RealArray:
    """Return Hermitian matrices, whitened, as four real numbers of equal variance at each line, (stretch, cell)."""
    one = root @ matrix @ root.conj().swapaxes(2, 3)
    across = np.sqrt(2) * one[..., 0, 1]
    rows = np.stack([one[..., 0, 0].real, one[..., 1, 1].real, across.real, across.imag], axis=-1)
    return np.asarray(rows.reshape(len(rows), -1))


def _descended(problem: AxleProblem, state: AxleState) -> AxleState:
    """Return the most likely point near a start."""
    (value, power), damping = _value(problem, state), 1e-3
    # About 10 steps are needed.
    for _ in range(60):
        information, gradient, every = _equation(problem, state, power)
        hold(information, gradient, _stuck(problem, state, gradient))
        inverse = np.linalg.inv(information)
        left = np.max(np.abs(inverse @ gradient / np.sqrt(np.diag(inverse)))[: problem.shared])
        while damping < 1e8:
            scaled = information + damping * np.diag(np.diag(information))
            trial = _moved(problem, state, every, np.asarray(np.linalg.solve(scaled, gradient)))
            new, seen = _value(problem, trial)
            if new <= value or left < WAY_LEFT:
                break
            damping *= 10
        else:
            break
        state, value, power, damping = trial, new, seen, damping / 10
        if left < WAY_LEFT:
            break
    return state


def _equation(
    problem: AxleProblem, state: AxleState, power: Sequence[ComplexArray]
) -> tuple[RealArray, RealArray, list[Cells]]:
    """Return information and gradient of all that is known and measured, and the derivatives of each model."""
    information, gradient = _known(problem, state)
    every = [_cells(problem, state, number, one) for number, one in enumerate(power)]
    for number, cells in enumerate(every):
        place = _place(problem, number)
        flat = cells.slopes.reshape(-1, len(place))
        information[np.ix_(place, place)] += flat.T @ flat
        gradient[place] += flat.T @ cells.excess.ravel()
    return information, gradient, every


def _stuck(problem: AxleProblem, state: AxleState, gradient: RealArray) -> NDArray[np.intp]:
    """Return which unknowns lie on a bound that they would cross."""
    u, first = problem.unknowns, problem.spread.shape[1]
    low, high = np.zeros(len(gradient), bool), np.zeros(len(gradient), bool)
    x = slice(first, first + len(u))
    low[x], high[x] = state.x <= u.lower, state.x >= u.upper
    low[problem.shared :] = np.concatenate([o <= m.lower for m, o in zip(problem.models, state.own, strict=True)])
    return np.flatnonzero((low & (gradient < 0)) | (high & (gradient > 0)))


def hold(information: RealArray, gradient: RealArray, which: NDArray[np.intp]) -> None:
    """Take unknowns out of an equation of steps, in place."""
    gradient[which] = 0.0
    information[which] = information[:, which] = 0.0
    information[which, which] = 1.0


def _moved(problem: AxleProblem, state: AxleState, every: Sequence[Cells], step: RealArray) -> AxleState:
    """Return a point one step on; levels follow."""
    u, first = problem.unknowns, problem.spread.shape[1]
    # Unknowns of roads, logarithms of which some go a long way, take longer steps than the car.
    longest = np.where(np.arange(len(step)) < problem.shared, LARGEST_STEP, 4 * LARGEST_STEP)
    longest[problem.shared :][np.concatenate([np.isfinite(m.lower) for m in problem.models])] = np.inf
    step = np.clip(step, -longest, longest)
    by_x = step[first : first + len(u)]
    x = np.where(u.positive, state.x * np.exp(np.where(u.positive, by_x, 0.0)), state.x + by_x)
    own, levels = [], []
    for number, cells in enumerate(every):
        place = _place(problem, number)
        own.append(np.maximum(state.own[number] + step[place[problem.shared :]], problem.models[number].lower))
        change = cells.level_step + cells.level_slope @ step[place]
        levels.append(state.levels[number] + np.clip(change, -2 * LARGEST_STEP, 2 * LARGEST_STEP))
    return AxleState(
        off=state.off + step[:first],
        x=np.clip(x, u.lower, u.upper),
        log_lag=state.log_lag + float(step[first + len(u)]),
        late=state.late + float(step[first + len(u) + 1]),
        own=tuple(own),
        levels=tuple(levels),
    )
