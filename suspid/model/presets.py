"""Cars by the usual names: a quarter, a half and a full car, with or without a seat.

Vertical motion about static equilibrium, for small angles, in the axes of ISO 8855: x forward, y to the left, z up,
with the origin at the body's centre of gravity. So heave is positive upward, pitch positive nose down, roll positive
left side up, and the body at (x, y) rises by ``heave - x pitch + y roll``. Wheels, seat and roads are positive upward.
Struts are vertical; their rates are those at the wheel. A strut's travel is positive in extension.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.model.suspension import Strut, Suspension, finite_number
from suspid.units import Kilogram, Metre, NewtonPerMetre, NewtonSecondPerMetre

KilogramSquareMetre: TypeAlias = Annotated[float, "kg m2"]
PerSide: TypeAlias = float | Sequence[float]  # one value for both sides, or (left, right)


def quarter_car(
    *,
    seat_mass: Kilogram | None = None,
    chassis_mass: Kilogram,
    tire_mass: Kilogram,
    seat_stiffness: NewtonPerMetre | None = None,
    chassis_stiffness: NewtonPerMetre,
    tire_stiffness: NewtonPerMetre,
    seat_damping: NewtonSecondPerMetre | None = None,
    chassis_damping: NewtonSecondPerMetre,
    tire_damping: NewtonSecondPerMetre = 0.0,
) -> Suspension:
    """Return the quarter car of Fig. 1: seat on chassis on tire on the road.

    Parameters
    ----------
    seat_mass, chassis_mass, tire_mass : float
        Masses [kg]. Without the three seat arguments: the 2-DOF quarter car.
    seat_stiffness, chassis_stiffness, tire_stiffness : float
        Spring rates between seat and chassis, chassis and tire, tire and road [N/m].
    seat_damping, chassis_damping, tire_damping : float
        Damper rates in the same places [N s/m].

    Returns
    -------
    Suspension
        Coordinates ``seat``, ``chassis``, ``tire``; struts of the same names; input ``road``.

    Raises
    ------
    InputError
        If only some of the seat arguments are given, or a value is refused.

    Examples
    --------
    The paper's car, Table 1, with ten times the printed damping:

    >>> car = quarter_car(seat_mass=200, chassis_mass=200, tire_mass=200,
    ...                   seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    ...                   seat_damping=300, chassis_damping=200, tire_damping=100)
    >>> car.coordinates
    ('seat', 'chassis', 'tire')
    """
    seat = _seat({"seat_mass": seat_mass, "seat_stiffness": seat_stiffness, "seat_damping": seat_damping})
    struts = [
        _between("chassis", chassis_stiffness, chassis_damping, {"chassis": 1.0}, {"tire": 1.0}),
        _between("tire", tire_stiffness, tire_damping, {"tire": 1.0}, {"road": 1.0}),
    ]
    return _seated({"chassis": chassis_mass, "tire": tire_mass}, struts, seat, {"chassis": 1.0})


def half_car(
    *,
    seat_mass: Kilogram | None = None,
    chassis_mass: Kilogram,
    pitch_inertia: KilogramSquareMetre,
    front_tire_mass: Kilogram,
    rear_tire_mass: Kilogram,
    cg_to_front: Metre,
    cg_to_rear: Metre,
    seat_ahead: Metre | None = None,
    seat_stiffness: NewtonPerMetre | None = None,
    front_stiffness: NewtonPerMetre,
    rear_stiffness: NewtonPerMetre,
    front_tire_stiffness: NewtonPerMetre,
    rear_tire_stiffness: NewtonPerMetre,
    seat_damping: NewtonSecondPerMetre | None = None,
    front_damping: NewtonSecondPerMetre,
    rear_damping: NewtonSecondPerMetre,
    front_tire_damping: NewtonSecondPerMetre = 0.0,
    rear_tire_damping: NewtonSecondPerMetre = 0.0,
) -> Suspension:
    """Return the half car: a body that heaves and pitches on two axles, 4 DOF, or 5 with a seat.

    Pitch is positive nose down. All masses and rates belong to one share of the car: the whole body with both wheels
    of each axle, or one side with half the body.

    Parameters
    ----------
    seat_mass, chassis_mass, front_tire_mass, rear_tire_mass : float
        Masses [kg] of seat, body, and wheels (what moves with the tire) of each axle.
    pitch_inertia : float
        Moment of inertia of the body in pitch about its centre of gravity [kg m2].
    cg_to_front, cg_to_rear : float
        Distances of the axles from the centre of gravity of the body [m], both positive.
    seat_ahead : float
        How far the seat stands ahead of the centre of gravity [m]; negative behind it. The four seat arguments come
        together; without them there is no seat.
    seat_stiffness, front_stiffness, rear_stiffness, front_tire_stiffness, rear_tire_stiffness : float
        Spring rates between seat and body, body and wheels (at the wheel), wheels and road [N/m].
    seat_damping, front_damping, rear_damping, front_tire_damping, rear_tire_damping : float
        Damper rates in the same places [N s/m].

    Returns
    -------
    Suspension
        Coordinates ``seat`` (if any), ``heave``, ``pitch``, ``front``, ``rear``; struts ``seat``, ``front``, ``rear``,
        ``front_tire``, ``rear_tire``; road inputs ``road_front``, ``road_rear``.

    Raises
    ------
    InputError
        If only some of the seat arguments are given, a distance is not positive, or a value is refused.

    Examples
    --------
    >>> car = half_car(chassis_mass=1200, pitch_inertia=1800, front_tire_mass=80, rear_tire_mass=80,
    ...                cg_to_front=1.2, cg_to_rear=1.5, front_stiffness=40e3, rear_stiffness=36e3,
    ...                front_tire_stiffness=400e3, rear_tire_stiffness=400e3,
    ...                front_damping=3000, rear_damping=2800)
    >>> car.coordinates
    ('heave', 'pitch', 'front', 'rear')
    >>> dict(car.struts[0].arms)
    {'heave': 1.0, 'pitch': -1.2, 'front': -1.0}
    """
    seat = _seat(
        {
            "seat_mass": seat_mass,
            "seat_stiffness": seat_stiffness,
            "seat_damping": seat_damping,
            "seat_ahead": seat_ahead,
        }
    )
    masses = {
        "heave": _positive("chassis_mass", chassis_mass, "kg"),
        "pitch": _positive("pitch_inertia", pitch_inertia, "kg m2"),
        "front": front_tire_mass,
        "rear": rear_tire_mass,
    }
    at_front = _body(_positive("cg_to_front", cg_to_front, "m"))
    at_rear = _body(-_positive("cg_to_rear", cg_to_rear, "m"))
    struts = [
        _between("front", front_stiffness, front_damping, at_front, {"front": 1.0}),
        _between("rear", rear_stiffness, rear_damping, at_rear, {"rear": 1.0}),
        _between("front_tire", front_tire_stiffness, front_tire_damping, {"front": 1.0}, {"road_front": 1.0}),
        _between("rear_tire", rear_tire_stiffness, rear_tire_damping, {"rear": 1.0}, {"road_rear": 1.0}),
    ]
    return _seated(masses, struts, seat, _body(seat.get("seat_ahead", 0.0)))


def full_car(
    *,
    seat_mass: Kilogram | None = None,
    chassis_mass: Kilogram,
    pitch_inertia: KilogramSquareMetre,
    roll_inertia: KilogramSquareMetre,
    front_tire_mass: PerSide,
    rear_tire_mass: PerSide,
    cg_to_front: Metre,
    cg_to_rear: Metre,
    front_track: Metre,
    rear_track: Metre,
    seat_ahead: Metre | None = None,
    seat_left: Metre | None = None,
    seat_stiffness: NewtonPerMetre | None = None,
    front_stiffness: PerSide,
    rear_stiffness: PerSide,
    front_tire_stiffness: PerSide,
    rear_tire_stiffness: PerSide,
    front_antiroll_stiffness: NewtonPerMetre | None = None,
    rear_antiroll_stiffness: NewtonPerMetre | None = None,
    seat_damping: NewtonSecondPerMetre | None = None,
    front_damping: PerSide,
    rear_damping: PerSide,
    front_tire_damping: PerSide = 0.0,
    rear_tire_damping: PerSide = 0.0,
) -> Suspension:
    """Return the full car: a body that heaves, pitches and rolls on four wheels, 7 DOF, or 8 with a seat.

    Pitch is positive nose down, roll positive left side up. What is said of a wheel, its strut or its tire is one value
    for both sides or a pair (left, right).

    Parameters
    ----------
    seat_mass, chassis_mass : float
        Masses of seat and body [kg].
    pitch_inertia, roll_inertia : float
        Moments of inertia of the body about its centre of gravity [kg m2].
    front_tire_mass, rear_tire_mass : float or (left, right)
        Mass of one wheel, with what moves with it [kg].
    cg_to_front, cg_to_rear : float
        Distances of the axles from the centre of gravity of the body [m], both positive.
    front_track, rear_track : float
        Distances between the left and the right wheel of each axle [m]; the centre of gravity lies midway.
    seat_ahead, seat_left : float
        How far the seat stands ahead and to the left of the centre of gravity [m]; negative behind, to the right. The
        five seat arguments come together; without them there is no seat.
    seat_stiffness : float
        Spring rate between seat and body [N/m].
    front_stiffness, rear_stiffness, front_tire_stiffness, rear_tire_stiffness : float or (left, right)
        Spring rates of one strut, at the wheel, and of one tire [N/m].
    front_antiroll_stiffness, rear_antiroll_stiffness : float, optional
        Force of the anti-roll bar at each wheel per difference of the travels of the two struts [N/m]; in roll the
        axle gains ``antiroll * track^2`` [N m/rad].
    seat_damping : float
        Damper rate between seat and body [N s/m].
    front_damping, rear_damping, front_tire_damping, rear_tire_damping : float or (left, right)
        Damper rates of one strut, at the wheel, and of one tire [N s/m].

    Returns
    -------
    Suspension
        Coordinates ``seat`` (if any), ``heave``, ``pitch``, ``roll``, ``front_left``, ``front_right``, ``rear_left``,
        ``rear_right``; struts ``seat``, ``front_left`` …, ``front_left_tire`` …, ``front_antiroll``, ``rear_antiroll``
        (those given); road inputs ``road_front_left`` ….

    Raises
    ------
    InputError
        If only some of the seat arguments are given, a length is not positive, or a value is refused.

    Examples
    --------
    >>> car = full_car(chassis_mass=1200, pitch_inertia=1800, roll_inertia=500, front_tire_mass=40, rear_tire_mass=40,
    ...                cg_to_front=1.2, cg_to_rear=1.5, front_track=1.5, rear_track=1.48,
    ...                front_stiffness=20e3, rear_stiffness=(18e3, 18.5e3), front_antiroll_stiffness=8e3,
    ...                front_tire_stiffness=200e3, rear_tire_stiffness=200e3, front_damping=1500, rear_damping=1400)
    >>> car.coordinates
    ('heave', 'pitch', 'roll', 'front_left', 'front_right', 'rear_left', 'rear_right')
    >>> dict(car.struts[0].arms)
    {'heave': 1.0, 'pitch': -1.2, 'roll': 0.75, 'front_left': -1.0}
    """
    seat = _seat(
        {
            "seat_mass": seat_mass,
            "seat_stiffness": seat_stiffness,
            "seat_damping": seat_damping,
            "seat_ahead": seat_ahead,
            "seat_left": seat_left,
        }
    )
    masses = {
        "heave": _positive("chassis_mass", chassis_mass, "kg"),
        "pitch": _positive("pitch_inertia", pitch_inertia, "kg m2"),
        "roll": _positive("roll_inertia", roll_inertia, "kg m2"),
        **_wheels("tire_mass", front_tire_mass, rear_tire_mass, "kg"),
    }
    stiffness = _wheels("stiffness", front_stiffness, rear_stiffness, "N/m")
    damping = _wheels("damping", front_damping, rear_damping, "N s/m")
    tire_stiffness = _wheels("tire_stiffness", front_tire_stiffness, rear_tire_stiffness, "N/m")
    tire_damping = _wheels("tire_damping", front_tire_damping, rear_tire_damping, "N s/m")
    front, rear = _positive("cg_to_front", cg_to_front, "m"), -_positive("cg_to_rear", cg_to_rear, "m")
    front_half, rear_half = _positive("front_track", front_track, "m") / 2, _positive("rear_track", rear_track, "m") / 2
    corners = {
        "front_left": _body(front, front_half),
        "front_right": _body(front, -front_half),
        "rear_left": _body(rear, rear_half),
        "rear_right": _body(rear, -rear_half),
    }
    struts = [_between(name, stiffness[name], damping[name], body, {name: 1.0}) for name, body in corners.items()]
    struts += [
        _between(f"{name}_tire", tire_stiffness[name], tire_damping[name], {name: 1.0}, {f"road_{name}": 1.0})
        for name in corners
    ]
    for axle, rate, track in (
        ("front", front_antiroll_stiffness, front_track),
        ("rear", rear_antiroll_stiffness, rear_track),
    ):
        if rate is not None:
            wheels = {f"{axle}_left": 1.0, f"{axle}_right": -1.0}
            struts.append(_between(f"{axle}_antiroll", rate, 0.0, {"roll": track}, wheels))
    return _seated(masses, struts, seat, _body(seat.get("seat_ahead", 0.0), seat.get("seat_left", 0.0)))


def _body(ahead: Metre, left: Metre | None = None) -> dict[str, float]:
    """Return the rise of the body at a point per unit of its coordinates; a half car has no left."""
    pitch = {"heave": 1.0, "pitch": 0.0 - ahead}
    return pitch if left is None else {**pitch, "roll": left}


def _between(
    name: str, stiffness: float, damping: float, upper: Mapping[str, float], lower: Mapping[str, float]
) -> Strut:
    """Return the strut whose elongation is the rise of its upper end less that of its lower one."""
    arms = {**upper, **{coordinate: 0.0 - arm for coordinate, arm in lower.items()}}
    return Strut(name=name, stiffness=stiffness, damping=damping, arms=arms)


def _seat(given: Mapping[str, float | None]) -> dict[str, float]:
    """Return the arguments of the seat: all of them, or none."""
    missing = [name for name, value in given.items() if value is None]
    if missing and len(missing) < len(given):
        raise InputError(
            f"a car with a seat needs {', '.join(missing)} as well; give all of {', '.join(given)}, or none of them"
        )
    units = {"seat_ahead": "m", "seat_left": "m"}
    return {
        name: finite_number(name, value, units[name]) if name in units else value
        for name, value in given.items()
        if value is not None
    }


def _seated(
    masses: Mapping[str, float], struts: Sequence[Strut], seat: Mapping[str, float], under: Mapping[str, float]
) -> Suspension:
    """Return the car with its seat, if there is one, on the point ``under`` it."""
    if not seat:
        return Suspension(masses=masses, struts=struts)
    strut = _between("seat", seat["seat_stiffness"], seat["seat_damping"], {"seat": 1.0}, under)
    return Suspension(masses={"seat": seat["seat_mass"], **masses}, struts=[strut, *struts])


def _wheels(what: str, front: PerSide, rear: PerSide, unit: str) -> dict[str, float]:
    """Return the value of each of the four wheels."""
    values: dict[str, float] = {}
    for axle, value in (("front", front), ("rear", rear)):
        name = f"{axle}_{what}"
        pair = value if isinstance(value, list | tuple | np.ndarray) else (value, value)
        if len(pair) != 2:
            raise InputError(f"{name} = {value!r}: give one value [{unit}] for both sides, or two, (left, right)")
        for side, one in zip(("left", "right"), pair, strict=True):
            values[f"{axle}_{side}"] = finite_number(name, one, unit)
    return values


def _positive(name: str, value: object, unit: str) -> float:
    number = finite_number(name, value, unit)
    if number <= 0:
        raise InputError(f"{name} = {number:g} {unit} must be positive")
    return number
