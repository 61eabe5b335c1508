"""The part of a page on performance: grip on a test bench, and ride on a road."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.reporting.axes import without_legend
from suspid.reporting.numerals import NOTHING, Quantity, decimals, fixed, quantity
from suspid.reporting.pictures import Picture, picture
from suspid.reporting.plot_grip import plot_grip
from suspid.reporting.plot_ride import MOST_SPECTRA, colours_of, plot_ride
from suspid.reporting.svg import page_style
from suspid.simulation import ROUGHNESS
from suspid.units import in_print

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.performance import Grip, Ride
    from suspid.units import Ratio


@dataclass(frozen=True, kw_only=True, slots=True)
class WheelRow:
    """A wheel on the bench: adhesion [%] with its class, least phase [deg], each with the ends of its interval."""

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
            "ride_keys": [] if ride is None else [(c.css, kind) for kind, c in colours_of(ride).items()],
            "ride_picture": None if ride is None else _spectra(ride, level),
            "ride_verdict": None if ride is None else ride.verdict,
        }


def drive_to_tune(ride: Ride | None) -> tuple[str, str]:
    """Return road and speed, as the commands take them, for which the car that was found is tuned.

    Examples
    --------
    >>> drive_to_tune(None)
    ('C', '20')
    """
    road = None if ride is None else ride.road
    if road is None:
        return "C", "20"
    named = next((name for name, g in ROUGHNESS.items() if g == road.roughness), f"{road.roughness:g}")
    return named, f"{road.speed:g}"


def _wheels(found: Grip, level: Ratio) -> list[WheelRow]:
    ends, degrees = found.interval(level), float(np.degrees(1.0))
    return [
        WheelRow(
            name=printable(wheel),
            load=f"{load:.0f}",
            adhesion=_between(100.0, adhesion, ends[f"{wheel}.adhesion"], digits=3),
            classed=classed,
            phase=_between(degrees, phase, ends[f"{wheel}.phase"], digits=3),
        )
        for wheel, load, adhesion, classed, phase in zip(
            found.wheels, found.load.tolist(), found.adhesion.tolist(), found.classes, found.phase.tolist(), strict=True
        )
    ]


def _figures(found: Ride, level: Ratio) -> list[FigureRow]:
    ends = found.interval(level)
    return [
        FigureRow(name=printable(name), value=_between(1.0, value, ends[name], digits=4), unit=in_print(unit))
        for name, unit, value in zip(found.figures, found.units, found.values.tolist(), strict=True)
    ]


def _between(factor: float, value: float, ends: tuple[float, float], *, digits: int) -> Quantity:
    """Return a figure in another unit with the ends of its interval, which need not be as far from it on both sides."""
    if np.isnan(value):
        return Quantity(value=NOTHING)
    low, high = factor * ends[0], factor * ends[1]
    if not high > low:
        return quantity(factor * value, None, digits=digits)
    places = decimals((high - low) / 2)
    return Quantity(value=fixed(factor * value, places), reach=f"{fixed(low, places)} to {fixed(high, places)}")


def _bench(found: Grip, level: Ratio) -> Picture:
    described = "Least contact force and phase of each wheel over the frequency of the platform"
    return picture(partial(_draw, found, level), name="bench", described=described, height=4.2, wide_height=4.2)


def _spectra(found: Ride, level: Ratio) -> Picture | None:
    if not found.channels:
        return None
    described = "Weightings of ISO 2631-1, and the spectral density of each acceleration with and without them"
    height = 0.4 + 1.45 * (1 + min(len(found.channels), MOST_SPECTRA))
    return picture(partial(_draw_ride, found, level), name="felt", described=described, height=height,
                   wide_height=height)  # fmt: skip


def _draw_ride(found: Ride, level: Ratio, figure: Figure) -> None:
    without_legend(plot_ride(found, figure, level=level).axes[0])


def _draw(found: Grip, level: Ratio, figure: Figure) -> None:
    plot_grip(found, figure, level=level)
