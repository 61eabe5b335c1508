"""Files of CASSY Lab: a header of four lines for each quantity, a table of samples, and tables computed from it.

The first line names the version (``CL4``). A quantity is a name, a symbol, a unit and a line of settings of its axis,
below lines that say how it is measured. A line of two counts, columns and rows, stands above each table. The columns of
the first are the quantities but frequency, and but spectra, which have tables of their own over it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from suspid.io.names import PER_SECOND
from suspid.io.text.dialects import shortened
from suspid.words import LeftOut, Number, Remark

FIRST_LINE = re.compile(rb"CL\d[ \t]*\n")
# Two counts above a table, and the settings of an axis below the unit of its quantity.
SIZE_LINE, AXIS = re.compile(r"(\d{1,9}) (\d{1,9})"), re.compile(r"(?:[-+.\dE]+|NAN)(?: (?:[-+.\dE]+|NAN)){15}")
# The first of the lines that say how a quantity is measured, for a spectrum.
SPECTRUM = "10 4 "
# Quantities that each file has first, of which the third is the frequency of spectra.
ALWAYS, FREQUENCY = 3, 2
# Lines of a header that are looked at. One has six for each quantity.
MOST_HEADER = 1000


def with_cassy_names(text: bytes) -> tuple[bytes, dict[str, Remark], bool]:
    r"""Return a text with names and units above the first table of such a file, alone, and what is left out of it.

    Lines keep their numbers. The unit in the header is that of a display: times are stored in seconds. The last value
    tells whether all rows that the file states are there; of other files it is not known.

    Examples
    --------
    >>> axis = "0 1 1 0 1 0 0 1 0 0 0 0 0 0 1 1\n"
    >>> always = "".join(f"{name}\n{axis}" for name in ("Index\nn\n", "Time\nt\nms", "Frequency\nf\nHz"))
    >>> head = f"CL4\n180 0.1\n{always}1 1\n0 1 0 1\n1 0 0\nVoltage\nU_A1\nV\n{axis}"
    >>> with_cassy_names(f"{head}3 2\n1\t0\t0.5\t\n2\t1\t0.7\t\n1 0\n".encode())[0].strip()
    b'n\tt\tU_A1\t\n\t[s]\t[V]\t\n1\t0\t0.5\t\n2\t1\t0.7'
    """
    if FIRST_LINE.match(text) is None:
        return text, {}, False
    lines = [line.rstrip() for line in text.split(b"\n", MOST_HEADER)[:MOST_HEADER]]
    above = next((k for k, line in enumerate(lines[1:]) if b"\t" in line), 0)
    head = b"\n".join(lines[: above + 1]).decode().split("\n")
    counts, columns = SIZE_LINE.fullmatch(head[-1]), list(_columns(head))
    # Another version may state its quantities in another way: its columns then have no names.
    if counts is None or not 2 < int(counts[1]) == len(columns):
        return text, {}, False
    rows = text.split(b"\n")
    stop = len(head) + int(counts[2])
    left_out = dict(_tables_below(rows, stop))
    # Behind its last line feed a text has one more line, which is empty.
    whole = stop < len(rows)
    if not whole:
        there = len(rows) - 1 - len(head)
        left_out["table"] = Remark(LeftOut.FEWER_ROWS, {"stated": int(counts[2]), "there": there})
    names = "".join(f"{symbol}\t" for symbol, _ in columns)
    units = "".join(f"[{unit}]\t" if unit else "\t" for _, unit in columns)
    top = b"\n" * (len(head) - 2) + f"{names}\n{units}\n".encode()
    return top + b"\n".join(rows[len(head) : stop]).rstrip(b"\n") + b"\n", left_out, whole


def _columns(head: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield symbol and unit of each column of the first table."""
    ends = [k for k, line in enumerate(head) if k > ALWAYS and AXIS.fullmatch(line)]
    for n, end in enumerate(ends):
        name, symbol, unit = head[end - 3 : end]
        settings = head[ends[n - 1] + 1] if n > ALWAYS else head[ends[n - 1] + 2] if n == ALWAYS else ""
        if n != FREQUENCY and not settings.startswith(SPECTRUM):
            yield symbol or name, "s" if unit in PER_SECOND else unit


def _tables_below(rows: Sequence[bytes], start: int) -> Iterator[tuple[str, Remark]]:
    """Yield the lines of the tables from a line on, and that they are left out."""
    while start < len(rows) and (counts := SIZE_LINE.fullmatch(rows[start].strip().decode())) is not None:
        stop = start + 1 + int(counts[2])
        if stop > start + 1:
            numbers: dict[str, Number] = {"lines": stop - start, "line": shortened(rows[start].decode())}
            yield f"lines {start + 1} to {stop}", Remark(LeftOut.OTHER_TABLE, numbers)
        start = stop
