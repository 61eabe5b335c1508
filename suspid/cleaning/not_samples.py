"""Data that are no samples, or in another order than they are taken in, and what to write instead."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable
from suspid.io import is_time
from suspid.recordings import Recording
from suspid.units import Hertz, RealArray
from suspid.values import listed

# Steps of even times differ by this share at most: stamps of seven digits over thousands of samples.
EVEN_STEPS = 1e-2
# How many of a unit of time make a second: s, ms, us, ns.
TIME_SCALES = (1.0, 1e3, 1e6, 1e9)


def check_samples(data: Any) -> None:
    """Refuse what contains no samples, and pairs of other things than times and samples.

    Examples
    --------
    >>> check_samples((500, np.zeros(9)))
    Traceback (most recent call last):
    suspid.errors.RecordError: a pair is (timepts, samples), and one of these is the number 500: write as_record(data...
    """
    if isinstance(data, tuple) and len(data) == 2:
        _check_pair(data)
        return
    if isinstance(data, str) or hasattr(data, "__fspath__"):
        raise RecordError(f"{printable(str(data))!r:.80} is a path: read it with read_record, or pass it to analyse")
    if isinstance(data, Mapping):
        raise RecordError(
            "a mapping of names to samples: write as_record([*data.values()], channels=[*data], fs=...) with the "
            "sampling rate in Hz, without the time"
        )
    if isinstance(data, Recording):
        raise RecordError("this is a recording as it was read: clean(recording).record is a record, analyse takes both")
    names = getattr(getattr(data, "dtype", None), "names", None)
    if names:
        raise RecordError(
            f"the data is a structured array with the fields {listed(names)}: pass it as a table, "
            "as_record(pandas.DataFrame(data))"
        )
    # A set of modes is a sequence of such sets without end.
    own = type(data).__module__.partition(".")[0] == __name__.partition(".")[0]
    if own or (not isinstance(data, Sequence) and not np.ndim(data) and np.asarray(data).dtype == object):
        raise RecordError(
            f"the data is {'None' if data is None else f'of the type {type(data).__name__}'} and contains no samples: "
            "pass an array as in as_record(data, fs=...), a pair (timepts, samples), a table or a response"
        )


def _check_pair(pair: tuple[Any, Any]) -> None:
    for k, one in enumerate(pair):
        if isinstance(one, numbers.Real | np.number) and np.ndim(pair[1 - k]):
            raise RecordError(
                f"a pair is (timepts, samples), and one of these is the number {one:g}: write as_record(data, fs=...) "
                "with the sampling rate in Hz"
            )
    if all(np.ndim(one) == 1 and np.asarray(one).dtype.kind in "iuf" for one in pair):
        first, second = (np.asarray(one, float) for one in pair)
        if first.size == second.size and not np.all(np.diff(first) > 0) and runs_evenly(second):
            raise RecordError(
                "the second of the pair increases like a time, the first does not: write as_record((timepts, samples))"
            )


def runs_evenly(row: RealArray) -> bool:
    """Return whether numbers increase in even steps, as times do.

    Examples
    --------
    >>> runs_evenly(np.arange(4) / 500), runs_evenly(np.array([0.0, 1.0, 3.0])), runs_evenly(np.ones(3))
    (True, False, False)
    """
    if not np.all(np.isfinite(row)):
        return False
    steps = np.diff(row)
    mean = float(np.mean(steps)) if steps.size > 1 else 0.0
    return mean > 0 and float(np.max(np.abs(steps - mean))) <= EVEN_STEPS * mean


def check_first_row(values: RealArray, names: Sequence[str], fs: Hertz) -> None:
    """Refuse rows of which the first is the time at the sampling rate, unless it is named as a channel.

    Examples
    --------
    >>> check_first_row(np.array([[0.0, 0.1, 0.2], [5.0, 4.0, 3.0]]), ["y[0]", "y[1]"], 10.0)
    Traceback (most recent call last):
    suspid.errors.RecordError: row 0 of the data is the time, in steps of 0.1: write as_record((data[0], data[1:]))...
    """
    if len(values) < 2 or not (names[0] == "y[0]" or is_time(names[0])) or not runs_evenly(values[0]):
        return
    step = float(values[0, -1] - values[0, 0]) / (values.shape[1] - 1)
    if any(abs(step * fs / scale - 1) <= EVEN_STEPS for scale in TIME_SCALES):
        raise RecordError(
            f"row 0 of the data is the time, in steps of {step:.4g}: write as_record((data[0], data[1:])), with times "
            "in s"
        )
