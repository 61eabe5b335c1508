"""Motion after a command: about where it settles, it is free while the command holds its value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from suspid.analysis.choice import NO_CYCLE, level_of, settled
from suspid.analysis.held import held_from
from suspid.analysis.largest import MOST_OF_IT
from suspid.analysis.settings import Settings
from suspid.analysis.support import questioned
from suspid.analysis.swings import AT_REST
from suspid.analysis.tries import tried
from suspid.analysis.used import Used, instead_of
from suspid.decays import SAME_MODE, Decay, in_common
from suspid.identification import Identification, cycles_seen
from suspid.records import cut, of_channels
from suspid.samples import held
from suspid.signals import Signal, as_signal
from suspid.units import Ratio, Second
from suspid.words import DecayKind, Level, ModeCheck, Note, Remark

if TYPE_CHECKING:
    import control

# Doubts that a pulse of force may look like the modes: where the command holds its value, none acts.
ANSWERED_BY_COMMAND = frozenset({ModeCheck.NOT_CROSS_CHECKED, ModeCheck.ONE_SHAPE})
# What is said of modes that only follow what a drive, a delay or a chain of lags makes of a step.
LEFT_OPEN_BY_IT = frozenset({ModeCheck.KNOWN_ROUGHLY, ModeCheck.DAMPING_UNKNOWN, ModeCheck.UNRESOLVED})
# Modes stay the same, to within the second share, from later on by the first angle [rad] of the slowest: those that
# follow what leads a motion do not.
LATER_ANGLE, SAME_LATER = 1.5, 0.05
# Stretches that are tried at most, the longest, and samples that they have together: each takes the time of an
# identification.
MOST_TRIED, SAMPLES_TRIED = 8, 40_000
# After one change alone, what moves must have been at rest before, for this many samples.
FEWEST_BEFORE = 8

Span = tuple[Second, Second]


def after_commands(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings
) -> Used | None:
    """Return the stretches after changes of a command that show the same modes; None if that is not asked for or seen.

    They are tried where the search for decays ends in doubts or without modes: a heavily damped step response has too
    few cycles to tell it from a pulse of force, but a command that holds its value makes none.
    """
    if not questioned(found, settings):
        return None
    if len(found.modes) and level_of(found, stretch.used, stretch.decays) > Level.DOUBTFUL:
        return None
    names, spans = held_from(record)
    motion = of_channels(record, as_signal(stretch.record).channels)
    step = as_signal(record).step
    spans = sorted(spans, key=lambda span: -round((span[1] - span[0]) / step))[:MOST_TRIED]
    if sum(stop - start for start, stop in spans) > SAMPLES_TRIED * step:
        return None
    tries = [(span, tried(cut(motion, start=span[0], stop=span[1]), settings)) for span in spans]
    shown = [(span, one) for span, one in tries if one is not None and _free(one)]
    shown = [each for each in shown if _again(each[1], [one for _, one in shown if one is not each[1]])] or shown
    shown = sorted(shown, key=lambda each: -_size(as_signal(held(each[1], "fitted"))))
    if not shown or 2 * len(shown) < len(tries):
        return None
    first = shown[0][1]
    if (len(shown) == 1 and not _from_rest(as_signal(motion), shown[0][0])) or not _has(first, found):
        return None
    if any(check.remark.code in LEFT_OPEN_BY_IT for check in first.verdict.checks):
        return None
    if not _stays(first, settings):
        return None
    used = tuple(_decay_of(span, one, rank=k + 1) for k, (span, one) in enumerate(shown))
    note = Remark(Note.COMMANDED, {"names": names, "number": len(used)})
    part = Used(record=held(first, "response"), decays=used, used=used, notes=(note,), identification=first)
    return instead_of(stretch, part if len(used) > 1 else replace(part, decays=(), used=()))


def _has(one: Identification, modes: Identification, *, within: Ratio = SAME_MODE) -> bool:
    """Return whether all modes of another identification are modes of one."""
    return all(in_common(np.array([wn]), one.modes.wn, within=within) for wn in modes.modes.wn)


def _again(one: Identification, others: Sequence[Identification]) -> bool:
    """Return whether another stretch shows the modes of one, or one that has no others."""
    return any(_has(one, other) or _has(other, one) for other in others)


def _free(one: Identification) -> bool:
    """Return whether modes that swing are most of a motion, alone, and what is doubted of them a command answers.

    What a drive leads smoothly from one place to the next looks like modes that are damped before they swing.
    """
    alone = not any(considered.removed for considered in one.considered)
    swing = bool(np.all(one.modes.zeta < NO_CYCLE))
    if not (alone and swing and settled(one) and float(np.max(one.explained)) > MOST_OF_IT):
        return False
    doubts = {check.remark.code for check in one.verdict.checks if check.level is Level.DOUBTFUL}
    return doubts <= ANSWERED_BY_COMMAND


def _stays(one: Identification, settings: Settings) -> bool:
    """Return whether the modes are the same from later on."""
    response = as_signal(held(one, "response"))
    start = response.start + LATER_ANGLE / float(np.min(one.modes.wn))
    if start >= response.timepts[-1]:
        return False
    later = tried(cut(held(one, "response"), start=start), settings)
    return later is not None and _has(later, one, within=SAME_LATER) and _has(one, later, within=SAME_LATER)


def _from_rest(motion: Signal, span: Span) -> bool:
    """Return whether a motion begins from rest: from what was seen of it before, of some samples."""
    before = motion.values[:, motion.timepts < span[0]]
    if before.shape[1] < FEWEST_BEFORE:
        return False
    return bool(np.max(np.ptp(before, axis=1) / np.maximum(np.ptp(motion.values, axis=1), 1e-300)) < AT_REST)


def _size(signal: Signal) -> float:
    """Return the largest range of a motion."""
    return float(np.max(np.ptp(signal.values, axis=1)))


def _decay_of(span: Span, one: Identification, *, rank: int) -> Decay:
    """Return a stretch after a command as a decay."""
    ranges = np.ptp(as_signal(held(one, "fitted")).values, axis=1)
    nepers = float(np.log(np.max(ranges / np.maximum(one.noise_std, 1e-300)) + 1e-300))
    cycles = float(np.max(cycles_seen(one.modes, span[1] - span[0], nepers=nepers), initial=0.0))
    level = 20 * nepers / np.log(10)
    return Decay(
        start=span[0],
        stop=span[1],
        rank=rank,
        kind=DecayKind.STEP,
        level=float(level),
        cycles=cycles,
        strength=float(level + 20 * np.log10(max(cycles, 1e-3))),
        wn=one.modes.wn,
        zeta=one.modes.zeta,
        doubts=(),
    )
