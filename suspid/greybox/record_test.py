"""A record of a suspension in a test, with what was done in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from suspid.cleaning import RecordLike
from suspid.model import added_masses
from suspid.units import Kilogram


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RecordTest:
    """One record of a suspension in a test, with what was done in that test.

    Parameters
    ----------
    record : control.TimeResponseData, or what `as_record` takes
        Measured motions as outputs, causes as inputs or outputs.
    given : sequence of str, optional
        Causes in this test, if not those of all tests; see `estimate`.
    added_masses : mapping of str to float
        Mass [kg] (or moment of inertia [kg m2]) added at each coordinate, such as a driver or a bag of sand.
    logger : str, optional
        What recorded it. Where motion is given, records of one logger, such as stretches of one drive, share gains,
        delays and noise levels. Default: each record has its own.

    Raises
    ------
    InputError
        If an added mass is not a finite number >= 0.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0, 2, 0.01)
    >>> loaded = RecordTest(record=(t, np.cos(9 * t)), added_masses={"chassis": 75.0})
    >>> loaded.added_masses["chassis"]
    75.0
    """

    record: RecordLike
    given: Sequence[str] | None = None
    added_masses: Mapping[str, Kilogram] = field(default_factory=dict)
    logger: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "added_masses", added_masses(self.added_masses))
