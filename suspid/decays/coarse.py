"""A recording averaged over blocks of a length suited to its own motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suspid.decays.trials import block_size
from suspid.levels import FEWEST_SAMPLES
from suspid.signals import Signal, block_means
from suspid.values import frozen_real

# Share of the power of each channel below the highest frequency that is kept. More keeps what clicks and hum add far
# above the motion; less loses a mode that is a tenth as large as another.
MOTION = 0.99


def coarsened(signal: Signal) -> Signal | None:
    """Return the means over blocks of a fraction of the period of the fastest motion, None where those are samples.

    Clicks and hum far above the motion make events and poles of their own; the means have little of them.

    Examples
    --------
    >>> time = np.arange(20_000) / 5000
    >>> values = np.exp(-time) * np.cos(9 * time) + 0.01 * np.sin(9000 * time)
    >>> coarse = coarsened(Signal(start=0.0, step=2e-4, values=values[None], channels=("seat",)))
    >>> coarse.step > 20 * 2e-4, float(np.ptp(np.diff(coarse.values[0]) / coarse.step)) < 20
    (True, True)
    """
    values = signal.values - signal.values.mean(axis=1, keepdims=True)
    power = np.cumsum(np.abs(np.fft.rfft(values * np.hanning(values.shape[1]), axis=1)) ** 2, axis=1)
    lines = np.argmax(power >= MOTION * power[:, -1:], axis=1)[power[:, -1] > 0]
    if not lines.size:
        return None
    size = block_size(signal.step, float(max(np.max(lines), 1)) / (signal.step * values.shape[1]))
    if size < 2 or values.shape[1] < FEWEST_SAMPLES * size:
        return None
    means = frozen_real(block_means(signal.values, size))
    return replace(signal, start=signal.start + 0.5 * (size - 1) * signal.step, step=size * signal.step, values=means)
