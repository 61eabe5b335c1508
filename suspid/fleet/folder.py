"""The folder of a fleet's results: one run at a time writes there, and continues with its original settings."""

from __future__ import annotations

import filecmp
import itertools
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from suspid.errors import InputError
from suspid.files import printable
from suspid.fleet.listing import Listing
from suspid.fleet.manifest import check_same, durable_write, read_manifest, writing
from suspid.fleet.parts import part_counts, part_names, part_numbers
from suspid.fleet.records import LIST, Entry, entry_hash, read_list, samples_hash, write_list
from suspid.fleet.tables import Layout, layout_of
from suspid.words import count


@contextmanager
def own(folder: Path) -> Iterator[None]:
    """Make the folder and hold it for this run alone."""
    name = printable(str(folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        strangers = [p.name for p in folder.iterdir() if not p.name.startswith(".")]
        if strangers and "manifest.json" not in strangers:
            raise InputError(
                f"{name}: contains {printable(strangers[0])!r}, which is not a result of a fleet; give a new folder"
            )
    except OSError as refusal:
        raise InputError(f"{name}: cannot be used for results: {refusal.strerror or refusal}") from None
    try:
        import fcntl
    except ImportError:
        # Windows has no such lock: two runs in one folder are not detected.
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise InputError(
            f"{name}: another run is writing its results there; wait for it, or give another folder"
        ) from None
    except OSError:
        # A file system without locks: two runs in one folder are not detected.
        pass
    try:
        yield
    finally:
        os.close(handle)


def begun(folder: Path, manifest: Mapping[str, object]) -> Mapping[str, object]:
    """Write the manifest of a new run, or check that of one to go on with; return it."""
    if (folder / "manifest.json").exists():
        check_same(folder, read_manifest(folder), manifest)
    else:
        write_manifest(folder, manifest)
    # The manifest comes first: a folder that holds anything and no manifest is not ours.
    for table in layout_of(manifest).names:
        with writing(folder / table):
            (folder / table).mkdir(exist_ok=True)
    return manifest


def write_manifest(folder: Path, manifest: Mapping[str, object]) -> None:
    """Write the manifest, complete or absent."""
    durable_write(folder / "manifest.json", (json.dumps(manifest, indent=1) + "\n").encode())


def taken(folder: Path, source: Listing, layout: Layout) -> tuple[Iterator[Entry], int | None, tuple[str, ...]]:
    """Return the records, their number if it is known, and what to say of them; files from the list kept."""
    if not source.listed:
        return iter(source.entries), None, ()
    notes = []
    kept, now = folder / LIST, folder / f".{LIST}.now"
    if kept.exists():
        write_list(now, source.entries)
        total = sum(1 for _ in read_list(kept))
        if not filecmp.cmp(now, kept, shallow=False):
            notes += _changes(folder, kept, now, layout)
        now.unlink()
    else:
        total = write_list(kept, source.entries)
    if source.left_out:
        kinds = ", ".join(f"{count} {suffix}" for suffix, count in sorted(source.left_out.items()))
        notes.append(f"left out, since such files are not records: {kinds}")
    return read_list(kept), total, tuple(notes)


def _changes(folder: Path, kept: Path, now: Path, layout: Layout) -> list[str]:
    """Say how the files differ from those of then; one that was written again with the same content does not."""
    then, here = ({one.path: one for one in read_list(path)} for path in (kept, now))
    there = [path for path in then if path in here]
    other = {then[path].name: here[path] for path in there if then[path].size != here[path].size}
    again = {
        then[path].name: here[path]
        for path in there
        if then[path].size == here[path].size and then[path].modified != here[path].modified
    }
    numbers = part_numbers(folder, layout.main) if again else []
    for number in numbers:
        if part_counts(folder, number, layout) is not None:
            for name, digest in part_names(folder, number, layout):
                if name in again and entry_hash(again[name]) == digest:
                    del again[name]
    changed = sorted({*other, *again})
    notes = []
    if changed:
        notes.append(
            f"{count(len(changed), 'file')} changed since the run began, {printable(changed[0])} first; results that "
            f"are there are of what it was then: for others give another folder"
        )
    if len(there) < max(len(then), len(here)):
        notes.append(
            f"the files have changed since the run began: {len(then)} records then, {len(here)} now; the results are "
            f"of those of then; for the others give another folder"
        )
    return notes


def not_empty(source: Listing, folder: Path) -> Listing:
    """Return the source of a new run; one without a record is refused.

    Raises
    ------
    InputError
        If a new run would have no record; the message says what else was met.
    """
    if not source.listed or (folder / "manifest.json").exists():
        return source
    entries = iter(source.entries)
    first = next(entries, None)
    if first is not None:
        return replace(source, entries=itertools.chain([first], entries))
    where = next((place for place in source.source.values() if isinstance(place, str)), "")
    kinds = ", ".join(f"{count} {suffix}" for suffix, count in sorted(source.left_out.items()))
    said = f"only {kinds}" if kinds else "it contains no file of a known type"
    refusal = InputError(f"there is no record: {printable(said)}; give a folder of recordings, such as .csv or .mf4")
    raise refusal.about(printable(where))


def is_of(folder: Path, number: int, chunk: Sequence[Entry], layout: Layout) -> bool:
    """Return whether a part has rows of no other records than those of its chunk, as a copy of another part would."""
    return {name for name, _ in part_names(folder, number, layout)} <= {entry.name for entry in chunk}


def check_part(folder: Path, number: int, chunk: Sequence[Entry], layout: Layout, *, listed: bool) -> None:
    """Refuse to go on with a stream whose records are not those that made a part."""
    if listed:
        return
    there = part_names(folder, number, layout)
    names = {name for name, _ in there}
    for entry in chunk:
        known = entry.samples is None or (entry.name, samples_hash(entry.samples)) in there
        if entry.name not in names or not known:
            raise InputError(
                f"record {printable(entry.name)!r} is not the one that stands in part {number} of "
                f"{printable(str(folder))}: the records do not come as they did when the run began; give the same "
                f"ones in the same order, or another folder for the results"
            )


def check_end(folder: Path, parts: int, layout: Layout) -> None:
    """Refuse to end a run whose folder holds parts beyond its last one."""
    beyond = [number for number in part_numbers(folder, layout.main) if number >= parts]
    if beyond:
        raise InputError(
            f"{printable(str(folder))}: contains parts from number {beyond[0]} on, but the records end before: "
            f"fewer came than when the run began; give the same ones, or another folder for the results"
        )
