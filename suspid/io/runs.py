"""Runs: several tests inside one file, distinguished by the names and clocks of their channels."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from suspid.io.names import bare_name, plain

# Between the parts of a name, such as those of a structure, of a group, or of a run of Logger Pro. Between digits they
# are part of a date, a time of day or a number.
SEPARATORS = re.compile(r"(?:(?<!\d)[.:/|]|[.:/|](?!\d))\s*")
# Names that number tests; channels of such groups may share a clock.
NUMBERED = re.compile(
    r"(?:run|test|trial|take|shot|data ?set|lauf|versuch|messung|essai|mesure|prueba|ensayo|prova)[\W_]*\d+\]?"
    r"|.*\[\d+\]",
    re.I,
)
# The same at the end of a name, as Capstone writes it.
NUMBERED_LAST = re.compile(rf"(.*\S)\s+({NUMBERED.pattern.split('|.*')[0]})", re.I)


def runs_of(clocks: Mapping[str, int]) -> dict[str, str]:
    """Return the test of each channel, by its name and the number of its clock; empty if there is but one test.

    Groups of channels are tests of their own if they hold channels of the same names, and either no group shares its
    clock with another or their names number tests. A channel outside all groups belongs to the test of its clock.

    Examples
    --------
    >>> runs_of({"Fe.Out.Acc": 1, "Fe.Out.Pos": 1, "Al.Out.Acc": 2, "Al.Out.Pos": 2})
    {'Fe.Out.Acc': 'Fe', 'Fe.Out.Pos': 'Fe', 'Al.Out.Acc': 'Al', 'Al.Out.Pos': 'Al'}
    >>> runs_of({"front.acc": 1, "rear.acc": 1}), runs_of({"Run 1: z (m)": 1, "Run 2: z (m)": 1})["Run 2: z (m)"]
    ({}, 'Run 2')
    >>> runs_of({"Angle (rad) Run #1": 1, "Angle (rad) Run #2": 1})
    {'Angle (rad) Run #1': 'Run #1', 'Angle (rad) Run #2': 'Run #2'}
    >>> list(runs_of({"9/7/2012 6:58:23 PM - all/Dev1": 1, "9/7/2012 6:58:23 PM - means/Dev1": 2}).values())
    ['9/7/2012 6:58:23 PM - all', '9/7/2012 6:58:23 PM - means']
    """
    parts = _without_common({name: _parts(name) for name in clocks})
    groups: dict[str, dict[str, str]] = {}
    for name, (first, *rest) in parts.items():
        if rest:
            groups.setdefault(first, {})[name] = ".".join(rest)
    if len(groups) < 2 or not set.intersection(*(set(rests.values()) for rests in groups.values())):
        return {}
    used = {group: {clocks[name] for name in names} for group, names in groups.items()}
    shared = sum(map(len, used.values())) > len(set().union(*used.values()))
    if shared and not all(NUMBERED.fullmatch(plain(group)) for group in groups):
        return {}
    by_clock = {clock: group for group, some in used.items() for clock in some} if not shared else {}
    of = {name: group for group, names in groups.items() for name in names}
    return {name: of.get(name) or by_clock.get(clocks[name], "") for name in clocks}


def _parts(name: str) -> Sequence[str]:
    """Return the parts of a name, that which numbers a test first."""
    last = NUMBERED_LAST.fullmatch(plain(name))
    return [last[2], bare_name(last[1])] if last else SEPARATORS.split(bare_name(name))


def _without_common(parts: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Return the parts of names without the first ones that all have."""
    found = dict(parts)
    while found and all(len(one) > 1 for one in found.values()) and len({one[0] for one in found.values()}) == 1:
        found = {name: one[1:] for name, one in found.items()}
    return found
