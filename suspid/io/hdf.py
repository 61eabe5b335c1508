"""HDF5 files, MATLAB v7.3 among them: groups are read as structures."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered
from suspid.io.labels import Group, Text, Value, Variable, of_cells
from suspid.io.limits import most_bytes
from suspid.io.names import stated_rate
from suspid.io.tables import Table
from suspid.io.variables import DEEPEST, as_table
from suspid.units import Hertz
from suspid.words import LeftOut, Remark

if TYPE_CHECKING:
    import h5py

Read = TypeVar("Read")
# Limit of a record; a damaged file may seem to have more groups.
MOST_VARIABLES = 20_000


def read_hdf(path: Path) -> Table:
    """Return the table of an HDF5 file, that of MATLAB v7.3 among them: its real vectors, rates and times.

    Groups become dotted names (``run1.seat``), arrays of structures are numbered (``run[2].seat``), matrices are
    split into columns. Attributes named like units and rates are used. Links to other files are not followed.
    """
    content = read_bytes(path, error=RecordError)
    return as_table(_sheltered(lambda: _content(content)))


def _sheltered(read: Callable[[], Read]) -> Read:
    return sheltered(read, extra="hdf", suffix=".h5")


def _content(content: bytes) -> Group:
    import h5py

    return _group(h5py.File(io.BytesIO(content), "r"), 0, itertools.count())


def _group(group: h5py.Group, depth: int, count: Iterator[int], around: frozenset[int] = frozenset()) -> Group:
    """Return what a group holds by its names."""
    import h5py

    found: dict[str, Value] = {}
    around |= {h5py.h5o.get_info(group.id).addr}
    for name in group:
        link = group.get(name, getlink=True)
        if name in ("#refs#", "#subsystem#"):
            continue
        if isinstance(link, h5py.ExternalLink):
            found[name] = Remark(LeftOut.OTHER_FILE)
        elif isinstance(link, h5py.SoftLink) and group.get(name) is None:
            found[name] = Remark(LeftOut.BROKEN_LINK)
        else:
            found[name] = _value(group[name], depth + 1, count, around)
    for name, number in _numbers(group).items():
        if stated_rate(name, number) is not None:
            found.setdefault(name, Variable(shape=(), read=partial(np.array, number)))
    return found


def _value(thing: object, depth: int, count: Iterator[int], around: frozenset[int]) -> Value:
    """Return what a group or data set holds, or why it is left out."""
    import h5py

    if next(count) > MOST_VARIABLES:
        raise RecordError(f"contains more than {MOST_VARIABLES} variables; save the channels of one record")
    if depth > DEEPEST:
        return Remark(LeftOut.TOO_DEEP, {"levels": DEEPEST})
    if isinstance(thing, h5py.Group):
        if "MATLAB_sparse" in thing.attrs:
            return Remark(LeftOut.SPARSE)
        if h5py.h5o.get_info(thing.id).addr in around:
            return Remark(LeftOut.LOOP)
        return _structures(thing, depth, count, around) or _group(thing, depth, count, around)
    if not isinstance(thing, h5py.Dataset):
        return Remark(LeftOut.NO_NUMBERS)
    if _class_of(thing) == "cell" and _refers(thing) and "MATLAB_empty" not in thing.attrs:
        return of_cells(
            [
                _value(thing.file[ref], depth + 1, count, around) if ref else Remark(LeftOut.EMPTY)
                for ref in _references(thing, count)
            ]
        )
    return _dataset(thing)


def _class_of(data: h5py.Dataset) -> str:
    """Return the class that MATLAB states; empty if it states none."""
    of_class = data.attrs.get("MATLAB_class", b"")
    return of_class.decode("latin1") if isinstance(of_class, bytes) else str(of_class)


def _references(data: h5py.Dataset, count: Iterator[int]) -> NDArray[Any]:
    """Return the references of a data set; more than a record may have variables are refused."""
    if _in_memory(data) > most_bytes(0):
        raise RecordError("is damaged: its references take more memory than any record")
    if next(count) + data.size > MOST_VARIABLES:
        raise RecordError(f"contains more than {MOST_VARIABLES} variables; save the channels of one record")
    return np.ravel(data[()])


def _structures(group: h5py.Group, depth: int, count: Iterator[int], around: frozenset[int]) -> Group | None:
    """Return the elements of an array of structures, which MATLAB stores by field as references."""
    import h5py

    fields = {name: group[name] for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)}
    if not fields or not all(_refers(field) and "MATLAB_class" not in field.attrs for field in fields.values()):
        return None
    if sum(map(_in_memory, fields.values())) > most_bytes(0):
        raise RecordError("is damaged: its references take more memory than any record")
    referred = {name: np.ravel(field[()]) for name, field in fields.items()}
    length = min(map(len, referred.values()))
    if next(count) + length * len(fields) > MOST_VARIABLES:
        raise RecordError(f"contains more than {MOST_VARIABLES} variables; save the channels of one record")
    return {
        f"[{k + 1}]": {
            name: _value(group.file[refs[k]], depth + 1, count, around) if refs[k] else Remark(LeftOut.EMPTY)
            for name, refs in referred.items()
        }
        for k in range(length)
    }


def _in_memory(data: h5py.Dataset) -> int:
    """Return the bytes that reading a data set takes: its own and those of a chunk, of which it may fill a part."""
    chunk = math.prod(data.chunks) * data.dtype.itemsize if data.chunks else 0
    return int(max(data.nbytes, chunk))


def _refers(thing: object) -> bool:
    import h5py

    return isinstance(thing, h5py.Dataset) and h5py.check_ref_dtype(thing.dtype) is h5py.Reference


def _dataset(data: h5py.Dataset) -> Value:
    """Return the numbers of a data set, to be read later, or why it has none."""
    import h5py

    kind = data.dtype.kind
    of_class = _class_of(data)
    if "MATLAB_object_decode" in data.attrs:
        numbers = {"name": printable(of_class), "variable": printable(data.name.rpartition("/")[2])}
        return Remark(LeftOut.CLASS_OBJECT, numbers)
    if kind in "OSU" and _in_memory(data) > most_bytes(data.id.get_storage_size()):
        return Remark(LeftOut.UNFILLED, {"shape": str(data.shape)})
    if "MATLAB_empty" in data.attrs or (data.shape and not data.size):
        return Remark(LeftOut.EMPTY)
    if of_class == "cell" or (kind == "O" and _refers(data)):
        return Remark(LeftOut.CELLS if of_class == "cell" else LeftOut.REFERENCES)
    if of_class == "char" or h5py.check_string_dtype(data.dtype) is not None:
        return Text(text=_letters(data))
    names = data.dtype.names
    if kind == "c" or (names and {name.lower() for name in names} <= {"real", "imag", "re", "im", "r", "i"}):
        return Remark(LeftOut.COMPLEX)
    if data.external or data.is_virtual:
        return Remark(LeftOut.OTHER_FILES)
    if _in_memory(data) > most_bytes(data.id.get_storage_size()):
        return Remark(LeftOut.UNFILLED, {"shape": str(data.shape)})
    if names and data.dtype.subdtype is None and all(data.dtype[name].kind in "iufb" for name in names):
        return {name: _variable(data, name) for name in names}
    return _variable(data, None) if kind in "iufb" else Remark(LeftOut.NOT_NUMERIC)


def _variable(data: h5py.Dataset, field: str | None) -> Variable:
    units = [] if field is not None else [name for name in data.attrs if name.lower() in ("unit", "units")]
    unit = _plain(data.attrs[units[0]]) if units else ""
    stated = {name: stated_rate(name, number) for name, number in _numbers(data).items()}
    rates: Mapping[str, Hertz] = {name: rate for name, rate in stated.items() if rate is not None}

    def read() -> NDArray[Any]:
        values = np.asarray(_sheltered(lambda: data[()] if field is None else data[field]))
        if field is not None:
            return values
        fills = _sheltered(lambda: _fills(data))
        masked = np.isin(values, fills)
        values = np.where(masked, np.nan, values) if np.any(masked) else values
        return _unpacked(values, data)

    return Variable(shape=tuple(data.shape), read=read, unit=unit, rates=rates)


def _fills(data: h5py.Dataset) -> NDArray[Any]:
    """Return the numbers that stand for masked samples, as netCDF states them."""
    stated = [np.ravel(data.attrs[name]) for name in ("_FillValue", "missing_value") if name in data.attrs]
    return np.concatenate([np.empty(0), *(fill for fill in stated if fill.dtype.kind in "iuf")])


def _unpacked(values: NDArray[Any], data: h5py.Dataset) -> NDArray[Any]:
    """Return packed numbers times their scale and plus their offset, as netCDF states them; others as they are."""
    stated = [np.ravel(data.attrs.get(name, usual)) for name, usual in (("scale_factor", 1.0), ("add_offset", 0.0))]
    if any(one.size != 1 or one.dtype.kind not in "iuf" or not np.isfinite(one[0]) for one in stated):
        raise RecordError(f"is damaged: {printable(data.name)!r} has a scale_factor or add_offset that is no number")
    scale, offset = (float(one[0]) for one in stated)
    return values if (scale, offset) == (1.0, 0.0) else values * scale + offset


def _numbers(thing: h5py.Group | h5py.Dataset) -> dict[str, float]:
    """Return the attributes that hold one number."""
    found = {}
    for name in thing.attrs:
        if stated_rate(name, 1.0) is not None:
            value = np.asarray(thing.attrs[name])
            if value.size == 1 and value.dtype.kind in "iuf":
                found[name] = float(value.ravel()[0])
    return found


def _plain(value: object) -> str:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    text = value.decode("utf-8", errors="replace") if isinstance(value, bytes) else value
    return printable(str(text)).strip() if isinstance(text, str) else ""


def _letters(data: h5py.Dataset) -> str:
    """Return a short text, such as the label of a signal."""
    if data.size > 1000:
        return ""
    content = data[()]
    if isinstance(content, np.ndarray) and content.dtype.kind == "u":
        return "".join(map(chr, content.ravel(order="F").tolist()))
    return _plain(content)
