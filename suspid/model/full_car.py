"""The full car: a body that heaves, pitches and rolls on four wheels."""

from __future__ import annotations

from suspid.arguments import explained
from suspid.model.car_parts import (
    KilogramSquareMetre,
    PerSide,
    between,
    body_arms,
    by_wheel,
    seat_arguments,
    seated,
)
from suspid.model.checks import distance, positive_number
from suspid.model.suspension import Suspension
from suspid.units import Kilogram, Metre, NewtonPerMetre, NewtonSecondPerMetre


@explained
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

    Pitch is positive nose down, roll positive left side up. A value of a wheel, its strut or its tire is one number for
    both sides or a pair (left, right).

    Parameters
    ----------
    seat_mass, chassis_mass : float
        Masses of seat and body [kg].
    pitch_inertia, roll_inertia : float
        Moments of inertia of the body about its centre of gravity [kg m2].
    front_tire_mass, rear_tire_mass : float or (left, right)
        Unsprung mass of one wheel [kg].
    cg_to_front, cg_to_rear : float
        Distances of the axles from the centre of gravity of the body [m], both positive.
    front_track, rear_track : float
        Distances between the left and the right wheel of each axle [m]; the centre of gravity lies midway.
    seat_ahead, seat_left : float
        Distances of the seat ahead of the centre of gravity and to its left [m]; negative behind it and to its right.
        Give all five seat arguments, or none for a car without a seat.
    seat_stiffness : float
        Spring rate between seat and body [N/m].
    front_stiffness, rear_stiffness, front_tire_stiffness, rear_tire_stiffness : float or (left, right)
        Spring rates of one strut, at the wheel, and of one tire [N/m].
    front_antiroll_stiffness, rear_antiroll_stiffness : float, optional
        Force of the anti-roll bar at each wheel per difference of the travels of the two struts [N/m]. It adds
        ``antiroll * track^2`` [N m/rad] to the roll stiffness of the axle.
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
    seat = seat_arguments(
        {
            "seat_mass": seat_mass,
            "seat_stiffness": seat_stiffness,
            "seat_damping": seat_damping,
            "seat_ahead": seat_ahead,
            "seat_left": seat_left,
        }
    )
    masses = {
        "heave": positive_number("chassis_mass", chassis_mass, "kg"),
        "pitch": positive_number("pitch_inertia", pitch_inertia, "kg m2"),
        "roll": positive_number("roll_inertia", roll_inertia, "kg m2"),
        **by_wheel("tire_mass", front_tire_mass, rear_tire_mass, "kg"),
    }
    stiffness = by_wheel("stiffness", front_stiffness, rear_stiffness, "N/m")
    damping = by_wheel("damping", front_damping, rear_damping, "N s/m")
    tire_stiffness = by_wheel("tire_stiffness", front_tire_stiffness, rear_tire_stiffness, "N/m")
    tire_damping = by_wheel("tire_damping", front_tire_damping, rear_tire_damping, "N s/m")
    front, rear = distance("cg_to_front", cg_to_front), -distance("cg_to_rear", cg_to_rear)
    front_half = distance("front_track", front_track) / 2
    rear_half = distance("rear_track", rear_track) / 2
    corners = {
        "front_left": body_arms(front, front_half),
        "front_right": body_arms(front, -front_half),
        "rear_left": body_arms(rear, rear_half),
        "rear_right": body_arms(rear, -rear_half),
    }
    struts = [between(name, stiffness[name], damping[name], body, {name: 1.0}) for name, body in corners.items()]
    struts += [
        between(f"{name}_tire", tire_stiffness[name], tire_damping[name], {name: 1.0}, {f"road_{name}": 1.0})
        for name in corners
    ]
    for axle, rate, track in (
        ("front", front_antiroll_stiffness, front_track),
        ("rear", rear_antiroll_stiffness, rear_track),
    ):
        if rate is not None:
            wheels = {f"{axle}_left": 1.0, f"{axle}_right": -1.0}
            struts.append(between(f"{axle}_antiroll", rate, 0.0, {"roll": track}, wheels))
    return seated(masses, struts, seat, body_arms(seat.get("seat_ahead", 0.0), seat.get("seat_left", 0.0)))
