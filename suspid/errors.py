"""Errors and warnings. An error carries the best result found before it."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from suspid.model import ModalSet, Suspension


class SuspidError(Exception):
    """Base of all errors that suspid raises.

    Attributes
    ----------
    source : str
        The file or record that it is about, with which the message begins; empty where there is none.
    """

    source: str = ""

    @property
    def message(self) -> str:
        """What is wrong, without the name of the source."""
        return super().__str__()

    def __str__(self) -> str:
        return f"{self.source}: {self.message}" if self.source else self.message

    def about(self, source: str) -> Self:
        """Return this error with the name of its source, unless it has one.

        Examples
        --------
        >>> print(RecordError("is empty").about("bump.csv").about("test 1"))
        bump.csv: is empty
        """
        named = copy.copy(self)
        named.source = self.source or source
        return named


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
