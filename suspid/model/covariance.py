"""Covariance of modes: order of its entries, and conversion between poles and (wn, zeta)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.levels import SEVEN_DIGITS
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


def check_definite(covariance: RealArray) -> None:
    """Refuse a matrix that is no covariance: not symmetric, or with a negative variance of a sum of its variables.

    Examples
    --------
    >>> check_definite(np.array([[1.0, 2.0], [2.0, 1.0]]))
    Traceback (most recent call last):
    suspid.errors.InputError: covariance is not positive semidefinite: a correlation in it is 2...
    """
    spread = np.sqrt(np.abs(np.diag(covariance)))
    # A variable without variance has rounding beside others.
    spread = np.maximum(spread, 1e-9 * np.max(spread, initial=0.0))
    if not np.any(spread):
        spread = np.ones(len(covariance))
    correlation = covariance / spread[:, None] / spread
    largest = float(np.max(np.abs(correlation), initial=0.0))
    if not np.allclose(correlation, correlation.T, rtol=0.0, atol=SEVEN_DIGITS):
        raise InputError("covariance is not symmetric")
    if not largest <= 1 + SEVEN_DIGITS:
        raise InputError(f"covariance is not positive semidefinite: a correlation in it is {largest:.3g}")
    least = float(np.min(np.linalg.eigvalsh(correlation), initial=0.0))
    if least < -SEVEN_DIGITS * len(correlation):
        raise InputError(f"covariance is not positive semidefinite: its correlation has the eigenvalue {least:.3g}")
