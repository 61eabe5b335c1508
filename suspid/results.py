"""Common methods of results: text, table, picture, notebook cell."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from suspid.errors import InputError
from suspid.files import printable

if TYPE_CHECKING:
    import control
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Letters of what `repr` says of a result: some lines of a terminal, whatever names it has.
LONGEST_REPR = 300
# Size of a picture in a notebook [inch], and its resolution [dots per inch].
NOTEBOOK, NOTEBOOK_DOTS = (7.0, 3.2), 96
# Notebooks give HTML their proportional font, and break words anywhere.
CELL_STYLE = "white-space: pre; overflow-x: auto; word-break: normal; font-family: monospace"


@dataclass(frozen=True, kw_only=True, slots=True)
class Drawing:
    """How a result is drawn.

    Parameters
    ----------
    alone : callable
        Draws its main picture on the Axes given.
    page : callable, optional
        Draws all of its pictures on an empty figure. Default: the main picture.
    size : (float, float)
        Size of the page [inch].
    cell : (float, float)
        Size of the main picture in a notebook [inch].
    """

    alone: Callable[[Axes], object]
    page: Callable[[Figure], object] | None = None
    size: tuple[float, float] = NOTEBOOK
    cell: tuple[float, float] = NOTEBOOK


@singledispatch
def drawing_of(found: object) -> Drawing | None:
    """Return how a result is drawn; `suspid.reporting` registers the pictures of each type."""
    del found
    return None


class Result:
    """The methods that all results share."""

    __slots__ = ()

    def __repr__(self) -> str:
        brief = printable(self._brief())
        return f"<{type(self).__name__} {brief if len(brief) <= LONGEST_REPR else f'{brief[:LONGEST_REPR]}…'}>"

    def _brief(self) -> str:
        """Return what was found in one line and at no cost, for lists, debuggers and failing tests."""
        return str(self).partition("\n")[0]

    def _table(self) -> Mapping[str, Sequence[object]]:
        """Return the numbers of the result by column, with units in the names."""
        raise InputError(f"{type(self).__name__} has no table; read its fields")

    def details(self) -> str:
        """Return all that can be said in words; ``str()`` is the part that fits a screen.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> modes = ModalSet(poles=[-1 + 20j])
        >>> str(modes) in modes.details()
        True
        """
        return str(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Return the numbers as a DataFrame, unrounded, with units in the names of the columns.

        Raises
        ------
        InputError
            If pandas is not installed, or the result has no table.

        Examples
        --------
        >>> from suspid import ModalSet
        >>> ModalSet(poles=[-3 + 4j]).to_pandas().loc[0, ["wn_rad_per_s", "zeta"]].tolist()
        [5.0, 0.6]
        """
        table = self._table()
        try:
            import pandas
        except ModuleNotFoundError:
            raise InputError("to_pandas needs pandas: pip install pandas") from None
        return pandas.DataFrame({name: list(column) for name, column in table.items()})

    def plot(self, ax: Axes | None = None) -> control.ControlPlot:
        """Draw the result.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw the main picture. Default: all pictures, on a figure of their own.

        Returns
        -------
        control.ControlPlot
            Lines, Axes and figure, as the plots of python-control return them.

        Raises
        ------
        InputError
            If there is nothing to draw.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import as_record, best_bandwidth
        >>> t = np.arange(0, 4, 0.01)
        >>> found = best_bandwidth(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), candidates=[2.0, 4.0, 8.0])
        >>> drawn = found.plot()
        >>> drawn.axes[0, 0].get_xlabel()
        'bandwidth N [1]'
        """
        import control
        import numpy as np

        drawing = drawing_of(self)
        if drawing is None:
            raise InputError(f"{type(self).__name__}: there is no picture of this result")
        if ax is not None:
            drawing.alone(ax)
            figure: Any = ax.figure
            axes = np.array([[ax]], dtype=object)
        else:
            from matplotlib import pyplot

            figure = pyplot.figure(figsize=drawing.size, layout="constrained")
            _draw(drawing, figure, whole=True)
            axes = np.array([figure.axes], dtype=object)
        lines = np.empty(axes.shape, dtype=object)
        for index, one in np.ndenumerate(axes):
            lines[index] = list(one.lines)
        return control.ControlPlot(lines, axes, figure)

    def _repr_html_(self) -> str:
        """Return the text and the main picture for a notebook; whatever a name holds stays text."""
        text = f'<pre style="{CELL_STYLE}">{_in_cell(str(self))}</pre>'
        drawing = drawing_of(self)
        if drawing is None:
            return text
        from matplotlib.figure import Figure

        figure = Figure(figsize=drawing.cell, layout="constrained")
        _draw(drawing, figure, whole=False)
        with io.BytesIO() as stream:
            figure.savefig(stream, format="png", dpi=NOTEBOOK_DOTS)
            content = base64.b64encode(stream.getvalue()).decode("ascii")
        return f'{text}<img alt="{type(self).__name__}" src="data:image/png;base64,{content}">'


def _in_cell(text: str) -> str:
    """Return text for a notebook: sentences are broken at the width of the cell, tables keep their columns."""
    lines = html.escape(text).split("\n")
    # Columns stand two spaces apart.
    return "\n".join(
        f'<span style="white-space: pre-wrap">{line}</span>'
        if " " in line.strip() and "  " not in line.strip()
        else line
        for line in lines
    )


def _draw(drawing: Drawing, figure: Figure, *, whole: bool) -> None:
    if whole and drawing.page is not None:
        drawing.page(figure)
    else:
        drawing.alone(figure.subplots())


def check_kind(found: object, made_by: Mapping[str, str]) -> None:
    """Refuse what is none of the types named, and say which function returns each.

    Examples
    --------
    >>> check_kind("seat.csv", {"Grip": "grip", "Ride": "ride"})
    Traceback (most recent call last):
    suspid.errors.InputError: a str was given where a Grip or Ride is needed: pass what grip or ride returns
    """
    if not any(one.__name__ in made_by for one in type(found).__mro__):
        needed = " or ".join(made_by)
        article = "an" if needed[0] in "AEIO" else "a"
        raise InputError(
            f"a {type(found).__name__} was given where {article} {needed} is needed: pass what "
            f"{' or '.join(made_by.values())} returns"
        )


def columns_of(rows: Sequence[object], names: Sequence[str]) -> dict[str, list[object]]:
    """Return fields of rows by column.

    Examples
    --------
    >>> columns_of([1 + 2j, 3.0 + 0j], ["real", "imag"])
    {'real': [1.0, 3.0], 'imag': [2.0, 0.0]}
    """
    return {name: [getattr(row, name) for row in rows] for name in names}
