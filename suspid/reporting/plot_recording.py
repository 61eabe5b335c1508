"""A whole recording, with the decays found in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.reporting.axes import entitle, position, shown, thinned, unit_ticks
from suspid.reporting.colours import Colour
from suspid.signals import as_signal
from suspid.units import Second

if TYPE_CHECKING:
    import control
    from matplotlib.axes import Axes

# Numbers of decays stand in at most this many rows; a number takes this width [inch].
TEXT_ROWS = 4


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
