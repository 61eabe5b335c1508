"""Words in names of channels that say what a channel measures."""

from __future__ import annotations

import re

SPEED_WORDS = frozenset(
    {"speed", "spd", "vehspd", "vehspeed", "vehiclespeed", "velocity", "geschwindigkeit", "vitesse"}
)
LATERAL_WORDS = frozenset({"lateral", "latacc", "lat", "querbeschleunigung"})
LONGITUDINAL_WORDS = frozenset(
    {"longitudinal", "longacc", "lon", "long", "inline", "längsbeschleunigung", "laengsbeschleunigung"}
)
# Words of a name that says acceleration alone: beside a lateral one, racing loggers name that along the car so.
PLAIN_WORDS = frozenset({"acceleration", "accel", "acc", "gs", "g", "s"})
YAW_WORDS = frozenset({"yaw", "yawrate", "gierrate"})
# Words of something else than the motion itself.
OTHER_WORDS = frozenset(
    {
        *("accuracy", "valid", "limit", "error", "std", "engine", "motor", "fan", "shaft", "wind", "air", "airflow"),
        *("target", "set", "setpoint", "setting", "cruise", "max", "min", "mean", "average"),
    }
)
# Words of a velocity within the car.
WITHIN_WORDS = OTHER_WORDS | {
    *("damper", "shock", "spring", "suspension", "travel", "vertical", "heave", "body", "chassis", "seat", "tire"),
}
# Words of an acceleration and of a rotation rate, without which a suffix such as _g is no unit.
ACCELERATION_WORDS = LATERAL_WORDS | LONGITUDINAL_WORDS | {"a", "ax", "ay", "az", "vertical", "vert"}
ROTATION_WORDS = YAW_WORDS | {"gyro", "gyr", "gyroscope", "rate", "pitch", "roll", "omega", "rotation"}
# Words of what is no vibration, whatever its unit: where the car is and points, pedals, and quality of a measurement.
ELSEWHERE_WORDS = frozenset(
    {
        *("accuracy", "std", "valid", "error", "target", "setpoint", "pedal", "throttle", "gravity", "steering"),
        *("rpm", "engine", "latitude", "longitude", "altitude", "elevation", "location", "gps", "odometer", "heading"),
        *("course", "magnetic", "mag"),
    }
)
# Words of axes that are level, and of upright ones or parts of the car whose motion up and down is meant.
LEVEL_WORDS = LATERAL_WORDS | LONGITUDINAL_WORDS | {"x", "y", "ax", "ay"}
UPRIGHT_WORDS = frozenset(
    {"z", "az", "vertical", "vert", "heave", "bounce", "body", "chassis", "sprung", "seat", "cab"}
)


def names_speed(name: str) -> bool:
    """Return whether a name says that a channel is the speed of the car.

    Examples
    --------
    >>> [names_speed(name) for name in ("VehicleSpeed", "locationSpeed", "damper speed", "engine speed", "az")]
    [True, True, False, False, False]
    """
    words = words_of(name)
    return bool(words & SPEED_WORDS) and not words & WITHIN_WORDS


def words_of(name: str) -> frozenset[str]:
    """Return the words of a name, of which capitals may begin one, in lower case.

    Examples
    --------
    >>> sorted(words_of("VehicleSpeed_2 [km/h]")), sorted(words_of("AccelZ_g"))
    (['speed', 'vehicle'], ['accel', 'g', 'z'])
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", re.sub(r"[\[(].*", "", name))
    return frozenset(word for word in re.split(r"[\W\d_]+", apart.lower()) if word)
