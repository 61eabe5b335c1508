"""Units of time columns, stated or seen in their stamps."""

from __future__ import annotations

import re
import warnings
from typing import cast

import numpy as np

from suspid.errors import RecordError, RecordWarning
from suspid.io.clock_digits import seconds_of_digits
from suspid.io.names import (
    KNOWN_UNITS,
    PER_SECOND,
    TIME_NAMES,
    bracketed_unit,
    is_time,
    is_time_in_unknown_unit,
    may_be_time,
    split_unit,
)
from suspid.io.tables import Table
from suspid.levels import FEWEST_SAMPLES
from suspid.stamps import continued
from suspid.units import Hertz, RealArray
from suspid.wording import Argument
from suspid.words import LeftOut, Remark, rates_of_units

# Units of quantities that are no time.
UNIT_OF_ELSE = re.compile(r"(?:[kcmµμu]?m|in|ft|deg|°|rad|V|mV|A|N|kN|m/s\^?2?|m/s²|g|km/h|rpm|1/min)")
# Fewer stamps show neither their unit nor that they are a clock's.
FEW_STAMPS = 8
# Least size of a stamp since 1970, by its unit: present ones are near 1.7e12 ms, 1.7e15 us and 1.7e18 ns.
EPOCHS = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))
# Sizes of ticks of 100 ns, of the years 1980 to 2080, since the years 1601 and 1: as ns since 1970 they would be of the
# years 1973, 1974 or about 1990, before any logger wrote ns.
TICKS_SINCE = ((1.195e17, 1.515e17), (6.24e17, 6.57e17))
# Usual step from which on stamps without a unit are in the next finer one [s]: as seconds, Nyquist's limit would be
# 1 Hz, below the modes of any suspension on its road wheels.
SLOWEST_STEP = 0.5
# Below this step [s] in a record shorter than this [s], a stated unit is doubted: no logger of a car is so fast, and no
# decay so short.
FASTEST_STEP, SHORT_RECORD = 1.5e-5, 1.0
# Shorter steps [s] in such a record, without a unit, are those of minutes at 33 Hz and more as well.
MINUTE_STEP = 5e-4
# Whole numbers in steps of at most this many ms are no us: a board that counts us samples below 50 kHz.
SURE_STEP = 20.0
# A record that is shorter [s] in the unit that would be guessed is that of another unit as likely.
SHORTEST_GUESS = 0.15
# A rate that is given agrees with that of stamps in a unit within this: their usual step is not their mean step.
NEAR_RATE = 0.1
# Steps below this, of whole numbers, are rounded by too much to tell a missing row.
ROUNDED_BELOW = 10.0
# Calls from the line that has a table to the column of its time: a warning shows that line.
CALLS_TO_HERE = 7
# Days since 1900 of the years 1982 to 2091 as spreadsheets count them, since the year 0 as MATLAB does, and the Julian
# ones. In seconds, steps below the largest would be sampled faster than 5 kHz, hours after the start.
DAYS, DAY_STEP = ((30_000.0, 70_000.0), (724_000.0, 754_000.0), (2_444_000.0, 2_484_000.0)), 2e-4


def time_unit(table: Table, time: str) -> str:
    """Return the unit of a column of time in lower case, as stated or in its name; empty if there is none."""
    stem, own = split_unit(time)
    unit = table.units.get(time, "").strip().lower() or own
    # Programs that write the unit of a channel behind the name of its time as well mean seconds.
    return unit if unit in PER_SECOND or stem in TIME_NAMES else ""


def unit_of_else(table: Table, name: str) -> str:
    """Return the unit of a column, as stated or in its name, where it is one of a quantity that is no time."""
    unit = table.units.get(name, "").strip() or bracketed_unit(name)
    return unit if UNIT_OF_ELSE.fullmatch(unit) else ""


def in_seconds(table: Table, time: str, stamps: RealArray) -> RealArray:
    """Return the numbers of a column of time in seconds."""
    unit = time_unit(table, time)
    other = "" if unit or may_be_time(time) else unit_of_else(table, time)
    if other:
        raise RecordError(f"{time!r} is in {other!r}, which is no unit of time; known: {KNOWN_UNITS}")
    of_digits = None if unit else seconds_of_digits(stamps)
    if of_digits is not None:
        return of_digits
    unit = unit or epoch_unit(stamps)
    if unit not in PER_SECOND:
        raise RecordError(unknown_unit(time))
    return np.asarray(stamps / PER_SECOND[unit])


def seconds_in(name: str, stamps: RealArray) -> RealArray | None:
    """Return stamps in seconds by the unit in their name; None where the name is not one of a time.

    Examples
    --------
    >>> seconds_in("time [ms]", np.array([0.0, 5.0])), seconds_in("seat", np.array([0.0]))
    (array([0.   , 0.005]), None)
    """
    if is_time_in_unknown_unit(name):
        raise RecordError(unknown_unit(name))
    if not is_time(name):
        return None
    unit, said = split_unit(name)[1], unit_remark(stamps)
    if not unit and said is not None and said.code is LeftOut.FINER_UNIT:
        step, finer = said.numbers["step"], said.numbers["unit"]
        raise RecordError(
            f"the unit of {name!r} is not stated, and steps of {step:.4g} s are too slow for a suspension; call it "
            f"'{name} [{finer}]', or '{name} [s]' if they are meant"
        )
    if not unit and said is not None and said.code is LeftOut.SHORT_SECONDS:
        length, rate = said.numbers["length"], said.numbers["rate"]
        warnings.warn(
            f"the unit of {name!r} is not stated; taken as s: {length:.2g} s at {rate:.6g} Hz; call it '{name} [s]', "
            f"or '{name} [min]' if it is in minutes",
            RecordWarning,
            stacklevel=CALLS_TO_HERE,
        )
    unit = unit or epoch_unit(stamps)
    return np.asarray(stamps / PER_SECOND[unit])


def unknown_unit(time: str) -> str:
    """Return what is wrong with a column of time in an unknown unit."""
    ignoring = f"ignore it and give {Argument('fs')}"
    return f"the unit of time in {time!r} is not known; known: {KNOWN_UNITS}; rename it, or {ignoring}"


def epoch_unit(stamps: RealArray) -> str:
    """Return the unit of stamps without one: s, unless that would be a year beyond 4000, or a date in days or ticks.

    The median is compared, so that single wrong stamps do not count.
    """
    sizes = np.abs(stamps[np.isfinite(stamps)])
    size = float(np.median(sizes)) if sizes.size else 0.0
    if any(low < size < high for low, high in DAYS) and np.ptp(sizes) < DAY_STEP * (sizes.size - 1):
        return "days"
    if any(low < size < high for low, high in TICKS_SINCE):
        return "100ns"
    return next((name for name, least in EPOCHS if size > least), "s")


def too_fine(unit: str, stamps: RealArray) -> Remark | None:
    """Return what a stated unit of time makes of stamps that are likely seconds; None where it may be right.

    Examples
    --------
    >>> rows = np.arange(9000.0)
    >>> [too_fine(unit, step * rows) is not None for unit, step in (("ms", 0.008), ("ms", 1.0), ("s", 8e-6))]
    [True, False, False]
    """
    if not PER_SECOND.get(unit, 0.0) > 1:
        return None
    known = np.sort(stamps[np.isfinite(stamps)])
    if known.size < FEW_STAMPS:
        return None
    length, step = float(known[-1] - known[0]), float(np.median(np.diff(known)))
    stated = PER_SECOND[unit]
    fast = 0 < step < FASTEST_STEP * stated and length < SHORT_RECORD * stated
    if not fast or step > SLOWEST_STEP or length < SHORT_RECORD:
        return None
    rate = (known.size - 1) / length
    return Remark(LeftOut.TOO_FINE, {"unit": unit, "step": step / stated, "length": length / stated, "rate": rate})


def unit_remark(stamps: RealArray) -> Remark | None:
    """Return why stamps without a unit are taken for one that is not seconds, or doubted; None where they are seconds.

    Examples
    --------
    >>> rows = np.arange(100.0)
    >>> [str(unit_remark(step * rows))[:29] for step in (0.005, 2.5, 1872)]
    ['None', 'is not stated; taken as ms: s', 'is not stated; taken as us: s']
    >>> print(unit_remark(rows / 200 / 60))
    is not stated; taken as s: 0.0083 s at 12000 Hz; give fs=200 if they are min
    """
    if seconds_of_digits(stamps) is not None:
        return Remark(LeftOut.OF_DIGITS)
    unit = epoch_unit(stamps)
    if unit != "s":
        return Remark({"days": LeftOut.DAYS, "100ns": LeftOut.TICKS}.get(unit, LeftOut.EPOCH), {"unit": unit})
    known = continued(stamps[np.isfinite(stamps)])[0]
    with np.errstate(over="ignore"):
        step = float(np.median(np.diff(known))) if known.size >= FEW_STAMPS else 0.0
    pace = _pace(known, step) if step > 0 else 0.0
    finer = next((unit for unit in ("s", "ms", "us") if step < SLOWEST_STEP * PER_SECOND[unit]), "ns")
    if finer != "s":
        others = _other_units(finer, step, whole=bool(np.all(known % 1 == 0)))
        rates = tuple(PER_SECOND[unit] / pace for unit in (finer, *others))
        span = float(np.ptp(known)) / PER_SECOND[finer]
        return Remark(
            LeftOut.FINER_UNIT, {"unit": finer, "step": step, "others": others, "rates": rates, "length": span}
        )
    length = float(np.ptp(known)) if 0 < step < MINUTE_STEP else SHORT_RECORD
    return Remark(LeftOut.SHORT_SECONDS, {"length": length, "rate": 1 / pace}) if length < SHORT_RECORD else None


def _pace(stamps: RealArray, step: float) -> float:
    """Return the mean step of stamps, whose usual step may be rounded or jitter, without those where rows are missing.

    Examples
    --------
    >>> rows = np.delete(20022.3 * np.arange(400.0), range(60, 390, 11)).round()
    >>> round(_pace(rows, 20022.0), 1), round(_pace((np.arange(400.0) / 0.93).round(), 1.0), 2)
    (20022.3, 1.08)
    """
    steps = np.diff(stamps)
    # Where whole numbers are near to the step, a step of two is no missing row.
    rows = np.sum(np.maximum(np.round(steps / step), 0)) if step > ROUNDED_BELOW else steps.size
    mean = float(np.ptp(stamps)) / max(float(rows), 1.0)
    return mean if abs(mean / step - 1) < NEAR_RATE else step


def _other_units(unit: str, step: float, *, whole: bool) -> tuple[str, ...]:
    """Return the units that stamps without one, taken as a unit finer than s, may be in as well.

    Clocks count in whole ms or us; numbers with decimals may as well be s, and steps of 1 may count the rows. Those of
    a slow logger in ms look like us, and so do those of a telephone or an oscilloscope in ns.

    Examples
    --------
    >>> [_other_units("ms", step, whole=step % 1 == 0) for step in (5.0, 1.0, 1.25, 64.0, 26.4)]
    [(), ('s',), ('s',), ('us',), ('us', 's')]
    >>> [_other_units("us", step, whole=True) for step in (1872.0, 2e5)]
    [('ms',), ('ms', 'ns')]
    """
    if unit == "us":
        return ("ms", *(("ns",) if step > 1000 * SURE_STEP else ()))
    if unit == "ns":
        return ("us",)
    return ("us",) * (step > SURE_STEP) + ("s",) * (not whole or step == 1)


def guessed_unit(time: str, stamps: RealArray, fs: Hertz | None) -> tuple[str, Remark | None]:
    """Return the unit that stamps without one are taken in beyond that of their size, and what is said of it.

    A rate that is given says which of the units it is that they may be in. Where none is, a guess is refused that makes
    no sense either: the record would be too short, unless few rows may be counted.

    Examples
    --------
    >>> stamps = 510 * np.arange(200.0)
    >>> guessed_unit("time", stamps, 1.96)
    ('ms', None)
    >>> guessed_unit("time", stamps, None)
    Traceback (most recent call last):
    suspid.errors.RecordError: the unit of 'time' is not stated; if it is us, the record is only 0.101 s long: give ...
    """
    said = unit_remark(stamps)
    if said is None or said.code is not LeftOut.FINER_UNIT:
        return "s", said
    unit, others = str(said.numbers["unit"]), cast("tuple[str, ...]", said.numbers["others"])
    rates, length = cast("tuple[float, ...]", said.numbers["rates"]), cast("float", said.numbers["length"])
    agreeing = [own for own, rate in zip((unit, *others), rates, strict=True) if fs and abs(fs / rate - 1) < NEAR_RATE]
    if agreeing:
        return agreeing[0], None
    if fs is None and others and length < SHORTEST_GUESS and said.numbers["step"] != 1:
        few = f"; it has {len(stamps)} samples, and modes need {FEWEST_SAMPLES}" if len(stamps) < FEWEST_SAMPLES else ""
        raise RecordError(
            f"the unit of {time!r} is not stated; if it is {unit}, the record is only {length:.3g} s long: give "
            f"{rates_of_units(said.numbers)}{few}"
        )
    return unit, said


def runs_beside(first: RealArray, second: RealArray, most: float) -> bool:
    """Return whether two columns of time run alike but for their start, with at most ``most`` between them.

    One may end before the other, after more than half of it.

    Examples
    --------
    >>> clock = np.array([0.0, 1.0, 2.0])
    >>> runs_beside(clock, clock + 60.1, 0.5), runs_beside(clock, 2 * clock, 0.5)
    (True, False)
    """
    apart = np.abs((first - first[:1]) - (second - second[:1]))
    known = np.isfinite(apart)
    return bool(2 * np.count_nonzero(known) > known.size and np.all(apart[known] <= most))


def late_by(first: RealArray, second: RealArray) -> dict[str, float]:
    """Return by how much a second column of time runs behind the first, if by at most ten samples; else nothing.

    Examples
    --------
    >>> clock = np.array([0.0, 1.0, 2.0])
    >>> late_by(clock, clock + 0.25), late_by(clock, clock + 60)
    ({'late': 0.25}, {})
    """
    with np.errstate(invalid="ignore"):
        late = float(np.nanmedian(second - first))
        step = float(np.nanmedian(np.abs(np.diff(first))))
    return {"late": late} if 0.01 * step < abs(late) < 10 * step else {}
