"""Checks of a suspension: its masses, struts, coordinates and sensors, and whether it is linear."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.model.checks import check_name, positive_number
from suspid.model.sensor import DERIVATIVES, ROAD_DERIVATIVES, Sensor
from suspid.model.strut import Strut
from suspid.units import Kilogram
from suspid.values import nearest_names
from suspid.wording import WayOut

if TYPE_CHECKING:
    from suspid.model.suspension import Suspension

# Damper that friction equals, over twice the mass that the strut moves times the highest natural frequency, from which
# on the strut is as good as rigid: its force is then twenty times that of inertia at every mode of the car.
HELD_FAST = 10.0


def check_linear(suspension: Suspension, what: str) -> None:
    """Refuse a suspension with friction or curves where only linear struts are meant."""
    for strut in suspension.struts:
        if not strut.linear:
            has = "a curve" if strut.curve is not None else f"friction of {strut.friction:g} N"
            raise InputError(
                f"{what} needs linear struts, but strut {strut.name!r} has {has}; ",
                WayOut(
                    "use car.linearised(amplitude=…), with the dampers of equal work at that amplitude of velocity "
                    "[m/s], or car.linearised(), with damping as stated; free_decay and simulate take the car as it is",
                    "linearise",
                    "give {option}, the amplitude of velocity in m/s at which dampers of equal work replace it; "
                    "suspid simulate takes the car as it is",
                    "leave friction and curves out of the car file; suspid simulate takes the car as it is",
                ),
            )


def check_amplitude(suspension: Suspension, amplitude: float) -> None:
    """Refuse an amplitude of velocity at which friction holds a strut fast: no damper stands for that."""
    highest = float(np.max(np.linalg.eigvals(suspension.K / np.diag(suspension.M)[:, None]).real)) ** 0.5
    for strut, arms in zip(suspension.struts, suspension.arms(suspension.coordinates), strict=True):
        mobility = float(np.sum(arms**2 / np.diag(suspension.M)))
        most = HELD_FAST * 2 * highest / mobility if mobility else np.inf
        # Work of friction over a cycle, as in `equal_work`.
        damper = 4 * strut.friction / (np.pi * amplitude)
        if damper > most > 0:
            least = f"{damper / most * amplitude:.2g}"
            raise InputError(
                WayOut(f"amplitude={amplitude:g}", "linearise", f"{{option}} {amplitude:g}", f"{amplitude:g}"),
                f" m/s is too small: there the friction of strut {strut.name!r}, {strut.friction:g} N, equals a damper "
                f"of {damper:.3g} N s/m, which holds the strut fast; give the amplitude of velocity in the motion that "
                f"is meant, such as 0.1 m/s, and at least {least} m/s",
            )


def check_plain(suspension: Suspension, what: str) -> None:
    """Refuse a suspension with struts that are more than a linear spring and a viscous damper in parallel."""
    check_linear(suspension, what)
    mounted = [strut.name for strut in suspension.struts if strut.relaxation]
    if mounted:
        raise InputError(
            f"{what} needs struts of a spring and a damper in parallel, but the damper of strut {mounted[0]!r} is on a "
            f"mount; remove mount_stiffness, or use statespace, eigenmodes or estimate"
        )


def check_masses(masses: Mapping[str, Kilogram]) -> None:
    """Refuse masses that are not positive numbers by name."""
    if not isinstance(masses, Mapping):
        raise InputError(f"masses = {masses!r} must map coordinates to masses [kg], such as {{'seat': 80.0}}")
    if not masses:
        raise InputError("a suspension needs at least one mass; masses is empty")
    for coordinate, mass in masses.items():
        check_name("a mass", coordinate)
        positive_number(f"mass {coordinate!r}", mass, "kg")


def check_struts(struts: Sequence[Strut]) -> None:
    """Refuse struts that are not of their type, or share a name."""
    for strut in struts:
        if not isinstance(strut, Strut):
            raise InputError(f"struts contains {strut!r}; every item must be a Strut")
    names = [strut.name for strut in struts]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"strut name {twice[0]!r} is used {names.count(twice[0])} times; names must be unique")


def check_coordinates(suspension: Suspension) -> set[str]:
    """Refuse names with two meanings, probable misspellings and masses without a strut; return all names taken."""
    masses, roads, struts = suspension.masses, suspension.roads, suspension.struts
    derived = {f"{c}_{d}" for c in masses for d in DERIVATIVES} | {f"{strut.name}_travel" for strut in struts}
    derived |= {f"{road}_{d}" for road in roads for d in ROAD_DERIVATIVES}
    ambiguous = sorted(derived & {*masses, *roads})
    if ambiguous:
        raise InputError(f"coordinate {ambiguous[0]!r} has the name of an input or output; give it another name")
    for road in roads:
        intended = _probably_meant(road, tuple(suspension.coordinates))
        if intended:
            raise InputError(
                f"coordinate {road!r} is used in an arm but has no mass, and is close to {intended!r}: "
                f"correct the arm, or give the road input another name"
            )
    for coordinate, mass in masses.items():
        if not any(s.arms.get(coordinate) and (s.stiffness or s.damping or not s.linear) for s in struts):
            raise InputError(
                f"mass {coordinate!r} = {mass:g} kg is not connected: "
                f"no strut with stiffness or damping has an arm on it"
            )
    return derived | {*masses, *roads}


def check_sensors(suspension: Suspension, taken: set[str]) -> None:
    """Refuse sensors of unknown coordinates or struts, and names with two meanings."""
    struts = [strut.name for strut in suspension.struts]
    coordinates = (*suspension.coordinates, *suspension.roads)
    names: list[str] = []
    for sensor in suspension.sensors:
        if not isinstance(sensor, Sensor):
            raise InputError(f"sensors contains {sensor!r}; every item must be a Sensor")
        if sensor.name in names:
            raise InputError(f"sensor name {sensor.name!r} is used twice; names must be unique")
        if sensor.name in taken:
            raise InputError(f"sensor {sensor.name!r} has the name of an input or output; give it another name")
        names.append(sensor.name)
        kind, known = ("strut", struts) if isinstance(sensor.of, str) else ("coordinate", coordinates)
        for name in [sensor.of] if isinstance(sensor.of, str) else sensor.of:
            if name not in known:
                raise InputError(f"sensor {sensor.name!r}: there is no {kind} {name!r}.{nearest_names(name, known)}")


# A fit makes the same car of other values many times; a fleet has some cars.
@lru_cache(maxsize=256)
def _probably_meant(road: str, coordinates: tuple[str, ...]) -> str | None:
    """Return the coordinate that ``road`` probably misspells; numbered names may differ in digits."""
    for coordinate in coordinates:
        # 0.85 catches a missing letter in names of four and a wrong one in names of seven, and passes front and rear.
        alike = difflib.SequenceMatcher(None, road.lower(), coordinate.lower()).ratio() >= 0.85
        if alike and re.sub(r"\d", "", road) != re.sub(r"\d", "", coordinate):
            return coordinate
    return None
