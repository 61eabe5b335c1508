"""Wear of dampers that are not viscous: their curves compared by the damping of equal work at one amplitude."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from suspid.greybox import DamperCurve
from suspid.performance.losses import Rates, WearRule, loss_of
from suspid.performance.wear_checks import LEVELS, said_of_loss
from suspid.performance.wears import DamperWear
from suspid.units import MetrePerSecond
from suspid.words import Check, DamperState, Level, Number, Remark, WearCheck

# Largest share of the force by which a residual may follow the motion, over the scatter of dampers from drive to drive.
MOST_FOLLOWED = 1 / 3
# Error of the stiffness over that share, and of the damping over it at most: where a sensor is 0.25 to 1 ms late, the
# stiffness is off by 1.5 to 2.3 times the share, the damping by half of it.
SPRING_TIMES = 2.0


def bent(curve: DamperCurve | None) -> bool:
    """Return whether a curve is no line."""
    return curve is not None and not curve.linear


def curve_named(curves: Sequence[DamperCurve], damper: str, rule: WearRule) -> DamperCurve | None:
    """Return the curve of a damper that damps and holds, as closely as wear needs it; None if there is none.

    What is missing in a curve, such as a delay of a sensor, leaves a residual that follows the motion. In long drives
    that is seen long before it matters beside what dampers differ by from drive to drive.
    """
    named = [one for one in curves if one.name == damper and one.equivalent_damping() > 0]
    return next((one for one in named if one.explains or one.followed <= MOST_FOLLOWED * rule.damper_std), None)


def wear_by_curve(
    damper: str, now: DamperCurve, before: Sequence[DamperCurve], rule: WearRule, wheel: str | None
) -> DamperWear:
    """Return the wear of a damper by its curve, against curves of earlier drives at the least amplitude of all."""
    amplitude = min(float(np.sqrt(2) * one.velocity_std) for one in (now, *before))
    new, rates = rates_at(now, amplitude), [rates_at(one, amplitude) for one in before]
    loss = loss_of(new, rates, rule)
    state = rule.state(loss.low, loss.high)
    by = Remark(WearCheck.BY_CURVE, {"damper": damper, "amplitude": amplitude, "damping": new.damping})
    return DamperWear(
        damper=damper,
        state=state,
        damping=new.damping,
        reference=new.damping / (1 - loss.value) if loss.value < 1 else rates[-1].damping,
        loss=loss,
        wheel=wheel,
        checks=(*said_of_loss(damper, loss, state, rule, new, rates), Check(by, Level.NOTE), *_said_of_misfit(now)),
    )


def _said_of_misfit(curve: DamperCurve) -> Iterator[Check]:
    """Yield that a residual follows the motion, by so little that it does not matter."""
    if not curve.explains:
        numbers: dict[str, Number] = {"damper": curve.name, "share": curve.followed}
        yield Check(Remark(WearCheck.FOLLOWS_LITTLE, numbers), Level.NOTE)


def said_of_bent(damper: str, curve: DamperCurve) -> Check:
    """Return why the wear of a damper that is not viscous cannot be told without an earlier curve."""
    numbers: dict[str, Number] = {
        "damper": damper,
        "amplitude": float(np.sqrt(2) * curve.velocity_std),
        "damping": curve.equivalent_damping(),
    }
    return Check(Remark(WearCheck.BENT, numbers), LEVELS[DamperState.CANNOT_TELL])


def rates_at(curve: DamperCurve, amplitude: MetrePerSecond) -> Rates:
    """Return the damping of equal work at an amplitude of the velocity and the stiffness, with their covariance.

    It contains what is missing in a curve whose residual follows the motion.
    """
    work = np.append(0.0, curve.work_of(amplitude))
    spring = np.eye(len(work))[0]
    both = np.vstack([work, spring])
    damping, stiffness = curve.equivalent_damping(amplitude), max(curve.stiffness, 0.0)
    missing = np.zeros(2) if curve.explains else curve.followed * np.array([damping, SPRING_TIMES * stiffness])
    return Rates(
        damping=damping,
        stiffness=stiffness,
        covariance=np.asarray(both @ curve.covariance @ both.T) + np.diag(missing**2),
    )
