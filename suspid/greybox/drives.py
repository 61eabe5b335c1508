"""The stretches of a drive, taken and left, with the reasons."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, overload

import numpy as np

from suspid.greybox.drive_tables import nothing_usable, stretch_table, summary_table
from suspid.results import Result
from suspid.units import MetrePerSecond, RealArray, Second
from suspid.words import Check, Remark, Verdict
from suspid.words.drives import DriveRemark

if TYPE_CHECKING:
    import control


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
        """Its length [s].

        Examples
        --------
        >>> from suspid import Drive
        >>> Drive(start=12.0, stop=42.5, taken=True, reasons=(), speed=20.0).length
        30.5
        """
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
            return nothing_usable(self, self.remarks)
        numbers = {"stretches": len(self.taken), "seconds": self.usable, "length": self.length}
        return Verdict(Remark(DriveRemark.FOUND, numbers), self.remarks)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "start_s": [one.start for one in self],
            "stop_s": [one.stop for one in self],
            "taken": [one.taken for one in self],
            "speed_m_per_s": [one.speed for one in self],
            "reasons": ["; ".join(map(str, one.reasons)) for one in self],
        }

    def _brief(self) -> str:
        return str(self.verdict.headline)

    def __str__(self) -> str:
        return f"{summary_table(self)}\n{self.verdict}"

    def details(self) -> str:
        """Return everything as text: each stretch with its reasons, and `str`.

        Examples
        --------
        >>> from suspid import Drive, Drives, Remark
        >>> from suspid.words.drives import DriveReason
        >>> slow = Remark(DriveReason.SLOW, {"limit": 3.0, "low": 0.0})
        >>> rest = Drive(start=0.0, stop=22.0, taken=False, reasons=(slow,), speed=0.0)
        >>> "slower than 3 m/s (down to 0 m/s)" in Drives(stretches=(rest,)).details()
        True
        """
        return f"{stretch_table(self)}\n{self}" if self else str(self)
