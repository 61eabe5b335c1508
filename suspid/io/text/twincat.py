"""Exports of TwinCAT Scope: pairs of label and value above each channel, whose times are ticks of 100 ns since 1601."""

from __future__ import annotations

import re

from suspid.io.text.dialects import shortened
from suspid.words import LeftOut, Number, Remark

# The unit of its times, and labels of two of its lines, of which the first names the channels.
TICKS, NAMES, PACE = "100ns", b"Name", b"SampleTime[ms]"
# A line of pairs: the label stands before each value.
NAMED = re.compile(rb"Name([\t,;])[^\t,;\n]*(?:\1Name\1[^\t,;\n]*)*\1?\r?")
# Lines above the first row, at most.
MOST_ABOVE = 60


def with_scope_names(text: bytes) -> tuple[bytes, dict[str, Remark]]:
    r"""Return a text with names of channels and times in the line above the rows of such a file; and what is left out.

    Lines keep their numbers. Other texts are returned as they are.

    Examples
    --------
    >>> head = "Name,Scope,\n\nName,seat,Name,tire\nSampleTime[ms],5,SampleTime[ms],5\n\n"
    >>> rows = "133327233574060000,1,133327233574060000,2\n"
    >>> with_scope_names((head + rows).encode())[0].decode().split("\n")[4:6]
    ['Time (1) [100ns],seat,Time (2) [100ns],tire', '133327233574060000,1,133327233574060000,2']
    """
    if not text.startswith(NAMES):
        return text, {}
    lines = text.split(b"\n", MOST_ABOVE)[:MOST_ABOVE]
    first = next((k for k, line in enumerate(lines) if line[:1].isdigit()), 0)
    # The first line may name the project.
    named = next((k for k in range(first - 2, -1, -1) if NAMED.fullmatch(lines[k])), None)
    if named is None or lines[first - 1].strip():
        return text, {}
    mark = lines[named][len(NAMES) : len(NAMES) + 1]
    names = lines[named].rstrip(b"\r" + mark).split(mark)[1::2]
    if not any(line.startswith(PACE + mark) for line in lines[named:first]):
        return text, {}
    titles = [part for k, name in enumerate(names, 1) for part in (f"Time ({k}) [{TICKS}]".encode(), name)]
    above = sum(len(line) + 1 for line in lines[: first - 1])
    rest = text[above + len(lines[first - 1]) + 1 :]
    said: dict[str, Number] = {"lines": first - 1, "line": shortened(lines[0].decode(errors="replace"))}
    return b"\n" * (first - 1) + mark.join(titles) + b"\n" + rest, {
        f"lines 1 to {first - 1}": Remark(LeftOut.HEADINGS, said)
    }
