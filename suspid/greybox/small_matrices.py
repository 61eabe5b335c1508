"""Stacks of small matrices: those of one row and column without LAPACK, which takes longer to call than to compute."""

from __future__ import annotations

import numpy as np

from suspid.units import ComplexArray, RealArray


def inverses(matrices: ComplexArray) -> ComplexArray:
    """Return the inverse of each matrix of a stack (…, row, column).

    Examples
    --------
    >>> inverses(np.array([[[4.0 + 0j]], [[2j]]])).ravel()
    array([0.25+0.j , 0.  -0.5j])
    """
    return np.asarray(1 / matrices if matrices.shape[-1] == 1 else np.linalg.inv(matrices))


def whitening(covariances: ComplexArray) -> ComplexArray:
    """Return the inverse of the Cholesky factor of each covariance of a stack: noise times it is white.

    Examples
    --------
    >>> whitening(np.array([[[4.0 + 0j]]])).item()
    (0.5+0j)
    """
    if covariances.shape[-1] == 1:
        return np.asarray(covariances.real**-0.5, complex)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariances)))


def log_determinants(covariances: ComplexArray) -> RealArray:
    """Return the logarithm of the determinant of each covariance of a stack.

    Examples
    --------
    >>> float(log_determinants(np.array([[[np.e + 0j]]])).item())
    1.0
    """
    if covariances.shape[-1] == 1:
        return np.asarray(np.log(covariances.real[..., 0, 0]))
    return np.asarray(np.linalg.slogdet(covariances)[1])
