"""Codes and sentences: the wear of dampers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeAlias

from suspid.words.remarks import MOST_LISTED, Code, count, in_a_row, sentence

Numbers: TypeAlias = Mapping[str, Any]

# What is assumed of the drives, by what the new estimate is compared with.
ASSUMED = {
    "nominal": "new dampers and springs differ from nominal by {nominal:.0%}, and from drive to drive dampers by "
    "{damper:.0%}, springs by {spring:.0%} and loads by {load:.0%} (standard deviations)",
    "earlier": "from drive to drive dampers differ by {damper:.0%}, springs by {spring:.0%} and loads by {load:.0%} "
    "(standard deviations)",
    "history": "the last drive differs from the earlier ones as these among themselves",
}


def _followed(numbers: Numbers, *, state: str) -> str:
    names = numbers["names"]
    others = len(names) - MOST_LISTED
    listed = [*names[:MOST_LISTED], f"{others} others"] if others > 1 else names
    return f"{count(len(names), 'damper')} {state}: {in_a_row(listed)}."


def _rates(numbers: Numbers) -> str:
    told = (
        "A damper that lost no more than {small:.0%} is called worn, and one that lost {large:.0%} or more good, in at "
        "most {rate:.2%} of such comparisons, if "
    )
    return f"{told.format_map(numbers)}{ASSUMED[numbers['against']].format_map(numbers)}."


class DamperState(Code):
    """State of a damper.

    Examples
    --------
    >>> [str(state) for state in DamperState]
    ['good', 'watch', 'worn', 'cannot tell']
    """

    GOOD = "good"
    WATCH = "watch"
    WORN = "worn"
    CANNOT_TELL = "cannot tell"


class WearHeadline(Code):
    """Headline for all dampers."""

    DAMPERS = "dampers", sentence(lambda numbers: in_a_row(numbers["texts"]))


class WearCheck(Code):
    """Checks of a damper."""

    LOST = "lost", "{damper}: lost {loss:.0%} of its damping, at least {low:.0%}."
    SOME = (
        "some lost",
        "{damper}: lost {loss:.0%} of its damping. The loss is significant, but may be less than {small:.0%} (at "
        "most {high:.0%}).",
    )
    HOLDS = (
        "holds",
        sentence(
            lambda n: (
                f"{n['damper']}: lost no more than {n['high']:.0%} of its damping."
                if n["high"] > 0
                else f"{n['damper']}: lost none of its damping."
            )
        ),
    )
    WIDE = (
        "wide",
        "{damper}: the loss is between nothing and {high:.0%}, too uncertain to tell a good damper from one that "
        "lost {large:.0%}. Drive longer, or give an earlier estimate in place of nominal values.",
    )
    GAINED = "gained", "{damper}: its damping rose by at least {gain:.0%}."
    SPRING = (
        "spring",
        "{damper}: its spring changed by {change:+.0%}, more than load and temperature explain. The interval of the "
        "loss covers both causes: a changed spring or a load that is not described.",
    )
    PHASE_PASSES = "phase passes", "{damper}: the least phase of {wheel}, {phase:.1f} deg, is above {limit:.0f} deg."
    PHASE_FAILS = (
        "phase fails",
        "{damper}: the least phase of {wheel}, {phase:.1f} deg, is certainly below {limit:.0f} deg.",
    )
    PHASE_NEAR = (
        "phase near",
        "{damper}: the least phase of {wheel}, {phase:.1f} deg, is not certainly above {limit:.0f} deg.",
    )
    PHASE_AS_BEFORE = (
        "phase as before",
        "{damper}: the least phase of {wheel}, {phase:.1f} deg, is below {limit:.0f} deg, as it was in the car it is "
        "compared with ({before:.1f} deg).",
    )
    BY_CURVE = (
        "by curve",
        "{damper}: compared by its curve, whose damping of equal work is {damping:.4g} N s/m at a velocity of "
        "{amplitude:.2g} m/s.",
    )
    FOLLOWS_LITTLE = (
        "follows little",
        "{damper}: the residual of its curve follows the motion by {share:.1%} of the damper's force; the interval of "
        "the loss contains that.",
    )
    BENT = (
        "bent",
        "{damper}: it is not viscous, and a nominal c holds at one amplitude only: here its damping of equal work is "
        "{damping:.4g} N s/m at {amplitude:.2g} m/s. Compare it with the curve of an earlier drive.",
    )
    UNTRUSTED = "untrusted", "The estimate {which} is {level}: dampers cannot be judged from it."
    NOT_USED = "not used", "The estimate {which} is {level} and was not used: the dampers are judged by their curves."
    RATES = "rates", _rates


class TrendHeadline(Code):
    """How many dampers were followed over their drives."""

    DAMPERS = "dampers", sentence(lambda n: f"{count(n['dampers'], 'damper')} followed over time")


class TrendCheck(Code):
    """Which dampers are in each state after their drives."""

    NOTHING = "no trend", "no trend: a vehicle needs at least four drives in which a damper was found"
    WORN = "worn", sentence(partial(_followed, state="worn"))
    WATCH = "watch", sentence(partial(_followed, state="to watch"))
    CANNOT_TELL = "cannot tell", sentence(partial(_followed, state="cannot be told from worn or good"))
    GOOD = "good", sentence(partial(_followed, state="good"))
