"""Codes and sentences: the stretches of a drive: why they were taken or left."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from suspid.wording import Argument, AtCommandLine
from suspid.words.remarks import MOST_NAMED, Code, Number, count, in_a_row, sentence


def _channels(numbers: Mapping[str, Number]) -> str:
    names = numbers["channels"]
    assert isinstance(names, tuple)
    if len(names) <= MOST_NAMED + 1:
        return ", ".join(map(repr, names))
    return f"{', '.join(map(repr, names[:MOST_NAMED]))} and {len(names) - MOST_NAMED} others"


def _speeds(numbers: Mapping[str, Number]) -> str:
    low, high = (f"{float(str(numbers[end])):.3g}" for end in ("low", "high"))
    return low if low == high else f"{low} to {high}"


def _listed(numbers: Mapping[str, Number]) -> str:
    names = numbers["names"]
    assert isinstance(names, tuple)
    return in_a_row(names)


def _no_unit(numbers: Mapping[str, Any]) -> str:
    one = len(numbers["channels"]) == 1
    measures = "measures" if one else "measure"
    were = "it were an acceleration" if one else "they were accelerations"
    state = (
        "State its unit, or name it by what it measures"
        if one
        else ("State their units, or name them by what they measure")
    )
    return (
        f"Nothing says what {_channels(numbers)} {measures}: whether the car moves was judged as if {were} in m/s2. "
        f"{state}, such as 'body_travel'."
    )


def _unknown_unit(numbers: Mapping[str, Any]) -> str:
    state, si = "states" if len(numbers["channels"]) == 1 else "state", numbers["si"]
    unit = f"a unit of {numbers['unit']}" if numbers["known"] else f"the unit {numbers['unit']!r}"
    why = f"which is none of {si}" if numbers["known"] else "which is not known"
    scale = AtCommandLine("scale", f"{numbers['channels'][0]}=9.81")
    return (
        f"{_channels(numbers)} {state} {unit}, {why}: the samples were taken as {si}. Results are wrong if they are "
        f"not. State the unit in brackets behind the name, such as 'body_acceleration [g]', or multiply by the factor "
        f"to {si}{scale}."
    )


def _found(numbers: Mapping[str, Number]) -> str:
    stretches = numbers["stretches"]
    assert isinstance(stretches, int)
    return "{what}, {seconds:.4g} of {length:.4g} s, usable".format_map(
        {**numbers, "what": count(stretches, "stretch") if stretches == 1 else f"{stretches} stretches"}
    )


def _none(numbers: Mapping[str, Number]) -> str:
    why = numbers.get("why")
    return "no stretch of {length:.4g} s is usable".format_map(numbers) + (f": {why}" if why else "")


class DriveReason(Code):
    """Why a stretch of a drive was taken or left."""

    MOVING = "moving", sentence(lambda n: f"moving at {_speeds(n)} m/s")
    VIBRATING = "vibrating", "moving (vibration {level:.2g} m/s2)"
    MISSING = "missing", sentence(lambda n: f"samples missing in {_channels(n)}")
    CLIPPED = "clipped", sentence(lambda n: f"{_channels(n)} clipped")
    STUCK = "stuck", sentence(lambda n: f"{_channels(n)} stuck at one value")
    SLOW = "slow", "slower than {limit:g} m/s (down to {low:.2g} m/s)"
    STANDING = "standing", "standing (vibration {level:.2g} m/s2, limit {limit:g} m/s2)"
    QUIET = (
        "quiet",
        "hardly vibrating ({level:.2g} m/s2, limit {limit:g} m/s2), though {channel!r} is up to {most:.3g}: state "
        "the unit of speed",
    )
    ROLLING = (
        "on rollers",
        "not on a road: at {speed:.3g} m/s the body vibrates with only {level:.2g} m/s2 (limit {limit:g} m/s2), as on "
        "a roller bench",
    )
    BRAKING = "braking", "braking or accelerating with up to {most:.3g} m/s2 (limit {limit:g} m/s2)"
    CORNERING = "cornering", "cornering with up to {most:.3g} m/s2 (limit {limit:g} m/s2)"
    SHORT = "short", "usable, but only {length:.3g} s long (minimum {least:g} s)"
    BRIEF = "brief", "{length:.2g} s are too short for a drive: it is judged in blocks of {block:g} s"


class DriveRemark(Code):
    """Remarks on a whole drive."""

    FOUND = "found", _found
    NONE = "none", _none
    TOO_SHORT = (
        "too short",
        sentence(
            lambda n: (
                f"The longest usable stretch has {n['longest']:.3g} s of the {n['least']:g} s that one must have. "
                f"Record a longer drive at steady speed, or allow shorter stretches ({Argument('shortest')}), whose "
                f"intervals are wider."
            )
        ),
    )
    STANDS = (
        "stands",
        "The car stands. If it was released, pushed or shaken there, its modes follow from identify, its springs and "
        "dampers from estimate.",
    )
    NO_SPEED = "no speed", "No speed channel: whether the car moves was judged from its vibration."
    SPEED_UNUSED = "speed unused", "Channel {channel!r} looks like the speed of the car, but was not used: {why}."
    BRAKING_UNKNOWN = (
        "braking unknown",
        "Neither speed nor longitudinal acceleration was measured: braking was not detected, and the records may "
        "contain it.",
    )
    CORNERING_UNKNOWN = (
        "cornering unknown",
        "Neither lateral acceleration nor yaw rate and speed were measured: cornering was not detected, and the "
        "records may contain it.",
    )
    YAW_BY_GRAVITY = (
        "yaw by gravity",
        "{channel!r} was taken as the yaw rate, because the acceleration along its axis shows gravity.",
    )
    SPEED_BY_UNIT = "speed by unit", "{channel!r} was taken as the speed of the car, because of its unit."
    BY_AXIS = (
        "by axis",
        sentence(
            lambda n: (
                f"Taken as acceleration along or across the car, from the name of the axis or from gravity: "
                f"{_channels(n)}."
            )
        ),
    )
    NO_UNIT = "no unit", sentence(_no_unit)
    UNKNOWN_UNIT = "unknown unit", sentence(_unknown_unit)
    TOO_STRONG = (
        "too strong",
        "The usual vibration is {level:.0f} m/s2, which no car has: the unit of a channel is wrong, such as g for "
        "thousandths of g. Frequencies do not depend on it; which stretches were taken does.",
    )
    DEAD_SPEED = (
        "dead speed",
        sentence(
            lambda n: (
                f"The speed is 0 throughout, but the car vibrates as one that moves, with {n['level']:.3g} m/s2: the "
                f"channel of the speed is dead. {Argument('speed', repr('none'))} goes by the vibration."
            )
        ),
    )
    NO_MOTION = (
        "no motion",
        sentence(
            lambda n: (
                f"Left out, because not known to show vibration of the car: {_channels(n)}. Name those that "
                f"do ({Argument('channels')})."
            )
        ),
    )
    OUTLIERS = (
        "outliers",
        sentence(
            lambda n: (
                f"Samples far from all others, which are no motion, were treated as missing: {n['samples']} in "
                f"{_channels(n)}, first at {n['start']:.6g} s."
            )
        ),
    )
    NO_WHEELS = (
        "no wheels",
        sentence(
            lambda n: (
                f"No channel measures the motion of {_listed(n)} alone: springs and dampers cannot be separated from "
                f"the road. Only frequencies of the body are found."
            )
        ),
    )
    NO_DELAY = (
        "no delay",
        "The speed is not known throughout, so neither is the delay between the axles: tires and wheel masses are "
        "those of each axle by itself.",
    )
    NO_SPRINGS = "no springs", "Springs and dampers were not found: {why}."
    NO_FREQUENCIES = "no frequencies", "The frequencies of the body were not found: {why}."
    CURVES_FROM = (
        "curves from",
        "The curves of the dampers are from the longest stretches, {used:.4g} of {seconds:.4g} s.",
    )
    SENSORS = (
        "sensors",
        sentence(
            lambda n: (
                f"The curve of {_listed(n)} was found with corrected sensors ({n['corrections']}, from a fit of "
                f"viscous dampers without mounts): without the correction the residual exceeds noise. The intervals "
                f"of the curve take the correction as exact."
            )
        ),
    )
    MISFIT = (
        "misfit",
        sentence(
            lambda n: (
                f"The residual of the curve of {_listed(n)} exceeds the noise of the sensors: a mount of the damper, "
                f"gain or delay of a sensor, another axle, or a force on the body (an engine of varying speed) may be "
                f"missing. Do not use the curve."
            )
        ),
    )
    BENT = (
        "bent",
        sentence(
            lambda n: (
                f"The damper of {_listed(n)} is not viscous: its c holds only at the amplitude of this drive, and a "
                f"car with viscous dampers may not explain the drive. Use the curve and "
                "the stiffness found with it."
            )
        ),
    )
    BY_CURVES = (
        "by curves",
        sentence(
            lambda n: (
                f"A car with viscous dampers does not explain this drive, but the curve of each damper does: "
                f"{_listed(n)} is not viscous. Use the curves and the stiffness found with them; k, c and modes "
                f"found with viscous dampers may be off by more than their intervals."
            )
        ),
    )
    NO_CURVE = "no curve", sentence(lambda n: f"The curve of the damper of {_listed(n)} was not found: {n['why']}.")
    NO_WEAR = "no wear", "The wear of the dampers was not judged: {why}."
    UNREADABLE = "unreadable", "The part from {start:.6g} to {stop:.6g} s was left out: {why}."


class DriveHeadline(Code):
    """What was found in a drive."""

    SPRINGS = "springs", "springs and dampers from {seconds:.4g} usable of {length:.4g} s"
    FREQUENCIES = "frequencies", "frequencies of the body from {seconds:.4g} usable of {length:.4g} s"
    NOTHING = "nothing", "no frequency of the body from {seconds:.4g} usable of {length:.4g} s"


class BodyCheck(Code):
    """Checks of a body that was measured without the wheels."""

    FOUND = (
        "found",
        sentence(lambda n: f"the body's frequency in {n['channels']} of the channels, from {n['seconds']:.4g} s"),
    )
    NO_RESONANCE = "no resonance", "A smooth spectrum without a resonance explains {channel!r}."
    NOT_DETERMINED = "not determined", "The records do not determine the resonance of {channel!r}."
    NO_DAMPING = (
        "no damping",
        "Damping is not reported: depending on the model of the road it would be {low:.2g} or {high:.2g}. Measure "
        "the motion of "
        "the wheels as well, or a free decay.",
    )
    ONE_EACH = (
        "one each",
        "Each channel gives one frequency for all modes of the body that it shows. Lines of the rotating wheels, at "
        "8 to 15 Hz, are not modes and are not searched.",
    )
