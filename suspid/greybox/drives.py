"""The stretches of a drive, taken and left, with the reasons."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import TYPE_CHECKING, overload

import numpy as np

from suspid.errors import InputError
from suspid.files import printable
from suspid.results import Result, columns_of
from suspid.text_tables import COLUMN_GAP, TERMINAL, text_table
from suspid.units import Hertz, MetrePerSecond, MetrePerSecond2, RealArray, Second
from suspid.wording import Argument
from suspid.words import Check, Code, Level, Remark, Verdict
from suspid.words.drives import DriveRemark

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveLimits:
    """Limits of a usable stretch of a drive. All are physical quantities; none depends on the record.

    Parameters
    ----------
    least_speed : float
        Speed from which a car counts as moving [m/s]. Below walking pace a car manoeuvres: it is steered, pulls away
        and stops.
    least_vibration : float
        Vibration from which a car counts as moving where its speed is not known [m/s2], see `band_hz`. A very good road
        (class A of ISO 8608) taken at 3 m/s moves the bodies of ordinary cars by 0.1 m/s2, cars at rest by less than
        0.02 m/s2.
    longitudinal, lateral : float
        Largest acceleration [m/s2], mean over a block. With a centre of gravity at a fifth of the wheelbase, 1.5 m/s2
        move 3 % of the weight from one axle to the other; springs and dampers then work away from their usual point,
        and the inertia of the body is a force that no channel shows.
    band_hz : (float, float)
        Frequencies in which the vibration is judged [Hz]: above the pitching of braking, below the second order of
        idling engines. Its level follows from the median of the spectrum in the band, which single lines do not change.
    block : float
        Length of the blocks for each of which it is decided [s]: a period of the body or more, so that braking is not
        hidden by vibration.
    shortest : float
        Least length of a stretch [s]: `estimate` transforms stretches of eight periods of the body.
    recovery : float
        Time after clipping for which a sensor is given to recover [s]: what drove it out of range rings on, and so do
        its filters.
    stuck : float
        How long a channel may stay at exactly one value while the car moves [s]: half a period of the slowest body.

    Examples
    --------
    >>> from suspid import DriveLimits
    >>> limits = DriveLimits(least_speed=8.0, shortest=30.0)
    >>> limits.least_speed, limits.longitudinal
    (8.0, 1.5)
    """

    least_speed: MetrePerSecond = 3.0
    least_vibration: MetrePerSecond2 = 0.05
    longitudinal: MetrePerSecond2 = 1.5
    lateral: MetrePerSecond2 = 1.5
    band_hz: tuple[Hertz, Hertz] = (1.0, 15.0)
    block: Second = 1.0
    shortest: Second = 10.0
    recovery: Second = 0.5
    stuck: Second = 0.5

    def __post_init__(self) -> None:
        for name in (
            "least_speed",
            "least_vibration",
            "longitudinal",
            "lateral",
            "block",
            "shortest",
            "recovery",
            "stuck",
        ):
            if not getattr(self, name) > 0:
                raise InputError(Argument(name, str(getattr(self, name))), " must be positive")
        if not 0 < self.band_hz[0] < self.band_hz[1]:
            raise InputError(Argument("band_hz", f"{self.band_hz}"), " must be a lower and a higher frequency [Hz]")


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """A stretch of a recorded drive.

    Parameters
    ----------
    start, stop : float
        Its first and last time [s].
    taken : bool
        Whether it is usable.
    reasons : tuple of Remark
        Why it was used or left out, each a `suspid.words.drives.DriveReason` with its numbers.
    speed : float
        Mean speed [m/s]; NaN where it is not known.

    Examples
    --------
    >>> from suspid import RawChannel, Recording, find_drives
    >>> t = np.arange(6000) / 100
    >>> body = 0.3 * np.random.default_rng(1).standard_normal(t.size)
    >>> rows = {"chassis": (body, "m/s2"), "speed": (np.full(t.size, 72.0), "km/h")}
    >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
    >>> stretch = find_drives(Recording(title="ride", channels=tuple(made)))[0]
    >>> stretch.taken, stretch.length, stretch.speed
    (True, 60.0, 20.0)
    """

    start: Second
    stop: Second
    taken: bool
    reasons: tuple[Remark, ...]
    speed: MetrePerSecond

    @property
    def length(self) -> Second:
        """Its length [s]."""
        return self.stop - self.start

    def __str__(self) -> str:
        said = "; ".join(map(str, self.reasons))
        return f"{self.start:.6g} … {self.stop:.6g} s {'taken' if self.taken else 'left'}: {said}"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Drives(Sequence[Drive], Result):
    """The stretches of a recorded drive in order of time, as a sequence.

    Parameters
    ----------
    stretches : tuple of Drive
        All stretches; together they cover the recording.
    records : tuple of control.TimeResponseData
        The record of each stretch that was taken: all channels on one clock, short gaps filled.
    speeds : tuple of ndarray
        Speed at each sample of each record [m/s], straight between the middles of the blocks; NaN where not known.
    remarks : tuple of Check
        What was checked and what could not be.
    title : str
        Name of the recording.
    course : ndarray (block, 3)
        Middle [s], speed [m/s] and vibration [m/s2] of each block of the recording; NaN where not known.

    Examples
    --------
    >>> from suspid import RawChannel, Recording, find_drives
    >>> t = np.arange(6000) / 100
    >>> speed = np.where(t < 20, 0.0, 20.0)
    >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
    >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
    >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
    >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
    >>> len(drives.taken), len(drives.left), round(drives.usable), round(drives.length)
    (1, 2, 39, 60)
    """

    stretches: tuple[Drive, ...] = ()
    records: tuple[control.TimeResponseData, ...] = ()
    speeds: tuple[RealArray, ...] = ()
    remarks: tuple[Check, ...] = field(default=())
    title: str = ""
    course: RealArray = field(default_factory=lambda: np.empty((0, 3)))

    def __len__(self) -> int:
        return len(self.stretches)

    def __iter__(self) -> Iterator[Drive]:
        return iter(self.stretches)

    @overload
    def __getitem__(self, index: int) -> Drive: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Drive, ...]: ...

    def __getitem__(self, index: int | slice) -> Drive | tuple[Drive, ...]:
        return self.stretches[index]

    @property
    def taken(self) -> tuple[Drive, ...]:
        """The usable stretches.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> speed = np.where(t < 20, 0.0, 20.0)
        >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> [drive.start for drive in drives.taken]
        [21.0]
        """
        return tuple(one for one in self.stretches if one.taken)

    @property
    def left(self) -> tuple[Drive, ...]:
        """The other stretches.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> speed = np.where(t < 20, 0.0, 20.0)
        >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> len(drives.left)
        2
        """
        return tuple(one for one in self.stretches if not one.taken)

    @property
    def usable(self) -> Second:
        """Length of all usable stretches together [s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> speed = np.where(t < 20, 0.0, 20.0)
        >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> round(drives.usable)
        39
        """
        return float(sum(one.length for one in self.taken))

    @property
    def length(self) -> Second:
        """Length of all stretches together [s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> speed = np.where(t < 20, 0.0, 20.0)
        >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> round(drives.length)
        60
        """
        return float(sum(one.length for one in self.stretches))

    @property
    def verdict(self) -> Verdict:
        """Whether there is a usable stretch, and what could not be checked.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> speed = np.where(t < 20, 0.0, 20.0)
        >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (speed, "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> drives.verdict.level.label
        'care'
        """
        if not self.taken:
            none = Remark(DriveRemark.NONE, {"length": self.length, "why": left_for(self)})
            return Verdict(none, (Check(none, Level.NONE), *self.remarks))
        numbers = {"stretches": len(self.taken), "seconds": self.usable, "length": self.length}
        return Verdict(Remark(DriveRemark.FOUND, numbers), self.remarks)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return columns_of(self, ["start", "stop", "taken", "speed", "reasons"])

    def _brief(self) -> str:
        return str(self.verdict.headline)

    def __str__(self) -> str:
        return f"{summary_table(self)}\n{self.verdict}"

    def details(self) -> str:
        """Return everything as text: each stretch with its reasons, and `str`."""
        return f"{stretch_table(self)}\n{self}" if self else str(self)


def stretch_table(drives: Sequence[Drive]) -> str:
    """Return a table of all stretches with their reasons, each on lines of its own within a terminal.

    Examples
    --------
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
    lines = [
        [line for reason in one.reasons for line in wrap(printable(str(reason)), TERMINAL - taken - COLUMN_GAP)]
        for one in drives
    ]
    long = {
        name: [cell for text, own in zip(column, lines, strict=True) for cell in (text, *[""] * (len(own) - 1))]
        for name, column in columns.items()
    }
    because = {"because": [line for own in lines for line in own]}
    return text_table({**long, **because}, words=because)


def _second(time: Second) -> str:
    """Return a time as text, to a millisecond: estimated clocks begin a few microseconds from zero."""
    return f"{round(time, 3) + 0.0:.10g}"


def _by_reason(drives: Sequence[Drive]) -> list[tuple[tuple[bool, Code], list[Drive]]]:
    """Return the stretches by whether they were left and the gravest reason, the longest together first."""
    groups: dict[tuple[bool, Code], list[Drive]] = {}
    for one in drives:
        groups.setdefault((not one.taken, one.reasons[0].code), []).append(one)
    return sorted(groups.items(), key=lambda item: (item[0][0], -sum(one.length for one in item[1])))


def left_for(drives: Sequence[Drive]) -> str:
    """Return in words how long was left for which reason first."""
    return ", ".join(
        f"{sum(one.length for one in every):.4g} s {code}" for (left, code), every in _by_reason(drives) if left
    )


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
