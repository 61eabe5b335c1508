"""Limit of memory for a file, proportional to its size: a few bytes cannot claim gigabytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from suspid.errors import RecordError
from suspid.io.tables import Table
from suspid.units import RealArray

# Memory that any file may take [bytes]; a larger one may take this many times its own size. Compressed records of
# measured numbers take 2 to 20 times theirs, bombs 1000 times and more.
ANY_FILE, TIMES_SIZE = 1 << 29, 100


def most_bytes(size: int) -> int:
    """Return how many bytes the content of a file of a size may take in memory.

    Examples
    --------
    >>> most_bytes(1000) >> 20, most_bytes(10**9)
    (512, 100000000000)
    """
    return max(ANY_FILE, TIMES_SIZE * size)


def check_memory(wanted: int, size: int) -> None:
    """Refuse a file of a size whose content would take more memory than that of any record of this size.

    Examples
    --------
    >>> check_memory(1 << 33, 9000)
    Traceback (most recent call last):
    suspid.errors.RecordError: would take 8 GiB of memory, of a file of 9000 bytes; at most 0.5 GiB are taken: it is ...
    """
    if wanted > (most := most_bytes(size)):
        raise RecordError(
            f"would take {wanted / 2**30:.3g} GiB of memory, of a file of {size} bytes; at most {most / 2**30:.3g} GiB "
            f"are taken: it is damaged or only padding; choose fewer channels, or save them without compression"
        )


def metered(table: Table, size: int | None) -> Table:
    """Return the table of a file of a size, whose columns are limited together before one of them is read."""
    if size is None:
        return table
    file_size, read = size, set[str]()

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        read.update(wanted)
        # A number as it is held has 8 bytes.
        check_memory(8 * sum(table.sizes.get(name, 0) for name in read), file_size)
        return table.columns(wanted)

    return replace(table, columns=columns)
