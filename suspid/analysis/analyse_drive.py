"""The recipe for drives: read, find usable stretches, estimate the car over all of them, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from suspid.analysis.drive_reading import read_drive
from suspid.analysis.reading import naming
from suspid.analysis.settings import Settings
from suspid.errors import InputError
from suspid.files import printable
from suspid.greybox import (
    BodyModes,
    DriveLimits,
    Drives,
    Estimate,
    RecordTest,
    body_modes,
    estimate,
    find_drives,
    parameter_table,
    wheels_missing,
    wheels_of,
)
from suspid.model import Suspension
from suspid.recordings import Recording
from suspid.results import Result, columns_of
from suspid.signals import as_signal
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.drives import DriveHeadline, DriveRemark

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
    """

    drives: tuple[Drives, ...]
    estimate: Estimate | None
    body: BodyModes | None
    notes: tuple[Check, ...] = ()

    def _table(self) -> Mapping[str, Sequence[object]]:
        if self.estimate is not None:
            return self.estimate._table()
        return columns_of(self.body or (), ["channel", "hertz"])

    @property
    def usable(self) -> float:
        """Length of all usable stretches together [s]."""
        return float(sum(one.usable for one in self.drives))

    @property
    def explains(self) -> bool:
        """Whether the car that was found explains the records; true where none was looked for."""
        return self.estimate is None or self.estimate.explains

    @property
    def verdict(self) -> Verdict:
        """How far the result can be trusted: what is said of the drive, then of what was found in it."""
        found = self.estimate or self.body
        numbers = {"seconds": self.usable, "length": float(sum(one.length for one in self.drives))}
        said = [*self.notes, *(check for one in self.drives for check in one.remarks)]
        if found is None:
            return Verdict(
                Remark(DriveRemark.NONE, numbers), (Check(Remark(DriveRemark.NONE, numbers), Level.NONE), *said)
            )
        code = DriveHeadline.SPRINGS if self.estimate else DriveHeadline.FREQUENCIES
        checks = {str(check): check for check in [*said, *found.verdict.checks]}
        return Verdict(Remark(code, numbers), tuple(checks.values()))

    def __str__(self) -> str:
        parts = [f"{one.title}: {one.verdict.headline}" for one in self.drives]
        if self.estimate is not None:
            parts += ["", parameter_table(self.estimate), str(self.estimate.modes)]
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
    progress: Step | None = None,
) -> DriveAnalysis:
    """Return what a recorded drive tells of a car.

    The files are read one after the other, and only their usable stretches are kept. Where the motion of all wheels
    was measured, springs and dampers are estimated over all stretches jointly (`estimate`, with the wheels given).
    Where only the body was measured, its frequencies are found (`body_modes`); damping is not, because the road is
    not known.

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
        with naming(printable(name)):
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
    missing = () if car is None else wheels_missing(car, as_signal(records[0]).channels)
    if car is not None and wheels and not missing:
        step("estimating")
        tests = [RecordTest(record=record, logger=LOGGER) for record in records]
        found = estimate(tests, car, given=wheels, **dict(unknowns or {}))
        return DriveAnalysis(drives=tuple(drives), estimate=found, body=None)
    step("estimating")
    notes = [Check(Remark(DriveRemark.NO_WHEELS, {"names": missing}), Level.NOTE)] if missing else []
    body = body_modes(records, car=car)
    return DriveAnalysis(drives=tuple(drives), estimate=None, body=body, notes=tuple(notes))
