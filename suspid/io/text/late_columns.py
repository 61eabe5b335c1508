"""Last columns that are blank at the top of a text file, as those of a sensor that starts late."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

from suspid.io.text.layouts import Layout

# Rows that fill a last column from which on it is one: fewer are odd lines.
FEW_LATE = 20


def with_late_column(layout: Layout, text: bytes, start: int) -> Layout:
    """Return a layout with a last column where rows without a name above it are filled further down.

    At the top a delimiter that ends each row looks alike.
    """
    end = layout.dialect.delimiter.encode()
    if layout.names[-1] or end == b" " or text.count(end + b"\n", start) == text.count(b"\n", start):
        return layout
    mark = re.escape(end)
    before = len(layout.names) - 1
    filled = rb"^(?:[^%b\n]*%b){%d}[ \t]*[-+.\d][^%b\n]*$" % (mark, mark, before, mark)
    rows = re.compile(filled, re.M).finditer(text, start)
    if len(list(itertools.islice(rows, FEW_LATE))) < FEW_LATE:
        return layout
    name = f"column {len(layout.names)}"
    return replace(layout, names=(*layout.names[:-1], name), kinds={**layout.kinds, name: "missing"})
