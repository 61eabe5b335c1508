"""Which channels tell by their vibration whether a car moves, and as which derivative of a displacement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from suspid.cleaning import derivative_order, si_unit, to_si
from suspid.errors import InputError
from suspid.greybox.stated_units import own_unit
from suspid.greybox.wheels import body_channels
from suspid.model import Suspension, output_weights
from suspid.recordings import Recording
from suspid.words import Check, Level, Remark
from suspid.words.drives import DriveRemark

# Derivative of a displacement that a channel of which nothing is said is taken for: sensors on cars are accelerometers.
UNSTATED_ORDER = 2


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Shaken:
    """The channels whose vibration is judged: derivative of the displacement, and factor to SI."""

    orders: Mapping[str, tuple[int, float]]
    # Those that move wherever the car is on a road: on the body where a car says which they are.
    body: frozenset[str] = frozenset()
    unknown: tuple[str, ...] = ()  # of which nothing says what they measure, though they are judged


def shaken_of(recording: Recording, names: Sequence[str], car: Suspension | None) -> Shaken:
    """Return the channels whose vibration tells whether the car moves, each as the quantity that it measures.

    Those that measure displacements, velocities and accelerations are judged; without any, angles and their rates. If
    nothing says what any channel measures, all are judged as accelerations.
    """
    straight, turning, others = dict[str, tuple[int, float]](), dict[str, tuple[int, float]](), list[str]()
    for name in names:
        unit = own_unit(recording[name])
        order = order_in(car, name)
        if order is None:
            order = derivative_order(name, unit)
        if order is None:
            others.append(name)
            continue
        kind = turning if si_unit(unit).startswith("rad") else straight
        kind[name] = order, _factor(unit)
    told = straight or turning
    if not told:
        return Shaken(orders=dict.fromkeys(others, (UNSTATED_ORDER, 1.0)), unknown=tuple(others))
    return Shaken(orders=told, body=frozenset(told if car is None else body_channels(car, list(told))))


def said_of(shaken: Shaken, *, by_vibration: bool) -> list[Check]:
    """Return what is to be said where the vibration decides and nothing says what the channels measure."""
    if not (by_vibration and shaken.unknown):
        return []
    return [Check(Remark(DriveRemark.NO_UNIT, {"channels": shaken.unknown}), Level.NOTE)]


def order_in(car: Suspension | None, name: str) -> int | None:
    """Return the derivative that a channel of a car measures; None where it is none."""
    if car is None:
        return None
    try:
        return output_weights(car, name)[0]
    except InputError:
        return None


def _factor(unit: str) -> float:
    """Return the factor from a unit to SI; 1 where the unit is not known."""
    try:
        return float(to_si(1.0, unit)[0])
    except InputError:
        return 1.0
