"""Parts of frozen values: read-only arrays and ordered, hashable mappings; text of numbers and tables."""

from __future__ import annotations

import difflib
import itertools
import numbers
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TypeGuard, TypeVar

import numpy as np
from tabulate import tabulate

from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.units import ComplexArray, RealArray
from suspid.wording import Argument

# Names that a message lists; a file may have hundreds of channels.
MOST_NAMES = 10

# Numbers that a line of text holds with their names and units.
MOST_NUMBERS = 6

# Magnitudes beyond these are no quantities of mechanics in SI units, and products of several leave the range of floats.
SMALLEST_SIZE, LARGEST_SIZE = 1e-30, 1e30

# Magnitudes between which numbers are printed without an exponent: up to three zeros stand before their digits.
SMALLEST_PLAIN, LARGEST_PLAIN = 1e-4, 1e7
# What stands in a table for a number that is not known.
NOTHING = "–"
# Columns of a terminal that nobody has widened, and spaces between the columns of a table that has to fit it.
TERMINAL, COLUMN_GAP = 80, 2
# Letters of a word from which on a heading of several lines is better cut in it.
LONG_WORD = 15

Value = TypeVar("Value")


class FrozenItems(Mapping[str, Value]):
    """An ordered, immutable mapping from names to hashable values (hashable, picklable)."""

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, Value]) -> None:
        self._items = dict(items)

    def __getitem__(self, name: str) -> Value:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __eq__(self, other: object) -> bool:
        """Compare names, order and values; the order counts because the matrices have it."""
        if not isinstance(other, Mapping):
            return NotImplemented
        return list(self.items()) == list(other.items())

    def __hash__(self) -> int:
        return hash(tuple(self._items.items()))

    def __repr__(self) -> str:
        return repr(self._items)


class FrozenMapping(FrozenItems[float]):
    """An ordered, immutable mapping from names to numbers (hashable, picklable)."""

    __slots__ = ()

    def __init__(self, items: Mapping[str, float]) -> None:
        super().__init__({str(name): float(value) for name, value in items.items()})


def frozen_real(array: object) -> RealArray:
    """Return a read-only float64 copy."""
    copy = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


def frozen_complex(array: object) -> ComplexArray:
    """Return a read-only complex128 copy."""
    copy = np.array(array, dtype=np.complex128)
    copy.flags.writeable = False
    return copy


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Return ``" Did you mean …?"`` when a known name is close, else the list of known names, the first ten of many.

    Examples
    --------
    >>> nearest_names("sat", ["seat", "tire", "seat"]), nearest_names("x", ["seat", "tire"])
    (" Did you mean 'seat'?", " Known: 'seat', 'tire'.")
    """
    names = list(dict.fromkeys(known))
    return likely_names(name, names) or (f" Known: {listed(names)}." if names else "")


def likely_names(name: str, known: Iterable[str]) -> str:
    """Return ``" Did you mean …?"`` when a known name is close, else nothing.

    Examples
    --------
    >>> likely_names("sat", ["seat", "tire", "seat"]), likely_names("x", ["seat", "tire"])
    (" Did you mean 'seat'?", '')
    """
    close = difflib.get_close_matches(name, list(dict.fromkeys(known)), n=3, cutoff=0.6)
    return f" Did you mean {' or '.join(repr(c) for c in close)}?" if close else ""


def listed(names: Sequence[str]) -> str:
    """Return names in quotes, the first ten of many and the number of the others.

    Examples
    --------
    >>> listed(["seat", "tire"]), listed([str(k) for k in range(12)])[-16:]
    ("'seat', 'tire'", "'9' and 2 others")
    """
    more = len(names) - MOST_NAMES
    return ", ".join(map(repr, names[:MOST_NAMES])) + (f" and {more} other{'s' * (more > 1)}" if more > 0 else "")


def numbers_in_words(names: Sequence[str], values: Iterable[float], units: Sequence[str] = ()) -> str:
    """Return named numbers in one line, the first six of many and the number of the others.

    Examples
    --------
    >>> numbers_in_words(["seat.stiffness", "seat.damping"], [200002.9, 299.57], ["N/m", "N s/m"])
    'seat.stiffness = 200003 N/m, seat.damping = 299.57 N s/m'
    """
    rows = list(itertools.zip_longest(names, values, units, fillvalue=""))
    said = [f"{name} = {value:.6g} {unit}".removesuffix(" 1").strip() for name, value, unit in rows[:MOST_NUMBERS]]
    more = len(rows) - len(said)
    return printable(", ".join([*said, f"and {more} more"] if more else said))


def samples_in_words(timepts: RealArray, channels: Sequence[str]) -> str:
    """Return length, rate, start and channels of a record in one line.

    Examples
    --------
    >>> samples_in_words(np.arange(5) / 100, ["seat", "tire"])
    '5 samples at 100 Hz from t = 0 s, 2 channels: seat, tire'
    """
    length = float(timepts[-1] - timepts[0]) if len(timepts) > 1 else 0.0
    rate = f" at {(len(timepts) - 1) / length:.6g} Hz" if length > 0 else ""
    # A start within rounding of zero is zero.
    start = 0.0 if not len(timepts) or abs(timepts[0]) <= 1e-9 * length / len(timepts) else float(timepts[0])
    names = ", ".join(channels[:6]) + (", …" if len(channels) > 6 else "")
    number = f"{len(channels)} channel{'s' * (len(channels) != 1)}"
    return f"{len(timepts)} samples{rate} from t = {start:.6g} s, {number}: {names}"


@contextmanager
def within_numbers() -> Iterator[None]:
    """Turn an error of arithmetic or of linear algebra into an `InputError`: something is far too large or too small.

    Examples
    --------
    >>> with within_numbers():
    ...     np.linalg.inv(np.zeros((2, 2)))
    Traceback (most recent call last):
    suspid.errors.InputError: the computation overflowed (Singular matrix): a mass, spring, ...
    """
    try:
        yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise InputError(
            f"the computation overflowed ({error}): a mass, spring, damper or sample is far too large "
            f"or too small; check the units of the car and of the channels"
        ) from None


def text_table(columns: Mapping[str, Sequence[str]], *, widest: int | None = None, words: Collection[str] = ()) -> str:
    """Return named columns of text as a table, aligned to the right; those of ``words`` to the left.

    One that is wider than ``widest`` has headings of several lines, and then several parts, each with the first column.

    Examples
    --------
    >>> print(text_table({"car": ["1"], "seat.stiffness": ["20000"], "seat.damping": ["900"]}, widest=24))
         seat.    seat.
    car  stiffness  damping
    ---  ---------  -------
      1      20000      900
    """
    sides = ["left" if name in words else "right" for name in columns]
    whole: str = tabulate(columns, headers="keys", disable_numparse=True, stralign="right", colalign=sides)
    whole = "\n".join(map(str.rstrip, whole.split("\n"))) if words else whole
    if widest is None or len(whole.partition("\n")[0]) <= widest:
        return whole
    cells = list(columns.values())
    # Headings are cut no further than one part needs; where several are needed names stay whole.
    for cut in (0, 1, 2, 3, 2):
        heads = [_heading(name, cut) for name in columns]
        widths = [max(map(len, [*head, *column])) for head, column in zip(heads, cells, strict=True)]
        if sum(widths) + COLUMN_GAP * (len(widths) - 1) <= widest:
            break
    parts: list[list[int]] = []
    left = list(range(1, len(heads)))
    while left or not parts:
        use, room = [0], widest - widths[0]
        while left and (len(use) == 1 or room >= widths[left[0]] + COLUMN_GAP):
            room -= widths[left[0]] + COLUMN_GAP
            use.append(left.pop(0))
        parts.append(use)
    return "\n\n".join(_part([heads[i] for i in use], [cells[i] for i in use]) for use in parts)


def _heading(name: str, cut: int) -> list[str]:
    """Return the lines of a heading.

    Cut once the terms of a sum, a remark and the unit stand apart, cut twice a name and its last word, at last the
    parts of long words.
    """
    if not cut:
        return [name.strip()]
    what, *remarks = name.replace(" [", ", [").split(", ")
    words = what.replace(" + ", " +\n").split("\n")
    if cut > 1 and len(words) == 1:
        words = what.replace(".", ".\n").split("\n")
    if cut > 2:
        words = [part for word in words for part in ([word] if len(word) < LONG_WORD else _halves(word))]
    return [*words, *remarks]


def _halves(word: str) -> list[str]:
    first, mark, last = word.rpartition("_")
    return [first + mark, last] if mark else [word]


def _part(heads: Sequence[Sequence[str]], cells: Sequence[Sequence[str]]) -> str:
    """Return a table whose headings have several lines, the last lines side by side."""
    height = max(map(len, heads))
    columns = [[*[""] * (height - len(head)), *head, *column] for head, column in zip(heads, cells, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    rows = [[*column[:height], "-" * width, *column[height:]] for column, width in zip(columns, widths, strict=True)]
    gap = " " * COLUMN_GAP
    lines = zip(*rows, strict=True)
    return "\n".join(
        gap.join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def figures_of(value: float, digits: int = 4) -> str:
    """Return a number with its significant digits, without an exponent unless it is far from 1; "–" of what is unknown.

    Examples
    --------
    >>> figures_of(50000.0), figures_of(0.0123456), figures_of(8.2e-9), figures_of(float("nan"))
    ('50000', '0.01235', '8.2e-09', '–')
    """
    if np.isnan(value):
        return NOTHING
    if value == 0 or not np.isfinite(value) or not SMALLEST_PLAIN <= abs(value) < LARGEST_PLAIN:
        return f"{value:.{digits}g}"
    return np.format_float_positional(float(f"{value:.{digits}g}"), trim="-")


def rounded(values: RealArray, stds: RealArray | None, scale: float = 1.0) -> list[str]:
    """Return values with the digits that their uncertainty (times ``scale``) leaves, or six significant ones.

    Examples
    --------
    >>> rounded(np.array([0.61049, 8.2e-9, 5.0]), np.array([0.0123, 1.1e-8, np.nan]))
    ['0.610', '8e-09', '5']
    """
    if stds is None:
        return [f"{v:.6g}" for v in values]
    return [_rounded(float(v), float(s) * scale) for v, s in zip(values, stds, strict=True)]


def _rounded(value: float, std: float) -> str:
    if not np.isfinite(std) or not np.isfinite(value):
        return NOTHING if np.isnan(value) else f"{value:.6g}"
    places = 1 - int(np.floor(np.log10(std))) if std > 0 else 6
    largest = max(abs(value), std)
    if value and std > 0 and largest < SMALLEST_PLAIN:
        digits = max(0, places + int(np.floor(np.log10(abs(value)))))
        return f"{value:.{digits}e}"
    text = f"{value:.{min(max(places, 0), 12)}f}"
    return text if float(text) else text.removeprefix("-")


def spread(std: float) -> str:
    """Return a standard deviation with two digits; tens and more are written out, what is unknown is "–".

    Examples
    --------
    >>> spread(0.01234), spread(1.0), spread(512.0), spread(0.0), spread(float("nan"))
    ('0.012', '1.0', '510', '0', '–')
    """
    if np.isnan(std):
        return NOTHING
    return f"{std:.0f}" if std == 0 else f"{std:#.2g}" if std < 9.95 else f"{float(f'{std:.2g}'):.0f}"


def values_beside(values: RealArray, stds: RealArray) -> dict[str, list[str]]:
    """Return a column of values, and one of their standard deviations unless all are known exactly.

    Examples
    --------
    >>> values_beside(np.array([26.181, 4.724]), np.array([1.23, np.nan]))
    {'value': ['26.2', '4.724'], '±': ['1.2', '–']}
    >>> values_beside(np.array([26.181]), np.array([0.0]))
    {'value': ['26.18']}
    """
    if not np.any(np.isnan(stds) | (stds > 0)):
        return {"value": [figures_of(value) for value in values.tolist()]}
    return {
        "value": [
            rounded(np.array([value]), np.array([std]))[0] if std > 0 else figures_of(value)
            for value, std in zip(values.tolist(), stds.tolist(), strict=True)
        ],
        "±": [spread(std) for std in stds.tolist()],
    }


def ends_beside(ends: Sequence[tuple[float, float]]) -> dict[str, list[str]]:
    """Return columns of lower and upper ends, with the digits that tell them apart.

    Examples
    --------
    >>> ends_beside([(0.017991, 0.018003), (63.73, 64.09), (np.nan, np.nan)])
    {'lower': ['0.0179910', '63.73', '–'], 'upper': ['0.0180030', '64.09', '–']}
    """
    half = np.array([max((high - low) / 2, 0.0) for low, high in ends])
    rows = [
        (rounded(np.array([low]), np.array([one]))[0], rounded(np.array([high]), np.array([one]))[0])
        if one > 0 or np.isnan(one)
        else (figures_of(low), figures_of(high))
        for (low, high), one in zip(ends, half.tolist(), strict=True)
    ]
    return {"lower": [low for low, _ in rows], "upper": [high for _, high in rows]}


def is_size(value: object) -> TypeGuard[float]:
    """Return whether a value is a positive number of a size that is computed with; True is none.

    Examples
    --------
    >>> is_size(0.5), is_size(True), is_size("0.5"), is_size(1e300)
    (True, False, False, False)
    """
    known = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    return known and bool(SMALLEST_SIZE <= value <= LARGEST_SIZE)  # type: ignore[operator]


def check_rate(fs: object) -> None:
    """Refuse a sampling rate that is neither None nor a positive number.

    Examples
    --------
    >>> check_rate(True)
    Traceback (most recent call last):
    suspid.errors.RecordError: fs = True must be a positive and finite number of Hz
    """
    number = isinstance(fs, int | float | np.integer | np.floating) and not isinstance(fs, bool)
    if fs is not None and not (number and 0 < fs < np.inf):  # type: ignore[operator]
        raise RecordError(f"fs = {fs!r:.40} must be a positive and finite number of Hz")


def is_count(value: object) -> TypeGuard[int]:
    """Return whether a value is a whole number from one on; True is none."""
    return not isinstance(value, bool) and isinstance(value, numbers.Integral) and int(value) >= 1


def check_count(name: str, value: object) -> None:
    """Refuse a number of things that is neither None nor a whole number from one on.

    Examples
    --------
    >>> check_count("modes", 1.5)
    Traceback (most recent call last):
    suspid.errors.InputError: modes=1.5 must be a whole number from 1 on, or left out
    """
    if value is not None and not is_count(value):
        raise InputError(Argument(name, f"{value!r:.40}"), " must be a whole number from 1 on, or left out")


def check_names(argument: str, names: object, such: str) -> None:
    """Refuse what is no list of different names.

    Examples
    --------
    >>> check_names("parameters", "damping", "chassis.damping")
    Traceback (most recent call last):
    suspid.errors.InputError: parameters='damping' must be a list of names such as ['chassis.damping']
    """
    listed_names = list(names) if isinstance(names, list | tuple) else []
    if not listed_names or not all(isinstance(name, str) for name in listed_names):
        raise InputError(Argument(argument, f"{names!r:.60}"), f" must be a list of names such as [{such!r}]")
    twice = next((name for name in listed_names if listed_names.count(name) > 1), None)
    if twice is not None:
        raise InputError(Argument(argument), f": {twice!r} is named twice")
