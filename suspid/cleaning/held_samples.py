"""Samples that a logger repeats because the sensor is slower: one of each is the measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from suspid.cleaning.findings import Finding, found
from suspid.units import RealArray
from suspid.words import Defect, Number

# Rows at which a channel changes, at least: fewer may all be at the same pace by chance.
CHANGES_AT_A_PACE = 40


def once_each(
    times: RealArray, table: Mapping[str, RealArray]
) -> tuple[RealArray, dict[str, RealArray], list[Finding]]:
    """Return the first of each number of rows at which alone any channel changes, and a finding where that is done.

    A row that repeats the one before is no measurement: in a fit, what repeats has images at multiples of the rate.

    Examples
    --------
    >>> times = np.arange(300) / 300
    >>> seat = np.sin(30 * times[::3])
    >>> slow, taken, findings = once_each(times, {"seat": np.repeat(seat, 3)})
    >>> slow[:3], bool(np.all(taken["seat"] == seat)), findings[0].text[:40]
    (array([0.  , 0.01, 0.02]), True, 'each sample stands in 3 rows: the sensor')
    """
    size = times.size
    changes = np.zeros(size - 1, bool)
    for values in table.values():
        changes |= values[1:] != values[:-1]
        # Mostly the first channel tells.
        if np.any(changes[1:] & changes[:-1]):
            return times, dict(table), []
    rows = np.flatnonzero(changes) + 1
    pace = int(np.gcd.reduce(np.diff(rows))) if rows.size >= CHANGES_AT_A_PACE else 1
    if pace < 2:
        return times, dict(table), []
    first = slice(int(rows[0]) % pace, None, pace)
    numbers: dict[str, Number] = {"rows": pace, "rate": (size - 1) / float(times[-1] - times[0]) / pace}
    said = found(Defect.ONE_OF_EACH, times, size, numbers)
    return times[first], {name: values[first] for name, values in table.items()}, [said]


def without_those(findings: Sequence[Finding], said: Sequence[Finding]) -> list[Finding]:
    """Return the findings without those of each channel whose samples are taken once, as is said of all."""
    rows = [one.remark.numbers["rows"] for one in said]
    return [one for one in findings if one.kind is not Defect.HELD_SAMPLES or one.remark.numbers["repeats"] not in rows]
