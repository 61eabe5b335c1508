"""Scenarios of uncertain parameters in a search: along the directions that change its figures most."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from suspid.performance.choices import Choice
from suspid.performance.joined import Joined
from suspid.performance.road_response import exact_grid
from suspid.units import Ratio, RealArray

# Uncertain parameters up to which all of their scenarios are looked at: two for each.
FEW_UNCERTAIN = 4
# Share of the variance of each figure, at every place that is tried, that the directions of a search hold: standard
# deviations are then short by half a per cent at most.
VARIANCE_HELD: Ratio = 0.99


def for_search(asked: Joined, choice: Choice, places: Iterable[RealArray]) -> Choice:
    """Return a choice with fewer scenarios where many parameters are uncertain.

    Figures move along few directions of them: those of their derivatives, at each of the places in the box.
    """
    names = tuple(choice.scenarios[0])
    if len(names) <= FEW_UNCERTAIN:
        return choice
    logs = np.log([[one[name] for name in names] for one in choice.scenarios])
    root = logs[::2].T / len(names) ** 0.5
    rows = np.vstack([_moved(asked, choice, names, x) @ root for x in places])
    sizes = np.linalg.norm(rows, axis=1)
    if not np.any(sizes):
        return choice
    directions = directions_of(rows[sizes > 0] / sizes[sizes > 0, None])
    reach = root @ directions * len(directions.T) ** 0.5
    moves = [sign * column for column in reach.T for sign in (1.0, -1.0)]
    return replace(choice, scenarios=tuple(dict(zip(names, np.exp(move).tolist(), strict=True)) for move in moves))


def places_in(low: RealArray, high: RealArray) -> list[RealArray]:
    """Return places in the box at which scenarios are chosen: its middle, its ends, and those of each unknown."""
    middle = (low + high) / 2
    one_each = [np.where(np.arange(len(low)) == i, end, middle) for i in range(len(low)) for end in (low, high)]
    return [middle, low, high, *one_each]


def directions_of(rows: RealArray) -> RealArray:
    """Return the fewest orthonormal directions, as columns, that hold most of each row of length one.

    Examples
    --------
    >>> directions_of(np.array([[1.0, 0.0, 0.0], [0.999, 0.0447, 0.0]])).shape
    (3, 1)
    """
    _, _, found = np.linalg.svd(rows)
    held = np.cumsum((rows @ found.T) ** 2, axis=1)
    count = int(np.argmax(np.all(held >= VARIANCE_HELD, axis=0))) + 1
    return np.asarray(found[:count].T)


def _moved(asked: Joined, choice: Choice, names: Sequence[str], x: RealArray) -> RealArray:
    """Return how figures move by logarithms of uncertain parameters, (figure, parameter)."""
    _, slopes = asked.values(choice.car(x, {}), names, lambda car: exact_grid(car, asked.plan.signals, asked.plan.road))
    return np.asarray(slopes * np.array([choice.values[name] for name in names]))
