"""WAV files: each sample as a fraction of full scale."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import read_bytes
from suspid.io.foreign import sheltered
from suspid.io.tables import Table, TimeBase
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import LeftOut, Remark, count

# Stated as the size where the writer did not know it, or where another chunk states it.
UNKNOWN_SIZE = 0xFFFFFFFF


def read_wav(path: Path) -> Table:
    """Return the table of a WAV file (PCM of 8 to 64 bit, or floating point).

    Columns are named ``channel 1``, ``channel 2`` …. Integers are divided by the largest that their type
    can hold, so that full scale is 1; floating point is not changed.
    """
    content = read_bytes(path, error=RecordError)
    end, missing = _end_of_chunks(content)
    behind = len(content) - end
    said = [Remark(LeftOut.BEHIND_CHUNKS, {"bytes": count(behind, "byte")})] if behind else []
    said += [Remark(LeftOut.FEWER_BYTES, {"bytes": count(missing, "byte")})] if missing else []
    content = content[:end]
    rate, samples = sheltered(lambda: _read(content), extra="formats", suffix=path.suffix)
    if not rate > 0:
        raise RecordError(f"is damaged: it states a sampling rate of {rate} Hz")
    if not samples.size:
        raise RecordError("contains no sample")
    names = [f"channel {k + 1}" for k in range(samples.shape[1])]
    clock = TimeBase(name="wav", rate=float(rate))

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return [_fraction(samples[:, names.index(name)]) for name in wanted]

    return Table(
        sizes=dict.fromkeys(names, len(samples)),
        columns=columns,
        unusable=dict(zip(("end of the file", "size of the file"), said, strict=False)),
        units=dict.fromkeys(names, "full scale"),
        clocks=dict.fromkeys(names, clock),
    )


def _read(content: bytes) -> tuple[int, np.ndarray[Any, Any]]:
    """Return the rate [Hz] and the samples (sample, channel) as integers or floating point."""
    from scipy.io import wavfile

    rate, samples = wavfile.read(io.BytesIO(content))
    return rate, samples if samples.ndim == 2 else samples[:, None]


def _fraction(samples: np.ndarray[Any, Any]) -> RealArray:
    """Return samples as fractions of full scale; scipy puts 24 bits into the upper ones of 32."""
    if samples.dtype.kind == "f":
        return frozen_real(samples)
    middle = 128.0 if samples.dtype.kind == "u" else 0.0
    return frozen_real((samples.astype(np.float64) - middle) / 2.0 ** (8 * samples.dtype.itemsize - 1))


def _end_of_chunks(content: bytes) -> tuple[int, int]:
    """Return where the last chunk ends, and how many bytes the file states that are not there.

    A file that lacks a part of a chunk is refused, before their sizes are used. What follows the end that the file
    states, as a line feed or a tag of a player does, holds no sample.
    """
    order = ">" if content[:4] == b"RIFX" else "<"
    if content[:4] not in (b"RIFF", b"RIFX", b"RF64") or content[8:12] != b"WAVE":
        raise RecordError(f"is not a WAV file: it begins with {content[:12]!r}")
    if content[:4] == b"RF64" and content[12:16] == b"ds64" and len(content) >= 36:
        whole, long_size = struct.unpack_from("<QQ", content, 20)
    else:
        whole, long_size = struct.unpack_from(f"{order}I", content, 4)[0], UNKNOWN_SIZE
    position, seen = 12, list[bytes]()
    # Chunks are padded to an even size, but some writers do not pad the last one.
    while position + 8 <= len(content):
        name, size = content[position : position + 4], struct.unpack_from(f"{order}I", content, position + 4)[0]
        size = long_size if name == b"data" and size == UNKNOWN_SIZE else size
        named = name.isascii() and name.decode("ascii").isprintable()
        whole_chunk = named and position + 8 + size <= len(content)
        if not whole_chunk and position >= 8 + whole and name != b"data":
            break
        if not named:
            raise RecordError(f"is damaged: at byte {position} there should be a chunk, not {name!r}")
        if name == b"data" and size == UNKNOWN_SIZE:
            raise RecordError("does not state its number of samples, since it was not closed; convert it with sox")
        if not whole_chunk:
            raise RecordError(
                f"is cut off: its chunk {name.decode('ascii')!r} should have {size} bytes, there are "
                f"{len(content) - position - 8}"
            )
        seen.append(name)
        position += 8 + size + size % 2
    for name in (b"fmt ", b"data"):
        if seen.count(name) != 1:
            raise RecordError(
                f"is damaged: it has {seen.count(name)} chunks {name.decode('ascii')!r}; there must be one"
            )
    # Some programs count a byte of padding that they do not write.
    missing = 8 + whole - len(content) if whole != UNKNOWN_SIZE and 8 + whole > len(content) + 1 else 0
    return min(position, len(content)), missing
