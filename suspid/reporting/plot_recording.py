"""A whole recording, with the decays found in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import Cleaned
from suspid.decays import Decays
from suspid.recordings import RawChannel
from suspid.reporting.axes import entitle, position, shown, thinned, unit_ticks
from suspid.reporting.colours import Colour
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Second

if TYPE_CHECKING:
    import control
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Numbers of decays stand in at most this many rows; a number takes this width [inch].
TEXT_ROWS = 4
# Decays that fit a picture, and channels that a page of a recording has room for.
MOST_DRAWN, MOST_PANELS = 8, 6


def plot_recording(
    record: control.TimeResponseData,
    *,
    ax: Axes,
    channel: str,
    stretches: Sequence[tuple[Second, Second]] = (),
    used: int | None = None,
    unit: str = "",
) -> Axes:
    """Draw one channel of a recording, with the decays in it shaded and numbered.

    ``stretches`` are start and end of each decay [s]; the ``used`` one is shaded green.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> record = free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0})
    >>> ax = plot_recording(record, ax=Figure().subplots(), channel="tire", stretches=[(0.0, 4.0)], unit="m")
    >>> [text.get_text() for text in ax.texts]
    ['1']
    """
    signal = as_signal(record)
    start, end = signal.start, signal.start + signal.duration
    # Decays may overlap: the one that was used is drawn last.
    for i in sorted(range(len(stretches)), key=lambda i: i == used):
        ax.axvspan(*stretches[i], color=Colour.PALE_GREEN if i == used else Colour.SHADE, linewidth=0.0)
        ax.axvline(stretches[i][0], color=Colour.GREEN, linewidth=0.6)
    at = position(channel, signal.channels)
    ax.plot(*thinned(ax, signal.timepts, signal.values[at]), color=Colour.BLUE, linewidth=0.8)
    ax.set(xlim=(start, end), xlabel="time [s]")
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.22 * (high - low))
    room = 0.25 * (end - start) * ax.figure.dpi / ax.figure.bbox.width
    for i, row in enumerate(_rows([first for first, _ in stretches], room)):
        ax.annotate(
            f"{i + 1}", (stretches[i][0], 1.0), xycoords=("data", "axes fraction"), xytext=(2, -3 - 9 * row),
            textcoords="offset points", ha="left", va="top", fontsize="small", fontweight="bold",
        )  # fmt: skip
    entitle(ax, shown(channel))
    unit_ticks(ax, shown(unit, most=8) or "unit")
    return ax


def draw_raw(channel: RawChannel, ax: Axes) -> None:
    """Draw a channel as a file holds it, in the order of its stamps; missing samples are gaps."""
    order = np.argsort(channel.timepts, kind="stable")
    ax.plot(*thinned(ax, channel.timepts[order], channel.values[order]), color=Colour.BLUE, linewidth=0.8)
    ax.set_xlabel("time [s]")
    ax.margins(x=0)
    entitle(ax, shown(channel.name))
    unit_ticks(ax, shown(channel.unit, most=8) or "unit")


def draw_cleaned(found: Cleaned, ax: Axes, channel: int = 0) -> None:
    """Draw one channel of a record that was cleaned; where a defect of it was found is shaded."""
    record = held(found, "record")
    name = as_signal(record).channels[channel]
    for one in found.findings:
        if one.channel == name and one.start is not None and one.stop is not None:
            ax.axvspan(one.start, one.stop, color=Colour.SHADE)
    plot_recording(record, ax=ax, channel=name, unit=found.units[channel])


def plot_recordings(found: Cleaned, figure: Figure) -> None:
    """Draw the channels of a record that was cleaned, one below another, as many as fit."""
    count = min(len(found.units), MOST_PANELS)
    axes = figure.subplots(count, sharex=True, squeeze=False)[:, 0]
    for k, ax in enumerate(axes):
        draw_cleaned(found, ax, k)
    for ax in axes[:-1]:
        ax.set_xlabel("")


def draw_decays(found: Decays, ax: Axes) -> None:
    """Draw from when to when each decay lasts, the best above, with its frequencies; those with doubts are light."""
    drawn = found[:MOST_DRAWN]
    for row, one in enumerate(drawn):
        face = Colour.PALE_BLUE if one.doubts else Colour.BLUE
        ax.barh(row, one.stop - one.start, left=one.start, height=0.5, color=face, edgecolor=Colour.BLUE)
        hertz = ", ".join(f"{wn / (2 * np.pi):.3g}" for wn in one.wn)
        ax.annotate(f"{hertz} Hz" if hertz else "", (one.stop, row), xytext=(4, 0), textcoords="offset points",
                    va="center", fontsize="small")  # fmt: skip
    ax.set_yticks(range(len(drawn)), [f"decay {one.rank}" for one in drawn])
    first, last = min(one.start for one in drawn), max(one.stop for one in drawn)
    # The frequencies behind the last bar stay in the picture.
    ax.set(xlabel="time [s]", xlim=(first, last + 0.25 * (last - first)), ylim=(len(drawn) - 0.5, -0.5))
    entitle(ax, "free decays; light: with doubts" if any(one.doubts for one in drawn) else "free decays")


def _rows(starts: Sequence[float], room: float) -> list[int]:
    """Return a row for each text: the first row where the text before it has ended, else the last.

    Examples
    --------
    >>> _rows([0.0, 0.5, 3.0], 1.0)
    [0, 1, 0]
    """
    rows, free = [0] * len(starts), [-np.inf] * TEXT_ROWS
    for i in np.argsort(starts, kind="stable"):
        rows[i] = next((row for row, end in enumerate(free) if end <= starts[i]), TEXT_ROWS - 1)
        free[rows[i]] = starts[i] + room
    return rows
