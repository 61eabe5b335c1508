"""Fit modes that are driven by given forces: each state follows ``z' = theta z + sum_j gain_j g_j`` from ``z = 1``.

The samples of every channel are ``Re sum_k a_ck z_k`` and fixed exponentials (an offset, a drift), in white noise. The
amplitudes are linear and eliminated; poles and gains are found by damped Gauss-Newton steps. With a force that is
orthogonal to the states, the pole is that of the equivalent linear system.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from suspid.identification.noise import WhiteNoise, degrees_of_freedom
from suspid.identification.poles import MOST_GROWTH
from suspid.levels import NEGLIGIBLE_GAIN
from suspid.units import ComplexArray, RealArray

# States of motion that began with 1 stay below this, and amplitudes of motion as well: their squares must not overflow.
LARGEST_STATE = 1e50


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Drive:
    """Poles, and how forces drive them."""

    theta: ComplexArray  # (pole,): exponents per sample, upper half plane
    gains: ComplexArray  # (pole, force)
    forces: RealArray  # (force, sample): mean of each force from a sample to the next
    nuisances: RealArray  # (nuisance,): exponents of the offset and drift, held fixed
    through: bool = False  # whether the forces also show directly in the channels, as in accelerations

    @property
    def gain_places(self) -> list[tuple[int, int]]:
        """Pole and force of each gain that is free."""
        return [(k, j) for k in range(len(self.theta)) for j in range(len(self.forces))]

    @property
    def free(self) -> int:
        """Number of real parameters of poles and gains."""
        return 2 * len(self.theta) + 2 * len(self.gain_places)

    @property
    def amplitudes(self) -> int:
        """Number of real amplitudes of each channel."""
        return 2 * len(self.theta) + len(self.nuisances) + (len(self.forces) if self.through else 0)

    def moved(self, step: RealArray) -> Drive:
        """Return the drive after a step in (Re, Im of each pole; Re, Im of each free gain)."""
        poles = len(self.theta)
        change = step.reshape(-1, 2) @ np.array([1, 1j])
        theta = self.theta + change[:poles]
        highest = MOST_GROWTH / self.forces.shape[1]
        gains = self.gains.copy()
        for (k, j), more in zip(self.gain_places, change[poles:], strict=True):
            gains[k, j] += more
        return replace(self, theta=np.minimum(theta.real, highest) + 1j * np.abs(theta.imag), gains=gains)

    def with_forces(self, forces: RealArray) -> Drive:
        """Return the drive with forces (force, sample) in place of its own; new ones have gain 0."""
        gains = np.zeros((len(self.theta), len(forces)), complex)
        if len(forces) == len(self.forces):
            gains = self.gains
        return replace(self, forces=forces, gains=gains)

    def without_force(self, index: int) -> Drive:
        """Return the drive without one of the forces."""
        return replace(self, forces=np.delete(self.forces, index, axis=0), gains=np.delete(self.gains, index, axis=1))

    def with_pole(self, theta: complex) -> Drive:
        """Return the drive with one more pole, on which no force acts yet."""
        return replace(
            self,
            theta=np.append(self.theta, theta),
            gains=np.vstack([self.gains, np.zeros((1, len(self.forces)))]),
        )

    def without_pole(self, index: int) -> Drive:
        """Return the drive without one of the poles."""
        return replace(self, theta=np.delete(self.theta, index), gains=np.delete(self.gains, index, axis=0))


@dataclass(frozen=True, kw_only=True, eq=False)
class DrivenFit:
    """The amplitudes that fit a record best at given poles and gains, and what a step needs."""

    values: RealArray  # (channel, sample): the record
    drive: Drive
    noise: WhiteNoise
    free: ComplexArray  # (pole, sample): the states without forces
    states: ComplexArray  # (pole, sample): z
    answers: ComplexArray  # (pole, force, sample): derivatives of the states by the gains
    basis: RealArray  # (sample, column): orthonormal columns
    inverse: RealArray  # (column, column): amplitudes from inner products with `basis`
    coefficients: RealArray  # (column, channel)
    residual: RealArray  # (channel, sample)

    @property
    def theta(self) -> ComplexArray:
        """Exponents per sample, (pole,)."""
        return self.drive.theta

    @property
    def amplitudes(self) -> ComplexArray:
        """Complex amplitudes of the states, (pole, channel)."""
        poles = len(self.theta)
        return np.asarray(self.coefficients[:poles] - 1j * self.coefficients[poles : 2 * poles])

    @cached_property
    def squares(self) -> RealArray:
        """Residual sum of squares, (channel,)."""
        return np.asarray(np.sum(self.residual**2, axis=1))

    @property
    def variance(self) -> RealArray:
        """Variance of the residual, at least the least of the noise, (channel,)."""
        return self.noise.variance(self.squares, self.residual.shape[1])

    @cached_property
    def loss(self) -> float:
        """Minus twice the log likelihood less a constant."""
        return self.noise.loss(self.squares, self.residual.shape[1])

    @cached_property
    def cost(self) -> float:
        """What steps make less: the loss, and below the least variance the squares."""
        return self.noise.cost(self.squares, self.residual.shape[1])

    @property
    def bic(self) -> float:
        """Loss and ``log(samples)`` for each parameter."""
        unknowns = self.drive.free + len(self.residual) * self.drive.amplitudes
        return float(self.loss + unknowns * np.log(self.residual.size))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the residual of one channel."""
        channels, count = self.residual.shape
        return degrees_of_freedom(count, amplitudes=self.drive.amplitudes, poles=self.drive.free, channels=channels)

    @property
    def promised(self) -> float:
        """BIC after the next Gauss-Newton step, as the linearised model has it."""
        scale = 1 / np.sqrt(np.maximum(self.information.diagonal(), 1e-300))
        unit = self.information * np.outer(scale, scale)
        if not np.all(np.isfinite(unit)):
            return np.inf
        step = np.linalg.lstsq(unit, self.gradient * scale, rcond=1e-10)[0]
        share = min(float(step @ (self.gradient * scale)) / self.residual.size, 1 - 1e-12)
        return float(self.bic + self.residual.size * np.log1p(-share))

    @property
    def worths(self) -> RealArray:
        """What each force is worth in twice the log likelihood, from its gains and their covariance, (force,)."""
        scale = 1 / np.sqrt(np.maximum(self.information.diagonal(), 1e-300))
        unit = self.information * np.outer(scale, scale)
        places, out = self.drive.gain_places, np.zeros(len(self.drive.forces))
        if not np.all(np.isfinite(unit)):
            return out
        covariance = np.linalg.pinv(unit, rcond=1e-12, hermitian=True)
        for j in range(len(out)):
            own = [i for i, (_, force) in enumerate(places) if force == j]
            at = np.ravel([[2 * len(self.drive.theta) + 2 * i, 2 * len(self.drive.theta) + 2 * i + 1] for i in own])
            gains = np.array([self.drive.gains[places[i]] for i in own])
            parts = np.stack([gains.real, gains.imag], axis=1).ravel() / scale[at]
            out[j] = parts @ np.linalg.lstsq(covariance[np.ix_(at, at)], parts, rcond=1e-12)[0]
        return out

    @property
    def owners(self) -> NDArray[np.intp]:
        """Which pole each of the `slopes` belongs to, (parameter pair,)."""
        poles, forces = self.drive.gains.shape
        return np.concatenate([np.arange(poles), np.repeat(np.arange(poles), forces)])

    @cached_property
    def slopes(self) -> ComplexArray:
        """Derivatives of the state by its pole, then by each free gain, (parameter pair, sample)."""
        from scipy.signal import lfilter

        samples, drive = np.arange(self.states.shape[1]), self.drive
        by_pole = self.free * samples
        if not len(drive.forces):
            return np.asarray(by_pole)
        for k, (theta, gains) in enumerate(zip(drive.theta, drive.gains, strict=True)):
            turn, held = np.exp(theta), np.expm1(theta) / theta
            drift = gains @ (turn * self.answers[k, :, :-1] + (turn - held) / theta * drive.forces[:, :-1])
            by_pole[k, 1:] += lfilter([1.0], [1, -turn], drift)
        return np.concatenate([by_pole, self.answers.reshape(-1, len(samples))])

    @cached_property
    def slopes_by_channel(self) -> RealArray:
        """Derivatives of each channel by the parameters, orthogonal to the columns, (channel, sample, parameter)."""
        parts = np.concatenate([self.slopes.real, self.slopes.imag]).T
        parts = parts - self.basis @ (self.basis.T @ parts)
        half = len(self.owners)
        re, im = parts[:, :half], parts[:, half:]
        out = np.empty((len(self.residual), len(parts), 2 * half))
        for c, a in enumerate(self.amplitudes.T):
            own = a[self.owners]
            # Re(a dz) for a real step, Re(i a dz) for an imaginary one.
            out[c, :, 0::2] = re * own.real - im * own.imag
            out[c, :, 1::2] = -im * own.real - re * own.imag
        return out

    @cached_property
    def information(self) -> RealArray:
        """Fisher information of the parameters, amplitudes unknown, (parameter, parameter)."""
        return np.asarray(
            sum(s.T @ s / v for s, v in zip(self.slopes_by_channel, self.variance, strict=True)), dtype=float
        )

    @cached_property
    def gradient(self) -> RealArray:
        """Gradient of the log likelihood by the parameters, (parameter,)."""
        return np.asarray(
            sum(s.T @ r / v for s, r, v in zip(self.slopes_by_channel, self.residual, self.variance, strict=True)),
            dtype=float,
        )


def evaluate(values: RealArray, drive: Drive, noise: WhiteNoise) -> DrivenFit | None:
    """Return the fit at given poles and gains, or None where its columns are linearly dependent."""
    from scipy.linalg import solve_triangular

    samples = np.arange(values.shape[1])
    free = np.exp(np.outer(drive.theta, samples))
    states, answers = _states(drive, free)
    columns = np.column_stack([states.real.T, states.imag.T, np.exp(np.outer(samples, drive.nuisances))])
    if drive.through:
        columns = np.column_stack([columns, drive.forces.T])
    # A step that lets a state grow without bound is none.
    if not max(np.max(np.abs(columns)), np.max(np.abs(answers), initial=0.0)) < LARGEST_STATE:
        return None
    # Nor is one to a pole so near the real axis that its amplitude does.
    norms = np.linalg.norm(columns, axis=0)
    if len(columns) < columns.shape[1] or not np.all(norms > 1 / LARGEST_STATE):
        return None
    basis, triangle = np.linalg.qr(columns / norms)
    # Least pivot of the columns of unit norm: below it they are dependent.
    if not np.min(np.abs(triangle.diagonal())) > 1e-7:
        return None
    inverse = solve_triangular(triangle, np.eye(len(triangle))) / norms[:, None]
    inner = basis.T @ values.T
    return DrivenFit(
        values=values,
        drive=drive,
        noise=noise,
        free=free,
        states=states,
        answers=answers,
        basis=basis,
        inverse=inverse,
        coefficients=inverse @ inner,
        residual=values - (basis @ inner).T,
    )


def _states(drive: Drive, free: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the states (pole, sample), of which those without forces are given, and their derivatives by the gains.

    The derivatives are (pole, force, sample).
    """
    from scipy.signal import lfilter

    answers = np.zeros((len(drive.theta), *drive.forces.shape), complex)
    if not len(drive.forces):
        return free, answers
    states = free.copy()
    force = drive.forces[:, :-1].astype(complex)
    for k, (theta, gains) in enumerate(zip(drive.theta, drive.gains, strict=True)):
        # A force that is constant between samples: z_{i+1} = e^theta z_i + (e^theta - 1) / theta g_i.
        answers[k, :, 1:] = lfilter([np.expm1(theta) / theta], [1, -np.exp(theta)], force)
        states[k] += gains @ answers[k]
    return states, answers


def maximize(values: RealArray, start: Drive, noise: WhiteNoise, *, steps: int) -> DrivenFit | None:
    """Return the fit of greatest likelihood near given poles and gains, by damped Gauss-Newton steps."""
    fit = evaluate(values, start, noise)
    if fit is None or not fit.drive.free:
        return fit
    damping = 1e-3
    for _ in range(steps):
        scale = np.sqrt(np.maximum(fit.information.diagonal(), 1e-300))
        unit, slope = fit.information / np.outer(scale, scale), fit.gradient / scale
        if not (np.all(np.isfinite(unit)) and np.all(np.isfinite(slope))):
            return fit
        curvature, axes = np.linalg.eigh(unit)
        curvature, along = np.maximum(curvature, 0.0), axes.T @ slope
        better = None
        for _ in range(10):
            part = along / (curvature + damping)
            if float(part @ along) < NEGLIGIBLE_GAIN:
                return fit
            trial = evaluate(values, fit.drive.moved(axes @ part / scale), noise)
            if trial is not None and trial.cost < fit.cost:
                better = trial
                break
            damping = max(10 * damping, 1e-4)
        if better is None:
            return fit
        fit, damping = better, damping / 10
    return fit
