"""The transform with the modified Morlet wavelet from checked samples, and the rows it has by default."""

from __future__ import annotations

from typing import get_args

import numpy as np

from suspid.errors import InputError, RecordError
from suspid.signals import Signal
from suspid.units import RadianPerSecond, RealArray
from suspid.values import frozen_real
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.rows import RowPlan, wavelet_rows
from suspid.wavelets.scalogram import Normalization, Scalogram

# Share of its peak below which the spectrum of the wavelet counts as zero. It is near rounding; a larger share is
# faster and leaves that error in the coefficients.
CUT = 1e-13
# Longest envelope of a wavelet [records]. A longer wavelet sees only the ends of the record.
LONGEST_ENVELOPE = 10.0


def row_band(
    signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None = None
) -> tuple[RadianPerSecond, RadianPerSecond]:
    """Return the first and last angular frequency of the rows [rad/s]: the band, or where ridges can be found.

    Without a band they go from four cycles in the record to 0.9 of the Nyquist frequency.
    """
    nyquist = np.pi / signal.step
    low, high = band or (2 * np.pi * 4.0 / signal.duration, 0.9 * nyquist)
    if band is None and low >= high:
        raise RecordError(f"the record has {signal.timepts.size} samples, too few for a transform; record longer")
    if not 0 < low < high <= nyquist:
        raise InputError(
            f"the band {low / (2 * np.pi):.5g} … {high / (2 * np.pi):.5g} Hz must be two increasing frequencies "
            f"between 0 and the Nyquist frequency, {0.5 / signal.step:.5g} Hz"
        )
    return float(low), float(min(high, 0.999 * nyquist))


def row_frequencies(signal: Signal, band: tuple[RadianPerSecond, RadianPerSecond] | None = None) -> RealArray:
    """Return the angular frequencies of the rows over a band [rad/s], (row,), evenly spaced in the logarithm."""
    low, high = row_band(signal, band)
    # Rows per octave: a third of the width of the narrowest row in use. Fewer rows miss ridges.
    return frozen_real(np.geomspace(low, high, max(8, int(np.ceil(24 * np.log2(high / low))))))


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
    _check_rows(signal, omega, wavelet)
    if not CUT / 10 <= precision < 0.1:
        raise InputError(f"{precision=} must be a share between {CUT / 10:g} and 0.1, such as {CUT:g}")
    if normalization not in get_args(Normalization):
        raise InputError(f"{normalization=} must be one of {', '.join(map(repr, get_args(Normalization)))}")
    scale = wavelet.center / omega
    plan = RowPlan(
        wavelet=wavelet,
        step=signal.step,
        count=signal.values.shape[1],
        precision=precision,
        scale=scale,
        factor=np.sqrt(scale)
        if normalization == "paper"
        else np.full_like(scale, 2 / np.sqrt(np.pi * wavelet.bandwidth)),
    )
    strides = np.ones(len(omega), int) if full_rate else plan.strides()
    return Scalogram(
        signal=signal,
        wavelet=wavelet,
        normalization=normalization,
        omega=frozen_real(omega),
        rows=wavelet_rows(signal.values, plan, strides),
        strides=tuple(int(s) for s in strides),
    )


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
