"""Frequency responses of a record from the causes of its motion, and those of the fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.errors import InputError
from suspid.levels import EXACT
from suspid.performance import SHARED_HALF
from suspid.records import inputs_of
from suspid.reporting.axes import IN_VIEW, position
from suspid.reporting.channel_units import gain_unit
from suspid.reporting.plot_spectra import STRETCHES, no_such_record
from suspid.signals import as_signal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from suspid.greybox import Estimate
    from suspid.units import ComplexArray, Hertz, RealArray


@dataclass(frozen=True, kw_only=True, slots=True)
class Frf:
    """A frequency response of a record and of its fit."""

    hertz: RealArray
    record: ComplexArray
    fit: ComplexArray
    std: RealArray  # of the record's gain, over the gain
    cause: str
    unit: str  # of the gain


@dataclass(frozen=True, kw_only=True, slots=True)
class Pair:
    """A cause and what it moves."""

    cause: RealArray
    motion: RealArray


def responses(
    found: Estimate, *, record: int = 0, cause: str | None = None, channels: Sequence[str] | None = None
) -> dict[str, Frf]:
    """Return the frequency responses of a record and of its fit by channel.

    Raises
    ------
    InputError
        If the record is a free decay, or there is no such record, cause or channel.
    """
    if not 0 <= record < len(found.fitted):
        raise InputError(f"{record=}: {no_such_record(found)}")
    causes = found.causes[record]
    if not causes:
        raise InputError(f"record {record} is a free decay: nothing moves it; plot_spectra draws its spectra")
    fitted, left = as_signal(found.fitted[record]), as_signal(found.residual[record])
    moved = causes[0 if cause is None else position(cause, causes)]
    known = inputs_of(found.fitted[record])
    if moved in known:
        motion, quiet = (known[moved], known[moved]), 0.0
    else:
        at = position(moved, left.channels)
        motion = (fitted.values[at], fitted.values[at] + left.values[at])
        quiet = 2 * left.step * float(found.noise_std[record][at]) ** 2
    made = {}
    for name in [one for one in fitted.channels if one not in causes] if channels is None else channels:
        at = position(name, fitted.channels)
        fit, rest = fitted.values[at], left.values[at]
        pairs = Pair(cause=motion[0], motion=fit), Pair(cause=motion[1], motion=fit + rest)
        unit = gain_unit(found.suspension, name, moved)
        made[name] = _response(*pairs, 1 / left.step, quiet, _shown_band(found), cause=moved, unit=unit)
    return made


def _shown_band(found: Estimate) -> tuple[Hertz, Hertz]:
    """Return the frequencies that were used; where all were, those that hold modes: above, both are noise."""
    if found.band_hz is not None:
        return found.band_hz
    modes = found.modes.wn[np.isfinite(found.modes.wn)] / (2 * np.pi)
    return 0.0, IN_VIEW * float(np.max(modes)) if modes.size else np.inf


def _response(
    fit: Pair, record: Pair, rate: Hertz, quiet: float, band: tuple[Hertz, Hertz], *, cause: str, unit: str
) -> Frf:
    """Return the responses; ``quiet`` is the power density of the noise of the cause."""
    from scipy.signal import csd

    size = record.cause.size
    length = max(min(size, 64), size // STRETCHES)

    def density(x: RealArray, y: RealArray) -> ComplexArray:
        return np.asarray(csd(x, y, fs=rate, nperseg=length)[1], complex)

    hertz = np.asarray(np.fft.rfftfreq(length, 1 / rate), float)
    power, own, motion = (density(x, x).real for x in (record.cause, record.motion, fit.cause))
    cross = density(record.cause, record.motion)
    kept = (hertz > 0) & (hertz >= band[0]) & (hertz <= band[1]) & (motion > EXACT * np.max(motion)) & (power > quiet)
    if not np.any(kept):
        raise InputError("the cause does not move, so there is no frequency response")
    coherence = np.clip(np.abs(cross) ** 2 / np.maximum(power * own, 1e-300), 1e-12, 1.0)[kept]
    averages = max(1, 2 * (size // length) - 1) / (1 + SHARED_HALF)
    # What the noise that is taken off does to the spectrum of the cause in this record stays in the gain.
    taken_off = (quiet / (power - quiet))[kept] ** 2 / averages
    return Frf(
        hertz=hertz[kept],
        record=(cross / (power - quiet))[kept],
        fit=(density(fit.cause, fit.motion) / motion)[kept],
        std=np.sqrt((1 - coherence) / (2 * averages * coherence) + taken_off),
        cause=cause,
        unit=unit,
    )
