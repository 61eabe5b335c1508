"""Lines through spectra of roads: level and exponent by maximum likelihood, from the waves that folding leaves."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.simulation import REFERENCE
from suspid.units import Metre, Ratio, RealArray

# Exponents of measured roads are 1.5 to 3; beyond these a spectrum is that of noise, or of a filter.
EXPONENTS, LEAST_MEASURED = (1.0, 4.0), 1.5
# Fewest spectral lines from which a level and an exponent are told, and lines of each piece of the test of a bend.
FEWEST_WAVES, LINES_OF_PIECE = 20, 16
# Shares of half the sampling rate up to which lines are used: the largest one at which folding is no matter. Heights
# are points of a road with shorter waves, which fold into those lines: at the exponent 2 they add 11 % at a half.
UNFOLDED = tuple((0.5 * 0.8 ** np.arange(12)).tolist())
# Largest step of the logarithm of a line in the search of the fit: from far off, the next would be too far.
LARGEST_LOG_STEP = 2.0
# Error by folding, in standard deviations, up to which it is none: intervals of 95 % then hold 94.5 %.
MOST_FOLDING = 0.2

# Log level, exponent, their covariance, chi-square of the spectrum against the line with its degrees of freedom, and
# the mean square of the lines' departures.
Fitted: TypeAlias = tuple[float, float, RealArray, tuple[float, int], float]


def line_of(n: RealArray, power: RealArray, held: RealArray, spacing: Metre) -> tuple[RealArray, Fitted]:
    """Return the wavenumbers that are used, and the line fitted to them: as many as folding leaves."""
    for share in UNFOLDED:
        use = unfolded(n, spacing, share)
        if np.sum(use) < FEWEST_WAVES:
            break
        lines, found = n[use], _fitted(n[use], power[use], held[use])
        if np.all(np.abs(_folding(lines, spacing, found[1])) <= MOST_FOLDING * np.sqrt(np.diag(found[2]))):
            break
    return lines, found


def unfolded(n: RealArray, spacing: Metre, share: Ratio) -> NDArray[np.bool_]:
    """Return which wavenumbers lie below a share of the sampling rate over distance, 1 for half of it."""
    return np.asarray(n <= share * 0.5 / spacing)


def _folding(n: RealArray, spacing: Metre, exponent: Ratio) -> RealArray:
    """Return the errors of log level and exponent by waves that are shorter than two samples, were there all of them.

    Waves of ``2 m / x - 1`` and ``2 m / x + 1`` times the wavenumber of a line fold into it, where x is its share of
    half the sampling rate and m = 1, 2, …; their sum is one of Hurwitz's zeta functions.
    """
    from scipy.special import zeta

    # Below the least exponent of a measured road the sum is one of noise, and has no end at 1.
    w, half = max(exponent, LEAST_MEASURED), n * spacing
    more = half**w * (zeta(w, 1 - half) + zeta(w, 1 + half))
    X = _design(n)
    return np.asarray(np.linalg.solve(X.T @ X, X.T @ more))


def _design(n: RealArray) -> RealArray:
    """Return the derivatives of the logarithm of the density by log level and exponent."""
    return np.column_stack([np.ones(len(n)), -np.log(n / REFERENCE)])


def line_through(n: RealArray, density: RealArray) -> RealArray:
    """Return log level and exponent of the line through the logarithms, which a few strong lines hardly move."""
    logs = np.log(np.maximum(density, 1e-300)) + np.euler_gamma
    return np.asarray(np.linalg.lstsq(_design(n), logs, rcond=None)[0])


def _fitted(n: RealArray, power: RealArray, held: RealArray) -> Fitted:
    """Return log level, exponent, their covariance, and chi-square of the spectrum against the line."""
    X = _design(n)
    p = line_through(n, power / held)
    for _ in range(50):
        # Fisher scoring of an exponential distribution with a log-linear mean.
        score = power / (held * np.exp(X @ p)) - 1
        step = np.linalg.solve(X.T @ X, X.T @ score)
        step = step * min(1.0, LARGEST_LOG_STEP / max(float(np.max(np.abs(X @ step))), LARGEST_LOG_STEP))
        p = p + step
        if np.max(np.abs(step)) < 1e-10:
            break
    score = power / (held * np.exp(X @ p)) - 1
    bread = np.linalg.inv(X.T @ X)
    # The larger of what exponential lines have by law and what these have: a bent spectrum scatters more.
    covariance = np.asarray(bread * max(1.0, float(np.mean(score**2))), float)
    pieces = np.array_split(score, max(len(score) // LINES_OF_PIECE, 3))
    bends = np.array([np.sum(piece) ** 2 / len(piece) for piece in pieces])
    scatter = float(np.mean(score**2))
    return float(p[0]), float(p[1]), covariance, (float(np.sum(bends)), len(pieces) - 2), scatter
