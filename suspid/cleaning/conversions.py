"""Conversions: units of files to SI, and factors for channels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from suspid.arguments import explained
from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.io import TEMPERATURES, bracketed_unit, unit_in_name
from suspid.records import like
from suspid.signals import as_signal
from suspid.units import STANDARD_GRAVITY, RealArray
from suspid.values import nearest_names

if TYPE_CHECKING:
    import control

# Exact by definition.
INCH = 0.0254
# Factor and SI unit of each unit.
FACTORS: dict[str, tuple[float, str]] = {
    "m": (1.0, "m"), "dm": (0.1, "m"), "cm": (1e-2, "m"), "mm": (1e-3, "m"), "um": (1e-6, "m"), "nm": (1e-9, "m"),
    "in": (INCH, "m"), "inch": (INCH, "m"), "mil": (1e-3 * INCH, "m"), "ft": (12 * INCH, "m"),
    "m/s": (1.0, "m/s"), "cm/s": (1e-2, "m/s"), "mm/s": (1e-3, "m/s"), "in/s": (INCH, "m/s"), "ips": (INCH, "m/s"),
    "ft/s": (12 * INCH, "m/s"), "km/h": (1 / 3.6, "m/s"), "kph": (1 / 3.6, "m/s"), "mph": (0.44704, "m/s"),
    "kn": (1852 / 3600, "m/s"),
    "m/s2": (1.0, "m/s2"), "cm/s2": (1e-2, "m/s2"), "gal": (1e-2, "m/s2"), "mgal": (1e-5, "m/s2"),
    "mm/s2": (1e-3, "m/s2"),
    "in/s2": (INCH, "m/s2"), "ft/s2": (12 * INCH, "m/s2"),
    "g": (STANDARD_GRAVITY, "m/s2"), "gn": (STANDARD_GRAVITY, "m/s2"), "g0": (STANDARD_GRAVITY, "m/s2"),
    "mg": (1e-3 * STANDARD_GRAVITY, "m/s2"), "ug": (1e-6 * STANDARD_GRAVITY, "m/s2"),
    "n": (1.0, "N"), "kn_force": (1e3, "N"), "lbf": (4.4482216152605, "N"), "kgf": (STANDARD_GRAVITY, "N"),
    "rad": (1.0, "rad"), "mrad": (1e-3, "rad"), "deg": (np.pi / 180, "rad"), "°": (np.pi / 180, "rad"),
    "rad/s": (1.0, "rad/s"), "deg/s": (np.pi / 180, "rad/s"), "°/s": (np.pi / 180, "rad/s"),
    "dps": (np.pi / 180, "rad/s"), "rpm": (np.pi / 30, "rad/s"),
    "rad/s2": (1.0, "rad/s2"), "deg/s2": (np.pi / 180, "rad/s2"), "°/s2": (np.pi / 180, "rad/s2"),
    "strain": (1.0, "strain"), "ε": (1.0, "strain"), "m/m": (1.0, "strain"), "mm/m": (1e-3, "strain"),
    "uε": (1e-6, "strain"), "ue": (1e-6, "strain"), "ustrain": (1e-6, "strain"), "microstrain": (1e-6, "strain"),
    "um/m": (1e-6, "strain"),
    "pa": (1.0, "Pa"), "kpa": (1e3, "Pa"), "mpa": (1e6, "Pa"), "bar": (1e5, "Pa"), "psi": (6894.757293168, "Pa"),
    "v": (1.0, "V"), "mv": (1e-3, "V"),
}  # fmt: skip

# Units in words, as files spell them besides.
IN_WORDS = {
    "milli-g": "mg", "millig": "mg", "milligee": "mg", "micro-g": "ug", "microg": "ug", "gee": "g", "g-force": "g",
    "gforce": "g", "milligal": "mgal", "metre": "m", "metres": "m", "meter": "m", "meters": "m", "millimetre": "mm",
    "millimetres": "mm", "millimeter": "mm", "millimeters": "mm", "centimetre": "cm", "centimetres": "cm",
    "centimeter": "cm", "centimeters": "cm", "inches": "inch", "mils": "mil", "feet": "ft", "volt": "v", "volts": "v",
    "degree": "deg", "ms2": "m/s2", "mps2": "m/s2", "mps": "m/s", "degrees": "deg", "radian": "rad", "radians": "rad",
}  # fmt: skip

# Units of temperature, which nothing here needs.
OF_TEMPERATURE = TEMPERATURES | {"k", "kelvin"}
# Newton metres, which differ from nanometres in case alone.
TORQUES = {"Nm", "kNm", "NM"}
# Other spellings and what replaces them, in this order.
SPELLINGS = (
    ("²", "2"), ("⁻", "-"), ("^", ""), ("**", ""), ("µ", "u"), ("μ", "u"), ("·", ""), ("*", ""), (" ", ""),
    ("/sec", "/s"), ("/s/s", "/s2"), ("s-2", "/s2"), ("s-1", "/s"), ("//", "/"),
)  # fmt: skip


@explained
def to_si(values: ArrayLike, unit: str) -> tuple[RealArray, str]:
    """Return values in SI units, and that unit.

    Parameters
    ----------
    values : array_like
        In the unit given.
    unit : str
        Such as "mm", "in", "g" (of gravity), "m/s^2", "deg/s", "km/h", "µε" (strain stays strain, a ratio).

    Raises
    ------
    InputError
        If the unit is not known.

    Examples
    --------
    >>> to_si([1.0, -2.0], "mm")
    (array([ 0.001, -0.002]), 'm')
    >>> to_si(1.0, "g"), to_si(250.0, "µε")
    ((array(9.80665), 'm/s2'), (array(0.00025), 'strain'))
    """
    key = _key(unit)
    if key in TORQUES:
        raise InputError(f"the unit {printable(unit)!r} is one of torque, which is not converted")
    if key in OF_TEMPERATURE:
        raise InputError(f"the unit {printable(unit)!r} is one of temperature, which is not converted")
    if key not in FACTORS:
        known = ["kN" if name == "kn_force" else name for name in FACTORS]
        raise InputError(f"the unit {printable(unit)!r} is not known.{nearest_names(_spelled(unit), known)}")
    factor, si = FACTORS[key]
    return np.array(np.asarray(values, float) * factor), si


def si_unit(unit: str) -> str:
    """Return the SI unit of a unit; empty if it is not known."""
    return FACTORS.get(_key(unit), (1.0, ""))[1]


def _key(unit: str) -> str:
    """Return a unit as it stands in `FACTORS`, `OF_TEMPERATURE` or `TORQUES`, if it is known."""
    plain = _spelled(unit)
    if plain in FACTORS or plain in TORQUES:
        return plain
    # kN and kn (knot), N and n: the only units that differ in case alone.
    return "kn_force" if plain == "kN" else IN_WORDS.get(plain.lower(), plain.lower())


def _spelled(unit: str) -> str:
    plain = unit.strip().strip("[]()").strip()
    for old, new in SPELLINGS:
        plain = plain.replace(old, new)
    return plain


def name_in_si(name: str, unit: str) -> str:
    """Return the name of a channel that was converted to a unit: one that states the unit before states this one.

    Examples
    --------
    >>> name_in_si("seat [mm]", "m"), name_in_si("body (g)", "m/s2"), name_in_si("seat", "m"), name_in_si("a [g]", "m")
    ('seat [m]', 'body (m/s2)', 'seat', 'a [g]')
    >>> name_in_si("seat_mm", "m"), name_in_si("acc_ms2", "m/s2")
    ('seat_m', 'acc_ms2')
    """
    before = unit_in_name(name)
    if not before or before == unit or si_unit(before) != unit:
        return name
    if not bracketed_unit(name) and to_si(1.0, before)[0] == 1.0:
        return name
    at = name.rindex(before)
    return f"{name[:at]}{unit}{name[at + len(before) :]}"


def converted(values: RealArray, name: str, unit: str) -> tuple[RealArray, str]:
    """Return samples of a channel in SI units, and its name.

    Raises
    ------
    InputError
        If the unit is not known.
    RecordError
        If the name states a unit of another quantity.

    Examples
    --------
    >>> converted(np.array([1.0, -2.0]), "seat [mm]", "mm")
    (array([ 0.001, -0.002]), 'seat [m]')
    """
    samples, si = to_si(values, unit)
    called = name_in_si(name, si)
    if (own := si_unit(bracketed_unit(called))) not in ("", si):
        raise RecordError(f"channel {name!r} has the unit {unit!r} by units, and one of {own} by its name")
    return samples, called


@explained
def scaled(response: control.TimeResponseData, factors: Mapping[str, float]) -> control.TimeResponseData:
    """Return a record with some channels multiplied: a sign, a sensitivity, a unit.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    factors : mapping of str to float
        Factor by channel; the other channels stay as they are.

    Raises
    ------
    InputError
        If a channel is not there, or a factor is zero or not finite.

    Examples
    --------
    >>> from suspid.records import as_response
    >>> record = as_response(np.arange(3) / 10, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), ["seat", "tire"])
    >>> scaled(record, {"tire": -0.5}).y
    array([[ 1. ,  2. ,  3. ],
           [-2. , -2.5, -3. ]])
    """
    signal = as_signal(response)
    for name, factor in factors.items():
        if name not in signal.channels:
            raise InputError(f"there is no channel {name!r}.{nearest_names(name, signal.channels)}")
        if not np.isfinite(factor) or factor == 0:
            raise InputError(f"the factor of channel {name!r}, {factor}, must be finite and not zero")
    by = np.array([factors.get(name, 1.0) for name in signal.channels])
    title = getattr(response, "title", None) or ""
    return like(response, np.asarray(response.time), signal.values * by[:, None], signal.channels, title=title)
