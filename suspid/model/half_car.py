"""The half car: a body that heaves and pitches on two axles."""

from __future__ import annotations

from suspid.arguments import explained
from suspid.model.car_parts import KilogramSquareMetre, between, body_arms, seat_arguments, seated
from suspid.model.checks import distance, positive_number
from suspid.model.suspension import Suspension
from suspid.units import Kilogram, Metre, NewtonPerMetre, NewtonSecondPerMetre


@explained
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

    Pitch is positive nose down. All masses and rates describe the same part of the car: either the whole body with
    both wheels of each axle, or one side with half the body.

    Parameters
    ----------
    seat_mass, chassis_mass, front_tire_mass, rear_tire_mass : float
        Masses [kg] of the seat, the body, and the unsprung parts of each axle.
    pitch_inertia : float
        Moment of inertia of the body in pitch about its centre of gravity [kg m2].
    cg_to_front, cg_to_rear : float
        Distances of the axles from the centre of gravity of the body [m], both positive.
    seat_ahead : float
        Distance of the seat ahead of the centre of gravity [m]; negative behind it. Give all four seat arguments, or
        none for a car without a seat.
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
    seat = seat_arguments(
        {
            "seat_mass": seat_mass,
            "seat_stiffness": seat_stiffness,
            "seat_damping": seat_damping,
            "seat_ahead": seat_ahead,
        }
    )
    masses = {
        "heave": positive_number("chassis_mass", chassis_mass, "kg"),
        "pitch": positive_number("pitch_inertia", pitch_inertia, "kg m2"),
        "front": front_tire_mass,
        "rear": rear_tire_mass,
    }
    at_front = body_arms(distance("cg_to_front", cg_to_front))
    at_rear = body_arms(-distance("cg_to_rear", cg_to_rear))
    struts = [
        between("front", front_stiffness, front_damping, at_front, {"front": 1.0}),
        between("rear", rear_stiffness, rear_damping, at_rear, {"rear": 1.0}),
        between("front_tire", front_tire_stiffness, front_tire_damping, {"front": 1.0}, {"road_front": 1.0}),
        between("rear_tire", rear_tire_stiffness, rear_tire_damping, {"rear": 1.0}, {"road_rear": 1.0}),
    ]
    return seated(masses, struts, seat, body_arms(seat.get("seat_ahead", 0.0)))
