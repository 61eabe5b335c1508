"""The swings of a mode: their sizes, and where they turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.nonlinear.driven import DrivenFit
from suspid.identification.nonlinear.turns import (
    extremes,
    first_swing,
    measured_turns,
    middles,
    prolonged,
    turns_between,
)
from suspid.levels import SURE
from suspid.units import ComplexArray, RealArray

# A turn that the record misses by at most 3 samples, and by less than this share of a swing, is one of its turns.
MISSED, MISSED_SHARE = 3.0, 0.1
# Forces show as in an acceleration if what they add lies within this share of what their gains say.
LIKE_AN_ACCELERATION = 0.5
# Share of a cycle before and after a sample over which a measured motion is seen to rise: noise turns shorter ways.
CYCLE_SHARE = 0.125
# A state that falls by this many e-foldings within the samples before the record is not continued there: 1e-100.
FASTEST_FALL = 230.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Swings:
    """The swings of one mode, from each turning point of its fitted motion to the next.

    From a swing to a later one, forces that follow the motion leave no ripple as they do between two samples.
    """

    time: RealArray  # (swing,): middle of each in samples, where its size holds
    size: RealArray  # (swing,): half of the way between its turning points, in the unit of the channel
    slopes: ComplexArray  # (parameter pair, swing): derivatives of the logarithm of the state there by those of `own`
    own: NDArray[np.intp]
    free: int  # number of parameters of the fit

    def pole(self, first: int = 0, last: int = -1) -> tuple[complex, RealArray]:
        """Return the exponent of the linear decay from one swing to another, and its derivatives, (2, parameter).

        The derivatives are those of its real and imaginary part.
        """
        turns = range(len(self.time))[last] - first
        span = self.time[last] - self.time[first]
        by_own = (self.slopes[:, last] - self.slopes[:, first]) / span
        out = np.zeros((2, self.free))
        out[:, 2 * self.own] = by_own.real, by_own.imag
        out[:, 2 * self.own + 1] = -by_own.imag, by_own.real
        return complex((np.log(self.size[last] / self.size[first]) + 1j * np.pi * turns) / span), out

    def mean(self) -> tuple[complex, RealArray]:
        """Return the pole of the mean natural frequency and damping ratio of all cycles, and its derivatives.

        A cycle is two swings. Its pole is that of `pole`: two means and not one, because the modulus of a mean
        exponent is less than the mean of the moduli, where the damping differs from cycle to cycle.
        """
        count = len(self.time)
        cycles = [self.pole(first, first + 2) for first in range(count - 2)] or [self.pole()]
        return mean_of(cycles, np.ones(len(cycles)))


def mean_of(
    poles: Sequence[tuple[complex, RealArray]], weights: RealArray | Sequence[float]
) -> tuple[complex, RealArray]:
    """Return the pole of the mean natural frequency and damping ratio of several, each with derivatives."""
    share = np.array(weights, float) / np.sum(weights)
    exponents, slopes = np.array([theta for theta, _ in poles]), np.array([by for _, by in poles])
    wn, zeta = float(share @ np.abs(exponents)), float(share @ (-exponents.real / np.abs(exponents)))
    by_wn, by_zeta = np.einsum("c,pci,cij->pj", share, by_pole(exponents), slopes)
    turned = np.sqrt(max(1 - zeta**2, 1e-12))
    change = (-zeta + 1j * turned) * by_wn - wn * (1 + 1j * zeta / turned) * by_zeta
    return wn * (-zeta + 1j * turned), np.array([change.real, change.imag])


def swings_of(fit: DrivenFit, pole: int, window: slice = slice(None)) -> Swings | None:
    """Return the swings of a mode in its strongest channel within a window; None if there are not two."""
    own, strongest = np.flatnonzero(fit.owners == pole), int(np.argmax(np.abs(fit.amplitudes[pole])))
    amplitude = fit.amplitudes[pole, strongest]
    state = fit.states[pole, window]
    # States begin with 1; below this their ratios are not known to rounding.
    gone = np.flatnonzero(np.abs(state) < 1e-100)
    state = state[: int(gone[0])] if gone.size else state
    if len(state) < 3:
        return None
    theta = complex(fit.drive.theta[pole])
    most = min(MISSED, MISSED_SHARE * np.pi / theta.imag)
    more = int(np.ceil(most))
    # What falls faster swings nowhere, and its powers backwards in time overflow.
    more = more if -theta.real * more < FASTEST_FALL else 0
    first = window.indices(fit.states.shape[1])[0]
    pushes = fit.drive.gains[pole] @ fit.drive.forces[:, first : first + len(state)]
    measured = (fit.values - fit.residual)[strongest, window][: len(state)]
    state = prolonged(state, theta, pushes[[0, -1]], more)
    rise = theta * state + np.pad(pushes, more, mode="edge")
    times = turns_between(np.real(amplitude * theta * state), np.real(amplitude * theta * rise), theta.imag) - more
    times = times[(times > -most) & (times < len(measured) - 1 + most)]
    changed = _changed_by_forces(fit, pole, strongest)
    if changed:
        times = measured_turns(measured, times, max(1, round(CYCLE_SHARE * 2 * np.pi / theta.imag)))
    if len(times) < 3:
        return None
    slopes = fit.slopes[own][:, window][:, : len(measured)]
    slopes = np.pad(slopes, ((0, 0), (more, more)), mode="edge")
    at = np.minimum((times + more).astype(int), len(state) - 2)
    logs = np.log(np.abs(state)) + 1j * np.unwrap(np.angle(state))
    rows = np.vstack([logs, slopes / state])
    rows = rows[:, at] + (times + more - at) * (rows[:, at + 1] - rows[:, at])
    positions = extremes(measured, times) if changed else np.real(amplitude * np.exp(rows[0]))
    size = 0.5 * np.abs(np.diff(positions))
    # What is lost in the noise was not met.
    lost = np.flatnonzero(size <= SURE * np.sqrt(fit.variance[strongest]))
    last = int(lost[0]) if lost.size else len(size)
    seen = slice(first_swing(size), last)
    if len(size[seen]) < 2:
        return None
    slopes = 0.5 * (rows[1:, :-1] + rows[1:, 1:])[:, seen]
    return Swings(time=middles(times)[seen], size=size[seen], slopes=slopes, own=own, free=fit.drive.free)


def _changed_by_forces(fit: DrivenFit, pole: int, channel: int) -> bool:
    """Return whether what forces add to a channel changes the size of the swings as they were measured.

    Forces show in accelerations at once, about as much as their gains say: the swings are those of the state then.
    Forces that show otherwise are of no acceleration. What counts is what they do together: two of them may be nearly
    alike and cancel each other.
    """
    drive = fit.drive
    if not (drive.through and len(drive.forces)):
        return False
    direct = fit.coefficients[-len(drive.forces) :, channel]
    told = np.real(fit.amplitudes[pole, channel] * drive.gains[pole] / drive.theta[pole])
    off, like = (direct - told) @ drive.forces, told @ drive.forces
    return bool(np.linalg.norm(off) >= LIKE_AN_ACCELERATION * np.linalg.norm(like))


def cuts_of(envelope: RealArray, *, least: int) -> list[int]:
    """Return points between which the envelope, a logarithm, falls by about equal parts, the first and last included.

    No two are nearer to each other than ``least``.
    """
    last = len(envelope) - 1
    fallen = np.maximum.accumulate(envelope[0] - envelope)
    # Parts of the decay over which a mode is described, at most; each is of one cycle at least.
    wanted = np.linspace(0.0, fallen[-1], min(12, max(1, last // least)) + 1)[1:-1]
    cuts = [0]
    for cut in np.searchsorted(fallen, wanted).tolist():
        if cut - cuts[-1] >= least and last - cut >= least:
            cuts.append(int(cut))
    return [*cuts, last]


def by_pole(theta: ComplexArray) -> RealArray:
    """Return the derivatives of natural frequency and damping ratio by Re and Im of a pole, (2, …, 2)."""
    size = np.abs(theta)
    of_wn = np.stack([theta.real, theta.imag], axis=-1) / size[..., None]
    of_zeta = np.stack([-(theta.imag**2), theta.real * theta.imag], axis=-1) / size[..., None] ** 3
    return np.array([of_wn, of_zeta])
