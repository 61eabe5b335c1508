"""The vertical acceleration in drives that a tilted accelerometer of three axes has recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.cleaning import Vertical, unmarked, vertical
from suspid.errors import RecordError
from suspid.recordings import RawChannel
from suspid.records import as_response
from suspid.values import listed

NAME = "vertical"


def upright(axes: Sequence[RawChannel]) -> tuple[RawChannel, Vertical]:
    """Return the vertical motion in the channels of three axes, less gravity, and its direction over all samples.

    Raises
    ------
    RecordError
        If the axes have different clocks or units, or nothing moves.

    Examples
    --------
    >>> t = np.arange(2000) / 200
    >>> up = 9.81 + np.sin(10 * t)
    >>> made = {"x": 0 * t, "y": 0.6 * up, "z": 0.8 * up}
    >>> one, found = upright([RawChannel(name=n, unit="m/s2", timepts=t, values=v, rate=None) for n, v in made.items()])
    >>> one.name, round(found.tilt_deg, 1), bool(np.std(one.values - np.sin(10 * t)) < 1e-6)
    ('vertical', 36.9, True)
    """
    names = [one.name for one in axes]
    first = axes[0]
    if any(not np.array_equal(first.timepts, one.timepts, equal_nan=True) for one in axes):
        raise RecordError(f"the axes {listed(names)} are on different clocks: their vertical cannot be found")
    if len({one.unit for one in axes}) > 1:
        raise RecordError(f"the axes {listed(names)} are in different units: {listed([one.unit for one in axes])}")
    values = np.array([unmarked(one) for one in axes])
    there = np.all(np.isfinite(values), axis=0)
    # The direction does not depend on when a sample was taken: gaps are left out.
    _, found = vertical(as_response(np.arange(float(np.sum(there))), values[:, there], names))
    along = found.up @ values - (found.gravity * (found.by == "gravity"))
    # Gravity tells the unit where the file does not.
    return replace(first, name=NAME, unit=first.unit or found.gravity_unit, values=np.asarray(along)), found
