"""Dynamic stiffness of struts, ``b = k + c s / (1 + rho s)``, with exact derivatives by their parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.model import Suspension
from suspid.units import ComplexArray, RealArray


def strut_slopes(
    car: Suspension, relaxation: RealArray, free: Sequence[str], s: ComplexArray, parameters: Sequence[str]
) -> tuple[ComplexArray, list[tuple[int, ComplexArray] | None]]:
    """Return the dynamic stiffness of each strut, (frequency, strut), and for each parameter its strut and derivative.

    ``free`` are the struts whose relaxation is a parameter of its own; on a mount of known stiffness it grows with the
    damping. A parameter that is none of a strut has None.
    """
    rates = s[:, None] / (1 + relaxation * s[:, None])
    c = np.array([strut.damping for strut in car.struts])
    b = np.array([strut.stiffness for strut in car.struts]) + c * rates
    index = {strut.name: i for i, strut in enumerate(car.struts)}
    slopes: list[tuple[int, ComplexArray] | None] = []
    for name in parameters:
        owner, _, quantity = name.rpartition(".")
        if owner not in index or quantity not in ("stiffness", "damping", "relaxation"):
            slopes.append(None)
            continue
        j = index[owner]
        if quantity == "stiffness":
            change = np.ones_like(s)
        elif quantity == "relaxation":
            change = -c[j] * rates[:, j] ** 2
        else:
            change = rates[:, j] if owner in free else s / (1 + relaxation[j] * s) ** 2
        slopes.append((j, change))
    return np.asarray(b), slopes
