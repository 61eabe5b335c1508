"""Pictures of one row for each number: limits, frequencies of a body, what a feedback does; and that of a road."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.levels import LEVEL, normal_reach
from suspid.reporting.axes import decade_ticks, entitle, frequency_ticks, shown
from suspid.reporting.colours import Colour
from suspid.simulation import REFERENCE, ROUGHNESS
from suspid.words.limits import LimitState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from suspid.analysis import CheckedLimit, CheckedLimits
    from suspid.greybox import BodyModes
    from suspid.performance import ActiveTuning, RoadClass

STATE_COLOURS = {LimitState.MET: Colour.GREEN, LimitState.MISSED: Colour.VERMILION, LimitState.OPEN: Colour.GREY}


def draw_limits(found: CheckedLimits, ax: Axes) -> None:
    """Draw each value with its interval in percent of its limit, of two the nearer one; what is allowed is shaded.

    A limit of zero has no percentage: its row has a name alone, as that of a value that was not found.
    """
    drawn = [(row, one, nearest) for row, one in enumerate(found.rows) if (nearest := _nearest(one))]
    marks = [100 * end / limit for _, one, limit in drawn for end in (one.lower, one.value, one.upper)]
    low, high = min([*filter(np.isfinite, marks), 100.0]), max([*filter(np.isfinite, marks), 100.0])
    margin = 0.1 * (high - low) or 10.0
    ax.set(xlim=(low - margin, high + margin), ylim=(len(found.rows) - 0.5, -0.5))
    for row, one, limit in drawn:
        ends = np.sort(np.clip([100 * one.limit.least / limit, 100 * one.limit.most / limit], *ax.get_xlim()))
        ax.barh(row, ends[1] - ends[0], left=ends[0], height=0.8, color=Colour.SHADE)
        colour = STATE_COLOURS[one.state]
        ax.plot([100 * one.lower / limit, 100 * one.upper / limit], [row, row], color=colour, linewidth=2.0)
        ax.plot([100 * one.value / limit], [row], "o", color=colour, markersize=5)
    ax.axvline(100.0, color=Colour.PALE, linewidth=0.8)
    _rows(ax, [f"{one.limit.name}: {one.state}" for one in found.rows])
    ax.set_xlabel("share of the limit [%]")
    entitle(ax, f"allowed (shaded) and found, with {100 * found.level:g} % intervals")


def _nearest(one: CheckedLimit) -> float:
    """Return the limit nearest to a value, 0 if there is none or no value."""
    some = [limit for limit in (one.limit.least, one.limit.most) if np.isfinite(limit)]
    return min(some, key=lambda limit: abs(limit - one.value)) if np.isfinite(one.value) else 0.0


def draw_body(found: BodyModes, ax: Axes) -> None:
    """Draw the frequency by each model of the road for each channel, and the interval that contains all of them."""
    for row, mode in enumerate(found):
        low, high = mode.interval()
        if not np.isfinite(low):
            continue
        ax.plot([low, high], [row, row], color=Colour.BLUE, linewidth=2.0)
        hertz = [f for f, _ in mode.models]
        ax.plot(hertz, [row] * len(hertz), "o", color=Colour.BLUE, markersize=4)
    _rows(ax, [mode.channel if mode.models else f"{mode.channel}: none" for mode in found])
    ax.set(xlabel="natural frequency [Hz]", ylim=(len(found) - 0.5, -0.5))
    entitle(ax, f"models of road and damper that fit, and their {100 * LEVEL:g} % interval")


def draw_active(found: ActiveTuning, ax: Axes) -> None:
    """Draw what is left of each root mean square with the feedback, in percent of that without; not of the force."""
    left = {name: 100 * found.rms[name] / rms for name, rms in found.passive.items() if rms > 0}
    ax.barh(range(len(left)), list(left.values()), height=0.5, color=Colour.BLUE)
    ax.axvline(100.0, color=Colour.GREY, linewidth=1.0, linestyle="--")
    _rows(ax, list(left))
    ax.set(xlabel="rms with feedback, in percent of that without [%]", ylim=(len(left) - 0.5, -0.5))
    entitle(ax, "what the feedback changes; dashed: without it")


def draw_road(found: RoadClass, ax: Axes) -> None:
    """Draw the fitted spectrum over the wavelengths that were used with its interval, and the middle of each class."""
    n = np.geomspace(1 / found.wavelengths[1], 1 / found.wavelengths[0], 100)
    level = np.log(found.roughness) - found.exponent * np.log(n / REFERENCE)
    slopes = np.stack([np.ones_like(n), -np.log(n / REFERENCE)])
    reach = normal_reach(LEVEL) * np.sqrt(np.einsum("in,ij,jn->n", slopes, found.covariance, slopes))
    for name, middle in ROUGHNESS.items():
        line = middle * (n / REFERENCE) ** -2
        ax.plot(n, line, color=Colour.PALE, linewidth=0.8)
        ax.annotate(name, (float(n[-1]), float(line[-1])), xytext=(3, 0), textcoords="offset points", va="center",
                    fontsize="x-small", color=Colour.GREY)  # fmt: skip
    ax.fill_between(n, np.exp(level - reach), np.exp(level + reach), color=Colour.PALE_BLUE, linewidth=0)
    ax.plot(n, np.exp(level), color=Colour.BLUE, linewidth=1.4)
    ax.set(xscale="log", yscale="log", xlabel="wavenumber [cycle/m]", ylabel="G_d [m³]", xlim=(n[0], n[-1]))
    frequency_ticks(ax.xaxis, float(n[-1] / n[0]))
    low, high = ax.get_ylim()
    decade_ticks(ax.yaxis, high / low)
    entitle(ax, f"spectrum of the road with {100 * LEVEL:g} % band; grey: middles of the classes")


def _rows(ax: Axes, names: Sequence[str]) -> None:
    ax.set_yticks(range(len(names)), [shown(name) for name in names])
