"""What a file holds besides its channels: the reason why each part was left out, as a predicate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

from suspid.wording import Argument
from suspid.words.remarks import Code, Number, count, sentence


def _blank(numbers: Mapping[str, Number]) -> str:
    more = numbers["more"]
    return f"is empty, and {more} more" if more else "is empty"


def _names_again(numbers: Mapping[str, Number]) -> str:
    more = numbers["more"]
    others = f", the first of {count(cast(int, more) + 1, 'line')}" if more else ""
    return f"has the names of the columns again{others}"


def _anew(numbers: Mapping[str, Number]) -> str:
    return f"begins anew after row {numbers['row']}{_of_tests(numbers)}"


def _breaks(numbers: Mapping[str, Number]) -> str:
    return f"has a long break after row {numbers['row']}{_of_tests(numbers)}"


def _of_tests(numbers: Mapping[str, Number]) -> str:
    more = numbers["more"]
    if not more:
        return ": what follows is a test of its own"
    return f", the first of {cast(int, more) + 1}: what follows each is a test of its own"


def rates_of_units(numbers: Mapping[str, Number]) -> str:
    """Return the rates to give for a unit of time that is guessed, and for the others that it may be.

    Examples
    --------
    >>> rates_of_units({"unit": "ms", "others": ("us",), "rates": (15.625, 15625.0)})
    'fs=15.625 if it is ms, fs=15625 if it is us'
    """
    others, rates = cast("tuple[str, ...]", numbers["others"]), cast("tuple[float, ...]", numbers["rates"])
    units = (str(numbers["unit"]), *others)
    return ", ".join(
        f"{Argument('fs', format(rate, '.6g'))} if it is {unit}" for unit, rate in zip(units, rates, strict=True)
    )


def _magnitude(numbers: Mapping[str, Number]) -> str:
    axes = numbers["axes"]
    assert isinstance(axes, tuple)
    return f"is the magnitude of {', '.join(map(repr, axes))}: it is not linear in the motion"


AS_VECTORS = "save its contents as vectors, such as ts.Time and ts.Data of a timeseries"
# How numbers are taken out of MATLAB's objects of a class, whose variable is {0}.
TAKEN_OUT = {
    "timeseries": "t = {0}.Time; y = squeeze({0}.Data)",
    "timetable": "t = seconds({0}.Properties.RowTimes - {0}.Properties.RowTimes(1)); y = {0}.Variables; "
    "names = {0}.Properties.VariableNames",
    "table": "y = {0}.Variables; names = {0}.Properties.VariableNames",
    "iddata": "y = {0}.OutputData; names = {0}.OutputName; Ts = {0}.Ts",
    "duration": "{0} = seconds({0})",
    "datetime": "{0} = seconds({0} - {0}(1))",
    "Simulink.SimulationData.Dataset": "ts = {0}{{1}}.Values; t = ts.Time; y = squeeze(ts.Data)",
}


def _object(numbers: Mapping[str, Number]) -> str:
    name, variable = str(numbers["name"]), str(numbers.get("variable") or "x")
    lines = TAKEN_OUT.get(name)
    if lines is None:
        return f"is an object of class {name!r}; {AS_VECTORS}"
    saved = [part.split(" = ")[0] for part in lines.format(variable).split("; ")]
    listed = ", ".join(f"'{one}'" for one in saved if one != "ts")
    return f"is a {name}; in MATLAB: {lines.format(variable)}; save('record.mat', {listed})"


class LeftOut(Code):
    """Why a part of a file is not a channel; the sentence follows the name of the part.

    Examples
    --------
    >>> from suspid.words import Remark
    >>> str(Remark(LeftOut.CUT_SHORT, {"cells": 2, "width": 3}))
    'is cut short: it has 2 of 3 cells'
    """

    # What the part is.
    TEXT = "text", sentence(lambda n: f"is text such as {n['cell']!r}" if n.get("cell") else "is text")
    TEXT_OR_BYTES = "text_or_bytes", "is text or bytes"
    ODD_STAMPS = (
        "odd_stamps",
        "is text such as {cell!r}, neither a number nor a time; write seconds, or 2024-05-31 23:59:59.125",
    )
    DATES = "dates", "contains dates"
    EMPTY = "empty", "is empty"
    COMPLEX = "complex", "is complex; a record is real"
    NUMBER = "number", "is a single number"
    NOT_NUMERIC = "not_numeric", "is not numeric"
    NOT_REAL = "not_real", "is not real numbers"
    NO_VALUES = "no_values", "contains no real values"
    ENUMERATION = "enumeration", "is an enumeration, not numeric"
    TYPE = "type", "is of type {type}"
    CLASS = "class", "is of class {number}"
    CELLS = "cells", "is a cell array of different things; save vectors"
    NOTE = "note", "is text"
    PICKLE = "pickle", "is a Python object; pickles are not read"
    SPARSE = "sparse", "is a sparse matrix"
    OBJECT = "object", f"is an object; {AS_VECTORS}"
    CLASS_OBJECT = "class_object", _object
    EMPTY_STRUCTURE = "empty_structure", "is an empty structure"
    STRUCTURE = "structure", "is an array or a structure"
    NESTED = "nested", "is nested ({type})"
    ARRAY = "array", "is an array of {shape}; save its columns as vectors"
    MATRIX = "matrix", "is a matrix of {shape}; save its columns as vectors"
    TOO_DEEP = "too_deep", "is nested within {levels} groups or more"
    REFERENCES = "references", "contains references"
    NO_NUMBERS = "no_numbers", "contains no numbers"
    FUNCTION = "function", "is {function}, not a time history"
    COMPLEX_FUNCTION = "complex_function", "is complex ({function}); a record is real"
    ABSCISSA = "abscissa", "is not sampled over time (abscissa type {type})"
    NOT_OVER_TIME = "not_over_time", "is sampled over {axis}, not over time"
    TIME_UNIT = "time_unit", "has its time in {unit!r}; known: s, ms, us, ns, min, h, days"
    INVALID = "invalid", "is marked as invalid throughout"
    FORMULA = "formula", "is scaled by a formula; formulas from files are not evaluated"
    # What keeps it from being read.
    OTHER_FILE = "other_file", "is a link to another file, which is not followed"
    OTHER_FILES = "other_files", "keeps its numbers in other files, which are not read"
    BROKEN_LINK = "broken_link", "is a link to nothing"
    LOOP = "loop", "is a link to a group around it"
    UNFILLED = "unfilled", "has the size {shape}, but no data"
    FRAMES = (
        "frames",
        sentence(lambda n: f"contains raw CAN frames ({n['ids']}); decode them with {Argument('dbc', '…')}"),
    )
    UNKNOWN_FRAMES = "unknown_frames", "contains frames that are not in the CAN database ({ids})"
    NO_FRAMES = "no_frames", "has no raw CAN frames to decode"
    # Time.
    TIME = "time", "is the time, counted from its first stamp {start!r}"
    NEWEST_FIRST = (
        "newest_first",
        "is newest first: rows are taken, and counted, from the last of the file to its first",
    )
    SINCE_A_DATE = "since_a_date", "is {start:.6f} s; times are counted from there"
    GROUP_TIME = "group_time", "is the time of its group"
    TAKEN_AS_TIME = "taken_as_time", "increases like a clock: taken as the time"
    STEP_CLOCK = "step_clock", "holds the time from each sample to the next [{unit}]: their sums are the time"
    SAME_TIME = (
        "same_time",
        sentence(
            lambda n: (
                f"runs {float(str(n['late'])):+.3g} s from {n['other']!r}: one is used for both"
                if n.get("late")
                else f"is the same time as {n['other']!r}"
            )
        ),
    )
    EVEN = "even", "changes evenly with the time, as a clock or an axis does"
    LIKE_TIME = "like_time", "reads like a time"
    PARTS = "parts", "holds the parts of a second, beside the time {other!r}"
    SPARE_TIMES = "spare_times", "contains times of day, which are not needed: another column is the time"
    SEVERAL_TIMES = "several_times", "contains times of day, as other columns do; name the time"
    NO_TIME = "no_time", "has no time; name its column of time, or give the sampling rate"
    SIZE = "size", "has {samples} samples, time {time!r} has {stamps}"
    LENGTH = "length", "has {samples} samples, the others have {others}"
    IGNORED_TIME = "ignored_time", "is a time, ignored as asked"
    EPOCH = "epoch", "is not stated; stamps of this size are {unit} since 1970"
    TICKS = "ticks", "is not stated; stamps of this size are ticks of 100 ns, as Windows counts them"
    DAYS = "days", "is not stated; numbers of this size are dates in {unit}"
    OF_DIGITS = "of_digits", "is not stated; its numbers are hours, minutes and seconds, such as 235959.5"
    FINER_UNIT = (
        "finer_unit",
        sentence(
            lambda n: (
                f"is not stated; taken as {n['unit']}: steps of {n['step']:.4g} seconds are too slow for a suspension"
                + (f"; give {rates_of_units(n)}" if n["others"] else f"; give {Argument('fs')} if they are s, or finer")
            )
        ),
    )
    TOO_FINE = (
        "too_fine",
        sentence(
            lambda n: (
                f"is {n['unit']}: steps of {n['step']:.2g} s, {n['length']:.2g} s in all; are these seconds? "
                f"then correct the unit in the file, or give {Argument('fs', format(n['rate'], '.6g'))}"
            )
        ),
    )
    SHORT_SECONDS = (
        "short_seconds",
        sentence(
            lambda n: (
                f"is not stated; taken as s: {n['length']:.2g} s at {n['rate']:.6g} Hz; "
                f"give {Argument('fs', format(n['rate'] / 60, '.6g'))} if they are min"
            )
        ),
    )
    OTHER_RATE = "other_rate", "is {rate:.9g} Hz; the given {fs:.9g} Hz replaces it"
    OUTVOTED = (
        "outvoted",
        sentence(
            lambda n: (
                f"is {n['rate']:.9g} Hz, but the time stamps run at {n['stamps']:.9g} Hz and are used; give "
                f"{Argument('fs')} if they are wrong"
            )
        ),
    )
    MAGNITUDE = "magnitude", _magnitude
    TEMPERATURE = "temperature", "is a temperature, not a motion"
    ANEW = "anew", _anew
    BREAKS = "breaks", _breaks
    ROLLS_OVER = "rolls_over", "rolls over at {period:.10g}: it is counted on from there"
    ROW_COUNTER = "row_counter", "counts the rows"
    AXIS = "axis", "rises in even steps and ends before the record does: an axis of its own"
    OVER_AXIS = "over_axis", "ends with {axis!r}, which is no time"
    # Lines of text files.
    HEADING = "heading", "is above the data: {line}"
    HEADINGS = "headings", "are above the data, {lines} of them neither names nor units: {line} …"
    COMMENT = "comment", "is a comment: {line}"
    BLANK = "blank", _blank
    NAMES_AGAIN = "names_again", _names_again
    NO_ROWS = "no_rows", "has names of columns, and no row below them"
    CUT_SHORT = "cut_short", "is cut short: it has {cells} of {width} cells"
    CUT_CELL = "cut_cell", "is cut short within its last number: {cell!r}"
    CUT_NUMBER = (
        "cut_number",
        "is cut short within its last number: {cell!r} has {digits} of {usual} characters behind the decimal sign",
    )
    NO_END = (
        "no_end",
        "does not end with a line feed: its last number {cell!r} is whole unless the file was cut off there",
    )
    OTHER_TABLE = "other_table", "are another table, of {lines} lines: {line} …; save it as a file of its own to use it"
    OTHER_SHEET = "other_sheet", "is another sheet, of {rows} rows; save it as a file of its own to use it"
    FEWER_ROWS = "fewer_rows", "has {there} of the {stated} rows that the file states: the rest is missing"
    FOOTER = "footer", "is below the data: {line}"
    NAME_TWICE = "name_twice", "occurs twice, {name!r}; the column is called {new!r}"
    BEHIND_CHUNKS = "behind_chunks", "holds {bytes} behind its last chunk, and no sample"
    FEWER_BYTES = "fewer_bytes", "lacks {bytes} that the file states, but no sample"
    UTF_16 = "utf_16", "is UTF-16, by its first bytes"
    WINDOWS_1252 = (
        "windows_1252",
        "is not UTF-8 (byte 0x{byte:02x} on line {line}); read as Windows-1252",
    )


# What is no loss: single numbers and texts, which may state rate and names, and times, which are used.
ASIDE = frozenset({LeftOut.NUMBER, LeftOut.GROUP_TIME, LeftOut.NOTE, LeftOut.COMPLEX})
# What does not fit the time in its number of samples.
OTHER_LENGTHS = frozenset({LeftOut.SIZE, LeftOut.LENGTH})
# What a file has lost, and a unit of time that is guessed: these are warned of, where the others are merely listed.
DAMAGE = frozenset(
    {
        LeftOut.CUT_SHORT,
        LeftOut.CUT_CELL,
        LeftOut.CUT_NUMBER,
        LeftOut.NO_END,
        LeftOut.OTHER_TABLE,
        LeftOut.FEWER_ROWS,
        LeftOut.WINDOWS_1252,
        LeftOut.FINER_UNIT,
        LeftOut.TOO_FINE,
        LeftOut.SHORT_SECONDS,
    }
)
