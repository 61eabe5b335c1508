"""Identify a decay by the ridges of its wavelet transform."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from suspid.identification.identification import Identification
from suspid.identification.steps import FourSteps
from suspid.model import ModalSet
from suspid.samples import as_samples
from suspid.signals import Signal
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real
from suspid.wavelets import sample_noise

if TYPE_CHECKING:
    import control


def by_ridges(response: control.TimeResponseData, signal: Signal, steps: FourSteps) -> Identification:
    """Return the modes that the wavelet's steps find, with the decay that they make."""
    fitted = _decay_of(steps.modes, signal, min(ridge.onset for ridge in steps.ridges))
    return Identification(
        response=response,
        method="ridge",
        modes=steps.modes,
        fitted=as_samples(signal.timepts, fitted, signal.channels, title="Fitted decay"),
        residual=as_samples(signal.timepts, signal.values - fitted, signal.channels, title="Residual"),
        noise_std=frozen_real(sample_noise(signal)),
        loudness=frozen_real(np.ones(len(steps.modes))),
        considered=(),
        steps=steps,
    )


def _decay_of(modes: ModalSet, signal: Signal, onset: float) -> RealArray:
    """Return the sum of the modes' decays and a constant nearest to the record from the onset on, (channel, sample)."""
    elapsed = signal.timepts - onset
    since = elapsed >= -0.5 * signal.step
    powers: ComplexArray = np.exp(modes.poles * elapsed[since, None])
    basis = np.column_stack([powers.real, powers.imag[:, modes.poles.imag > 0], np.ones(len(powers))])
    amplitudes, *_ = np.linalg.lstsq(basis, signal.values[:, since].T, rcond=None)
    fitted = np.zeros_like(signal.values)
    fitted[:, since] = (basis @ amplitudes).T
    return fitted
