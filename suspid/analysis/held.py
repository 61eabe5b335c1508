"""Commands and forces: channels that are constant except for jumps or blows, or named as commands, and not motions."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from suspid.analysis.blows import blows_of
from suspid.analysis.swings import turns_of
from suspid.levels import EXACT, FEWEST_SAMPLES
from suspid.records import of_channels
from suspid.signals import Signal, as_signal
from suspid.units import Flags, RealArray, Second
from suspid.words import Note, Remark

if TYPE_CHECKING:
    import control

# After which samples the changes of a channel begin and end, for each run of them.
Runs: TypeAlias = list[tuple[int, int]]

# A channel is held if it changes in this many places at most, none of them longer than this many samples: a spline
# through a jump rings for about as many. A motion changes for longer, and one of a few steps of its resolution tells
# nothing of its modes.
MOST_JUMPS, LONGEST_JUMP = 4, 48
# A channel of this many values at most is a switch, or a sensor that toggles by a step of its resolution: it tells
# nothing of a motion, however often it changes.
FEW_VALUES = 3
# What turns back this often within a jump, by this share of its range, swings: masses that friction stops soon stand
# still for most of a record. A pulse turns once, one that goes both ways twice; a spline rings from sample to sample,
# no slower than this many.
LEAST_TURNS, SWING, RINGS_FOR = 3, 0.02, 3
# A command makes others move for more than this many times as long as it changes. What turns back once and ends at
# another level, by this share of its range, is a motion that ends as soon as theirs: a force comes back.
GOES_ON, ELSEWHERE = 2, 0.25
# Words of names of what was asked for, not measured. Controllers that are switched off let it follow a sensor.
COMMAND = re.compile(
    r"(?<![a-z])(command(ed)?|cmd|duty|pwm|set[ _-]?point|target|desired|demand(ed)?)(?![a-z])", re.IGNORECASE
)


def without_held(record: control.TimeResponseData) -> tuple[control.TimeResponseData, tuple[Remark, ...]]:
    """Return the record without commands and forces, and what was left out.

    Those hold their value but for a few jumps, measure blows (see `blows_of`), or are named as commands beside channels
    that are not. A record of such channels alone, or one too short to tell, stays as it is.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid.records import as_response
    >>> motion = np.exp(-np.arange(400) / 80) * np.sin(np.arange(400) / 5)
    >>> force = np.where(np.arange(400) < 20, 0.5, 0.0)
    >>> left, notes = without_held(as_response(np.arange(400) / 100, np.stack([motion, force]), ["x", "F"]))
    >>> list(left.output_labels), len(notes)
    (['x'], 1)
    """
    why = _held(as_signal(record))
    kept = [name for name in as_signal(record).channels if name not in why]
    return (of_channels(record, kept), tuple(why.values())) if why else (record, ())


def held_from(record: control.TimeResponseData) -> tuple[tuple[str, ...], list[tuple[Second, Second]]]:
    """Return the commands and forces of a record that hold their values, and from when to when all hold a new one.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid.records import as_response
    >>> time = np.arange(400) / 100
    >>> motion, asked = 1 - np.cos(20 * time), np.floor(time / 1.3)
    >>> held_from(as_response(time, np.stack([motion, asked]), ["x", "u"]))
    (('u',), [(1.3, 2.59), (2.6, 3.89)])
    """
    signal = as_signal(record)
    names = tuple(_held(signal))
    if not names:
        return (), []
    values = signal.values[[signal.channels.index(name) for name in names]]
    first = 1 + np.flatnonzero(np.any(_changes(values), axis=0))
    last = np.append(first[1:], values.shape[1]) - 1
    long = last - first >= FEWEST_SAMPLES
    times = signal.timepts
    return names, list(zip(times[first[long]].tolist(), times[last[long]].tolist(), strict=True))


def _held(signal: Signal) -> dict[str, Remark]:
    """Return the channels that are commands or forces beside others that move, and why."""
    jumps = dict(zip(signal.channels, _jumps_of(signal.values), strict=True))
    blows = dict(zip(signal.channels, blows_of(signal.values).tolist(), strict=True))
    moving = [name for name, number in jumps.items() if number is None and not blows[name]]
    kept = [name for name in moving if not COMMAND.search(name)] or moving
    if not kept:
        return {}
    return {name: _why(name, jumps[name], blows[name]) for name in signal.channels if name not in kept}


def _why(name: str, jumps: int | None, blows: int) -> Remark:
    """Return why a channel is left out."""
    if blows:
        return Remark(Note.BLOW_CHANNEL, {"channel": name, "blows": blows})
    if jumps is None:
        return Remark(Note.COMMAND_CHANNEL, {"channel": name})
    return Remark(Note.HELD_CHANNEL, {"channel": name, "jumps": jumps})


def toggles(samples: RealArray) -> bool:
    """Return whether a channel has a few values only.

    Examples
    --------
    >>> import numpy as np
    >>> toggles(np.array([0.0, 0.017, 0.0, 0.017])), toggles(np.arange(4.0))
    (True, False)
    """
    # The first samples of a motion have more values, and are looked at alone.
    return np.unique(samples[:100]).size <= FEW_VALUES and np.unique(samples).size <= FEW_VALUES


def _jumps_of(values: RealArray) -> list[int | None]:
    """Return how often each channel (channel, sample) jumps between values that it holds; None if it moves otherwise.

    Friction may stop masses within a cycle: then none moves for longer than one that jumps.
    """
    runs = [_runs(samples) for samples in values]
    jumps = list(map(_jumps, values, runs))
    lasts = [sum(last - first + 1 for first, last in each) for each in runs]
    moving = max((each for each, held in zip(lasts, jumps, strict=True) if held is None), default=0)
    return [
        None if held and moving < GOES_ON * last and _rests_elsewhere(samples, each) else held
        for samples, each, held, last in zip(values, runs, jumps, lasts, strict=True)
    ]


def _changes(samples: RealArray) -> Flags:
    """Return after which samples a channel changes, or each of several."""
    return np.asarray(np.abs(np.diff(samples)) > EXACT * np.ptp(samples, axis=-1, keepdims=True))


def _runs(samples: RealArray) -> Runs:
    """Return after which samples a channel begins and ends to change; a run may pause for no longer than a jump."""
    changes = np.flatnonzero(_changes(samples))
    if not changes.size:
        return []
    first = np.flatnonzero(np.diff(changes, prepend=-LONGEST_JUMP - 2) > LONGEST_JUMP)
    last = np.append(first[1:], changes.size) - 1
    return list(zip(changes[first].tolist(), changes[last].tolist(), strict=True))


def _jumps(samples: RealArray, runs: Runs) -> int | None:
    """Return how often a channel jumps between values that it holds; None if it moves otherwise."""
    if samples.size < 4 * LONGEST_JUMP or not runs:
        return None
    if toggles(samples):
        return int(np.sum(_changes(samples)))
    if len(runs) > MOST_JUMPS or max(last - first for first, last in runs) >= LONGEST_JUMP:
        return None
    return None if any(turns >= LEAST_TURNS for turns in _turns(samples, runs)) else len(runs)


def _rests_elsewhere(samples: RealArray, runs: Runs) -> bool:
    """Return whether a channel turns back once within a jump, and then holds another value than before."""
    if toggles(samples):
        return False
    apart = [abs(float(samples[last + 1] - samples[first])) for first, last in runs]
    least = ELSEWHERE * float(np.ptp(samples))
    return any(turns and each > least for turns, each in zip(_turns(samples, runs), apart, strict=True))


def _turns(samples: RealArray, runs: Runs) -> list[int]:
    """Return how often a channel turns back by a size in each run of changes, not from sample to sample."""
    least = SWING * float(np.ptp(samples))
    turns = [turns_of(samples[first : last + 2], least) for first, last in runs]
    return [int(np.sum(np.diff(each, prepend=-RINGS_FOR) >= RINGS_FOR)) for each in turns]
