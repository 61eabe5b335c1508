"""The characteristic polynomial as a sum over sets of struts, for many suspensions at once.

By the theorem of Cauchy and Binet

    det(lambda^2 M + lambda C + K) / det M = sum over sets S of struts of det(G_S) lambda^(2 (n - |S|)) prod_S f_i

with the force ``f_i = k_i + lambda c_i`` of each strut per unit of elongation and the principal minors of
``G = A M^-1 A^T``, where A holds the arms. It is linear in each strut; masses are known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.reconstruction.equations import Observed
from suspid.reconstruction.unknowns import Unknowns
from suspid.units import ComplexArray, RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Characteristic:
    """The polynomial of one test at its nodes, as a function of the unknowns."""

    real: NDArray[np.bool_]  # nodes whose imaginary part carries no information
    base: ComplexArray  # force of each strut [N/m]: base + spread @ x, (node, strut)
    spread: ComplexArray  # (node, strut, unknown)
    terms: ComplexArray  # (node, set, unknown + 1): derivatives by the unknowns, and the value, per product of forces
    target: ComplexArray  # (node,)

    def __call__(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual (start, row) and its derivatives (start, row, unknown) at many points (start, unknown).

        It equals `suspid.reconstruction.equations.spectral` up to rounding.
        """
        forces = self.base[:, None, :] + x @ self.spread.swapaxes(1, 2)  # (node, start, strut)
        products = np.ones((*forces.shape[:2], 1 << forces.shape[2]), complex)
        for i in range(forces.shape[2]):
            half = 1 << i
            np.multiply(products[..., :half], forces[..., i, None], out=products[..., half : 2 * half])
        both = products @ self.terms  # (node, start, unknown + 1)
        both[..., -1] -= self.target[:, None]
        rows = np.concatenate([both.real, both.imag[~self.real]]).swapaxes(0, 1)
        return rows[..., -1], rows[..., :-1]


def characteristic(test: Observed, unknowns: Unknowns) -> Characteristic | None:
    """Return the polynomial of a test, or None if masses are unknown or the struts too many."""
    car = unknowns.car
    arms, struts = unknowns.arms, len(car.struts)
    # Nine struts have 512 sets; beyond, determinants are cheaper.
    if struts > 9 or np.any(unknowns.spread[2 * struts :]):
        return None
    masses = unknowns.base[2 * struts :] + test.added
    minors, sizes = principal_minors((arms / masses) @ arms.T), _sizes(struts)
    left = np.maximum(len(masses) - sizes, 0)
    # Minors of more struts than masses are zero; rounding would make them small numbers.
    value = np.where(sizes <= len(masses), minors, 0.0) * test.nodes[:, None] ** (2 * left) / test.spacing[:, None]
    base = unknowns.base[:struts] + test.nodes[:, None] * unknowns.base[struts : 2 * struts]
    spread = (
        unknowns.spread[:struts] + test.nodes[:, None, None] * unknowns.spread[struts : 2 * struts]
    )  # (node, strut, unknown)
    terms = np.zeros((len(test.nodes), len(minors), len(unknowns) + 1), complex)
    every = np.arange(len(minors))
    for i in range(struts):
        without = every[every >> i & 1 == 0]
        terms[:, without, :-1] += value[:, without + (1 << i), None] * spread[:, i, None, :]
    terms[..., -1] = value
    return Characteristic(real=test.real, base=base, spread=spread, terms=terms, target=test.target / test.spacing)


def principal_minors(G: RealArray) -> RealArray:
    """Return the determinants of all principal submatrices, indexed by the bits of the set.

    Examples
    --------
    >>> principal_minors(np.array([[2.0, 1.0], [1.0, 3.0]])).round(12)
    array([1., 2., 3., 5.])
    """
    members = np.arange(1 << len(G))[:, None] >> np.arange(len(G)) & 1 == 1
    both = members[:, :, None] & members[:, None, :]
    return np.asarray(np.linalg.det(np.where(both, G, np.eye(len(G)) * ~members[:, None, :])))


def _sizes(count: int) -> NDArray[np.intp]:
    """Return the number of members of each set."""
    return np.array([number.bit_count() for number in range(1 << count)])
