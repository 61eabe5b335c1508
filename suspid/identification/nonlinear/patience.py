"""Patience: how often structures of several modes and forces are sought in vain within one analysis.

An analysis tries many stretches of a recording. Where costly searches have failed on some, others fail as well: noise,
and sensors that are driven, would take minutes. The limits are counts of steps, not of time: they do not hang on the
machine.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

# Costly searches in vain with as many channels, after which no more are made, and the steps of a motion from which on
# one is costly: rigs with friction take fewer, or succeed.
SEARCHES_IN_VAIN, COSTLY = 3, 100_000

_in_vain: ContextVar[Counter[int] | None] = ContextVar("in_vain", default=None)
_stepped: ContextVar[list[int] | None] = ContextVar("stepped", default=None)


@contextmanager
def patience() -> Iterator[None]:
    """Count what is sought in vain within; another one inside begins anew.

    Examples
    --------
    >>> with patience():
    ...     for _ in range(3):
    ...         note_in_vain(2)
    ...     print(is_exhausted(2), is_exhausted(3))
    True False
    >>> is_exhausted(2)
    False
    """
    token = _in_vain.set(Counter())
    try:
        yield
    finally:
        _in_vain.reset(token)


def is_exhausted(channels: int) -> bool:
    """Return whether no more structures are sought with as many channels."""
    counts = _in_vain.get()
    return counts is not None and counts[channels] >= SEARCHES_IN_VAIN


def note_in_vain(channels: int) -> None:
    """Count a costly search in vain."""
    counts = _in_vain.get()
    if counts is not None:
        counts[channels] += 1


@contextmanager
def counted_steps() -> Iterator[list[int]]:
    """Give a list whose only number counts the steps of motions within.

    Examples
    --------
    >>> with counted_steps() as steps:
    ...     note_steps(500)
    >>> steps
    [500]
    """
    steps = [0]
    token = _stepped.set(steps)
    try:
        yield steps
    finally:
        _stepped.reset(token)


def note_steps(count: int) -> None:
    """Count the steps of a motion."""
    steps = _stepped.get()
    if steps is not None:
        steps[0] += count
