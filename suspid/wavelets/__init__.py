"""The wavelet steps of the paper.

`denoise` shrinks the coefficients of a discrete wavelet transform (PyWavelets). `best_bandwidth` chooses the
modified Morlet wavelet of least entropy, `cwt` computes the `Scalogram`, `find_ridges` its ridges and
skeletons, and `fit_ridges` the modes from the slopes of log modulus and phase.
"""

from suspid.wavelets.denoise import denoise
from suspid.wavelets.ridges import (
    ABOVE_NOISE,
    Ridge,
    SkeletonFit,
    Window,
    find_ridges,
    fit_ridges,
    fit_skeleton,
    sample_noise,
)
from suspid.wavelets.scalogram import BandwidthSearch, Morlet, Scalogram, best_bandwidth, cwt

__all__ = [
    "ABOVE_NOISE",
    "BandwidthSearch",
    "Morlet",
    "Ridge",
    "Scalogram",
    "SkeletonFit",
    "Window",
    "best_bandwidth",
    "cwt",
    "denoise",
    "find_ridges",
    "fit_ridges",
    "fit_skeleton",
    "sample_noise",
]
