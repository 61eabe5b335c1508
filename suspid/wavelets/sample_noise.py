"""Standard deviation of white noise from wavelet coefficients."""

from __future__ import annotations

import numpy as np

from suspid.signals import Signal
from suspid.units import RealArray

# Median of |z| for standard normal z: the median absolute coefficient is 0.6745 standard deviations.
NORMAL_MEDIAN = 0.6744897501960817
# A shorter record has no finest details of the 16 taps of "sym8".
FEWEST = 16


def sample_noise(signal: Signal) -> RealArray:
    """Return the standard deviation of white noise in each channel, from the median of its finest wavelet details."""
    import pywt

    if signal.values.shape[1] < FEWEST:
        return np.zeros(len(signal.values))
    _, details = pywt.dwt(signal.values, "sym8", mode="symmetric", axis=1)
    return np.asarray(np.median(np.abs(details), axis=1) / NORMAL_MEDIAN)
