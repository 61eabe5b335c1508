"""MATLAB files up to v7: structures are read as groups.

`scipy.io.loadmat` does not check the types and sizes that a file states: a damaged file can crash the process. Files
of v5 to v7 are therefore read here, and each size is checked before it is used. scipy reads v4, which has only
matrices.
"""

from __future__ import annotations

import io
import math
import struct
import warnings
import zlib
from collections.abc import Iterator, Mapping
from enum import IntEnum
from pathlib import Path

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.iddata import of_iddata
from suspid.io.labels import Group, Text, Value, Variable, of_cells
from suspid.io.limits import check_memory, most_bytes
from suspid.io.names import told_apart
from suspid.io.tables import Table
from suspid.io.variables import DEEPEST, as_table
from suspid.words import LeftOut, Remark

# Bytes before the first element.
HEADER = 128


class Item(IntEnum):
    """Types of the parts of a file."""

    INT8 = 1
    INT32 = 5
    UINT32 = 6
    MATRIX = 14
    COMPRESSED = 15
    UTF8 = 16


class ArrayClass(IntEnum):
    """Classes of arrays that are no numbers; those from 6 to 15 are."""

    CELL = 1
    STRUCT = 2
    OBJECT = 3
    CHAR = 4
    SPARSE = 5


# Type of a number by its code.
ITEMS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
TEXTS = {2: "latin1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
NUMERIC_CLASSES = range(6, 16)


def read_matlab(path: Path) -> Table:
    """Return the table of a MATLAB file up to v7: its real vectors, rates and times.

    Structures become dotted names (``run1.seat``), their arrays are numbered (``run[2].seat``), matrices are split
    into columns.
    """
    content = read_bytes(path, error=RecordError)
    try:
        return as_table(_matrices(content) if _version(content) == 4 else _variables(content))
    # A size that does not fit into memory fails where it is used.
    except (zlib.error, struct.error, MemoryError, OverflowError, RecursionError) as refusal:
        raise RecordError(f"is damaged: {type(refusal).__name__}: {printable(str(refusal))}") from None


def _matrices(content: bytes) -> Group:
    """Return the variables of a file of v4."""
    from scipy.io import loadmat

    try:
        with warnings.catch_warnings():
            # scipy warns where it may have read numbers wrongly, or a name occurs twice.
            warnings.simplefilter("error", UserWarning)
            variables = loadmat(io.BytesIO(content))  # type: ignore[arg-type]  # the stubs know paths only
    except KeyboardInterrupt:
        raise
    # A damaged file causes errors of every kind, MemoryError among them.
    except Exception as refusal:
        raise RecordError(f"is damaged: {type(refusal).__name__}: {printable(str(refusal))}") from None
    found: dict[str, Value] = {}
    for name, value in variables.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iufb":
            if not name.startswith("__"):
                found[name] = Remark(LeftOut.NOT_REAL)
            continue
        found[name] = _variable(value)
    return found


def _version(content: bytes) -> int:
    # Files of v5 begin with text, those of v4 with numbers.
    if 0 in content[:4]:
        return 4
    order = content[126:128]
    if len(content) < HEADER or order not in (b"IM", b"MI"):
        raise RecordError("is not a MATLAB file: it has no MATLAB header")
    if content[125 if order == b"IM" else 124] == 2:
        raise RecordError("is a damaged MATLAB v7.3 file: its HDF5 part is missing")
    return 5


def _variables(content: bytes) -> Group:
    """Return the variables of a file of v5 to v7."""
    order = "<" if content[126:128] == b"IM" else ">"
    found: dict[str, Value] = {}
    position, left = HEADER, most_bytes(len(content))
    while position < len(content):
        kind, body = _element(content, position, order)
        position += 8 + len(body)
        if kind == Item.COMPRESSED:
            inflater = zlib.decompressobj()
            matrix = inflater.decompress(body, left)
            left -= len(matrix)
            if inflater.unconsumed_tail or left <= 0:
                check_memory(most_bytes(len(content)) + 1, len(content))
            kind, body = _element(matrix, 0, order)
        if kind != Item.MATRIX:
            raise RecordError(f"is damaged: element of type {kind} in place of a variable")
        name, value = _value(body, order, 0)
        if name in found:
            raise RecordError(f"contains two variables named {name!r}")
        # What MATLAB stores for its objects has no name.
        if name:
            found[name] = value
    return found


def _value(body: bytes, order: str, depth: int) -> tuple[str, Value]:
    """Return the name of a variable or field, and what it holds or why it is left out."""
    if not body:
        return "", Remark(LeftOut.EMPTY)
    parts = _elements(body, order)
    flags_kind, flags = next(parts, (0, b""))
    if flags_kind != Item.UINT32 or len(flags) != 8:
        raise RecordError("is damaged: a variable lacks its flags")
    word = struct.unpack(order + "I", flags[:4])[0]
    class_code = word & 0xFF
    # Objects of newer classes state no size here.
    if class_code > NUMERIC_CLASSES[-1]:
        name_kind, name = next(parts, (0, b""))
        text = name.decode("latin1") if name_kind in (Item.INT8, Item.UTF8) else ""
        return text, _object(text, parts)
    (dims_kind, dims), (name_kind, name) = next(parts, (0, b"")), next(parts, (0, b""))
    if dims_kind != Item.INT32 or len(dims) % 4 or not 8 <= len(dims) <= 128 or name_kind not in (Item.INT8, Item.UTF8):
        raise RecordError("is damaged: a variable lacks its size or its name")
    text = name.decode("latin1")
    shape = struct.unpack(f"{order}{len(dims) // 4}i", dims)
    if min(shape) < 0:
        raise RecordError(f"is damaged: variable {text!r} has the size {shape}")
    if class_code == ArrayClass.STRUCT:
        return text, _structure(parts, shape, order, depth)
    if class_code == ArrayClass.CELL:
        return text, _cells(parts, shape, order, depth)
    if class_code == ArrayClass.CHAR:
        kind, letters = next(parts, (0, b""))
        return text, _text(kind, letters, order)
    if class_code == ArrayClass.OBJECT:
        return text, _old_object(text, parts, shape, order, depth)
    if class_code == ArrayClass.SPARSE:
        return text, Remark(LeftOut.SPARSE)
    if class_code not in NUMERIC_CLASSES:
        return text, Remark(LeftOut.CLASS, {"number": class_code})
    return text, _array(text, parts, shape, order, complex_=bool(word >> 8 & 0x08))


def _object(name: str, parts: Iterator[tuple[int, bytes]]) -> Remark:
    """Return what is to be done about an object, of which the file tells the class behind that of its system."""
    _, system = next(parts, (0, b""))
    return _of_class(name, parts)[1] if system == b"MCOS" else Remark(LeftOut.OBJECT)


def _old_object(name: str, parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, depth: int) -> Value:
    """Return what an object of an old class holds: behind the name of its class, a file has it as a structure."""
    of_class, unread = _of_class(name, parts)
    fields = _structure(parts, shape, order, depth) if of_class == "iddata" else unread
    return of_iddata(fields) if isinstance(fields, Mapping) else fields


def _of_class(name: str, parts: Iterator[tuple[int, bytes]]) -> tuple[str, Remark]:
    """Return the class that the next part of an object names, and what is to be done about one that is not read."""
    kind, letters = next(parts, (0, b""))
    if kind not in (Item.INT8, Item.UTF8):
        return "", Remark(LeftOut.OBJECT)
    of_class = printable(letters.decode("latin1"))
    return of_class, Remark(LeftOut.CLASS_OBJECT, {"name": of_class, "variable": printable(name)})


def _cells(parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, depth: int) -> Value:
    """Return what a cell array holds."""
    if depth >= DEEPEST:
        return Remark(LeftOut.TOO_DEEP, {"levels": DEEPEST})
    cells: list[Value] = []
    for _ in range(math.prod(shape)):
        kind, body = next(parts, (0, b""))
        if kind != Item.MATRIX:
            raise RecordError("is damaged: a cell array lacks cells")
        cells.append(_value(body, order, depth + 1)[1])
    return of_cells(cells)


def _array(
    name: str, parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, *, complex_: bool
) -> Variable | Remark:
    kind, numbers = next(parts, (0, b""))
    item = np.dtype(order + ITEMS.get(kind, "V1"))
    if kind not in ITEMS or math.prod(shape) * item.itemsize != len(numbers):
        raise RecordError(f"is damaged: variable {name!r} has fewer numbers than its size {shape} says")
    if complex_:
        return Remark(LeftOut.COMPLEX)
    return _variable(np.frombuffer(numbers, item).reshape(shape, order="F"))


def _variable(array: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> Variable:
    return Variable(shape=array.shape, read=lambda: array)


def _text(kind: int, letters: bytes, order: str) -> Text:
    encoding = TEXTS.get(kind, "latin1")
    if encoding in ("utf-16", "utf-32"):
        encoding += "-le" if order == "<" else "-be"
    return Text(text=letters.decode(encoding, errors="replace"))


def _structure(parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, depth: int) -> Value:
    """Return the fields of a structure by their names, or the structures of an array of them by their numbers."""
    if depth >= DEEPEST:
        return Remark(LeftOut.TOO_DEEP, {"levels": DEEPEST})
    (length_kind, length), (names_kind, names) = next(parts, (0, b"")), next(parts, (0, b""))
    # Other programs than MATLAB write the length without a sign.
    known = length_kind in (Item.INT32, Item.UINT32)
    if not known or len(length) != 4 or names_kind not in (Item.INT8, Item.UTF8):
        raise RecordError("is damaged: a structure lacks the names of its fields")
    width = struct.unpack(order + "i", length)[0]
    if width <= 0 or len(names) % width:
        raise RecordError("is damaged: the field names of a structure have no length")
    fields = [names[k : k + width].split(b"\0")[0].decode("latin1") for k in range(0, len(names), width)]
    # Such programs may also write a name twice.
    fields = told_apart(fields)
    if not fields or not math.prod(shape):
        return Remark(LeftOut.EMPTY_STRUCTURE)
    found: list[dict[str, Value]] = []
    for _ in range(math.prod(shape)):
        one: dict[str, Value] = {}
        for field in fields:
            kind, body = next(parts, (0, b""))
            if kind != Item.MATRIX:
                raise RecordError(f"is damaged: field {field!r} of a structure is missing")
            one[field] = _value(body, order, depth + 1)[1]
        found.append(one)
    if len(found) == 1:
        return found[0]
    return {f"[{k + 1}]": one for k, one in enumerate(found)}


def _elements(body: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield type and content of each part of a variable."""
    position = 0
    while position < len(body):
        kind, content = _element(body, position, order)
        small = struct.unpack_from(order + "I", body, position)[0] >> 16
        position += 8 if small else 8 + -(-len(content) // 8) * 8
        yield kind, content


def _element(data: bytes, position: int, order: str) -> tuple[int, bytes]:
    """Return type and content of the element at a position; up to four bytes may be in the tag itself."""
    if position + 8 > len(data):
        raise RecordError("is damaged: it ends within a variable")
    kind, size = struct.unpack_from(order + "II", data, position)
    start = position + 8
    if kind >> 16:
        kind, size, start = kind & 0xFFFF, kind >> 16, position + 4
        if size > 4:
            raise RecordError("is damaged: a short element is too long")
    if start + size > len(data):
        raise RecordError("is damaged: it ends within a variable")
    return kind, data[start : start + size]
