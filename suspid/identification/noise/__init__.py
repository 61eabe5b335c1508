"""The noise of a record: least variance, likelihood, colour, and correlation between channels.

Every fit of samples takes the noise of each channel for white, of unknown variance above a least one (`WhiteNoise`):
`identify`, and `estimate` of decays and rigs. Fits of spectra, of drives, have noise of their own
(`suspid.greybox.noise_levels`). Where the residual contradicts that, `loudness` and `shared_noise` are the factors by
which variances of the estimates are widened. To fit another noise model, replace `WhiteNoise` in `white`.
"""

from suspid.identification.noise.colour import (
    LOUD,
    correlated,
    lag_one,
    loudness,
    noise_colour,
    over_channels,
    power_near,
)
from suspid.identification.noise.quantisation import ABOVE_RESOLUTION, UNIFORM_STD, resolution
from suspid.identification.noise.shared import most_shared, shared_noise
from suspid.identification.noise.white import (
    ROUNDING_OF_SAMPLES,
    KnownNoise,
    WhiteNoise,
    degrees_of_freedom,
    loss_growth,
    noise_of,
)

__all__ = [
    "ABOVE_RESOLUTION",
    "LOUD",
    "ROUNDING_OF_SAMPLES",
    "UNIFORM_STD",
    "KnownNoise",
    "WhiteNoise",
    "correlated",
    "degrees_of_freedom",
    "lag_one",
    "loss_growth",
    "loudness",
    "most_shared",
    "noise_colour",
    "noise_of",
    "over_channels",
    "power_near",
    "resolution",
    "shared_noise",
]
