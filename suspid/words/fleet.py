"""Codes and sentences: the records of a fleet: the step at which one failed, and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from suspid.words.remarks import Code, count, sentence


class Step(Code):
    """Where a record failed."""

    READ = "read", "reading"
    FIND_DECAYS = "find decays", "finding decays"
    IDENTIFY = "identify", "identifying"
    RECONSTRUCT = "reconstruct", "reconstructing"
    FIND_STRETCHES = "find stretches", "finding usable stretches"
    ESTIMATE = "estimate", "estimating"
    WORK = "work", "in its worker process"


class Failure(Code):
    """Why a record has no modes, or no springs and dampers; of a drive, no usable stretch."""

    NOT_A_RESPONSE = "not a response", "expected a response or a path, not {kind}"
    CHANGED = "changed", "the file changed after it was listed: from {then} to {now} bytes"
    NOT_FOUND = "not found", "there is no such file"
    UNUSABLE = "unusable record", "{why}"
    REFUSED = "refused", "{why}"
    NOT_IDENTIFIED = "not identified", "{why}"
    NO_MODE = "no mode", "{why}"
    NO_SPRINGS = "no springs", "{why}"
    NO_STRETCH = "no stretch", "{why}"
    NOT_ESTIMATED = "not estimated", "{why}"
    UNEXPECTED = "unexpected error", "{kind}: {why}"
    MEMORY = "out of memory", "there was not enough memory for this record"
    TIME = "time limit", "took longer than {limit:g} s"
    TIME_NATIVE = "time limit in native code", "took longer than {limit:g} s, in native code that cannot be interrupted"
    WORKER_DIED = (
        "worker died",
        "its process died {times} times ({how}): out of memory, or a crash in native code",
    )
    WORKER_LOST = "worker lost", "{times} workers were lost over its chunk: {why}"


def _identified(numbers: Mapping[str, Any]) -> str:
    return f"results of {numbers['identified']} of {count(numbers['records'], 'record')}"


def _doubtful(numbers: Mapping[str, Any]) -> str:
    one = numbers["doubtful"] == 1
    return f"{count(numbers['doubtful'], 'result')} {'is' if one else 'are'} doubtful or missing"


def _changes(numbers: Mapping[str, Any]) -> str:
    return f"{count(numbers['changes'], 'significant change')} over time in {count(numbers['trends'], 'trend')}."


class FleetHeadline(Code):
    """How many records of a fleet gave a result."""

    RESULTS = "results", _identified


class FleetCheck(Code):
    """Checks of the results of a fleet."""

    NOTHING = "no result", "No record gave a result."
    NOT_ENDED = "not ended", "The run is not complete: these are the records done so far."
    FAILED = "failed", sentence(lambda n: f"{count(n['failed'], 'record')} failed.")
    NO_FAILURE = "no failure", "No record failed."
    DOUBTFUL = "doubtful", sentence(lambda n: f"{_doubtful(n)}.")
    CARE = (
        "care",
        sentence(lambda n: f"{count(n['care'], 'record')} to be used with care: the table of doubts says why."),
    )
    UNPLACED = (
        "unplaced",
        sentence(lambda n: f"{count(n['unplaced'], 'record')} without vehicle and date: not in any trend."),
    )
    UNTRUSTED = (
        "untrusted",
        sentence(lambda n: f"{count(n['untrusted'], 'drive')} with doubtful dampers: not in the trends of dampers."),
    )
    CHANGES = "changes", _changes
    DAMPERS = "dampers", sentence(lambda n: f"{count(n['worn'], 'worn damper')} of {n['dampers']} followed over time.")
    OUTLIERS = "outliers", sentence(lambda n: f"{count(n['outliers'], 'value')} far from the median of the fleet.")
