"""The part of a page on the wear of dampers: the state of each with its reasons, and the error rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.reporting.numerals import NOTHING, signed
from suspid.words import Level

if TYPE_CHECKING:
    from suspid.performance import DamperWear, Wear
    from suspid.units import Ratio
    from suspid.words import Check

# What the damping is compared with, by `Wear.against`.
COMPARED_WITH = {
    "nominal": "nominal values",
    "earlier": "earlier estimates",
    "history": "earlier estimates, by their own scatter",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class WearRow:
    """A damper: its state, damping found and expected [N s/m], and the share that is lost with its one-sided ends."""

    name: str
    state: str
    damping: str
    reference: str
    lost: str
    least: str
    most: str


def wear_fields(found: Wear | None) -> dict[str, object]:
    """Return what the template shows of the wear of dampers; nothing where it is None."""
    if found is None:
        return {"dampers": [], "wear_points": []}
    own = {id(check) for one in found.dampers for check in one.checks}
    # Of the estimates first, then of each damper, last the error rates.
    estimates = [check for check in found.verdict.checks if id(check) not in own]
    doubts = [check for check in estimates if check.level < Level.NOTE]
    rates = [check for check in estimates if check.level >= Level.NOTE]
    every = [*doubts, *(check for one in found.dampers for check in one.checks), *rates]
    return {
        "dampers": [_row(one) for one in found.dampers],
        "wear_points": [(_kind(check), printable(str(check))) for check in every],
        "wear_against": COMPARED_WITH[found.against],
        "wear_sure": f"{100 * found.certainty:g} %",
    }


def _row(one: DamperWear) -> WearRow:
    loss = one.loss
    return WearRow(
        name=printable(one.damper),
        state=str(one.state),
        damping=f"{one.damping:.4g}",
        reference=f"{one.reference:.4g}",
        lost=_percent(loss.value),
        least=_percent(loss.low),
        most=_percent(loss.high),
    )


def _percent(share: Ratio) -> str:
    return signed(f"{100 * share:z.1f} %") if np.isfinite(share) else NOTHING


def _kind(check: Check) -> str:
    return "for" if check.level is Level.SOUND else "note-point" if check.level is Level.NOTE else "against"
