"""The wear of the dampers of a car: the loss of each, the grip of its wheel, and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from suspid.levels import LEVEL
from suspid.performance.grips import Grip
from suspid.performance.losses import TESTS, Loss, WearRule
from suspid.results import Result, columns_of
from suspid.text_tables import TERMINAL, figures_of, rounded, spread, text_table
from suspid.units import NewtonSecondPerMetre, Ratio
from suspid.words import Check, DamperState, Verdict


@dataclass(frozen=True, kw_only=True, slots=True)
class DamperWear:
    """One damper.

    Parameters
    ----------
    damper : str
        Its strut.
    state : DamperState
        Good, watch, worn or cannot tell.
    damping, reference : float
        Rate found, and the one it is compared with [N s/m], which has the load of the new estimate.
    loss : Loss
        Share of its damping that it has lost, with its ends at the rate of the rule.
    wheel : str or None
        The wheel that it damps; None of a damper elsewhere, such as that of a seat.
    checks : tuple of Check
        What the state rests on.

    Examples
    --------
    >>> from suspid import DamperState
    >>> from suspid.performance import Loss
    >>> one = DamperWear(damper="chassis", state=DamperState.WORN, damping=900.0, reference=1500.0,
    ...                  loss=Loss(value=0.4, low=0.3, high=0.5), wheel="tire", checks=())
    >>> one.loss.value, str(one.state)
    (0.4, 'worn')
    """

    damper: str
    state: DamperState
    damping: NewtonSecondPerMetre
    reference: NewtonSecondPerMetre
    loss: Loss
    wheel: str | None
    checks: tuple[Check, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class ParameterChange:
    """A spring, a damper or a mass in two estimates.

    Parameters
    ----------
    name, unit : str
        The parameter, such as ``"front.damping"``, and its unit.
    before, after : float
        Its values; ``before`` is the nominal one where nothing was estimated before.
    low, high : float
        Ends of the 95 % interval of ``after / before - 1`` [1], by the errors of the estimates alone.
    significant : bool
        Whether the drives differ by more than the errors of the estimates explain in 95 % of comparisons, for all
        parameters together.
    """

    name: str
    unit: str
    before: float
    after: float
    low: Ratio
    high: Ratio
    significant: bool

    @property
    def change(self) -> Ratio:
        """``after / before - 1`` [1]."""
        return self.after / self.before - 1

    @property
    def in_percent(self) -> bool:
        """Whether a share says anything: the interval stays above -100 %, which nothing positive falls below."""
        return bool(self.low > -1 or not np.isfinite(self.low))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Wear(Result):
    """Result of `wear`; ``str()`` has the changes of springs and dampers, the grip before and after, and the verdict.

    Parameters
    ----------
    dampers : tuple of DamperWear
        Each damper that was estimated.
    changes : tuple of ParameterChange
        Each spring, damper and mass that was estimated.
    before : Grip or None
        Grip with the last of the earlier estimates, or of the nominal car; None of a car that has no wheel on a road.
    after : Grip or None
        Grip with the new estimate.
    rule : WearRule
        What was assumed.
    against : str
        ``"nominal"``, ``"earlier"``, or ``"history"`` where the scatter of earlier drives was used.
    verdict : Verdict
        The state of every damper, with the reasons.

    Examples
    --------
    >>> from suspid import estimate, free_decay, quarter_car, wear
    >>> new = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3,
    ...                   tire_stiffness=210e3, chassis_damping=1300)
    >>> worn = new.with_parameters(damping={"chassis": 700})
    >>> record = free_decay(worn, np.arange(0, 2, 0.01), initial_state={"v_tire": 1.0})
    >>> record.outputs[:] += 1e-4 * np.random.default_rng(1).standard_normal(record.outputs.shape)
    >>> found = wear(estimate(record, new, fixed=["tire.damping"]))
    >>> found.against, {name: str(state) for name, state in found.states.items()}
    ('nominal', {'chassis': 'worn'})
    """

    dampers: tuple[DamperWear, ...]
    changes: tuple[ParameterChange, ...]
    before: Grip | None
    after: Grip | None
    rule: WearRule
    against: str
    verdict: Verdict

    @property
    def states(self) -> dict[str, DamperState]:
        """The state of each damper.

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import add_noise, estimate, free_decay, quarter_car, wear
        >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
        ...                   tire_stiffness=200e3, chassis_damping=1500)
        >>> record = free_decay(car, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0})
        >>> found = estimate(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
        >>> wear(found).states
        {'chassis': <DamperState.GOOD: 'good'>}
        """
        return {one.damper: one.state for one in self.dampers}

    @property
    def certainty(self) -> Ratio:
        """Probability with which each end of a loss holds [1].

        Examples
        --------
        >>> import numpy as np
        >>> from suspid import Wear
        >>> from suspid.performance import WearRule
        >>> from suspid.words import Remark, Verdict
        >>> from suspid.words.wear import WearHeadline
        >>> Wear(dampers=(), changes=(), before=None, after=None, rule=WearRule(rate=0.02), against="nominal",
        ...      verdict=Verdict(Remark(WearHeadline.DAMPERS, {"texts": ()}))).certainty
        0.99
        """
        return 1 - self.rule.rate / TESTS

    def _table(self) -> Mapping[str, Sequence[object]]:
        return columns_of(self.changes, ["name", "unit", "before", "after", "change", "low", "high", "significant"])

    def _brief(self) -> str:
        lost = ", ".join(f"{one.damper} {one.state} ({one.loss.value:z.1%} lost)" for one in self.dampers)
        return f"{lost or 'no damper'}; against {self.against}"

    def __str__(self) -> str:
        reach = f"{100 * LEVEL:g} % interval"
        changes = {
            "parameter": [one.name for one in self.changes],
            "unit": [one.unit for one in self.changes],
            "before": [figures_of(one.before, 6) for one in self.changes],
            "after": [figures_of(one.after, 6) for one in self.changes],
            "change": [_percent(one.change) if one.in_percent else "" for one in self.changes],
            reach: [f"{_percent(one.low)} to {_percent(one.high)}" if one.in_percent else "" for one in self.changes],
            "significant": ["yes" if one.significant else "no" for one in self.changes],
        }
        parts = [text_table(changes, widest=TERMINAL)]
        if self.before is not None and self.after is not None:
            parts.append(text_table(_grips(self.before, self.after), widest=TERMINAL))
        sides = f"{100 * self.certainty:g} % certain"
        dampers = {
            "damper": [one.damper for one in self.dampers],
            "verdict": [str(one.state) for one in self.dampers],
            "lost": [f"{one.loss.value:z.1%}" for one in self.dampers],
            f"at least, {sides}": [f"{one.loss.low:z.1%}" if np.isfinite(one.loss.low) else "" for one in self.dampers],
            "at most": [f"{one.loss.high:z.1%}" for one in self.dampers],
        }
        return "\n\n".join([*parts, text_table(dampers, widest=TERMINAL), str(self.verdict)])


def _grips(before: Grip, after: Grip) -> dict[str, list[str]]:
    columns: dict[str, list[str]] = {"wheel": list(after.wheels)}
    for what, scale, name in (("adhesion", 100.0, "adhesion [%]"), ("phase", np.degrees(1.0), "least phase [deg]")):
        for when, one in (("before", before), ("after", after)):
            values, stds = getattr(one, what), getattr(one, f"{what}_std")
            columns[f"{name}, {when}"] = [
                "none" if np.isnan(v) else f"{figure} ± {spread(scale * s)}" if s > 0 else f"{scale * v:.1f}"
                for v, s, figure in zip(values, stds, rounded(scale * values, scale * stds), strict=True)
            ]
    return columns


def _percent(value: Ratio) -> str:
    return f"{100 * value:+z.1f} %" if np.isfinite(value) else "any"
