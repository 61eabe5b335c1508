"""Tables of the stretches of a drive: each with its reasons, and how long was taken and left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.files import printable
from suspid.text_tables import COLUMN_GAP, TERMINAL, sentence_table, text_table
from suspid.units import Second
from suspid.words import Check, Code, Level, Remark, Verdict
from suspid.words.drives import DriveReason, DriveRemark

if TYPE_CHECKING:
    from suspid.greybox.drives import Drive


def stretch_table(drives: Sequence[Drive]) -> str:
    """Return a table of all stretches with their reasons, each on lines of its own within a terminal.

    Examples
    --------
    >>> from suspid import Drive
    >>> from suspid.words import Remark
    >>> from suspid.words.drives import DriveReason
    >>> slow = Remark(DriveReason.SLOW, {"limit": 3.0, "low": 0.0})
    >>> hard = Remark(DriveReason.BRAKING, {"limit": 1.5, "most": 2.0})
    >>> print(stretch_table([Drive(start=0.0, stop=22.0, taken=False, reasons=(slow, hard), speed=1.5)]))
      start [s]    stop [s]    speed [m/s]        because
    -----------  ----------  -------------  ----  ----------------------------------
              0          22            1.5  left  slower than 3 m/s (down to 0 m/s)
                                                  braking or accelerating with up to
                                                  2 m/s2 (limit 1.5 m/s2)
    """
    columns: dict[str, list[str]] = {
        "start [s]": [_second(one.start) for one in drives],
        "stop [s]": [_second(one.stop) for one in drives],
        "speed [m/s]": ["" if np.isnan(one.speed) else f"{one.speed:.3g}" for one in drives],
        "": ["taken" if one.taken else "left" for one in drives],
    }
    taken = max(map(len, text_table(columns).split("\n")))
    reasons = [[printable(str(reason)) for reason in one.reasons] for one in drives]
    return sentence_table(columns, "because", reasons, TERMINAL - taken - COLUMN_GAP)


def _second(time: Second) -> str:
    """Return a time as text, to a millisecond: estimated clocks begin a few microseconds from zero."""
    return f"{round(time, 3) + 0.0:.10g}"


def _by_reason(drives: Sequence[Drive]) -> list[tuple[tuple[bool, Code], list[Drive]]]:
    """Return the stretches by whether they were left and the gravest reason, the longest together first."""
    groups: dict[tuple[bool, Code], list[Drive]] = {}
    for one in drives:
        groups.setdefault((not one.taken, one.reasons[0].code), []).append(one)
    return sorted(groups.items(), key=lambda item: (item[0][0], -sum(one.length for one in item[1])))


def nothing_usable(drives: Sequence[Drive], remarks: Sequence[Check]) -> Verdict:
    """Return the verdict on stretches none of which is usable: how long each was left for which reason first."""
    reasons = {code: sum(one.length for one in every) for (left, code), every in _by_reason(drives) if left}
    why = ", ".join(f"{length:.4g} s {code}" for code, length in reasons.items())
    none = Remark(DriveRemark.NONE, {"length": float(sum(one.length for one in drives)), "why": why})
    stands = [Check(Remark(DriveRemark.STANDS), Level.NOTE)] if set(reasons) == {DriveReason.STANDING} else []
    short = [one.reasons[0].numbers for one in drives if one.reasons[0].code is DriveReason.SHORT]
    longest = max(short, key=lambda numbers: float(str(numbers["length"])), default=None)
    if longest is not None:
        none_of = Remark(DriveRemark.TOO_SHORT, {"longest": longest["length"], "least": longest["least"]})
        return Verdict(none, (Check(none_of, Level.NONE), *remarks))
    if set(reasons) == {DriveReason.BRIEF}:
        return Verdict(none, (Check(drives[0].reasons[0], Level.NONE), *remarks))
    return Verdict(none, (Check(none, Level.NONE), *stands, *remarks))


def summary_table(drives: Sequence[Drive]) -> str:
    """Return a table of how long was taken, and left for which reason first."""
    order = _by_reason(drives)
    return text_table(
        {
            "stretches": [str(len(every)) for _, every in order],
            "length [s]": [f"{sum(one.length for one in every):.4g}" for _, every in order],
            "": ["left" if left else "taken" for (left, _), _ in order],
            "because": [str(code) for (_, code), _ in order],
        }
    )
