"""Check fields of settings: each function returns the value in its own type, or refuses it by name."""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeAlias, TypeVar

import numpy as np

from suspid.errors import InputError
from suspid.values import FrozenItems, FrozenMapping, is_count
from suspid.wording import Argument, Entry

# The name of a field; or that and the key of one entry of it.
Name: TypeAlias = "str | tuple[str, str]"
Check: TypeAlias = Callable[[str, object], object]
Kind = TypeVar("Kind")


def wrong(name: Name, value: object, what: str) -> InputError:
    """Return the error of a field, or of one entry of it: its name, its value and what to give."""
    shown = f"{value:g}" if isinstance(value, float) else f"{value!r:.80}"
    of = Argument(name, shown) if isinstance(name, str) else Entry(*name, shown)
    return InputError(of, f": {what}")


def none_or(check: Check) -> Check:
    """Return the check of a field that may be None."""
    return lambda name, value: None if value is None else check(name, value)


def number(name: Name, value: object) -> float:
    """Return a finite real number."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real) or not math.isfinite(value):
        raise wrong(name, value, "give a finite number")
    return float(value)


def positive(name: Name, value: object) -> float:
    """Return a finite number above zero."""
    found = number(name, value)
    if found <= 0:
        raise wrong(name, value, "give a number above 0")
    return found


def not_negative(name: Name, value: object) -> float:
    """Return a finite number of zero or more."""
    found = number(name, value)
    if found < 0:
        raise wrong(name, value, "give a number of 0 or more")
    return found


def not_zero(name: Name, value: object) -> float:
    """Return a finite number that is not zero."""
    found = number(name, value)
    if found == 0:
        raise wrong(name, value, "give a number other than 0")
    return found


def probability(name: str, value: object) -> float:
    """Return a number between zero and one."""
    found = number(name, value)
    if not 0 < found < 1:
        raise wrong(name, value, "give a probability between 0 and 1, such as 0.95")
    return found


def rank(name: str, value: object) -> int:
    """Return a whole number from one on."""
    if not is_count(value):
        raise wrong(name, value, "give a whole number from 1 on")
    return int(value)


def flag(name: str, value: object) -> bool:
    """Return True or False."""
    if not isinstance(value, bool | np.bool_):
        raise wrong(name, value, "give True or False")
    return bool(value)


def text(name: Name, value: object) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise wrong(name, value, "give a text")
    return str(value)


def path(name: str, value: object) -> str | os.PathLike[str]:
    """Return a path."""
    if not isinstance(value, str | os.PathLike):
        raise wrong(name, value, "give the path of a file")
    return value


def several(name: Name, value: object, example: str) -> list[object]:
    """Return the items of a sequence; a text is none."""
    if isinstance(value, str | bytes | Mapping | set | frozenset) or not isinstance(value, Iterable):
        raise wrong(name, value, f"give a tuple, such as {example}")
    return list(value)


def distinct(name: str, found: Sequence[str], value: object) -> None:
    """Refuse names that stand more than once."""
    twice = [one for one in found if found.count(one) > 1]
    if twice:
        raise wrong(name, value, f"{twice[0]!r} occurs more than once; name each once")


def texts(name: str, value: object) -> tuple[str, ...]:
    """Return a tuple of texts."""
    items = several(name, value, "('seat', 'chassis')")
    for item in items:
        if not isinstance(item, str):
            raise wrong(name, value, f"{item!r:.40} is not a text; give a tuple such as ('seat', 'chassis')")
    return tuple(str(item) for item in items)


def names(name: str, value: object) -> tuple[str, ...]:
    """Return a tuple of distinct names."""
    found = texts(name, value)
    distinct(name, found, value)
    return found


def some_names(name: str, value: object) -> tuple[str, ...]:
    """Return a tuple of distinct names that is not empty."""
    found = names(name, value)
    if not found:
        raise wrong(name, value, "names nothing; give at least one name, or None for all")
    return found


def axes(name: str, value: object) -> tuple[str, ...]:
    """Return the names of three axes."""
    found = names(name, value)
    if len(found) != 3:
        raise wrong(name, value, "give three axes, such as ('ax', 'ay', 'az')")
    return found


def groups(name: str, value: object) -> tuple[tuple[str, ...], ...]:
    """Return groups of two names or more."""
    found = tuple(names(name, group) for group in several(name, value, "(('front.stiffness', 'rear.stiffness'),)"))
    for group in found:
        if len(group) < 2:
            raise wrong(name, group, "a group needs two names or more")
    return found


def numbers_above_zero(name: str, value: object) -> tuple[float, ...]:
    """Return a tuple of positive numbers that is not empty."""
    found = tuple(positive(name, one) for one in several(name, value, "(5.0, 10.0)"))
    if not found:
        raise wrong(name, value, "is empty; give at least one number")
    return found


def limits(name: str, value: object) -> tuple[float, float]:
    """Return a lower and a higher frequency [Hz]."""
    items = several(name, value, "(0.5, 20.0) [Hz]")
    if len(items) != 2:
        raise wrong(name, value, "give two frequencies, such as (0.5, 20.0) [Hz]")
    low, high = positive(name, items[0]), positive(name, items[1])
    if not low < high:
        raise wrong(name, value, "must be two increasing frequencies [Hz]")
    return low, high


def by_name(name: str, value: object, check: Callable[[Name, object], Kind], example: str) -> dict[str, Kind]:
    """Return a mapping, or a tuple of pairs, as a mapping with checked values; each name stands once."""
    pairs = list(value.items()) if isinstance(value, Mapping) else several(name, value, example)
    found: dict[str, Kind] = {}
    for pair in pairs:
        if not isinstance(pair, tuple | list) or len(pair) != 2 or not isinstance(pair[0], str):
            raise wrong(name, value, f"give a mapping, such as {example}")
        if pair[0] in found:
            raise wrong(name, value, f"{pair[0]!r} occurs more than once; name each once")
        found[str(pair[0])] = check((name, str(pair[0])), pair[1])
    return found


def new_names(name: str, value: object) -> FrozenItems[str]:
    """Return texts by name."""
    return FrozenItems(by_name(name, value, text, "{'old': 'new'}"))


def factors(name: str, value: object) -> FrozenMapping:
    """Return factors by name."""
    return FrozenMapping(by_name(name, value, not_zero, "{'seat': -9.81}"))


def masses(name: str, value: object) -> FrozenMapping:
    """Return masses [kg] by name."""
    return FrozenMapping(by_name(name, value, not_negative, "{'seat': 75.0}"))


def relative_stds(name: str, value: object) -> float | FrozenMapping:
    """Return a relative standard deviation, or several by name."""
    if isinstance(value, Mapping):
        return FrozenMapping(by_name(name, value, positive, "{'tire.stiffness': 0.1}"))
    return positive(name, value)


def bounds(name: str, value: object) -> FrozenItems[tuple[float | None, float | None]]:
    """Return lower and upper bounds by name; None and infinity are no bounds."""
    return FrozenItems(by_name(name, value, _ends, "{'tire.stiffness': (1e5, 3e5)}"))


def _ends(name: Name, value: object) -> tuple[float | None, float | None]:
    items = several(name, value, "(1e5, 3e5)")
    if len(items) != 2:
        raise wrong(name, value, "give (low, high), with None for no bound")
    low, high = _end(name, items[0], -math.inf), _end(name, items[1], math.inf)
    if low is not None and high is not None and not low < high:
        raise wrong(name, value, "low must be below high")
    return low, high


def _end(name: Name, value: object, none: float) -> float | None:
    """Return one end; the infinity on its side is none."""
    return None if value is None or (isinstance(value, float) and value == none) else number(name, value)
