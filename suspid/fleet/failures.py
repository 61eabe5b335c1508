"""Records that failed: the reason of each, as one row."""

from __future__ import annotations

from collections.abc import Sequence

from suspid.errors import EstimationError, IdentificationError, RecordError, SuspidError
from suspid.files import printable
from suspid.fleet.job import Job
from suspid.fleet.records import Entry, RefusedError, Seen
from suspid.fleet.tables import Rows
from suspid.words import Failure, Remark

# A reason longer than this [characters] is cut: some libraries put whole tables into their errors.
LONGEST_REASON = 600


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


def why_of(error: Exception, place: str) -> Remark:
    """Return an error as a code with the words of the error."""
    if isinstance(error, RefusedError):
        return error.remark
    if isinstance(error, MemoryError):
        return Remark(Failure.MEMORY)
    text = without(error.message if isinstance(error, SuspidError) else str(error), place)
    if isinstance(error, RecordError):
        return Remark(Failure.UNUSABLE, {"why": text})
    if isinstance(error, IdentificationError):
        return Remark(Failure.NOT_IDENTIFIED, {"why": text})
    if isinstance(error, EstimationError):
        return Remark(Failure.NOT_ESTIMATED, {"why": text})
    if isinstance(error, SuspidError):
        return Remark(Failure.REFUSED, {"why": text})
    return Remark(Failure.UNEXPECTED, {"kind": type(error).__name__, "why": text})


def without(text: str, place: str) -> str:
    """Return a message without the path of the file: the row has its name, and a copy has another path."""
    return text.replace(place, "the file") if place else text
