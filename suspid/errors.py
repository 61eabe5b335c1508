"""What can go wrong, each carrying what was found so far."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from suspid.model import ModalSet, Suspension


class SuspidError(Exception):
    """Every error that suspid raises on purpose."""


class InputError(SuspidError, ValueError):
    """A value that cannot be used; the message says which, why, and what to do."""


class RecordError(InputError):
    """A record, or the file that should hold one, that cannot be used."""


class RecordWarning(UserWarning):
    """What was repaired in a record as it was read, or was seen there and left alone."""


class IdentificationError(SuspidError):
    """Modes could not be found as asked.

    Attributes
    ----------
    found : ModalSet or None
        The modes that could be found.
    """

    def __init__(self, message: str, *, found: ModalSet | None = None) -> None:
        super().__init__(message)
        self.found = found


class ReconstructionError(SuspidError):
    """No springs and dampers explain the modes.

    Attributes
    ----------
    best : Suspension or None
        The nearest suspension met on the way.
    """

    def __init__(self, message: str, *, best: Suspension | None = None) -> None:
        super().__init__(message)
        self.best = best
