"""Order of derivative of a channel, from its unit and its name."""

from __future__ import annotations

import re

from suspid.cleaning.conversions import si_unit
from suspid.io import bare_name, bracketed_unit

# How often a displacement, and an angle, is differentiated, by the SI unit of the result.
MOTION_OF_UNIT = {"m": ("m", 0), "m/s": ("m", 1), "m/s2": ("m", 2), "rad": ("rad", 0), "rad/s": ("rad", 1)}
# Words in names without a unit that say it. A speed is that of the vehicle.
WORDS = (
    (re.compile(r"disp|displ|displacement|travel|deflection|weg"), "displacement"),
    (re.compile(r"vel|velo|velocity|geschwindigkeit"), "velocity"),
    (re.compile(r"acc|accel|acceleration|accelerometer|beschleunigung"), "acceleration"),
)
# Beside an acceleration, words of the pedal of that name.
PEDAL_WORDS = {"position", "pos", "pedal", "ped"}
ORDER_OF_QUANTITY = {"displacement": 0, "velocity": 1, "acceleration": 2}


def named_quantity(name: str) -> str:
    """Return displacement, velocity or acceleration where a name says so; empty if it does not.

    Examples
    --------
    >>> [named_quantity(name) for name in ("acc_body", "Disp1", "chassisVelocity", "seat", "account")]
    ['acceleration', 'displacement', 'velocity', '', '']
    >>> named_quantity("Accel Position")
    ''
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", bare_name(name)).lower()
    called = re.split(r"[\W\d_]+", apart)
    for word in called:
        for words, quantity in WORDS:
            if words.fullmatch(word):
                return "" if quantity == "acceleration" and PEDAL_WORDS & set(called) else quantity
    return ""


def derivative_order(name: str, unit: str = "") -> int | None:
    """Return how often the displacement or angle is differentiated in a channel; None where nothing says it.

    Examples
    --------
    >>> derivative_order("seat", "g"), derivative_order("vel [mm/s]"), derivative_order("disp"), derivative_order("a")
    (2, 1, 0, None)
    """
    known = MOTION_OF_UNIT.get(si_unit(unit or bracketed_unit(name)))
    return known[1] if known else ORDER_OF_QUANTITY.get(named_quantity(name))
