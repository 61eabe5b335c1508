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

from suspid.reconstruction.descent import Equations
from suspid.reconstruction.equations import Observed, spectral
from suspid.reconstruction.unknowns import Unknowns
from suspid.units import ComplexArray, RealArray

# Points that are evaluated together: more do not stay in the cache.
POINTS_AT_ONCE = 192
# Up to this number of struts, one product of all sets of forces takes less than those of two halves.
FEW_STRUTS = 5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Characteristic:
    """The polynomial of one test at its nodes, as a function of the unknowns."""

    real: NDArray[np.bool_]  # nodes whose imaginary part carries no information
    base: ComplexArray  # force of each strut that is not known [N/m]: base + spread @ x, (node, strut)
    spread: ComplexArray  # (node, strut, unknown)
    factors: ComplexArray  # (node, set): value per product of forces
    # (node, unknown + 1, set): derivatives by the unknowns, and the value, per product of forces; of few struts only
    terms: ComplexArray | None
    target: ComplexArray  # (node,)

    def __call__(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual (start, row) and its derivatives (start, row, unknown) at many points (start, unknown).

        It equals `suspid.reconstruction.equations.spectral` up to rounding.
        """
        parts = [self._at(x[first : first + POINTS_AT_ONCE]) for first in range(0, len(x), POINTS_AT_ONCE)]
        values, slopes = (np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))
        values -= self.target[:, None]
        residual = np.concatenate([values.real, values.imag[~self.real]]).T
        return residual, np.concatenate([slopes.real, slopes.imag[~self.real]]).transpose(2, 0, 1).copy()

    def _at(self, x: RealArray) -> tuple[ComplexArray, ComplexArray]:
        """Return values (node, start) and derivatives (node, unknown, start)."""
        forces = self.base[:, :, None] + self.spread @ x.T  # (node, strut, start)
        if self.terms is not None:
            both = self.terms @ _products(forces)
            return both[:, -1], both[:, :-1]
        # Of two halves of the struts only the products of forces within each are formed: the polynomial is bilinear in
        # them.
        first = forces.shape[1] // 2
        one, other = _products(forces[:, :first]), _products(forces[:, first:])
        factors = self.factors.reshape(len(forces), other.shape[1], one.shape[1])
        by_one, by_other = factors.swapaxes(1, 2) @ other, factors @ one
        slopes = np.concatenate([_by_forces(one, by_one), _by_forces(other, by_other)], axis=1)
        return (one * by_one).sum(axis=1), self.spread.swapaxes(1, 2) @ slopes


def _products(forces: ComplexArray) -> ComplexArray:
    """Return the products of the forces of all sets of struts, (node, set, start), indexed by the bits of the set."""
    nodes, struts, starts = forces.shape
    products = np.empty((nodes, 1 << struts, starts), complex)
    products[:, 0] = 1.0
    for i in range(struts):
        half = 1 << i
        np.multiply(products[:, :half], forces[:, i, None], out=products[:, half : 2 * half])
    return products


def _by_forces(products: ComplexArray, slopes: ComplexArray) -> ComplexArray:
    """Return derivatives by the forces, (node, strut, start), from those by their products."""
    nodes, sets, starts = products.shape
    out = np.empty((nodes, sets.bit_length() - 1, starts), complex)
    for i in range(out.shape[1]):
        # Sets without a strut, and with it.
        without, having = (part.reshape(nodes, -1, 2, 1 << i, starts) for part in (products, slopes))
        np.einsum("khls,khls->ks", without[:, :, 0], having[:, :, 1], out=out[:, i])
    return out


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
    searched = np.any(spread, axis=(0, 2))
    for i in np.flatnonzero(~searched)[::-1]:
        # The force of a known strut is a number.
        sets = value.reshape(len(value), -1, 2, 1 << i)
        value = (sets[:, :, 0] + base[:, i, None, None] * sets[:, :, 1]).reshape(len(value), -1)
    base, spread = base[:, searched], spread[:, searched]
    terms = None
    if spread.shape[1] <= FEW_STRUTS:
        terms = np.zeros((len(value), len(unknowns) + 1, value.shape[1]), complex)
        every = np.arange(value.shape[1])
        for i in range(spread.shape[1]):
            without = every[every >> i & 1 == 0]
            terms[:, :-1, without] += spread[:, i, :, None] * value[:, None, without + (1 << i)]
        terms[:, -1] = value
    target = test.target / test.spacing
    return Characteristic(real=test.real, base=base, spread=spread, factors=value, terms=terms, target=target)


def polynomial_of(test: Observed, unknowns: Unknowns) -> Equations:
    """Return the residual of the poles of a test, with derivatives by the unknowns, as a function of many points."""

    def by_determinants(x: RealArray) -> tuple[RealArray, RealArray]:
        residual, slope = spectral(test, unknowns.arms, unknowns.parameters(x))
        return residual, slope @ unknowns.spread

    return characteristic(test, unknowns) or by_determinants


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
