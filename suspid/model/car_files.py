"""Car descriptions: a `Suspension` as a TOML file that a person writes.

Masses [kg] by coordinate, struts with stiffness [N/m], damping [N s/m] and arms::

    [masses]
    chassis = 400.0
    tire = 40.0

    [[struts]]
    name = "chassis"
    stiffness = 20e3
    damping = 1500.0
    arms = { chassis = 1, tire = -1 }

    [[struts]]
    name = "tire"
    stiffness = 200e3
    damping = 0.0
    arms = { tire = 1, road = -1 }

or, shorter, a table ``[quarter_car]``, ``[half_car]`` or ``[full_car]`` with the arguments of `quarter_car`,
`half_car` or `full_car`; where `full_car` takes a pair of values, write ``[left, right]``.

Both may be followed by rubber mounts in series with dampers, by strut [N/m], by the friction of dampers [N] and their
curves (points of velocity [m/s] and force [N]), and by the sensors of its records::

    [mounts]
    front = 1e6

    [friction]
    front = 30.0

    [curves]
    front = [[-1.0, -700.0], [0.0, 0.0], [1.0, 2000.0]]

    [sensors]
    az_seat = { acceleration = "heave", ahead = 0.3, left = 0.4 }  # a point of the body [m]
    pitch_rate = { velocity = "pitch" }
    lift = { displacement = { front = 0.5, rear = 0.5 } }
    damper_pot = { travel = "front" }
"""

from __future__ import annotations

import inspect
import os
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import naming, read_text, replacing
from suspid.model.car_parts import body_arms
from suspid.model.car_text import car_to_toml
from suspid.model.full_car import full_car
from suspid.model.half_car import half_car
from suspid.model.quarter_car import quarter_car
from suspid.model.sensor import MOTIONS, Sensor
from suspid.model.strut import Strut
from suspid.model.suspension import Suspension
from suspid.results import check_kind
from suspid.toml import as_number, as_table, check_keys, parsed_toml, refuse
from suspid.units import UNITS

EXTRAS = ("mounts", "friction", "curves", "sensors")  # tables that go with any description of the car
STRUT_KEYS = ("name", "stiffness", "damping", "arms")
PRESETS: Mapping[str, Callable[..., Suspension]] = {
    "quarter_car": quarter_car,
    "half_car": half_car,
    "full_car": full_car,
}


@explained
def read_car(path: str | os.PathLike[str]) -> Suspension:
    """Return the suspension that a TOML file describes.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or a table, key or value in it is wrong; the message
        names the file, the table and the key.

    Examples
    --------
    >>> read_car("examples/car.toml").coordinates
    ('seat', 'chassis', 'tire')
    """
    with naming(path):
        return car_from_toml(read_text(Path(path)))


@explained
def write_car(suspension: Suspension, path: str | os.PathLike[str]) -> None:
    """Write a suspension as TOML; the file is replaced only after everything is written.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "car.toml"
    ...     write_car(read_car("examples/car.toml"), path)
    ...     read_car(path) == read_car("examples/car.toml")
    True
    """
    check_kind(suspension, {"Suspension": "read_car or quarter_car"})
    with replacing(path) as draft:
        draft.write_text(car_to_toml(suspension), encoding="utf-8")


def car_from_toml(text: str) -> Suspension:
    """Return the suspension that a TOML text describes; the form is that of the module docstring.

    Raises
    ------
    InputError
        If the text is not TOML, or a table, key or value in it is wrong.

    Examples
    --------
    >>> car = car_from_toml('''
    ... [quarter_car]
    ... chassis_mass = 400
    ... tire_mass = 40
    ... chassis_stiffness = 20e3
    ... tire_stiffness = 200e3
    ... chassis_damping = 1500
    ... ''')
    >>> car.masses
    {'chassis': 400.0, 'tire': 40.0}
    """
    content = parsed_toml(text)
    check_keys("the file", content, ("constraints", "masses", "struts", *EXTRAS, *PRESETS))
    content.pop("constraints", None)
    mounts = as_table("[mounts]", content.pop("mounts", {}))
    friction = as_table("[friction]", content.pop("friction", {}))
    curves = as_table("[curves]", content.pop("curves", {}))
    sensors = as_table("[sensors]", content.pop("sensors", {}))
    return replace(
        _car(content).with_parameters(
            mount_stiffness={name: as_number("[mounts]", name, value, "N/m") for name, value in mounts.items()},
            friction={name: as_number("[friction]", name, value, "N") for name, value in friction.items()},
            curve={name: _curve(name, points) for name, points in curves.items()},
        ),
        sensors=[_sensor(f"[sensors] {name!r}", name, table) for name, table in sensors.items()],
    )


def _car(content: Mapping[str, object]) -> Suspension:
    short = next((name for name in PRESETS if name in content), None)
    if short:
        if len(content) > 1:
            others = ", ".join(f"[{name}]" for name in content if name != short)
            raise InputError(f"[{short}] describes the whole car; remove {others}, or [{short}]")
        return _preset(short, as_table(f"[{short}]", content[short]))
    for key, form in (("masses", "[masses]"), ("struts", "[[struts]]")):
        if key not in content:
            shorts = ", ".join(f"[{name}]" for name in PRESETS)
            raise InputError(
                f"there is no {form}; describe the car with [masses] and [[struts]], or with one of {shorts}"
            )
    masses = {name: as_number("[masses]", name, m, "kg") for name, m in as_table("[masses]", content["masses"]).items()}
    if not isinstance(content["struts"], list):
        raise InputError("[struts] must be a list of tables; write [[struts]] before each strut")
    struts = [_strut(f"[[struts]] number {k}", table) for k, table in enumerate(content["struts"], start=1)]
    return Suspension(masses=masses, struts=struts)


def read_constraints(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return the constraints on stiffness and damping in a car file, for `reconstruct`; they are parsed there.

    They stand at the top of the file: ``constraints = ["tire.stiffness >= 8 * chassis.stiffness"]``.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or ``constraints`` is not a list of texts.

    Examples
    --------
    >>> read_constraints("examples/car.toml")
    ()
    """
    with naming(path):
        found = parsed_toml(read_text(Path(path))).get("constraints", [])
        if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
            raise InputError(
                f"constraints = {reprlib.repr(found)} must be a list of texts, such as "
                f'["tire.stiffness >= 8 * chassis.stiffness"]'
            )
    return tuple(found)


def _preset(preset: str, given: Mapping[str, object]) -> Suspension:
    where, parameters = f"[{preset}]", inspect.signature(PRESETS[preset]).parameters
    check_keys(where, given, tuple(parameters))
    for name, parameter in parameters.items():
        if parameter.default is inspect.Parameter.empty and name not in given:
            raise InputError(f"{where}: {name} is missing")
    values: dict[str, object] = {}
    for name, value in given.items():
        unit = UNITS.get(name.rpartition("_")[2], "m")
        if isinstance(value, list) and preset == "full_car":  # full_car refuses a pair where it takes one value
            values[name] = tuple(as_number(where, name, side, unit) for side in value)
        else:
            values[name] = as_number(where, name, value, unit)
    try:
        return PRESETS[preset](**values)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _strut(where: str, given: object) -> Strut:
    table = as_table(where, given)
    name = table.get("name")
    if isinstance(name, str):
        where = f"[[struts]] {name!r}"
    check_keys(where, table, STRUT_KEYS)
    for key in STRUT_KEYS:
        if key not in table:
            raise InputError(f"{where}: {key} is missing")
    if not isinstance(name, str):
        raise InputError(f"{where}: name = {reprlib.repr(name)} must be text")
    arms = as_table(f"{where}: arms", table["arms"])
    return Strut(
        name=name,
        stiffness=as_number(where, "stiffness", table["stiffness"], "N/m"),
        damping=as_number(where, "damping", table["damping"], "N s/m"),
        arms={coordinate: as_number(f"{where}: arms", coordinate, arm, "1 or m") for coordinate, arm in arms.items()},
    )


def _curve(name: str, given: object) -> list[tuple[float, float]]:
    points = []
    for point in given if isinstance(given, list) else [given]:
        if not (isinstance(point, list) and len(point) == 2):
            refuse(f"[curves]: {name} = {reprlib.repr(given)} must be a list of pairs [velocity in m/s, force in N]")
        velocity = as_number("[curves]", name, point[0], "m/s")
        points.append((velocity, as_number("[curves]", name, point[1], "N")))
    return points


def _sensor(where: str, name: str, given: object) -> Sensor:
    table = as_table(where, given)
    check_keys(where, table, (*MOTIONS, "ahead", "left"))
    motions = [motion for motion in MOTIONS if motion in table]
    if len(motions) != 1:
        raise InputError(f"{where} must have one of {', '.join(MOTIONS)}, such as {{ acceleration = 'heave' }}")
    of = table[motions[0]]
    if "ahead" in table or "left" in table:
        if of != "heave" or motions[0] == "travel":
            raise InputError(f"{where}: ahead and left place a point on the body; they go with 'heave' alone")
        ahead, left = (as_number(where, key, table.get(key, 0.0), "m") for key in ("ahead", "left"))
        of = body_arms(ahead, left if "left" in table else None)
    elif isinstance(of, dict):
        of = {coordinate: as_number(where, coordinate, arm, "1 or m") for coordinate, arm in of.items()}
    elif not isinstance(of, str):
        raise InputError(f"{where}: {motions[0]} = {reprlib.repr(of)} must be a name, or a table of arms")
    return Sensor(name=name, motion=motions[0], of=of)
