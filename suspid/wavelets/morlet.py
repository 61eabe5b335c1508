"""The modified Morlet wavelet: Eq. (13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from suspid.errors import InputError
from suspid.units import ComplexArray, Radian, RealArray


@dataclass(frozen=True, kw_only=True, slots=True)
class Morlet:
    """The modified Morlet wavelet ``psi(t) = exp(j w0 t) exp(-t^2 / N)``, Eq. (13).

    Up to a constant factor it is PyWavelets' ``cmorB-C`` with B = N and w0 = 2 pi C.

    Parameters
    ----------
    center : float
        w0 [rad]: the scale of angular frequency omega is ``w0 / omega``.
    bandwidth : float
        N [1]. A larger N resolves frequency better and time worse.

    Examples
    --------
    >>> Morlet(center=6.0, bandwidth=2.0).spectrum(6.0).round(4)
    np.float64(2.5066)
    """

    center: Radian
    bandwidth: float

    def __post_init__(self) -> None:
        for name, value in (("center", self.center), ("bandwidth", self.bandwidth)):
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value} of the wavelet must be positive and finite")

    def waveform(self, t: ArrayLike) -> ComplexArray:
        """Return ``psi(t)``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Morlet
        >>> wavelet = Morlet(center=6.0, bandwidth=2.0)
        >>> abs(wavelet.waveform([0.0, 2.0**0.5])).round(3)
        array([1.   , 0.368])
        """
        t = np.asarray(t, float)
        return np.asarray(np.exp(1j * self.center * t - t**2 / self.bandwidth))

    def spectrum(self, omega: ArrayLike) -> RealArray:
        """Return ``psi^(w) = sqrt(pi N) exp(-N (w - w0)^2 / 4)``.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Morlet
        >>> wavelet = Morlet(center=6.0, bandwidth=2.0)
        >>> (wavelet.spectrum([5.0, 6.0]) / np.sqrt(2 * np.pi)).round(3)
        array([0.607, 1.   ])
        """
        away = np.asarray(omega, float) - self.center
        return np.asarray(np.sqrt(np.pi * self.bandwidth) * np.exp(-self.bandwidth * away**2 / 4))

    def gain(self, pole: ArrayLike, scale: ArrayLike) -> ComplexArray:
        """Return the transform of ``exp(pole t)`` at tau = 0: ``sqrt(pi N s) exp(N (s pole - j w0)^2 / 4)``.

        At any other tau, far from the ends of the record, it is this times ``exp(pole tau)``. A skeleton along one row
        is therefore exactly an exponential, and damping does not bias its slopes.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Morlet
        >>> wavelet = Morlet(center=6.0, bandwidth=2.0)
        >>> scale = 6.0 / 20
        >>> complex(wavelet.gain(20j, scale)).real / (2 * np.pi * scale) ** 0.5
        1.0
        """
        scale = np.asarray(scale, float)
        away = scale * np.asarray(pole, complex) - 1j * self.center
        return np.asarray(np.sqrt(np.pi * self.bandwidth * scale) * np.exp(self.bandwidth * away**2 / 4))

    def envelope(self, omega: ArrayLike) -> RealArray:
        """Return the time ``s sqrt(N)`` in which the envelope falls by e [s], at angular frequencies [rad/s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Morlet
        >>> wavelet = Morlet(center=6.0, bandwidth=2.0)
        >>> wavelet.envelope([6.0, 12.0]).round(3)
        array([1.414, 0.707])
        """
        return np.asarray(self.center / np.asarray(omega, float) * np.sqrt(self.bandwidth))

    def noise_gain(self) -> float:
        """Return the transform's standard deviation for white noise of unit density: ``(pi N / 2)^(1/4)``.

        Samples of standard deviation sigma at a step h give a row of ``sigma sqrt(h)`` times this.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Morlet
        >>> wavelet = Morlet(center=6.0, bandwidth=2.0)
        >>> round(wavelet.noise_gain() ** 4 / np.pi, 6)
        1.0
        """
        return float((np.pi * self.bandwidth / 2) ** 0.25)
