"""Pictures of each step, drawn on given Axes; no pyplot, no global state.

Names of channels come from files: they are shown as plain text, never as mathematics.
Long records are drawn by the extremes of their samples, so that no peak gets lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from suspid.errors import InputError
from suspid.files import printable
from suspid.model import modal_table, scaled_shapes
from suspid.reporting.thinning import PIECES as PIECES
from suspid.reporting.thinning import extremes, pooled, power_weights, row_edges
from suspid.signals import as_signal
from suspid.units import RealArray, Second
from suspid.values import nearest_names
from suspid.wavelets import ABOVE_NOISE, Ridge, fit_skeleton

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from suspid.identification import Identification
    from suspid.model import ModalSet
    from suspid.wavelets import BandwidthSearch, Scalogram

# Okabe and Ito's colours, told apart with any colour vision; yellow is left out, as it fades on paper.
BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, "#E69F00", "#56B4E9", "#000000", "#777777")
GREY = "#8C8C8C"
SHADE = "#ECECEC"
# Most columns of a scalogram's picture.
COLUMNS = 800
# A bar of this length [columns of modes] stands for the largest component of a shape.
FULL_BAR = 0.42
# On one page: panels side by side, ridges, channels, and lines of the table of modes.
ABREAST = 4
KEYS_ABREAST = 5
MOST_RIDGES = 8
MOST_CHANNELS = 8
MOST_MODES = 12
# Size in inches at which a page is made to be printed: A4.
PAGE = (8.27, 11.69)


def plot_scalogram(
    scalogram: Scalogram,
    *,
    ax: Axes,
    ridges: Sequence[Ridge] = (),
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
        Each is drawn at its frequency over its trusted window, and as the trace of largest modulus near it
        from the onset of the decay to where the window stops, wherever that is not nearer to another ridge.
    channel : str, optional
        The channel to show. Default: the root of the sum of squares of all, each over its own effective value.
    decibels : float
        How far below the largest modulus the colours reach [dB].
    colorbar : bool
        Whether a colour bar takes its place beside the Axes.

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
    signal = scalogram.signal
    start, end = signal.start, signal.start + signal.duration
    order = np.argsort(scalogram.omega)
    hertz = np.asarray(scalogram.omega)[order] / (2 * np.pi)
    # Half a step earlier, so that a sample lies in the middle of its column.
    edges = np.linspace(start, end, min(COLUMNS, signal.values.shape[1]) + 1) - signal.step / 2
    modulus = pooled(scalogram, _channel_weights(scalogram, channel), edges)[order]
    largest = np.max(modulus) or 1.0
    level = 20 * np.log10(np.maximum(modulus / largest, 10 ** (-decibels / 20)))
    mesh = ax.pcolormesh(edges, row_edges(hertz), level, cmap="Blues", vmin=-decibels, vmax=0.0, rasterized=True)
    cone = scalogram.cone[order]
    for boundary, side in ((start + cone, start), (end - cone, end)):
        ax.fill_betweenx(
            hertz, side, boundary, facecolor="none", edgecolor=GREY, hatch="////", linewidth=0.0, alpha=0.6, zorder=2
        )
        label = "cone of influence" if side == start else None
        ax.plot(boundary, hertz, color="black", linewidth=0.8, linestyle=":", label=label)
    for i, ridge in enumerate(ridges):
        sought = (ridge.timepts >= ridge.onset) & (ridge.timepts <= ridge.window.stop)
        trace = np.where(sought & _own(ridge, ridges), ridge.trace, np.nan) / (2 * np.pi)
        ax.plot(
            *extremes(ridge.timepts, trace), color="black", linewidth=0.7, label=None if i else "largest modulus near"
        )
        window, at = [ridge.window.start, ridge.window.stop], ridge.omega / (2 * np.pi)
        ax.plot(window, [at, at], color=VERMILION, linewidth=2.0, label=None if i else "ridge, where trusted")
    ax.set(xlim=(start, end), yscale="log", xlabel="time [s]", ylabel="frequency [Hz]")
    low, high = row_edges(hertz)[[0, -1]]
    ax.set_ylim(low, high)
    _frequency_ticks(ax.yaxis, high / low)
    right = ax.secondary_yaxis("right", functions=(_radian_per_second, _hertz))
    right.set_ylabel("angular frequency [rad/s]")
    _frequency_ticks(right.yaxis, high / low)
    ax.set_title("all channels" if channel is None else _shown(channel), loc="left")
    ax.legend(loc="upper right", fontsize="small", framealpha=0.9)
    if colorbar:
        bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02, aspect=30)
        bar.set_label("modulus [dB of the largest]")
    return ax


def plot_skeletons(ridges: Sequence[Ridge], *, axes: Sequence[Sequence[Axes]] | NDArray[np.object_]) -> None:
    r"""Draw modulus and phase along each ridge with the fitted lines.

    The window that the lines are fitted in is shaded. The modulus is drawn on a logarithmic scale with the
    level below which noise takes over (dotted). Of the phase is drawn what is left when each channel's phase at
    the onset and the ridge's frequency are taken off, as the whole phase would hide every deviation.

    Parameters
    ----------
    ridges : sequence of Ridge
        The ridges.
    axes : (2, ridge) of matplotlib.axes.Axes
        Where to draw: modulus above, phase below.

    Examples
    --------
    >>> import control, numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import cwt, find_ridges
    >>> t = np.arange(0, 10, 0.01)
    >>> decay = control.TimeResponseData(t, np.exp(-t) * np.cos(40 * t), issiso=True, output_labels=["seat"])
    >>> ridges = find_ridges(cwt(decay, omega=np.geomspace(10, 100, 100), bandwidth=22.0))
    >>> axes = Figure().subplots(2, len(ridges), squeeze=False)
    >>> plot_skeletons(ridges, axes=axes)
    >>> axes[1, 0].get_ylabel()
    'phase left\n[rad]'
    """
    grid = _grid(axes, (2, len(ridges)))
    for i, ridge in enumerate(ridges):
        _plot_modulus(ridge, grid[0, i])
        _plot_phase(ridge, grid[1, i])
        grid[0, i].set_title(f"ridge at {ridge.omega / (2 * np.pi):.4g} Hz", loc="left")
        if i == 0:
            grid[0, i].set_ylabel("modulus\n[√s × unit]")
            grid[1, i].set_ylabel("phase left\n[rad]")
            grid[0, i].legend(fontsize="x-small", ncols=2 if len(ridge.channels) > 3 else 1)


def plot_entropy(search: BandwidthSearch, *, ax: Axes) -> Axes:
    """Draw wavelet entropy against bandwidth, with its minimum; warn where that lies at an end of the range.

    Parameters
    ----------
    search : BandwidthSearch
        The curve.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import BandwidthSearch
    >>> search = BandwidthSearch(candidates=np.array([4.0, 8.0, 16.0]), entropy=np.array([5.0, 4.0, 4.5]))
    >>> plot_entropy(search, ax=Figure().subplots()).get_title(loc="left")
    'least entropy at N = 8'
    """
    order = np.argsort(search.candidates)
    tried, entropy = search.candidates[order], search.entropy[order]
    ax.plot(tried, entropy, color=BLUE, marker=".", markersize=4, linewidth=1.0)
    least = float(np.min(search.entropy))
    ax.plot([search.best], [least], color=VERMILION, marker="o", markersize=8, fillstyle="none", linestyle="none")
    ax.axvline(search.best, color=VERMILION, linewidth=0.8, linestyle="--")
    if tried[-1] > 100 * tried[0]:
        ax.set_xscale("log")
    ax.set(xlabel="bandwidth N [1]", ylabel="wavelet entropy [nat]")
    title = f"least entropy at N = {search.best:.4g}"
    if search.at_end:
        ax.set_title(f"{title}, an end of the range:\nthe range decided, not the record", loc="left", color=VERMILION)
    else:
        ax.set_title(title, loc="left")
    return ax


def plot_fit(
    identification: Identification,
    *,
    axes: Sequence[Axes] | NDArray[np.object_],
    channels: Sequence[str] | None = None,
    span: tuple[Second, Second] | None = None,
) -> None:
    """Draw the record of each channel with the fitted decay and what that leaves, all in the unit of the record.

    Parameters
    ----------
    identification : Identification
        What was found.
    axes : (channel,) of matplotlib.axes.Axes
        Where to draw.
    channels : sequence of str, optional
        Which channels. Default: all.
    span : (float, float), optional
        Times between which to draw [s]. Default: the whole record.

    Raises
    ------
    InputError
        If there is no such channel, or there are not as many Axes as channels.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> record = free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0})
    >>> axes = Figure().subplots(2)
    >>> plot_fit(identify(record, modes=1), axes=axes)
    >>> axes[1].get_xlabel()
    'time [s]'
    """
    from matplotlib.ticker import MaxNLocator

    record, fitted, residual = (
        as_signal(r) for r in (identification.response, identification.fitted, identification.residual)
    )
    names = record.channels if channels is None else tuple(channels)
    drawn = _grid(axes, (len(names),))
    low, high = span or (record.start, record.start + record.duration)
    kept = (record.timepts >= low) & (record.timepts <= high)
    time, share = record.timepts[kept], identification.explained
    for ax, name in zip(drawn, names, strict=True):
        at = _position(name, record.channels)
        for signal, label, colour, width in (
            (record, "record", "#BBBBBB", 2.0),
            (fitted, "fit", BLUE, 0.8),
            (residual, "residual", VERMILION, 0.8),
        ):
            ax.plot(*extremes(time, signal.values[at, kept]), color=colour, linewidth=width, label=label)
        ax.set_title(f"{_shown(name)}: {100 * share[at]:.4g} % explained", loc="left")
        ax.set(ylabel="[unit]", xlim=(low, high))
        ax.yaxis.set_major_locator(MaxNLocator(3))
    if len(names):
        drawn[-1].set_xlabel("time [s]")
        drawn[0].legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize="small", ncols=3, frameon=False, borderaxespad=0.0
        )


def plot_shapes(modes: ModalSet, *, ax: Axes) -> Axes:
    """Draw mode shapes: a column for each mode, and in it a bar for each channel.

    To the right is in phase with the largest component, to the left against it. The dark bar is the real part, the
    light one the whole amplitude; phases that are neither 0 nor 180° to within 1° are written beside.

    Parameters
    ----------
    modes : ModalSet
        Modes with shapes.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Raises
    ------
    InputError
        If the modes have no shapes.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import eigenmodes, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> ax = plot_shapes(eigenmodes(car), ax=Figure().subplots())
    >>> [label.get_text() for label in ax.get_yticklabels()]
    ['chassis', 'tire']
    """
    if modes.shapes is None:
        raise InputError("these modes have no shapes to draw: poles alone were given")
    shapes = scaled_shapes(modes.shapes)
    rows = np.arange(len(shapes))
    numbered = shapes.size <= 24
    for k, shape in enumerate(shapes.T, 1):
        amplitude = np.where(shape.real < 0, -1, 1) * np.abs(shape)
        ax.barh(rows, FULL_BAR * amplitude, left=k, height=0.5, color="#A6CEE3", edgecolor=BLUE, linewidth=0.6)
        ax.barh(rows, FULL_BAR * shape.real, left=k, height=0.5, color=BLUE)
        ax.plot([k, k], [-0.5, len(shapes) - 0.5], color="black", linewidth=0.8)
        for row, component in enumerate(shape):
            degrees = float(np.degrees(np.angle(component)))
            if numbered and abs(component) > 0.01 and 1.0 < abs(degrees) < 179.0:
                # On the far side of the axis, where there is no bar.
                side = "right" if component.real >= 0 else "left"
                offset = -0.03 if side == "right" else 0.03
                ax.text(k + offset, row, f"{degrees:.0f}°".replace("-", "−"), ha=side, va="center", fontsize="x-small")
    count = len(modes)
    for k in range(1, count):
        ax.axvline(k + 0.5, color=SHADE, linewidth=0.8)
    ax.set(xlim=(0.5, count + 0.5), ylim=(len(shapes) - 0.5, -0.5))
    ax.set_xticks(range(1, count + 1), [f"{wn / (2 * np.pi):.4g}" for wn in modes.wn])
    ax.set_yticks(rows, [_shown(name, most=16) for name in modes.channels])
    ax.set_xlabel("natural frequency of the mode [Hz]")
    ax.set_title("shapes [1 = largest]", loc="left")
    return ax


def plot_identification(identification: Identification, figure: Figure) -> Figure:
    """Draw a page: modes, scalogram with ridges, skeletons, record with fit, entropy and shapes.

    What there is nothing of (ridges, a search for the bandwidth, shapes of several channels) is left out.

    Parameters
    ----------
    identification : Identification
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure; made for ``Figure(figsize=PAGE)``, that is A4 upright.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> record = free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0})
    >>> page = plot_identification(identify(record, modes=1), Figure(figsize=PAGE))
    >>> page.axes[1].get_ylabel()
    'frequency [Hz]'
    """
    if figure.get_layout_engine() is None:
        figure.set_layout_engine("constrained")
    modes, every_ridge = identification.modes, identification.ridges
    search, ridges = identification.bandwidth_search, every_ridge[:MOST_RIDGES]
    blocks = [ridges[i : i + ABREAST] for i in range(0, len(ridges), ABREAST)]
    names = as_signal(identification.response).channels[:MOST_CHANNELS]
    fit_rows = len(names) if len(names) <= ABREAST else -(-len(names) // 2)
    several = modes.shapes is not None and modes.shapes.size > len(modes)
    last = ["entropy"] * (search is not None) + ["shapes"] * several
    heights = {"modes": 0.25 + 0.14 * min(len(modes) + 2, MOST_MODES + 2), "scalogram": 2.7 if len(blocks) < 2 else 2.3}
    keys = 3 + (2 + len(ridges[0].channels) if ridges else 0)
    heights |= {"key": 0.2 + 0.2 * -(-keys // KEYS_ABREAST)}
    heights |= {f"skeletons {i}": 2.5 for i in range(len(blocks))}
    heights |= {"fit": 0.5 + 0.75 * fit_rows} | ({"last": max(1.6, 0.6 + 0.2 * len(modes.channels))} if last else {})
    places = _places(figure, heights)

    _write_modes(identification, figure.add_subplot(places["modes"]))
    scalogram_ax = figure.add_subplot(places["scalogram"])
    plot_scalogram(identification.scalogram, ax=scalogram_ax, ridges=every_ridge)
    _mark_modes(modes, scalogram_ax)
    explained: list[Axes] = []
    for i, block in enumerate(blocks):
        skeletons = _subplots(places[f"skeletons {i}"], 2, len(block))
        plot_skeletons(block, axes=skeletons)
        explained.append(_without_legend(skeletons[0, 0]))
    onset = min((ridge.onset for ridge in every_ridge), default=None)
    explained = [*explained[:1], _draw_fit(identification, names, onset, places["fit"], rows=fit_rows)]
    _write_key(figure.add_subplot(places["key"]), explained)
    if last:
        parts = places["last"].subgridspec(1, len(last), width_ratios=[3 if p == "shapes" else 2 for p in last])
        for i, part in enumerate(last):
            ax = figure.add_subplot(parts[i])
            if part == "shapes":
                plot_shapes(modes, ax=ax)
            elif search is not None:
                plot_entropy(search, ax=ax)
    for ax in figure.axes:
        _small_print(ax)
    return figure


def _places(figure: Figure, heights: dict[str, float]) -> dict[str, SubplotSpec]:
    """Return where each part of a page goes: below one another, or in two columns on a wide page."""
    names = list(heights)
    right = [n for n in names if n.startswith("skeletons") or n in ("key", "fit")]
    columns = [names]
    if figure.get_figwidth() > figure.get_figheight():
        columns = [[n for n in names if n not in right], right]
    places: dict[str, SubplotSpec] = {}
    outer = figure.add_gridspec(1, len(columns))
    for i, column in enumerate(columns):
        inner = outer[i].subgridspec(len(column), 1, height_ratios=[heights[n] for n in column])
        places |= {name: inner[j] for j, name in enumerate(column)}
    return places


def _own(ridge: Ridge, ridges: Sequence[Ridge]) -> NDArray[np.bool_]:
    """Return where the trace of a ridge is not nearer to another one."""
    away = [np.abs(np.log(ridge.trace / other.omega)) for other in ridges]
    return np.asarray(np.abs(np.log(ridge.trace / ridge.omega)) <= np.min(away, axis=0))


def _channel_weights(scalogram: Scalogram, channel: str | None) -> RealArray:
    if channel is None:
        return power_weights(scalogram)
    chosen = np.zeros(len(scalogram.channels))
    chosen[_position(channel, scalogram.channels)] = 1.0
    return chosen


def _radian_per_second(hertz: ArrayLike) -> RealArray:
    return 2 * np.pi * np.asarray(hertz, float)


def _hertz(radian_per_second: ArrayLike) -> RealArray:
    return np.asarray(radian_per_second, float) / (2 * np.pi)


def _plot_modulus(ridge: Ridge, ax: Axes) -> None:
    fit = fit_skeleton(ridge)
    _shade_window(ridge, ax)
    modulus = np.abs(ridge.skeleton)
    lowest = np.inf
    for i, name in enumerate(ridge.channels):
        if not np.any(modulus[i] > 0):
            continue
        colour = COLOURS[i % len(COLOURS)]
        ax.plot(*extremes(ridge.timepts, modulus[i]), color=colour, linewidth=1.6, alpha=0.6, label=_in_legend(name))
        label = None if np.isfinite(lowest) else f"{ABOVE_NOISE:g} × noise"
        level = ABOVE_NOISE * ridge.floor[i]
        ax.axhline(level, color=colour, linewidth=0.8, linestyle=":", label=label)
        line = np.exp(fit.lines[i].real)
        key = None if label is None else "fitted line"
        ax.plot(*extremes(fit.timepts, line), color="black", linewidth=0.8, linestyle="--", label=key)
        lowest = min(lowest, max(0.3 * level, 0.3 * float(line[-1])))
    largest = float(np.max(modulus))
    ax.set(yscale="log", xlim=(ridge.timepts[0], ridge.timepts[-1]))
    if largest > 0:
        ax.set_ylim(max(min(lowest, 0.1 * largest), 1e-8 * largest), 3 * largest)


def _plot_phase(ridge: Ridge, ax: Axes) -> None:
    from matplotlib.ticker import MaxNLocator

    fit = fit_skeleton(ridge)
    _shade_window(ridge, ax)
    elapsed = ridge.timepts - ridge.onset
    reference = ridge.omega * (fit.timepts - ridge.onset)
    reach = 0.05
    for i in range(len(ridge.channels)):
        phase = np.unwrap(np.angle(ridge.skeleton[i] * np.exp(-1j * ridge.omega * elapsed))) - fit.origin[i].imag
        fitted = fit.logarithm[i].imag - reference - fit.origin[i].imag
        # Unwrapping starts in the noise or in the edge: whole turns are taken from the trusted samples.
        phase += fitted[0] - phase[np.argmax(ridge.trusted)]
        ax.plot(*extremes(ridge.timepts, phase), color=COLOURS[i % len(COLOURS)], linewidth=1.6, alpha=0.6)
        clear = np.abs(ridge.skeleton[i, ridge.trusted]) > ABOVE_NOISE * ridge.floor[i]
        reach = max(reach, float(np.max(np.abs(fitted[clear]), initial=0.0)))
    line = (fit.pole.imag - ridge.omega) * (fit.timepts - ridge.onset)
    ax.plot(*extremes(fit.timepts, line), color="black", linewidth=0.8, linestyle="--")
    ax.set(xlabel="time [s]", xlim=(ridge.timepts[0], ridge.timepts[-1]), ylim=(-1.3 * reach, 1.3 * reach))
    ax.yaxis.set_major_locator(MaxNLocator(5))


def _shade_window(ridge: Ridge, ax: Axes) -> None:
    ax.axvspan(ridge.window.start, ridge.window.stop, color=SHADE, linewidth=0.0)


def _mark_modes(modes: ModalSet, ax: Axes) -> None:
    """Mark the damped frequency of each mode at the right edge, whether it has a ridge or not."""
    hertz = modes.poles.imag / (2 * np.pi)
    low, high = ax.get_ylim()
    within = hertz[(hertz > low) & (hertz < high)]
    if not within.size:
        return
    end = ax.get_xlim()[1]
    ax.plot(np.full(len(within), end), within, color=GREEN, marker="<", linestyle="none", label="mode", clip_on=False)
    ax.legend(loc="upper right", fontsize="small", framealpha=0.9)


def _write_modes(identification: Identification, ax: Axes) -> None:
    lines = modal_table(identification.modes).splitlines()
    if len(lines) > MOST_MODES + 2:
        lines = [*lines[: MOST_MODES + 1], f"  … {len(identification.modes)} modes in all"]
    ax.set_axis_off()
    ax.text(0.0, 1.0, "\n".join(lines), family="monospace", va="top", transform=ax.transAxes, fontsize=8)
    title = str(identification.response.title or "")
    ax.set_title(f"{_shown(title, most=60)} — method {identification.method}".lstrip(" —"), loc="left")


def _write_key(ax: Axes, explained: Sequence[Axes]) -> None:
    """Put the legends of some Axes together, away from the panels, whose space the lines need."""
    handles: list[Artist] = []
    labels: list[str] = []
    for panel in explained:
        more, names = panel.get_legend_handles_labels()
        handles, labels = handles + more, labels + names
    ax.set_axis_off()
    legend = ax.legend(handles, labels, loc="center", ncols=KEYS_ABREAST, borderaxespad=0.0)
    legend.set_in_layout(False)


def _draw_fit(
    identification: Identification, names: Sequence[str], onset: Second | None, spec: SubplotSpec, *, rows: int
) -> Axes:
    """Draw few channels whole and over the first cycles; many in two columns. Return the first of the Axes."""
    if len(names) > ABREAST:
        grid = _subplots(spec, rows, 2)
        plot_fit(identification, axes=grid.T.ravel()[: len(names)], channels=names)
        for ax in grid.T.ravel()[len(names) :]:
            ax.set_axis_off()
        for column in grid.T:
            column[-1].set_xlabel("time [s]")
        return _without_legend(grid[0, 0])
    grid = _subplots(spec, rows, 2, widths=[3, 2])
    signal, poles = as_signal(identification.response), identification.modes.poles
    onset = signal.start if onset is None else onset
    turning = poles.imag[poles.imag > 0]
    cycles = 6 * 2 * np.pi / np.min(turning) if len(turning) else signal.duration
    stop = min(onset + max(cycles, 20 * signal.step), signal.start + signal.duration)
    plot_fit(identification, axes=grid[:, 0], channels=names)
    plot_fit(identification, axes=grid[:, 1], channels=names, span=(onset, stop))
    for ax in grid[:, 1]:
        ax.set_title("first cycles", loc="left")
        ax.set_ylabel("")
    _without_legend(grid[0, 1])
    return _without_legend(grid[0, 0])


def _without_legend(ax: Axes) -> Axes:
    legend = ax.get_legend()
    if legend is not None:
        legend.remove()
    return ax


def _subplots(
    spec: SubplotSpec, rows: int, columns: int, *, widths: Sequence[float] | None = None
) -> NDArray[np.object_]:
    inner = spec.subgridspec(rows, columns, width_ratios=widths)
    return np.asarray(inner.subplots(sharex="col", squeeze=False), dtype=object)


def _small_print(ax: Axes) -> None:
    """Set the type sizes of a page."""
    for part in (ax, *ax.child_axes):
        part.tick_params(labelsize=7)
        part.xaxis.label.set_fontsize(8)
        part.yaxis.label.set_fontsize(8)
    for side in ("left", "center", "right"):
        ax.set_title(ax.get_title(loc=side), loc=side, fontsize=8)
    legend = ax.get_legend()
    if legend is not None:
        for text in (legend.get_title(), *legend.get_texts()):
            text.set_fontsize(7)


def _frequency_ticks(axis: Axis, ratio: float) -> None:
    """Label 1, 2, 5 of each decade; of a band too narrow for that, evenly spaced frequencies."""
    from matplotlib.ticker import AutoLocator, FuncFormatter, LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)) if ratio > 8 else AutoLocator())
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _position(name: str, channels: Sequence[str]) -> int:
    if name not in channels:
        raise InputError(f"there is no channel {name!r}.{nearest_names(name, channels)}")
    return channels.index(name)


def _grid(axes: object, shape: tuple[int, ...]) -> NDArray[np.object_]:
    grid = np.asarray(axes, dtype=object)
    if grid.shape != shape:
        raise InputError(f"axes must be an array of {' x '.join(map(str, shape))} Axes; got the shape {grid.shape}")
    return grid


def _shown(name: str, *, most: int = 32) -> str:
    r"""Return a name as text that matplotlib shows as it stands.

    Examples
    --------
    >>> print(_shown("seat $x^2$\x07"))
    seat \$x^2\$\x07
    """
    from matplotlib.font_manager import FontProperties, findfont, get_font

    families = FontProperties().get_family()
    fonts = [get_font(findfont(FontProperties(family=[family]))).get_charmap() for family in families]
    short = name if len(name) <= most else name[: most - 1] + "…"
    known = "".join(c if any(ord(c) in font for font in fonts) else ascii(c)[1:-1] for c in printable(short))
    return known.replace("$", r"\$")


def _in_legend(name: str) -> str:
    """Return the name for a legend, which leaves out what begins with an underscore."""
    shown = _shown(name, most=16)
    return f" {shown}" if shown.startswith("_") else shown
