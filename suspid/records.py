"""Records: files into `control.TimeResponseData`, and back."""

from __future__ import annotations

import contextlib
import csv
import importlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from suspid.delimited import read_delimited
from suspid.errors import RecordError
from suspid.files import printable, replacing
from suspid.matlab import read_matlab
from suspid.recordings import Recording
from suspid.signals import JITTER, as_response, as_signal, uniform_step
from suspid.tables import Table, is_time
from suspid.timing import as_recording
from suspid.units import Hertz, RealArray, Second

if TYPE_CHECKING:
    import control

# How far two clocks may differ and still be meant to be one; over a long record, half a sample at most.
CLOCK = 1e-4
LEAST = 2
HDF5 = b"\x89HDF\r\n\x1a\n"

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
        wanted = [channels] if isinstance(channels, str) else channels
        return as_recording(table, channels=wanted, time=time, fs=fs, title=path.stem)
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
    # MATLAB v7.3 writes HDF5, below a page with its own head.
    if suffix == ".mat" and (_holds(path, HDF5, 0) or _holds(path, HDF5, 512)):
        return READERS[".h5"]
    mdf = suffix in (".mf4", ".mdf") or (suffix == ".dat" and _holds(path, b"MDF", 0))
    if dbc is not None and not mdf:
        raise RecordError("dbc decodes CAN frames; only MDF files hold them: leave it out")
    if mdf and dbc is not None:
        return lambda file: importlib.import_module("suspid.mdf").read_mdf(file, dbc=dbc)
    return READERS[".mdf"] if mdf else READERS.get(suffix, read_delimited)


def _holds(path: Path, mark: bytes, position: int) -> bool:
    """Whether a file can be read and holds a mark at a position."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as stream:
            stream.seek(position)
            return stream.read(len(mark)) == mark
    except (OSError, ValueError):
        return False


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
