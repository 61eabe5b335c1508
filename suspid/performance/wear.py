"""Wear of dampers, from estimates of a car."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.greybox import DamperCurve, Estimate, parameter_unit
from suspid.levels import NORMAL_95, beyond_chance, normal_reach
from suspid.model import Suspension, value_in
from suspid.performance.curve_wear import bent, curve_named, said_of_bent, wear_by_curve
from suspid.performance.damper_rates import dampers_of, nominal_rates, rates_of
from suspid.performance.grip import grip_if_any
from suspid.performance.losses import ENOUGH_DRIVES, TESTS, WearRule, loss_of
from suspid.performance.wear_checks import said_of_loss, said_of_phase, stayed_nominal, untrusted, verdict_of, worst
from suspid.performance.wears import DamperWear, ParameterChange, Wear
from suspid.units import Ratio
from suspid.words import DamperState


@explained
def wear(
    now: Estimate,
    *,
    before: Estimate | Sequence[Estimate] | None = None,
    curves: Sequence[DamperCurve] = (),
    curves_before: Sequence[Sequence[DamperCurve]] = (),
    rule: WearRule | None = None,
    nominal_std: Ratio | Mapping[str, Ratio] | None = None,
) -> Wear:
    """Return a verdict on each damper of a car: good, watch, worn or cannot tell.

    A damper is worn if it has certainly lost more than a small share of its damping (10 %), or if the least phase of
    its wheel on a test bench is certainly below EGEA's limit and was not before. It is good if a large loss (30 %) is
    excluded, watch if some loss is certain, and cannot tell if the interval is too wide. Certain means: wrong in at
    most 0.5 % of the comparisons, if drives differ as the rule says.

    Parameters
    ----------
    now : Estimate
        The newest estimate.
    before : Estimate or sequence of Estimate, optional
        Earlier estimates of the same car. From six on their own scatter is taken in place of the stated one.
        Default: the nominal values that the estimate began with, which new dampers meet to within a few percent only.
    curves : sequence of DamperCurve, optional
        Curves of dampers in the drive of the newest estimate. A damper that is not viscous is compared by its curve:
        by the damping of equal work at the least amplitude of the drives.
    curves_before : sequence of sequences of DamperCurve, optional
        Curves in earlier drives, in order of time. Without one, a damper that is not viscous cannot be told.
    rule : WearRule, optional
        What is assumed of drives, and what is asked.
    nominal_std : float, or mapping of str to float, optional
        Relative standard deviation of parameters that were not estimated [1], such as ``{"tire.stiffness": 0.05}``; see
        `grip`.

    Returns
    -------
    Wear
        Verdicts, changes of all springs and dampers, grip before and after; ``str()`` is the tables.

    Raises
    ------
    InputError
        If an argument is of the wrong type, the estimates are of different cars, or no damper was estimated.

    Notes
    -----
    Estimates from drives give ratios to the mass, so a load that is not described changes springs and dampers alike.
    The stiffness of the parallel spring shows how much of a change is due to load. If it changed by more than load and
    temperature explain, the interval of the loss covers both causes.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> new = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3,
    ...                   tire_stiffness=210e3, chassis_damping=1300)
    >>> found = []
    >>> for damping in (1300, 900):
    ...     car = new.with_parameters(damping={"chassis": damping})
    ...     record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    ...     noisy = add_noise(record, snr_db=30.0, rng=np.random.default_rng(1))
    ...     found.append(estimate(noisy, new, fixed=["tire.damping"]))
    >>> {name: str(state) for name, state in wear(found[1], before=found[0]).states.items()}
    {'chassis': 'worn'}
    """
    from scipy.special import ndtri

    rule = WearRule() if rule is None else rule
    earlier = _estimates(now, before)
    after = grip_if_any(now, nominal_std)
    former = grip_if_any(earlier[-1], nominal_std) if earlier else grip_if_any(now.nominal)
    doubts = tuple(untrusted(now, earlier))
    quantile = float(-ndtri(rule.rate / TESTS))
    dampers, by_curve = [], list[str]()
    for strut in dampers_of(now, earlier):
        wheel = None if after is None else next((one for one in after.wheels if strut.arms.get(one)), None)
        own = curve_named(curves, strut.name, rule)
        old = [one for one in (curve_named(each, strut.name, rule) for each in curves_before) if one is not None]
        if own is not None and old and (doubts or bent(own) or any(map(bent, old))):
            dampers.append(wear_by_curve(strut.name, own, old, rule, wheel))
            by_curve.append(strut.name)
            continue
        rates = [rates_of(one, strut.name) for one in earlier] or [nominal_rates(now, strut.name)]
        new = rates_of(now, strut.name)
        if not all(one.damping > 0 for one in rates):
            continue
        loss = loss_of(new, rates, rule, nominal=not earlier)
        phase = said_of_phase(strut.name, wheel, former, after, quantile) if wheel else None
        state = rule.state(loss.low, loss.high)
        checks = list(said_of_loss(strut.name, loss, state, rule, new, rates))
        if phase is not None:
            checks.append(phase[0])
            state = worst(state, phase[1])
        if own is not None and bent(own):
            state, checks = DamperState.CANNOT_TELL, [said_of_bent(strut.name, own)]
        dampers.append(
            DamperWear(
                damper=strut.name,
                state=DamperState.CANNOT_TELL if doubts else state,
                damping=new.damping,
                reference=new.damping / (1 - loss.value) if loss.value < 1 else rates[-1].damping,
                loss=loss,
                wheel=wheel,
                checks=tuple(checks),
            )
        )
    if not dampers:
        raise InputError("no damper above a wheel was estimated in all of these estimates: no wear can be computed")
    against = "nominal" if not earlier else "history" if len(earlier) >= ENOUGH_DRIVES else "earlier"
    judged = verdict_of(dampers, doubts, rule, against, by_curve=by_curve)
    return Wear(
        dampers=tuple(dampers),
        changes=tuple(_changes(now, earlier)),
        before=former,
        after=after,
        rule=rule,
        against=against,
        verdict=replace(judged, checks=(*judged.checks, *stayed_nominal(after))),
    )


def _estimates(now: Estimate, before: Estimate | Sequence[Estimate] | None) -> list[Estimate]:
    """Return the earlier estimates as a list, checked against the new one."""
    given = [] if before is None else [before] if isinstance(before, Estimate) else list(before)
    _check("now", now)
    for one in given:
        _check("before", one)
        if _shape(one.suspension) != _shape(now.suspension):
            raise InputError("the estimates are of different cars: their masses, struts or arms differ by name")
    return given


def _check(what: str, one: object) -> None:
    if not isinstance(one, Estimate):
        raise InputError(
            f"{what}: wear compares estimates, not {type(one).__name__}; see estimate and read_estimate, "
            f"and compare for reconstructions and modes"
        )


def _shape(car: Suspension) -> tuple[object, ...]:
    """Return masses by name, and struts with the coordinates that they connect."""
    return tuple(car.masses), tuple((s.name, tuple(n for n, arm in s.arms.items() if arm)) for s in car.struts)


def _changes(now: Estimate, earlier: Sequence[Estimate]) -> Iterator[ParameterChange]:
    """Yield the parameters of the car in the new estimate and in the last one before, or at their nominal values."""
    old = earlier[-1] if earlier else None
    rows = []
    for name, after, std in zip(now.parameters, now.values.tolist(), now.std.tolist(), strict=True):
        if value_in(now.nominal, name) is None or (old is not None and name not in old.parameters):
            continue
        spread = 0.0
        if old is None:
            before = float(value_in(now.nominal, name) or 0.0)
        else:
            at = old.parameters.index(name)
            before, spread = float(old.values[at]), float(old.std[at])
        if before <= 0:
            continue
        ratio = after / before
        rows.append((name, before, after, float(np.hypot(std, ratio * spread)) / before))

    def outside(level: Ratio) -> list[str]:
        reach = normal_reach(level)
        return [name for name, before, after, std in rows if abs(after / before - 1) > reach * std]

    apart = beyond_chance(outside, len(rows))
    for name, before, after, std in rows:
        change = after / before - 1
        yield ParameterChange(
            name=name,
            unit=parameter_unit(name),
            before=before,
            after=after,
            low=change - NORMAL_95 * std,
            high=change + NORMAL_95 * std,
            significant=name in apart,
        )
