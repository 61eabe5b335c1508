"""Causes on a clock of their own, late or early by more than a fit of delays finds from none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from suspid.errors import EstimationError
from suspid.greybox.clocks import clear_lag
from suspid.greybox.fits import Fit
from suspid.greybox.frequency_domain import fit_in_frequency
from suspid.greybox.further import label
from suspid.greybox.one_car import not_one_car_in_drives
from suspid.greybox.transfers import Layout, Physics, layout_of, shown_by_causes
from suspid.greybox.trials import Trial
from suspid.greybox.wheel_problem import band_of, by_logger, wheel_problem
from suspid.model import Suspension
from suspid.reconstruction import Unknowns
from suspid.signals import PASSED
from suspid.units import Hertz, Second

LOOKED_THROUGH: Second = 120.0  # of a record, in which lags are looked for: some 100 periods of the body


def fit_drives(
    car: Suspension,
    trials: Sequence[Trial],
    unknowns: Unknowns,
    *,
    delays: Sequence[str] | None,
    band: tuple[Hertz, Hertz] | None,
    options: Mapping[str, Any],
) -> Fit:
    """Return the fit of records with measured causes, which are brought in step with the other channels before."""
    groups = by_logger(trials)
    shifted, lags = list(trials), []
    for numbers in groups:
        lag = _lag(car, max((trials[i] for i in numbers), key=lambda trial: trial.count), delays, band)
        lags.append(lag * trials[numbers[0]].step)
        for i in numbers:
            shifted[i] = _in_step(car, trials[i], lag)

    def fitted(some: Sequence[Trial]) -> Fit:
        return fit_in_frequency(wheel_problem(car, some, unknowns, delays=delays, band=band, **options))

    fit, alone = fitted(shifted), dict[int, Fit]()
    for numbers in groups if len(groups) > 1 else ():
        with suppress(EstimationError):
            alone[numbers[0]] = fitted([shifted[i] for i in numbers])
    fit = replace(fit, checks=(*not_one_car_in_drives(fit, alone, unknowns.labels), *fit.checks))
    late = {
        f"{label(trials[numbers[0]].channels[c], i, len(groups))}.delay": lag
        for i, (numbers, lag) in enumerate(zip(groups, lags, strict=True))
        for c in layout_of(car, trials[numbers[0]]).causes
    }
    return replace(fit, extra_values=fit.extra_values + [late.get(name, 0.0) for name in fit.extras])


def _in_step(car: Suspension, trial: Trial, lag: int) -> Trial:
    """Return a trial whose causes are taken some samples later."""
    if not lag:
        return trial
    causes = list(layout_of(car, trial).causes)
    kept = trial.count - abs(lag)
    values = trial.values[:, max(0, -lag) :][:, :kept].copy()
    values[causes] = trial.values[causes, max(0, lag) :][:, :kept]
    return replace(trial, values=values, start=trial.start + max(0, -lag) * trial.step)


def _lag(car: Suspension, trial: Trial, delays: Sequence[str] | None, band: tuple[Hertz, Hertz] | None) -> int:
    """Return by how many samples the causes are late, 0 if that is within a period of the band's end or not clear."""
    layout = layout_of(car, trial)
    causes, outputs = list(layout.causes), list(layout.outputs)
    known = delays is not None and not {trial.channels[c] for c in causes} <= set(delays)
    if known or np.any(layout.on_free[causes]):
        return 0
    low, high = band_of(car) if band is None else band
    trial = trial.first(round(LOOKED_THROUGH / trial.step))
    # With as many zeros behind the record, its end does not meet its beginning.
    f = np.fft.rfftfreq(2 * trial.count, trial.step)
    inside = (f >= low) & (f <= min(high, PASSED / trial.step))
    lines = np.fft.rfft(trial.values - trial.values.mean(axis=1, keepdims=True), 2 * trial.count)[:, inside]
    shown = _nominal(car, trial, layout, np.asarray(2j * np.pi * f[inside], complex), lines)
    both = np.zeros((len(outputs), len(f)), complex)
    both[:, inside] = shown * lines[outputs].conj()
    power = np.sum(np.abs(shown) ** 2, axis=1) * np.sum(np.abs(lines[outputs]) ** 2, axis=1)
    found = np.fft.irfft(both, 2 * trial.count) ** 2
    score = np.sum(found / np.maximum(power, np.finfo(float).tiny)[:, None], axis=0)
    return clear_lag(score, trial.count, 1 / (high * trial.step))


def _nominal(
    car: Suspension, trial: Trial, layout: Layout, s: np.ndarray[tuple[int], np.dtype[np.complex128]], lines: Any
) -> Any:
    """Return what the nominal car makes of the causes, (output, line)."""
    ones = np.ones(len(trial.channels))
    physics = Physics(
        stiffness=np.array([strut.stiffness for strut in car.struts]),
        damping=np.array([strut.damping for strut in car.struts]),
        masses=np.array([car.masses[name] for name in car.coordinates]) + trial.added,
        relaxation=np.array([strut.relaxation for strut in car.struts]),
        gains=ones,
        delays=0 * ones,
    )
    return np.einsum("log,gl->ol", shown_by_causes(layout, s, physics), lines[list(layout.causes)])
