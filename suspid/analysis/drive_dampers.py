"""Curves and wear of the dampers that a drive shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError, SuspidError
from suspid.greybox import DamperCurve, Estimate, RecordTest, damper_curve, estimate, wheels_of
from suspid.model import Suspension
from suspid.performance import Wear, dampers_between, wear
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.wording import Wording
from suspid.words import Check, Level, Remark
from suspid.words.drives import DriveRemark

if TYPE_CHECKING:
    import control

# Samples from which curves are found at most: forces are then known to less than a percent, in seconds.
ENOUGH_SAMPLES = 40_000
# Samples from which it is told whether the sensors fit: a delay of 2 ms leaves a hundred times the noise's chi-square.
TRIAL_SAMPLES = 6000
# Shortest piece of a record that is used: a curve leaves out both ends of each.
SHORTEST_PIECE = 1000


@dataclass(frozen=True, kw_only=True, slots=True)
class Correction:
    """Gain of a channel [1] and its delay behind the others [s]."""

    gain: float
    delay: float


def curves_of(
    records: Sequence[control.TimeResponseData], found: Estimate, logger: str
) -> tuple[tuple[DamperCurve, ...], tuple[Check, ...]]:
    """Return the curve of each damper above a given wheel, and what is to be said of them.

    Sensors are taken as they are. Where the curve of a short part then leaves more than noise, it is sought again with
    the gains and delays of a car of viscous dampers without mounts: the curve has none either, and a mount takes the
    place of a delay. The better of the two is kept, and found from more samples if it leaves but noise.
    """
    car = _without_mounts(found.suspension)
    names = dampers_above_wheels(car)
    part = longest(records)
    if not names:
        return (), ()
    if not part:
        why = f"no usable stretch has {SHORTEST_PIECE} samples"
        return (), (Check(Remark(DriveRemark.NO_CURVE, {"names": tuple(names), "why": why}), Level.NOTE),)
    trial = longest(part, TRIAL_SAMPLES)
    curves, failed = _sought(trial, car, names)
    doubtful = [name for name, one in curves.items() if not one.explains]
    corrections = _corrections(part, car, logger) if doubtful else {}
    again, _ = _sought(_all_corrected(trial, corrections), car, doubtful if corrections else ())
    better = {name: one for name, one in again.items() if _misfit(one) < _misfit(curves[name])}
    curves |= better
    fit = [name for name, one in curves.items() if one.explains]
    plain, _ = _sought(part, car, [name for name in fit if name not in better])
    mended, _ = _sought(_all_corrected(part, corrections), car, [name for name in fit if name in better])
    curves |= plain | mended
    return tuple(curves.values()), tuple(_said(records, part, curves, failed, tuple(better), corrections))


def wear_of(
    found: Estimate,
    before: Sequence[Estimate],
    curves: Sequence[DamperCurve] = (),
    curves_before: Sequence[Sequence[DamperCurve]] = (),
) -> tuple[Wear | None, tuple[Check, ...]]:
    """Return the wear of the dampers, or why it is not judged.

    Raises
    ------
    InputError
        If earlier estimates were given and are of another car.
    """
    try:
        return wear(found, before=list(before) or None, curves=curves, curves_before=curves_before), ()
    except InputError as error:
        if before:
            raise
        return None, (Check(Remark(DriveRemark.NO_WEAR, {"why": error.wording}), Level.NOTE),)


def longest(records: Sequence[control.TimeResponseData], most: int = ENOUGH_SAMPLES) -> list[control.TimeResponseData]:
    """Return the longest records, no more than ``most`` samples together, in their order.

    Examples
    --------
    >>> from suspid.records import as_response
    >>> made = [as_response(np.arange(n) * 0.01, np.ones((1, n)), ("a",)) for n in (500, 2000, 70_000)]
    >>> [one.time.size for one in longest(made)]
    [40000]
    """
    left, kept = most, {}
    for i in sorted(range(len(records)), key=lambda i: -len(records[i].time)):
        signal = as_signal(records[i])
        size = min(signal.timepts.size, left)
        if size < SHORTEST_PIECE:
            break
        kept[i] = as_response(signal.timepts[:size], signal.values[:, :size], signal.channels, title=records[i].title)
        left -= size
    return [kept[i] for i in sorted(kept)]


def dampers_above_wheels(car: Suspension) -> list[str]:
    """Return the names of the struts with a damper between a wheel and something else."""
    return [strut.name for strut in dampers_between(car) if _above_wheel(car, strut.name) and strut.damping > 0]


def _above_wheel(car: Suspension, strut: str) -> bool:
    """Return whether a strut acts between a wheel and something else."""
    wheels, arms = set(wheels_of(car)), next(dict(s.arms) for s in car.struts if s.name == strut)
    acts = {name for name, arm in arms.items() if arm}
    return bool(acts & wheels) and bool(acts - wheels)


def _without_mounts(car: Suspension) -> Suspension:
    return replace(car, struts=[replace(strut, mount_stiffness=None) for strut in car.struts])


def _sought(
    records: Sequence[control.TimeResponseData], car: Suspension, names: Sequence[str]
) -> tuple[dict[str, DamperCurve], dict[Wording, list[str]]]:
    """Return the curves by strut, and the struts by why there is none."""
    curves, failed = dict[str, DamperCurve](), dict[Wording, list[str]]()
    for name in names:
        try:
            curves[name] = damper_curve(records, car, strut=name, given=wheels_of(car))
        except SuspidError as error:
            failed.setdefault(error.wording, []).append(name)
    return curves, failed


def _misfit(curve: DamperCurve) -> float:
    return curve.chi_square / max(curve.freedom, 1) if np.isnan(curve.following) else curve.following


def _corrections(records: Sequence[control.TimeResponseData], car: Suspension, logger: str) -> dict[str, Correction]:
    """Return what is wrong with the sensors if dampers are viscous and have no mounts; empty where not known."""
    try:
        tests = [RecordTest(record=record, logger=logger) for record in records]
        return corrections_of(estimate(tests, car, given=wheels_of(car), mounts=()))
    except SuspidError:
        return {}


def _all_corrected(
    records: Sequence[control.TimeResponseData], corrections: dict[str, Correction]
) -> list[control.TimeResponseData]:
    return [corrected(record, corrections) for record in records]


def corrections_of(found: Estimate) -> dict[str, Correction]:
    """Return the gain and the delay of each channel that were found."""
    values = dict(zip(found.parameters, found.values.tolist(), strict=True))
    channels = {name.rpartition(".")[0] for name in values if name.endswith((".gain", ".delay"))}
    return {
        name: Correction(gain=values.get(f"{name}.gain", 1.0), delay=values.get(f"{name}.delay", 0.0))
        for name in sorted(channels)
    }


def corrected(record: control.TimeResponseData, corrections: dict[str, Correction]) -> control.TimeResponseData:
    """Return a record whose channels have no gain and no delay, less what the shift may spoil at its ends.

    Examples
    --------
    >>> t = np.arange(2000) * 0.01
    >>> late = as_response(t, 1.1 * np.sin(9 * (t - 0.004))[None], ("a",))
    >>> mended = corrected(late, {"a": Correction(gain=1.1, delay=0.004)})
    >>> bool(np.max(np.abs(mended.outputs - np.sin(9 * mended.time))) < 0.01)
    True
    """
    signal = as_signal(record)
    values, hertz = signal.values.copy(), np.fft.rfftfreq(signal.timepts.size, signal.step)
    for row, name in enumerate(signal.channels):
        if name not in corrections:
            continue
        own = corrections[name]
        # Less the line between its ends, a record continues itself without a jump.
        line = np.linspace(values[row, 0], values[row, -1], values.shape[1])
        slope = (values[row, -1] - values[row, 0]) / signal.duration
        lines = np.fft.rfft(values[row] - line) * np.exp(2j * np.pi * hertz * own.delay)
        values[row] = (np.fft.irfft(lines, values.shape[1]) + line + slope * own.delay) / own.gain
    # Samples at the ends that a shift by a fraction of a sample may spoil.
    inside = slice(50, -50)
    return as_response(signal.timepts[inside], values[:, inside], signal.channels, title=record.title)


def _said(
    records: Sequence[control.TimeResponseData],
    part: Sequence[control.TimeResponseData],
    curves: dict[str, DamperCurve],
    failed: dict[Wording, list[str]],
    better: tuple[str, ...],
    corrections: dict[str, Correction],
) -> Iterator[Check]:
    """Yield what is to be said of the curves that were found, and of those that were not."""
    used, seconds = (sum(as_signal(one).duration for one in every) for every in (part, records))
    if curves and used < 0.99 * seconds:
        yield Check(Remark(DriveRemark.CURVES_FROM, {"used": used, "seconds": seconds}), Level.NOTE)
    if better:
        text = ", ".join(
            f"{name}: gain {one.gain:.4g}, delay {1e3 * one.delay:.3g} ms" for name, one in corrections.items()
        )
        yield Check(Remark(DriveRemark.SENSORS, {"names": better, "corrections": text}), Level.NOTE)
    misfits = tuple(name for name, one in curves.items() if not one.explains)
    if misfits:
        yield Check(Remark(DriveRemark.MISFIT, {"names": misfits}), Level.NOTE)
    for why, names in failed.items():
        yield Check(Remark(DriveRemark.NO_CURVE, {"names": tuple(names), "why": why}), Level.NOTE)
