"""The rows of a report's table of limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.reporting.numerals import NOTHING, Quantity, quantity
from suspid.words import NextStep, Remark
from suspid.words.limits import LimitState

if TYPE_CHECKING:
    from suspid.analysis import CheckedLimit, CheckedLimits

# The class of each state on the page.
STYLES = {LimitState.MET: "met", LimitState.MISSED: "missed", LimitState.OPEN: "open"}


@dataclass(frozen=True, kw_only=True, slots=True)
class LimitRow:
    """A limit in the unit that it was written in, what was found, and whether it is met."""

    name: str
    unit: str
    asked: str
    value: Quantity
    state: str
    style: str
    why: str


def limit_rows(checked: CheckedLimits | None) -> list[LimitRow]:
    """Return a row for each limit."""
    return [] if checked is None else [_row(one) for one in checked.rows]


def _row(one: CheckedLimit) -> LimitRow:
    scale, known = one.limit.scale, not math.isnan(one.lower)
    reach = (one.upper - one.lower) / 2 / scale if known else None
    return LimitRow(
        name=printable(one.limit.name),
        unit=one.limit.unit,
        asked=str(one.limit),
        value=Quantity(value=NOTHING) if math.isnan(one.value) else quantity(one.value / scale, reach),
        state=str(one.state),
        style=STYLES[one.state],
        why=printable(str(one.why or "")),
    )


def limit_steps(limits: CheckedLimits | None) -> tuple[Remark, ...]:
    """Return what follows from limits that are not met, or not known to be."""
    if limits is None:
        return ()
    steps = ((NextStep.LIMITS_MISSED, LimitState.MISSED), (NextStep.LIMITS_OPEN, LimitState.OPEN))
    return tuple(Remark(step, {"names": limits.named(state)}) for step, state in steps if limits.named(state))
