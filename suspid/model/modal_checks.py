"""Checks of the poles, shapes and covariance that a set of modes is made of."""

from __future__ import annotations

import numpy as np

from suspid.errors import InputError
from suspid.model.covariance import check_definite
from suspid.units import ComplexArray, RealArray
from suspid.values import LARGEST_SIZE, frozen_complex, frozen_real


def checked_poles(given: object) -> ComplexArray:
    """Return poles as a vector, or refuse them; one stands for a conjugate pair."""
    poles = frozen_complex(given)
    if poles.ndim != 1 or not np.all(np.isfinite(poles)):
        raise InputError(f"poles must be a finite vector; got shape {poles.shape}: {poles}")
    if np.any(poles.imag < 0):
        raise InputError(
            f"pole {poles[poles.imag < 0][0]:g} rad/s lies in the lower half plane; one entry stands for a "
            f"conjugate pair: give the pole above the real axis, and the conjugate of its shape"
        )
    return poles


def checked_shapes(given: object, channels: tuple[str, ...], modes: int) -> ComplexArray:
    """Return shapes as a matrix (channel, mode), or refuse them."""
    shapes = frozen_complex(given)
    if shapes.ndim != 2 or shapes.shape[1] != modes or len(channels) not in (0, len(shapes)):
        raise InputError(
            f"shapes must be (channel, mode): got {shapes.shape} for {len(channels)} channels and {modes} modes"
        )
    wild = ~(np.abs(shapes) <= LARGEST_SIZE)
    if np.any(wild):
        raise InputError(
            f"{np.sum(wild)} of {shapes.size} components of shapes are not finite, or beyond {LARGEST_SIZE:g}"
        )
    return shapes


def checked_covariance(given: object, modes: int, channels: int) -> RealArray:
    """Return the covariance of poles, or of poles and shapes, or refuse it."""
    covariance = frozen_real(given)
    sizes = {2 * modes, 2 * modes * (1 + channels)}
    if covariance.shape not in {(size, size) for size in sizes}:
        raise InputError(f"covariance has shape {covariance.shape}; expected one of the sizes {sorted(sizes)}")
    if not np.all(np.isfinite(covariance)) or np.any(np.diag(covariance) < 0):
        raise InputError(f"covariance must be finite, with variances >= 0; its diagonal is {np.diag(covariance)}")
    check_definite(covariance[: 2 * modes, : 2 * modes])
    return covariance
