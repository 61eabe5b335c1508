"""Other parts of a record, which are tried where what the search for decays led to is in question."""

from __future__ import annotations

from typing import TYPE_CHECKING

from suspid.analysis.between_rests import between_rests
from suspid.analysis.free_end import at_free_end
from suspid.analysis.from_release import from_release
from suspid.analysis.largest import of_largest
from suspid.analysis.later import from_later
from suspid.analysis.settings import Settings
from suspid.analysis.until_locked import until_locked
from suspid.analysis.used import Used
from suspid.identification import Identification

if TYPE_CHECKING:
    import control

# In the order in which they are tried.
OTHER_PARTS = (between_rests, until_locked, from_later, from_release, of_largest, at_free_end)
# What a smooth wave hides can only be where it has ended.
PARTS_AFTER_A_WAVE = (at_free_end,)


def other_part(
    record: control.TimeResponseData, stretch: Used, found: Identification, settings: Settings, *, wave: bool
) -> Used | None:
    """Return the first other part of a record that is better, with what is identified in it; None if there is none.

    ``found`` is what the search for decays led to, and whether that swells and fades as one smooth ``wave``.
    """
    parts = (part_of(record, stretch, found, settings) for part_of in (PARTS_AFTER_A_WAVE if wave else OTHER_PARTS))
    return next((part for part in parts if part is not None and part.identification is not None), None)
