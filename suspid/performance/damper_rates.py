"""Damping and stiffness of a strut in an estimate, and at their nominal values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.greybox import Estimate
from suspid.model import Strut, Suspension
from suspid.performance.losses import Rates


def dampers_of(now: Estimate, earlier: Sequence[Estimate] = ()) -> list[Strut]:
    """Return the struts between masses whose damping was found in all estimates."""
    return [
        strut
        for strut in dampers_between(now.suspension)
        if all(f"{strut.name}.damping" in one.parameters for one in (now, *earlier))
    ]


def dampers_between(car: Suspension) -> list[Strut]:
    """Return the struts between masses: all but those of tires."""
    return [s for s in car.struts if not any(name in car.roads for name, arm in s.arms.items() if arm)]


def rates_of(found: Estimate, damper: str) -> Rates:
    """Return damping and stiffness of a strut, with their covariance; stiffness 0 where it was not found."""
    c, spring = found.parameters.index(f"{damper}.damping"), _spring_found(found, damper)
    if spring is None:
        covariance = np.diag([found.covariance[c, c], 0.0])
        return Rates(damping=float(found.values[c]), stiffness=0.0, covariance=covariance)
    k = found.parameters.index(f"{spring}.stiffness")
    return Rates(
        damping=float(found.values[c]),
        stiffness=float(found.values[k]),
        covariance=found.covariance[np.ix_([c, k], [c, k])],
    )


def nominal_rates(found: Estimate, damper: str) -> Rates:
    """Return the nominal damping and stiffness of a strut, the latter 0 where it was not found."""
    struts, spring = {strut.name: strut for strut in found.nominal.struts}, _spring_found(found, damper)
    stiffness = struts[spring].stiffness if spring else 0.0
    return Rates(damping=struts[damper].damping, stiffness=stiffness, covariance=np.zeros((2, 2)))


def parallel_spring(car: Suspension, damper: str) -> str | None:
    """Return the strut with a spring that acts along with a damper: its own, or one between the same points.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> parallel_spring(car, "chassis")
    'chassis'
    """
    return next((strut.name for strut in _beside(car, damper) if strut.stiffness > 0), None)


def _beside(car: Suspension, damper: str) -> list[Strut]:
    """Return the struts between the same points as a damper, its own first."""
    own = next(strut for strut in car.struts if strut.name == damper)
    return [own, *(strut for strut in car.struts if dict(strut.arms) == dict(own.arms))]


def _spring_found(found: Estimate, damper: str) -> str | None:
    """Return the strut whose spring was found and acts along with a damper."""
    values = dict(zip(found.parameters, found.values.tolist(), strict=True))
    near = (strut.name for strut in _beside(found.suspension, damper))
    return next((name for name in near if values.get(f"{name}.stiffness", 0.0) > 0), None)
