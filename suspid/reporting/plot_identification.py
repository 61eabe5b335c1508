"""One printable page on an identification."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from suspid.arguments import explained
from suspid.model import modal_table
from suspid.reporting.axes import keep_apart, key_above, shown, without_legend
from suspid.reporting.plot_entropy import plot_entropy
from suspid.reporting.plot_fit import plot_fit
from suspid.reporting.plot_scalogram import plot_scalogram
from suspid.reporting.plot_shapes import plot_shapes
from suspid.reporting.plot_skeletons import MOST_IN_KEY, plot_skeletons
from suspid.reporting.thinning import first_cycles
from suspid.results import check_kind
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Second
from suspid.words import Verdict, count

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from suspid.identification import Identification

# What fits on one page in readable type: panels or shapes side by side, entries of a key side by side, those of a fit
# one below another, ridges, lines of the table of modes, rows of the shapes.
ABREAST = 4
KEYS_ABREAST = 3
KEYS_OF_FIT = 3
MOST_RIDGES = 8
MODES_ON_PAGE = 12
ROWS_ON_PAGE = 10
# Signs of a line of the verdict in small type, lines of it on an upright page, and the pitch of lines over the size of
# type.
SIGNS_ABREAST = 125
LINES_ON_PAGE = 9
LINE_PITCH = 1.2
# Size in inches of a page to be printed: A4.
PAGE = (8.27, 11.69)
# A figure narrower or lower than this has no room for all parts of the page [inch].
LEAST_PAGE = 4.0


@explained
def plot_identification(
    identification: Identification,
    figure: Figure,
    *,
    units: Sequence[str] | None = None,
    title: str | None = None,
    verdict: Verdict | None = None,
) -> Figure:
    """Draw a page: modes and verdict, scalogram with ridges, skeletons, record with fit, entropy and shapes.

    Parts without content (no ridges, no search for the bandwidth, shapes of one channel) are omitted. On a figure that
    is narrower or lower than four inches the scalogram stands alone.

    Parameters
    ----------
    identification : Identification
        What was found.
    figure : matplotlib.figure.Figure
        An empty figure; made for ``Figure(figsize=PAGE)``, that is A4 upright.
    units : sequence of str, optional
        Units of the channels, by which shapes of different quantities are compared.
    title : str, optional
        What the page is called, such as the file. Default: the title of the record.
    verdict : Verdict, optional
        The verdict to show, such as that of the analysis of a whole recording. Default: that of the identification.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from suspid import free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=200)
    >>> record = free_decay(car, np.arange(0, 10, 0.005), initial_state={"v_chassis": 1.0})
    >>> page = plot_identification(identify(record, modes=1), Figure(figsize=PAGE))
    >>> page.axes[1].get_ylabel()
    'frequency [Hz]'
    """
    check_kind(identification, {"Identification": "identify"})
    keep_apart(figure)
    if min(figure.get_size_inches()) < LEAST_PAGE:
        plot_scalogram(
            identification.scalogram, ax=figure.subplots(), ridges=identification.ridges, modes=identification.modes
        )
        return figure
    ridges = identification.ridges[:MOST_RIDGES]
    blocks = [ridges[i : i + ABREAST] for i in range(0, len(ridges), ABREAST)]
    names = as_signal(held(identification, "response")).channels[:8]
    last = _last_parts(identification)
    width, height = figure.get_size_inches()
    most = LINES_ON_PAGE if height >= width >= PAGE[0] else 1
    said = _in_lines(identification.verdict if verdict is None else verdict, most)
    places = _places(figure, _heights(identification, len(blocks), len(names), last, said=len(said)))

    name = str(held(identification, "response").title or "") if title is None else title
    _write_modes(identification, name, said, figure.add_subplot(places["modes"]))
    scalogram = plot_scalogram(
        identification.scalogram,
        ax=figure.add_subplot(places["scalogram"]),
        ridges=identification.ridges,
        modes=identification.modes,
    )
    # The widths of the page leave it more room than it has alone.
    key_above(scalogram, abreast=4)
    explained: dict[str, Axes] = {}
    for i, block in enumerate(blocks):
        skeletons = _subplots(places[f"skeletons {i}"], 2, len(block))
        plot_skeletons(block, axes=skeletons)
        explained["skeletons along the ridges"] = without_legend(skeletons[0, 0])
    onset = min((ridge.onset for ridge in identification.ridges), default=None)
    explained["record and fit"] = _draw_fit(identification, names, onset, places["fit"], units)
    _write_key(figure.add_subplot(places["key"]), explained)
    if last:
        _draw_last(identification, last, places["last"], figure, units)
    for ax in figure.axes:
        _small_print(ax)
    return figure


def _last_parts(identification: Identification) -> list[str]:
    """Return which panels stand in the last row."""
    modes = identification.modes
    several = modes.shapes is not None and modes.shapes.size > len(modes)
    return ["entropy"] * (identification.bandwidth_search is not None) + ["shapes"] * several


def _in_lines(verdict: Verdict, most: int) -> list[str]:
    """Return the verdict and its gravest doubts as lines of a page."""
    doubts = [textwrap.wrap(f"- {doubt}", SIGNS_ABREAST, subsequent_indent="  ") for doubt in verdict.doubts]
    lines = [str(verdict).split("\n", 1)[0]]
    for number, doubt in enumerate(doubts):
        left = len(doubts) - number
        if len(lines) + len(doubt) + (left > 1) > most:
            return [*lines, f"… and {count(left, 'doubt' if len(lines) == 1 else 'more doubt')}"][: max(most, 1)]
        lines += doubt
    return lines


def _heights(
    identification: Identification, blocks: int, channels: int, last: Sequence[str], *, said: int
) -> dict[str, float]:
    """Return the height of each part [inch on A4]."""
    modes, ridges = identification.modes, identification.ridges[:MOST_RIDGES]
    named = min(len(modes.channels), MOST_IN_KEY + 1)
    keys = max(KEYS_OF_FIT, -(-(2 + named) // KEYS_ABREAST)) if ridges else 1
    table = min(len(modes) + 2, MODES_ON_PAGE + 2) if len(modes) else 0
    heights = {"modes": 0.3 + 0.14 * (table + said), "scalogram": 2.7 if blocks < 2 else 2.3}
    heights |= {"key": 0.35 + 0.2 * keys}
    heights |= {f"skeletons {i}": 2.5 for i in range(blocks)}
    heights |= {"fit": 0.5 + 0.75 * _fit_rows(channels)}
    return heights | ({"last": max(1.6, 0.6 + 0.2 * min(len(modes.channels), ROWS_ON_PAGE))} if last else {})


def _fit_rows(channels: int) -> int:
    return channels if channels <= ABREAST else -(-channels // 2)


def _places(figure: Figure, heights: dict[str, float]) -> dict[str, SubplotSpec]:
    """Return where each part of a page goes: one below another, or in two columns on a wide page."""
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


def _write_modes(identification: Identification, title: str, said: Sequence[str], ax: Axes) -> None:
    lines = modal_table(identification.modes).splitlines() if len(identification.modes) else []
    if len(lines) > MODES_ON_PAGE + 2:
        lines = [*lines[: MODES_ON_PAGE + 1], f"  … {len(identification.modes)} modes in all"]
    ax.set_axis_off()
    ax.text(0.0, 1.0, "\n".join(lines), family="monospace", va="top", transform=ax.transAxes, fontsize=8)
    words = "\n".join(shown(line, most=2 * SIGNS_ABREAST) for line in said)
    below = -8.0 * LINE_PITCH * (len(lines) + 0.8 * bool(lines))
    ax.annotate(words, (0.0, 1.0), (0.0, below), xycoords="axes fraction", textcoords="offset points", va="top",
                fontsize=7.5)  # fmt: skip
    ax.set_title(f"{shown(title, most=60)} — method {identification.method}".lstrip(" —"), loc="left")


def _write_key(ax: Axes, explained: Mapping[str, Axes]) -> None:
    """Put the legends of some Axes side by side, away from the panels, whose space the lines need."""
    from matplotlib.legend import Legend

    ax.set_axis_off()
    sides: list[Literal["center left", "center right", "center"]] = ["center left", "center right"]
    if len(explained) == 1:
        sides = ["center"]
    for (title, panel), side in zip(explained.items(), sides, strict=True):
        handles, labels = panel.get_legend_handles_labels()
        abreast = 1 if side == "center right" else KEYS_ABREAST
        legend = Legend(ax, handles, labels, title=title, loc=side, ncols=abreast, fontsize=7, title_fontsize=8,
                        borderaxespad=0.0, frameon=False)  # fmt: skip
        legend.set_in_layout(False)
        ax.add_artist(legend)


def _draw_fit(
    identification: Identification,
    names: Sequence[str],
    onset: Second | None,
    spec: SubplotSpec,
    units: Sequence[str] | None,
) -> Axes:
    """Draw few channels whole and their beginning enlarged; many in two columns. Return the first of the Axes."""
    rows = _fit_rows(len(names))
    if len(names) > ABREAST:
        grid = _subplots(spec, rows, 2)
        drawn = grid.T.ravel()[: len(names)]
        plot_fit(identification, axes=drawn, channels=names, units=units)
        for ax in grid.T.ravel()[len(names) :]:
            ax.set_axis_off()
        for lowest in (drawn[rows - 1], drawn[-1]):
            lowest.set_xlabel("time [s]")
            lowest.tick_params(labelbottom=True)
        return without_legend(grid[0, 0])
    span = first_cycles(identification, onset)
    grid = _subplots(spec, rows, 1) if span is None else _subplots(spec, rows, 2, widths=[3, 2])
    plot_fit(identification, axes=grid[:, 0], channels=names, units=units)
    if span is not None:
        plot_fit(identification, axes=grid[:, 1], channels=names, span=span)
        for ax in grid[:, 1]:
            ax.set_title("beginning, enlarged", loc="left")
            ax.set_ylabel("")
        without_legend(grid[0, 1])
    return without_legend(grid[0, 0])


def _draw_last(
    identification: Identification,
    parts: Sequence[str],
    place: SubplotSpec,
    figure: Figure,
    units: Sequence[str] | None,
) -> None:
    columns = place.subgridspec(1, len(parts), width_ratios=[3 if part == "shapes" else 2 for part in parts])
    search = identification.bandwidth_search
    for i, part in enumerate(parts):
        ax = figure.add_subplot(columns[i])
        if part == "shapes":
            plot_shapes(identification.modes, ax=ax, units=units)
        elif search is not None:
            plot_entropy(search, ax=ax)


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
