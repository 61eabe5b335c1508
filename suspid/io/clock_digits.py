"""Times of day whose hours, minutes and seconds stand in one number, such as 235959.95, as GPS loggers write them."""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray

# The number of a day's end, and half a day [s]: a time that falls by more has passed midnight.
END_OF_DAY, HALF_A_DAY = 240_000.0, 43_200.0
# Steps beyond this many usual ones are jumps: where a minute ends, the digits go on by 40 s.
FAR_APART = 10.0
# Stamps that are looked at first: all take a part of the time in which a file is read.
SEEN_FIRST = 4096


def seconds_of_digits(stamps: RealArray) -> RealArray | None:
    """Return the seconds of such times, None where numbers are none: they jump only where a minute, hour or day ends.

    Examples
    --------
    >>> seconds_of_digits(np.array([125959.8, 125959.9, 130000.0, 130000.1])).round(3)
    array([46799.8, 46799.9, 46800. , 46800.1])
    >>> seconds_of_digits(np.array([1.0, 2.0, 3.0, 80.0])), seconds_of_digits(np.array([125958.0, 125959.0]))
    (None, None)
    """
    known = stamps[np.isfinite(stamps)]
    # Within a minute nothing jumps. Of other clocks, few stamps tell that they are none.
    if known.size < 2 or np.min(known) < 0 or not 100 <= np.max(known) < END_OF_DAY:
        return None
    if np.any(known[:: 1 + known.size // SEEN_FIRST] % 100 >= 60):
        return None
    usual = float(np.median(np.diff(known)))
    finite = np.where(np.isfinite(stamps), stamps, np.nan)
    hours, minutes, seconds = np.floor(finite / 10_000), np.floor(finite / 100) % 100, finite % 100
    jumps = np.abs(np.diff(known)) > FAR_APART * max(usual, 0.0)
    if not usual > 0 or not np.any(jumps) or np.nanmax(minutes) >= 60 or np.nanmax(seconds) >= 60:
        return None
    of_day = 3600 * hours + 60 * minutes + seconds
    there = np.isfinite(of_day)
    of_day[there] += 2 * HALF_A_DAY * np.cumsum(np.diff(of_day[there], prepend=of_day[there][:1]) < -HALF_A_DAY)
    return None if np.any(np.abs(np.diff(of_day[there])) > FAR_APART * usual) else of_day
