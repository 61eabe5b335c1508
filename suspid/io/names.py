"""Names in files: times, units, rates and counters that they state."""

from __future__ import annotations

import itertools
import math
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from suspid.units import Hertz, RealArray

# How many of each unit of time make a second.
PER_SECOND = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden"), 1.0),
    **dict.fromkeys(("ms", "msec", "millis", "millisecond", "milliseconds", "millisekunden"), 1e3),
    **dict.fromkeys(("us", "usec", "µs", "μs", "micros", "microsecond", "microseconds"), 1e6),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), 1e9),
    # Ticks of Windows.
    "100ns": 1e7,
    **dict.fromkeys(("min", "minute", "minutes", "minuten"), 1 / 60),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), 1 / 3600),
    **dict.fromkeys(("day", "days"), 1 / 86400),
}
# Units of temperature, in lower case without blanks; k alone may be a count of thousands, and c a charge.
TEMPERATURES = {"°c", "degc", "ºc", "℃", "celsius", "°f", "degf", "℉", "fahrenheit"}
# Of these, units that stand behind a name of time without a mark between, as in TimeMs. Others make other words.
JOINED = re.compile(r"(t|time|timestamp|uptime|zeit)(ms|msec|us|usec|millis|micros|nanos)")
# Names of the frequencies of a spectrum; with their unit also f.
FREQUENCIES = {"freq", "frequency", "frequencies", "frequenz", "frequenzen", "hz"}
# Units of a column of frequencies.
FREQUENCY_UNITS = {"hz", "khz", "mhz", "ghz"}
# These units of time as a message lists them.
KNOWN_UNITS = "s, ms, us, ns, min, h, days"
# Columns of these names are not taken for the time: they are parts of a date.
DATE_PARTS = {"min", "hr", "hrs", "hour", "hours", "day", "days"}
TIME_NAMES = {"t", "time", "timepts", "timestamp", "timestamps", "timedomain", "timevector", "elapsed", "elapsedtime"}
TIME_NAMES |= {"zeit", "temps", "tiempo", "uhrzeit", "zeitstempel", "datetime", "date/time", "secondselapsed", "xvalue"}
TIME_NAMES |= {"jd", "mjd", "julianday", "juliandate", "datenum"}
TIME_NAMES |= {"timed", "timeelapsed", "timesincestart", "uptime"} | (
    {name for name in PER_SECOND if len(name) > 2} - DATE_PARTS
)
RATE_NAMES = {"fs", "samplerate", "samplingrate", "timesamplerate", "samplefrequency", "samplingfrequency"}
RATE_NAMES |= {"actualrate", "actualsamplerate", "actualsamplingrate", "scanrate", "acquisitionrate"}
RATE_NAMES |= {"samplespersecond", "samplefreq", "samplingfreq", "srate", "abtastrate"}
# Of these, names that nothing else has as its last word.
LONG_RATE_NAMES = {"samplerate", "samplingrate", "samplefrequency", "samplingfrequency", "samplefreq", "samplingfreq"}
# How many hertz make a unit of a rate.
HERTZ = {"": 1.0, "hz": 1.0, "s/s": 1.0, "sa/s": 1.0, "sps": 1.0, "khz": 1e3, "ks/s": 1e3, "ksps": 1e3, "mhz": 1e6}
STEP_NAMES = {"dt", "ts", "deltat", "timestep", "sampletime", "samplingtime", "sampleinterval", "samplinginterval"}
STEP_NAMES |= {"increment", "xincrement", "deltax", "samplingtimeinterval"}
# What oscilloscopes call the time of the first sample, beside the step.
START_NAMES = {"start"}
# Words of which one makes a name read like a time, if the numbers run as a clock does.
TIME_WORDS = {"time", "times", "timestamp", "elapsed", "clock", "seconds", "secs", "sec", "millis", "micros", "date"}
TIME_WORDS |= {"zeit", "zeitpunkt", "temps", "tiempo", "tempo", "tijd", "czas", "zaman", "aika", "tid", "idő", "čas"}
TIME_WORDS |= {"время", "时间", "時間", "시간"}
# Words of the names that plots and oscilloscopes give their first column, beside x.
ABSCISSA = {"x", "axis", "value", "values", "data"}
# Between words that are joined as in loggingTime and GPSTime.
CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
# Names of columns that count the rows.
COUNTERS = {"#", "n", "no", "nr", "sample", "samples", "samplenumber", "index", "row", "line", "count", "counter"}
COUNTERS |= {"frame", "frames", "framenumber", "frameno", "idx", "id", "point", "record", "scan", "rownumber", "rowid"}
# Names of columns that have none.
UNNAMED_COLUMN = re.compile(r"column \d+")
# Names that say no more: the numbers of columns, from 1 on, as spreadsheets, R and MATLAB write them.
NUMBERED_COLUMN = re.compile(r"(?:c|v|var|col|column|field)[ _]?(\d+)", re.IGNORECASE)
# The index of a data frame, as pandas reads it again.
UNNAMED = re.compile(r"Unnamed: ?\d+", re.IGNORECASE)
# Characters of a name or of a line that patterns are tried on, whose time grows with their square. Longer ones are no
# names that a program wrote.
LONGEST_READ = 200
# Names whose parts are kept: each is asked for its time and unit a dozen times.
NAMES_KEPT = 512
# A name and, in brackets behind it, its unit; a number there counts columns.
BRACKETED = re.compile(r"(.*\S)\s*[\[(]\s*(?!\d+\s*[\])])([^\[\]()]*(?:\([^\[\]()]*\))?[^\[\]()]*)[\])]")

# Units behind a name after a line or a blank. Others are words or sides as well: m, g, in, rad.
SUFFIXED = re.compile(
    r".*[^\W_][\s_]+((?:[mcuµμ]m|[mc]?m/s|[mc]?m/s(?:\^?2|²)|ms2|mps2?|deg(?:/s)?|dps|rad/s)|(?-i:kN))", re.IGNORECASE
)

# Units behind a quantity and a solidus, as DIN 1313 and ISO 80000 head columns; behind a unit they are a ratio.
HEADED = re.compile(
    r"(?!(?:k?N|Nm|m?V|[mcuµμ]?m|rad|deg|°) ?/)[^\W\d_]+ ?/ ?([mcuµμ]m|[mc]?m/s(?:\^?2|²)?|(?:deg|°)(?:/s)?|rad/s|kN)"
)


# How far a column may be off, behind its name and unit.
TOLERANCE = re.compile(r" [\[(] ?(?:±|\+/?-)[^()\[\]]*[\])]$")

# Names that number tests, and such a number behind the name of a column, as Capstone writes it.
NUMBERED_TEST = (
    r"(?:run|test|trial|take|shot|data ?set|lauf|versuch|messung|essai|mesure|prueba|ensayo|prova)[\W_]*\d+\]?"
)
NUMBERED_LAST = re.compile(rf"(.*\S)\s+({NUMBERED_TEST})", re.I)


def told_apart(names: Sequence[str]) -> list[str]:
    """Return names that differ: one that occurs again is numbered, as no other is called.

    Examples
    --------
    >>> told_apart(["seat", "flags", "flags", "flags (2)"])
    ['seat', 'flags', 'flags (3)', 'flags (2)']
    """
    apart, taken, above = list[str](), set(names), set[str]()
    further: defaultdict[str, Iterator[int]] = defaultdict(lambda: itertools.count(2))
    for name in names:
        new = name
        if name in above:
            new = next(other for n in further[name] if (other := f"{name} ({n})") not in taken)
        apart.append(new)
        above.add(new)
        taken.add(new)
    return apart


def plain(text: str) -> str:
    """Return a text with single blanks, as far as a pattern is to look: patterns take the power of its length.

    Examples
    --------
    >>> plain("  seat   [ mm ] "), len(plain(1000 * "x"))
    ('seat [ mm ]', 200)
    """
    return " ".join(text[: 10 * LONGEST_READ].split())[:LONGEST_READ]


def bare_name(name: str) -> str:
    """Return the name without the unit in brackets behind it.

    Examples
    --------
    >>> bare_name("seat [mm]"), bare_name("a_seat_m/s2")
    ('seat', 'a_seat_m/s2')
    """
    found = BRACKETED.fullmatch(plain(name))
    return found[1].strip() if found else name.strip()


def bracketed_unit(name: str) -> str:
    """Return the unit in brackets behind a name; empty if there is none.

    Examples
    --------
    >>> [bracketed_unit(name) for name in ("seat [mm]", "acc (m/s^2)", "a_seat_m/s2", "Force (N) Run #1")]
    ['mm', 'm/s^2', '', 'N']
    """
    found = BRACKETED.fullmatch(_without_tolerance(name))
    return found[2].strip() if found else ""


def _without_tolerance(name: str) -> str:
    """Return a name, plain, without the number of its test and how far its column may be off, in brackets behind it."""
    text = TOLERANCE.sub("", plain(name))
    numbered = NUMBERED_LAST.fullmatch(text)
    return numbered[1] if numbered else text


def test_in_name(name: str) -> str:
    """Return the test that the end of a name numbers; empty if it does not.

    Examples
    --------
    >>> test_in_name("Time (s) Run #2"), test_in_name("Time 2")
    ('Run #2', '')
    """
    numbered = NUMBERED_LAST.fullmatch(plain(name))
    return numbered[2] if numbered else ""


def unit_in_name(name: str) -> str:
    """Return the unit in brackets behind a name, or one that it ends with; empty if none is sure.

    Examples
    --------
    >>> [unit_in_name(name) for name in ("seat [mm]", "seat_mm", "a_seat_m/s2", "front kN", "z_seat_m", "mm")]
    ['mm', 'mm', 'm/s2', 'kN', '', '']
    >>> [unit_in_name(name) for name in ("seat/mm", "a / m/s²", "N/mm", "imu/g")]
    ['mm', 'm/s²', '', '']
    """
    found = SUFFIXED.fullmatch(plain(name)) or HEADED.fullmatch(plain(name))
    return bracketed_unit(name) or (found[1] if found else "")


@lru_cache(maxsize=NAMES_KEPT)
def split_unit(name: str) -> tuple[str, str]:
    """Return the bare name in lower case and the unit that follows it, if any.

    Examples
    --------
    >>> split_unit("Time [ms]"), split_unit("t_s"), split_unit("Time_domain")
    (('time', 'ms'), ('t', 's'), ('timedomain', ''))
    >>> split_unit("Zeit in ms"), split_unit("time.ms"), split_unit("TimeMs"), split_unit("uptimeNanos")
    (('zeit', 'ms'), ('time', 'ms'), ('time', 'ms'), ('uptime', 'nanos'))
    >>> split_unit("Time (seconds) (± 0.0083s)"), split_unit("time (+/- 1 ms)")
    (('time', 'seconds'), ('time', ''))
    """
    # A number behind a name that occurs twice is none of its own.
    lowered = re.sub(r"\s+\(\d+\)$", "", _without_tolerance(name)).lower()
    bracketed = re.fullmatch(r"(.*?)[\s_,/]*[\[(]\s*(?!\d+\s*[\])])(.*?)\s*[\])]", lowered)
    suffixed = re.fullmatch(r"(.*?)[\s_,/.]+(?:in\s+)?([^\s_,/.]+)", lowered) or JOINED.fullmatch(lowered)
    stem, unit = lowered, ""
    if bracketed:
        stem, unit = bracketed[1], bracketed[2]
    elif suffixed and (suffixed[2] in PER_SECOND or suffixed[2] == "hz"):
        stem, unit = suffixed[1], suffixed[2]
    bare = re.sub(r"[\s_\-.]", "", stem)
    return bare, unit or (bare if bare in PER_SECOND else "")


def is_time(name: str) -> bool:
    """Whether a column of that name holds time in a unit that is known; a unit of time in brackets alone is a name.

    Examples
    --------
    >>> [is_time(name) for name in ("t", "time [ms]", "[s]", "[V]", "time [furlong]")]
    [True, True, True, False, False]
    """
    stem, unit = split_unit(name)
    return unit in set(PER_SECOND) - DATE_PARTS if not stem else stem in TIME_NAMES and (not unit or unit in PER_SECOND)


def is_frequency(name: str) -> bool:
    """Whether a column of that name holds the frequencies of a spectrum.

    Examples
    --------
    >>> [is_frequency(name) for name in ("Freq", "Frequency [Hz]", "f (Hz)", "Freq [s]", "f", "frequent")]
    [True, True, True, False, False, False]
    """
    stem, unit = split_unit(name)
    return stem in FREQUENCIES | {"f"} if unit == "hz" else stem in FREQUENCIES and not unit


@lru_cache(maxsize=NAMES_KEPT)
def may_be_time(name: str) -> bool:
    """Whether a word for time is part of a name.

    Examples
    --------
    >>> [may_be_time(name) for name in ("Run 1: Time (s)", "Time - Road (m)", "t_received", "timing belt")]
    [True, True, True, False]
    >>> [may_be_time(name) for name in ("loggingTime", "gyroTimestamp_sinceReboot(s)", "GPSTime", "overtime")]
    [True, True, True, False]
    """
    words = _words(name)
    parts = _words(CAMEL.sub(" ", bare_name(name)))
    # Stamps of time are ts, where the numbers are no steps.
    called_t = words == {"ts"} or ("t" in words and bracketed_unit(name) in ("", *PER_SECOND))
    return bool((words | parts) & TIME_WORDS) or called_t


def is_abscissa(name: str, *, rate_known: bool = False) -> bool:
    """Whether a first column of that name may be a time: it has no name or, if nothing states the rate, is called x.

    Examples
    --------
    >>> [is_abscissa(name) for name in ("column 1", "arr_0", "data[1]", "x-axis", "seat x", "seat")]
    [True, True, True, True, False, False]
    """
    words = _words(name)
    called_x = "x" in words and words <= ABSCISSA and not rate_known
    return called_x or re.fullmatch(r"column \d+|arr_0|.*\[[12]\]", name) is not None


def _words(name: str) -> set[str]:
    return {word for word in re.split(r"[\W\d_]+", bare_name(name).lower()) if word}


def is_time_in_unknown_unit(name: str) -> bool:
    """Whether a column is named time in full, in a unit that is not known.

    Examples
    --------
    >>> is_time_in_unknown_unit("time [furlong]"), is_time_in_unknown_unit("time [h]"), is_time_in_unknown_unit("t [C]")
    (True, False, False)
    """
    stem, unit = split_unit(name)
    return stem in TIME_NAMES and stem != "t" and bool(unit) and unit not in PER_SECOND


def stated_rate(name: str, value: float, unit: str = "") -> Hertz | None:
    """Return the sampling rate [Hz] that a number of that name states, if it does.

    Examples
    --------
    >>> stated_rate("Fs", 500.0), stated_rate("dt_ms", 2.0), stated_rate("mass", 80.0)
    (500.0, 500.0, None)
    >>> stated_rate("VCAP_SAMPLERATE", 5120.0), stated_rate("resamplerate", 2.0)
    (5120.0, None)
    """
    stem, own = split_unit(name)
    unit = unit.lower() or own
    if not (math.isfinite(value) and value > 0):
        return None
    words = re.split(r"[\s_.-]+", name.lower())
    if (stem in RATE_NAMES or words[-1] in LONG_RATE_NAMES) and unit in HERTZ:
        return value * HERTZ[unit]
    if stem in STEP_NAMES and (not unit or unit in PER_SECOND):
        return PER_SECOND[unit or "s"] / value
    return None


def is_step(name: str) -> bool:
    """Whether a number of that name states the step between two samples, not their rate."""
    return split_unit(name)[0] in STEP_NAMES


def is_since_last(name: str) -> bool:
    """Whether a column of that name holds the time since the sample before.

    Examples
    --------
    >>> [is_since_last(name) for name in ("time_from_previous_sample(ms)", "time (ms)", "previous runs")]
    [True, False, False]
    """
    return may_be_time(name) and "prev" in split_unit(name)[0]


def is_start(name: str) -> bool:
    """Return whether a number of that name states the time of the first sample."""
    return split_unit(name)[0] in START_NAMES


def counts_rows(name: str, values: RealArray) -> bool:
    """Whether a column counts the rows, by its name and its numbers; of rows that were picked, every nth.

    Examples
    --------
    >>> import numpy as np
    >>> counts_rows("frame", np.arange(3.0)), counts_rows("seat", np.arange(3.0)), counts_rows("#", np.ones(3))
    (True, False, False)
    """
    return (is_counter(name) or UNNAMED.fullmatch(name) is not None) and is_nth_count(values)


def is_counter(name: str) -> bool:
    """Whether a column of that name counts rows.

    Examples
    --------
    >>> is_counter("Frame"), is_counter("seat")
    (True, False)
    """
    return split_unit(name)[0] in COUNTERS


def is_nth_count(values: RealArray) -> bool:
    """Whether whole numbers count every nth row: they rise by the same whole number in each.

    Examples
    --------
    >>> is_nth_count(np.array([4.0, 6.0, 8.0])), is_nth_count(np.array([0.0, 0.5, 1.0]))
    (True, False)
    """
    if values.size < 2 or not np.all(np.isfinite(values[:2])):
        return False
    step = values[1] - values[0]
    return bool(step >= 1 and step == round(step) and values[0] == round(values[0])) and is_count(
        (values - values[0]) / step
    )


def is_count(values: RealArray) -> bool:
    """Whether whole numbers count by one."""
    # Beyond this, a number and the next whole one are the same number.
    if values.size < 2 or not abs(values[0]) < 2.0**53 or values[0] != round(values[0]):
        return False
    # The last number tells of most columns that they do not count, without the memory of all whole numbers.
    last = values[0] + values.size - 1
    return bool(values[-1] == last) and np.array_equal(values, values[0] + np.arange(values.size))
