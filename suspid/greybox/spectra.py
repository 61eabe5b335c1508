"""Spectra of stretches of a record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.errors import RecordError
from suspid.greybox.trials import Trial
from suspid.signals import PASSED
from suspid.units import ComplexArray, Hertz, RealArray, Second

FEWEST_LINES = 16  # in the band: fewer do not tell a resonance from noise


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Spectra:
    """Fourier transforms of stretches of one length; white noise of variance 1 has the mean square 1 at every line."""

    values: ComplexArray  # (line, stretch, channel)
    s: ComplexArray  # (line,): j omega [rad/s]
    samples: int  # of a stretch
    counts: tuple[int, ...]  # stretches of each record, one after the other

    @property
    def hertz(self) -> RealArray:
        """Frequencies of the lines [Hz]."""
        return np.asarray(self.s.imag / (2 * np.pi))


def spectra_of(trials: Sequence[Trial], *, length: Second, band: tuple[Hertz, Hertz]) -> Spectra:
    """Return the lines in the band of stretches of about a given length of records at one rate.

    They cover a single record; of several, the ends may be left.
    """
    step = trials[0].step
    shortest = min(trial.count for trial in trials)
    if len(trials) == 1:
        samples = shortest // max(1, round(shortest * step / length))
    else:
        samples = min(shortest, round(length / step))
    hertz = np.fft.rfftfreq(samples, step)
    inside = (hertz >= band[0]) & (hertz <= min(band[1], PASSED / step))
    if np.sum(inside) < FEWEST_LINES:
        raise RecordError(
            f"the record has {np.sum(inside)} spectral lines between {band[0]:.3g} and {band[1]:.3g} Hz; at least "
            f"{FEWEST_LINES} are needed: a longer record, a higher rate or a wider band"
        )
    counts = tuple(trial.count // samples for trial in trials)
    cuts = [
        trial.values[:, : n * samples].reshape(len(trial.values), n, samples)
        for trial, n in zip(trials, counts, strict=True)
    ]
    values = np.concatenate([np.fft.rfft(cut, axis=2)[:, :, inside] for cut in cuts], axis=1) / np.sqrt(samples)
    return Spectra(
        values=np.ascontiguousarray(values.transpose(2, 1, 0)),
        s=np.asarray(2j * np.pi * hertz[inside], complex),
        samples=samples,
        counts=counts,
    )
