"""A record at hand: a file of this machine or a response, its hash, and what is known of it while work goes on."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from suspid.fleet.records import Entry, samples_hash
from suspid.signals import as_response
from suspid.words import Failure, Remark, Step

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True)
class Seen:
    """What is known of a record while work on it goes on: the step, the sha256 of its content, and its place."""

    step: Step = Step.READ
    sha256: str | None = None
    place: str = ""


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
        yield as_response(samples.timepts, samples.values, samples.channels, title=entry.name)
        return
    assert entry.path is not None
    with _at_hand(entry.path) as path:
        know(Seen(place=str(path)))
        if path.is_file():
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
            know(Seen(place=str(path), sha256=digest))
            size = path.stat().st_size
            if entry.size is not None and size != entry.size:
                raise RefusedError(Remark(Failure.CHANGED, {"then": entry.size, "now": size}))
        yield path


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
