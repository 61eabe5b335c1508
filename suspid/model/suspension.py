"""Masses tied by struts: the suspension, and the state space of it."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.units import Kilogram, NewtonPerMetre, NewtonSecondPerMetre, RealArray
from suspid.values import FrozenMapping, nearest_names

if TYPE_CHECKING:
    import control

DERIVATIVES = {"velocity": 1, "acceleration": 2}


@dataclass(frozen=True, kw_only=True, slots=True)
class Strut:
    """A linear spring and a viscous damper in parallel.

    The elongation is ``sum(arm * coordinate)``. A strut between two masses that move along one
    line has arms 1 and -1; lever arms in metres bring in pitch and roll.

    Parameters
    ----------
    name : str
        Name of the strut.
    stiffness : float
        Spring rate [N/m], not negative.
    damping : float
        Damper rate [N s/m], not negative.
    arms : mapping of str to float
        Elongation per unit of each coordinate, by coordinate [1 or m/rad].

    Raises
    ------
    InputError
        If a rate is negative or not finite, or if there is no arm that is not zero.

    Examples
    --------
    >>> Strut(name="seat", stiffness=16e3, damping=500.0, arms={"seat": 1.0, "chassis": -1.0}).stiffness
    16000.0
    """

    name: str
    stiffness: NewtonPerMetre
    damping: NewtonSecondPerMetre
    arms: Mapping[str, float]

    def __post_init__(self) -> None:
        _check_name("a strut", self.name)
        for quantity, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
            value = finite_number(f"strut {self.name!r}: {quantity}", getattr(self, quantity), unit)
            if value < 0:
                raise InputError(f"strut {self.name!r}: {quantity} = {value:g} {unit} is negative; it must be >= 0")
            object.__setattr__(self, quantity, value)
        if not isinstance(self.arms, Mapping):
            raise InputError(
                f"strut {self.name!r}: arms = {self.arms!r} must map coordinates to arms, as {{'seat': 1.0}}"
            )
        for coordinate, arm in self.arms.items():
            _check_name(f"strut {self.name!r}: a coordinate", coordinate)
            finite_number(f"strut {self.name!r}: arm {coordinate!r}", arm, "1 or m")
        if not any(self.arms.values()):
            raise InputError(f"strut {self.name!r} has no arm that is not zero; it ties nothing")
        object.__setattr__(self, "arms", FrozenMapping(self.arms))


@dataclass(frozen=True, kw_only=True, slots=True)
class Suspension:
    """Masses by coordinate and the struts between them and the road.

    ``M q'' + C q' + K q = C_road r' + K_road r``, with q the coordinates in the order of
    ``masses`` and r the road inputs: Eq. (1)-(4) of the paper, for any topology.

    Parameters
    ----------
    masses : mapping of str to float
        Mass [kg], or moment of inertia [kg m2], by coordinate; positive.
    struts : sequence of Strut
        The struts. A coordinate that stands in an arm but not in ``masses`` is a road input.

    Raises
    ------
    InputError
        If a mass is not positive, a name stands twice or could mean two things, a mass is tied
        to nothing, or the name of a road input is so close to that of a mass that it must be a slip.

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

    def __post_init__(self) -> None:
        if not isinstance(self.masses, Mapping):
            raise InputError(f"masses = {self.masses!r} must map coordinates to masses [kg], as {{'seat': 80.0}}")
        if not self.masses:
            raise InputError("a suspension needs at least one mass; masses is empty")
        for coordinate, mass in self.masses.items():
            _check_name("a mass", coordinate)
            value = finite_number(f"mass {coordinate!r}", mass, "kg")
            if value <= 0:
                raise InputError(f"mass {coordinate!r} = {value:g} kg must be positive")
        for strut in self.struts:
            if not isinstance(strut, Strut):
                raise InputError(f"struts holds {strut!r}; every one of them must be a Strut")
        names = [strut.name for strut in self.struts]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise InputError(f"strut name {twice[0]!r} stands {names.count(twice[0])} times; names must differ")
        object.__setattr__(self, "masses", FrozenMapping(self.masses))
        object.__setattr__(self, "struts", tuple(self.struts))
        derived = {f"{c}_{d}" for c in self.masses for d in DERIVATIVES} | {f"{name}_travel" for name in names}
        derived |= {f"{road}_rate" for road in self.roads}
        ambiguous = sorted(derived & {*self.masses, *self.roads})
        if ambiguous:
            raise InputError(f"coordinate {ambiguous[0]!r} has the name of an input or output; give it another name")
        for road in self.roads:
            slip = _probable_slip(road, self.coordinates)
            if slip:
                raise InputError(
                    f"coordinate {road!r} stands in an arm but has no mass, and is close to {slip!r}: "
                    f"correct the arm, or give the road input another name"
                )
        for coordinate in self.masses:
            if not any(s.arms.get(coordinate) and (s.stiffness or s.damping) for s in self.struts):
                raise InputError(
                    f"mass {coordinate!r} = {self.masses[coordinate]:g} kg is tied to nothing: "
                    f"no strut with stiffness or damping has an arm on it"
                )

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates, in the order of all matrices."""
        return tuple(self.masses)

    @property
    def roads(self) -> tuple[str, ...]:
        """Names of the road inputs, in the order in which the struts name them."""
        return tuple(dict.fromkeys(c for s in self.struts for c in s.arms if c not in self.masses))

    @property
    def M(self) -> RealArray:
        """Mass matrix [kg], (coordinate, coordinate)."""
        return np.diag(np.fromiter(self.masses.values(), dtype=float))

    @property
    def C(self) -> RealArray:
        """Damping matrix [N s/m], (coordinate, coordinate)."""
        arms = self.arms(self.coordinates)
        return np.asarray(arms.T * [s.damping for s in self.struts] @ arms)

    @property
    def K(self) -> RealArray:
        """Stiffness matrix [N/m], (coordinate, coordinate)."""
        arms = self.arms(self.coordinates)
        return np.asarray(arms.T * [s.stiffness for s in self.struts] @ arms)

    @property
    def C_road(self) -> RealArray:
        """Force on each coordinate per rate of each road input [N s/m], (coordinate, road)."""
        return np.asarray(-self.arms(self.coordinates).T * [s.damping for s in self.struts] @ self.arms(self.roads))

    @property
    def K_road(self) -> RealArray:
        """Force on each coordinate per displacement of each road input [N/m], (coordinate, road)."""
        return np.asarray(-self.arms(self.coordinates).T * [s.stiffness for s in self.struts] @ self.arms(self.roads))

    def arms(self, coordinates: Sequence[str]) -> RealArray:
        """Return the elongation of each strut per unit of each coordinate, (strut, coordinate)."""
        rows = [[strut.arms.get(c, 0.0) for c in coordinates] for strut in self.struts]
        return np.array(rows, dtype=float).reshape(len(self.struts), len(coordinates))

    def with_parameters(
        self,
        *,
        stiffness: Mapping[str, NewtonPerMetre] | None = None,
        damping: Mapping[str, NewtonSecondPerMetre] | None = None,
        masses: Mapping[str, Kilogram] | None = None,
    ) -> Suspension:
        """Return a copy with some parameters changed, by name of strut or of mass.

        Raises
        ------
        InputError
            If a name is unknown or a value is refused by `Strut` or `Suspension`.

        Examples
        --------
        >>> from suspid import quarter_car
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> car.with_parameters(damping={"chassis": 900}).struts[0].damping
        900.0
        """
        stiffness, damping, masses = stiffness or {}, damping or {}, masses or {}
        struts = [s.name for s in self.struts]
        for kind, given, known in (("strut", {**stiffness, **damping}, struts), ("mass", masses, self.coordinates)):
            for name in given:
                if name not in known:
                    raise InputError(f"there is no {kind} {name!r}.{nearest_names(name, known)}")
        return Suspension(
            masses={**self.masses, **masses},
            struts=tuple(
                replace(
                    s,
                    stiffness=stiffness.get(s.name, s.stiffness),
                    damping=damping.get(s.name, s.damping),
                )
                for s in self.struts
            ),
        )


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
        True: the paper's form, inputs ``road`` and ``road_rate`` for each road (all roads first).
        False: the same physics with one proper input per road; its rate is absorbed in the
        states, whose ``v_`` parts are then velocity less ``M^-1 C_road road``.

    Returns
    -------
    control.StateSpace
        States ``z_<coordinate>`` … then ``v_<coordinate>`` ….

    Raises
    ------
    InputError
        If an output is unknown or stands twice, or needs the rate of a road input that is not there: an
        acceleration of a mass that a damper ties to the road, with ``road_rate=False``.

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
        raise InputError(f"{outputs=} is one string; give a sequence of names, as [{outputs!r}]")
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
    # Motion in terms of states and inputs: displacement, velocity and acceleration of every coordinate.
    eye = np.eye(2 * n)
    state_part = {0: eye[:n], 1: eye[n:], 2: A[n:]}
    input_part = {0: jump[:n], 1: jump[n:], 2: B[n:]}
    names = list(suspension.coordinates if outputs is None else outputs)
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise InputError(f"output {twice[0]!r} stands {names.count(twice[0])} times; names must differ")
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


def finite_number(what: str, value: object, unit: str) -> float:
    """Return a value as a float; what is no finite number is an `InputError` that names it and its unit."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"{what} = {value!r} is not a number; give it in {unit}")
    if not math.isfinite(value):
        raise InputError(f"{what} = {value} {unit} is not finite")
    return float(value)


def output_weights(suspension: Suspension, output: str) -> tuple[int, RealArray, RealArray]:
    """Return, for an output by name, its order of derivative and its weights of coordinates and roads."""
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


def _check_name(what: str, name: object) -> None:
    if not isinstance(name, str) or not name or "." in name:
        raise InputError(f"{what} is named {name!r}; a name is a string, not empty, without '.' (as in python-control)")


def _probable_slip(road: str, coordinates: Sequence[str]) -> str | None:
    """Return the coordinate that ``road`` probably misspells; numbered names may differ in digits."""
    for coordinate in coordinates:
        alike = difflib.SequenceMatcher(None, road.lower(), coordinate.lower()).ratio() >= 0.85
        if alike and re.sub(r"\d", "", road) != re.sub(r"\d", "", coordinate):
            return coordinate
    return None
