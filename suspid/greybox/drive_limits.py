"""Limits of a usable stretch of a drive."""

from __future__ import annotations

from dataclasses import dataclass

from suspid.errors import InputError
from suspid.units import Hertz, MetrePerSecond, MetrePerSecond2, Second
from suspid.wording import Argument


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveLimits:
    """Limits of a usable stretch of a drive. All are physical quantities; none depends on the record.

    Parameters
    ----------
    least_speed : float
        Speed from which a car counts as moving [m/s]. Below walking pace a car manoeuvres: it is steered, pulls away
        and stops.
    least_vibration : float
        Vibration from which a car counts as moving where its speed is not known [m/s2], see `band_hz`. A very good road
        (class A of ISO 8608) taken at 3 m/s moves the bodies of ordinary cars by 0.1 m/s2, cars at rest by less than
        0.02 m/s2.
    longitudinal, lateral : float
        Largest acceleration [m/s2], mean over a block. With a centre of gravity at a fifth of the wheelbase, 1.5 m/s2
        move 3 % of the weight from one axle to the other; springs and dampers then work away from their usual point,
        and the inertia of the body is a force that no channel shows.
    band_hz : (float, float)
        Frequencies in which the vibration is judged [Hz]: above the pitching of braking, below the second order of
        idling engines. Its level follows from the median of the spectrum in the band, which single lines do not change.
    block : float
        Length of the blocks for each of which it is decided [s]: a period of the body or more, so that braking is not
        hidden by vibration.
    shortest : float
        Least length of a stretch [s]: `estimate` transforms stretches of eight periods of the body.
    recovery : float
        Time after clipping for which a sensor is given to recover [s]: what drove it out of range rings on, and so do
        its filters.
    stuck : float
        How long a channel may stay at exactly one value while the car moves [s]: half a period of the slowest body.

    Examples
    --------
    >>> from suspid import DriveLimits
    >>> limits = DriveLimits(least_speed=8.0, shortest=30.0)
    >>> limits.least_speed, limits.longitudinal
    (8.0, 1.5)
    """

    least_speed: MetrePerSecond = 3.0
    least_vibration: MetrePerSecond2 = 0.05
    longitudinal: MetrePerSecond2 = 1.5
    lateral: MetrePerSecond2 = 1.5
    band_hz: tuple[Hertz, Hertz] = (1.0, 15.0)
    block: Second = 1.0
    shortest: Second = 10.0
    recovery: Second = 0.5
    stuck: Second = 0.5

    def __post_init__(self) -> None:
        for name in (
            "least_speed",
            "least_vibration",
            "longitudinal",
            "lateral",
            "block",
            "shortest",
            "recovery",
            "stuck",
        ):
            if not getattr(self, name) > 0:
                raise InputError(Argument(name, str(getattr(self, name))), " must be positive")
        if not 0 < self.band_hz[0] < self.band_hz[1]:
            raise InputError(Argument("band_hz", f"{self.band_hz}"), " must be a lower and a higher frequency [Hz]")
