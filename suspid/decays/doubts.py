"""What speaks against a stretch as a free decay, and what set it off."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from suspid.cleaning import CLIPPED, clipped_run, runs
from suspid.decays.bursts import Burst, Envelopes
from suspid.decays.trials import Trial, background_loudness
from suspid.identification import FEWEST_SAMPLES
from suspid.signals import Signal
from suspid.units import Decibel, RealArray, Second
from suspid.words import Reason

# At least one mode stands out of the background of its own band, so far below the threshold at most.
OWN_BAND: Decibel = 6.0
# More poles than these are no decay of a few modes; modes that explain less than this of the motion are not its cause.
MOST_POLES, EXPLAINED = 10, 0.5
# What grows beside a decay has less than this share of its energy.
GROWN = 0.1
# A decay whose rate is known no better than to this is none.
LEAST_KNOWN = 0.1
# What casts doubt: fewer cycles, and more of the motion left as something that is no white noise.
FEW_CYCLES, DRIVEN = 2.0, 0.03
# Modes that carry this share of the energy count; each wants so many samples of the band that rings.
STRONG, FEW_SAMPLES = 0.01, 40
# If so many stretches of a recording and more than half of all are refused, the others are in bad company.
MANY_REFUSED = 4
# A background so many times louder than white noise at a mode shakes the mode.
LOUD = 4.0
# The place of rest moves if by more than this share of the motion, together if by the same to this.
SHIFTED, ALIKE = 0.15, 0.1
# What comes before is taken over this long [s], at most; a spike stands so many times above what follows.
BEFORE, SPIKE = 1.0, 2.0

Kind = Literal["impulse", "step", "release", "step or release"]


def refused(trial: Trial) -> str | None:
    """Return why a stretch is no decay, or None if it is one."""
    if not len(trial.modes):
        others = sorted({str(reason) for reason in trial.selection.reasons if reason is not None})
        return "no mode decays after it" + (f" ({', '.join(others)})" if others else "")
    if trial.poles > MOST_POLES:
        return f"it takes {trial.poles} poles to follow it: it is no decay of a few modes"
    # A decay rate is known to about sqrt(2 / E), with E the energy over the variance of the noise.
    spread = float(np.sqrt(2 / np.max(trial.strengths)))
    if spread > LEAST_KNOWN:
        return f"its decay rate would be known to {100 * spread:.0f} % at best: too little stands above the noise"
    early = max(1, trial.motion.shape[1] // 3)
    motion = np.sum(trial.motion[:, :early] ** 2, axis=1)
    share = motion / (motion + np.sum(trial.residual[:, :early] ** 2, axis=1) + 1e-300)
    grown = np.sum(trial.growing**2, axis=1) / np.maximum(np.sum(trial.motion**2, axis=1), 1e-300)
    if grown[np.argmax(share)] > GROWN:
        return f"part of the motion grows, with {100 * grown[np.argmax(share)]:.0f} % of the energy: it is driven on"
    left = float(trial.left[np.argmax(share)])
    if left > EXPLAINED:
        return f"{100 * left:.0f} % of the motion is left over by modes that decay: it is driven on"
    if np.max(share) < EXPLAINED:
        return f"modes that decay explain {100 * np.max(share):.0f} % of it at most: it is driven on, or noise"
    return None


def fits(trial: Trial) -> bool:
    """Return whether a trial leaves neither more at its beginning than chance does nor motion that is no noise."""
    return trial.excess <= 1 and float(np.max(trial.left)) <= DRIVEN


def drowned(trial: Trial, found: Envelopes, start: Second) -> str | None:
    """Return why the modes of a stretch are no news: none stands out of the background of its own band."""
    highest = -np.inf
    for theta in trial.selection.fit.poles.pairs[trial.modes]:
        frequency = abs(theta) / (2 * np.pi * trial.step)
        band = int(np.argmin(np.abs(np.log(found.centres / frequency))))
        first, last = np.searchsorted(found.timepts, [start, start + 1 / min(frequency, found.centres[band])])
        highest = max(highest, float(np.max(found.levels[band, max(0, first - 1) : last + 1])))
    if highest < found.threshold - OWN_BAND:
        return f"what decays then is at most {highest:.0f} dB above the background of its own band"
    return None


def doubts_of(
    signal: Signal, trial: Trial, burst: Burst, cycles: float, begin: int, clipped: NDArray[np.bool_]
) -> tuple[str, ...]:
    """Return in words what casts doubt on a decay that starts at a sample."""
    doubts = []
    if cycles < FEW_CYCLES:
        doubts.append(f"{cycles:.1f} cycles are few")
    strong = trial.strengths >= STRONG * np.max(trial.strengths)
    count = trial.residual.shape[1]
    slowest = float(np.min(trial.selection.fit.poles.pairs[trial.modes][strong].imag))
    if slowest * count < 2 * np.pi * FEW_CYCLES:
        doubts.append(
            f"too short for its mode at {slowest / (2 * np.pi * trial.step):.3g} Hz, "
            f"which makes {slowest * count / (2 * np.pi):.1f} cycles in it"
        )
    if count < FEW_SAMPLES * len(trial.modes):
        doubts.append(f"{count} samples, at the rate of what rings, are few for {len(trial.modes)} modes")
    if trial.excess > 1:
        doubts.append(
            f"its first part is off by {100 * trial.early:.2g} % of the motion from any decay: "
            f"the forcing has not ended, or the motion is not linear"
        )
    left = trial.left
    if np.max(left) > DRIVEN:
        worst = int(np.argmax(left))
        doubts.append(
            f"still driven, or not linear: {100 * left[worst]:.2g} % of the motion of {signal.channels[worst]!r} is "
            f"left over, and that is no white noise"
        )
    if Reason.GROWING in trial.selection.reasons:
        doubts.append("still driven: part of the motion grows")
    if np.any(clipped):
        doubts.append(f"clipped in {int(np.sum(clipped))} samples")
    if begin == 0:
        doubts.append("the record begins with it: whether the forcing had ended cannot be seen")
    if burst.cut:
        doubts.append("cut off by what comes next, before it has sunk into the background")
    return tuple(doubts)


def doubts_of_company(refusals: int, looked: int) -> tuple[str, ...]:
    """Return the doubt that a recording in which most of what stands out is no decay was driven all the time."""
    if refusals < MANY_REFUSED or refusals <= 0.5 * looked:
        return ()
    return (
        f"{refusals} of {looked} stretches that stand out are no free decays: the recording may be driven all along, "
        f"and this one look like a decay by chance",
    )


def doubts_of_background(signal: Signal, trial: Trial, *, size: int, length: int) -> tuple[str, ...]:
    """Return the doubt that the background shakes the modes all the time, or nothing."""
    loud = background_loudness(signal.values, trial, size=size, length=length)
    worst = int(np.argmax(loud))
    if loud[worst] < LOUD:
        return ()
    frequency = trial.selection.fit.poles.pairs[trial.modes[worst]].imag / (2 * np.pi * trial.step)
    return (
        f"the background near {frequency:.3g} Hz is {10 * np.log10(loud[worst]):.0f} dB louder than white noise: it "
        f"shakes the decay too, and intervals that rest on white noise are too narrow",
    )


def kind_of(signal: Signal, trial: Trial, first: int, begin: int) -> Kind | None:
    """Return what set a decay off, where the places of rest before and after or a spike tell."""
    quiet = signal.values[:, max(0, first - int(BEFORE / signal.step)) : first]
    if quiet.shape[1] < FEWEST_SAMPLES:
        return None
    count = trial.residual.shape[1]
    after = signal.values[:, begin : begin + count * max(1, round(trial.step / signal.step))]
    swing = np.max(np.abs(trial.motion), axis=1)
    shift = np.mean(after, axis=1) - np.mean(trial.motion, axis=1) - np.mean(quiet, axis=1)
    spread = np.std(quiet, axis=1)
    moved = (np.abs(shift) > SHIFTED * swing) & (np.abs(shift) > 5 * spread)
    if np.any(moved):
        if np.sum(moved) < 2:
            return "step or release"
        size = np.abs(shift[moved])
        return "step" if np.ptp(shift[moved]) < ALIKE * np.max(size) else "release"
    forced = signal.values[:, first:begin]
    if forced.shape[1]:
        spike = np.max(np.abs(forced - np.mean(quiet, axis=1, keepdims=True)), axis=1)
        if np.any((spike > SPIKE * swing) & (spike > 10 * spread)):
            return "impulse"
    return None


def clipped_samples(values: RealArray) -> NDArray[np.bool_]:
    """Return which samples lie in a run at the largest or smallest value of a channel that clips there, (sample,)."""
    out = np.zeros(values.shape[1], bool)
    for samples in values:
        for largest in (True, False):
            run = clipped_run(samples, largest=largest)
            if run is not None:
                for first, after in zip(*runs(samples == samples[run[0]]), strict=True):
                    out[first:after] |= after - first >= CLIPPED
    return out
