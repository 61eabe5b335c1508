"""The group of commands: start, errors and signals."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import click

from suspid.cli.option_groups import Grouped
from suspid.cli.option_names import COMMANDS_ELSEWHERE, in_options, named_elsewhere
from suspid.cli.output import Failed, said_when_full, shown
from suspid.errors import SuspidError
from suspid.values import within_numbers

# Where the context keeps the arguments of the command.
ARGUMENTS = "suspid.arguments"


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


def open_closed_streams() -> None:
    """Give the null device to standard streams that were closed, as by `>&-`; files would take their place."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode))


@contextmanager
def drawn_to_files() -> Iterator[None]:
    """Let matplotlib draw to files while a command runs; the user's MPLBACKEND may need a screen, or be misspelt."""
    before = os.environ.get("MPLBACKEND")
    os.environ["MPLBACKEND"] = "agg"
    try:
        yield
    finally:
        del os.environ["MPLBACKEND"]
        if before is not None:
            os.environ["MPLBACKEND"] = before


def stopped_code(stop: KeyboardInterrupt) -> int:
    """Return the exit code that shells give to a program that a signal ended.

    Examples
    --------
    >>> stopped_code(KeyboardInterrupt()), stopped_code(Terminated())
    (130, 143)
    """
    return 128 + (signal.SIGTERM if isinstance(stop, Terminated) else signal.SIGINT)


def check_once(command: click.Command, above: click.Context, arguments: list[str]) -> None:
    """Refuse an option with too few values, and one of a single value that is given twice: the last would count."""
    ctx = click.Context(command, info_name=command.name, parent=above)
    try:
        _, _, given = command.make_parser(ctx).parse_args(list(arguments))
    except click.BadOptionUsage as error:
        option = next((one for one in command.params if error.option_name in one.opts), None)
        if option is None:
            return
        needed = f"{error.message.rstrip('.')}: {error.option_name} {option.make_metavar(ctx)}"
        raise click.BadOptionUsage(error.option_name, needed, ctx=ctx) from None
    except click.UsageError:
        return  # The command itself says what is wrong.
    for option in given:
        several = not isinstance(option, click.Option) or option.multiple or option.is_flag or option.count
        if given.count(option) > 1 and not several:
            raise click.BadParameter("given twice; it takes one value.", ctx=ctx, param=option)


# Commands whose output is read for the options of another one, or that do its work without all of its options.
FOLLOWED_BY = {"channels": "identify", "report": "estimate"}


class Commands(click.Group):
    """Commands whose `SuspidError` ends the program with one line instead of a traceback."""

    command_class: type[click.Command] | None = Grouped

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Keep the arguments, for reports that show the command they come from."""
        ctx.meta[ARGUMENTS] = list(args)
        with said_when_full(), named_elsewhere():
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command that was asked for."""
        open_closed_streams()
        for stream in (sys.stdout, sys.stderr):
            # A terminal that cannot show "±" gets its code, not a traceback.
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
        try:
            with ends_when_told(), drawn_to_files(), within_numbers(), said_when_full(), named_elsewhere():
                return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            click.echo("suspid: stopped", err=True)
            raise click.exceptions.Exit(stopped_code(stop)) from None
        except SuspidError as error:
            raise Failed(shown(str(error))) from None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that was asked for; until it ends, all texts name its options instead of arguments."""
        if args[0] not in self.commands and (meant := COMMANDS_ELSEWHERE.get(args[0])):
            ctx.fail(f"No such command {args[0]!r}. Did you mean {meant!r}?")
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None:
            check_once(command, ctx, rest)
            ctx.with_resource(in_options(command, self.commands.get(FOLLOWED_BY.get(name or "", ""))))
        return name, command, rest
