"""Grip on a test bench: contact force and phase over the sweep, with limits and bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.performance import CLASSES, PHASE_LIMIT
from suspid.reporting.axes import entitle, frequency_ticks, in_legend, keep_apart, key_above
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.results import check_kind
from suspid.units import Ratio, RealArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.performance import Grip

# Relative difference of two curves below which one hides the other: the width of a line in half a page.
SAME_CURVE = 5e-3


@explained
def plot_grip(found: Grip, figure: Figure, *, level: Ratio = LEVEL) -> Figure:
    """Draw least contact force and phase of each wheel over frequency, with bands and the limits of EUSAMA and EGEA.

    A dot marks the figure of each wheel. The force is negative where a linear wheel would pull: it leaves the platform.

    Parameters
    ----------
    found : Grip
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure.
    level : float
        Probability of the bands [1], at each frequency.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import grip, quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=650, tire_damping=60)
    >>> page = plot_grip(grip(car), Figure())
    >>> [ax.get_ylabel() for ax in page.axes]
    ['adhesion [%]', 'phase [deg]']
    """
    check_kind(found, {"Grip": "grip"})
    check_level(level)
    keep_apart(figure)
    reach, degrees = normal_reach(level), float(np.degrees(1.0))
    upper, lower = figure.subplots(2, 1, sharex=True)
    draw_adhesion(found, upper, level=level)
    _draw(lower, found, degrees * found.phase_curve, degrees * reach * found.phase_band)
    for i, colour in zip(range(len(found.wheels)), _colours(found), strict=True):
        lower.plot(found.phase_hertz[i], degrees * found.phase[i], "o", color=colour, markersize=4)
    lower.axhline(degrees * PHASE_LIMIT, color=Colour.GREY, linewidth=0.8, linestyle=":")
    lower.annotate(
        f"limit\n{degrees * PHASE_LIMIT:.0f} deg",
        (1.0, degrees * PHASE_LIMIT),
        xycoords=("axes fraction", "data"),
        xytext=(3, -3),
        textcoords="offset points",
        fontsize="small",
        color=Colour.GREY,
    )
    lower.axvspan(found.resonances[0, 0], float(np.max(found.resonances[:, 1])), color=Colour.SHADE, zorder=0)
    lower.set(xlabel="frequency [Hz]", ylabel="phase [deg]", ylim=(0.0, 180.0), yticks=range(0, 181, 45))
    entitle(lower, "EGEA: phase of contact force; grey: between the resonances")
    upper.set_xlabel("")
    return figure


def draw_adhesion(found: Grip, ax: Axes, *, level: Ratio = LEVEL) -> None:
    """Draw the least contact force of each wheel over frequency, with its band and the classes of EUSAMA."""
    reach = normal_reach(level)
    # How far below zero a wheel would pull tells no more: it has left the platform. The classes keep their room.
    low = min(-5.0, max(-20.0, 105 * float(np.min(found.least))))
    _draw(ax, found, 100 * found.adhesion_curve, 100 * reach * found.adhesion_band)
    for hertz, least, colour in zip(found.adhesion_hertz, found.least, _colours(found), strict=True):
        # A mark at the lower end of the axis is drawn whole.
        ax.plot(hertz, max(100 * least, low), "o", color=colour, markersize=4, clip_on=False, zorder=3)
    for name, share in CLASSES.items():
        ax.axhline(100 * share, color=Colour.GREY, linewidth=0.8, linestyle=":")
        ax.annotate(
            name,
            (1.0, 100 * share),
            xycoords=("axes fraction", "data"),
            xytext=(3, 3),
            textcoords="offset points",
            fontsize="small",
            color=Colour.GREY,
        )
    ax.set(xlabel="frequency [Hz]", ylabel="adhesion [%]", ylim=(low, 105.0))
    entitle(ax, "EUSAMA: least over static force")
    ax.set_xscale("log")
    ax.set_xlim(0.5, float(found.hertz[-1]))
    frequency_ticks(ax.xaxis, float(found.hertz[-1]) / 0.5)
    key_above(ax)


def _draw(ax: Axes, found: Grip, values: RealArray, reach: RealArray) -> None:
    for i, (wheel, row, band, colour) in enumerate(zip(found.wheels, values, reach, _colours(found), strict=True)):
        ax.fill_between(found.hertz, row - band, row + band, color=colour, alpha=0.25, linewidth=0.0)
        # The wheels of one axle often have one curve: dashes show the line below them.
        hidden = any(np.allclose(row, other, rtol=SAME_CURVE) for other in values[:i])
        ax.plot(found.hertz, row, "--" if hidden else "-", color=colour, linewidth=1.0, label=in_legend(wheel))


def _colours(found: Grip) -> list[Colour]:
    return [CHANNEL_COLOURS[i % len(CHANNEL_COLOURS)] for i in range(len(found.wheels))]
