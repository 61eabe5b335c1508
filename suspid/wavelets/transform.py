"""The transform with the modified Morlet wavelet from checked samples, and the rows it has by default."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.signals import Signal
from suspid.units import ComplexArray, RadianPerSecond, RealArray
from suspid.values import frozen_complex, frozen_real
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.scalogram import Normalization, Scalogram

# Share of its peak below which the spectrum of the wavelet counts as zero. It is near rounding; a larger share is
# faster and leaves that error in the coefficients.
CUT = 1e-13
# Most samples of all rows that are transformed at once. More are no faster and take more memory.
BLOCK = 2**21
# Longest envelope of a wavelet [records]. A longer wavelet sees only the ends of the record.
LONGEST_ENVELOPE = 10.0
# Rows per octave: a third of the width of the narrowest row in use. Fewer rows miss ridges.
ROWS_PER_OCTAVE = 24


def row_band(
    signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None = None
) -> tuple[RadianPerSecond, RadianPerSecond]:
    """Return the first and last angular frequency of the rows [rad/s]: the band, or where ridges can be found.

    Without a band they go from four cycles in the record to 0.9 of the Nyquist frequency.
    """
    nyquist = np.pi / signal.step
    low, high = band or (2 * np.pi * 4.0 / signal.duration, 0.9 * nyquist)
    if not 0 < low < high <= nyquist:
        raise InputError(
            f"the band {low / (2 * np.pi):.5g} … {high / (2 * np.pi):.5g} Hz must be two increasing frequencies "
            f"between 0 and the Nyquist frequency, {0.5 / signal.step:.5g} Hz"
        )
    return float(low), float(min(high, 0.999 * nyquist))


def row_frequencies(signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None = None) -> RealArray:
    """Return the angular frequencies of the rows over a band [rad/s], (row,), evenly spaced in the logarithm."""
    low, high = row_band(signal, band)
    return frozen_real(np.geomspace(low, high, max(8, int(np.ceil(ROWS_PER_OCTAVE * np.log2(high / low))))))


def transform(
    signal: Signal,
    *,
    omega: RealArray,
    wavelet: Morlet,
    normalization: Normalization = "paper",
    full_rate: bool = False,
    precision: float = CUT,
) -> Scalogram:
    """Return the transform of checked samples; see `cwt`."""
    from scipy.fft import fft

    _check_rows(signal, omega, wavelet)
    if not CUT / 10 <= precision < 0.1:
        raise InputError(f"{precision=} must be a share between {CUT / 10:g} and 0.1, such as {CUT:g}")
    scale = wavelet.center / omega
    count = signal.values.shape[1]
    reach = np.sqrt(-np.log(precision) * wavelet.bandwidth) * np.max(scale) / signal.step
    length = _length(count + int(np.ceil(reach)))
    fourier = fft(signal.values, n=length, axis=1)
    per_bin = 2 * np.pi / (length * signal.step)
    halfwidth = 2 * np.sqrt(-np.log(precision) / wavelet.bandwidth)
    first = np.ceil((wavelet.center - halfwidth) / scale / per_bin).astype(int)
    last = np.floor((wavelet.center + halfwidth) / scale / per_bin).astype(int)
    doublings = np.maximum(np.floor(np.log2(length / (last - first + 1))), 0).astype(int)
    strides = 1 << np.minimum(doublings, _twos(length)) if not full_rate else np.ones_like(first)
    factor = np.sqrt(scale) if normalization == "paper" else 2 / np.sqrt(np.pi * wavelet.bandwidth) + 0 * scale
    rows: list[ComplexArray] = [np.empty(0, complex)] * len(omega)
    for stride in np.unique(strides):
        members = np.flatnonzero(strides == stride)
        at_once = max(1, BLOCK // (len(signal.channels) * (length // stride)))
        for some in np.array_split(members, -(-len(members) // at_once)):
            block = _row_block(fourier, first[some], last[some], scale[some] * per_bin, wavelet, length // stride)
            block = block[..., : -(-count // stride)] * (factor[some, None] / stride)
            for i, index in enumerate(some):
                rows[index] = frozen_complex(block[:, i])
    return Scalogram(
        signal=signal,
        wavelet=wavelet,
        normalization=normalization,
        omega=frozen_real(omega),
        rows=tuple(rows),
        strides=tuple(int(s) for s in strides),
    )


def _row_block(
    fourier: ComplexArray,
    first: NDArray[np.intp],
    last: NDArray[np.intp],
    per_bin: RealArray,
    wavelet: Morlet,
    length: int,
) -> ComplexArray:
    """Return rows (channel, row, length): inverse FFTs of the Fourier bins first … last, folded to ``length``."""
    from scipy.fft import ifft

    whole = fourier.shape[1]
    folded = np.zeros((len(fourier), len(first), length), complex)
    width = int(np.max(last - first)) + 1
    kernels = wavelet.spectrum((first[:, None] + np.arange(width)) * per_bin[:, None])
    for row, (start, kernel) in enumerate(zip(first, kernels, strict=True)):
        done = 0
        # A slice ends where the spectrum of the record or the folded one ends. Bins beyond Nyquist repeat the periodic
        # spectrum of the record, as in the sum of Eq. (12).
        while done < width:
            source, target = (start + done) % whole, (start + done) % length
            size = min(width - done, whole - source, length - target)
            folded[:, row, target : target + size] += fourier[:, source : source + size] * kernel[done : done + size]
            done += size
    return np.asarray(ifft(folded, axis=2, overwrite_x=True))


def _check_rows(signal: Signal, omega: RealArray, wavelet: Morlet) -> None:
    nyquist = np.pi / signal.step
    if omega.ndim != 1 or not omega.size:
        raise InputError(f"omega must be a vector of at least one angular frequency; got shape {omega.shape}")
    wrong = omega[~((omega > 0) & (omega < nyquist))]
    if wrong.size:
        raise InputError(
            f"{wrong.size} of {omega.size} angular frequencies (the first: {wrong[0]:g} rad/s) do not lie between 0 "
            f"and the Nyquist frequency {nyquist:g} rad/s of the record"
        )
    longest = float(np.max(wavelet.envelope(omega)))
    if longest > LONGEST_ENVELOPE * signal.duration:
        raise InputError(
            f"at omega = {np.min(omega):g} rad/s the envelope of the wavelet lasts {longest:g} s, over "
            f"{LONGEST_ENVELOPE:g} times the {signal.duration:g} s of the record; raise the lowest omega, or lower "
            f"bandwidth or center"
        )


def _length(least: int) -> int:
    """Return a length for a fast FFT that can be halved often."""
    from scipy.fft import next_fast_len

    unit = 1 << max(0, least.bit_length() - 8)
    return int(next_fast_len(-(-least // unit))) * unit


def _twos(length: int) -> int:
    """Return the number of times that the length can be halved."""
    return (length & -length).bit_length() - 1
