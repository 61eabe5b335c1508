"""Check a result against limits: met, not met, or cannot tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.analysis.analysis import Analysis
from suspid.analysis.limits import OF_STRUTS, Limit
from suspid.arguments import explained
from suspid.errors import InputError
from suspid.greybox import Estimate
from suspid.identification import Identification, Repeats
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.model import ModalSet
from suspid.reconstruction import Reconstruction, parameter_values
from suspid.results import Result, check_kind
from suspid.text_tables import text_table
from suspid.units import Ratio
from suspid.values import nearest_names
from suspid.words import Check, Level, Number, Remark, Verdict
from suspid.words.limits import LimitHeadline, LimitReason, LimitState

# A mode that is meant by its frequency lies within this factor of it: an octave.
OCTAVE = 2.0
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
                "found": ["" if math.isnan(row.value) else f"{row.value / row.limit.scale:.5g}" for row in self.rows],
                f"{100 * self.level:g} % interval": [_interval(row) for row in self.rows],
                "": [str(row.state) for row in self.rows],
            }
        )
        why = [f"{row.limit.name}: {row.why}" for row in self.rows if row.why is not None]
        return "\n".join([f"{self.verdict.headline}", table, *why])


def _interval(row: CheckedLimit) -> str:
    if math.isnan(row.lower):
        return ""
    return f"{row.lower / row.limit.scale:.5g} to {row.upper / row.limit.scale:.5g}"


@explained
def check_limits(
    found: Analysis | Estimate | Reconstruction | Identification | Repeats,
    limits: Sequence[Limit],
    *,
    level: Ratio = LEVEL,
) -> CheckedLimits:
    """Check each limit against the interval of the result: met, not met, or cannot tell.

    A limit is met if the whole interval lies within it, and not met if the whole interval lies outside. It is undecided
    where the interval contains the limit, where there is no interval, where the value was fixed, where the result is
    doubtful, and where other springs and dampers explain the data as well and lie on the other side.

    Parameters
    ----------
    found : Analysis, Estimate, Reconstruction, Identification or Repeats
        What was found.
    limits : sequence of Limit
        The limits; `read_limits` reads them from a file.
    level : float
        Probability of the intervals [1].

    Returns
    -------
    CheckedLimits
        A row for each limit.

    Raises
    ------
    InputError
        If there is no strut of a name, or the level is not between 0 and 1.

    Examples
    --------
    >>> from suspid import add_noise, free_decay, identify, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> found = identify(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)))
    >>> asked = [Limit(of=1, quantity="zeta", least=0.2), Limit(of=2, quantity="zeta", least=0.3)]
    >>> [str(row.state) for row in check_limits(found, asked).rows]
    ['met', 'not met']
    """
    check_kind(
        found,
        {
            "Analysis": "analyse",
            "Estimate": "estimate",
            "Reconstruction": "reconstruct",
            "Identification": "identify",
            "Repeats": "identify_repeats",
        },
    )
    check_level(level)
    springs = _springs_of(found)
    modes = None if isinstance(found, Reconstruction) else found.modes
    if springs is not None:
        names = [strut.name for strut in springs.suspension.struts]
        for limit in limits:
            if limit.quantity in OF_STRUTS and limit.of not in names:
                raise InputError(f"limits: there is no strut {limit.of!r}.{nearest_names(str(limit.of), names)}")
    doubtful = found.verdict.level <= Level.DOUBTFUL
    rows = [
        _of_strut(limit, springs, level) if limit.quantity in OF_STRUTS else _of_mode(limit, modes, level)
        for limit in limits
    ]
    return CheckedLimits(rows=tuple(_doubtful(row) if doubtful else row for row in rows), level=level)


def _springs_of(found: object) -> Estimate | Reconstruction | None:
    if isinstance(found, Analysis):
        return found.estimate or found.reconstruction
    return found if isinstance(found, Estimate | Reconstruction) else None


def _doubtful(row: CheckedLimit) -> CheckedLimit:
    if row.state is LimitState.OPEN:
        return row
    return _open(row.limit, LimitReason.DOUBTFUL, row.value, (row.lower, row.upper))


def _open(
    limit: Limit,
    why: LimitReason,
    value: float = math.nan,
    ends: tuple[float, float] = (math.nan, math.nan),
    *,
    numbers: Mapping[str, Number] | None = None,
) -> CheckedLimit:
    """Return the row of a limit that cannot be judged."""
    return CheckedLimit(
        limit=limit, value=value, lower=ends[0], upper=ends[1], state=LimitState.OPEN, why=Remark(why, numbers or {})
    )


def _judged(limit: Limit, value: float, ends: tuple[float, float]) -> CheckedLimit:
    """Return the row of a value with its interval."""
    low, high = ends
    if limit.least <= low and high <= limit.most:
        state = LimitState.MET
    elif high < limit.least or low > limit.most:
        state = LimitState.MISSED
    else:
        margin = min(abs(value - limit.least), abs(value - limit.most))
        reach = max(high - value, value - low)
        # The interval of n tests is shorter by the root of n.
        tests = math.ceil((reach / margin) ** 2) if margin > 0.01 * reach else 0
        return _open(limit, LimitReason.INTERVAL, value, ends, numbers={"tests": tests})
    return CheckedLimit(limit=limit, value=value, lower=low, upper=high, state=state)


def _of_mode(limit: Limit, modes: ModalSet | None, level: Ratio) -> CheckedLimit:
    count = 0 if modes is None else len(modes)
    k = None if modes is None else _mode_meant(limit, modes)
    if modes is None or k is None:
        which = f"near {limit.near:g} Hz" if limit.near is not None else f"{limit.of}"
        return _open(limit, LimitReason.NO_MODE, numbers={"which": which, "found": count})
    value = float(getattr(modes, limit.quantity)[k])
    if modes.covariance is None:
        return _open(limit, LimitReason.NO_INTERVAL, value)
    low, high = getattr(modes.interval(level), limit.quantity)[k]
    if not np.isfinite(low + high):
        return _open(limit, LimitReason.NO_INTERVAL, value)
    return _judged(limit, value, (float(low), float(high)))


def _mode_meant(limit: Limit, modes: ModalSet) -> int | None:
    """Return which mode a limit means, from 0 on."""
    if limit.near is None:
        return int(limit.of) - 1 if int(limit.of) <= len(modes) else None
    far = np.abs(np.log(np.maximum(modes.wn, 1e-300) / (2 * np.pi * limit.near)))
    return int(np.argmin(far)) if len(modes) and np.min(far) <= np.log(OCTAVE) else None


def _of_strut(limit: Limit, springs: Estimate | Reconstruction | None, level: Ratio) -> CheckedLimit:
    if springs is None:
        return _open(limit, LimitReason.NO_SPRINGS)
    value = parameter_values(springs.suspension)[limit.name]
    if limit.name not in springs.parameters:
        return _open(limit, LimitReason.HELD, value)
    if springs.covariance is None:
        return _open(limit, LimitReason.NO_INTERVAL, value)
    ends = springs.interval(level)[limit.name]
    if not springs.explains:
        return _open(limit, LimitReason.UNEXPLAINED, value, ends)
    row = _judged(limit, value, ends)
    std = float(np.sqrt(np.diag(springs.covariance))[springs.parameters.index(limit.name)])
    reach = normal_reach(level) * std
    others = (parameter_values(car)[limit.name] for car in springs.alternatives)
    if any(_judged(limit, other, (other - reach, other + reach)).state is not row.state for other in others):
        return _open(limit, LimitReason.ALTERNATIVE, value, ends)
    return row
