"""Order of derivative of a channel, from its unit and its name."""

from __future__ import annotations

import re
from collections.abc import Sequence

from suspid.cleaning.conversions import si_unit
from suspid.io import bare_name, unit_in_name

# How often a displacement, and an angle, is differentiated, by the SI unit of the result.
MOTION_OF_UNIT = {
    "m": ("m", 0), "m/s": ("m", 1), "m/s2": ("m", 2), "rad": ("rad", 0), "rad/s": ("rad", 1), "rad/s2": ("rad", 2),
}  # fmt: skip
# Words in names without a unit that say it. A speed is that of the vehicle.
WORDS = (
    (re.compile(r"disp|displ|displacement|travel|deflection|weg"), "displacement"),
    (re.compile(r"vel|velo|velocity|geschwindigkeit"), "velocity"),
    (re.compile(r"acc|accel|acceleration|accelerometer|beschleunigung"), "acceleration"),
)
# Beside an acceleration, words of the pedal of that name.
PEDAL_WORDS = {"position", "pos", "pedal", "ped"}
# Letters before a name that stand for a quantity, where two of them stand before one name: z_seat beside a_seat.
LETTER_OF = {**dict.fromkeys("dsuxz", "displacement"), "v": "velocity", "a": "acceleration"}
LETTERED = re.compile(r"([dsuvxza])_([^\W_]+)(?:_[^\W_]+(?:/s2?)?)?", re.IGNORECASE)
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


def named_quantities(names: Sequence[str]) -> list[str]:
    """Return the quantity that each name says, by a word or by its letter before a name that another has as well.

    Examples
    --------
    >>> named_quantities(["z_seat_m", "a_seat", "z_wheel_m", "tire"])
    ['displacement', 'acceleration', 'displacement', '']
    >>> named_quantities(["a_left", "a_right"]), named_quantities(["acc_body", "a_seat"])
    (['', ''], ['acceleration', ''])
    """
    lettered = [LETTERED.fullmatch(bare_name(name)) for name in names]
    pairs = {(LETTER_OF[found[1].lower()], found[2].lower()) for found in lettered if found}
    several = len({of for _, of in pairs}) < len(pairs)
    quantities = [LETTER_OF[found[1].lower()] if found and several else "" for found in lettered]
    return [named_quantity(name) or letter for name, letter in zip(names, quantities, strict=True)]


def derivative_order(name: str, unit: str = "") -> int | None:
    """Return how often the displacement or angle is differentiated in a channel; None where nothing says it.

    Examples
    --------
    >>> derivative_order("seat", "g"), derivative_order("vel [mm/s]"), derivative_order("disp"), derivative_order("a")
    (2, 1, 0, None)
    """
    known = MOTION_OF_UNIT.get(si_unit(unit or unit_in_name(name)))
    return known[1] if known else ORDER_OF_QUANTITY.get(named_quantity(name))


def derivative_orders(names: Sequence[str]) -> list[int | None]:
    """Return how often the displacement or angle is differentiated in each channel, as the names say together.

    Examples
    --------
    >>> derivative_orders(["z_seat_m", "a_seat", "seat [m/s]", "tire"])
    [0, 2, 1, None]
    """
    quantities = named_quantities(names)
    by_unit = [derivative_order(name) for name in names]
    return [
        ORDER_OF_QUANTITY.get(quantity) if order is None else order
        for order, quantity in zip(by_unit, quantities, strict=True)
    ]
