"""Springs, dampers and masses that were found, by name, with their joint covariance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from suspid.levels import LEVEL, check_level, normal_reach
from suspid.model.suspension import Suspension
from suspid.units import Ratio, RealArray
from suspid.values import FrozenMapping


class FoundCar(Protocol):
    """What `reconstruct` and `estimate` return: a car, the names of the parameters found, and their covariance."""

    @property
    def suspension(self) -> Suspension:
        """The car that was found."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names such as ``"tire.stiffness"``."""

    @property
    def covariance(self) -> RealArray | None:
        """Joint covariance of the parameters, in their units squared."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FoundParameters:
    """Values and standard deviations of parameters by name, such as ``"tire.stiffness"``.

    Parameters
    ----------
    values : mapping of str to float
        Values in the units of the parameters.
    stds : mapping of str to float, or None
        Standard deviations in the same units; None where none are known.
    """

    values: Mapping[str, float]
    stds: Mapping[str, float] | None

    def interval(self, level: Ratio = LEVEL) -> dict[str, tuple[float, float]]:
        """Return the ends between which each lies with probability ``level``; the value itself where none are known.

        Examples
        --------
        >>> FoundParameters(values={"tire.stiffness": 2e5}, stds=None).interval()
        {'tire.stiffness': (200000.0, 200000.0)}
        """
        check_level(level)
        reach = {} if self.stds is None else {name: normal_reach(level) * std for name, std in self.stds.items()}
        return {
            name: (value - reach.get(name, 0.0), value + reach.get(name, 0.0)) for name, value in self.values.items()
        }


def value_in(car: Suspension, name: str) -> float | None:
    """Return the value of a parameter of a car by its name; None of one that it does not have.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> value_in(car, "tire.mass"), value_in(car, "tire.stiffness"), value_in(car, "acceleration.gain")
    (40.0, 200000.0, None)
    """
    owner, _, quantity = name.rpartition(".")
    if quantity == "mass":
        return car.masses.get(owner)
    strut = next((one for one in car.struts if one.name == owner), None)
    return None if strut is None or not hasattr(strut, quantity) else float(getattr(strut, quantity))


def found_parameters(found: FoundCar) -> FoundParameters:
    """Return the parameters of the car that a result found; those of its channels are left out.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car, reconstruct
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> round(found_parameters(reconstruct(eigenmodes(car), car)).values["tire.stiffness"])
    200000
    """
    values = {name: value_in(found.suspension, name) for name in found.parameters}
    known = {name: value for name, value in values.items() if value is not None}
    stds = None
    if found.covariance is not None:
        every = dict(zip(found.parameters, np.sqrt(np.diag(found.covariance)).tolist(), strict=True))
        stds = FrozenMapping({name: every[name] for name in known})
    return FoundParameters(values=FrozenMapping(known), stds=stds)
