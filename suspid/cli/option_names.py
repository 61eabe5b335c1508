"""Names of options: those of Python arguments, and those used by other programs."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager

import click

from suspid.wording import called

# What the arguments of Python are called on the command line.
ARGUMENTS_AS_OPTIONS = {
    "added_masses": "--added",
    "band_hz": "--band",
    "before": "--before",
    "behind": "--behind",
    "bounds": "--bound",
    "car": "--car",
    "channels": "--channel",
    "clearance": "--clearance",
    "constraints": "--limit",
    "dbc": "--dbc",
    "decay": "--decay",
    "duration": "--duration",
    "delays": "--delay",
    "fixed": "--fixed",
    "free_masses": "--free-mass",
    "gains": "--gain",
    "fs": "--fs",
    "given": "--given",
    "impulse": "--impulse",
    "initial_state": "--initial",
    "lateral": "--lateral",
    "linearise": "--linearise",
    "longitudinal": "--longitudinal",
    "level": "--level",
    "loads": "--load",
    "method": "--method",
    "modes": "--modes",
    "mounts": "--mount",
    "noisy": "--noisy",
    "nominal_std": "--nominal-std",
    "objective": "--objective",
    "parameters": "--parameter",
    "pattern": "--vehicle-from",
    "points": "--points",
    "rename": "--rename",
    "road": "--road",
    "robust": "--robust",
    "scale": "--scale",
    "shortest": "--shortest",
    "speed": "--speed",
    "speed_unit": "--speed-unit",
    "start": "--from",
    "stop": "--to",
    "test": "--test",
    "ties": "--tie",
    "time": "--time",
    "tolerance": "--tolerance",
    "vertical": "--vertical",
    "weightings": "--weighting",
    "wheel_radius": "--wheel-radius",
    "without": "--without",
}
# What those who come from other programs write, and what it is called here: the first that the command has.
CALLED_ELSEWHERE: Mapping[str, tuple[str, ...]] = {
    "--columns": ("--channel",),
    "--cutoff": ("--band",),
    "--end": ("--to",),
    "--exclude": ("--without",),
    "--frequency": ("--band",),
    "--html": ("--page", "--output"),
    "--mass": ("--free-mass",),
    "--order": ("--modes",),
    "--out": ("--output",),
    "--output": ("--json",),
    "--pdf": ("--page", "--output"),
    "--rate": ("--fs",),
    "--sampling-rate": ("--fs",),
    "--report": ("--page", "--output"),
    "--start": ("--from",),
    "--std": ("--nominal-std",),
    "--stop": ("--to",),
    "--unit": ("--scale",),
    "--units": ("--scale",),
    "-V": ("--version",),
    "-o": ("--json",),
    "-v": ("--version",),
}
# The same for commands; those with a line before them are options of the program.
COMMANDS_ELSEWHERE: Mapping[str, str] = {
    **dict.fromkeys(("analyse", "analyze", "find", "fit", "modalfit"), "identify"),
    **dict.fromkeys(("damp", "eig", "eigenmodes"), "modes"),
    **dict.fromkeys(("info", "list", "read", "show"), "channels"),
    **dict.fromkeys(("optimise", "optimize"), "tune"),
    "greyest": "estimate", "help": "--help", "version": "--version", "wear": "compare",
}  # fmt: skip
# Likeness of two names from which one may be meant by the other: a letter or two of a short one are wrong.
LIKE_NAME = 0.75


def in_options(*commands: click.Command | None) -> AbstractContextManager[None]:
    """Write arguments of Python as options of commands, by default that which runs, in the texts made within.

    Examples
    --------
    >>> from suspid import SuspidError
    >>> from suspid.wording import Argument
    >>> error = SuspidError("hold it with ", Argument("fixed", "…"), ", or set ", Argument("rate", "2"))
    >>> with in_options(click.Command("reconstruct", params=[click.Option(["--fixed"])])):
    ...     print(error)
    hold it with --fixed …, or set rate=2
    """
    meant = [command for command in commands if command is not None] or [click.get_current_context().command]
    known = {name for command in meant for option in command.params for name in option.opts}
    return called({argument: option for argument, option in ARGUMENTS_AS_OPTIONS.items() if option in known})


@contextmanager
def named_elsewhere() -> Iterator[None]:
    """Name the option that is meant by one of another program."""
    try:
        yield
    except click.NoSuchOption as error:
        command = None if error.ctx is None else error.ctx.command
        known = {name for option in getattr(command, "params", ()) for name in option.opts} | {"--version"}
        meant = [name for name in CALLED_ELSEWHERE.get(error.option_name, ()) if name in known][:1]
        meant = meant or difflib.get_close_matches(error.option_name, sorted(known), n=2, cutoff=LIKE_NAME)
        have = [] if meant else _commands_with(error.option_name, error.ctx)
        way = f"Did you mean {' or '.join(map(repr, meant))}?" if meant else ""
        if have:
            way = f"Commands that have it: {', '.join(have)}."
        text = f"No such option '{error.option_name}'. {way}".rstrip()
        raise click.NoSuchOption(error.option_name, text, ctx=error.ctx) from None


def _commands_with(option: str, ctx: click.Context | None) -> list[str]:
    """Return the commands beside that of a context, or below it, that have an option."""
    groups = () if ctx is None else (ctx.command, *([] if ctx.parent is None else [ctx.parent.command]))
    group = next((one for one in groups if isinstance(one, click.Group)), None)
    commands = {} if group is None else group.commands
    return [name for name, one in commands.items() if any(option in each.opts for each in one.params)]
