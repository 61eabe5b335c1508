"""Options that several commands share, and the settings made of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from typing import Any, Literal, TypeAlias, cast, get_args

import click

from suspid.analysis import Settings
from suspid.cli.named_values import names_in, pairs
from suspid.cli.option_names import in_options
from suspid.cli.quantities import Finite, Positive, Whole
from suspid.cli.streams import FILE
from suspid.errors import InputError
from suspid.identification import Method, identify

TIME_OPTION = click.option(
    "--time", metavar="NAME", help="Column of time, if its name does not say so; none: ignore times in the file."
)
FS_OPTION = click.option(
    "--fs", type=Positive("Hz"), metavar="HZ", help="Sampling rate; replaces any time in the file."
)
ON_ROAD = click.option("--road", metavar="A..H|G_d", help="Class of ISO 8608, or G_d(0.1 cycle/m) [m3].")
AT_SPEED = click.option("--speed", type=Positive("m/s"), help="Speed.")
LINEARISE = click.option(
    "--linearise",
    type=Positive("m/s"),
    metavar="V",
    help="Replace friction and curves by dampers of equal work at this amplitude of velocity [m/s].",
)
DBC_OPTION = click.option(
    "--dbc", type=FILE, metavar="FILE", help="Database that decodes the CAN frames of an MDF file."
)

# What gives a command options.
Decorator: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]


class Which(click.ParamType[str]):
    """Which decay: "auto", "whole", "all", or its rank."""

    name = "auto|whole|all|N"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the choice, or refuse it as a usage error."""
        text = str(value)
        if text not in ("auto", "whole", "all") and not (text.isdecimal() and int(text) > 0):
            self.fail(f"{text!r} is not auto, whole, all or a rank (1, 2, …).", param, ctx)
        return text


READING = (
    click.option("--test", metavar="NAME", help="Which of several tests in the file; all joins them."),
    click.option(
        "--channel", "channels", metavar="NAME", multiple=True, help="Channel to use; repeat, or NAME,NAME. [all]"
    ),
    click.option("--without", metavar="NAME", multiple=True, help="Channel to leave out; repeat, or NAME,NAME."),
    click.option(
        "--rename",
        "renames",
        metavar="OLD=NEW",
        multiple=True,
        help="Rename a channel; repeat, or A=B,C=D.",
    ),
    click.option(
        "--scale",
        "scales",
        metavar="NAME=FACTOR",
        multiple=True,
        help="Multiply a channel: NAME=FACTOR, such as az=-9.81; repeat.",
    ),
    click.option("--vertical", metavar="X,Y,Z", help="Add the vertical of a tilted accelerometer, and drop its axes."),
    click.option("--si", is_flag=True, help="Convert channels to SI from the units in the file."),
    TIME_OPTION,
    FS_OPTION,
    DBC_OPTION,
)
STRETCH = (
    click.option(
        "--from", "start", type=Finite("s"), metavar="SECONDS", help="First time to use; of a decay, its start."
    ),
    click.option(
        "--to", "stop", type=Finite("s"), metavar="SECONDS", help="Last time to use; alone, a decay may begin later."
    ),
    click.option(
        "--decay",
        "which",
        type=Which(),
        default="auto",
        show_default=True,
        help="auto: the best decay if the largest motion comes late; whole: the whole record; all: all decays jointly; "
        "N: the decay of rank N.",
    ),
)


METHOD = inspect.signature(identify).parameters["method"].default
SETTINGS = (
    click.option("--modes", type=Whole(1), help="Number of modes. [all significant ones]"),
    click.option(
        "--method",
        type=click.Choice(get_args(Method)),
        default=METHOD,
        show_default=True,
        help="Method of identification.",
    ),
    click.option("--band", type=Positive("Hz"), nargs=2, metavar="LOW HIGH", help="Lowest and highest frequency [Hz]."),
)


def settings_of(
    *,
    test: str | None,
    channels: tuple[str, ...],
    without: tuple[str, ...],
    renames: tuple[str, ...],
    scales: tuple[str, ...],
    vertical: str | None,
    si: bool,
    time: str | None,
    fs: float | None,
    dbc: Path | None,
    start: float | None,
    stop: float | None,
    which: str,
    modes: int | None,
    method: Method,
    band: tuple[float, float] | None,
) -> Settings:
    """Return the settings that the options ask for, or refuse them as a usage error."""
    axes = None if vertical is None else tuple(name.strip() for name in vertical.split(","))
    if axes is not None and len(axes) != 3:
        raise click.BadParameter(f"{vertical!r}: name three axes, as X,Y,Z.", param_hint="'--vertical'")
    decay = int(which) if which.isdecimal() else cast("Literal['auto', 'whole', 'all']", which)
    rename, scale = pairs(renames, "--rename", str), pairs(scales, "--scale", float)
    if start is not None and stop is not None and not start < stop:
        raise click.BadParameter(f"{start:g} s is not before {stop:g} s.", param_hint="'--from' / '--to'")
    if band and not band[0] < band[1]:
        raise click.BadParameter(f"{band[0]:g} Hz is not below {band[1]:g} Hz.", param_hint="'--band'")
    try:
        return Settings(
            test=test,
            channels=names_in(channels) or None,
            without=names_in(without),
            rename=rename,
            scale=scale,
            vertical=axes,
            si=si,
            time=time,
            fs=fs,
            dbc=dbc,
            start=start,
            stop=stop,
            decay=decay,
            modes=modes,
            method=method,
            band_hz=band,
        )
    except InputError as error:
        with in_options():
            raise click.UsageError(f"{error}.") from None


def packed(make: Callable[..., object], options: Sequence[Callable[[Any], Any]], argument: str) -> Decorator:
    """Return a decorator that gives a command options, and what a function makes of them as one argument."""
    names = [name for name, p in inspect.signature(make).parameters.items() if p.default is p.empty]

    def give(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def unpacked(**values: Any) -> Any:
            made = make(**{name: values.pop(name) for name in names})
            return command(**{argument: made}, **values)

        whole: Callable[..., Any] = unpacked
        for option in reversed(options):
            whole = option(whole)
        return whole

    return give


# A command with all options of an analysis, or with those of reading a whole record, as its argument ``settings``.
analysing: Decorator = packed(settings_of, (*READING, *STRETCH, *SETTINGS), "settings")
reading: Decorator = packed(
    partial(settings_of, which="whole", modes=None, method=METHOD, band=None), (*READING, *STRETCH[:2]), "settings"
)


@contextmanager
def progress(*steps: str) -> Iterator[Callable[[str], None]]:
    """Give a function to call as each step begins; long work shows a bar, on a terminal only."""
    from tqdm import tqdm

    # Work that takes longer than a second shows a bar, on a terminal only.
    with tqdm(total=len(steps), disable=None, delay=1.0, leave=False, bar_format="{l_bar}{bar}| {elapsed}") as bar:

        def step(name: str) -> None:
            bar.set_description(name, refresh=False)
            bar.update()

        yield step


def road_named(text: str | None) -> str | float | None:
    """Return a class of roads as it is, and a number as G_d [m3]."""
    try:
        return float(text) if text is not None else None
    except ValueError:
        return text
