"""Units of channels, as given, stated in the file, or in the name."""

from __future__ import annotations

import re

from suspid.cleaning import to_si
from suspid.errors import InputError
from suspid.recordings import RawChannel

# How names and files spell units that `to_si` knows.
SPELLED = {
    "kmh": "km/h", "kmph": "km/h", "kph": "km/h", "km/hr": "km/h", "mps": "m/s", "mph": "mph", "mi/h": "mph",
    "kt": "kn", "kts": "kn", "knot": "kn", "knots": "kn",
}  # fmt: skip


def stated_unit(channel: RawChannel, unit: str | None, si: str) -> str | None:
    """Return the unit of a channel, as given, stated, or in its name, if it is one of the quantity; else None."""
    tail = re.split(r"[\s_]", channel.name.strip("[]() "))[-1]
    # Names are written in any case; kN and kn differ in nothing else.
    for candidate in (unit, channel.unit, tail if tail == "kN" else tail.lower()):
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
        hint = "; give it as speed_unit" if si == "m/s" else ""
        raise InputError(f"channel {channel.name!r} has no unit like {si} (it states {channel.unit or 'none'}){hint}")
    return RawChannel(
        name=channel.name, unit=si, timepts=channel.timepts, values=to_si(channel.values, found)[0], rate=channel.rate
    )
