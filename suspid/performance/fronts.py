"""Search for fronts: smooth problems in the logarithms of parameters and figures, from many starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from suspid.performance.relations import Relations
from suspid.units import RealArray

# Figures in logarithms, (figure,), and their derivatives, (figure, unknown).
Evaluate = Callable[[RealArray], tuple[RealArray, RealArray]]

# Points at which the box is looked at before the search, for each unknown, and how many of the best begin a search.
PLACES_EACH, BEST_STARTS = 16, 3
# Two searches agree where their figures differ by less than this share; a limit is met to it.
SAME_FIGURE = 1e-4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Search:
    """A problem: figures within a box of unknowns, the first ones to be minimised, the others below limits.

    Between the unknowns there may be relations.
    """

    evaluate: Evaluate
    low: RealArray  # (unknown,)
    high: RealArray
    objectives: int
    limits: RealArray  # (figure - objectives,), logarithms
    relations: Relations
    known: dict[bytes, tuple[RealArray, RealArray]] = field(default_factory=dict)

    def at(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return `evaluate` at a point of the box; the last points are remembered."""
        inside = np.clip(x, self.low, self.high)
        key = inside.tobytes()
        if key not in self.known:
            if len(self.known) > 4 * PLACES_EACH:
                self.known.clear()
            self.known[key] = self.evaluate(inside)
        return self.known[key]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Point:
    """Where a search ended: unknowns, figures, and whether it converged within the limits."""

    x: RealArray
    figures: RealArray
    good: bool


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Front:
    """Points of a front, how many searches from other starts agreed, of how many, and how many points failed."""

    points: tuple[Point, ...]
    agreed: int
    searches: int
    failed: int


def tuning_steps(objectives: int, points: int) -> tuple[str, ...]:
    """Return the names of the steps of a search, in order.

    Examples
    --------
    >>> tuning_steps(2, 4)
    ('looking around', 'least of figure 1', 'least of figure 2', 'car 2 of 4', 'car 3 of 4')
    """
    between = [f"car {k} of {points}" for k in range(2, points)] if objectives > 1 else []
    return ("looking around", *(f"least of figure {i + 1}" for i in range(objectives)), *between)


def front_of(search: Search, start: RealArray, points: int, begin: Callable[[str], None] = lambda _: None) -> Front:
    """Return the front of one or two objectives: its ends, and points spread evenly between them.

    ``begin`` is called with each of `tuning_steps` as it begins.
    """
    first, *steps = tuning_steps(search.objectives, points)
    begin(first)
    sample = _spread(search.low, search.high, PLACES_EACH * len(start))
    seen = np.array([search.evaluate(x)[0] for x in (start, *sample)])
    places = np.vstack([start, sample])
    over = np.sum(np.maximum(seen[:, search.objectives :] - search.limits, 0.0), axis=1)
    over += np.array([np.sum(search.relations.broken(x)) for x in places])
    agreed = searches = 0
    ends = []
    for i in range(search.objectives):
        begin(steps[i])
        order = np.lexsort((seen[:, i], over))[:BEST_STARTS]
        found = [_minimised(search, places[k], [i], np.zeros(1)) for k in order]
        best = min(found, key=lambda point: (not point.good, float(point.figures[i])))
        agreed += sum(point.good and point.figures[i] - best.figures[i] < SAME_FIGURE for point in found) - 1
        searches += len(found) - 1
        ends.append(best)
    if search.objectives == 1 or not all(end.good for end in ends):
        return Front(
            points=tuple(end for end in ends if end.good)[:1],
            agreed=agreed,
            searches=searches,
            failed=sum(not end.good for end in ends),
        )
    # Among the cars that are best in one figure, the one that is best in the other.
    for i, other in ((0, 1), (1, 0)):
        # How far the ends of a front may be from the very best in one figure, for the sake of the other.
        better = _minimised(search, ends[i].x, [other], np.zeros(1), cap=(i, float(ends[i].figures[i]) + 1e-5))
        ends[i] = better if better.good else ends[i]
    ideal = np.array([ends[0].figures[0], ends[1].figures[1]])
    span = np.array([ends[1].figures[0], ends[0].figures[1]]) - ideal
    if np.any(span < SAME_FIGURE):
        return Front(points=(ends[0],), agreed=agreed, searches=searches, failed=0)
    found, failed, last = [ends[0]], 0, ends[0].x
    scaled = (seen[:, :2] - ideal) / span
    for name, share in zip(steps[2:], np.linspace(0, 1, points)[1:-1], strict=True):
        begin(name)
        line = np.array([share, 1 - share])
        start_of_sample = places[int(np.lexsort((np.max(scaled - line, axis=1), over))[0])]
        both = [_minimised(search, x, [0, 1], ideal + line * span, span) for x in (last, start_of_sample)]
        gains = [float(np.max((point.figures[:2] - ideal) / span - line)) for point in both]
        if not any(point.good for point in both):
            failed += 1
            continue
        take = min((k for k in (0, 1) if both[k].good), key=gains.__getitem__)
        searches += 1
        agreed += both[1 - take].good and gains[1 - take] - gains[take] < SAME_FIGURE / float(np.max(span))
        found.append(both[take])
        last = both[take].x
    return Front(points=_efficient([*found, ends[1]]), agreed=int(agreed), searches=searches, failed=failed)


def _minimised(
    search: Search,
    start: RealArray,
    wanted: Sequence[int],
    line: RealArray,
    span: RealArray | None = None,
    cap: tuple[int, float] | None = None,
) -> Point:
    """Return where the largest of ``(figure - line) / span`` is least, with one figure below a cap.

    The unknown z beside x is that largest value: minimise z with ``figure - line <= span z`` for each wanted one.
    """
    from scipy import optimize

    scale = np.ones(len(wanted)) if span is None else span
    count, rows = len(start), list(wanted)
    limited = list(range(search.objectives, search.objectives + len(search.limits)))
    tops = search.limits
    if cap is not None:
        limited, tops = [*limited, cap[0]], np.append(tops, cap[1])

    def below(v: RealArray) -> RealArray:
        figures, _ = search.at(v[:count])
        return np.concatenate([v[count] - (figures[rows] - line) / scale, tops - figures[limited]])

    def below_slopes(v: RealArray) -> RealArray:
        _, slopes = search.at(v[:count])
        upper = np.hstack([-slopes[rows] / scale[:, None], np.ones((len(rows), 1))])
        return np.vstack([upper, np.hstack([-slopes[limited], np.zeros((len(limited), 1))])])

    figures, _ = search.at(start)
    first = np.append(start, np.max((figures[rows] - line) / scale))
    constraints: list[Any] = [{"type": "ineq", "fun": below, "jac": below_slopes}, *_related(search.relations, count)]
    gradient = np.append(np.zeros(count), 1.0)
    minimize: Any = optimize.minimize
    solved = minimize(
        lambda v: float(v[count]),
        first,
        jac=lambda _: gradient,
        bounds=[*zip(search.low.tolist(), search.high.tolist(), strict=True), (None, None)],
        constraints=constraints,
        method="SLSQP",
        options={"maxiter": 60, "ftol": 1e-8},
    )
    x = np.clip(solved.x[:count], search.low, search.high)
    figures, _ = search.at(x)
    met = bool(np.all(figures[limited] <= tops + SAME_FIGURE) and np.all(search.relations.broken(x) <= SAME_FIGURE))
    return Point(x=x, figures=figures, good=bool(solved.success) and met)


def _related(relations: Relations, count: int) -> Iterator[Any]:
    """Yield the relations between the first unknowns, as SLSQP takes them."""
    for kind, rows in (("ineq", ~relations.equal), ("eq", relations.equal)):
        if np.any(rows):

            def room(v: RealArray, rows: NDArray[np.bool_] = rows) -> RealArray:
                return relations.room(v[:count])[0][rows]

            def slopes(v: RealArray, rows: NDArray[np.bool_] = rows) -> RealArray:
                by_unknown = relations.room(v[:count])[1][rows]
                return np.hstack([by_unknown, np.zeros((len(by_unknown), 1))])

            yield {"type": kind, "fun": room, "jac": slopes}


def _efficient(found: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points that no other one beats in both objectives, by the first one."""
    values = np.array([point.figures[:2] for point in found])
    kept = [
        point
        for point, one in zip(found, values, strict=True)
        if not np.any(np.all(values < one - SAME_FIGURE / 10, axis=1))
    ]
    return tuple(sorted(kept, key=lambda point: float(point.figures[0])))


def _spread(low: RealArray, high: RealArray, count: int) -> RealArray:
    """Return points spread evenly over a box: multiples of powers of the generalised golden ratio, modulo 1."""
    size, ratio = len(low), 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (size + 1))
    steps = ratio ** -np.arange(1.0, size + 1)
    return np.asarray(low + (high - low) * ((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0))
