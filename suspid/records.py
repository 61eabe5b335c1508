"""Records: files into `control.TimeResponseData`, and back."""

from __future__ import annotations

import contextlib
import csv
import importlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from suspid.delimited import read_delimited
from suspid.errors import RecordError
from suspid.files import printable, replacing
from suspid.matlab import read_matlab
from suspid.recordings import RawChannel, Recording
from suspid.signals import JITTER, as_response, as_signal, uniform_step
from suspid.tables import PER_SECOND, Clock, Table, is_time, split_unit
from suspid.units import Hertz, RealArray, Second

if TYPE_CHECKING:
    import control

# How far two clocks may differ and still be meant to be one; over a long record, half a sample at most.
CLOCK = 1e-4
# A rate stored in single precision, or as a rounded step, is still the same rate.
SAME_RATE = 1e-6
LEAST = 2

Reader: TypeAlias = Callable[[Path], Table]


def _module_reader(module: str) -> Reader:
    """Return ``read_<module>`` of a module of the library that is imported with the first file of its kind."""

    def read(path: Path) -> Table:
        table: Table = getattr(importlib.import_module(f"suspid.{module}"), f"read_{module}")(path)
        return table

    return read


READERS: dict[str, Reader] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), read_delimited),
    ".mat": read_matlab,
    **dict.fromkeys((".h5", ".hdf5"), _module_reader("hdf")),
    **dict.fromkeys((".parquet", ".pq"), _module_reader("parquet")),
    **dict.fromkeys((".uff", ".unv"), _module_reader("uff")),
    ".tdms": _module_reader("tdms"),
    **dict.fromkeys((".mf4", ".mdf"), _module_reader("mdf")),
    ".wav": _module_reader("wav"),
}
WRITTEN = (".csv", ".parquet", ".pq")


def read_recording(
    path: str | os.PathLike[str],
    *,
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    dbc: str | os.PathLike[str] | None = None,
) -> Recording:
    r"""Return what a file holds, channel by channel, with nothing repaired and nothing refused that can be.

    Parameters
    ----------
    path : str or path
        The file; its suffix says what it is.
    channels : sequence of str, optional
        Columns to take, by their names or by these without the unit. Default: all but time that have a clock
        or are as long as time.
    time : str, optional
        The column of time. Default: the clock of the channel, or the column named like a time (``t``,
        ``time [s]``, ``t_ms``, …). A unit in its name, or stated by the file, is obeyed.
    fs : float, optional
        Sampling rate [Hz] of the channels; they start at 0 where nothing in the file tells their time.
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.

    Raises
    ------
    RecordError
        If the file cannot be read as what its suffix says, a column is not there or holds text, or nothing
        tells the time. The message begins with the name of the file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "bump.csv")
    ...     _ = path.write_text("time [ms],seat [mm]\n0,0.0\n2,nan\n5,0.4\n")
    ...     recording = read_recording(path)
    >>> recording["seat [mm]"].unit, recording["seat [mm]"].timepts, recording["seat [mm]"].values
    ('mm', array([0.   , 0.002, 0.005]), array([0. , nan, 0.4]))
    """
    path = Path(path)
    try:
        table = _reader(path, dbc)(path)
        return _recording(table, [channels] if isinstance(channels, str) else channels, time, fs, title=path.stem)
    except RecordError as error:
        name = printable(str(path))
        message = str(error) if str(error).startswith(f"{name}: ") else f"{name}: {error}"
        raise RecordError(message) from None


def read_record(
    path: str | os.PathLike[str],
    *,
    channels: Sequence[str] | str | None = None,
    time: str | None = None,
    fs: Hertz | None = None,
    dbc: str | os.PathLike[str] | None = None,
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
    recording = read_recording(path, channels=channels, time=time, fs=fs, dbc=dbc)
    try:
        return _strict(recording)
    except RecordError as error:
        raise RecordError(f"{printable(str(path))}: {error}") from None


def write_record(
    response: control.TimeResponseData,
    path: str | os.PathLike[str],
    *,
    digits: int | None = None,
    units: Sequence[str] | None = None,
) -> None:
    """Write a record as CSV or Parquet: a column ``time [s]``, then the channels.

    Parameters
    ----------
    response : control.TimeResponseData
        One trace.
    path : str or path
        The file, ``.csv``, ``.parquet`` or ``.pq``. It is written under another name and renamed at the end.
    digits : int, optional
        Significant digits of the samples in CSV. Default: as many as bring every bit back; Parquet always does.
    units : sequence of str, optional
        Units by channel, empty where there is none: a row below the names in CSV, metadata in Parquet, where the
        title stands too.

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
    if units is not None and len(units) != len(signal.channels):
        raise RecordError(f"{len(units)} units for {len(signal.channels)} channels; give one for each, perhaps empty")
    parquet = Path(path).suffix.lower() != ".csv"
    if parquet and digits is not None:
        raise RecordError(f"{digits=} is for CSV; Parquet keeps every bit")
    for name in signal.channels:
        if not name or name != printable(name).strip() or is_time(name) or signal.channels.count(name) > 1:
            raise RecordError(
                f"channel {name!r} could not be read back under this name: it is empty, stands twice, reads like a "
                f"time, or holds control characters or outer spaces; rename it"
            )
    number = repr if digits is None else f"{{:.{digits}g}}".format
    timepts = np.asarray(response.time, float)
    if parquet:
        write: Callable[..., None] = importlib.import_module("suspid.parquet").write_parquet
        given = tuple(units or [""] * len(signal.channels))
        title = str(getattr(response, "title", None) or "")
        with replacing(path) as draft:
            write(draft, timepts, signal.values, signal.channels, units=given, title=title)
        return
    with replacing(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["time [s]", *signal.channels])
        if units is not None and any(units):
            writer.writerow(["s", *units])
        for t, row in zip(timepts.tolist(), signal.values.T.tolist(), strict=True):
            writer.writerow([repr(t), *map(number, row)])


def check_record_name(path: str | os.PathLike[str]) -> None:
    """Refuse a name under which `write_record` does not write."""
    if Path(path).suffix.lower() not in WRITTEN:
        raise RecordError(f"{printable(str(path))}: records are written as {', '.join(WRITTEN)}; choose such a name")


def _reader(path: Path, dbc: str | os.PathLike[str] | None) -> Reader:
    suffix = path.suffix.lower()
    if suffix not in READERS and not path.is_dir():
        raise RecordError(
            f"records of type {path.suffix!r} are not known; known: {', '.join(READERS)}; save it as one of them"
        )
    mdf = suffix in (".mf4", ".mdf") or (suffix == ".dat" and _starts_with(path, b"MDF"))
    if dbc is not None and not mdf:
        raise RecordError("dbc decodes CAN frames; only MDF files hold them: leave it out")
    if mdf and dbc is not None:
        return lambda file: importlib.import_module("suspid.mdf").read_mdf(file, dbc=dbc)
    return READERS[".mdf"] if mdf else READERS.get(suffix, read_delimited)


def _starts_with(path: Path, mark: bytes) -> bool:
    """Whether a file can be read and starts so."""
    try:
        with path.open("rb") as stream:
            return stream.read(len(mark)) == mark
    except (OSError, ValueError):
        return False


def _recording(
    table: Table, channels: Sequence[str] | None, time: str | None, fs: Hertz | None, *, title: str
) -> Recording:
    if fs is not None and not (np.isfinite(fs) and fs > 0):
        raise RecordError(f"{fs=} Hz must be positive and finite")
    channels = [table.full_name(name, what="channel") for name in channels or ()]
    time = None if time is None else table.full_name(time, what="time column")
    clocks = {} if time is not None else {name: table.clocks[name] for name in table.sizes if name in table.clocks}
    if time is None and not (channels and all(name in clocks for name in channels)):
        time = _time_column(table, channels, fs)
    # A clock of its own does not obey what is said of the others.
    rate = _rate(table, fs)
    names = channels or _all_channels(table, time, clocks, rate)
    followers = [name for name in names if name not in clocks]
    for name in names:
        if name == time or names.count(name) > 1:
            raise RecordError(f"column {name!r} is asked for twice")
    if followers and time is None and rate is None:
        raise RecordError(
            f"no column is named like a time: {', '.join(map(repr, table.sizes))}; name one (time), or give the "
            f"sampling rate (fs)"
        )
    for name in followers:
        reference = followers[0] if time is None else time
        if table.sizes[name] != table.sizes[reference]:
            raise RecordError(
                f"channel {name!r} has {table.sizes[name]} samples, {reference!r} has {table.sizes[reference]}"
            )
    stamps: RealArray | None = None
    if followers and time is not None:
        stamps = table.columns([time])[0] / _per_second(time, table.units.get(time, ""))
    elif followers:
        stamps = np.arange(table.sizes[followers[0]]) / (rate or 1.0)
    values = dict(zip(names, table.columns(names), strict=True))
    by_clock = {id(clock): _stamps(clock, table.sizes[name], fs) for name, clock in clocks.items() if name in names}
    raw = []
    for name in names:
        timepts = by_clock[id(clocks[name])] if name in clocks else stamps
        assert timepts is not None
        timepts.flags.writeable = False
        own = clocks[name].rate if name in clocks else rate
        raw.append(
            RawChannel(
                name=name,
                unit=table.units.get(name, ""),
                timepts=timepts,
                values=values[name],
                rate=own if own is not None else fs,
            )
        )
    others = [name for name in table.sizes if name not in names and name != time and not channels]
    left_out = {**table.unusable, **{name: _why_left_out(table, name, time) for name in others}}
    return Recording(title=table.title or title, channels=tuple(raw), left_out=tuple(left_out.items()))


def _stamps(clock: Clock, size: int, fs: Hertz | None) -> RealArray:
    """Return the stamps of a clock [s]."""
    if clock.stamps is not None:
        stamps = np.asarray(clock.stamps(), float)
        if stamps.size != size:
            raise RecordError(f"clock {clock.name!r} has {stamps.size} stamps for {size} samples")
        return stamps
    rate = clock.rate if clock.rate is not None else fs
    if rate is None:
        raise RecordError(f"nothing tells the rate of {clock.name!r}; give the sampling rate (fs)")
    if fs is not None and not abs(fs - rate) <= SAME_RATE * rate:
        raise RecordError(f"'fs' says {fs:g} Hz, {clock.name!r} in the file {rate:g} Hz; leave fs out")
    return np.asarray(clock.start + np.arange(size) / rate)


def _why_left_out(table: Table, name: str, time: str | None) -> str:
    if time is not None and table.sizes[name] != table.sizes[time]:
        return f"has {table.sizes[name]} samples, time {time!r} has {table.sizes[time]}"
    return "reads like a time"


def _strict(recording: Recording) -> control.TimeResponseData:
    """Return the record of channels that share one uniform clock and miss nothing."""
    first = recording.channels[0]
    for channel in recording.channels:
        if channel.timepts is not first.timepts:
            raise RecordError(
                f"channels {first.name!r} and {channel.name!r} have clocks of their own; name one of them"
            )
    if first.values.size < LEAST:
        raise RecordError(f"the record has {first.values.size} samples; at least {LEAST} are needed")
    timepts = _timepts(first.timepts, first.rate)
    values = np.array([channel.values for channel in recording.channels])
    response = as_response(timepts, values, recording.names, title=recording.title)
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


def _all_channels(table: Table, time: str | None, clocks: Mapping[str, Clock], rate: Hertz | None) -> list[str]:
    others = [name for name in table.sizes if name != time and name not in clocks]
    if time is not None:
        others = [name for name in others if table.sizes[name] == table.sizes[time]]
        if not others and not clocks:
            raise RecordError(f"there is no channel as long as time, {time!r}: {table.sizes[time]} samples")
    elif clocks and rate is None:
        others = []
    elif len({table.sizes[name] for name in others}) > 1:
        sizes = ", ".join(f"{name!r} {table.sizes[name]}" for name in others)
        raise RecordError(f"the vectors differ in length ({sizes}); say which are channels")
    return [name for name in table.sizes if name in clocks or name in others]


def _rate(table: Table, fs: Hertz | None) -> Hertz | None:
    """Return the rate that was given and the file states, which must be one."""
    rates = dict(table.rates) if fs is None else {"fs": fs, **table.rates}
    if not rates:
        return None
    given, rate = next(iter(rates.items()))
    for name, other in rates.items():
        if not abs(other - rate) <= SAME_RATE * rate:
            raise RecordError(f"{given!r} says {rate:g} Hz, {name!r} in the file {other:g} Hz; correct one of them")
    return rate


def _per_second(time: str, unit: str) -> float:
    unit = unit.strip().lower() or split_unit(time)[1]
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
