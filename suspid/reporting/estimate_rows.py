"""The rows of a report's table of estimated springs and dampers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.greybox import nominal_value, parameter_unit
from suspid.levels import normal_reach
from suspid.reporting.rows import NOTHING, Quantity, quantity, signed
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.greybox import Estimate


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimateRow:
    """A parameter beside its nominal value: the change [%], and whether the interval leaves the nominal value out."""

    name: str
    unit: str
    nominal: str
    value: Quantity
    change: str
    significant: str


def estimate_rows(found: Estimate, level: Ratio) -> list[EstimateRow]:
    """Return a row for each parameter that was found, those held last."""
    ends, reach = found.interval(level), normal_reach(level)
    rows = []
    for name, value, std in zip(found.parameters, found.values.tolist(), found.std.tolist(), strict=True):
        nominal = nominal_value(found.nominal, name)
        low, high = ends[name]
        rows.append(
            EstimateRow(
                name=printable(name),
                unit=parameter_unit(name),
                nominal=NOTHING if nominal is None else signed(f"{nominal:.6g}"),
                value=quantity(value, reach * std),
                change=signed(f"{100 * (value / nominal - 1):+.1f} %") if nominal else NOTHING,
                significant=NOTHING if nominal is None else "no" if low <= nominal <= high else "yes",
            )
        )
    for name in found.held:
        held = nominal_value(found.nominal, name)
        text = NOTHING if held is None else signed(f"{held:.6g}")
        rows.append(
            EstimateRow(
                name=printable(name),
                unit=parameter_unit(name),
                nominal=text,
                value=Quantity(value="held"),
                change=NOTHING,
                significant=NOTHING,
            )
        )
    return rows


def masses_of(found: Estimate) -> str:
    """Return the masses that springs and dampers rest on, in words."""
    return ", ".join(f"{printable(name)} {mass:.6g}" for name, mass in found.suspension.masses.items())
