"""Natural frequency and damping ratio of a mode over the amplitudes that were met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.covariance import with_changes
from suspid.levels import NORMAL_95
from suspid.model import ModalSet
from suspid.units import RadianPerSecond, Ratio, RealArray, Second
from suspid.values import frozen_real

# Share of the largest damping by which it is larger at one amplitude than at others. A smaller one takes the ripple of
# bilinear springs for a beat.
RIPPLE = 0.2


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AmplitudeDependence:
    """Natural frequency and damping ratio of a mode over the amplitudes that were met.

    Each is that of the linear system whose motion decays and turns as much, within whole cycles of the mode: damping
    from the logarithmic decrement, frequency from the time that the cycles take.

    Parameters
    ----------
    spans : tuple of (float, float)
        Start and end of each window [s]; of a single mode, the middles of its first and last swing.
    channel : str
        The channel in whose unit the amplitude is: that of the largest motion.
    amplitude : ndarray (window,)
        Amplitude of the mode: geometric mean of those at both ends of the window, in the unit of the channel.
    wn : ndarray (window,)
        Natural frequency [rad/s].
    zeta : ndarray (window,)
        Damping ratio [1].
    wn_std, zeta_std : ndarray (window,)
        Their standard deviations.
    holds_at : float
        The amplitude at which the pole is nearest to the mean over all cycles, which the table of modes has.
    """

    spans: tuple[tuple[Second, Second], ...]
    channel: str
    amplitude: RealArray
    wn: RealArray
    zeta: RealArray
    wn_std: RealArray
    zeta_std: RealArray
    holds_at: float

    @property
    def ends(self) -> tuple[tuple[RadianPerSecond, Ratio], tuple[RadianPerSecond, Ratio]]:
        """Natural frequency and damping ratio at the largest and at the smallest amplitude."""
        first, last = int(np.argmax(self.amplitude)), int(np.argmin(self.amplitude))
        return (float(self.wn[first]), float(self.zeta[first])), (float(self.wn[last]), float(self.zeta[last]))

    def at(self, amplitude: float) -> tuple[RadianPerSecond, Ratio]:
        """Return natural frequency and damping ratio at an amplitude, between the windows beside it."""
        return self._between(amplitude, self.wn, self.zeta)

    def stds_at(self, amplitude: float) -> tuple[RadianPerSecond, Ratio]:
        """Return the standard deviations of both there."""
        return self._between(amplitude, self.wn_std, self.zeta_std)

    def _between(self, amplitude: float, one: RealArray, other: RealArray) -> tuple[float, float]:
        order = np.argsort(self.amplitude)
        logs = np.log(self.amplitude[order])
        first, second = (np.interp(np.log(amplitude), logs, values[order]) for values in (one, other))
        return float(first), float(second)

    @property
    def known(self) -> AmplitudeDependence:
        """The windows in which the damping ratio is known to its own value; all where those are fewer than two.

        Of the last swings in the noise nothing is told by its ends, and where a mode grows, another one feeds it.
        """
        rows = np.flatnonzero(NORMAL_95 * self.zeta_std < self.zeta)
        if len(rows) < 2:
            return self
        return replace(
            self,
            spans=tuple(self.spans[k] for k in rows),
            amplitude=frozen_real(self.amplitude[rows]),
            wn=frozen_real(self.wn[rows]),
            zeta=frozen_real(self.zeta[rows]),
            wn_std=frozen_real(self.wn_std[rows]),
            zeta_std=frozen_real(self.zeta_std[rows]),
        )

    @property
    def varies(self) -> bool:
        """Whether frequency or damping differs between two amplitudes by more than both 95 % intervals.

        Friction and springs that harden change both; a damper that differs in compression and rebound changes neither.
        """
        pairs = (self.wn, self.wn_std), (self.zeta, self.zeta_std)
        return any(
            bool(np.any(np.abs(values[:, None] - values) > NORMAL_95 * np.maximum(stds[:, None], stds)))
            for values, stds in pairs
        )

    @property
    def beats(self) -> bool:
        """Whether the damping is largest between larger and smaller amplitudes, or negative, by twice the intervals.

        Friction damps small motions more, drag large ones, and together those between least. Where parts end within a
        cycle of a bilinear spring, the damping ripples by some percent; by less than `RIPPLE` it is not larger.
        """
        apart = 2 * NORMAL_95 * np.maximum(self.zeta_std[:, None], self.zeta_std)
        apart = np.maximum(apart, RIPPLE * np.max(np.abs(self.zeta)))
        above = self.zeta[:, None] - self.zeta > apart
        largest = np.any(np.tril(above), axis=1) & np.any(np.triu(above), axis=1)
        return bool(np.any(largest) or np.any(self.zeta < -2 * NORMAL_95 * self.zeta_std))


def with_tables(modes: ModalSet, tables: Sequence[AmplitudeDependence]) -> ModalSet:
    """Return modes whose covariance contains how far each is from its table at the amplitude at which it holds."""
    wn, zeta = np.array([table.at(table.holds_at) for table in tables]).T
    poles = wn * (-zeta + 1j * np.sqrt(np.maximum(1 - zeta**2, 0.0)))
    return with_changes(modes, [poles - modes.poles])
