"""Contact forces of the wheels: dynamic stiffness at the road and static loads, with exact derivatives.

A unit motion of a road elongates the struts by E, and the force it needs is ``G = sum_j B_j b_j E_j``, with B the arms
on the road and ``b = k + c s / (1 + rho s)``. Since all matrices are symmetric, ``dG/db_j = E_j^2`` and
``dG/dm_i = s^2 q_i^2``. A wheel's static load is that of the springs under gravity, each unstressed at one height.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import InputError
from suspid.model import Suspension
from suspid.performance.strut_slopes import strut_slopes
from suspid.units import STANDARD_GRAVITY, ComplexArray, Hertz, Newton, RealArray, Second


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Wheels:
    """Wheels that stand on roads, and the car above them; ``relaxation`` is that of each strut's damper [s]."""

    car: Suspension
    names: tuple[str, ...]
    relaxation: RealArray  # (strut,)
    free: tuple[str, ...]  # struts whose relaxation is a parameter of its own

    @property
    def index(self) -> list[int]:
        """Place of each wheel among the coordinates."""
        return [self.car.coordinates.index(name) for name in self.names]

    def resonances(self) -> tuple[Hertz, RealArray]:
        """Return the lowest natural frequency of the body and that of each wheel under a body held still [Hz]."""
        from scipy.linalg import eigh

        K, mass = self.car.K, np.diag(self.car.M)
        lowest = float(eigh(K, self.car.M, eigvals_only=True, subset_by_index=(0, 0))[0])
        wheel = np.array([K[i, i] / mass[i] for i in self.index])
        return float(np.sqrt(max(lowest, 0.0))) / (2 * np.pi), np.sqrt(wheel) / (2 * np.pi)


def resonance_slopes(wheels: Wheels, parameters: Sequence[str]) -> tuple[RealArray, RealArray]:
    """Return derivatives of `Wheels.resonances`, (parameter,) and (parameter, wheel); both know no dampers."""
    from scipy.linalg import eigh

    car = wheels.car
    (lowest, wheel), K, mass = wheels.resonances(), car.K, np.diag(car.M)
    square, shape = eigh(K, car.M, subset_by_index=(0, 0))
    arms, at = car.arms(car.coordinates), wheels.index
    names = [strut.name for strut in car.struts]
    by_body, by_wheel = np.zeros(len(parameters)), np.zeros((len(parameters), len(at)))
    for row, name in enumerate(parameters):
        owner, _, quantity = name.rpartition(".")
        if quantity == "stiffness":
            arm = arms[names.index(owner)]
            by_body[row] = float(arm @ shape[:, 0]) ** 2 / max(2 * float(square[0]), np.finfo(float).tiny) * lowest
            by_wheel[row] = arm[at] ** 2 / (2 * K[at, at]) * wheel
        elif quantity == "mass":
            i = car.coordinates.index(owner)
            by_body[row] = -(float(shape[i, 0]) ** 2) / 2 * lowest
            by_wheel[row] = np.where(np.array(at) == i, -wheel / (2 * mass[i]), 0.0)
    return by_body, by_wheel


def wheels_of(car: Suspension, relaxations: Mapping[str, Second] | None = None) -> Wheels:
    """Return the wheels of a car: the coordinate that the struts on each road hold, in the order of the roads.

    Raises
    ------
    InputError
        If the car has no road, a road holds none or several coordinates, a wheel stands on several roads or carries
        nothing.
    """
    if not car.roads:
        raise InputError("the car stands on no road: no strut has an arm on anything but masses")
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    names = []
    for column, road in zip(road_arms.T, car.roads, strict=True):
        held = np.flatnonzero(np.any(arms[column != 0] != 0, axis=0))
        if len(held) != 1:
            raise InputError(f"road {road!r} must carry one wheel, but its struts move {len(held)} coordinates")
        name = car.coordinates[held[0]]
        if not np.any((arms[:, held[0]] != 0) & ~np.any(road_arms != 0, axis=1)):
            raise InputError(f"wheel {name!r} carries no load: no strut connects it to the car")
        if name in names:
            raise InputError(f"wheel {name!r} stands on two roads; describe one road for each wheel")
        names.append(name)
    given = relaxations or {}
    relaxation = np.array([given.get(strut.name, strut.relaxation) for strut in car.struts])
    return Wheels(car=car, names=tuple(names), relaxation=relaxation, free=tuple(given))


def contact(wheels: Wheels, hertz: RealArray, parameters: Sequence[str] = ()) -> tuple[ComplexArray, ComplexArray]:
    """Return the force of each wheel's road per unit of its motion [N/m], (wheel, frequency), and its derivatives.

    The other roads stand still. The derivatives, (parameter, wheel, frequency), are by stiffness, damping, relaxation
    or mass, by name; those by parameters of channels are zero.
    """
    car = wheels.car
    s: ComplexArray = 2j * np.pi * np.asarray(hertz, np.complex128)
    b, by_strut = strut_slopes(car, wheels.relaxation, wheels.free, s, parameters)
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    D = np.einsum("ji,fj,jk->fik", arms, b, arms) + (s**2)[:, None, None] * car.M
    q = -np.linalg.solve(D, np.einsum("ji,fj,jr->fir", arms, b, road_arms))
    E = arms @ q + road_arms
    G = np.einsum("jr,fj,fjr->rf", road_arms, b, E)
    slopes = np.zeros((len(parameters), *G.shape), np.complex128)
    for row, (name, strut) in enumerate(zip(parameters, by_strut, strict=True)):
        owner, _, quantity = name.rpartition(".")
        if quantity == "mass":
            slopes[row] = (s[:, None] ** 2 * q[:, car.coordinates.index(owner)] ** 2).T
        elif strut is not None:
            j, change = strut
            slopes[row] = (change[:, None] * E[:, j] ** 2).T
    return G, slopes


def contact_by_hertz(wheels: Wheels, hertz: Hertz) -> ComplexArray:
    """Return the derivative of each wheel's dynamic stiffness by the frequency [N/m/Hz], (wheel,).

    ``dG/ds = sum_j E_j^2 db_j/ds + sum_i 2 s m_i q_i^2``, with ``db/ds = c / (1 + rho s)^2``.
    """
    car, s = wheels.car, 2j * np.pi * hertz
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    c = np.array([strut.damping for strut in car.struts])
    by_s = c / (1 + wheels.relaxation * s) ** 2
    b = np.array([strut.stiffness for strut in car.struts]) + c * s / (1 + wheels.relaxation * s)
    q = -np.linalg.solve((arms.T * b) @ arms + s**2 * car.M, (arms.T * b) @ road_arms)
    E = arms @ q + road_arms
    return np.asarray(2j * np.pi * (by_s @ E**2 + 2 * s * np.diag(car.M) @ q**2))


def static_loads(wheels: Wheels, parameters: Sequence[str] = ()) -> tuple[RealArray, RealArray]:
    """Return the static contact force of each wheel [N], (wheel,), and its derivatives, (parameter, wheel).

    Raises
    ------
    InputError
        If the springs do not hold the car, or it cannot be lifted as a whole without a strut being stretched.
    """
    car, lift = wheels.car, lift_of(wheels)
    arms, road_arms, k = car.arms(car.coordinates), car.arms(car.roads), _springs(car)
    by_road = -np.linalg.solve(car.K, arms.T @ (k[:, None] * road_arms))
    stretch, unit = _stretch(wheels, lift), arms @ by_road + road_arms
    slopes = np.zeros((len(parameters), len(car.roads)))
    for row, name in enumerate(parameters):
        owner, _, quantity = name.rpartition(".")
        if quantity == "mass":
            i = car.coordinates.index(owner)
            slopes[row] = by_road[i] * lift[i] * STANDARD_GRAVITY
        for j, strut in enumerate(car.struts):
            if strut.name == owner and quantity == "stiffness":
                slopes[row] = unit[j] * stretch[j]
    return _weight(car, lift) @ by_road, slopes


def carried_loads(wheels: Wheels, parameters: Sequence[str] = ()) -> tuple[RealArray, RealArray]:
    """Return `static_loads` of a car that stands on all of its wheels.

    Raises
    ------
    InputError
        As `static_loads`, or if a wheel carries nothing.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3,
    ...                   chassis_damping=1500)
    >>> carried_loads(wheels_of(car))[0].round(1).tolist()
    [4314.9]
    """
    load, slopes = static_loads(wheels, parameters)
    for name, own in zip(wheels.names, load.tolist(), strict=True):
        check_carried(name, own)
    return load, slopes


def check_carried(wheel: str, load: Newton) -> None:
    """Refuse a wheel on which nothing rests."""
    if load <= 0:
        raise InputError(f"wheel {wheel!r} carries {load:.0f} N: the car as described stands on fewer wheels")


def static_stretch(wheels: Wheels) -> tuple[RealArray, RealArray]:
    """Return the force of each strut's spring [N] and how far the weight stretches the strut [m], (strut,).

    Raises
    ------
    InputError
        As `static_loads`.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3,
    ...                   chassis_damping=1500)
    >>> force, stretch = static_stretch(wheels_of(car))
    >>> force.round(1).tolist(), stretch.round(4).tolist()
    ([-3922.7, -4314.9], [-0.1961, -0.0216])
    """
    stretch = _stretch(wheels, lift_of(wheels))
    return _springs(wheels.car) * stretch, stretch


def _springs(car: Suspension) -> RealArray:
    return np.array([strut.stiffness for strut in car.struts])


def _weight(car: Suspension, lift: RealArray) -> RealArray:
    return np.asarray(np.diag(car.M) * lift * STANDARD_GRAVITY)


def _stretch(wheels: Wheels, lift: RealArray) -> RealArray:
    car = wheels.car
    return np.asarray(-car.arms(car.coordinates) @ np.linalg.solve(car.K, _weight(car, lift)))


def lift_of(wheels: Wheels) -> RealArray:
    """Return the rise of each coordinate where all roads rise by 1 m: 1 of a displacement, 0 of pitch and roll.

    Raises
    ------
    InputError
        As `static_loads`.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3,
    ...                   chassis_damping=1500)
    >>> lift_of(wheels_of(car)).round(6).tolist()
    [1.0, 1.0]
    """
    car = wheels.car
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    if np.linalg.matrix_rank(car.K) < len(car.K):
        raise InputError("the springs do not support the car: static loads need a spring under every mass")
    lift = np.linalg.lstsq(arms, -np.sum(road_arms, axis=1), rcond=None)[0]
    stretched = np.abs(arms @ lift + np.sum(road_arms, axis=1))
    # Elongation of a strut [m] under a lift of the whole car by 1 m up to which the lift counts as free: rounding of
    # arms.
    if np.max(stretched) > 1e-9:
        name = car.struts[int(np.argmax(stretched))].name
        raise InputError(
            f"static loads: strut {name!r} is stretched where the whole car is lifted, so its load cannot be "
            f"computed; check its arms, or give the loads"
        )
    return np.asarray(lift)
