"""Codes and sentences: springs, dampers and masses found from modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from suspid.wording import Argument
from suspid.words.remarks import Code, count, in_a_row, sentence

Numbers: TypeAlias = Mapping[str, Any]


def _listed(text: str) -> Callable[[Numbers], str]:
    """Return words with the names in place of ``{names}``, joined by commas."""
    return lambda numbers: text.format_map({**numbers, "names": ", ".join(numbers["names"])})


def _split_by_nominal(numbers: Numbers) -> str:
    names = numbers["names"]
    if len(names) == 1:
        return f"{names[0]} is known from the nominal values alone"
    return (
        f"{in_a_row(names)} are determined by the nominal values alone: the modes do not determine "
        f"{numbers['combinations']}"
    )


def _linear(numbers: Numbers) -> str:
    unique = " (unique solution)" if numbers["unique"] else ""
    return f"linear convex fit of poles and shapes{unique}" + ", then refined" * (not numbers["exact"])


def _chi_square(numbers: Numbers) -> str:
    freedom, value = numbers["freedom"], numbers["chi_square"]
    return f"chi-square {value if value > 1e-6 else 0:.3g} at {count(freedom, 'degree')} of freedom"


def _acting(numbers: Numbers) -> str:
    names = numbers["names"]
    return f"active constraint{'s' * (len(names) > 1)}: {'; '.join(names)}"


def _mass(numbers: Numbers) -> str:
    error = numbers["error"]
    what = f"the mass of {numbers['name']} being {abs(error):.1%} {'larger' if error > 0 else 'smaller'} than given"
    return f"{what} would explain the modes (chi-square {numbers['chi_square']:.3g} at {numbers['freedom']})"


def _others(numbers: Numbers) -> str:
    number = numbers["count"]
    have = "has" if number == 1 else "have"
    said = f"{count(number, 'other set')} of springs and dampers {have} the same modes"
    chosen = "; nearness to the nominal car alone decides which comes first" * bool(numbers.get("by_nominal"))
    return f"{said}{chosen}: see what distinguishes them."


def _found(numbers: Numbers) -> str:
    parameters = numbers["parameters"]
    return f"{count(parameters, 'parameter')} of the car found"


class ReconstructionHeadline(Code):
    """Headline of the result."""

    FOUND = "found", _found


class ReconstructionNote(Code):
    """How a suspension was found, and what to know about it."""

    LINEAR = "linear fit", _linear
    SEQUENCE = "sequence of fits", "sequence of convex fits of {data}"
    POLE_ERROR = "pole error", "largest relative pole error {residual:.1e}"
    CHANNEL_UNKNOWN = (
        "channel unknown",
        "shapes not used: channel {channel!r} is not a coordinate, its velocity or acceleration, or the travel of a "
        "strut; rename it to use them",
    )
    CHANNEL_TWICE = "channel twice", "shapes not used: channel {channel!r} occurs more than once"
    ONE_CHANNEL = "one channel", "shapes not used: one channel has none"
    POLES_MEET = "poles meet", "shapes not used: poles coincide (critical damping), and their shapes with them"
    NOT_WEIGHTED = "not weighted", "not weighted: the covariance is for the poles only, and they are too few"
    WHOLE_BY_NOMINAL = (
        "scale by nominal",
        "the common scale of masses, stiffnesses and dampings is known from the nominal values alone",
    )
    SPLIT_BY_NOMINAL = "split by nominal", _split_by_nominal
    UNSEEN = (
        "chosen by penalty",
        _listed("{names}: determined by the penalty, not by the modes; no intervals"),
    )
    LEAST_MAC = "least MAC", "least MAC of the shapes {mac:.4f}"
    VANISHED = (
        "vanished",
        sentence(
            lambda numbers: (
                f"{', '.join(numbers['names'])} at the smallest positive value: the best fit has none; check the "
                f"topology, or fix it with {Argument('fixed', '…')}"
            )
        ),
    )
    AT_BOUND = "at bound", _listed("at its bound: {names}")
    ACTIVE = "active constraints", _acting
    PENALTY = "penalty", "penalty {penalty:.3g}"
    NOT_SHARP = "not sharp", "no sharp optimum: a further step would reduce the squared residual by {share:.1e} of it"
    FEW_DIGITS = (
        "few digits",
        sentence(
            lambda numbers: (
                f"the modes have few digits and are taken as known to {numbers['known_to']:.1%}; set "
                f"{Argument('tolerance', '…')} to change that"
            )
        ),
    )
    NEAR_MISS = (
        "near miss",
        sentence(
            lambda numbers: (
                f"another suspension comes within {numbers['distance']:.1e} of these modes: give their uncertainty, or "
                f"{Argument('tolerance', '…')}, to have it judged"
            )
        ),
    )
    CHI_SQUARE = "chi-square", _chi_square
    MISFIT = "misfit", "the modes are reproduced to {misfit:.1e} rms (shapes to ten times that)"
    UNEXPLAINED = (
        "unexplained",
        "this topology does not explain these modes: standard deviations are widened {widening:.3g} times",
    )
    BEYOND_TOLERANCE = (
        "beyond tolerance",
        "this topology does not explain these modes: the misfit exceeds the tolerance of {tolerance:.1%}",
    )


class Suspect(Code):
    """What would explain modes that the suspension as described does not."""

    GAIN = (
        "gain",
        "a gain of {gain:.3f} of channel {name} would explain the modes (chi-square {chi_square:.3g} at {freedom})",
    )
    MASS = "mass", _mass
    CHANNEL = "channel", "most of chi-square comes from channel {name}: without it, {chi_square:.3g} at {freedom}"
    MODE = "mode", "most of chi-square comes from mode {name}: without it, {chi_square:.3g} at {freedom}"


class ReconstructionCheck(Code):
    """Checks of a suspension that was found."""

    EXPLAINS = (
        "explains",
        "With the springs and dampers found, the car explains the modes within their uncertainty (chi-square "
        "{chi_square:.3g} at {freedom}).",
    )
    WITHIN_TOLERANCE = "within tolerance", "The modes are reproduced to {misfit:.1e} rms, within the tolerance."
    UNEXPLAINED = (
        "unexplained",
        "This car, with its masses, does not explain the modes within their uncertainty with any springs and dampers.",
    )
    NOT_JUDGED = (
        "not judged",
        "There are as many unknowns as equations: whether the car explains the modes is not tested.",
    )
    NO_UNCERTAINTY = "no uncertainty", "The modes state no uncertainty, so springs and dampers have no intervals."
    ALTERNATIVES = "alternatives", _others
    CHANNEL_UNKNOWN = (
        "channel unknown",
        "Shapes were not used: channel {channel!r} is neither a coordinate of the car, its velocity or acceleration, "
        "nor the travel of a strut.",
    )
    NO_ALTERNATIVES = "no alternatives", "No other set of springs and dampers with these modes was found."
    NEAR_MISS = "near miss", "Another set of springs and dampers comes within {distance:.1e} of these modes."
    OTHER_UNITS = (
        "other units",
        "Springs are {factor:.2g} times the nominal ones: check whether masses are in kg (1 t is 1000 kg) and nominal "
        "stiffness in N/m (1 N/mm is 1000 N/m).",
    )
    NOT_SEARCHED = "not searched", "Other sets of springs and dampers were not looked for."
    VANISHED = "vanished", _listed("The best fit has no {names}: the topology may be wrong.")
    AT_BOUND = "at bound", _listed("At its bound: {names}.")
    ACTIVE = (
        "active constraints",
        _listed("Active constraints, which determine the result together with the modes: {names}."),
    )
    PENALTY = "penalty", "The penalty biases the parameters; the intervals do not contain this bias."
    BY_NOMINAL = "by nominal", _listed("Known from the nominal values alone: {names}.")
    NOT_SHARP = "not sharp", "The optimum is not sharp: a further step would still reduce the squared residual."
    CHANGED = (
        "changed",
        _listed("Significantly different from nominal (5 % level for all parameters together): {names}."),
    )
    UNCHANGED = "unchanged", "No parameter differs significantly from nominal (5 % level for all together)."
    VAGUE = "vague", _listed("Poorly determined (95 % interval wider than the value): {names}.")
