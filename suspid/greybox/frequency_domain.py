"""Estimates in the frequency domain: the measured motion of wheels is the cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.greybox.fits import Fit
from suspid.greybox.further import TIMES
from suspid.greybox.identifiability import blind, check_determined, names_in
from suspid.greybox.measured_causes import WheelProblem, Whitened, first_levels
from suspid.greybox.misfit import Misfit, misfit_of
from suspid.greybox.noise_levels import Levels
from suspid.greybox.search import SAME_FIT, starts_of
from suspid.greybox.trials import signal_of
from suspid.levels import CHI_SQUARE_95
from suspid.reconstruction import descend
from suspid.signals import Signal
from suspid.units import Ratio, RealArray
from suspid.words import Check, Level, Remark
from suspid.words.greybox import EstimateCheck

NEGLIGIBLE_RISE = 1e-3  # gain of chi-square that ends a descent
HELD_WITHIN = 1e-9  # distance between the bounds of what is held
SOFT = (0.2, 0.5)  # relaxations from which softer mounts are looked for, of `TIMES`: 2 and 5 ms


def fit_in_frequency(problem: WheelProblem) -> Fit:
    """Return the best car under measured causes.

    Raises
    ------
    EstimationError
        If the records do not determine a combination of the unknowns.
    """
    u, extras = problem.unknowns, problem.extras
    ends: list[tuple[RealArray, list[Levels], list[Whitened], Misfit]] = []
    for start in starts_of(u):
        first = [first_levels(source) for source in problem.sources]
        z, levels = _released(problem, *_settled(problem, np.concatenate([start, extras.start]), first))
        every = problem.every(z, levels)
        ends.append((z, levels, every, misfit_of(every, [source.spectra.hertz for source in problem.sources])))
        # Two starts that ended at one fit are enough.
        closest = min(end[3].chi_square for end in ends)
        if ends[-1][3].likely or sum(end[3].chi_square < closest + SAME_FIT for end in ends) >= 2:
            break
    z, levels, every, judged = min(ends, key=lambda end: end[3].chi_square)
    size = np.concatenate([u.sizes(z[: len(u)]), np.ones(len(extras.names))])
    data = np.concatenate([w.slope.reshape(-1, len(z)) for w in every]) * size
    prior = np.hstack([u.prior(z[: len(u)])[1], np.zeros((int(np.sum(u.has_prior)), len(extras.names)))])
    labels = (*u.labels, *extras.names)
    squares = np.asarray(np.linalg.qr(data, mode="r"))
    check_determined(np.concatenate([squares, prior * size]), labels, u.suspension(z[: len(u)]))
    checks = [judged.check]
    if len(prior) and len(blind(squares)):
        checks.append(Check(Remark(EstimateCheck.BY_NOMINAL, {"names": names_in(blind(squares), labels)}), Level.CARE))
    signals = sorted((made for i, w in enumerate(every) for made in _in_time(problem, w, i)), key=lambda made: made[0])
    noise = {n: _noise(problem, own, i) for i, own in enumerate(levels) for n in problem.sources[i].numbers}
    whitened = _at_stiff_mounts(problem, z, levels, judged.inflation) or every
    covariance = _sandwich(whitened, prior, judged.inflation)
    if not judged.likely:
        apart = _from_held(problem, z, levels)
        covariance += np.outer(apart, apart)
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
        extras=extras.names,
        levels=tuple(levels),
        extra_scale=extras.scale,
        extra_values=z[len(u) :] * extras.scale,
        extra_ranges=np.column_stack([extras.lower, extras.upper]) * extras.scale[:, None],
    )


def _descended(
    problem: WheelProblem, z: RealArray, levels: Sequence[Levels], *, extras: tuple[RealArray, RealArray] | None = None
) -> RealArray:
    """Return the best unknowns near a start at given noise levels, perhaps with other bounds of the extras."""
    u, more = problem.unknowns, problem.extras
    low, high = (more.lower, more.upper) if extras is None else extras
    lower, upper = np.concatenate([u.lower, low]), np.concatenate([u.upper, high])
    return descend(
        lambda y: problem.equations(y, levels),
        np.clip(z, lower, upper),
        positive=np.concatenate([u.positive, more.positive]),
        lower=lower,
        upper=upper,
        negligible=NEGLIGIBLE_RISE,
    )


def _settled(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> tuple[RealArray, list[Levels]]:
    """Return unknowns and noise levels that belong to each other, near a start."""
    # Fits and noise levels in turn: 3 to 6 rounds are needed.
    for _ in range(12):
        before, z = z, _descended(problem, z, levels)
        every = problem.every(z, levels)
        levels = problem.levels(every, levels)
        # Change of the unknowns, in standard deviations, below which both have settled.
        if sum(float(np.sum((w.slope @ (z - before)) ** 2)) for w in every) < 0.02**2:
            break
    return z, levels


def _released(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> tuple[RealArray, list[Levels]]:
    """Return the best of the unknowns that were found and those on the other side of the ridge between stiff and soft.

    A mount acts nearly as a negative delay does, so there may be a minimum without a mount beside the right one. The
    softer one is taken if the records rule out the stiffer one.
    """
    extras = problem.extras
    if not extras.mounts:
        return z, levels
    count, mounts = len(problem.unknowns), len(extras.mounts)
    found = [z]
    for soft in SOFT:
        start = z.copy()
        start[count : count + mounts] = soft
        late = np.array([name.endswith(".delay") for name in extras.names])
        start[count:][late] += soft - float(np.mean(z[count : count + mounts]))
        found.append(_descended(problem, start, levels))
    costs = [float(np.sum(problem.equations(one, levels)[0] ** 2)) for one in found]
    best = int(np.argmin(costs))
    return (z, levels) if costs[0] - costs[best] < CHI_SQUARE_95 else _settled(problem, found[best], levels)


def _at_stiff_mounts(
    problem: WheelProblem, z: RealArray, levels: list[Levels], inflation: Ratio
) -> list[Whitened] | None:
    """Return the residuals of the best car without mounts, if the records do not rule it out; else None.

    A delay and a mount differ by the squares of both times alone, so the records tell them apart the worse the shorter
    these are. Standard deviations at chance values of such a mount would be far too small.
    """
    if not problem.extras.mounts:
        return None
    upper = problem.extras.upper.copy()
    upper[: len(problem.extras.mounts)] = HELD_WITHIN
    stiff = _descended(problem, z, levels, extras=(problem.extras.lower, upper))
    rise = np.sum(problem.equations(stiff, levels)[0] ** 2) - np.sum(problem.equations(z, levels)[0] ** 2)
    return None if float(rise) > inflation * CHI_SQUARE_95 else problem.every(stiff, levels)


def _from_held(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> RealArray:
    """Return how far the unknowns are from those of the best car with gains, delays and mounts as stated.

    What a car lacks passes for a gain of the sensor, a delay or a mount, as far as it can.
    """
    u, extras = problem.unknowns, problem.extras
    stated = extras.start.copy()
    stated[: len(extras.mounts)] = [u.car.struts[j].relaxation / TIMES for j in extras.mounts]
    held = _descended(problem, z, levels, extras=(stated - HELD_WITHIN, stated + HELD_WITHIN))
    positive = np.concatenate([u.positive, extras.positive])
    ratio = np.where(positive, z, 1.0) / np.where(positive, held, 1.0)
    return np.asarray(np.where(positive, z * np.log(ratio), z - held))


def _sandwich(every: Sequence[Whitened], prior: RealArray, inflation: Ratio = 1.0) -> RealArray:
    """Return the covariance of the unknowns from the scatter of the scores of all lines.

    The information is that of the true motion: what the noise of the estimated motion adds is subtracted. A residual is
    smaller than its noise by what was fitted to it, at few lines a large part: ``1 - h`` of its variance is left, with
    h its leverage (HC2 of J. G. MacKinnon and H. White, J. Econometrics 29 (1985) 305-325). All variances of the data
    are ``inflation`` times as large where the car does not explain them.
    """
    information, scores = prior.T @ prior, prior.T @ prior
    for w in every:
        flat = w.slope.reshape(-1, w.slope.shape[2])
        information = information + (flat.T @ flat - w.spurious) / inflation
    scale = np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    for w in every:
        lines, stretches, outputs = w.left.shape
        leverage = np.sum((w.slope @ inverse) * w.slope, axis=2) / inflation + np.sum(w.basis**2, axis=1)
        # Of the variance of a residual: where more was fitted, next to nothing is known of its noise.
        residual = w.residual / np.sqrt(np.maximum(1 - leverage, 0.1))
        own = (w.slope * residual[:, :, None]).reshape(stretches, 2, lines, outputs, -1).sum(axis=(1, 3))
        flat = own.reshape(-1, own.shape[2])
        scores = scores + flat.T @ flat / inflation
    return np.asarray(inverse @ scores @ inverse)


def _noise(problem: WheelProblem, levels: Levels, number: int) -> RealArray:
    """Return the standard deviation of white noise of the same power in the band, (channel,)."""
    source = problem.sources[number]
    outputs, causes = levels.spectra(source.basis)
    noise = np.zeros(len(source.trial.channels))
    noise[list(source.layout.outputs)] = np.sqrt(np.mean(outputs, axis=0))
    noise[list(source.layout.causes)] = np.sqrt(causes)
    return noise


def _in_time(problem: WheelProblem, found: Whitened, number: int) -> list[tuple[int, Signal, Signal]]:
    """Return the number of each record, its motion in the band as explained by the car, and what is left of it."""
    source = problem.sources[number]
    spectra, trial = source.spectra, source.trial
    left = np.zeros_like(spectra.values)
    left[:, :, list(source.layout.causes)] = spectra.values[:, :, list(source.layout.causes)] - found.motion
    left[:, :, list(source.layout.outputs)] = found.misfit
    samples = spectra.samples
    first = round(spectra.hertz[0] * samples * trial.step)
    made = []
    for shown in (spectra.values - left, left):
        lines = shown.swapaxes(0, 1)
        whole = np.zeros((len(lines), samples // 2 + 1, lines.shape[2]), complex)
        whole[:, first : first + lines.shape[1]] = lines
        time = np.fft.irfft(whole, samples, axis=1) * np.sqrt(samples)
        parts = np.split(time, np.cumsum(spectra.counts)[:-1])
        made.append(
            [
                replace(signal_of(trial), start=start, values=part.reshape(-1, lines.shape[2]).T)
                for start, part in zip(source.starts, parts, strict=True)
            ]
        )
    return list(zip(source.numbers, *made, strict=True))
