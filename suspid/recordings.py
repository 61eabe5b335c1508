"""Recordings: channels as a file holds them, each on its own clock, before anything is repaired."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from suspid.errors import RecordError
from suspid.results import Result
from suspid.stamps import rate_and_gaps
from suspid.text_tables import COLUMN_GAP, TERMINAL, named, sentence_table, text_table
from suspid.units import Hertz, RealArray, Second
from suspid.values import listed, nearest_names
from suspid.wording import Argument
from suspid.words import Remark, count


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
    test : str
        Which of several tests in the file the channel belongs to; empty where the file holds one.

    Examples
    --------
    >>> t = np.array([0.0, 0.01, 0.02, 0.05])
    >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=np.array([0.0, 0.1, np.nan, 0.3]), rate=None)
    >>> seat.mean_rate, seat.duration, seat.gaps, seat.missing
    (100.0, 0.05, 2, 1)
    """

    name: str
    unit: str
    timepts: RealArray = field(repr=False)
    values: RealArray = field(repr=False)
    rate: Hertz | None
    test: str = ""

    @property
    def mean_rate(self) -> Hertz:
        """Rate that is stated, or else that of the uniform clock nearest to the stamps [Hz]; NaN if there is none.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel
        >>> t = np.array([0.0, 0.1, 0.2, 0.5, 0.6])
        >>> y = np.array([0.0, 1.0, np.nan, 2.0, 1.0])
        >>> channel = RawChannel(name="seat", unit="m", timepts=t, values=y, rate=10.0)
        >>> round(channel.mean_rate, 3)
        10.0
        """
        return rate_and_gaps(self.timepts)[0] if self.rate is None else self.rate

    @property
    def duration(self) -> Second:
        """Time between the earliest and the latest stamp [s]; NaN if there is none.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel
        >>> t = np.array([0.0, 0.1, 0.2, 0.5, 0.6])
        >>> y = np.array([0.0, 1.0, np.nan, 2.0, 1.0])
        >>> channel = RawChannel(name="seat", unit="m", timepts=t, values=y, rate=10.0)
        >>> channel.duration
        0.6
        """
        finite = self.timepts[np.isfinite(self.timepts)]
        return float(np.max(finite) - np.min(finite)) if finite.size else float("nan")

    @property
    def gaps(self) -> int:
        """Number of runs of missing samples: holes in the time stamps, and runs of NaN.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel
        >>> t = np.array([0.0, 0.01, 0.02, 0.05, 0.06])
        >>> seat = RawChannel(name="seat", unit="m", timepts=t, values=np.sin(20 * t), rate=None)
        >>> seat.gaps
        1
        """
        return rate_and_gaps(self.timepts)[1] + self.missing

    @property
    def missing(self) -> int:
        """Number of runs of NaN.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel
        >>> t = np.array([0.0, 0.1, 0.2, 0.5, 0.6])
        >>> y = np.array([0.0, 1.0, np.nan, 2.0, 1.0])
        >>> channel = RawChannel(name="seat", unit="m", timepts=t, values=y, rate=10.0)
        >>> channel.missing
        1
        """
        missing = np.isnan(self.values)
        return int(np.sum(missing[1:] & ~missing[:-1])) + int(missing.size > 0 and missing[0])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Recording(Result):
    """The channels of a file.

    Parameters
    ----------
    title : str
        Name of the file without its suffix.
    channels : tuple of RawChannel
        In the order of the file.
    left_out : tuple of (str, Remark)
        Other contents of the file, and why they are not channels: its name and a `suspid.words.LeftOut`.

    Examples
    --------
    >>> t = np.arange(100) / 100
    >>> seat = RawChannel(name="seat", unit="mm", timepts=t, values=np.sin(20 * t), rate=None)
    >>> bump = Recording(title="bump", channels=(seat,))
    >>> bump.names, bump["seat"].unit
    (('seat',), 'mm')
    >>> print(bump)
      channel    unit    rate [Hz]    samples    length [s]    gaps
    ---------  ------  -----------  ---------  ------------  ------
         seat      mm          100        100          0.99       0
    """

    title: str
    channels: tuple[RawChannel, ...]
    left_out: tuple[tuple[str, Remark], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording
        >>> t = np.array([0.0, 0.1, 0.2, 0.5, 0.6])
        >>> y = np.array([0.0, 1.0, np.nan, 2.0, 1.0])
        >>> channel = RawChannel(name="seat", unit="m", timepts=t, values=y, rate=10.0)
        >>> Recording(title="drop", channels=(channel,)).names
        ('seat',)
        """
        return tuple(channel.name for channel in self.channels)

    @property
    def tests(self) -> tuple[str, ...]:
        """Names of the tests, where the file holds several; else empty.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording
        >>> t = np.arange(100) / 100
        >>> both = [RawChannel(name="seat", unit="m", timepts=t + k, values=np.sin(20 * t), rate=None, test=f"run {k}")
        ...         for k in (1, 2)]
        >>> found = Recording(title="bumps", channels=tuple(both))
        >>> found.tests
        ('run 1', 'run 2')
        """
        return tuple(dict.fromkeys(channel.test for channel in self.channels if channel.test))

    def of_test(self, name: str) -> Recording:
        """Return the channels of one of the tests.

        Raises
        ------
        RecordError
            If there is no such test; the message lists those that there are.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording
        >>> t = np.arange(100) / 100
        >>> both = [RawChannel(name="seat", unit="m", timepts=t + k, values=np.sin(20 * t), rate=None, test=f"run {k}")
        ...         for k in (1, 2)]
        >>> found = Recording(title="bumps", channels=tuple(both))
        >>> float(found.of_test("run 2")["seat"].timepts[0])
        2.0
        """
        if name not in self.tests:
            known = (
                f"it contains {listed(self.tests)}"
                if self.tests
                else f"it contains only one, so leave out {Argument('test')}"
            )
            raise RecordError(f"there is no test {name!r}: {known}")
        return replace(self, channels=tuple(channel for channel in self.channels if channel.test == name))

    def __getitem__(self, name: str) -> RawChannel:
        """Return the channel of that name, or refuse with the nearest ones."""
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise RecordError(f"there is no channel {name!r}.{nearest_names(name, self.names)}")

    def _brief(self) -> str:
        return f"{self.title!r}: {count(len(self.channels), 'channel')}: {listed(self.names)}"

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "channel": self.names,
            "unit": [channel.unit for channel in self.channels],
            "rate_hz": [channel.mean_rate for channel in self.channels],
            "samples": [channel.values.size for channel in self.channels],
            "length_s": [channel.duration for channel in self.channels],
            "gaps": [channel.gaps for channel in self.channels],
        }

    def __str__(self) -> str:
        times = {id(channel.timepts): channel.timepts for channel in self.channels}
        clocks = {key: rate_and_gaps(stamps) for key, stamps in times.items()}
        read = [clocks[id(channel.timepts)] for channel in self.channels]
        rates = [channel.rate or rate for channel, (rate, _) in zip(self.channels, read, strict=True)]
        table = text_table(
            {
                **({"test": [channel.test for channel in self.channels]} if self.tests else {}),
                "channel": list(self.names),
                "unit": [channel.unit or "?" for channel in self.channels],
                "rate [Hz]": ["irregular" if np.isnan(rate) else f"{rate:.6g}" for rate in rates],
                "samples": [str(channel.values.size) for channel in self.channels],
                "length [s]": [f"{channel.duration:.6g}" for channel in self.channels],
                "gaps": [str(holes + channel.missing) for channel, (_, holes) in zip(self.channels, read, strict=True)],
            },
            widest=TERMINAL,
        )
        names, reasons = [name for name, _ in self.left_out], [str(reason) for _, reason in self.left_out]
        if names:
            room = TERMINAL - COLUMN_GAP - max(len(named(name)) for name in [*names, "left out"])
            whys = sentence_table({"left out": names}, "because it", [[reason] for reason in reasons], room)
            table = f"{table}\n\n{whys}"
        if not self.tests:
            return table
        first, together = Argument("test", repr(self.tests[0])), Argument("test", "'all'")
        return (
            f"{table}\n\nThe file contains {len(self.tests)} tests. Choose one, such as {first}; {together} joins them."
        )
