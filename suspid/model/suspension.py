"""A suspension: masses connected by struts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from suspid.errors import InputError
from suspid.model.sensor import Sensor
from suspid.model.strut import Strut
from suspid.model.suspension_checks import (
    check_amplitude,
    check_coordinates,
    check_masses,
    check_plain,
    check_sensors,
    check_struts,
)
from suspid.units import Kilogram, MetrePerSecond, Newton, NewtonPerMetre, NewtonSecondPerMetre, RealArray
from suspid.values import FrozenMapping, nearest_names


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
        check_masses(self.masses)
        check_struts(self.struts)
        object.__setattr__(self, "masses", FrozenMapping(self.masses))
        object.__setattr__(self, "struts", tuple(self.struts))
        object.__setattr__(self, "sensors", tuple(self.sensors))
        derived = check_coordinates(self)
        check_sensors(self, derived)

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

        Raises
        ------
        InputError
            If the amplitude is not positive, or so small that friction holds a strut fast.

        Examples
        --------
        >>> from suspid import eigenmodes, quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500).with_parameters(friction={"chassis": 50})
        >>> eigenmodes(car.linearised(amplitude=0.2)).zeta.round(3)
        array([0.282, 0.316])
        """
        if self.linear:
            return self
        struts = [strut.linearised(amplitude) for strut in self.struts]
        if amplitude is not None:
            check_amplitude(self, amplitude)
        return replace(self, struts=struts)
