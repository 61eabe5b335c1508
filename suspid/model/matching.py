"""Pair the modes of two sets by the distance of their poles and the similarity of their shapes."""

from __future__ import annotations

import numpy as np

from suspid.model.modes import ModalSet
from suspid.units import ComplexArray, Ratio, RealArray


def pole_distances(a: ComplexArray, b: ComplexArray) -> RealArray:
    """Return ``|a - b| / max(|a|, |b|)`` of every pole of ``a`` from every pole of ``b``; 0 for two zeros.

    Examples
    --------
    >>> pole_distances(np.array([4j, 10j]), np.array([5j])).round(3)
    array([[0.2],
           [0.5]])
    """
    larger = np.maximum(np.abs(a)[:, None], np.abs(b))
    return np.asarray(np.abs(a[:, None] - b) / np.where(larger > 0, larger, 1.0))


def modal_assurance(a: ComplexArray, b: ComplexArray) -> RealArray:
    """Return the MAC ``|a^H b|^2 / (a^H a b^H b)`` of every shape (column) of ``a`` with every shape of ``b`` [1].

    It is 1 for shapes that differ by a complex factor, and 0 for orthogonal shapes or where a shape is zero.

    Examples
    --------
    >>> modal_assurance(np.array([[1.0], [1j]]), np.array([[2j], [-2.0]])).round(12)
    array([[1.]])
    """
    powers = np.sum(np.abs(a) ** 2, axis=0)[:, None] * np.sum(np.abs(b) ** 2, axis=0)
    return np.asarray(np.abs(a.conj().T @ b) ** 2 / np.where(powers > 0, powers, 1.0))


def common_mac(found: ModalSet, expected: ModalSet) -> RealArray | None:
    """Return the MAC (found, expected) on the channels that both sets have; None with fewer than two of them."""
    common = [c for c in expected.channels if c in found.channels]
    if found.shapes is None or expected.shapes is None or len(common) < 2:
        return None
    return modal_assurance(
        found.shapes[[found.channels.index(c) for c in common]],
        expected.shapes[[expected.channels.index(c) for c in common]],
    )


def with_rigid(found: ModalSet, expected: ModalSet, rtol: Ratio) -> ModalSet:
    """Return exact modes with zeros where poles are within the allowed error of an expected pole at zero.

    Rounding splits the double pole of a free mass into a pair or into two real poles near zero.

    Examples
    --------
    >>> free = ModalSet(poles=[0.0, 0.0, -1 + 50j])
    >>> with_rigid(ModalSet(poles=[6e-7j, -1 + 50j]), free, 1e-6).kinds
    ('rigid', 'rigid', 'pair')
    """
    if found.covariance is not None or "rigid" not in expected.kinds:
        return found
    zero = found.wn <= rtol * np.max(expected.wn)
    each = np.repeat(np.arange(len(found)), np.where(zero & (found.poles.imag > 0), 2, 1))
    shapes = None if found.shapes is None else found.shapes[:, each]
    return ModalSet(poles=np.where(zero, 0.0, found.poles)[each], shapes=shapes, channels=found.channels)


def paired(found: ModalSet, expected: ModalSet, *, mac: RealArray | None, gate: Ratio) -> dict[int, int]:
    """Return the index of the found mode by the index of its expected mode.

    The assignment minimises the sum of pole distances, plus ``1 - mac`` where it is given. Two modes whose poles are
    further apart than ``gate`` are not paired; a mode of each set that is left alone costs as much as the worst pair
    within it, so that a missing mode and a new one do not shift all pairs between them.
    """
    from scipy.optimize import linear_sum_assignment

    distance = pole_distances(found.poles, expected.poles)
    cost = distance if mac is None else distance + (1 - mac)
    worst = gate if mac is None else gate + 1
    rows, columns = distance.shape
    # Every mode has a partner of its own that stands for none. A pair beyond the gate costs more than all others.
    padded = np.full((rows + columns, columns + rows), worst / 2)
    padded[rows:, columns:] = 0.0
    padded[:rows, :columns] = np.where(distance > gate, (1 + worst) * (rows + columns), cost)
    pairs = zip(*linear_sum_assignment(padded), strict=True)
    return {int(j): int(i) for i, j in pairs if i < rows and j < columns and distance[i, j] <= gate}
