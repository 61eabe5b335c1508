"""Free decays of a recording, in order of rank."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from suspid.decays.refusals import DRIVEN
from suspid.results import Result, columns_of
from suspid.text_tables import TERMINAL, text_table
from suspid.units import Decibel, RealArray, Second
from suspid.values import MOST_NAMES
from suspid.wording import moment
from suspid.words import Check, DecayDoubt, DecayKind, DecayRemark, Level, Remark, Verdict

# Doubts that the motion is a free decay at all; the others say that it tells little.
GRAVE = frozenset(
    {
        DecayDoubt.FORCED,
        DecayDoubt.DRIVEN,
        DecayDoubt.NONLINEAR,
        DecayDoubt.GROWING,
        DecayDoubt.SWELLS,
        DecayDoubt.COMPANY,
        DecayDoubt.SMALL_PART,
        DecayDoubt.NOT_IDENTIFIED,
        DecayDoubt.MODES_MISSING,
        DecayDoubt.HIGH_RESIDUAL,
    }
)

# Doubts of a quick fit to a decay, and that it is long enough for its modes.
FIT = frozenset(
    {DecayDoubt.FORCED, DecayDoubt.DRIVEN, DecayDoubt.NONLINEAR, DecayDoubt.GROWING, DecayDoubt.HIGH_RESIDUAL}
)
LITTLE = frozenset({DecayDoubt.FEW_CYCLES, DecayDoubt.TOO_SHORT, DecayDoubt.FEW_SAMPLES})


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Decay(Result):
    """A stretch of free decay.

    Parameters
    ----------
    start, stop : float
        Its first and last time [s]; the excitation ends at the start.
    rank : int
        1 for the decay that determines its modes best.
    kind : DecayKind or None
        What started it: "impulse", "step", "release", "step or release"; None if the record does not show it.
    level : float
        Power above the background, at the peak of the strongest band [dB].
    cycles : float
        Cycles until the decay meets the noise or ends, of the mode that makes most among those with at least a
        hundredth of the energy [1].
    strength : float
        Energy of its modes over the variance of the noise, times the square of the cycles [dB].
    wn, zeta : ndarray (mode,)
        Natural frequencies [rad/s] and damping ratios [1] of a quick fit; those of `identify` are more accurate.
    doubts : tuple of Remark
        Doubts about it, each a `DecayDoubt` with its numbers; empty if there are none.

    Examples
    --------
    >>> from suspid import as_record, find_decays
    >>> t = np.arange(600) / 100
    >>> late = np.where(t < 2, 0.0, np.exp(2 - t) * np.sin(20 * (t - 2)))
    >>> best = find_decays(as_record(late + 1e-5 * np.random.default_rng(1).standard_normal(t.size), timepts=t))[0]
    >>> best.rank, round(best.start, 1), best.wn.round(1), best.zeta.round(3)
    (1, 2.0, array([20.]), array([0.05]))
    """

    start: Second
    stop: Second
    rank: int
    kind: DecayKind | None
    level: Decibel
    cycles: float
    strength: Decibel
    wn: RealArray
    zeta: RealArray
    doubts: tuple[Remark, ...]

    def _table(self) -> Mapping[str, Sequence[object]]:
        return _columns([self])

    def __str__(self) -> str:
        what = f"{self.cycles:.1f} cycles above the noise, peak {self.level:.0f} dB above the background"
        return "; ".join([f"{moment(self.start)} … {moment(self.stop)} s: {what}", *map(str, self.doubts)])


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Decays(Sequence[Decay], Result):
    """Free decays of a recording in order of rank, as a sequence, and remarks on the other events.

    Parameters
    ----------
    decays : tuple of Decay
        The decays, the best first.
    remarks : tuple of Remark
        Events that are not free decays, each with its reason, and events that were not examined.

    Examples
    --------
    >>> from suspid import as_record, find_decays
    >>> t = np.arange(600) / 100
    >>> late = np.where(t < 2, 0.0, np.exp(2 - t) * np.sin(20 * (t - 2)))
    >>> decays = find_decays(as_record(late + 1e-5 * np.random.default_rng(1).standard_normal(t.size), timepts=t))
    >>> len(decays), decays.verdict.level.label
    (1, 'sound')
    """

    decays: tuple[Decay, ...] = ()
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        return len(self.decays)

    def __iter__(self) -> Iterator[Decay]:
        return iter(self.decays)

    @overload
    def __getitem__(self, index: int) -> Decay: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Decay, ...]: ...

    def __getitem__(self, index: int | slice) -> Decay | tuple[Decay, ...]:
        return self.decays[index]

    @property
    def verdict(self) -> Verdict:
        """How far the best decay can be trusted: its doubts are the checks.

        Examples
        --------
        >>> from suspid import Decays
        >>> Decays().verdict.level.label
        'none'
        """
        if not self.decays:
            none = Remark(DecayRemark.NONE)
            return Verdict(none, tuple(Check(remark, Level.NONE) for remark in self.remarks or (none,)))
        checks = [Check(d, Level.DOUBTFUL if is_grave(d) else Level.CARE) for d in self.decays[0].doubts]
        return Verdict(Remark(DecayRemark.FOUND, {"decays": len(self.decays)}), tuple(checks))

    def _table(self) -> Mapping[str, Sequence[object]]:
        return _columns(self)

    def _brief(self) -> str:
        more = [f"and {len(self) - MOST_NAMES} more"] if len(self) > MOST_NAMES else []
        spans = ", ".join([f"{moment(one.start)} … {moment(one.stop)} s" for one in self[:MOST_NAMES]] + more)
        return f"{self.verdict.headline}{': ' if spans else ''}{spans}"

    def __str__(self) -> str:
        columns: dict[str, list[str]] = {
            "rank": [str(decay.rank) for decay in self],
            "start [s]": [f"{decay.start:.6g}" for decay in self],
            "stop [s]": [f"{decay.stop:.6g}" for decay in self],
            "after": [decay.kind or "?" for decay in self],
            "above background [dB]": [f"{decay.level:.0f}" for decay in self],
            "cycles": [f"{decay.cycles:.1f}" for decay in self],
            "f [Hz]": [", ".join(f"{wn / (2 * np.pi):.3g}" for wn in decay.wn) for decay in self],
            "doubts": [str(len(decay.doubts) or "none") for decay in self],
        }
        parts = [text_table(columns, widest=TERMINAL)] if self else [str(Remark(DecayRemark.NONE))]
        doubts = [f"decay {decay.rank}: {'; '.join(map(str, decay.doubts))}" for decay in self if decay.doubts]
        return "\n".join([*parts, *doubts, *map(str, self.remarks)])


def is_grave(doubt: Remark) -> bool:
    """Return whether a doubt is one that a stretch is free motion at all.

    A first part that deviates by no more of the motion than a free decay may leave is nonlinear, or the noise is small.
    """
    share = doubt.numbers.get("share")
    little = doubt.code is DecayDoubt.FORCED and isinstance(share, float) and share <= DRIVEN
    return doubt.code in GRAVE and not little


def by_chance(decay: Decay) -> bool:
    """Return whether a stretch looks like a decay by chance: most events are none, and it says little of its modes."""
    codes = {doubt.code for doubt in decay.doubts}
    return DecayDoubt.COMPANY in codes and bool(codes & (GRAVE - {DecayDoubt.COMPANY} | LITTLE))


def _columns(decays: Sequence[Decay]) -> dict[str, list[object]]:
    """Return the numbers of decays by column."""
    return {
        **columns_of(decays, ["rank"]),
        "start_s": [one.start for one in decays],
        "stop_s": [one.stop for one in decays],
        "cycles": [one.cycles for one in decays],
        "level_db": [one.level for one in decays],
        "strength_db": [one.strength for one in decays],
        "kind": [one.kind for one in decays],
        "doubts": ["; ".join(map(str, one.doubts)) for one in decays],
    }
