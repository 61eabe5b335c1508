"""Doubts about a free decay."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning import CLIPPED, is_clipped, runs
from suspid.decays.bursts import Burst
from suspid.decays.refusals import DRIVEN
from suspid.decays.trials import Trial, background_ratio
from suspid.identification import CYCLES_SEEN
from suspid.signals import Signal
from suspid.units import RealArray
from suspid.words import DecayDoubt, Reason, Remark

# Fewer cycles than these, of the mode that makes most or of the slowest one, are doubted. One less than `CYCLES_SEEN`
# of an identification: this doubts the whole stretch, whose other modes may be well seen; that remarks on one mode.
DOUBTED_CYCLES = CYCLES_SEEN - 1
# Modes with this share of the energy of the strongest count. With a smaller share, traces of noise cast doubts. Less
# than `STRONG` of the verification: a mode this weak is in the fit, but other starts need not find it again.
COUNTING_SHARE = 0.01
# Blocks that each mode needs, about five cycles of the highest one.
FEW_BLOCKS = 40
# If at least this many events, and more than half of all examined, are no decays, the others are doubted. A lower
# number doubts drives with a few potholes between their bumps.
MANY_REFUSED = 4
# Ratio of the power of the background at a mode to that of white noise, from which it is said. Intervals that assume
# white noise are then too narrow by a factor of 2.
HIGH_BACKGROUND = 4.0


def doubts_of(
    signal: Signal, trial: Trial, burst: Burst, cycles: float, begin: int, clipped: NDArray[np.bool_]
) -> tuple[Remark, ...]:
    """Return the doubts about a decay that starts at sample ``begin``."""
    return (
        *_doubts_of_length(trial, cycles),
        *_doubts_of_fit(signal, trial),
        *([Remark(DecayDoubt.CLIPPED, {"samples": int(np.sum(clipped))})] if np.any(clipped) else []),
        *([Remark(DecayDoubt.AT_START)] if begin == 0 else []),
        *([Remark(DecayDoubt.CUT_OFF)] if burst.cut else []),
    )


def _doubts_of_length(trial: Trial, cycles: float) -> Iterator[Remark]:
    if cycles < DOUBTED_CYCLES:
        yield Remark(DecayDoubt.FEW_CYCLES, {"cycles": cycles})
    strong = trial.strengths >= COUNTING_SHARE * np.max(trial.strengths)
    blocks = trial.residual.shape[1]
    slowest = float(np.min(trial.selection.fit.poles.pairs[trial.modes][strong].imag)) / (2 * np.pi)
    if slowest * blocks < DOUBTED_CYCLES:
        yield Remark(DecayDoubt.TOO_SHORT, {"hertz": slowest / trial.step, "cycles": slowest * blocks})
    if blocks < FEW_BLOCKS * len(trial.modes):
        yield Remark(DecayDoubt.FEW_SAMPLES, {"samples": blocks, "modes": len(trial.modes)})


def _doubts_of_fit(signal: Signal, trial: Trial) -> Iterator[Remark]:
    if trial.excess > 1:
        yield Remark(DecayDoubt.FORCED, {"share": trial.early})
    worst = int(np.argmax(trial.left))
    if trial.left[worst] > DRIVEN:
        yield Remark(DecayDoubt.DRIVEN, {"share": float(trial.left[worst]), "channel": signal.channels[worst]})
    if Reason.GROWING in trial.selection.reasons:
        yield Remark(DecayDoubt.GROWING)


def doubts_of_company(refusals: int, looked: int) -> tuple[Remark, ...]:
    """Return the doubt that the recording is driven throughout, if most of its events are no decays."""
    if refusals < MANY_REFUSED or refusals <= 0.5 * looked:
        return ()
    return (Remark(DecayDoubt.COMPANY, {"refused": refusals, "examined": looked}),)


def doubts_of_background(means: RealArray, trial: Trial, *, size: int, length: int) -> tuple[Remark, ...]:
    """Return the doubt that the background excites the modes, if it is stronger than white noise at one of them."""
    ratio = background_ratio(means, trial, size=size, length=length)
    worst = int(np.argmax(ratio))
    if ratio[worst] < HIGH_BACKGROUND:
        return ()
    frequency = float(trial.selection.fit.poles.pairs[trial.modes[worst]].imag) / (2 * np.pi * trial.step)
    return (Remark(DecayDoubt.BACKGROUND, {"hertz": frequency, "decibel": float(10 * np.log10(ratio[worst]))}),)


def clipped_samples(values: RealArray) -> NDArray[np.bool_]:
    """Return which samples are clipped: in a run at an end of the range of their channel, (sample,)."""
    out = np.zeros(values.shape[1], bool)
    for samples in values:
        if not is_clipped(samples):
            continue
        # A range has two ends: runs at the other one are clipped too, however they are left.
        for limit in (np.max(samples), np.min(samples)):
            for first, after in zip(*runs(samples == limit), strict=True):
                out[first:after] |= after - first >= CLIPPED
    return out
