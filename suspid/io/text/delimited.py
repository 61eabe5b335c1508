"""Delimited text, as loggers, spreadsheets and telephones write it, as a table."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from suspid.errors import RecordError
from suspid.files import read_bytes
from suspid.io.names import PER_SECOND, bare_name, is_time, split_unit
from suspid.io.tables import Table, TimeBase
from suspid.io.text.cassy import with_cassy_names
from suspid.io.text.cells import seconds
from suspid.io.text.coordinates import with_coordinates
from suspid.io.text.encodings import decoded
from suspid.io.text.endings import is_open
from suspid.io.text.late_columns import with_late_column
from suspid.io.text.layouts import Layout, find_layout
from suspid.io.text.log_stamps import with_point_stamps
from suspid.io.text.named_cells import with_names_above
from suspid.io.text.notes import without_notes
from suspid.io.text.rows import Rows, find_rows
from suspid.io.text.sections import has_rows, sections_of, title_above
from suspid.io.text.step_columns import step_clock
from suspid.io.text.stray_blanks import with_tabs
from suspid.io.text.thousands import refuse_thousands
from suspid.io.text.twincat import with_scope_names
from suspid.units import RealArray
from suspid.values import listed
from suspid.wording import Argument
from suspid.words import LeftOut, Remark

# Columns of these names say which channel a row is of.
LABELS = {
    "channel",
    "ch",
    "sensor",
    "sensor id",
    "sensor_id",
    "sensorid",
    "signal",
    "variable",
    "parameter",
    "id",
    "name",
}
# A frame as candump writes it: a time, the bus, the identifier and the bytes.
FRAME = re.compile(r"\(\d+\.\d+\)\s+\S+\s+[0-9A-F]{3,8}#", re.I)
# What begins a cell that is a formula of a text.
AS_FORMULA = re.compile(rb'(^|[,;\t])="', re.M)
# Hours and minutes, in a cell that is no time of day as a whole.
OF_CLOCK = re.compile(r"\d:\d\d")
# Most recordings, one below the other, that a file is read with.
MOST_SECTIONS = 5000
# The beginning in which header and layout are looked for. A larger one costs time, a smaller one misses long headers.
HEAD_LINES, HEAD_BYTES = 1000, 1 << 18


def read_delimited(path: Path) -> Table:
    """Return the table of a text file; delimiter, decimal sign, header and units are detected."""
    return table_of_text(read_bytes(path, error=RecordError))


def table_of_text(content: bytes) -> Table:
    """Return the table of the content of a text file."""
    ends_within = is_open(content)
    text, left_out = decoded(content)
    del content
    # Programs write a number as a formula that is its text, so that no spreadsheet changes it.
    text = AS_FORMULA.sub(rb'\1"', text) if b'="' in text[:HEAD_BYTES] else text
    text, of_scope = with_scope_names(text)
    text, of_cassy, whole = with_cassy_names(text)
    text, notes = without_notes(text, within=HEAD_BYTES)
    left_out |= {**of_scope, **of_cassy, **notes}
    text = with_coordinates(with_tabs(with_point_stamps(text), within=HEAD_BYTES), within=HEAD_BYTES)
    unnamed = text
    text = with_names_above(unnamed, within=HEAD_BYTES)
    inserted = int(text is not unnamed)
    del unnamed
    table = _table(text, inserted, ends_within=ends_within and not whole)
    return replace(table, unusable={**left_out, **table.unusable})


def _table(text: bytes, inserted: int, *, ends_within: bool, whole: bool = True) -> Table:
    """Return the table of a text in UTF-8, whose lines each have an end.

    Lines were ``inserted`` above its rows; of a part of a file, minus the number of lines before it. Only a ``whole``
    text has sections.
    """
    head = text[:HEAD_BYTES].split(b"\n", HEAD_LINES)
    middle: list[bytes] = []
    if len(text) > HEAD_BYTES or len(head) > HEAD_LINES:
        head.pop()
        middle = text[len(text) // 2 : len(text) // 2 + HEAD_BYTES // 4].split(b"\n", 300)[1:-1]
    top, within = _texts(head), _texts(middle)
    try:
        layout = find_layout(top, list(filter(str.strip, (*top, *within))), before=-inserted)
    except RecordError:
        _refuse_frames(top)
        _refuse_long_line(text, sum(len(line) + 1 for line in head), len(head) + 1 - inserted)
        raise
    refuse_thousands([*top[layout.first :], *within], layout.names, layout.dialect)
    start = sum(len(line) + 1 for line in head[: layout.first])
    sections = sections_of(text, top, layout) if whole else []
    if sections:
        return _of_sections(text, sections, layout, inserted, ends_within=ends_within)
    layout = with_late_column(layout, text, start)
    rows, odd = find_rows(text, start, layout, is_open=ends_within, inserted=inserted)
    del text
    counter = _counter(layout, top)
    left_out = {**layout.left_out, **odd, **dict.fromkeys(counter, Remark(LeftOut.ROW_COUNTER))}
    _refuse_long(rows, layout)
    blank = _blank(rows)
    # Where each line begins with a delimiter, below no names, nothing is left out.
    said = [name for name in blank if layout.first or name != layout.names[0]]
    left_out |= dict.fromkeys(said, Remark(LeftOut.NO_NUMBERS))
    usable = [name for name in layout.names if name and name not in counter and name not in blank]
    numeric = [name for name in usable if layout.kinds[name] in ("number", "missing")]
    clock, others = _clock(rows, numeric)
    if clock is None:
        clock, steps = step_clock(rows, numeric)
        others |= steps
    numeric = [name for name in numeric if name not in others]
    return Table(
        sizes=dict.fromkeys(numeric, rows.size),
        columns=rows.columns,
        read_at_once=True,
        unusable={**left_out, **others},
        rates=layout.rates,
        start=layout.start,
        units=layout.units,
        clocks={} if clock is None else dict.fromkeys(numeric, clock),
    )


def _of_sections(
    text: bytes, sections: Sequence[tuple[int, int]], layout: Layout, inserted: int, *, ends_within: bool
) -> Table:
    """Return the table of a text whose sections begin where they do (see `sections_of`), with a table of each."""
    if len(sections) > MOST_SECTIONS:
        raise RecordError(
            f"has {len(sections)} times the names of the columns, each above rows of its own; at most {MOST_SECTIONS} "
            f"recordings in one file are read: save them in files of their own"
        )
    parts, lines, again, said = list[Table](), -inserted, list[int](), dict[str, Remark]()
    for (start, names), (stop, _) in itertools.pairwise([*sections, (len(text), 0)]):
        line = lines + text.count(b"\n", start, names) + 1
        again.append(line)
        if has_rows(text, names, stop, layout):
            part = _table(text[start:stop], -lines, ends_within=ends_within and stop == len(text), whole=False)
            parts.append(replace(part, title=title_above(text, names, layout)))
        else:
            said[f"line {line}"] = Remark(LeftOut.NO_ROWS)
        lines += text.count(b"\n", start, stop)
    said = {f"line {again[1]}": Remark(LeftOut.NAMES_AGAIN, {"more": len(again) - 2}), **said}
    if len(parts) == 1:
        return replace(parts[0], unusable={**parts[0].unusable, **said})
    return Table(sizes={}, columns=lambda _: [], parts=tuple(parts), unusable=said)


def _texts(lines: Sequence[bytes]) -> list[str]:
    """Return lines as text, decoded together: one by one takes longer."""
    return b"\n".join(lines).decode().split("\n") if lines else []


def _refuse_frames(top: Sequence[str]) -> None:
    """Refuse a log of CAN frames, by its first lines."""
    lines = [line for line in top[:20] if line.strip()]
    if lines and all(FRAME.match(line) for line in lines):
        raise RecordError(
            "is a log of raw CAN frames; decode them into a table of signals, or save them as MDF and give ",
            Argument("dbc", "…"),
        ) from None


def _refuse_long_line(text: bytes, start: int, number: int) -> None:
    """Refuse a line at which the search for the layout ended because it is too long."""
    if text.find(b"\n", start, start + HEAD_BYTES) < 0 and len(text) > start + HEAD_BYTES:
        raise RecordError(f"line {number} is longer than {HEAD_BYTES} bytes; a record has one sample a line") from None


def _refuse_long(rows: Rows, layout: Layout) -> None:
    """Refuse channels next to each other in one row each, and channels one below the other, named by a column."""
    width = len(layout.names)
    named = not layout.names[-1].startswith("column ")
    # Many more cells than rows are channels in lines.
    if not named and width > 64 and rows.size * 4 < width:
        raise RecordError(f"contains {rows.size} rows of {width} cells; a record has one sample a line: transpose it")
    for name in (name for name in layout.names if bare_name(name).lower() in LABELS):
        first = list(itertools.islice(rows.cells(name), 200))
        few = list(dict.fromkeys(first))
        if 1 < len(few) <= len(first) / 2:
            raise RecordError(
                f"contains the samples of several channels one below the other: {name!r} is {listed(few)} in turn; "
                f"save a "
                f"column for each"
            )


def _blank(rows: Rows) -> list[str]:
    """Return the columns without a cell that is not blank."""
    layout = rows.layout
    mark, blank = re.escape(layout.dialect.delimiter.encode()), list[str]()
    if layout.dialect.delimiter == " ":
        return blank
    for k, name in enumerate(layout.names):
        filled = rb"^(?:[^%b\n]*%b){%d}[^%b\S\n]*[^%b\s]" % (mark, mark, k, mark, mark)
        if name and layout.kinds[name] == "missing" and not re.compile(filled, re.M).search(rows.text, rows.start):
            blank.append(name)
    return blank


def _counter(layout: Layout, top: Sequence[str]) -> list[str]:
    """Return the first column if it alone has no name and counts from 0 or 1, as pandas writes it."""
    names = layout.names
    if names[0] != "column 1" or len(names) < 2 or names[1] == "column 2":
        return []
    rows = [layout.dialect.cells(line)[0] for line in top[layout.first :] if line.strip()]
    return ["column 1"] if any(rows == [str(k + start) for k in range(len(rows))] for start in (0, 1)) else []


def _clock(rows: Rows, numeric: Sequence[str]) -> tuple[TimeBase | None, dict[str, Remark]]:
    """Return the time base that a column of times of day gives, and why other columns are not channels."""
    kinds = {name: kind for name, kind in rows.layout.kinds.items() if name}
    why = {"text": LeftOut.TEXT, "date": LeftOut.DATES, "stamp": LeftOut.SEVERAL_TIMES}
    reasons = {name: Remark(why[kind]) for name, kind in kinds.items() if kind in why}
    top = rows.top()
    for name in (name for name, kind in kinds.items() if kind == "text"):
        stamped = is_time(name) or OF_CLOCK.search(top.get(name, ""))
        reasons[name] = Remark(LeftOut.ODD_STAMPS if stamped else LeftOut.TEXT, {"cell": top.get(name, "")})
    stamps = [name for name, kind in kinds.items() if kind == "stamp"]
    named = [name for name in stamps if is_time(name)]
    chosen = next((names[0] for names in (named, stamps) if len(names) == 1), None)
    if chosen is None:
        return None, reasons
    start = next(rows.cells(chosen), "")
    times = [name for name in numeric if is_time(name)]
    parts = _parted(rows, chosen, times)
    if parts is not None:
        said = {chosen: Remark(LeftOut.TIME, {"start": start}), times[0]: Remark(LeftOut.PARTS, {"other": chosen})}
        return TimeBase(name=chosen, stamps=lambda: parts), {**reasons, **said}
    if times:
        return None, {**reasons, chosen: Remark(LeftOut.SPARE_TIMES)}
    clock = TimeBase(name=chosen, stamps=lambda: seconds(rows.cells(chosen)))
    return clock, {**reasons, chosen: Remark(LeftOut.TIME, {"start": start})}


def _parted(rows: Rows, chosen: str, times: Sequence[str]) -> RealArray | None:
    """Return the stamps [s] of times of day in whole seconds and the parts of each second beside them; None of others.

    The parts fall where a second begins, and both together rise from row to row.
    """
    if len(times) != 1 or PER_SECOND.get(split_unit(times[0])[0], 0.0) <= 1:
        return None
    per, parts = PER_SECOND[split_unit(times[0])[0]], rows.columns(times)[0]
    if not (np.all((parts >= 0) & (parts < per)) and np.any(np.diff(parts) < 0)):
        return None
    stamps = seconds(rows.cells(chosen)) + parts / per
    return stamps if np.all(np.diff(stamps) > 0) else None
