"""Fit the modes to the slopes of log modulus and phase along the ridges: Eq. (21)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model import ModalSet, scaled_shapes
from suspid.units import ComplexArray, RealArray, Second
from suspid.wavelets.ridge import Ridge


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class SkeletonFit:
    """Lines of Eq. (21) through the log modulus and the phase of all channels.

    Parameters
    ----------
    pole : complex
        Slopes [rad/s]: of the log modulus in the real part, of the phase in the imaginary part.
    variance : float
        Variance of each slope [(rad/s)^2]; the two are independent.
    origin : ndarray (channel,)
        Logarithm of the skeleton on the lines, at the onset.
    onset : float
        Time of ``origin`` [s].
    timepts : ndarray (sample,)
        Trusted times [s].
    logarithm : ndarray (channel, sample)
        Log modulus (real) and unwrapped phase (imaginary) of the skeleton there.

    Examples
    --------
    >>> from suspid import as_record, cwt, find_ridges, identify
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
    >>> fit = identify(decay, method="ridge", modes=1).lines[0]
    >>> round(fit.pole.real, 3), round(fit.pole.imag, 2)
    (-1.0, 20.0)
    """

    pole: complex
    variance: float
    origin: ComplexArray
    onset: Second
    timepts: RealArray = field(repr=False)
    logarithm: ComplexArray = field(repr=False)

    @property
    def lines(self) -> ComplexArray:
        """The fitted lines at ``timepts``, (channel, sample).

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t)
        >>> fit = identify(decay, method="ridge", modes=1, bandwidth=8.0).lines[0]
        >>> bool(np.abs(fit.lines - fit.logarithm).max() < 1e-3)
        True
        """
        return np.asarray(self.origin[:, None] + self.pole * (self.timepts - self.onset))


@explained
def fit_ridges(ridges: Sequence[Ridge]) -> ModalSet:
    """Return the modes from the slopes along the ridges, Eq. (21).

    ``wn = sqrt(a_phi^2 + a_A^2)`` and ``zeta = -a_A / wn`` with a_phi the slope of the phase and a_A that of the log
    modulus, by weighted least squares over the trusted window with a slope common to all channels. The weights are the
    squared modulus over the squared noise, the inverse variance of log modulus and phase.

    Parameters
    ----------
    ridges : sequence of Ridge
        As from `find_ridges`.

    Returns
    -------
    ModalSet
        With shapes at the channels and the covariance of the poles: that of the weighted lines to first order, for
        noise with the correlation over time that the wavelet gives it.

    Raises
    ------
    InputError
        If there are no ridges.

    Examples
    --------
    >>> import numpy as np, control
    >>> from suspid import cwt, find_ridges
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = control.TimeResponseData(t, np.exp(-t) * np.cos(40 * t), issiso=True, output_labels=["seat"])
    >>> modes = fit_ridges(find_ridges(cwt(decay, omega=np.geomspace(10, 100, 100), bandwidth=22.0)))
    >>> modes.zeta.round(6)
    array([0.024992])
    """
    if not ridges:
        raise InputError("no ridges to fit; find_ridges raises where there are none")
    fits = [fit_skeleton(ridge) for ridge in ridges]
    covariance = np.diag(np.repeat([fit.variance for fit in fits], 2))
    # The common factor avoids overflow.
    shapes = np.stack([np.exp(fit.origin - np.max(fit.origin.real)) for fit in fits], axis=1)
    return ModalSet(
        poles=np.array([fit.pole for fit in fits]),
        shapes=scaled_shapes(shapes),
        channels=ridges[0].channels,
        covariance=covariance,
    )


def fit_skeleton(ridge: Ridge) -> SkeletonFit:
    """Fit weighted lines through log modulus and phase of one ridge, with slopes common to all channels."""
    keep = ridge.trusted
    time, skeleton = ridge.timepts[keep], ridge.skeleton[:, keep]
    elapsed = time - ridge.onset
    # Without its mean rate omega the phase can be unwrapped without slips.
    turned = skeleton * np.exp(-1j * ridge.omega * elapsed)
    # A channel that is zero has no logarithm: it gets the smallest number and no weight.
    silent = np.finfo(float).tiny
    logarithm = np.log(np.maximum(np.abs(turned), silent)) + 1j * np.unwrap(np.angle(turned), axis=1)
    weights = np.maximum((np.abs(skeleton) / ridge.floor[:, None]) ** 2, silent)
    mean_time = np.sum(weights * elapsed, axis=1, keepdims=True) / np.sum(weights, axis=1, keepdims=True)
    lever = weights * (elapsed - mean_time)
    inertia = float(np.sum(lever * (elapsed - mean_time)))
    slope = complex(np.sum(lever * logarithm) / inertia)
    origin = np.sum(weights * (logarithm - slope * elapsed), axis=1) / np.sum(weights, axis=1)
    model: ComplexArray = np.exp(origin[:, None] + slope * elapsed)
    variance = 0.0
    for channel, floor in enumerate(ridge.floor):
        if not np.any(skeleton[channel]):
            continue
        # A residual above the noise floor widens the interval.
        residual = float(np.mean(np.abs(turned[channel] - model[channel]) ** 2))
        influence = np.asarray(lever[channel] / inertia / model[channel], complex)
        variance += 0.5 * max(floor**2, residual) * _correlated_power(influence, ridge, time)
    return SkeletonFit(
        pole=slope + 1j * ridge.omega,
        variance=variance,
        origin=origin,
        onset=ridge.onset,
        timepts=time,
        logarithm=logarithm + 1j * ridge.omega * elapsed,
    )


def _correlated_power(influence: ComplexArray, ridge: Ridge, time: RealArray) -> float:
    """Return ``g^H R g`` with R the correlation of the noise along the row (a Gaussian of the time lag)."""
    from scipy.fft import fft, next_fast_len

    count = len(time)
    lag = (time - time[0]) / ridge.scale
    length = next_fast_len(2 * count)
    correlation = np.zeros(length)
    correlation[:count] = np.exp(-(lag**2) / (2 * ridge.wavelet.bandwidth))
    correlation[length - count + 1 :] = correlation[1:count][::-1]
    return float(np.sum(np.abs(fft(influence, length)) ** 2 * fft(correlation).real) / length)
