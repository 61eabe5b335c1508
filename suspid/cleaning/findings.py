"""Findings: what was met in a recording, where and how much, repaired or left alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.units import RealArray, Second


@dataclass(frozen=True, kw_only=True, slots=True)
class Finding:
    """One thing that was met in a recording.

    Parameters
    ----------
    kind : str
        What it is, in a word or two: "rounded stamps", "missing", "sentinel", "clipped" ….
    channel : str
        The channel; empty for time and for the recording as a whole.
    start, stop : float
        First and last time that it touches [s].
    samples : int
        How many samples.
    text : str
        What it is, how much, and what was done.
    repaired : bool
        Whether the record differs from the file for it.
    """

    kind: str
    channel: str
    start: Second
    stop: Second
    samples: int
    text: str
    repaired: bool

    def __str__(self) -> str:
        of = f", channel {self.channel!r}" if self.channel else ""
        where = f" from {self.start:.6g} to {self.stop:.6g} s" if self.stop > self.start else f" at {self.start:.6g} s"
        return f"{self.kind}{of}{where}: {self.text}"


def of_time(kind: str, where: RealArray, samples: int, text: str, *, repaired: bool = True) -> Finding:
    """Return a finding of time."""
    return Finding(
        kind=kind,
        channel="",
        start=float(np.min(where)),
        stop=float(np.max(where)),
        samples=samples,
        text=text,
        repaired=repaired,
    )
