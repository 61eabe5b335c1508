"""Modes of a structure that is not quite linear, with their uncertainty and how they depend on amplitude."""

from __future__ import annotations

import numpy as np

from suspid.identification.covariance import estimate_of, with_changes
from suspid.identification.noise import loudness, power_near, shared_noise
from suspid.identification.nonlinear.amplitude import (
    covariance_of,
    dependence,
    mean_over_parts,
    window_changes,
)
from suspid.identification.nonlinear.dependence import AmplitudeDependence, with_tables
from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.feedback import Bent
from suspid.identification.nonlinear.linearised import modes_of_structure
from suspid.model import ModalSet
from suspid.units import RealArray
from suspid.values import frozen_real


def modes_of_bent(
    bent: Bent, *, timepts: RealArray, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray, tuple[AmplitudeDependence, ...]]:
    """Return the modes, how loud the residual is near each, (mode,), and how each depends on its amplitude.

    Each pole is the mean over the cycles of the record. Their variances are widened by the loudness, by noise that the
    channels share, by what the choice of the stretch does, and by how far each is from its table over the amplitudes.
    """
    if bent.structure is not None:
        modes, loud, tables = modes_of_structure(bent.structure, timepts=timepts, channels=channels)
    else:
        modes, loud, tables = _modes_of_driven(bent.fit, timepts=timepts, channels=channels)
    return with_tables(modes, tables), loud, tables


def _modes_of_driven(
    fit: DrivenFit, *, timepts: RealArray, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray, tuple[AmplitudeDependence, ...]]:
    """Return the modes of a motion that forces drive, how loud the residual is near each, and their tables."""
    step = float(timepts[-1] - timepts[0]) / (len(timepts) - 1)
    means = [mean_over_parts(fit, k) for k in range(len(fit.drive.theta))]
    exponents = np.array([theta for theta, _ in means])
    order = np.argsort(np.abs(exponents), kind="stable")
    chosen = np.vstack([means[k][1] for k in order])
    weights = np.abs(fit.amplitudes[order]).T ** 2 / fit.variance[:, None]
    beside = power_near(fit.residual, fit.variance, exponents[order])
    loud = loudness(fit.residual, fit.variance, exponents[order], beside=beside, weights=weights)
    widening = loud * shared_noise(fit.residual)
    dragged, noise = _amplitude_errors(fit, order.tolist())
    joint = estimate_of(
        exponents[order],
        fit.amplitudes[order].T,
        chosen=chosen,
        of_parameters=covariance_of(fit),
        dragged=dragged,
        noise=noise,
        inflation=widening,
    )
    found = joint.modes(step=step, channels=channels)
    # What the choice of the stretch does to each pole.
    windows = [window_changes(fit, int(k), complex(exponents[k]), refit=True) for k in order]
    return (
        with_changes(found, np.stack(windows, axis=1) / step),
        frozen_real(loud),
        tuple(
            dependence(
                fit, int(k), holds=complex(exponents[k]), widening=float(wide), timepts=timepts, channels=channels
            )
            for k, wide in zip(order, widening, strict=True)
        ),
    )


def _amplitude_errors(fit: DrivenFit, modes: list[int]) -> tuple[RealArray, RealArray]:
    """Return derivatives of the amplitudes by the parameters, and their covariance at given parameters.

    Rows are Re and Im of each mode's amplitude, channel by channel.
    """
    poles, channels = len(fit.drive.theta), len(fit.residual)
    rows = np.ravel([[k, poles + k] for k in modes])
    signs = np.tile([1.0, -1.0], len(modes))
    half = fit.inverse[rows] * signs[:, None]
    size = len(rows)
    dragged, noise = np.zeros((channels * size, fit.drive.free)), np.zeros((channels * size, channels * size))
    inner = fit.basis.T @ np.concatenate([fit.slopes.real, fit.slopes.imag]).T
    re, im = inner[:, : len(fit.owners)], inner[:, len(fit.owners) :]
    for c, a in enumerate(fit.amplitudes.T):
        at, own = slice(c * size, (c + 1) * size), a[fit.owners]
        slopes = np.empty((len(inner), fit.drive.free))
        slopes[:, 0::2] = re * own.real - im * own.imag
        slopes[:, 1::2] = -im * own.real - re * own.imag
        dragged[at] = -half @ slopes
        noise[at, at] = half @ half.T * (fit.squares[c] / fit.freedom)
    return dragged, noise
