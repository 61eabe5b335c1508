"""What can be said of the records of a fleet: the step at which one failed, and why."""

from __future__ import annotations

from suspid.words.remarks import Code


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
