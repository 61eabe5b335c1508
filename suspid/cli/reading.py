"""How the commands read a record: which file, channels and clock, what is cleaned, and which stretch is the decay."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click
import numpy as np

from suspid.cli.support import Positive
from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.identification import late_start
from suspid.io import bare_name
from suspid.signals import as_response, as_signal, cut
from suspid.values import nearest_names

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned
    from suspid.decays import Decay, Decays
    from suspid.recordings import Recording

FILE = click.Path(path_type=Path)
# Work that takes longer [s] shows how far it is, on a terminal.
PATIENCE = 1.0
# So many things that a file holds and that are no channels are said; the rest is counted.
MOST_LEFT_OUT = 3
# So many stretches that are no decay are explained.
MOST_REMARKS = 2

Command = TypeVar("Command", bound=Callable[..., Any])


class Which(click.ParamType[str]):
    """Which decay: "auto", "whole", "all", or its rank."""

    name = "auto|whole|all|N"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the choice, or refuse it as a usage error."""
        text = str(value)
        if text not in ("auto", "whole", "all") and not (text.isdecimal() and int(text) > 0):
            self.fail(f"{text!r} is neither auto, whole, all nor a rank from 1 on.", param, ctx)
        return text


READING = (
    click.option("--channel", "channels", metavar="NAME", multiple=True, help="Channel to use; repeat. [all]"),
    click.option("--without", "without", metavar="NAME", multiple=True, help="Channel to leave out; repeat."),
    click.option(
        "--rename", "renames", metavar="OLD=NEW", multiple=True, help="Call a channel by another name; repeat."
    ),
    click.option(
        "--scale", "scales", metavar="NAME=FACTOR", multiple=True, help="Multiply a channel, as -9.81; repeat."
    ),
    click.option("--vertical", metavar="X,Y,Z", help="Add the vertical of a tilted accelerometer, and drop its axes."),
    click.option("--si", is_flag=True, help="Convert channels to SI by the units that the file states."),
    click.option("--time", "time", metavar="NAME", help="Column of time, if it is not named like one."),
    click.option(
        "--fs",
        type=Positive("Hz"),
        metavar="HZ",
        help="Sampling rate; it must agree with the time in the file, if any.",
    ),
    click.option("--dbc", type=FILE, metavar="FILE", help="Database that decodes the CAN frames of an MDF file."),
)
STRETCH = (
    click.option("--from", "start", type=float, metavar="SECONDS", help="Time at which the decay begins."),
    click.option("--to", "stop", type=float, metavar="SECONDS", help="Last time to use."),
    click.option(
        "--decay",
        "which",
        type=Which(),
        default="auto",
        show_default=True,
        help="Which of the free decays found in a long recording: the best where the record does not begin with its "
        "largest motion (auto), none: the whole record (whole), that of rank N, or all of them jointly (all).",
    ),
)


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadOptions:
    """What the user says of the file; names as on the command line."""

    channels: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    renames: tuple[str, ...] = ()
    scales: tuple[str, ...] = ()
    vertical: str | None = None
    si: bool = False
    time: str | None = None
    fs: float | None = None
    dbc: Path | None = None


def reading(*options: Callable[[Any], Any]) -> Callable[[Command], Command]:
    """Return a decorator that gives a command `READING`, packed as its argument ``read``, and further options."""
    packed = [field.name for field in fields(ReadOptions)]

    def give(command: Command) -> Command:
        @wraps(command)
        def unpacked(**values: Any) -> Any:
            read = ReadOptions(**{name: values.pop(name) for name in packed})
            return command(read=read, **values)

        made: Any = unpacked
        for option in reversed((*READING, *options)):
            made = option(made)
        return cast("Command", made)

    return give


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Stretch:
    """The part of a record that is taken for a decay, among those that were found."""

    record: control.TimeResponseData
    decays: Decays | tuple[Decay, ...]
    used: tuple[Decay, ...]
    said: tuple[str, ...]


@contextmanager
def progress(*steps: str) -> Iterator[Callable[[], None]]:
    """Give a function that says that the next step begins; long work shows a bar, on a terminal alone."""
    from tqdm import tqdm

    with tqdm(total=len(steps), disable=None, delay=PATIENCE, leave=False, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        waiting = iter(steps)

        def step() -> None:
            bar.set_description(next(waiting, ""), refresh=False)
            bar.update()

        yield step


def read_cleaned(
    file: Path, options: ReadOptions, *, start: float | None = None, stop: float | None = None
) -> tuple[Cleaned, list[str]]:
    """Return the record of a file as the user wants it, and all that was left out, repaired or met, in sentences.

    What lies before the start or after the stop [s] is not looked at.
    """
    from suspid.cleaning import clean
    from suspid.io import read_recording

    recording = read_recording(
        file, channels=options.channels or None, time=options.time, fs=options.fs, dbc=options.dbc
    )
    said = [f"in the file: {name!r} {why}" for name, why in recording.left_out[:MOST_LEFT_OUT]]
    if len(recording.left_out) > MOST_LEFT_OUT:
        more = len(recording.left_out) - MOST_LEFT_OUT
        said.append(f"in the file: {more} more things that are no channels, which `suspid channels` lists")
    recording = _without(recording, options.without)
    try:
        cleaned = clean(recording, channels=options.channels or None, fs=options.fs, start=start, stop=stop)
    except RecordError as error:
        raise RecordError(f"{printable(str(file))}: {error}") from None
    said += [str(finding) for finding in cleaned.findings]
    return _as_wanted(cleaned, options, said), said


def _without(recording: Recording, names: Sequence[str]) -> Recording:
    dropped = {channel_named(name, recording.names) for name in names}
    return replace(recording, channels=tuple(c for c in recording.channels if c.name not in dropped))


def _as_wanted(cleaned: Cleaned, options: ReadOptions, said: list[str]) -> Cleaned:
    """Return the record scaled, in SI, with its vertical, and renamed, in this order."""
    from suspid.cleaning import scaled, vertical

    if options.scales:
        factors = _by_channel(pairs(options.scales, "--scale", float), cleaned)
        cleaned = replace(cleaned, record=scaled(cleaned.record, factors))
    if options.si:
        cleaned = _in_si(cleaned, said)
    if options.vertical is not None:
        known = as_signal(cleaned.record).channels
        axes = tuple(channel_named(name.strip(), known) for name in options.vertical.split(","))
        up, found = vertical(cleaned.record, axes)
        said += str(found).split("\n")
        signal = as_signal(cleaned.record)
        kept = [k for k, name in enumerate(signal.channels) if name not in axes]
        cleaned = replace(
            cleaned,
            record=as_response(
                signal.timepts,
                np.concatenate([as_signal(up).values, signal.values[kept]]),
                [*as_signal(up).channels, *(signal.channels[k] for k in kept)],
                title=str(cleaned.record.title or ""),
            ),
            units=(cleaned.units[signal.channels.index(axes[0])], *(cleaned.units[k] for k in kept)),
        )
    renames = _by_channel(pairs(options.renames, "--rename", str), cleaned)
    if renames:
        signal = as_signal(cleaned.record)
        names = [renames.get(name, name) for name in signal.channels]
        if len(set(names)) < len(names):
            raise InputError(f"--rename leaves two channels of one name: {', '.join(map(repr, names))}")
        record = as_response(signal.timepts, signal.values, names, title=str(cleaned.record.title or ""))
        cleaned = replace(cleaned, record=record)
    return cleaned


def _in_si(cleaned: Cleaned, said: list[str]) -> Cleaned:
    """Return the record with every channel whose unit is known in SI."""
    from suspid.cleaning import scaled, to_si

    factors, units = dict[str, float](), list[str]()
    for name, unit in zip(as_signal(cleaned.record).channels, cleaned.units, strict=True):
        try:
            factor, si = to_si(1.0, unit)
        except InputError as error:
            said.append(f"channel {name!r} is left as it is: {error if unit else 'the file states no unit'}")
            units.append(unit)
            continue
        units.append(si)
        if float(factor) != 1.0:
            factors[name] = float(factor)
            said.append(f"channel {name!r} was converted from {unit} to {si}: times {float(factor):.6g}")
    return replace(cleaned, record=scaled(cleaned.record, factors), units=tuple(units))


def channel_named(name: str, channels: Sequence[str]) -> str:
    """Return the channel of that name, or the one of that name without its unit; refuse with the nearest ones."""
    if name in channels:
        return name
    short = [channel for channel in channels if bare_name(channel) == name]
    if len(short) != 1:
        raise RecordError(f"there is no channel {name!r}.{nearest_names(name, [*channels, *map(bare_name, channels)])}")
    return short[0]


Value = TypeVar("Value", str, float)


def pairs(given: Sequence[str], option: str, kind: Callable[[str], Value]) -> dict[str, Value]:
    """Return the values by name, from texts as ``NAME=VALUE``, each name once."""
    found: dict[str, Value] = {}
    for text in given:
        name, equals, value = text.rpartition("=")
        try:
            made = kind(value)
        except ValueError:
            equals = ""
        if not equals or not name or not value or name in found:
            raise click.BadParameter(f"{text!r}: write NAME=VALUE, each name once.", param_hint=f"'{option}'")
        found[name] = made
    return found


def _by_channel(values: Mapping[str, Value], cleaned: Cleaned) -> dict[str, Value]:
    """Return values by the full names of the channels."""
    channels = as_signal(cleaned.record).channels
    return {channel_named(name, channels): value for name, value in values.items()}


def stretch_of(record: control.TimeResponseData, start: float | None, stop: float | None, which: str) -> Stretch:
    """Return the part of a record that is taken for a decay."""
    from suspid.decays import find_decays

    if start is not None or stop is not None:
        if which not in ("auto", "whole"):
            raise click.UsageError("Give either --decay or --from and --to.")
        return Stretch(record=cut(record, start=start, stop=stop), decays=(), used=(), said=())
    if which == "whole" or (which == "auto" and late_start(as_signal(record)) is None):
        return Stretch(record=record, decays=(), used=(), said=())
    decays = find_decays(record)
    remarks = " ".join(map(str, decays.remarks[:MOST_REMARKS]))
    if len(decays.remarks) > MOST_REMARKS:
        remarks += f" … and {len(decays.remarks) - MOST_REMARKS} more such."
    if not decays and which != "auto":
        raise RecordError(f"no free decay was found. {remarks}")
    if which == "auto" and (not decays or decays[0].doubts):
        why = "no free decay was found" if not decays else f"no decay is beyond doubt (the best: {decays[0]})"
        said = f"{why}, so the whole record is used. {remarks}".rstrip()
        return Stretch(record=record, decays=decays, used=(), said=(said,))
    if which == "all":
        sure = tuple(decay for decay in decays if not decay.doubts) or tuple(decays)
        said = f"{len(sure)} decays are used, from {', '.join(f'{decay.start:.6g}' for decay in sure)} s"
        part = cut(record, start=sure[0].start, stop=sure[0].stop)
        doubtful = len(decays) - len(sure)
        more = (f"{doubtful} more carry doubts and are left out",) if doubtful else ()
        return Stretch(record=part, decays=decays, used=sure, said=(said, *more))
    rank = 1 if which == "auto" else int(which)
    if rank > len(decays):
        raise RecordError(f"there is no decay of rank {rank}; found: {'; '.join(map(str, decays))}")
    best = decays[rank - 1]
    others = f"; {len(decays) - 1} more: see --decay" if len(decays) > 1 else ""
    said = f"the decay from {best.start:.6g} to {best.stop:.6g} s is used{others}"
    doubts = tuple(f"this decay: {doubt}" for doubt in best.doubts)
    part, still = _moving(cut(record, start=best.start, stop=best.stop))
    return Stretch(record=part, decays=decays, used=(best,), said=(said, *doubts, *still))


def _moving(record: control.TimeResponseData) -> tuple[control.TimeResponseData, list[str]]:
    """Return the record without channels that stand still in it, and what was left out."""
    signal = as_signal(record)
    moving = np.ptp(signal.values, axis=1) > 0
    if moving.all() or not moving.any():
        return record, []
    kept = [name for name, moves in zip(signal.channels, moving, strict=True) if moves]
    said = [f"channel {n!r} is constant in this decay; left out" for n in signal.channels if n not in kept]
    return as_response(signal.timepts, signal.values[moving], kept, title=str(record.title or "")), said
