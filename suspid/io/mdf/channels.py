"""Channels of MDF files: their places and metadata, and which are numbers over time."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable
from suspid.io.mdf.blocks import ChannelFlag, GroupFlag
from suspid.words import LeftOut, Remark

FRAMES = "CAN_DataFrame"
# Bits of an extended CAN identifier; the bus stands above them.
ID_BITS = 29
# A frame of CAN XL has up to 2048 bytes.
VARIABLE, LONGEST_FRAME = 1, 2048
BY_TIME, SYNCHRONOUS = 1, ("", "time", "angle", "distance", "index")
# By generation of the format: types of data that are numbers, conversions to words, and by formulas.
NUMBERS: dict[bool, Sequence[int]] = {True: range(6), False: (0, 1, 2, 3, 9, 10, 11, 12, 13, 14, 15, 16)}
TO_WORDS: dict[bool, tuple[int, ...]] = {True: (7, 8, 9, 10, 11), False: (11, 12)}
BY_FORMULA = {True: 3, False: 10}


@dataclass(frozen=True, kw_only=True, slots=True)
class Place:
    """Place and metadata of a channel."""

    group: int
    index: int
    group_name: str
    name: str
    unit: str
    size: int
    timed: bool
    reason: Remark | None


@contextlib.contextmanager
def opened(content: bytes) -> Iterator[Any]:
    """Open a file with asammdf, and close it with its temporary files."""
    from asammdf import MDF

    # Attachments are not opened, and arrays not split into channels, whose number a damaged file may inflate.
    options: dict[str, Any] = {"process_bus_logging": False, "add_array_components": False}
    file = MDF(io.BytesIO(content), **options)
    try:
        yield file
    finally:
        file.close()


def _is_raw(group: Any) -> bool:
    """Whether a group holds the frames of a bus, not signals."""
    flags = getattr(group.channel_group, "flags", 0)
    return bool(flags & GroupFlag.PLAIN_BUS_EVENT or (flags & GroupFlag.BUS_EVENT and _named(group, FRAMES)))


def _named(group: Any, name: str) -> bool:
    return any(channel.name == name for channel in group.channels)


def _size(group: Any) -> int:
    return int(group.channel_group.cycles_nr)


def places_of(file: Any) -> list[Place]:
    """Return all channels that are neither time nor frames of a bus."""
    new, places = str(file.version) >= "4", []
    for k, group in enumerate(file.groups):
        if _is_raw(group):
            continue
        name = printable(getattr(group.channel_group, "acq_name", "") or "") or f"group {k + 1}"
        remote = getattr(group.channel_group, "flags", 0) & GroupFlag.REMOTE_MASTER
        leader = group.channel_group.cg_master_index if remote else k
        time = file.masters_db.get(leader)
        master = None if time is None else file.groups[leader].channels[time]
        for i, channel in enumerate(group.channels):
            if channel is not master:
                places.append(
                    Place(
                        group=k,
                        index=i,
                        group_name=name,
                        name=printable(channel.name) or f"channel {i}",
                        unit=printable((channel.unit or getattr(channel.conversion, "unit", "") or "").strip()),
                        size=_size(group),
                        timed=master is not None,
                        reason=_why_not(group, i, master, new),
                    )
                )
    return places


def _why_not(group: Any, index: int, master: Any, new: bool) -> Remark | None:
    """Return why a channel is not numbers over time, None if it is."""
    channel = group.channels[index]
    kind = _conversion(channel)
    sync = getattr(master, "sync_type", BY_TIME)
    if not _size(group):
        return Remark(LeftOut.EMPTY)
    if sync != BY_TIME:
        axis = SYNCHRONOUS[sync] if sync < len(SYNCHRONOUS) else f"axis {sync}"
        return Remark(LeftOut.NOT_OVER_TIME, {"axis": axis})
    if new and channel.flags & ChannelFlag.ALL_INVALID:
        return Remark(LeftOut.INVALID)
    if group.channel_dependencies[index]:
        return Remark(LeftOut.STRUCTURE)
    if channel.data_type not in NUMBERS[new] or (new and channel.channel_type in (1, 5, 7)):
        return Remark(LeftOut.TEXT_OR_BYTES)
    if kind in TO_WORDS[new]:
        return Remark(LeftOut.ENUMERATION)
    if BY_FORMULA[new] in (kind, _conversion(master)):
        return Remark(LeftOut.FORMULA)
    return None


def check_records(file: Any, stated: int) -> None:
    """Refuse a file with fewer records than its groups state."""
    found = sum(
        _size(group)
        for group in file.groups
        if not getattr(group.channel_group, "flags", 0) & GroupFlag.VARIABLE_LENGTH
    )
    if found < stated:
        raise RecordError(f"is damaged: {found} of {stated} records were found")


def frame_groups(file: Any) -> list[int]:
    """Return the groups that hold CAN frames."""
    return [k for k, group in enumerate(file.groups) if _is_raw(group) and _named(group, FRAMES) and _size(group)]


def frame_ids(file: Any, frames: Sequence[int]) -> list[tuple[int, int]]:
    """Return bus and id of all CAN frames, each pair once."""
    found: set[tuple[int, int]] = set()
    for k in frames:
        channels = file.groups[k].channels
        if any(
            _conversion(channel) == BY_FORMULA[True] or channel.flags & ChannelFlag.ALL_INVALID for channel in channels
        ):
            raise RecordError(
                "has CAN frames that are marked as invalid or scaled by a formula, which is not evaluated"
            )
        _check_payloads(file, k)
        buses, ids = (
            np.asarray(file.get(f"{FRAMES}.{name}", group=k, samples_only=True)[0]).astype(np.int64)
            for name in ("BusChannel", "ID")
        )
        pairs = np.unique((buses << ID_BITS) | (ids & ((1 << ID_BITS) - 1)))
        found |= {(int(pair) >> ID_BITS, int(pair) & ((1 << ID_BITS) - 1)) for pair in pairs}
    return sorted(found)


def _check_payloads(file: Any, group: int) -> None:
    """Refuse frames with wrong offsets of their bytes: asammdf would read outside its memory."""
    for i, channel in enumerate(file.groups[group].channels):
        if channel.channel_type == VARIABLE:
            channel.channel_type = 0
            places = file.get(group=group, index=i, raw=True, samples_only=True, ignore_invalidation_bits=True)[0]
            channel.channel_type = VARIABLE
            places = np.frombuffer(places.tobytes(), "<u8")
            payloads = np.frombuffer(_payloads(file, group, i), np.uint8)
            if places.size != _size(file.groups[group]) or np.any(places[1:] < places[:-1]):
                raise RecordError("is damaged: its CAN frames are out of order")
            if places.size and int(places[-1]) + 4 > payloads.size:
                raise RecordError("is damaged: the bytes of its CAN frames lie beyond their end")
            sizes = sum(payloads[places + np.uint64(k)].astype(np.int64) << (8 * k) for k in range(4))
            if np.any(sizes > LONGEST_FRAME):
                raise RecordError(f"is damaged: a CAN frame has {np.max(sizes)} bytes; there may be {LONGEST_FRAME}")


def _payloads(file: Any, group: int, index: int) -> bytes:
    """Return the bytes to which the numbers of a channel of variable length point.

    asammdf has no public access to them without following the numbers, which is what must be checked first. This is
    the only use of a private part of it.
    """
    load = getattr(getattr(file, "_mdf", None), "_load_signal_data", None)
    if load is None:
        raise RecordError(
            "contains CAN frames of variable length, and this release of asammdf has no way to check them "
            "(MDF4._load_signal_data is missing); install asammdf 8.8"
        )
    content: bytes = load(group=file.groups[group], index=index)
    return content


def _conversion(channel: Any) -> int | None:
    return getattr(getattr(channel, "conversion", None), "conversion_type", None)


def listed_ids(ids: Sequence[tuple[int, int]]) -> str:
    """Return ids by bus, as text."""
    buses = dict.fromkeys(bus for bus, _ in ids)
    return "; ".join(f"bus {bus}: {', '.join(f'0x{i:X}' for b, i in ids if b == bus)}" for bus in buses)
