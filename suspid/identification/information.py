"""Inverse of the Fisher information of poles."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

# Least eigenvalue of an information matrix of unit diagonal: smaller ones are rounding. It limits the standard
# deviation of poles that can hardly be distinguished.
LEAST_INFORMATION = 1e-10


def inverse_information(information: RealArray) -> RealArray:
    """Return the inverse of an information matrix (parameter, parameter), never indefinite.

    Where poles can hardly be distinguished, rounding leaves eigenvalues near 0 or below; they are raised to
    `LEAST_INFORMATION` of a unit diagonal.
    """
    diagonal = np.abs(information.diagonal())
    scale = 1 / np.sqrt(np.maximum(diagonal, 1e-300 + 1e-30 * np.max(diagonal, initial=0.0)))
    values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
    half = scale[:, None] * vectors / np.sqrt(np.maximum(values, LEAST_INFORMATION))
    return np.asarray(half @ half.T)
