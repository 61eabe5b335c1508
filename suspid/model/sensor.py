"""One sensor: the motion that a channel of a record measures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from suspid.errors import InputError
from suspid.model.checks import check_name, finite_number
from suspid.values import FrozenMapping

Motion: TypeAlias = Literal["displacement", "velocity", "acceleration", "travel"]
MOTIONS: tuple[Motion, ...] = get_args(Motion)
# Suffixes of outputs that are time derivatives of a coordinate, with the order of the derivative.
DERIVATIVES = {"velocity": 1, "acceleration": 2}
# The same of a road, whose first derivative is an input named so.
ROAD_DERIVATIVES = {"rate": 1, "acceleration": 2}


@dataclass(frozen=True, kw_only=True, slots=True)
class Sensor:
    """A sensor by the name of its channel.

    Parameters
    ----------
    name : str
        Name of the channel.
    motion : {"displacement", "velocity", "acceleration", "travel"}
        What it measures [m, m/s, m/s2 or m; rad for an angle]. Travel is a strut's elongation.
    of : str or mapping of str to float
        A coordinate, or the strut of a travel. A point of a rigid body is a sum over coordinates: the body at 1.2 m
        ahead and 0.75 m left of its centre of gravity is ``{"heave": 1, "pitch": -1.2, "roll": 0.75}``.

    Raises
    ------
    InputError
        If the motion is unknown, an arm is not finite, or all arms are zero.

    Examples
    --------
    >>> Sensor(name="az_front", motion="acceleration", of={"heave": 1, "pitch": -1.2}).of
    {'heave': 1.0, 'pitch': -1.2}
    >>> Sensor(name="pitch_rate", motion="velocity", of="pitch").of
    {'pitch': 1.0}
    >>> Sensor(name="damper_pot", motion="travel", of="front").of
    'front'
    """

    name: str
    motion: Motion
    of: str | Mapping[str, float]

    def __post_init__(self) -> None:
        check_name("a sensor", self.name)
        if self.motion not in MOTIONS:
            raise InputError(f"sensor {self.name!r}: motion = {self.motion!r} is not one of {', '.join(MOTIONS)}")
        if self.motion == "travel":
            if not isinstance(self.of, str):
                raise InputError(f"sensor {self.name!r}: a travel is of one strut; of = {self.of!r} is not a name")
            return
        arms = {self.of: 1.0} if isinstance(self.of, str) else self.of
        if not isinstance(arms, Mapping):
            raise InputError(f"sensor {self.name!r}: of = {self.of!r} must be a coordinate, or map coordinates to arms")
        for coordinate, arm in arms.items():
            check_name(f"sensor {self.name!r}: a coordinate", coordinate)
            finite_number(f"sensor {self.name!r}: arm {coordinate!r}", arm, "1 or m")
        if not any(arms.values()):
            raise InputError(f"sensor {self.name!r} has no nonzero arm; it measures nothing")
        object.__setattr__(self, "of", FrozenMapping(arms))
