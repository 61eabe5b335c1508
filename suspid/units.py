"""Units as types.

A parameter annotated ``stiffness: NewtonPerMetre`` is a plain float in that unit. All values are in SI units; angles
are in radians and damping ratios are ratios, not percent.
"""

import re
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.wording import Argument

Kilogram: TypeAlias = Annotated[float, "kg"]
Metre: TypeAlias = Annotated[float, "m"]
Second: TypeAlias = Annotated[float, "s"]
MetrePerSecond: TypeAlias = Annotated[float, "m/s"]
MetrePerSecond2: TypeAlias = Annotated[float, "m/s2"]
Hertz: TypeAlias = Annotated[float, "Hz"]
Newton: TypeAlias = Annotated[float, "N"]
RadianPerSecond: TypeAlias = Annotated[float, "rad/s"]
Radian: TypeAlias = Annotated[float, "rad"]
NewtonPerMetre: TypeAlias = Annotated[float, "N/m"]
NewtonSecondPerMetre: TypeAlias = Annotated[float, "N s/m"]
Decibel: TypeAlias = Annotated[float, "dB"]
Ratio: TypeAlias = Annotated[float, "1"]

RealArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]
Flags: TypeAlias = NDArray[np.bool_]

STANDARD_GRAVITY = 9.80665  # [m/s2]

# Units in which nothing but the speed of a vehicle is stated.
ROAD_SPEEDS = frozenset({"km/h", "mph", "kn"})

# The unit of a value by the last word of its name.
UNITS = {
    "mass": "kg",
    "inertia": "kg m2",
    "stiffness": "N/m",
    "damping": "N s/m",
    "mount_stiffness": "N/m",
    "friction": "N",
    "force": "N",
    "wn": "rad/s",
    "zeta": "1",
    "gain": "1",
    "delay": "s",
    "relaxation": "s",
}

# Digits and signs of exponents in print.
SUPERSCRIPT = str.maketrans("-0123456789.", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹·")
# Exponents behind the names of units, in text as it is typed.
POWER_OF_UNIT = re.compile(r"(?<=[a-zA-Z]/s)\d(?:\.\d+)?\b|(?<=\d m)\d\b|(?<=\bkg m)2\b")


def in_print(text: str) -> str:
    """Return a unit, or a sentence with units, with exponents as they are printed.

    Examples
    --------
    >>> in_print("m/s2"), in_print("0.61 m/s2, ISO 2631-1"), in_print("m/s1.75"), in_print("256e-6 m3")
    ('m/s²', '0.61 m/s², ISO 2631-1', 'm/s¹·⁷⁵', '256e-6 m³')
    """
    return POWER_OF_UNIT.sub(lambda found: found[0].translate(SUPERSCRIPT), text)


def angular(band_hz: tuple[Hertz, Hertz] | None) -> tuple[RadianPerSecond, RadianPerSecond] | None:
    """Return a band of frequencies as angular frequencies; None stays None.

    Examples
    --------
    >>> angular((1.0, 2.0))
    (6.283185307179586, 12.566370614359172)
    >>> angular((1.0, "2"))
    Traceback (most recent call last):
    suspid.errors.InputError: band_hz=(1.0, '2') must be two frequencies in Hz
    """
    if band_hz is None:
        return None
    known = isinstance(band_hz, tuple | list | np.ndarray) and len(band_hz) == 2
    if not known or not all(
        isinstance(edge, int | float | np.number) and np.isfinite(2 * np.pi * edge) for edge in band_hz
    ):
        raise InputError(Argument("band_hz", f"{band_hz!r:.60}"), " must be two frequencies in Hz")
    return 2 * np.pi * band_hz[0], 2 * np.pi * band_hz[1]
