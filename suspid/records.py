"""Records: files into `control.TimeResponseData`, and back."""

from __future__ import annotations

import contextlib
import csv
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, replacing
from suspid.matlab import read_matlab
from suspid.signals import JITTER, as_response, as_signal, uniform_step
from suspid.tables import PER_SECOND, Table, is_time, read_delimited, split_unit
from suspid.units import Hertz, RealArray, Second

if TYPE_CHECKING:
    import control

# How far two clocks may differ and still be meant to be one; over a long record, half a sample at most.
CLOCK = 1e-4

READERS: dict[str, Callable[[Path], Table]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv"), read_delimited),
    ".mat": read_matlab,
}


def read_record(
    path: str | os.PathLike[str],
    *,
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
) -> control.TimeResponseData:
    r"""Return the record that a file holds.

    Text (``.csv``, ``.txt``, ``.tsv``): one sample a line, comma, semicolon or tab between the cells,
    UTF-8. Without a header the columns are named ``column 1``, ``column 2`` …. MATLAB up to v7
    (``.mat``): every real vector is a column; a scalar named like ``Fs`` or ``dt`` is the rate.

    Parameters
    ----------
    path : str or path
        The file; its suffix says what it is.
    channels : sequence of str, optional
        Columns to take. Default: all but time that are as long as time.
    time : str, optional
        The column of time. Default: the one named like a time (``t``, ``time [s]``, ``t_ms``, …).
        A unit in its name is obeyed: the response is in seconds.
    fs : float, optional
        Sampling rate [Hz]. Without a column of time, the record starts at 0. Beside one, the stamps must
        agree with it to within their own rounding; the grid of ``fs`` then stands in for them.

    Returns
    -------
    control.TimeResponseData
        Outputs (channel, sample), in the units of the file; no sample is changed.

    Raises
    ------
    RecordError
        If the file cannot be read as what its suffix says, a column is not there or holds text,
        time is not found, irregular or at odds with ``fs``, or a sample is not finite. The message
        begins with the name of the file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.csv")
    ...     _ = path.write_text("time [ms],seat,chassis\n0,0.0,1.0\n2,0.5,0.8\n4,0.4,0.6\n")
    ...     record = read_record(path, channels=["chassis"])
    >>> record.time
    array([0.   , 0.002, 0.004])
    >>> record.output_labels, record.y
    (['chassis'], array([[1. , 0.8, 0.6]]))
    """
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None and not path.is_dir():
        raise RecordError(
            f"{printable(str(path))}: records of type {path.suffix!r} are not known; "
            f"known: {', '.join(READERS)}; save it as one of them"
        )
    try:
        table = (reader or read_delimited)(path)
        return _record(table, [channels] if isinstance(channels, str) else channels, time, fs, title=path.stem)
    except RecordError as error:
        name = printable(str(path))
        message = str(error) if str(error).startswith(f"{name}: ") else f"{name}: {error}"
        raise RecordError(message) from None


def write_record(
    response: control.TimeResponseData, path: str | os.PathLike[str], *, digits: int | None = None
) -> None:
    """Write a record as CSV: a column ``time [s]``, then the channels.

    Parameters
    ----------
    response : control.TimeResponseData
        One trace.
    path : str or path
        The file, ``.csv``. It is written under another name and renamed at the end.
    digits : int, optional
        Significant digits of the samples. Default: as many as bring every bit back.

    Raises
    ------
    RecordError
        If the record is refused by `as_signal`, or the name of a channel would not come back.
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from suspid import free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> decay = free_decay(car, np.arange(0, 1, 0.01), initial_state={"v_tire": 1.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_record(decay, Path(folder, "decay.csv"))
    ...     same = read_record(Path(folder, "decay.csv"))
    >>> bool(np.all(same.y == decay.y) and np.all(same.time == decay.time))
    True
    """
    check_record_name(path)
    if digits is not None and not 1 <= digits <= 17:
        raise RecordError(f"{digits=} must lie between 1 and 17, or be None for every bit")
    signal = as_signal(response)
    for name in signal.channels:
        if not name or name != printable(name).strip() or is_time(name) or signal.channels.count(name) > 1:
            raise RecordError(
                f"channel {name!r} could not be read back under this name: it is empty, stands twice, reads like a "
                f"time, or holds control characters or outer spaces; rename it"
            )
    number = repr if digits is None else f"{{:.{digits}g}}".format
    with replacing(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["time [s]", *signal.channels])
        for t, row in zip(np.asarray(response.time, float).tolist(), signal.values.T.tolist(), strict=True):
            writer.writerow([repr(t), *map(number, row)])


def check_record_name(path: str | os.PathLike[str]) -> None:
    """Refuse a name under which `write_record` does not write."""
    if Path(path).suffix.lower() != ".csv":
        raise RecordError(f"{printable(str(path))}: records are written as .csv; choose such a name")


def _record(
    table: Table, channels: Sequence[str] | None, time: str | None, fs: Hertz | None, *, title: str
) -> control.TimeResponseData:
    if fs is not None and not (np.isfinite(fs) and fs > 0):
        raise RecordError(f"{fs=} Hz must be positive and finite")
    for name in channels or ():
        table.check(name, what="channel")
    if time is not None:
        table.check(time, what="time column")
    time = _time_column(table, channels or (), fs) if time is None else time
    rate = _rate(table, fs)
    if time is None and rate is None:
        raise RecordError(
            f"no column is named like a time: {', '.join(map(repr, table.sizes))}; name one (time), or give the "
            f"sampling rate (fs)"
        )
    names = list(channels) if channels else _all_channels(table, time)
    for name in names:
        if name == time or names.count(name) > 1:
            raise RecordError(f"column {name!r} is asked for twice")
        reference = names[0] if time is None else time
        if table.sizes[name] != table.sizes[reference]:
            raise RecordError(
                f"channel {name!r} has {table.sizes[name]} samples, {reference!r} has {table.sizes[reference]}"
            )
    if time is None:
        values = table.columns(names)
        timepts = np.arange(values[0].size) / (rate or 1.0)
    else:
        stamps, *values = table.columns([time, *names])
        timepts = _timepts(stamps / _per_second(time), rate)
    response = as_response(timepts, np.array(values), names, title=title)
    as_signal(response)
    return response


def _time_column(table: Table, channels: Sequence[str], fs: Hertz | None) -> str | None:
    candidates = [name for name in table.sizes if is_time(name) and name not in channels]
    if len(candidates) > 1 and len({table.sizes[c] for c in channels}) == 1:
        # Vectors of another length are another record's time.
        candidates = [name for name in candidates if table.sizes[name] == table.sizes[channels[0]]]
    if len(candidates) > 1:
        also = "" if fs is None else ", even beside fs: it must agree"
        raise RecordError(f"{', '.join(map(repr, candidates))} all read like a time; name one (time){also}")
    return candidates[0] if candidates else None


def _all_channels(table: Table, time: str | None) -> list[str]:
    others = [name for name in table.sizes if name != time]
    if time is not None:
        others = [name for name in others if table.sizes[name] == table.sizes[time]]
        if not others:
            raise RecordError(f"there is no channel as long as time, {time!r}: {table.sizes[time]} samples")
    elif len(set(table.sizes.values())) > 1:
        sizes = ", ".join(f"{name!r} {size}" for name, size in table.sizes.items())
        raise RecordError(f"the vectors differ in length ({sizes}); say which are channels")
    return others


def _rate(table: Table, fs: Hertz | None) -> Hertz | None:
    """Return the rate that was given and the file states, which must be one."""
    rates = dict(table.rates) if fs is None else {"fs": fs, **table.rates}
    if not rates:
        return None
    given, rate = next(iter(rates.items()))
    for name, other in rates.items():
        # A rate stored in single precision, or as a rounded step, is still the same rate.
        if not abs(other - rate) <= 1e-6 * rate:
            raise RecordError(f"{given!r} says {rate:g} Hz, {name!r} in the file {other:g} Hz; correct one of them")
    return rate


def _per_second(time: str) -> float:
    _, unit = split_unit(time)
    if unit and unit not in PER_SECOND:
        raise RecordError(f"the unit of time in {time!r} is not known; known: s, ms, us, ns, min; or give fs alone")
    return PER_SECOND[unit or "s"]


def _timepts(stamps: RealArray, rate: Hertz | None) -> RealArray:
    """Return the stamps or, where the rate is known and agrees, the uniform grid that they round."""
    if rate is None or not np.all(np.isfinite(stamps)):
        return stamps
    grid = np.asarray(stamps[0] + np.arange(stamps.size) / rate)
    off = np.abs(stamps - grid)
    allowed = JITTER / rate + _rounding(stamps) + np.minimum(0.5 / rate, CLOCK * np.abs(grid - grid[0]))
    if np.any(off > allowed):
        worst = int(np.argmax(off - allowed))
        span = float(stamps[-1] - stamps[0])
        mean = f"{(stamps.size - 1) / span:.9g} Hz on average" if span > 0 else "backwards"
        raise RecordError(
            f"fs = {rate:.9g} Hz and the column of time disagree: the stamps run at {mean}, and "
            f"stamp {worst + 1}, {stamps[worst]:.9g} s, lies {off[worst] * rate:.3g} samples off"
        )
    return grid


def _rounding(stamps: RealArray) -> Second:
    """Return the decimal, or the single precision, to which irregular stamps are rounded; 0 for regular ones [s]."""
    with contextlib.suppress(RecordError):
        uniform_step(stamps)
        return 0.0
    largest = float(np.max(np.abs(stamps)))
    places = next((k for k in range(10) if np.allclose(stamps, np.round(stamps, k), rtol=0, atol=1e-10)), 10)
    with np.errstate(over="ignore"):
        single = bool(np.all(stamps == stamps.astype(np.float32)))
    return max(10.0**-places, float(np.spacing(np.float32(largest))) if single else 0.0)
