"""Reactions of people to a weighted acceleration."""

from __future__ import annotations

from suspid.words import Check, Level, Remark
from suspid.words.ride import RideCheck

# ISO 2631-1, C.2.3: reactions to weighted accelerations in public transport, from … to [m/s2]. They overlap. Taken from
# publications that quote the standard, not from the standard itself.
REACTIONS = (
    ("not uncomfortable", 0.0, 0.315),
    ("a little uncomfortable", 0.315, 0.63),
    ("fairly uncomfortable", 0.5, 1.0),
    ("uncomfortable", 0.8, 1.6),
    ("very uncomfortable", 1.25, 2.5),
    ("extremely uncomfortable", 2.0, float("inf")),
)


def reaction(channel: str, weighted: float) -> Check:
    """Return the reaction to a weighted acceleration after ISO 2631-1."""
    words = tuple(word for word, low, high in REACTIONS if low <= weighted <= high)
    return Check(Remark(RideCheck.COMFORT, {"channel": channel, "words": words, "weighted": weighted}), Level.NOTE)
