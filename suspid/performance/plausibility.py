"""Doubts about a car whose numbers no vehicle has: static deflection of springs, damping of modes, weighed loads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension, eigenmodes
from suspid.performance.contact import static_stretch, wheels_of
from suspid.units import Newton
from suspid.words import Check, Level, Number, Remark
from suspid.words.plausibility import PlausibilityCheck

# Static deflections of a spring that carries weight [m]. Solid rubber tires and benches give a tenth of a millimetre,
# which is a natural frequency of 50 Hz; more than two metres no vehicle has room for, 0.35 Hz. Units that are off by
# 1000 move ordinary ones, 10 to 300 mm, beyond these.
LEAST_DEFLECTION, MOST_DEFLECTION = 1e-4, 2.0
# Damping ratio of the best damped mode below which not even rubber and joints are in it.
LEAST_ZETA = 2e-3
# Share of the largest load from which on a spring counts as one that carries: antiroll bars carry hardly anything.
CARRIES = 0.05
# A scale and a list of masses agree better than this; beyond, one of them is in another unit or of another car.
MOST_LOAD_RATIO = 3.0


def plausible(car: Suspension) -> Iterator[Check]:
    """Yield what no vehicle has: springs that are compressed by far too much or too little, and hardly any damping.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> in_tonnes = quarter_car(chassis_mass=0.4, tire_mass=0.04, chassis_stiffness=20e3, tire_stiffness=200e3,
    ...                         chassis_damping=1500)
    >>> [check.remark.numbers["part"] for check in plausible(in_tonnes)]
    ['tire']
    """
    try:
        force, stretch = (np.abs(part) for part in static_stretch(wheels_of(car)))
    except (InputError, np.linalg.LinAlgError):
        # What stands on no wheels, or on no springs, is refused where it matters.
        force, stretch = np.zeros(len(car.struts)), np.zeros(len(car.struts))
    for i in np.flatnonzero(force > CARRIES * np.max(force)).tolist():
        numbers: dict[str, Number] = {
            "part": car.struts[i].name, "load": float(force[i]), "metres": float(stretch[i]),
        }  # fmt: skip
        if stretch[i] > MOST_DEFLECTION:
            yield _doubt(PlausibilityCheck.SINKS, {**numbers, "limit": MOST_DEFLECTION})
        elif stretch[i] < LEAST_DEFLECTION:
            yield _doubt(PlausibilityCheck.RIGID, {**numbers, "limit": LEAST_DEFLECTION})
    if any(strut.damping for strut in car.struts):
        zeta = float(np.max(eigenmodes(car.linearised()).zeta))
        if zeta < LEAST_ZETA:
            yield _doubt(PlausibilityCheck.UNDAMPED, {"zeta": zeta, "limit": LEAST_ZETA})


def plausible_loads(own: Mapping[str, Newton], given: Mapping[str, Newton]) -> Iterator[Check]:
    """Yield weighed loads that are far from those of the masses."""
    for wheel, load in given.items():
        factor = load / own[wheel]
        if not 1 / MOST_LOAD_RATIO <= factor <= MOST_LOAD_RATIO:
            numbers: dict[str, Number] = {"wheel": wheel, "given": load, "load": own[wheel], "factor": factor}
            yield _doubt(PlausibilityCheck.LOAD, numbers)


def _doubt(code: PlausibilityCheck, numbers: Mapping[str, Number]) -> Check:
    return Check(Remark(code, numbers), Level.DOUBTFUL)
