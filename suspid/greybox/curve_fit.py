"""Fit of spring, damper curve and friction of a strut, with the true motion of the strut unknown at every sample.

Unknown are the spline of the strut's travel (one coefficient for each sample), the stiffness, the forces at the nodes
and the friction. Minimised is the sum of squares of what both signals of `strut_motion` differ from their noise-free
values, over their noise: errors in variables. Steps of Gauss and Newton eliminate the spline by a banded solution.
What the strut does between the samples passes the filter that both sides are compared behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.greybox.force_basis import node_slope, node_weights, sign_between, sign_slope
from suspid.greybox.latent_splines import (
    CORNER_SHARE,
    FILTER_STEPS,
    FINE_POINTS,
    SPLINE_DEGREE,
    at_samples,
    between_samples,
    filtered,
    filtered_samples,
    spline_through,
    stencils,
)
from suspid.greybox.strut_motion import StrutMotion
from suspid.units import Hertz, MetrePerSecond, RealArray, Second

# Errors of velocity [sd] over which the sign of friction is smoothed, in the derivative alone.
SMOOTH = 3.0
# Blocks whose scores are independent [s]: several times as long as noise in the motion lasts.
SCORE_BLOCK: Second = 0.5
# Frequencies below which the integral of accelerations is not used to begin with [Hz].
LOWEST: Hertz = 0.3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Noise:
    """Standard deviations of both signals, and of the velocity that follows from them."""

    force: float  # [N]
    motion: float  # [m/s2 or m]
    velocity: MetrePerSecond = 1e-3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Shape:
    """Nodes of a curve, and whether there is friction; the unknowns are k, the forces at nodes but rest, friction."""

    nodes: RealArray
    friction: bool

    @property
    def moving(self) -> RealArray:
        """Velocities of the nodes but the one at rest [m/s]."""
        return np.asarray(self.nodes[self.nodes != 0])

    def forces(self, theta: RealArray) -> RealArray:
        """Return the forces at all nodes."""
        out = np.zeros(len(self.nodes))
        out[self.nodes != 0] = theta[1 : len(self.nodes)]
        return out

    def columns(self, x: RealArray, v: RealArray, error: MetrePerSecond) -> RealArray:
        """Return the force per unknown at given travel and velocity, (time, unknown)."""
        parts = [x[:, None], node_weights(v, self.nodes)[:, self.nodes != 0]]
        return np.hstack([*parts, sign_between(v, error)[:, None]] if self.friction else parts)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Linearised:
    """One record about the present values, with its spline and its offset eliminated."""

    normal: RealArray  # (unknown, unknown)
    gradient: RealArray  # (unknown,)
    change: RealArray  # of the spline, (coefficient,)
    per_unknown: RealArray  # change of the spline that an unknown takes back, (coefficient, unknown)
    scores: RealArray  # (block, unknown)
    force_residual: RealArray  # [N], (sample,)
    velocity: RealArray  # (sample,)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class CurveFit:
    """Values of the unknowns, their covariance, and the records about them."""

    theta: RealArray
    covariance: RealArray
    splines: tuple[RealArray, ...]
    records: tuple[Linearised, ...]
    steps: int
    settled: bool


def first_spline(motion: StrutMotion) -> RealArray:
    """Return the spline to begin with: the integral of accelerations above `LOWEST`."""
    acceleration = motion.motion - motion.share * motion.force
    f = np.fft.rfftfreq(len(acceleration), motion.step)
    lines = np.fft.rfft(acceleration - np.mean(acceleration))
    lines[1:] *= pass_high(np.asarray(f[1:], float)) / (2j * np.pi * f[1:]) ** 2
    lines[0] = 0
    return spline_through(np.fft.irfft(lines, len(acceleration)))


def pass_high(f: RealArray) -> RealArray:
    """Return by how much frequencies pass [Hz]: those above the lowest one."""
    return np.asarray((f / LOWEST) ** 8 / (1 + (f / LOWEST) ** 8))


def fitted_curve(
    motions: Sequence[StrutMotion], shape: Shape, theta: RealArray, splines: Sequence[RealArray], noise: Noise
) -> CurveFit:
    """Return the fit from a start."""
    splines, settled, step = list(splines), False, 0
    # Friction that changes its sign at another sample keeps steps from vanishing.
    while step < 15 and not settled:
        step += 1
        parts = [linearised(m, shape, theta, c, noise) for m, c in zip(motions, splines, strict=True)]
        normal, gradient = sum(p.normal for p in parts), sum(p.gradient for p in parts)
        move = np.linalg.solve(normal, gradient)
        # Square of a step in standard errors that ends a fit.
        settled = float(gradient @ move) < 0.04
        theta = theta + move
        splines = [c + p.change - p.per_unknown @ move for c, p in zip(splines, parts, strict=True)]
    parts = [linearised(m, shape, theta, c, noise) for m, c in zip(motions, splines, strict=True)]
    inverse = np.linalg.inv(sum(p.normal for p in parts))
    scores = np.concatenate([p.scores for p in parts])
    spread = len(scores) / max(len(scores) - len(theta), 1)
    return CurveFit(
        theta=theta,
        covariance=inverse @ (scores.T @ scores) @ inverse * spread,
        splines=tuple(splines),
        records=tuple(parts),
        steps=step,
        settled=settled,
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Equations:
    """Both signals of one record about given values, in standard deviations."""

    wide: tuple[RealArray, RealArray]  # derivatives by the spline, (sample, coefficient of the sample)
    narrow: tuple[RealArray, RealArray]  # derivatives by the unknowns and the offset, (sample, unknown)
    residuals: tuple[RealArray, RealArray]


def linearised(motion: StrutMotion, shape: Shape, theta: RealArray, spline: RealArray, noise: Noise) -> Linearised:
    """Return one record about given values."""
    equations = equations_of(motion, shape, theta, spline, noise)
    return _eliminated(equations, spline, motion.step, noise)


def equations_of(motion: StrutMotion, shape: Shape, theta: RealArray, spline: RealArray, noise: Noise) -> Equations:
    """Return derivatives and residuals of both signals."""
    h, count = motion.step, len(motion.force)
    v = at_samples(spline, 1, h)
    fine = shape.columns(between_samples(spline, 0, h), between_samples(spline, 1, h), noise.velocity)
    columns, ends = filtered(fine, h, CORNER_SHARE / h), _ends(count)
    columns[ends] = fine[::FINE_POINTS][ends]
    force = columns @ theta
    slope = node_slope(v, shape.nodes, shape.forces(theta))
    if shape.friction:
        slope = slope + theta[-1] * sign_slope(v, SMOOTH * noise.velocity)
    at, per_step = stencils(0)[0, :SPLINE_DEGREE], stencils(1)[0, :SPLINE_DEGREE] / h
    strut = theta[0] * at + slope[:, None] * per_step
    other = motion.motion - at_samples(spline, 2, h) - motion.share * force
    own = stencils(2)[0, :SPLINE_DEGREE] / h**2 + motion.share * strut
    level = np.ones(count) / noise.motion
    first, second = (smoothed(motion.force, h) - force) / noise.force, other / noise.motion
    offset = (level @ second) / (level @ level)
    return Equations(
        wide=(strut / noise.force, own / noise.motion),
        narrow=(
            np.column_stack([columns / noise.force, np.zeros(count)]),
            np.column_stack([motion.share * columns / noise.motion, level]),
        ),
        residuals=(first, second - offset * level),
    )


def smoothed(samples: RealArray, step: Second) -> RealArray:
    """Return samples behind the filter, but for the ends."""
    out, ends = filtered_samples(samples, step, CORNER_SHARE / step), _ends(len(samples))
    out[ends] = samples[ends]
    return out


def _ends(count: int) -> NDArray[np.intp]:
    return np.concatenate([np.arange(FILTER_STEPS), np.arange(count - FILTER_STEPS, count)])


def spline_equations(equations: Equations, dense: Sequence[RealArray], size: int) -> tuple[RealArray, RealArray]:
    """Return the bands of the normal equations of the spline, and their right sides for dense columns of both."""
    count = len(equations.residuals[0])
    bands, right = np.zeros((SPLINE_DEGREE, size)), np.zeros((size, dense[0].shape[1]))
    for rows, columns in zip(equations.wide, dense, strict=True):
        for i in range(SPLINE_DEGREE):
            right[i : i + count] += rows[:, i, None] * columns
            for j in range(i, SPLINE_DEGREE):
                bands[j - i, i : i + count] += rows[:, i] * rows[:, j]
    return bands, right


def of_spline(rows: RealArray, coefficients: RealArray) -> RealArray:
    """Return what coefficients (coefficient, column) add to a signal, (sample, column)."""
    parts = [rows[:, i, None] * coefficients[i : i + len(rows)] for i in range(SPLINE_DEGREE)]
    return np.asarray(sum(parts))


def _eliminated(equations: Equations, spline: RealArray, step: Second, noise: Noise) -> Linearised:
    """Return the normal equations of the unknowns."""
    from scipy.linalg import solveh_banded

    narrow, residuals = equations.narrow, equations.residuals
    count, size = len(residuals[0]), narrow[0].shape[1]
    dense = [np.column_stack([one, left]) for one, left in zip(narrow, residuals, strict=True)]
    bands, right = spline_equations(equations, dense, len(spline))
    solved = solveh_banded(bands, right, lower=True)
    normal = sum(one.T @ one for one in narrow) - right[:, :size].T @ solved[:, :size]
    gradient = sum(d.T @ r for d, r in zip(narrow, residuals, strict=True)) - right[:, :size].T @ solved[:, size]
    # The offset is an unknown of this record alone; its column is the last.
    apart, per = normal[:-1, -1] / normal[-1, -1], solved[:, :size]
    own = np.zeros((count, size))
    for rows, one, left in zip(equations.wide, narrow, residuals, strict=True):
        own += (one - of_spline(rows, per)) * left[:, None]
    own = own[:, :-1] - own[:, -1:] * apart
    block = max(1, round(SCORE_BLOCK / step))
    blocks = count // block
    return Linearised(
        normal=normal[:-1, :-1] - np.outer(apart, normal[-1, :-1]),
        gradient=gradient[:-1] - apart * gradient[-1],
        change=solved[:, size] - per[:, -1] * gradient[-1] / normal[-1, -1],
        per_unknown=per[:, :-1] - np.outer(per[:, -1], normal[-1, :-1] / normal[-1, -1]),
        scores=own[: blocks * block].reshape(blocks, block, -1).sum(axis=1),
        force_residual=residuals[0] * noise.force,
        velocity=at_samples(spline, 1, step),
    )
