"""Checks of a damper: its loss, the phase of its wheel, and both estimates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from suspid.greybox import Estimate
from suspid.performance.grips import PHASE_LIMIT, Grip
from suspid.performance.losses import Loss, Rates, WearRule
from suspid.performance.wears import DamperWear
from suspid.words import Check, DamperState, Level, Number, Remark, Verdict, WearCheck, WearHeadline
from suspid.words.grip import GripCheck

# What a state says of the result; worn is as much a finding as good, and both are read with their reasons.
LEVELS = {
    DamperState.GOOD: Level.SOUND,
    DamperState.WATCH: Level.CARE,
    DamperState.WORN: Level.CARE,
    DamperState.CANNOT_TELL: Level.DOUBTFUL,
}


def untrusted(now: Estimate, earlier: Sequence[Estimate]) -> Iterator[Check]:
    """Yield which estimates cannot be built upon."""
    for which, one in (("now", now), *(("before", old) for old in earlier)):
        if one.verdict.level <= Level.DOUBTFUL:
            yield Check(Remark(WearCheck.UNTRUSTED, {"which": which, "level": one.verdict.level.label}), Level.DOUBTFUL)


def stayed_nominal(after: Grip | None) -> Iterator[Check]:
    """Yield what the grip beside the wear rests on that was not found."""
    for check in () if after is None else after.verdict.checks:
        if check.remark.code is GripCheck.STAYED_NOMINAL:
            yield Check(check.remark, Level.NOTE)


def said_of_loss(
    damper: str, loss: Loss, state: DamperState, rule: WearRule, now: Rates, before: Sequence[Rates]
) -> Iterator[Check]:
    """Yield what the loss says of a damper."""
    numbers: dict[str, Number] = {
        "damper": damper, "loss": loss.value, "low": loss.low, "high": loss.high, "small": rule.small,
        "large": rule.large, "gain": -loss.high,
    }  # fmt: skip
    code = {
        DamperState.WORN: WearCheck.LOST,
        DamperState.WATCH: WearCheck.GAINED if loss.high < 0 else WearCheck.SOME,
        DamperState.GOOD: WearCheck.HOLDS,
        DamperState.CANNOT_TELL: WearCheck.WIDE,
    }[state]
    yield Check(Remark(code, numbers), LEVELS[state])
    if loss.spring:
        change = now.stiffness / float(np.mean([one.stiffness for one in before])) - 1
        yield Check(Remark(WearCheck.SPRING, {"damper": damper, "change": change}), Level.CARE)


def said_of_phase(
    damper: str, wheel: str, before: Grip | None, after: Grip | None, quantile: float
) -> tuple[Check, DamperState] | None:
    """Return what the least phase of a damper's wheel says; None where the damper is so strong that it says nothing."""
    if before is None or after is None:
        return None
    i = after.wheels.index(wheel)
    value, std, old = after.phase[i], after.phase_std[i], before.phase[i]
    if after.stiff[i]:
        return None
    low, high = value - quantile * std, value + quantile * std
    numbers: dict[str, Number] = {
        "damper": damper, "wheel": wheel, "phase": float(np.degrees(value)), "before": float(np.degrees(old)),
        "limit": float(np.degrees(PHASE_LIMIT)),
    }  # fmt: skip
    if low >= PHASE_LIMIT:
        code, state = WearCheck.PHASE_PASSES, DamperState.GOOD
    elif high >= PHASE_LIMIT:
        code, state = WearCheck.PHASE_NEAR, DamperState.WATCH
    elif old < PHASE_LIMIT:
        code, state = WearCheck.PHASE_AS_BEFORE, DamperState.WATCH
    else:
        code, state = WearCheck.PHASE_FAILS, DamperState.WORN
    return Check(Remark(code, numbers), LEVELS[state]), state


def worst(by_loss: DamperState, by_phase: DamperState) -> DamperState:
    """Return the graver of two states; a phase that is certainly high does not make up for a loss that is not known."""
    order = (DamperState.WORN, DamperState.WATCH, DamperState.CANNOT_TELL, DamperState.GOOD)
    return min(by_loss, by_phase, key=order.index)


def verdict_of(
    dampers: Sequence[DamperWear], doubts: Sequence[Check], rule: WearRule, against: str, *, by_curve: Sequence[str]
) -> Verdict:
    """Return the verdict on all dampers; doubts about estimates are notes where every damper is judged by its curve."""
    if len(by_curve) == len(dampers):
        doubts = [Check(Remark(WearCheck.NOT_USED, dict(check.remark.numbers)), Level.NOTE) for check in doubts]
    texts = tuple(f"{one.damper} {one.state}" for one in dampers)
    numbers: dict[str, Number] = {
        "small": rule.small, "large": rule.large, "rate": rule.rate, "against": against, "damper": rule.damper_std,
        "spring": rule.spring_std, "load": rule.load_std, "nominal": rule.nominal_std,
    }  # fmt: skip
    checks = [check for one in dampers for check in one.checks]
    return Verdict(
        Remark(WearHeadline.DAMPERS, {"texts": texts}),
        (*doubts, *checks, Check(Remark(WearCheck.RATES, numbers), Level.NOTE)),
    )
