"""The records of a fleet: the list of files, its chunks, and one record with its size and hash."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.files import printable
from suspid.samples import as_samples
from suspid.units import RealArray
from suspid.words import Failure, Remark, Step

if TYPE_CHECKING:
    import control

LIST = "records.jsonl"
# A chunk ends before it has more bytes of files, or of samples, than these. Larger limits cost memory of the
# workers, and with long records make chunks of many minutes.
MOST_FILE_BYTES = 64_000_000
MOST_SAMPLE_BYTES = 8_000_000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Samples:
    """A response as arrays, which can be pickled."""

    timepts: RealArray
    values: RealArray
    channels: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Entry:
    """One record of a fleet."""

    name: str
    # A path, or an address that fsspec knows; None if the samples travel.
    path: str | None = None
    # Bytes of the file when it was listed.
    size: int | None = None
    # When the file was last changed, or its tag in an object store, when it was listed.
    modified: str | None = None
    samples: Samples | None = None
    # Of a drive.
    vehicle: str | None = None
    when: float | None = None
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
    try:
        with draft.open("w", encoding="ascii") as stream:
            for entry in entries:
                stream.write(json.dumps([entry.path, entry.name, entry.size, entry.modified]) + "\n")
                count += 1
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(path)
    except OSError as refusal:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise InputError(f"{printable(str(path))}: cannot be written: {refusal.strerror or refusal}") from None
    return count


def read_list(path: Path) -> Iterator[Entry]:
    """Yield the files of a list that `write_list` wrote."""
    try:
        with path.open(encoding="ascii") as stream:
            for number, line in enumerate(stream, start=1):
                yield _listed(path, number, line)
    except (OSError, UnicodeDecodeError) as refusal:
        raise InputError(f"{printable(str(path))}: cannot be read: {printable(str(refusal))}") from None


def _listed(path: Path, number: int, line: str) -> Entry:
    try:
        address, name, size, modified = json.loads(line)
        kinds = all(isinstance(one, str) for one in (address, name)) and isinstance(size, int | None)
        kinds = kinds and isinstance(modified, str | None)
    except (ValueError, TypeError, RecursionError):
        kinds = False
    if not kinds or not line.endswith("\n"):
        raise InputError(
            f"{printable(str(path))}: line {number} is damaged; remove this file if the recordings are those with "
            f"which the run began, else give another folder for the results"
        )
    return Entry(name=name, path=address, size=size, modified=modified)


def in_chunks(entries: Iterable[Entry], most: int) -> Iterator[tuple[Entry, ...]]:
    """Yield the entries in chunks of at most ``most``; which ones go together depends on the entries alone."""
    chunk: list[Entry] = []
    size = 0.0
    for entry in entries:
        if entry.samples is not None:
            share = entry.samples.values.nbytes / MOST_SAMPLE_BYTES
        else:
            share = (entry.size or 0) / MOST_FILE_BYTES
        if chunk and (len(chunk) == most or size + share > 1):
            yield tuple(chunk)
            chunk, size = [], 0.0
        chunk.append(entry)
        size += share
    if chunk:
        yield tuple(chunk)


@dataclass(frozen=True, kw_only=True, slots=True)
class Seen:
    """What is known of a record while work on it goes on: the step, and the sha256 of its content."""

    step: Step = Step.READ
    sha256: str | None = None


class RefusedError(Exception):
    """A record that is refused before it is analysed."""

    def __init__(self, remark: Remark) -> None:
        super().__init__(str(remark))
        self.remark = remark


@contextmanager
def source_of(entry: Entry, know: Callable[[Seen], None]) -> Iterator[Path | control.TimeResponseData]:
    """Give what `analyse` takes: a file of this machine or a response; tell its hash as soon as it is known."""
    if entry.refusal is not None:
        raise RefusedError(entry.refusal)
    if entry.samples is not None:
        know(Seen(sha256=samples_hash(entry.samples)))
        samples = entry.samples
        yield as_samples(samples.timepts, samples.values, samples.channels, title=entry.name)
        return
    assert entry.path is not None
    with _at_hand(entry.path) as path:
        if path.is_file():
            know(Seen(sha256=file_hash(path)))
            size = path.stat().st_size
            if entry.size is not None and size != entry.size:
                raise RefusedError(Remark(Failure.CHANGED, {"then": entry.size, "now": size}))
        yield path


def entry_hash(entry: Entry) -> str | None:
    """Return the sha256 of a file as it is now; None if it cannot be read."""
    try:
        with _at_hand(entry.path or "") as path:
            return file_hash(path)
    except (OSError, RefusedError):
        return None


def file_hash(path: Path) -> str:
    """Return the sha256 of a file."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextmanager
def _at_hand(address: str) -> Iterator[Path]:
    """Give a file of this machine: the one named, or a copy of one elsewhere."""
    if "://" not in address:
        yield Path(address)
        return
    import fsspec

    with tempfile.TemporaryDirectory(prefix="suspid-") as folder:
        files, place = fsspec.core.url_to_fs(address)
        copy = Path(folder, Path(place).name)
        try:
            files.get_file(place, str(copy))
        except FileNotFoundError:
            raise RefusedError(Remark(Failure.NOT_FOUND)) from None
        yield copy
