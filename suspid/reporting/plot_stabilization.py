"""The stabilisation diagram: poles of every model order over frequency, before the spectrum of the record."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import RecordLike, as_record
from suspid.identification import Identification, Stabilization, stabilization
from suspid.reporting.axes import key_above
from suspid.reporting.colours import Colour
from suspid.signals import as_signal

if TYPE_CHECKING:
    import control
    from matplotlib.axes import Axes

# Highest frequency in view, over that of the highest mode.
IN_VIEW = 2.5


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
    highest = None
    if isinstance(found, Stabilization):
        diagram = found
    else:
        record = found.response if isinstance(found, Identification) else as_record(found)
        rate = 1 / as_signal(record).step
        highest = float(min(IN_VIEW * hertz.max(), 0.4 * rate)) if len(hertz) else 0.4 * rate
        diagram = stabilization(record, most=most, highest_hz=highest)
        _draw_spectrum(ax, record, highest)
    for one in hertz.tolist():
        ax.axvline(one, color=Colour.PALE, linewidth=1.0, zorder=0)
    _draw_poles(ax, diagram)
    frequencies = np.abs(np.concatenate(diagram.poles)) / (2 * np.pi)
    if highest is None:
        highest = float(frequencies.max(initial=0.0)) * 1.05 or 1.0
    ax.set(xlabel="frequency [Hz]", ylabel="order: number of poles", xlim=(0.0, highest))
    ax.set_ylim(0, diagram.orders[-1] + 2)
    key_above(ax)
    return ax


def _draw_poles(ax: Axes, found: Stabilization) -> None:
    order = np.repeat(found.orders, [len(poles) for poles in found.poles])
    hertz = np.abs(np.concatenate(found.poles)) / (2 * np.pi)
    in_wn, in_zeta = np.concatenate(found.stable_wn), np.concatenate(found.stable_zeta)
    for chosen, label, marker, colour, face in (
        (~in_wn, "not stable", "x", Colour.PALE, Colour.PALE),
        (in_wn & ~in_zeta, "stable in frequency", "o", Colour.BLUE, "none"),
        (in_zeta, "and damping", "o", Colour.GREEN, Colour.GREEN),
    ):
        ax.plot(hertz[chosen], order[chosen], marker, color=colour, markerfacecolor=face, markersize=4.0, label=label)


def _draw_spectrum(ax: Axes, record: control.TimeResponseData, highest: float) -> None:
    """Draw the power of all channels, each of unit power, on an axis of its own behind the poles."""
    signal = as_signal(record)
    values = signal.values - signal.values.mean(axis=1, keepdims=True)
    power = np.mean(values**2, axis=1, keepdims=True)
    spectrum = np.sum(np.abs(np.fft.rfft(values)) ** 2 / np.where(power > 0, power, 1.0), axis=0)
    frequency = np.fft.rfftfreq(values.shape[1], signal.step)
    shown = (frequency > 0) & (frequency <= highest)
    decibel = 10 * np.log10(np.maximum(spectrum[shown], 1e-300) / max(float(spectrum[shown].max(initial=0.0)), 1e-300))
    behind = ax.twinx()
    behind.plot(frequency[shown], decibel, color=Colour.GREY, linewidth=0.5)
    behind.set(ylabel="spectrum [dB of its peak]", ylim=(-80.0, 3.0))
    ax.set_zorder(behind.get_zorder() + 1)
    ax.patch.set_visible(False)
