"""Find the usable stretches of a recorded drive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.cleaning import Finding, RecordLike, as_record, parts_of
from suspid.errors import InputError, RecordError
from suspid.greybox.blocks import examined
from suspid.greybox.car_records import renaming
from suspid.greybox.channel_words import names_speed
from suspid.greybox.drive_limits import DriveLimits
from suspid.greybox.drives import Drive, Drives
from suspid.greybox.shaken import moving, order_in, said_of, said_of_level, said_of_units, shaken_of
from suspid.greybox.speeds import way_of
from suspid.greybox.stretches import judged, stretches_of
from suspid.model import Suspension
from suspid.recordings import RawChannel, Recording
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.values import frozen_real, listed
from suspid.wording import Argument, AtCommandLine
from suspid.words import MOST_LISTED, Check, Defect, Level, Number, Remark
from suspid.words.drives import DriveRemark

if TYPE_CHECKING:
    import control


@explained
def find_drives(
    recording: Recording | RecordLike,
    *,
    car: Suspension | None = None,
    channels: Sequence[str] | None = None,
    speed: str | None = None,
    speed_unit: str | None = None,
    longitudinal: str | None = None,
    lateral: str | None = None,
    limits: DriveLimits | None = None,
) -> Drives:
    """Return the stretches of a recorded drive, and which are usable.

    A stretch is usable where the car moves, does not brake or corner hard, and the channels that show its motion are
    there and in range.
    It is decided for blocks of a second; pauses of the logger part a recording.

    Parameters
    ----------
    recording : Recording, control.TimeResponseData or what `as_record` takes
        The recording, of any length, with channels on any clocks.
    car : Suspension, optional
        The channels that measure it, named as its outputs or sensors, are those that must be usable.
    channels : sequence of str, optional
        The channels that must be usable. Default: those that measure the car; without one, the displacements,
        velocities, accelerations and rotation rates on the fastest clock; if nothing says what channels measure, all.
    speed : str, optional
        The channel of speed, in any unit. Default: the one named like a speed, in a unit of speed, or the only one in
        km/h, mph or knots. ``"none"``, and where there is none: the vibration shows whether the car moves.
    speed_unit : str, optional
        Unit of the speed, where the file states none: ``"km/h"``, ``"m/s"``, ``"mph"``, ``"kn"``.
    longitudinal, lateral : str, optional
        Channels of acceleration along and across the car. Default: by their names, or the axes of a sensor that are
        level by gravity, or the axes x and y. Braking is judged by the speed as well, cornering by the speed and a
        channel of yaw rate.
    limits : DriveLimits, optional
        Limits of usable stretches.

    Returns
    -------
    Drives
        All stretches with the reasons, and the records of those that were taken.

    Raises
    ------
    InputError
        If a channel is missing, or has no suitable unit.
    RecordError
        If no part of the recording has a clock.

    Examples
    --------
    >>> t = np.arange(6000) / 100
    >>> speed = np.clip(2.0 * (t - 20), 0, 20)
    >>> body = (0.3 * (speed > 0) + 0.002) * np.random.default_rng(1).standard_normal(t.size)
    >>> rows = {"chassis": (body, "m/s2"), "speed": (3.6 * speed, "km/h")}
    >>> made = [RawChannel(name=n, unit=u, timepts=t, values=v, rate=None) for n, (v, u) in rows.items()]
    >>> for one in find_drives(Recording(title="ride", channels=tuple(made))):
    ...     print(one)
    0 … 22 s left: slower than 3 m/s (down to 0 m/s); braking or accelerating with up to 2 m/s2 (limit 1.5 m/s2)
    22 … 30 s left: braking or accelerating with up to 2 m/s2 (limit 1.5 m/s2)
    30 … 60 s taken: moving at 20 m/s
    """
    whole, limits = recording_of(recording), limits or DriveLimits()
    needed = _needed(whole, car, channels)
    # The speed is that of the car also where it is named among the channels.
    own = [name for name in needed or () if order_in(car, name) is not None or not names_speed(name)]
    way = way_of(whole, speed=speed, speed_unit=speed_unit, longitudinal=longitudinal, lateral=lateral, without=own)
    free = [c for c in whole.channels if c.name not in way.names]
    said: list[Check] = []
    if needed is None:
        needed, said = _shaking(_fastest(free), limits)
    shaken = shaken_of(whole, needed, car)
    said += said_of(shaken, by_vibration=way.speed is None)
    said += said_of_units(whole, shaken)
    stretches: list[Drive] = []
    records: list[control.TimeResponseData] = []
    speeds: list[RealArray] = []
    course: list[RealArray] = []
    outliers: list[Finding] = []
    parts = parts_of([whole[name] for name in needed])
    for part in parts:
        try:
            blocks = examined(part, way, shaken, limits)
        except RecordError as error:
            if len(parts) == 1:
                raise
            ends = part[0].timepts[np.isfinite(part[0].timepts)]
            numbers: dict[str, Number] = {
                "start": float(np.min(ends)),
                "stop": float(np.max(ends)),
                "why": error.wording,
            }
            said.append(Check(Remark(DriveRemark.UNREADABLE, numbers), Level.CARE))
            continue
        if isinstance(blocks, Drive):
            stretches.append(blocks)
            continue
        outliers += [one for one in blocks.part.findings if one.remark.code is Defect.SENTINEL]
        found, kept, going = stretches_of(blocks, limits, whole.title)
        course.append(blocks.course)
        stretches += found
        records += kept
        speeds += going
    return Drives(
        stretches=tuple(stretches),
        records=tuple(records),
        speeds=tuple(speeds),
        remarks=(*said, *said_of_level(course), *_far_off(outliers), *judged(way)),
        title=whole.title,
        course=frozen_real(np.concatenate(course)) if course else np.empty((0, 3)),
    )


def _far_off(outliers: Sequence[Finding]) -> list[Check]:
    if not outliers:
        return []
    numbers: dict[str, Number] = {
        "channels": tuple(dict.fromkeys(one.channel for one in outliers)),
        "samples": sum(one.samples for one in outliers),
        "start": min(one.start for one in outliers),
    }
    return [Check(Remark(DriveRemark.OUTLIERS, numbers), Level.NOTE)]


def recording_of(recording: Recording | RecordLike) -> Recording:
    """Return a recording as it is, and a response or a table as one, without units.

    Examples
    --------
    >>> recording_of((np.arange(3) / 10, np.zeros(3))).names
    ('y[0]',)
    """
    if isinstance(recording, Recording):
        return recording
    signal = as_signal(as_record(recording))
    t = signal.timepts
    return Recording(
        title=str(getattr(recording, "title", None) or ""),
        channels=tuple(
            RawChannel(name=name, unit="", timepts=t, values=row, rate=1 / signal.step)
            for name, row in zip(signal.channels, signal.values, strict=True)
        ),
    )


def _needed(recording: Recording, car: Suspension | None, channels: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the channels that must be usable; None where neither they nor a car say."""
    if channels is not None:
        if not len(channels):
            raise InputError("channels is empty; name those that must be usable, or leave it out")
        return tuple(recording[name].name for name in channels)
    if car is None:
        return None
    known = tuple(name for name in recording.names if order_in(car, name) is not None)
    if not known:
        such = f"{car.coordinates[0]}_acceleration"
        raise InputError(
            f"no channel of the recording measures the car: {', '.join(map(repr, recording.names[:10]))}; rename them "
            f"to outputs or sensors of the car, such as {such!r}",
            AtCommandLine("rename", renaming(recording.names[0], such)),
        )
    return known


def _shaking(channels: Sequence[RawChannel], limits: DriveLimits) -> tuple[tuple[str, ...], list[Check]]:
    """Return the names of the channels that show motion of the car, and that others were left out."""
    kept = tuple(channel.name for channel in moving(channels, limits.stuck))
    others = tuple(channel.name for channel in channels if channel.name not in kept)
    if not kept:
        raise InputError(
            f"no channel of the recording is known to measure motion of the car: {listed(others[:MOST_LISTED])}"
            f"{f' and {len(others) - MOST_LISTED} others' * (len(others) > MOST_LISTED)}; name those that do in ",
            Argument("channels"),
        )
    return kept, [Check(Remark(DriveRemark.NO_MOTION, {"channels": others}), Level.NOTE)] if others else []


def _fastest(channels: Sequence[RawChannel]) -> list[RawChannel]:
    """Return the channels on the fastest clock, and on others as fast."""
    if not channels:
        raise InputError("the recording has no channel beside those of the motion along the way")
    rates = [channel.mean_rate for channel in channels]
    best = np.nanmax(rates) if np.any(np.isfinite(rates)) else np.nan
    return [c for c, rate in zip(channels, rates, strict=True) if not rate < 0.5 * best]
