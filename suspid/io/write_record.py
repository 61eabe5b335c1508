"""Write a record as CSV or Parquet."""

from __future__ import annotations

import csv
import importlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import RecordError
from suspid.files import printable, replacing
from suspid.io.names import is_time
from suspid.records import inputs_of
from suspid.signals import as_signal

if TYPE_CHECKING:
    import control

WRITTEN = (".csv", ".parquet", ".pq")


@explained
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
        Significant digits of the samples in CSV. Default: all, so that nothing is lost; Parquet never loses any.
    units : sequence of str, optional
        Units by channel and input, empty where there is none: a row below the names in CSV, metadata in Parquet, as
        is the title.

    Raises
    ------
    RecordError
        If `as_signal` refuses the record, or a name of a channel could not be read back.
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from suspid import free_decay, quarter_car, read_record
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
    signal, causes = as_signal(response), inputs_of(response)
    signal = replace(signal, values=np.vstack([signal.values, *causes.values()]), channels=(*signal.channels, *causes))
    if units is not None and len(units) != len(signal.channels):
        raise RecordError(f"{len(units)} units for {len(signal.channels)} channels; give one for each, perhaps empty")
    parquet = Path(path).suffix.lower() != ".csv"
    if parquet and digits is not None:
        raise RecordError(f"{digits=} is for CSV; Parquet keeps every bit")
    for name in signal.channels:
        if not name or name != printable(name).strip() or is_time(name) or signal.channels.count(name) > 1:
            raise RecordError(
                f"channel {name!r} could not be read back under this name: it is empty, occurs twice, reads like a "
                f"time, or holds control characters or outer spaces; rename it"
            )
    number = repr if digits is None else f"{{:.{digits}g}}".format
    timepts = np.asarray(response.time, float)
    if parquet:
        write: Callable[..., None] = importlib.import_module("suspid.io.parquet").write_parquet
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
        error = RecordError(f"records are written as {', '.join(WRITTEN)}; choose such a name")
        raise error.about(printable(str(path)))
