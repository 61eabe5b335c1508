"""The discrete wavelet transform: filters, details and approximation, and back."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError, RecordError
from suspid.levels import NORMAL_MEDIAN
from suspid.signals import Signal
from suspid.units import ComplexArray, RealArray

if TYPE_CHECKING:
    import pywt


@dataclass(frozen=True, kw_only=True, eq=False)
class FilterBank:
    """Filters of a wavelet for records of one length."""

    wavelet: pywt.Wavelet  # the wavelet with the taps of its filters
    count: int  # length of the record; reflected at its ends it has twice that period
    depth: int  # the deepest possible level

    @cached_property
    def spectra(self) -> ComplexArray:
        """Discrete Fourier transforms of the analysis (low, high) and synthesis (low, high) filters, (filter, bin).

        Their period is that of the reflected record. The plain transform with an orthogonal wavelet needs none.
        """
        return np.asarray(np.fft.fft(np.array(self.wavelet.filter_bank), 2 * self.count))

    @cached_property
    def gains(self) -> RealArray:
        """Gain of the standard deviation of white noise from record to coefficients, (level,): 1 if orthogonal."""
        return np.ones(self.depth) if self.wavelet.orthogonal else _gains(self)

    def at(self, level: int) -> ComplexArray:
        """Return the spectra of the filters stretched by ``2^level``, (filter, non-negative frequency)."""
        bins = (2**level * np.arange(self.count + 1)) % (2 * self.count)
        return np.asarray(np.take(self.spectra, bins, axis=1))


def filter_bank(name: str, count: int) -> FilterBank:
    """Return the filters of a wavelet for records of ``count`` samples."""
    import pywt

    names = pywt.wavelist(kind="discrete")
    if not isinstance(name, str) or name.lower() not in names:
        nearest = ", ".join(repr(n) for n in difflib.get_close_matches(str(name).lower(), names, n=3, cutoff=0.0))
        kind = "a continuous wavelet, which has no inverse here" if name in pywt.wavelist() else "no discrete wavelet"
        raise InputError(f"wavelet={name!r} is {kind}; the nearest names are {nearest}")
    wavelet = pywt.Wavelet(name)
    depth = int(pywt.dwt_max_level(count, wavelet.dec_len))
    if depth < 1:
        raise RecordError(
            f"the record has {count} samples; {name!r} with its {wavelet.dec_len} taps needs at least "
            f"{2 * (wavelet.dec_len - 1)}; take a shorter wavelet, such as 'haar' from 2 samples or 'sym2' from 6"
        )
    return FilterBank(wavelet=wavelet, count=count, depth=depth)


def noise_std(details: list[RealArray], filters: FilterBank) -> RealArray:
    """Return the noise deviation of the record estimated at each level: ``median(|x|) / 0.6745 / gain``."""
    median = np.array([_median(np.abs(d)) for d in details])
    return np.asarray(median / NORMAL_MEDIAN / filters.gains[: len(details)])


def sample_noise(signal: Signal) -> RealArray:
    """Return the standard deviation of white noise in each channel, from the median of its finest wavelet details."""
    import pywt

    # A shorter record has no finest details of the 16 taps of "sym8".
    if signal.values.shape[1] < 16:
        return np.zeros(len(signal.values))
    _, details = pywt.dwt(signal.values, "sym8", mode="symmetric", axis=1)
    return np.asarray(np.median(np.abs(details), axis=1) / NORMAL_MEDIAN)


def stationary_details(samples: RealArray, filters: FilterBank, depth: int) -> tuple[list[RealArray], RealArray]:
    """Return the coefficients of all shifts of one period, finest level first, and the approximation.

    The filters are stretched by ``2^j`` instead of decimating the samples. Multiplied as spectra they are circular for
    a period of any length, not only for multiples of ``2^depth``.
    """
    from scipy.fft import irfft, rfft

    rough = rfft(samples)
    details = []
    for j in range(depth):
        low, high, _, _ = filters.at(j)
        details.append(irfft(rough * high, samples.size))
        rough = rough * low
    return details, irfft(rough, samples.size)


def stationary_inverse(details: list[RealArray], rough: RealArray, filters: FilterBank) -> RealArray:
    """Return one period of samples: the mean of the inverse transforms over all shifts.

    ``low low' + high high'`` is 2 up to the delay of the filters. Division by it instead of 2 also corrects the error
    of "dmey", a truncated wavelet.
    """
    from scipy.fft import irfft, rfft

    spectrum = rfft(rough)
    for j in reversed(range(len(details))):
        low, high, back_low, back_high = filters.at(j)
        spectrum = (spectrum * back_low + rfft(details[j]) * back_high) / (low * back_low + high * back_high)
    return np.asarray(irfft(spectrum, rough.size))


def stationary_split(samples: RealArray, filters: FilterBank, depth: int) -> tuple[list[RealArray], RealArray]:
    """Return details and approximation of the reflected samples, over all shifts."""
    return stationary_details(np.concatenate([samples, samples[::-1]]), filters, depth)


def stationary_merge(details: list[RealArray], rough: RealArray, filters: FilterBank) -> RealArray:
    """Return the samples from details and approximation over all shifts."""
    return stationary_inverse(details, rough, filters)[: filters.count]


def decimated_split(samples: RealArray, filters: FilterBank, depth: int) -> tuple[list[RealArray], RealArray]:
    """Return details, finest level first, and approximation of the plain transform."""
    import pywt

    # PyWavelets refuses read-only arrays.
    rough, *details = pywt.wavedec(samples.copy(), filters.wavelet, mode="symmetric", level=depth)
    return details[::-1], rough


def decimated_merge(details: list[RealArray], rough: RealArray, filters: FilterBank) -> RealArray:
    """Return the samples from details and approximation of the plain transform."""
    import pywt

    samples = pywt.waverec([rough, *details[::-1]], filters.wavelet, mode="symmetric")
    return np.asarray(samples, float)[: filters.count]


def _median(values: RealArray) -> float:
    """Return the median; `numpy.median` takes three times as long for a few hundred values."""
    half = values.size // 2
    parted = np.partition(values, half)
    above = float(parted[half])
    return above if values.size % 2 else (float(np.max(parted[:half])) + above) / 2


def _gains(filters: FilterBank) -> RealArray:
    """Return the root mean square over frequency of the response of each level: the gain of white noise."""
    rough = np.ones(filters.count + 1)
    weight = np.full(filters.count + 1, 1 / filters.count)
    weight[[0, -1]] /= 2
    gains = []
    for j in range(filters.depth):
        low, high, _, _ = np.abs(filters.at(j)) ** 2
        gains.append(np.sqrt(np.sum(weight * rough * high)))
        rough = rough * low
    return np.array(gains)
