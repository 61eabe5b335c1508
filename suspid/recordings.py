"""Recordings: channels as a file holds them, each on its own clock, before anything is repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.errors import RecordError
from suspid.stamps import rate_and_gaps
from suspid.units import Hertz, RealArray, Second
from suspid.values import nearest_names, text_table
from suspid.words import Remark


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RawChannel:
    """A channel as stored in a file; nothing is checked or changed.

    Parameters
    ----------
    name : str
        Its name in the file; unique within the recording.
    unit : str
        Its unit as stated in the file; empty where it is not.
    timepts : ndarray (sample,)
        The stamps [s] as stored: possibly rounded, repeated, decreasing or not a number. Channels of one
        clock share one array.
    values : ndarray (sample,)
        The samples, possibly not a number.
    rate : float or None
        Sampling rate [Hz] stated by the file or the user; None where there are only stamps.
    """

    name: str
    unit: str
    timepts: RealArray
    values: RealArray
    rate: Hertz | None

    @property
    def mean_rate(self) -> Hertz:
        """Rate that is stated, or else that of the uniform clock nearest to the stamps [Hz]; NaN if there is none."""
        return rate_and_gaps(self.timepts)[0] if self.rate is None else self.rate

    @property
    def duration(self) -> Second:
        """Time between the earliest and the latest stamp [s]; NaN if there is none."""
        finite = self.timepts[np.isfinite(self.timepts)]
        return float(np.max(finite) - np.min(finite)) if finite.size else float("nan")

    @property
    def gaps(self) -> int:
        """Number of runs of missing samples: holes in the time stamps, and runs of NaN."""
        holes = rate_and_gaps(self.timepts)[1]
        missing = np.isnan(self.values)
        runs = int(np.sum(missing[1:] & ~missing[:-1])) + int(missing.size > 0 and missing[0])
        return holes + runs


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Recording:
    """The channels of a file.

    Parameters
    ----------
    title : str
        Name of the file without its suffix.
    channels : tuple of RawChannel
        In the order of the file.
    left_out : tuple of (str, Remark)
        What else the file holds, and why it is not a channel: its name and a `suspid.words.LeftOut`.
    """

    title: str
    channels: tuple[RawChannel, ...]
    left_out: tuple[tuple[str, Remark], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(channel.name for channel in self.channels)

    def __getitem__(self, name: str) -> RawChannel:
        """Return the channel of that name, or refuse with the nearest ones."""
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise RecordError(f"there is no channel {name!r}.{nearest_names(name, self.names)}")

    def __str__(self) -> str:
        table = text_table(
            {
                "channel": list(self.names),
                "unit": [channel.unit or "?" for channel in self.channels],
                "rate [Hz]": [f"{channel.mean_rate:.6g}" for channel in self.channels],
                "samples": [str(channel.values.size) for channel in self.channels],
                "length [s]": [f"{channel.duration:.6g}" for channel in self.channels],
                "gaps": [str(channel.gaps) for channel in self.channels],
            }
        )
        names, reasons = [name for name, _ in self.left_out], [str(reason) for _, reason in self.left_out]
        return f"{table}\n\n{text_table({'left out': names, 'because it': reasons})}" if names else table
