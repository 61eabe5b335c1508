"""Arrays and tables in memory as records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from suspid.arguments import explained
from suspid.cleaning.conversions import to_si
from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.io import bracketed_unit, is_time, seconds_in
from suspid.recordings import Recording
from suspid.records import as_response
from suspid.signals import check_size, real_numbers, uniform_step
from suspid.units import Hertz, RealArray
from suspid.values import check_rate
from suspid.wording import Argument

if TYPE_CHECKING:
    import control
    from numpy.typing import ArrayLike

# What `as_record` takes: arrays, (time, samples), pandas and xarray objects, responses. Types are checked at run time:
# neither pandas nor xarray is needed.
RecordLike: TypeAlias = Any


@explained
def as_record(
    data: RecordLike,
    *,
    fs: Hertz | None = None,
    timepts: ArrayLike | None = None,
    channels: Sequence[str] | None = None,
    units: Sequence[str] | Mapping[str, str] | None = None,
) -> control.TimeResponseData:
    """Return arrays or a table as a record, the type of signal that every function takes.

    Functions that take a record call this themselves. Call it to add a sampling rate, names or
    units.

    Parameters
    ----------
    data : array_like (channel, sample) or (sample,), or a table
        Samples; a pair ``(timepts, samples)``; a pandas Series or DataFrame whose index, or a column named as a time,
        is the time; an xarray DataArray or Dataset with a dimension of time; or a control.TimeResponseData. Several
        traces, as of `control.impulse_response`, become channels named ``output_from_input``; inputs that
        move nothing are left out.
    fs : float, optional
        Sampling rate [Hz]; it replaces a time in the data.
    timepts : array_like (sample,), optional
        Time of each sample [s], uniform; it replaces a time in the data.
    channels : sequence of str, optional
        Names of the channels. Default: those of the table, or y[0], y[1], ….
    units : sequence of str or mapping of str to str, optional
        Unit of each channel in order, or of some by name; these are converted to SI. Default: the attribute ``units``
        of xarray; other samples stay as they are.

    Returns
    -------
    control.TimeResponseData
        One trace. A response is returned unchanged where nothing is to be done.

    Raises
    ------
    RecordError
        If the data has no time and no ``fs``, is complex or masked, has samples in rows instead of columns where their
        number is not known from the time, or time is irregular.
    InputError
        If a unit is not known.

    Examples
    --------
    >>> t = np.arange(0, 1, 0.01)
    >>> record = as_record(np.exp(-t) * np.sin(40 * t), fs=100, channels=["seat"], units=["mm"])
    >>> record.output_labels, len(record.time), float(record.time[1])
    (['seat'], 100, 0.01)
    >>> as_record(np.ones((2, 100)))
    Traceback (most recent call last):
    suspid.errors.RecordError: an array has no time: write as_record(data, fs=...) with the sampling rate in Hz...
    """
    if fs is not None and timepts is not None:
        raise RecordError("fs and timepts both state the time: give one of them")
    check_rate(fs)
    if _is_response(data) and np.ndim(data.y) == 2 and fs is None is timepts and channels is None is units:
        response: control.TimeResponseData = data
        samples = real_numbers(response.y, "the response")
        _check_sizes(response.output_labels or [f"y[{i}]" for i in range(len(samples))], response.time, samples)
        return response
    values, time, names = _parts(data, None if timepts is None else np.size(timepts), own_units=units is None)
    if channels is not None:
        if isinstance(channels, str) or len(channels) != len(values):
            raise RecordError(Argument("channels", f"{channels!r:.80}"), f" must name {len(values)} channels, in order")
        names = [str(name) for name in channels]
    if timepts is not None:
        time = _real(timepts, "timepts")
    if fs is not None:
        time = np.arange(values.shape[1]) / fs
    if time is None:
        raise RecordError(
            "an array has no time: write as_record(data, fs=...) with the sampling rate in Hz, or "
            "as_record((timepts, data)) with the time of each sample in s"
        )
    if time.ndim != 1 or time.size != values.shape[1]:
        raise RecordError(f"{time.size} time points, but {values.shape[1]} samples")
    if time.size > 1:
        uniform_step(time)
    values = _converted(values, names, units)
    _check_sizes(names, time, values)
    return as_response(time, values, names, title=str(getattr(data, "title", None) or ""))


def _check_sizes(names: Sequence[str], time: RealArray, values: RealArray) -> None:
    for name, samples in zip(names, values, strict=False):
        check_size(name, time, samples)


def _is_response(data: RecordLike) -> bool:
    return all(hasattr(data, name) for name in ("time", "y", "output_labels"))


def _parts(data: RecordLike, samples: int | None, *, own_units: bool) -> tuple[RealArray, RealArray | None, list[str]]:
    """Return samples (channel, sample), their time if it is known [s], and names; ``samples`` is their known number.

    With ``own_units`` those of xarray are in SI by the units that are stated in them.
    """
    if _is_response(data):
        return _of_response(data)
    package = type(data).__module__.partition(".")[0]
    if package == "pandas":
        return _of_pandas(data)
    if package == "xarray":
        return _of_xarray(data, samples, own_units=own_units)
    if isinstance(data, tuple) and len(data) == 2 and np.ndim(data[0]) == 1 and np.shape(data[0]) != ():
        values = _matrix(data[1], np.size(data[0]))
        return values, _real(data[0], "time"), _numbered(values)
    if isinstance(data, str) or hasattr(data, "__fspath__"):
        raise RecordError(f"{printable(str(data))!r:.80} is a path: read it with read_record, or pass it to analyse")
    if isinstance(data, Recording):
        raise RecordError("this is a recording as it was read: clean(recording).record is a record, analyse takes both")
    values = _matrix(data, samples)
    return values, None, _numbered(values)


def _of_response(data: RecordLike) -> tuple[RealArray, RealArray, list[str]]:
    values = _real(data.y, "the response")
    labels = list(data.output_labels or [f"y[{i}]" for i in range(len(values))])
    if values.ndim == 3:
        inputs = list(data.input_labels or [f"u[{i}]" for i in range(values.shape[1])])
        traces = list(getattr(data, "trace_labels", None) or inputs)
        if values.shape[1] > 1:
            # An input that moves nothing, such as the rate of the road under a tire without damping, is no test.
            moving = [k for k in range(values.shape[1]) if np.any(values[:, k])] or [*range(values.shape[1])]
            values, traces = values[:, moving], [traces[k] for k in moving]
            labels = [f"{label}_from_{_cause(trace)}" for label in labels for trace in traces]
        values = values.reshape(len(labels), -1)
    return values, np.asarray(data.time, float), labels


def _cause(trace: str) -> str:
    """Return the input that a trace is named after, as in "From u[0]"."""
    return trace.removeprefix("From ")


def _of_pandas(data: RecordLike) -> tuple[RealArray, RealArray | None, list[str]]:
    table = data if hasattr(data, "columns") else data.to_frame(name=data.name if data.name is not None else "y[0]")
    columns = {str(name): table[name] for name in table.columns}
    if len(columns) < table.shape[1]:
        raise RecordError(f"{table.shape[1]} columns, but {len(columns)} names: name every column once")
    time, used = _index_time(table.index), ""
    for name, column in columns.items():
        if (found := _column_time(name, column)) is not None:
            time, used = found, name
            break
    kept = {name: column for name, column in columns.items() if name != used}
    words = [name for name, column in kept.items() if column.dtype.kind not in "iufb"]
    if words:
        raise RecordError(
            f"columns without real numbers: {', '.join(map(repr, words[:3]))}; leave them out, as in "
            f"data.select_dtypes('number')"
        )
    return _matrix([column.to_numpy(float) for column in kept.values()]), time, list(kept)


def _index_time(index: RecordLike) -> RealArray | None:
    """Return the time that an index of pandas is [s]; None for one that counts the rows or contains no numbers."""
    if index.dtype.kind in "mM":
        return _elapsed(index.to_series())
    name = "" if index.name is None else str(index.name)
    if index.dtype.kind not in "iuf" or (not name and index.dtype.kind != "f"):
        return None
    stamps = np.asarray(index.to_numpy(), float)
    return stamps if not name else seconds_in(name, stamps)


def _column_time(name: str, column: RecordLike) -> RealArray | None:
    if column.dtype.kind in "mM":
        return _elapsed(column)
    return seconds_in(name, np.asarray(column.to_numpy(), float)) if column.dtype.kind in "iuf" else None


def _elapsed(stamps: RecordLike) -> RealArray:
    """Return the seconds since the first date, or those of durations."""
    # Whole nanoseconds: a date of our age in seconds has no more than 2e-7 s as a float.
    kind = "datetime64[ns]" if stamps.dtype.kind == "M" else "timedelta64[ns]"
    counts = np.asarray(stamps.to_numpy(), kind) if hasattr(stamps, "dims") else stamps.to_numpy(kind)
    whole = counts.astype(np.int64)
    return np.asarray((whole - whole[:1] if kind.startswith("date") else whole) / 1e9)


def _of_xarray(
    data: RecordLike, samples: int | None, *, own_units: bool
) -> tuple[RealArray, RealArray | None, list[str]]:
    arrays = {str(name): data[name] for name in data.data_vars} if hasattr(data, "data_vars") else {"": data}
    rows: list[RealArray] = []
    names: list[str] = []
    time: RealArray | None = None
    for name, array in arrays.items():
        along, time = _along_time(array, name or "the array", samples)
        others = [dim for dim in array.dims if dim != along]
        block = _matrix(array.transpose(*others, along).to_numpy(), samples)
        own = str(name or array.name or "y[0]")
        labels = [str(label) for label in array[others[0]].to_numpy()] if others else [own]
        rows.append(_by_attribute(block, array) if own_units else block)
        names += [f"{name}_{label}" if name and others else label for label in labels]
    if len({block.shape[1] for block in rows}) != 1:
        raise RecordError("the variables have different lengths: choose those of one rate")
    return np.concatenate(rows), time, names


def _along_time(array: RecordLike, what: str, samples: int | None) -> tuple[RecordLike, RealArray | None]:
    """Return the dimension of time of an array of xarray, and its coordinate [s]; None where it has none."""
    times = {}
    for dim in array.dims:
        if dim in array.coords:
            unit = str(array[dim].attrs.get("units", ""))
            named = f"{dim} [{unit}]" if unit and not bracketed_unit(str(dim)) else str(dim)
            times[dim] = _column_time(named, array[dim])
    stated = [dim for dim, time in times.items() if time is not None]
    if len(stated) == 1 and array.ndim <= 2:
        return stated[0], times[stated[0]]
    bare = [dim for dim in array.dims if is_time(str(dim)) or (samples and array.sizes[dim] == samples)]
    if stated or array.ndim not in (1, 2) or (array.ndim == 2 and len(bare) != 1):
        raise RecordError(f"{what} needs a dimension called time, and one more at most, as in data.rename(dim='time')")
    return (bare or array.dims)[0], None


def _by_attribute(values: RealArray, array: RecordLike) -> RealArray:
    """Return samples in SI units by the attribute "units" of an array of xarray, where that is a unit we know."""
    with suppress(InputError):
        return to_si(values, str(array.attrs.get("units", "")))[0]
    return values


def _matrix(data: RecordLike, samples: int | None = None) -> RealArray:
    """Return samples as (channel, sample); a column, and rows of a known number of samples, are turned."""
    values = np.atleast_2d(_real(data, "the data"))
    if values.ndim != 2:
        raise RecordError(f"the data has the shape {values.shape}; it must be (sample,) or (channel, sample)")
    if not values.size:
        raise RecordError(f"the data has the shape {values.shape}: it contains no samples")
    if values.shape[1] == 1 or (samples == len(values) and samples != values.shape[1]):
        values = np.ascontiguousarray(values.T)
    if len(values) > values.shape[1]:
        raise RecordError(
            f"the data has the shape {values.shape}: rows are channels, as in python-control; else pass data.T"
        )
    return values


def _real(data: RecordLike, what: str) -> RealArray:
    return np.array(real_numbers(data, what))


def _numbered(values: RealArray) -> list[str]:
    return [f"y[{i}]" for i in range(len(values))]


def _converted(values: RealArray, names: Sequence[str], units: Sequence[str] | Mapping[str, str] | None) -> RealArray:
    """Return the samples in SI units."""
    if units is None:
        return values
    if not isinstance(units, Mapping):
        if isinstance(units, str) or len(units) != len(names):
            raise RecordError(f"units={units!r:.80} must state the unit of each of {len(names)} channels, or map names")
        # In order: two channels of one name may have different units.
        return np.array([to_si(row, unit)[0] for row, unit in zip(values, units, strict=True)])
    unknown = sorted(set(units) - set(names))
    if unknown:
        raise RecordError(f"units of {unknown[0]!r}: there is no such channel; the channels are {', '.join(names)}")
    rows = zip(names, values, strict=True)
    return np.array([to_si(row, units[name])[0] if name in units else row for name, row in rows])
