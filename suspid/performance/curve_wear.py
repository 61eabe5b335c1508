"""Wear of dampers that are not viscous: their curves compared by the damping of equal work at one amplitude."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from suspid.greybox import DamperCurve
from suspid.performance.losses import TESTS, Rates, WearRule, loss_of
from suspid.performance.wear_checks import LEVELS, said_of_loss
from suspid.performance.wears import DamperWear
from suspid.units import MetrePerSecond
from suspid.words import Check, DamperState, Level, Number, Remark, WearCheck


def bent(curve: DamperCurve | None) -> bool:
    """Return whether a curve holds and is no line."""
    return curve is not None and curve.explains and not curve.linear


def curve_named(curves: Sequence[DamperCurve], damper: str) -> DamperCurve | None:
    """Return the curve of a damper that explains its records and damps; None if there is none."""
    fit = (one for one in curves if one.name == damper and one.explains)
    return next((one for one in fit if one.equivalent_damping() > 0), None)


def wear_by_curve(
    damper: str, now: DamperCurve, before: Sequence[DamperCurve], rule: WearRule, wheel: str | None
) -> DamperWear:
    """Return the wear of a damper by its curve, against curves of earlier drives at the least amplitude of all."""
    amplitude = min(float(np.sqrt(2) * one.velocity_std) for one in (now, *before))
    new, rates = rates_at(now, amplitude), [rates_at(one, amplitude) for one in before]
    loss = loss_of(new, rates, rule, tests=TESTS)
    state = rule.state(loss.low, loss.high)
    by = Remark(WearCheck.BY_CURVE, {"damper": damper, "amplitude": amplitude, "damping": new.damping})
    return DamperWear(
        damper=damper,
        state=state,
        damping=new.damping,
        reference=new.damping / (1 - loss.value) if loss.value < 1 else rates[-1].damping,
        loss=loss,
        wheel=wheel,
        checks=(*said_of_loss(damper, loss, state, rule, new, rates), Check(by, Level.NOTE)),
    )


def said_of_bent(damper: str, curve: DamperCurve) -> Check:
    """Return why the wear of a damper that is not viscous cannot be told without an earlier curve."""
    numbers: dict[str, Number] = {
        "damper": damper,
        "amplitude": float(np.sqrt(2) * curve.velocity_std),
        "damping": curve.equivalent_damping(),
    }
    return Check(Remark(WearCheck.BENT, numbers), LEVELS[DamperState.CANNOT_TELL])


def rates_at(curve: DamperCurve, amplitude: MetrePerSecond) -> Rates:
    """Return the damping of equal work at an amplitude of the velocity and the stiffness, with their covariance."""
    work = np.append(0.0, curve.work_of(amplitude))
    spring = np.eye(len(work))[0]
    both = np.vstack([work, spring])
    return Rates(
        damping=curve.equivalent_damping(amplitude),
        stiffness=max(curve.stiffness, 0.0),
        covariance=np.asarray(both @ curve.covariance @ both.T),
    )
