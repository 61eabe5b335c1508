"""Loss of damping of a damper: the interval of a ratio, and the rule of wear.

Drives give ratios to the mass, and a damper is softer when it is warm: estimates of different days differ by more than
their own errors. A load changes k and c alike; so the change of the spring, which hardly wears, says how much of that
of the damper is load. With ``R = (c / c_0) (k / k_0)^-b``, a share x that remains is in the interval if
``(R - x)^2 <= z^2 (a - 2 g x + s^2 x^2)``: a and g are the errors of the new estimate, s^2 those of the reference and
of what differs from drive to drive. The interval is sound down to dampers that have nothing left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from suspid.errors import InputError
from suspid.units import Ratio, RealArray
from suspid.words.wear import DamperState

# Earlier drives from which on their own scatter is taken in place of the stated one: with five degrees of freedom the
# interval is about half as wide again.
ENOUGH_DRIVES = 6
TESTS = 2  # of one damper, which share the rate of the rule: its loss, and the phase of its wheel


@dataclass(frozen=True, kw_only=True, slots=True)
class WearRule:
    """What is assumed of drives, and what is asked of verdicts; all values are ratios.

    Parameters
    ----------
    damper_std : float
        Standard deviation of one damper's rate from drive to drive, by its temperature [1].
    spring_std : float
        The same of a spring's rate.
    load_std : float
        The same of the mass that the estimate takes as known: luggage and passengers.
    nominal_std : float
        Standard deviation of new springs and dampers about their nominal values [1].
    small, large : float
        A damper is worn if it has certainly lost more than ``small``, and not good unless a loss of ``large`` is
        excluded [1].
    rate : float
        Largest probability that a damper which lost no more than ``small`` is called worn, or one that lost ``large``
        or more is called good [1].

    Raises
    ------
    InputError
        If a value is no ratio, or ``small`` is not below ``large``.

    Examples
    --------
    >>> WearRule(damper_std=0.02).rate
    0.005
    """

    damper_std: Ratio = 0.03
    spring_std: Ratio = 0.01
    load_std: Ratio = 0.10
    nominal_std: Ratio = 0.05
    small: Ratio = 0.10
    large: Ratio = 0.30
    rate: Ratio = 0.005

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if not (isinstance(value, int | float | np.number) and 0 <= value < 1):
                raise InputError(f"{each.name} = {value!r} must be a ratio from 0 to below 1, such as {each.default}")
        if not self.small < self.large or not 0 < self.rate < 0.5:
            raise InputError(
                f"small = {self.small} must be below large = {self.large}, and rate = {self.rate} below 0.5"
            )

    def state(self, low: Ratio, high: Ratio) -> DamperState:
        """Return what an interval of the loss says.

        Examples
        --------
        >>> [str(WearRule().state(*ends)) for ends in [(-0.1, 0.2), (0.2, 0.4), (0.05, 0.2), (-0.2, 0.4)]]
        ['good', 'worn', 'watch', 'cannot tell']
        """
        if low > self.small:
            return DamperState.WORN
        if high < -self.small:  # it has gained
            return DamperState.WATCH
        if high < self.small:
            return DamperState.GOOD
        if low > 0:
            return DamperState.WATCH
        return DamperState.GOOD if high < self.large else DamperState.CANNOT_TELL


@dataclass(frozen=True, kw_only=True, slots=True)
class Rates:
    """Damping and stiffness of a strut in one estimate, with their covariance; stiffness 0 where it was not found."""

    damping: float
    stiffness: float
    covariance: RealArray  # (2, 2)

    @property
    def relative(self) -> RealArray:
        """Covariance of the logarithms, (2, 2); 0 for a spring that was not found."""
        scale = np.array([1 / self.damping, 1 / self.stiffness if self.stiffness else 0.0])
        return np.asarray(self.covariance * np.outer(scale, scale))


@dataclass(frozen=True, kw_only=True, slots=True)
class Loss:
    """Share of its damping that a damper has lost [1]: value, and one-sided ends at the rate of the rule."""

    value: Ratio
    low: Ratio
    high: Ratio
    # Whether the spring changed by more than load and temperature explain; the interval then allows for both causes.
    spring: bool = False


def loss_of(now: Rates, before: Sequence[Rates], rule: WearRule, *, nominal: bool = False) -> Loss:
    """Return what a damper has lost since earlier estimates, or against its nominal rate.

    The tests of one damper share the rate of the rule.

    Examples
    --------
    >>> covariance = np.diag([5.0, 60.0]) ** 2
    >>> old = Rates(damping=1300.0, stiffness=22e3, covariance=covariance)
    >>> new = Rates(damping=910.0, stiffness=22e3, covariance=covariance)
    >>> loss = loss_of(new, [old], WearRule())
    >>> round(loss.value, 3), round(loss.low, 2), round(loss.high, 2)
    (0.3, 0.2, 0.38)
    """
    from scipy.special import ndtri

    quantile = float(-ndtri(rule.rate / TESTS))
    loads = rule.load_std**2 * (1 + (0 if nominal else 1 / len(before)))
    springs, gap = _spring_variance(now, before, rule, nominal=nominal)
    told = now.stiffness > 0 and all(one.stiffness > 0 for one in before)
    share = loads / (loads + springs) if told and loads > 0 else 0.0
    loss = _interval(now, before, rule, share, nominal=nominal)
    if not told or abs(gap) <= quantile * np.sqrt(loads + springs):
        return loss
    alone = _interval(now, before, rule, 0.0, nominal=nominal)
    return Loss(value=loss.value, low=min(loss.low, alone.low), high=max(loss.high, alone.high), spring=True)


def _spring_variance(now: Rates, before: Sequence[Rates], rule: WearRule, *, nominal: bool) -> tuple[float, float]:
    """Return the variance of the change of a spring's logarithm without load, and the change."""
    count = len(before)
    if not now.stiffness or not all(one.stiffness for one in before):
        return 0.0, 0.0
    own = float(now.relative[1, 1]) + sum(float(one.relative[1, 1]) for one in before) / count**2
    between = rule.spring_std**2 * (1 if nominal else 1 + 1 / count) + (rule.nominal_std**2 if nominal else 0.0)
    gap = float(np.log(now.stiffness) - np.mean([np.log(one.stiffness) for one in before]))
    return own + between, gap


def _interval(now: Rates, before: Sequence[Rates], rule: WearRule, share: float, *, nominal: bool) -> Loss:
    """Return the loss if ``share`` of the change of the spring is that of the mass."""
    from scipy import stats

    count, spread = len(before), np.array([1.0, -share])
    fresh = 1.0 if nominal else 1 + 1 / count
    logs = np.array([np.log(one.damping) - (share * np.log(one.stiffness) if share else 0.0) for one in before])
    scale = float(np.exp(np.mean(logs))) * (now.stiffness**share if share else 1.0)
    R = now.damping / scale
    a = float(now.covariance[0, 0]) / scale**2
    g = share * float(now.covariance[0, 1]) / (scale * now.stiffness) if share else 0.0
    if count >= ENOUGH_DRIVES:
        s2 = float(np.var(logs, ddof=1)) * fresh
        z = float(stats.t.isf(rule.rate / TESTS, count - 1))
    else:
        z = float(stats.norm.isf(rule.rate / TESTS))
        s2 = sum(float(spread @ one.relative @ spread) for one in before) / count**2
        s2 += fresh * (rule.damper_std**2 + (share * rule.spring_std) ** 2 + ((1 - share) * rule.load_std) ** 2)
        s2 += (1 + share**2) * rule.nominal_std**2 if nominal else 0.0
    if share:
        s2 += share**2 * float(now.relative[1, 1])
    A, B, C = 1 - z**2 * s2, R - z**2 * g, R**2 - z**2 * a
    if A <= 0:
        return Loss(value=1 - R, low=-np.inf, high=1.0)
    root = float(np.sqrt(max(B**2 - A * C, 0.0)))
    return Loss(value=1 - R, low=1 - (B + root) / A, high=1 - max((B - root) / A, 0.0))
