"""Skeletons: modulus and phase of the wavelet transform along its ridges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.reporting.axes import checked_grid, decade_ticks, in_legend, thinned
from suspid.reporting.colours import CHANNEL_COLOURS, Colour
from suspid.wavelets import ABOVE_NOISE, Ridge, SkeletonFit, fit_skeleton

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Channels named in the key: the colours of further ones repeat, and their names would take the room of the lines.
MOST_IN_KEY = len(CHANNEL_COLOURS)


@explained
def plot_skeletons(ridges: Sequence[Ridge], *, axes: Sequence[Sequence[Axes]] | NDArray[np.object_]) -> None:
    r"""Draw modulus and phase along each ridge with the fitted lines.

    The window of the fit is shaded. The modulus is drawn on a logarithmic scale, with the level below which noise
    prevails (dotted). From the phase of each channel its value at the onset and the ridge's frequency times the
    time since then are subtracted: what remains shows the deviations. Outside the
    window, phases of noise are not drawn.

    Parameters
    ----------
    ridges : sequence of Ridge
        The ridges.
    axes : (2, ridge) of matplotlib.axes.Axes
        Where to draw: modulus above, phase below.

    Raises
    ------
    InputError
        If the Axes have another shape.

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
    'detrended phase\n[rad]'
    """
    grid = checked_grid(axes, (2, len(ridges)))
    for i, ridge in enumerate(ridges):
        fit = fit_skeleton(ridge)
        for ax in grid[:, i]:
            ax.axvspan(ridge.window.start, ridge.window.stop, color=Colour.SHADE, linewidth=0.0)
        _draw_modulus(ridge, fit, grid[0, i])
        _plot_phase(ridge, fit, grid[1, i])
        grid[0, i].set_title(f"ridge at {ridge.omega / (2 * np.pi):.4g} Hz", loc="left")
        if i == 0:
            grid[0, i].set_ylabel("modulus\n[√s × unit]")
            grid[1, i].set_ylabel("detrended phase\n[rad]")
            grid[0, i].legend(fontsize="x-small", ncols=2 if len(ridge.channels) > 3 else 1)


def plot_modulus(ridge: Ridge, ax: Axes) -> None:
    """Draw the modulus along one ridge with the fitted line, the window of the fit shaded."""
    ax.axvspan(ridge.window.start, ridge.window.stop, color=Colour.SHADE, linewidth=0.0)
    _draw_modulus(ridge, fit_skeleton(ridge), ax)
    ax.set(xlabel="time [s]", ylabel="modulus\n[√s × unit]")
    ax.set_title(f"ridge at {ridge.omega / (2 * np.pi):.4g} Hz", loc="left")
    ax.legend(fontsize="x-small", ncols=2 if len(ridge.channels) > 3 else 1)


def _draw_modulus(ridge: Ridge, fit: SkeletonFit, ax: Axes) -> None:
    modulus = np.abs(ridge.skeleton)
    lowest = np.inf
    for i, name in enumerate(ridge.channels):
        if not np.any(modulus[i] > 0):
            continue
        colour = CHANNEL_COLOURS[i % len(CHANNEL_COLOURS)]
        entry = in_legend(name) if i < MOST_IN_KEY else f"… {len(ridge.channels)} in all" if i == MOST_IN_KEY else None
        ax.plot(*thinned(ax, ridge.timepts, modulus[i]), color=colour, linewidth=1.6, alpha=0.6, label=entry)
        label = None if np.isfinite(lowest) else f"{ABOVE_NOISE:g} × noise"
        level = ABOVE_NOISE * ridge.floor[i]
        ax.axhline(level, color=colour, linewidth=0.8, linestyle=":", label=label)
        line = np.exp(fit.lines[i].real)
        key = None if label is None else "fitted line"
        ax.plot(*thinned(ax, fit.timepts, line), color=Colour.BLACK, linewidth=0.8, linestyle="--", label=key)
        lowest = min(lowest, max(0.3 * level, 0.3 * float(line[-1])))
    largest = float(np.max(modulus))
    ax.set(yscale="log", xlim=(ridge.timepts[0], ridge.timepts[-1]))
    if largest > 0:
        low = max(min(lowest, 0.1 * largest), 1e-8 * largest)
        ax.set_ylim(low, 3 * largest)
        decade_ticks(ax.yaxis, 3 * largest / low)


def _plot_phase(ridge: Ridge, fit: SkeletonFit, ax: Axes) -> None:
    from matplotlib.ticker import MaxNLocator

    elapsed = ridge.timepts - ridge.onset
    reference = ridge.omega * (fit.timepts - ridge.onset)
    reach = 0.05
    for i in range(len(ridge.channels)):
        phase = np.unwrap(np.angle(ridge.skeleton[i] * np.exp(-1j * ridge.omega * elapsed))) - fit.origin[i].imag
        fitted = fit.logarithm[i].imag - reference - fit.origin[i].imag
        # Unwrapping starts in the noise or at the edge: whole turns are taken from the trusted samples.
        phase += fitted[0] - phase[np.argmax(ridge.trusted)]
        clear = np.abs(ridge.skeleton[i]) > ABOVE_NOISE * ridge.floor[i]
        ax.plot(
            *thinned(ax, ridge.timepts, np.where(clear | ridge.trusted, phase, np.nan)),
            color=CHANNEL_COLOURS[i % len(CHANNEL_COLOURS)],
            linewidth=1.6,
            alpha=0.6,
        )
        reach = max(reach, float(np.max(np.abs(fitted[clear[ridge.trusted]]), initial=0.0)))
    line = (fit.pole.imag - ridge.omega) * (fit.timepts - ridge.onset)
    ax.plot(*thinned(ax, fit.timepts, line), color=Colour.BLACK, linewidth=0.8, linestyle="--")
    ax.set(xlabel="time [s]", xlim=(ridge.timepts[0], ridge.timepts[-1]), ylim=(-1.3 * reach, 1.3 * reach))
    ax.yaxis.set_major_locator(MaxNLocator(5))
