"""Recordings of drives, with the channels, names and units that are asked for."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from suspid.analysis.drive_vertical import upright
from suspid.analysis.reading import channel_named
from suspid.analysis.settings import Settings
from suspid.cleaning import RecordLike, to_si, unmarked
from suspid.errors import InputError, RecordError
from suspid.greybox import own_unit, recording_of
from suspid.io import bare_name, read_recording
from suspid.recordings import RawChannel, Recording
from suspid.units import ROAD_SPEEDS
from suspid.wording import Argument
from suspid.words import Check, Level


def read_drive(
    source: str | os.PathLike[str] | Recording | RecordLike, settings: Settings
) -> tuple[Recording, tuple[Check, ...]]:
    """Return a recording with channels in SI units where the file states a unit, renamed and scaled, and notes on it.

    Names lose the units in brackets behind them where that leaves them different.

    Raises
    ------
    RecordError
        If the source cannot be read, or a channel is not there.
    InputError
        If renaming leaves two channels of the same name.
    """
    if not isinstance(source, str | os.PathLike):
        return _wanted(recording_of(source), settings)
    recording = read_recording(source, time=settings.time, fs=settings.fs, dbc=settings.dbc)
    return _wanted(recording, settings)


def _wanted(recording: Recording, settings: Settings) -> tuple[Recording, tuple[Check, ...]]:
    if settings.test is not None:
        recording = recording.of_test(settings.test)
    elif len(recording.tests) > 1:
        raise RecordError(f"contains {len(recording.tests)} tests; choose one: {', '.join(recording.tests)}")
    scale = {channel_named(name, recording.names): factor for name, factor in dict(settings.scale).items()}
    notes: tuple[Check, ...] = ()
    if settings.vertical is not None:
        recording, notes = _with_vertical(recording, settings.vertical, scale)
    names = recording.names
    for name in settings.channels or ():
        channel_named(name, names)
    dropped = {channel_named(name, names) for name in settings.without}
    rename = {channel_named(name, names): new for name, new in dict(settings.rename).items()}
    short = [bare_name(name) for name in names]
    called = {name: own if short.count(own) == 1 else name for name, own in zip(names, short, strict=True)} | rename
    channels = [_made(recording[name], called, scale) for name in names if name not in dropped]
    if len({channel.name for channel in channels}) < len(channels):
        raise InputError("renaming leaves two channels of the same name; choose a new name")
    if settings.start is not None or settings.stop is not None:
        channels = _between(channels, settings)
    return replace(recording, channels=tuple(channels)), notes


def _with_vertical(
    recording: Recording, given: Iterable[str], scale: Mapping[str, float]
) -> tuple[Recording, tuple[Check, ...]]:
    """Return a recording with the vertical of a tilted accelerometer in place of its axes, and how it was found."""
    axes = [channel_named(name.strip(), recording.names) for name in given]
    up, found = upright([_made(recording[name], {name: name}, scale) for name in axes])
    kept = (up if channel.name == axes[0] else channel for channel in recording.channels)
    notes = (Check(remark, Level.NOTE) for remark in found.remarks)
    return replace(recording, channels=tuple(c for c in kept if c.name not in axes)), tuple(notes)


def _made(channel: RawChannel, called: Mapping[str, str], scale: Mapping[str, float]) -> RawChannel:
    """Return a channel in SI, if its unit is known, times its factor, with its name.

    A speed in a unit of the road keeps it: the unit tells that it is the speed of the car.
    """
    if channel.unit.strip().lower() in ROAD_SPEEDS and channel.name not in scale:
        return replace(channel, name=called[channel.name])
    try:
        factor, unit = to_si(1.0, own_unit(channel))
    except InputError:
        # A factor of its own makes SI of what is in a unit that is not known.
        factor, unit = np.asarray(1.0), "" if channel.name in scale else own_unit(channel)
    by = float(factor) * scale.get(channel.name, 1.0)
    values = channel.values if by == 1.0 else unmarked(channel) * by
    return replace(channel, name=called[channel.name], unit=unit, values=values)


def _between(channels: list[RawChannel], settings: Settings) -> list[RawChannel]:
    low = -np.inf if settings.start is None else settings.start
    high = np.inf if settings.stop is None else settings.stop
    # One array of stamps stays one array, so that the channels of a clock are known to be of one.
    inside = {id(c.timepts): (c.timepts >= low) & (c.timepts <= high) for c in channels}
    stamps = {id(c.timepts): c.timepts[inside[id(c.timepts)]] for c in channels}
    if not any(np.sum(there) > 1 for there in inside.values()):
        ends = [end for c in channels for end in (np.nanmin(c.timepts), np.nanmax(c.timepts)) if c.timepts.size]
        raise RecordError(
            f"there are no samples between {low:g} and {high:g} s ({Argument('start')}, {Argument('stop')}): the "
            f"recording runs from {min(ends):.6g} to {max(ends):.6g} s"
        )
    return [
        replace(c, timepts=stamps[id(c.timepts)], values=c.values[inside[id(c.timepts)]])
        for c in channels
        if np.sum(inside[id(c.timepts)]) > 1
    ]
