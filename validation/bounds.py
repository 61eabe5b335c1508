"""Cramér-Rao bound of damped sinusoids in white noise: the least variance of an unbiased estimator.

Nothing here is taken from the library's estimators; it is a second opinion on them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid import InputError
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Bound:
    """Least standard deviations of an unbiased estimate.

    Parameters
    ----------
    wn_std : ndarray (mode,)
        Of the natural frequencies [rad/s].
    zeta_std : ndarray (mode,)
        Of the damping ratios [1].
    """

    wn_std: RealArray
    zeta_std: RealArray


def cramer_rao(
    poles: ComplexArray, amplitudes: ComplexArray, timepts: RealArray, *, noise_std: ArrayLike, offset: bool = False
) -> Bound:
    """Return the Cramér-Rao bound for the poles of a sampled decay in white Gaussian noise.

    The record is ``x_c(t) = Re sum_k a_ck exp(lambda_k t)`` in channel c, plus noise of standard
    deviation ``sigma_c``. Unknown are Re and Im of every pole, common to all channels, and Re and Im of every
    amplitude. With J the derivatives of all samples by these, every row divided by its ``sigma_c``, the
    covariance of any unbiased estimate is at least ``(J^T J)^-1``. Its part for each pole is carried to
    ``wn = |lambda|`` and ``zeta = -Re(lambda) / |lambda|`` to first order.

    Parameters
    ----------
    poles : ndarray (mode,)
        Poles [rad/s] with Im > 0, one for each conjugate pair.
    amplitudes : ndarray (channel, mode)
        Complex amplitudes at t = 0, in the unit of each channel.
    timepts : ndarray (sample,)
        Sampling times [s].
    noise_std : array_like (channel,) or float
        Standard deviation of the noise, in the unit of each channel.
    offset : bool
        Whether a constant in every channel is unknown too.

    Returns
    -------
    Bound
        In the order of the poles.

    Raises
    ------
    InputError
        If sizes disagree, a pole is not in the upper half plane, or a noise is not positive.

    Examples
    --------
    For one lightly damped pole the bound on the decay rate over a long record is
    ``4 sigma / A sqrt(delta^3 h)``, with A the amplitude and h the sampling step.

    >>> delta, h, sigma = 0.5, 0.001, 0.1
    >>> bound = cramer_rao(np.array([-delta + 60j]), np.array([[2.0]]), np.arange(0, 40, h), noise_std=sigma)
    >>> float(bound.wn_std[0] / (4 * sigma / 2 * np.sqrt(delta**3 * h))).__round__(2)
    1.0
    """
    poles, amplitudes = np.asarray(poles, complex), np.atleast_2d(np.asarray(amplitudes, complex))
    sigma = np.broadcast_to(np.asarray(noise_std, float), (len(amplitudes),))
    if amplitudes.shape[1] != len(poles):
        raise InputError(f"amplitudes have shape {amplitudes.shape}; expected (channel, {len(poles)}) for the poles")
    if not np.all(poles.imag > 0):
        raise InputError(f"poles {poles} rad/s must lie above the real axis, one for each conjugate pair")
    if not np.all(sigma > 0):
        raise InputError(f"noise_std {sigma} must be positive")
    powers: ComplexArray = np.exp(np.outer(timepts, poles))
    own = np.column_stack([powers.real, -powers.imag] + ([np.ones(len(powers))] if offset else []))
    # The amplitudes of a channel affect that channel alone, so they can be projected out channel by channel.
    basis, _ = np.linalg.qr(own)
    information = np.zeros((2 * len(poles), 2 * len(poles)))
    for row, std in zip(amplitudes, sigma, strict=True):
        slopes: ComplexArray = np.asarray(timepts)[:, None] * powers * row
        common = np.column_stack([slopes.real, -slopes.imag]) / std
        common -= basis @ (basis.T @ common)
        information += common.T @ common
    covariance = _inverse(information)
    wn_std, zeta_std = np.empty(len(poles)), np.empty(len(poles))
    for k, pole in enumerate(poles):
        pair = covariance[np.ix_([k, k + len(poles)], [k, k + len(poles)])]
        wn = abs(pole)
        by_wn = np.array([pole.real, pole.imag]) / wn
        by_zeta = np.array([-(pole.imag**2), pole.real * pole.imag]) / wn**3
        wn_std[k], zeta_std[k] = np.sqrt(by_wn @ pair @ by_wn), np.sqrt(by_zeta @ pair @ by_zeta)
    return Bound(wn_std=frozen_real(wn_std), zeta_std=frozen_real(zeta_std))


def decay_amplitudes(
    system: control.StateSpace, initial_state: Mapping[str, float] | ArrayLike
) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles of a free decay and its complex amplitudes, by eigenvectors of A.

    ``y(t) = C exp(A t) x_0 = Re sum_k a_k exp(lambda_k t)`` with ``a_k = 2 C v_k w_k^H x_0`` over the poles of the
    upper half plane (v_k, w_k the right and left eigenvectors, ``w_k^H v_k = 1``).

    Parameters
    ----------
    system : control.StateSpace
        Continuous, with complex pole pairs only.
    initial_state : mapping of str to float, or array_like (state,)
        State at t = 0, by label (others zero) or whole.

    Returns
    -------
    poles : ndarray (mode,)
        In order of ascending natural frequency [rad/s].
    amplitudes : ndarray (output, mode)
        In the unit of each output.

    Raises
    ------
    InputError
        If a pole is real.
    """
    A, C = np.asarray(system.A, float), np.asarray(system.C, float)
    if isinstance(initial_state, Mapping):
        initial_state = [initial_state.get(label, 0.0) for label in system.state_labels]
    poles, vectors = np.linalg.eig(A)
    if np.any(poles.imag == 0):
        raise InputError(f"the system has real poles, {poles[poles.imag == 0].real} rad/s")
    weights = np.linalg.solve(vectors, np.asarray(initial_state, complex))
    upper = np.flatnonzero(poles.imag > 0)
    upper = upper[np.argsort(np.abs(poles[upper]))]
    return np.asarray(poles[upper]), np.asarray(2 * (C @ vectors[:, upper]) * weights[upper])


def _inverse(matrix: RealArray) -> RealArray:
    """Return the inverse of a positive definite matrix, scaled to a unit diagonal first."""
    scale = np.sqrt(np.diag(matrix))
    return np.asarray(np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale))
