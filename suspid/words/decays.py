"""Codes and sentences: the free decays in a recording, and of the events that are none."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from suspid.wording import Argument, moment
from suspid.words.remarks import Code, Number, count, percent, sentence


def _percent(share: Number) -> str:
    """Return a share as a percentage of two digits; above twice the whole as a multiple of it."""
    assert isinstance(share, float)
    # A share above it is said as a multiple.
    if share > 2.0:
        return f"{share:.2g} times the size"
    return percent(share)


def _event(numbers: Mapping[str, Number]) -> str:
    return f"t = {moment(float(str(numbers['time'])))} s, {numbers['level']:.0f} dB above the background: "


def _names(names: Number, form: str = "") -> str:
    assert isinstance(names, tuple)
    return ", ".join(format(name, form) for name in names)


def _driven(numbers: Mapping[str, Number]) -> str:
    share, channel = numbers["share"], numbers["channel"]
    assert isinstance(share, float)
    if share > 2.0:
        return (
            f"{channel!r} hardly decays with the others: {share:.2g} times the power of its decaying part remains as a "
            f"coloured residual; if it is a force or a road, leave it out ({Argument('without')})"
        )
    return f"{_percent(share)} of the motion of {channel!r} remains as a coloured residual: still driven, or nonlinear"


class DecayKind(StrEnum):
    """What started a decay."""

    IMPULSE = "impulse"
    STEP = "step"
    RELEASE = "release"
    STEP_OR_RELEASE = "step or release"


class DecayDoubt(Code):
    """Doubts whether a stretch is a free decay."""

    FEW_CYCLES = "few cycles", "only {cycles:.1f} cycles"
    TOO_SHORT = "too short", "too short for the mode at {hertz:.3g} Hz: {cycles:.1f} cycles of it"
    FEW_SAMPLES = (
        "few samples",
        sentence(
            lambda n: (
                f"the quick fit has only {n['samples']} means over samples for {count(int(str(n['modes'])), 'mode')}"
            )
        ),
    )
    FORCED = (
        "forced",
        sentence(
            lambda n: (
                f"the first part deviates from a free decay by {_percent(n['share'])} of the motion: the excitation "
                f"still acts, or the motion is nonlinear"
            )
        ),
    )
    DRIVEN = (
        "driven",
        _driven,
    )
    NONLINEAR = (
        "nonlinear",
        sentence(
            lambda n: (
                f"the residual of damped exponentials is {_percent(n['share'])} of the motion: friction, clearance "
                f"or another nonlinearity, or a force that still acts"
            )
        ),
    )
    LATER = (
        "later",
        "the motion decays from {first:.6g} s on, but no fit explains it before {start:.6g} s: an excitation still "
        "acts, modes die soon, or frequency or damping change there",
    )
    SWELLS = (
        "swells",
        "the motion swells to its largest and fades as one smooth wave, as after a force at a natural frequency that "
        "ends, but a swept sine or a modulated tone looks the same",
    )
    GROWING = "growing", "part of the motion grows: still driven"
    CLIPPED = "clipped", sentence(lambda n: f"{count(int(str(n['samples'])), 'sample')} clipped")
    AT_START = "at start", "the decay starts at the first sample, so the excitation may still be acting"
    CUT_OFF = "cut off", "the next event begins before the decay has reached the background"
    COMPANY = (
        "company",
        "{refused} of {examined} events are not free decays with its modes: the recording may be driven throughout, "
        "and this decay may be a coincidence",
    )
    SMALL_PART = (
        "small part",
        sentence(
            lambda n: (
                f"{_percent(n['share'])} of the motion of the recording is in this decay: the recording may be driven "
                f"throughout, and the fit may be a coincidence"
            )
        ),
    )
    BACKGROUND = (
        "background",
        "the background near {hertz:.3g} Hz is {decibel:.0f} dB above white noise: it excites the mode during the "
        "decay, and intervals that assume white noise are too narrow",
    )
    NOT_IDENTIFIED = "not identified", "identify fails on this stretch: {error}"
    MODES_MISSING = (
        "modes missing",
        sentence(lambda n: f"identify finds no mode at {_names(n['hertz'], '.3g')} Hz in this stretch"),
    )
    HIGH_RESIDUAL = (
        "high residual",
        "identify leaves a residual {decibel:.0f} dB above white noise near the modes: still driven, or nonlinear",
    )


class DecayRemark(Code):
    """What was found in a recording, and why an event is no free decay."""

    FOUND = "found", sentence(lambda n: f"{count(int(str(n['decays'])), 'free decay')} found")
    NONE = "none", "no free decay found"
    NO_EVENT = (
        "no event",
        "No event found: the level peaks at {level:.1f} dB above the background (t = {time:.6g} s); steady noise "
        "reaches {threshold:.1f} dB.",
    )
    NOT_ALL = (
        "not all",
        "{found} events found; the {examined} strongest were examined. Cut the recording, or give the stretches, to "
        "examine the others.",
    )
    DRIVEN = "driven", sentence(lambda n: f"{_event(n)}driven motion; no sum of damped exponentials fits it.")
    TOO_SHORT = "too short", sentence(lambda n: f"{_event(n)}too short for a decay.")
    NO_MODE = (
        "no mode",
        sentence(lambda n: f"{_event(n)}no decaying mode" + (f" ({_names(n['others'])})" if n["others"] else "") + "."),
    )
    MANY_POLES = (
        "many poles",
        sentence(
            lambda n: f"{_event(n)}{n['poles']} poles needed, more than the {n['most']} of a decay of a few modes."
        ),
    )
    WEAK = (
        "weak",
        sentence(
            lambda n: (
                f"{_event(n)}what decays is too weak beside the rest; its decay rate would be known to "
                f"{_percent(n['share'])} at best."
            )
        ),
    )
    GROWING = (
        "growing",
        sentence(lambda n: f"{_event(n)}driven; growing motion holds {_percent(n['share'])} of the energy."),
    )
    LEFT_OVER = (
        "left over",
        sentence(
            lambda n: f"{_event(n)}driven; the residual of decaying modes is {_percent(n['share'])} of the motion."
        ),
    )
    UNEXPLAINED = (
        "unexplained",
        sentence(
            lambda n: (
                f"{_event(n)}driven, or noise; decaying modes explain at most {_percent(n['share'])} of the motion."
            )
        ),
    )
    DROWNED = (
        "drowned",
        sentence(
            lambda n: f"{_event(n)}no mode rises more than {n['most']:.0f} dB above the background of its own band."
        ),
    )
