"""Frequencies of a body, one for each channel, with their intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from suspid.levels import LEVEL, check_level, normal_reach
from suspid.results import Result, columns_of
from suspid.text_tables import text_table
from suspid.units import Hertz, Ratio
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.drives import BodyCheck


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BodyMode:
    """The frequency of the body from one channel.

    Parameters
    ----------
    channel : str
        The channel.
    hertz : float
        Natural frequency [Hz]: the middle of the models that fit; NaN where there is no resonance, or it is not
        determined.
    models : tuple of (float, float)
        Frequency and standard deviation [Hz] of each model of road and damper that the records do not reject.
    zetas : tuple of float
        Damping ratio [1] of each: they differ, which is why none is reported.
    why : Remark or None
        Why there is no frequency.

    Examples
    --------
    >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
    >>> low, high = mode.interval(0.95)
    >>> round(low, 2), round(high, 2)
    (1.11, 1.29)
    """

    channel: str
    hertz: Hertz
    models: tuple[tuple[Hertz, Hertz], ...] = ()
    zetas: tuple[Ratio, ...] = ()
    why: Remark | None = None

    def interval(self, level: Ratio = LEVEL) -> tuple[Hertz, Hertz]:
        """Return the bounds [Hz] that contain the intervals of all models.

        Examples
        --------
        >>> from suspid import BodyMode
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.2, 0.1),))
        >>> round((mode.interval(0.95)[1] - 1.2) / 0.1, 2)
        1.96
        """
        check_level(level)
        if not self.models:
            return float("nan"), float("nan")
        reach = normal_reach(level)
        return min(f - reach * s for f, s in self.models), max(f + reach * s for f, s in self.models)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class BodyModes(Sequence[BodyMode], Result):
    """Frequencies of the body, one for each channel, as a sequence.

    Parameters
    ----------
    modes : tuple of BodyMode
        One for each channel.
    seconds : float
        Length of the stretches that were used [s].

    Examples
    --------
    >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
    >>> print(BodyModes(modes=(mode,), seconds=300.0))
      channel    f [Hz]    95 % interval      zeta [1]
    ---------  --------  ---------------  ------------
         seat       1.2      1.11 … 1.29  not reported
    Verdict: the body's frequency in 1 of the channels, from 300 s: sound. Every check that could be made was passed.
    note: Damping is not reported: depending on the model of the road it would be 0.2 or 0.4. ...
    """

    modes: tuple[BodyMode, ...]
    seconds: float

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[BodyMode]:
        return iter(self.modes)

    @overload
    def __getitem__(self, index: int) -> BodyMode: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[BodyMode, ...]: ...

    def __getitem__(self, index: int | slice) -> BodyMode | tuple[BodyMode, ...]:
        return self.modes[index]

    @property
    def verdict(self) -> Verdict:
        """What was found, and why damping is not reported.

        Examples
        --------
        >>> from suspid import BodyMode, BodyModes
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
        >>> BodyModes(modes=(mode,), seconds=300.0).verdict.level.label
        'sound'
        """
        found = [mode for mode in self.modes if mode.models]
        checks = [Check(mode.why, Level.NOTE if found else Level.NONE) for mode in self.modes if mode.why is not None]
        if found:
            zetas = [zeta for mode in found for zeta in mode.zetas]
            refused = Remark(BodyCheck.NO_DAMPING, {"low": min(zetas), "high": max(zetas)})
            checks += [Check(refused, Level.NOTE), Check(Remark(BodyCheck.ONE_EACH), Level.NOTE)]
        return Verdict(Remark(BodyCheck.FOUND, {"channels": len(found), "seconds": self.seconds}), tuple(checks))

    def table(self, level: Ratio = LEVEL) -> str:
        """Return the table of frequencies with intervals.

        Examples
        --------
        >>> from suspid import BodyMode, BodyModes
        >>> mode = BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4), why=None)
        >>> print(BodyModes(modes=(mode,), seconds=300.0).table(0.68))
          channel    f [Hz]    68 % interval      zeta [1]
        ---------  --------  ---------------  ------------
             seat       1.2      1.13 … 1.27  not reported
        """
        ends = [mode.interval(level) for mode in self.modes]
        return text_table(
            {
                "channel": [mode.channel for mode in self.modes],
                "f [Hz]": [f"{mode.hertz:.3g}" if mode.models else "none" for mode in self.modes],
                f"{100 * level:g} % interval": [f"{a:.3g} … {b:.3g}" if np.isfinite(a) else "" for a, b in ends],
                "zeta [1]": ["not reported" for _ in self.modes],
            }
        )

    def _table(self) -> Mapping[str, Sequence[object]]:
        low, high = zip(*(mode.interval() for mode in self.modes), strict=True) if self.modes else ((), ())
        return {**columns_of(self.modes, ["channel", "hertz"]), "low_hz": low, "high_hz": high}

    def _brief(self) -> str:
        return ", ".join(f"{mode.channel} {mode.hertz:.3g} Hz" for mode in self.modes if mode.models) or "no frequency"

    def __str__(self) -> str:
        return f"{self.table()}\n{self.verdict}"
