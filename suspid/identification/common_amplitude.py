"""Two results whose modes depend on their amplitude, each taken at an amplitude that both met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.identification.nonlinear import AmplitudeDependence
from suspid.model import ModalSet, common_mac, jacobian_of, paired
from suspid.units import RealArray
from suspid.words import AmplitudeRemark, Remark

# Poles of two decays further apart than this share of the larger are not those of one mode: friction and springs that
# bend move them by less.
ONE_MODE = 0.25
# Standard deviations of what a table says at one amplitude are taken this many times as large: each fit has forces of
# its own choice, and what those miss there is not in them.
ROOM = 2.0
# Shares: of the step from window to window, how far a frequency between them is off; of the difference between a power
# and a straight line, how far the damping is. And the change of frequency in an e-folding of amplitude that one window
# alone may hide, over the frequency.
STEP_SHARE, OFF_SHARE, STEEPEST_WN = 0.1, 0.25, 0.1


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Described:
    """Modes, and how each depends on its amplitude; None where it does not, or where that is not known.

    Examples
    --------
    >>> Described(modes=ModalSet.from_wn_zeta([10.0], [0.6]), tables=(None,)).tables
    (None,)
    """

    modes: ModalSet
    tables: Sequence[AmplitudeDependence | None]

    def moved(self, poles: dict[int, tuple[complex, RealArray]]) -> ModalSet:
        """Return the modes with other poles and covariances of those; what those have to do with others is unknown."""
        if not poles:
            return self.modes
        values, covariance = self.modes.poles.copy(), self.modes.covariance
        assert covariance is not None
        covariance = covariance.copy()
        for k, (pole, own) in poles.items():
            at = slice(2 * k, 2 * k + 2)
            covariance[at], covariance[:, at] = 0.0, 0.0
            values[k], covariance[at, at] = pole, own
        return replace(self.modes, poles=values, covariance=covariance)


def overlap(tables: Sequence[AmplitudeDependence | None]) -> float | None:
    """Return the middle of the amplitudes that all decays met, in the unit of one channel; None if there are none."""
    known = [table.known for table in tables if table is not None]
    if len(known) < len(tables) or len({table.channel for table in known}) > 1:
        return None
    low = max(float(np.min(table.amplitude)) for table in known)
    high = min(float(np.max(table.amplitude)) for table in known)
    return float(np.sqrt(low * high)) if low <= high else None


def pole_at(table: AmplitudeDependence, amplitude: float) -> tuple[complex, RealArray]:
    """Return the pole at an amplitude, with the covariance of its real and imaginary part.

    Between windows the damping follows a power of the amplitude, as friction and drag make it. In the covariance is how
    far straight lines are from that, and that a window says the mean over its amplitudes: with damping that falls as
    1 over the amplitude, and a window from which a mode falls by w e-foldings, it is w^2 / 24 above that of its middle.
    """
    amplitudes, rows = np.unique(table.amplitude, return_index=True)
    (wn, zeta), stds = table.at(amplitude), np.array(table.stds_at(amplitude))
    nearest = rows[np.argmin(np.abs(np.log(amplitudes / amplitude)))]
    fall = float(table.wn[nearest] * abs(table.zeta[nearest])) * (table.spans[nearest][1] - table.spans[nearest][0])
    within = np.array([STEEPEST_WN * wn, zeta]) * fall**2 / 24
    if len(amplitudes) > 1:
        straight, place = zeta, np.log(amplitude)
        if np.all(table.zeta > 0):
            zeta = float(np.exp(_smooth(np.log(amplitudes), np.log(table.zeta[rows]), place)))
        wn = _smooth(np.log(amplitudes), table.wn[rows], place)
        after = int(np.clip(np.searchsorted(amplitudes, amplitude), 1, len(amplitudes) - 1))
        pair, far = rows[after - 1 : after + 1], np.log(amplitudes[after] / amplitudes[after - 1])
        steep = float(np.log(np.max(np.abs(table.zeta[pair])) / np.min(np.abs(table.zeta[pair])))) / far
        within = np.array([STEP_SHARE * abs(np.diff(table.wn[pair])[0]), within[1] * steep**2])
        stds = np.hypot(stds, [0.0, OFF_SHARE * (zeta - straight)])
    stds = np.hypot(stds, within)
    pole = complex(-zeta * wn, wn * np.sqrt(max(1 - zeta**2, 0.0)))
    to_pole = np.linalg.pinv(jacobian_of(pole))
    return pole, ROOM**2 * to_pole @ np.diag(stds**2) @ to_pole.T


def _smooth(places: RealArray, values: RealArray, place: float) -> float:
    """Return a value between given ones, which no curve through them leaves."""
    if len(places) < 3:
        return float(np.interp(place, places, values))
    from scipy.interpolate import PchipInterpolator

    return float(PchipInterpolator(places, values)(np.clip(place, places[0], places[-1])))


def at_common_amplitudes(found: Described, expected: Described) -> tuple[ModalSet, ModalSet, tuple[Remark, ...]]:
    """Return two sets of modes, those that depend on their amplitude at one that both met, and what was done.

    Where they met none in common, a mode stays as it is, and it is said that a difference may be that of amplitudes.
    """
    if found.modes.covariance is None or expected.modes.covariance is None:
        return found.modes, expected.modes, ()
    pairs = paired(found.modes, expected.modes, mac=common_mac(found.modes, expected.modes), gate=ONE_MODE)
    sides: tuple[dict[int, tuple[complex, RealArray]], dict[int, tuple[complex, RealArray]]] = ({}, {})
    remarks = []
    for j, i in sorted(pairs.items()):
        both = [side.tables[k] for side, k in ((found, i), (expected, j))]
        if not any(table is not None and table.varies for table in both):
            continue
        middle = overlap(both)
        if middle is None:
            remarks.append(Remark(AmplitudeRemark.NONE_IN_COMMON, {"mode": j + 1}))
            continue
        for side, k, table in zip(sides, (i, j), both, strict=True):
            assert table is not None
            side[k] = pole_at(table, middle)
        channel = both[0].channel if both[0] is not None else ""
        remarks.append(Remark(AmplitudeRemark.COMPARED_AT, {"mode": j + 1, "amplitude": middle, "channel": channel}))
    return found.moved(sides[0]), expected.moved(sides[1]), tuple(remarks)
