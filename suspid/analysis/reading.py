"""Read and clean a source, with the channels, scales and names that the settings ask for."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from suspid.analysis.settings import Settings
from suspid.cleaning import Cleaned, RecordLike, Vertical, as_record, clean, moves, name_in_si, scaled, to_si, vertical
from suspid.errors import InputError, RecordError
from suspid.files import naming
from suspid.io import bare_name, read_recording
from suspid.recordings import Recording
from suspid.records import like
from suspid.samples import held
from suspid.signals import as_signal
from suspid.values import listed, nearest_names
from suspid.wording import Argument
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control

Value = TypeVar("Value", str, float)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Read:
    """A source as read: the recording (None for a response), the cleaned record, and what was done to it."""

    recording: Recording | None
    cleaned: Cleaned
    notes: tuple[Remark, ...]


def read(source: str | os.PathLike[str] | Recording | RecordLike, settings: Settings) -> Read:
    """Return a source as a cleaned record; a response is on a uniform clock already."""
    if isinstance(source, str | os.PathLike):
        recording, name = _opened(source, settings), os.fspath(source)
    elif isinstance(source, Recording):
        recording, name = source, source.title
    else:
        source, settings = _sampled(source, settings)
        _refuse_clock(settings)
        cleaned, done = _as_wanted(_chosen(source, settings), settings)
        return Read(recording=None, cleaned=cleaned, notes=done)
    notes: tuple[Remark, ...] = ()
    with naming(name):
        if settings.test is not None:
            recording = recording.of_test(settings.test)
        elif settings.channels is None and len(recording.tests) > 1:
            used = _first_moving(recording)
            notes = (Remark(Note.ONE_OF_TESTS, {"tests": recording.tests, "used": used}),)
            recording = recording.of_test(used)
        kept = _kept(recording.names, settings)
        wanted = None if settings.channels is None else kept
        if wanted is None:
            recording = replace(recording, channels=tuple(c for c in recording.channels if c.name in kept))
        cleaned = clean(recording, channels=wanted, fs=settings.fs, start=settings.start, stop=settings.stop)
    cleaned, done = _as_wanted(cleaned, settings)
    return Read(recording=recording, cleaned=cleaned, notes=(*notes, *done))


def _first_moving(recording: Recording) -> str:
    """Return the first test in which a channel moves, as none does in that of a step that is held; else the first."""
    return next((channel.test for channel in recording.channels if channel.test and moves(channel)), recording.tests[0])


def tests_of(source: str | os.PathLike[str] | Recording, settings: Settings) -> list[Recording]:
    """Return the tests in a source, each a recording of its own with names that do not tell the test."""
    recording = source if isinstance(source, Recording) else _opened(source, settings)
    return [_plainly_named(recording.of_test(name)) for name in recording.tests] or [recording]


def _opened(source: str | os.PathLike[str], settings: Settings) -> Recording:
    return read_recording(source, channels=_asked(settings), time=settings.time, fs=settings.fs, dbc=settings.dbc)


def _plainly_named(recording: Recording) -> Recording:
    """Return the channels of one test with the part of their names that names it, in front or behind, left out."""
    title = recording.channels[0].test
    channels = (replace(channel, name=_without_title(channel.name, title), test="") for channel in recording.channels)
    return replace(recording, title=title, channels=tuple(channels))


def _without_title(name: str, title: str) -> str:
    """Return a name without that of its test behind it, or all up to that."""
    before = name.removesuffix(title).rstrip(".:/|_ ")
    if name.endswith(title) and before:
        return before
    return name.partition(title)[2].lstrip(".:/| ") if title in name else name


def channel_named(name: str, channels: Sequence[str]) -> str:
    """Return the channel of that name, or the only one that has it before its unit.

    Raises
    ------
    RecordError
        If there is none; the message lists the nearest names.

    Examples
    --------
    >>> channel_named("seat", ["time [s]", "seat [mm]"])
    'seat [mm]'
    """
    if name in channels:
        return name
    short = [channel for channel in channels if bare_name(channel) == name]
    if len(short) != 1:
        raise RecordError(f"there is no channel {name!r}.{nearest_names(name, [*channels, *map(bare_name, channels)])}")
    return short[0]


def _sampled(source: RecordLike, settings: Settings) -> tuple[control.TimeResponseData, Settings]:
    """Return samples as a response, and the settings that are left; those without a time have the rate given."""
    try:
        return as_record(source), settings
    except RecordError:
        if settings.fs is None:
            raise
    return as_record(source, fs=settings.fs), replace(settings, fs=None)


def _refuse_clock(settings: Settings) -> None:
    """Refuse settings that say how a file is read: a response has its time and its names already."""
    for name in ("fs", "time", "dbc", "test"):
        if getattr(settings, name) is not None:
            what = "no frames to decode" if name == "dbc" else "a clock already"
            given = Argument(name, repr(getattr(settings, name)))
            raise InputError(given, f": a response has {what}; leave ", Argument(name), " out")


def _asked(settings: Settings) -> tuple[str, ...] | None:
    """Return the channels that are asked for, with the axes that a vertical is made of; None for all."""
    if settings.channels is None:
        return None
    for before, name in dict(settings.rename).items():
        # A channel that is renamed is one of those that are chosen.
        if name in settings.channels and before not in settings.channels:
            raise RecordError(f"channels are chosen before they are renamed: choose {before!r} instead of {name!r}")
    return (*settings.channels, *(axis for axis in settings.vertical or () if axis not in settings.channels))


def _kept(channels: tuple[str, ...], settings: Settings) -> tuple[str, ...]:
    """Return the channels that the settings ask for, each once."""
    wanted = tuple(channel_named(name, channels) for name in (_asked(settings) or channels))
    for name in wanted:
        if wanted.count(name) > 1 and settings.channels is not None:
            raise RecordError(f"channel {name!r} is requested twice")
    dropped = {channel_named(name, channels) for name in settings.without}
    kept = tuple(name for name in wanted if name not in dropped)
    if wanted and not kept:
        raise RecordError(
            f"leaving {listed(settings.without)} out ({Argument('without')}) leaves no channel; keep at least one of "
            f"{listed(wanted)}"
        )
    return kept


def _chosen(response: control.TimeResponseData, settings: Settings) -> Cleaned:
    """Return the channels of a response that the settings ask for."""
    signal = as_signal(response)
    kept = _kept(signal.channels, settings)
    record = response
    if kept != signal.channels:
        rows = [signal.channels.index(name) for name in kept]
        record = like(response, signal.timepts, signal.values[rows], kept, title=_title(response))
    return Cleaned(record=record, units=("",) * len(kept), findings=())


def _as_wanted(cleaned: Cleaned, settings: Settings) -> tuple[Cleaned, tuple[Remark, ...]]:
    """Return the record scaled, in SI, with its vertical, and renamed, in this order."""
    notes: tuple[Remark, ...] = ()
    if settings.scale:
        cleaned = replace(cleaned, record=scaled(held(cleaned, "record"), _by_channel(dict(settings.scale), cleaned)))
    if settings.si:
        cleaned, notes = in_si(cleaned)
    if settings.vertical is not None:
        cleaned, found = _upright(cleaned, settings.vertical)
        notes = (*notes, *found.remarks)
    if settings.rename:
        # Tests of one car are renamed alike: what stood still in one of them was left out of it, and that was said.
        there = as_signal(held(cleaned, "record")).channels
        gone = {bare_name(finding.channel) for finding in cleaned.findings if finding.channel not in there}
        renames = {name: new for name, new in dict(settings.rename).items() if bare_name(name) not in gone}
        cleaned = _renamed(cleaned, _by_channel(renames, cleaned))
    return (_renamed(cleaned, _units_in_names(cleaned)) if settings.si else cleaned), notes


def _units_in_names(cleaned: Cleaned) -> dict[str, str]:
    """Return the channels that were converted but whose names still say the unit before, with their new names."""
    pairs = zip(as_signal(held(cleaned, "record")).channels, cleaned.units, strict=True)
    return {name: now for name, unit in pairs if (now := name_in_si(name, unit)) != name}


def in_si(cleaned: Cleaned) -> tuple[Cleaned, tuple[Remark, ...]]:
    """Return the record with every channel whose unit is known in SI."""
    factors, units, notes = dict[str, float](), list[str](), list[Remark]()
    for name, unit in zip(as_signal(held(cleaned, "record")).channels, cleaned.units, strict=True):
        try:
            factor, si = to_si(1.0, unit)
        except InputError as error:
            why = error.message if unit else f"the file states no unit; {Argument('scale')} multiplies it"
            notes.append(Remark(Note.NOT_CONVERTED, {"channel": name, "why": why}))
            units.append(unit)
            continue
        units.append(si)
        if float(factor) != 1.0:
            factors[name] = float(factor)
            notes.append(
                Remark(Note.CONVERTED, {"channel": name, "unit": unit, "si": si, "factor": float(factor)}),
            )
    return replace(cleaned, record=scaled(held(cleaned, "record"), factors), units=tuple(units)), tuple(notes)


def _upright(cleaned: Cleaned, given: Iterable[str]) -> tuple[Cleaned, Vertical]:
    """Return the record with the vertical of a tilted accelerometer in place of its axes, and how it was found."""
    signal = as_signal(held(cleaned, "record"))
    axes = tuple(channel_named(name.strip(), signal.channels) for name in given)
    up, found = vertical(held(cleaned, "record"), axes)
    kept = [k for k, name in enumerate(signal.channels) if name not in axes]
    record = like(
        held(cleaned, "record"),
        signal.timepts,
        np.concatenate([as_signal(up).values, signal.values[kept]]),
        [*as_signal(up).channels, *(signal.channels[k] for k in kept)],
        title=_title(held(cleaned, "record")),
    )
    units = (cleaned.units[signal.channels.index(axes[0])], *(cleaned.units[k] for k in kept))
    return replace(cleaned, record=record, units=units), found


def _renamed(cleaned: Cleaned, renames: dict[str, str]) -> Cleaned:
    signal = as_signal(held(cleaned, "record"))
    names = [renames.get(name, name) for name in signal.channels]
    if len(set(names)) < len(names):
        raise InputError(
            f"renaming leaves two channels of the same name: {', '.join(map(repr, names))}; "
            f"choose a new name, or leave one out ({Argument('without')})"
        )
    return replace(
        cleaned,
        record=like(
            held(cleaned, "record"), signal.timepts, signal.values, names, title=_title(held(cleaned, "record"))
        ),
    )


def _by_channel(values: Mapping[str, Value], cleaned: Cleaned) -> dict[str, Value]:
    """Return values by the full names of the channels."""
    channels = as_signal(held(cleaned, "record")).channels
    return {channel_named(name, channels): value for name, value in values.items()}


def _title(response: control.TimeResponseData) -> str:
    return str(getattr(response, "title", None) or "")
