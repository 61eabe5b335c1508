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
from suspid.units import STANDARD_GRAVITY, ComplexArray, Hertz, RealArray, Second


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
            raise InputError(f"road {road!r} must hold one wheel, but its struts move {len(held)} coordinates")
        name = car.coordinates[held[0]]
        if not np.any((arms[:, held[0]] != 0) & ~np.any(road_arms != 0, axis=1)):
            raise InputError(f"wheel {name!r} carries nothing: no strut connects it to the car")
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


def static_loads(wheels: Wheels, parameters: Sequence[str] = ()) -> tuple[RealArray, RealArray]:
    """Return the static contact force of each wheel [N], (wheel,), and its derivatives, (parameter, wheel).

    Raises
    ------
    InputError
        If the springs do not hold the car, or it cannot be lifted as a whole without a strut being stretched.
    """
    car = wheels.car
    arms, road_arms = car.arms(car.coordinates), car.arms(car.roads)
    k = np.array([strut.stiffness for strut in car.struts])
    K = car.K
    if np.linalg.matrix_rank(K) < len(K):
        raise InputError("the springs do not hold the car: static loads need a spring under every mass")
    # The rise of each coordinate where all roads rise by 1 m: 1 of a displacement, 0 of pitch and roll.
    lift = np.linalg.lstsq(arms, -np.sum(road_arms, axis=1), rcond=None)[0]
    stretched = np.abs(arms @ lift + np.sum(road_arms, axis=1))
    # Elongation of a strut [m] under a lift of the whole car by 1 m up to which the lift counts as free: rounding of
    # arms.
    if np.max(stretched) > 1e-9:
        name = car.struts[int(np.argmax(stretched))].name
        raise InputError(
            f"static loads: strut {name!r} is stretched where the whole car is lifted, so its weight cannot be told; "
            f"check its arms, or give the loads"
        )
    weight = np.diag(car.M) * lift * STANDARD_GRAVITY
    by_road = -np.linalg.solve(K, arms.T @ (k[:, None] * road_arms))
    stretch, unit = -arms @ np.linalg.solve(K, weight), arms @ by_road + road_arms
    slopes = np.zeros((len(parameters), len(car.roads)))
    for row, name in enumerate(parameters):
        owner, _, quantity = name.rpartition(".")
        if quantity == "mass":
            i = car.coordinates.index(owner)
            slopes[row] = by_road[i] * lift[i] * STANDARD_GRAVITY
        for j, strut in enumerate(car.struts):
            if strut.name == owner and quantity == "stiffness":
                slopes[row] = unit[j] * stretch[j]
    return weight @ by_road, slopes
