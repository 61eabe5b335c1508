"""Limits beside what was found: met, not met, or cannot tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.analysis.limits import Limit
from suspid.results import Result
from suspid.text_tables import TERMINAL, bound_columns, figures_of, rounded, text_table
from suspid.units import Ratio
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.limits import LimitHeadline, LimitState

WEIGHTS = {LimitState.MET: Level.SOUND, LimitState.MISSED: Level.DOUBTFUL, LimitState.OPEN: Level.CARE}


@dataclass(frozen=True, kw_only=True, slots=True)
class CheckedLimit:
    """A limit beside what was found.

    Parameters
    ----------
    limit : Limit
        The limit.
    value, lower, upper : float
        What was found and the ends of its interval, in SI units; NaN where there is none.
    state : Code
        Whether the limit is met: the whole interval lies within it, or outside, or neither.
    why : Remark or None
        Why that cannot be told.
    """

    limit: Limit
    value: float
    lower: float
    upper: float
    state: LimitState
    why: Remark | None = None

    @property
    def check(self) -> Check:
        """The limit as part of a verdict."""
        numbers: dict[str, Number] = {"name": self.limit.name, "why": str(self.why or ""), "value": self.value}
        return Check(Remark(self.state, numbers), WEIGHTS[self.state])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class CheckedLimits(Result):
    """Result of `check_limits`, a row for each limit.

    Parameters
    ----------
    rows : tuple of CheckedLimit
        The limits in their order.
    level : float
        Probability of the intervals [1].

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import Limit, as_record, check_limits, identify
    >>> t = np.arange(400) / 100
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t))
    >>> checked = check_limits(found, [Limit(of=1, quantity="zeta", least=0.2)])
    >>> checked.passed, [str(row.state) for row in checked.rows]
    (False, ['not met'])
    """

    rows: tuple[CheckedLimit, ...]
    level: Ratio

    def named(self, state: LimitState) -> tuple[str, ...]:
        """Return the names of the limits in a state.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Limit, as_record, check_limits, identify
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t))
        >>> checked = check_limits(found, [Limit(of=1, quantity="zeta", least=0.2)])
        >>> checked.named(checked.rows[0].state)
        ('mode 1.zeta',)
        """
        return tuple(row.limit.name for row in self.rows if row.state is state)

    @property
    def passed(self) -> bool:
        """Whether every limit is met.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Limit, as_record, check_limits, eigenmodes, identify
        >>> t = np.arange(0, 4, 0.01)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t), timepts=t), modes=1)
        >>> check_limits(found, [Limit(of=1, quantity="zeta", least=0.01)]).passed
        True
        """
        return len(self.named(LimitState.MET)) == len(self.rows)

    @property
    def verdict(self) -> Verdict:
        """How many limits are met, and each of them.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Limit, as_record, check_limits, identify
        >>> t = np.arange(400) / 100
        >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        >>> found = identify(as_record(np.exp(-t) * np.cos(20 * t) + noise, timepts=t))
        >>> checked = check_limits(found, [Limit(of=1, quantity="zeta", least=0.2)])
        >>> checked.verdict.level.label
        'doubtful'
        """
        met, missed, open_ = (len(self.named(state)) for state in LimitState)
        numbers = {"limits": len(self.rows), "met": met, "missed": missed, "open": open_}
        return Verdict(Remark(LimitHeadline.JUDGED, numbers), tuple(row.check for row in self.rows))

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "limit": [row.limit.name for row in self.rows],
            "least": [row.limit.least / row.limit.scale for row in self.rows],
            "most": [row.limit.most / row.limit.scale for row in self.rows],
            "value": [row.value / row.limit.scale for row in self.rows],
            "lower": [row.lower / row.limit.scale for row in self.rows],
            "upper": [row.upper / row.limit.scale for row in self.rows],
            "unit": [row.limit.unit for row in self.rows],
            "state": [str(row.state) for row in self.rows],
        }

    def __str__(self) -> str:
        table = text_table(
            {
                "limit": [row.limit.name for row in self.rows],
                "unit": [row.limit.unit for row in self.rows],
                "asked": [str(row.limit) for row in self.rows],
                "found": [_found(row) for row in self.rows],
                f"{100 * self.level:g} % interval": [_interval(row) for row in self.rows],
                "": [str(row.state) for row in self.rows],
            },
            widest=TERMINAL,
        )
        why = [f"{row.limit.name}: {row.why}" for row in self.rows if row.why is not None]
        return "\n".join([f"{self.verdict.headline}", table, *why])


def _found(row: CheckedLimit) -> str:
    """Return the value with the digits that its interval leaves."""
    if math.isnan(row.value):
        return ""
    if not row.upper > row.lower:
        return figures_of(row.value / row.limit.scale, 5)
    half = (row.upper - row.lower) / 2 / row.limit.scale
    return rounded(np.array([row.value / row.limit.scale]), np.array([half]))[0]


def _interval(row: CheckedLimit) -> str:
    """Return the ends with the digits that tell them apart."""
    if math.isnan(row.lower):
        return ""
    ends = bound_columns([(row.lower / row.limit.scale, row.upper / row.limit.scale)])
    return f"{ends['lower'][0]} to {ends['upper'][0]}"
