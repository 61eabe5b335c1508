"""Options of the form NAME=VALUE, and lists of names."""

from __future__ import annotations

import csv
import itertools
from collections.abc import Callable, Sequence
from typing import TypeVar

import click

Value = TypeVar("Value", str, float)


def names_in(given: Sequence[str]) -> tuple[str, ...]:
    """Return names that may stand in one text, with commas between them; a name with a comma stands in quotes.

    Examples
    --------
    >>> names_in(["seat, tire", '"acc, z"'])
    ('seat', 'tire', 'acc, z')
    """
    return tuple(name.strip() for row in csv.reader(given, skipinitialspace=True) for name in row if name.strip())


def pairs(given: Sequence[str], option: str, kind: Callable[[str], Value]) -> dict[str, Value]:
    """Return values by name from texts ``NAME=VALUE``, or several with commas between them; each name may stand once.

    Examples
    --------
    >>> pairs(["front=1,rear=2"], "--load", float), pairs(["az=Wk,Wf,ax=Wd"], "--weighting", str)
    ({'front': 1.0, 'rear': 2.0}, {'az': 'Wk,Wf', 'ax': 'Wd'})
    """
    found: dict[str, Value] = {}
    for text in itertools.chain.from_iterable(map(_apart, given)):
        name, equals, value = text.rpartition("=")
        try:
            made = kind(value)
        except ValueError:
            equals = ""
        if not equals or not name or not value or name in found:
            raise click.BadParameter(f"{text!r}: write {_form(option)}, each name once.", param_hint=f"'{option}'")
        found[name] = made
    return found


def _form(option: str) -> str:
    """Return how the command that runs writes the values of an option."""
    context = click.get_current_context(silent=True)
    parameters = [] if context is None else context.command.params
    forms = [one.metavar for one in parameters if option in one.opts and isinstance(one, click.Option)]
    return next((form for form in forms if form), "NAME=VALUE")


def _apart(text: str) -> list[str]:
    """Return the pairs in a text, each a name with what follows its ``=`` up to the next name.

    A name with a comma, alone or in quotes, stays whole.
    """
    parts: list[str] = []
    for part in next(csv.reader([text], skipinitialspace=True), []):
        if "=" in part:
            parts.append(part.strip())
        elif parts and part.strip():
            parts[-1] += f",{part.strip()}"
        else:
            return [text]
    return parts or [text]
