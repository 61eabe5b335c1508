"""The tables on the page of a fleet, as texts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.fleet import MOST_SHOWN, known_columns
from suspid.reporting.numerals import NOTHING, signed
from suspid.text_tables import figures_of
from suspid.words import DamperState, label_in_words

if TYPE_CHECKING:
    from suspid.fleet import DamperTrend, Distribution, FleetSummary, Outlier, Trend


@dataclass(frozen=True, kw_only=True, slots=True)
class Heading:
    """The heading of a column, and whether numbers stand below it."""

    text: str
    number: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetTable:
    """A table: its headings, its rows, and how many rows are not shown."""

    headings: tuple[Heading, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    more: int = 0


def verdict_table(found: FleetSummary) -> FleetTable:
    """Return how many records have each level of verdict."""
    return _table({"verdict": map(label_in_words, found.verdicts)}, {"records": found.verdicts.values()})


def doubt_table(found: FleetSummary) -> FleetTable:
    """Return how many records have each doubt, and what is said of one of them."""
    said = [found.said.get(doubt, NOTHING) for doubt in found.doubts]
    return _table({"doubt": found.doubts}, {"records": found.doubts.values()}, {"such as": said})


def failure_table(found: FleetSummary) -> FleetTable:
    """Return how many records failed at each step and why, with one of them."""
    some = found.failures
    return _table(
        {"failed at": (one.step for one in some), "why": (one.code for one in some)},
        {"records": (one.count for one in some)},
        {"such as": (one.example for one in some)},
    )


def wear_table(found: FleetSummary) -> FleetTable:
    """Return in how many drives each damper has each state of wear."""
    states = {str(state): [each.get(str(state), 0) for each in found.wear.values()] for state in DamperState}
    return _table({"damper": found.wear}, states)


def distribution_table(some: Sequence[Distribution]) -> FleetTable:
    """Return a row for each quantity: median, quantiles, scatter and stated uncertainty."""
    return _table(
        {"quantity": (one.quantity for one in some), "unit": (one.unit for one in some)},
        {
            "records": (one.count for one in some),
            "median": (one.median for one in some),
            **known_columns(some),
            "scatter": (_number(one.known_scatter, 2) for one in some),
            "stated ±": (_number(one.stated, 2) for one in some),
        },
        most=len(some),
    )


def outlier_table(some: Sequence[Outlier], units: Mapping[str, str]) -> FleetTable:
    """Return a row for each value that stands out, the furthest first; units by quantity."""
    return _table(
        {
            "record": (one.record for one in some),
            "quantity": (f"{one.quantity} [{units[one.quantity]}]" for one in some),
        },
        {
            "value": (one.value for one in some),
            "median": (one.median for one in some),
            "off [sd]": (signed(f"{one.z:+.1f}") for one in some),
        },
    )


def trend_table(some: Sequence[Trend], units: Mapping[str, str]) -> FleetTable:
    """Return a row for each change, the surest first; units by quantity."""
    return _table(
        {
            "vehicle": (one.vehicle for one in some),
            "quantity": (f"{one.quantity} {one.direction}" for one in some),
            "unit": (units[one.quantity] for one in some),
        },
        {
            "tests": (one.count for one in some),
            "over": (_number(one.span, 3) for one in some),
            "start": (one.start for one in some),
            "end": (one.end for one in some),
            "change, 95 %": (" … ".join(signed(f"{end:+.3g}") for end in one.change) for one in some),
            "p": (_number(one.p_adjusted, 1) for one in some),
        },
    )


def damper_table(some: Sequence[DamperTrend]) -> FleetTable:
    """Return a row for each damper of each vehicle, the gravest first."""
    return _table(
        {
            "vehicle": (one.vehicle for one in some),
            "damper": (one.damper for one in some),
            "verdict": (one.state for one in some),
        },
        {
            "records": (one.drives for one in some),
            "lost": (_percent(one.loss.value) for one in some),
            "at least": (_percent(one.loss.low) for one in some),
            "at most": (_percent(one.loss.high) for one in some),
            "scatter": (_percent(one.scatter) for one in some),
        },
    )


def _table(
    names: Mapping[str, Iterable[object]],
    numbers: Mapping[str, Iterable[object]],
    texts: Mapping[str, Iterable[object]] | None = None,
    *,
    most: int = MOST_SHOWN,
) -> FleetTable:
    """Return a table of columns of names, of numbers and of further texts, with the rows that fit."""
    columns = {**names, **numbers, **(texts or {})}
    rows = [tuple(map(_cell, row)) for row in zip(*columns.values(), strict=True)]
    return FleetTable(
        headings=tuple(Heading(text=text, number=text in numbers) for text in columns),
        rows=tuple(rows[:most]),
        more=max(0, len(rows) - most),
    )


def _cell(value: object) -> str:
    return _number(value, 5) if value is None or isinstance(value, float) else printable(str(value))


def _number(value: float | None, digits: int) -> str:
    return signed(figures_of(value, digits)) if value is not None and np.isfinite(value) else NOTHING


def _percent(share: float) -> str:
    return signed(f"{100 * share:z.1f} %") if np.isfinite(share) else NOTHING
