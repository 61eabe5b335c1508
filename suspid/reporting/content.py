"""The content of a report: one value for the page and for the JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from suspid.analysis import Analysis, CheckedLimits
from suspid.cleaning import Cleaned
from suspid.greybox import Estimate
from suspid.performance import Grip, Ride, Sensitivities, grip_if_any
from suspid.reporting.limit_rows import limit_steps
from suspid.reporting.sensitivity_part import sensitivities_of
from suspid.reporting.source import Source
from suspid.samples import held
from suspid.signals import as_signal
from suspid.units import Ratio
from suspid.words import Note, Remark, next_steps

if TYPE_CHECKING:
    import control

    from suspid.decays import Decay
    from suspid.identification import Identification
    from suspid.reconstruction import Reconstruction


@dataclass(frozen=True, kw_only=True)
class Content:
    """An analysis and where it comes from.

    Parameters
    ----------
    analysis : Analysis
        What was found. Its identification has a wavelet transform that is quickly drawn; see `drawable`.
    sources : tuple of Source
        The files and the command; empty if they are not known.
    cleaned : Cleaned or None
        The whole recording; None if it is not known, and the analysis has the record alone.
    warnings : sequence of str
        Warnings during the analysis.
    ride : Ride or None
        The car that was found on a road.
    car : Source or None
        The car file with its text.
    limits : CheckedLimits or None
        The limits that were given, judged.
    """

    analysis: Analysis
    sources: tuple[Source, ...]
    cleaned: Cleaned | None
    warnings: Sequence[str]
    ride: Ride | None = None

    @property
    def grip(self) -> Grip | None:
        """Grip of the car that was found, if there is one and it has wheels."""
        return None if self.springs is None else grip_if_any(self.springs)

    @cached_property
    def sensitivities(self) -> Sensitivities | None:
        """Which spring and damper of the car that was found moves which mode and figure."""
        return sensitivities_of(self.springs, self.ride)

    car: Source | None = None
    limits: CheckedLimits | None = None

    @property
    def source(self) -> Source | None:
        """The file, or the first of several."""
        return self.sources[0] if self.sources else None

    @property
    def springs(self) -> Estimate | Reconstruction | None:
        """Springs and dampers: those fitted to the record itself, if there are any."""
        return self.analysis.estimate or self.analysis.reconstruction

    @property
    def steps(self) -> tuple[Remark, ...]:
        """What to do next."""
        given = self.springs is not None or self._no_springs
        meant = [] if self.grip is None else [self.grip.verdict]
        return (*limit_steps(self.limits), *next_steps(self.analysis.verdict, car=given, further=meant))

    @property
    def _no_springs(self) -> bool:
        return any(note.code is Note.NO_SPRINGS for note in self.analysis.notes)

    @property
    def identification(self) -> Identification:
        """Modes of the record."""
        return self.analysis.identification

    @property
    def level(self) -> Ratio:
        """Probability of all intervals [1]."""
        return self.analysis.settings.level

    @property
    def used(self) -> int | None:
        """Which of the decays the record is."""
        return used_decay(held(self.identification, "response"), self.analysis.decays)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each channel of the record; empty where it is not known."""
        return self.analysis.units

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was said of stretches that are no decay, if the decays come with remarks."""
        return tuple(str(remark) for remark in getattr(self.analysis.decays, "remarks", ()))


def used_decay(response: control.TimeResponseData, decays: Sequence[Decay]) -> int | None:
    """Return which of the decays the record is, or None if it is none of them."""
    signal = as_signal(response)
    # A record begins with a decay if their starts differ by no more than 1.5 steps.
    near = [i for i, decay in enumerate(decays) if abs(decay.start - signal.start) <= 1.5 * signal.step]
    return min(near, key=lambda i: abs(decays[i].stop - signal.start - signal.duration), default=None)
