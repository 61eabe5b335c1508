"""Natural frequency and damping ratio of a mode against its amplitude."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.identification import AmplitudeDependence, Identification, Repeats
from suspid.levels import NORMAL_95
from suspid.reporting.axes import checked_grid, in_legend, label_within
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.results import check_kind
from suspid.units import RealArray
from suspid.wavelets import Ridge

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@explained
def plot_amplitude(found: Identification | Repeats, *, axes: Sequence[Sequence[Axes]] | NDArray[np.object_]) -> None:
    """Draw natural frequency and damping ratio of each mode against its amplitude, with 95 % bands.

    Open circles are slopes of the skeleton of the nearest ridge over the same windows of time: a second way to the same
    curve, without forces and without a fit of the whole decay. Of several decays each has a line, and the joint mode is
    a diamond at its amplitude.

    Parameters
    ----------
    found : Identification or Repeats
        Modes that depend on their amplitude.
    axes : (2, mode) of matplotlib.axes.Axes
        Where to draw: frequency above, damping below.

    Raises
    ------
    InputError
        If the Axes have another shape.

    Examples
    --------
    >>> import control, numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import identify
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = np.random.default_rng(0).normal(scale=1e-3, size=t.size)
    >>> angle = (np.exp(-0.1 * t) - 0.25) * np.cos(10 * t) + noise
    >>> swing = control.TimeResponseData(t, angle, issiso=True, output_labels=["angle"])
    >>> found = identify(swing)
    >>> axes = Figure().subplots(2, len(found.modes), squeeze=False)
    >>> plot_amplitude(found, axes=axes)
    >>> axes[1, 0].get_xlabel()
    'amplitude in angle'
    """
    check_kind(found, {"Identification": "identify", "Repeats": "identify_repeats"})
    if isinstance(found, Repeats):
        _plot_joint(found, checked_grid(axes, (2, len(found.amplitude_dependence))))
        return
    grid = checked_grid(axes, (2, len(found.amplitude_dependence)))
    for mode, each in enumerate(found.amplitude_dependence):
        ridges = [ridge for ridge in found.ridges if abs(np.log(ridge.omega / found.modes.wn[mode])) < np.log(1.1)]
        nearest = min(ridges, key=lambda ridge: abs(ridge.omega - float(np.mean(each.wn))), default=None)
        witness = None if nearest is None else _slopes(nearest, each)
        hertz = 2 * np.pi
        _draw(grid[0, mode], each.amplitude, each.wn / hertz, each.wn_std / hertz)
        _draw(grid[1, mode], each.amplitude, each.zeta, each.zeta_std)
        if witness is not None:
            grid[0, mode].plot(
                each.amplitude, witness[0] / hertz, "o", color=Colour.VERMILION, fillstyle="none", markersize=5
            )
            grid[1, mode].plot(each.amplitude, witness[1], "o", color=Colour.VERMILION, fillstyle="none", markersize=5)
        grid[0, mode].set(title=f"mode {mode + 1}", ylabel="frequency [Hz]" if mode == 0 else "")
        grid[1, mode].set(ylabel="damping ratio [1]" if mode == 0 else "")
        label_within(grid[1, mode], f"amplitude in {in_legend(each.channel)}")
        for ax in grid[:, mode]:
            ax.axvline(each.holds_at, color=Colour.VERMILION, linewidth=0.8, linestyle="--")


def draw_amplitudes(found: Identification | Repeats, figure: Figure) -> None:
    """Draw frequency and damping of each mode against its amplitude into a figure."""
    modes = len(found.amplitude_dependence)
    axes = np.asarray(figure.subplots(2, modes, sharex="col", squeeze=False), dtype=object)
    plot_amplitude(found, axes=axes)
    figure.align_ylabels(list(axes[:, 0]))


def _plot_joint(found: Repeats, grid: NDArray[np.object_]) -> None:
    """Draw the tables of each decay, in a colour of its own, and the joint modes."""
    names = found.names or [f"decay {number}" for number in range(1, len(found.each) + 1)]
    hertz = 2 * np.pi
    for mode, (joint, agreement) in enumerate(zip(found.amplitude_dependence, found.consistency, strict=True)):
        ends: list[list[float]] = [[], []]
        for decay in agreement.held:
            own = found.each[decay]
            nearest = int(np.argmin(np.abs(np.log(own.modes.wn / found.modes.wn[mode]))))
            if not own.amplitude_dependence:
                continue
            each = own.amplitude_dependence[nearest].known
            colour, order = CHANNEL_COLOURS[decay % len(CHANNEL_COLOURS)], np.argsort(each.amplitude)
            rows = (each.wn / hertz, each.wn_std / hertz), (each.zeta, each.zeta_std)
            for ax, reached, (value, std) in zip(grid[:, mode], ends, rows, strict=True):
                ax.errorbar(
                    each.amplitude[order], value[order], NORMAL_95 * std[order], fmt=".-", color=colour,
                    linewidth=1.0, markersize=4, label=in_legend(names[decay]),
                )  # fmt: skip
                reached += [float(np.min(value)), float(np.max(value))]
            label_within(grid[1, mode], f"amplitude in {in_legend(each.channel)}")
        values = float(found.modes.wn[mode]) / hertz, float(found.modes.zeta[mode])
        for ax, own_value, reached in zip(grid[:, mode], values, ends, strict=True):
            if joint is not None:
                ax.plot(joint.holds_at, own_value, "D", color=Colour.BLACK, markersize=5, zorder=3, label="joint")
            # A window of which little is known must not hide the others.
            low, high = min([own_value, *reached]), max([own_value, *reached])
            room = 0.2 * (high - low) + 1e-3 * abs(own_value)
            ax.set_ylim(low - room, high + room)
        grid[0, mode].set(title=f"mode {mode + 1}", ylabel="frequency [Hz]" if mode == 0 else "")
        grid[1, mode].set(ylabel="damping ratio [1]" if mode == 0 else "")
    grid[1, 0].legend(loc="best", fontsize="x-small", framealpha=0.8)


def _draw(ax: Axes, amplitude: RealArray, value: RealArray, std: RealArray) -> None:
    order = np.argsort(amplitude)
    low, high = (value - NORMAL_95 * std)[order], (value + NORMAL_95 * std)[order]
    ax.fill_between(amplitude[order], low, high, color=Colour.SHADE, linewidth=0.0)
    ax.plot(amplitude[order], value[order], ".-", color=Colour.BLUE, linewidth=1.0, markersize=4)
    # A window of which little is known must not hide the others.
    inner = np.sort(std)[: max(1, (3 * len(std) + 3) // 4)]
    reach = 2 * NORMAL_95 * float(inner[-1]) + 0.1 * float(np.ptp(value)) + 1e-3 * float(np.mean(np.abs(value)))
    ax.set_ylim(float(np.min(value)) - reach, float(np.max(value)) + reach)


def _slopes(ridge: Ridge, each: AmplitudeDependence) -> tuple[RealArray, RealArray]:
    """Return natural frequency and damping ratio from the skeleton over each window; NaN where it is not trusted."""
    strongest = int(np.argmax(np.mean(np.abs(ridge.skeleton), axis=1)))
    logarithm = np.log(np.maximum(np.abs(ridge.skeleton[strongest]), 1e-300))
    phase = np.unwrap(np.angle(ridge.skeleton[strongest]))
    wn, zeta = np.full(len(each.spans), np.nan), np.full(len(each.spans), np.nan)
    for i, (start, stop) in enumerate(each.spans):
        inside = ridge.trusted & (ridge.timepts >= start) & (ridge.timepts <= stop)
        if np.sum(inside) < 3 or np.ptp(ridge.timepts[inside]) < 0.5 * (stop - start):
            continue
        decay = np.polyfit(ridge.timepts[inside], logarithm[inside], 1)[0]
        turn = np.polyfit(ridge.timepts[inside], phase[inside], 1)[0]
        wn[i] = abs(complex(decay, turn))
        zeta[i] = -decay / wn[i]
    return wn, zeta
