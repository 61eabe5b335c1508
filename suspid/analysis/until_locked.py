"""The motion until friction locks one mass to another: from there on fewer modes are left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import level_of, linear, settled
from suspid.analysis.explained_parts import explains_swings, part_used, shortened, used_instead
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.tries import PLAIN, tried_linear
from suspid.analysis.used import Used
from suspid.decays import STARTS_AFTER_REST, at_rest_from, finest, releases_before, stops_at
from suspid.identification import ForceKind, Identification
from suspid.levels import FEWEST_SAMPLES
from suspid.model import ModalSet
from suspid.records import cut, of_channels
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control

# What rests, or moves as one, does so at most for this share of a record.
AS_ONE_AFTER = 0.97
# Channels of which each pair is compared, at most: the first ones.
MOST_COMPARED = 6
# A quarter of a period [rad].
QUARTER_PERIOD = 0.5 * np.pi
# What stops moves by this many times as much before as its steps.
MOVED_BEFORE = 30.0


def until_locked(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the motion until a channel stops, or two move as one, if it is explained down to its noise.

    Friction in a strut lets two masses move against each other until it locks them. What goes on is another structure,
    and no fit without friction explains both. ``found`` is what the search for decays led to: nothing else is tried
    where that leaves only noise and begins before the strut is locked, unless it goes on beyond that without friction.
    What has fewer modes is not used but in place of that, nor as many where what begins before it is not doubtful.
    """
    if not questioned(found, settings) or linear(found):
        return None
    record = of_channels(record, as_signal(stretch.record).channels)
    signal, used = as_signal(record), as_signal(stretch.record)
    last = min(sample for sample, _ in _stops(signal))
    if last == signal.values.shape[1]:
        return None
    locked = _time(signal, last)
    before = used.start < locked - _quarter(found.modes)
    both = before and _goes_on(found, stretch, locked)
    if settled(found) and before and not both:
        return None
    clear = before and not both and level_of(found, stretch.used, stretch.decays) > Level.DOUBTFUL
    least = 1 if both else max(1, len(found.modes) + clear)
    releases = releases_before(signal, locked)
    first = min((*releases, used.start))
    # Starts that differ by fewer samples than are left out are tried already.
    last_ones = [each for each in releases[-1:] if each > first + STARTS_AFTER_REST[-1] * signal.step]
    for begins in (first, *last_ones):
        for part, moved in shortened(record, begins, _time(signal, last - 1), settings):
            if moved is None or len(moved.modes) < least:
                break
            if explains_swings(moved) and (_rubs(moved) or not both):
                return used_instead(stretch, part, moved, Note.UNTIL_LOCKED)
    return None


def released_and_locked(record: control.TimeResponseData, settings: Settings) -> Used | None:
    """Return the motion from a release until a channel stops, or two move as one; None where friction explains it not.

    It is tried before decays are sought, which takes long where friction is: it leaves no doubt which stretch is meant.
    Fewer than two modes are what is locked.
    """
    if settings != replace(PLAIN, channels=settings.channels):
        return None
    signal = as_signal(record)
    last = min(sample for sample, _ in _stops(signal))
    if len(signal.channels) < 2 or last == signal.values.shape[1]:
        return None
    for begins in releases_before(signal, _time(signal, last))[-1:]:
        free = tried_linear(cut(record, start=begins + STARTS_AFTER_REST[-1] * signal.step), settings)
        if free is not None and linear(free):
            return None
        for part, moved in shortened(record, begins, _time(signal, last - 1), settings):
            if moved is not None and len(moved.modes) > 1 and linear(moved):
                return None
            if moved is not None and len(moved.modes) > 1 and explains_swings(moved) and _rubs(moved):
                return Used(
                    record=part, decays=(), used=(), notes=(part_used(part, Note.UNTIL_LOCKED),), identification=moved
                )
    return None


def _goes_on(found: Identification, stretch: Used, locked: Second) -> bool:
    """Return whether a stretch goes on beyond a lock, without friction that would explain that."""
    return float(as_signal(stretch.record).timepts[-1]) > locked + _quarter(found.modes) and not _rubs(found)


def _rubs(found: Identification) -> bool:
    return any(force.kind is ForceKind.FRICTION for force in found.forces)


def _quarter(modes: ModalSet) -> Second:
    """Return a quarter of a period of the fastest mode, 0 without any."""
    return QUARTER_PERIOD / float(np.max(modes.wn)) if len(modes) else 0.0


def after_lock(record: control.TimeResponseData, stretch: Used, modes: ModalSet) -> tuple[Remark, ...]:
    """Return the note that two channels of a stretch move as one, and moved against each other before it.

    The stretch begins where they do, to a quarter of a period of the fastest of its modes: what is explained from
    earlier on says itself how the channels move.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid.records import as_response, cut
    >>> time = np.arange(3000) / 1000
    >>> low, apart = np.sin(20 * time), np.cos(15 * np.minimum(time, 1.2))
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal((2, 3000))
    >>> record = as_response(time, np.stack([low, low + apart]) + noise, ["hub", "frame"])
    >>> used = Used(record=cut(record, start=1.25), decays=(), used=(), notes=())
    >>> modes = ModalSet(poles=np.array([-0.1 + 20j]), shapes=np.ones((2, 1), complex), channels=("hub", "frame"))
    >>> [str(note) for note in after_lock(record, used, modes)]
    ["'hub' and 'frame' move as one from 1.2 s on, and did not before"]
    """
    part = as_signal(stretch.record)
    signal = as_signal(of_channels(record, part.channels))
    last, names = min(_stops(signal))
    locked = _time(signal, last)
    if len(names) < 2 or not len(modes) or part.start < locked - _quarter(modes):
        return ()
    return (Remark(Note.AFTER_LOCK, {"first": names[0], "second": names[1], "time": locked}),)


def _stops(signal: Signal) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Yield the samples from which on a channel rests, or two move as one, where each moved much further before."""
    steps, values, names = finest(signal.values), signal.values, signal.channels
    yield from ((_stop(values[k], steps[k]), (names[k],)) for k in range(len(names)))
    for i, k in combinations(range(min(len(names), MOST_COMPARED)), 2):
        yield _stop(values[i] - values[k], steps[i] + steps[k]), (names[i], names[k])


def _stop(values: RealArray, step: float) -> int:
    """Return the sample from which on a motion rests within its steps or its noise; the number of samples without."""
    size = len(values)
    within = at_rest_from(values[None], np.array([step]))
    if np.ptp(values) <= MOVED_BEFORE * step:
        return size
    rests = within if size - within > FEWEST_SAMPLES and within > (1 - AS_ONE_AFTER) * size else size
    return min(rests, stops_at(values[None], most=AS_ONE_AFTER))


def _time(signal: Signal, sample: int) -> Second:
    return signal.start + signal.step * sample
