"""The unknowns of a suspension: stiffnesses, dampings and masses, except fixed or tied ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.model import Suspension
from suspid.units import UNITS, RealArray

QUANTITIES = ("stiffness", "damping")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Unknowns:
    """Dimensionless unknowns x, each the value of one parameter (or of several tied ones) over its scale.

    All parameters of a suspension are one vector p: k of every strut, c of every strut, every mass.
    """

    car: Suspension  # the nominal suspension
    names: tuple[str, ...]  # of the free parameters, in the order of p
    rows: list[int]  # where each of `names` stands in p
    column: list[int]  # which unknown each of `names` is; tied ones share theirs
    scale: RealArray  # (unknown,): what 1 means [N/m, N s/m or kg]
    nominal: RealArray
    positive: NDArray[np.bool_]  # stiffnesses and masses: stepped in their logarithm
    lower: RealArray
    upper: RealArray
    prior_std: RealArray  # of the nominal value; infinite where none is stated
    base: RealArray  # p = base + spread @ x, (parameter,)
    spread: RealArray  # (parameter, unknown)
    arms: RealArray  # (strut, coordinate): elongation of each strut per unit of each coordinate

    def __len__(self) -> int:
        return len(self.scale)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each unknown: of the parameter, or of those tied, joined by ``=``."""
        return tuple(
            " = ".join(n for n, c in zip(self.names, self.column, strict=True) if c == i) for i in range(len(self))
        )

    @property
    def has_prior(self) -> NDArray[np.bool_]:
        """Of which unknowns a nominal value with a standard deviation is data."""
        return np.isfinite(self.prior_std)

    def parameters(self, x: RealArray) -> RealArray:
        """Return p = (k, c, masses) of unknowns x, (…, parameter), in SI units."""
        return np.asarray(self.base + x @ self.spread.T)

    def on_bounds(self, x: RealArray) -> NDArray[np.bool_]:
        """Return which unknowns lie on one of their bounds, but for rounding."""
        rounding = 1e-9 * np.maximum(np.abs(x), 1e-9)
        return np.asarray((x <= self.lower + rounding) | (x >= self.upper - rounding))

    def sizes(self, x: RealArray) -> RealArray:
        """Return what a change of 1 means: of springs and masses themselves, unless there is next to none; else 1."""
        # A spring below a thousandth of nominal is judged beside the nominal one.
        return np.where(self.positive & (x > 1e-3), x, 1.0)

    def per_step(self, x: RealArray) -> RealArray:
        """Return what a step of 1 changes: springs and masses are stepped in their logarithm."""
        return np.where(self.positive, x, 1.0)

    def settled(self, x: RealArray) -> RealArray:
        """Return x with dampers that are nothing but rounding on their bound."""
        strongest = np.max(x[~self.positive], initial=0.0)
        # On the bound but for rounding, as a share of the strongest damper.
        return np.where(~self.positive & (x - self.lower < 1e-13 * strongest), self.lower, x)

    def suspension(self, x: RealArray) -> Suspension:
        """Return the suspension with these unknowns."""
        p, struts = self.parameters(x).tolist(), [s.name for s in self.car.struts]
        n = len(struts)
        return self.car.with_parameters(
            stiffness=dict(zip(struts, p[:n], strict=True)),
            damping=dict(zip(struts, p[n : 2 * n], strict=True)),
            masses=dict(zip(self.car.coordinates, p[2 * n : 2 * n + len(self.car.coordinates)], strict=True)),
        )

    def prior(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return how far x is from the nominal values in their standard deviations, and the derivatives."""
        told = self.has_prior
        std = self.prior_std[told]
        return (x - self.nominal)[told] / std, np.eye(len(x))[told] / std[:, None]


def parameter_vector(car: Suspension) -> RealArray:
    """Return p = (k of every strut, c of every strut, every mass)."""
    return np.array([*(s.stiffness for s in car.struts), *(s.damping for s in car.struts), *car.masses.values()])


def parameter_names(car: Suspension) -> list[str]:
    """Return the names of p.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> parameter_names(car)[1:5]
    ['tire.stiffness', 'chassis.damping', 'tire.damping', 'chassis.mass']
    """
    return [*(f"{s.name}.{q}" for q in QUANTITIES for s in car.struts), *(f"{m}.mass" for m in car.masses)]


def parameter_values(car: Suspension) -> dict[str, float]:
    """Return every parameter by name, such as ``"tire.stiffness"``, in its unit."""
    return dict(zip(parameter_names(car), parameter_vector(car).tolist(), strict=True))


def with_values(car: Suspension, values: Mapping[str, float]) -> Suspension:
    """Return a suspension with some parameters changed, by their names.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> changed = with_values(car, {"chassis.damping": 900.0, "tire.mass": 45.0})
    >>> [name for name, value in parameter_values(changed).items() if value != parameter_values(car)[name]]
    ['chassis.damping', 'tire.mass']
    """
    parts: dict[str, dict[str, float]] = {"stiffness": {}, "damping": {}, "mass": {}}
    for name, value in values.items():
        owner, _, quantity = name.rpartition(".")
        parts[quantity][owner] = value
    return car.with_parameters(stiffness=parts["stiffness"], damping=parts["damping"], masses=parts["mass"])


def unit_of(parameter: str) -> str:
    """Return the unit of a parameter.

    Examples
    --------
    >>> unit_of("tire.damping")
    'N s/m'
    """
    return UNITS[parameter.rpartition(".")[2]]
