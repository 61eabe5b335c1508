"""Cleaning: from the channels of a file to a record on one uniform clock, with a list of all that was met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import RecordError
from suspid.recordings import RawChannel, Recording
from suspid.signals import as_response, as_signal
from suspid.units import Hertz, Second
from suspid.values import text_table

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True)
class Finding:
    """One thing that was met in a recording, repaired or left alone.

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


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Cleaned:
    """A record that can be used, and what was done to make it so.

    Parameters
    ----------
    record : control.TimeResponseData
        Finite samples on a uniform clock.
    units : tuple of str
        Units of the channels as the file states them.
    findings : tuple of Finding
        What was met; none for a clean recording, whose samples and stamps are unchanged to the last bit.
    """

    record: control.TimeResponseData
    units: tuple[str, ...]
    findings: tuple[Finding, ...]

    def __str__(self) -> str:
        if not self.findings:
            return "nothing was found and nothing was changed"
        return text_table(
            {
                "found": [finding.kind for finding in self.findings],
                "channel": [finding.channel or "(time)" for finding in self.findings],
                "from [s]": [f"{finding.start:.6g}" for finding in self.findings],
                "to [s]": [f"{finding.stop:.6g}" for finding in self.findings],
                "samples": [str(finding.samples) for finding in self.findings],
                "repaired": ["yes" if finding.repaired else "no" for finding in self.findings],
                "what": [finding.text for finding in self.findings],
            }
        )


def clean(recording: Recording, *, channels: Sequence[str] | str | None = None, fs: Hertz | None = None) -> Cleaned:
    """Return the record that a recording holds, on one uniform clock, and what had to be done for it."""
    if fs is not None and not (np.isfinite(fs) and fs > 0):
        raise RecordError(f"{fs=} Hz must be positive and finite")
    names = [channels] if isinstance(channels, str) else list(channels or recording.names)
    chosen: list[RawChannel] = [recording[name] for name in names]
    if not chosen:
        raise RecordError("the recording holds no channel")
    if len({channel.values.size for channel in chosen}) > 1:
        raise RecordError("the channels differ in length")
    values = np.array([channel.values for channel in chosen], float)
    response = as_response(chosen[0].timepts, values, names, title=recording.title)
    as_signal(response)
    return Cleaned(record=response, units=tuple(channel.unit for channel in chosen), findings=())
