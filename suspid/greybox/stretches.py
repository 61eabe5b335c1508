"""Blocks of a drive as stretches with reasons, and the records of those that are usable."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.greybox.blocks import Blocks
from suspid.greybox.drive_limits import DriveLimits
from suspid.greybox.drives import Drive
from suspid.greybox.speeds import Way
from suspid.records import as_response
from suspid.units import Flags, RealArray
from suspid.values import frozen_real
from suspid.words import Check, Level, Number, Remark
from suspid.words.drives import DriveReason, DriveRemark

if TYPE_CHECKING:
    import control


def stretches_of(
    blocks: Blocks, limits: DriveLimits, title: str
) -> tuple[list[Drive], list[control.TimeResponseData], list[RealArray]]:
    """Return all stretches of a part of a recording; of those that were taken the records, and speeds by sample."""
    bad = np.any(list(blocks.flags.values()), axis=0)
    found, records, speeds = [], [], []
    for first, after in zip(*_alike(blocks, bad), strict=True):
        start, stop = _ends(blocks, first, after)
        taken = not bad[first] and stop - start >= limits.shortest - 0.5 * blocks.part.step
        reasons = _against(blocks, first, after, limits) if bad[first] else (_moving(blocks, first, after),)
        if not bad[first] and not taken:
            reasons = (Remark(DriveReason.SHORT, {"length": stop - start, "least": limits.shortest}),)
        speed = blocks.going.speed[first:after]
        mean = float(np.nanmean(speed)) if np.any(np.isfinite(speed)) else float("nan")
        found.append(Drive(start=start, stop=stop, taken=taken, reasons=reasons, speed=mean))
        if taken:
            inside = slice(first * blocks.size, after * blocks.size)
            part = blocks.part
            records.append(as_response(part.timepts[inside], part.values[:, inside], part.channels, title=title))
            speeds.append(_by_sample(speed, blocks.size))
    return found, records, speeds


def _by_sample(speed: RealArray, size: int) -> RealArray:
    """Return the speed at each sample of blocks, straight between their middles; NaN where no block knows it."""
    known = np.flatnonzero(np.isfinite(speed))
    if not known.size:
        return frozen_real(np.full(len(speed) * size, np.nan))
    return frozen_real(np.interp((np.arange(len(speed) * size) + 0.5) / size - 0.5, known, speed[known]))


def _alike(blocks: Blocks, bad: Flags) -> tuple[list[int], list[int]]:
    """Return the first block of each stretch and the one after its last: usable ones, or of one gravest reason."""
    gravest = np.full(blocks.count, -1)
    for number, flags in enumerate(blocks.flags.values()):
        gravest[(gravest < 0) & flags] = number
    ends = np.flatnonzero(np.diff(np.where(bad, gravest, -1))) + 1
    return [0, *ends.tolist()], [*ends.tolist(), blocks.count]


def _ends(blocks: Blocks, first: int, after: int) -> tuple[float, float]:
    start, step = float(blocks.part.timepts[0]), blocks.part.step
    return start + step * blocks.size * first, start + step * blocks.size * after


def _moving(blocks: Blocks, first: int, after: int) -> Remark:
    speed = blocks.going.speed[first:after]
    if np.any(np.isfinite(speed)):
        return Remark(DriveReason.MOVING, {"low": float(np.nanmin(speed)), "high": float(np.nanmax(speed))})
    return Remark(DriveReason.VIBRATING, {"level": float(np.median(blocks.level[first:after]))})


def _against(blocks: Blocks, first: int, after: int, limits: DriveLimits) -> tuple[Remark, ...]:
    """Return the reasons that a stretch was left for, the gravest first."""
    found = []
    for reason, flags in blocks.flags.items():
        here = flags[first:after]
        if not np.any(here):
            continue
        numbers: dict[str, Number]
        if reason in blocks.faults:
            by_channel = blocks.faults[reason].items()
            numbers = {"channels": tuple(name for name, where in by_channel if np.any(where[first:after] & here))}
        elif reason is DriveReason.SLOW:
            numbers = {"limit": limits.least_speed, "low": _most(-blocks.going.speed[first:after], sign=-1)}
        elif reason is DriveReason.STANDING:
            numbers = {"limit": limits.least_vibration, "level": float(np.median(blocks.level[first:after][here]))}
        elif reason is DriveReason.QUIET:
            numbers = {
                "limit": limits.least_vibration,
                "level": float(np.median(blocks.level[first:after][here])),
                "channel": blocks.unread,
                "most": _most(blocks.going.unread[first:after][here]),
            }
        elif reason is DriveReason.ROLLING:
            numbers = {
                "limit": limits.least_vibration,
                "level": float(np.median(blocks.loudest[first:after][here])),
                "speed": _most(blocks.going.speed[first:after][here]),
            }
        elif reason is DriveReason.BRAKING:
            numbers = {"limit": limits.longitudinal, "most": _most(blocks.going.longitudinal[first:after])}
        else:
            numbers = {"limit": limits.lateral, "most": _most(blocks.going.lateral[first:after])}
        found.append(Remark(reason, numbers))
    return tuple(found)


def _most(values: RealArray, *, sign: int = 1) -> float:
    return sign * float(np.nanmax(values))


def judged(way: Way) -> list[Check]:
    """Return what could not be judged of a drive, and what was taken for granted to judge it."""
    said = []
    if way.speed is None:
        said.append(Check(Remark(DriveRemark.NO_SPEED), Level.NOTE))
    if way.unused is not None:
        channel, why = way.unused
        said.append(Check(Remark(DriveRemark.SPEED_UNUSED, {"channel": channel, "why": why}), Level.CARE))
    if way.speed is None and way.longitudinal is None:
        said.append(Check(Remark(DriveRemark.BRAKING_UNKNOWN), Level.CARE))
    if way.lateral is None and (way.yaw is None or way.speed is None):
        said.append(Check(Remark(DriveRemark.CORNERING_UNKNOWN), Level.CARE))
    elif way.upright and way.yaw is not None and way.speed is not None:
        said.append(Check(Remark(DriveRemark.YAW_BY_GRAVITY, {"channel": way.yaw.name}), Level.NOTE))
    if way.by_unit and way.speed is not None:
        said.append(Check(Remark(DriveRemark.SPEED_BY_UNIT, {"channel": way.speed.name}), Level.NOTE))
    if way.by_axis:
        said.append(Check(Remark(DriveRemark.BY_AXIS, {"channels": way.by_axis}), Level.NOTE))
    return said
