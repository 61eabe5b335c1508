"""Comfort and travel of a record, from its samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import RecordLike, as_record
from suspid.io import bare_name, bracketed_unit
from suspid.levels import PIECES_OF_RECORD
from suspid.performance.felt import Felt, felt_of, shown_by
from suspid.performance.figure_plan import ROTATION, SICKNESS, TRAVEL, comfort_of
from suspid.performance.figures import check_exposure
from suspid.performance.mean_squares import power_mean
from suspid.performance.reactions import reaction
from suspid.performance.record_checks import no_figures, record_checks, rounding_checks
from suspid.performance.record_sizes import implausible
from suspid.performance.rides import Ride
from suspid.performance.weightings import weighted
from suspid.signals import as_signal
from suspid.units import RealArray, Second
from suspid.values import FrozenItems, frozen_real
from suspid.words import Check, Level, Remark, Verdict
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
    felt, travels, unknown = felt_of(signal, weightings)
    felt, hidden = shown_by(signal, felt, asked=weightings is not None)
    seconds = signal.duration if duration is None else duration
    if duration is not None:
        check_exposure(duration)
    found: list[Measured] = []
    checks: list[Check] = []
    for one in felt:
        plain, scatter = power_mean(one.samples, 2)
        found.append(Measured(name=f"{one.name}.rms", value=plain, unit=f"{one.turn}/s2", scatter=scatter))
        comfort = comfort_of(one.kinds)
        for kind in one.kinds:
            weighed = weighted(one.samples, signal.step, kind)
            figures = list(_of_weighted(one, kind, weighed, seconds, first=kind == comfort))
            found += figures
            checks += _doubts(one.name, kind, {each.name: each.value for each in figures}, seconds)
    for one in travels:
        found += _of_travel(one.name, one.samples)
    count = signal.values.shape[1]
    length = max(count // SEGMENTS, 16)
    hertz, density = welch(np.array([one.samples for one in felt]), 1 / signal.step, nperseg=length)
    averaged = (count - length // 2) // (length - length // 2)
    checks += record_checks(signal, felt, travels, hidden, unknown)
    checks += rounding_checks(felt, {one.name: (one.value, one.scatter) for one in found}, signal.step)
    checks += no_figures(signal.channels, {one.name for one in (*felt, *travels)}, unknown)
    stated = {bare_name(name) for name in signal.channels if bracketed_unit(name)}
    checks += implausible(felt, travels, {one.name: one.value for one in found}, stated)
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
        channels=tuple(one.name for one in felt),
        density=frozen_real(density[:, 1:]),
        density_band=frozen_real(density[:, 1:] * ((1 + SHARED_HALF) / averaged) ** 0.5),
        weightings=FrozenItems({one.name: one.kinds for one in felt}),
        road=None,
        about=None,
        verdict=Verdict(Remark(RideHeadline.RECORDED, {"seconds": signal.duration}), tuple(checks)),
    )


def _of_weighted(one: Felt, kind: str, felt: RealArray, seconds: Second, *, first: bool) -> Iterator[Measured]:
    """Yield the figures of one weighted acceleration; doses are those of the wanted time."""
    channel, turn = one.name, one.turn
    rms, scatter = power_mean(felt, 2)
    yield Measured(name=f"{channel}.{kind}", value=rms, unit=f"{turn}/s2", scatter=scatter)
    if kind == SICKNESS:
        root = seconds**0.5
        yield Measured(name=f"{channel}.MSDV", value=root * rms, unit=f"{turn}/s1.5", scatter=root * scatter)
    elif first:
        fourth, fourth_scatter = power_mean(felt, 4)
        root = seconds**0.25
        yield Measured(name=f"{channel}.VDV", value=root * fourth, unit=f"{turn}/s1.75", scatter=root * fourth_scatter)
        peak = float(np.max(np.abs(felt)))
        yield Measured(name=f"{channel}.crest", value=peak / rms if rms else 0.0, unit="1")


def _of_travel(channel: str, travel: RealArray) -> Iterator[Measured]:
    strut = channel.removesuffix(TRAVEL)
    rms, scatter = power_mean(travel, 2)
    yield Measured(name=f"{strut}.travel", value=rms, unit="m", scatter=scatter)
    yield Measured(name=f"{strut}.peak_travel", value=float(np.max(np.abs(travel))), unit="m")


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
