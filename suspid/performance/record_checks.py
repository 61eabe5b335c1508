"""Doubts about the figures of a record: its rate and length, its sensors, and time at rest."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from suspid.cleaning import clipped_times, clipping
from suspid.greybox import DriveLimits
from suspid.identification import UNIFORM_STD, resolution
from suspid.io import bare_name
from suspid.levels import PIECES_OF_RECORD
from suspid.performance.felt import Felt
from suspid.performance.figure_plan import TRAVEL
from suspid.performance.weightings import weighting, weighting_named
from suspid.recordings import RawChannel
from suspid.signals import Signal
from suspid.units import Ratio, Second
from suspid.words import Check, Level, Number, Remark
from suspid.words.ride import RideCheck


def record_checks(
    signal: Signal, felt: Sequence[Felt], travels: Sequence[Felt], hidden: Sequence[str], unknown: Sequence[str]
) -> Iterator[Check]:
    """Yield what speaks against the figures of a record, and what was done to it.

    ``hidden`` are weightings, ``unknown`` travels that were left out.
    """
    yield from _band(signal, {kind for one in felt for kind in one.kinds})
    for one in (*felt, *travels):
        yield from _clipped(signal, one)
    share = rest_share(signal, felt)
    if share:
        more = (1 - share) ** -0.5 if share < 1 else float("nan")
        limit = DriveLimits().least_vibration
        # Of a car that never moves, the figures are those of its sensors and of its engine.
        level = Level.NOTE if share < 1 else Level.DOUBTFUL
        yield Check(Remark(RideCheck.REST, {"share": share, "limit": limit, "factor": more}), level)
    for one in (*felt, *travels):
        if one.unit:
            numbers: dict[str, Number] = {"channel": one.name, "unit": one.unit}
            yield Check(Remark(RideCheck.CONVERTED, numbers), Level.NOTE)
    for kind in hidden:
        w = weighting_named(kind)
        short: dict[str, Number] = {"weighting": kind, "low": w.f1, "high": w.f2, "seconds": signal.duration}
        yield Check(Remark(RideCheck.HIDDEN, short), Level.NOTE)
    for name in unknown:
        yield Check(Remark(RideCheck.NO_LENGTH, {"channel": name}), Level.NOTE)


def no_figures(channels: Sequence[str], used: Collection[str], unknown: Collection[str]) -> Iterator[Check]:
    """Yield the channels that are named like a travel, but not so that figures are made of them.

    Examples
    --------
    >>> [check.remark.numbers["names"] for check in no_figures(["front_travel_mm", "speed"], [], [])]
    [('front_travel_mm',)]
    """
    left = [
        name
        for name in channels
        if TRAVEL.strip("_") in name.lower() and name not in unknown and not {name, bare_name(name)} & set(used)
    ]
    if left:
        yield Check(Remark(RideCheck.NO_FIGURES, {"names": tuple(left)}), Level.NOTE)


def rest_share(signal: Signal, felt: Sequence[Felt]) -> Ratio:
    """Return the share of time in which no acceleration [m/s2] shows a car that moves.

    In blocks of a second the vibration in the band of `DriveLimits` is below its limit.
    """
    limits = DriveLimits()
    low, high = limits.band_hz
    rows = [one.samples for one in felt if one.turn == "m"]
    size = round(limits.block / signal.step)
    if not rows or 0.5 / signal.step < high or not size <= signal.values.shape[1]:
        return 0.0
    count = len(rows[0]) // size
    blocks = np.array([row[: count * size].reshape(count, size) for row in rows])
    hertz = np.fft.rfftfreq(size, signal.step)
    within = (hertz >= low) & (hertz <= high)
    # At rest a sensor has another mean than on the move: the brake holds the body, the road is not level.
    blocks -= blocks.mean(axis=-1, keepdims=True)
    # A window, as the drift within a block would leak into the band; 3/8 is its mean square.
    power = np.abs(np.fft.rfft(blocks * np.hanning(size))[..., within]) ** 2
    rms = np.sqrt(2 * np.sum(power, axis=-1) / size**2 / 0.375)
    return float(np.mean(np.all(rms < limits.least_vibration, axis=0)))


def rounding_checks(felt: Sequence[Felt], figures: Mapping[str, tuple[float, float]], step: Second) -> Iterator[Check]:
    """Yield which weighted accelerations are those of rounded samples: by more than their own standard deviation.

    ``figures`` are value and standard deviation by name. Rounding to steps of q adds a white variance ``q^2 / 12``.
    """
    hertz = np.linspace(0.0, 0.5 / step, 1000)[1:]
    for one in felt:
        std = float(resolution(one.samples[None])[0])
        for kind in one.kinds:
            value, scatter = figures[f"{one.name}.{kind}"]
            if value <= 0 or not np.isfinite(scatter):
                continue
            share = (std / value) ** 2 * float(np.mean(np.abs(weighting(kind, hertz)) ** 2))
            # A variance that is added changes the root by half of its share.
            if share / 2 > scatter / value:
                numbers: dict[str, Number] = {
                    "channel": one.name, "weighting": kind, "share": min(share, 1.0), "unit": f"{one.turn}/s2",
                    "step": std / UNIFORM_STD,
                }  # fmt: skip
                yield Check(Remark(RideCheck.ROUNDED, numbers), Level.CARE)


def _band(signal: Signal, kinds: set[str]) -> Iterator[Check]:
    """Yield what a record leaves out of its weightings."""
    top = 0.5 / signal.step
    for kind in sorted(kinds):
        w = weighting_named(kind)
        # Rounded stamps give a rate that is off by less than this; so little more band adds nothing to a figure.
        if top < 0.99 * w.f2:
            yield Check(Remark(RideCheck.HIGH, {"held": top, "weighting": kind, "hertz": w.f2}), Level.CARE)
        if signal.duration * w.f1 < PIECES_OF_RECORD:
            needed = PIECES_OF_RECORD / w.f1
            numbers: dict[str, Number] = {
                "seconds": signal.duration, "weighting": kind, "hertz": w.f1, "needed": needed,
            }  # fmt: skip
            # Of less than a period the figure says nothing.
            level = Level.CARE if signal.duration * w.f1 >= 1 else Level.DOUBTFUL
            yield Check(Remark(RideCheck.SHORT, numbers), level)


def _clipped(signal: Signal, one: Felt) -> Iterator[Check]:
    """Yield whether a sensor was out of range: what is cut off is missing in peaks and doses."""
    count = sum(found.samples for found in clipping(one.name, signal.timepts, one.samples))
    if not count:
        raw = RawChannel(name=one.name, unit="", timepts=signal.timepts, values=one.samples, rate=1 / signal.step)
        count = len(clipped_times(raw))
    if count:
        numbers: dict[str, Number] = {
            "channel": one.name, "samples": int(count), "largest": float(np.max(np.abs(one.samples))),
            "unit": f"{one.turn}/s2" if one.kinds else "m",
        }  # fmt: skip
        yield Check(Remark(RideCheck.CLIPPED, numbers), Level.CARE)
