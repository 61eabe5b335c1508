"""Codes and sentences: the ride of a car, and roads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from suspid.text_tables import figures_of
from suspid.words.remarks import Code, amount, in_a_row

Numbers: TypeAlias = Mapping[str, Any]


def listed(text: str) -> Callable[[Numbers], str]:
    """Return words with the names in place of ``{names}``, the last after an "and"."""
    return lambda numbers: text.format_map({**numbers, "names": in_a_row(numbers["names"])})


def plainly(text: str) -> Callable[[Numbers], str]:
    """Return words with a count in place of ``{times}`` and a value in place of ``{value}``, without exponents."""
    shown = {"times": amount, "value": figures_of}
    return lambda numbers: text.format_map(
        {name: shown[name](number) if name in shown else number for name, number in numbers.items()}
    )


def _driven(numbers: Numbers) -> str:
    road = f"class {numbers['class']} ({amount(1e6 * numbers['roughness'])}e-6 m3)"
    return f"ride at {numbers['speed']:.3g} m/s on a road of {road}"


def _comfort(numbers: Numbers) -> str:
    said = f"{numbers['channel']}: {' to '.join(numbers['words'])} ({numbers['weighted']:.2g} m/s2"
    return f"{said}, ISO 2631-1, C.2.3, as quoted in the literature)."


def _rest(numbers: Numbers) -> str:
    said = (
        f"At rest for {numbers['share']:.0%} of the time (below {numbers['limit']:g} m/s2 in blocks of a second), "
        f"included in all figures"
    )
    if numbers["share"] >= 1:
        return f"{said}: they show sensors and engine, not a ride."
    return f"{said}: over the driving time alone each rms is {numbers['factor']:.3g} times as large."


def _in_other_units(numbers: Numbers) -> str:
    """Return the units that may be meant, and what to do."""
    units = numbers["units"]
    likely = f"most likely it is in {' or '.join(units)}" if units else "most likely it is in counts or volts"
    return f"{likely}; state the unit in brackets after its name, or scale it"


def _gravity_in(numbers: Numbers) -> str:
    units = " or ".join(numbers["units"])
    return (
        f"{numbers['channel']}: the mean, {numbers['mean']:.4g}, is gravity in {units}, but the figures take it as "
        f"m/s2: state the unit in brackets after its name, or scale it."
    )


def _too_large(numbers: Numbers) -> str:
    return (
        f"{numbers['channel']}: {amount(numbers['weighted'])} {numbers['unit']} weighted is above "
        f"{numbers['limit']:g}, more than people survive: {_in_other_units(numbers)}."
    )


def _too_far(numbers: Numbers) -> str:
    return (
        f"{numbers['channel']}: a travel of {amount(numbers['peak'])} m is above {numbers['limit']:g} m, more than any "
        f"suspension has: {_in_other_units(numbers)}."
    )


def dampers_of_equal_work(numbers: Numbers) -> str:
    """Return which damper rates were taken in place of friction and curves."""
    rates = [f"{name} {amount(rate)} N s/m" for name, rate in zip(numbers["names"], numbers["damping"], strict=True)]
    return (
        f"Linearised at an amplitude of velocity of {numbers['amplitude']:g} m/s: dampers of equal work in place of "
        f"friction and curves, {in_a_row(rates)}."
    )


class RideHeadline(Code):
    """Headline of the result."""

    DRIVEN = "driven", _driven
    RECORDED = "recorded", "ride over a record of {seconds:.4g} s"


class RideCheck(Code):
    """Checks of the figures of a ride."""

    COMFORT = "comfort", _comfort
    CREST = (
        "crest",
        "{channel}: the crest factor, {crest:.1f}, is above {limit:.0f}: the weighted rms understates single shocks; "
        "use VDV (ISO 2631-1, 6.2).",
    )
    SHOCKS = (
        "shocks",
        "{channel}: VDV is {ratio:.2f} times the weighted rms and the fourth root of the duration, above {limit:.2f}: "
        "use VDV (ISO 2631-1, 6.3.3).",
    )
    LIFTS = (
        "lifts",
        plainly(
            "{wheel}: the total wheel load would be negative {times} times in {seconds:.4g} s. The wheel leaves the "
            "road there; the linear figures do not include this."
        ),
    )
    STOPS = (
        "stops",
        plainly(
            "{strut}: the travel reaches the stops {times} times in {seconds:.4g} s; the figures do not include the "
            "stops."
        ),
    )
    LONG_WAVES = (
        "long waves",
        "The road has no waves longer than {metres:.4g} m: motion below {hertz:.2g} Hz, which Wf includes, is missing.",
    )
    HIGH = (
        "high",
        "The record contains frequencies up to {held:.4g} Hz; {weighting} extends to {hertz:.4g} Hz. Motion above is "
        "missing.",
    )
    SHORT = (
        "short",
        "The record of {seconds:.3g} s is short for {weighting}, which starts at {hertz:.2g} Hz: the transient of "
        "the filter affects its figures. Twenty periods, {needed:.3g} s, are needed.",
    )
    HIDDEN = (
        "hidden",
        "{weighting} is left out: a record of {seconds:.3g} s does not resolve {low:g} to {high:g} Hz.",
    )
    CLIPPED = (
        "clipped",
        "{channel}: {samples} samples are clipped, at up to {largest:.3g} {unit} from the mean: the true rms, peaks, "
        "crest factor and doses are larger; use a sensor with a larger range.",
    )
    ROUNDED = (
        "rounded",
        "{channel}: its samples are multiples of {step:.2g} {unit}; rounding adds {share:.0%} or more to the mean "
        "square of {weighting}, more than the figure varies by chance: use a sensor or a range of finer steps.",
    )
    TOO_ROUGH = (
        "too rough",
        "G_d(n_0) = {roughness:.4g} m3 is above {limit:.3g} m3, twice that of class H, the roughest: check its unit; "
        "class C has 256e-6 m3.",
    )
    REST = "rest", _rest
    GRAVITY = "gravity", "{channel}: the mean, {mean:.4g} m/s2, is gravity; figures are about the mean."
    GRAVITY_IN = "gravity in", _gravity_in
    TOO_LARGE = "too large", _too_large
    TOO_SMALL = (
        "too small",
        "{channel}: {weighted:.2g} {unit} weighted is below {limit:g}, less than people feel and vehicle sensors "
        "resolve: check its unit and scale.",
    )
    TOO_FAR = "too far", _too_far
    CONVERTED = "converted", "{channel}: converted from {unit} to SI."
    NO_FIGURES = (
        "no figures",
        listed("No figures for {names}: the name of a travel must end in _travel, with its unit in brackets."),
    )
    NO_LENGTH = "no length", "{channel} is left out: its unit is not a length."
    WIDE = (
        "wide",
        listed(
            "The parameters are too uncertain for {names}: the ends of an interval differ by a factor above {ratio:g}."
        ),
    )
    EVENTS = (
        "events",
        listed(
            "The parameters are too uncertain to count events in {seconds:.4g} s: the interval of {names} extends "
            "from less than one to more, or beyond what is possible on a road."
        ),
    )
    UNTRUSTED = "untrusted", "The figures depend on an estimate that is {level}: read its verdict first."
    STAYED_NOMINAL = (
        "stayed nominal",
        listed(
            "The figures depend on nominal values that the records do not determine, because the motion of the "
            "wheels was given: {names}. State their error, or estimate them on a known or modelled road."
        ),
    )
    LINEARISED = "linearised", dampers_of_equal_work
    KNOWN = "known", listed("Taken as known, without any error in the intervals: {names}.")


class RoadHeadline(Code):
    """Headline of the result."""

    CLASS = "class", "road of class {name} of ISO 8608"


class RoadCheck(Code):
    """Checks of the class of a road."""

    CLASS = (
        "sure",
        "Class {name} has a probability of {share:.1%}, with the limits of ISO 8608 as quoted in the literature.",
    )
    NO_ROAD = (
        "no road",
        "G_d(n_0) = {roughness:.3g} m3 is more than twice that of class H, the roughest: check whether the heights are "
        "in m, and whether the channel is the road.",
    )
    NO_POWER_LAW = (
        "exponent",
        "The exponent, {exponent:.2f}, is outside the range of roads, {low:g} to {high:g}: the channel may not be a "
        "road, or it is filtered or noisy.",
    )
    BETWEEN = "between", listed("The class may be {names}: the interval contains a limit.")
    ONE_EVENT = (
        "one event",
        "The lines of the spectrum do not scatter as those of a random road do: the heights may show a single event, "
        "such as a step or a kerb, or waves of one length beyond those that are used.",
    )
    BENT = (
        "bent",
        "The spectrum is not a straight line (chi-square {chi_square:.3g} at {freedom}): the exponent is a mean over "
        "the band, and the intervals do not include the curvature.",
    )
