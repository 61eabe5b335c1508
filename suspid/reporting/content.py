"""What a report is made from: one value for the page and for the JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from suspid.analysis import Judgement, judge
from suspid.reporting.source import Source
from suspid.reporting.thinning import drawable
from suspid.signals import as_signal
from suspid.units import Ratio

if TYPE_CHECKING:
    import control

    from suspid.cleaning import Cleaned
    from suspid.decays import Decay
    from suspid.identification import Identification, Repeats
    from suspid.reconstruction import Reconstruction

# A record begins with a decay if their starts differ by no more than this [sampling steps].
SAME_START = 1.5


@dataclass(frozen=True, kw_only=True, slots=True)
class Content:
    """Everything that a report shows; see `report` for the fields.

    The identification has a wavelet transform that is quickly drawn; see `drawable`.
    """

    identification: Identification
    source: Source | None
    cleaned: Cleaned | None
    decays: Sequence[Decay]
    repeats: Repeats | None
    reconstruction: Reconstruction | None
    level: Ratio
    warnings: Sequence[str]

    @property
    def used(self) -> int | None:
        """Which of the decays the record is."""
        return used_decay(self.identification.response, self.decays)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each channel of the record; empty where it is not known."""
        names = as_signal(self.identification.response).channels
        if self.cleaned is None:
            return ("",) * len(names)
        known = dict(zip(as_signal(self.cleaned.record).channels, self.cleaned.units, strict=True))
        return tuple(known.get(name, "") for name in names)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was said of stretches that are no decay, if the decays come with remarks."""
        return tuple(str(remark) for remark in getattr(self.decays, "remarks", ()))

    @property
    def judgement(self) -> Judgement:
        """The verdict on all of it."""
        return judgement_of(
            self.identification,
            cleaned=self.cleaned,
            decays=self.decays,
            repeats=self.repeats,
            reconstruction=self.reconstruction,
            level=self.level,
        )


def content_of(
    identification: Identification,
    *,
    source: Source | None,
    cleaned: Cleaned | None,
    decays: Sequence[Decay],
    repeats: Repeats | None,
    reconstruction: Reconstruction | None,
    level: Ratio,
    warnings: Sequence[str],
) -> Content:
    """Return the content of a report; the parameters are those of `report`."""
    return Content(
        identification=drawable(identification),
        source=source,
        cleaned=cleaned,
        decays=decays,
        repeats=repeats,
        reconstruction=reconstruction,
        level=level,
        warnings=warnings,
    )


def judgement_of(
    identification: Identification,
    *,
    cleaned: Cleaned | None,
    decays: Sequence[Decay],
    repeats: Repeats | None,
    reconstruction: Reconstruction | None,
    level: Ratio,
) -> Judgement:
    """Return the verdict on everything that a report is given."""
    used = used_decay(identification.response, decays)
    return judge(
        identification,
        decay_doubts=() if used is None else [str(doubt) for doubt in decays[used].doubts],
        unrepaired=0 if cleaned is None else len(cleaned.verdict.doubts),
        repeats=repeats,
        reconstruction=reconstruction,
        level=level,
    )


def used_decay(response: control.TimeResponseData, decays: Sequence[Decay]) -> int | None:
    """Return which of the decays the record is, or None if it is none of them."""
    signal = as_signal(response)
    near = [i for i, decay in enumerate(decays) if abs(decay.start - signal.start) <= SAME_START * signal.step]
    return min(near, key=lambda i: abs(decays[i].stop - signal.start - signal.duration), default=None)
