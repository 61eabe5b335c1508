"""Reasons for and against each block of a recorded drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import MOST_FILLED, Aligned, aligned, clipped_times, stuck_times
from suspid.errors import RecordError
from suspid.greybox.drive_limits import DriveLimits
from suspid.greybox.shaken import Shaken
from suspid.greybox.speeds import Going, Way, going
from suspid.recordings import RawChannel
from suspid.signals import PASSED
from suspid.units import Flags, RealArray, Second
from suspid.words.drives import DriveReason


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Blocks:
    """What was found in each block of a part of a recording."""

    part: Aligned
    size: int  # samples of a block
    going: Going
    level: RealArray  # (block,): vibration of the quietest channel [m/s2]
    loudest: RealArray  # (block,): vibration of the loudest channel on the body [m/s2]; inf where none tells
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


def examined(part: Sequence[RawChannel], way: Way, shaken: Shaken, limits: DriveLimits) -> Blocks:
    """Return what speaks against each block of a part of a recording."""
    together = aligned(part)
    size = max(2, round(limits.block / together.step))
    count = together.timepts.size // size
    if not count:
        length = together.timepts.size * together.step
        raise RecordError(f"{length:.3g} s are too short for a drive: it is divided into blocks of {limits.block:g} s")
    edges = together.timepts[0] + together.step * size * np.arange(count + 1)
    moves = going(way, edges)
    clear, faults = {}, dict[DriveReason, dict[str, Flags]]()
    for reason in (DriveReason.MISSING, DriveReason.CLIPPED, DriveReason.STUCK):
        faults[reason] = {}
    levels = dict[str, RealArray]()
    for row, channel in enumerate(part):
        values = together.values[row, : count * size].reshape(count, size)
        filled = together.filled[row, : count * size].reshape(count, size)
        holes = np.any(np.isnan(values), axis=1) | (np.mean(filled, axis=1) > MOST_FILLED)
        still = _hit(stuck_times(channel, limits.stuck), edges)
        faults[DriveReason.MISSING][channel.name] = holes
        faults[DriveReason.CLIPPED][channel.name] = _hit(_until_recovered(clipped_times(channel), limits), edges)
        faults[DriveReason.STUCK][channel.name] = still
        if channel.name in shaken.orders:
            order, factor = shaken.orders[channel.name]
            level = factor * vibration(together.values[row, : count * size], together.step, order, size, limits)
            levels[channel.name] = np.where(still, np.nan, level)
    every, inf = np.array([*levels.values()]), np.inf
    quiet = np.min(np.where(np.isnan(every), inf, every), axis=0)
    level = np.where(np.isinf(quiet), 0.0, quiet)
    # A channel that is stuck tells nothing of a road.
    body = np.array([np.where(np.isnan(one), inf, one) for name, one in levels.items() if name in shaken.body])
    loudest = np.max(body, axis=0, initial=0.0) if len(body) else np.full(count, inf)
    known = np.isfinite(moves.speed)
    rolling = known & (moves.speed >= limits.least_speed) & (loudest < limits.least_vibration)
    slow, standing = known & (moves.speed < limits.least_speed), ~known & (level < limits.least_vibration)
    for reason, by_channel in faults.items():
        clear[reason] = np.any(list(by_channel.values()), axis=0)
    clear[DriveReason.STUCK] &= ~slow & ~standing
    standing &= ~clear[DriveReason.MISSING]
    return Blocks(
        part=together,
        size=size,
        going=moves,
        level=level,
        loudest=loudest,
        faults=faults,
        flags={
            DriveReason.MISSING: clear[DriveReason.MISSING],
            DriveReason.CLIPPED: clear[DriveReason.CLIPPED],
            DriveReason.SLOW: slow,
            DriveReason.STANDING: standing,
            DriveReason.ROLLING: rolling & ~clear[DriveReason.MISSING],
            DriveReason.STUCK: clear[DriveReason.STUCK],
            DriveReason.BRAKING: moves.longitudinal > limits.longitudinal,
            DriveReason.CORNERING: moves.lateral > limits.lateral,
        },
    )


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
