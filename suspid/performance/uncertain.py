"""A car with its uncertainty: from a description, an estimate or a reconstruction with covariance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from suspid.errors import InputError
from suspid.files import printable
from suspid.greybox import Estimate
from suspid.model import Suspension
from suspid.reconstruction import QUANTITIES, Reconstruction, parameter_names, parameter_values, with_values
from suspid.units import Ratio, RealArray, Second
from suspid.values import frozen_real, is_size, nearest_names
from suspid.wording import Argument
from suspid.words import EstimateCheck, Level

ALL = "all springs, dampers and masses"
# Relative standard deviation of a positive parameter from which on nothing is known of it.
MOST_STATED = 1.0
# What the name of a parameter ends with that is the relaxation of a mount.
RELAXATION = ".relaxation"
# What figures are computed of: a car as described, or as found with its uncertainty.
Car: TypeAlias = Suspension | Estimate | Reconstruction


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Uncertain:
    """A car, its uncertain parameters with their joint covariance, and what is taken as known."""

    car: Suspension
    parameters: tuple[str, ...]
    values: RealArray  # of the parameters
    covariance: RealArray
    relaxations: Mapping[str, Second]  # of mounts that are parameters
    known: tuple[str, ...]
    nominal: tuple[str, ...]  # what of it the records could not tell, so that it stayed nominal
    doubt: Level | None  # the level of the estimate's verdict, where it is below sound

    def at(self, values: Mapping[str, float]) -> tuple[Suspension, dict[str, Second]]:
        """Return the car and the relaxations of its mounts with some parameters changed, by their names."""
        mounts = {name: value for name, value in values.items() if name.endswith(RELAXATION)}
        changed = {name: value for name, value in values.items() if name not in mounts}
        relaxations = {name.removesuffix(RELAXATION): value for name, value in mounts.items()}
        return with_values(self.car, changed), {**self.relaxations, **relaxations}


def uncertain(car: Car, nominal_std: Ratio | Mapping[str, Ratio] | None = None) -> Uncertain:
    """Return a car with the parameters of springs, dampers, masses and mounts that are uncertain.

    Raises
    ------
    InputError
        If the car is no Suspension, Estimate or Reconstruction, or ``nominal_std`` names what is unknown or was
        estimated.
    """
    described = suspension_of(car)
    found = None if isinstance(car, Suspension) else car
    values, names = parameter_values(described), parameter_names(described)
    estimated = () if found is None or found.covariance is None else found.parameters
    own = [i for i, name in enumerate(estimated) if name in names or _is_mount(described, name)]
    stds = _stated(nominal_std, [name for name in names if name not in estimated], values, names)
    parameters = (*(estimated[i] for i in own), *stds)
    covariance = np.diag([0.0] * len(own) + [values[name] * std for name, std in stds.items()]) ** 2
    if found is not None and found.covariance is not None:
        covariance[: len(own), : len(own)] = found.covariance[np.ix_(own, own)]
    relaxations: dict[str, float] = {}
    if isinstance(found, Estimate):
        relaxations = {
            estimated[i].rpartition(".")[0]: float(found.values[i]) for i in own if estimated[i] not in names
        }
    known = tuple(name for name in names if name not in parameters and values[name])
    level = None if found is None else found.verdict.level
    return Uncertain(
        car=described,
        parameters=parameters,
        values=frozen_real([relaxations[n.rpartition(".")[0]] if n not in values else values[n] for n in parameters]),
        covariance=frozen_real(covariance),
        relaxations=relaxations,
        known=known if parameters else (ALL,),
        nominal=tuple(name for name in known if name in _cancelled(found)),
        doubt=level if level is not None and level < Level.SOUND else None,
    )


def _cancelled(found: Estimate | Reconstruction | None) -> set[str]:
    """Return the springs and dampers beyond the wheels whose motion was given: of them the records tell nothing."""
    if not isinstance(found, Estimate):
        return set()
    codes = [check.remark for check in found.verdict.checks if check.remark.code is EstimateCheck.CANCELS]
    said = [remark.numbers["names"] for remark in codes]
    struts = [str(name) for names in said if isinstance(names, tuple) for name in names]
    return {f"{strut}.{quantity}" for strut in struts for quantity in QUANTITIES}


def suspension_of(car: object) -> Suspension:
    """Return the car as described or as found.

    Raises
    ------
    InputError
        If it is no Suspension, Estimate or Reconstruction.
    """
    if isinstance(car, Car):
        return car if isinstance(car, Suspension) else car.suspension
    hint = "; take its .suspension" if hasattr(car, "suspension") else ""
    if isinstance(car, str | os.PathLike):
        path = printable(os.fspath(car))
        hint = f": read {path!r} with read_estimate" if path.lower().endswith(".json") else f": read_car({path!r})"
    raise InputError(f"this needs a Suspension, an Estimate or a Reconstruction, not {type(car).__name__}{hint}")


def _is_mount(car: Suspension, name: str) -> bool:
    owner, _, quantity = name.rpartition(".")
    return quantity == "relaxation" and any(strut.name == owner for strut in car.struts)


def _stated(
    given: object,
    held: list[str],
    values: Mapping[str, float],
    names: list[str],
) -> dict[str, float]:
    """Return the relative standard deviations of parameters that were not estimated, by name."""
    if given is None:
        return {}
    if not isinstance(given, Mapping | int | float | np.number):
        raise InputError(
            Argument("nominal_std", f"{given!r:.40}"),
            " must be a number such as 0.05, or map parameters to numbers",
        )
    if isinstance(given, Mapping):
        for name in given:
            if name not in names:
                raise InputError(
                    Argument("nominal_std"), f": there is no parameter {name!r}.{nearest_names(name, names)}"
                )
            if name not in held:
                raise InputError(
                    Argument("nominal_std"), f": {name!r} was estimated; its uncertainty is that of the estimate"
                )
    stds = dict(given) if isinstance(given, Mapping) else {
        name: given for name in held if values[name] and not name.endswith(".mass")
    }  # fmt: skip
    for name, std in stds.items():
        if isinstance(std, bool) or not (is_size(std) or std == 0):
            raise InputError(
                Argument("nominal_std"),
                f": {name!r} = {std!r} must be a relative standard deviation >= 0, such as 0.05",
            )
        if std > MOST_STATED:
            raise InputError(
                Argument("nominal_std"),
                f": {name!r} = {std:g} means {std:.0%} for a positive quantity; 1 is the largest, 0.05 is 5 %",
            )
    return {name: float(std) for name, std in stds.items()}
