"""Before against after: springs and dampers, or modes, of two results with the intervals of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.greybox import Estimate
from suspid.levels import LEVEL, check_level
from suspid.model import Comparison, FoundCar, FoundParameters, ModalSet, compare, found_parameters
from suspid.reporting.axes import entitle, keep_apart, key_above, shown
from suspid.reporting.colours import Colour
from suspid.results import check_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from suspid.units import Ratio

# What the two results of a line are called and drawn in, and how far each stands from the line's middle [lines].
DRAWN = (("before", Colour.GREY, -0.16), ("after", Colour.BLUE, 0.16))


@dataclass(frozen=True, kw_only=True, slots=True)
class Compared:
    """One quantity in two results: lower end, value and upper end of each."""

    name: str
    before: tuple[float, float, float]
    after: tuple[float, float, float]


@explained
def plot_comparison(
    before: FoundCar | FoundParameters | ModalSet,
    after: FoundCar | FoundParameters | ModalSet,
    figure: Figure,
    *,
    level: Ratio = LEVEL,
) -> Figure:
    """Draw springs and dampers, or modes, of two results with the intervals of both.

    Every line is one quantity in percent of its value before. Intervals that are apart show a change that the errors
    of the two results do not explain; `wear` and `compare` judge it.

    Parameters
    ----------
    before, after : ModalSet, or Reconstruction or Estimate
        Two results: modes, or springs and dampers. Parameters that only one of them has, or that were not known from
        zero before, and modes without a partner, are left out.
    figure : matplotlib.figure.Figure
        An empty figure.
    level : float
        Probability of the intervals [1]. Exact modes are drawn as points.

    Returns
    -------
    matplotlib.figure.Figure
        ``figure``.

    Raises
    ------
    InputError
        If the results are of two kinds, or have nothing in common.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> old = ModalSet.from_wn_zeta([10.0], [0.3], wn_std=[0.1], zeta_std=[0.01])
    >>> new = ModalSet.from_wn_zeta([10.1], [0.2], wn_std=[0.1], zeta_std=[0.01])
    >>> page = plot_comparison(old, new, Figure())
    >>> [ax.get_title(loc="left") for ax in page.axes]
    ['natural frequency', 'damping ratio']
    """
    check_level(level)
    for one in (before, after):
        made_by = {
            "Estimate": "estimate",
            "Reconstruction": "reconstruct",
            "ModalSet": "eigenmodes, or identify as .modes,",
        }
        if not isinstance(one, FoundParameters):
            check_kind(one, made_by)
    keep_apart(figure)
    panels = _panels(before, after, level)
    if not any(panels.values()):
        raise InputError("the two results have no quantity in common to draw")
    heights = [1.0 + len(rows) for rows in panels.values()]
    grid = np.atleast_1d(figure.subplots(len(panels), 1, height_ratios=heights))
    for ax, (title, rows) in zip(grid, panels.items(), strict=True):
        _draw(ax, rows)
        entitle(ax, title)
    key_above(grid[0])
    grid[-1].set_xlabel(f"change from before, with {100 * level:g} % intervals [%]")
    return figure


def _panels(
    before: FoundCar | FoundParameters | ModalSet, after: FoundCar | FoundParameters | ModalSet, level: Ratio
) -> Mapping[str, Sequence[Compared]]:
    if not isinstance(before, ModalSet) and not isinstance(after, ModalSet):
        return {"springs and dampers": _parameters(before, after, level)}
    if isinstance(before, ModalSet) and isinstance(after, ModalSet):
        names = {"wn": "natural frequency", "zeta": "damping ratio"}
        return {title: _modes(before, after, quantity, level) for quantity, title in names.items()}
    raise InputError(
        f"two sets of modes, or two of Reconstruction and Estimate, not {type(before).__name__} and "
        f"{type(after).__name__}"
    )


def _parameters(before: FoundCar | FoundParameters, after: FoundCar | FoundParameters, level: Ratio) -> list[Compared]:
    def ends(found: FoundCar | FoundParameters) -> dict[str, tuple[float, float, float]]:
        named = found if isinstance(found, FoundParameters) else found_parameters(found)
        # Those of an estimate are cut at its bounds, and its channels have parameters too.
        reach = found.interval(level) if isinstance(found, Estimate) else named.interval(level)
        values = dict(named.values)
        if isinstance(found, Estimate):
            values = dict(zip(found.parameters, found.values.tolist(), strict=True))
        return {name: (reach[name][0], value, reach[name][1]) for name, value in values.items()}

    old, new = ends(before), ends(after)
    rows = [Compared(name=name, before=old[name], after=new[name]) for name in new if old.get(name, (0.0, 0.0))[1]]
    # Shares of a value that may be zero, such as a delay, say nothing and hide all others.
    return [row for row in rows if row.before[0] * row.before[2] > 0] or rows


def _modes(before: ModalSet, after: ModalSet, quantity: str, level: Ratio) -> list[Compared]:
    """Return one quantity of every mode that both sets have."""
    table = compare(after, before).table
    partners = [
        (wn.item, _at(before, wn.expected, zeta.expected), _at(after, wn.found, zeta.found))
        for wn, zeta in zip(table[::2], table[1::2], strict=True)
    ]
    old, new = _ends(before, quantity, level), _ends(after, quantity, level)
    return [
        Compared(name=name, before=old[i], after=new[k])
        for name, i, k in partners
        if i is not None and k is not None and old[i][1]
    ]


def _at(modes: ModalSet, wn: float | None, zeta: float | None) -> int | None:
    """Return the number of the mode of this frequency and damping ratio, one of which others may have; None of none."""
    return None if wn is None or zeta is None else int(np.argmin(np.abs(modes.wn - wn) + np.abs(modes.zeta - zeta)))


def _ends(modes: ModalSet, quantity: str, level: Ratio) -> list[tuple[float, float, float]]:
    """Return lower end, value and upper end of each mode; the value itself where they are exact."""
    values = getattr(modes, quantity).tolist()
    if modes.wn_std is None:
        return [(value, value, value) for value in values]
    known = getattr(modes.interval(level), quantity).tolist()
    return [(low, value, high) for value, (low, high) in zip(values, known, strict=True)]


def _draw(ax: Axes, rows: Sequence[Compared]) -> None:
    for which, colour, offset in DRAWN:
        for at, row in enumerate(rows):
            low, here, high = (100 * (end / row.before[1] - 1) for end in getattr(row, which))
            ax.plot([low, high], [at + offset] * 2, color=colour, linewidth=2.0)
            ax.plot([here], [at + offset], "o", color=colour, markersize=4, label=None if at else which)
    ax.axvline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    ax.set_yticks(range(len(rows)), [shown(row.name) for row in rows])
    ax.set_ylim(len(rows) - 0.5, -0.5)


def draw_errors(found: Comparison, ax: Axes) -> None:
    """Draw the error of every value that has a partner over what is allowed, between lines at what passes."""
    rows = [row for row in found.table if row.error is not None]
    for at, row in enumerate(rows):
        # Nothing is allowed of an exact comparison: its errors are drawn as they are.
        size = (row.error or 0.0) / (row.allowed or 1.0)
        colour = Colour.BLUE if row.verdict == "ok" else Colour.VERMILION
        ax.plot([0.0, size], [at, at], color=colour, linewidth=2.0)
        ax.plot([size], [at], "o", color=colour, markersize=4)
    for edge in (-1.0, 1.0):
        ax.axvline(edge, color=Colour.GREY, linewidth=0.8, linestyle=":", zorder=0)
    ax.axvline(0.0, color=Colour.PALE, linewidth=0.8, zorder=0)
    ax.set_yticks(range(len(rows)), [f"{shown(row.item)} {row.quantity}" for row in rows])
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_xlabel("error over what is allowed [1]")
