"""Residuals of poles and shapes as functions of the parameters of a suspension, with derivatives.

The parameters are one vector p of stiffnesses [N/m], dampings [N s/m] and masses [kg], see
`suspid.reconstruction.unknowns`; every function takes the arms (strut, coordinate) and p, and returns a dimensionless
residual with its derivatives by p.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from suspid.model import pole_distances
from suspid.units import ComplexArray, RealArray

EXACT_POLE = 1e-8  # relative pole error that counts as zero: the accuracy of an eigenvalue solver, with a margin


@dataclass(frozen=True, kw_only=True, eq=False)
class Observed:
    """The modes of one test, as equations for the parameters."""

    poles: ComplexArray  # those not at zero, (mode,) [rad/s]
    rigid: int  # number of those at zero
    real: NDArray[np.bool_]  # overdamped modes: neither pole nor shape has an imaginary part
    # (channel, mode): velocities over the modulus of the pole, accelerations over its square; largest component 1
    shapes: ComplexArray | None
    orders: NDArray[np.intp]  # (channel,): 0, 1, 2 for displacement, velocity, acceleration
    weights: RealArray  # (channel, coordinate): what each channel shows, per unit of each coordinate
    added: RealArray  # (coordinate,): known masses added in this test [kg]
    whiten: RealArray | None  # makes the rows of `sensitivities` uncorrelated and of variance 1
    poles_alone: bool  # only the poles are weighed; the shapes then only choose among suspensions
    # (mode,): where `spectral` takes the determinant, its value there, and what it is divided by
    nodes: ComplexArray
    target: ComplexArray
    spacing: ComplexArray

    @cached_property
    def full(self) -> bool:
        """Whether the channels show the motion of every coordinate."""
        return self.shapes is not None and int(np.linalg.matrix_rank(self.weights)) == self.weights.shape[1]

    @property
    def weighed_shapes(self) -> ComplexArray | None:
        """The shapes, unless the poles alone have a covariance."""
        return None if self.poles_alone else self.shapes

    @cached_property
    def pole_equations(self) -> int:
        """Number of real equations of the poles."""
        return int(2 * len(self.real) - np.sum(self.real))

    @property
    def alone(self) -> bool:
        """Whether there is nothing but poles, and no covariance: then their polynomial decides."""
        return self.whiten is None and self.shapes is None

    @property
    def equations(self) -> int:
        """Number of real equations of poles and shapes."""
        return self.pole_equations * (1 if self.shapes is None else len(self.shapes))

    @property
    def rows(self) -> int:
        """Number of real equations that are weighed."""
        return self.pole_equations if self.poles_alone else self.equations


def partners(poles: ComplexArray, found: ComplexArray) -> NDArray[np.intp]:
    """Return, for each pole, the index of its partner among those found; each partner is used once."""
    distances = pole_distances(poles, found)
    nearest = np.argmin(distances, axis=1)
    if len(set(nearest.tolist())) == len(nearest):
        return np.asarray(nearest)
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(distances)[1])


def all_poles(poles: ComplexArray) -> ComplexArray:
    """Return the poles, followed by the conjugates of the complex ones."""
    return np.concatenate([poles, poles[poles.imag != 0].conj()])


def deciding(test: Observed, arms: RealArray, p: RealArray) -> tuple[RealArray, RealArray]:
    """Return the weighted residual of poles and shapes that is minimised, and its derivatives by p."""
    residual, slope = sensitivities(test, arms, p)
    if test.whiten is None:
        # Errors of shapes are about ten times as large as those of poles.
        weights = np.where(np.arange(len(residual)) < test.pole_equations, 1.0, 0.1)
        return weights * residual, weights[:, None] * slope
    return test.whiten @ residual, test.whiten @ slope


def linear(test: Observed, arms: RealArray, masses: RealArray) -> tuple[RealArray, RealArray]:
    """Return ``(lambda^2 M + lambda C + K) psi`` at p = 0, relative to its first term, and its derivatives by p.

    It is linear in p, so this holds for any p. ``masses`` [kg] make it dimensionless.
    """
    motion, roots = motion_of(test), np.sqrt(masses + test.added)
    motion = motion / np.linalg.norm(motion * roots, axis=1, keepdims=True)
    modes, n = motion.shape
    travel = motion @ arms.T  # (mode, strut)
    # (mode, coordinate, strut): the force of each strut per unit of stiffness, over the inertia.
    springs = travel[:, None, :] * arms.T / roots[:, None] / test.poles[:, None, None] ** 2
    inertia = (motion / roots)[:, :, None] * np.eye(n)
    slope = np.concatenate([springs, springs * test.poles[:, None, None], inertia], axis=2).reshape(modes * n, -1)
    residual = (motion * test.added / roots).ravel()
    real = np.repeat(test.real, n)
    return _real_rows(residual, real), _real_rows(slope, real)


def motion_of(test: Observed) -> ComplexArray:
    """Return the motion of every coordinate, (mode, coordinate), from channels that determine it."""
    assert test.shapes is not None
    displacements = test.shapes.T / (test.poles / np.abs(test.poles))[:, None] ** test.orders
    return np.asarray(np.linalg.lstsq(test.weights.astype(complex), displacements.T, rcond=None)[0].T)


def spectral(test: Observed, arms: RealArray, p: RealArray) -> tuple[RealArray, RealArray]:
    """Return ``det(lambda^2 M + lambda C + K) / det M`` at the given poles, and its derivatives by p, (…, parameter).

    Divided by the product of the distances to all other poles, it is the relative error of the pole near a solution.
    As a polynomial it needs no pairing of poles and stays smooth where a pair becomes overdamped.
    """
    struts, n = arms.shape
    nodes, masses = test.nodes, p[..., 2 * struts :] + test.added
    light = (arms / np.sqrt(masses)[..., None, :])[..., None, :, :]  # (…, 1, strut, coordinate)
    forces = p[..., None, :struts] + nodes[:, None] * p[..., None, struts : 2 * struts]
    dynamic = nodes[:, None, None] ** 2 * np.eye(n) + (light.swapaxes(-1, -2) * forces[..., None, :]) @ light
    U, S, Vh = np.linalg.svd(dynamic)
    others = np.stack([np.prod(np.delete(S, i, axis=-1), axis=-1) for i in range(n)], axis=-1)
    turn = np.linalg.det(U) * np.linalg.det(Vh)
    adjugate = (Vh.conj().swapaxes(-1, -2) * others[..., None, :]) @ U.conj().swapaxes(-1, -2)
    value, share = turn * np.prod(S, axis=-1), turn / test.spacing
    per_force = share[..., None] * np.sum((light @ adjugate) * light, axis=-1)
    own = nodes[:, None] ** 2 * np.diagonal(adjugate, axis1=-2, axis2=-1)
    per_mass = (share[..., None] * own - (value / test.spacing)[..., None]) / masses[..., None, :]
    slope = np.concatenate([per_force, nodes[:, None] * per_force, per_mass], axis=-1)
    residual = (value - test.target) / test.spacing
    pair = ~test.real
    return (
        np.concatenate([residual.real, residual.imag[..., pair]], axis=-1),
        np.concatenate([slope.real, slope.imag[..., pair, :]], axis=-2),
    )


def spectral_nodes(
    poles: ComplexArray, real: NDArray[np.bool_], rigid: int, coordinates: int
) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return `Observed.nodes`, `target` and `spacing`.

    The nodes are the poles and the targets zero. Where poles coincide (critical damping), the value at one does not
    determine the others; if all poles are known, distinct points near them serve as nodes instead.
    """
    size = np.abs(poles)
    everything = all_poles(np.concatenate([poles, np.zeros(rigid)]))
    if len(everything) < 2 * coordinates:
        return poles, np.zeros_like(poles), np.asarray(poles / size * size ** (2 * coordinates))
    near = 0.02 * size
    nodes = np.where(real, poles, poles.real + 1j * np.maximum(poles.imag, near))
    for i in range(1, len(nodes)):
        while np.any(np.abs(nodes[:i] - nodes[i]) < near[i]):
            nodes[i] *= 1.03
    target = np.prod(nodes[:, None] - everything, axis=1)
    target[nodes == poles] = 0.0
    gaps = nodes[:, None] - np.concatenate([nodes, nodes[~real].conj(), np.zeros(rigid)])
    gaps[np.arange(len(nodes)), np.arange(len(nodes))] = size
    return nodes, target, np.asarray(np.prod(gaps, axis=1))


def sensitivities(test: Observed, arms: RealArray, p: RealArray) -> tuple[RealArray, RealArray]:
    """Return relative errors of the poles and errors of the shapes (if weighed), and derivatives of both by p."""
    struts, n = arms.shape
    masses = p[2 * struts :] + test.added
    roots = np.sqrt(masses)
    light = arms / roots
    damping, stiffness = light.T * p[struts : 2 * struts] @ light, light.T * p[:struts] @ light
    A = np.zeros((2 * n, 2 * n), complex)
    A[:n, n:], A[n:, :n], A[n:, n:] = np.eye(n), -stiffness, -damping
    found, vectors = np.linalg.eig(A)
    partner = partners(test.poles, found)
    pole, motion = found[partner], vectors[:n, partner].T
    modes = np.arange(len(pole))
    reference = np.argmax(np.abs(motion), axis=1)
    motion = motion / motion[modes, reference][:, None]
    # Derivatives of pole and shape together: the dynamic matrix, bordered by a fixed largest component.
    bordered = np.zeros((len(pole), n + 1, n + 1), complex)
    bordered[:, :n, :n] = pole[:, None, None] ** 2 * np.eye(n) + pole[:, None, None] * damping + stiffness
    bordered[:, :n, n] = 2 * pole[:, None] * motion + motion @ damping
    bordered[modes, n, reference] = 1.0
    load = np.zeros((len(pole), n + 1, len(p)), complex)
    load[:, :n, :struts] = -(motion @ light.T)[:, None, :] * light.T
    load[:, :n, struts : 2 * struts] = pole[:, None, None] * load[:, :n, :struts]
    load[:, np.arange(n), 2 * struts + np.arange(n)] = -(pole[:, None] ** 2) * motion / masses
    try:
        slope = np.linalg.solve(bordered, load)
    except np.linalg.LinAlgError:  # poles that coincide
        slope = np.asarray(np.linalg.pinv(bordered) @ load, complex)
    size = np.abs(test.poles)
    errors = [_real_rows((pole - test.poles) / size, test.real)]
    slopes = [_real_rows(slope[:, n] / size[:, None], test.real)]
    shapes = test.weighed_shapes
    if shapes is not None:
        # The components seen by the channels, (mode, channel), and their derivatives. The motion is scaled by the
        # roots of the masses; for fixed roots its derivatives are those of the displacements times the roots.
        largest = np.argmax(np.abs(shapes), axis=0)
        show = test.weights / roots
        power = (pole / size)[:, None] ** test.orders
        seen = power * (motion @ show.T)
        change = power[:, :, None] * (show @ slope[:, :n])
        change += (test.orders * seen / pole[:, None])[:, :, None] * slope[:, n, None, :]
        at = seen[modes, largest]
        at = np.where(np.abs(at) > 1e-12 * np.max(np.abs(seen), axis=1), at, 1e-12)[:, None]
        ratio = seen / at
        change = (change - ratio[:, :, None] * change[modes, largest][:, None, :]) / at[:, :, None]
        others = np.arange(len(shapes)) != largest[:, None]
        error = (ratio - shapes.T / shapes.T[modes, largest][:, None])[others]
        real = np.repeat(test.real, len(shapes) - 1)
        errors.append(_real_rows(error, real))
        slopes.append(_real_rows(change[others], real))
    return np.concatenate(errors), np.concatenate(slopes)


def _real_rows(values: ComplexArray | RealArray, which: NDArray[np.bool_]) -> RealArray:
    """Return real and imaginary parts as rows, without the imaginary parts of ``which``."""
    return np.concatenate([values.real, values.imag[~which]])
