"""Arguments of another type than a function takes: the raw error they lead to is told by the argument.

Nothing is checked before a call, so whatever works is taken. Only where a call failed is each argument compared with
its annotation; where all fit, the error stays as it was raised.
"""

from __future__ import annotations

import functools
import inspect
import numbers
import re
import sys
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from suspid.calls import misfit
from suspid.errors import InputError, SuspidError
from suspid.wording import Argument

Given = ParamSpec("Given")
Returned = TypeVar("Returned")

# Characters of a value that a message shows; of a longer one its type alone.
LONGEST_SHOWN = 40
# What annotations of numbers take, those of numpy too; True is no number.
NUMBER_TYPES: Mapping[object, type] = {float: numbers.Real, int: numbers.Integral, complex: numbers.Complex}

# What the annotation of arrays consists of.
ARRAYS = frozenset(typing.get_args(ArrayLike))
# Where names are looked up that a module imports for type checkers alone.
PLACES = ("builtins", "suspid", "collections.abc", "numpy.typing", "matplotlib.axes", "matplotlib.figure")


def explained(verb: Callable[Given, Returned]) -> Callable[Given, Returned]:
    """Return the function; a raw error that an argument of another type led to becomes an `InputError` that names it.

    Examples
    --------
    >>> @explained
    ... def half(value: float) -> float:
    ...     return value / 2
    >>> half(3.0)
    1.5
    >>> half("3")
    Traceback (most recent call last):
    suspid.errors.InputError: value='3' is a str where float is needed; help(suspid.half) describes it
    """

    @functools.wraps(verb)
    def told(*args: Given.args, **kwargs: Given.kwargs) -> Returned:
        # In a failing test pytest shows the test, not this frame.
        __tracebackhide__ = True
        try:
            return verb(*args, **kwargs)
        except SuspidError:
            raise
        except Exception as error:
            try:
                given = inspect.signature(verb).bind(*args, **kwargs).arguments
            except TypeError as unfit:
                # Python's own message names the function; that of the binding does not.
                raise misfit(verb, error if isinstance(error, TypeError) else unfit, args, kwargs) from None
            refusal = _refusal(verb, given)
            if refusal is None:
                raise
            raise refusal from error

    return told


def hints(verb: Callable[..., object]) -> dict[str, Any]:
    """Return the types that the parameters are annotated with; what cannot be resolved stands for anything."""
    function = inspect.unwrap(verb)
    return {
        name: _Names(function.__globals__).resolved(text) for name, text in inspect.get_annotations(function).items()
    }


def fits(value: object, hint: Any) -> bool:
    """Return whether a value is of an annotated type, in doubt True.

    Examples
    --------
    >>> fits(1, float), fits("1", float), fits(["a"], Sequence[str]), fits("a", Sequence[str]), fits(3, int | None)
    (True, False, True, False, True)
    """
    kind, parts = typing.get_origin(hint) or hint, typing.get_args(hint)
    if kind is typing.Annotated:
        return fits(value, parts[0])
    if kind in (typing.Union, types.UnionType):
        arrays = set(parts) >= ARRAYS
        return (arrays and _is_numeric(value)) or any(fits(value, p) for p in parts if not (arrays and p in ARRAYS))
    if kind is typing.Literal:
        return any(type(value) is type(one) and value == one for one in parts)
    if kind is None or kind in NUMBER_TYPES:
        return value is None if kind is None else isinstance(value, NUMBER_TYPES[kind]) and not isinstance(value, bool)
    return not isinstance(kind, type) or (_is_a(value, kind) and _members_fit(value, kind, parts))


class _Unknown(type):
    """The type of a stand-in for annotations that cannot be resolved: everything is an instance of it."""

    def __instancecheck__(cls, value: object) -> bool:
        return True

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return cls

    def __getitem__(cls, parts: object) -> Any:
        return cls


class _Anything(metaclass=_Unknown):
    pass


class _Names(dict[str, Any]):
    """Names that annotations use; those imported for type checkers alone are looked up in what is loaded."""

    def resolved(self, annotation: object) -> Any:
        try:
            return eval(annotation, {}, self) if isinstance(annotation, str) else annotation
        except (TypeError, AttributeError):
            return _Anything

    def __getitem__(self, name: str) -> Any:
        loaded = [vars(sys.modules[place]) for place in PLACES if place in sys.modules]
        places: list[Mapping[str, object]] = [self.copy(), *loaded, sys.modules]
        # An alias may be a text itself.
        return self.resolved(next((names[name] for names in places if name in names), _Anything))


def _refusal(verb: Callable[..., object], given: Mapping[str, object]) -> InputError | None:
    """Return the error about the first argument that is none of what the function takes."""
    known = hints(verb)
    for name, value in given.items():
        if name in known and not fits(value, known[name]):
            kind, shown = type(value).__name__, repr(value)
            short = len(shown) <= LONGEST_SHOWN and shown.isprintable() and not shown.startswith("<")
            return InputError(
                Argument(name, shown if short else "…"),
                f" is {'an' if kind[0] in 'aeioAEIO' else 'a'} {kind} where {_needed(verb, name)} is needed; "
                f"help(suspid.{verb.__qualname__}) describes it",
            )
    return None


def _needed(verb: Callable[..., object], name: str) -> str:
    """Return what a parameter is to be, in the words of the documentation or else of the annotation."""
    said = re.search(rf"^(?:\w+, )*{name}(?:, \w+)* : (.+)$", inspect.getdoc(verb) or "", re.MULTILINE)
    return said[1].removesuffix(", optional") if said else str(inspect.unwrap(verb).__annotations__[name])


def _is_a(value: object, kind: type) -> bool:
    if issubclass(kind, Iterable) and not issubclass(kind, str) and isinstance(value, str | bytes):
        return False
    if kind is np.ndarray:
        return isinstance(value, Sequence | np.ndarray)
    try:
        return isinstance(value, kind)
    except TypeError:  # a protocol that cannot be asked for
        return True


def _members_fit(value: object, kind: type, parts: tuple[Any, ...]) -> bool:
    """Return whether the members of a collection are of the types named; what can be read only once stays unread."""
    if isinstance(value, Mapping):
        return len(parts) != 2 or all(fits(k, parts[0]) and fits(v, parts[1]) for k, v in value.items())
    if kind is np.ndarray:
        return parts[1] == np.dtype[np.object_] or _is_numeric(value)
    if not isinstance(value, Collection) or not parts:
        return True
    if kind is tuple and parts[-1] is not Ellipsis:
        return len(value) == len(parts) and all(map(fits, value, parts))
    return all(fits(one, parts[0]) for one in value)


def _is_numeric(value: object) -> bool:
    try:
        return np.asarray(value).dtype.kind in "biufc" or bool(np.asarray(value, float).size)
    except (TypeError, ValueError):
        return False
