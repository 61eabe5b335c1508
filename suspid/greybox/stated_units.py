"""Units of channels, as given, stated in the file, or in the name."""

from __future__ import annotations

import re

import numpy as np

from suspid.cleaning import named_quantity, si_unit, to_si
from suspid.errors import InputError
from suspid.greybox.channel_words import ACCELERATION_WORDS, ROTATION_WORDS, words_of
from suspid.io import bare_name, bracketed_unit
from suspid.recordings import RawChannel
from suspid.units import RealArray
from suspid.wording import Argument

# How names and files spell units that `to_si` knows.
SPELLED = {
    "kmh": "km/h", "kmph": "km/h", "kph": "km/h", "km/hr": "km/h", "mps": "m/s", "mph": "mph", "mi/h": "mph",
    "kt": "kn", "kts": "kn", "knot": "kn", "knots": "kn", "g's": "g", "ms2": "m/s2", "mps2": "m/s2",
    "m_s2": "m/s2", "degps": "deg/s", "deg_s": "deg/s", "radps": "rad/s", "rad_s": "rad/s",
}  # fmt: skip
# Suffixes that are units of accelerations, and of rotation rates, if the name says that it is one.
OF_ACCELERATIONS = re.compile(
    r"(.*?)[\s_](g|gs|g's|mg|milli[\s_-]?g|gal|m/s2|m/s\^2|ms2|mps2|m_s2|(?:cm|mm|ft|in)[/_]s\^?2)", re.IGNORECASE
)
OF_ROTATIONS = re.compile(r"(.*?)[\s_](dps|deg/s|degps|deg_s|rad/s|radps|rad_s)", re.IGNORECASE)
# Largest usual values in SI units: 20 g and 2000 deg/s. Larger ones are in another unit than the name says.
MOST_USUAL = {"m/s2": 200.0, "rad/s": 35.0}


def suffixed(name: str) -> tuple[str, str]:
    """Return a name and the unit of acceleration or of rotation rate that it ends with; empty if not sure.

    Examples
    --------
    >>> suffixed("AccelZ_g"), suffixed("GyroX_degps"), suffixed("Lateral Gs"), suffixed("acc_m_s2")
    (('AccelZ', 'g'), ('GyroX', 'deg/s'), ('Lateral', 'g'), ('acc', 'm/s2'))
    >>> suffixed("AccZ_mg"), suffixed("Acc Z milli g"), suffixed("acc_z_cm_s2"), suffixed("acc_ft/s^2")
    (('AccZ', 'mg'), ('Acc Z', 'mg'), ('acc_z', 'cm/s2'), ('acc', 'ft/s^2'))
    >>> suffixed("x_m"), suffixed("load_g"), suffixed("MagX_Gs"), suffixed("MagX_uT")
    (('x_m', ''), ('load_g', ''), ('MagX_Gs', ''), ('MagX_uT', ''))
    """
    for pattern, words in ((OF_ACCELERATIONS, ACCELERATION_WORDS), (OF_ROTATIONS, ROTATION_WORDS)):
        found = pattern.fullmatch(name.strip())
        if found is None:
            continue
        called = words_of(found[1])
        moves = named_quantity(found[1]) == "acceleration" if pattern is OF_ACCELERATIONS else False
        if moves or called & words:
            unit = found[2].lower()
            unit = "g" if unit == "gs" else re.sub(r"milli[\s_]g", "mg", unit).replace("_s", "/s")
            return found[1], SPELLED.get(found[2].lower(), unit)
    return name, ""


def own_unit(channel: RawChannel) -> str:
    """Return the unit that a channel states, or its name in brackets or as a suffix; empty if none is sure.

    A suffix counts if usual values are possible in it.

    Examples
    --------
    >>> t = np.arange(3) / 10
    >>> [own_unit(RawChannel(name="AccZ_g", unit="", timepts=t, values=by * t, rate=None)) for by in (5.0, 5000.0)]
    ['g', '']
    """
    stated = channel.unit or bracketed_unit(channel.name)
    if stated.strip().lower() == "gs":  # gauss elsewhere
        return suffixed(f"{bare_name(channel.name)} Gs")[1] or stated
    if stated:
        return SPELLED.get(stated.strip().lower(), stated)
    unit = suffixed(channel.name)[1]
    return unit if unit and _possible(channel.values, unit) else ""


def _possible(values: RealArray, unit: str) -> bool:
    """Return whether the usual size of values is one that sensors on cars show."""
    sizes = np.abs(values[np.isfinite(values)])
    return not sizes.size or float(to_si(np.median(sizes), unit)[0]) <= MOST_USUAL[si_unit(unit)]


def stated_unit(channel: RawChannel, unit: str | None, si: str) -> str | None:
    """Return the unit of a channel, as given, stated, or in its name, if it is one of the quantity; else None."""
    tail = re.split(r"[\s_]", channel.name.strip("[]() "))[-1]
    # Names are written in any case; kN and kn differ in nothing else.
    for candidate in (unit, channel.unit, own_unit(channel), tail if tail == "kN" else tail.lower()):
        known = spelled(candidate, si) if candidate else None
        if known is not None:
            return known
    return None


def spelled(unit: str, si: str) -> str | None:
    """Return a unit as `to_si` knows it, if it is one of the quantity; else None."""
    known = unit if unit.strip() == "kN" else SPELLED.get(unit.strip().lower(), unit)
    try:
        return known if known and to_si(0.0, known)[1] == si else None
    except InputError:
        return None


def in_si(channel: RawChannel, si: str, unit: str | None) -> RawChannel:
    """Return a channel in the unit of SI of its quantity."""
    found = stated_unit(channel, unit, si)
    if found is None:
        hint = ("; give it as ", Argument("speed_unit")) if si == "m/s" else ()
        raise InputError(f"channel {channel.name!r} has no unit like {si} (it states {channel.unit or 'none'})", *hint)
    return RawChannel(
        name=channel.name, unit=si, timepts=channel.timepts, values=to_si(channel.values, found)[0], rate=channel.rate
    )
