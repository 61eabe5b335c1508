"""Codes and sentences: the grip of wheels on a test bench."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from suspid.words.remarks import Code, in_a_row, sentence
from suspid.words.ride import dampers_of_equal_work

Numbers: TypeAlias = Mapping[str, Any]


def _named(text: str) -> Callable[[Numbers], str]:
    """Return words with the names in place of ``{names}``, the last after an "and"."""
    return lambda numbers: text.format_map({**numbers, "names": in_a_row(numbers["names"])})


def _apart(low: object, high: object) -> str:
    """Return two ends with as many digits as show that they differ."""
    ends = (float(str(low)), float(str(high)))
    every = [tuple(f"{end:.{digits}f}" for end in ends) for digits in range(5)]
    return " to ".join(next((one for one in every if one[0] != one[1]), every[-1]))


class GripHeadline(Code):
    """Headline of the result."""

    GRIP = "grip", _named("grip of {names}")


class GripCheck(Code):
    """Checks of the grip of a wheel."""

    PASSES = "passes", "{wheel}: the least phase, {phase:.1f} deg, is above EGEA's limit of {limit:.0f} deg."
    FAILS = "fails", "{wheel}: the least phase, {phase:.1f} deg, is below EGEA's limit of {limit:.0f} deg."
    NEAR = (
        "near",
        "{wheel}: EGEA's limit of {limit:.0f} deg lies inside the interval of the least phase, {low:.1f} to {high:.1f} "
        "deg.",
    )
    BETWEEN_CLASSES = (
        "between classes",
        sentence(
            lambda n: (
                f"{n['wheel']}: the interval of the adhesion, {_apart(n['low'], n['high'])} %, reaches from "
                f"{n['worst']} to {n['best']}."
            )
        ),
    )
    STIFF = (
        "stiff",
        "{wheel}: the least phase lies at the wheel's resonance: the damper is so strong that a stronger one lowers "
        "the phase and a weaker one raises it.",
    )
    LIFTS = (
        "lifts",
        "{wheel}: the wheel leaves the platform near {hertz:.3g} Hz, where the linear force would be negative; its "
        "adhesion is 0.",
    )
    STAYED_NOMINAL = (
        "stayed nominal",
        _named(
            "Grip depends on nominal values that the records do not determine, because the motion of the wheels was "
            "given: {names}. State their error, or estimate them on a known or modelled road."
        ),
    )
    BEYOND = (
        "beyond sweep",
        "{wheel}: its resonance, {hertz:.3g} Hz, is above the sweep, which starts at {highest:.3g} Hz.",
    )
    AMPLITUDE = (
        "amplitude",
        "The platform moves by {amplitude:g} m; EUSAMA's classes hold for {usual:g} m.",
    )
    KNOWN = "known", _named("Taken as known, without any error in the intervals: {names}.")
    LINEARISED = "linearised", dampers_of_equal_work
    UNTRUSTED = "untrusted", "The estimate of the car is {level}: its verdict says why."
