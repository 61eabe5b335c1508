"""The recipe for drives: read, find usable stretches, estimate the car over all of them, judge."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, TypeGuard

import numpy as np

from suspid.analysis.drive_analysis import DriveAnalysis
from suspid.analysis.drive_dampers import curves_of, wear_of
from suspid.analysis.drive_reading import read_drive
from suspid.analysis.settings import Settings
from suspid.arguments import explained
from suspid.cleaning import RecordLike, is_pair
from suspid.errors import EstimationError, InputError, RecordError
from suspid.files import naming, printable
from suspid.greybox import (
    DamperCurve,
    DriveLimits,
    Drives,
    Estimate,
    Led,
    RecordTest,
    body_modes,
    estimate,
    find_drives,
    wheels_missing,
    wheels_of,
)
from suspid.model import Suspension
from suspid.recordings import Recording
from suspid.signals import as_signal
from suspid.threads import in_one_thread
from suspid.units import Metre
from suspid.wording import Argument
from suspid.words import Check, Level, Remark
from suspid.words.drives import DriveRemark

LOGGER = "drive"  # all files of a drive come from one logger
Step = Callable[[str], None]


@explained
@in_one_thread
def analyse_drive(
    sources: Sequence[str | os.PathLike[str] | Recording | RecordLike]
    | str
    | os.PathLike[str]
    | Recording
    | RecordLike,
    *,
    car: Suspension | None = None,
    settings: Settings | None = None,
    limits: DriveLimits | None = None,
    way: Mapping[str, str | None] | None = None,
    unknowns: Mapping[str, Any] | None = None,
    road: Literal["iso8608"] | None = None,
    wheel_radius: Metre | None = None,
    behind: Led | None = None,
    before: Sequence[Estimate] = (),
    curves_before: Sequence[Sequence[DamperCurve]] = (),
    curves: bool = True,
    progress: Step | None = None,
) -> DriveAnalysis:
    """Return springs, dampers, curves and wear of a car from recorded drives.

    The files are read one after the other, and only their usable stretches are kept. Where the motion of all wheels
    was measured, springs and dampers are estimated over all stretches jointly (`estimate`, with the wheels given), the
    curve of each damper is found (`damper_curve`), and its wear and its wheel's grip are judged (`wear`). Where only
    the body was measured, its frequencies are found (`body_modes`); damping is not, because the road is not known.
    Usable stretches that do not determine springs and dampers give frequencies, and those that are too short for
    frequencies are a result without them; the result says so.

    Parameters
    ----------
    sources : str, path, Recording, control.TimeResponseData or what `as_record` takes, or a list of them
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
    behind : mapping of str to (str, float), optional
        Which road follows which, and how far behind [m], with a model of the road; see `estimate`.
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
        If a file cannot be read, or does not fit the car; see `find_drives` and `estimate`.

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
    every: list[Any] = list(sources) if _are_several(sources) else [sources]
    if not every:
        raise InputError("no recording of a drive given; name at least one file")
    settings, step = settings or Settings(), progress or (lambda _: None)
    drives = []
    for number, source in enumerate(every, start=1):
        step("reading")
        titled = str(getattr(source, "title", None) or f"record {number}")
        name = os.fspath(source) if isinstance(source, str | os.PathLike) else titled
        with naming(name):
            recording, said = read_drive(source, settings)
            step("finding stretches")
            renamed = dict(settings.rename)
            chosen = [renamed.get(name, name) for name in settings.channels] if settings.channels else None
            found = find_drives(recording, car=car, channels=chosen, limits=limits, **dict(way or {}))
            drives.append(replace(found, remarks=(*said, *found.remarks)))
            del recording
    records = [record for one in drives for record in one.records]
    if not records:
        return DriveAnalysis(drives=tuple(drives), estimate=None, body=None)
    wheels = () if car is None else wheels_of(car)
    missing = () if car is None else _missing(car, drives)
    step("estimating")
    notes = [Check(Remark(DriveRemark.NO_WHEELS, {"names": missing}), Level.NOTE)] if missing else []
    if car is not None and wheels and not missing:
        rolling = _rolling(drives, road, wheel_radius)
        if behind and road is not None and rolling["speed"] is None:
            notes.append(Check(Remark(DriveRemark.NO_DELAY), Level.CARE))
        else:
            rolling["behind"] = behind
        try:
            whole = _with_dampers(
                drives, car, {**dict(unknowns or {}), **rolling}, (before, curves_before), step if curves else None
            )
            return replace(whole, notes=(*notes, *whole.notes))
        except (RecordError, EstimationError) as error:
            notes.append(Check(Remark(DriveRemark.NO_SPRINGS, {"why": error.wording}), Level.CARE))
    elif road is not None or behind or before:
        raise InputError(
            *(Argument("road"), ", ", Argument("behind"), " and ", Argument("before")),
            " need springs and dampers: give a car, and a channel for the motion of each wheel"
            + (f" (not shown: {', '.join(missing)})" if missing else ""),
        )
    try:
        body = body_modes(records, car=car)
    except RecordError as error:
        notes.append(Check(Remark(DriveRemark.NO_FREQUENCIES, {"why": error.wording}), Level.NONE))
        return DriveAnalysis(drives=tuple(drives), estimate=None, body=None, notes=tuple(notes))
    return DriveAnalysis(drives=tuple(drives), estimate=None, body=body, notes=tuple(notes))


def _are_several(sources: object) -> TypeGuard[Iterable[Any]]:
    """Return whether sources are several records, no path, table, array or pair of time and samples."""
    if isinstance(sources, str | os.PathLike | Recording | Mapping) or is_pair(sources):
        return False
    return isinstance(sources, Iterable) and not any(
        hasattr(sources, one) for one in ("shape", "dims", "output_labels")
    )


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
