"""Motion between samples as a spline of fifth degree, and the low-pass filter for quantities computed from it.

The knots are the samples. The second derivative of such a spline takes any value at every sample, so accelerations are
met as measured, and motion and velocity between the samples follow from them.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from suspid.units import Hertz, RealArray, Second

# Degree of the spline of the motion: its second derivative, the acceleration, is then a smooth cubic spline.
SPLINE_DEGREE = 5
# Points in each step at which forces are computed. Friction that changes its sign between two points is averaged.
FINE_POINTS = 4
# Half the length of the filter, in steps. Twice as much moves no node by a tenth of its error.
FILTER_STEPS = 12
# Corner of the filter, as a share of the rate: below the anti-alias filters of loggers, which cut near 0.4.
CORNER_SHARE = 0.3


@cache
def stencils(order: int) -> RealArray:
    """Return the weights of the coefficients in a derivative at the points of a step, (point, coefficient).

    The first point is the sample; coefficients number ``i`` to ``i + 5`` belong to the step after sample ``i``.
    """
    from scipy.interpolate import BSpline

    basis = BSpline.basis_element(np.arange(SPLINE_DEGREE + 2.0) - (SPLINE_DEGREE + 1) / 2, extrapolate=False)
    one = basis.derivative(order) if order else basis
    points = np.arange(FINE_POINTS)[:, None] / FINE_POINTS - (np.arange(SPLINE_DEGREE + 1) - 2.0)
    return np.asarray(np.nan_to_num(np.asarray(one(points), float)))


def at_samples(coefficients: RealArray, order: int, step: Second) -> RealArray:
    """Return a derivative of the motion at the samples."""
    weights = stencils(order)[0, :SPLINE_DEGREE] / step**order
    count = len(coefficients) - SPLINE_DEGREE + 1
    return np.asarray(sum(w * coefficients[i : i + count] for i, w in enumerate(weights)))


def between_samples(coefficients: RealArray, order: int, step: Second) -> RealArray:
    """Return a derivative of the motion at the samples and at `FINE_POINTS` - 1 points in each step."""
    count = len(coefficients) - SPLINE_DEGREE + 1
    out = np.empty((count - 1) * FINE_POINTS + 1)
    for point, weights in enumerate(stencils(order) / step**order):
        there = count if point == 0 else count - 1
        out[point::FINE_POINTS] = sum(
            w * coefficients[i : i + there] for i, w in enumerate(weights) if point or i < SPLINE_DEGREE
        )
    return out


def spline_through(samples: RealArray) -> RealArray:
    """Return the coefficients of the spline through samples, with zeros beyond the ends."""
    from scipy.linalg import solve_banded

    weights = stencils(0)[0, :SPLINE_DEGREE]
    bands = np.tile(weights[:, None], (1, len(samples)))
    return np.concatenate([np.zeros(2), solve_banded((2, 2), bands, samples), np.zeros(2)])


def filtered(fine: RealArray, step: Second, corner: Hertz) -> RealArray:
    """Return what is given at the fine points, low-passed and at the samples alone; the first axis is time."""
    from scipy.signal import upfirdn

    ends = FILTER_STEPS * FINE_POINTS
    padded = np.concatenate([np.repeat(fine[:1], ends, axis=0), fine, np.repeat(fine[-1:], ends, axis=0)])
    first = 2 * FILTER_STEPS
    whole = upfirdn(_filter(step, corner), padded, up=1, down=FINE_POINTS, axis=0)
    return np.asarray(whole[first : first + (len(fine) - 1) // FINE_POINTS + 1])


def filtered_samples(samples: RealArray, step: Second, corner: Hertz) -> RealArray:
    """Return samples after the same filter as `filtered`."""
    ends = FILTER_STEPS
    padded = np.concatenate([np.repeat(samples[:1], ends), samples, np.repeat(samples[-1:], ends)])
    taps = FINE_POINTS * _filter(step, corner)[::FINE_POINTS]
    return np.asarray(np.convolve(padded, taps, mode="valid"))


@cache
def _filter(step: Second, corner: Hertz) -> RealArray:
    from scipy.signal import firwin

    taps = 2 * FILTER_STEPS * FINE_POINTS + 1
    return np.asarray(firwin(taps, corner, window=("kaiser", 5.0), fs=FINE_POINTS / step))
