"""Poles that were considered and are no modes, and why."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from suspid.identification.classification import fading
from suspid.identification.fitting import OTHER_FREQUENCY
from suspid.identification.harmonics import HIGHEST, combination_of, multiple_of
from suspid.identification.nonlinear import at_multiple
from suspid.identification.selection import Selection
from suspid.model import ModalSet
from suspid.units import Second
from suspid.words import Number, Reason, Remark


@dataclass(frozen=True, kw_only=True, slots=True)
class Considered:
    """A pole that was considered and is not among the modes.

    Parameters
    ----------
    pole : complex
        The pole [rad/s].
    remark : Remark
        Why it is not a mode: a `Reason` with its numbers.
    removed : bool
        Whether its motion was removed from the record with the fit (a tone, a drift), or left in the residual.

    Examples
    --------
    >>> from suspid import as_record, identify
    >>> t = np.arange(400) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> tone = 0.05 * np.sin(60 * t)
    >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + tone + noise, timepts=t))
    >>> [(round(abs(one.pole)), one.reason, one.removed) for one in found.considered]
    [(60, 'steady tone: no decay is seen within the record', True)]
    """

    pole: complex
    remark: Remark
    removed: bool

    @property
    def reason(self) -> str:
        """Why it is not a mode, in words.

        Examples
        --------
        >>> from suspid import Considered, Remark
        >>> from suspid.words import Reason
        >>> Considered(pole=60j, remark=Remark(Reason.HARMONIC, {"mode": 1, "multiple": 3}), removed=True).reason
        '3 times mode 1: a harmonic of its nonlinear motion'
        """
        return str(self.remark)


def removed_as(considered: Iterable[Considered], *reasons: Reason) -> list[Considered]:
    """Return what was removed from a record with the fit for one of some reasons.

    Examples
    --------
    >>> tone = Considered(pole=60j, remark=Remark(Reason.TONE), removed=True)
    >>> removed_as([tone], Reason.TONE, Reason.DRIFT) == [tone], removed_as([tone], Reason.HARMONIC)
    (True, [])
    """
    return [one for one in considered if one.removed and one.remark.code in reasons]


def considered_of(selection: Selection, modes: ModalSet, step: Second) -> tuple[Considered, ...]:
    """Return what was fitted but is no mode, then what was tried and not kept."""
    removed = []
    tones = Reason.TONE in selection.reasons
    lost = fading(selection.fit, selection.loudness) if tones else np.zeros(0)
    larger = _larger_than_modes(selection) if tones else np.zeros(0, bool)
    for k, (theta, reason) in enumerate(zip(selection.fit.poles.every.tolist(), selection.reasons, strict=True)):
        if reason is not None:
            faded = {"share": float(lost[k]), "largest": bool(larger[k])} if reason is Reason.TONE and lost[k] else {}
            remark = _remark(reason, complex(theta) / step, modes, faded)
            removed.append(Considered(pole=complex(theta) / step, remark=remark, removed=True))
    left = tuple(
        Considered(pole=candidate.theta / step, remark=remark, removed=False)
        for candidate, remark in sorted(selection.rejected, key=lambda item: -item[0].gain)
    )
    return (*removed, *left)


def _remark(reason: Reason, pole: complex, modes: ModalSet, faded: Mapping[str, Number]) -> Remark:
    """Return why a pole that was fitted is no mode, with the modes it belongs to."""
    if reason in (Reason.HARMONIC, Reason.COMBINATION) and not len(modes):
        return Remark(Reason.OF_NO_MODE)
    if reason is Reason.HARMONIC:
        mode, multiple = multiple_of(modes, pole)
        return Remark(reason, {"mode": mode, "multiple": multiple})
    if reason is Reason.COMBINATION:
        one, other, word = combination_of(modes, pole)
        return Remark(reason, {"mode": one, "other": other, "word": word})
    return Remark(reason, faded)


def _larger_than_modes(selection: Selection) -> NDArray[np.bool_]:
    """Return which free poles carry more energy, over the noise of all channels, than all modes together, (pole,)."""
    fit = selection.fit
    falls = np.maximum(-2 * fit.poles.every.real * fit.count, 1e-9)
    sizes = np.abs(fit.amplitudes[fit.poles.rows]) ** 2 / np.maximum(fit.squares / fit.freedom, 1e-300)
    energies = np.sum(sizes, axis=1) * -np.expm1(-falls) / falls
    return np.asarray(energies > np.sum(energies[selection.modes]))


def beside_bent(selection: Selection, modes: ModalSet, step: Second) -> tuple[Considered, ...]:
    """Return what the linear fit took for further poles: parts and harmonics of the modes, and other distortion."""
    out = []
    for theta in selection.fit.poles.pairs:
        ratio = abs(theta) / step / modes.wn
        nearest = int(np.argmin(np.abs(np.log(ratio))))
        mode, multiple = multiple_of(modes, complex(theta) / step)
        times = abs(theta.imag) / step / max(modes.poles[mode - 1].imag, 1e-300)
        if abs(np.log(ratio[nearest])) < np.log(OTHER_FREQUENCY):
            remark = Remark(Reason.SAME_MODE, {"mode": nearest + 1})
        elif 1 < multiple <= HIGHEST and at_multiple(np.array([times]))[0]:
            remark = Remark(Reason.HARMONIC, {"mode": mode, "multiple": multiple})
        else:
            remark = Remark(Reason.DISTORTION)
        if remark.code is not Reason.SAME_MODE or abs(np.log(ratio[nearest])) > 1e-3:
            out.append(Considered(pole=complex(theta) / step, remark=remark, removed=False))
    return tuple(out)
