"""A tuning: the front of two figures, and the springs and dampers along it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.reconstruction import unit_of
from suspid.reporting.axes import frequency_ticks, keep_apart, shown
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.results import check_kind
from suspid.text_tables import figures_of
from suspid.units import in_print

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.performance import DamperTuning, Tuning

# Letters of a figure's name along an axis.
MOST_OF_LABEL = 60
# Width of the first of several lines of parameters [point].
WIDEST_LINE = 3.0
# Room for an entry of the key, a name with two values and their unit [inch].
WIDEST_ENTRY = 3.3


@explained
def plot_tuning(found: Tuning, figure: Figure) -> Figure:
    """Draw the front of a tuning and the car as it was, and the parameters along it.

    Parameters
    ----------
    found : Tuning
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import quarter_car, tune
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> found = tune(car, parameters=["chassis.damping"], objective=["chassis_acceleration.Wk", "tire.load"],
    ...              road="C", speed=20.0, points=3)
    >>> page = plot_tuning(found, Figure())
    >>> page.axes[0].get_ylabel()
    'tire.load [N]'
    """
    check_kind(found, {"Tuning": "tune"})
    keep_apart(figure)
    upper, lower = figure.subplots(2, 1, sharex=True)
    draw_front(found, upper)
    first, knee = found.values[:, 0], found.knee
    # Lines may lie on each other: earlier ones are wider, so that both are seen.
    widths = np.linspace(WIDEST_LINE, 1.0, len(found.distinct)) if len(found.distinct) > 1 else [1.2]
    for i, colour, width in zip(found.distinct, CHANNEL_COLOURS * len(found.parameters), widths, strict=False):
        name, row = found.parameters[i], found.choices[:, i]
        values = f"{figures_of(float(row[knee]))}, now {figures_of(float(found.described[i]))} {unit_of(name)}"
        lower.plot(first, row / row[knee], "o-", color=colour, markersize=3 + width, linewidth=width,
                   label=f"{shown(name)} ({values})")  # fmt: skip
    lower.axvline(float(first[knee]), color=Colour.PALE, linewidth=0.8)
    lower.set(xlabel=_label(found, 0), ylabel="value / at the knee [1]")
    # A key inside hides lines on a phone: it has a row for each parameter, as wide as the panel.
    width = float(figure.bbox.width / figure.dpi)
    figure.legend(*lower.get_legend_handles_labels(), loc="outside lower right", fontsize="x-small", frameon=False,
                  ncols=max(1, int(width / WIDEST_ENTRY)))  # fmt: skip
    upper.set_xlabel("")
    lower.grid(color=Colour.SHADE, linewidth=0.6)
    lower.margins(0.05)
    if np.all(found.choices > 0) and float(np.max(found.choices / found.choices[knee])) > 3:
        lower.set_yscale("log")
        low, high = lower.get_ylim()
        frequency_ticks(lower.yaxis, high / low)
    return figure


def draw_damper(found: DamperTuning, ax: Axes) -> None:
    """Draw the curve of a damper with the rms velocity on each road, and the best single damper rate."""
    points = np.array(found.strut.curve)
    reach = 3 * float(np.max(found.velocity))
    velocities = np.linspace(-reach, reach, 400)
    forces = np.interp(velocities, points[:, 0], points[:, 1])
    ax.plot(velocities, forces, color=Colour.BLUE, linewidth=1.4, label="curve")
    if found.single is not None:
        ax.plot(velocities, found.single * velocities, color=Colour.GREY, linewidth=1.0, linestyle="--",
                label=f"one rate, {found.single:.4g} N s/m")  # fmt: skip
    ax.plot(found.velocity, np.interp(found.velocity, points[:, 0], points[:, 1]), "o", color=Colour.VERMILION,
            markersize=4, label="rms velocity on each road")  # fmt: skip
    ax.set(xlabel="velocity [m/s]", ylabel="force [N]", xlim=(-reach, reach))
    ax.legend(fontsize="small", frameon=False)
    ax.grid(color=Colour.SHADE, linewidth=0.6)


def draw_front(found: Tuning, upper: Axes) -> None:
    """Draw the front and the car as it was; of one objective its value."""
    first, knee = found.values[:, 0], found.knee
    other = min(1, found.values.shape[1] - 1)
    second = found.values[:, other]
    upper.plot(first, second, "o-", color=Colour.BLUE, markersize=4, linewidth=1.2, label="best compromises")
    upper.plot(first[knee], second[knee], "o", color=Colour.VERMILION, markersize=7, label="knee")
    now = found.present[[0, other]]
    # A car far from the front would squeeze it into a corner.
    span = np.array([np.ptp(first), np.ptp(second)])
    near = np.abs(now - [np.mean(first), np.mean(second)]) <= 1.5 * span
    if np.all(near) or len(first) == 1:
        upper.plot(now[0], now[1], "s", color=Colour.GREY, markersize=6, label="now")
    else:
        upper.plot([], [], " ", label=f"now, off the picture: {figures_of(float(now[0]))}, {figures_of(float(now[1]))}")
    upper.set(xlabel=_label(found, 0), ylabel=_label(found, other))
    upper.legend(fontsize="small", frameon=False)
    upper.grid(color=Colour.SHADE, linewidth=0.6)
    upper.margins(0.05)


def _label(found: Tuning, figure: int) -> str:
    return shown(in_print(found.heading(figure)), most=MOST_OF_LABEL)
