"""Ridges of the scalogram and the skeletons along them: Eq. (18)-(20)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from suspid.results import Result
from suspid.units import ComplexArray, RadianPerSecond, RealArray, Second
from suspid.wavelets.morlet import Morlet


@dataclass(frozen=True, kw_only=True, slots=True)
class Window:
    """Trusted part of a skeleton, and its bounds.

    Parameters
    ----------
    onset_edge : float
        The onset of the decay disturbs the skeleton before this time [s].
    record_end : float
        The end of the record disturbs it after this time [s].
    noise_floor : float
        The skeleton meets the noise at this time [s]; infinite if it does not.

    Examples
    --------
    >>> window = Window(onset_edge=0.5, record_end=9.5, noise_floor=4.0)
    >>> window.start, window.stop, window.reason
    (0.5, 4.0, 'noise floor')
    """

    onset_edge: Second
    record_end: Second
    noise_floor: Second

    @property
    def start(self) -> Second:
        """First trusted time [s].

        Examples
        --------
        >>> from suspid import Window
        >>> window = Window(onset_edge=0.5, record_end=9.5, noise_floor=4.0)
        >>> window.start
        0.5
        """
        return self.onset_edge

    @property
    def stop(self) -> Second:
        """Last trusted time [s].

        Examples
        --------
        >>> from suspid import Window
        >>> window = Window(onset_edge=0.5, record_end=9.5, noise_floor=4.0)
        >>> window.stop
        4.0
        """
        return min(self.record_end, self.noise_floor)

    @property
    def reason(self) -> str:
        """Reason for the end of the window: ``"record end"`` or ``"noise floor"``.

        Examples
        --------
        >>> from suspid import Window
        >>> window = Window(onset_edge=0.5, record_end=9.5, noise_floor=4.0)
        >>> window.reason
        'noise floor'
        """
        return "noise floor" if self.noise_floor < self.record_end else "record end"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Ridge(Result):
    """Ridge of a scalogram: a scale of most energy, the skeleton along it and its trusted window.

    Parameters
    ----------
    omega : float
        Angular frequency of the ridge [rad/s], refined between the rows of the scalogram.
    wavelet : Morlet
        The wavelet.
    timepts : ndarray (sample,)
        Times of the skeleton [s].
    skeleton : ndarray (channel, sample)
        Coefficients along the ridge (normalised as in the paper).
    trace : ndarray (sample,)
        Frequency of the largest coefficient near this ridge, at each time [rad/s].
    floor : ndarray (channel,)
        Standard deviation of the noise in the skeleton.
    window : Window
        Trusted part of the skeleton.
    onset : float
        Time at which the free decay begins [s].
    channels : tuple of str
        Names of the channels.

    Examples
    --------
    >>> from suspid import as_record, cwt, find_ridges
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
    >>> ridge = find_ridges(cwt(decay, omega=np.geomspace(10, 40, 60), bandwidth=22.0))[0]
    >>> round(ridge.omega, 1), ridge.channels, ridge.skeleton.shape == (1, ridge.timepts.size)
    (20.0, ('seat',), True)
    """

    omega: RadianPerSecond
    wavelet: Morlet
    timepts: RealArray = field(repr=False)
    skeleton: ComplexArray = field(repr=False)
    trace: RealArray = field(repr=False)
    floor: RealArray = field(repr=False)
    window: Window
    onset: Second
    channels: tuple[str, ...]

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Samples in the window, (sample,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt, find_ridges
        >>> t = np.arange(0, 10, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
        >>> ridge = find_ridges(cwt(decay, omega=np.geomspace(10, 40, 60), bandwidth=22.0))[0]
        >>> inside = ridge.timepts[ridge.trusted]
        >>> bool(inside[0] >= ridge.window.start), bool(inside[-1] <= ridge.window.stop)
        (True, True)
        """
        return np.asarray((self.timepts >= self.window.start) & (self.timepts <= self.window.stop))

    @property
    def strength(self) -> RealArray:
        """Modulus of the skeleton over its noise, root mean square over the channels [1], (sample,).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt, find_ridges
        >>> t = np.arange(0, 10, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
        >>> ridge = find_ridges(cwt(decay, omega=np.geomspace(10, 40, 60), bandwidth=22.0))[0]
        >>> bool(ridge.strength[ridge.trusted].min() > 1)
        True
        """
        return np.asarray(np.sqrt(np.mean((np.abs(self.skeleton) / self.floor[:, None]) ** 2, axis=0)))

    @property
    def scale(self) -> Second:
        """Scale of the ridge [s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, cwt, find_ridges
        >>> t = np.arange(0, 10, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
        >>> ridge = find_ridges(cwt(decay, omega=np.geomspace(10, 40, 60), bandwidth=22.0))[0]
        >>> round(ridge.scale * ridge.omega, 6)
        6.283185
        """
        return self.wavelet.center / self.omega

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "time_s": self.timepts.tolist(),
            "f_hz": (self.trace / (2 * np.pi)).tolist(),
            "trusted": self.trusted.tolist(),
            **{f"{name} modulus": row.tolist() for name, row in zip(self.channels, np.abs(self.skeleton), strict=True)},
        }

    def _brief(self) -> str:
        return str(self).removeprefix("ridge ")

    def __str__(self) -> str:
        return (
            f"ridge at {self.omega:.6g} rad/s ({self.omega / (2 * np.pi):.5g} Hz), from {self.window.start:.4g} to "
            f"{self.window.stop:.4g} s ({self.window.reason})"
        )
