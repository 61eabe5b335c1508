"""Two results whose modes depend on their amplitude, each taken at an amplitude that both met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from suspid.identification.nonlinear import AmplitudeDependence
from suspid.model import ModalSet, common_mac, jacobian_of, paired
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import AmplitudeRemark, Remark

# Poles of two decays further apart than this share of the larger are not those of one mode: friction and springs that
# bend move them by less.
ONE_MODE = 0.25
# Shares: of the change of frequency within a window, how far it is off; of what powers differ from straight lines, of
# what a mean over a window differs from its middle, and of the change beyond the windows, how far the damping is. And
# the change of frequency in an e-folding of amplitude that one window alone may hide, over the frequency.
STEP_SHARE, OFF_SHARE, BEYOND_SHARE, STEEPEST_WN = 0.15, 0.2, 0.5, 0.1
# E-foldings between the amplitudes of two decays up to which both are compared in the middle of the gap.
WIDEST_GAP = 1.0
# Windows of amplitudes that differ by less e-foldings are one: a slope between them is noise. Damping is no steeper a
# power of the amplitude than the second number.
MERGED, MOST_POWER = 0.1, 2.0


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
    """Return the middle of the amplitudes that all decays met, in the unit of one channel, or of a gap between them.

    None if the gap is wider than an e-folding.
    """
    known = [table.known for table in tables if table is not None]
    if len(known) < len(tables) or len({table.channel for table in known}) > 1:
        return None
    ends = np.array([_ends(table) for table in known])
    low, high = float(np.max(ends[:, 0])), float(np.min(ends[:, 1]))
    return float(np.sqrt(low * high)) if np.log(low / high) <= WIDEST_GAP else None


def _ends(table: AmplitudeDependence) -> tuple[float, float]:
    """Return the smallest and the largest amplitude within the windows of a table; each has that of its middle."""
    reach = np.exp(0.5 * _falls(table))
    return float(np.min(table.amplitude / reach)), float(np.max(table.amplitude * reach))


def _falls(table: AmplitudeDependence) -> RealArray:
    """Return by how many e-foldings a mode falls within each window."""
    lasts = np.array([stop - start for start, stop in table.spans])
    return np.asarray(table.wn * np.abs(table.zeta) * lasts)


def pole_at(table: AmplitudeDependence, amplitude: float) -> tuple[complex, RealArray]:
    """Return the pole at an amplitude, with the covariance of its real and imaginary part.

    Between windows, and to the ends of the first and the last, the damping follows a power s of the amplitude, as
    friction and drag make it. A window in which the mode falls by w e-foldings says the mean over its time, which is
    that of its middle over ``1 + s^2 w^2 / 24``; it is brought there. A share of that, of what the curve differs from
    straight lines, and of what it changes beyond the windows, is in the covariance; where there is one window, all that
    friction would change. What is unknown of the damping is so of the frequency: forces turn a motion as they damp it.
    """
    table = _merged(table)
    logs, place = np.log(table.amplitude), float(np.log(amplitude))
    (wn, zeta), stds = table.at(amplitude), table.stds_at(amplitude)
    falls = _falls(table)
    fall = float(falls[np.argmin(np.abs(logs - place))])
    slopes, guessed, bent = np.array([STEEPEST_WN * wn, abs(zeta)]), 1.0, 0.0
    of_window = 1 / 24
    if len(logs) > 1:
        after = int(np.clip(np.searchsorted(logs, place), 1, len(logs) - 1))
        pair = slice(after - 1, after + 1)
        slopes = np.abs([np.diff(table.wn[pair])[0], np.diff(table.zeta[pair])[0]]) / (logs[after] - logs[after - 1])
        straight, curve = zeta, _power if np.all(table.zeta > 0) else _smooth
        wn, zeta = _smooth(logs, table.wn, place), curve(logs, table.zeta, place)
        guessed, bent, of_window = BEYOND_SHARE, OFF_SHARE * (zeta - straight), OFF_SHARE / 24
    power = float(min(slopes[1] / max(abs(zeta), 1e-300), MOST_POWER))
    mean = power**2 * fall**2
    beyond = max(logs[0] - place, place - logs[-1], 0.0)
    off_wn = slopes[0] * (STEP_SHARE * fall + guessed * beyond)
    off_zeta = float(np.linalg.norm([stds[1], bent, of_window * mean * zeta, guessed * beyond * slopes[1]]))
    zeta *= 1 + mean / 24 if len(logs) > 1 else 1.0
    pole = complex(-zeta * wn, wn * np.sqrt(max(1 - zeta**2, 0.0)))
    wn_std = float(np.linalg.norm([stds[0], off_wn, wn * off_zeta]))
    to_pole = np.linalg.pinv(jacobian_of(pole)) * np.array([wn_std, off_zeta])
    return pole, to_pole @ to_pole.T


def _merged(table: AmplitudeDependence) -> AmplitudeDependence:
    """Return a table by rising amplitude in which windows of nearly one amplitude, as of several decays, are one."""
    order = np.argsort(table.amplitude, kind="stable")
    logs = np.log(table.amplitude[order])
    begins = [0]
    for k in range(1, len(logs)):
        if logs[k] - logs[begins[-1]] > MERGED:
            begins.append(k)
    parts = [order[a:b] for a, b in pairwise([*begins, len(order)])]

    def means(values: RealArray) -> RealArray:
        return frozen_real([float(np.mean(values[part])) for part in parts])

    def lasts(part: NDArray[np.intp]) -> tuple[float, float]:
        return 0.0, float(np.mean([table.spans[k][1] - table.spans[k][0] for k in part]))

    return replace(
        table,
        spans=tuple(lasts(part) for part in parts),
        amplitude=frozen_real([float(np.exp(np.mean(np.log(table.amplitude[part])))) for part in parts]),
        wn=means(table.wn),
        zeta=means(table.zeta),
        wn_std=means(table.wn_std),
        zeta_std=means(table.zeta_std),
    )


def _smooth(places: RealArray, values: RealArray, place: float) -> float:
    """Return a value between given ones, which no curve through them leaves; beyond the ends straight lines go on."""
    if places[0] <= place <= places[-1] and len(places) > 2:
        from scipy.interpolate import PchipInterpolator

        return float(PchipInterpolator(places, values)(place))
    first = 0 if place < places[1] else len(places) - 2
    slope = (values[first + 1] - values[first]) / (places[first + 1] - places[first])
    return float(values[first] + slope * (place - places[first]))


def _power(places: RealArray, values: RealArray, place: float) -> float:
    """Return the same between logarithms."""
    return float(np.exp(_smooth(places, np.log(values), place)))


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
