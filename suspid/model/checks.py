"""Checks of the names and numbers that describe a suspension."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from suspid.errors import InputError
from suspid.values import LARGEST_SIZE, SMALLEST_SIZE, FrozenMapping
from suspid.wording import Argument


def finite_number(what: str, value: object, unit: str) -> float:
    """Return a value as a float; raise an `InputError` with its name and unit unless it is a number of usual size."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"{what} = {value!r} is not a number; give it in {unit}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{what} = {number} {unit} is not finite")
    if abs(number) > LARGEST_SIZE:
        raise InputError(f"{what} = {number:g} {unit} is beyond {LARGEST_SIZE:g}; check its unit")
    return number


# Longest distance between parts of a vehicle [m]: no car, lorry or wagon is as long. Ordinary ones in mm are beyond.
LONGEST_VEHICLE = 100.0


def distance(what: str, value: object) -> float:
    """Return a distance on a vehicle in metres; raise an `InputError` for one that no vehicle has.

    Examples
    --------
    >>> distance("front_track", 1500)
    Traceback (most recent call last):
    suspid.errors.InputError: front_track = 1500 m is longer than any vehicle: in metres it is 1.5 if it was given in mm
    """
    number = positive_number(what, value, "m")
    if number > LONGEST_VEHICLE:
        raise InputError(
            f"{what} = {number:g} m is longer than any vehicle: in metres it is {number / 1000:g} if it was given in mm"
        )
    return number


def positive_number(what: str, value: object, unit: str) -> float:
    """Return the same as `finite_number`, for what must be positive."""
    number = finite_number(what, value, unit)
    if number <= 0:
        raise InputError(f"{what} = {number:g} {unit} must be positive")
    if number < SMALLEST_SIZE:
        raise InputError(f"{what} = {value:g} {unit} is below {SMALLEST_SIZE:g}; check its unit")
    return number


def check_name(what: str, name: object) -> None:
    """Refuse a name that python-control would not accept as a label."""
    if not isinstance(name, str) or not name or "." in name:
        raise InputError(f"{what} is named {name!r}; a name is a string, not empty, without '.' (as in python-control)")


def added_masses(given: object) -> FrozenMapping:
    """Return the masses [kg] that a test adds, by coordinate, checked."""
    if not isinstance(given, Mapping):
        raise InputError(f"added_masses = {given!r} must map coordinates to masses [kg]")
    for name, mass in given.items():
        if not (isinstance(mass, int | float | np.number) and np.isfinite(mass) and mass >= 0):
            raise InputError(Argument("added_masses"), f": {name!r} = {mass!r} must be a finite mass >= 0 in kg")
    return FrozenMapping(given)
