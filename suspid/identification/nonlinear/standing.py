"""What a fit explains: what it leaves near its modes, which modes stand, and what each force is worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from suspid.identification.classification import is_tone
from suspid.identification.likelihood import bic_penalty
from suspid.identification.noise import LOUD, WhiteNoise, over_channels, power_near
from suspid.identification.nonlinear.amplitude import covariance_of, mean_pole, window_changes
from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.linearised import slopes_of
from suspid.identification.nonlinear.own import UNKNOWN, next_poles
from suspid.identification.nonlinear.structure import StructureFit
from suspid.identification.nonlinear.swings import swings_of
from suspid.identification.refinement import WORTHWHILE
from suspid.levels import SURE
from suspid.units import ComplexArray, RealArray

# What is damped as much falls within a cycle by so much that its mean over that is not its middle.
HEAVIEST_TOLD = 0.3


def explains(fit: StructureFit, highest: float) -> bool:
    """Return whether the BIC of a fit is below the highest and no more than noise is left near a mode."""
    return fit.bic < highest and not misses(fit)


def misses(fit: StructureFit | DrivenFit) -> bool:
    """Return whether more than noise is left near a mode."""
    return bool(np.any(beside(fit) > LOUD))


def leaves_more(fit: StructureFit | DrivenFit, noise: WhiteNoise) -> bool:
    """Return whether more than noise is left near a mode, or a further one stands out of the residual."""
    return misses(fit) or bool(next_poles(fit.residual, fit.variance, noise, worth=WORTHWHILE))


def beside(fit: StructureFit | DrivenFit) -> RealArray:
    """Return the power of the residual near each pole over that of white noise, (pole,)."""
    weights = np.abs(fit.amplitudes).T ** 2 / fit.variance[:, None]
    return over_channels(power_near(fit.residual, fit.variance, fit.theta), weights)


def stands(fit: StructureFit) -> NDArray[np.bool_]:
    """Return whether each pole decays, makes a cycle, stands out of the residual near it and is known, (pole,).

    It is below the Nyquist frequency.
    """
    theta, slopes = slopes_of(fit)
    covariance = fit.covariance
    if not np.all(np.isfinite(theta)):
        return np.isfinite(theta)
    left = _excess(fit)
    variances = np.diag(slopes @ covariance @ slopes.T).reshape(-1, 2) * left[:, None]
    count = fit.residual.shape[1]
    tones = [is_tone(-each.real, float(np.sqrt(v[0])), count) for each, v in zip(theta, variances, strict=True)]
    known = np.sqrt(np.sum(variances, axis=1)) < UNKNOWN * np.abs(theta)
    turns = (theta.imag * count > 2 * np.pi) & (np.abs(theta) < np.pi)
    return np.asarray(_worthwhile(fit, fit.motion.states[0], left) & ~np.array(tones) & known & turns)


def driven_stands(fit: DrivenFit) -> NDArray[np.bool_]:
    """Return the same of a fit with forces as they follow from the motion that was measured, (pole,).

    A cycle is one between its turns, and its rest lies between them.
    """
    left = _excess(fit)
    means = [mean_pole(fit, k) for k in range(len(fit.theta))]
    theta, covariance = np.array([each for each, _ in means]), covariance_of(fit)
    spread = np.sqrt([np.trace(slopes @ covariance @ slopes.T) for _, slopes in means] * left)
    # Nothing can be known of what turns faster than the samples.
    visible = (theta.imag > 0) & (np.abs(theta) < np.pi)
    if not np.all(visible):
        return np.asarray(visible)
    spread = np.maximum(spread, [np.max(np.abs(window_changes(fit, k, each))) for k, each in enumerate(theta)])
    turns = np.array([swings_of(fit, k) is not None for k in range(len(theta))])
    rates = np.sqrt([(slopes @ covariance @ slopes.T)[0, 0] for _, slopes in means] * left)
    tones = [is_tone(-each.real, std, fit.residual.shape[1]) for each, std in zip(theta, rates, strict=True)]
    known = spread < UNKNOWN * np.abs(theta)
    return np.asarray(_worthwhile(fit, fit.states, left) & ~np.array(tones) & turns & known & ~_strays(fit))


def _strays(fit: DrivenFit) -> NDArray[np.bool_]:
    """Return whether each mode swings beside its rest, most of the time that it is seen, (pole,).

    Forces that follow a motion may move its middle, but between its turns it passes its rest: what is pushed further
    away than it swings follows a drift, and its swings are not those of the record.
    """
    from scipy.ndimage import uniform_filter1d

    out = np.zeros(len(fit.theta), bool)
    above = np.max(np.abs(fit.amplitudes) / np.sqrt(fit.variance), axis=1)
    for k, (theta, state, size) in enumerate(zip(fit.theta, fit.states, above, strict=True)):
        turns = 2 * np.pi / len(state) < theta.imag < np.pi
        if not turns or -theta.real > HEAVIEST_TOLD * abs(theta):
            continue
        cycle = round(2 * np.pi / theta.imag)
        middle = uniform_filter1d(state, cycle)
        inside = slice(cycle // 2, len(state) - cycle // 2)
        middle, swing = middle[inside], np.abs(state[inside] - middle[inside])
        seen = size * swing > SURE
        out[k] = np.sum(np.abs(middle[seen]) > swing[seen]) > 0.5 * np.sum(seen)
    return out


def energies(fit: StructureFit | DrivenFit, states: ComplexArray) -> RealArray:
    """Return the energy of each pole's motion over the variance of the residual, (pole,)."""
    energy = np.sum(np.abs(fit.amplitudes).T ** 2 / fit.variance[:, None], axis=0)
    return np.asarray(energy * np.sum(np.abs(states) ** 2, axis=1) / 2)


def _excess(fit: StructureFit | DrivenFit) -> RealArray:
    """Return the power of the residual near each pole over that of white noise; 1 where that may be chance, (pole,)."""
    left = beside(fit)
    return np.where(left > LOUD, left, 1.0)


def _worthwhile(fit: StructureFit | DrivenFit, states: ComplexArray, left: RealArray) -> NDArray[np.bool_]:
    """Return whether each pole stands out of the residual near it, (pole,): as in a linear fit where that is noise."""
    needed = np.where(left > LOUD, WORTHWHILE * left, 1.0) * bic_penalty(len(fit.residual), fit.residual.size)
    return np.asarray(energies(fit, states) > needed)


def worths_of(fit: StructureFit) -> RealArray:
    """Return the gain of each force in twice the log likelihood, from its gains and their covariance, (force,)."""
    covariance, gains = fit.covariance, fit.structures.gains[0]
    first = 2 * (fit.structures.theta.size + fit.structures.shapes.size)
    out = np.empty(len(fit.forces))
    for j in range(len(out)):
        places = first + 2 * (np.arange(len(gains)) * len(out) + j)
        at = np.ravel(np.column_stack([places, places + 1]))
        parts = np.column_stack([gains[:, j].real, gains[:, j].imag]).ravel()
        scale = 1 / np.sqrt(np.maximum(covariance.diagonal()[at], 1e-300))
        unit = covariance[np.ix_(at, at)] * np.outer(scale, scale)
        out[j] = (parts * scale) @ np.linalg.lstsq(unit, parts * scale, rcond=1e-6)[0]
    return out
