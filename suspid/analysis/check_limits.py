"""Check a result against limits: met, not met, or cannot tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from suspid.analysis.analysis import Analysis
from suspid.analysis.checked_limits import CheckedLimit, CheckedLimits
from suspid.analysis.limits import OF_STRUTS, Limit
from suspid.arguments import explained
from suspid.errors import InputError
from suspid.greybox import Estimate
from suspid.identification import Identification, Repeats
from suspid.levels import LEVEL, check_level, normal_reach
from suspid.model import ModalSet
from suspid.reconstruction import Reconstruction, parameter_values
from suspid.results import check_kind
from suspid.units import Ratio
from suspid.values import nearest_names
from suspid.words import Level, Number, Remark
from suspid.words.limits import LimitReason, LimitState


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
    # A mode that is meant by its frequency lies within an octave of it.
    far = np.abs(np.log(np.maximum(modes.wn, 1e-300) / (2 * np.pi * limit.near)))
    return int(np.argmin(far)) if len(modes) and np.min(far) <= np.log(2) else None


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
