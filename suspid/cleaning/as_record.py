"""Arrays and tables in memory as records."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.cleaning.conversions import converted
from suspid.cleaning.data_forms import RecordLike, is_response, samples_of, time_samples
from suspid.cleaning.not_samples import EVEN_STEPS, check_first_row, runs_evenly
from suspid.errors import RecordError, RecordWarning
from suspid.io import SLOWEST_STEP
from suspid.records import as_response
from suspid.signals import check_size, real_numbers, uniform_step
from suspid.units import Hertz, RealArray
from suspid.values import check_rate
from suspid.wording import Argument

if TYPE_CHECKING:
    import control
    from numpy.typing import ArrayLike


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
        Samples; a pair ``(timepts, samples)``; a pandas Series or DataFrame whose index, or a column named as a time
        or with dates or times of day, is the time; such a table of polars or pyarrow; an xarray DataArray or Dataset
        with a dimension of time; or a control.TimeResponseData. Several traces, as of `control.impulse_response`,
        become channels named ``output_from_input``; inputs that move nothing are left out.
    fs : float, optional
        Sampling rate [Hz]; it replaces a time in the data.
    timepts : array_like (sample,), optional
        Time of each sample [s], or dates or times of day, uniform; it replaces a time in the data.
    channels : sequence of str, optional
        Names of the channels. Default: those of the table, or y[0], y[1], ….
    units : sequence of str or mapping of str to str, optional
        Unit of each channel in order, or of some by name; these are converted to SI, and named so where a name states
        its unit. Default: the attribute ``units`` of xarray, where that of every variable is known; other samples stay
        as they are.

    Returns
    -------
    control.TimeResponseData
        One trace. A response is returned unchanged where nothing is to be done.

    Raises
    ------
    RecordError
        If the data has no time and no ``fs``, is complex or masked, has samples in rows instead of columns where their
        number is not known from the time, or time is irregular; if a name states another unit than ``units``, or only
        some variables of xarray have a unit that is known.
    InputError
        If a unit is not known.

    Warns
    -----
    RecordWarning
        If the steps, in seconds, are too slow for a suspension, or ``fs`` is not the rate of the time that it replaces.

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
    if timepts is not None and not np.ndim(timepts):
        raise RecordError(f"timepts = {timepts!r:.40} must have a number for each sample; or give fs, the rate in Hz")
    if is_response(data) and np.ndim(data.y) == 2 and fs is None is timepts and channels is None is units:
        response: control.TimeResponseData = data
        samples = real_numbers(response.y, "the response")
        _check_sizes(response.output_labels or [f"y[{i}]" for i in range(len(samples))], response.time, samples)
        return response
    values, time, names = samples_of(data, None if timepts is None else np.size(timepts), own_units=units is None)
    if channels is not None:
        if isinstance(channels, str) or len(channels) != len(values):
            number = f"{len(values)} channel{'s' * (len(values) != 1)}"
            raise RecordError(Argument("channels", f"{channels!r:.80}"), f" must name {number} in a list, in order")
        names = [str(name) for name in channels]
    if timepts is not None:
        time = time_samples(timepts, "timepts")
    if fs is not None:
        _check_rate_beside(time, values, names, fs)
        time = np.arange(values.shape[1]) / fs
    if time is None:
        first = len(values) > 1 and runs_evenly(values[0])
        raise RecordError(
            "an array has no time: write as_record(data, fs=...) with the sampling rate in Hz, or "
            + ("as_record((data[0], data[1:])), as row 0 increases like a time" if first else "")
            + ("" if first else "as_record((timepts, data)) with the time of each sample in s")
        )
    if time.ndim != 1 or time.size != values.shape[1]:
        raise RecordError(
            f"{time.size} time points, but {values.shape[1]} samples: each sample needs one; or give fs, the sampling "
            "rate in Hz"
        )
    # A rate below 1 Hz is likely a step. A column of a table states its unit, or is asked for it.
    own = fs is None is timepts and not isinstance(data, tuple)
    if time.size > 1 and (step := uniform_step(time)) >= SLOWEST_STEP and not own and (fs is None or fs < 1):
        meant = "times are in s (milliseconds divided by 1000), fs in Hz"
        warnings.warn(f"steps of {step:.4g} s are too slow for a suspension: {meant}", RecordWarning, stacklevel=3)
    values, names = _converted(values, names, units)
    _check_sizes(names, time, values)
    return as_response(time, values, names, title=str(getattr(data, "title", None) or ""))


def _check_rate_beside(time: RealArray | None, values: RealArray, names: Sequence[str], fs: Hertz) -> None:
    """Refuse a rate where a row is the time, and say where it differs from that of the time that it replaces."""
    if time is None:
        check_first_row(values, names, fs)
        return
    length = float(np.ptp(time)) if time.size > 1 else 0.0
    if length and abs(fs * length / (time.size - 1) - 1) > EVEN_STEPS:
        states = f"the time in the data, which states {(time.size - 1) / length:.6g} Hz"
        warnings.warn(f"fs = {fs:g} Hz replaces {states}: leave fs out to keep it", RecordWarning, stacklevel=4)


def _check_sizes(names: Sequence[str], time: RealArray, values: RealArray) -> None:
    for name, samples in zip(names, values, strict=False):
        check_size(name, time, samples)


def _converted(
    values: RealArray, names: Sequence[str], units: Sequence[str] | Mapping[str, str] | None
) -> tuple[RealArray, list[str]]:
    """Return the samples in SI units, and the names, in which these replace the units before."""
    if units is None:
        return values, [*names]
    if isinstance(units, Mapping):
        unknown = sorted(set(units) - set(names))
        if unknown:
            raise RecordError(f"units of {unknown[0]!r}: there is no such channel; the channels are {', '.join(names)}")
        stated = [units.get(name) for name in names]
    elif isinstance(units, str) or len(units) != len(names):
        raise RecordError(f"units={units!r:.80} must state the unit of each of {len(names)} channels, or map names")
    else:
        stated = [*units]
    rows, called = [*values], [*names]
    for k, unit in enumerate(stated):
        if unit is not None:
            rows[k], called[k] = converted(values[k], names[k], unit)
    return np.array(rows), called
