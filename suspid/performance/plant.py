"""The plant of a state feedback: a car on white slopes with one actuator, and its outputs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from suspid.errors import InputError
from suspid.levels import EXACT
from suspid.model import FORCE, Suspension, statespace
from suspid.performance.ride import driven_road
from suspid.simulation import REFERENCE, Road
from suspid.units import RealArray
from suspid.values import is_size, nearest_names
from suspid.wording import Argument

# The name of the actuator's own force among objectives and limits.
ACTUATOR = "force"


def outputs_wanted(
    objective: Mapping[str, float], limits: Mapping[str, float], peaks: Mapping[str, float]
) -> tuple[tuple[str, ...], dict[str, tuple[float, float]]]:
    """Return all outputs, and of each its scale in the objective and its limit, 0 where it has none."""
    for what, given in (("objective", objective), ("limits", limits), ("peaks", peaks)):
        if not isinstance(given, Mapping):
            raise InputError(
                Argument(what, f"{given!r:.60}"),
                ' must map outputs to numbers, such as {"chassis_acceleration": 1.0, "force": 500.0}',
            )
    if not objective:
        raise InputError("objective is empty; name outputs, each with the value that counts as one")
    for name, value in [*objective.items(), *limits.items(), *peaks.items()]:
        if not isinstance(name, str):
            raise InputError(f"{name!r} is not the name of an output, such as 'chassis_acceleration'")
        if not is_size(value):
            raise InputError(f"{name!r} = {value!r} must be a positive number within the usual range")
    names = tuple(dict.fromkeys([*objective, *limits, *peaks]))
    return names, {name: (float(objective.get(name, 0.0)), float(limits.get(name, 0.0))) for name in names}


def slope_density(car: Suspension, road: Road | str | float, speed: float | None) -> tuple[float, Road]:
    """Return the two-sided density of the road's slope in time [m2/s2 s], of exponent 2, and the road."""
    if len(car.roads) != 1:
        raise InputError(f"the car has {len(car.roads)} roads; state feedback is computed for cars with one")
    driven = driven_road(car, road, speed)
    if driven.exponent != 2:
        raise InputError(
            f"the road has the exponent {driven.exponent:g}; state feedback needs white slopes, exponent 2"
        )
    return (2 * np.pi * REFERENCE) ** 2 * driven.roughness * driven.speed / 2, driven


def plant(
    car: Suspension, actuator: str, names: tuple[str, ...]
) -> tuple[RealArray, RealArray, RealArray, RealArray, RealArray, tuple[str, ...]]:
    """Return A, B, G of the car above its road, and C, D of outputs; displacements count from the road."""
    outputs = [name for name in names if name != ACTUATOR]
    known = [
        *car.coordinates,
        *(f"{c}_acceleration" for c in car.coordinates),
        *(f"{s.name}_travel" for s in car.struts),
    ]
    for name in outputs:
        if name in (*car.coordinates, *car.roads):
            raise InputError(f"output {name!r} grows without bound on white slopes.{nearest_names(name, known)}")
    system = statespace(car, outputs=outputs, forces=[actuator], roads=car.roads)
    A, C = np.asarray(system.A, float), np.asarray(system.C, float)
    inputs = list(system.input_labels)
    place = [
        inputs.index(name) for name in (car.roads[0], f"{car.roads[0]}_rate", f"{actuator.removesuffix(FORCE)}{FORCE}")
    ]
    B, D = np.asarray(system.B, float)[:, place], np.asarray(system.D, float)[:, place]
    if np.linalg.matrix_rank(car.K) < len(car.K):
        raise InputError("the springs do not support the car: state feedback needs a spring under every mass")
    if np.max(np.linalg.eigvals(A).real) > -EXACT * np.max(np.abs(A)) ** 0.5:
        raise InputError(
            "a mode has no damping: on a random road it grows without bound, so there is nothing to compare with; "
            "add damping to a strut that moves in it"
        )
    # On a road that is higher by 1 m the car at rest is higher by ``lift``: A lift + B_road = 0.
    lift = -np.linalg.solve(A, B[:, 0])
    infinite = [name for name, row in zip(outputs, D, strict=True) if row[1]]
    if infinite:
        raise InputError(f"output {infinite[0]!r} is infinite on white slopes: a damper on the road acts on it")
    rows = [C[outputs.index(name)] if name in outputs else np.zeros(len(A)) for name in names]
    direct = [D[outputs.index(name), 2] if name in outputs else 1.0 for name in names]
    return A, B[:, 2], B[:, 1] - lift, np.array(rows), np.array(direct), tuple(system.state_labels)
