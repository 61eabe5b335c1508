"""Bridges: long gaps closed by the polynomial through many samples on each side, where that is known to be near."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from suspid.units import RealArray

# Samples on each side of a gap, two or these shares of its length, and degrees that are tried. Few samples carry noise
# into it, many hold more of the motion than a polynomial follows. Higher degrees follow half a period of a sinusoid,
# but what is left of noise and of faster motion hardly bears them.
SIDES, BENDS = (0.0, 0.125, 0.25, 0.5, 1.0), (1, 3)
# Most samples on each side that a polynomial is fitted to, and most inside at which it is checked: more cost time only.
SOME_BESIDE, SOME_CHECKED = 40, 20
# Stretches on each side that are taken for gaps, spread over this multiple of the length of the gap, but over at least
# that many samples: near enough for a decay.
SOME_STRETCHES, SPREAD_OVER, LEAST_SPREAD = 100, 2, 200


def bridge(values: RealArray, measured: NDArray[np.bool_], first: int, after: int) -> tuple[RealArray, float] | None:
    """Return samples for a gap and their rms error, or None where too little is known around it.

    The error is measured: stretches of the same length before and behind are closed in the same way as if they were
    missing. The larger of both is returned, as the motion may have begun or ended at the gap.

    Parameters
    ----------
    values : ndarray (sample,)
        NaN where missing.
    measured : ndarray (sample,)
        Which samples are of the sensor; others may have been filled.
    first, after : int
        First sample of the gap, and the one after its last.

    Examples
    --------
    >>> values = np.sin(np.arange(1000) / 50)
    >>> true = values[400:480].copy()
    >>> values[400:480] = np.nan
    >>> filled, error = bridge(values, np.isfinite(values), 400, 480)
    >>> error < 0.02, bool(np.max(np.abs(filled - true)) < 0.05)
    (True, True)
    """
    length = after - first
    best: tuple[RealArray, float] | None = None
    for share, degree in product(SIDES, BENDS):
        side = max(2, round(share * length))
        if 2 * min(side, SOME_BESIDE) <= degree + 1:
            continue
        reach = np.unique(np.linspace(1, side, min(side, SOME_BESIDE)).round().astype(np.intp))
        points = np.concatenate([-reach[::-1], length - 1 + reach])
        if first + points[0] < 0 or first + points[-1] >= values.size:
            continue
        around = values[first + points]
        error = _error(values, measured, points, (first, length), degree) if np.all(np.isfinite(around)) else np.inf
        if np.isfinite(error) and (best is None or error < best[1]):
            best = _weights(points, np.arange(length), degree) @ around, error
    return best


def _error(
    values: RealArray, measured: NDArray[np.bool_], points: NDArray[np.intp], gap: tuple[int, int], degree: int
) -> float:
    """Return the larger of the rms errors before and behind a gap, of which first sample and length are given."""
    first, length = gap
    inside = np.unique(np.linspace(0, length - 1, min(length, SOME_CHECKED)).round().astype(np.intp))
    weights = _weights(points, inside, degree)
    far = max(LEAST_SPREAD, SPREAD_OVER * length)
    # A stretch and the samples beside it end before the gap, or begin behind it.
    ends = (first - int(points[-1]), first + length - int(points[0]))
    errors = []
    for low, high in ((ends[0] - far, ends[0]), (ends[1], ends[1] + far)):
        starts = np.arange(max(low, -int(points[0])), min(high, values.size - int(points[-1])))
        every = max(1, starts.size // SOME_STRETCHES)
        starts = starts[::every]
        missed = values[starts[:, None] + points] @ weights.T - values[starts[:, None] + inside]
        missed = missed[np.all(np.isfinite(missed), axis=1)[:, None] & measured[starts[:, None] + inside]]
        # Stretches that overlap are one: what is checked must span the length of the gap.
        if missed.size * every >= length * inside.size:
            errors.append(float(np.sqrt(np.mean(missed**2))))
    return max(errors, default=np.inf)


def _weights(points: NDArray[np.intp], wanted: NDArray[np.intp], degree: int) -> RealArray:
    """Return the weights (wanted, point) of samples in the polynomial of least squares through them."""
    middle, half = 0.5 * float(points[0] + points[-1]), 0.5 * float(points[-1] - points[0])
    known, asked = (np.vander((where - middle) / half, degree + 1) for where in (points, wanted))
    return np.asarray(asked @ np.linalg.pinv(known))
