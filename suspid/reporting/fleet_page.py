"""The HTML page of a fleet: verdict counts, failures, distributions, outliers, trends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from suspid.files import printable
from suspid.fleet import LEGEND, MOST_SHOWN, no_outlier
from suspid.levels import LEVEL
from suspid.reporting import fleet_tables as tables
from suspid.reporting.pictures import Picture, picture
from suspid.reporting.plot_fleet import Change, changes_of, draw_distribution, draw_intervals, losses_of
from suspid.reporting.svg import page_style
from suspid.words import DamperState, count

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.fleet import DamperTrends, Distribution, FleetSummary, Trend
    from suspid.reporting.source import Source
    from suspid.units import Ratio

# Histograms that the page draws at most; its table has all quantities.
MOST_HISTOGRAMS = 24


@dataclass(frozen=True, kw_only=True, slots=True)
class FleetContent:
    """The summary of a fleet and where it comes from.

    Parameters
    ----------
    found : FleetSummary
        What the results say.
    sources : sequence of Source
        The manifest of the results and the command.
    warnings : sequence of str
        Warnings during the analysis.
    """

    found: FleetSummary
    sources: Sequence[Source] = ()
    warnings: Sequence[str] = ()

    @property
    def level(self) -> Ratio:
        """Probability of the intervals of trends [1]."""
        return LEVEL


def fleet_fields(content: FleetContent) -> dict[str, object]:
    """Return what the template of a fleet shows in addition to what every page has."""
    found = content.found
    changing = [one for one in found.trends if one.changes]
    units = {one.quantity: one.unit for one in found.distributions}
    drawn = found.distributions[:MOST_HISTOGRAMS]
    with page_style():
        return {
            "facts": f"{count(found.records, 'record')} in {printable(str(found.folder))}",
            "glance": _glance(found, len(changing)),
            "verdicts": tables.verdict_table(found),
            "doubts": tables.doubt_table(found),
            "failures": tables.failure_table(found),
            "wear": tables.wear_table(found),
            "distributions": tables.distribution_table(found.distributions),
            "legend": LEGEND.replace("Empty", "–"),
            "histograms": [_histogram(one, k) for k, one in enumerate(drawn)],
            "undrawn": len(found.distributions) - len(drawn),
            "others": count(found.others, "mode") if found.others else "",
            "no_outlier": no_outlier(found.distributions),
            "outliers": tables.outlier_table(found.outliers, units),
            "followed": len(found.trends),
            "vehicles": count(len({one.vehicle for one in found.trends}), "vehicle"),
            "trends": tables.trend_table(changing, units),
            "trends_picture": _changes(changing[:MOST_SHOWN]),
            **_dampers(found.dampers),
        }


def _glance(found: FleetSummary, changing: int) -> list[tuple[int, str]]:
    """Return the numbers that the page begins with."""
    cards = [
        (found.records, "records"),
        (found.failed, "failed"),
        (len({one.record for one in found.outliers}), "stand out"),
    ]
    if found.trends:
        cards.append((changing, "significant changes"))
    if found.dampers is not None and found.dampers.trends:
        cards.append((sum(1 for one in found.dampers.trends if one.state is DamperState.WORN), "dampers worn"))
    return cards


def _histogram(found: Distribution, which: int) -> Picture:
    described = f"Histogram of {printable(found.quantity)} over the records"
    return picture(partial(_draw_histogram, found), name=f"spread-{which}", described=described, height=1.6)


def _draw_histogram(found: Distribution, figure: Figure) -> None:
    draw_distribution(found, figure.subplots())


def _changes(some: Sequence[Trend]) -> Picture | None:
    """Draw the changes over time in percent of their start."""
    return _intervals(changes_of(some), "changes", "change from first to last test [%]", ())


def _dampers(found: DamperTrends | None) -> dict[str, object]:
    """Return the trends of dampers; nothing where there are none."""
    if found is None or not found.trends:
        return {"dampers": tables.damper_table(()), "dampers_picture": None, "rule": ""}
    rule = found.rule
    marks = (100 * rule.small, 100 * rule.large)
    return {
        "dampers": tables.damper_table(found.trends),
        "dampers_picture": _intervals(losses_of(found), "dampers", "damping lost from first to last test [%]", marks),
        "rule": f"Worn: lost significantly more than {100 * rule.small:g} %. Good: a loss of {100 * rule.large:g} % is "
        f"excluded. Each holds with {100 * (1 - rule.rate):g} % certainty; dotted lines mark both.",
    }


def _intervals(changes: Sequence[Change], name: str, label: str, marks: Sequence[float]) -> Picture | None:
    if not changes:
        return None
    height = 0.6 + 0.22 * (1 + len(changes))
    draw = partial(_draw_intervals, changes, label, marks)
    described = f"{label.partition(' [')[0].capitalize()} with intervals"
    return picture(draw, name=name, described=described, height=height, wide_height=height)


def _draw_intervals(changes: Sequence[Change], label: str, marks: Sequence[float], figure: Figure) -> None:
    draw_intervals(changes, figure.subplots(), label=label, marks=marks)
