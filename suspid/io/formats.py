"""Which reader reads a file: by its suffix, and where that does not tell, by its first bytes."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from suspid.errors import RecordError
from suspid.io.matlab import read_matlab
from suspid.io.signatures import HDF5, signature
from suspid.io.tables import Table
from suspid.io.text.delimited import read_delimited

Reader: TypeAlias = Callable[[Path], Table]


def _module_reader(module: str) -> Reader:
    """Return ``read_<module>`` of a module of this package that is imported with the first file of its kind."""

    def read(path: Path) -> Table:
        name = module.rpartition(".")[2]
        table: Table = getattr(importlib.import_module(f"suspid.io.{module}"), f"read_{name}")(path)
        return table

    return read


READERS: dict[str, Reader] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".log", ".asc"), read_delimited),
    ".mat": read_matlab,
    **dict.fromkeys((".h5", ".hdf5"), _module_reader("hdf")),
    **dict.fromkeys((".parquet", ".pq"), _module_reader("parquet")),
    **dict.fromkeys((".uff", ".unv", ".uf", ".58"), _module_reader("uff")),
    ".tdms": _module_reader("tdms"),
    **dict.fromkeys((".mf4", ".mdf"), _module_reader("mdf.mdf")),
    **dict.fromkeys((".wav", ".wave"), _module_reader("wav")),
}


def reader_of(path: Path, dbc: str | os.PathLike[str] | None) -> Reader:
    """Return the reader of a file: by its suffix, or by its first bytes where the suffix is unknown."""
    suffix = path.suffix.lower()
    if suffix not in READERS and not path.is_dir():
        known, looks = signature(path)
        if not known:
            raise RecordError(
                f"records of type {path.suffix!r} are not known; known: {', '.join(READERS)}; save it as one of them"
                f"{f'; it looks like {looks}' if looks else ''}"
            )
        # The marks of binary files leave no doubt.
        suffix = known
    # MATLAB v7.3 writes HDF5, below a page with its own head.
    if suffix == ".mat" and (_holds(path, HDF5, 0) or _holds(path, HDF5, 512)):
        return READERS[".h5"]
    mdf = suffix in (".mf4", ".mdf") or (suffix == ".dat" and _holds(path, b"MDF", 0))
    if dbc is not None and not mdf:
        raise RecordError("dbc decodes CAN frames; only MDF files hold them: leave it out")
    if mdf and dbc is not None:
        return lambda file: importlib.import_module("suspid.io.mdf.mdf").read_mdf(file, dbc=dbc)
    return READERS[".mdf"] if mdf else READERS.get(suffix, read_delimited)


def _holds(path: Path, mark: bytes, position: int) -> bool:
    """Whether a file can be read and holds a mark at a position."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as stream:
            stream.seek(position)
            return stream.read(len(mark)) == mark
    except (OSError, ValueError):
        return False
