"""Calls of foreign libraries: a failure becomes one line; what they print, log and warn of is suppressed."""

from __future__ import annotations

import contextlib
import gc
import io
import logging
import re
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import requires
from typing import TypeVar

from suspid.errors import RecordError
from suspid.files import printable

Answer = TypeVar("Answer")
# Characters of a foreign message that are passed on: some state the whole content of a block.
LONGEST_MESSAGE = 160


def sheltered(read: Callable[[], Answer], *, extra: str, suffix: str, doing: str = "reading") -> Answer:
    r"""Return what a library reads, ``extra`` being suspid's that brings it; turn every failure into one line.

    Examples
    --------
    >>> def read():
    ...     raise MemoryError("line 1\nline 2")
    >>> sheltered(read, extra="tdms", suffix=".tdms")
    Traceback (most recent call last):
    suspid.errors.RecordError: is damaged: MemoryError: line 1 line 2
    """
    with _silence():
        try:
            return read()
        except RecordError:
            raise
        except ModuleNotFoundError as refusal:
            message = f"{doing} {suffix} needs {refusal.name or extra}: {install_line(extra)}"
        # A damaged file causes errors of every kind, MemoryError and RecursionError among them.
        except Exception as refusal:
            words = printable(" ".join(str(refusal).split()))
            words = words if len(words) <= LONGEST_MESSAGE else f"{words[:LONGEST_MESSAGE]} …"
            message = f"is damaged: {type(refusal).__name__}{f': {words}' if words else ''}"
        # Files that the failed reader holds open are closed here, where warnings are suppressed. The error below is
        # raised outside the handler, so that it does not keep the frames of the reader alive.
        gc.collect()
    raise RecordError(message)


def install_line(extra: str) -> str:
    """Return the command that installs the requirements of an extra of suspid.

    Examples
    --------
    >>> install_line("uff")
    "pip install 'pyuff>=...'"
    """
    marker = re.compile(rf"""extra\s*==\s*['"]{re.escape(extra)}['"]""")
    stated = [text.partition(";") for text in requires("suspid") or ()]
    wanted = [requirement.strip() for requirement, _, condition in stated if marker.search(condition)]
    return " ".join(["pip install", *(f"'{requirement}'" for requirement in wanted)])


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    logged, unraisable = logging.root.manager.disable, sys.unraisablehook
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        warnings.simplefilter("ignore")
        logging.disable(logging.CRITICAL)
        # The destructor of a reader that failed may fail as well.
        sys.unraisablehook = lambda _: None
        try:
            yield
        finally:
            sys.unraisablehook = unraisable
            logging.disable(logged)


def unique_names(named: Sequence[tuple[str, str]]) -> list[str]:
    """Return a name for each pair of group and name that no other has.

    Examples
    --------
    >>> unique_names([("front", "z"), ("rear", "z"), ("rear", "speed"), ("rear", "z")])
    ['front/z', 'rear/z', 'speed', 'rear/z (2)']
    """
    often = Counter(name for _, name in named)
    unique: dict[str, None] = {}
    for group, name in named:
        stem = f"{group}/{name}" if often[name] > 1 and group else name or "channel"
        full, number = stem, 1
        while full in unique:
            number += 1
            full = f"{stem} ({number})"
        unique[full] = None
    return list(unique)
