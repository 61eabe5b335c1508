"""ASAM MDF files of versions 2 to 4: channels on the clocks of their groups, and CAN frames decoded."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered, unique_names
from suspid.io.mdf.blocks import check_blocks
from suspid.io.mdf.channels import FRAMES, Place, check_records, frame_groups, frame_ids, listed_ids, opened, places_of
from suspid.io.tables import Table, TimeBase
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import LeftOut, Remark


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Decoded:
    """The signals of CAN frames: samples and which are invalid by place, stamps by group, ids not known."""

    places: tuple[Place, ...] = ()
    samples: Mapping[Place, tuple[Any, Any]] = field(default_factory=dict)
    timepts: Mapping[int, RealArray] = field(default_factory=dict)
    unknown: tuple[tuple[int, int], ...] = ()


def read_mdf(path: Path, *, dbc: str | os.PathLike[str] | None = None) -> Table:
    """Return the table of an MDF file: a column for each channel of numbers, with the clock of its group.

    A name that two groups have becomes ``group/name``. Samples that the file marks as invalid are NaN.
    Raw CAN frames are decoded with a database, and left out without one. Formulas in the file are not
    evaluated, and attachments not opened.
    """
    content = read_bytes(path, error=RecordError)
    records = check_blocks(content)
    database = None if dbc is None else Path(dbc)
    if database is not None:
        _check_database(database)
    return sheltered(lambda: _table(content, records, path.suffix, database), extra="mdf", suffix=path.suffix)


def _check_database(dbc: Path) -> None:
    if dbc.suffix.lower() != ".dbc":
        raise RecordError(f"{printable(str(dbc))}: is not a CAN database: give a .dbc file")
    read_bytes(dbc, error=RecordError)


def _table(content: bytes, records: int, suffix: str, dbc: Path | None) -> Table:
    with opened(content) as file:
        check_records(file, records)
        places = places_of(file)
        frames = frame_groups(file)
        ids = frame_ids(file, frames)
        decoded = _decoded(file, dbc, ids) if dbc is not None and frames else _Decoded()
    names = unique_names([(place.group_name, place.name) for place in [*places, *decoded.places]])
    by_name = dict(zip(names, [*places, *decoded.places], strict=True))
    stored, signals = set(names[: len(places)]), dict(zip(names[len(places) :], decoded.places, strict=True))
    usable = {name: place for name, place in by_name.items() if not place.reason}
    unusable: dict[str, Remark] = {name: place.reason for name, place in by_name.items() if place.reason}
    if frames and dbc is None:
        unusable[FRAMES] = Remark(LeftOut.FRAMES, {"ids": listed_ids(ids)})
    elif decoded.unknown:
        unusable[FRAMES] = Remark(LeftOut.UNKNOWN_FRAMES, {"ids": listed_ids(decoded.unknown)})
    elif dbc is not None and not frames:
        unusable[printable(dbc.name)] = Remark(LeftOut.NO_FRAMES)
    if not usable:
        listed = ", ".join(f"{name!r} {why}" for name, why in unusable.items())
        raise RecordError(f"contains no channel of numbers: {listed or 'nothing at all'}")
    # The stamps of a group are read with its channels, since opening the file again for each group takes long.
    stamps: dict[int, RealArray] = {}

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        asked = {name: by_name[name] for name in wanted if name in stored}
        read = sheltered(lambda: _values(content, asked, stamps), extra="mdf", suffix=suffix)
        return [
            read[name] if name in stored else _marked(*decoded.samples[signals[name]], signals[name]) for name in wanted
        ]

    def stamps_of(group: int, name: str) -> RealArray:
        if group not in stamps:
            columns([name])
        return stamps[group]

    own: dict[tuple[bool, int], TimeBase] = {}
    clocks: dict[str, TimeBase] = {}
    for name, place in usable.items():
        if place.timed:
            late = partial(stamps_of, place.group, name)
            source = late if name in stored else partial(decoded.timepts.__getitem__, place.group)
            key = (name in stored, place.group)
            clocks[name] = own.setdefault(key, TimeBase(name=place.group_name, stamps=source))
    return Table(
        apart=False,
        sizes={name: place.size for name, place in usable.items()},
        columns=columns,
        unusable=unusable,
        units={name: place.unit for name, place in usable.items() if place.unit},
        clocks=clocks,
    )


def _values(content: bytes, asked: Mapping[str, Place], stamps: dict[int, RealArray]) -> dict[str, RealArray]:
    """Return the numbers of channels, and add the stamps of their groups to those that are known."""
    read: dict[str, RealArray] = {}
    if not asked:
        return read
    with opened(content) as file:
        for name, place in asked.items():
            # Otherwise asammdf leaves out invalid samples.
            samples, invalid = file.get(
                group=place.group, index=place.index, samples_only=True, ignore_invalidation_bits=True
            )
            read[name] = _marked(samples, invalid, place)
            if place.timed and place.group not in stamps:
                stamps[place.group] = frozen_real(file.get_master(place.group))
                if stamps[place.group].size != place.size:
                    raise RecordError(
                        f"is damaged: group {place.group_name!r} contains {stamps[place.group].size} stamps"
                    )
    return read


def _marked(samples: Any, invalid: Any, place: Place) -> RealArray:
    """Return samples with those that the file marks as invalid as NaN."""
    if samples.dtype.kind not in "iufb" or samples.shape != (place.size,):
        found = f"{samples.dtype} x {samples.shape}"
        raise RecordError(f"is damaged: channel {place.name!r} contains {found}, not {place.size} numbers")
    values = np.array(samples, np.float64)
    if invalid is not None:
        values[np.asarray(invalid, bool)] = np.nan
    return frozen_real(values)


def _decoded(file: Any, dbc: Path, ids: Sequence[tuple[int, int]]) -> _Decoded:
    """Return the signals that a database finds in CAN frames."""
    from asammdf.blocks.utils import load_can_database

    try:
        matrix = sheltered(lambda: load_can_database(dbc), extra="mdf", suffix=".dbc")
    except RecordError as error:
        raise RecordError(f"CAN database {printable(str(dbc))}: {error}") from None
    if matrix is None or not matrix.frames:
        raise RecordError(f"CAN database {printable(str(dbc))}: contains no message")
    out = file.extract_bus_logging({"CAN": [(matrix, 0)]})
    try:
        places = places_of(out)
        samples = {
            place: out.get(group=place.group, index=place.index, samples_only=True, ignore_invalidation_bits=True)
            for place in places
            if not place.reason
        }
        timepts = {group: frozen_real(out.get_master(group)) for group in {place.group for place in samples}}
    finally:
        out.close()
    if not samples:
        raise RecordError(f"contains no CAN frame that {printable(dbc.name)} knows; there are {listed_ids(ids)}")
    known = {frame.arbitration_id.id for frame in matrix.frames}
    # Frames of J1939 are known by a part of their id.
    parts = any(frame.is_j1939 for frame in matrix.frames)
    unknown = () if parts else tuple(pair for pair in ids if pair[1] not in known)
    return _Decoded(places=tuple(places), samples=samples, timepts=timepts, unknown=unknown)
