"""Checks of the cars of a tuning."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from suspid.performance.choices import REACHED, Choice
from suspid.performance.fronts import Front, Search
from suspid.performance.larger_better import limit_in_words, small
from suspid.performance.plausibility import plausible
from suspid.performance.uncertain import Uncertain
from suspid.reconstruction import unit_of
from suspid.units import Ratio, RealArray
from suspid.words import Check, Level, Number, Remark
from suspid.words.ride import RideCheck
from suspid.words.tuning import TuningCheck

# Share of the searches from other starts that must agree.
AGREED = 0.5


def tuning_checks(
    front: Front, choice: Choice, search: Search, robust: Ratio, about: Uncertain, given: Collection[str]
) -> Iterator[Check]:
    """Yield the checks of a front; ``given`` are the parameters whose bounds were stated."""
    yield from plausible(about.car)
    share = front.agreed / front.searches if front.searches else 1.0
    yield Check(
        Remark(TuningCheck.STARTS, {"share": share, "count": front.searches}),
        Level.SOUND if share >= AGREED else Level.CARE,
    )
    if front.failed:
        numbers = {"count": front.failed, "points": front.failed + len(front.points)}
        yield Check(Remark(TuningCheck.UNFINISHED, numbers), Level.CARE)
    if search.objectives == 2 and len(front.points) == 1:
        yield Check(Remark(TuningCheck.ONE), Level.NOTE)
    yield from _at_bounds(front, choice, search, given)
    yield from _related(front, search)
    if robust:
        reached: dict[str, Number] = {"reach": robust, "names": tuple(choice.scenarios[0])}
        yield Check(Remark(TuningCheck.ROBUST, reached), Level.NOTE)
    if about.doubt is not None:
        yield Check(Remark(RideCheck.UNTRUSTED, {"level": about.doubt.label}), about.doubt)
    if about.nominal:
        yield Check(Remark(RideCheck.STAYED_NOMINAL, {"names": about.nominal}), Level.CARE)


def idle_limits(limits: Mapping[str, float], values: Mapping[str, RealArray]) -> Iterator[Check]:
    """Yield limits that no car of the front comes near: they may be in another unit."""
    for name, limit in limits.items():
        (top,), _ = small([name], np.array([limit]))
        losses = small([name] * len(values[name]), values[name])[0]
        if np.all(losses < top * (1 - REACHED)):
            nearest = float(values[name][int(np.argmax(losses))])
            numbers: dict[str, Number] = {"label": limit_in_words(name, limit), "value": nearest}
            yield Check(Remark(TuningCheck.IDLE, numbers), Level.NOTE)


def _at_bounds(front: Front, choice: Choice, search: Search, given: Collection[str]) -> Iterator[Check]:
    """Yield which bounds decide, and for how many cars; one that nobody stated is a doubt."""
    x = np.array([point.x for point in front.points])
    for i, group in enumerate(choice.groups):
        for side, end, stuck in (
            ("least", search.low[i], x[:, i] <= search.low[i] + REACHED),
            ("largest", search.high[i], x[:, i] >= search.high[i] - REACHED),
        ):
            if np.any(stuck):
                numbers: dict[str, Number] = {
                    "name": group[0], "side": side, "value": choice.values[group[0]] * float(np.exp(end)),
                    "unit": unit_of(group[0]), "count": int(np.sum(stuck)), "cars": len(x),
                }  # fmt: skip
                stated = group[0] in given
                code = TuningCheck.AT_BOUND if stated else TuningCheck.AT_REACH
                yield Check(Remark(code, numbers), Level.NOTE if stated else Level.CARE)


def _related(front: Front, search: Search) -> Iterator[Check]:
    """Yield which relations that could be kept with room are kept with none."""
    relations = search.relations
    rooms = np.array([relations.room(point.x)[0] for point in front.points])
    for label in dict.fromkeys(relations.labels):
        rows = np.array([one == label for one in relations.labels]) & ~relations.equal
        acts = np.any(rooms[:, rows] < REACHED, axis=1)
        if np.any(acts):
            numbers: dict[str, Number] = {"label": label, "count": int(np.sum(acts)), "cars": len(acts)}
            yield Check(Remark(TuningCheck.RELATED, numbers), Level.NOTE)
