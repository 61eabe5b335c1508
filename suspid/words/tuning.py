"""Codes and sentences: better suspensions, and better curves of dampers."""

from __future__ import annotations

from suspid.words.remarks import Code, count, in_a_row, sentence
from suspid.words.ride import Numbers, dampers_of_equal_work, listed, plainly


def _front(numbers: Numbers) -> str:
    points, parameters = count(numbers["points"], "car"), in_a_row(numbers["parameters"])
    best = "best compromises" if numbers["points"] > 1 else "the best car"
    return f"{best} over {parameters}: {points}"


class TuningHeadline(Code):
    """Headline of the result."""

    FRONT = "front", _front


class TuningCheck(Code):
    """Checks of a tuning."""

    STARTS = "starts", "{share:.0%} of the {count} searches from other starts ended at the same values."
    UNFINISHED = "unfinished", "{count} of {points} points did not converge and were left out."
    AT_BOUND = (
        "at bound",
        plainly("{name} is at its {side} value, {value} {unit}, in {count} of {cars} cars: the bound is active."),
    )
    AT_REACH = (
        "at reach",
        plainly(
            "{name} is at the end of the search, {value} {unit}, in {count} of {cars} cars. The search covers a "
            "quarter to four times the car's own value by default; state the {side} value that can be built."
        ),
    )
    IDLE = (
        "idle",
        plainly("The limit {label} (SI units) is not active: the nearest of these cars has {value}."),
    )
    RELATED = "related", "The constraint {label} is active in {count} of {cars} cars."
    ROBUST = (
        "robust",
        listed(
            "Each figure is its mean plus {reach:.3g} times its standard deviation over what is uncertain: {names}."
        ),
    )
    LINEARISED = "linearised", dampers_of_equal_work
    ONE = "one", "One car is best for both objectives: there is no trade-off."


class DamperTuningHeadline(Code):
    """Headline of the result."""

    CURVE = "curve", sentence(lambda n: f"curve of {n['strut']} for {count(n['roads'], 'road')}")


class DamperTuningCheck(Code):
    """Checks of a damper's curve."""

    STARTS = "starts", "{share:.0%} of the searches from other starts ended at the same values."
    AT_BOUND = (
        "at bound",
        "The bound on the {side} damper rate, {rate:.4g} N s/m, is active on {count} of {roads} roads: state what "
        "can be built.",
    )
    NO_SINGLE = "no single", "No single damper rate within the bounds meets the limits on all roads."
    UNEVEN = (
        "uneven",
        "Rebound over compression is {ratio:.3g}: the car rides lower or higher on rough roads; the figures do not "
        "include this.",
    )
    GAUSSIAN = (
        "gaussian",
        "The figures are those of the damper rate of equal work; simulate the car with its curve for the peaks.",
    )
