"""Sensitivities of modes and figures to springs and dampers, as a table of bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.performance import per_cent
from suspid.reporting.axes import shown
from suspid.reporting.colours import Colour
from suspid.results import check_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from suspid.performance import Sensitivities

# Changes of a figure that fill a cell [% for each %]; larger ones are cut and their number tells.
FULL_CELL = 1.0
# Longest bar, in widths of a cell: those of neighbours do not touch.
HALF_CELL = 0.46
# Width of a column that holds "stiffness" [inch]; in narrower ones the names stand upright.
NARROW_COLUMN = 0.55
# Height of letters over that of a row, in which a bar stands below a number; width of a number such as +0.19 over the
# height of its letters.
LETTERS_OF_ROW, LETTERS_OF_NUMBER = 0.55, 3.2
# Letters of an inch [points], and the smallest size of words that stand alone [points].
POINTS, SMALLEST_WORDS = 72, 5.0


@explained
def plot_sensitivities(found: Sensitivities, ax: Axes) -> Axes:
    """Draw a row for each mode and figure and a column for each parameter: per cent for each per cent, as bars.

    Parameters
    ----------
    found : Sensitivities
        What was found.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from suspid import quarter_car, sensitivities
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3,
    ...                   chassis_damping=1300)
    >>> ax = plot_sensitivities(sensitivities(car), Figure().subplots())
    >>> [label.get_text() for label in ax.get_yticklabels()]
    ['mode 1.wn', 'mode 1.zeta', 'mode 2.wn', 'mode 2.zeta']
    """
    check_kind(found, {"Sensitivities": "sensitivities"})
    rows, columns = found.elasticity.shape
    inch = ax.get_window_extent().width / ax.figure.dpi / columns
    # A long name of a strut would run into its neighbour; in narrow columns every name does.
    upright = inch < NARROW_COLUMN
    high = ax.get_window_extent().height / ax.figure.dpi / rows
    # Letters are as small as the rows need them, the numbers as the columns do: in print or enlarged they can be read.
    size = min(6.9 if upright else 8.3, POINTS * LETTERS_OF_ROW * high)
    legible = max(size, SMALLEST_WORDS)
    size_of_number = min(size, POINTS * inch / LETTERS_OF_NUMBER)
    for column in range(columns):
        ax.vlines([column] * rows, np.arange(rows) + 0.12, np.arange(rows) + 0.48, color=Colour.GREY, linewidth=0.6)
        for row in range(rows):
            value = float(found.elasticity[row, column])
            if np.isnan(value):
                continue
            reach = HALF_CELL * float(np.clip(value / FULL_CELL, -1, 1))
            # The number stands above its bar.
            ax.barh(row + 0.3, reach, left=column, height=0.26, color=Colour.SKY if value > 0 else Colour.ORANGE)
            ax.text(column, row - 0.14, per_cent(value).replace("-", "−"), ha="center", va="center",
                    fontsize=size_of_number)  # fmt: skip
    ax.set_yticks(range(rows), [shown(name) for name in found.names], fontsize=size)
    names = [shown(name).rpartition(".") for name in found.parameters]
    words = [(" " if upright else "\n").join([*owner.split("_"), last]) for owner, _, last in names]
    ax.set_xticks(range(columns), words, fontsize=min(legible, POINTS * inch), rotation=90.0 if upright else 0.0)
    ax.set_ylim(rows - 0.5, -0.5)
    ax.set_xlim(-0.55, columns - 0.45)
    ax.tick_params(length=0)
    ax.xaxis.tick_top()
    for row in range(1, rows):
        ax.axhline(row - 0.5, color=Colour.SHADE, linewidth=0.6, zorder=0)
    ax.set_xlabel(
        f"change [%] for each % more; a bar of half a cell: {FULL_CELL:g}",
        fontsize=legible,
        wrap=True,
    )
    return ax


def size_of(found: Sensitivities) -> tuple[float, float]:
    """Return width and height of a figure that holds all [inch]."""
    rows, columns = found.elasticity.shape
    return max(7.0, 2.4 + 0.6 * columns), 1.2 + 0.27 * rows
