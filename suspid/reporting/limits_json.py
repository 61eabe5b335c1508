"""Limits that were judged, as JSON: a part of the JSON of reports and of estimates."""

from __future__ import annotations

from suspid.analysis import SCALES, CheckedLimits


def limits_to_dict(checked: CheckedLimits | None) -> list[dict[str, object]] | None:
    """Return limits as plain numbers in the units that they were given in; None where none were given."""
    if checked is None:
        return None
    return [
        {
            "name": row.limit.name,
            "near_hz": row.limit.near,
            "unit": next(iter(SCALES[row.limit.quantity])),
            "least": row.limit.least,
            "most": row.limit.most,
            "value": row.value,
            "lower": row.lower,
            "upper": row.upper,
            "state": str(row.state),
            "why": None if row.why is None else row.why.to_dict(),
        }
        for row in checked.rows
    ]
