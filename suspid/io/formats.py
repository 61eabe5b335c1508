"""Formats of files: the reader of each, by suffix, and by the first bytes where the suffix is unknown.

To add a format ``x``:

1. Write ``suspid/io/x.py`` with ``read_x(path) -> Table``; read the bytes with `suspid.files.read_bytes`.
2. Refuse damage with `RecordError`, as a predicate of the file (``"is cut off: …"``); call a foreign library through
   `suspid.io.foreign.sheltered`, which turns its failures into such a line. No reader raises any other error.
3. State units, rates and time bases in the `Table`; name what is not a channel with a `suspid.words.LeftOut`.
4. Add one line to `FORMATS` below: module, suffixes, what a file is called, and the bytes that mark it.
5. Add a writer of a small file to ``tests/test_any_file.py``, which damages it; nothing else needs to know the format.
"""

from __future__ import annotations

import codecs
import importlib
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from suspid.errors import RecordError
from suspid.io.tables import Table
from suspid.wording import Argument

Reader: TypeAlias = Callable[[Path], Table]

HDF5 = b"\x89HDF\r\n\x1a\n"


@dataclass(frozen=True, slots=True)
class Format:
    """A kind of file."""

    # The module of this package that reads it with ``read_<module>``; imported with the first such file.
    module: str
    suffixes: tuple[str, ...]
    name: str
    # Positions and bytes, each of which identifies such a file.
    marks: tuple[tuple[int, bytes], ...] = ()

    def read(self, path: Path) -> Table:
        """Return the table of a file."""
        function = f"read_{self.module.rpartition('.')[2]}"
        table: Table = getattr(importlib.import_module(f"suspid.io.{self.module}"), function)(path)
        return table


PLAIN_TEXT = Format("text.delimited", (".csv", ".txt", ".tsv", ".dat", ".log", ".asc", ".lvm", ".prn", ".lab"), "text")
FORMATS = (
    PLAIN_TEXT,
    Format("matlab", (".mat",), "a MATLAB file", ((0, b"MATLAB 5.0 MAT-file"),)),
    Format("hdf", (".h5", ".hdf5"), "an HDF5 file", ((0, HDF5), (512, HDF5))),
    Format("parquet", (".parquet", ".pq"), "a Parquet file", ((0, b"PAR1"),)),
    Format("uff", (".uff", ".unv", ".uf", ".58"), "a universal file", ((0, b"    -1"),)),
    Format("tdms", (".tdms",), "a TDMS file", ((0, b"TDSm"),)),
    Format("mdf.mdf", (".mf4", ".mdf"), "an MDF file", ((0, b"MDF     "),)),
    Format("npz", (".npy", ".npz"), "a NumPy array", ((0, b"\x93NUMPY"),)),
    Format("wav", (".wav", ".wave"), "a WAV file", ((8, b"WAVE"),)),
    Format("sheets", (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"), "a spreadsheet"),
)
BY_SUFFIX = {suffix: kind for kind in FORMATS for suffix in kind.suffixes}
READERS: dict[str, Reader] = {suffix: kind.read for suffix, kind in BY_SUFFIX.items()}
# What cannot be read, and what to do.
UNREADABLE = (
    (b"PK\x03\x04", "a spreadsheet or an archive (name a spreadsheet .xlsx or .ods, unpack an archive)"),
    (b"\xd0\xcf\x11\xe0", "an old spreadsheet (name it .xls)"),
    (b"\x1f\x8b", "compressed with gzip (unpack it)"),
    (b"{", "JSON (a record is a table)"),
)
# An element of XML is followed by another.
XML = re.compile(rb"\s*<(?:\?xml\s|\w+[^<>]{0,200}>\s*<)")
MDF = BY_SUFFIX[".mdf"]


def reader_of(path: Path, dbc: str | os.PathLike[str] | None) -> Reader:
    """Return the reader of a file: by its suffix, or by its first bytes where the suffix is unknown."""
    kind = format_of(path)
    if dbc is None:
        return kind.read
    if kind is not MDF:
        raise RecordError(Argument("dbc"), " decodes CAN frames; only MDF files contain them: leave it out")
    return lambda file: importlib.import_module("suspid.io.mdf.mdf").read_mdf(file, dbc=dbc)


def format_of(path: Path) -> Format:
    """Return the format of a file; a folder, and text of any other suffix, counts as text."""
    suffix = path.suffix.lower()
    if suffix not in BY_SUFFIX and not path.is_dir():
        marked = marked_format(path)
        if marked is None and (refusal := appearance(path)) is not None:
            raise RecordError(
                f"records of type {path.suffix!r} are not known; known: {', '.join(READERS)}; save it as one of them"
                f"{f'; it looks like {refusal}' if refusal else ''}"
            )
        return marked or PLAIN_TEXT
    # MATLAB v7.3 writes HDF5 after 512 bytes of its own, and .dat is a suffix of MDF as well as of text.
    if suffix in (".mat", ".dat") and (marked := marked_format(path)) in (BY_SUFFIX[".h5"], MDF):
        return marked
    return BY_SUFFIX.get(suffix, PLAIN_TEXT)


def marked_format(path: Path) -> Format | None:
    r"""Return the format that the first bytes of a file identify, None if they identify none.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "bump.data").write_bytes(b"TDSm\x0e")
    ...     marked_format(Path(folder, "bump.data")).name
    'a TDMS file'
    """
    head = _head(path)
    marked = (kind for kind in FORMATS for at, mark in kind.marks if head[at : at + len(mark)] == mark)
    return next(marked, None)


def is_guess(path: Path) -> bool:
    """Return whether neither the suffix nor the first bytes of a file say what it is, so that it is read as text."""
    known = path.suffix.lower() in BY_SUFFIX or marked_format(path) is not None
    return not known and bool(_head(path)) and appearance(path) is None


def is_document(path: Path) -> bool:
    """Return whether a file begins as a document in XML or HTML does."""
    return _is_xml(_head(path))


def _is_xml(head: bytes) -> bool:
    return XML.match(head.removeprefix(codecs.BOM_UTF8)) is not None


def appearance(path: Path) -> str | None:
    """Return what a file that cannot be read looks like, empty if that is not known; None if it may be text."""
    head = _head(path)
    for mark, name in UNREADABLE:
        if head.startswith(mark):
            return name
    if _is_xml(head):
        return "a document of another program, in XML (export its table as CSV there)"
    wide = head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return None if head and (wide or not set(head) & set(b"\x00\x01\x02\x03\x04\x05\x06\x07\x08\x0e\x0f")) else ""


def _head(path: Path) -> bytes:
    try:
        if not path.is_file():
            return b""
        with path.open("rb") as stream:
            return stream.read(1024)
    except (OSError, ValueError):
        return b""
