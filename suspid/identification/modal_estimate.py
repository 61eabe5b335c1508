"""Modes with their uncertainty, from the poles that were selected."""

from __future__ import annotations

import numpy as np

from suspid.identification.covariance import joint_covariance
from suspid.identification.halves import disagreement
from suspid.identification.noise import shared_noise
from suspid.identification.selection import Selection
from suspid.model import ModalSet
from suspid.units import RealArray, Second
from suspid.values import frozen_real


def modes_of(
    selection: Selection, values: RealArray, *, step: Second, channels: tuple[str, ...]
) -> tuple[ModalSet, RealArray]:
    """Return the modes of one decay and how loud the residual is near each, (mode,).

    The variances of a mode are widened by its loudness, or by the square of the disagreement of the two halves of
    the decay where that is more, and by noise that the channels share.

    Parameters
    ----------
    selection : Selection
        The poles.
    values : ndarray (channel, sample)
        The record less its mean.
    step : float
        Sampling step [s].
    channels : tuple of str
        Names of the channels.
    """
    fit, kept = selection.fit, selection.modes
    loudness = selection.loudness[kept]
    widening = loudness * shared_noise(selection.residual)
    noise_std = np.sqrt(fit.squares / fit.count)
    for k in np.flatnonzero((loudness > 1) & (kept < len(fit.poles.pairs))):
        widening[k] = np.nanmax([widening[k], disagreement(values, fit.poles, int(kept[k]), noise_std) ** 2])
    joint = joint_covariance([fit], kept, widening)
    order = np.argsort(np.abs(joint.exponents), kind="stable")
    return joint.modes(step=step, channels=channels), frozen_real(loudness[order])
