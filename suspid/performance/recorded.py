"""Comfort and travel of a record, from its samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import RecordLike, as_record
from suspid.errors import InputError
from suspid.levels import PIECES_OF_RECORD
from suspid.model import positive_number
from suspid.performance.figure_plan import (
    ACCELERATION,
    ANGLES,
    ROTATION,
    SICKNESS,
    TRAVEL,
    VERTICAL,
    checked_weightings,
    comfort_of,
)
from suspid.performance.reactions import reaction
from suspid.performance.rides import Ride
from suspid.performance.weightings import weighted, weighting_named
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.values import FrozenItems, frozen_real, nearest_names
from suspid.wording import Argument
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.ride import RideCheck, RideHeadline

# ISO 2631-1, 6.2.1 and 6.3.3, as publications quote them: above these the weighted rms understates shocks.
MOST_CREST, MOST_DOSE = 9.0, 1.75
# Segments of a record whose spectra are averaged: sixteenths resolve the modes of a car in a record of a minute.
SEGMENTS = 16
# What neighbours that share half their samples under Hann windows add to the variance of their mean: twice the square
# of the correlation, a sixth (P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 1967, 70-73).
SHARED_HALF = 2 / 6**2


@dataclass(frozen=True, kw_only=True, slots=True)
class Measured:
    """One figure of a record, and its standard deviation over other records of the same length."""

    name: str
    value: float
    unit: str
    scatter: float = float("nan")


def recorded(
    record: RecordLike,
    *,
    duration: Second | None = None,
    weightings: Mapping[str, str | Sequence[str]] | None = None,
) -> Ride:
    """Return the figures of a record; see `ride`."""
    from scipy.signal import welch

    signal = as_signal(as_record(record), least=2 * PIECES_OF_RECORD)
    chosen = _chosen(signal, weightings)
    seconds = signal.duration if duration is None else duration
    positive_number("duration", seconds, "s")
    about = dict(zip(signal.channels, signal.values - signal.values.mean(axis=1, keepdims=True), strict=True))
    found: list[Measured] = []
    checks: list[Check] = []
    for channel, kinds in chosen.items():
        plain, scatter = _power_mean(about[channel], 2)
        found.append(Measured(name=f"{channel}.rms", value=plain, unit=f"{_turn(channel)}/s2", scatter=scatter))
        comfort = comfort_of(kinds)
        for kind in kinds:
            felt = weighted(about[channel], signal.step, kind)
            figures = list(_of_weighted(channel, kind, felt, seconds, first=kind == comfort))
            found += figures
            checks += _doubts(channel, kind, {one.name: one.value for one in figures}, seconds)
    for channel in signal.channels:
        if channel.endswith(TRAVEL) and channel not in chosen:
            found += _of_travel(channel, about[channel])
    channels = tuple(chosen)
    length = max(len(about[channels[0]]) // SEGMENTS, 16)
    hertz, density = welch(np.array([about[c] for c in channels]), 1 / signal.step, nperseg=length)
    averaged = (len(about[channels[0]]) - length // 2) // (length - length // 2)
    checks += _band(signal, {kind for kinds in chosen.values() for kind in kinds})
    none = np.zeros((len(found), 0))
    return Ride(
        figures=tuple(one.name for one in found),
        values=frozen_real([one.value for one in found]),
        units=tuple(one.unit for one in found),
        duration=float(seconds),
        parameters=(),
        jacobian=frozen_real(none),
        bends=frozen_real(none[:, :, None]),
        parameter_values=frozen_real([]),
        covariance=frozen_real(np.zeros((0, 0))),
        scatter=frozen_real([one.scatter for one in found]),
        hertz=frozen_real(hertz[1:]),
        channels=channels,
        density=frozen_real(density[:, 1:]),
        density_band=frozen_real(density[:, 1:] * ((1 + SHARED_HALF) / averaged) ** 0.5),
        weightings=FrozenItems(chosen),
        road=None,
        verdict=Verdict(Remark(RideHeadline.RECORDED, {"seconds": signal.duration}), tuple(checks)),
    )


def _chosen(signal: Signal, given: Mapping[str, str | Sequence[str]] | None) -> dict[str, tuple[str, ...]]:
    """Return the weightings of the accelerations of a record."""
    if given is not None:
        for channel in given:
            if channel not in signal.channels:
                raise InputError(
                    Argument("weightings"),
                    f": there is no channel {channel!r}.{nearest_names(channel, signal.channels)}",
                )
        return checked_weightings(given)
    named: dict[str, tuple[str, ...]] = {
        c: ROTATION if c.removesuffix(ACCELERATION) in ANGLES else VERTICAL
        for c in signal.channels
        if c.endswith(ACCELERATION)
    }
    if not named:
        raise InputError(
            "no channel is named like an acceleration; name those that are with ",
            Argument("weightings"),
            f", such as Wk for {signal.channels[0]!r}",
        )
    return named


def _of_weighted(channel: str, kind: str, felt: RealArray, seconds: Second, *, first: bool) -> Iterator[Measured]:
    """Yield the figures of one weighted acceleration [m/s2]; doses are those of the wanted time."""
    turn = _turn(channel)
    rms, scatter = _power_mean(felt, 2)
    yield Measured(name=f"{channel}.{kind}", value=rms, unit=f"{turn}/s2", scatter=scatter)
    if kind == SICKNESS:
        root = seconds**0.5
        yield Measured(name=f"{channel}.MSDV", value=root * rms, unit=f"{turn}/s1.5", scatter=root * scatter)
    elif first:
        fourth, fourth_scatter = _power_mean(felt, 4)
        root = seconds**0.25
        yield Measured(name=f"{channel}.VDV", value=root * fourth, unit=f"{turn}/s1.75", scatter=root * fourth_scatter)
        peak = float(np.max(np.abs(felt)))
        yield Measured(name=f"{channel}.crest", value=peak / rms if rms else 0.0, unit="1")


def _turn(channel: str) -> str:
    """Return the unit of what a channel is the acceleration of."""
    return "rad" if channel.removesuffix(ACCELERATION) in ANGLES else "m"


def _of_travel(channel: str, travel: RealArray) -> Iterator[Measured]:
    strut = channel.removesuffix(TRAVEL)
    rms, scatter = _power_mean(travel, 2)
    yield Measured(name=f"{strut}.travel", value=rms, unit="m", scatter=scatter)
    yield Measured(name=f"{strut}.peak_travel", value=float(np.max(np.abs(travel))), unit="m")


def _power_mean(samples: RealArray, power: int) -> tuple[float, float]:
    """Return ``mean(|x|^p)^(1/p)`` and its standard deviation by the scatter of the means over pieces."""
    powers = np.abs(samples) ** power
    mean = float(np.mean(powers))
    if not mean:
        return 0.0, 0.0
    pieces = np.array([np.mean(piece) for piece in np.array_split(powers, PIECES_OF_RECORD)])
    std = float(np.std(pieces, ddof=1)) / PIECES_OF_RECORD**0.5
    root = mean ** (1 / power)
    return root, root * std / (power * mean)


def _doubts(channel: str, kind: str, figures: Mapping[str, float], seconds: Second) -> Iterator[Check]:
    """Yield the reaction of people, and where the weighted rms understates shocks."""
    if kind in (SICKNESS, *ROTATION) or f"{channel}.VDV" not in figures:
        return
    rms, crest = figures[f"{channel}.{kind}"], figures[f"{channel}.crest"]
    yield reaction(channel, rms)
    if crest > MOST_CREST:
        yield Check(Remark(RideCheck.CREST, {"channel": channel, "crest": crest, "limit": MOST_CREST}), Level.CARE)
    ratio = figures[f"{channel}.VDV"] / (rms * seconds**0.25) if rms else 0.0
    if ratio > MOST_DOSE:
        yield Check(Remark(RideCheck.SHOCKS, {"channel": channel, "ratio": ratio, "limit": MOST_DOSE}), Level.CARE)


def _band(signal: Signal, kinds: set[str]) -> Iterator[Check]:
    """Yield what a record leaves out of its weightings."""
    top = 0.5 / signal.step
    for kind in sorted(kinds):
        w = weighting_named(kind)
        if top < w.f2:
            yield Check(Remark(RideCheck.HIGH, {"held": top, "weighting": kind, "hertz": w.f2}), Level.NOTE)
        if signal.duration * w.f1 < PIECES_OF_RECORD:
            numbers: dict[str, Number] = {"seconds": signal.duration, "weighting": kind, "hertz": w.f1}
            yield Check(Remark(RideCheck.SHORT, numbers), Level.NOTE)
