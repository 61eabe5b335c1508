"""Default parameters and objectives of a tuning."""

from __future__ import annotations

from suspid.model import Suspension
from suspid.performance.contact import wheels_of
from suspid.reconstruction import QUANTITIES


def equal_groups(car: Suspension) -> list[list[str]]:
    """Return springs and dampers of the struts that are not on the road; left and right ones that are equal as one.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> equal_groups(car)
    [['chassis.stiffness'], ['chassis.damping']]
    """
    off = [s for s in car.struts if not any(s.arms.get(r) for r in car.roads)]
    wheels = wheels_of(car).names
    groups: dict[tuple[object, ...], list[str]] = {}
    for quantity in QUANTITIES:
        sides: dict[tuple[object, ...], float] = {}
        for s in off:
            value, roll = getattr(s, quantity), s.arms.get("roll", 0.0)
            # What a mirror leaves as it is.
            arms = sorted((c, abs(arm) if c == "roll" else arm) for c, arm in s.arms.items() if c not in wheels)
            key = (quantity, value, *arms)
            mirrored = key in groups and roll and sides[key] == -roll
            if value:
                sides.setdefault(key, roll)
                groups.setdefault(key if mirrored or key not in groups else (*key, s.name), []).append(
                    f"{s.name}.{quantity}"
                )
    return list(groups.values())


def comfort_and_load(car: Suspension) -> tuple[str, str]:
    """Return the weighted acceleration of the first coordinate that is no wheel, and the dynamic load of all wheels.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> comfort_and_load(quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                              chassis_damping=1300))
    ('chassis_acceleration.Wk', 'tire.load')
    """
    wheels = wheels_of(car).names
    felt = next(c for c in car.coordinates if c not in wheels)
    return f"{felt}_acceleration.Wk", " + ".join(f"{wheel}.load" for wheel in wheels)
