"""Parts of the quarter, half and full car: struts, seat, wheels, and the axes of the body.

Vertical motion about static equilibrium, for small angles, in the axes of ISO 8855: x forward, y to the left, z up,
with the origin at the body's centre of gravity. So heave is positive upward, pitch positive nose down, roll positive
left side up, and the body at (x, y) rises by ``heave - x pitch + y roll``. Wheels, seat and roads are positive upward.
Struts are vertical; their rates are those at the wheel. A strut's travel is positive in extension.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.model.checks import finite_number
from suspid.model.strut import Strut
from suspid.model.suspension import Suspension
from suspid.units import Metre

KilogramSquareMetre: TypeAlias = Annotated[float, "kg m2"]
PerSide: TypeAlias = float | Sequence[float]  # one value for both sides, or (left, right)


def body_arms(ahead: Metre, left: Metre | None = None) -> dict[str, float]:
    """Return the rise of the body at a point per unit of heave, pitch and, if ``left`` is given, roll."""
    pitch = {"heave": 1.0, "pitch": 0.0 - ahead}
    return pitch if left is None else {**pitch, "roll": left}


def between(
    name: str, stiffness: float, damping: float, upper: Mapping[str, float], lower: Mapping[str, float]
) -> Strut:
    """Return the strut whose elongation is the rise of its upper end minus that of its lower end."""
    arms = {**upper, **{coordinate: 0.0 - arm for coordinate, arm in lower.items()}}
    return Strut(name=name, stiffness=stiffness, damping=damping, arms=arms)


def seat_arguments(given: Mapping[str, float | None]) -> dict[str, float]:
    """Return the arguments of the seat: all of them or none; refuse a part of them."""
    missing = [name for name, value in given.items() if value is None]
    if missing and len(missing) < len(given):
        raise InputError(
            f"a car with a seat also needs {', '.join(missing)}; give all of {', '.join(given)}, or none of them"
        )
    units = {"seat_ahead": "m", "seat_left": "m"}
    return {
        name: finite_number(name, value, units[name]) if name in units else value
        for name, value in given.items()
        if value is not None
    }


def seated(
    masses: Mapping[str, float], struts: Sequence[Strut], seat: Mapping[str, float], under: Mapping[str, float]
) -> Suspension:
    """Return the car with its seat, if there is one, mounted where the body rises by the arms ``under``."""
    if not seat:
        return Suspension(masses=masses, struts=struts)
    strut = between("seat", seat["seat_stiffness"], seat["seat_damping"], {"seat": 1.0}, under)
    return Suspension(masses={"seat": seat["seat_mass"], **masses}, struts=[strut, *struts])


def by_wheel(what: str, front: PerSide, rear: PerSide, unit: str) -> dict[str, float]:
    """Return the value of each of the four wheels, given one value or (left, right) for each axle."""
    values: dict[str, float] = {}
    for axle, value in (("front", front), ("rear", rear)):
        name = f"{axle}_{what}"
        pair = value if isinstance(value, list | tuple | np.ndarray) else (value, value)
        if len(pair) != 2:
            raise InputError(f"{name} = {value!r}: give one value [{unit}] for both sides, or two, (left, right)")
        for side, one in zip(("left", "right"), pair, strict=True):
            values[f"{axle}_{side}"] = finite_number(name, one, unit)
    return values
