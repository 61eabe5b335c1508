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

    By how much a smooth curve and straight lines between the windows differ there is in it.
    """
    (wn, zeta), stds = table.at(amplitude), np.array(table.stds_at(amplitude))
    amplitudes, rows = np.unique(table.amplitude, return_index=True)
    if len(amplitudes) > 2:
        from scipy.interpolate import PchipInterpolator

        smooth = PchipInterpolator(np.log(amplitudes), np.stack([table.wn, table.zeta])[:, rows], axis=1)
        straight = np.array([wn, zeta])
        wn, zeta = smooth(np.log(amplitude)).tolist()
        stds = np.hypot(stds, np.array([wn, zeta]) - straight)
    pole = complex(-zeta * wn, wn * np.sqrt(max(1 - zeta**2, 0.0)))
    to_pole = np.linalg.pinv(jacobian_of(pole))
    return pole, ROOM**2 * to_pole @ np.diag(stds**2) @ to_pole.T


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
