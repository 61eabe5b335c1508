"""Result of `analyse_drive`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from suspid.analysis.damper_table import damper_table
from suspid.analysis.drive_dampers import dampers_above_wheels
from suspid.greybox import (
    BodyModes,
    DamperCurve,
    Drives,
    Estimate,
    nothing_usable,
    parameter_table,
)
from suspid.performance import Wear
from suspid.results import Result, columns_of
from suspid.values import numbers_in_words
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.drives import DriveHeadline, DriveRemark
from suspid.words.greybox import EstimateCheck
from suspid.words.grip import GripCheck


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class DriveAnalysis(Result):
    """Results of recorded drives of a car.

    Parameters
    ----------
    drives : tuple of Drives
        The stretches of each file, used and left out.
    estimate : Estimate or None
        Springs and dampers, where the wheels were measured.
    body : BodyModes or None
        Frequencies of the body, where only the body was measured.
    notes : tuple of Check
        Further remarks.
    curves : tuple of DamperCurve
        Curves of the dampers above the wheels, where the sensors determine them.
    wear : Wear or None
        Wear and grip of the dampers, against earlier estimates or nominal values.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import RawChannel, Recording, analyse_drive
    >>> t = np.arange(30000) / 100
    >>> body = 0.3 * np.random.default_rng(1).standard_normal(t.size)
    >>> rows = {"chassis_acceleration": (body, "m/s2"), "speed": (np.full(t.size, 20.0), "m/s")}
    >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
    >>> found = analyse_drive(Recording(title="ride", channels=tuple(made)))
    >>> found.estimate is None, found.body is None, round(found.usable)
    (True, False, 300)
    """

    drives: tuple[Drives, ...]
    estimate: Estimate | None
    body: BodyModes | None
    notes: tuple[Check, ...] = ()
    curves: tuple[DamperCurve, ...] = ()
    wear: Wear | None = None

    def _table(self) -> Mapping[str, Sequence[object]]:
        if self.estimate is not None:
            return self.estimate._table()
        return columns_of(self.body or (), ["channel", "hertz"])

    @property
    def usable(self) -> float:
        """Length of all usable stretches together [s].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DriveAnalysis, RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> body = 0.3 * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (np.full(t.size, 20.0), "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> round(DriveAnalysis(drives=(drives, drives), estimate=None, body=None).usable)
        120
        """
        return float(sum(one.usable for one in self.drives))

    @property
    def remarks(self) -> tuple[Check, ...]:
        """Remarks on the drive, without those on the estimate.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import DriveAnalysis, RawChannel, Recording, find_drives
        >>> t = np.arange(6000) / 100
        >>> body = 0.3 * np.random.default_rng(1).standard_normal(t.size)
        >>> rows = {"chassis": (body, "m/s2"), "speed": (np.full(t.size, 20.0), "m/s")}
        >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
        >>> drives = find_drives(Recording(title="ride", channels=tuple(made)))
        >>> DriveAnalysis(drives=(drives,), estimate=None, body=None).remarks == drives.remarks
        True
        """
        return (*self.notes, *(check for one in self.drives for check in one.remarks))

    @property
    def explains(self) -> bool:
        """Whether the car that was found explains the records, by its curves at least; true where none was sought.

        Examples
        --------
        >>> from suspid import DriveAnalysis
        >>> DriveAnalysis(drives=(), estimate=None, body=None).explains
        True
        """
        return self.estimate is None or self.estimate.explains or bool(self._by_curves)

    @property
    def _by_curves(self) -> tuple[str, ...]:
        """The dampers that are not viscous, where the curves explain what viscous dampers do not; else none."""
        if self.estimate is None or self.estimate.explains:
            return ()
        told = {one.name for one in self.curves if one.explains}
        bent = tuple(one.name for one in self.curves if one.explains and not one.linear)
        return bent if told.issuperset(dampers_above_wheels(self.estimate.suspension)) else ()

    @property
    def verdict(self) -> Verdict:
        """How far the result can be trusted: remarks on the drive, then on the estimate.

        Examples
        --------
        >>> from suspid import DriveAnalysis, Drives
        >>> DriveAnalysis(drives=(Drives(),), estimate=None, body=None).verdict.level.label
        'none'
        """
        found = self.estimate or self.body
        numbers = {"seconds": self.usable, "length": float(sum(one.length for one in self.drives))}
        if found is None and self.usable:
            return Verdict(Remark(DriveHeadline.NOTHING, numbers), self.remarks)
        if found is None:
            return nothing_usable([stretch for one in self.drives for stretch in one], self.remarks)
        code = DriveHeadline.SPRINGS if self.estimate else DriveHeadline.FREQUENCIES
        beside = () if self.wear is None else self.wear.verdict.checks
        every = [
            *self.remarks,
            *found.verdict.checks,
            *(check for check in beside if check.remark.code is GripCheck.STAYED_NOMINAL),
        ]
        if self._by_curves:
            # The residual follows the wheels because the dampers bend, and not because a part of the car is missing.
            every = [check for check in every if check.remark.code not in (EstimateCheck.FOLLOWS, DriveRemark.BENT)]
            every.insert(0, Check(Remark(DriveRemark.BY_CURVES, {"names": self._by_curves}), Level.CARE))
        checks = {str(check): check for check in every}
        return Verdict(Remark(code, numbers), tuple(checks.values()))

    def _brief(self) -> str:
        if self.estimate is not None:
            return self.estimate._brief()
        body = self.body or ()
        return (
            numbers_in_words([one.channel for one in body], [one.hertz for one in body], ["Hz"] * len(body))
            or "nothing"
        )

    def __str__(self) -> str:
        parts = [f"{one.title}: {one.verdict.headline}" for one in self.drives]
        if self.estimate is not None:
            parts += ["", parameter_table(self.estimate), *map(str, self.estimate.road), str(self.estimate.modes)]
            dampers = damper_table(self.curves, self.wear)
            parts += ["", dampers, ""] if dampers else []
            if self.wear is not None and self.wear.against != "nominal":
                parts += [str(self.wear), ""]
        elif self.body is not None:
            parts += ["", self.body.table()]
        return "\n".join([*parts, str(self.verdict)])
