"""Numbers of rows of a text file: all rows of a piece at once, or none.

Both readers round to the nearest number in double precision, so that their numbers are the same.
"""

from __future__ import annotations

import importlib
import io
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from suspid.io.text.layouts import Layout
from suspid.units import RealArray

# Bytes of a text from which on pyarrow is imported to read it: its import takes the time that it saves on as many.
# Pieces of fewer bytes than the second number are read as fast by numpy.
WORTH_IMPORT, WORTH_ARROW = 1 << 21, 1 << 13
# Bytes of a text up to which its numbers may be held twice for a moment.
HELD_TWICE = 1 << 24


def loaded_piece(piece: bytes, count: int, use: Sequence[int], layout: Layout, *, size: int) -> RealArray | None:
    """Return the numbers of some columns of the ``count`` rows of a piece, (column, row); None if a cell is refused.

    pyarrow is the faster of the two, where it is installed; ``size`` is that of the whole text [bytes].
    """
    values = _by_arrow(piece, count, use, layout, size=size)
    return loaded(piece.decode(), count, use, layout) if values is None else values


def _by_arrow(piece: bytes, count: int, use: Sequence[int], layout: Layout, *, size: int) -> RealArray | None:
    """Return what `loaded_piece` does, as pyarrow reads it; None also where numpy is as fast, with its import."""
    dialect = layout.dialect
    here = size >= WORTH_IMPORT or "pyarrow" in sys.modules
    if not here or len(piece) < WORTH_ARROW or dialect.delimiter == " ":
        return None
    try:
        arrow: Any = importlib.import_module("pyarrow")
        text: Any = importlib.import_module("pyarrow.csv")
    except ImportError:
        return None
    names = [str(k) for k in range(len(layout.names))]
    used = [names[k] for k in use]
    # A blank cell beside others is a missing number.
    blank = [""] if len(names) > 1 else []
    try:
        table = text.read_csv(
            arrow.BufferReader(piece),
            read_options=text.ReadOptions(use_threads=False, block_size=len(piece) + 1, column_names=names),
            parse_options=text.ParseOptions(
                delimiter=dialect.delimiter, quote_char=False, double_quote=False, ignore_empty_lines=False
            ),
            convert_options=text.ConvertOptions(
                column_types=dict.fromkeys(used, arrow.float64()), include_columns=used, null_values=blank,
                decimal_point="," if dialect.comma else ".",
            ),
        )  # fmt: skip
    except (arrow.ArrowInvalid, arrow.ArrowKeyError):
        return None
    return np.array([column.to_numpy() for column in table.columns]) if table.num_rows == count else None


def every_number(piece: bytes, count: int, layout: Layout, *, size: int) -> RealArray | None:
    """Return the numbers of all columns of a piece, (column, line), None where pyarrow does not read each line as some.

    Of texts of more than `HELD_TWICE` bytes there are none: they would be held twice.
    """
    plain = all(layout.names) and set(layout.kinds.values()) <= {"number", "missing"}
    # What ends in a blank line would be read in vain.
    if not plain or size > HELD_TWICE or b'"' in piece or piece.endswith(b"\n\n"):
        return None
    return _by_arrow(piece, count, range(len(layout.names)), layout, size=size)


def loaded(rows: str | Sequence[str], count: int, use: Sequence[int], layout: Layout) -> RealArray | None:
    """Return the numbers of ``count`` rows, a text or one text each, as numpy reads them; None if it refuses one."""
    delimiter = None if layout.dialect.delimiter == " " else layout.dialect.delimiter
    if layout.dialect.comma:
        whole = rows if isinstance(rows, str) else "\n".join(rows)
        # A point beside decimal commas marks thousands, and a comma that separates cells is no decimal sign.
        if "." in whole or delimiter == ",":
            return None
        whole = whole.replace(",", ".")
        rows = whole if isinstance(rows, str) else whole.split("\n")
    # The text is read as a file: splitting it into lines would take half as long as reading its numbers.
    read = partial(np.loadtxt, delimiter=delimiter, comments=None, quotechar='"', usecols=use, ndmin=2)
    try:
        values = read(io.StringIO(rows) if isinstance(rows, str) else rows)
    except ValueError:
        whole = rows if isinstance(rows, str) else "\n".join(rows)
        filled = whole if delimiter is None else _with_blanks_filled(whole, delimiter)
        if filled == whole:
            return None
        try:
            values = read(io.StringIO(filled))
        except ValueError:
            return None
    return values.T if len(values) == count else None


def _with_blanks_filled(rows: str, delimiter: str) -> str:
    r"""Return rows with a word for a missing number in each blank cell, which numpy refuses.

    Examples
    --------
    >>> _with_blanks_filled("0,,,1\n,2,3,\n", ",")
    '0,nan,nan,1\nnan,2,3,nan\n'
    """
    lines = f"\n{rows}\n"
    # Of blank cells in a row, each pass fills every second one.
    for _ in range(2):
        lines = lines.replace(2 * delimiter, f"{delimiter}nan{delimiter}")
    return lines.replace(f"\n{delimiter}", f"\nnan{delimiter}").replace(f"{delimiter}\n", f"{delimiter}nan\n")[1:-1]
