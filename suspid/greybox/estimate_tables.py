"""Tables of an estimate: its parameters with units and nominal values, and its channels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from suspid.model import value_in
from suspid.signals import as_signal
from suspid.text_tables import TERMINAL, figures_of, rounded, spread, text_table
from suspid.units import UNITS

if TYPE_CHECKING:
    from suspid.greybox.estimates import Estimate


# What quantities are that no table of springs and dampers has.
EXPLAINED = {
    "relaxation": "damping over stiffness of the mount, 0 of a rigid one",
    "gain": "of a sensor over what it should show",
    "delay": "of a sensor behind the others",
}


def parameter_unit(name: str) -> str:
    """Return the unit of a parameter, such as N/m of ``"tire.stiffness"``."""
    return UNITS[name.rpartition(".")[2]]


def parameter_table(found: Estimate) -> str:
    """Return the table of all parameters, with their nominal values."""
    nominal = [value_in(found.nominal, name) for name in found.parameters]
    apart = found.beyond_chance()
    rows: dict[str, list[str]] = {
        "parameter": list(found.parameters),
        "unit": [parameter_unit(name) for name in found.parameters],
        "found": rounded(found.values, found.std),
        "±": [spread(std) for std in found.std],
        "nominal": ["" if value is None else figures_of(value, 6) for value in nominal],
        "change": [
            "" if not old else f"{100 * (new / old - 1):+.1f} %" for new, old in zip(found.values, nominal, strict=True)
        ],
        "significant": [
            "" if old is None else "yes" if name in apart else "no"
            for name, old in zip(found.parameters, nominal, strict=True)
        ],
    }
    held = f"\nfixed: {', '.join(found.held)}" if found.held else ""
    meant = quantities_in(found.parameters)
    return text_table(rows, widest=TERMINAL) + held + (f"\n{meant}" if meant else "")


def quantities_in(parameters: Sequence[str]) -> str:
    """Return what the quantities are among parameters that are no spring, damper or mass; empty if there is none.

    Examples
    --------
    >>> quantities_in(["chassis.stiffness", "chassis.relaxation", "tire_acceleration.delay"])
    'relaxation: damping over stiffness of the mount, 0 of a rigid one; delay: of a sensor behind the others.'
    >>> quantities_in(["chassis.stiffness"])
    ''
    """
    there = {name.rpartition(".")[2] for name in parameters}
    said = "; ".join(f"{quantity}: {meant}" for quantity, meant in EXPLAINED.items() if quantity in there)
    return f"{said}." if said else ""


def channel_table(found: Estimate) -> str:
    """Return the table of the channels of all records: noise and whiteness."""
    rows: dict[str, list[str]] = {"record": [], "channel": [], "noise std": [], "lag-1 correlation": []}
    for i, (response, noise, white) in enumerate(zip(found.residual, found.noise_std, found.whiteness, strict=True)):
        for channel, std, correlation in zip(as_signal(response).channels, noise, white, strict=True):
            for column, cell in zip(
                rows.values(), (str(i + 1), channel, f"{std:.3g}", f"{correlation:+.2f}"), strict=True
            ):
                column.append(cell)
    return text_table(rows, widest=TERMINAL)
