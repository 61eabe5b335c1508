"""State space of a suspension."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model.outputs import FORCE, OutputRows, force_weights, output_rows
from suspid.model.suspension import Suspension
from suspid.model.suspension_checks import check_linear
from suspid.results import check_kind
from suspid.units import RealArray
from suspid.values import nearest_names

if TYPE_CHECKING:
    import control


@explained
def statespace(
    suspension: Suspension,
    *,
    outputs: Sequence[str] | None = None,
    forces: Sequence[str] = (),
    roads: Sequence[str] | None = None,
    road_rate: bool = True,
) -> control.StateSpace:
    """Return the suspension as a `control.StateSpace`.

    Parameters
    ----------
    suspension : Suspension
        Masses and struts.
    outputs : sequence of str, optional
        A sensor of the suspension, a coordinate (``"seat"``, displacement [m]), its ``"seat_velocity"`` [m/s] or
        ``"seat_acceleration"`` [m/s2], ``"<strut>_travel"``, a strut's elongation [m], or a road.
        Default: the displacements of all coordinates.
    forces : sequence of str
        Inputs that are forces [N], named by the displacement on which they do work: a coordinate, or
        ``"<strut>_travel"`` for an actuator that pushes the ends of a strut apart. Their labels end in ``_force``.
    roads : sequence of str, optional
        Roads that are inputs; the others do not move. Default: all, or none if there are ``forces``, so that
        `control.lqr` takes no road for an actuator; ``roads=car.roads`` has both.
    road_rate : bool
        True: the paper's form, with inputs ``road`` and ``road_rate`` for each road (all roads first).
        False: the same physics with one input per road. The ``v_`` states are then the velocities minus
        ``M^-1 C_road road``, which removes the rate from the inputs.

    Returns
    -------
    control.StateSpace
        States ``z_<coordinate>`` …, then ``v_<coordinate>`` …, then ``d_<strut>``, the elongation [m] of each damper
        in series with a mount. Inputs: roads, their rates, forces.

    Raises
    ------
    InputError
        If an output or input is unknown or given twice, if an output is an acceleration of a road, or if
        ``road_rate=False`` and an output depends on the rate of a road input: the acceleration of a mass with a
        damper to the road.

    Notes
    -----
    Bode plots, pole maps and singular values are those of python-control. Height and rate of a road are not
    independent; with as many outputs as inputs python-control then finds no frequencies by itself and draws nothing:
    give ``omega_limits`` in rad/s. A map of poles and zeros needs one input and one output, as with
    ``road_rate=False``.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=50)
    >>> system = statespace(car, outputs=["chassis_acceleration", "chassis_travel"], forces=["chassis_travel"])
    >>> system.state_labels
    ['z_chassis', 'z_tire', 'v_chassis', 'v_tire']
    >>> system.input_labels
    ['chassis_travel_force']
    >>> statespace(car, forces=["chassis_travel"], roads=car.roads).input_labels
    ['road', 'road_rate', 'chassis_travel_force']

    >>> import control, numpy as np
    >>> response = control.frequency_response(statespace(car), omega_limits=(1, 300))  # bode_plot takes the same
    >>> bool(np.all(response.magnitude > 0))
    True
    >>> control.pole_zero_map(statespace(car, outputs=["chassis"], road_rate=False)).zeros.real.round(1)
    array([-4000. ,   -13.3])
    """
    check_kind(suspension, {"Suspension": "read_car or quarter_car"})
    import control

    check_linear(suspension, "statespace")
    names = _once("output", suspension.coordinates if outputs is None else outputs)
    acting = _once("force", [force.removesuffix(FORCE) for force in _several("force", forces)])
    used = _once("road", (() if acting else suspension.roads) if roads is None else roads)
    for road in used:
        if road not in suspension.roads:
            raise InputError(f"there is no road {road!r}.{nearest_names(road, suspension.roads)}")
    columns = [suspension.roads.index(road) for road in used]
    n, inverse_mass = len(suspension.coordinates), 1 / np.diag(suspension.M)[:, None]
    A, per_road, per_rate = _equations(suspension)
    per_road, per_rate = per_road[:, columns], per_rate[:, columns]
    pushed = np.array([force_weights(suspension, force) for force in acting]).reshape(len(acting), n).T
    per_force = np.zeros((len(A), len(acting)))
    per_force[n : 2 * n] = inverse_mass * pushed
    inputs = [*used, *(f"{road}_rate" for road in used)] if road_rate else list(used)
    # State in terms of that of the system and the inputs: velocities lose M^-1 C_road road without a rate.
    jump = np.zeros((len(A), len(inputs) + len(acting)))
    if road_rate:
        B = np.hstack([per_road, per_rate, per_force])
    else:
        jump[:, : len(used)] = per_rate
        B = np.hstack([per_road, per_force]) + A @ jump
    rows = output_rows(suspension, names)
    C, D = _observed(rows, A, B, jump)
    D = D + _seen_roads(rows.roads[:, columns], rows.orders, names, D.shape, road_rate=road_rate)
    hidden = np.any(rows.coordinates @ per_rate[n : 2 * n], axis=1) & (rows.orders == 2)
    if not road_rate and np.any(hidden):
        raise InputError(
            f"output {names[int(np.argmax(hidden))]!r} depends on the rate of a road input; use road_rate=True, "
            f"or choose a mass without a damper to the road"
        )
    return control.ss(
        A,
        B,
        C,
        D,
        states=[
            *(f"{kind}_{c}" for kind in ("z", "v") for c in suspension.coordinates),
            *(f"d_{strut.name}" for strut in suspension.struts if strut.relaxation),
        ],
        inputs=[*inputs, *(f"{force}{FORCE}" for force in acting)],
        outputs=list(names),
    )


def state_matrix(suspension: Suspension) -> RealArray:
    """Return A of Eq. (6), ``[[0, I], [-M^-1 K, -M^-1 C]]``, with one row more for each damper on a mount."""
    check_linear(suspension, "a state matrix")
    return _equations(suspension)[0]


def _equations(suspension: Suspension) -> tuple[RealArray, RealArray, RealArray]:
    """Return A and what a road and its rate add to the derivative of the state, (state, road).

    A damper c in series with a mount k_m carries ``k_m (e - d)``, with e the elongation of the strut and d its own,
    ``d' = (e - d) k_m / c``; so its force is c s / (1 + c / k_m s) times e, and no rate of a road acts through it.
    """
    struts, n = suspension.struts, len(suspension.coordinates)
    arms, road_arms = suspension.arms(suspension.coordinates), suspension.arms(suspension.roads)
    inverse_mass = 1 / np.diag(suspension.M)[:, None]
    mounted = [i for i, strut in enumerate(struts) if strut.relaxation]
    mount = np.array([strut.mount_stiffness if strut.relaxation else 0.0 for strut in struts])
    damping = np.array([0.0 if strut.relaxation else strut.damping for strut in struts])
    spring = np.array([strut.stiffness for strut in struts]) + mount
    rate = np.array([1 / struts[i].relaxation for i in mounted])[:, None]
    acceleration = -inverse_mass * arms.T
    still = np.zeros((n, n))
    A = np.block(
        [
            [still, np.eye(n), np.zeros((n, len(mounted)))],
            [(acceleration * spring) @ arms, (acceleration * damping) @ arms, -(acceleration * mount)[:, mounted]],
            [rate * arms[mounted], np.zeros((len(mounted), n)), -np.diag(rate[:, 0])],
        ]
    )
    nothing = np.zeros((n, road_arms.shape[1]))
    per_road = np.vstack([nothing, (acceleration * spring) @ road_arms, rate * road_arms[mounted]])
    per_rate = np.vstack([nothing, (acceleration * damping) @ road_arms, 0 * road_arms[mounted]])
    return A, per_road, per_rate


def _observed(rows: OutputRows, A: RealArray, B: RealArray, jump: RealArray) -> tuple[RealArray, RealArray]:
    """Return C and D of displacements (order 0), velocities (1) and accelerations (2) of the masses."""
    n = rows.coordinates.shape[1]
    eye = np.eye(len(A))
    state_part, input_part = (eye[:n], eye[n : 2 * n], A[n : 2 * n]), (jump[:n], jump[n : 2 * n], B[n : 2 * n])
    pairs = list(zip(rows.orders, rows.coordinates, strict=True))
    C = np.array([weights @ state_part[order] for order, weights in pairs]).reshape(len(pairs), len(A))
    D = np.array([weights @ input_part[order] for order, weights in pairs]).reshape(len(pairs), B.shape[1])
    return C, D


def _seen_roads(
    roads: RealArray, orders: NDArray[np.intp], names: Sequence[str], shape: tuple[int, ...], *, road_rate: bool
) -> RealArray:
    """Return the part of D by which outputs show the roads themselves."""
    seen, count = np.zeros(shape), roads.shape[1]
    for row, (order, name) in enumerate(zip(orders, names, strict=True)):
        if not np.any(roads[row]):
            continue
        if order > road_rate:
            what = "acceleration" if order == 2 else "rate"
            raise InputError(f"output {name!r} depends on the {what} of a road, which is no input of this form")
        seen[row, order * count : (order + 1) * count] = roads[row]
    return seen


def _several(what: str, names: Sequence[str]) -> Sequence[str]:
    if isinstance(names, str):
        raise InputError(f"{what}s={names!r} is one string; give a sequence of names: [{names!r}]")
    return names


def _once(what: str, names: Sequence[str]) -> list[str]:
    """Return the names as a list; refuse one string, and a name that stands twice."""
    given = list(_several(what, names))
    twice = [name for name in dict.fromkeys(given) if given.count(name) > 1]
    if twice:
        raise InputError(f"{what} {twice[0]!r} is given {given.count(twice[0])} times; names must be unique")
    return given
