"""Figures of a ride from the moments of one signal, with exact derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.model import positive_number
from suspid.performance.road_response import Moments
from suspid.units import Metre, RealArray, Second
from suspid.values import SMALLEST_SIZE
from suspid.wording import Argument

# Times of doses and peaks [s]: in less than a second a body on springs does not swing once, and no vehicle is driven
# for longer than 30 years.
LEAST_EXPOSURE, MOST_EXPOSURE = 1.0, 1e9


def check_exposure(duration: object) -> None:
    """Refuse a time of doses and peaks that is no number of seconds on a road.

    Examples
    --------
    >>> check_exposure(1e20)
    Traceback (most recent call last):
    suspid.errors.InputError: duration=1e+20 s is outside of 1 to 1e+09 s; an hour is 3600
    """
    seconds = positive_number("duration", duration, "s")
    if not LEAST_EXPOSURE <= seconds <= MOST_EXPOSURE:
        raise InputError(
            Argument("duration", f"{seconds:g}"),
            f" s is outside of {LEAST_EXPOSURE:g} to {MOST_EXPOSURE:g} s; an hour is 3600",
        )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Moment:
    """Standard deviation of one signal and how often a second it rises through zero, with derivatives."""

    rms: float
    rms_slopes: RealArray
    rises: float  # [1/s]
    rises_slopes: RealArray  # of its logarithm

    @classmethod
    def of(cls, found: Moments, at: int) -> Moment:
        """Return that of the signal at a place."""
        variance, rate = float(found.variance[at]), float(found.rate[at])
        tiny = np.finfo(float).tiny
        by_variance, by_rate = found.variance_slopes[at], found.rate_slopes[at]
        rms = float(np.sqrt(variance))
        return cls(
            rms=rms,
            rms_slopes=by_variance / max(2 * rms, tiny),
            rises=float(np.sqrt(rate / max(variance, tiny))) / (2 * np.pi),
            rises_slopes=(by_rate / max(rate, tiny) - by_variance / max(variance, tiny)) / 2,
        )


Static = tuple[float, RealArray] | None
Formula = Callable[[Moment, Second, Static], tuple[float, RealArray]]


def rms(m: Moment, _: Second, __: Static) -> tuple[float, RealArray]:
    """Return the root mean square."""
    return m.rms, m.rms_slopes


def dose(m: Moment, seconds: Second, _: Static) -> tuple[float, RealArray]:
    """Return VDV of a Gaussian vibration, ``(3 T)^(1/4) rms``: its fourth power has the mean 3 rms^4."""
    factor = (3 * seconds) ** 0.25
    return factor * m.rms, factor * m.rms_slopes


def sickness(m: Moment, seconds: Second, _: Static) -> tuple[float, RealArray]:
    """Return MSDV, ``T^(1/2) rms``."""
    return seconds**0.5 * m.rms, seconds**0.5 * m.rms_slopes


def crest(m: Moment, seconds: Second, _: Static) -> tuple[float, RealArray]:
    """Return the expected largest peak over rms, ``u + 0.5772 / u`` with ``u = (2 ln 2 nu T)^(1/2)``, Davenport."""
    count = 2 * m.rises * seconds
    u = float(np.sqrt(2 * np.log(max(count, math.e))))
    # Of the expected largest of many peaks: Davenport, Proc. ICE 28 (1964) 187-196.
    return u + np.euler_gamma / u, (1 / u - np.euler_gamma / u**3) * (count > math.e) * m.rises_slopes


def peak(m: Moment, seconds: Second, _: Static) -> tuple[float, RealArray]:
    """Return the expected largest value of either sign."""
    ratio, slopes = crest(m, seconds, None)
    return ratio * m.rms, ratio * m.rms_slopes + slopes * m.rms


def share(m: Moment, _: Second, static: Static) -> tuple[float, RealArray]:
    """Return rms over the static load."""
    load, slopes = _known(static)
    return m.rms / load, m.rms_slopes / load - m.rms / load**2 * slopes


def lifts(m: Moment, _: Second, static: Static) -> tuple[float, RealArray]:
    """Return the share of time in which a Gaussian dynamic load is beyond the static one."""
    from scipy.special import ndtr

    load, slopes = _known(static)
    z = load / m.rms
    density = float(np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi))
    return float(ndtr(-z)), -density * (slopes / m.rms - z / m.rms * m.rms_slopes)


def exceedances(rises: float, ratio: float) -> float:
    """Return how often a second a Gaussian signal exceeds ``ratio`` times its rms, ``nu exp(-ratio^2 / 2)`` (Rice).

    ``rises`` is how often it rises through zero, nu [1/s].

    Examples
    --------
    >>> exceedances(1.5, 0.0), round(exceedances(1.5, 2.0), 3)
    (1.5, 0.203)
    """
    return rises * float(np.exp(-(ratio**2) / 2))


def lift_rate(m: Moment, _: Second, static: Static) -> tuple[float, RealArray]:
    """Return how often a second the wheel leaves the road, of a Gaussian load."""
    load, slopes = _known(static)
    z = load / m.rms
    value = exceedances(m.rises, z)
    return value, value * (m.rises_slopes - z * (slopes / m.rms - z / m.rms * m.rms_slopes))


def crossings(limits: tuple[Metre, Metre]) -> Formula:
    """Return the formula of the rate at which a Gaussian travel exceeds either of two limits [1/s]."""

    def rate(m: Moment, _: Second, __: Static) -> tuple[float, RealArray]:
        parts = [exceedances(m.rises, limit / m.rms) for limit in limits]
        by_rms = sum(part * limit**2 / m.rms**3 for part, limit in zip(parts, limits, strict=True))
        return sum(parts), sum(parts) * m.rises_slopes + by_rms * m.rms_slopes

    return rate


def _known(static: Static) -> tuple[float, RealArray]:
    if static is None:
        raise InputError("a ratio to the static load needs that load")
    if abs(static[0]) < SMALLEST_SIZE:
        raise InputError(f"a wheel carries {static[0]:g} N at rest, which allows no ratio; check masses and arms")
    return static
