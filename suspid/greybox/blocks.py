"""Reasons for and against each block of a recorded drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import MOST_FILLED, Aligned, aligned, clipped_times, stuck_times
from suspid.errors import RecordError
from suspid.greybox.drive_limits import DriveLimits
from suspid.greybox.drives import Drive
from suspid.greybox.shaken import Shaken, usually_held
from suspid.greybox.speeds import KMH, Going, Way, going
from suspid.recordings import RawChannel
from suspid.signals import PASSED
from suspid.units import Flags, RealArray, Second
from suspid.words import Remark
from suspid.words.drives import DriveReason


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Blocks:
    """What was found in each block of a part of a recording."""

    part: Aligned
    size: int  # samples of a block
    going: Going
    level: RealArray  # (block,): vibration of the loudest channel that decides [m/s2]
    loudest: RealArray  # (block,): vibration of the loudest channel on the body [m/s2]; inf where none tells
    unread: str | None  # name of what may be the speed, in an unknown unit
    flags: Mapping[DriveReason, Flags]  # reasons against, the gravest first
    faults: Mapping[DriveReason, Mapping[str, Flags]]  # those of channels, by channel

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.level)

    @property
    def course(self) -> RealArray:
        """Middle [s], speed [m/s] and vibration [m/s2] of each block, (block, 3)."""
        middles = self.part.timepts[0] + self.part.step * self.size * (np.arange(self.count) + 0.5)
        return np.column_stack([middles, self.going.speed, self.level])


def examined(part: Sequence[RawChannel], way: Way, shaken: Shaken, limits: DriveLimits) -> Blocks | Drive:
    """Return what speaks against each block of a part of a recording; the stretch to leave if it has no block."""
    together = aligned(part)
    least = limits.band_hz[0] / PASSED
    if together.step * least > 1:
        raise RecordError(
            f"{1 / together.step:.3g} Hz is too slow for a drive: vibration is judged from "
            f"{limits.band_hz[0]:g} Hz on, which needs {least:g} Hz"
        )
    size = max(2, round(limits.block / together.step))
    count = together.timepts.size // size
    if not count:
        start, length = float(together.timepts[0]), together.timepts.size * together.step
        brief = Remark(DriveReason.BRIEF, {"length": length, "block": limits.block})
        return Drive(start=start, stop=start + length, taken=False, reasons=(brief,), speed=float("nan"))
    edges = together.timepts[0] + together.step * size * np.arange(count + 1)
    moves = going(way, edges)
    faults, levels = _faults(part, together, shaken, limits, edges, way)
    deciding = np.array([level for name, level in levels.items() if name in shaken.judged])
    level = np.max(np.where(np.isnan(deciding), 0.0, deciding), axis=0, initial=0.0)
    # A channel that is stuck tells nothing of a road.
    body = np.array([np.where(np.isnan(one), np.inf, one) for name, one in levels.items() if name in shaken.body])
    loudest = np.max(body, axis=0, initial=0.0) if shaken.upright else np.full(count, np.inf)
    known = np.isfinite(moves.speed)
    slow, still = known & (moves.speed < limits.least_speed), ~known & (level < limits.least_vibration)
    clear = {reason: np.any(list(by_channel.values()), axis=0) for reason, by_channel in faults.items()}
    still &= ~clear[DriveReason.MISSING]
    quiet = still & (np.nan_to_num(moves.unread) >= limits.least_speed * KMH)
    rolling = known & (moves.speed >= limits.least_speed) & (loudest < limits.least_vibration)
    return Blocks(
        part=together,
        size=size,
        going=moves,
        level=level,
        loudest=loudest,
        unread=None if way.unread is None else way.unread.name,
        faults=faults,
        flags={
            DriveReason.MISSING: clear[DriveReason.MISSING],
            DriveReason.CLIPPED: clear[DriveReason.CLIPPED],
            DriveReason.SLOW: slow,
            DriveReason.STANDING: still & ~quiet,
            DriveReason.QUIET: quiet,
            DriveReason.ROLLING: rolling & ~clear[DriveReason.MISSING],
            DriveReason.STUCK: clear[DriveReason.STUCK] & ~slow & ~still,
            DriveReason.BRAKING: moves.longitudinal > limits.longitudinal,
            DriveReason.CORNERING: moves.lateral > limits.lateral,
        },
    )


def _faults(
    part: Sequence[RawChannel], together: Aligned, shaken: Shaken, limits: DriveLimits, edges: RealArray, way: Way
) -> tuple[dict[DriveReason, dict[str, Flags]], dict[str, RealArray]]:
    """Return what is wrong with each channel, and the vibration of those that show it; NaN where it is stuck."""
    faults: dict[DriveReason, dict[str, Flags]]
    faults = {reason: {} for reason in (DriveReason.MISSING, DriveReason.CLIPPED, DriveReason.STUCK)}
    levels, count = dict[str, RealArray](), len(edges) - 1
    size = together.timepts.size // count
    for row, channel in enumerate(part):
        values = together.values[row, : count * size].reshape(count, size)
        filled = together.filled[row, : count * size].reshape(count, size)
        holes = np.any(np.isnan(values), axis=1) | (np.mean(filled, axis=1) > MOST_FILLED)
        # Values that are held as a rule, such as those of a slow bus, and a steady speed are neither stuck nor clipped.
        held = channel.name in way.names or usually_held(channel) >= limits.stuck
        still = _hit(np.empty(0) if held else stuck_times(channel, limits.stuck), edges)
        beyond = np.empty(0) if held else _until_recovered(clipped_times(channel), limits)
        faults[DriveReason.MISSING][channel.name] = holes
        faults[DriveReason.CLIPPED][channel.name] = _hit(beyond, edges)
        faults[DriveReason.STUCK][channel.name] = still
        if channel.name in shaken.orders:
            order, factor = shaken.orders[channel.name]
            level = factor * vibration(together.values[row, : count * size], together.step, order, size, limits)
            levels[channel.name] = np.where(still, np.nan, level)
    return faults, levels


def vibration(values: RealArray, step: Second, order: int, size: int, limits: DriveLimits) -> RealArray:
    """Return the level of acceleration near each block of the ``order``-th derivative of a displacement (sample,).

    Spectra are those of twice a block, about its middle. The level is the root of the median of the spectrum in the
    band times the bandwidth: the root mean square if the spectrum is flat, and single lines, such as those of an idling
    engine, count for nothing. What is missing is left out of the mean and of the spectrum.
    """
    count, wide = len(values) // size, min(2 * size, len(values))
    first = np.clip(size * np.arange(count) - (wide - size) // 2, 0, len(values) - wide)
    about = np.lib.stride_tricks.sliding_window_view(values, wide)[first]
    missing = np.isnan(about)
    if np.any(missing):
        number = np.maximum(np.sum(~missing, axis=1, keepdims=True), 1)
        about = np.where(missing, np.nansum(about, axis=1, keepdims=True) / number, about)
    window = np.hanning(wide + 2)[1:-1]
    hertz = np.fft.rfftfreq(wide, step)
    inside = (hertz >= limits.band_hz[0]) & (hertz <= min(limits.band_hz[1], PASSED / step))
    lines = np.fft.rfft((about - np.mean(about, axis=1, keepdims=True)) * window, axis=1)[:, inside]
    lines = lines * (2 * np.pi * hertz[inside]) ** (2 - order)
    power = 2 * step * np.abs(lines) ** 2 / np.sum(window**2)
    # The median of a periodogram of noise is ln 2 of its mean.
    return np.asarray(np.sqrt(np.median(power, axis=1) / np.log(2) * (limits.band_hz[1] - limits.band_hz[0])))


def _until_recovered(times: RealArray, limits: DriveLimits) -> RealArray:
    """Return times of clipping, and as many later ones, at which a sensor may not have recovered yet."""
    return np.concatenate([times, times + limits.recovery])


def _hit(times: RealArray, edges: RealArray) -> Flags:
    """Return which blocks hold one of some times."""
    at = np.searchsorted(edges, times[np.isfinite(times)], side="right") - 1
    return np.bincount(at[(at >= 0) & (at < len(edges) - 1)], minlength=len(edges) - 1) > 0
