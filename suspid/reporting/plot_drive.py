"""Plot of a recorded drive: its stretches, and the measured and fitted transmissibility."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.greybox import body_channels, wheels_of
from suspid.levels import UNLIKELY
from suspid.reporting.axes import entitle, frequency_ticks, keep_apart, shown
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.reporting.plot_damper_curve import plot_damper_curve
from suspid.results import check_kind
from suspid.signals import as_signal
from suspid.units import ComplexArray, RealArray, Second
from suspid.words import Code
from suspid.words.drives import DriveReason

if TYPE_CHECKING:
    from collections.abc import Sequence

    import control
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.analysis import DriveAnalysis
    from suspid.greybox import Drives, Estimate

REASON_COLOURS: dict[Code, Colour] = {
    DriveReason.SLOW: Colour.PALE,
    DriveReason.STANDING: Colour.PALE,
    DriveReason.BRAKING: Colour.ORANGE,
    DriveReason.CORNERING: Colour.PURPLE,
    DriveReason.SHORT: Colour.PALE_GREEN,
}
WELCH_WINDOW: Second = 8.0  # of the spectra that are drawn


@explained
def plot_drive(found: DriveAnalysis, figure: Figure) -> Figure:
    """Draw the stretches of each file over time, spectra of the channels with what was fitted, and curves of dampers.

    Parameters
    ----------
    found : DriveAnalysis
        What `analyse_drive` returned.
    figure : matplotlib.figure.Figure
        An empty figure.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import RawChannel, Recording, analyse_drive
    >>> t = np.arange(2000) / 100
    >>> still = RawChannel(name="az", unit="m/s2", timepts=t, values=1e-3 * np.sin(9 * t), rate=None)
    >>> page = plot_drive(analyse_drive(Recording(title="parked", channels=(still,))), Figure())
    >>> page.axes[0].get_xlabel()
    'time [s]'
    """
    check_kind(found, {"DriveAnalysis": "analyse_drive"})
    keep_apart(figure)
    # Files whose stretches fit on one page.
    files = found.drives[:6]
    records = [record for one in found.drives for record in one.records]
    # Curves that fit on one page.
    curves = found.curves[:2]
    heights = [1.0] * len(files) + [4.0] * bool(records) + [4.0 / len(curves) ** 0.5 for _ in curves]
    axes = np.atleast_1d(figure.subplots(len(heights), 1, height_ratios=heights))
    for ax, drives in zip(axes, files, strict=False):
        draw_stretches(ax, drives)
    axes[len(files) - 1].set_xlabel("time [s]")
    if records:
        draw_finding(found, axes[len(files)])
    for ax, curve in zip(axes[len(files) + 1 :], curves, strict=False):
        entitle(ax, f"damper of {shown(curve.name)}")
        plot_damper_curve(curve, ax)
    return figure


def draw_finding(found: DriveAnalysis, ax: Axes) -> None:
    """Draw what was found: transfers from the wheels, spectra of the body, or the stretches of the first file."""
    records = [record for one in found.drives for record in one.records]
    if found.estimate is not None:
        _draw_transmissibility(ax, found.estimate)
    elif records:
        _draw_body(ax, found, records)
    else:
        draw_stretches(ax, found.drives[0])


def draw_stretches(ax: Axes, drives: Drives) -> None:
    """Draw the speed, or where it is not known the vibration, over stretches in the colour of the reason."""
    known = np.any(np.isfinite(drives.course[:, 1]))
    times, shows = drives.course[:, 0], drives.course[:, 1 if known else 2]
    named = set[str]()
    for one in drives:
        code = one.reasons[0].code
        colour = Colour.BLUE if one.taken else REASON_COLOURS.get(code, Colour.VERMILION)
        label = "taken" if one.taken else str(code)
        ax.axvspan(one.start, one.stop, color=colour, alpha=0.25, linewidth=0, label=None if label in named else label)
        named.add(label)
    # Pauses of the logger are left open.
    after = np.flatnonzero(np.diff(times) > 1.5 * np.min(np.diff(times), initial=np.inf)) + 1
    ax.plot(np.insert(times, after, np.nan), np.insert(shows, after, np.nan), color=Colour.BLACK, linewidth=0.9)
    ax.set_ylim(bottom=0)
    ax.set_ylabel("speed [m/s]" if known else "vibration\n[m/s²]")
    if drives:
        ax.set_xlim(drives[0].start, drives[-1].stop)
    entitle(ax, shown(drives.title) or "drive")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize="small", ncols=6, frameon=False, borderaxespad=0.0)


def _draw_transmissibility(ax: Axes, found: Estimate) -> None:
    """Draw the transfers from the wheels to each other channel: measured, and of the car that was found."""
    signals = [(as_signal(fit), as_signal(left)) for fit, left in zip(found.fitted, found.residual, strict=True)]
    channels, step = signals[0][0].channels, signals[0][0].step
    on_body = set(body_channels(found.suspension, channels))
    causes = [i for i, name in enumerate(channels) if name not in on_body]
    outputs = [i for i, name in enumerate(channels) if name in on_body]
    if len(causes) != len(wheels_of(found.suspension)) or not outputs:
        return
    alike = [(fit.values, left.values) for fit, left in signals if fit.channels == channels]
    hertz, measured, std = _transfers([fit + left for fit, left in alike], step, causes, outputs)
    _, fitted, _ = _transfers([fit for fit, _ in alike], step, causes, outputs)
    low, high = _band(alike[0][0], step)
    # A transfer that is noise has a complex normal error, which exceeds this once in a thousand lines.
    told = np.abs(measured) > np.sqrt(-np.log(UNLIKELY)) * std
    told[(hertz < low) | (hertz > high)] = False
    pairs = [(o, c) for o in range(len(outputs)) for c in range(len(causes))][: len(CHANNEL_COLOURS)]
    for (o, c), colour in zip(pairs, CHANNEL_COLOURS, strict=False):
        here = told[:, o, c]
        name = f"{shown(channels[outputs[o]])} / {shown(channels[causes[c]])}"
        ax.loglog(hertz[here], np.abs(measured[here, o, c]), "o", color=colour, alpha=0.35, markersize=4, linewidth=0)
        ax.loglog(hertz, np.where(here, np.abs(fitted[:, o, c]), np.nan), color=colour, linewidth=1.2, label=name)
    frequency_ticks(ax.xaxis, high / low)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("transfer [SI]")
    entitle(ax, "transmissibility: measured (points) and fitted (lines), where beyond noise")
    ax.legend(fontsize="small", frameon=False)


def _transfers(
    rows: Sequence[RealArray], step: Second, causes: Sequence[int], outputs: Sequence[int]
) -> tuple[RealArray, ComplexArray, RealArray]:
    """Return frequencies, and transfers with their standard deviations (line, output, cause), over all windows."""
    size = round(WELCH_WINDOW / step)
    window = np.hanning(size + 2)[1:-1]
    spectra = []
    for values in rows:
        for start in range(0, values.shape[1] - size + 1, size // 2):
            part = values[:, start : start + size]
            spectra.append(np.fft.rfft((part - np.mean(part, axis=1, keepdims=True)) * window, axis=1))
    lines = np.array(spectra).transpose(2, 1, 0)  # (line, channel, window)
    g, o = lines[:, list(causes)], lines[:, list(outputs)]
    own = g @ g.conj().swapaxes(1, 2)
    own += 1e-9 * np.trace(own, axis1=1, axis2=2).real[:, None, None] * np.eye(len(causes)) + 1e-300 * np.eye(
        len(causes)
    )
    inverse = np.linalg.inv(own)
    found = np.asarray(o @ g.conj().swapaxes(1, 2) @ inverse)
    left = np.sum(np.abs(o - found @ g) ** 2, axis=2) / max(1, lines.shape[2] - len(causes))
    std = np.sqrt(left[:, :, None] * np.einsum("fcc->fc", inverse).real[:, None])
    return np.asarray(np.fft.rfftfreq(size, step), float), found, np.asarray(std)


def _band(values: RealArray, step: Second) -> tuple[float, float]:
    """Return the band outside of which fitted motion is nothing [Hz]."""
    size = min(values.shape[1], round(WELCH_WINDOW / step))
    power = np.sum(np.abs(np.fft.rfft(values[:, :size] * np.hanning(size), axis=1)) ** 2, axis=0)
    some = np.fft.rfftfreq(size, step)[power > 1e-4 * np.max(power)]
    return max(float(some[0]), 1 / WELCH_WINDOW), float(some[-1])


def _draw_body(ax: Axes, found: DriveAnalysis, records: Sequence[control.TimeResponseData]) -> None:
    """Draw the mean spectrum of each channel, and the interval of its frequency."""
    from scipy.signal import welch

    modes = {mode.channel: mode for mode in found.body or ()}
    signals = [as_signal(record) for record in records]
    for channel, colour in zip(signals[0].channels, CHANNEL_COLOURS, strict=False):
        size = round(WELCH_WINDOW / signals[0].step)
        rows = [s.values[s.channels.index(channel)] for s in signals if s.values.shape[1] >= size]
        if not rows:
            continue
        hertz = welch(rows[0], fs=1 / signals[0].step, nperseg=size)[0]
        density = np.mean([welch(row, fs=1 / signals[0].step, nperseg=size)[1] for row in rows], axis=0)
        inside = (hertz > 0.3) & (hertz < 20)
        ax.loglog(hertz[inside], density[inside], color=colour, label=shown(channel))
        mode = modes.get(channel)
        if mode is not None and mode.models:
            low, high = mode.interval()
            ax.axvspan(low, high, color=colour, alpha=0.2, label=f"{mode.hertz:.3g} Hz, 95 %")
    frequency_ticks(ax.xaxis, 20 / 0.3)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("PSD [SI²/Hz]")
    ax.legend(fontsize="small", frameon=False)
    entitle(ax, "spectra over all usable stretches")
