"""Errors in variables: the motion of wheels is the cause, as measured, and the road cancels.

Per stretch and line ``r = Y_o - T Y_g - (ends)``, ``R = S_o + T S_g T^H``, and ``sum r^H R^-1 r`` is minimised. The
true motion of the wheels is free at every line; ``log det R`` would make that inconsistent and is left out. With the
best motion ``X = Y_g + S_g T^H R^-1 r`` the derivatives are ``-R^(-1/2) dT X``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.further import label
from suspid.greybox.noise_levels import Levels, levels_of, shared_of
from suspid.greybox.spectra import Spectra
from suspid.greybox.transfers import Layout, Physics, transfer
from suspid.greybox.trials import Trial
from suspid.greybox.whitened import Whitened, precision, turned, whitened
from suspid.reconstruction import Unknowns
from suspid.units import RealArray, Second

# Least noise, as a share of that at the start: 80 dB below the signal, where what the ends of a stretch leave, held by
# polynomials, would be taken for an error of the car.
LEAST_NOISE = 1e-5


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Source:
    """Trials of one logger with measured causes."""

    trial: Trial  # the first of them
    numbers: tuple[int, ...]  # of the trials, among all
    starts: tuple[Second, ...]  # of the trials
    layout: Layout
    spectra: Spectra
    basis: RealArray  # (line, node): of the spectra of noise
    gains: tuple[int, ...]  # channels whose gain is unknown
    delays: tuple[int, ...]  # channels whose delay is unknown


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Extras:
    """Unknowns besides those of the car: relaxations of mounts, and gains and delays of channels."""

    names: tuple[str, ...]
    mounts: tuple[int, ...]  # struts, common to all trials
    start: RealArray
    positive: np.ndarray[tuple[int], np.dtype[np.bool_]]
    scale: RealArray
    lower: RealArray
    upper: RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class WheelProblem:
    """All trials with measured causes, and their unknowns: those of the car, then the extras."""

    sources: tuple[Source, ...]
    unknowns: Unknowns
    extras: Extras

    def physics(self, z: RealArray, number: int) -> Physics:
        """Return the values of all parameters for one trial."""
        u, source = self.unknowns, self.sources[number]
        struts, count = len(u.car.struts), len(u)
        p, more = u.parameters(z[:count]), z[count:] * self.extras.scale
        values = dict(zip(self.extras.names, more.tolist(), strict=True))
        tau = np.array([s.relaxation for s in u.car.struts])
        for j in self.extras.mounts:
            tau[j] = values[f"{u.car.struts[j].name}.relaxation"]
        channels = source.trial.channels
        return Physics(
            stiffness=p[:struts],
            damping=p[struts : 2 * struts],
            masses=p[2 * struts :] + source.trial.added,
            relaxation=tau,
            gains=np.array([values.get(f"{label(c, number, len(self.sources))}.gain", 1.0) for c in channels]),
            delays=np.array([values.get(f"{label(c, number, len(self.sources))}.delay", 0.0) for c in channels]),
        )

    def columns(self, number: int) -> RealArray:
        """Return how the parameters of `transfer` follow from the unknowns, (parameter, unknown)."""
        u, source, extras = self.unknowns, self.sources[number], self.extras
        channels = source.trial.channels
        names = [f"{u.car.struts[j].name}.relaxation" for j in extras.mounts]
        names += [f"{label(channels[c], number, len(self.sources))}.gain" for c in source.gains]
        names += [f"{label(channels[c], number, len(self.sources))}.delay" for c in source.delays]
        whole = np.zeros((len(u.rows) + len(names), len(u) + len(extras.names)))
        whole[: len(u.rows), : len(u)] = u.spread[u.rows]
        for i, name in enumerate(names):
            at = extras.names.index(name)
            whole[len(u.rows) + i, len(u) + at] = extras.scale[at]
        return whole

    def whitened(self, z: RealArray, number: int, levels: Levels) -> Whitened:
        """Return the residual of one trial at given noise levels."""
        source = self.sources[number]
        made = transfer(
            source.layout, source.spectra.s, self.physics(z, number), self.unknowns.rows,
            mounts=self.extras.mounts, gains=source.gains, delays=source.delays,
        )  # fmt: skip
        outputs, causes = levels.spectra(source.basis)
        return whitened(
            source.spectra.values, source.layout, made, outputs=outputs, causes=causes, columns=self.columns(number)
        )

    def every(self, z: RealArray, levels: Sequence[Levels]) -> list[Whitened]:
        """Return the residuals of all trials at given noise levels."""
        return [self.whitened(z, i, own) for i, own in enumerate(levels)]

    def equations(self, z: RealArray, levels: Sequence[Levels]) -> tuple[RealArray, RealArray]:
        """Return residual and derivatives of all trials, turned into as few rows as can be."""
        return self.compressed(z, self.every(z, levels))

    def compressed(self, z: RealArray, found: Sequence[Whitened]) -> tuple[RealArray, RealArray]:
        """Return residual and derivatives of all trials at z, turned into as few rows as can be."""
        count = len(self.unknowns)
        prior, slope = self.unknowns.prior(z[:count])
        parts = [(prior, np.hstack([slope, np.zeros((len(prior), len(z) - count))]))]
        parts += [w.rows() for w in found]
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    def levels(self, found: Sequence[Whitened], before: Sequence[Levels]) -> list[Levels]:
        """Return the noise levels from the moments of residuals; those of ``before`` are where the search begins."""
        levels = list(before)
        for i, (source, w) in enumerate(zip(self.sources, found, strict=True)):
            left = w.left
            lines, stretches, outputs = left.shape
            # What was projected out is missing from the moments.
            share = np.sum(w.basis.reshape(2, lines, outputs, -1) ** 2, axis=(0, 2, 3)) / (2 * outputs)
            moments = turned(left) @ left.conj() / stretches
            moments /= np.maximum(1 - share, 0.1)[:, None, None]
            anchor = first_levels(source)
            causes = source.spectra.values[:, :, list(source.layout.causes)]
            shared = shared_of(w.transfer.T, precision(w.factor), left, causes)
            own = levels_of(
                w.transfer.T, moments, source.basis, before[i], anchor=anchor, count=stretches, shared=shared
            )
            levels[i] = Levels(
                outputs=np.maximum(own.outputs, anchor.outputs + np.log(LEAST_NOISE)),
                causes=np.maximum(own.causes, anchor.causes + np.log(LEAST_NOISE)),
            )
        return levels


def first_levels(source: Source) -> Levels:
    """Return noise levels to begin with: the same small share of every channel."""
    power = np.log(1e-3 * np.mean(np.abs(source.spectra.values) ** 2, axis=(0, 1)))
    nodes = source.basis.shape[1]
    return Levels(
        outputs=np.tile(power[list(source.layout.outputs)], (nodes, 1)), causes=power[list(source.layout.causes)]
    )
