"""The ride of a car or a record: spectra of its accelerations, plain and weighted, and the weightings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.performance import weighting
from suspid.reporting.axes import decade_ticks, frequency_ticks, keep_apart, key_above, shown
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.results import check_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from suspid.performance import Ride

# Accelerations on one page, and decades of a spectrum below its peak that are drawn.
MOST_SPECTRA, DECADES_DRAWN = 5, 5


def plot_ride(found: Ride, figure: Figure) -> Figure:
    """Draw the weightings of ISO 2631-1 and, of each acceleration, its spectral density with and without them.

    Parameters
    ----------
    found : Ride
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
    >>> from suspid import quarter_car, ride
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> page = plot_ride(ride(car, road="C", speed=20.0), Figure())
    >>> [ax.get_title(loc="left") for ax in page.axes]
    ['weightings', 'chassis_acceleration']
    """
    check_kind(found, {"Ride": "ride"})
    keep_apart(figure)
    channels = found.channels[:MOST_SPECTRA]
    axes = np.atleast_1d(figure.subplots(1 + len(channels), 1, sharex=True))
    kinds = list(dict.fromkeys(kind for kinds in found.weightings.values() for kind in kinds))
    colours = dict(zip(kinds, CHANNEL_COLOURS, strict=False))
    use = _drawn(found)
    hertz = found.hertz[use]
    for kind, colour in colours.items():
        decibel = 20 * np.log10(np.maximum(np.abs(weighting(kind, hertz)), 1e-6))
        axes[0].plot(hertz, decibel, color=colour, linewidth=1.2, label=kind)
    axes[0].plot([], [], color=Colour.PALE, linewidth=1.6, label="not weighted")
    axes[0].set(ylabel="[dB]", ylim=(-50, 5))
    axes[0].set_title("weightings", loc="left")
    key_above(axes[0])
    for ax, channel in zip(axes[1:], channels, strict=True):
        draw_spectrum(found, channel, ax)
        ax.set_xlabel("")
    axes[0].grid(color=Colour.SHADE, linewidth=0.6)
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def draw_spectrum(found: Ride, channel: str, ax: Axes) -> None:
    """Draw the spectral density of an acceleration with and without its weightings."""
    kinds = list(dict.fromkeys(kind for kinds in found.weightings.values() for kind in kinds))
    colours = dict(zip(kinds, CHANNEL_COLOURS, strict=False))
    use = _drawn(found)
    hertz, row = found.hertz[use], found.density[found.channels.index(channel), use]
    ax.plot(hertz, row, color=Colour.PALE, linewidth=1.6)
    for kind in found.weightings[channel]:
        ax.plot(hertz, row * np.abs(weighting(kind, hertz)) ** 2, color=colours[kind], linewidth=1.2)
    _logarithmic(ax, float(np.max(row)))
    ax.set_title(shown(channel), loc="left")
    turn = found.units[found.figures.index(f"{channel}.{found.weightings[channel][0]}")].removesuffix("/s2")
    ax.set_ylabel(f"[({turn}/s²)²/Hz]")
    text = ", ".join(f"{kind} {found[f'{channel}.{kind}']:.2g}" for kind in found.weightings[channel])
    ax.annotate(f"rms {text}", (1.0, 1.0), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points",
                ha="right", fontsize="small")  # fmt: skip
    ax.set_xscale("log")
    ax.grid(color=Colour.SHADE, linewidth=0.6)
    ax.set(xlabel="frequency [Hz]", xlim=(float(hertz[0]), float(hertz[-1])))
    frequency_ticks(ax.xaxis, float(hertz[-1] / hertz[0]))


def _drawn(found: Ride) -> NDArray[np.bool_]:
    """Return which frequencies are drawn: those that a weighting can feel."""
    return np.asarray((found.hertz >= 0.05) & (found.hertz <= 200))


def _logarithmic(ax: Axes, top: float) -> None:
    ax.set_yscale("log")
    high = 10 ** np.ceil(np.log10(top or 1.0))
    ax.set_ylim(float(high) * 10.0**-DECADES_DRAWN, float(high))
    decade_ticks(ax.yaxis, 10.0**DECADES_DRAWN)
