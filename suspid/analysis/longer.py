"""Whether the decay that is used is the end of a longer one, which shows more of its modes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from suspid.analysis.choice import settled
from suspid.analysis.far_larger import only_the_end
from suspid.analysis.forced_start import behind_blow
from suspid.analysis.settings import Settings
from suspid.analysis.shown_modes import shows_all, shows_more
from suspid.analysis.tries import tried, tried_linear
from suspid.analysis.used import Used, used_of
from suspid.decays import LITTLE, Decay, Decays, releases_before, rests_from
from suspid.identification import Identification, removed_as
from suspid.records import cut, of_channels
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.words import DecayDoubt, Reason

if TYPE_CHECKING:
    import control

# Two decays are one where the later begins within this number of periods of its slowest mode after the earlier.
# Friction that holds a mass and lets it go parts them; a larger number tries to join a second release to the first.
SHORT_PAUSE = 1.0
# A release this number of periods of the slowest mode before a decay is tried as its start: a fast mode may have died
# since. A smaller number costs the time of a fit for nothing.
EARLIER = 0.3
# Samples at its start that may be of the hold before a decay: the first fits take means over some.
OF_HOLD = 2.5
# The motion goes on after a decay if the samples there spread by more than this many standard deviations of the
# residual. White noise hardly spreads by more than ten; a smaller number costs the time of a fit where none is needed.
MOVES = 15.0
# A release is looked for before a decay within this multiple of its length, after which a fast mode has died, and
# within this number of periods of the slowest: friction bends a motion until only its last cycles look like a decay.
BEFORE_DECAY, BEFORE_PERIODS = 3.0, 20.0
# Doubts that end with the first of two decays that are joined.
OF_LENGTH = LITTLE | {DecayDoubt.CUT_OFF}


def longer(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the longer decay of which the best one is a part, if that shows more of its modes."""
    for decay in _earlier(record, best):
        more = _behind_blow(record, best, decay, settings)
        if more.identification is None:
            continue
        shown = best.identification is None and shows_all(more.identification, best.used[0])
        if not shown:
            best = with_identification(best, settings)
            shown = shows_more(more.identification, best.identification)
        if shown or only_the_end(more.identification, best.identification):
            best = more
            break
    return with_its_end(record, best, settings)


def with_its_end(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the decay that ends later of which the best one is the start, if that shows more of its modes."""
    for decay in _later(record, best):
        best = with_identification(best, settings)
        if not (_goes_on(record, best).any() or _has_tones(best.identification)):
            continue
        more = with_identification(used_of(record, best.decays, decay), settings)
        if more.identification is not None and shows_more(more.identification, best.identification):
            best = more
            break
    return _with_its_events(record, best, settings)


def _with_its_events(record: control.TimeResponseData, best: Used, settings: Settings) -> Used:
    """Return the linear decay to the end of a record of which other events are part, where most of these are no decays.

    Modes that beat rise again and again. It leaves only noise, and is most of the record.
    """
    signal = as_signal(record)
    if len(best.used) != 1:
        return best
    doubts = tuple(doubt for doubt in best.used[0].doubts if doubt.code is not DecayDoubt.COMPANY)
    if doubts == best.used[0].doubts:
        return best
    decay = _to_the_end(replace(best.used[0], doubts=doubts), rests_from(signal))
    if 2 * (decay.stop - decay.start) < float(signal.timepts[-1]) - signal.start:
        return best
    more = used_of(record, best.decays, decay)
    found = tried_linear(more.record, settings, strict=False)
    if found is None or not settled(found) or not shows_more(found, best.identification):
        return best
    return replace(more, identification=found)


def longest(record: control.TimeResponseData, best: Used) -> Used | None:
    """Return the longest decay of which the one that is used may be a part; None where it is no part of another.

    It has the same channels. Where one has stopped, none ends later.
    """
    record = of_channels(record, as_signal(best.record).channels)
    starts = [one.start for one in _earlier(record, best) if one.start < best.used[0].start]
    later = list(_later(record, best))
    later = later if later and _goes_on(record, best).all() else []
    if not (starts or later):
        return None
    last = max([best.used[0], *later], key=lambda decay: decay.stop)
    return used_of(record, best.decays, _from(last, min([last.start, *starts])) if starts else last)


def with_identification(used: Used, settings: Settings) -> Used:
    """Return the part of a record that is used with what is identified in it."""
    return replace(used, identification=used.identification or tried(used.record, settings))


def _behind_blow(record: control.TimeResponseData, best: Used, decay: Decay, settings: Settings) -> Used:
    """Return what is identified in a decay, from behind the blow at its start on where that leaves only noise."""
    used = with_identification(used_of(record, best.decays, decay), settings)
    late = None if used.identification is None else behind_blow(used.identification)
    if late is None or late > EARLIER * _period(decay):
        return used
    free = with_identification(used_of(record, best.decays, replace(decay, start=decay.start + late)), settings)
    return free if free.identification is not None and settled(free.identification) else used


def _released(record: control.TimeResponseData, used: Decay, first: Second) -> tuple[Second, ...]:
    """Return when the motion that a decay continues, from a first time on, may have been let go.

    A look at all of a long recording would cost too much.
    """
    reach = max(BEFORE_DECAY * (used.stop - first), BEFORE_PERIODS * _period(used))
    earliest = max(as_signal(record).start, first - reach)
    return releases_before(as_signal(cut(record, start=earliest, stop=used.stop)), first)


def _after(signal: Signal, best: Used) -> RealArray:
    """Return the samples of a record after the stretch that is used, (channel, sample), of its channels."""
    rows = [signal.channels.index(name) for name in as_signal(best.record).channels]
    return signal.values[rows][:, signal.timepts > best.used[0].stop + 0.5 * signal.step]


def _before(used: Decay, decays: Sequence[Decay], signal: Signal) -> list[Decay]:
    """Return the decays that begin before the one that is used: those that contain it or that it continues, joined."""
    earlier = [decay for decay in decays if decay.start < used.start]
    return [
        decay if decay.stop >= used.stop else _until(decay, used.stop)
        for decay in earlier
        if decay.stop >= used.stop or _continued(signal, decay, used)
    ]


def _earlier(record: control.TimeResponseData, best: Used) -> Iterator[Decay]:
    """Yield longer decays that begin earlier: where the motion before was let go, then where those before it begin.

    First that from where it was let go to where all channels rest, if they do: it is all of the motion. The first
    samples of the one that is used may be of the hold before it.
    """
    if len(best.used) != 1 or not isinstance(best.decays, Decays):
        return
    signal, used = as_signal(record), best.used[0]
    before = _before(used, best.decays, signal)
    released = _released(record, used, min(decay.start for decay in (used, *before)) + OF_HOLD * signal.step)
    rest = rests_from(signal)
    # The last samples are alike by chance.
    rests = signal.timepts[-1] - rest > EARLIER * _period(used)
    if rests and used.stop <= rest and not _followed(signal, best):
        all_of_it = (replace(_to_the_end(used, rest), start=start) for start in released)
        yield from (decay for decay in all_of_it if (decay.start, decay.stop) != (used.start, used.stop))
    yield from (_from(used, start) for start in released if start < used.start - EARLIER * _period(used))
    yield from before


def _later(record: control.TimeResponseData, best: Used) -> Iterator[Decay]:
    """Yield longer decays that end later: joined to the next where the one that is used is cut off.

    Then continued to where all channels rest, or to the last sample, where no other motion follows: what fills a record
    has no background to meet.
    """
    if len(best.used) != 1 or not isinstance(best.decays, Decays):
        return
    signal, used = as_signal(record), best.used[0]
    end = rests_from(signal)
    if any(doubt.code is DecayDoubt.CUT_OFF for doubt in used.doubts):
        near = used.stop + SHORT_PAUSE * _period(used)
        yield from (_until(used, decay.stop) for decay in _after_it(best) if decay.start <= near)
    if end > used.stop and not _followed(signal, best):
        yield _to_the_end(used, end)


def _after_it(best: Used) -> list[Decay]:
    """Return the decays that begin and end after the one that is used does."""
    used = best.used[0]
    return [decay for decay in best.decays if decay.start > used.start and decay.stop > used.stop]


def _followed(signal: Signal, best: Used) -> bool:
    """Return whether other motion follows the decay that is used, and not only its end."""
    return not all(_continued(signal, best.used[0], decay) for decay in _after_it(best))


def _goes_on(record: control.TimeResponseData, best: Used) -> NDArray[np.bool_]:
    """Return which channels move after a decay by more than what the fit to it leaves, (channel,)."""
    after = _after(as_signal(record), best)
    if best.identification is None or not after.shape[1]:
        return np.full(len(after), best.identification is None)
    return np.asarray(np.ptp(after, axis=1) > MOVES * best.identification.noise_std)


def _has_tones(found: Identification | None) -> bool:
    """Return whether a fit has what does not decay within its stretch: a slow mode looks so beside faster ones."""
    return found is not None and bool(removed_as(found.considered, Reason.TONE))


def _from(decay: Decay, start: Second) -> Decay:
    """Return a decay that begins earlier: what was said of few cycles, and of a small part, was said of its end."""
    of_end = LITTLE | {DecayDoubt.SMALL_PART}
    return replace(decay, start=start, doubts=tuple(doubt for doubt in decay.doubts if doubt.code not in of_end))


def _until(decay: Decay, stop: Second) -> Decay:
    """Return a decay that ends later."""
    return replace(decay, stop=stop, doubts=tuple(doubt for doubt in decay.doubts if doubt.code not in OF_LENGTH))


def _to_the_end(decay: Decay, stop: Second) -> Decay:
    """Return a decay that goes on to the end of a record: what was taken for a background is part of it."""
    doubts = tuple(doubt for doubt in decay.doubts if doubt.code is not DecayDoubt.BACKGROUND)
    return _until(replace(decay, doubts=doubts), stop)


def _continued(signal: Signal, before: Decay, after: Decay) -> bool:
    """Return whether one decay continues another: after a short pause, or without a rise of the motion between them."""
    if before.stop >= after.start - SHORT_PAUSE * _period(after):
        return True
    borders = np.searchsorted(signal.timepts, [before.start, before.stop, after.start, after.stop], side="right")
    parts = [signal.values[:, i:j] for i, j in itertools.pairwise(borders.tolist())]
    if min(part.shape[1] for part in parts) < 2:
        return False
    first, pause, last = (np.ptp(part, axis=1) for part in parts)
    return bool(np.all(first > pause) and np.all(pause > last))


def _period(decay: Decay) -> Second:
    return 2 * np.pi / float(np.min(decay.wn)) if len(decay.wn) else 0.0
