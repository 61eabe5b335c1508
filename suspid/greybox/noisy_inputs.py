"""Known roads and forces that are measured with noise: errors in variables, as for the motion of wheels.

A road or force is one more given motion, seen by a channel of its own: ``r = Y_o - T Y_g`` has the covariance
``S_o + T S_g T^H``, that of the input's noise through the car, which the outputs have in common. Noises are white.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.errors import EstimationError
from suspid.greybox.fits import Fit
from suspid.greybox.frequency_domain import fit_in_frequency
from suspid.greybox.further import SENSOR_KINDS
from suspid.greybox.measured_causes import LEAST_NOISE, WheelProblem
from suspid.greybox.noise_levels import Levels
from suspid.greybox.sensors_asked import Names, possible
from suspid.greybox.sensors_needed import most_telling
from suspid.greybox.trials import Trial
from suspid.greybox.wheel_problem import BELOW, band_of, wheel_problem
from suspid.greybox.whitened import Whitened
from suspid.levels import SURE, likely
from suspid.reconstruction import Unknowns
from suspid.units import Hertz, RealArray, Second
from suspid.words import Check, Level, Remark, percent
from suspid.words.greybox import EstimateCheck

# Of the lowest mode, in a stretch: sensors of inputs have one noise throughout, so ends cost more than changes do.
LONG_PERIODS = 24.0
POWER_BANDS = 12  # of each output, in which the power of a whitened residual is compared with that of noise


def noise_told(trials: Sequence[Trial], bare: Unknowns, chosen: Names, unknowns: Unknowns, fit: Fit) -> bool:
    """Return whether residuals of a fit with exactly known inputs hold noise of these.

    It is the score test of a level of zero, by the motion that the residual of all channels together stands for.
    ``unknowns`` are those of the fit: those of the car alone, ``bare``, and what was ``chosen``.
    """
    problem = _problem(trials, bare, chosen, band=None, stretch=None)
    found, extras = dict(zip(unknowns.labels, fit.x, strict=True)), problem.extras
    z = np.concatenate([fit.x[: len(bare)], [found[name] for name in extras.names]])
    score = information = 0.0
    for i, std in enumerate(fit.noise):
        source = problem.sources[i]
        power = np.mean(np.abs(source.spectra.values[:, :, list(source.layout.causes)]) ** 2, axis=(0, 1))
        levels = Levels(outputs=2 * np.log(std[None]), causes=np.log(LEAST_NOISE**2 * power))
        w = problem.whitened(z, i, levels)
        for cause in range(w.transfer.T.shape[2]):
            own, variance = _score(w, std, cause)
            score, information = score + own, information + variance
    return score > SURE * float(np.sqrt(information))


def _score(w: Whitened, std: RealArray, cause: int) -> tuple[float, float]:
    """Return the score of the noise of a cause, made independent of those of the outputs, and its variance."""
    T, left = w.transfer.T[:, :, cause] / std, w.left / std
    lines, stretches, _ = left.shape
    seen = np.sum(np.abs(T) ** 2, axis=1)
    scale = np.mean(seen)
    common = np.abs(np.sum(T.conj()[:, None] * left, axis=2)) ** 2
    per_output = np.sum(np.abs(left) ** 2, axis=(0, 1)) - lines * stretches
    shared = stretches * np.sum(np.abs(T) ** 2, axis=0)
    score = np.sum(common - seen[:, None]) - shared @ per_output / (lines * stretches)
    variance = stretches * np.sum(seen**2) - np.sum(shared**2) / (lines * stretches)
    return float(score / scale), float(variance / scale**2)


def with_noise_of_inputs(
    trials: Sequence[Trial],
    bare: Unknowns,
    asked: Names,
    free: Sequence[str],
    *,
    band: tuple[Hertz, Hertz] | None = None,
    stretch: Second | None = None,
    demanded: bool = False,
) -> tuple[Fit, tuple[Trial, ...], Names] | None:
    """Return the fit with noise of the inputs, with what else the records need, its trials and what was chosen.

    None if that does not explain the records, or all noises are not white, unless it is ``demanded``.
    """
    chosen, noisy = asked, tuple(trial.with_noisy_inputs() for trial in trials)
    while True:
        problem = _problem(trials, bare, chosen, band=band, stretch=stretch)
        try:
            fit = fit_in_frequency(problem)
        except EstimationError:
            if demanded:
                raise
            return None
        more = _more(trials, bare, chosen, free, fit, band=band, stretch=stretch)
        if more is None:
            break
        chosen = more
    white = _white(problem, fit)
    if not (fit.explains and white):
        if not demanded:
            return None
        if not white:
            fit = fit_in_frequency(wheel_problem(bare.car, noisy, bare, **chosen, band=band, stretch=stretch))
    added = tuple(f"{name} ({kind[:-1]})" for kind in SENSOR_KINDS for name in chosen[kind] if name not in asked[kind])
    needed = Check(Remark(EstimateCheck.NEEDED, {"names": added}), Level.NOTE)
    return replace(fit, checks=(*fit.checks, _said(noisy, fit), *([needed] if added else []))), noisy, chosen


def _problem(
    trials: Sequence[Trial],
    bare: Unknowns,
    chosen: Names,
    *,
    band: tuple[Hertz, Hertz] | None,
    stretch: Second | None,
) -> WheelProblem:
    length = LONG_PERIODS * BELOW / band_of(bare.car)[0] if stretch is None else stretch
    noisy = [trial.with_noisy_inputs() for trial in trials]
    made = wheel_problem(bare.car, noisy, bare, **chosen, band=band, stretch=length)
    return replace(made, sources=tuple(replace(s, basis=np.ones((len(s.basis), 1))) for s in made.sources))


def _more(
    trials: Sequence[Trial],
    bare: Unknowns,
    chosen: Names,
    free: Sequence[str],
    fit: Fit,
    *,
    band: tuple[Hertz, Hertz] | None,
    stretch: Second | None,
) -> Names | None:
    """Return what is chosen and what explains most of the residual of a fit beside it; None if chance does as much."""
    every = possible(trials, bare, chosen, free)
    if every == chosen:
        return None
    whole = _problem(trials, bare, every, band=band, stretch=stretch)
    names, found = whole.extras.names, dict(zip(fit.extras, fit.extra_values / fit.extra_scale, strict=True))
    start = np.where([name.endswith(".relaxation") for name in names], 0.0, whole.extras.start)
    z = np.concatenate([fit.x, [found.get(name, value) for name, value in zip(names, start, strict=True)]])
    residual, slope = whole.compressed(z, whole.every(z, fit.levels))
    labels = (*bare.labels, *whole.extras.names)
    return most_telling(residual, slope, labels, (*bare.labels, *fit.extras), trials, chosen, every)


def _white(problem: WheelProblem, fit: Fit) -> bool:
    """Return whether the residual has the power of white noises of all sensors at all frequencies."""
    z = np.concatenate([fit.x, fit.extra_values / fit.extra_scale])
    total, freedom = 0.0, 0
    for w in problem.every(z, fit.levels):
        lines, outputs = w.factor.shape[:2]
        kept = (1 - np.sum(w.basis**2, axis=1)).reshape(2, lines, outputs).sum(axis=0) * len(w.residual)
        power = np.sum(w.residual**2, axis=0).reshape(2, lines, outputs).sum(axis=0)
        for own, expected in zip(np.array_split(power, POWER_BANDS), np.array_split(kept, POWER_BANDS), strict=True):
            count = expected.sum(axis=0)
            total += float(np.sum((own.sum(axis=0) - count) ** 2 / (2 * count)))
        freedom += (POWER_BANDS - 1) * outputs
    return likely(total, freedom)


def _said(noisy: Sequence[Trial], fit: Fit) -> Check:
    """Return what is said of the noise of the inputs of the first record."""
    count = len(noisy[0].sensed_roads) + noisy[0].sensed_forces
    names, std = noisy[0].channels[-count:], fit.noise[0][-count:]
    share = std / np.std(noisy[0].values[-count:], axis=1)
    shown = tuple(f"{name} {percent(one)} of its motion" for name, one in zip(names, share.tolist(), strict=True))
    return Check(Remark(EstimateCheck.NOISY_INPUTS, {"names": shown}), Level.NOTE)
