"""Estimates in the frequency domain: the measured motion of wheels is the cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from suspid.greybox.fits import Fit
from suspid.greybox.identifiability import blind, check_determined, names_in
from suspid.greybox.leftover import coherent_leftover
from suspid.greybox.measured_causes import WheelProblem, Whitened, first_levels
from suspid.greybox.noise_levels import Levels
from suspid.greybox.search import starts_of
from suspid.greybox.trials import signal_of
from suspid.levels import CHI_SQUARE_95, likely
from suspid.reconstruction import descend
from suspid.signals import Signal
from suspid.units import Hertz, Ratio, RealArray
from suspid.words import Check, Level, Number, Remark
from suspid.words.greybox import EstimateCheck

NEGLIGIBLE_RISE = 1e-3  # gain of chi-square that ends a descent
SOFT = (0.2, 0.5)  # relaxations from which softer mounts are looked for, of `TIMES`: 2 and 5 ms


def fit_in_frequency(problem: WheelProblem) -> Fit:
    """Return the best car under measured causes.

    Raises
    ------
    EstimationError
        If the records do not determine a combination of the unknowns.
    """
    u, extras = problem.unknowns, problem.extras
    ends: list[tuple[RealArray, list[Levels], list[Whitened], Judged]] = []
    for start in starts_of(u):
        first = [first_levels(source) for source in problem.sources]
        z, levels = _released(problem, *_settled(problem, np.concatenate([start, extras.start]), first))
        every = problem.every(z, levels)
        ends.append((z, levels, every, _judged(problem, every)))
        if ends[-1][3].likely:
            break
    z, levels, every, judged = min(ends, key=lambda end: end[3].chi_square)
    size = np.concatenate([u.sizes(z[: len(u)]), np.ones(len(extras.names))])
    data = np.concatenate([w.slope.reshape(-1, len(z)) for w in every]) * size
    prior = np.hstack([u.prior(z[: len(u)])[1], np.zeros((int(np.sum(u.has_prior)), len(extras.names)))])
    labels = (*u.labels, *extras.names)
    squares = np.asarray(np.linalg.qr(data, mode="r"))
    check_determined(np.concatenate([squares, prior * size]), labels, u.suspension(z[: len(u)]))
    checks = [_said(judged)]
    if len(prior) and len(blind(squares)):
        checks.append(Check(Remark(EstimateCheck.BY_NOMINAL, {"names": names_in(blind(squares), labels)}), Level.CARE))
    signals = sorted((made for i, w in enumerate(every) for made in _in_time(problem, w, i)), key=lambda made: made[0])
    noise = {n: _noise(problem, own, i) for i, own in enumerate(levels) for n in problem.sources[i].numbers}
    return Fit(
        x=z[: len(u)],
        covariance=_sandwich(_at_stiff_mounts(problem, z, levels) or every, prior),
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


def _descended(problem: WheelProblem, z: RealArray, levels: Sequence[Levels], *, stiff: bool = False) -> RealArray:
    """Return the best unknowns near a start at given noise levels, perhaps without mounts."""
    u, extras = problem.unknowns, problem.extras
    upper = extras.upper.copy()
    if stiff:
        # Of `TIMES`: as good as no relaxation.
        upper[: len(extras.mounts)] = 1e-9
    ceiling = np.concatenate([u.upper, upper])
    return descend(
        lambda y: problem.equations(y, levels),
        np.minimum(z, ceiling),
        positive=np.concatenate([u.positive, extras.positive]),
        lower=np.concatenate([u.lower, extras.lower]),
        upper=ceiling,
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


def _at_stiff_mounts(problem: WheelProblem, z: RealArray, levels: list[Levels]) -> list[Whitened] | None:
    """Return the residuals of the best car without mounts, if the records do not rule it out; else None.

    A delay and a mount differ by the squares of both times alone, so the records tell them apart the worse the shorter
    these are. Standard deviations at chance values of such a mount would be far too small.
    """
    if not problem.extras.mounts:
        return None
    stiff = _descended(problem, z, levels, stiff=True)
    rise = np.sum(problem.equations(stiff, levels)[0] ** 2) - np.sum(problem.equations(z, levels)[0] ** 2)
    return None if float(rise) > CHI_SQUARE_95 else problem.every(stiff, levels)


class Judged(NamedTuple):
    """Whether what is left of the outputs follows the given motion."""

    chi_square: float
    freedom: int
    error: Ratio  # largest of a transfer
    hertz: Hertz  # where

    @property
    def likely(self) -> bool:
        """Whether the statistic is not improbably large."""
        return likely(self.chi_square, self.freedom)


def _judged(problem: WheelProblem, every: Sequence[Whitened]) -> Judged:
    parts = [
        Judged(*coherent_leftover(w, source.spectra.hertz)) for w, source in zip(every, problem.sources, strict=True)
    ]
    worst = max(parts, key=lambda part: part.chi_square / max(part.freedom, 1))
    return worst._replace(
        chi_square=sum(part.chi_square for part in parts), freedom=sum(part.freedom for part in parts)
    )


def _said(judged: Judged) -> Check:
    numbers: dict[str, Number] = {"chi_square": judged.chi_square, "freedom": judged.freedom}
    if judged.likely:
        return Check(Remark(EstimateCheck.NOTHING_FOLLOWS, numbers), Level.SOUND)
    return Check(
        Remark(EstimateCheck.FOLLOWS, {**numbers, "error": judged.error, "hertz": judged.hertz}), Level.DOUBTFUL
    )


def _sandwich(every: Sequence[Whitened], prior: RealArray) -> RealArray:
    """Return the covariance of the unknowns from the scatter of the scores of all lines.

    The information is that of the true motion: what the noise of the estimated motion adds is subtracted. A residual is
    smaller than its noise by what was fitted to it, at few lines a large part: ``1 - h`` of its variance is left, with
    h its leverage (HC2 of J. G. MacKinnon and H. White, J. Econometrics 29 (1985) 305-325).
    """
    information, scores = prior.T @ prior, prior.T @ prior
    for w in every:
        flat = w.slope.reshape(-1, w.slope.shape[2])
        information = information + flat.T @ flat - w.spurious
    scale = np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    for w in every:
        lines, stretches, outputs = w.left.shape
        leverage = np.sum((w.slope @ inverse) * w.slope, axis=2) + np.sum(w.basis**2, axis=1)
        # Of the variance of a residual: where more was fitted, next to nothing is known of its noise.
        residual = w.residual / np.sqrt(np.maximum(1 - leverage, 0.1))
        own = (w.slope * residual[:, :, None]).reshape(stretches, 2, lines, outputs, -1).sum(axis=(1, 3))
        flat = own.reshape(-1, own.shape[2])
        scores = scores + flat.T @ flat
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
