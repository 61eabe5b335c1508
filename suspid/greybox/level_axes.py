"""Axes of sensors in the body: which is vertical, which are level."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from suspid.cleaning import to_si
from suspid.greybox.channel_words import ELSEWHERE_WORDS, words_of
from suspid.greybox.stated_units import in_si, stated_unit, suffixed
from suspid.recordings import RawChannel
from suspid.units import STANDARD_GRAVITY

AXES = ("x", "y", "z")
GRAVITY_OFF = 0.6  # how far the mean along a vertical axis may be off gravity [m/s2]: a tilt of 20 deg
# Words of a sensor in the body whose axes are those of the car where it names x and y alone (ISO 8855: forward, left).
BODY_WORDS = frozenset({"", "a", "acc", "accel", "acceleration", "imu", "body", "vehicle", "car", "g"})
# Words of a sensor that moves with a wheel, which shakes harder than the car brakes.
WHEEL_WORDS = frozenset({"wheel", "hub", "axle", "upright", "unsprung", "tire", "tyre", "rad", "achse", "knuckle"})


def about_vertical(channels: Sequence[RawChannel]) -> RawChannel | None:
    """Return the rate about the axis whose acceleration shows gravity, of sensors with three axes; None if not sure."""
    rates = {axis: c for c, axis in _with_axis(channels, "rad/s")}
    upright = [axis for c, axis in _with_axis(channels, "m/s2") if shows_gravity(c)]
    if len(upright) != 1 or set(rates) != set(AXES):
        return None
    return in_si(rates[upright[0]], "rad/s", None)


def _with_axis(channels: Sequence[RawChannel], si: str) -> list[tuple[RawChannel, str]]:
    """Return the channels of a quantity whose names end in an axis, with the axis."""
    ends = [(c, stem_of(c.name)[-1:].lower()) for c in channels]
    every = [(c, axis) for c, axis in ends if axis in AXES and not words_of(c.name) & ELSEWHERE_WORDS]
    return [(c, axis) for c, axis in every if stated_unit(c, None, si) is not None]


def stem_of(name: str) -> str:
    """Return a name without the unit in brackets or the suffix of a unit behind it.

    Examples
    --------
    >>> stem_of("Box x [g]"), stem_of("AccelZ_g"), stem_of("x_m")
    ('Box x', 'AccelZ', 'x_m')
    """
    return re.sub(r"[\s_]*[\[(].*", "", suffixed(name)[0])


def shows_gravity(channel: RawChannel) -> bool:
    """Return whether the median of an acceleration is that of gravity, up or down."""
    unit = stated_unit(channel, None, "m/s2")
    values = channel.values[np.isfinite(channel.values)]
    if unit is None or not values.size:
        return False
    return bool(abs(abs(float(to_si(np.median(values), unit)[0])) - STANDARD_GRAVITY) < GRAVITY_OFF)


def horizontal(channels: Sequence[RawChannel], without: Iterable[str]) -> tuple[RawChannel | None, RawChannel | None]:
    """Return the accelerations along and across the car by the axes of a sensor in its body; None where not sure.

    Of three axes gravity shows the vertical one, and the others are level: which of them points forward does not matter
    where both are judged. Axes x and y without a third are those of the car. Channels in ``without`` only help to tell.
    """
    sensors: dict[str, dict[str, RawChannel]] = {}
    for channel, axis in _with_axis(channels, "m/s2"):
        stem = stem_of(channel.name)[:-1].lower().strip(" _-.")
        sensors.setdefault(stem, {})[axis] = channel
    sure: list[dict[str, RawChannel]] = []
    for stem, axes in sensors.items():
        if WHEEL_WORDS & set(re.split(r"[\W\d_]+", stem)):
            continue
        upright = [a for a, c in axes.items() if shows_gravity(c)]
        if len(upright) == 1:
            sure.append({a: c for a, c in axes.items() if a not in upright})
        elif not upright and "z" not in axes and frozenset(re.split(r"[\W\d_]+", stem)) <= BODY_WORDS:
            sure.append(axes)
    others = set(without)
    free = [{a: c for a, c in axes.items() if c.name not in others} for axes in sure]
    sure = [axes for axes in free if axes]
    if len(sure) != 1:
        return None, None
    level = {axis: in_si(channel, "m/s2", None) for axis, channel in sure[0].items()}
    if len(level) == 2:
        first, second = (level[axis] for axis in sorted(level))
        return first, second
    return level.get("x"), level.get("y")
