"""Times in memory that are no numbers: dates, durations, and clocks as text."""

from __future__ import annotations

from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.io import clock_seconds
from suspid.units import RealArray


def elapsed(stamps: Any) -> RealArray | None:
    """Return the seconds since the first date or time of day, or those of durations; None of what is neither.

    Examples
    --------
    >>> elapsed(np.array(["10:00:00.50", "10:00:00.75"]))
    array([0.  , 0.25])
    >>> elapsed(np.array(["2024-05-01T10:00:00.5", "2024-05-01T10:00:01"], "datetime64[ns]"))
    array([0. , 0.5])
    >>> elapsed(np.array(["left", "right"])) is None
    True
    """
    kind = getattr(stamps.dtype, "kind", "O")
    if kind not in "mM":
        texts = kind in "OUT"
        return clock_seconds(["" if _is_missing(one) else str(one) for one in stamps]) if texts else None
    if kind == "m" and np.datetime_data(stamps.dtype)[0] == "generic":
        raise RecordError("durations have no unit; give them one, as in times.astype('timedelta64[ms]')")
    # Whole nanoseconds: a date of our age in seconds has no more than 2e-7 s as a float.
    whole = "datetime64[ns]" if kind == "M" else "timedelta64[ns]"
    bare = isinstance(stamps, np.ndarray) or hasattr(stamps, "dims")
    counts = np.asarray(stamps, whole) if bare else stamps.to_numpy(whole)
    known = ~np.isnat(counts)
    first = counts[known][:1] if kind == "M" else np.zeros(1, whole)
    return np.where(known, (counts - first).astype(np.int64) / 1e9 if known.any() else np.nan, np.nan)


def _is_missing(one: object) -> bool:
    """Return whether a cell is empty, in the ways of Python, numpy and pandas."""
    return one is None or str(one) in ("<NA>", "NaT", "nan")
