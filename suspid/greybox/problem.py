"""Output error of all tests as one least-squares problem in the unknowns of the suspension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.greybox.further import mounts_of, sensing_of
from suspid.greybox.responses import OutputError, output_error
from suspid.greybox.trials import HOLDS, Hold, Trial
from suspid.reconstruction import Unknowns
from suspid.units import RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Problem:
    """Tests and unknowns."""

    trials: tuple[Trial, ...]
    holds: tuple[Hold, ...]  # by test
    unknowns: Unknowns

    def errors(self, x: RealArray, noise: Sequence[RealArray], *, slopes: bool = True) -> list[OutputError]:
        """Return the residual of each test, given the standard deviation of the noise of each channel."""
        u = self.unknowns
        p, mounts, rows = u.parameters(x), mounts_of(u), u.rows if slopes else ()
        return [
            output_error(
                u.car, trial, p, rows, std=std, hold=hold, mounts=mounts,
                sensing=sensing_of(u, p, i, len(trial.channels)),
            )
            for i, (trial, hold, std) in enumerate(zip(self.trials, self.holds, noise, strict=True))
        ]  # fmt: skip

    def equations(self, x: RealArray, noise: Sequence[RealArray]) -> tuple[RealArray, RealArray]:
        """Return the residual in standard deviations and its derivatives by x, turned into as few rows as can be."""
        parts = [self.unknowns.prior(x)]
        parts += [self.compressed(error, std) for error, std in zip(self.errors(x, noise), noise, strict=True)]
        return np.concatenate([r for r, _ in parts]), np.concatenate([s for _, s in parts])

    def compressed(self, error: OutputError, std: RealArray) -> tuple[RealArray, RealArray]:
        """Return rows of the same norm and inner products as a residual and its derivatives by x."""
        u = self.unknowns
        slope = error.slope / std[:, None, None] @ u.spread[u.rows]
        return squeezed((error.residual / std[:, None]).ravel(), slope.reshape(-1, len(u)))

    def noise(self, x: RealArray, noise: Sequence[RealArray], *, fair: bool = False) -> list[RealArray]:
        """Return the noise of each channel at x: most likely, or ``fair``, without bias; weighted by ``noise``."""
        found = []
        for trial, error in zip(self.trials, self.errors(x, noise, slopes=False), strict=True):
            freedom = float(trial.count)
            if fair:
                freedom -= (error.linear + len(x) / len(self.trials)) / len(trial.channels)
            found.append(np.sqrt(trial.noise.variance(np.sum(error.residual**2, axis=1), max(freedom, 1.0))))
        return found

    def loss(self, noise: Sequence[RealArray]) -> float:
        """Return minus twice the log likelihood, less a constant, of most likely noise."""
        return sum(t.noise.loss(t.count * std**2, t.count) for t, std in zip(self.trials, noise, strict=True))


def squeezed(residual: RealArray, slope: RealArray) -> tuple[RealArray, RealArray]:
    """Return a residual and its derivatives as at most one row more than unknowns, by a QR decomposition."""
    whole = np.column_stack([slope, residual])
    if len(whole) > whole.shape[1]:
        whole = np.asarray(np.linalg.qr(whole, mode="r"))
    return whole[:, -1], whole[:, :-1]


def default_holds(trials: Sequence[Trial]) -> tuple[Hold, ...]:
    """Return how inputs move between samples, before the records have been asked."""
    return tuple(HOLDS[0] for _ in trials)
