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


def suited(samples: RealArray) -> Interpolation:
    """Return the interpolation of inputs (input, sample) where none is asked for.

    A spline overshoots at steps. An input that moves for less than half of its samples, and not for none, is a step, a
    pulse or a bump.

    Examples
    --------
    >>> suited(np.sin(np.arange(50.0))[None]), suited((np.arange(50.0)[None] > 9) * 1.0)
    ('cubic', 'linear')
    """
    moves = np.mean(np.diff(samples, axis=1) != 0, axis=1)
    return "linear" if samples.shape[1] < 3 or np.any((moves > 0) & (moves < 0.5)) else "cubic"


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
    forcing = made[:n, n:] @ pieces.reshape(width, pieces.shape[2])
    return recursion(made[:n, :n], forcing[:, :, None], start[:, None], forcing.shape[1])[:, :, 0]


def recursion(E: RealArray, forcing: RealArray | None, start: RealArray, count: int) -> RealArray:
    """Return x of ``x[k + 1] = E x[k] + forcing[k]`` for k = 0 … count - 1, (state, sample, column).

    ``start`` is (state, column), ``forcing`` (state, sample, column), None for free motion. The record is cut into
    about ``sqrt(count)`` blocks. All run side by side from rest, then the free motion from the start of each is added:
    three loops of the square root of the length.
    """
    size, columns = start.shape
    length = int(np.ceil(np.sqrt(count)))
    blocks = -(-count // length)
    states = np.zeros((length + 1, size, blocks * columns))
    if forcing is not None:
        padded = np.zeros((size, blocks * length, columns))
        padded[:, :count] = forcing
        states[1:] = padded.reshape(size, blocks, length, columns).transpose(2, 0, 1, 3).reshape(length, size, -1)
        for k in range(length):
            states[k + 1] += E @ states[k]
    ends = states[length].reshape(size, blocks, columns)
    jump = np.linalg.matrix_power(E, length)
    starts, state = np.empty((size, blocks, columns)), start
    for block in range(blocks):
        starts[:, block] = state
        state = jump @ state + ends[:, block]
    free = starts.reshape(size, -1)
    for k in range(length):
        states[k] += free
        free = E @ free
    whole = states[:length].reshape(length, size, blocks, columns).transpose(1, 2, 0, 3)
    return np.asarray(whole.reshape(size, blocks * length, columns)[:, :count])
