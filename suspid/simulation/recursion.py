"""Exact response of a linear system to inputs that are polynomials between samples."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from suspid.units import RealArray, Second

# How an input moves between two samples: on a straight line, or on the cubic spline through all samples.
Interpolation: TypeAlias = Literal["linear", "cubic"]
DEGREES = {"linear": 1, "cubic": 3}


def derivatives(samples: RealArray, step: Second, interpolation: Interpolation) -> RealArray:
    """Return the value and the derivatives of inputs just after each sample, (derivative, input, sample).

    They are those of the interpolating polynomials; the last sample continues the last one.
    """
    if interpolation == "linear":
        slope = np.diff(samples, axis=1) / step
        return np.stack([samples, np.concatenate([slope, slope[:, -1:]], axis=1)])
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(step * np.arange(samples.shape[1]), samples, axis=1)
    times = step * np.arange(samples.shape[1])
    return np.stack([spline(times, order) for order in range(DEGREES[interpolation] + 1)])


def driven_states(A: RealArray, B: RealArray, pieces: RealArray, start: RealArray, step: Second) -> RealArray:
    """Return the states at the samples, (state, sample): exact for polynomials between them.

    ``x' = A x + sum_d B[d] u^(d)``, with B (derivative, state, input), of which the higher derivatives may be left out,
    and ``pieces`` as `derivatives` returns them. One step is the exponential of the system with the derivatives of the
    inputs as states.
    """
    from scipy.linalg import expm

    degrees, inputs, _ = pieces.shape
    n, width = len(A), degrees * inputs
    whole = np.zeros((n + width, n + width))
    whole[:n, :n] = A
    for derivative, columns in enumerate(B):
        whole[:n, n + derivative * inputs : n + (derivative + 1) * inputs] = columns
    whole[n : n + width - inputs, n + inputs :] = np.eye(width - inputs)
    made = expm(whole * step)
    return recursion(made[:n, :n], made[:n, n:] @ pieces.reshape(width, -1), start)


def recursion(E: RealArray, forcing: RealArray, start: RealArray) -> RealArray:
    """Return x of ``x[k + 1] = E x[k] + forcing[k]``, (state, sample), without a loop over the samples.

    The record is cut into about as many blocks as each has samples. All blocks run side by side from rest, then one
    after another their starts are found, then all run again from those: three loops of the square root of the length.
    """
    n, count = forcing.shape
    length = max(1, round(count**0.5))
    blocks = -(-count // length)
    padded = np.zeros((n, blocks * length))
    padded[:, :count] = forcing
    pushes = np.ascontiguousarray(padded.reshape(n, blocks, length).transpose(2, 0, 1))
    ends = np.zeros((n, blocks))
    for push in pushes:
        ends = E @ ends + push
    jump = np.linalg.matrix_power(E, length)
    starts = np.empty((n, blocks))
    state = start
    for block in range(blocks):
        starts[:, block] = state
        state = jump @ state + ends[:, block]
    states = np.empty((length, n, blocks))
    states[0] = starts
    for k in range(length - 1):
        states[k + 1] = E @ states[k] + pushes[k]
    return np.asarray(states.transpose(1, 2, 0).reshape(n, -1)[:, :count])
