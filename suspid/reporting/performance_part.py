"""What the pages say of a car that was found: its wheels on a test bench, and its ride on a road."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.levels import normal_reach
from suspid.reporting.pictures import Picture, picture
from suspid.reporting.plot_grip import plot_grip
from suspid.reporting.rows import NOTHING, Quantity, quantity
from suspid.reporting.svg import page_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.performance import Grip, Ride
    from suspid.units import Ratio


@dataclass(frozen=True, kw_only=True, slots=True)
class WheelRow:
    """A wheel on the bench: adhesion [%] with its class, least phase [deg]."""

    name: str
    load: str
    adhesion: Quantity
    classed: str
    phase: Quantity


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureRow:
    """A figure of the ride with its interval."""

    name: str
    value: Quantity
    unit: str


def performance_fields(grip: Grip | None, ride: Ride | None, level: Ratio) -> dict[str, object]:
    """Return what the templates show of a car's grip and ride; nothing where these are None."""
    with page_style():
        return {
            "wheels": [] if grip is None else _wheels(grip, level),
            "grip_verdict": None if grip is None else grip.verdict,
            "grip_picture": None if grip is None else _bench(grip, level),
            "ride_figures": [] if ride is None else _figures(ride, level),
            "ride_verdict": None if ride is None else ride.verdict,
        }


def _wheels(found: Grip, level: Ratio) -> list[WheelRow]:
    reach, degrees = normal_reach(level), float(np.degrees(1.0))
    return [
        WheelRow(
            name=printable(wheel),
            load=f"{load:.0f}",
            # A wheel that surely leaves the platform has no adhesion.
            adhesion=Quantity(value="0") if least + reach * std < 0
            else quantity(100 * max(least, 0.0), 100 * reach * std or None, digits=3),
            classed=classed,
            phase=Quantity(value=NOTHING)
            if np.isnan(phase)
            else quantity(degrees * phase, degrees * reach * phase_std or None, digits=3),
        )
        for wheel, load, least, std, classed, phase, phase_std in zip(
            found.wheels, found.load.tolist(), found.least.tolist(), found.adhesion_std.tolist(), found.classes,
            found.phase.tolist(), found.phase_std.tolist(), strict=True,
        )
    ]  # fmt: skip


def _figures(found: Ride, level: Ratio) -> list[FigureRow]:
    reach = normal_reach(level)
    rows = zip(found.figures, found.units, found.values.tolist(), found.std.tolist(), strict=True)
    return [
        FigureRow(name=printable(name), value=quantity(value, reach * std or None, digits=4), unit=unit)
        for name, unit, value, std in rows
    ]


def _bench(found: Grip, level: Ratio) -> Picture:
    described = "Least contact force and phase of each wheel over the frequency of the platform"
    return picture(partial(_draw, found, level), name="bench", described=described, height=4.2, wide_height=4.2)


def _draw(found: Grip, level: Ratio, figure: Figure) -> None:
    plot_grip(found, figure, level=level)
