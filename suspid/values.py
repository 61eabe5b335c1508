"""Parts of frozen values: read-only arrays and ordered, hashable mappings; lists of names; checks of arguments."""

from __future__ import annotations

import difflib
import itertools
import numbers
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TypeGuard, TypeVar

import numpy as np

from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.units import ComplexArray, RealArray
from suspid.wording import Argument, moment

# Names that a message lists; a file may have hundreds of channels.
MOST_NAMES = 10

# Numbers that a line of text holds with their names and units.
MOST_NUMBERS = 6

# Magnitudes beyond these are no quantities of mechanics in SI units, and products of several leave the range of floats.
SMALLEST_SIZE, LARGEST_SIZE = 1e-30, 1e30
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
    return f"{len(timepts)} samples{rate} from t = {moment(start)} s, {number}: {names}"


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


def check_parameters(names: object) -> None:
    """Refuse what is no list of different names of parameters.

    Examples
    --------
    >>> check_parameters("damping")
    Traceback (most recent call last):
    suspid.errors.InputError: parameters='damping' must be a list of names such as ['chassis.damping']
    """
    listed_names = list(names) if isinstance(names, list | tuple) else []
    if not listed_names or not all(isinstance(name, str) for name in listed_names):
        raise InputError(
            Argument("parameters", f"{names!r:.60}"), " must be a list of names such as ['chassis.damping']"
        )
    twice = next((name for name in listed_names if listed_names.count(name) > 1), None)
    if twice is not None:
        raise InputError(Argument("parameters"), f": {twice!r} is named twice")
