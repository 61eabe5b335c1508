"""The manifest of a fleet's run: its settings and versions; and files that are complete or absent."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from suspid.errors import InputError
from suspid.files import printable, read_text
from suspid.io import install_line
from suspid.wording import Argument

FLEET_FORMAT = "suspid fleet 4"
# Differences of settings that a message lists.
MOST_DIFFERENCES = 4
INSTALL = install_line("fleet")


def environment() -> dict[str, str]:
    """Return the versions on which the bytes of the results depend."""
    from importlib.metadata import version

    return {name: version(name) for name in ("suspid", "numpy", "scipy", "cvxpy", "pyarrow", "control", "PyWavelets")}


def read_manifest(folder: Path) -> dict[str, object]:
    """Return the manifest of a folder of results."""
    path = folder / "manifest.json"
    if not path.exists():
        raise InputError(
            f"{printable(str(folder))}: contains no results of a fleet: there is no manifest.json in it; name "
            f"the folder that `suspid fleet … -o FOLDER` wrote"
        )
    try:
        content = json.loads(read_text(path))
    except ValueError as error:
        raise InputError(f"{printable(str(path))}: is not a manifest: {printable(str(error))}") from None
    if not isinstance(content, dict) or content.get("format") != FLEET_FORMAT:
        said = f", but of {content.get('format')!r:.40}" if isinstance(content, dict) and "format" in content else ""
        raise InputError(f"{printable(str(path))}: is not a manifest of {FLEET_FORMAT!r}{printable(said)}")
    return content


def check_same(folder: Path, begun: Mapping[str, object], asked: Mapping[str, object]) -> None:
    """Refuse to continue a run that was begun with other settings or by other versions.

    Raises
    ------
    InputError
        The message says what differs, then and now.
    """
    then = _flat("", {key: value for key, value in begun.items() if key != "complete"})
    now = _flat("", json.loads(json.dumps(asked)))
    different = [key for key in {**then, **now} if then.get(key) != now.get(key)]
    if different:
        drives = [any(key.startswith("drives.") for key in settings) for settings in (then, now)]
        more = f"; and {len(different) - MOST_DIFFERENCES} more" if len(different) > MOST_DIFFERENCES else ""
        kinds = ["drives" if one else "decays" for one in drives]
        parts: list[object] = [f"records were {kinds[0]}, are {kinds[1]}"]
        if drives[0] == drives[1]:
            each = [_difference(key, then.get(key), now.get(key)) for key in different[:MOST_DIFFERENCES]]
            parts = [*[part for one in each for part in ("; ", *one)][1:], more]
        raise InputError(
            "this run was begun with other settings: ",
            *parts,
            "; continue as it was begun, or give another folder for the results",
        ).about(printable(str(folder)))


def _difference(key: str, then: object, now: object) -> tuple[object, str]:
    """Return which setting differs, and how; of a text of several lines the first line that does."""
    name = Argument(key.rpartition(".")[2])
    if isinstance(then, str) and isinstance(now, str) and "\n" in then + now:
        lines = itertools.zip_longest(then.splitlines(), now.splitlines(), fillvalue="nothing")
        old, new = next(pair for pair in lines if pair[0] != pair[1])
        return name, printable(f" had {old.strip()!r:.80}, has {new.strip()!r:.80}")
    was, is_now = ("not given" if value is None else f"{value!r:.80}" for value in (then, now))
    return name, printable(f" was {was}, is {is_now}")


def durable_write(path: Path, content: bytes) -> None:
    """Write a file so that it is complete or absent, even if the power fails: write, sync, rename, sync."""
    # The draft has a fixed name, so that the next run overwrites what a killed one left.
    draft = path.with_name(f".{path.name}.draft")
    with writing(path):
        with draft.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(path)
        sync_folder(path.parent)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say what cannot be written, and that the run may go on from there."""
    try:
        yield
    except OSError as refusal:
        raise InputError(
            f"{printable(str(path))}: cannot be written: {refusal.strerror or refusal}; what is written so far is "
            f"complete, and the same command continues from there"
        ) from None


def sync_folder(folder: Path) -> None:
    """Flush the names in a folder to disk; where folders cannot be opened (Windows) there is nothing to do."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def require_fleet() -> None:
    """Refuse with the line that installs what is missing."""
    import importlib.util

    missing = [name for name in ("pyarrow", "fsspec") if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError(f"fleets need {', '.join(missing)}: {INSTALL}")


def _flat(prefix: str, content: object) -> dict[str, object]:
    if not isinstance(content, dict):
        return {prefix: content}
    flat: dict[str, object] = {}
    for key, value in content.items():
        flat |= _flat(f"{prefix}.{key}" if prefix else str(key), value)
    return flat
