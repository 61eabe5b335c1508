"""The quarter car: tire, chassis and, if there is one, seat in a chain."""

from __future__ import annotations

from suspid.arguments import explained
from suspid.model.car_parts import between, seat_arguments, seated
from suspid.model.suspension import Suspension
from suspid.units import Kilogram, NewtonPerMetre, NewtonSecondPerMetre


@explained
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
    """Return the quarter car: seat on chassis on tire on the road.

    Parameters
    ----------
    seat_mass, chassis_mass, tire_mass : float
        Masses [kg]. Give all three seat arguments, or none for the quarter car with 2 DOF.
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
    seat = seat_arguments({"seat_mass": seat_mass, "seat_stiffness": seat_stiffness, "seat_damping": seat_damping})
    struts = [
        between("chassis", chassis_stiffness, chassis_damping, {"chassis": 1.0}, {"tire": 1.0}),
        between("tire", tire_stiffness, tire_damping, {"tire": 1.0}, {"road": 1.0}),
    ]
    return seated({"chassis": chassis_mass, "tire": tire_mass}, struts, seat, {"chassis": 1.0})
