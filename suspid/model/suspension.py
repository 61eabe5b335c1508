"""A suspension: masses connected by struts."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from suspid.errors import InputError
from suspid.model.checks import check_name, positive_number
from suspid.model.sensor import Sensor
from suspid.model.strut import Strut
from suspid.units import Kilogram, MetrePerSecond, Newton, NewtonPerMetre, NewtonSecondPerMetre, RealArray
from suspid.values import FrozenMapping, nearest_names
from suspid.wording import WayOut

# Suffixes of outputs that are time derivatives of a coordinate, with the order of the derivative.
DERIVATIVES = {"velocity": 1, "acceleration": 2}
# The same of a road, whose first derivative is an input named so.
ROAD_DERIVATIVES = {"rate": 1, "acceleration": 2}


@dataclass(frozen=True, kw_only=True, slots=True)
class Suspension:
    """Masses by coordinate, and the struts between them and the road.

    ``M q'' + C q' + K q = C_road r' + K_road r``, with q the coordinates in the order of
    ``masses`` and r the road inputs: Eq. (1)-(4) of the paper, for any topology.

    Parameters
    ----------
    masses : mapping of str to float
        Mass [kg], or moment of inertia [kg m2], by coordinate; positive.
    struts : sequence of Strut
        The struts. A coordinate that is used in an arm and is not in ``masses`` is a road input.
    sensors : sequence of Sensor
        Channels of records that are not named like an output of `statespace`.

    Raises
    ------
    InputError
        If a mass is not positive, a name is used twice or has two meanings, a mass has no strut, the name of a
        road input is probably a misspelt mass, or a sensor is of something that does not exist.

    Examples
    --------
    >>> car = Suspension(
    ...     masses={"body": 400.0, "wheel": 40.0},
    ...     struts=[
    ...         Strut(name="spring", stiffness=20e3, damping=1500.0, arms={"body": 1, "wheel": -1}),
    ...         Strut(name="tire", stiffness=200e3, damping=0.0, arms={"wheel": 1, "road": -1}),
    ...     ],
    ... )
    >>> car.K
    array([[ 20000., -20000.],
           [-20000., 220000.]])
    >>> car.roads
    ('road',)
    """

    masses: Mapping[str, Kilogram]
    struts: Sequence[Strut]
    sensors: Sequence[Sensor] = ()

    def __post_init__(self) -> None:
        _check_masses(self.masses)
        _check_struts(self.struts)
        object.__setattr__(self, "masses", FrozenMapping(self.masses))
        object.__setattr__(self, "struts", tuple(self.struts))
        object.__setattr__(self, "sensors", tuple(self.sensors))
        derived = _check_coordinates(self)
        _check_sensors(self, derived)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates, in the order of all matrices.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.coordinates
        ('chassis', 'tire')
        """
        return tuple(self.masses)

    @property
    def roads(self) -> tuple[str, ...]:
        """Names of the road inputs, in the order in which the struts name them.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.roads
        ('road',)
        """
        return tuple(dict.fromkeys(c for s in self.struts for c in s.arms if c not in self.masses))

    @property
    def M(self) -> RealArray:
        """Mass matrix [kg], (coordinate, coordinate).

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.M.tolist()
        [[400.0, 0.0], [0.0, 40.0]]
        """
        return np.diag(np.fromiter(self.masses.values(), dtype=float))

    @property
    def C(self) -> RealArray:
        """Damping matrix [N s/m], (coordinate, coordinate); refused where a damper is on a mount or not linear.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.C.tolist()
        [[1500.0, -1500.0], [-1500.0, 1500.0]]
        """
        check_plain(self, "a damping matrix")
        arms = self.arms(self.coordinates)
        return np.asarray(arms.T * [s.damping for s in self.struts] @ arms)

    @property
    def K(self) -> RealArray:
        """Stiffness matrix [N/m], (coordinate, coordinate).

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.K.tolist()
        [[20000.0, -20000.0], [-20000.0, 220000.0]]
        """
        arms = self.arms(self.coordinates)
        return np.asarray(arms.T * [s.stiffness for s in self.struts] @ arms)

    @property
    def C_road(self) -> RealArray:
        """Force on each coordinate per rate of each road input [N s/m], (coordinate, road).

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=60)
        >>> car.C_road.tolist()
        [[0.0], [60.0]]
        """
        check_plain(self, "a damping matrix")
        return np.asarray(-self.arms(self.coordinates).T * [s.damping for s in self.struts] @ self.arms(self.roads))

    @property
    def K_road(self) -> RealArray:
        """Force on each coordinate per displacement of each road input [N/m], (coordinate, road).

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=60)
        >>> car.K_road.tolist()
        [[0.0], [200000.0]]
        """
        return np.asarray(-self.arms(self.coordinates).T * [s.stiffness for s in self.struts] @ self.arms(self.roads))

    def arms(self, coordinates: Sequence[str]) -> RealArray:
        """Return the elongation of each strut per unit of each coordinate, (strut, coordinate).

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=60)
        >>> car.arms(car.coordinates).tolist()
        [[1.0, -1.0], [0.0, 1.0]]
        """
        rows = [[strut.arms.get(c, 0.0) for c in coordinates] for strut in self.struts]
        return np.array(rows, dtype=float).reshape(len(self.struts), len(coordinates))

    def with_parameters(
        self,
        *,
        stiffness: Mapping[str, NewtonPerMetre] | None = None,
        damping: Mapping[str, NewtonSecondPerMetre] | None = None,
        masses: Mapping[str, Kilogram] | None = None,
        mount_stiffness: Mapping[str, NewtonPerMetre] | None = None,
        friction: Mapping[str, Newton] | None = None,
        curve: Mapping[str, Any] | None = None,
    ) -> Suspension:
        """Return a copy with some parameters changed, by name of strut or of mass.

        The curve of a damper, points or None as in `Strut`, is kept if only ``damping`` is changed.

        Raises
        ------
        InputError
            If a name is unknown, or `Strut` or `Suspension` refuses a value.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.with_parameters(damping={"chassis": 900}).struts[0].damping
        900.0
        """
        masses, struts = masses or {}, [s.name for s in self.struts]
        quantities: dict[str, Mapping[str, Any]] = {
            "stiffness": stiffness or {},
            "damping": damping or {},
            "mount_stiffness": mount_stiffness or {},
            "friction": friction or {},
            "curve": curve or {},
        }
        by_strut = [name for given in quantities.values() for name in given]
        for kind, given, known in (("strut", by_strut, struts), ("mass", masses, self.coordinates)):
            for name in given:
                if name not in known:
                    raise InputError(f"there is no {kind} {name!r}.{nearest_names(name, known)}")
        return replace(
            self,
            masses={**self.masses, **masses},
            struts=tuple(
                replace(s, **{quantity: given[s.name] for quantity, given in quantities.items() if s.name in given})
                for s in self.struts
            ),
        )

    @property
    def linear(self) -> bool:
        """Whether no strut has friction or a curve.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500, tire_damping=60)
        >>> car.linear, car.with_parameters(friction={"chassis": 50}).linear
        (True, False)
        """
        return all(strut.linear for strut in self.struts)

    def linearised(self, amplitude: MetrePerSecond | None = None) -> Suspension:
        """Return the suspension with linear struts, each as `Strut.linearised` returns it.

        Parameters
        ----------
        amplitude : float, optional
            Amplitude of the dampers' velocities [m/s]. Default: their ``damping`` as stated.

        Examples
        --------
        >>> from suspid import eigenmodes, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500).with_parameters(friction={"chassis": 50})
        >>> eigenmodes(car.linearised(amplitude=0.2)).zeta.round(3)
        array([0.282, 0.316])
        """
        return self if self.linear else replace(self, struts=[s.linearised(amplitude) for s in self.struts])


def check_linear(suspension: Suspension, what: str) -> None:
    """Refuse a suspension with friction or curves where only linear struts are meant."""
    for strut in suspension.struts:
        if not strut.linear:
            has = "a curve" if strut.curve is not None else f"friction of {strut.friction:g} N"
            raise InputError(
                f"{what} needs linear struts, but strut {strut.name!r} has {has}; ",
                WayOut(
                    "use car.linearised(amplitude=…), with the dampers of equal work at that amplitude of velocity "
                    "[m/s], or car.linearised(), with damping as stated; free_decay and simulate take the car as it is",
                    "linearise",
                    "give {option}, the amplitude of velocity in m/s at which dampers of equal work replace it; "
                    "suspid simulate takes the car as it is",
                    "leave friction and curves out of the car file; suspid simulate takes the car as it is",
                ),
            )


def check_plain(suspension: Suspension, what: str) -> None:
    """Refuse a suspension with struts that are more than a linear spring and a viscous damper in parallel."""
    check_linear(suspension, what)
    mounted = [strut.name for strut in suspension.struts if strut.relaxation]
    if mounted:
        raise InputError(
            f"{what} needs struts of a spring and a damper in parallel, but the damper of strut {mounted[0]!r} is on a "
            f"mount; remove mount_stiffness, or use statespace, eigenmodes or estimate"
        )


def _check_masses(masses: Mapping[str, Kilogram]) -> None:
    if not isinstance(masses, Mapping):
        raise InputError(f"masses = {masses!r} must map coordinates to masses [kg], such as {{'seat': 80.0}}")
    if not masses:
        raise InputError("a suspension needs at least one mass; masses is empty")
    for coordinate, mass in masses.items():
        check_name("a mass", coordinate)
        positive_number(f"mass {coordinate!r}", mass, "kg")


def _check_struts(struts: Sequence[Strut]) -> None:
    for strut in struts:
        if not isinstance(strut, Strut):
            raise InputError(f"struts contains {strut!r}; every item must be a Strut")
    names = [strut.name for strut in struts]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"strut name {twice[0]!r} is used {names.count(twice[0])} times; names must be unique")


def _check_coordinates(suspension: Suspension) -> set[str]:
    """Refuse names with two meanings, probable misspellings and masses without a strut; return all names taken."""
    masses, roads, struts = suspension.masses, suspension.roads, suspension.struts
    derived = {f"{c}_{d}" for c in masses for d in DERIVATIVES} | {f"{strut.name}_travel" for strut in struts}
    derived |= {f"{road}_{d}" for road in roads for d in ROAD_DERIVATIVES}
    ambiguous = sorted(derived & {*masses, *roads})
    if ambiguous:
        raise InputError(f"coordinate {ambiguous[0]!r} has the name of an input or output; give it another name")
    for road in roads:
        intended = _probably_meant(road, suspension.coordinates)
        if intended:
            raise InputError(
                f"coordinate {road!r} is used in an arm but has no mass, and is close to {intended!r}: "
                f"correct the arm, or give the road input another name"
            )
    for coordinate, mass in masses.items():
        if not any(s.arms.get(coordinate) and (s.stiffness or s.damping or not s.linear) for s in struts):
            raise InputError(
                f"mass {coordinate!r} = {mass:g} kg is not connected: "
                f"no strut with stiffness or damping has an arm on it"
            )
    return derived | {*masses, *roads}


def _check_sensors(suspension: Suspension, taken: set[str]) -> None:
    """Refuse sensors of unknown coordinates or struts, and names with two meanings."""
    struts = [strut.name for strut in suspension.struts]
    coordinates = (*suspension.coordinates, *suspension.roads)
    names: list[str] = []
    for sensor in suspension.sensors:
        if not isinstance(sensor, Sensor):
            raise InputError(f"sensors contains {sensor!r}; every item must be a Sensor")
        if sensor.name in names:
            raise InputError(f"sensor name {sensor.name!r} is used twice; names must be unique")
        if sensor.name in taken:
            raise InputError(f"sensor {sensor.name!r} has the name of an input or output; give it another name")
        names.append(sensor.name)
        kind, known = ("strut", struts) if isinstance(sensor.of, str) else ("coordinate", coordinates)
        for name in [sensor.of] if isinstance(sensor.of, str) else sensor.of:
            if name not in known:
                raise InputError(f"sensor {sensor.name!r}: there is no {kind} {name!r}.{nearest_names(name, known)}")


def _probably_meant(road: str, coordinates: Sequence[str]) -> str | None:
    """Return the coordinate that ``road`` probably misspells; numbered names may differ in digits."""
    for coordinate in coordinates:
        # 0.85 catches a missing letter in names of four and a wrong one in names of seven, and passes front and rear.
        alike = difflib.SequenceMatcher(None, road.lower(), coordinate.lower()).ratio() >= 0.85
        if alike and re.sub(r"\d", "", road) != re.sub(r"\d", "", coordinate):
            return coordinate
    return None
