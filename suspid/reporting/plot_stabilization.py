"""The stabilisation diagram: poles of every model order over frequency, before the spectrum of the record."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import RecordLike, as_record
from suspid.identification import Identification, Stabilization, stabilization
from suspid.reporting.axes import IN_VIEW, key_above
from suspid.reporting.colours import Colour
from suspid.signals import PASSED, as_signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


@explained
def plot_stabilization(found: Identification | Stabilization | RecordLike, ax: Axes, *, most: int = 40) -> Axes:
    """Draw the poles of every model order over frequency, marked where they are stable; see `stabilization`.

    Behind them stands the spectrum of the record, all channels together; lines mark the modes that were identified.

    Parameters
    ----------
    found : Identification, Stabilization, or a record
        Its record, or one by itself.
    ax : matplotlib.axes.Axes
        Where to draw.
    most : int
        Highest order.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> plot_stabilization(record, Figure().subplots(), most=8).get_ylabel()
    'order: number of poles'
    """
    hertz = found.modes.wn / (2 * np.pi) if isinstance(found, Identification) else np.empty(0)
    if isinstance(found, Stabilization):
        diagram = found
    elif isinstance(found, Identification) and len(hertz):
        highest = min(IN_VIEW * float(hertz.max()), PASSED / as_signal(found.response).step)
        diagram = stabilization(found.response, most=most, highest_hz=highest)
    else:
        diagram = stabilization(found.response if isinstance(found, Identification) else as_record(found), most=most)
    if diagram.hertz.size:
        _draw_spectrum(ax, diagram)
    for one in hertz.tolist():
        ax.axvline(one, color=Colour.PALE, linewidth=1.0, zorder=0)
    _draw_poles(ax, diagram)
    frequencies = np.abs(np.concatenate(diagram.poles)) / (2 * np.pi)
    end = float(diagram.hertz[-1] if diagram.hertz.size else 1.05 * frequencies.max(initial=0.0)) or 1.0
    ax.set(xlabel="frequency [Hz]", ylabel="order: number of poles", xlim=(0.0, end))
    if not len(hertz):
        # Beside lines that mark modes, lines of a grid would be taken for more of them.
        ax.grid(visible=True, axis="x", color=Colour.PALE, linewidth=0.4)
    ax.set_ylim(0, diagram.orders[-1] + 2)
    key_above(ax)
    return ax


def _draw_poles(ax: Axes, found: Stabilization) -> None:
    order = np.repeat(found.orders, [len(poles) for poles in found.poles])
    hertz = np.abs(np.concatenate(found.poles)) / (2 * np.pi)
    for chosen, label, marker, colour, face in _kinds(found):
        ax.plot(hertz[chosen], order[chosen], marker, color=colour, markerfacecolor=face, markersize=4.0, label=label)


def _kinds(found: Stabilization) -> list[tuple[NDArray[np.bool_], str, str, str, str]]:
    """Return which poles are of each kind, with its label, marker, colour and filling."""
    in_wn, in_zeta = np.concatenate(found.stable_wn), np.concatenate(found.stable_zeta)
    return [
        (~in_wn, "not stable", "x", Colour.PALE, Colour.PALE),
        (in_wn & ~in_zeta, "stable in frequency", "o", Colour.BLUE, "none"),
        (in_zeta, "and damping", "o", Colour.GREEN, Colour.GREEN),
    ]


def _draw_spectrum(ax: Axes, found: Stabilization) -> None:
    """Draw the spectrum of the record on an axis of its own behind the poles."""
    behind = ax.twinx()
    behind.plot(found.hertz, found.decibel, color=Colour.GREY, linewidth=0.5)
    behind.set(ylabel="spectrum [dB of its peak]", ylim=(-80.0, 3.0))
    ax.set_zorder(behind.get_zorder() + 1)
    ax.patch.set_visible(False)


def plot_stabilization_page(found: Stabilization, figure: Figure) -> None:
    """Draw the diagram, and below it the damping of the poles that are stable in frequency."""
    upper, lower = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    plot_stabilization(found, upper)
    upper.set_xlabel("")
    hertz = np.abs(np.concatenate(found.poles)) / (2 * np.pi)
    zeta = -np.cos(np.angle(np.concatenate(found.poles)))
    for chosen, _, marker, colour, face in _kinds(found)[1:]:
        lower.plot(hertz[chosen], zeta[chosen], marker, color=colour, markerfacecolor=face, markersize=4.0)
    lower.set(xlabel="frequency [Hz]", ylabel="damping ratio [1]", yscale="log")
    lower.grid(visible=True, color=Colour.PALE, linewidth=0.4)
