"""Decide for one event whether it is followed by a free decay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from suspid.decays.bursts import Burst
from suspid.decays.decay import FIT, Decay
from suspid.decays.doubts import COUNTING_SHARE, clipped_samples, doubts_of, doubts_of_background
from suspid.decays.envelopes import Envelopes
from suspid.decays.kinds import kind_of
from suspid.decays.predictions import at_rest_from, at_rest_until, released_at
from suspid.decays.refusals import Refusal, drowned, fits, refused
from suspid.decays.rests import decay_between, rests_until
from suspid.decays.starts import Start, find_start
from suspid.decays.trials import Trial, block_size, blocks_of, quiet_variance, tried, with_all_motion
from suspid.decays.verification import LATEST_START, verified
from suspid.levels import ROUNDING
from suspid.signals import Signal, block_means
from suspid.units import Decibel, RealArray
from suspid.values import frozen_real
from suspid.words import DecayDoubt, DecayKind, DecayRemark, Remark

# Most times that a band may rise again within an event; more often than that, the motion is driven. Two of them are
# this many periods of the highest band apart, because a decay needs some cycles.
MOST_AGAIN, LEAST_PERIODS = 3, 8.0
# Blows that bounce fall within this part of a decay. What rises later may be the same motion, which friction holds and
# lets go.
BOUNCES = 0.25
# Most blocks of the final fit, from the start that was found. More follow long decays further and cost time.
FINAL_BLOCKS = 2000

# Samples at rest before a decay that begins with a release.
LEAST_STILL = 2
# An event that fills most of the recording may decay after this share of it only.
LATEST_ALONE = 0.9

# The decays after an event, or the reasons why there are none.
Found: TypeAlias = tuple[tuple[Decay, ...], tuple[Remark, ...]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Channels:
    """Channels of a recording with what every event in them needs, found once."""

    signal: Signal  # the recording
    finest: RealArray  # (channel,): standard deviation of the rounding and quantisation error

    @cached_property
    def clipped(self) -> NDArray[np.bool_]:
        """Which samples are clipped, (sample,)."""
        return clipped_samples(self.signal.values)

    @cached_property
    def means(self) -> Callable[[int], RealArray]:
        """Means over blocks of some samples, (channel, block)."""
        return cache(partial(block_means, self.signal.values))

    @cached_property
    def quiet(self) -> Callable[[int, int], RealArray]:
        """Lower bounds of the variance of noise in the means over blocks of some samples, in stretches of some."""

        def of(size: int, blocks: int) -> RealArray:
            return quiet_variance(self.means(size), size=size, blocks=blocks, finest=self.finest)

        return cache(of)


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """A recording with what every event in it needs."""

    signal: Signal  # the recording
    bands: Envelopes  # power of its octave bands above the background
    finest: RealArray  # (channel,): standard deviation of the rounding and quantisation error

    def among(self, moving: NDArray[np.intp]) -> Channels:
        """Return some of the channels."""
        if len(moving) == len(self.signal.channels):
            return self._all
        part = replace(
            self.signal,
            values=frozen_real(self.signal.values[moving]),
            channels=tuple(self.signal.channels[channel] for channel in moving),
        )
        return Channels(signal=part, finest=self.finest[moving])

    @cached_property
    def _all(self) -> Channels:
        return Channels(signal=self.signal, finest=self.finest)


def decays_after(recording: Recording, burst: Burst) -> Found:
    """Return the decays after an event; another begins where a band rises again, unless a decay lasts through that."""
    out, remarks = examined(recording, burst, moved=True)
    if not burst.again or len(burst.again) > MOST_AGAIN:
        return out, remarks
    if out and out[0].start < burst.again[0]:
        return (out if _free_motion(out) else _hit_again(recording, burst, out[0]) or out), remarks
    for onset in reversed(burst.again):
        later, _ = examined(recording, replace(burst, onset=onset), moved=True)
        if later:
            out = later if not out or later[0].start < out[0].start else out
            break
    if not out:
        return (), remarks
    remarks = ()
    edges = [burst.onset, *(onset for onset in burst.again if onset <= out[0].start)]
    for onset, stop in pairwise(edges):
        if stop - onset > LEAST_PERIODS * burst.width:
            before, said = examined(recording, replace(burst, onset=onset, stop=stop, cut=True), moved=True)
            out, remarks = (*out, *before), (*remarks, *said)
    return out, remarks


def _hit_again(recording: Recording, burst: Burst, decay: Decay) -> tuple[Decay, ...]:
    """Return the decay after the last of several blows that begin a decay, if it is free motion; none if it is not.

    A hammer that bounces sets off one decay upon another.
    """
    latest = decay.start + BOUNCES * (decay.stop - decay.start)
    for onset in reversed([again for again in burst.again if again < latest]):
        later, _ = examined(recording, replace(burst, onset=onset), moved=True)
        if later and _free_motion(later):
            return later
    return ()


def _free_motion(decays: Sequence[Decay]) -> bool:
    return not any(doubt.code in FIT for decay in decays for doubt in decay.doubts)


def examined(recording: Recording, burst: Burst, *, moved: bool, alone: bool = False) -> Found:
    """Return the decay after an event, or the reason why there is none.

    Unless the start is ``moved``, the decay begins with the event. One that is ``alone`` has no background in the
    recording that it must rise above: what was before it drove the motion.
    """
    signal = recording.signal
    first = max(0, int(np.ceil((burst.onset - signal.start) / signal.step - 1e-6)))
    last = min(signal.values.shape[1], int(np.floor((burst.stop - signal.start) / signal.step + 1e-6)) + 1)
    end = last
    if last > first:
        last = first + at_rest_from(signal.values[:, first:last], recording.finest)
    released, rested = _rests(signal.values[:, first:last], recording.finest) if moved and last > first else (0, 0)
    first += released + rested
    # Channels that are constant in the second half, such as the road after a step, take no part.
    later = signal.values[:, first + (last - first) // 2 : last]
    moving = np.zeros(0, np.intp)
    if later.size:
        moving = np.flatnonzero(np.ptp(later, axis=1) > ROUNDING * np.max(np.abs(later), axis=1))
    chosen = recording.among(moving)
    part = chosen.signal
    size = min(block_size(signal.step, burst.top), max(1, (last - first) // 64))
    fills = alone or 2 * (last - first) > signal.values.shape[1]
    if fills and moving.size:
        size = with_all_motion(part.values[:, first:last], size)
    clipped = chosen.clipped
    start, doubt = Start(begin=first, trial=None), None
    if moving.size:
        # What drove the motion is no noise of a decay that is alone.
        least = chosen.finest**2 / size
        if not alone:
            least = chosen.quiet(size, blocks_of(last - first, size))
        if moved:
            finest, latest = chosen.finest, LATEST_ALONE if fills else LATEST_START
            start = find_start(part, least, burst, first, last, size, clipped, finest, latest=latest)
            start, doubt = _verified(part, start, last, size)
            start = replace(start, begin=start.begin + at_rest_until(part.values[:, start.begin : last], finest))
        if start.linear and (start.trial is not None or not moved):
            rest = part.values[:, start.begin : last]
            whole = tried(rest, step=signal.step, size=size, least=least, most=FINAL_BLOCKS)
            start = replace(start, trial=whole or start.trial)
    refusal = _refusal(recording, start, alone=fills)
    if start.trial is None or refusal is not None:
        if moved and moving.size:
            held = at_rest_until(part.values[:, first:last], recording.finest[moving])
            still = last < end or held > LEAST_STILL or released
            found = decay_between(part, first + held, last, level=burst.level) if still else None
            if found is not None:
                return (found,), ()
        code, numbers = refusal or (DecayRemark.TOO_SHORT, {})
        return (), (Remark(code, {"time": burst.onset, "level": burst.level, **numbers}),)
    if not moved and fits(start.trial):
        _, doubt = verified(part, start.trial, start.begin, last, size, moved=False)
    background = (
        () if alone else doubts_of_background(chosen.means(size), start.trial, size=size, length=last - start.begin)
    )
    doubts = (
        *doubts_of(part, start.trial, burst, _cycles(start.trial), start.begin, clipped[start.begin : last]),
        *background,
        *([doubt] if doubt is not None else []),
    )
    kind = kind_of(part, start.trial, first, start.begin) if moved else None
    return (_decay(part, start.trial, (start.begin, last), level=burst.level, kind=kind, doubts=doubts),), ()


def _rests(values: RealArray, finest: RealArray) -> tuple[int, int]:
    """Return the samples for which a mass is held still, or else for which it rests within noise."""
    released = released_at(values, finest)
    return (released, 0) if released else (0, rests_until(values))


def _verified(part: Signal, start: Start, last: int, size: int) -> tuple[Start, Remark | None]:
    """Return a start from which `identify` finds the same modes; one that is refused or doubted anyway stays."""
    if not start.linear and start.trial is not None:
        return start, Remark(DecayDoubt.NONLINEAR, {"share": start.trial.early})
    if start.trial is None or not fits(start.trial) or refused(start.trial) is not None:
        return start, None
    begin, doubt = verified(part, start.trial, start.begin, last, size, moved=True)
    return replace(start, begin=begin), doubt


def _refusal(recording: Recording, start: Start, *, alone: bool) -> Refusal | None:
    """Return the reason why there is no decay from a start, if there is one besides a missing fit.

    An event ``alone`` in the recording fills most of it: it is its own background.
    """
    if start.driven:
        return DecayRemark.DRIVEN, {}
    if start.trial is None:
        return None
    signal = recording.signal
    if alone:
        return refused(start.trial)
    return refused(start.trial) or drowned(start.trial, recording.bands, signal.start + signal.step * start.begin)


def _cycles(trial: Trial) -> float:
    """Return the most cycles of a mode that counts."""
    return float(np.max(trial.cycles[trial.strengths >= COUNTING_SHARE * np.max(trial.strengths)]))


def _decay(
    part: Signal,
    trial: Trial,
    samples: tuple[int, int],
    *,
    level: Decibel,
    kind: DecayKind | None,
    doubts: tuple[Remark, ...],
) -> Decay:
    theta = trial.selection.fit.poles.pairs[trial.modes] / trial.step
    order = np.argsort(np.abs(theta))
    cycles, energy = _cycles(trial), float(np.sum(trial.strengths))
    time = part.start + part.step * np.array([samples[0], samples[1] - 1])
    return Decay(
        start=float(time[0]),
        stop=float(time[1]),
        rank=0,
        kind=kind,
        level=level,
        cycles=cycles,
        strength=float(10 * np.log10(max(energy, 1e-30) * max(cycles, 1e-3) ** 2)),
        wn=frozen_real(np.abs(theta[order])),
        zeta=frozen_real(-theta[order].real / np.abs(theta[order])),
        doubts=doubts,
    )
