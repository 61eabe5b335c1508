"""The part of a record that is identified."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.held import toggles
from suspid.analysis.past_clipping import past_clipping
from suspid.decays import Decay, Decays
from suspid.identification import Identification
from suspid.records import cut, of_channels
from suspid.signals import as_signal
from suspid.words import DecayDoubt, Note, Remark

if TYPE_CHECKING:
    import control

# What is said of channels that are left out of a whole record; it holds for any part of it.
OF_CHANNELS = frozenset(
    {
        Note.HELD_CHANNEL,
        Note.BLOW_CHANNEL,
        Note.IDLE_CHANNEL,
        Note.CLIPPED_CHANNEL,
        Note.COMMAND_CHANNEL,
        Note.COPIED_CHANNEL,
        Note.DERIVED_CHANNEL,
        Note.FEWER_CHANNELS,
    }
)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Used:
    """The part of a record that is taken as a decay, among the decays that were found."""

    record: control.TimeResponseData
    decays: Decays | tuple[Decay, ...]
    used: tuple[Decay, ...]
    notes: tuple[Remark, ...]
    identification: Identification | None = None  # of the record, where it was needed for the choice


def used_of(record: control.TimeResponseData, decays: Decays | tuple[Decay, ...], best: Decay) -> Used:
    """Return a decay of a record as the part that is used, without clipped samples at its start and still channels."""
    best = _from_its_start(past_clipping(record, best))
    used = Remark(Note.DECAY_USED, {"start": best.start, "stop": best.stop, "others": len(decays) - 1})
    doubts = [Remark(Note.DECAY_DOUBT, {"doubt": str(doubt)}) for doubt in best.doubts]
    part, still = _moving(cut(record, start=best.start, stop=best.stop))
    return Used(record=part, decays=decays, used=(best,), notes=(used, *doubts, *still))


def _from_its_start(decay: Decay) -> Decay:
    """Return a decay without the doubt that no fit explains it before some time, where it is used from before that."""
    doubts = []
    for doubt in decay.doubts:
        first, start = (doubt.numbers.get(name) for name in ("first", "start"))
        if doubt.code is DecayDoubt.LATER and isinstance(first, float) and isinstance(start, float):
            if decay.start <= first:
                continue
            doubt = replace(doubt, numbers={"first": first, "start": min(start, decay.start)})
        doubts.append(doubt)
    return replace(decay, doubts=tuple(doubts))


def instead_of(before: Used, part: Used) -> Used:
    """Return another part of the same channels of a record, with what was said of those that are left out."""
    said = tuple(note for note in before.notes if note.code in OF_CHANNELS and note not in part.notes)
    return replace(part, notes=(*said, *part.notes))


def without_channels(
    record: control.TimeResponseData, out: NDArray[np.bool_], why: Note
) -> tuple[control.TimeResponseData, tuple[Remark, ...]]:
    """Return the record without some of its channels, (channel,), and a note on each; the record where none is left."""
    if out.all() or not out.any():
        return record, ()
    channels = as_signal(record).channels
    kept = [name for name, left_out in zip(channels, out, strict=True) if not left_out]
    return of_channels(record, kept), tuple(Remark(why, {"channel": name}) for name in channels if name not in kept)


def _moving(record: control.TimeResponseData) -> tuple[control.TimeResponseData, tuple[Remark, ...]]:
    """Return the record without channels that stand still in it, and what was left out."""
    still = np.array([toggles(samples) for samples in as_signal(record).values])
    return without_channels(record, still, Note.STILL_CHANNEL)
