"""The continuous wavelet transform with the modified Morlet wavelet: Eq. (12)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.signals import as_signal
from suspid.units import Hertz, Radian, RadianPerSecond, RealArray
from suspid.wavelets.best_bandwidth import best_bandwidth
from suspid.wavelets.morlet import Morlet
from suspid.wavelets.scalogram import Normalization, Scalogram
from suspid.wavelets.transform import CUT, row_frequencies, transform


@explained
def cwt(
    response: RecordLike,
    *,
    fs: Hertz | None = None,
    omega: Sequence[RadianPerSecond] | RealArray | None = None,
    bandwidth: float | None = None,
    center: Radian = 2 * np.pi,
    normalization: Normalization = "paper",
    full_rate: bool = False,
    precision: float = CUT,
) -> Scalogram:
    """Return the continuous wavelet transform of all channels, Eq. (12).

    ``CWT(s, tau) = s^-1/2 sum_n x(t_n) conj(psi((t_n - tau) / s)) h`` with h the sampling step, computed
    from the exact spectrum of the wavelet, which is neither truncated nor sampled. The signal is zero before and after
    the record, so the coefficients within the cone of influence contain an edge effect.

    Parameters
    ----------
    response : control.TimeResponseData, or what `as_record` takes
        The record, uniformly sampled.
    fs : float, optional
        Sampling rate [Hz] of samples that come without a time.
    omega : array_like (row,), optional
        Angular frequencies of the rows [rad/s], below the Nyquist frequency; the scale is ``center / omega``. Default:
        24 an octave from four cycles in the record to 0.9 of the Nyquist frequency.
    bandwidth : float, optional
        N of the modified Morlet wavelet. Default: that of least entropy, see `best_bandwidth`.
    center : float
        w0 [rad].
    normalization : {"paper", "amplitude"}
        "paper": Eq. (12). "amplitude": divided by ``sqrt(pi N s) / 2``, so that ``A cos(omega t)``
        has modulus A on its row.
    full_rate : bool
        False: each row holds only the samples that its bandwidth needs, from an inverse FFT of its own Fourier bins.
        True: every row holds every sample of the record.
    precision : float
        Share of its peak below which the spectrum of the wavelet counts as zero. The error of the coefficients is
        about that share of the largest one. For pictures 1e-5 suffices, at less than half the cost.

    Returns
    -------
    Scalogram
        Rows in the order of ``omega``.

    Raises
    ------
    InputError
        If a frequency is not between 0 and Nyquist, or a wavelet is more than ten times as long as the record.
    RecordError
        If the record cannot be used, see `read_record`.

    Examples
    --------
    >>> import numpy as np, control
    >>> t = np.arange(0, 10, 0.01)
    >>> tone = control.TimeResponseData(t, 3 * np.cos(20 * t), issiso=True, output_labels=["seat"])
    >>> scalogram = cwt(tone, omega=[20.0], bandwidth=4.0, normalization="amplitude")
    >>> float(np.abs(scalogram.rows[0][0, scalogram.inside(0, cones=3)]).mean().round(6))
    3.0
    """
    record = as_record(response, fs=fs)
    signal = as_signal(record)
    rows = row_frequencies(signal) if omega is None else np.atleast_1d(np.asarray(omega, float))
    if bandwidth is None:
        bandwidth = best_bandwidth(record, omega=rows, center=center).best
    return transform(
        signal,
        omega=rows,
        wavelet=Morlet(center=center, bandwidth=bandwidth),
        normalization=normalization,
        full_rate=full_rate,
        precision=precision,
    )
