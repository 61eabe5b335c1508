"""What a fleet's results say, as one value and as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from suspid.files import printable
from suspid.fleet.damper_trends import DamperTrends
from suspid.fleet.distributions import FEWEST_RECORDS, QUANTILES, Distribution, Outlier
from suspid.fleet.trends import Trend
from suspid.model import Suspension
from suspid.results import Result, columns_of
from suspid.values import text_table
from suspid.words import (
    Check,
    DamperState,
    Failure,
    FleetCheck,
    FleetHeadline,
    Level,
    Number,
    Remark,
    Step,
    Verdict,
    count,
)

LEGEND = (
    "scatter: robust standard deviation from record to record; stated ±: root mean square of the standard deviations "
    "that the records state. Empty: too few records."
)
# Lines of a table of the text: what fits a screen. All of them are attributes.
MOST_SHOWN = 20


@dataclass(frozen=True, kw_only=True, slots=True)
class FailureCount:
    """How many records failed at one step for one reason.

    Parameters
    ----------
    step : Step
        Where.
    code : Failure
        Why.
    count : int
        How many records.
    example : str
        The first of them, and its reason.
    """

    step: Step
    code: Failure
    count: int
    example: str


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetSummary(Result):
    """What a fleet's results say.

    Parameters
    ----------
    folder : path
        Where they are.
    records, failed : int
        How many records there are, and how many of them have a row among the failures.
    failures : tuple of FailureCount
        How many failed at which step for which reason, the most frequent first.
    verdicts : mapping of str to int
        How many records have each level of verdict.
    doubts : mapping of str to int
        How many records have each doubt, by its code, the most frequent first.
    distributions : tuple of Distribution
        Of frequency and damping of each family of modes, and of each parameter.
    outliers : tuple of Outlier
        The furthest first.
    trends : tuple of Trend
        Of each quantity of each vehicle, the surest change first; none without vehicles.
    dampers : DamperTrends or None
        What each damper of each vehicle has lost over its records, by the rule of `wear`; None without vehicles or
        springs.
    others : int
        How many modes belong to no family.
    unplaced : int or None
        How many records have no vehicle; None if none was asked for.
    complete : bool
        Whether the run has ended.
    wear : mapping of str to mapping of str to int
        In how many drives each damper has each state of wear against its nominal value; empty of decays.
    untrusted : int
        How many drives have springs and dampers that cannot be built upon, and are in no trend of dampers.
    car : Suspension or None
        The nominal car that the run was given.

    Examples
    --------
    >>> import numpy as np
    >>> import tempfile
    >>> from suspid import as_record, fleet_summary, identify_many
    >>> t = np.arange(0, 3, 0.01)
    >>> decay = as_record(np.exp(-t) * np.cos(20 * t), timepts=t, channels=["seat"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = identify_many([("bump", decay), ("bump again", decay)], output=folder, workers=1)
    ...     summary = fleet_summary(folder)
    >>> summary.records, summary.failed, summary.complete
    (2, 0, True)
    """

    folder: Path
    records: int
    failed: int
    failures: tuple[FailureCount, ...]
    verdicts: Mapping[str, int]
    doubts: Mapping[str, int]
    distributions: tuple[Distribution, ...]
    outliers: tuple[Outlier, ...]
    trends: tuple[Trend, ...]
    dampers: DamperTrends | None
    others: int
    unplaced: int | None
    complete: bool
    wear: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    untrusted: int = 0
    car: Suspension | None = None

    @property
    def verdict(self) -> Verdict:
        """How far the results can be trusted as a whole, and what they show."""
        identified = sum(self.verdicts.values())
        doubtful = sum(self.verdicts.get(level.label, 0) for level in (Level.DOUBTFUL, Level.NONE))
        changes = sum(1 for one in self.trends if one.changes)
        dampers = () if self.dampers is None else self.dampers.trends
        worn = sum(1 for one in dampers if one.state is DamperState.WORN)
        said: tuple[tuple[object, FleetCheck, dict[str, Number], Level], ...] = (
            (not identified, FleetCheck.NOTHING, {}, Level.NONE),
            (not self.complete, FleetCheck.NOT_ENDED, {}, Level.CARE),
            (self.failed, FleetCheck.FAILED, {"failed": self.failed}, Level.CARE),
            (not self.failed, FleetCheck.NO_FAILURE, {}, Level.SOUND),
            (
                doubtful,
                FleetCheck.DOUBTFUL,
                {"doubtful": doubtful},
                Level.DOUBTFUL if doubtful == identified else Level.CARE,
            ),
            (self.unplaced, FleetCheck.UNPLACED, {"unplaced": self.unplaced or 0}, Level.CARE),
            (self.untrusted, FleetCheck.UNTRUSTED, {"untrusted": self.untrusted}, Level.CARE),
            (dampers, FleetCheck.DAMPERS, {"worn": worn, "dampers": len(dampers)}, Level.NOTE),
            (self.trends, FleetCheck.CHANGES, {"changes": changes, "trends": len(self.trends)}, Level.NOTE),
            (self.outliers, FleetCheck.OUTLIERS, {"outliers": len(self.outliers)}, Level.NOTE),
        )
        checks = tuple(Check(Remark(code, numbers), level) for holds, code, numbers, level in said if holds)
        return Verdict(Remark(FleetHeadline.RESULTS, {"identified": identified, "records": self.records}), checks)

    def _table(self) -> Mapping[str, Sequence[object]]:
        return columns_of(self.distributions, ["quantity", "unit", "count", "median", "scatter", "stated"])

    def __str__(self) -> str:
        parts = [
            f"{printable(str(self.folder))}: {count(self.records, 'record')}, {self.failed} of them with a failure"
            + ("" if self.complete else "; the run has not ended")
        ]
        if self.failures:
            columns = {
                "failed at": [f"{one.step}: {one.code}" for one in self.failures],
                "records": [str(one.count) for one in self.failures],
                "such as": [one.example for one in self.failures],
            }
            parts.append(text_table(columns) + "\nThe table of failures lists all of them with their reasons.")
        if self.verdicts:
            parts.append(_verdict_table(self.verdicts, self.doubts))
        if self.wear:
            parts.append(_wear_table(self.wear))
        if self.distributions:
            parts.append(f"{_distribution_table(self.distributions)}\n{LEGEND}")
        if self.others:
            parts.append(
                f"{count(self.others, 'mode')} {'belongs' if self.others == 1 else 'belong'} to no family: "
                "too few records have one there"
            )
        if self.outliers:
            shown = self.outliers[:MOST_SHOWN]
            columns = {
                "outlier": [one.record for one in shown],
                "quantity": [one.quantity for one in shown],
                "value": [f"{one.value:.5g}" for one in shown],
                "median": [f"{one.median:.5g}" for one in shown],
                "off [sd]": [f"{one.z:+.1f}" for one in shown],
            }
            parts.append(text_table(columns) + _more(len(self.outliers)))
        else:
            parts.append(_no_outlier(self.distributions))
        if self.unplaced is not None:
            parts.append(_trends_in_words(self.trends, self.unplaced))
        if self.dampers is not None and (self.dampers.trends or self.wear):
            parts.append(_dampers_in_words(self.dampers, self.untrusted))
        return "\n\n".join(parts)


def _verdict_table(verdicts: Mapping[str, int], doubts: Mapping[str, int]) -> str:
    levels = text_table({"verdict": list(verdicts), "records": [str(number) for number in verdicts.values()]})
    if not doubts:
        return levels
    shown = list(doubts.items())[:MOST_SHOWN]
    table = text_table({"doubt": [code for code, _ in shown], "records": [str(number) for _, number in shown]})
    return f"{levels}\n\n{table}{_more(len(doubts))}"


def _wear_table(wear: Mapping[str, Mapping[str, int]]) -> str:
    columns = {f"{state}": [str(states.get(str(state), 0)) for states in wear.values()] for state in DamperState}
    return text_table({"drives by wear against nominal": list(wear), **columns})


def _distribution_table(distributions: Sequence[Distribution]) -> str:
    return text_table(
        {
            "quantity": [f"{one.quantity} [{one.unit}]" for one in distributions],
            "records": [str(one.count) for one in distributions],
            "median": [f"{one.median:.5g}" for one in distributions],
            **{
                f"{100 * q:g} %": [_or_empty(one.known_quantiles[k], ".5g") for one in distributions]
                for k, q in enumerate(QUANTILES)
            },
            "scatter": [_or_empty(one.known_scatter, ".2g") for one in distributions],
            "stated ±": [f"{one.stated:.2g}" for one in distributions],
        }
    )


def _or_empty(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _no_outlier(distributions: Sequence[Distribution]) -> str:
    enough = sum(one.count >= FEWEST_RECORDS for one in distributions)
    few = f"fewer than {FEWEST_RECORDS} records do not tell which stands out"
    if not enough:
        return few
    return "no record stands out" + (f"; {few}" if enough < len(distributions) else "")


def _trends_in_words(trends: Sequence[Trend], unplaced: int) -> str:
    changing = [one for one in trends if one.changes]
    vehicles = len({one.vehicle for one in trends})
    are = "is" if len(changing) == 1 else "are"
    said = (
        f"{count(len(trends), 'trend')} of {count(vehicles, 'vehicle')} (at least four tests each); "
        f"{count(len(changing), 'change')} {are} significant (at most 5 % of these by chance)"
    )
    if unplaced:
        said += f"; {count(unplaced, 'record')} {'has' if unplaced == 1 else 'have'} no vehicle and date"
    if not changing:
        return said
    shown = changing[:MOST_SHOWN]
    columns = {
        "vehicle": [one.vehicle for one in shown],
        "quantity": [f"{one.quantity} {one.direction}" for one in shown],
        "tests": [str(one.count) for one in shown],
        "over": [f"{one.span:.4g}" for one in shown],
        "start": [f"{one.start:.5g}" for one in shown],
        "end": [f"{one.end:.5g}" for one in shown],
        "95 % of the change": [f"{one.change[0]:+.3g} … {one.change[1]:+.3g}" for one in shown],
        "p": [f"{one.p_adjusted:.1g}" for one in shown],
    }
    return f"{said}\n\n{text_table(columns)}{_more(len(changing))}"


def _dampers_in_words(dampers: DamperTrends, untrusted: int) -> str:
    left_out = ""
    if untrusted:
        left_out = (
            f"{count(untrusted, 'drive')} {'is' if untrusted == 1 else 'are'} in no trend of a damper, because the "
            "springs and dampers found are doubtful: see suspid drive"
        )
    if not dampers.trends:
        return "\n".join(filter(None, [str(dampers), left_out]))
    rule, doubtful = dampers.rule, dampers.doubtful
    states = Counter(str(one.state) for one in dampers.trends)
    numbers = ", ".join(f"{number} {state}" for state, number in sorted(states.items()))
    said = (
        f"{count(len(dampers.trends), 'damper')} over their records: {numbers} (of those that lost no more than "
        f"{rule.small:.0%}, at most {rule.rate:.1%} are called worn)"
    )
    said = "\n".join(filter(None, [said, left_out]))
    if not doubtful.trends:
        return said
    return f"{said}\n\n{replace(doubtful, trends=doubtful.trends[:MOST_SHOWN])}{_more(len(doubtful.trends))}"


def _more(number: int) -> str:
    return f"\n… and {number - MOST_SHOWN} more" if number > MOST_SHOWN else ""
