"""Which channels show the motion of the car, and which of them tell by their vibration whether it moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import derivative_order, si_unit, to_si
from suspid.errors import InputError
from suspid.greybox.channel_words import ELSEWHERE_WORDS, LEVEL_WORDS, UPRIGHT_WORDS, words_of
from suspid.greybox.level_axes import WHEEL_WORDS, shows_gravity, stem_of
from suspid.greybox.stated_units import own_unit
from suspid.greybox.wheels import body_channels
from suspid.model import Suspension, output_weights
from suspid.recordings import RawChannel, Recording
from suspid.units import MetrePerSecond2, RealArray, Second
from suspid.words import Check, Level, Remark
from suspid.words.drives import DriveRemark

# Derivative of a displacement that a channel of which nothing is said is taken for: sensors on cars are accelerometers.
UNSTATED_ORDER = 2
# Unit that a displacement or an angle is taken in, by how often it is differentiated.
UNIT_OF_ORDER = (("m", "rad"), ("m/s", "rad/s"), ("m/s2", "rad/s2"))
FEWEST_CHANGES = 10  # of a channel that is held: fewer may be those of one that is stuck
# Usual vibration beyond which a unit is wrong [m/s2]: a wheel on the worst roads has half of it, a body a tenth.
MOST_SHAKEN: MetrePerSecond2 = 100.0
# Usual vibration of a car that moves, beyond which its speed is not the same throughout; an idling engine makes less.
SURELY_MOVING: MetrePerSecond2 = 0.3


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Shaken:
    """The channels whose vibration is judged: derivative of the displacement, and factor to SI."""

    orders: Mapping[str, tuple[int, float]]
    # Those that move wherever the car is on a road: on the body where a car or their names say which they are.
    body: frozenset[str] = frozenset()
    judged: frozenset[str] = frozenset()  # the loudest of them says whether the car moves
    upright: bool = False  # whether one on the body measures up and down
    unknown: tuple[str, ...] = ()  # of which nothing says what they measure, though they are judged


def shaken_of(recording: Recording, names: Sequence[str], car: Suspension | None) -> Shaken:
    """Return the channels whose vibration tells whether the car moves, each as the quantity that it measures.

    Those that measure displacements, velocities and accelerations are judged; without any, angles and their rates. If
    nothing says what any channel measures, all are judged as accelerations. Of the body's, those of the highest
    derivative decide: in the others the noise of the sensor may look like vibration.
    """
    straight, turning, others = dict[str, tuple[int, float]](), dict[str, tuple[int, float]](), list[str]()
    for name in names:
        channel, order = recording[name], order_in(car, name)
        if order is None:
            order = _order(channel)
        if order is None:
            others.append(name)
            continue
        kind = turning if si_unit(own_unit(channel)).startswith("rad") else straight
        kind[name] = order, _factor(own_unit(channel))
    told = straight or turning
    if not told:
        alike = dict.fromkeys(others, (UNSTATED_ORDER, 1.0))
        return Shaken(orders=alike, judged=frozenset(others), unknown=tuple(others))
    on_body = body_channels(car, list(told)) if car is not None else [n for n in told if not words_of(n) & WHEEL_WORDS]
    body = frozenset(on_body) if car is not None else frozenset(on_body or told)
    highest = max(told[name][0] for name in body or told)
    return Shaken(
        orders=told,
        body=body,
        judged=frozenset(name for name in body or told if told[name][0] == highest),
        upright=any(car is not None or _upright(recording[name]) for name in body),
    )


def moving(channels: Sequence[RawChannel], least: Second) -> list[RawChannel]:
    """Return the channels that show motion of the car: displacements to accelerations, and rates of rotation.

    Where there is none, those of which nothing is known. Values that are usually held for ``least`` [s] are those of a
    slow bus or of satellites, which show no vibration.
    """
    quick = [one for one in channels if usually_held(one) < least] or list(channels)
    known = [one for one in quick if _order(one) is not None]
    turns = {one.name for one in known if si_unit(own_unit(one)) == "rad"}
    # Angles count where nothing else is known: headings turn with the road.
    told = [one for one in known if one.name not in turns] or known
    return told or [one for one in quick if _open(one)]


def usually_held(channel: RawChannel) -> Second:
    """Return how long a channel usually stays at one value [s]; 0 where it hardly changes at all.

    Examples
    --------
    >>> t = np.arange(1000) / 100
    >>> usually_held(RawChannel(name="speed", unit="m/s", timepts=t, values=np.floor(t / 0.5), rate=None))
    0.5
    """
    good = np.isfinite(channel.values) & np.isfinite(channel.timepts)
    times, values = channel.timepts[good], channel.values[good]
    changes = np.flatnonzero(np.diff(values) != 0)
    if changes.size < FEWEST_CHANGES:
        return 0.0
    return float(np.round(np.median(np.diff(times[changes])), 9))


def said_of(shaken: Shaken, *, by_vibration: bool) -> list[Check]:
    """Return what is to be said where the vibration decides and nothing says what the channels measure."""
    if not (by_vibration and shaken.unknown):
        return []
    return [Check(Remark(DriveRemark.NO_UNIT, {"channels": shaken.unknown}), Level.NOTE)]


def said_of_level(course: Sequence[RealArray]) -> list[Check]:
    """Return what is to be said where a car cannot shake so; ``course`` has speed and vibration of each block last.

    Examples
    --------
    >>> [len(said_of_level([np.array([[0.0, 20.0, level]])])) for level in (20.0, 1000.0)]
    [0, 1]
    >>> [len(said_of_level([np.array([[0.0, 0.0, level], [1.0, 0.0, level]])])) for level in (0.2, 2.0)]
    [0, 1]
    """
    if not course:
        return []
    _, speed, level = np.concatenate(course).T
    usual, said = float(np.median(level)), []
    if usual > MOST_SHAKEN:
        said.append(Check(Remark(DriveRemark.TOO_STRONG, {"level": usual}), Level.CARE))
    if np.all(speed == 0) and usual > SURELY_MOVING:
        said.append(Check(Remark(DriveRemark.DEAD_SPEED, {"level": usual}), Level.CARE))
    return said


def said_of_units(recording: Recording, shaken: Shaken) -> list[Check]:
    """Return what is to be said of channels that state a unit which is not one of what they are taken for.

    Examples
    --------
    >>> t = np.arange(300) / 100
    >>> made = RawChannel(name="acc", unit="volts/8", timepts=t, values=np.sin(9 * t), rate=None)
    >>> ride = Recording(title="ride", channels=(made,))
    >>> [check.remark.numbers["unit"] for check in said_of_units(ride, shaken_of(ride, ["acc"], None))]
    ['volts/8']
    """
    named = dict[tuple[str, str], list[str]]()
    for name, (order, _) in shaken.orders.items():
        unit = own_unit(recording[name]).strip()
        # What has no letter, such as a dash, states nothing.
        if name in shaken.unknown or not any(letter.isalpha() for letter in unit):
            continue
        if si_unit(unit) not in UNIT_OF_ORDER[order]:
            named.setdefault((unit, UNIT_OF_ORDER[order][0]), []).append(name)
    return [
        Check(
            Remark(
                DriveRemark.UNKNOWN_UNIT,
                {"channels": tuple(names), "unit": unit, "si": si, "known": bool(si_unit(unit))},
            ),
            Level.CARE,
        )
        for (unit, si), names in named.items()
    ]


def order_in(car: Suspension | None, name: str) -> int | None:
    """Return the derivative that a channel of a car measures; None where it is none."""
    if car is None:
        return None
    try:
        return output_weights(car, name)[0]
    except InputError:
        return None


def _order(channel: RawChannel) -> int | None:
    """Return the derivative that a channel measures by its unit, or by its name if the unit may be any sensor's."""
    unit = own_unit(channel)
    if words_of(channel.name) & ELSEWHERE_WORDS or unit.strip().lower() in ("rpm", "%"):
        return None
    return derivative_order(channel.name, unit)


def _open(channel: RawChannel) -> bool:
    """Return whether nothing says what a channel measures: no unit, that of a voltage, or none of a quantity."""
    unit = own_unit(channel).strip()
    there = channel.values[np.isfinite(channel.values)]
    changes = there.size > 0 and bool(np.any(there != there[0]))
    return changes and not words_of(channel.name) & ELSEWHERE_WORDS and (not unit or si_unit(unit) == "V")


def _upright(channel: RawChannel) -> bool:
    """Return whether a channel measures up and down: by its axis, its place in the car, or gravity."""
    words = words_of(channel.name)
    if words & LEVEL_WORDS:
        return shows_gravity(channel)
    return bool(words & UPRIGHT_WORDS) or stem_of(channel.name)[-1:].lower() == "z" or shows_gravity(channel)


def _factor(unit: str) -> float:
    """Return the factor from a unit to SI; 1 where the unit is not known."""
    try:
        return float(to_si(1.0, unit)[0])
    except InputError:
        return 1.0
