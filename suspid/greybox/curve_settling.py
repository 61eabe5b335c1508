"""Noise and curve of a strut, found in turn; and both readings of a residual that is not white."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from suspid.greybox.curve_fit import CurveFit, Noise, Shape, fitted_curve
from suspid.greybox.curve_following import Following, following_of
from suspid.greybox.curve_noise import Residual, drawn_noises, lines_of, loud_bands, misfit_of, noise_of, residual_of
from suspid.greybox.curve_whitened import whitened_fit
from suspid.greybox.strut_motion import StrutMotion
from suspid.levels import NORMAL_95, likely
from suspid.units import MetrePerSecond2

# How often noise and curve are found in turn. After one round the noise of the motion is at its least value in half of
# the drives of a half car whose sensors are equally noisy, and chi-square is too large by 70 %; after three by 12 %.
CURVE_ROUNDS = 3
# Noise of a good accelerometer, from which a fit begins. Where what is left is taken for a force on the body, the noise
# of the motion is at most that.
QUIET: MetrePerSecond2 = 0.05
# Up to this multiple of the frequency of the body on the strut, a force on the body moves the strut: by a third of what
# it does at rest, or more.
SOFT_UP_TO = 2.0


def settled(motions: Sequence[StrutMotion], shape: Shape, fit: CurveFit, noise: Noise) -> tuple[CurveFit, Noise]:
    """Return curve and noise found in turn; noise is only raised, and a record without noise is left as it is."""
    for _ in range(CURVE_ROUNDS - 1):
        shown = noise_of(residual_of(motions, fit, drawn_noises(motions, fit, shape, noise)), noise)
        raised = replace(shown, force=max(noise.force, shown.force), motion=max(noise.motion, shown.motion))
        try:
            fit, noise = fitted_curve(motions, shape, fit.theta, fit.splines, raised), raised
        except (np.linalg.LinAlgError, ValueError):
            break
    return fit, noise


def is_lost(shape: Shape, fit: CurveFit) -> bool:
    """Return whether not even the sign of the largest force is known, at 95 %: such a curve says nothing."""
    forces = shape.forces(fit.theta)
    stds = np.sqrt(np.diag(fit.covariance)[1 : len(shape.nodes)])
    return not NORMAL_95 * float(np.max(stds)) < float(np.max(np.abs(forces)))


def of_both_readings(
    motions: Sequence[StrutMotion], shape: Shape, fit: CurveFit, noise: Noise
) -> tuple[CurveFit, Noise, Residual, Following]:
    """Return a fit with what is left, and whether that follows the motion of the strut.

    Where the residual is not that of white noise, the curve is found beside a force on the body of any spectrum, and
    kept if what that leaves does not follow the motion. If it does, a sensor may be wrong: its spectrum is like that of
    noise in the motion, and the curve is found once more with a quiet sensor of the motion. The covariance holds the
    difference of both, and that residual is judged which follows the motion more.
    """
    drawn = drawn_noises(motions, fit, shape, noise)
    left, follows = residual_of(motions, fit, drawn), following_of(motions, shape, fit, drawn)
    if likely(*misfit_of(left)):
        return fit, noise, left, follows
    beside = _beside_a_force(motions, shape, fit, noise)
    if beside is not None and not beside[2]:
        return beside[0], beside[1], left, beside[2]
    instead = fit if beside is None else beside[0]
    force = np.sqrt(np.mean(np.concatenate([part.force_residual for part in fit.records]) ** 2))
    quiet = replace(noise, force=float(force), motion=min(QUIET, noise.motion))
    try:
        other = fitted_curve(motions, shape, fit.theta, fit.splines, quiet)
        there = following_of(motions, shape, other, drawn_noises(motions, other, shape, quiet))
    except (np.linalg.LinAlgError, ValueError):  # one reading alone does not explain the record
        return instead, noise, left, replace(follows, pushed=True)
    apart = np.outer(other.theta - fit.theta, other.theta - fit.theta)
    worse = min(follows, there, key=lambda one: one.p_value)
    if beside is not None and beside[2].p_value < worse.p_value:
        worse = replace(beside[2], share=worse.share)
    worse = replace(worse, pushed=too_loud(motions, fit, noise, left))
    if worse.pushed:
        return instead, noise, left, worse
    return replace(fit, covariance=fit.covariance + apart), noise, left, worse


def _beside_a_force(
    motions: Sequence[StrutMotion], shape: Shape, fit: CurveFit, noise: Noise
) -> tuple[CurveFit, Noise, Following] | None:
    """Return the fit with the curve beside a force of any spectrum, its noise and its test; None if not found."""
    try:
        return whitened_fit(motions, shape, fit, noise)
    except (np.linalg.LinAlgError, ValueError):
        return None


def too_loud(motions: Sequence[StrutMotion], fit: CurveFit, noise: Noise, left: Residual) -> bool:
    """Return whether bands are too loud in which a force on the body moves the strut, or half of all.

    The residual and the motion then have a part in common that is taken for stiffness.
    """
    step = motions[0].step
    length, use = lines_of(min(len(m.force) for m in motions), step)
    starts = [band[0] for band in np.array_split(np.fft.rfftfreq(length, step)[use], len(left.power))]
    own = np.sqrt(max(abs(motions[0].share) * float(fit.theta[0]), 0.0)) / (2 * np.pi)
    loud = loud_bands(left, noise)
    return bool(np.any(loud & (np.array(starts) < SOFT_UP_TO * own)) or 2 * np.sum(loud) >= len(loud))
