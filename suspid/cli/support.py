"""What the commands of ``suspid`` share: how they refuse, warn and print, and how their options are read."""

from __future__ import annotations

import errno
import io
import math
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import click

from suspid.errors import SuspidError
from suspid.files import printable
from suspid.values import within_numbers
from suspid.wording import called

# What the arguments of Python are called on the command line.
ARGUMENTS_AS_OPTIONS = {
    "added_masses": "--added",
    "band_hz": "--band",
    "bounds": "--bound",
    "channels": "--channel",
    "dbc": "--dbc",
    "decay": "--decay",
    "delays": "--delay",
    "fixed": "--fixed",
    "free_masses": "--free-mass",
    "gains": "--gain",
    "fs": "--fs",
    "given": "--given",
    "level": "--level",
    "method": "--method",
    "modes": "--modes",
    "mounts": "--mount",
    "nominal_std": "--nominal-std",
    "rename": "--rename",
    "road": "--road",
    "scale": "--scale",
    "speed": "--speed",
    "start": "--from",
    "stop": "--to",
    "test": "--test",
    "ties": "--tie",
    "time": "--time",
    "tolerance": "--tolerance",
    "vertical": "--vertical",
    "wheel_radius": "--wheel-radius",
    "without": "--without",
}
# How systems say that nothing more can be written.
NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
# What those who come from other programs write, and what it is called here.
CALLED_ELSEWHERE = {
    "--columns": "--channel",
    "--cutoff": "--band",
    "--end": "--to",
    "--exclude": "--without",
    "--frequency": "--band",
    "--html": "--output",
    "--mass": "--free-mass",
    "--order": "--modes",
    "--out": "--output",
    "--output": "--json",
    "--pdf": "--page",
    "--rate": "--fs",
    "--sampling-rate": "--fs",
    "--start": "--from",
    "--stop": "--to",
    "--unit": "--scale",
    "--units": "--scale",
    "-V": "--version",
    "-o": "--json",
    "-v": "--version",
}
# Where the context keeps the arguments of the command.
ARGUMENTS = "suspid.arguments"
# Where the context keeps the file that holds the standard input, and what users read in place of its path.
PIPED, STANDARD_INPUT = "suspid.piped", "standard input"


class Finite(click.ParamType[float]):
    """A finite number, in the unit that ``name`` says."""

    required = "finite"

    def __init__(self, unit: str) -> None:
        self.name = unit

    @property
    def wanted(self) -> str:
        """What to write in place of what is no number."""
        return (
            "write a share of one, such as 0.3"
            if self.name == "share"
            else f"write it in {self.name}, without the unit"
        )

    def allowed(self, number: float) -> bool:
        """Return whether the number may be given."""
        return math.isfinite(number)

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or refuse it as a usage error."""
        try:
            number = float(str(value))
        except ValueError:
            self.fail(f"{value!r} is not a number; {self.wanted}.", param, ctx)
        if not self.allowed(number):
            self.fail(f"{value} {self.name} must be {self.required}.", param, ctx)
        return number


class Positive(Finite):
    """A finite number above zero, in the unit that ``name`` says."""

    required = "positive and finite"

    def allowed(self, number: float) -> bool:
        """Return whether the number may be given."""
        return number > 0 and math.isfinite(number)


class Probability(click.FloatRange):
    """A probability between 0 and 1."""

    name = "share"

    def __init__(self) -> None:
        super().__init__(0, 1, min_open=True, max_open=True)


class Whole(click.IntRange):
    """A whole number from one on, up to another if one is given."""

    name = "n"


class _Failure(click.ClickException):
    """An error of suspid's, shown as one line."""

    exit_code = 1

    def show(self, file: IO[Any] | None = None) -> None:
        line = " ".join(part.strip() for part in self.message.splitlines())
        click.echo(f"suspid: error: {printable(line)}", file=file or sys.stderr)


def in_options(command: click.Command | None = None) -> AbstractContextManager[None]:
    """Write arguments of Python as options of a command, by default that which runs, in the texts made within.

    Examples
    --------
    >>> from suspid.wording import Argument
    >>> error = SuspidError("hold it with ", Argument("fixed", "…"), ", or set ", Argument("rate", "2"))
    >>> with in_options(click.Command("reconstruct", params=[click.Option(["--fixed"])])):
    ...     print(error)
    hold it with --fixed …, or set rate=2
    """
    command = command or click.get_current_context().command
    known = {name for option in command.params for name in option.opts}
    return called({argument: option for argument, option in ARGUMENTS_AS_OPTIONS.items() if option in known})


class Terminated(KeyboardInterrupt):
    """The program was told to end by SIGTERM: it leaves as after Ctrl-C, without half a file or a worker."""


@contextmanager
def ends_when_told() -> Iterator[None]:
    """Raise `Terminated` on SIGTERM, unless whoever runs this listens already."""

    def end(*_: object) -> None:
        raise Terminated

    mine = threading.current_thread() is threading.main_thread()
    if not mine or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def stopped_code(stop: KeyboardInterrupt) -> int:
    """Return the exit code that shells give to a program that a signal ended.

    Examples
    --------
    >>> stopped_code(KeyboardInterrupt()), stopped_code(Terminated())
    (130, 143)
    """
    return 128 + (signal.SIGTERM if isinstance(stop, Terminated) else signal.SIGINT)


@contextmanager
def said_when_full() -> Iterator[None]:
    """Say in one line that there is no room for output, such as the help that `click` writes."""
    try:
        yield
    except OSError as refusal:
        if refusal.errno not in NO_SPACE:
            raise
        raise _unwritten(refusal) from None


@contextmanager
def named_elsewhere() -> Iterator[None]:
    """Name the option that is meant by one of another program."""
    try:
        yield
    except click.NoSuchOption as error:
        command = None if error.ctx is None else error.ctx.command
        known = {name for option in getattr(command, "params", ()) for name in option.opts} | {"--version"}
        meant = CALLED_ELSEWHERE.get(error.option_name)
        if meant not in known:
            raise
        text = f"No such option '{error.option_name}'. Did you mean '{meant}'?"
        raise click.NoSuchOption(error.option_name, text, ctx=error.ctx) from None


class Commands(click.Group):
    """Commands whose `SuspidError` ends the program with one line instead of a traceback."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Keep the arguments, for reports that show the command they come from."""
        ctx.meta[ARGUMENTS] = list(args)
        with said_when_full(), named_elsewhere():
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command that was asked for."""
        for stream in (sys.stdout, sys.stderr):
            # A terminal that cannot show "±" gets its code, not a traceback.
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
        try:
            with ends_when_told(), within_numbers(), said_when_full(), named_elsewhere():
                return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            click.echo("suspid: stopped", err=True)
            raise click.exceptions.Exit(stopped_code(stop)) from None
        except SuspidError as error:
            with in_options(self.commands.get(ctx.invoked_subcommand or "", self)):
                raise _Failure(shown(str(error))) from None


def shown(text: str) -> str:
    """Return a line as it may reach the terminal and files: printable, and without the place of the standard input."""
    context = click.get_current_context(silent=True)
    piped = None if context is None else context.meta.get(PIPED)
    return printable(text if piped is None else text.replace(str(piped), STANDARD_INPUT))


def check_apart(inputs: list[Path], outputs: list[Path | None]) -> None:
    """Refuse an output that is also an input or another output: nothing that is read is ever overwritten."""
    taken = [path.resolve() for path in inputs]
    for path in outputs:
        if path is not None:
            if path.resolve() in taken:
                raise click.UsageError(f"{printable(str(path))} is named twice: as an output and for something else.")
            taken.append(path.resolve())


def say(text: str) -> None:
    """Print text whose names may come from a file: nothing in it reaches the terminal as a command."""
    try:
        click.echo("\n".join(shown(line) for line in text.split("\n")))
    except OSError as refusal:
        if refusal.errno == errno.EPIPE:
            raise
        raise _unwritten(refusal) from None


def _unwritten(refusal: OSError) -> _Failure:
    # What is still to be written would fail again at the end of the program.
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return _Failure(f"the output cannot be written: {refusal.strerror or refusal}")


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
