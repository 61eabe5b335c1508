"""State space of a suspension."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.model.suspension import DERIVATIVES, Suspension
from suspid.units import RealArray
from suspid.values import nearest_names

if TYPE_CHECKING:
    import control


def statespace(
    suspension: Suspension, *, outputs: Sequence[str] | None = None, road_rate: bool = True
) -> control.StateSpace:
    """Return the suspension as a `control.StateSpace`: Eq. (5)-(7).

    Parameters
    ----------
    suspension : Suspension
        Masses and struts.
    outputs : sequence of str, optional
        A coordinate (``"seat"``, displacement [m]), its ``"seat_velocity"`` [m/s] or
        ``"seat_acceleration"`` [m/s2], or ``"<strut>_travel"``, a strut's elongation [m].
        Default: the displacements of all coordinates.
    road_rate : bool
        True: the paper's form, with inputs ``road`` and ``road_rate`` for each road (all roads first).
        False: the same physics with one input per road. The ``v_`` states are then the velocities minus
        ``M^-1 C_road road``, which removes the rate from the inputs.

    Returns
    -------
    control.StateSpace
        States ``z_<coordinate>`` … then ``v_<coordinate>`` ….

    Raises
    ------
    InputError
        If an output is unknown or given twice, or if ``road_rate=False`` and an output depends on the rate of a road
        input: the acceleration of a mass with a damper to the road.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=50)
    >>> system = statespace(car, outputs=["chassis_acceleration", "chassis_travel"])
    >>> system.state_labels
    ['z_chassis', 'z_tire', 'v_chassis', 'v_tire']
    >>> system.input_labels
    ['road', 'road_rate']
    """
    import control

    if isinstance(outputs, str):
        raise InputError(f"{outputs=} is one string; give a sequence of names: [{outputs!r}]")
    n, roads = len(suspension.coordinates), suspension.roads
    inverse_mass = 1 / np.diag(suspension.M)
    per_road = inverse_mass[:, None] * suspension.K_road
    per_rate = inverse_mass[:, None] * suspension.C_road
    A = state_matrix(suspension)
    if road_rate:
        B = np.vstack([np.zeros((n, 2 * len(roads))), np.hstack([per_road, per_rate])])
        jump = np.zeros((2 * n, 2 * len(roads)))
        inputs = [*roads, *(f"{road}_rate" for road in roads)]
    else:
        jump = np.vstack([np.zeros_like(per_rate), per_rate])
        B = np.vstack([np.zeros_like(per_road), per_road]) + A @ jump
        inputs = list(roads)
    # Displacement (0), velocity (1) and acceleration (2) of every coordinate in terms of states and inputs.
    eye = np.eye(2 * n)
    state_part = {0: eye[:n], 1: eye[n:], 2: A[n:]}
    input_part = {0: jump[:n], 1: jump[n:], 2: B[n:]}
    names = list(suspension.coordinates if outputs is None else outputs)
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise InputError(f"output {twice[0]!r} is given {names.count(twice[0])} times; names must be unique")
    C, D = np.zeros((len(names), 2 * n)), np.zeros((len(names), len(inputs)))
    for row, name in enumerate(names):
        derivative, weights, road_weights = output_weights(suspension, name)
        if derivative == 2 and not road_rate and np.any(weights @ per_rate):
            raise InputError(
                f"output {name!r} depends on the rate of a road input; use road_rate=True, "
                f"or choose a mass without a damper to the road"
            )
        C[row] = weights @ state_part[derivative]
        D[row] = weights @ input_part[derivative]
        D[row, : len(roads)] += road_weights
    return control.ss(
        A,
        B,
        C,
        D,
        states=[f"{kind}_{c}" for kind in ("z", "v") for c in suspension.coordinates],
        inputs=inputs,
        outputs=names,
    )


def state_matrix(suspension: Suspension) -> RealArray:
    """Return A of Eq. (6): ``[[0, I], [-M^-1 K, -M^-1 C]]``."""
    n = len(suspension.coordinates)
    inverse_mass = 1 / np.diag(suspension.M)[:, None]
    return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse_mass * suspension.K, -inverse_mass * suspension.C]])


def output_weights(suspension: Suspension, output: str) -> tuple[int, RealArray, RealArray]:
    """Return the order of derivative of an output, and its weights of coordinates and roads."""
    stem, _, suffix = output.rpartition("_")
    coordinates, roads = suspension.coordinates, suspension.roads
    struts = [s.name for s in suspension.struts]
    unmoved = np.zeros(len(roads))
    if output in coordinates:
        return 0, np.eye(len(coordinates))[coordinates.index(output)], unmoved
    if suffix in DERIVATIVES and stem in coordinates:
        return DERIVATIVES[suffix], np.eye(len(coordinates))[coordinates.index(stem)], unmoved
    if suffix == "travel" and stem in struts:
        strut = struts.index(stem)
        return 0, suspension.arms(coordinates)[strut], suspension.arms(roads)[strut]
    known = [*coordinates, *(f"{c}_{d}" for c in coordinates for d in DERIVATIVES), *(f"{s}_travel" for s in struts)]
    raise InputError(f"there is no output {output!r}.{nearest_names(output, known)}")
