"""Covariance of modes: order of its entries, and conversion between poles and (wn, zeta)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.units import RealArray


def jacobian_of(pole: complex) -> RealArray:
    """Return d(wn, zeta) / d(Re, Im) at a pole."""
    wn = abs(pole)
    if wn == 0:
        return np.zeros((2, 2))
    re, im = pole.real, pole.imag
    return np.array([[re / wn, im / wn], [-((im / wn) ** 2) / wn, (re / wn) * (im / wn) / wn]])


def covariance_order(order: NDArray[np.intp], size: int, count: int) -> list[int]:
    """Return the entries of the covariance of ``count`` modes that belong to those in ``order``, in that order."""
    per_mode = size // (2 * count) - 1 if count else 0
    poles = [2 * m + part for m in order for part in (0, 1)]
    shapes = [2 * count + 2 * (m * per_mode + c) + part for m in order for c in range(per_mode) for part in (0, 1)]
    return [int(i) for i in poles + shapes]
