"""Pictures of a fleet: distributions, and changes with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.fleet import MOST_SHOWN, DamperTrends
from suspid.reporting.axes import entitle, key_above, shown
from suspid.reporting.colours import Colour
from suspid.text_tables import figures_of
from suspid.words import DamperState

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.fleet import Distribution, FleetSummary, Trend
    from suspid.performance import Wear

# Significant digits of a median, those of the table beside.
MEDIAN_DIGITS = 5


@dataclass(frozen=True, kw_only=True, slots=True)
class Change:
    """A change with its interval, all in percent, and whether it stands out."""

    name: str
    low: float
    value: float
    high: float
    grave: bool


def draw_distribution(found: Distribution, ax: Axes) -> None:
    """Draw the histogram of a quantity with its median."""
    edges = np.array(found.edges)
    if len(found.bars) == 1 and not edges[-1] > edges[0]:
        # Values that are all alike make one bar, as wide as a tenth of the picture.
        half = 0.05 * (abs(float(edges[0])) or 1.0)
        edges = np.array([edges[0] - half, edges[0] + half])
    ax.bar(
        edges[:-1],
        found.bars,
        width=np.diff(edges),
        align="edge",
        color=Colour.PALE_BLUE,
        edgecolor=Colour.BLUE,
        linewidth=0.6,
    )
    ax.axvline(
        found.median, color=Colour.VERMILION, linewidth=1.2, label=f"median {figures_of(found.median, MEDIAN_DIGITS)}"
    )
    ax.set(xlabel=f"{shown(found.quantity)} [{shown(found.unit)}]", ylabel="records")
    key_above(ax)
    # Values of one fleet differ in their last digits: whole numbers are as wide as the room of three.
    ax.locator_params(axis="x", nbins=3)
    ax.ticklabel_format(axis="x", useOffset=False)
    ax.locator_params(axis="y", nbins=3, integer=True)


def draw_intervals(changes: Sequence[Change], ax: Axes, *, label: str, marks: Sequence[float] = ()) -> None:
    """Draw changes with their intervals, a line for each; dotted lines mark the limits of a rule."""
    for row, one in enumerate(changes):
        colour = Colour.VERMILION if one.grave else Colour.BLUE
        ax.plot([one.low, one.high], [row, row], color=colour, linewidth=2.0)
        ax.plot([one.value], [row], "o", color=colour, markersize=4)
    ax.axvline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    for mark in marks:
        ax.axvline(mark, color=Colour.GREY, linewidth=0.8, linestyle=":", zorder=0)
    ax.set_yticks(range(len(changes)), [shown(one.name) for one in changes])
    ax.set_ylim(len(changes) - 0.5, -0.5)
    ax.set_xlabel(label)


def changes_of(trends: Sequence[Trend]) -> list[Change]:
    """Return the changes of quantities over time, in percent of their start."""
    return [
        Change(
            name=f"{one.vehicle}: {one.quantity}",
            low=100 * one.change[0] / abs(one.start),
            value=100 * (one.end - one.start) / abs(one.start),
            high=100 * one.change[1] / abs(one.start),
            grave=False,
        )
        for one in trends[:MOST_SHOWN]
        if one.start
    ]


def losses_of(found: DamperTrends | Wear) -> list[Change]:
    """Return what dampers have lost, in percent of their damping; an end that is not known is the value."""
    named = (
        [(f"{one.vehicle}: {one.damper}", one.loss, one.state) for one in found.trends]
        if isinstance(found, DamperTrends)
        else [(one.damper, one.loss, one.state) for one in found.dampers]
    )
    return [
        Change(
            name=name,
            low=100 * (loss.low if np.isfinite(loss.low) else loss.value),
            value=100 * loss.value,
            high=100 * (loss.high if np.isfinite(loss.high) else loss.value),
            grave=state is DamperState.WORN,
        )
        for name, loss, state in named[:MOST_SHOWN]
    ]


def draw_losses(found: DamperTrends | Wear, ax: Axes) -> None:
    """Draw what each damper has lost with its interval, and the limits of the rule as dotted lines."""
    marks = (100 * found.rule.small, 100 * found.rule.large)
    draw_intervals(losses_of(found), ax, label="damping lost [%]", marks=marks)
    entitle(ax, f"dotted: worn if the interval is above {marks[0]:g} %, good if below {marks[1]:g} %")


def draw_fleet(found: FleetSummary, ax: Axes) -> None:
    """Draw what decides: the losses of dampers, else the changes over time, else how the first quantity is spread."""
    if found.dampers is not None and found.dampers.trends:
        draw_losses(found.dampers, ax)
    elif found.trends:
        draw_intervals(changes_of(found.trends), ax, label="change from first to last test [%]")
    else:
        draw_distribution(found.distributions[0], ax)
