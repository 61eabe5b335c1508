"""Mean squares of a record, and their sampling error over records of its length.

The mean square m of a Gaussian vibration with covariance R and one-sided density G has the variance ``(2 / T) int R^2``
or ``(1 / T) int G^2 df`` (J. S. Bendat, A. G. Piersol, Random Data, 4th ed., 2010, 8.2), as a chi-square of ``n = 2 m^2
/ variance`` degrees of freedom has. A steady tone of mean square p does not vary; with the vibration at its frequency
it adds ``2 p G / T``.

What is not known is n: the share of the variance in m^2 is estimated with a bias of ``-(4 t - 3 u)`` and a variance of
``4 w + 4 u - 8 t``, where ``u, t, w = S2 / S1^2, S3 / (S1 S2), S4 / S2^2`` and ``Sp`` is the sum of the p-th powers of
the lines; the interval is widened as Student's is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.levels import NORMAL_95, PIECES_OF_RECORD, UNLIKELY
from suspid.performance.tones import steady_tones
from suspid.units import Ratio, RealArray

# Share of a record whose lags count. What swings for longer than that is not told from a tone; the variance of the
# covariance at each lag, which adds twice this share, is taken off.
SHARE_OF_LAGS: Ratio = 1 / 3
# Least degrees of freedom, of a mean square and of its variance: those of one line and of one square.
LEAST_FREEDOM = 1.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Vibration:
    """Autocovariance of the Gaussian vibration in a record, and the mean squares of its tones."""

    covariance: RealArray  # (lag,), of a sum over as many products as samples
    count: int  # samples
    tones: RealArray  # (tone,), mean squares
    beside: RealArray  # (tone,), mean square of a line of the vibration at the frequency of the tone

    @property
    def mean_square(self) -> float:
        """Mean square of all."""
        return float(self.covariance[0] + np.sum(self.tones))


def power_mean(samples: RealArray, power: int) -> tuple[float, float]:
    """Return ``mean(|x|^p)^(1/p)`` of samples, p 2 or 4, and its standard deviation over records of the same length.

    Where means over pieces of the record scatter more than those of a steady Gaussian vibration, they tell it.

    Examples
    --------
    White noise has as many degrees of freedom as samples:

    >>> root, std = power_mean(np.random.default_rng(1).standard_normal(20_000), 2)
    >>> round(std / root * (2 * 20_000) ** 0.5, 1)
    1.0
    """
    powers = np.abs(samples) ** power
    mean = float(np.mean(powers))
    if not mean:
        return 0.0, 0.0
    root, found = mean ** (1 / power), _vibration(samples)
    steady = _of_squares(found) if power == 2 else _of_fourths(found, mean)
    pieces = np.array([np.mean(piece) for piece in np.array_split(powers, PIECES_OF_RECORD)])
    told = float(np.std(pieces, ddof=1)) / PIECES_OF_RECORD**0.5 / (power * mean)
    return root, root * (told if _unsteady(told, steady) else steady)


def _unsteady(told: Ratio, steady: Ratio) -> bool:
    """Return whether pieces scatter more than chance explains."""
    from scipy.special import chdtrc

    freedom = PIECES_OF_RECORD - 1
    return told > 0 and bool(chdtrc(freedom, freedom * (told / max(steady, np.finfo(float).tiny)) ** 2) < UNLIKELY)


def _vibration(samples: RealArray) -> Vibration:
    from scipy.fft import irfft, next_fast_len, rfft

    rest, tones, beside = steady_tones(samples - np.mean(samples))
    count = len(rest)
    size = next_fast_len(2 * count, real=True)
    covariance = irfft(np.abs(rfft(rest, size)) ** 2, size)[: max(int(SHARE_OF_LAGS * count), 1)] / count
    return Vibration(covariance=covariance, count=count, tones=tones, beside=beside)


def _of_squares(found: Vibration, mixed: Ratio | RealArray = 1.0) -> Ratio:
    """Return the relative standard deviation of the root mean square, widened by what is not known of it.

    ``mixed`` are factors of what tones add.
    """
    from scipy.special import stdtrit

    share, variance = _share(found)
    own = share * float(found.covariance[0]) ** 2 + 2 * float(np.sum(found.tones * found.beside * mixed))
    if not own:
        return 0.0
    freedom = max(2 * found.mean_square**2 / own, LEAST_FREEDOM)
    known = max(2 / variance, LEAST_FREEDOM)
    # Student's interval beside the normal one, at 95 %.
    wider = float(stdtrit(known, 0.975)) / NORMAL_95
    return wider * float((2 * freedom) ** -0.5)


def _of_fourths(found: Vibration, fourth: float) -> Ratio:
    """Return the same of the fourth root of the mean fourth power.

    In Hermite polynomials, ``x^4 = 6 m (x^2 - m) + ...``, and the next term has the variance ``24 / T int R^4`` beside
    ``72 m^2 / T int R^2``. A tone mixes with ``1 - p / (2 m)`` of that, as the mean of a sine's fourth power tells.
    """
    mean, R = found.mean_square, found.covariance
    square = _share(found)[0] * float(R[0]) ** 2 * found.count / 2  # sum over all lags of R^2
    more = (2 * float(np.sum(R**4)) - float(R[0]) ** 4) / max(3 * mean**2 * square, np.finfo(float).tiny)
    by_square = _of_squares(found, (1 - found.tones / (2 * mean)) ** 2)
    return float(by_square * max(3 * mean**2 / fourth, 1.0) * (1 + more) ** 0.5)


def _share(found: Vibration) -> tuple[Ratio, Ratio]:
    """Return the variance of the vibration's mean square over its square, and the relative variance of that."""
    R, lags = found.covariance, np.arange(len(found.covariance))
    total = float(R[0])
    if not total:
        return 0.0, 1.0
    left = 1 - lags / found.count
    twice = np.where(lags > 0, 2.0, 1.0)
    share = 2 / found.count * float(np.sum(twice * R**2 / left)) / total**2 / (1 + 2 * SHARE_OF_LAGS)
    # Lines of a density that the window of the lags has smoothed.
    held = R / left * (1 + np.cos(np.pi * lags / len(lags))) / 2
    lines = np.maximum(np.fft.hfft(np.append(held, np.zeros(max(found.count // 2 + 1 - len(held), 1)))), 0.0)
    sums = [float(np.sum((lines / np.max(lines)) ** power)) for power in (1, 2, 3, 4)]
    # Both halves of the spectrum are summed: a line of the record is there twice.
    u, t, w = 2 * sums[1] / sums[0] ** 2, 2 * sums[2] / sums[0] / sums[1], 2 * sums[3] / sums[1] ** 2
    return share / max(1 - (4 * t - 3 * u), share / 2), max(4 * w + 4 * u - 8 * t, np.finfo(float).eps)
