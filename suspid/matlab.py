"""MATLAB files up to v7: their real vectors as the columns of a table.

scipy's reader trusts the types and sizes that a file states, and a damaged file ends the whole
process there. So every variable is checked first, and only sound numeric ones are handed over.
"""

from __future__ import annotations

import io
import math
import struct
import warnings
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.tables import PER_SECOND, Table, split_unit
from suspid.units import RealArray
from suspid.values import frozen_real

HEADER = 128
MATRIX, COMPRESSED, UINT32, INT32, INT8, UTF8 = 14, 15, 6, 5, 1, 16
# Bytes of one number, by the code of its type.
ITEM_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}
NUMERIC_CLASSES = range(6, 16)
OTHER_CLASSES = {1: "a cell array", 2: "a struct", 3: "an object", 4: "text", 5: "a sparse matrix"}
COMPLEX_FLAG = 0x08
MOST_BYTES = 1 << 31

RATE_NAMES = {"fs", "samplerate", "samplingrate", "timesamplerate", "samplefrequency", "samplingfrequency"}
RATE_NAMES |= {"samplefreq", "samplingfreq", "srate"}
STEP_NAMES = {"dt", "ts", "deltat", "timestep", "sampletime", "samplingtime", "sampleinterval", "samplinginterval"}


def read_matlab(path: Path) -> Table:
    """Return the table of a MATLAB file up to v7: its real vectors, and the rates it states.

    Raises
    ------
    RecordError
        If the file is of another kind, damaged, or holds no real vector.
    """
    from scipy.io import loadmat

    content = read_bytes(path, error=RecordError)
    version = _version(content)
    unusable: dict[str, str] = {}
    try:
        if version == 5:
            content, unusable = _sound_part(content)
        with warnings.catch_warnings():
            # What scipy warns of, such as numbers it may have read wrongly or a name that stands twice, is no record.
            warnings.simplefilter("error", UserWarning)
            variables = loadmat(io.BytesIO(content))  # type: ignore[arg-type]  # the stubs know paths only
    except (RecordError, KeyboardInterrupt):
        raise
    # The parsers meet a damaged file with errors of every kind, MemoryError among them.
    except Exception as refusal:
        raise RecordError(f"is damaged: {type(refusal).__name__}: {printable(str(refusal))}") from None
    vectors: dict[str, RealArray] = {}
    rates: dict[str, float] = {}
    for name, value in variables.items():
        if name in ("__header__", "__version__", "__globals__"):
            continue
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iufbc":
            unusable[name] = "is not numeric"
        elif value.dtype.kind == "c":
            unusable[name] = "is complex; a record is real"
        elif value.size > 1 and value.size == max(value.shape):
            vectors[name] = frozen_real(value.ravel())
        elif value.size > 1:
            unusable[name] = f"is a matrix of {' x '.join(map(str, value.shape))}; save its columns as vectors"
        elif value.size:
            unusable[name] = "is a single number"
            rate = _rate(name, float(value.item()))
            if rate is not None:
                rates[name] = rate
        else:
            unusable[name] = "is empty"
    if not vectors:
        listed = ", ".join(f"{name!r} {why}" for name, why in unusable.items())
        raise RecordError(f"holds no real vector: {listed or 'nothing at all'}")

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return [vectors[name] for name in wanted]

    return Table(sizes={n: v.size for n, v in vectors.items()}, columns=columns, unusable=unusable, rates=rates)


def _rate(name: str, value: float) -> float | None:
    """Return the sampling rate [Hz] that a scalar of that name states, if it does."""
    stem, unit = split_unit(name)
    if not (math.isfinite(value) and value > 0):
        return None
    if stem in RATE_NAMES and unit in ("", "hz"):
        return value
    if stem in STEP_NAMES and (not unit or unit in PER_SECOND):
        return PER_SECOND[unit or "s"] / value
    return None


def _version(content: bytes) -> int:
    if content[:8] == b"\x89HDF\r\n\x1a\n":
        raise RecordError("is an HDF5 file (MATLAB v7.3); save it in MATLAB with the option -v7")
    # A text stands at the head of v5, numbers at that of v4.
    if 0 in content[:4]:
        return 4
    order = content[126:128]
    if len(content) < HEADER or order not in (b"IM", b"MI"):
        raise RecordError("is not a MATLAB file: its head is not that of one")
    if content[125 if order == b"IM" else 124] == 2:
        raise RecordError("is a MATLAB v7.3 file; save it in MATLAB with the option -v7")
    return 5


def _sound_part(content: bytes) -> tuple[bytes, dict[str, str]]:
    """Return a file of the numeric variables alone, and why each of the others is left out.

    Raises
    ------
    RecordError
        If a variable is damaged, or its name stands twice.
    """
    order = "<" if content[126:128] == b"IM" else ">"
    kept, seen, unusable = [content[:116] + b" " * 8 + content[124:HEADER]], set(), {}
    position = HEADER
    while position < len(content):
        kind, body = _element(content, position, order)
        position += 8 + len(body)
        if kind == COMPRESSED:
            inflater = zlib.decompressobj()
            matrix = inflater.decompress(body, MOST_BYTES)
            if inflater.unconsumed_tail:
                raise RecordError(f"holds a variable of more than {MOST_BYTES >> 30} GiB")
            kind, body = _element(matrix, 0, order)
        if kind != MATRIX:
            raise RecordError(f"is damaged: an element of type {kind} stands where a variable should")
        name, reason = _checked_variable(body, order)
        if name in seen:
            raise RecordError(f"holds two variables named {name!r}")
        seen.add(name)
        if reason:
            unusable[name] = reason
        else:
            kept.append(struct.pack(order + "II", MATRIX, len(body)) + body)
    return b"".join(kept), unusable


def _checked_variable(body: bytes, order: str) -> tuple[str, str]:
    """Return the name of a variable, and why it is not numeric, if it is not."""
    parts = _elements(body, order)
    flags_kind, flags = next(parts, (0, b""))
    if flags_kind != UINT32 or len(flags) != 8:
        raise RecordError("is damaged: a variable lacks its flags")
    word = struct.unpack(order + "I", flags[:4])[0]
    class_code = word & 0xFF
    # Objects of newer kinds have no size and no name here.
    if class_code > NUMERIC_CLASSES[-1]:
        return f"object of class {class_code}", "is an object"
    (dims_kind, dims), (name_kind, name) = next(parts, (0, b"")), next(parts, (0, b""))
    if dims_kind != INT32 or len(dims) % 4 or not 8 <= len(dims) <= 128 or name_kind not in (INT8, UTF8):
        raise RecordError("is damaged: a variable lacks its size or its name")
    text = name.decode("latin1")
    if class_code not in NUMERIC_CLASSES:
        return text, f"is {OTHER_CLASSES.get(class_code, f'of class {class_code}')}"
    if not text:
        return text, "has no name"
    shape = struct.unpack(f"{order}{len(dims) // 4}i", dims)
    for _ in range(2 if word >> 8 & COMPLEX_FLAG else 1):
        kind, numbers = next(parts, (0, b""))
        if min(shape) < 0 or math.prod(shape) * ITEM_SIZES.get(kind, -1) != len(numbers):
            raise RecordError(f"is damaged: variable {text!r} does not hold what its size {shape} says")
    return text, ""


def _elements(body: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield type and content of each part of a variable."""
    position = 0
    while position < len(body):
        kind, content = _element(body, position, order)
        small = struct.unpack_from(order + "I", body, position)[0] >> 16
        position += 8 if small else 8 + -(-len(content) // 8) * 8
        yield kind, content


def _element(data: bytes, position: int, order: str) -> tuple[int, bytes]:
    """Return type and content of the element at a position; up to four bytes may stand in the tag itself."""
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
