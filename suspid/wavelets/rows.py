"""Rows of the wavelet transform: products of spectra, each row at the rate and over the length that it needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.units import ComplexArray, RealArray, Second
from suspid.values import frozen_complex
from suspid.wavelets.morlet import Morlet

# Most samples of all rows that are transformed at once. More are no faster and take more memory.
BLOCK = 2**18


@dataclass(frozen=True, kw_only=True, slots=True)
class RowPlan:
    """Which rows are transformed, and how far their wavelets reach."""

    wavelet: Morlet
    step: Second  # sampling step of the record [s]
    count: int  # samples of the record
    precision: float  # share of its peak below which the spectrum of the wavelet counts as zero
    scale: RealArray  # (row,): scales [s]
    factor: RealArray  # (row,): what the inverse transform of each row is multiplied by

    @property
    def reach(self) -> RealArray:
        """Samples over which each wavelet falls to the precision, (row,)."""
        return np.asarray(np.sqrt(-np.log(self.precision) * self.wavelet.bandwidth) * self.scale / self.step)

    def bins(self, rows: slice | NDArray[np.intp], length: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the first and the last bin of a transform of some length in which a wavelet counts, (row,)."""
        halfwidth = 2 * np.sqrt(-np.log(self.precision) / self.wavelet.bandwidth)
        per_bin = self.scale[rows] * (2 * np.pi / (length * self.step))
        first = np.ceil((self.wavelet.center - halfwidth) / per_bin).astype(int)
        return first, np.floor((self.wavelet.center + halfwidth) / per_bin).astype(int)

    def strides(self) -> NDArray[np.intp]:
        """Return the samples of the record per sample of each row that its bandwidth permits, (row,)."""
        length = _length(self.count + int(np.ceil(np.max(self.reach))))
        first, last = self.bins(slice(None), length)
        doublings = np.maximum(np.floor(np.log2(length / (last - first + 1))), 0).astype(int)
        return np.asarray(1 << np.minimum(doublings, (length & -length).bit_length() - 1))


def wavelet_rows(values: RealArray, plan: RowPlan, strides: NDArray[np.intp]) -> tuple[ComplexArray, ...]:
    """Return the rows (channel, row sample) of samples (channel, sample).

    The record is zero before its first and after its last sample, so each transform is longer than the record by the
    reach of its wavelets. Rows of short reach are transformed over a shorter length than those of long reach.
    """
    from scipy.fft import fft

    rows: list[ComplexArray] = [np.empty(0, complex)] * len(strides)
    for members in _groups(plan, strides):
        length = _length(plan.count + int(np.ceil(np.max(plan.reach[members]))), int(np.max(strides[members])))
        fourier = fft(values, n=length, axis=1)
        for stride in np.unique(strides[members]):
            alike = members[strides[members] == stride]
            at_once = max(1, BLOCK // (len(values) * (length // stride)))
            for some in np.array_split(alike, -(-len(alike) // at_once)):
                block = _row_block(fourier, plan, some, int(stride))
                for i, index in enumerate(some):
                    rows[index] = frozen_complex(block[:, i, : -(-plan.count // stride)])
    return tuple(rows)


def _groups(plan: RowPlan, strides: NDArray[np.intp]) -> Sequence[NDArray[np.intp]]:
    """Return the rows that share a length, such that the fewest samples are transformed in all.

    The rows of one octave of reach stay together. A group costs half a transform for the record, which is real, and a
    transform at its own rate for each of its rows.
    """
    reach = plan.reach
    octaves = np.floor(np.log2(np.maximum(reach, 1.0))).astype(int)
    each = [np.flatnonzero(octaves == octave) for octave in np.unique(octaves)]
    lengths = [plan.count + float(np.max(reach[rows])) for rows in each]
    work = np.cumsum([0.0, *(float(np.sum(1 / strides[rows])) for rows in each)])
    # The least cost of the octaves before each one, and where the last of their groups begins.
    least, begin = [0.0], [0]
    for stop in range(1, len(each) + 1):
        costs = [least[start] + lengths[stop - 1] * (0.5 + work[stop] - work[start]) for start in range(stop)]
        begin.append(int(np.argmin(costs)))
        least.append(min(costs))
    return [np.sort(np.concatenate(each[start:stop])) for start, stop in _spans(begin)]


def _spans(begin: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield the first octave and the one after the last of each group, from the last group to the first."""
    stop = len(begin) - 1
    while stop:
        yield begin[stop], stop
        stop = begin[stop]


def _row_block(fourier: ComplexArray, plan: RowPlan, rows: NDArray[np.intp], stride: int) -> ComplexArray:
    """Return rows (channel, row, sample): inverse FFTs of the bins of each wavelet, folded to their own rate."""
    from scipy.fft import ifft

    whole = fourier.shape[1]
    length = whole // stride
    first, last = plan.bins(rows, whole)
    folded = np.zeros((len(fourier), len(rows), length), complex)
    width = int(np.max(last - first)) + 1
    per_bin = plan.scale[rows] * (2 * np.pi / (whole * plan.step))
    kernels = plan.wavelet.spectrum((first[:, None] + np.arange(width)) * per_bin[:, None])
    kernels *= plan.factor[rows, None] / stride
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


def _length(least: int, multiple: int = 1) -> int:
    """Return a length for a fast FFT that can be halved often, and is a multiple of a power of two."""
    from scipy.fft import next_fast_len

    unit = max(multiple, 1 << max(0, least.bit_length() - 8))
    return int(next_fast_len(-(-least // unit))) * unit
