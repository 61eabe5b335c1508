"""Combinations of the unknowns that the records do not determine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.errors import EstimationError
from suspid.levels import EXACT
from suspid.model import Suspension
from suspid.units import RealArray
from suspid.wording import Argument

# Standard deviation above which a combination of unknowns counts as undetermined: springs and masses in their logarithm
# (a factor of e), dampers in units of a nearly critical one.
UNDETERMINED = 1.0
NEXT_TO_NOTHING = 1e-3  # of what 1 means of an unknown: shares of smaller values would be all that is named
NAMED_SHARE = 0.05  # of a combination: below it a parameter is not named


def blind(slope: RealArray) -> RealArray:
    """Return the combinations of unknowns that data do not determine, (combination, unknown).

    ``slope`` is in standard deviations per size of each unknown, (row, unknown).

    Examples
    --------
    >>> blind(np.array([[50.0, -50.0], [0.1, 0.1]])).round(3)
    array([[0.707, 0.707]])
    """
    _, values, directions = np.linalg.svd(slope, full_matrices=True)
    values = np.append(values, np.zeros(len(directions) - len(values)))
    found = directions[(values < 1 / UNDETERMINED) | (values < EXACT * values[0])]
    largest = np.argmax(np.abs(found), axis=1) if len(found) else np.zeros(0, int)
    return np.asarray(found * np.sign(np.take_along_axis(found, largest[:, None], axis=1)))


def names_in(directions: RealArray, labels: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the unknowns that take part in directions."""
    weight = np.linalg.norm(directions, axis=0)
    return tuple(label for label, w in zip(labels, weight, strict=True) if w > NAMED_SHARE)


def check_determined(
    slope: RealArray,
    labels: Sequence[str],
    car: Suspension,
    *,
    relative: RealArray,
    hint: Sequence[str | Argument] = (),
) -> None:
    """Raise if data and nominal values leave a combination of the unknowns open.

    ``relative`` is what 1 changes of each unknown, relative to its value; see `shares_of`.

    Raises
    ------
    EstimationError
        With the names, the combinations as relative changes, after a hint.
    """
    open_ = blind(slope)
    if not len(open_):
        return
    names = names_in(open_, labels)
    masses = [name for name in names if name.endswith(".mass")]
    scale = "; only ratios to a known mass (or to a given force) can be found" if masses else ""
    raise EstimationError(
        *hint,
        f"the records do not determine {', '.join(names)}: {len(open_)} of {len(labels)} combinations of the "
        f"unknowns do not change any channel by more than its noise "
        f"({'; or '.join(_in_words(o * relative, labels) for o in open_)}){scale}; fix one with ",
        Argument("fixed", "…"),
        ", state ",
        Argument("nominal_std", "…"),
        ", or measure at more coordinates",
        best=car,
    )


def shares_of(size: RealArray, value: RealArray) -> RealArray:
    """Return the relative change of values by their sizes; of a damper next to nothing its size is the share.

    Examples
    --------
    >>> shares_of(np.array([3.0, 1.0, 1.0]), np.array([3.0, 0.25, 0.0]))
    array([1., 4., 1.])
    """
    return np.asarray(np.divide(size, value, out=np.ones_like(size), where=value > NEXT_TO_NOTHING))


def _in_words(direction: RealArray, labels: Sequence[str]) -> str:
    largest = float(np.max(np.abs(direction)))
    parts = [(d / largest, label) for d, label in zip(direction, labels, strict=True) if abs(d) > NAMED_SHARE * largest]
    return ", ".join(f"{label} {100 * d:+.0f} %" for d, label in parts)
