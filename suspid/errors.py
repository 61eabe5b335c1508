"""Errors and warnings. An error carries the best result found before it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from suspid.model import ModalSet, Suspension


class SuspidError(Exception):
    """Base of all errors that suspid raises."""


class InputError(SuspidError, ValueError):
    """A value cannot be used; the message says which, why, and what to do."""


class RecordError(InputError):
    """A record or its file cannot be used."""


class RecordWarning(UserWarning):
    """Something was repaired in a record while it was read, or was noticed and left as it is."""


class IdentificationError(SuspidError):
    """The requested modes could not be found.

    Attributes
    ----------
    found : ModalSet or None
        The modes that were found.
    """

    def __init__(self, message: str, *, found: ModalSet | None = None) -> None:
        super().__init__(message)
        self.found = found


class _NoSuspensionError(SuspidError):
    """No suspension explains what was measured.

    Attributes
    ----------
    best : Suspension or None
        The best suspension found.
    """

    def __init__(self, message: str, *, best: Suspension | None = None) -> None:
        super().__init__(message)
        self.best = best


class ReconstructionError(_NoSuspensionError):
    """No springs and dampers explain the modes; ``.best`` is the best suspension found, or None."""


class EstimationError(_NoSuspensionError):
    """The records do not determine the suspension, or none explains them; ``.best`` is the best one found, or None."""
