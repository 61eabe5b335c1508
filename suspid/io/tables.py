"""Tables: the named columns of numbers of a file, before time and channels are distinguished."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

from suspid.errors import RecordError
from suspid.io.names import bare_name, is_time
from suspid.units import Hertz, RealArray, Second
from suspid.values import nearest_names
from suspid.words import Remark


@dataclass(frozen=True, kw_only=True, slots=True)
class TimeBase:
    """The times at which the samples of a column were taken."""

    # Its name, such as that of the group of channels that share it.
    name: str
    # Time of the first sample [s], where there are no stamps.
    start: Second = 0.0
    # Sampling rate that the file states [Hz]; None where there are only stamps.
    rate: Hertz | None = None
    # Returns the stamps [s] as stored in the file. Default: ``start + arange(sample) / rate``.
    stamps: Callable[[], RealArray] | None = None
    # Whether there are fewer stamps than rows where columns of other lengths stand beside it.
    cut: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Table:
    """Columns that may be time or channels; their numbers are read on demand."""

    # Number of samples by column, in the order of the file.
    sizes: Mapping[str, int]
    # Returns the numbers of the named columns, one read-only array each, NaN where one is missing; refuses text
    # cells.
    columns: Callable[[Sequence[str]], list[RealArray]]
    # What else the file holds, and why it cannot be a column (`suspid.words.LeftOut`).
    unusable: Mapping[str, Remark] = field(default_factory=dict)
    # Sampling rates that the file states [Hz], by name; they hold for every column without a time base.
    rates: Mapping[str, Hertz] = field(default_factory=dict)
    # Time of the first sample that the file states beside such a rate [s].
    start: Second = 0.0
    # Units by column as the file states them; a column without one may be absent.
    units: Mapping[str, str] = field(default_factory=dict)
    # Time bases by column; columns that share one have the same object. Without one, time is the column named like a
    # time, or follows from the rate.
    clocks: Mapping[str, TimeBase] = field(default_factory=dict)
    # Tables one below the other in place of columns: tests of their own, or pages of one.
    parts: Sequence[Table] = ()
    # Whether groups of channels may be tests of their own; not where everything in a file was sampled at once.
    apart: bool = True
    # Title that the file states; if empty, the name of the file is used.
    title: str = ""
    # Whether one column takes nearly as long to read as all of them, as in text.
    read_at_once: bool = False

    def check(self, name: str, *, what: str) -> None:
        """Refuse a column that is missing."""
        if name in self.unusable:
            raise RecordError(f"{what} {name!r} {self.unusable[name]}")
        if name not in self.sizes:
            known = [column for column in self.sizes if what != "channel" or not is_time(column)]
            raise RecordError(f"there is no {what} {name!r}.{nearest_names(name, known)}")

    def full_name(self, name: str, *, what: str) -> str:
        """Return the column of that name, or the only one of that name before its unit."""
        short = [column for column in self.sizes if bare_name(column) == name]
        if name not in self.sizes and name not in self.unusable and len(short) == 1:
            return short[0]
        self.check(name, what=what)
        return name


def all_at_once(table: Table) -> Table:
    """Return a table whose columns are all read with the first of them, if they are nearly free then.

    Examples
    --------
    >>> import numpy as np
    >>> asked: list[object] = []
    >>> table = Table(sizes={"t": 2, "seat": 2}, columns=lambda names: asked.append(names) or [np.ones(2)] * len(names))
    >>> once = all_at_once(replace(table, read_at_once=True))
    >>> for names in (["t"], ["t", "seat"]):
    ...     _ = once.columns(names)
    >>> asked
    [['t', 'seat']]
    """
    if not table.read_at_once:
        return table

    @cache
    def every() -> dict[str, RealArray] | None:
        try:
            return dict(zip(table.sizes, table.columns(list(table.sizes)), strict=True))
        except RecordError:
            # A column that nobody wants may hold what is no number.
            return None

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        read = every()
        return table.columns(wanted) if read is None else [read[name] for name in wanted]

    return replace(table, columns=columns)
