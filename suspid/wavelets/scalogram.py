"""The scalogram: the wavelet transform of a record, row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from suspid.errors import InputError
from suspid.results import Result
from suspid.signals import Signal
from suspid.units import ComplexArray, RealArray
from suspid.wavelets.morlet import Morlet
from suspid.words import count

Normalization = Literal["paper", "amplitude"]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Scalogram(Result):
    """Wavelet transform of a record, each row at the sampling rate that its bandwidth needs.

    Parameters
    ----------
    signal : Signal
        The record.
    wavelet : Morlet
        The wavelet.
    normalization : {"paper", "amplitude"}
        See `cwt`.
    omega : ndarray (row,)
        Angular frequencies [rad/s].
    rows : tuple of ndarray (channel, row sample)
        Coefficients; row i holds every ``strides[i]``-th sample of the record.
    strides : tuple of int
        Samples of the record per sample of the row.

    Examples
    --------
    >>> from suspid import as_record, cwt
    >>> t = np.arange(0, 10, 0.01)
    >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
    >>> found.channels, found.scale.round(3), len(found.rows)
    (('seat',), array([0.628, 0.314]), 2)
    """

    signal: Signal
    wavelet: Morlet
    normalization: Normalization
    omega: RealArray
    rows: tuple[ComplexArray, ...]
    strides: tuple[int, ...]

    @property
    def scale(self) -> RealArray:
        """Scales ``w0 / omega`` [s], (row,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> (found.scale * found.omega).round(3)
        array([6.283, 6.283])
        """
        return np.asarray(self.wavelet.center / self.omega)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 4, 0.01)
        >>> scalogram = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[20.0], bandwidth=8.0)
        >>> scalogram.channels
        ('seat',)
        """
        return self.signal.channels

    @property
    def cone(self) -> RealArray:
        """Cone of influence [s], (row,): the distance from either end within which the edge disturbs the coefficients.

        It is the time ``s sqrt(N)`` in which the wavelet's envelope falls by e.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> found.cone / found.scale
        array([2., 2.])
        """
        return self.wavelet.envelope(self.omega)

    @property
    def coefficients(self) -> ComplexArray:
        """All coefficients, (channel, row, sample), of a transform made with ``full_rate=True``.

        Raises
        ------
        InputError
            If the rows are stored at their own rates.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> whole = cwt(found.signal.values[0], fs=100, omega=[20.0], bandwidth=4.0, full_rate=True)
        >>> whole.coefficients.shape
        (1, 1, 1000)
        """
        if set(self.strides) - {1}:
            raise InputError(
                "the rows are stored at their own rates; use cwt(..., full_rate=True), or timepts() and rows"
            )
        return np.stack(self.rows, axis=1)

    def timepts(self, row: int) -> RealArray:
        """Return the times of the samples of a row [s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> found.timepts(1)[:3]
        array([0.  , 0.16, 0.32])
        """
        count = self.rows[row].shape[1]
        return np.asarray(self.signal.start + self.signal.step * self.strides[row] * np.arange(count), float)

    def weights(self, row: int) -> RealArray:
        """Return the number of samples of the record that each sample of a row represents.

        They are the weights of the trapezoidal rule, corrected to second order at both ends, where the modulus of a
        long wavelet need not be small.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> round(found.weights(0).sum())
        1000
        """
        stride, count = self.strides[row], self.rows[row].shape[1]
        weights = np.full(count, float(stride))
        if stride == 1:
            return weights
        beyond = self.signal.values.shape[1] - 0.5 - stride * (count - 1)
        if count < 3:
            weights[-1] += 0.5 - stride + beyond
            return weights
        outward = np.array([3.0, -4.0, 1.0]) / (2 * stride)
        for end, reach in ((weights[:3], 0.5), (weights[-1:-4:-1], beyond)):
            end += (reach**2 / 2 - stride**2 / 12) * outward
            end[0] += reach - stride / 2
        return weights

    def inside(self, row: int, *, cones: float = 1.0) -> NDArray[np.bool_]:
        """Return which samples of a row lie at least ``cones`` cones away from both ends.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> kept = found.timepts(1)[found.inside(1)]
        >>> bool(kept[0] >= found.cone[1])
        True
        """
        time, reach = self.timepts(row), cones * self.cone[row]
        end = self.signal.start + self.signal.duration
        return np.asarray((time >= self.signal.start + reach) & (time <= end - reach))

    def modulus(self, timepts: ArrayLike) -> RealArray:
        """Return the modulus at any times, (channel, row, time), linear between the samples of each row.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt
        >>> t = np.arange(0, 10, 0.01)
        >>> found = cwt(as_record(np.cos(20 * t), timepts=t, channels=["seat"]), omega=[10.0, 20.0], bandwidth=4.0)
        >>> (found.modulus([5.0])[0, 1] / found.wavelet.gain(20j, found.scale[1])).real.round(2)
        array([0.5])
        """
        time = np.asarray(timepts, float)
        out = np.empty((len(self.channels), len(self.omega), time.size))
        for i, row in enumerate(self.rows):
            for j, samples in enumerate(np.abs(row)):
                out[j, i] = np.interp(time, self.timepts(i), samples)
        return out

    def _table(self) -> Mapping[str, Sequence[object]]:
        moduli = np.array([np.max(np.abs(row), axis=1) for row in self.rows])
        return {
            "f_hz": (self.omega / (2 * np.pi)).tolist(),
            "omega_rad_per_s": self.omega.tolist(),
            "scale_s": self.scale.tolist(),
            "cone_s": self.cone.tolist(),
            "step_s": [self.signal.step * stride for stride in self.strides],
            **{f"{name} largest": column for name, column in zip(self.channels, moduli.T.tolist(), strict=True)},
        }

    def __str__(self) -> str:
        low, high = (float(end) / (2 * np.pi) for end in (np.min(self.omega), np.max(self.omega)))
        start, end = self.signal.start, self.signal.start + self.signal.duration
        return (
            f"wavelet transform of {count(len(self.channels), 'channel')}: {count(len(self.omega), 'row')} from "
            f"{low:.4g} to {high:.4g} Hz, {start:.4g} to {end:.4g} s, bandwidth N = {self.wavelet.bandwidth:.4g}"
        )
