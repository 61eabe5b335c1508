"""Estimates in the frequency domain: the measured motion of wheels is the cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from suspid.errors import EstimationError
from suspid.greybox.fits import Fit
from suspid.greybox.identifiability import blind, check_determined, names_in, shares_of
from suspid.greybox.judgement import MOST_GAIN
from suspid.greybox.measured_causes import WheelProblem, first_levels
from suspid.greybox.misfit import Misfit, misfit_of
from suspid.greybox.nearly_rigid import toward_rigid
from suspid.greybox.noise_levels import Levels
from suspid.greybox.search import SAME_FIT, starts_of
from suspid.greybox.sensor_faults import sensor_fault
from suspid.greybox.settling import Point, from_held, released, settled
from suspid.greybox.suspects import suspect_of
from suspid.greybox.trials import signal_of
from suspid.greybox.whitened import Whitened
from suspid.levels import EXACT, LEVEL, NORMAL_95
from suspid.signals import Signal
from suspid.units import Ratio, RealArray
from suspid.words import Check, Level, Remark
from suspid.words.greybox import EstimateCheck


def fit_in_frequency(problem: WheelProblem) -> Fit:
    """Return the best car under measured causes.

    Raises
    ------
    EstimationError
        If the records do not determine a combination of the unknowns.
    """
    u, extras = problem.unknowns, problem.extras
    try:
        ends = _ends(problem)
    except np.linalg.LinAlgError:
        # Two causes that are one to the last digit have no spectra of their own.
        fault = sensor_fault(problem.sources)
        if fault is None:
            raise
        raise EstimationError(f"the records do not determine the car. {fault}") from None
    point, levels, judged, _ = min(ends, key=lambda end: (end.open, end.misfit.chi_square))
    z, every, _ = point
    squares, prior = _slopes(problem, point)
    labels = (*u.labels, *extras.names)
    slopes = np.concatenate([squares, prior])
    suspect = _suspect(problem, z, explains=judged.likely and not len(blind(slopes)))
    check_determined(
        slopes, labels, u.suspension(z[: len(u)]), relative=shares_of(_sizes(problem, z), z),
        hint=() if suspect is None else (f"{suspect} As they are, ",),
    )  # fmt: skip
    checks = [judged.check, *([] if suspect is None else [Check(suspect, Level.DOUBTFUL)])]
    if len(prior) and len(blind(squares)):
        checks.append(Check(Remark(EstimateCheck.BY_NOMINAL, {"names": names_in(blind(squares), labels)}), Level.CARE))
    noise = {n: _noise(problem, own, i) for i, own in enumerate(levels) for n in problem.sources[i].numbers}
    covariance, curvature = _sandwich(every, prior / _sizes(problem, z), judged.inflation)
    covariance = toward_rigid(problem, point, levels, covariance, curvature=curvature)
    if not judged.likely:
        apart = from_held(problem, z, levels)
        covariance += np.outer(apart, apart)
    pull = covariance @ _held_back(problem, point) / judged.inflation if judged.likely else None
    signals = sorted((made for i, w in enumerate(every) for made in _in_time(problem, w, i)), key=lambda made: made[0])
    return Fit(
        x=z[: len(u)],
        covariance=covariance,
        fitted=tuple(fitted for _, fitted, _ in signals),
        residual=tuple(residual for _, _, residual in signals),
        noise=tuple(noise[n] for n in sorted(noise)),
        chi_square=judged.chi_square,
        freedom=judged.freedom,
        explains=judged.likely,
        alternatives=(),
        checks=tuple(checks),
        pull=pull,
        band=(
            min(float(s.spectra.hertz[0]) for s in problem.sources),
            max(float(s.spectra.hertz[-1]) for s in problem.sources),
        ),
        extras=extras.names,
        levels=tuple(levels),
        extra_scale=extras.scale,
        extra_values=z[len(u) :] * extras.scale,
        extra_ranges=np.column_stack([extras.lower, extras.upper]) * extras.scale[:, None],
    )


def _ends(problem: WheelProblem) -> list[_End]:
    """Return where starts ended, as many as are needed."""
    u, extras = problem.unknowns, problem.extras
    ends: list[_End] = []
    for start in starts_of(u):
        first = [first_levels(source) for source in problem.sources]
        point, levels = released(problem, *settled(problem, np.concatenate([start, extras.start]), first))
        judged = misfit_of(point.every, [source.spectra.hertz for source in problem.sources])
        ends.append(_End(point, levels, judged, bool(len(blind(np.concatenate(_slopes(problem, point)))))))
        # Two starts that ended at one fit are enough. Where all is taken for noise, unknowns are open: that is none.
        closed = [end.misfit for end in ends if not end.open]
        closest = min((misfit.chi_square for misfit in closed), default=0.0)
        if any(m.likely for m in closed) or sum(m.chi_square < closest + SAME_FIT for m in closed) >= 2:
            break
    return ends


def _suspect(problem: WheelProblem, z: RealArray, *, explains: bool) -> Remark | None:
    """Return what is wrong with a sensor where the car does not explain the records, or a gain is that of none."""
    extras = problem.extras
    gains = (z[len(problem.unknowns) :] * extras.scale)[[name.endswith(".gain") for name in extras.names]]
    if explains and not np.any((gains < 1 / MOST_GAIN) | (gains > MOST_GAIN)):
        return None
    return sensor_fault(problem.sources) or (None if explains else suspect_of(problem))


class _End(NamedTuple):
    """Where a start ended."""

    point: Point
    levels: list[Levels]
    misfit: Misfit
    open: bool  # whether some combination of the unknowns is not determined


def _sizes(problem: WheelProblem, z: RealArray) -> RealArray:
    """Return the size of each unknown, in which it is told whether the records determine it."""
    u, extras = problem.unknowns, problem.extras
    return np.concatenate([u.sizes(z[: len(u)]), np.where(extras.positive, z[len(u) :], 1.0)])


def _slopes(problem: WheelProblem, point: Point) -> tuple[RealArray, RealArray]:
    """Return the derivatives of the records and of what is known beforehand per size of each unknown, in few rows."""
    u, z = problem.unknowns, point.z
    size = _sizes(problem, z)
    data = np.concatenate([w.rows()[1] for w in point.every]) * size
    prior = np.hstack([u.prior(z[: len(u)])[1], np.zeros((int(np.sum(u.has_prior)), len(problem.extras.names)))])
    return np.asarray(np.linalg.qr(data, mode="r")), prior * size


def _held_back(problem: WheelProblem, point: Point) -> RealArray:
    """Return by how much half of the misfit falls per unknown toward what its bound excludes, 0 off the bounds."""
    u, extras, z = problem.unknowns, problem.extras, point.z
    residual, slope = problem.compressed(z, point.every)
    falls = -slope.T @ residual
    lower, upper = np.concatenate([u.lower, extras.lower]), np.concatenate([u.upper, extras.upper])
    size = EXACT * _sizes(problem, z)
    return np.where(((z <= lower + size) & (falls < 0)) | ((z >= upper - size) & (falls > 0)), falls, 0.0)


def _sandwich(every: Sequence[Whitened], prior: RealArray, inflation: Ratio = 1.0) -> tuple[RealArray, RealArray]:
    """Return the covariance of the unknowns from the scatter of all lines' scores, and that of the curvature alone.

    The information is that of the true motion: what the noise of the estimated motion adds is subtracted. A residual is
    smaller than its noise by what was fitted to it, at few lines a large part: ``1 - h`` of its variance is left, with
    h its leverage (HC2 of J. G. MacKinnon and H. White, J. Econometrics 29 (1985) 305-325). All variances of the data
    are ``inflation`` times as large where the car does not explain them.

    Where few lines decide, such as those about a resonance, their scatter is uncertain as well. Deviations are wider by
    Student's factor of 95 % for the freedom of that scatter, which follows from the lines' shares in the variance of an
    unknown (F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114; R. M. Bell and D. F. McCaffrey, Survey
    Methodology 28 (2002) 169-181).
    """
    from scipy.special import stdtrit

    information, scores = prior.T @ prior, prior.T @ prior
    for w in every:
        slope = w.rows()[1]
        information = information + (slope.T @ slope - w.spurious) / inflation
    scale = np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    variance, squares = np.sum((prior @ inverse) ** 2, axis=0), np.zeros(len(inverse))
    for w in every:
        projected = np.sum(w.basis**2, axis=1)
        for part in w.parts():
            slope = w.slope(part)
            influence = slope @ inverse
            leverage = np.sum(influence * slope, axis=2) / inflation + projected
            # Of the variance of a residual: where more was fitted, next to nothing is known of its noise.
            residual = w.residual[part] / np.sqrt(np.maximum(1 - leverage, 0.1))
            shape = len(slope), 2, *w.factor.shape[:2], -1
            own = (slope * residual[:, :, None]).reshape(shape).sum(axis=(1, 3))
            flat = own.reshape(-1, own.shape[2])
            scores = scores + flat.T @ flat / inflation
            shares = (influence**2).reshape(shape).sum(axis=(1, 3)) / inflation
            variance = variance + shares.sum(axis=(0, 1))
            squares = squares + (shares**2).sum(axis=(0, 1))
    # What nothing moves has no freedom that counts.
    freedom = variance**2 / np.maximum(squares, np.finfo(float).tiny)
    wider = stdtrit(np.maximum(freedom, 1.0), (1 + LEVEL) / 2) / NORMAL_95
    return np.asarray(inverse @ scores @ inverse * np.outer(wider, wider)), inverse * inflation


def _noise(problem: WheelProblem, levels: Levels, number: int) -> RealArray:
    """Return the standard deviation of white noise of the same power in the band, (channel,)."""
    source = problem.sources[number]
    outputs, causes = levels.spectra(source.basis)
    noise = np.zeros(len(source.trial.channels))
    noise[list(source.layout.outputs)] = np.sqrt(np.mean(outputs, axis=0))
    noise[list(source.layout.causes)] = np.sqrt(causes)
    return noise


def _in_time(problem: WheelProblem, found: Whitened, number: int) -> list[tuple[int, Signal, Signal]]:
    """Return the number of each record, its motion in the band as explained by the car, and its residual."""
    source = problem.sources[number]
    spectra, trial = source.spectra, source.trial
    left = np.zeros_like(spectra.values)
    left[:, :, list(source.layout.causes)] = spectra.values[:, :, list(source.layout.causes)] - found.motion
    left[:, :, list(source.layout.outputs)] = found.misfit
    samples = spectra.samples
    first = round(spectra.hertz[0] * samples * trial.step)
    made = []
    for shown in (spectra.values - left, left):
        time = np.empty((shown.shape[2], len(found.residual), samples))
        for part in found.parts():
            lines = shown[:, part].transpose(2, 1, 0)
            whole = np.zeros((*lines.shape[:2], samples // 2 + 1), complex)
            whole[:, :, first : first + lines.shape[2]] = lines
            time[:, part] = np.fft.irfft(whole, samples, axis=2) * np.sqrt(samples)
        parts = np.split(time, np.cumsum(spectra.counts)[:-1], axis=1)
        made.append(
            [
                replace(signal_of(trial), start=start, values=part.reshape(len(part), -1))
                for start, part in zip(source.starts, parts, strict=True)
            ]
        )
    return list(zip(source.numbers, *made, strict=True))
