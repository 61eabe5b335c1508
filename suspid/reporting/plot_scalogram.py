"""Scalogram: the modulus of the wavelet transform over time and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from suspid.arguments import explained
from suspid.reporting.axes import entitle, frequency_ticks, pieces_across, position, shown, thinned
from suspid.reporting.colours import Colour
from suspid.reporting.thinning import pooled, power_weights, row_edges
from suspid.results import check_kind
from suspid.units import RealArray
from suspid.wavelets import Ridge

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.model import ModalSet
    from suspid.wavelets import Scalogram


@explained
def plot_scalogram(
    scalogram: Scalogram,
    *,
    ax: Axes,
    ridges: Sequence[Ridge] = (),
    modes: ModalSet | None = None,
    channel: str | None = None,
    decibels: float = 60.0,
    colorbar: bool = True,
) -> Axes:
    """Draw the modulus of the transform over time and frequency, with ridges and the cone of influence.

    Parameters
    ----------
    scalogram : Scalogram
        The transform.
    ax : matplotlib.axes.Axes
        Where to draw.
    ridges : sequence of Ridge
        Each is drawn at its frequency over its trusted window. The frequency of largest modulus near it is drawn
        from the onset of the decay to the end of the window, where it is not nearer to another ridge.
    modes : ModalSet, optional
        Modes whose damped frequencies are marked and numbered at the right edge.
    channel : str, optional
        The channel to show. Default: the root of the sum of squares of all channels, each divided by its own
        root mean square.
    decibels : float
        Range of the colours below the largest modulus [dB].
    colorbar : bool
        Whether to draw a colour bar next to the Axes.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Raises
    ------
    InputError
        If there is no such channel.

    Examples
    --------
    >>> import control, numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import cwt
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = control.TimeResponseData(t, np.exp(-t) * np.cos(40 * t), issiso=True, output_labels=["seat"])
    >>> ax = plot_scalogram(cwt(decay, omega=np.geomspace(10, 100, 50), bandwidth=8.0), ax=Figure().subplots())
    >>> ax.get_ylabel()
    'frequency [Hz]'
    """
    check_kind(scalogram, {"Scalogram": "cwt"})
    signal = scalogram.signal
    start, end = signal.start, signal.start + signal.duration
    order = np.argsort(scalogram.omega)
    hertz = np.asarray(scalogram.omega)[order] / (2 * np.pi)
    # Most columns of the picture: more than a page can show, and few enough to be drawn at once.
    columns = min(800, 2 * pieces_across(ax), signal.values.shape[1])
    # Half a step earlier, so that a sample lies in the middle of its column.
    edges = np.linspace(start, end, columns + 1) - signal.step / 2
    modulus = pooled(scalogram, _channel_weights(scalogram, channel), edges)[order]
    largest = np.max(modulus) or 1.0
    level = 20 * np.log10(np.maximum(modulus / largest, 10 ** (-decibels / 20)))
    mesh = ax.pcolormesh(edges, row_edges(hertz), level, cmap="Blues", vmin=-decibels, vmax=0.0, rasterized=True)
    _draw_cone(ax, hertz, scalogram.cone[order], start, end)
    _draw_ridges(ax, ridges)
    ax.set(xlim=(start, end), yscale="log", xlabel="time [s]", ylabel="frequency [Hz]")
    low, high = row_edges(hertz)[[0, -1]]
    ax.set_ylim(low, high)
    frequency_ticks(ax.yaxis, high / low)
    right = ax.secondary_yaxis("right", functions=(_radian_per_second, _hertz))
    right.set_ylabel("angular frequency [rad/s]")
    frequency_ticks(right.yaxis, high / low)
    entitle(ax, "all channels" if channel is None else shown(channel))
    if modes is not None:
        _mark_modes(ax, modes)
    # The bar with its label takes an inch next to the Axes, the labels of the right scale included.
    _key(ax, 1.0 if colorbar else 0.0)
    if colorbar:
        bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02, aspect=30)
        bar.set_label("modulus [dB of the largest]")
    return ax


def _key(ax: Axes, taken: float) -> None:
    """Put the key above the Axes where it fits next to their title, else below them in two columns or one.

    Of their width, the layout will take some for what stands beside them [inch].
    """
    from matplotlib.transforms import ScaledTranslation

    if not ax.get_legend_handles_labels()[1]:
        return
    box, inch = ax.get_window_extent(), ax.figure.dpi
    # The label and the ticks below the Axes take 0.45 inch, the title next to the key 0.8 inch.
    below = ax.transAxes + ScaledTranslation(0.0, -0.45, ax.figure.dpi_scale_trans)
    look: dict[str, Any] = {"fontsize": "small", "frameon": False, "borderaxespad": 0.0}
    beside_title = (0.8 + taken) * inch
    places = [
        ({"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 4}, beside_title),
        ({"loc": "upper left", "bbox_to_anchor": (0.0, 0.0), "bbox_transform": below, "ncols": 2}, taken * inch),
        ({"loc": "upper left", "bbox_to_anchor": (0.0, 0.0), "bbox_transform": below, "ncols": 1}, 0.0),
    ]
    for place, room in places:
        # The layout would make the Axes narrower for a key that is wider than they are.
        if ax.legend(**place, **look).get_window_extent().width + room < box.width:
            return


def _draw_cone(ax: Axes, hertz: RealArray, cone: RealArray, start: float, end: float) -> None:
    """Shade where the wavelet reaches beyond an end of the record, up to the middle where both cones meet."""
    half = (end - start) / 2
    for side, sign in ((start, 1), (end, -1)):
        reach = side + sign * np.minimum(cone, half)
        ax.fill_betweenx(hertz, side, reach, color=Colour.GREY, alpha=0.25, linewidth=0.0, zorder=2)
        label = "cone of influence" if side == start else None
        ax.plot(side + sign * cone, hertz, color=Colour.GREY, linewidth=0.9, linestyle=":", label=label)


def _draw_ridges(ax: Axes, ridges: Sequence[Ridge]) -> None:
    for i, ridge in enumerate(ridges):
        sought = (ridge.timepts >= ridge.onset) & (ridge.timepts <= ridge.window.stop)
        trace = np.where(sought & _own(ridge, ridges), ridge.trace, np.nan) / (2 * np.pi)
        label = None if i else "largest modulus nearby"
        ax.plot(*thinned(ax, ridge.timepts, trace), color=Colour.BLACK, linewidth=0.7, label=label)
        window, at = [ridge.window.start, ridge.window.stop], ridge.omega / (2 * np.pi)
        label = None if i else "ridge, trusted window"
        ax.plot(window, [at, at], color=Colour.VERMILION, linewidth=2.0, label=label)


def _own(ridge: Ridge, ridges: Sequence[Ridge]) -> NDArray[np.bool_]:
    """Return where the trace of a ridge is not nearer to another one."""
    away = [np.abs(np.log(ridge.trace / other.omega)) for other in ridges]
    return np.asarray(np.abs(np.log(ridge.trace / ridge.omega)) <= np.min(away, axis=0))


def _mark_modes(ax: Axes, modes: ModalSet) -> None:
    """Mark the damped frequency of each mode at the right edge, whether it has a ridge or not."""
    hertz = modes.poles.imag / (2 * np.pi)
    (low, high), end = ax.get_ylim(), ax.get_xlim()[1]
    numbers = np.flatnonzero((hertz > low) & (hertz < high))
    if not numbers.size:
        return
    at = np.full(numbers.size, end)
    ax.plot(at, hertz[numbers], color=Colour.GREEN, marker="<", linestyle="none", label="mode", clip_on=False)
    heights = ax.transData.transform(np.column_stack([at, hertz[numbers]]))[:, 1] * 72 / ax.figure.dpi
    # A number in its box takes 16 points with its gap.
    for k, place in zip(numbers, _places(heights), strict=True):
        ax.annotate(
            f"{k + 1}", (end, hertz[k]), xytext=(-8 - 16 * place, 0), textcoords="offset points", ha="right",
            va="center", fontsize="small", color=Colour.BLACK,
            bbox={"facecolor": Colour.WHITE, "edgecolor": Colour.GREEN, "linewidth": 0.6, "pad": 1.5},
        )  # fmt: skip


def _places(heights: RealArray) -> list[int]:
    """Return for numbers at ascending heights how many stand between each and the edge, so that none lies on another.

    Examples
    --------
    >>> _places(np.array([0.0, 5.0, 18.0, 100.0]))
    [0, 1, 0, 0]
    """
    places, tops = [], list[float]()
    for height in heights.tolist():
        # A box is 14 points high: nearer numbers stand side by side.
        free = next((k for k, top in enumerate(tops) if height - top >= 14), len(tops))
        tops[free : free + 1] = [height]
        places.append(free)
    return places


def _channel_weights(scalogram: Scalogram, channel: str | None) -> RealArray:
    if channel is None:
        return power_weights(scalogram)
    chosen = np.zeros(len(scalogram.channels))
    chosen[position(channel, scalogram.channels)] = 1.0
    return chosen


def _radian_per_second(hertz: ArrayLike) -> RealArray:
    return 2 * np.pi * np.asarray(hertz, float)


def _hertz(radian_per_second: ArrayLike) -> RealArray:
    return np.asarray(radian_per_second, float) / (2 * np.pi)
