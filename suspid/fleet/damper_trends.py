"""Trends of dampers: the loss of each damper of each vehicle over its drives, by the rule of wear."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.fleet.trends import Measured, trends_of
from suspid.greybox import Estimate
from suspid.model import Suspension
from suspid.performance import LEVELS, Loss, Rates, WearRule, dampers_between, dampers_of, rates_of
from suspid.results import Result
from suspid.text_tables import TERMINAL, text_table
from suspid.values import MOST_NAMES
from suspid.words import Check, DamperState, Level, Remark, TrendCheck, TrendHeadline, Verdict

# Between a vehicle and its damper in the name of a trend; no name of a strut has a dot.
BETWEEN = "."
# States of dampers in the order in which a reader needs them.
GRAVEST = (DamperState.WORN, DamperState.WATCH, DamperState.CANNOT_TELL, DamperState.GOOD)


@dataclass(frozen=True, kw_only=True, slots=True)
class DamperTrend:
    """The loss of one damper over its drives.

    Parameters
    ----------
    vehicle, damper : str
        The vehicle, and the damper's strut.
    drives : int
        How many drives.
    span : float
        Time from first to last.
    loss : Loss
        Share of its damping that it has lost over this time, with its ends at the rate of the rule.
    scatter : float
        Standard deviation from drive to drive [1], beyond the errors of the estimates.
    state : DamperState
        Good, watch, worn or cannot tell.
    """

    vehicle: str
    damper: str
    drives: int
    span: float
    loss: Loss
    scatter: float
    state: DamperState


@dataclass(frozen=True, kw_only=True, slots=True, repr=False)
class DamperTrends(Result):
    """Result of `damper_trends`, the gravest first; ``str()`` is the table.

    Examples
    --------
    >>> from suspid import damper_trends, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3,
    ...                   tire_stiffness=210e3, chassis_damping=1300)
    >>> record = free_decay(car, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
    >>> record.outputs[:] += 1e-4 * np.random.default_rng(1).standard_normal(record.outputs.shape)
    >>> found = estimate(record, car, fixed=["tire.damping"])
    >>> trends = damper_trends([("VAN 7", year, found) for year in (2022.0, 2023.0, 2024.0, 2025.0)])
    >>> [(one.vehicle, one.damper, str(one.state)) for one in trends.trends]
    [('VAN 7', 'chassis', 'good')]
    """

    trends: tuple[DamperTrend, ...]
    rule: WearRule

    @property
    def doubtful(self) -> DamperTrends:
        """Those that are not good.

        Examples
        --------
        >>> from suspid import damper_trends, estimate, free_decay, quarter_car
        >>> car = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3,
        ...                   tire_stiffness=210e3, chassis_damping=1300)
        >>> record = free_decay(car, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
        >>> record.outputs[:] += 1e-4 * np.random.default_rng(1).standard_normal(record.outputs.shape)
        >>> found = estimate(record, car, fixed=["tire.damping"])
        >>> damper_trends([("VAN 7", year, found) for year in (2022.0, 2023.0, 2024.0, 2025.0)]).doubtful.trends
        ()
        """
        return replace(self, trends=tuple(one for one in self.trends if one.state is not DamperState.GOOD))

    @property
    def verdict(self) -> Verdict:
        """Which dampers are worn, to watch, good or cannot be told: a check for each state.

        Examples
        --------
        >>> from suspid import WearRule
        >>> from suspid.fleet import DamperTrends
        >>> DamperTrends(trends=(), rule=WearRule()).verdict.level.label
        'none'
        """
        headline = Remark(TrendHeadline.DAMPERS, {"dampers": len(self.trends)})
        if not self.trends:
            return Verdict(headline, (Check(Remark(TrendCheck.NOTHING), Level.NONE),))
        names = {state: tuple(f"{o.vehicle} {o.damper}" for o in self.trends if o.state is state) for state in GRAVEST}
        checks = (
            Check(Remark(TrendCheck(state.value), {"names": some}), LEVELS[state]) for state, some in names.items()
        )
        return Verdict(headline, tuple(check for check in checks if check.remark.numbers["names"]))

    def _table(self) -> Mapping[str, Sequence[object]]:
        return {
            "vehicle": [one.vehicle for one in self.trends],
            "damper": [one.damper for one in self.trends],
            "drives": [one.drives for one in self.trends],
            "verdict": [str(one.state) for one in self.trends],
            "loss": [one.loss.value for one in self.trends],
            "loss_lower": [one.loss.low for one in self.trends],
            "loss_upper": [one.loss.high for one in self.trends],
            "scatter": [one.scatter for one in self.trends],
        }

    def _brief(self) -> str:
        lost = [f"{one.vehicle} {one.damper} {one.state}" for one in self.trends]
        more = [f"and {len(lost) - MOST_NAMES} more"] if len(lost) > MOST_NAMES else []
        return ", ".join([*lost[:MOST_NAMES], *more]) or str(self)

    def __str__(self) -> str:
        return f"{losses_table(self)}\n\n{self.verdict}" if self.trends else str(TrendCheck.NOTHING.words)


def losses_table(found: DamperTrends) -> str:
    """Return the losses of dampers with their intervals as a table of text."""
    percent = f"{100 * (1 - found.rule.rate):g} % certain"
    return text_table(
        {
            "vehicle": [one.vehicle for one in found.trends],
            "damper": [one.damper for one in found.trends],
            "tests": [str(one.drives) for one in found.trends],
            "verdict": [str(one.state) for one in found.trends],
            "lost": [f"{one.loss.value:z.1%}" for one in found.trends],
            f"at least, {percent}": [f"{one.loss.low:z.1%}" for one in found.trends],
            "at most": [f"{one.loss.high:z.1%}" for one in found.trends],
            "scatter": [f"{one.scatter:.1%}" for one in found.trends],
        },
        widest=TERMINAL,
    )


@explained
def damper_trends(drives: Iterable[tuple[str, float, Estimate]], *, rule: WearRule | None = None) -> DamperTrends:
    """Return what each damper of each vehicle has lost over its drives.

    A straight line is drawn through the logarithm of damping over stiffness of the parallel spring, in which a load
    that is not described cancels. Scatter from drive to drive (temperature) is estimated from all dampers of all
    vehicles but those that scatter improbably more, so its stated values in the rule are not used. The verdict is that
    of `wear`, by the loss between the first and the last drive.

    Parameters
    ----------
    drives : iterable of (str, float, Estimate)
        Vehicle, time (years, or a mileage) and estimate of each drive, in any order.
    rule : WearRule, optional
        What is asked of the verdicts.

    Returns
    -------
    DamperTrends
        A trend of each damper that was found in at least four drives of a vehicle.

    Raises
    ------
    InputError
        If a drive is of another form.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> new = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3,
    ...                   tire_stiffness=210e3, chassis_damping=1300)
    >>> drives = []
    >>> for number, damping in enumerate((1300, 1280, 1150, 1120, 1000, 960)):
    ...     car = new.with_parameters(damping={"chassis": damping})
    ...     record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    ...     noisy = add_noise(record, snr_db=30.0, rng=np.random.default_rng(number))
    ...     drives.append(("VAN 7", 2024 + number / 4, estimate(noisy, new, fixed=["tire.damping"])))
    >>> [(one.damper, str(one.state)) for one in damper_trends(drives).trends]
    [('chassis', 'worn')]
    """
    asked = WearRule() if rule is None else rule
    return trends_of_rates(
        ((vehicle, damper, when, rates) for vehicle, when, found in drives for damper, rates in _checked(found)), asked
    )


def trends_of_rates(rows: Iterable[tuple[str, str, float, Rates]], rule: WearRule) -> DamperTrends:
    """Return the trends of vehicle, damper, time and rates of each drive; rows without a damping are left out."""
    from scipy import stats

    tests: dict[str, list[tuple[float, float, float]]] = {}
    for vehicle, damper, when, rates in rows:
        if rates.damping > 0:
            weights = np.array([1.0, -1.0 if rates.stiffness > 0 else 0.0])
            value = float(np.log(rates.damping) - (np.log(rates.stiffness) if rates.stiffness > 0 else 0.0))
            std = float(np.sqrt(max(weights @ rates.relative @ weights, 0.0)))
            tests.setdefault(f"{vehicle}{BETWEEN}{damper}", []).append((when, value, std))
    measured: dict[str, Measured] = {name: _columns(rows) for name, rows in tests.items()}
    found = []
    for trend in trends_of("damping", measured, pooled=True):
        vehicle, _, damper = trend.vehicle.rpartition(BETWEEN)
        change, reach = trend.end - trend.start, float(stats.t.isf(rule.rate, trend.freedom)) * trend.std
        low, value, high = (float(-np.expm1(change + side * reach)) for side in (1, 0, -1))
        found.append(
            DamperTrend(
                vehicle=vehicle,
                damper=damper,
                drives=trend.count,
                span=trend.span,
                loss=Loss(value=value, low=low, high=high),
                scatter=trend.scatter,
                state=rule.state(low, high),
            )
        )
    found.sort(key=lambda one: (GRAVEST.index(one.state), -one.loss.value, one.vehicle, one.damper))
    return DamperTrends(trends=tuple(found), rule=rule)


def trends_of_table(
    rows: Iterable[tuple[str, str, float, float]],
    vehicles: Mapping[str, tuple[str, float]],
    car: Suspension,
    rule: WearRule | None = None,
) -> DamperTrends:
    """Return the trends of the dampers of a car from rows of record, parameter, value and standard deviation.

    ``vehicles`` has vehicle and time of each record. Rows hold no covariance of k and c, which is taken as 0.
    """
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for record, parameter, value, std in rows:
        if record in vehicles and np.isfinite(value):
            found.setdefault(record, {})[parameter] = value, float(np.nan_to_num(std))
    nothing = 0.0, 0.0
    measured = []
    for record, values in found.items():
        for name in [strut.name for strut in dampers_between(car) if f"{strut.name}.damping" in values]:
            (c, c_std), (k, k_std) = values[f"{name}.damping"], values.get(f"{name}.stiffness", nothing)
            rates = Rates(damping=c, stiffness=max(k, 0.0), covariance=np.diag([c_std, k_std]) ** 2)
            measured.append((vehicles[record][0], name, vehicles[record][1], rates))
    return trends_of_rates(measured, WearRule() if rule is None else rule)


def _columns(rows: list[tuple[float, float, float]]) -> Measured:
    time, value, std = np.array(rows, float).T
    return time, value, std


def _checked(found: object) -> list[tuple[str, Rates]]:
    """Return the dampers of a drive with their rates."""
    if not isinstance(found, Estimate):
        raise InputError(f"a drive is (vehicle, time, Estimate), but its last part is of type {type(found).__name__}")
    return [(strut.name, rates_of(found, strut.name)) for strut in dampers_of(found)]
