"""TDMS files of LabVIEW: scaled channels by group, each with the clock of its waveform."""

from __future__ import annotations

import io
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered, unique_names
from suspid.io.names import PER_SECOND, is_time, split_unit
from suspid.io.tables import Table, TimeBase
from suspid.units import RealArray, Second
from suspid.values import frozen_real
from suspid.words import LeftOut, Remark

# Bytes at the start of a segment, and the length of one whose writer was stopped.
LEAD_IN = 28
CRASHED = 0xFFFFFFFFFFFFFFFF
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription", "unit", "Unit")


@dataclass(frozen=True, kw_only=True, slots=True)
class _Entry:
    """Metadata of one channel; its start is given in whole seconds and units of 2^-64 s."""

    group: str
    channel: str
    size: int
    reason: Remark | None
    unit: str
    offset: Second
    step: Second | None
    began: tuple[int, int] | None
    is_stamp: bool


def read_tdms(path: Path) -> Table:
    """Return the table of a TDMS file: each channel of numbers, scaled as the file says.

    A name that two groups have becomes ``group/name``. The clock of a channel is that of its waveform
    (``wf_increment``, ``wf_start_offset``, and ``wf_start_time`` since the earliest there is), else the
    channel of its group that holds dates or is named like a time.
    """
    content = read_bytes(path, error=RecordError)
    _check_segments(content)

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        asked = {places[name]: by_name[name] for name in wanted}
        return sheltered(lambda: _values(content, asked), extra="tdms", suffix=path.suffix)

    entries = sheltered(lambda: _entries(content), extra="tdms", suffix=path.suffix)
    names = unique_names([(entry.group, entry.channel) for entry in entries])
    by_name = dict(zip(names, entries, strict=True))
    places = {name: k for k, name in enumerate(names)}
    unusable = {name: entry.reason for name, entry in by_name.items() if entry.reason}
    usable = {name: entry for name, entry in by_name.items() if not entry.reason}
    if not usable:
        listed = ", ".join(f"{name!r} {why}" for name, why in unusable.items())
        raise RecordError(f"contains no channel of numbers: {listed or 'nothing at all'}")
    earliest = min((entry.began for entry in usable.values() if entry.began and entry.step), default=(0, 0))
    clocks: dict[str, TimeBase] = {}
    shared: dict[tuple[object, ...], TimeBase] = {}
    for name, entry in usable.items():
        if entry.step is not None:
            whole, part = np.subtract(entry.began or earliest, earliest, dtype=object)
            clock = TimeBase(name=entry.group, start=entry.offset + float(whole + part / 2**64), rate=1 / entry.step)
            clocks[name] = shared.setdefault((clock.start, entry.step, entry.size), clock)
        elif (time := _time_of(name, usable)) is not None:
            clock = TimeBase(name=time, stamps=partial(_stamps, columns, time, _per_second(usable[time])))
            clocks[name] = shared.setdefault((time,), clock)
    return Table(
        sizes={name: entry.size for name, entry in usable.items()},
        columns=columns,
        unusable=unusable,
        units={name: entry.unit for name, entry in usable.items() if entry.unit},
        clocks=clocks,
    )


def _stamps(columns: Callable[[Sequence[str]], list[RealArray]], time: str, per_second: float) -> RealArray:
    return columns([time])[0] / per_second


def _check_segments(content: bytes) -> None:
    """Refuse a file whose segments do not end where it ends, before their sizes are used."""
    if content[:4] != b"TDSm":
        raise RecordError("is the index of a TDMS file, not the file" if content[:4] == b"TDSh" else "is not TDMS")
    position = 0
    while position < len(content):
        if position + LEAD_IN > len(content):
            raise RecordError("is cut off: it ends in the head of a segment")
        # The bit for big-endian numbers.
        order = ">" if struct.unpack_from("<I", content, position + 4)[0] & (1 << 6) else "<"
        size, before_data = struct.unpack_from(f"{order}QQ", content, position + 12)
        if content[position : position + 4] != b"TDSm" or (size != CRASHED and before_data > size):
            raise RecordError(f"is damaged: no segment begins at byte {position}")
        position += LEAD_IN + size
        if size == CRASHED or position > len(content):
            raise RecordError("is cut off: its last segment is not complete; the file was not closed by its writer")


def _entries(content: bytes) -> list[_Entry]:
    from nptdms import TdmsFile

    with TdmsFile.open(io.BytesIO(content), raw_timestamps=True) as file:
        status = file.file_status
        wrong = [p for p, s in (status.channel_statuses or {}).items() if s.expected_length != s.read_length]
        if status.incomplete_final_segment or wrong:
            raise RecordError("is damaged: a segment does not contain the stated number of samples")
        for holder in (file, *file.groups(), *(channel for group in file.groups() for channel in group.channels())):
            _check_scales(holder.properties)
        return [_entry(channel, len(content)) for group in file.groups() for channel in group.channels()]


def _check_scales(properties: Mapping[str, Any]) -> None:
    """Refuse more scales or coefficients than there are properties: npTDMS loops over them."""
    for key, value in properties.items():
        counts = key == "NI_Number_Of_Scales" or (key.startswith("NI_Scale[") and key.endswith("_Size"))
        if counts and not (_is_number(value) and value <= len(properties)):
            raise RecordError(f"is damaged: it states {key} = {printable(str(value))}")


def _entry(channel: Any, most: int) -> _Entry:
    size, properties = len(channel), channel.properties
    kind, is_stamp = channel.dtype, channel.data_type is not None and channel.data_type.__name__ == "TimeStamp"
    # A number takes at least a byte.
    if size < 0 or size > most:
        raise RecordError(f"is damaged: channel {printable(channel.name)!r} states {size} samples in {most} bytes")
    reason: Remark | None
    if not size:
        reason = Remark(LeftOut.EMPTY)
    elif kind.kind == "c":
        reason = Remark(LeftOut.COMPLEX)
    elif kind.kind in "iufb" or is_stamp:
        reason = None
    else:
        reason = Remark(LeftOut.TEXT) if kind.kind == "O" else Remark(LeftOut.TYPE, {"type": str(kind)})
    step, offset = properties.get("wf_increment"), properties.get("wf_start_offset", 0.0)
    began = properties.get("wf_start_time")
    per = PER_SECOND.get(str(properties.get("wf_xunit_string", "")).strip().lower(), 1.0)
    return _Entry(
        group=printable(channel.group_name),
        channel=printable(channel.name),
        size=size,
        reason=reason,
        unit=next((printable(str(properties[key]).strip()) for key in UNIT_PROPERTIES if key in properties), ""),
        offset=offset / per if _is_number(offset) else 0.0,
        step=step / per if _is_number(step) and step > 0 else None,
        began=(int(began.seconds), int(began.second_fractions)) if hasattr(began, "second_fractions") else None,
        is_stamp=is_stamp,
    )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and math.isfinite(value)


def _time_of(name: str, usable: dict[str, _Entry]) -> str | None:
    """Return the channel of time of another: of its group and length, with dates or named like a time."""
    entry = usable[name]
    if entry.is_stamp or is_time(entry.channel):
        return None
    fellows = {n: e for n, e in usable.items() if e.group == entry.group and e.size == entry.size and n != name}
    dates = [n for n, e in fellows.items() if e.is_stamp]
    called = [n for n, e in fellows.items() if is_time(e.channel) and _per_second(e) > 0]
    return called[0] if len(called) == 1 else dates[0] if len(dates) == 1 and not called else None


def _per_second(entry: _Entry) -> float:
    """Return how many units of a channel of time make a second; 0 if the unit is not known."""
    return 1.0 if entry.is_stamp else PER_SECOND.get(entry.unit.lower() or split_unit(entry.channel)[1] or "s", 0.0)


def _values(content: bytes, wanted: Mapping[int, _Entry]) -> list[RealArray]:
    """Return the numbers of the channels at the given places of the file."""
    from nptdms import TdmsFile

    columns = []
    with TdmsFile.open(io.BytesIO(content), raw_timestamps=True) as file:
        channels = [channel for group in file.groups() for channel in group.channels()]
        for place, entry in wanted.items():
            data = channels[place].read_data()
            if len(data) != entry.size:
                raise RecordError(f"is damaged: channel {entry.channel!r} contains {len(data)} of {entry.size} samples")
            columns.append(frozen_real(_since_first(data) if entry.is_stamp else data))
    return columns


def _since_first(stamps: Any) -> RealArray:
    """Return the seconds since the first stamp."""
    whole, parts = np.asarray(stamps.seconds, np.int64), np.asarray(stamps.second_fractions, np.float64)
    return np.asarray((whole - whole[0]) + (parts - parts[0]) / 2.0**64, np.float64)
