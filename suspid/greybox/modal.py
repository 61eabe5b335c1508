"""Modes of an estimated suspension, with the covariance of its parameters carried through."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.greybox.dynamics import plant_of
from suspid.model import ModalSet, Suspension, scaled_shapes
from suspid.reconstruction import parameter_vector
from suspid.units import ComplexArray, RealArray

# Poles nearer to each other than this share of their modulus count as one: their shapes have no derivatives.
COINCIDE = 1e-6


def modes_of(
    car: Suspension,
    rows: Sequence[int],
    covariance: RealArray,
    *,
    still: Sequence[str] = (),
    mounts: Sequence[int] = (),
) -> ModalSet:
    """Return the modes of a car while some coordinates are held still, and their joint covariance to first order.

    ``covariance`` is that of the parameters ``rows`` in SI units; the relaxations of the struts ``mounts`` follow k, c
    and masses. With ``A V = V diag(lambda)``, a change dA moves pole
    i by ``G_ii`` and vector i by ``sum_k v_k G_ki / (lambda_i - lambda_k)``, ``G = V^-1 dA V``.
    """
    p, n = np.append(parameter_vector(car), [car.struts[i].relaxation for i in mounts]), len(car.coordinates)
    plant = plant_of(car, p, rows, roads=(), forces=np.zeros((0, n)), mounts=mounts)
    moving = [i for i, name in enumerate(car.coordinates) if name not in still]
    keep = [*moving, *(n + i for i in moving), *range(2 * n, plant.states)]
    A, b, f = plant.F[np.ix_(keep, keep)], plant.b[:, keep], plant.f[:, keep]
    poles, vectors = np.linalg.eig(A)
    poles, vectors = poles.astype(complex), vectors.astype(complex)
    gaps = poles[None, :] - poles[:, None]
    np.fill_diagonal(gaps, 1.0)
    upper = np.flatnonzero(poles.imag >= 0)
    shapes, channels = scaled_shapes(vectors[: len(moving), upper]), tuple(car.coordinates[i] for i in moving)
    if np.any(np.abs(gaps) < COINCIDE * np.max(np.abs(poles))):
        return ModalSet(poles=poles[upper], shapes=shapes, channels=channels)
    left, right = b @ np.linalg.inv(vectors).T, f @ vectors
    columns = []
    for i in upper:
        pole_slopes = left[:, i] * right[:, i]
        weights = left * right[:, i : i + 1] / gaps[:, i]
        weights[:, i] = 0.0
        columns.append(_parts(pole_slopes[:, None]))
        moved = weights @ vectors[: len(moving)].T
        own = vectors[: len(moving), i]
        top = int(np.argmax(np.abs(own)))
        turned = (moved - np.outer(moved[:, top], own / own[top])) / own[top]
        columns.append(_parts(turned))
    slopes = np.concatenate([*columns[0::2], *columns[1::2]], axis=1)
    return ModalSet(
        poles=poles[upper], shapes=shapes, channels=channels, covariance=_symmetric(slopes.T @ covariance @ slopes)
    )


def _parts(slopes: ComplexArray) -> RealArray:
    """Return real and imaginary parts side by side, (parameter, 2 number)."""
    return np.stack([slopes.real, slopes.imag], axis=2).reshape(len(slopes), -1)


def _symmetric(matrix: RealArray) -> RealArray:
    return np.asarray((matrix + matrix.T) / 2)
