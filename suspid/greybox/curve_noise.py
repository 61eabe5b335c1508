"""Noise of force and motion of a strut, estimated from the residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from suspid.greybox.curve_fit import CurveFit, Noise, Shape, equations_of, of_spline, smoothed, spline_equations
from suspid.greybox.latent_splines import CORNER_SHARE, at_samples
from suspid.greybox.strut_motion import StrutMotion
from suspid.levels import likely
from suspid.units import Hertz, MetrePerSecond, RealArray, Second

# Lines of the residual that count: above slow drift, well below the corner of the filter.
LEAST_HERTZ: Hertz = 0.5
BELOW_CORNER = 0.8
# Length of the stretches whose spectra are averaged [s], and the number of bands of the spectrum.
SPECTRUM_STRETCH: Second = 5.0
SPECTRUM_BANDS = 16
# Test signals by which the effect of noise is computed: its spectrum is then known better than that of the residual.
PROBES = 4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Residual:
    """Spectrum of a fit's residual, and those that the assumed noise of each signal would leave, by bands."""

    power: RealArray  # (band,)
    expected: RealArray  # (band, signal)
    independent: RealArray  # values that each band averages, (band,)
    velocity: MetrePerSecond  # error of the velocity


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Drawn:
    """What drawn noises of a record do to a fit, `PROBES` of each signal in turn, (…, drawn)."""

    left: RealArray  # force that they leave, (sample, drawn)
    errors: RealArray  # of the spline, (coefficient, drawn)


def probes() -> np.random.Generator:
    """Return the generator of test noise: the same for all records, so that results do not depend on chance."""
    return np.random.default_rng(0)


def drawn_noises(motions: Sequence[StrutMotion], fit: CurveFit, shape: Shape, noise: Noise) -> list[Drawn]:
    """Return what noise does to the fit of each record: it is linear in it, and put through the fit's equations."""
    rng = probes()
    return [_drawn(m, shape, fit.theta, spline, noise, rng) for m, spline in zip(motions, fit.splines, strict=True)]


def residual_of(motions: Sequence[StrutMotion], fit: CurveFit, drawn: Sequence[Drawn]) -> Residual:
    """Return the spectra of the force that a fit leaves, and of what drawn noises leave."""
    power, expected, squares, weights = [], [], [], []
    for motion, part, noises in zip(motions, fit.records, drawn, strict=True):
        h, count, left, errors = motion.step, len(motion.force), noises.left, noises.errors
        power.append(by_bands(part.force_residual[:, None], h)[:, 0])
        expected.append(by_bands(left, h).reshape(-1, 2, PROBES).mean(axis=2))
        squares.append(float(np.mean([at_samples(errors[:, i], 1, h) ** 2 for i in range(PROBES)])))
        weights.append(count)
    return averaged(motions, power, expected, squares, weights)


def _drawn(
    motion: StrutMotion, shape: Shape, theta: RealArray, spline: RealArray, noise: Noise, rng: np.random.Generator
) -> Drawn:
    from scipy.linalg import solveh_banded

    count = len(motion.force)
    equations = equations_of(motion, shape, theta, spline, noise)
    drawn = rng.standard_normal((2, count, PROBES))
    still = np.zeros((count, PROBES))
    first = np.column_stack([smoothed(one, motion.step) for one in drawn[0].T])
    dense = [np.hstack([first, still]), np.hstack([still, drawn[1]])]
    bands, right = spline_equations(equations, dense, len(spline))
    solved = np.asarray(solveh_banded(bands, right, lower=True))
    return Drawn(left=(dense[0] - of_spline(equations.wide[0], solved)) * noise.force, errors=solved)


def averaged(
    motions: Sequence[StrutMotion],
    power: Sequence[RealArray],
    expected: Sequence[RealArray],
    squares: Sequence[float],
    weights: Sequence[int],
) -> Residual:
    """Return the spectra of several records, weighted; ``squares`` are those of the errors of the velocity."""
    share = np.array(weights) / np.sum(weights)
    return Residual(
        power=np.einsum("r,rb->b", share, power),
        expected=np.einsum("r,rbs->bs", share, expected),
        independent=_independent(motions),
        velocity=float(np.sqrt(share @ np.array(squares))),
    )


def noise_of(residual: Residual, noise: Noise) -> Noise:
    """Return the noise of both signals that the spectrum of a residual shows: a regression with gamma errors."""
    factors = np.ones(2)
    for _ in range(20):
        mean = residual.expected @ factors
        weights = residual.independent / mean**2
        scaled = residual.expected * weights[:, None]
        made = np.linalg.solve(scaled.T @ residual.expected, scaled.T @ residual.power)
        # Noise of a signal is at least this share of what noise there was taken to be: none of the two is exact.
        factors = np.maximum(made, 1e-4)
    return Noise(
        force=float(noise.force * np.sqrt(factors[0])),
        motion=float(noise.motion * np.sqrt(factors[1])),
        velocity=residual.velocity,
    )


def loud_bands(residual: Residual, noise: Noise) -> NDArray[np.bool_]:
    """Return the bands that are louder than white noise of both signals: the rest is noise, or half are loud."""
    loud = np.zeros(len(residual.power), np.bool_)
    while 2 * np.sum(loud) < len(loud):
        rest = replace(
            residual,
            power=residual.power[~loud],
            expected=residual.expected[~loud],
            independent=residual.independent[~loud],
        )
        found = noise_of(rest, noise)
        factors = np.array([(found.force / noise.force) ** 2, (found.motion / noise.motion) ** 2])
        beyond = (residual.power / (residual.expected @ factors) - 1) / np.sqrt((1 + 1 / PROBES) / residual.independent)
        if likely(float(np.sum(beyond[~loud] ** 2)), int(np.sum(~loud)) - 2):
            break
        loud[np.argmax(np.where(loud, -np.inf, beyond))] = True
    return loud


def misfit_of(residual: Residual) -> tuple[float, int]:
    """Return chi-square and its degrees of freedom of the residual's spectrum against white noise in both signals."""
    ratio = residual.power / residual.expected.sum(axis=1)
    # The expected spectrum has the errors of its draws.
    variance = (1 + 1 / PROBES) / residual.independent
    return float(np.sum((ratio - 1) ** 2 / variance)), SPECTRUM_BANDS - 2


def by_bands(signals: RealArray, step: Second) -> RealArray:
    """Return the mean power in bands of equal numbers of lines, (band, signal)."""
    from scipy.signal import welch

    length, use = lines_of(len(signals), step)
    _, density = welch(signals, fs=1 / step, nperseg=length, axis=0)
    return np.array([np.mean(band, axis=0) for band in np.array_split(density[use], SPECTRUM_BANDS)])


def lines_of(count: int, step: Second) -> tuple[int, NDArray[np.bool_]]:
    """Return the length of a stretch, and which lines of its spectrum count."""
    length = min(round(SPECTRUM_STRETCH / step), count)
    f = np.fft.rfftfreq(length, step)
    return length, (f >= LEAST_HERTZ) & (f <= BELOW_CORNER * CORNER_SHARE / step)


def _independent(motions: Sequence[StrutMotion]) -> RealArray:
    """Return how many independent values each band averages."""
    total = np.zeros(SPECTRUM_BANDS)
    for motion in motions:
        h, count = motion.step, len(motion.force)
        length, use = lines_of(count, h)
        sizes = np.array([len(one) for one in np.array_split(np.flatnonzero(use), SPECTRUM_BANDS)])
        # Neighbouring lines of a Hann window and stretches that overlap by half are not independent.
        total += sizes / 1.5 * max(0.8 * (2 * count // length - 1), 1)
    return np.maximum(total, 1.0)
