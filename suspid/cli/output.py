"""Output of the commands: lines on both streams, errors, warnings."""

from __future__ import annotations

import errno
import os
import shutil
import sys
import textwrap
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import click

from suspid.files import printable, real_path

# How systems say that nothing more can be written.
NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
# Where the context keeps the files that hold the standard input and output, with what users read in place of their
# paths, and the file that is written to the standard output at the end.
STANDS_FOR, WRITTEN_OUT = "suspid.stands_for", "suspid.written_out"
STANDARD_INPUT, STANDARD_OUTPUT = "standard input", "standard output"


class Failed(click.ClickException):
    """An error of suspid's, shown as one line."""

    exit_code = 1

    def show(self, file: IO[Any] | None = None) -> None:
        """Write the line."""
        line = " ".join(part.strip() for part in self.message.splitlines())
        click.echo(f"suspid: error: {printable(line)}", file=file or sys.stderr)


@contextmanager
def said_when_full() -> Iterator[None]:
    """Say in one line that there is no room for output, such as the help that `click` writes."""
    try:
        yield
    except OSError as refusal:
        if refusal.errno not in NO_SPACE:
            raise
        raise _unwritten(refusal) from None


def shown(text: str) -> str:
    """Return a line as it may reach the terminal and files: printable, and without the place of standard streams."""
    context = click.get_current_context(silent=True)
    streams: dict[Path, str] = {} if context is None else context.meta.get(STANDS_FOR, {})
    for path, stream in streams.items():
        text = text.replace(str(path), stream).replace(path.name, stream)
    return printable(text)


def check_apart(inputs: list[Path], outputs: list[Path | None]) -> None:
    """Refuse an output that is also an input or another output: nothing that is read is ever overwritten."""
    taken = [real_path(path) for path in inputs]
    for path in outputs:
        if path is not None:
            if real_path(path) in taken:
                raise click.UsageError(f"{printable(str(path))} is named twice: as an output and for something else.")
            taken.append(real_path(path))


def say(text: str) -> None:
    """Print text whose names may come from a file: nothing in it reaches the terminal as a command."""
    lines = [shown(line) for line in text.split("\n")]
    context = click.get_current_context(silent=True)
    # A result that is written to the standard output stands there alone.
    aside = context is not None and WRITTEN_OUT in context.meta
    if (sys.stderr if aside else sys.stdout).isatty():
        lines = broken(lines, shutil.get_terminal_size().columns)
    try:
        click.echo("\n".join(lines), err=aside)
    except OSError as refusal:
        if refusal.errno == errno.EPIPE:
            raise
        raise _unwritten(refusal) from None


def broken(lines: list[str], width: int) -> list[str]:
    """Return lines for a terminal: sentences that are longer are broken between words, tables are not.

    Examples
    --------
    >>> broken(["- the wheel leaves the road", "figure      unit    value of it"], 20)
    ['- the wheel leaves', '  the road', 'figure      unit    value of it']
    """
    return [
        part
        for line in lines
        for part in (
            # Columns stand two spaces apart.
            textwrap.wrap(line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
            if len(line) > width and "  " not in line.strip()
            else [line]
        )
    ]


def _unwritten(refusal: OSError) -> Failed:
    # What is still to be written would fail again at the end of the program.
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return Failed(f"the output cannot be written: {refusal.strerror or refusal}")


@contextmanager
def said_warnings() -> Iterator[list[str]]:
    """Collect warnings of the library, and add one's own; at the end, or at an error, each is a line on stderr."""
    said: list[str] = []

    def add(message: Warning | str, *_: object, **__: object) -> None:
        said.append(" ".join(str(message).split()))

    with warnings.catch_warnings():
        warnings.simplefilter("default")
        for category in (DeprecationWarning, PendingDeprecationWarning, FutureWarning, ResourceWarning):
            warnings.simplefilter("ignore", category)
        warnings.showwarning = add
        try:
            yield said
        finally:
            # What was found in a file may be why the command failed.
            for text in dict.fromkeys(said):
                click.echo(f"suspid: warning: {shown(text)}", err=True)


def in_the_file(name: str, why: object) -> str:
    """Return what is said of a column; of its unit or rate, whose name has its own quotes, without further ones.

    Examples
    --------
    >>> print(in_the_file("seat", "is empty"))
    in the file: 'seat' is empty
    >>> print(in_the_file("unit of 't'", "is not stated"))
    in the file: unit of 't' is not stated
    """
    shown_name = name if name.startswith(("unit of '", "rate '")) else repr(name)
    return f"in the file: {shown_name} {why}"
