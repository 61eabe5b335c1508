"""Patience: how often structures of several modes and forces are sought in vain within one analysis.

An analysis tries many stretches of a recording. Where costly searches have failed on some, others fail as well: noise,
and sensors that are driven, would take minutes. The limits are counts of steps, not of time: they do not hang on the
machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

# Steps of a motion from which on a search is costly: rigs with friction take fewer, or succeed. After as many of them
# in vain with as many channels, or as many steps of these, no more are made.
COSTLY, SEARCHES_IN_VAIN, STEPS_IN_VAIN = 100_000, 3, 600_000

# Steps of each search in vain, by the number of channels.
_in_vain: ContextVar[dict[int, list[int]] | None] = ContextVar("in_vain", default=None)
_stepped: ContextVar[list[int] | None] = ContextVar("stepped", default=None)


@contextmanager
def patience() -> Iterator[None]:
    """Count what is sought in vain within; another one inside begins anew.

    Examples
    --------
    >>> with patience():
    ...     for channels, steps in ((2, 120_000), (2, 150_000), (2, 130_000), (3, 700_000), (4, 120_000), (5, 8000)):
    ...         note_in_vain(channels, steps)
    ...     print([is_exhausted(channels) for channels in (2, 3, 4, 5)])
    [True, True, False, False]
    >>> is_exhausted(2)
    False
    """
    token = _in_vain.set({})
    try:
        yield
    finally:
        _in_vain.reset(token)


def is_exhausted(channels: int) -> bool:
    """Return whether no more structures are sought with as many channels."""
    searches = (_in_vain.get() or {}).get(channels, [])
    return len(searches) >= SEARCHES_IN_VAIN or sum(searches) >= STEPS_IN_VAIN


def note_in_vain(channels: int, steps: int) -> None:
    """Count a search in vain, if it was costly."""
    counts = _in_vain.get()
    if counts is not None and steps > COSTLY:
        counts.setdefault(channels, []).append(steps)


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
