"""The summary of a fleet as one value and as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from suspid.files import printable
from suspid.fleet.damper_trends import DamperTrends
from suspid.fleet.distributions import Distribution, Outlier
from suspid.fleet.summary_text import (
    MOST_SHOWN,
    dampers_in_words,
    distribution_table,
    more_than_shown,
    no_outlier,
    trends_in_words,
    verdict_table,
    wear_table,
    with_examples,
)
from suspid.fleet.trends import Trend
from suspid.model import Suspension
from suspid.results import Result, columns_of
from suspid.text_tables import TERMINAL, text_table
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


@dataclass(frozen=True, kw_only=True, slots=True, repr=False)
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
    said : mapping of str to str
        For each doubt what is said of it in the first record that has it.

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
    said: Mapping[str, str] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        """How far the results can be trusted as a whole, and what they show.

        Examples
        --------
        >>> from pathlib import Path
        >>> from suspid import FleetSummary
        >>> summary = FleetSummary(folder=Path("results"), records=10, failed=1, complete=True, failures=(),
        ...                        verdicts={"sound": 9}, doubts={}, distributions=(), outliers=(), trends=(),
        ...                        dampers=None, others=0, unplaced=None)
        >>> summary.verdict.level.label, [str(check.remark.code) for check in summary.verdict.checks]
        ('care', ['failed'])
        """
        identified = sum(self.verdicts.values())
        doubtful = sum(self.verdicts.get(level.label, 0) for level in (Level.DOUBTFUL, Level.NONE))
        care = self.verdicts.get(Level.CARE.label, 0)
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
            (care, FleetCheck.CARE, {"care": care}, Level.CARE),
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
            }
            examples = [one.example for one in self.failures]
            parts.append(
                f"{with_examples(columns, examples)}\nThe table of failures lists all of them with their reasons."
            )
        if self.verdicts:
            parts.append(verdict_table(self.verdicts, self.doubts, self.said))
        if self.wear:
            parts.append(wear_table(self.wear))
        if self.distributions:
            parts.append(f"{distribution_table(self.distributions)}\n{LEGEND}")
        if self.others:
            parts.append(
                f"{count(self.others, 'mode')} {'belongs' if self.others == 1 else 'belong'} to no group: "
                "too few records have one there, or a record has another that is nearer"
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
            parts.append(text_table(columns, widest=TERMINAL) + more_than_shown(len(self.outliers)))
        else:
            parts.append(no_outlier(self.distributions))
        if self.unplaced is not None:
            parts.append(trends_in_words(self.trends, self.unplaced))
        if self.dampers is not None and (self.dampers.trends or self.wear):
            parts.append(dampers_in_words(self.dampers, self.untrusted))
        return "\n\n".join(parts)
