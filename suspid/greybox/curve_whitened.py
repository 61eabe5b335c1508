"""Fit of a damper curve beside a coloured force on the body: least squares behind the inverse of its spectrum.

A force on the body moves the strut, so that residual and motion have a part in common. Least squares take it for
stiffness, unless each residual is what cannot be predicted from those before it: a prediction error (L. Ljung, System
Identification, ch. 7). The motion is that of the accelerometers, and the columns are averaged over its error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.greybox.curve_fit import LOWEST, SCORE_BLOCK, CurveFit, Noise, Shape, first_spline, pass_high, smoothed
from suspid.greybox.curve_following import Following
from suspid.greybox.curve_noise import BELOW_CORNER, SPECTRUM_STRETCH
from suspid.greybox.force_basis import sign_between, smooth_weights
from suspid.greybox.latent_splines import CORNER_SHARE, at_samples, between_samples, filtered
from suspid.greybox.strut_motion import StrutMotion
from suspid.units import MetrePerSecond, RealArray, Second

# How far back a force is predicted from [s]: lines of two thirds of a hertz are told apart.
MEMORY: Second = 0.75
# Variance that the prediction adds to that of the residual, as its share: behind the filter there is hardly any power.
POWER_FLOOR = 1e-6
# How often spectrum and curve are found in turn: the third changes the stiffness by a hundredth of its error.
WHITENING_ROUNDS = 4
# In how many of them the noise of the motion is found: from none, which biases friction, to what a residual allows.
MOTION_ROUNDS = 3
# Where it begins: noise of the motion of very good accelerometers [m/s2].
FIRST_NOISE = 0.01
# Lowest line of the residual's spectrum that is used, as a multiple of the lowest frequency: there the filter lowers it
# by 8 %. Neighbouring lines are averaged, because the smallest of single lines is half of the mean.
HARDLY_LOWERED, ALIKE_LINES = 1.5, 3
# Left out at both ends, where the motion is not known: a period of the lowest frequency that is used.
AT_ENDS: Second = 1.0 / LOWEST
# Least length in which a spectrum is known, in those that are predicted from.
LEAST_MEMORIES = 15
# Delay between force and motion that noise of the motion may look like: a twentieth of a millisecond makes the
# stiffness of a car wrong by half a percent.
UNSEEN_DELAY: Second = 5e-5


def whitened_fit(
    motions: Sequence[StrutMotion], shape: Shape, fit: CurveFit, noise: Noise
) -> tuple[CurveFit, Noise, Following] | None:
    """Return the fit that leaves the least that cannot be predicted, the noise, and whether what is left follows.

    None where records are short.
    """
    step = motions[0].step
    memory = round(MEMORY / step)
    long = [one for one in motions if len(one.force) - 2 * round(AT_ENDS / step) > LEAST_MEMORIES * memory]
    if not long:
        return None
    theta, motion, sides = fit.theta, min(noise.motion, FIRST_NOISE), list[tuple[RealArray, RealArray]]()
    for k in range(WHITENING_ROUNDS):
        if k < MOTION_ROUNDS:
            sides = [_sides(one, shape, motion) for one in long]
        predictor = _predictor([force - columns @ theta for columns, force in sides], memory)
        parts = [(_behind(columns, predictor), _behind(force, predictor)) for columns, force in sides]
        normal = np.array(sum(columns.T @ columns for columns, _ in parts))
        theta = np.linalg.solve(normal, np.array(sum(columns.T @ force for columns, force in parts)))
        # That of a fit with white noise is too small: it takes the force for noise of the body.
        motion = _most_noise([force - columns @ theta for columns, force in sides], shape, theta, step)
    block = max(1, round(SCORE_BLOCK / step))
    scores = []
    for columns, force in parts:
        blocks = len(force) // block
        own = columns * (force - columns @ theta)[:, None]
        scores.append(own[: blocks * block].reshape(blocks, block, -1).sum(axis=1))
    every, inverse = np.concatenate(scores), np.linalg.inv(normal)
    spread = len(every) / max(len(every) - len(theta), 1)
    # Whether the fit before has settled does not matter: this one does not begin with its motion.
    made = replace(
        fit,
        theta=theta,
        covariance=inverse @ (every.T @ every) @ inverse * spread,
        steps=WHITENING_ROUNDS,
        settled=True,
    )
    error = max(_velocity_error(motion, step, len(one.force)) for one in long)
    more = [
        _behind(_missing(one, columns[:, 1:] @ theta[1:], step), predictor)
        for one, (columns, _) in zip(long, sides, strict=True)
    ]
    return made, replace(noise, motion=motion, velocity=error), _followed(parts, more, theta, block, step)


def _missing(motion: StrutMotion, damper: RealArray, step: Second) -> RealArray:
    """Return what a wrong sensor, a mount or a bent spring adds to the force, but for a factor, (sample, 3).

    That is the motion of the other end of the strut, the cube of the travel, and the change of the damper's force in a
    step. A force on the body moves the body: the other end tells apart what that and a wrong sensor leave.
    """
    end = round(AT_ENDS / step)
    other = first_spline(replace(motion, share=0.0))
    signals = np.column_stack([at_samples(other, 0, step), at_samples(first_spline(motion), 0, step) ** 3])
    smooth = np.column_stack([smoothed(one, step) for one in signals.T])
    return np.column_stack([_above(smooth, step)[end:-end], np.diff(damper, prepend=damper[0])])


def _followed(
    parts: Sequence[tuple[RealArray, RealArray]],
    more: Sequence[RealArray],
    theta: RealArray,
    block: int,
    step: Second,
) -> Following:
    """Return the test that what cannot be predicted follows nothing that is missing in the strut: of its scores."""
    from scipy.stats import t

    whole = [slice(len(one) // block * block) for one in more]
    columns = np.concatenate([one[use] for (one, _), use in zip(parts, whole, strict=True)])
    left = np.concatenate([force[use] for (_, force), use in zip(parts, whole, strict=True)]) - columns @ theta
    extra = np.concatenate([one[use] for one, use in zip(more, whole, strict=True)])
    extra = extra - columns @ np.linalg.lstsq(columns, extra, rcond=None)[0]
    scores = (extra * left[:, None]).reshape(-1, block, extra.shape[1]).sum(axis=1)
    std = np.sqrt(len(scores) * np.var(scores, axis=0, ddof=1))
    ratios = np.sum(scores, axis=0) / std
    # The last one is a delay, in steps; noise of the motion looks like a small one.
    allowed = UNSEEN_DELAY / step * np.sum(extra[:, -1] ** 2) / std[-1]
    beyond = np.append(np.abs(ratios[:-1]), max(abs(float(ratios[-1])) - allowed, 0.0))
    return Following(
        statistic=float(np.mean(ratios[:-1] ** 2)),
        p_value=min(1.0, len(beyond) * 2 * float(t.sf(np.max(beyond), len(scores) - 1))),
        share=float("nan"),
    )


def _most_noise(residuals: Sequence[RealArray], shape: Shape, theta: RealArray, step: Second) -> float:
    """Return the most that the noise of the motion can be: at no frequency does it leave more than there is."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import welch

    forces = shape.forces(theta)
    damping = float(forces @ shape.nodes / (shape.nodes @ shape.nodes))
    least = np.inf
    for one in residuals:
        f, power = welch(one, fs=1 / step, nperseg=round(SPECTRUM_STRETCH / step))
        use = (f > HARDLY_LOWERED * LOWEST) & (f <= BELOW_CORNER * CORNER_SHARE / step)
        f, power = f[use], uniform_filter1d(power, ALIKE_LINES)[use]
        per_noise = np.abs(theta[0] / (2 * np.pi * f) ** 2 + damping / (2j * np.pi * f)) ** 2 * 2 * step
        least = min(least, float(np.min(power / per_noise)))
    return float(np.sqrt(least))


def _sides(motion: StrutMotion, shape: Shape, noise: float) -> tuple[RealArray, RealArray]:
    """Return the force per unknown, (sample, unknown), and the force, of a record above the lowest frequency."""
    h, spline = motion.step, first_spline(motion)
    x, v = between_samples(spline, 0, h), between_samples(spline, 1, h)
    error = _velocity_error(noise, h, len(motion.force))
    parts = [x[:, None], smooth_weights(v, shape.nodes, error)[:, shape.nodes != 0]]
    parts += [sign_between(v, error)[:, None]] if shape.friction else []
    columns = filtered(np.hstack(parts), h, CORNER_SHARE / h)
    both = _above(np.column_stack([columns, smoothed(motion.force, h)]), h)
    end = round(AT_ENDS / h)
    return both[end:-end, :-1], both[end:-end, -1]


def _velocity_error(noise: float, step: Second, count: int) -> MetrePerSecond:
    """Return the standard deviation of a velocity that is integrated from white noise above the lowest frequency."""
    f = np.asarray(np.fft.rfftfreq(count, step)[1:], float)
    return float(np.sqrt(np.sum((pass_high(f) / (2 * np.pi * f)) ** 2) * f[0] * 2 * step) * noise)


def _above(signals: RealArray, step: Second) -> RealArray:
    """Return signals above the lowest frequency, as the motion is, (sample, column)."""
    count = len(signals)
    lines = np.fft.rfft(signals - np.mean(signals, axis=0), 2 * count, axis=0)
    return np.asarray(
        np.fft.irfft(lines * pass_high(np.asarray(np.fft.rfftfreq(2 * count, step), float))[:, None], axis=0)[:count]
    )


def _predictor(residuals: Sequence[RealArray], memory: int) -> RealArray:
    """Return the filter that takes off what can be predicted (Yule and Walker)."""
    from scipy.linalg import solve_toeplitz

    common = np.zeros(memory + 1)
    for one in residuals:
        common += np.fft.irfft(np.abs(np.fft.rfft(one, 2 * len(one))) ** 2)[: memory + 1]
    common[0] *= 1 + POWER_FLOOR
    return np.concatenate([[1.0], -np.asarray(solve_toeplitz(common[:memory], common[1:]))])


def _behind(signals: RealArray, predictor: RealArray) -> RealArray:
    from scipy.signal import lfilter

    return np.asarray(lfilter(predictor, [1.0], signals, axis=0)[len(predictor) - 1 :])
