"""Modes of an estimated suspension, with the covariance of its parameters carried through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.greybox.dynamics import plant_of
from suspid.levels import NORMAL_95
from suspid.model import ModalSet, Suspension, scaled_shapes
from suspid.reconstruction import Unknowns, parameter_names, parameter_vector
from suspid.units import ComplexArray, RealArray, Second

# Share of the step between samples within which a mount that relaxes is rigid: it turns no phase by a thousandth.
AS_RIGID = 3e-4


def of_car(u: Unknowns) -> list[int]:
    """Return which names of the unknowns are stiffnesses, dampings and masses; they come first."""
    return [i for i, row in enumerate(u.rows) if row < len(parameter_names(u.car))]


def modes_with(
    car: Suspension, u: Unknowns, parameters: Sequence[str], covariance: RealArray, still: Sequence[str]
) -> ModalSet:
    """Return the modes of the car that was found, with the covariance of all its parameters."""
    mounts = [
        i for i, s in enumerate(car.struts) if s.mount_stiffness is not None and f"{s.name}.relaxation" in parameters
    ]
    own = of_car(u)
    count = len(parameter_names(car))
    rows = [*(u.rows[i] for i in own), *range(count, count + len(mounts))]
    own += [parameters.index(f"{car.struts[i].name}.relaxation") for i in mounts]
    return modes_of(car, rows, covariance[np.ix_(own, own)], still=still, mounts=mounts)


def mounted_car(
    car: Suspension, parameters: Sequence[str], values: RealArray, std: RealArray, step: Second
) -> Suspension:
    """Return the car with the mounts whose relaxation is known not to be zero, at a level of 95 %.

    What relaxes within a small part of a ``step`` from sample to sample is rigid: rounding of a simulation, or how
    motion between its samples was interpolated, does not make a mode of megahertz.
    """
    found: dict[str, float | None] = {}
    for name, value, spread in zip(parameters, values.tolist(), std.tolist(), strict=True):
        strut, _, quantity = name.rpartition(".")
        if quantity == "relaxation":
            damping = next(s.damping for s in car.struts if s.name == strut)
            found[strut] = damping / value if value > max(NORMAL_95 * spread, AS_RIGID * step) and damping > 0 else None
    struts = [replace(s, mount_stiffness=found[s.name]) if s.name in found else s for s in car.struts]
    return replace(car, struts=struts)


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
    # Poles nearer to each other than this share of their modulus count as one: their shapes have no derivatives.
    if np.any(np.abs(gaps) < 1e-6 * np.max(np.abs(poles))):
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
