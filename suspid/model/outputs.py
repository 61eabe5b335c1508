"""Meaning of a channel name: a combination of coordinates and roads, and the order of its derivative."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.model.sensor import DERIVATIVES, ROAD_DERIVATIVES
from suspid.model.suspension import Suspension
from suspid.units import RealArray
from suspid.values import nearest_names

FORCE = "_force"
# Gyroscopes are called by the rate of an angle, as in pitch_rate.
COORDINATE_DERIVATIVES = {**DERIVATIVES, "rate": 1}


class OutputRows(NamedTuple):
    """Channels as derivatives of combinations: ``y = d^order/dt^order (coordinates @ q + roads @ r)``."""

    orders: NDArray[np.intp]  # (channel,): 0, 1 or 2
    coordinates: RealArray  # (channel, coordinate)
    roads: RealArray  # (channel, road)


def output_rows(suspension: Suspension, channels: Sequence[str]) -> OutputRows:
    """Return what channels measure, by their names.

    A name is that of a sensor of the suspension, or a coordinate (displacement), ``<coordinate>_velocity`` or
    ``_rate``, ``<coordinate>_acceleration``, ``<strut>_travel``, a road, ``<road>_rate`` or ``<road>_acceleration``.

    Raises
    ------
    InputError
        If a name means none of these.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> rows = output_rows(car, ["chassis_acceleration", "tire_travel"])
    >>> rows.orders.tolist(), rows.coordinates.tolist(), rows.roads.tolist()
    ([2, 0], [[1.0, 0.0], [0.0, 1.0]], [[0.0], [-1.0]])
    """
    rows = [output_weights(suspension, name) for name in channels]
    count = len(rows)
    return OutputRows(
        np.array([order for order, _, _ in rows], int),
        np.array([weights for _, weights, _ in rows]).reshape(count, len(suspension.coordinates)),
        np.array([roads for _, _, roads in rows]).reshape(count, len(suspension.roads)),
    )


def output_weights(suspension: Suspension, output: str) -> tuple[int, RealArray, RealArray]:
    """Return the order of derivative of an output, and its weights of coordinates and roads; see `output_rows`."""
    for sensor in suspension.sensors:
        if sensor.name == output:
            if isinstance(sensor.of, str):
                return 0, *_elongation(suspension, sensor.of)
            return DERIVATIVES.get(sensor.motion, 0), *_weights(suspension, sensor.of)
    names, struts = (*suspension.coordinates, *suspension.roads), [s.name for s in suspension.struts]
    if output in names:
        return 0, *_weights(suspension, {output: 1.0})
    stem, _, suffix = output.rpartition("_")
    kinds = ROAD_DERIVATIVES if stem in suspension.roads else COORDINATE_DERIVATIVES
    if suffix in kinds and stem in names:
        return kinds[suffix], *_weights(suspension, {stem: 1.0})
    if suffix == "travel" and stem in struts:
        return 0, *_elongation(suspension, stem)
    known = [*(s.name for s in suspension.sensors), *suspension.coordinates]
    known += [f"{c}_{d}" for c in suspension.coordinates for d in DERIVATIVES] + [f"{s}_travel" for s in struts]
    known += [*suspension.roads, *(f"{r}_{d}" for r in suspension.roads for d in ROAD_DERIVATIVES)]
    raise InputError(f"there is no output {output!r}.{nearest_names(output, known)}")


def force_weights(suspension: Suspension, force: str) -> RealArray:
    """Return the force on each coordinate per newton of a force, (coordinate,).

    A force is named by the displacement on which it does work, with or without ``_force`` at the end: a coordinate
    (``"chassis"``), a strut's travel (``"seat_travel"``, positive where it pushes the ends apart), or a sensor of
    displacement.

    Raises
    ------
    InputError
        If the name means no displacement of the suspension.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> force_weights(car, "chassis_travel_force").tolist()
    [1.0, -1.0]
    """
    name = force.removesuffix(FORCE)
    try:
        order, weights, _ = output_weights(suspension, name)
    except InputError:
        struts = [s.name for s in suspension.struts]
        pushes = [*suspension.coordinates, *(f"{strut}_travel" for strut in struts)]
        stem = name.removesuffix("_strut")
        hint = f" Forces between the ends of that strut: '{stem}_travel'." if stem in struts else ""
        raise InputError(
            f"force {force!r} pushes nothing of the car; a force is named by a mass, or by the travel of the strut "
            f"whose ends it pushes apart.{hint or nearest_names(name, pushes)}"
        ) from None
    if order or not np.any(weights):
        raise InputError(
            f"force {force!r}: {name!r} is not a displacement of a mass; name a coordinate, or the travel of a strut"
        )
    return weights


def names_channel(suspension: Suspension, name: str) -> bool:
    """Return whether a channel of that name measures a suspension, or is a road or a force of it.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> [names_channel(car, name) for name in ("chassis_force", "road", "tire_acceleration", "temperature")]
    [True, True, True, False]
    """
    for weights in (output_weights, force_weights):
        try:
            weights(suspension, name)
        except InputError:
            continue
        return True
    return name in suspension.roads


def _weights(suspension: Suspension, arms: Mapping[str, float]) -> tuple[RealArray, RealArray]:
    return (
        np.array([arms.get(c, 0.0) for c in suspension.coordinates]),
        np.array([arms.get(r, 0.0) for r in suspension.roads]),
    )


def _elongation(suspension: Suspension, name: str) -> tuple[RealArray, RealArray]:
    return _weights(suspension, next(s.arms for s in suspension.struts if s.name == name))
