"""Records that failed: the reason of each, as one row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from suspid.errors import EstimationError, IdentificationError, RecordError, SuspidError
from suspid.files import printable
from suspid.fleet.job import Job
from suspid.fleet.records import Entry, RefusedError, Seen
from suspid.fleet.tables import Rows
from suspid.words import Failure, Remark

# A reason longer than this [characters] is cut: some libraries put whole tables into their errors.
LONGEST_REASON = 600
CODES: Mapping[type[SuspidError], Failure] = {
    RecordError: Failure.UNUSABLE,
    IdentificationError: Failure.NOT_IDENTIFIED,
    EstimationError: Failure.NOT_ESTIMATED,
}


def failure(job: Job, entry: Entry, seen: Seen, why: Remark, checks: Sequence[str] = ()) -> Rows:
    """Return the rows of a record that failed: one, with the step, the code and the reason in words."""
    said = printable(" ".join(str(why).split()))
    said = said if len(said) <= LONGEST_REASON else said[: LONGEST_REASON - 1] + "…"
    row = {
        **which(job, entry, seen),
        "step": str(seen.step),
        "code": str(why.code),
        "checks": list(checks),
        "reason": said,
    }
    return Rows(failures=(row,), failed=1)


def which(job: Job, entry: Entry, seen: Seen) -> dict[str, object]:
    """Return the columns that say which record a row is of."""
    return {"record": entry.name, "sha256": seen.sha256, "suspid": job.environment["suspid"]}


def why_of(error: Exception) -> Remark:
    """Return an error as a code with the words of the error, without the path of the file: a copy has another."""
    if isinstance(error, RefusedError):
        return error.remark
    if isinstance(error, MemoryError):
        return Remark(Failure.MEMORY)
    if isinstance(error, SuspidError):
        code = next((code for kind, code in CODES.items() if isinstance(error, kind)), Failure.REFUSED)
        return Remark(code, {"why": error.message})
    said = isinstance(error, OSError) and error.strerror
    return Remark(Failure.UNEXPECTED, {"kind": type(error).__name__, "why": said or str(error)})
