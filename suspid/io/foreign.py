"""Calls of foreign libraries: a failure becomes one line; what they print, log and warn of is suppressed."""

from __future__ import annotations

import contextlib
import gc
import io
import logging
import re
import sys
import threading
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import requires
from typing import TextIO, TypeVar

from suspid.errors import RecordError
from suspid.files import printable

Answer = TypeVar("Answer")
ONE_AT_A_TIME = threading.RLock()
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
    """Suppress what this thread prints, logs and warns of; what other threads print and log goes where it went.

    One thread at a time: what is changed for the process is put back before the next one changes it.
    """
    with ONE_AT_A_TIME, warnings.catch_warnings(), contextlib.ExitStack() as stack:
        warnings.simplefilter("ignore")
        silent = threading.get_ident()
        stack.enter_context(contextlib.redirect_stdout(_Elsewhere(sys.stdout, silent)))
        stack.enter_context(contextlib.redirect_stderr(_Elsewhere(sys.stderr, silent)))
        for handler in [*logging.root.handlers, *filter(None, [logging.lastResort])]:
            kept = partial(_is_of_others, silent)
            handler.addFilter(kept)
            stack.callback(handler.removeFilter, kept)
        unraisable = sys.unraisablehook
        stack.callback(setattr, sys, "unraisablehook", unraisable)
        # The destructor of a reader that failed may fail as well.
        sys.unraisablehook = lambda raised: None if threading.get_ident() == silent else unraisable(raised)
        yield


def _is_of_others(silent: int, record: logging.LogRecord) -> bool:
    return record.thread != silent


class _Elsewhere(io.TextIOBase):
    """A stream that drops what one thread writes and passes on what others do."""

    def __init__(self, stream: TextIO | None, silent: int) -> None:
        self._stream, self._silent = stream, silent

    def write(self, text: str, /) -> int:
        if self._stream is not None and threading.get_ident() != self._silent:
            return self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        if self._stream is not None and threading.get_ident() != self._silent:
            self._stream.flush()


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
