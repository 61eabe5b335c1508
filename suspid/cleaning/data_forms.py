"""Forms of data in memory: arrays, responses, tables of pandas and arrays of xarray, each with its time and names."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from suspid.cleaning.conversions import converted, si_unit
from suspid.cleaning.not_samples import check_samples
from suspid.cleaning.times_of_day import elapsed
from suspid.errors import RecordError
from suspid.io import bracketed_unit, is_time, seconds_in
from suspid.signals import real_numbers
from suspid.units import RealArray
from suspid.values import listed
from suspid.wording import Argument

# What `as_record` takes: arrays, (time, samples), pandas and xarray objects, responses. Types are checked at run time:
# neither pandas nor xarray is needed.
RecordLike: TypeAlias = Any


def is_response(data: RecordLike) -> bool:
    """Return whether data is a response of python-control."""
    return all(hasattr(data, name) for name in ("time", "y", "output_labels"))


def is_pair(data: RecordLike) -> bool:
    """Return whether data is a pair of time points and samples."""
    return isinstance(data, tuple) and len(data) == 2 and not is_response(data[0]) and _is_vector(data[0])


def _is_vector(data: RecordLike) -> bool:
    """Return whether an array is a vector, or a row or column, which MATLAB writes instead."""
    return np.ndim(data) == 1 or (np.ndim(data) == 2 and 1 in np.shape(data))


def samples_of(
    data: RecordLike, samples: int | None, *, own_units: bool
) -> tuple[RealArray, RealArray | None, list[str]]:
    """Return samples (channel, sample), their time if it is known [s], and names; ``samples`` is their known number.

    With ``own_units`` those of xarray are in SI by the units that are stated in them.
    """
    if is_response(data):
        return _of_response(data)
    package = type(data).__module__.partition(".")[0]
    if package == "pandas" and hasattr(data, "index"):
        return _of_pandas(data)
    if package == "pandas":
        try:
            data = data.to_numpy(float, na_value=np.nan)
        except (TypeError, ValueError):
            raise RecordError(f"an array of pandas of type {data.dtype} has no numbers; convert it") from None
    if package in ("polars", "pyarrow") and hasattr(data, "to_pandas"):
        return samples_of(_in_pandas(data, package), samples, own_units=own_units)
    if package == "xarray":
        return _of_xarray(data, samples, own_units=own_units)
    if isinstance(data, list | tuple) and len(data) and all(map(is_response, data)):
        raise RecordError(f"{len(data)} responses: pass one of them, or all to identify_repeats")
    check_samples(data)
    if is_pair(data):
        values = _matrix(data[1], np.size(data[0]))
        return values, time_samples(data[0], "time"), _numbered(values)
    values = _matrix(data, samples)
    return values, None, _numbered(values)


def _in_pandas(data: RecordLike, package: str) -> RecordLike:
    """Return a table of another package as one of pandas."""
    try:
        return data.to_pandas()
    except ImportError as missing:
        raise RecordError(f"tables of {package} are read by way of pandas: {missing}") from None


def _of_response(data: RecordLike) -> tuple[RealArray, RealArray, list[str]]:
    values = real_samples(data.y, "the response")
    labels = list(data.output_labels or [f"y[{i}]" for i in range(len(values))])
    if values.ndim == 3:
        inputs = list(data.input_labels or [f"u[{i}]" for i in range(values.shape[1])])
        traces = list(getattr(data, "trace_labels", None) or inputs)
        if values.shape[1] > 1:
            # An input that moves nothing, such as the rate of the road under a tire without damping, is no test.
            moving = [k for k in range(values.shape[1]) if np.any(values[:, k])] or [*range(values.shape[1])]
            values, traces = values[:, moving], [traces[k] for k in moving]
            if len(set(traces)) < len(traces):
                traces = [f"{trace} {k + 1}" for k, trace in enumerate(traces)]
            labels = [f"{label}_from_{_cause(trace)}" for label in labels for trace in traces]
        values = values.reshape(len(labels), -1)
    return values, np.asarray(data.time, float), labels


def _cause(trace: str) -> str:
    """Return the input that a trace is named after, as in "From u[0]"."""
    return trace.removeprefix("From ")


def _of_pandas(data: RecordLike) -> tuple[RealArray, RealArray | None, list[str]]:
    table = data if hasattr(data, "columns") else data.to_frame(name=data.name if data.name is not None else "y[0]")
    columns = {
        "_".join(map(str, name)) if isinstance(name, tuple) else str(name): table.iloc[:, k]
        for k, name in enumerate(table.columns)
    }
    if len(columns) < table.shape[1]:
        twice = listed([str(name) for name in dict.fromkeys(table.columns[table.columns.duplicated()])])
        raise RecordError(f"{table.shape[1]} columns, but {len(columns)} names; named more than once: {twice}")
    if (levels := table.index.nlevels) > 1:
        first = f"data.xs({table.index[0][0]!r})" if levels == 2 else "data.xs(...)"
        raise RecordError(f"the index has {levels} levels: choose one record, as in {first}, so that the time is left")
    time, times = _index_time(table.index), set[str]()
    for name, column in columns.items():
        if times:
            # Further columns of time say the same in another unit, or from another start.
            times |= {name} if is_time(name) else set()
        elif (found := _column_time(name, column)) is not None:
            time = found
            times.add(name)
    kept = {name: column for name, column in columns.items() if name not in times}
    words = [name for name, column in kept.items() if column.dtype.kind not in "iufb"]
    if words and time is None and any(map(is_time, words)):
        name = next(filter(is_time, words))
        raise RecordError(
            f"column {name!r} is text, such as {next(iter(kept[name]), '')!r:.40}, and neither a date nor a time of "
            f"day: convert it to seconds, as in data[{name!r}] = pandas.to_numeric(data[{name!r}])"
        )
    if words:
        numbers = [name for name in words if _is_number(next(iter(kept[name]), ""))]
        commas = ".str.replace(',', '.')" if numbers and isinstance(next(iter(kept[numbers[0]])), str) else ""
        ways = f"convert it, as in pandas.to_numeric(data[{numbers[0]!r}]{commas}), or " if numbers else ""
        raise RecordError(
            f"columns without real numbers: {', '.join(map(repr, words[:3]))}; {ways}leave them out, as in "
            f"data.drop(columns={words[:3]!r})"
        )
    return _matrix([column.to_numpy(float) for column in kept.values()]), time, list(kept)


def _is_number(cell: object) -> bool:
    """Return whether a text is a number, with decimals after a point or a comma."""
    try:
        float(str(cell).replace(",", "."))
    except ValueError:
        return False
    return True


def _index_time(index: RecordLike) -> RealArray | None:
    """Return the time that an index of pandas is [s]; None for one that counts the rows or contains no numbers."""
    if (times := elapsed(index.to_series())) is not None:
        return times
    name = "" if index.name is None else str(index.name)
    if index.dtype.kind not in "iuf" or (not name and index.dtype.kind != "f"):
        return None
    stamps = np.asarray(index.to_numpy(), float)
    return seconds_in(name or "time", stamps)


def _column_time(name: str, column: RecordLike) -> RealArray | None:
    if column.dtype.kind in "iuf":
        return seconds_in(name, np.asarray(column.to_numpy(), float))
    return elapsed(column)


def _of_xarray(
    data: RecordLike, samples: int | None, *, own_units: bool
) -> tuple[RealArray, RealArray | None, list[str]]:
    arrays = {str(name): data[name] for name in data.data_vars} if hasattr(data, "data_vars") else {"": data}
    rows: list[RealArray] = []
    names: list[str] = []
    unknown: list[str] = []
    time: RealArray | None = None
    for name, array in arrays.items():
        along, time = _along_time(array, name or "the array", samples)
        others = [dim for dim in array.dims if dim != along]
        block = _matrix(array.transpose(*others, along).to_numpy(), samples)
        own = str(name or array.name or "y[0]")
        labels = [str(label) for label in array[others[0]].to_numpy()] if others else [own]
        called = [f"{name}_{label}" if name and others else label for label in labels]
        unit = str(array.attrs.get("units", "")) if own_units else ""
        if si_unit(unit):
            pairs = [converted(row, label, unit) for row, label in zip(block, called, strict=True)]
            block, called = np.array([row for row, _ in pairs]), [label for _, label in pairs]
        else:
            unknown.append(own)
        rows.append(block)
        names += called
    if 0 < len(unknown) < len(arrays):
        raise RecordError(
            f"the unit of {listed(unknown)} is not known, those of the other variables are: state all of them (",
            Argument("units"),
            "), or choose variables",
        )
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


def _matrix(data: RecordLike, samples: int | None = None) -> RealArray:
    """Return samples as (channel, sample); a column, and rows of a known number of samples, are turned."""
    values = np.atleast_2d(real_samples(data, "the data"))
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


def real_samples(data: RecordLike, what: str) -> RealArray:
    """Return a copy of real numbers as an array; refuse others as those of ``what``."""
    return np.array(real_numbers(data, what))


def _numbered(values: RealArray) -> list[str]:
    return [f"y[{i}]" for i in range(len(values))]


def time_samples(data: RecordLike, what: str) -> RealArray:
    """Return time points [s]: numbers, or what dates, durations and times of day have since the first."""
    array = np.asarray(data)
    array = array.ravel() if _is_vector(array) else array
    times = elapsed(array) if array.ndim == 1 and array.dtype.kind in "mMOUT" else None
    return real_samples(np.ma.ravel(data) if np.ma.isMaskedArray(data) else array, what) if times is None else times
