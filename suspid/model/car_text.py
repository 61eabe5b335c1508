"""Text of a car file, from a `Suspension`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

from suspid.model.suspension import Suspension


def car_to_toml(suspension: Suspension) -> str:
    """Return a suspension as TOML text; `car_from_toml` returns the same values, bit for bit.

    Examples
    --------
    >>> from suspid import Strut
    >>> strut = Strut(name="spring", stiffness=4e3, damping=10.0, arms={"mass": 1.0, "road": -1.0})
    >>> print(car_to_toml(Suspension(masses={"mass": 10.0}, struts=[strut])))
    [masses]  # kg
    mass = 10.0
    <BLANKLINE>
    [[struts]]
    name = "spring"
    stiffness = 4000.0  # N/m
    damping = 10.0  # N s/m
    arms = { mass = 1.0, road = -1.0 }
    <BLANKLINE>
    """
    lines = ["[masses]  # kg", *(f"{_key(name)} = {mass!r}" for name, mass in suspension.masses.items())]
    for strut in suspension.struts:
        lines += [
            "",
            "[[struts]]",
            f"name = {_quoted(strut.name)}",
            f"stiffness = {strut.stiffness!r}  # N/m",
            f"damping = {strut.damping!r}  # N s/m",
            f"arms = {_arms(strut.arms)}",
        ]
    mounts = {strut.name: strut.mount_stiffness for strut in suspension.struts if strut.mount_stiffness is not None}
    if mounts:
        lines += ["", "[mounts]  # N/m", *(f"{_key(name)} = {stiffness!r}" for name, stiffness in mounts.items())]
    friction = {strut.name: strut.friction for strut in suspension.struts if strut.friction}
    if friction:
        lines += ["", "[friction]  # N", *(f"{_key(name)} = {force!r}" for name, force in friction.items())]
    curves = {strut.name: strut.curve for strut in suspension.struts if strut.curve is not None}
    if curves:
        lines += ["", "[curves]  # m/s, N"]
    for name, points in curves.items():
        lines.append(f"{_key(name)} = [{', '.join(f'[{v!r}, {f!r}]' for v, f in points)}]")
    if suspension.sensors:
        lines += ["", "[sensors]"]
    for sensor in suspension.sensors:
        of = _quoted(sensor.of) if isinstance(sensor.of, str) else _arms(sensor.of)
        lines.append(f"{_key(sensor.name)} = {{ {sensor.motion} = {of} }}")
    return "\n".join([*lines, ""])


def _arms(arms: Mapping[str, float]) -> str:
    return f"{{ {', '.join(f'{_key(name)} = {arm!r}' for name, arm in arms.items())} }}"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)


def _quoted(text: str) -> str:
    """Return a TOML basic string: JSON's, with DEL escaped as well."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
