"""The recipe for drives: read, find usable stretches, estimate the car over all of them, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from suspid.analysis.damper_table import damper_table
from suspid.analysis.drive_dampers import curves_of, dampers_above_wheels, wear_of
from suspid.analysis.drive_reading import read_drive
from suspid.analysis.settings import Settings
from suspid.errors import InputError
from suspid.files import naming, printable
from suspid.greybox import (
    BodyModes,
    DamperCurve,
    DriveLimits,
    Drives,
    Estimate,
    RecordTest,
    body_modes,
    estimate,
    find_drives,
    left_for,
    parameter_table,
    wheels_missing,
    wheels_of,
)
from suspid.model import Suspension
from suspid.performance import Wear
from suspid.recordings import Recording
from suspid.results import Result, columns_of
from suspid.signals import as_signal
from suspid.units import Metre
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.drives import DriveHeadline, DriveRemark
from suspid.words.greybox import EstimateCheck

LOGGER = "drive"  # all files of a drive come from one logger
Step = Callable[[str], None]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DriveAnalysis(Result):
    """What a recorded drive tells of a car.

    Parameters
    ----------
    drives : tuple of Drives
        The stretches of each file, taken and left.
    estimate : Estimate or None
        Springs and dampers, where the wheels were measured.
    body : BodyModes or None
        Frequencies of the body, where only the body was measured.
    notes : tuple of Check
        What else is to be said.
    curves : tuple of DamperCurve
        Curves of the dampers above the wheels, as far as the sensors tell them.
    wear : Wear or None
        Wear and grip of the dampers, against earlier estimates or nominal values.

    Examples
    --------
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
        """Length of all usable stretches together [s]."""
        return float(sum(one.usable for one in self.drives))

    @property
    def remarks(self) -> tuple[Check, ...]:
        """What is said of the drive, beside what is said of what was found in it."""
        return (*self.notes, *(check for one in self.drives for check in one.remarks))

    @property
    def explains(self) -> bool:
        """Whether the car that was found explains the records, by its curves at least; true where none was sought."""
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
        """How far the result can be trusted: what is said of the drive, then of what was found in it."""
        found = self.estimate or self.body
        numbers = {"seconds": self.usable, "length": float(sum(one.length for one in self.drives))}
        if found is None:
            why = left_for([stretch for one in self.drives for stretch in one])
            none = Remark(DriveRemark.NONE, {**numbers, "why": why})
            return Verdict(none, (Check(none, Level.NONE), *self.remarks))
        code = DriveHeadline.SPRINGS if self.estimate else DriveHeadline.FREQUENCIES
        every = [*self.remarks, *found.verdict.checks]
        if self._by_curves:
            # What is left follows the wheels because the dampers bend, and not because a part of the car is missing.
            every = [check for check in every if check.remark.code not in (EstimateCheck.FOLLOWS, DriveRemark.BENT)]
            every.insert(0, Check(Remark(DriveRemark.BY_CURVES, {"names": self._by_curves}), Level.CARE))
        checks = {str(check): check for check in every}
        return Verdict(Remark(code, numbers), tuple(checks.values()))

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


def analyse_drive(
    sources: Sequence[str | os.PathLike[str] | Recording] | str | os.PathLike[str] | Recording,
    *,
    car: Suspension | None = None,
    settings: Settings | None = None,
    limits: DriveLimits | None = None,
    way: Mapping[str, str | None] | None = None,
    unknowns: Mapping[str, Any] | None = None,
    road: Literal["iso8608"] | None = None,
    wheel_radius: Metre | None = None,
    before: Sequence[Estimate] = (),
    curves_before: Sequence[Sequence[DamperCurve]] = (),
    curves: bool = True,
    progress: Step | None = None,
) -> DriveAnalysis:
    """Return what a recorded drive tells of a car.

    The files are read one after the other, and only their usable stretches are kept. Where the motion of all wheels
    was measured, springs and dampers are estimated over all stretches jointly (`estimate`, with the wheels given), the
    curve of each damper is found (`damper_curve`), and its wear and its wheel's grip are judged (`wear`). Where only
    the body was measured, its frequencies are found (`body_modes`); damping is not, because the road is not known.

    Parameters
    ----------
    sources : str, path or Recording, or sequence of them
        Recordings of one drive, or of several of one car with the same sensors.
    car : Suspension, optional
        Masses and nominal struts; channels are named as its outputs or sensors. Without one: frequencies alone.
    settings : Settings, optional
        How the files are read; its channels are those that must be usable, others are read for the speed.
    limits : DriveLimits, optional
        Which stretches are usable.
    way : mapping, optional
        Arguments ``speed``, ``speed_unit``, ``longitudinal``, ``lateral`` of `find_drives`.
    unknowns : mapping, optional
        Arguments of `estimate`, such as ``fixed`` and ``bounds``.
    road : "iso8608", optional
        Model of the road, for tires, the modes of the whole car and the road's class; see `estimate`. The speed is that
        of the drive.
    wheel_radius : float, optional
        Rolling radius of the wheels [m], with a model of the road.
    before : sequence of Estimate, optional
        Earlier estimates of this car, in order of time, that the dampers are compared with. Default: nominal values.
    curves_before : sequence of sequences of DamperCurve, optional
        Curves of dampers in earlier drives, which those that are not viscous are compared with; see `wear`.
    curves : bool
        Whether curves of dampers are sought, which takes seconds for each.
    progress : callable, optional
        Called with the name of each step.

    Returns
    -------
    DriveAnalysis
        The stretches, what was found, and the verdict.

    Raises
    ------
    SuspidError
        If a file cannot be read, or no car can be estimated; see `find_drives` and `estimate`.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import quarter_car, road_profile, simulate
    >>> from suspid.recordings import RawChannel
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> t = np.arange(0, 60, 0.005)
    >>> road = road_profile(20.0 * t, roughness="B", rng=np.random.default_rng(1))
    >>> outputs = ["chassis_acceleration", "tire_acceleration"]
    >>> driven = simulate(car, t, {"road": road}, outputs=outputs)
    >>> made = [RawChannel(name=n, unit="m/s2", timepts=t, values=y, rate=None) for n, y in zip(outputs, driven.y)]
    >>> nominal = car.with_parameters(stiffness={"chassis": 25e3})
    >>> found = analyse_drive(Recording(title="ride", channels=tuple(made)), car=nominal)
    >>> print(f"{found.estimate.suspension.struts[0].stiffness / 1e3:.1f} kN/m")
    20.0 kN/m
    """
    every = [sources] if isinstance(sources, str | os.PathLike | Recording) else list(sources)
    if not every:
        raise InputError("there is no recording of a drive; name a file at least")
    settings, step = settings or Settings(), progress or (lambda _: None)
    drives = []
    for source in every:
        step("reading")
        name = source.title if isinstance(source, Recording) else os.fspath(source)
        with naming(name):
            recording = read_drive(source, settings)
            step("finding stretches")
            renamed = dict(settings.rename)
            chosen = [renamed.get(name, name) for name in settings.channels] if settings.channels else None
            drives.append(find_drives(recording, car=car, channels=chosen, limits=limits, **dict(way or {})))
            del recording
    records = [record for one in drives for record in one.records]
    if not records:
        return DriveAnalysis(drives=tuple(drives), estimate=None, body=None)
    wheels = () if car is None else wheels_of(car)
    missing = () if car is None else _missing(car, drives)
    step("estimating")
    if car is not None and wheels and not missing:
        rolling = _rolling(drives, road, wheel_radius)
        return _with_dampers(
            drives, car, {**dict(unknowns or {}), **rolling}, (before, curves_before), step if curves else None
        )
    if road is not None or before:
        raise InputError(
            "road and before need springs and dampers: give a car, and a channel for the motion of each wheel"
            + (f" (not shown: {', '.join(missing)})" if missing else "")
        )
    notes = [Check(Remark(DriveRemark.NO_WHEELS, {"names": missing}), Level.NOTE)] if missing else []
    body = body_modes(records, car=car)
    return DriveAnalysis(drives=tuple(drives), estimate=None, body=body, notes=tuple(notes))


def _rolling(drives: Sequence[Drives], road: str | None, radius: Metre | None) -> dict[str, Any]:
    """Return the arguments of `estimate` on the road; a speed that is lost somewhere is not known."""
    speeds = [speed for one in drives for speed in one.speeds]
    known = road is not None and all(np.all(np.isfinite(speed)) for speed in speeds)
    return {"road": road, "wheel_radius": radius, "speed": speeds if known else None}


def _with_dampers(
    drives: Sequence[Drives],
    car: Suspension,
    asked: Mapping[str, Any],
    earlier: tuple[Sequence[Estimate], Sequence[Sequence[DamperCurve]]],
    step: Step | None,
) -> DriveAnalysis:
    """Return springs and dampers, with the wear of the latter, and with their curves if there is a step for them."""
    records = [record for one in drives for record in one.records]
    tests = [RecordTest(record=record, logger=LOGGER) for record in records]
    found = estimate(tests, car, given=wheels_of(car), **asked)
    before, curves_before = earlier
    if step is None:
        judged, no_wear = wear_of(found, before)
        return DriveAnalysis(drives=tuple(drives), estimate=found, body=None, notes=no_wear, wear=judged)
    step("finding curves")
    curves, notes = curves_of(records, found, LOGGER)
    judged, no_wear = wear_of(found, before, curves, curves_before)
    bent = tuple(one.name for one in curves if one.explains and not one.linear)
    if bent:
        notes = (Check(Remark(DriveRemark.BENT, {"names": bent}), Level.NOTE), *notes)
    return DriveAnalysis(
        drives=tuple(drives), estimate=found, body=None, notes=(*notes, *no_wear), curves=curves, wear=judged
    )


def _missing(car: Suspension, drives: Sequence[Drives]) -> tuple[str, ...]:
    """Return the wheels that no channel shows; refuse recordings that show different ones."""
    seen = [(wheels_missing(car, as_signal(one.records[0]).channels), one.title) for one in drives if one.records]
    least, most = min(seen, key=lambda each: len(each[0])), max(seen, key=lambda each: len(each[0]))
    if least[0] != most[0]:
        raise InputError(
            f"{printable(most[1])} lacks a channel of the motion of {', '.join(map(repr, most[0]))}, which "
            f"{printable(least[1])} has: leave one of them out, or rename its channels"
        )
    return least[0]
