"""Words in names of channels that say what a channel measures."""

from __future__ import annotations

import re

SPEED_WORDS = frozenset(
    {"speed", "spd", "vehspd", "vehspeed", "vehiclespeed", "velocity", "geschwindigkeit", "vitesse"}
)
LATERAL_WORDS = frozenset({"lateral", "latacc", "lat"})
LONGITUDINAL_WORDS = frozenset({"longitudinal", "longacc", "lon", "long"})
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


def words_of(name: str) -> frozenset[str]:
    """Return the words of a name, of which capitals may begin one, in lower case.

    Examples
    --------
    >>> sorted(words_of("VehicleSpeed_2 [km/h]")), sorted(words_of("AccelZ_g"))
    (['speed', 'vehicle'], ['accel', 'g', 'z'])
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", re.sub(r"[\[(].*", "", name))
    return frozenset(word for word in re.split(r"[\W\d_]+", apart.lower()) if word)
