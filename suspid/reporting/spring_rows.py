"""The rows of a report's table of springs and dampers with their nominal values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.greybox import Estimate, parameter_unit
from suspid.levels import normal_reach
from suspid.model import value_in
from suspid.reconstruction import parameter_values
from suspid.reporting.numerals import NOTHING, Quantity, digits, plain, quantity, signed
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.reconstruction import Reconstruction


@dataclass(frozen=True, kw_only=True, slots=True)
class SpringRow:
    """A parameter relative to its nominal value: the change [%], and whether it is beyond chance, of all together.

    ``apart`` is the distance from nominal in standard deviations; ``others`` are its values in every alternative.
    """

    name: str
    unit: str
    nominal: str
    value: Quantity
    change: str
    significant: str
    apart: str
    others: tuple[str, ...]


def spring_rows(found: Estimate | Reconstruction, level: Ratio) -> list[SpringRow]:
    """Return a row for each parameter that was found, those held last."""
    reach, others = normal_reach(level), [parameter_values(car) for car in found.alternatives]
    values = values_of(found)
    apart = frozenset[str]() if found.covariance is None else found.beyond_chance(level)
    stds = [None] * len(values) if found.covariance is None else np.sqrt(np.diag(found.covariance)).tolist()
    rows = []
    for (name, value), std in zip(values.items(), stds, strict=True):
        nominal = None if found.nominal is None else value_in(found.nominal, name)
        rows.append(
            SpringRow(
                name=printable(name),
                unit=parameter_unit(name),
                nominal=NOTHING if nominal is None else plain(nominal),
                # From the standard deviation: an end that lies on a bound must not sharpen the value.
                value=quantity(value, None if std is None else reach * std),
                change=signed(f"{100 * (value / nominal - 1):+.1f} %") if nominal else NOTHING,
                significant=NOTHING if nominal is None or std is None else "yes" if name in apart else "no",
                apart=NOTHING if nominal is None or not std else f"{digits(abs(value - nominal) / std, 2)} sd",
                others=tuple(plain(float(f"{car[name]:.5g}")) if name in car else NOTHING for car in others),
            )
        )
    return rows + [_held(found, name) for name in found.held]


def values_of(found: Estimate | Reconstruction) -> dict[str, float]:
    """Return the parameters that were found with their values."""
    if isinstance(found, Estimate):
        return dict(zip(found.parameters, found.values.tolist(), strict=True))
    every = parameter_values(found.suspension)
    return {name: every[name] for name in found.parameters}


def _held(found: Estimate | Reconstruction, name: str) -> SpringRow:
    """Return the row of what was held at its nominal value."""
    value = value_in(found.suspension, name)
    return SpringRow(
        name=printable(name),
        unit=parameter_unit(name),
        nominal=NOTHING if value is None else plain(value),
        value=Quantity(value="held"),
        change=NOTHING,
        significant=NOTHING,
        apart=NOTHING,
        others=(NOTHING,) * len(found.alternatives),
    )


def masses_of(found: Estimate | Reconstruction) -> str:
    """Return the masses that springs and dampers rest on, in words."""
    return ", ".join(f"{printable(name)} {plain(mass)}" for name, mass in found.suspension.masses.items())
