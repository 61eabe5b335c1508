"""Motion of modes under forces other than friction: all steps of it at once.

The steps are equations for the states at their ends, solved by Newton's method: each step depends on the one before
alone, so that a solution is one forward substitution in a band.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suspid.identification.nonlinear.forces import ForceKind, size_of, slope_of
from suspid.units import ComplexArray, RealArray

# Newton steps at most, and the change over the largest state at which they end: the next would be rounding.
MOST_SWEEPS, SWEPT = 8, 1e-8


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BentSteps:
    """Steps of structures side by side: ``x' = x rotation + acting answer``, with states as real and imaginary parts.

    What acts over a step is the mean of the forces at its start and at its end, where the force at the start would
    bring it. Forces follow ``x seen``.
    """

    kind: ForceKind
    rotation: RealArray  # (structure, state, state)
    answer: RealArray  # (structure, force, state)
    seen: RealArray  # (structure, state, force)

    @classmethod
    def of(cls, kind: ForceKind, *, powers: ComplexArray, held: ComplexArray, place: ComplexArray) -> BentSteps:
        """Return the steps from factors of the states, (structure, pole), and what forces are and follow.

        The answer of the states to a force over a step is (structure, force, pole), and what a force follows is
        ``Re sum_k place_kj z_k``, (structure, pole, force).
        """
        poles = powers.shape[1]
        each, rotation = np.arange(poles), np.zeros((len(powers), 2 * poles, 2 * poles))
        rotation[:, each, each] = rotation[:, poles + each, poles + each] = powers.real
        rotation[:, each, poles + each], rotation[:, poles + each, each] = powers.imag, -powers.imag
        return cls(
            kind=kind,
            rotation=rotation,
            answer=np.ascontiguousarray(np.concatenate([held.real, held.imag], axis=2)),
            seen=np.concatenate([place.real, -place.imag], axis=1),
        )

    @property
    def first(self) -> BentSteps:
        """Those of the first structure."""
        return BentSteps(kind=self.kind, rotation=self.rotation[:1], answer=self.answer[:1], seen=self.seen[:1])

    def acting(self, states: RealArray) -> tuple[RealArray, RealArray, RealArray, RealArray]:
        """Return states after a step without forces, what acts over it, and what forces follow at start and end.

        States are (structure, step, state).
        """
        free, followed = states @ self.rotation, states @ self.seen
        force = size_of(self.kind, followed, followed)
        ahead = (free + force @ self.answer) @ self.seen
        return free, 0.5 * (force + size_of(self.kind, ahead, ahead)), followed, ahead

    def after(self, states: RealArray) -> RealArray:
        """Return the states after a step from each of the states, (structure, step, state)."""
        free, acting, _, _ = self.acting(states)
        return np.asarray(free + acting @ self.answer)

    def slopes(self, states: RealArray) -> tuple[RealArray, RealArray]:
        """Return the states of one structure after a step, and their derivatives by those before (step, state, state).

        States are (step, state).
        """
        free, acting, followed, ahead = (each[0] for each in self.acting(states[None]))
        rotation, answer, seen = self.rotation[0], self.answer[0], self.seen[0]
        by_start = seen * slope_of(self.kind, followed)[:, None]
        by_end = (rotation @ seen + by_start @ (answer @ seen)) * slope_of(self.kind, ahead)[:, None]
        return np.asarray(free + acting @ answer), np.asarray(rotation + 0.5 * (by_start + by_end) @ answer)

    def states(self, start: RealArray, count: int) -> RealArray | None:
        """Return the states at the ends of steps, (structure, step, state), and the start before them.

        Structures are near the first one, whose derivatives serve all. None where Newton's method leads nowhere, as
        with a motion that runs away.

        Parameters
        ----------
        start : ndarray of float, shape (state,)
        count : int
            Number of steps.
        """
        one = self.first
        # Without forces a state turns and decays.
        poles = len(start) // 2
        factor = self.rotation[0, :poles, :poles].diagonal() + 1j * self.rotation[0, :poles, poles:].diagonal()
        turned = (start[:poles] + 1j * start[poles:]) * factor ** np.arange(count + 1)[:, None]
        found = np.concatenate([turned.real, turned.imag], axis=1)
        for _ in range(MOST_SWEEPS):
            after, slopes = one.slopes(found[:-1])
            change = _substituted(slopes, (after - found[1:])[None])[0]
            found[1:] += change
            size = float(np.max(np.abs(change)))
            if not np.isfinite(size):
                return None
            if size < SWEPT * float(np.max(np.abs(found))):
                break
        else:
            return None
        left = self.after(np.broadcast_to(found[:-1], (len(self.rotation), count, len(start)))) - found[1:]
        out = np.broadcast_to(found, (len(left), *found.shape)).copy()
        out[:, 1:] += _substituted(slopes, left)
        return out if np.all(np.isfinite(out)) else None

    def one_by_one(self, start: RealArray, count: int) -> RealArray:
        """Return the same as `states` by one step after the other, which takes several times as long."""
        out = np.empty((count + 1, len(self.rotation), 1, len(start)))
        out[0] = start
        for step in range(count):
            out[step + 1] = self.after(out[step])
        return np.moveaxis(out[:, :, 0], 0, 1)


def _substituted(slopes: RealArray, left: RealArray) -> RealArray:
    """Return the changes y of states at the ends of steps, of which each follows from the last: y' = y slope + left.

    Slopes are (step, state, state), what is left is (structure, step, state).
    """
    from scipy.linalg.lapack import dtbtrs

    count, size = slopes.shape[:2]
    # Diagonals of a lower band of unit diagonal, column by column: (step, state, diagonal).
    band = np.zeros((count, size, 2 * size))
    row, column = np.arange(size)[None], np.arange(size)[:, None]
    band[:-1, column, size + row - column] = -slopes[1:]
    found, _ = dtbtrs(band.reshape(-1, 2 * size).T, left.reshape(len(left), -1).T, uplo="L", diag="U")
    return np.asarray(found.T.reshape(left.shape))
