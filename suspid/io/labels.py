"""Labels: lists of texts that name the columns of a matrix in the same file, or state their units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.io.tables import TimeBase
from suspid.units import Hertz
from suspid.words import LeftOut, Remark


@dataclass(frozen=True, kw_only=True, slots=True)
class Variable:
    """A real array that is read on demand."""

    shape: tuple[int, ...]
    read: Callable[[], NDArray[Any]]
    unit: str = ""
    # Sampling rates that the file states for it alone [Hz].
    rates: Mapping[str, Hertz] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of numbers."""
        return math.prod(self.shape)

    @property
    def is_vector(self) -> bool:
        """Whether only one side is longer than one."""
        return self.size > 1 and self.size == max(self.shape)

    @property
    def columns(self) -> int:
        """Number of columns of a matrix, its shorter side; 0 if it is none."""
        sides = [side for side in self.shape if side > 1]
        return min(sides) if len(sides) == 2 else 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Text:
    """A text, such as the label of a signal."""

    text: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Texts:
    """A list of texts, such as the names of channels."""

    texts: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Clocked:
    """Vectors that share a clock, whose name is that of their group; without one, they take the time of the file."""

    vectors: Mapping[str, Variable]
    clock: TimeBase | None


Value: TypeAlias = "Variable | Text | Texts | Clocked | Group | Remark"
# Content of a group by name: arrays, texts, further groups, or why something is left out.
Group: TypeAlias = "Mapping[str, Value]"


def of_cells(cells: Sequence[Value]) -> Value:
    """Return what a cell array holds: a list of texts, or vectors, matrices and structures by their numbers.

    Matrices are tests of their own, each with its channels, as structures are; vectors are channels.

    Examples
    --------
    >>> of_cells([Text(text="seat"), Text(text="tire")])
    Texts(texts=('seat', 'tire'))
    >>> str(of_cells([Text(text="seat"), Remark(LeftOut.EMPTY)]))
    'is a cell array of different things; save vectors'
    """
    texts = tuple(cell.text.strip() for cell in cells if isinstance(cell, Text))
    if cells and len(texts) == len(cells):
        return Texts(texts=texts)
    if not cells or any(isinstance(cell, Remark | Text | Texts) for cell in cells):
        return Remark(LeftOut.CELLS)
    return {
        f"[{k + 1}]": {"data": cell} if isinstance(cell, Variable) and cell.columns else cell
        for k, cell in enumerate(cells)
    }


def labelled(group: Group) -> Group:
    """Return a group with each matrix that one list of texts fits as vectors of these names.

    Examples
    --------
    >>> y = Variable(shape=(9, 2), read=lambda: np.zeros((9, 2)))
    >>> found = labelled({"y": y, "names": Texts(texts=("seat", "tire")), "units": Texts(texts=("m", "m"))})
    >>> list(found), found["tire"].shape, found["tire"].unit
    (['seat', 'tire', 'names', 'units'], (9,), 'm')
    """
    names, units = _fitting(group, units=False), _fitting(group, units=True)
    found: dict[str, Value] = {}
    for name, value in group.items():
        called = names.get(name, ())
        if not isinstance(value, Variable) or not called or {*called} & {*group, *found}:
            found[name] = value
            continue
        for k, one in enumerate(called):
            found[one] = _column(value, k, unit=units[name][k] if name in units else value.unit)
    return found


def _fitting(group: Group, *, units: bool) -> dict[str, tuple[str, ...]]:
    """Return by matrix the only list of names (or units) of as many texts as it, alone, has columns."""
    lists = [
        value.texts
        for name, value in group.items()
        if isinstance(value, Texts) and ("unit" in name.lower()) == units
        if units or (len(set(value.texts)) == len(value.texts) and all(value.texts))
    ]
    columns = {name: value.columns for name, value in group.items() if isinstance(value, Variable) and value.columns}
    lengths, widths = [len(texts) for texts in lists], list(columns.values())
    once = {len(texts): texts for texts in lists if lengths.count(len(texts)) == 1}
    return {name: once[n] for name, n in columns.items() if n in once and widths.count(n) == 1}


def _column(matrix: Variable, number: int, *, unit: str) -> Variable:
    sides = [side for side in matrix.shape if side > 1]
    axis = sides.index(matrix.columns)

    def read() -> NDArray[Any]:
        return np.asarray(np.take(np.reshape(matrix.read(), sides), number, axis=axis))

    return Variable(shape=(max(sides),), read=read, unit=unit, rates=matrix.rates)
