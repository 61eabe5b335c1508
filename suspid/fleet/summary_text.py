"""The summary of a fleet in words and tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from suspid.fleet.damper_trends import DamperTrends, losses_table
from suspid.fleet.distributions import FEWEST_RECORDS, Distribution, known_columns
from suspid.fleet.trends import Trend
from suspid.text_tables import COLUMN_GAP, TERMINAL, figures_of, sentence_table, text_table
from suspid.words import (
    DamperState,
    count,
    label_in_words,
)

# Lines of a table of the text: what fits a screen. All of them are attributes.
MOST_SHOWN = 20
# Significant digits of values: damping of a fleet is known to a few tenths of a per cent.
VALUE_DIGITS = 5
# Fewest letters of a line of a sentence beside other columns.
SENTENCE = 24


def verdict_table(verdicts: Mapping[str, int], doubts: Mapping[str, int], said: Mapping[str, str]) -> str:
    """Return the table of verdicts, and that of doubts, each with a sentence of one record, if there are any."""
    levels = text_table(
        {"verdict": [*map(label_in_words, verdicts)], "records": [str(number) for number in verdicts.values()]}
    )
    if not doubts:
        return levels
    shown = list(doubts.items())[:MOST_SHOWN]
    names = {"doubt": [code for code, _ in shown], "records": [str(number) for _, number in shown]}
    table = with_examples(names, [said.get(code, "") for code, _ in shown])
    return f"{levels}\n\n{table}{more_than_shown(len(doubts))}"


def with_examples(columns: Mapping[str, Sequence[str]], examples: Sequence[str]) -> str:
    """Return a table with a sentence beside each row, on lines of its own within a terminal."""
    taken = sum(max(len(name) + COLUMN_GAP, *map(len, cells)) + COLUMN_GAP for name, cells in columns.items())
    return sentence_table(columns, "such as", [[one] for one in examples], max(SENTENCE, TERMINAL - taken))


def wear_table(wear: Mapping[str, Mapping[str, int]]) -> str:
    """Return the table of drives by wear against nominal, a row per damper."""
    columns = {f"{state}": [str(states.get(str(state), 0)) for states in wear.values()] for state in DamperState}
    return text_table({"drives by wear against nominal": list(wear), **columns})


def distribution_table(distributions: Sequence[Distribution]) -> str:
    """Return the table of distributions with the outermost quantiles that are known, empty where a number is not."""
    quantiles = known_columns(distributions)
    ends = dict(list(quantiles.items())[:: max(len(quantiles) - 1, 1)])
    return text_table(
        {
            "quantity": [f"{one.quantity} [{one.unit}]" for one in distributions],
            "records": [str(one.count) for one in distributions],
            "median": [figures_of(one.median, VALUE_DIGITS) for one in distributions],
            **{heading: [_or_empty(value, VALUE_DIGITS) for value in column] for heading, column in ends.items()},
            "scatter": [_or_empty(one.known_scatter, 2) for one in distributions],
            "stated ±": [_or_empty(one.stated, 2) for one in distributions],
        },
        widest=TERMINAL,
    )


def _or_empty(value: float | None, digits: int) -> str:
    return "" if value is None or math.isnan(value) else figures_of(value, digits)


def no_outlier(distributions: Sequence[Distribution]) -> str:
    """Return that there is no outlier, or why none can be found."""
    enough = sum(one.count >= FEWEST_RECORDS for one in distributions)
    few = f"fewer than {FEWEST_RECORDS} records are too few to find outliers"
    if not enough:
        return few
    return "no outliers" + (f"; {few}" if enough < len(distributions) else "")


def trends_in_words(trends: Sequence[Trend], unplaced: int) -> str:
    """Return which vehicles change, with the table of changes."""
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
        "start": [figures_of(one.start, VALUE_DIGITS) for one in shown],
        "end": [figures_of(one.end, VALUE_DIGITS) for one in shown],
        "change, 95 %": [f"{one.change[0]:+.3g}…{one.change[1]:+.3g}" for one in shown],
        "p": [f"{one.p_adjusted:.1g}" for one in shown],
    }
    return f"{said}\n\n{text_table(columns, widest=TERMINAL)}{more_than_shown(len(changing))}"


def dampers_in_words(dampers: DamperTrends, untrusted: int) -> str:
    """Return which dampers change, with the table of those and the drives left out."""
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
    shown = losses_table(replace(doubtful, trends=doubtful.trends[:MOST_SHOWN]))
    return f"{said}\n\n{shown}{more_than_shown(len(doubtful.trends))}"


def more_than_shown(number: int) -> str:
    """Return the line that says how many rows of a table are not shown."""
    return f"\n… and {number - MOST_SHOWN} more" if number > MOST_SHOWN else ""
