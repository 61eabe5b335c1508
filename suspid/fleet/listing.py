"""Sources of a fleet's records: a folder, a pattern, a list, an object store, or a stream of responses."""

from __future__ import annotations

import functools
import glob
import hashlib
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from suspid.errors import InputError, SuspidError
from suspid.files import printable, real_path
from suspid.fleet.records import Entry, Samples
from suspid.io import READERS
from suspid.signals import as_signal
from suspid.words import Failure, Remark

if TYPE_CHECKING:
    import control

# Where object stores say that a file has changed, by the surest first.
CHANGE_KEYS = ("ETag", "etag", "md5Hash", "mtime", "LastModified", "last_modified", "updated", "modified", "created")
# Files of the results of a fleet, below the folder of the results.
RESULT = re.compile(r"[\\/](?:(?:modes|drives|springs|failures)[\\/]part-\d+\.parquet|manifest\.json|records\.jsonl)$")

Address: TypeAlias = "str | os.PathLike[str]"
Record: TypeAlias = "Address | control.TimeResponseData | tuple[str, control.TimeResponseData]"
Records: TypeAlias = "Address | Iterable[Record]"


@dataclass(frozen=True, kw_only=True, slots=True)
class Listing:
    """Where a run's records come from."""

    # What was asked for, as the manifest has it.
    source: Mapping[str, object]
    # The records in the order of the results; taken once.
    entries: Iterable[Entry]
    # Whether these are files, whose list can be kept, or a stream.
    listed: bool
    # How many files of other kinds were met, by suffix; filled as the entries are taken.
    left_out: Counter[str] = field(default_factory=Counter)


def listing(records: Records, *, output: Path) -> Listing:
    """Return the source of the records of `identify_many`, without its folder of results; no file is read yet."""
    left_out: Counter[str] = Counter()
    if isinstance(records, (str, os.PathLike)):
        text = os.fspath(records)
        if "://" in text:
            return Listing(source={"address": text}, entries=_remote(text, left_out), listed=True, left_out=left_out)
        path = Path(text)
        if path.is_dir():
            root = real_path(path)
            entries = _walk(root, root, real_path(output), left_out)
            return Listing(source={"folder": str(root)}, entries=entries, listed=True, left_out=left_out)
        if path.exists():
            return Listing(source={"list": [text]}, entries=[_local(text)], listed=True)
        if glob.has_magic(text):
            pattern = os.path.abspath(text)
            return Listing(source={"glob": pattern}, entries=_matches(text), listed=True, left_out=left_out)
        raise InputError(
            f"{printable(text)}: there is no such folder or file, and no pattern with * or ?; check the path"
        )
    if isinstance(records, Sequence) and all(isinstance(one, (str, os.PathLike)) for one in records):
        names = [os.fspath(one) for one in records if isinstance(one, (str, os.PathLike))]
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise InputError(f"{printable(twice[0])} stands {Counter(names)[twice[0]]} times; name every record once")
        digest = hashlib.sha256("\n".join(names).encode("utf-8", "surrogateescape")).hexdigest()
        source: dict[str, object] = {"list": {"count": len(names), "sha256": digest}}
        return Listing(source=source, entries=map(_local, names), listed=True)
    if isinstance(records, Mapping) or hasattr(records, "output_labels") or not isinstance(records, Iterable):
        raise InputError(
            f"records = {records!r:.80} must be a folder, a pattern, a list of paths or addresses, or an iterable of "
            f"responses or (name, response) pairs"
        )
    entries = (_given(number, one) for number, one in enumerate(records))
    return Listing(source={"stream": "responses"}, entries=entries, listed=False)


def _walk(folder: Path, root: Path, output: Path, left_out: Counter[str]) -> Iterator[Entry]:
    """Yield the records below a folder by name; one folder's names at a time are held."""
    try:
        with os.scandir(folder) as found:
            names = sorted((one for one in found if not one.name.startswith(".")), key=lambda one: one.name)
    except OSError as refusal:
        raise InputError(f"{printable(str(folder))}: cannot be listed: {refusal.strerror or refusal}") from None
    for one in names:
        path = Path(one.path)
        if one.is_dir(follow_symlinks=False):
            if path != output and not _holds_results(path):
                yield from _walk(path, root, output, left_out)
        elif _is_result(one.path, _holds_results):
            continue
        elif path.suffix.lower() in READERS:
            yield _local(one.path, name=path.relative_to(root).as_posix())
        else:
            left_out[path.suffix.lower() or "without suffix"] += 1


def _holds_results(folder: str | Path) -> bool:
    """Return whether a folder contains results of a fleet, whose tables are no records."""
    place = Path(folder)
    return (place / "manifest.json").is_file() and any((place / name).is_dir() for name in ("modes", "drives"))


def _is_result(place: str, holds_results: Callable[[str], bool]) -> bool:
    """Return whether a file belongs to the results of a fleet, by its place and by the files next to it."""
    found = RESULT.search(place)
    return found is not None and holds_results(place[: found.start()])


def _matches(pattern: str) -> Iterator[Entry]:
    for path in sorted(glob.iglob(pattern, recursive=True)):
        if not Path(path).is_dir() and not _is_result(os.path.abspath(path), _holds_results):
            yield _local(path)


def _remote(address: str, left_out: Counter[str]) -> Iterator[Entry]:
    """Yield what a folder, a pattern or a single address of an object store holds, by name."""
    import fsspec

    try:
        files, path = fsspec.core.url_to_fs(address)
        found = files.glob(path, detail=True) if glob.has_magic(path) else files.find(path, detail=True)
    except Exception as refusal:
        raise InputError(f"{printable(address)}: cannot be listed: {printable(str(refusal))}") from None
    if not found:
        raise InputError(f"{printable(address)}: there is no record there")
    holds_results = functools.cache(lambda root: _remote_results(files, root))
    for place in sorted(found):
        if found[place].get("type") == "directory" or _is_result(place, holds_results):
            continue
        suffix = Path(place).suffix.lower()
        if suffix in READERS or len(found) == 1:
            full = files.unstrip_protocol(place)
            name = place[len(path) :].lstrip("/") if place.startswith(f"{path.rstrip('/')}/") else full
            said = next((str(found[place][key]) for key in CHANGE_KEYS if found[place].get(key) is not None), None)
            yield Entry(name=_clean(name), path=full, size=found[place].get("size"), modified=said)
        else:
            left_out[suffix or "without suffix"] += 1


def _remote_results(files: Any, folder: str) -> bool:
    """Return the same as `_holds_results` of a folder of an object store."""
    return bool(files.exists(f"{folder}/manifest.json")) and any(
        files.isdir(f"{folder}/{name}") for name in ("modes", "drives")
    )


def _local(path: str, *, name: str | None = None) -> Entry:
    size = modified = None
    if "://" not in path:
        try:
            status = os.stat(path)
            size, modified = status.st_size, str(status.st_mtime_ns)
        except (OSError, ValueError):
            # It has its row among the failures when its turn comes.
            size = None
        path_there = os.path.abspath(path)
    else:
        path_there = path
    return Entry(name=_clean(path if name is None else name), path=path_there, size=size, modified=modified)


def _given(number: int, one: object) -> Entry:
    """Return what an iterable gave as an entry; what can be no record says why."""
    if isinstance(one, (str, os.PathLike)):
        return _local(os.fspath(one))
    name, response = f"record {number:08d}", one
    if isinstance(one, tuple) and len(one) == 2 and isinstance(one[0], str):
        name, response = _clean(one[0]), one[1]
    if not hasattr(response, "output_labels"):
        return Entry(name=name, refusal=Remark(Failure.NOT_A_RESPONSE, {"kind": type(response).__name__}))
    try:
        signal = as_signal(response)
    except SuspidError as error:
        return Entry(name=name, refusal=Remark(Failure.UNUSABLE, {"why": str(error)}))
    samples = Samples(timepts=signal.timepts, values=signal.values, channels=signal.channels)
    return Entry(name=name, samples=samples)


def _clean(name: str) -> str:
    # Parquet holds UTF-8; a file's name may be anything.
    return name if name.isprintable() else printable(name)
