"""What can be said of the stretches of a drive: why they were taken or left."""

from __future__ import annotations

from collections.abc import Mapping

from suspid.words.remarks import MOST_NAMED, Code, Number, count, in_a_row, sentence


def _channels(numbers: Mapping[str, Number]) -> str:
    names = numbers["channels"]
    assert isinstance(names, tuple)
    if len(names) <= MOST_NAMED + 1:
        return ", ".join(map(repr, names))
    return f"{', '.join(map(repr, names[:MOST_NAMED]))} and {len(names) - MOST_NAMED} others"


def _listed(numbers: Mapping[str, Number]) -> str:
    names = numbers["names"]
    assert isinstance(names, tuple)
    return in_a_row(names)


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

    MOVING = "moving", "moving at {low:.3g} to {high:.3g} m/s"
    VIBRATING = "vibrating", "moving, by its vibration of {level:.2g} m/s2"
    MISSING = "missing", sentence(lambda n: f"samples missing in {_channels(n)}")
    CLIPPED = "clipped", sentence(lambda n: f"{_channels(n)} clipped")
    STUCK = "stuck", sentence(lambda n: f"{_channels(n)} stuck at one value")
    SLOW = "slow", "slower than {limit:g} m/s (down to {low:.2g} m/s)"
    STANDING = "standing", "standing, by a vibration of only {level:.2g} m/s2 (limit {limit:g} m/s2)"
    BRAKING = "braking", "braking or accelerating with up to {most:.2g} m/s2 (limit {limit:g} m/s2)"
    CORNERING = "cornering", "cornering with up to {most:.2g} m/s2 (limit {limit:g} m/s2)"
    SHORT = "short", "usable, but only {length:.3g} s long (least {least:g} s)"


class DriveRemark(Code):
    """What is said of a drive as a whole."""

    FOUND = "found", _found
    NONE = "none", _none
    NO_SPEED = "no speed", "No channel of speed: whether the car moves was judged by its vibration."
    SPEED_UNUSED = "speed unused", "Channel {channel!r} looks like the speed of the car, but was not used: {why}."
    BRAKING_UNKNOWN = (
        "braking unknown",
        "Neither speed nor longitudinal acceleration was measured: braking was not judged, and its forces may be in "
        "the records.",
    )
    CORNERING_UNKNOWN = (
        "cornering unknown",
        "Neither lateral acceleration nor yaw rate and speed were measured: cornering was not judged, and its forces "
        "may be in the records.",
    )
    YAW_BY_GRAVITY = (
        "yaw by gravity",
        "{channel!r} was taken for the yaw rate, because the acceleration along its axis shows gravity.",
    )
    SPEED_BY_UNIT = "speed by unit", "{channel!r} was taken for the speed of the car, by its unit."
    BY_AXIS = (
        "by axis",
        sentence(
            lambda n: f"Acceleration along or across the car: {_channels(n)}, by the name of the axis or by gravity."
        ),
    )
    NO_UNIT = "no unit", sentence(lambda n: f"No unit is stated for {_channels(n)}: taken as SI.")
    NO_WHEELS = (
        "no wheels",
        sentence(
            lambda n: (
                f"No channel shows the motion of {_listed(n)} alone: springs and dampers cannot be told from the road. "
                "Frequencies of the body are all that is found."
            )
        ),
    )
    CURVES_FROM = (
        "curves from",
        "The curves of the dampers are from the longest stretches, {used:.4g} of {seconds:.4g} s.",
    )
    SENSORS = (
        "sensors",
        sentence(
            lambda n: (
                f"The curve of {_listed(n)} was found with corrected sensors ({n['corrections']}, by viscous dampers "
                "without mounts): with the sensors as they are, more than noise is left. The curve's intervals take "
                "the correction as exact."
            )
        ),
    )
    MISFIT = (
        "misfit",
        sentence(
            lambda n: (
                f"The curve of {_listed(n)} leaves more than noise of the sensors: a mount of the damper, gain or "
                "delay of a sensor, or another axle may be missing. Do not use it."
            )
        ),
    )
    BENT = (
        "bent",
        sentence(
            lambda n: (
                f"The damper of {_listed(n)} is not viscous: its c stands for it at the amplitude of this drive "
                "alone, and a car of viscous dampers may not explain the drive. Use the curve and "
                "the stiffness found with it."
            )
        ),
    )
    BY_CURVES = (
        "by curves",
        sentence(
            lambda n: (
                f"A car of viscous dampers does not explain this drive, but each damper's curve does: {_listed(n)} is "
                "not viscous. Use the curves and the stiffness beside them; k, c and modes found with viscous dampers "
                "may be off by more than their intervals."
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


class BodyCheck(Code):
    """What is said of a body that was measured alone."""

    FOUND = (
        "found",
        sentence(lambda n: f"the body's frequency in {n['channels']} of the channels, from {n['seconds']:.4g} s"),
    )
    NO_RESONANCE = "no resonance", "The spectrum of {channel!r} has no resonance that a smooth one would not explain."
    NOT_DETERMINED = "not determined", "The records do not determine the resonance of {channel!r}."
    NO_DAMPING = (
        "no damping",
        "Damping is not reported: by the model of the road it would be {low:.2g} or {high:.2g}. Measure the motion of "
        "the wheels as well, or a free decay.",
    )
    ONE_EACH = (
        "one each",
        "One frequency stands for all modes of the body that a channel shows; what follows the turning of wheels, such "
        "as lines of 8 to 15 Hz, is no mode and not looked for.",
    )
