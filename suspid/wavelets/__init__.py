"""The wavelet steps of the paper.

`denoise` shrinks the coefficients of a discrete wavelet transform. `best_bandwidth` finds the modified Morlet wavelet
(`Morlet`) of least entropy, `cwt` computes the `Scalogram` with it, `find_ridges` finds its ridges (`Ridge`) with
their trusted windows, and `fit_ridges` fits the modes to the slopes of log modulus and phase along them.
"""

from suspid.wavelets.best_bandwidth import BANDWIDTHS, BandwidthSearch, best_bandwidth
from suspid.wavelets.cwt import cwt
from suspid.wavelets.denoise import denoise
from suspid.wavelets.filter_bank import sample_noise
from suspid.wavelets.find_ridges import find_ridges
from suspid.wavelets.fit_ridges import SkeletonFit, fit_ridges, fit_skeleton
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.ridge import Ridge, Window
from suspid.wavelets.ridge_at import ABOVE_NOISE
from suspid.wavelets.scalogram import Scalogram
from suspid.wavelets.transform import row_band, row_frequencies

__all__ = [
    "ABOVE_NOISE",
    "BANDWIDTHS",
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
    "row_band",
    "row_frequencies",
    "sample_noise",
]
