"""Local change of a mode: what the residual within a window says against a fit to the whole decay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.levels import EXACT, SURE
from suspid.units import ComplexArray, RealArray

# Fewest samples of a window: three for each unknown of a channel (two of amplitude and phase, an offset, and two of the
# change).
FEWEST_IN_WINDOW = 15
# Numbers of windows that are looked at together: what is slight in each shows in several.
WINDOWS_TOGETHER = (1, 2, 4)
# What a change takes from the sum of squares of the residual over its variance, at least: chance reaches it in 1 of
# 1000 windows.
SIGNIFICANT_CHANGE = 13.8


def local_changes(
    state: ComplexArray, amplitudes: ComplexArray, residual: RealArray, spans: Sequence[tuple[float, float]]
) -> ComplexArray:
    """Return the changes of the exponent per sample of a mode that a residual shows in each window, (window,).

    Within a window the motion is that of the fit times ``1 + e + d (t - middle)``, with an ``e`` for each channel and
    one ``d`` for all. It is 0 where neither a window nor several together show a change that is significant.

    Parameters
    ----------
    state : ndarray (sample,)
        The state of the mode.
    amplitudes : ndarray (channel,)
        Complex amplitudes of the state.
    residual : ndarray (channel, sample)
        The record less the fit.
    spans : sequence of (float, float)
        First and last sample of each window.

    Examples
    --------
    A fit with a damping that holds on average, and a decay that is damped less in its second half:

    >>> time = np.arange(400.0)
    >>> fitted = np.exp((-0.01 + 0.5j) * time)
    >>> true = fitted * np.exp(np.where(time < 200, 0.0, 1e-3 * (time - 200)))
    >>> noise = 1e-5 * np.random.default_rng(1).standard_normal(400)
    >>> left = (true - fitted).real[None] + noise
    >>> local_changes(fitted, np.ones(1, complex), left, [(0, 199), (200, 399)]).real.round(4).tolist()
    [0.0, 0.0011]
    """
    changes = np.zeros(len(spans), complex)
    for together in WINDOWS_TOGETHER:
        for k in range(0, len(spans), together):
            group = slice(k, k + together)
            change = _change(state, amplitudes, residual, spans[group])
            changes[group] = np.where(np.abs(changes[group]) < abs(change), change, changes[group])
    return changes


def _change(
    state: ComplexArray, amplitudes: ComplexArray, residual: RealArray, spans: Sequence[tuple[float, float]]
) -> complex:
    """Return the change over windows that follow each other, 0 where it is not significant."""
    window = slice(int(np.ceil(spans[0][0])), int(spans[-1][1]) + 1)
    z = state[window]
    if len(z) < FEWEST_IN_WINDOW:
        return 0.0
    time = np.arange(len(z)) - (len(z) - 1) / 2
    fixed, _ = np.linalg.qr(np.stack([z.real, z.imag, np.ones(len(z))], axis=1))
    moved = amplitudes[:, None] * (z * time)
    columns = np.stack([moved.real, -moved.imag], axis=1)
    columns = columns - (columns @ fixed) @ fixed.T
    left = residual[:, window]
    left = left - (left @ fixed) @ fixed.T
    motion = np.mean(np.abs(amplitudes[:, None] * z) ** 2, axis=1)
    size = np.maximum(np.mean(left**2, axis=1), EXACT**2 * motion) + 1e-300
    # A mode that is not seen in the window says nothing there.
    if not np.any(motion > SURE**2 * size):
        return 0.0
    normal = np.einsum("cis,cjs,c->ij", columns, columns, 1 / size)
    pulled = np.einsum("cis,cs,c->i", columns, left, 1 / size)
    step = np.linalg.lstsq(normal, pulled, rcond=1e-12)[0]
    rest = np.mean((left - np.einsum("i,cis->cs", step, columns)) ** 2 / size[:, None])
    return complex(*step) if float(step @ pulled) > SIGNIFICANT_CHANGE * float(rest) else 0.0
