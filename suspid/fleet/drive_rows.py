"""One drive of a fleet as rows of the tables: one for the drive, and one for each spring and damper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from suspid.analysis import DriveAnalysis, analyse_drive
from suspid.files import printable
from suspid.fleet.failures import failure, which
from suspid.fleet.job import DriveJob, Job
from suspid.fleet.records import Entry, Seen
from suspid.fleet.tables import Row, Rows, dampers_named, doubts_of, drives_layout
from suspid.greybox import Estimate, parameter_unit
from suspid.model import car_from_toml, value_in
from suspid.performance import DamperWear, Grip, Wear, rates_of
from suspid.recordings import RawChannel, Recording
from suspid.signals import as_signal
from suspid.words import Failure, Level, Remark, Step

if TYPE_CHECKING:
    import control

DRIVE_STEPS = {"reading": Step.READ, "finding stretches": Step.FIND_STRETCHES, "estimating": Step.ESTIMATE}


def drive_rows(
    job: Job,
    drive: DriveJob,
    entry: Entry,
    source: Path | control.TimeResponseData,
    began: Seen,
    know: Callable[[Seen], None],
) -> Rows:
    """Return the rows of a drive: those of `analyse_drive`, without curves of dampers.

    A drive without a usable stretch has a row, and one among the failures.
    """
    car = None if job.car is None else car_from_toml(job.car)
    how = job.settings.springs
    found = analyse_drive(
        source if isinstance(source, Path) else _recording(source, entry.name),
        car=car,
        settings=job.settings,
        limits=drive.limits,
        way=drive.way,
        unknowns={name: getattr(how, name) for name in ("fixed", "bounds", "ties", "nominal_std", "free_masses")},
        road=drive.road,
        wheel_radius=drive.wheel_radius,
        behind=drive.behind,
        curves=False,
        progress=lambda step: know(replace(began, step=DRIVE_STEPS[step])),
    )
    named = which(job, entry, began)
    values = _of_drive(found, entry) | _of_body(found)
    springs: tuple[Row, ...] = ()
    if found.estimate is not None:
        values |= _of_estimate(found.estimate)
        springs = tuple({**named, **row} for row in _springs(found.estimate, job.settings.level))
    if found.wear is not None:
        values |= _of_wear(found.wear)
    columns = drives_layout(car).columns["drives"]
    row = dict.fromkeys(columns) | named | {name: one for name, one in values.items() if name in columns}
    if found.verdict.level is not Level.NONE:
        return Rows(drives=(row,), springs=springs)
    checks = [str(doubt.code) for doubt in found.verdict.doubts]
    why = "; ".join(dict.fromkeys(map(str, found.verdict.doubts)))
    seen = replace(began, step=Step.FIND_STRETCHES)
    return replace(failure(job, entry, seen, Remark(Failure.NO_STRETCH, {"why": why}), checks), drives=(row,))


def _of_drive(found: DriveAnalysis, entry: Entry) -> dict[str, object]:
    verdict, stretches = found.verdict, [one for drives in found.drives for one in drives.taken]
    speeds, lengths = (np.array([getattr(one, name) for one in stretches]) for name in ("speed", "length"))
    known = np.isfinite(speeds)
    said = dict.fromkeys(map(str, (*verdict.doubts, *verdict.notes)))
    return {
        "vehicle": entry.vehicle,
        "time": entry.when,
        "verdict": verdict.level.label,
        **doubts_of(verdict),
        "notes": list(dict.fromkeys(str(note.code) for note in verdict.notes)),
        "remarks": printable("; ".join(said)),
        "stretches": len(stretches),
        "used_s": found.usable,
        "length_s": float(sum(one.length for one in found.drives)),
        "speed_m_per_s": float(np.average(speeds[known], weights=lengths[known])) if np.any(known) else None,
    }


def _of_body(found: DriveAnalysis) -> dict[str, object]:
    modes = [] if found.body is None else [mode for mode in found.body if np.isfinite(mode.hertz)]
    ends = [mode.interval() for mode in modes]
    return {
        "body_channels": [printable(mode.channel) for mode in modes],
        "body_hz": [mode.hertz for mode in modes],
        "body_low_hz": [low for low, _ in ends],
        "body_high_hz": [high for _, high in ends],
    }


def _of_estimate(found: Estimate) -> dict[str, object]:
    values: dict[str, object] = {
        "explains": found.explains,
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "road_wheels": [road.wheel for road in found.road],
        "road_classes": [road.road_class for road in found.road],
        "road_exponents": [road.exponent for road in found.road],
        "road_roughness_m3": [road.mean_roughness for road in found.road],
    }
    for name, value, std in zip(found.parameters, found.values.tolist(), found.std.tolist(), strict=True):
        values |= {name: value, f"{name}_std": std}
    values |= {name: value_in(found.nominal, name) for name in found.held}
    for damper in dampers_named(found.suspension):
        if f"{damper}.damping" in found.parameters:
            covariance = rates_of(found, damper).covariance
            scale = float(np.sqrt(covariance[0, 0] * covariance[1, 1]))
            values[f"{damper}.correlation"] = float(covariance[0, 1]) / scale if scale else 0.0
    return values


def _of_wear(found: Wear) -> dict[str, object]:
    values: dict[str, object] = {}
    for one in found.dampers:
        own = {"wear": str(one.state), "lost": one.loss.value, "lost_low": one.loss.low, "lost_high": one.loss.high}
        own |= {} if found.after is None else _of_grip(found.after, one)
        values |= {f"{one.damper}.{name}": value for name, value in own.items()}
    return values


def _of_grip(grip: Grip, one: DamperWear) -> Mapping[str, Any]:
    if one.wheel is None:
        return {}
    i = grip.wheels.index(one.wheel)
    figures = {"phase_rad": grip.phase, "phase_std_rad": grip.phase_std}
    figures |= {"adhesion": grip.adhesion, "adhesion_std": grip.adhesion_std}
    return {name: float(values[i]) for name, values in figures.items()}


def _springs(found: Estimate, level: float) -> list[dict[str, object]]:
    shared: dict[str, object] = {
        "explains": found.explains,
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "residual": None,
        "alternatives": len(found.alternatives),
        "status": None,
    }
    ends = found.interval(level)
    rows = [
        {"parameter": name, "value": value, "std": std, "low": ends[name][0], "high": ends[name][1], "held": False}
        for name, value, std in zip(found.parameters, found.values.tolist(), found.std.tolist(), strict=True)
    ]
    rows += [
        {"parameter": name, "value": value_in(found.nominal, name), "std": None, "low": None, "high": None,
         "held": True}
        for name in found.held
    ]  # fmt: skip
    return [{**row, "unit": parameter_unit(str(row["parameter"])), **shared} for row in rows]


def _recording(response: control.TimeResponseData, name: str) -> Recording:
    """Return samples in memory as a recording of channels in SI."""
    signal = as_signal(response)
    channels = (
        RawChannel(name=channel, unit="", timepts=signal.timepts, values=values, rate=None)
        for channel, values in zip(signal.channels, signal.values, strict=True)
    )
    return Recording(title=name, channels=tuple(channels))
