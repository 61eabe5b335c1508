"""Plot of an estimate: its parameters relative to nominal, and the records with their fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.levels import LEVEL
from suspid.model import value_in
from suspid.reporting.axes import entitle, keep_apart, key_above, plot_residual, shown, unit_ticks
from suspid.reporting.channel_units import channel_unit
from suspid.reporting.colours import Colour
from suspid.reporting.spring_rows import values_of
from suspid.results import check_kind
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from suspid.greybox import Estimate
    from suspid.reconstruction import Reconstruction

# Height of a line of the upper picture, and the least of a channel [inch]; channels below each other at most.
LINE, LEAST_HEIGHT, PANELS_BELOW = 0.28, 1.2, 6


@explained
def plot_estimate(found: Estimate, figure: Figure, *, level: Ratio = LEVEL) -> Figure:
    """Draw the change of each parameter from nominal with its interval, and the first record with its residual.

    Parameters
    ----------
    found : Estimate
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure.
    level : float
        Probability of the intervals [1].

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> noisy = add_noise(record, snr_db=30.0, rng=np.random.default_rng(1))
    >>> page = plot_estimate(estimate(noisy, car, fixed=["tire.damping"]), Figure())
    >>> page.axes[0].get_xlabel()
    'change from nominal [%]'
    """
    check_kind(found, {"Estimate": "estimate"})
    keep_apart(figure)
    # Channels on one page; the others are in the JSON by their noise. An estimate that was read has no records.
    upper = LINE * (2 + len(found.parameters))
    most = min(PANELS_BELOW, max(1, int((figure.get_figheight() - upper) / LEAST_HEIGHT)))
    channels = as_signal(found.residual[0]).channels[:most] if found.residual else ()
    heights = [upper, *([max(LEAST_HEIGHT, min(2.0, figure.get_figheight() - upper))] * len(channels))]
    axes = np.atleast_1d(figure.subplots(len(heights), 1, height_ratios=heights))
    draw_changes(found, axes[0], level)
    if not channels:
        return figure
    fitted, residual, kept = as_signal(found.fitted[0]), as_signal(found.residual[0]), lively(found, 0)
    for at, (ax, name) in enumerate(zip(axes[1:], channels, strict=True)):
        fit, left = fitted.values[at, kept], residual.values[at, kept]
        plot_residual(ax, residual.timepts[kept], fit + left, fit, left)
        entitle(ax, shown(name))
        unit_ticks(ax, channel_unit(found.suspension, name))
    axes[-1].set_xlabel(time_label(found, 0))
    key_above(axes[1])
    return figure


def lively(found: Estimate, record: int) -> NDArray[np.bool_]:
    """Return which samples of a record are drawn: of a long one 20 periods of the slowest mode, not a band of ink."""
    residual = as_signal(found.residual[record])
    slowest = min((wn for wn in found.modes.wn.tolist() if wn > 0), default=2 * np.pi / residual.duration)
    until = min(residual.duration, 20 * 2 * np.pi / slowest)
    return np.asarray(residual.timepts - residual.start <= until)


def time_label(found: Estimate, record: int) -> str:
    """Return the name of the axis of time, which says how much of the record is drawn if that is not all of it."""
    times, kept = as_signal(found.residual[record]).timepts, lively(found, record)
    if np.all(kept):
        return "time [s]"
    return f"time [s]: the first {np.ptp(times[kept]):.3g} of {np.ptp(times):.3g} s"


def draw_changes(found: Estimate | Reconstruction, ax: Axes, level: Ratio = LEVEL) -> None:
    """Draw found over nominal with intervals if there are any, one line for each parameter with a nominal value."""
    known, names = found.covariance is not None, list[str]()
    ends, apart = (found.interval(level), found.beyond_chance(level)) if known else ({}, frozenset[str]())
    for name, value in values_of(found).items():
        nominal = None if found.nominal is None else value_in(found.nominal, name)
        if not nominal:
            continue
        low, high = ends.get(name, (value, value))
        colour = Colour.BLUE if name in apart or not known else Colour.GREY
        ax.plot([100 * (end / nominal - 1) for end in (low, high)], [len(names)] * 2, color=colour, linewidth=2.0)
        ax.plot([100 * (value / nominal - 1)], [len(names)], "o", color=colour, markersize=4)
        names.append(shown(name))
    ax.axvline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.set_xlabel("change from nominal [%]")
    intervals = f" with {100 * level:g} % intervals" if known else ""
    # In 5 inches the title has room for what the colours mean.
    if known and ax.figure.bbox.width > 5 * ax.figure.dpi:
        intervals += "; grey: no significant change"
    entitle(ax, f"springs and dampers{intervals}")
