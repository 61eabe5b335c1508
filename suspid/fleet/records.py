"""The records of a fleet, in chunks; and the list of files that a run is about."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from suspid.units import RealArray
from suspid.words import Remark

LIST = "records.jsonl"
# A chunk ends before it has more bytes of files, or of samples, than these. Larger limits cost memory of the
# workers, and with long records make chunks of many minutes.
MOST_BYTES = 64_000_000
MOST_SAMPLE_BYTES = 8_000_000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Samples:
    """A response as arrays, which can be pickled."""

    timepts: RealArray
    values: RealArray
    channels: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Entry:
    """One record of a fleet.

    Parameters
    ----------
    name : str
        Name of the record in the results.
    path : str or None
        A path, or an address that fsspec knows; None if the samples travel.
    size : int or None
        Bytes of the file when it was listed.
    samples : Samples or None
        The response itself.
    refusal : Remark or None
        Why what was given can be no record.
    """

    name: str
    path: str | None = None
    size: int | None = None
    samples: Samples | None = None
    refusal: Remark | None = None


def samples_hash(samples: Samples) -> str:
    """Return the sha256 of a response: its channels, times and samples."""
    content = hashlib.sha256("\n".join(samples.channels).encode("utf-8", "surrogatepass"))
    for array in (samples.timepts, samples.values):
        content.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return content.hexdigest()


def write_list(path: Path, entries: Iterable[Entry]) -> int:
    """Write the list of files that a run is about, complete or absent; return how many they are."""
    draft, count = path.with_name(f".{path.name}.draft"), 0
    with draft.open("w", encoding="ascii") as stream:
        for entry in entries:
            stream.write(json.dumps([entry.path, entry.name, entry.size]) + "\n")
            count += 1
        stream.flush()
        os.fsync(stream.fileno())
    draft.replace(path)
    return count


def read_list(path: Path) -> Iterator[Entry]:
    """Yield the files of a list that `write_list` wrote."""
    with path.open(encoding="ascii") as stream:
        for line in stream:
            address, name, size = json.loads(line)
            yield Entry(name=name, path=address, size=size)


def in_chunks(entries: Iterable[Entry], most: int) -> Iterator[tuple[Entry, ...]]:
    """Yield the entries in chunks of at most ``most``; which ones go together depends on the entries alone."""
    chunk: list[Entry] = []
    size = 0.0
    for entry in entries:
        if entry.samples is not None:
            share = entry.samples.values.nbytes / MOST_SAMPLE_BYTES
        else:
            share = (entry.size or 0) / MOST_BYTES
        if chunk and (len(chunk) == most or size + share > 1):
            yield tuple(chunk)
            chunk, size = [], 0.0
        chunk.append(entry)
        size += share
    if chunk:
        yield tuple(chunk)
