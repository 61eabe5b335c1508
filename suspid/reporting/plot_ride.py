"""The ride of a car or a record: spectra of its accelerations, plain and weighted, and the weightings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.levels import LEVEL, check_level
from suspid.performance import power_ends, weighting
from suspid.reporting.axes import decade_ticks, entitle, frequency_ticks, keep_apart, key_above, shown
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.reporting.plot_spectra import density_label
from suspid.results import check_kind
from suspid.units import Ratio, RealArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.performance import Ride

# Accelerations on one page, and decades of a spectrum below its peak that are drawn.
MOST_SPECTRA, DECADES_DRAWN = 5, 5
# Range of frequencies that is drawn: that of the weightings [Hz].
LOWEST_FELT, HIGHEST_FELT = 0.05, 200.0
# Width of a figure from which on figures fit next to the name of a channel [inch].
ROOM_FOR_FIGURES = 6.0
# Height of a panel below which the label of its vertical axis is set small, on two lines [inch].
LABEL_HEIGHT = 1.0
# Points of the curve of a weighting, which bends smoothly.
WEIGHTING_POINTS = 400
# Bands of an octave over which lines of a record's spectrum are averaged: finer than a mode with a damping of 2 %.
BANDS_AN_OCTAVE = 24
# Correlation of the powers of lines one and two apart under a Hann window, whose lines are 1/4, 1/2 and 1/4 of those of
# no window: squares of 2/3 and 1/6 (F. J. Harris, Proc. IEEE 66, 1978, 51-83).
HANN_SHARED = (4 / 9, 1 / 36)


@explained
def plot_ride(found: Ride, figure: Figure, *, level: Ratio = LEVEL) -> Figure:
    """Draw the weightings of ISO 2631-1 and, of each acceleration, its spectral density with and without them.

    Parameters
    ----------
    found : Ride
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure.
    level : float
        Probability of the bands and of the intervals of the figures [1].

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import quarter_car, ride
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> page = plot_ride(ride(car, road="C", speed=20.0), Figure())
    >>> [ax.get_title(loc="left") for ax in page.axes]
    ['weightings', 'chassis_acceleration']
    """
    check_kind(found, {"Ride": "ride"})
    check_level(level)
    keep_apart(figure)
    channels = found.channels[:MOST_SPECTRA]
    axes = np.atleast_1d(figure.subplots(1 + len(channels), 1, sharex=True))
    axes[0].plot([], [], color=Colour.PALE, linewidth=1.6, label="not weighted")
    for kind, colour in colours_of(found).items():
        hertz = np.geomspace(LOWEST_FELT, HIGHEST_FELT, WEIGHTING_POINTS)
        axes[0].plot(hertz, 20 * np.log10(np.abs(weighting(kind, hertz))), color=colour, linewidth=1.2, label=kind)
    axes[0].set(ylabel="gain [dB]", ylim=(-50, 5))
    entitle(axes[0], "weightings")
    key_above(axes[0], abreast=MOST_SPECTRA)
    ends = _ends(found, level)
    for ax, channel in zip(axes[1:], channels, strict=True):
        _draw(found, channel, ax, level, ends)
        ax.set_xlabel("")
    axes[0].grid(color=Colour.SHADE, linewidth=0.6)
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def size_of_ride(found: Ride) -> tuple[float, float]:
    """Return width and height of a figure that holds all spectra [inch]."""
    return 7.0, 0.6 + 2.1 * (1 + min(len(found.channels), MOST_SPECTRA))


def draw_spectrum(found: Ride, channel: str, ax: Axes, *, level: Ratio = LEVEL) -> None:
    """Draw the spectral density of an acceleration with and without its weightings, with bands.

    Its weighted rms stand above it where the figure is wide enough.
    """
    _draw(found, channel, ax, level, _ends(found, level))
    ax.legend(loc="best", fontsize="x-small", framealpha=0.8)


def _ends(found: Ride, level: Ratio) -> tuple[RealArray, RealArray] | None:
    """Return the ends of the densities of a car; those of a record are of the means that are drawn."""
    return None if found.road is None else found.density_interval(level)


def _draw(found: Ride, channel: str, ax: Axes, level: Ratio, ends: tuple[RealArray, RealArray] | None) -> None:
    colours, at = colours_of(found), found.channels.index(channel)
    use = (found.hertz >= LOWEST_FELT) & (found.hertz <= HIGHEST_FELT)
    hertz, row = found.hertz[use], found.density[at, use]
    if ends is None:
        hertz, row, std = _averaged(hertz, row, found.density_band[at, use])
        low, high = power_ends(row, std, level)
    else:
        low, high = (side[at, use] for side in ends)
    kinds: list[tuple[str | None, Colour, float]] = [(None, Colour.PALE, 1.6)]
    kinds += [(kind, colours[kind], 1.2) for kind in found.weightings[channel]]
    for kind, colour, width in kinds:
        gain = np.ones_like(row) if kind is None else np.abs(weighting(kind, hertz)) ** 2
        if np.any(high > low):
            ax.fill_between(hertz, low * gain, high * gain, color=colour, alpha=0.3, linewidth=0.0)
        ax.plot(hertz, row * gain, color=colour, linewidth=width, label=kind or "not weighted")
    _logarithmic(ax, float(np.max(row)))
    entitle(ax, shown(channel))
    turn = found.units[found.figures.index(f"{channel}.{found.weightings[channel][0]}")].removesuffix("/s2")
    label, low_panel = density_label(f"{turn}/s²"), ax.get_window_extent().height < LABEL_HEIGHT * ax.figure.dpi
    ax.set_ylabel(label.replace(" ", "\n") if low_panel else label, fontsize="x-small" if low_panel else None)
    ax.set_xscale("log")
    ax.grid(color=Colour.SHADE, linewidth=0.6)
    ax.set(xlabel="frequency [Hz]", xlim=(float(hertz[0]), float(hertz[-1])))
    frequency_ticks(ax.xaxis, float(hertz[-1] / hertz[0]))
    if ax.figure.bbox.width / ax.figure.dpi < ROOM_FOR_FIGURES:
        return
    figures = found.interval(level)
    text = ", ".join(
        f"{kind} {_with_ends(found[f'{channel}.{kind}'], figures[f'{channel}.{kind}'])}"
        for kind in found.weightings[channel]
    )
    ax.annotate(f"rms {text}", (1.0, 1.0), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points",
                ha="right", fontsize="small")  # fmt: skip


def colours_of(found: Ride) -> dict[str, Colour]:
    """Return the colour of each weighting."""
    kinds = dict.fromkeys(kind for kinds in found.weightings.values() for kind in kinds)
    return dict(zip(kinds, CHANNEL_COLOURS, strict=False))


def _with_ends(value: float, ends: tuple[float, float]) -> str:
    """Return a figure with the ends of its interval, if it has one."""
    low, high = ends
    return f"{value:.2g}" if not high > low else f"{value:.3g} ({low:.3g} to {high:.3g})"


def _averaged(hertz: RealArray, density: RealArray, std: RealArray) -> tuple[RealArray, RealArray, RealArray]:
    """Return frequencies, density and standard deviation of a record; lines within a part of an octave as their mean.

    Neighbours share what their windows have in common.
    """
    band = np.floor(BANDS_AN_OCTAVE * np.log2(hertz / hertz[0]))
    first = np.flatnonzero(np.diff(band, prepend=-1.0))
    count = np.diff(first, append=len(hertz))
    mean, middle = np.add.reduceat(density, first) / count, np.add.reduceat(hertz, first) / count
    variance = std**2
    for apart, shared in enumerate(HANN_SHARED, start=1):
        same = band[apart:] == band[:-apart]
        variance[:-apart] += 2 * shared * np.where(same, std[apart:] * std[:-apart], 0.0)
    return middle, mean, np.sqrt(np.add.reduceat(variance, first)) / count


def _logarithmic(ax: Axes, top: float) -> None:
    ax.set_yscale("log")
    high = 10 ** np.ceil(np.log10(top or 1.0))
    ax.set_ylim(float(high) * 10.0**-DECADES_DRAWN, float(high))
    decade_ticks(ax.yaxis, 10.0**DECADES_DRAWN)
