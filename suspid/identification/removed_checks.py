"""Checks of what was removed from a record with the fit, and is not among the modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.identification.considered import removed_as
from suspid.identification.mode_checks import check_of
from suspid.words import Check, Level, ModeCheck, Reason

if TYPE_CHECKING:
    from suspid.identification.identification import Identification

# As many tones that begin with a decay are no slow modes: faster ones would have been seen to decay.
MANY_TONES = 3


def check_tones(found: Identification) -> Iterator[Check]:
    """Check that no tone was removed with the fit: one that fades may be a mode."""
    tones = removed_as(found.considered, Reason.TONE)
    begun = [c.pole for c in tones if "begun" in c.remark.numbers]
    if len(begun) >= max(MANY_TONES, len(found.modes)):
        yield from _named(begun, ModeCheck.BEGUN_TONES, Level.DOUBTFUL)
    else:
        fading = [c.pole for c in tones if c.remark.numbers]
        # What moves more than all of the modes is what was recorded.
        largest = any(c.remark.numbers.get("largest") for c in tones)
        yield from _named(fading, ModeCheck.FADING_TONES, Level.DOUBTFUL if largest else Level.CARE)
    yield from _named([c.pole for c in tones if not c.remark.numbers], ModeCheck.STEADY_TONES, Level.NOTE)


def check_growing(found: Identification) -> Iterator[Check]:
    """Check that fewer pairs grow than there are modes: a free decay has none that do."""
    grows = [c.pole for c in removed_as(found.considered, Reason.GROWING) if c.pole.imag]
    if len(grows) >= len(found.modes):
        yield from _named(grows, ModeCheck.GROWING_BESIDE, Level.DOUBTFUL)


def check_removed(found: Identification, reason: Reason, check: ModeCheck, level: Level) -> Iterator[Check]:
    """Check that nothing was removed with the fit for a reason."""
    yield from _named([c.pole for c in removed_as(found.considered, reason)], check, level)


def check_too_many(found: Identification) -> Iterator[Check]:
    """Check that the search for modes did not end before all were found."""
    for one in found.considered:
        if one.remark.code is Reason.TOO_MANY:
            numbers = {"most": one.remark.numbers["most"], "hertz": in_hertz([one.pole])}
            yield check_of(ModeCheck.TOO_MANY, Level.DOUBTFUL, numbers)


def _named(poles: Sequence[complex], check: ModeCheck, level: Level) -> Iterator[Check]:
    if poles:
        yield check_of(check, level, {"number": len(poles), "hertz": in_hertz(poles)})


def in_hertz(poles: Sequence[complex]) -> str:
    """Return the frequencies of the first poles, to be named.

    Examples
    --------
    >>> in_hertz([-1 + 10j, -1 + 20j])
    '1.599, 3.187'
    """
    return ", ".join([f"{abs(pole) / (2 * np.pi):.4g}" for pole in poles[:4]] + ["…"] * (len(poles) > 4))


def check_dropped(found: Identification) -> Iterator[Check]:
    """Check that no significant pole was left out because fewer modes were asked for."""
    beyond = [abs(c.pole) / (2 * np.pi) for c in found.considered if c.remark.code is Reason.BEYOND]
    if beyond:
        hertz = ", ".join(f"{value:.4g}" for value in beyond)
        yield check_of(ModeCheck.DROPPED, Level.CARE, {"number": len(beyond), "hertz": hertz})
