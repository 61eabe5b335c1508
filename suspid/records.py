"""Records: files into `control.TimeResponseData`, and back."""

from __future__ import annotations

import csv
import importlib
import os
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from suspid.cleaning import clean
from suspid.errors import RecordError, RecordWarning
from suspid.files import printable, replacing
from suspid.formats.delimited import read_delimited
from suspid.formats.matlab import read_matlab
from suspid.formats.signatures import HDF5, signature
from suspid.formats.tables import Table, is_time
from suspid.formats.timing import as_recording
from suspid.recordings import Recording
from suspid.signals import as_signal
from suspid.units import Hertz

if TYPE_CHECKING:
    import control

# What of a file was lost, and not merely passed over.
DAMAGE = ("is cut short", "is not UTF-8")

Reader: TypeAlias = Callable[[Path], Table]


def _module_reader(module: str) -> Reader:
    """Return ``read_<module>`` of a module of the library that is imported with the first file of its kind."""

    def read(path: Path) -> Table:
        table: Table = getattr(importlib.import_module(f"suspid.formats.{module}"), f"read_{module}")(path)
        return table

    return read


READERS: dict[str, Reader] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".log", ".asc"), read_delimited),
    ".mat": read_matlab,
    **dict.fromkeys((".h5", ".hdf5"), _module_reader("hdf")),
    **dict.fromkeys((".parquet", ".pq"), _module_reader("parquet")),
    **dict.fromkeys((".uff", ".unv", ".uf", ".58"), _module_reader("uff")),
    ".tdms": _module_reader("tdms"),
    **dict.fromkeys((".mf4", ".mdf"), _module_reader("mdf")),
    **dict.fromkeys((".wav", ".wave"), _module_reader("wav")),
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
        known, looks = signature(path)
        if known and _reader(path, None) is not READERS[known]:
            message += f"; it looks like {looks}: name it {known}"
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

    Its channels are read by `read_recording` and made sound by `suspid.cleaning.clean`; whatever was repaired,
    left out or merely met is told as a `RecordWarning`.

    Text (``.csv``, ``.txt``, ``.tsv``, ``.dat``, ``.log``, ``.asc``): a sample a line, in UTF-8, UTF-16 or
    Windows-1252. What parts the cells, the sign before decimals, header, units, and lines that are no samples are
    found out; without a header the columns are named ``column 1``, ``column 2`` …. MATLAB (``.mat``) and HDF5
    (``.h5``, ``.hdf5``): every real vector, and every column of a matrix, is a column, those of a structure by
    dotted names; a number named like ``Fs`` or ``dt`` is the rate. Further: Parquet (``.parquet``, ``.pq``),
    universal files (``.uff``, ``.unv``, ``.uf``, ``.58``), TDMS (``.tdms``), ASAM MDF (``.mf4``, ``.mdf``,
    ``.dat``), and WAV (``.wav``, ``.wave``); what some of them need is named where it is missing. A file of another
    name is read if its first bytes say what it is.

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
    dbc : str or path, optional
        Database that decodes the raw CAN frames of an MDF file.

    Returns
    -------
    control.TimeResponseData
        Outputs (channel, sample), in the units of the file, on a uniform clock.

    Raises
    ------
    RecordError
        If the file cannot be read as what its suffix says, a column is not there or holds text, time is not
        found or at odds with ``fs``, or what is wrong cannot be repaired safely. The message begins with the name
        of the file.

    Warns
    -----
    RecordWarning
        For each thing that was repaired, left out, or met in the record.

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
        cleaned = clean(recording, channels=None if channels is None else recording.names, fs=fs)
    except RecordError as error:
        raise RecordError(f"{printable(str(path))}: {error}") from None
    damaged = [f"{what} {why}" for what, why in recording.left_out if why.startswith(DAMAGE)]
    found = [f"{finding.channel or 'time'}: {finding.kind}: {finding.text}" for finding in cleaned.findings]
    for text in (*damaged, *found):
        warnings.warn(f"{printable(str(path))}: {printable(text)}", RecordWarning, stacklevel=2)
    return cleaned.record


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
        write: Callable[..., None] = importlib.import_module("suspid.formats.parquet").write_parquet
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
        known, looks = signature(path)
        if not known:
            raise RecordError(
                f"records of type {path.suffix!r} are not known; known: {', '.join(READERS)}; save it as one of them"
                f"{f'; it looks like {looks}' if looks else ''}"
            )
        # The marks of binary files leave no doubt.
        suffix = known
    # MATLAB v7.3 writes HDF5, below a page with its own head.
    if suffix == ".mat" and (_holds(path, HDF5, 0) or _holds(path, HDF5, 512)):
        return READERS[".h5"]
    mdf = suffix in (".mf4", ".mdf") or (suffix == ".dat" and _holds(path, b"MDF", 0))
    if dbc is not None and not mdf:
        raise RecordError("dbc decodes CAN frames; only MDF files hold them: leave it out")
    if mdf and dbc is not None:
        return lambda file: importlib.import_module("suspid.formats.mdf").read_mdf(file, dbc=dbc)
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
