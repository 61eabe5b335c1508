"""Choice of the stretch to identify: the best decay, or the whole record if that fits the decay as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import explains, holds, linear, settled, swings
from suspid.analysis.derivatives import without_derivatives
from suspid.analysis.far_larger import far_larger
from suspid.analysis.first_rest import until_one_rests
from suspid.analysis.forced_start import freed, later_starts, without_start
from suspid.analysis.from_rest import from_rest
from suspid.analysis.held import without_held
from suspid.analysis.idle import without_idle
from suspid.analysis.longer import longer, with_identification, with_its_end
from suspid.analysis.settings import Settings
from suspid.analysis.shown_modes import shared_modes
from suspid.analysis.tries import tried, tried_linear
from suspid.analysis.until_locked import released_and_locked
from suspid.analysis.used import Used, used_of
from suspid.decays import LOOK_BLOCKS, Decay, Decays, by_chance, clearly_driven, find_decays, is_grave
from suspid.errors import RecordError
from suspid.identification import Identification
from suspid.records import cut, late_start
from suspid.signals import as_signal
from suspid.units import Second
from suspid.words import DecayDoubt, Level, Note, Number, Remark

if TYPE_CHECKING:
    import control

# Shares of the best decay after which it is tried again where no mode is found in it, and decays tried after it.
LATER_SHARES, NEXT_DECAYS = (0.05, 0.1, 0.2, 0.4), 2
# Decays tried where the identification of the best one is doubtful: each costs the time of an identification.
MOST_NEXT = 4
# The largest motion of a decay that begins with the record is within this part of it: with less than two cycles after
# it, its decay would not be known.
EARLY_PART = 0.25
# Remarks on stretches that are no decay which are repeated where no decay is used; `Decays.remarks` has all of them.
MOST_REMARKS = 2


def stretch_of(record: control.TimeResponseData, settings: Settings) -> Used:
    """Return the stretch of a record that the settings ask for, of the channels asked for or that measure a motion."""
    left_out: tuple[Remark, ...] = ()
    if settings.channels is None:
        record, held = without_held(record)
        record, derived = without_derivatives(record)
        record, idle = without_idle(record)
        left_out = (*held, *derived, *idle)
    found = _stretch_of(record, settings)
    return replace(found, notes=(*left_out, *found.notes))


def _stretch_of(record: control.TimeResponseData, settings: Settings) -> Used:
    part = part_asked_for(record, settings)
    if part is not None:
        return Used(record=part, decays=(), used=(), notes=_outside(record, settings))
    which = settings.decay
    if which == "whole":
        return Used(record=record, decays=(), used=(), notes=())
    if which == "auto":
        plain = _linear(record, settings)
        locked = released_and_locked(record, settings) if plain is None else None
        if locked is not None:
            return locked
        best = longer(record, _best(record, settings) if plain is None else plain, settings)
        sounder = _sounder(record, best, settings)
        best = sounder if sounder.used == best.used else longer(record, sounder, settings)
        free = _once_free(record, best, settings)
        free = free if free.used == best.used else with_its_end(record, free, settings)
        return until_one_rests(record, from_rest(record, free, settings), settings)
    decays = find_decays(record)
    if not decays:
        raise RecordError(f"no free decay was found. {_remarks(decays)}")
    return _all(record, decays) if which == "all" else _one(record, decays, int(which))


def part_asked_for(record: control.TimeResponseData, settings: Settings) -> control.TimeResponseData | None:
    """Return the part of a record that the settings name; None if they name none."""
    if settings.start is None and settings.stop is None:
        return None
    return cut(record, start=settings.start, stop=settings.stop)


def _outside(record: control.TimeResponseData, settings: Settings) -> tuple[Remark, ...]:
    """Return a remark where a time that was asked for lies before or after the record.

    A record of two seconds ends one sample before them, give or take rounding.
    """
    signal = as_signal(record)
    first, last, slack = float(signal.timepts[0]), float(signal.timepts[-1]), 1.5 * signal.step
    early = settings.start is not None and settings.start < first - slack
    late = settings.stop is not None and settings.stop > last + slack
    return (Remark(Note.OUTSIDE, {"first": first, "last": last}),) if early or late else ()


def _linear(record: control.TimeResponseData, settings: Settings) -> Used | None:
    """Return the whole record where several channels are a linear decay from the first sample on, beyond doubt."""
    signal = as_signal(record)
    largest = late_start(signal)
    if len(signal.channels) < 2 or (largest is not None and not _may_decay(record, largest)):
        return None
    found = tried_linear(record, settings)
    if found is None or not linear(found) or (largest is not None and not _holds_later(found, record, settings)):
        return None
    return Used(record=record, decays=(), used=(), notes=(), identification=found)


def _best(record: control.TimeResponseData, settings: Settings) -> Used:
    """Return the best clear decay; the whole record where it is one, explains it as well, or where there is none.

    Where neither has a mode, the best decay is tried from later on, and then the next ones.
    """
    largest = late_start(as_signal(record))
    late = largest is not None
    if largest is None:
        whole = tried(record, settings)
    else:
        whole = tried_linear(record, settings) if _may_decay(record, largest) else None
    if whole is not None and settled(whole) and (not late or _holds_later(whole, record, settings)):
        return Used(record=record, decays=(), used=(), notes=(), identification=whole)
    decays = find_decays(record)
    clear = [decay for decay in decays if not by_chance(decay)]
    fewer_doubts = False
    if clear:
        best = used_of(record, decays, clear[0])
        if late and not clear[0].doubts and swings(clear[0]):
            return best
        part = tried(best.record, settings)
        best = until_one_rests(record, replace(best, identification=part), settings)
        part = best.identification
        if late and not (part is not None and settled(part)):
            whole = tried(record, settings)
        pulse = part is not None and (clear[0].doubts or _doubtful(part)) and not swings(part.modes)
        fewer_doubts = _surer(whole, part)
        if part is not None and not pulse and not fewer_doubts and (whole is None or not explains(whole, part)):
            return replace(best, identification=part)
        if whole is None or not len(whole.modes):
            again = _again(record, decays, clear, settings, pulse=part if pulse else None)
            if again is not None:
                return again
    whole = tried(record, settings) if late and not clear else whole
    said: dict[str, Number] = {
        "surer": fewer_doubts,
        "found": len(decays),
        "clear": len(clear),
        "modes": 0 if whole is None else len(whole.modes),
        "best": str((clear or decays)[0]) if decays else "",
        "remarks": _remarks(decays),
    }
    note = Remark(Note.WHOLE_RECORD, said)
    return Used(record=record, decays=decays, used=(), notes=(note,), identification=whole)


def _sounder(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return another decay where the identification of the best one is doubtful: one that is not, or one that agrees.

    After each of several releases the same modes are seen; what a single decay shows that is still driven, none other.
    """
    decays = best.decays
    if len(best.used) != 1 or not isinstance(decays, Decays) or len(decays) < 2:
        return best
    best = with_identification(best, settings)
    if not _doubtful(best.identification):
        return best
    tries = [best]
    others = [decay for decay in decays if decay.start != best.used[0].start and not by_chance(decay)]
    for decay in others[:MOST_NEXT]:
        used = used_of(record, decays, decay)
        found = tried(used.record, settings)
        tries.append(replace(used, identification=found))
        if found is not None and settled(found) and not _doubtful(found):
            return tries[-1]
    # What the fit leaves calls for care, as friction does; that is less than a doubt.
    for used in tries[1:]:
        if not _doubtful(used.identification) and not any(is_grave(doubt) for doubt in used.used[0].doubts):
            return used
    shared = shared_modes([one.identification for one in tries])
    return tries[int(np.argmax(shared))] if max(shared) > shared[0] else far_larger(record, tries)


def _doubtful(found: Identification | None) -> bool:
    return found is None or not len(found.modes) or found.verdict.level is Level.DOUBTFUL


def _surer(whole: Identification | None, part: Identification | None) -> bool:
    """Return whether a fit to a whole record has the modes of one to its part, no others, and only that is doubtful."""
    return _doubtful(part) and not _doubtful(whole) and min(shared_modes([whole, part])) == 1.0


def _once_free(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the decay from a later start on where modes at its start stand for a force that ends."""
    if len(best.used) != 1:
        return best
    best = with_identification(best, settings)
    found = best.identification
    decay, decays = best.used[0], best.decays
    if found is None or not isinstance(decays, Decays):
        return best
    start = as_signal(best.record).start
    for later in later_starts(record, found):
        if start + later >= decay.stop:
            break
        used = used_of(record, decays, replace(decay, start=start + later))
        free = tried(used.record, settings)
        if free is not None and settled(free) and freed(found, free):
            return replace(used, identification=without_start(found, free))
    return best


def _may_decay(record: control.TimeResponseData, largest: Second) -> bool:
    """Return whether a record that moves most at a later time may be a decay from its first sample on.

    A coordinate that starts at rest moves most within half a period of the slowest mode, and a decay has cycles after.
    """
    signal = as_signal(record)
    samples = signal.values.shape[1]
    early = largest - signal.start < EARLY_PART * samples * signal.step
    return early and not clearly_driven(signal.values, size=max(1, samples // LOOK_BLOCKS))


def _holds_later(whole: Identification, record: control.TimeResponseData, settings: Settings) -> bool:
    """Return whether the fit to a record also explains what follows the first of its channels' largest motions.

    Where the release is later than the first sample, short modes stand for the rest before it, and go with it. A
    channel that begins near its largest motion may be held there, and does not tell.
    """
    signal = as_signal(record)
    about = np.abs(signal.values - signal.values.mean(axis=1, keepdims=True))
    peaks = np.argmax(about, axis=1)
    begun = 2 * about[:, 0] < np.max(about, axis=1)
    first = signal.start + signal.step * int(np.min(peaks[begun] if begun.any() else np.max(peaks)))
    part = cut(record, start=first)
    if holds(whole, part):
        return True
    later = tried_linear(part, settings)
    return later is not None and explains(whole, later)


def _again(
    record: control.TimeResponseData,
    decays: Decays,
    clear: Sequence[Decay],
    settings: Settings,
    *,
    pulse: Identification | None,
) -> Used | None:
    """Return the best clear decay from a later start on, or one of the next, in which modes are found.

    Where most events are no decays, a mode that is found in one try of several is no finding. Where the best decay
    begins with what looks like a ``pulse``, only modes that were found beside it are sought behind it.
    """
    best = clear[0]
    if any(doubt.code is DecayDoubt.COMPANY for doubt in best.doubts):
        return None
    later = [replace(best, start=best.start + share * (best.stop - best.start)) for share in LATER_SHARES]
    for decay in (*later, *(clear[1 : 1 + NEXT_DECAYS] if pulse is None else ())):
        used = used_of(record, decays, decay)
        found = tried(used.record, settings)
        known = found is not None and (pulse is None or shared_modes([found, pulse])[0] == 1.0)
        if found is not None and known and len(found.modes) and swings(found.modes):
            return replace(used, identification=found)
    return None


def _all(record: control.TimeResponseData, decays: Decays) -> Used:
    sure = tuple(decay for decay in decays if not decay.doubts) or tuple(decays)
    starts = ", ".join(f"{decay.start:.6g}" for decay in sure)
    notes = [Remark(Note.DECAYS_USED, {"number": len(sure), "starts": starts})]
    if len(decays) > len(sure):
        notes.append(Remark(Note.DECAYS_LEFT_OUT, {"number": len(decays) - len(sure)}))
    part = cut(record, start=sure[0].start, stop=sure[0].stop)
    return Used(record=part, decays=decays, used=sure, notes=tuple(notes))


def _one(record: control.TimeResponseData, decays: Decays, rank: int) -> Used:
    if rank > len(decays):
        some = f"choose a rank up to {len(decays)}: {'; '.join(map(str, decays))}"
        raise RecordError(f"there is no decay of rank {rank}; {some}")
    return used_of(record, decays, decays[rank - 1])


def _remarks(decays: Decays) -> str:
    said = " ".join(str(remark) for remark in decays.remarks[:MOST_REMARKS])
    more = len(decays.remarks) - MOST_REMARKS
    return f"{said} … and {more} more such." if more > 0 else said
