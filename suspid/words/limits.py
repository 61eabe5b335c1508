"""Codes and sentences: limits on modes, springs and dampers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from suspid.words.remarks import Code, count, sentence


def _judged(numbers: Mapping[str, Any]) -> str:
    parts = [f"{numbers['met']} of {count(numbers['limits'], 'limit')} met"]
    if numbers["missed"]:
        parts.append(f"{numbers['missed']} not met")
    if numbers["open"]:
        parts.append(f"{numbers['open']} undecided")
    return ", ".join(parts)


def _interval(numbers: Mapping[str, Any]) -> str:
    tests = numbers["tests"]
    more = f": about {tests} such tests joined would decide" if 1 < tests <= 100 else ""
    return f"its interval contains the limit{more}"


class LimitHeadline(Code):
    """How many limits are met."""

    JUDGED = "judged", _judged


class LimitState(Code):
    """Whether a limit is met: the whole interval lies within it, or outside, or neither."""

    MET = "met", "{name} is within its limit."
    MISSED = "not met", "{name} is outside its limit."
    OPEN = "cannot tell", "{name}: {why}."


class LimitReason(Code):
    """Why a limit cannot be judged."""

    INTERVAL = "interval", _interval
    NO_INTERVAL = "no interval", "the value has no interval"
    HELD = "held", "fixed at its nominal value, not estimated"
    NO_SPRINGS = "no springs", "no springs and dampers were found"
    NO_MODE = "no mode", sentence(lambda n: f"there is no mode {n['which']} among the {n['found']} found")
    DOUBTFUL = "doubtful", "the result is doubtful"
    UNEXPLAINED = "unexplained", "the car does not explain what it was found from"
    ALTERNATIVE = "alternative", "other springs and dampers that explain the data as well lie on the other side"
