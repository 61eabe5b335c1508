"""Means over several samples of a record, where it is sampled far faster than it moves and the result is doubtful."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import NO_CYCLE, level_of
from suspid.analysis.forced_start import SAME_POLE
from suspid.analysis.longer import longest, with_identification
from suspid.analysis.settings import Settings
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of, used_of
from suspid.decays import Decays, by_chance
from suspid.identification import Identification
from suspid.levels import FEWEST_SAMPLES
from suspid.records import like, of_channels
from suspid.signals import as_signal, block_means
from suspid.units import RadianPerSecond, Second
from suspid.words import Level, Note, Remark

if TYPE_CHECKING:
    import control

# Samples in each cycle of the fastest mode that are left. A motion that is not quite a decay leaves the same at each of
# many samples, as if each told of one more mode; fewer lose the forces.
LEFT_PER_CYCLE = (28.0, 20.0, 14.0)
# Samples in each cycle of a mode found in means, at least: where a slower one was expected, its harmonics are gone, and
# what forces do to it is another motion.
FEWEST_PER_CYCLE = 8.0
# Other decays that are tried where the one that is used does not agree with itself: each takes the time of three
# identifications of few samples.
OTHERS_IN_MEANS = 2


def with_means(record: control.TimeResponseData, used: Used, settings: Settings) -> Used:
    """Return the part of a record that is used of means over several samples, if that of all samples is doubtful.

    In means over blocks of two lengths the same modes must be found, neither be doubtful, and no mode be damped before
    it swings. Where the decay that is used does not agree with itself, others are tried.
    """
    return _of_parts(used, settings, _parts(record, used))


def with_means_of_longest(record: control.TimeResponseData, used: Used, settings: Settings) -> Used:
    """Return the same of the longest decay of which the one that is used may be a part, if there is one."""
    return _of_parts(used, settings, _longest(record, used))


def means_of(record: control.TimeResponseData, size: int) -> control.TimeResponseData:
    """Return the means over blocks of samples of a record, at the middle of each.

    Examples
    --------
    >>> from suspid.records import as_response
    >>> means = means_of(as_response(np.arange(7.0), np.arange(7.0)[None] ** 2, ["seat"]), 3)
    >>> means.time.tolist(), means.y.round(2).tolist()
    ([1.0, 4.0], [[1.67, 16.67]])
    """
    signal = as_signal(record)
    values = block_means(signal.values, size)
    times = signal.start + signal.step * (0.5 * (size - 1) + size * np.arange(values.shape[1]))
    title = str(getattr(record, "title", None) or "")
    return like(record, np.asarray(times), values, signal.channels, title=title)


def _of_parts(used: Used, settings: Settings, parts: Iterable[Used]) -> Used:
    """Return means of the first of several parts that agree with themselves, where what is used is doubtful."""
    if settings.decay != "auto" or settings.method != "likelihood" or len(used.used) > 1:
        return used
    used = with_identification(used, settings)
    if used.identification is not None and level_of(used.identification, used.used, used.decays) > Level.DOUBTFUL:
        return used
    return next((agreed for part in parts if (agreed := _agreed(part, settings)) is not None), used)


def _parts(record: control.TimeResponseData, used: Used) -> Iterator[Used]:
    """Yield the part that is used, and other decays, of the same channels."""
    yield used
    if isinstance(used.decays, Decays):
        record = of_channels(record, as_signal(used.record).channels)
        others = [decay for decay in used.decays if decay not in used.used and not by_chance(decay)]
        yield from (instead_of(used, used_of(record, used.decays, decay)) for decay in others[:OTHERS_IN_MEANS])


def _longest(record: control.TimeResponseData, used: Used) -> Iterator[Used]:
    """Yield the longest decay, looked for only when it is asked for."""
    part = longest(record, used)
    if part is not None:
        yield instead_of(used, part)


def _agreed(part: Used, settings: Settings) -> Used | None:
    """Return the means over the shorter of two blocks that show the same modes; None if no two do."""
    signal, fastest = as_signal(part.record), _fastest(part)
    before = list[tuple[Used, Identification]]()
    sizes = _sizes(fastest, signal.step)
    for size in sizes:
        if size < 2 or signal.values.shape[1] < FEWEST_SAMPLES * size:
            continue
        means = means_of(part.record, size)
        found = tried(means, settings)
        if (
            found is None
            or _never_swings(found)
            or _too_fast(found, means)
            or level_of(found, part.used, part.decays) <= Level.DOUBTFUL
        ):
            continue
        same = next((one for one, other in before if _same(other, found)), None)
        if same is not None:
            return same
        # What forces leave at each sample may have been the fastest mode, and is gone in means.
        slower = float(np.max(found.modes.wn))
        if slower * LEFT_PER_CYCLE[0] < fastest * LEFT_PER_CYCLE[1]:
            sizes += [more for more in _sizes(slower, signal.step) if more not in sizes]
        note = Remark(Note.MEANS, {"size": size, "rate": 1 / (size * signal.step)})
        before.append((replace(part, record=means, identification=found, notes=(note, *part.notes)), found))
    return None


def _sizes(fastest: RadianPerSecond, step: Second) -> list[int]:
    """Return the numbers of samples of which means are taken."""
    return list(dict.fromkeys(int(2 * np.pi / (each * fastest * step)) for each in LEFT_PER_CYCLE))


def _fastest(part: Used) -> RadianPerSecond:
    """Return the frequency of the fastest mode of a part, as the search for decays or an identification has it."""
    found = part.identification
    of_found = np.zeros(0) if found is None else found.modes.wn
    wn = part.used[0].wn if part.used else of_found
    return float(np.max(wn)) if wn.size else np.inf


def _never_swings(found: Identification) -> bool:
    """Return whether a mode is damped before it swings: beside others it may be what forces left, not a mode."""
    return bool(np.any(found.modes.zeta > NO_CYCLE))


def _too_fast(found: Identification, means: control.TimeResponseData) -> bool:
    """Return whether a mode that was found in means turns too fast for them."""
    return bool(np.max(found.modes.wn, initial=0.0) * as_signal(means).step * FEWEST_PER_CYCLE > 2 * np.pi)


def _same(one: Identification, other: Identification) -> bool:
    """Return whether two identifications have the same modes."""
    ours, theirs = one.modes.poles, other.modes.poles
    return len(ours) == len(theirs) and bool(np.all(np.abs(ours - theirs) < SAME_POLE * np.abs(ours)))
