"""NumPy files as tables: one array (.npy) or several by name (.npz), without pickles."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered
from suspid.io.labels import Group, Value, Variable
from suspid.io.limits import check_memory
from suspid.io.tables import Table
from suspid.io.variables import as_table
from suspid.words import LeftOut, Remark

HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def read_npz(path: Path) -> Table:
    """Return the table of a NumPy file: the arrays of an archive by their names, or the columns of a single array.

    The columns of a single array are named ``column 1``, ``column 2`` …, its longer side being time; those of a
    structured array have the names of its fields.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.npz")
    ...     np.savez(path, seat=np.ones(3), fs=50.0)
    ...     table = read_npz(path)
    >>> table.sizes, table.rates
    ({'seat': 3}, {'fs': 50.0})
    """
    content = read_bytes(path, error=RecordError)
    group = sheltered(lambda: _group(content), extra="formats", suffix=path.suffix)
    return as_table(group)


def _group(content: bytes) -> Group:
    if content.startswith(b"\x93NUMPY"):
        return _columns(_array(content))
    if not content.startswith(b"PK"):
        raise RecordError("is not a NumPy file")
    found: dict[str, Value] = {}
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        entries = archive.infolist()
        check_memory(sum(entry.file_size for entry in entries), len(content))
        for entry in entries:
            name = printable(entry.filename.removesuffix(".npy"))
            if name == entry.filename:
                found[name] = Remark(LeftOut.NOT_NUMERIC)
            else:
                found[name] = _value(_array(archive.read(entry)))
    return found


def _array(content: bytes) -> np.ndarray[Any, np.dtype[Any]] | Remark:
    """Return the array of a file; its size is checked before memory is taken."""
    stream = io.BytesIO(content)
    header = HEADERS.get(np.lib.format.read_magic(stream))
    if header is not None:
        shape, _, dtype = header(stream)
        if dtype.hasobject:
            return Remark(LeftOut.PICKLE)
        if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize > len(content):
            raise RecordError(f"is cut off: an array of shape {shape} does not fit in it")
    stream.seek(0)
    array: np.ndarray[Any, np.dtype[Any]] = np.lib.format.read_array(stream, allow_pickle=False)
    return array


def _value(array: np.ndarray[Any, np.dtype[Any]] | Remark) -> Value:
    if isinstance(array, Remark):
        return array
    if array.dtype.names:
        return {printable(name): _value(array[name]) for name in array.dtype.names}
    if array.dtype.kind not in "iufb":
        return Remark(
            {"c": LeftOut.COMPLEX, "U": LeftOut.TEXT, "S": LeftOut.TEXT}.get(array.dtype.kind, LeftOut.NOT_NUMERIC)
        )
    return Variable(shape=array.shape, read=lambda: array)


def _columns(array: np.ndarray[Any, np.dtype[Any]] | Remark) -> Group:
    value = _value(array)
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, Variable) or isinstance(array, Remark) or array.ndim != 2:
        return {"column 1": value}
    columns = array if array.shape[0] >= array.shape[1] else array.T
    return {f"column {k + 1}": _value(column) for k, column in enumerate(columns.T)}
