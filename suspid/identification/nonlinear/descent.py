"""Fit structures to records: damped Gauss-Newton steps that follow the bend of narrow valleys."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.nonlinear.forces import ForceKind
from suspid.identification.nonlinear.motion import Structures, steps_of
from suspid.identification.nonlinear.structure import (
    CHANGE,
    StructureFit,
    evaluated,
    gains_of,
    jumps_of,
    least_jumps,
    parameters_of,
    with_parameters,
)
from suspid.levels import EXACT
from suspid.units import RealArray

# Fall of the loss at which a fit ends.
SETTLED = 0.1
# Least damping after a refused step.
LEAST_DAMPING = 1e-3
# Share of a step at which its bend is measured, and the largest bend that is followed, as a share of the step: that
# of the reference.
PROBE, MOST_BEND = 0.1, 0.375
# A fit may make a motion take this many times the steps of its start: a pole that runs away would take minutes.
MOST_STEPS_OVER = 2


@dataclass(frozen=True, slots=True)
class Steps:
    """How a fit proceeds: steps at most, tries of each, and what divides the damping after a step, or multiplies it."""

    most: int
    tries: int
    less: float
    more: float
    bends: bool  # whether steps follow the bend of a valley


# A start without forces takes 4 to 8 steps, along a narrow valley 20; larger factors leave the valley again and again.
SMOOTH_STEPS = Steps(most=25, tries=6, less=5.0, more=5.0, bends=True)
# Where friction holds a mass the likelihood has no bend, and each motion takes ten times as long: first steps are few
# and large, and only last ones find the way between the kinks.
RUBBED_FIRST = Steps(most=15, tries=4, less=10.0, more=30.0, bends=False)
RUBBED_STEPS = Steps(most=25, tries=8, less=5.0, more=5.0, bends=False)


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """What is known of the parameters that a fit moves beside a record: values and standard deviations, (moved,)."""

    values: RealArray
    std: RealArray

    @classmethod
    def of(cls, structures: Structures, *, share: float, none: float) -> Around:
        """Return the parameters of a structure, each known to a share of the largest of its kind.

        What is zero is so to another share: a force that does nothing to a mass.
        """
        values, parts = _moved_by_fits(structures), (2 * structures.theta.size, 2 * structures.shapes.size)
        kinds = np.split(values, np.cumsum(parts))
        largest = np.concatenate([np.full(len(kind), np.max(np.abs(kind), initial=1e-300)) for kind in kinds])
        return cls(values, np.where(np.abs(values) < EXACT * largest, none, share) * largest)

    def apart(self, fit: StructureFit) -> RealArray:
        """Return by how many standard deviations each parameter is off."""
        return np.asarray((_moved_by_fits(fit.structures) - self.values) / self.std)


def fitted(start: StructureFit, *, steps: int | None = None, around: Around | None = None) -> StructureFit:
    """Return the fit of greatest likelihood near a start, by damped Gauss-Newton steps.

    Where the parameters of a force and those of a pole hardly differ, the likelihood falls along a narrow bent valley.
    After a refused step, steps follow the bend: to first order in how the slopes change along them.

    References
    ----------
    Transtrum, M. K. and Sethna, J. P. (2012). Improvements to the Levenberg-Marquardt algorithm for nonlinear
    least-squares minimization. arXiv:1201.5885.
    """
    fit, damping, refused = start, LEAST_DAMPING, False
    pace = SMOOTH_STEPS
    if start.structures.kind is ForceKind.FRICTION:
        pace = RUBBED_STEPS if steps is None else RUBBED_FIRST
    longest = MOST_STEPS_OVER * steps_of(start.theta, start.residual.shape[1], start.structures.kind)
    for _ in range(pace.most if steps is None else steps):
        at = _moved_by_fits(fit.structures)
        along = _along(fit.structures, at)
        slopes = along @ fit.nearby.slopes(fit)
        if around is not None:
            slopes = np.concatenate([slopes, np.diag(1 / around.std)], axis=1)
        scale = 1 / np.maximum(np.linalg.norm(slopes, axis=1), 1e-300)
        unit = slopes * scale[:, None]
        left = -_weighted(fit, fit, around)
        information, gradient = unit @ unit.T, unit @ left
        if not (np.all(np.isfinite(information)) and np.all(np.isfinite(gradient))):
            return fit
        better, before = None, _cost(fit, around)
        for _ in range(pace.tries):
            damped = information + damping * np.eye(len(information))
            step = np.linalg.lstsq(damped, gradient, rcond=None)[0]
            if refused and pace.bends:
                near = _moved(fit, at + PROBE * step * scale, longest)
                bend = (
                    None if near is None else 2 / PROBE * ((_weighted(near, fit, around) + left) / PROBE - step @ unit)
                )
                if bend is not None and np.all(np.isfinite(bend)):
                    turn = -0.5 * np.linalg.lstsq(damped, unit @ bend, rcond=None)[0]
                    step = step + turn if np.linalg.norm(turn) < MOST_BEND * np.linalg.norm(step) else step
            trial = _moved(fit, at + step * scale, longest)
            if trial is not None and _cost(trial, around) < before:
                better = trial
                break
            refused, damping = True, max(pace.more * damping, LEAST_DAMPING)
        if better is None:
            return fit
        fit, damping = better, damping / pace.less
        if before - _cost(fit, around) < SETTLED:
            return fit
    return fit


def _moved_by_fits(of: Structures) -> RealArray:
    """Return the parameters that a fit moves, (moved,).

    Of as many modes as channels they are poles, displacements and by how much each force slows each mass: gains follow,
    as no force moves a mass at once. With gains of their own, that would leave a narrow bent valley.
    """
    every: RealArray = parameters_of(of)[0]
    if not _settled(of):
        return every
    return np.concatenate([every[: 2 * (of.theta.size + of.shapes.size)], _slowed(of).ravel()])


def _along(of: Structures, at: RealArray) -> RealArray:
    """Return the derivatives of all parameters by those that a fit moves, (moved, parameter), at their values."""
    if not _settled(of):
        return np.eye(len(at))
    steps = np.maximum(CHANGE * np.abs(at), CHANGE * 1e-3 * np.max(np.abs(at)))
    near = parameters_of(_placed(of, at + np.vstack([np.diag(steps), -np.diag(steps)])))
    return np.asarray((near[: len(at)] - near[len(at) :]) / (2 * steps[:, None]))


def _settled(of: Structures) -> bool:
    """Return whether gains follow from what forces do to the masses: there are as many modes as channels."""
    return bool(of.theta.shape[1] == of.shapes.shape[2])


def _slowed(of: Structures) -> RealArray:
    """Return by how much each force slows each mass, (channel, force)."""
    speeds = of.shapes[0] * of.theta[0][:, None]
    return np.asarray(-(speeds.T @ of.gains[0]).real)


def _placed(of: Structures, free: RealArray) -> Structures:
    """Return structures with other parameters of those that a fit moves, (structure, moved)."""
    poles, channels = of.shapes.shape[1:]
    if not _settled(of):
        return with_parameters(of, free)
    count = poles * (1 + channels)
    every = free[:, : 2 * count : 2] + 1j * free[:, 1 : 2 * count : 2]
    theta, shapes = every[:, :poles], every[:, poles:].reshape(-1, poles, channels)
    slowed = free[:, 2 * count :].reshape(-1, channels, len(of.forces))
    return replace(of, theta=theta, shapes=shapes, gains=gains_of(theta, shapes, slowed))


def _moved(fit: StructureFit, free: RealArray, longest: int) -> StructureFit | None:
    """Return the fit with other parameters, None where its motion would take more steps than the longest."""
    structures = _placed(fit.structures, free[None])
    steps = steps_of(structures.theta[0], fit.residual.shape[1], structures.kind)
    possible = _possible(structures, fit) and steps <= longest
    return evaluated(fit.record, structures, fit.order) if possible else None


def _weighted(fit: StructureFit, of: StructureFit, around: Around | None) -> RealArray:
    """Return the motion less the record, the jumps, and what is off, over the standard deviations of another fit."""
    jumps = jumps_of(fit.structures) / least_jumps(of.structures)
    parts = [(-fit.residual / np.sqrt(of.variance)[:, None]).ravel(), jumps.ravel()]
    return np.concatenate(parts if around is None else [*parts, around.apart(fit)])


def _possible(structures: Structures, before: StructureFit) -> bool:
    """Return whether poles turn, and not more than twice as fast as before the step."""
    theta = structures.theta[0]
    return bool(np.all(theta.imag > 0) and np.max(np.abs(theta)) < 2 * np.max(np.abs(before.theta)))


def _cost(fit: StructureFit, around: Around | None) -> float:
    jumps = float(np.sum((jumps_of(fit.structures) / least_jumps(fit.structures)) ** 2))
    cost = fit.record.noise.cost(fit.squares, fit.residual.shape[1]) + jumps
    cost += 0.0 if around is None else float(np.sum(around.apart(fit) ** 2))
    return cost if np.isfinite(cost) else np.inf
