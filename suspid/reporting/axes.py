"""Common parts of plots: names as plain text, lines of long records, ticks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.errors import InputError
from suspid.files import printable
from suspid.reporting.colours import Colour
from suspid.reporting.thinning import PIECES, extremes
from suspid.units import SUPERSCRIPT, RealArray
from suspid.values import nearest_names

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.text import Text

# Pieces of a long line for each inch of the figure's width, each drawn by its two extremes: about one for each pixel
# of a screen. Fewer show steps; more make the file larger.
PIECES_AN_INCH = 100


def keep_apart(figure: Figure) -> None:
    """Let matplotlib keep the labels of a figure apart, unless it has a layout engine of its own."""
    if figure.get_layout_engine() is None:
        figure.set_layout_engine("constrained")


# Width of Axes once their labels have room, over that before.
LAID_OUT = 0.85
# Height of a panel for each of its ticks [inch].
TICK_ROOM = 0.4

# Characters of a name in a legend, and the unit that may stand behind it.
IN_LEGEND, UNIT_BEHIND = 16, re.compile(r"\s*(?:\[[^\[\]]*\]|\([^()]*\))$")

# Highest frequency in view, over that of the highest mode.
IN_VIEW = 2.5


def entitle(ax: Axes, title: str) -> None:
    """Put a title above the left end of some Axes; one that would leave the figure, or their cell, is broken."""
    text = ax.set_title(title, loc="left", wrap=True)
    spec = ax.get_subplotspec()
    grid = None if spec is None else spec.get_gridspec()
    if spec is None or grid is None or spec.colspan.stop == grid.ncols:
        return
    # Beside Axes to the right there is room up to these.
    room = 0.9 * ax.figure.bbox.width * len(spec.colspan) / grid.ncols
    _break(text, room)


def label_within(ax: Axes, label: str) -> None:
    """Put a label below some Axes; one that is wider than these is broken, as labels beside it may be as wide."""
    _break(ax.set_xlabel(label), LAID_OUT * ax.get_window_extent().width)


def _break(text: Text, room: float) -> None:
    """Break a text between words into lines that are no wider than the room [dots]."""
    width, words = text.get_window_extent().width, text.get_text()
    if width > room:
        text.set_text("\n".join(wrap(words, max(1, int(len(words) * room / width)), break_long_words=False)))


def pieces_across(ax: Axes) -> int:
    """Return how many pieces of a line the figure of some Axes can show."""
    return int(min(PIECES, PIECES_AN_INCH * ax.figure.bbox.width / ax.figure.dpi))


def thinned(ax: Axes, x: RealArray, y: RealArray) -> tuple[RealArray, RealArray]:
    """Return the samples of a line, or the extremes of its pieces where there are more than the figure can show."""
    return extremes(x, y, pieces=pieces_across(ax))


def position(name: str, channels: Sequence[str]) -> int:
    """Return the number of a channel.

    Raises
    ------
    InputError
        If there is no such channel.
    """
    if name not in channels:
        raise InputError(f"there is no channel {name!r}.{nearest_names(name, channels)}")
    return list(channels).index(name)


def checked_grid(axes: object, shape: tuple[int, ...]) -> NDArray[np.object_]:
    """Return the Axes as an array of this shape.

    Raises
    ------
    InputError
        If they have another shape.
    """
    grid = np.asarray(axes, dtype=object)
    if grid.shape != shape:
        raise InputError(f"axes must be an array of {' x '.join(map(str, shape))} Axes; got the shape {grid.shape}")
    return grid


def shown(name: str, *, most: int = 32) -> str:
    r"""Return a name as text that matplotlib shows as it stands: no mathematics, no characters without a glyph.

    Examples
    --------
    >>> print(shown("seat $x^2$\x07"))
    seat \$x^2\$\x07
    """
    from matplotlib.font_manager import FontProperties, findfont, get_font

    families = FontProperties().get_family()
    fonts = [get_font(findfont(FontProperties(family=[family]))).get_charmap() for family in families]
    short = name if len(name) <= most else name[: most - 1] + "…"
    known = "".join(c if any(ord(c) in font for font in fonts) else ascii(c)[1:-1] for c in printable(short))
    return known.replace("$", r"\$")


def in_legend(name: str) -> str:
    """Return the name for a legend, without its unit and its middle where it is long.

    matplotlib omits names that begin with an underscore.

    Examples
    --------
    >>> in_legend("Acceleration a_x [m/s^2]"), in_legend("Linear Acceleration x (m/s^2)")
    ('Acceleration a_x', 'Linear …ration x')
    """
    short = name if len(name) <= IN_LEGEND else UNIT_BEHIND.sub("", name)
    half = IN_LEGEND // 2
    text = shown(short if len(short) <= IN_LEGEND else f"{short[: half - 1]}…{short[-half:]}")
    return f" {text}" if text.startswith("_") else text


def frequency_ticks(axis: Axis, ratio: float) -> None:
    """Label 1, 2, 5 of each decade, 1 alone where there is no room; below a factor of 8, evenly spaced frequencies."""
    from matplotlib.ticker import AutoLocator, FuncFormatter, LogLocator, NullLocator

    decades = float(np.log10(ratio))
    room = axis.axes.get_window_extent().width / axis.axes.figure.dpi
    # A number takes 0.36 inch.
    crowded = axis is axis.axes.xaxis and room < 3 * decades * 0.36
    subs = (1.0,) if crowded and decades >= 2 else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=subs) if ratio > 8 else AutoLocator())
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def decade_ticks(axis: Axis, ratio: float) -> None:
    """Label the powers of ten of a logarithmic axis; over less than two decades, 1, 2, 5 of each."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    if ratio < 100:
        return frequency_ticks(axis, ratio)
    room = axis.axes.get_window_extent()
    long = (room.height if axis is axis.axes.yaxis else room.width) / axis.axes.figure.dpi
    # A power of ten takes 0.2 inch with the space to the next.
    axis.set_major_locator(LogLocator(numticks=int(np.clip(long / 0.2, 2, 5))))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: power_of_ten(round(float(np.log10(value))))))
    return None


def power_of_ten(exponent: int) -> str:
    """Return a power of ten in print.

    Examples
    --------
    >>> power_of_ten(-3)
    '10⁻³'
    """
    return f"10{str(exponent).translate(SUPERSCRIPT)}"


def unit_ticks(ax: Axes, unit: str) -> None:
    """Label the vertical axis with the unit; a power of a thousand in the label keeps the numbers short.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().subplots()
    >>> _ = ax.plot([0.0, 4e-6])
    >>> unit_ticks(ax, "m")
    >>> ax.get_ylabel()
    '[10⁻⁶ m]'
    """
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    largest = max(abs(end) for end in ax.get_ylim())
    power = 0 if 0.1 <= largest < 1e4 else 3 * int(np.floor(np.log10(max(largest, 1e-300)) / 3))
    room = ax.get_window_extent().height / ax.figure.dpi / TICK_ROOM
    # Two ticks alone tell neither middle nor ends; a low panel has no room for more.
    least = 3 if room > 2 else 2
    ax.yaxis.set_major_locator(MaxNLocator(int(np.clip(room, 3, 6)), steps=(1, 2, 2.5, 5, 10), min_n_ticks=least))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 10.0**power:.10g}".replace("-", "−")))
    ax.set_ylabel(f"[{power_of_ten(power)} {unit}]" if power else f"[{unit}]")


def label_below(axes: Iterable[Axes], label: str) -> None:
    """Label the horizontal axis of each panel with none of the others below it, as of panels side by side.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> axes = list(Figure().subplots(2, 2).flat)
    >>> label_below(axes[:3], "time [s]")
    >>> [ax.get_xlabel() for ax in axes]
    ['', 'time [s]', 'time [s]', '']
    """
    drawn = list(axes)
    for ax in drawn:
        own = ax.get_position()
        # A hundredth of a panel is less than any gap between two.
        slack = 0.01 * min(own.width, own.height)
        below = [one.get_position() for one in drawn if one is not ax and one.figure is ax.figure]
        if not any(one.y1 < own.y0 + slack and one.x0 < own.x1 - slack and own.x0 < one.x1 - slack for one in below):
            ax.set_xlabel(label)


def plot_residual(ax: Axes, time: RealArray, record: RealArray, fit: RealArray, residual: RealArray) -> None:
    """Draw a channel of a record, what a fit explains of it, and the residual."""
    for values, label, colour, width in (
        (record, "record", Colour.PALE, 2.0),
        (fit, "fit", Colour.BLUE, 0.8),
        (residual, "residual", Colour.VERMILION, 0.8),
    ):
        ax.plot(*thinned(ax, time, values), color=colour, linewidth=width, label=label)


def key_above(ax: Axes, *, abreast: int = 3) -> None:
    """Put the key to the lines of some Axes above them, at the right; inside where the title leaves no room."""
    entries = min(abreast, len(ax.get_legend_handles_labels()[1]))
    width = ax.get_window_extent().width
    # An entry and its part of the title beside it take 1.1 inch.
    if width < 1.1 * ax.figure.dpi * entries:
        _key_inside(ax)
        return
    key = ax.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize="small", ncols=abreast, frameon=False, borderaxespad=0.0
    )
    said = ax.get_title(loc="left")
    title = next((part for part in ax.get_children() if said and getattr(part, "get_text", str)() == said), None)
    if title is not None and title.get_window_extent().width + key.get_window_extent().width > LAID_OUT * width:
        _key_inside(ax)


def _key_inside(ax: Axes) -> None:
    """Put the key where it hides least; over a transform at its top right, where a decay has gone first.

    Every cell of a transform would be asked for room, which takes longer than to draw all.
    """
    from matplotlib.collections import QuadMesh

    mesh = any(isinstance(part, QuadMesh) for part in ax.collections)
    ax.legend(loc="upper right" if mesh else "best", fontsize="x-small", framealpha=0.8)


def without_legend(ax: Axes) -> Axes:
    """Remove the legend of some Axes, if there is one, and return them."""
    legend: Artist | None = ax.get_legend()
    if legend is not None:
        legend.remove()
    return ax
