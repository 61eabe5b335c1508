"""Estimates without stated causes: the first likely cause that explains the records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from suspid.errors import EstimationError, RecordError
from suspid.greybox.car_records import record_of_car
from suspid.greybox.causes import likely_causes, swells, under
from suspid.greybox.estimates import Estimate
from suspid.greybox.fitted_car import Asked, fitted_car
from suspid.greybox.record_test import RecordTest
from suspid.model import Suspension
from suspid.signals import as_signal
from suspid.threads import in_one_thread
from suspid.words.greybox import EstimateCheck


def estimate_by_cause(
    tests: Sequence[RecordTest],
    suspension: Suspension,
    *,
    causes: Sequence[tuple[str, ...]] | None = None,
    options: Mapping[str, Any] | None = None,
) -> tuple[Estimate, tuple[str, ...]]:
    """Return the estimate under the first cause that explains the tests, and the cause; ``()`` is a free decay.

    Records that are each explained by a car of its own are explained, too: they are not of one car. Where no cause
    explains them it is the estimate of the best verdict, and of equal ones that which leaves least. ``causes`` are
    those to try, in order (default: `likely_causes`), ``options`` are arguments of `estimate`.

    Raises
    ------
    EstimationError, RecordError
        If no cause leads to an estimate: what was raised under the first.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, quarter_car, simulate
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> times = np.arange(0, 5, 0.005)
    >>> rig = simulate(car, times, {"road": 0.01 * np.sin(6 * times**2)}, outputs=["chassis", "tire"])
    >>> noisy = add_noise(rig, snr_db=40.0, rng=np.random.default_rng(1))
    >>> found, cause = estimate_by_cause([RecordTest(record=noisy)], car)
    >>> cause, found.explains
    (('road',), True)
    """
    found: list[tuple[Estimate, tuple[str, ...]]] = []
    refused: list[EstimationError | RecordError] = []
    tried = [(cause, True) for cause in (likely_causes(tests, suspension) if causes is None else causes)]
    at = next((i for i, (cause, _) in enumerate(tried[:-1]) if not cause), None)
    if at is not None and any(swells(as_signal(record_of_car(t.record, suspension)).values) for t in tests):
        # Where in a record a decay begins takes seconds to find; in one that swells it is looked for at last.
        tried = [*tried[:at], ((), False), *tried[at + 1 :], ((), True)]
    for cause, onsets in tried:
        try:
            moved = [under(test, cause, suspension) for test in tests]
            found.append((_estimate(moved, suspension, {"given": cause, **(options or {})}, onsets=onsets), cause))
        except (EstimationError, RecordError) as error:
            refused.append(error)
            continue
        if _explained(found[-1][0]):
            return found[-1]
    if not found:
        raise refused[0]
    return max(found, key=lambda one: (one[0].verdict.level, -_left(one[0])))


@in_one_thread
def _estimate(tests: Sequence[RecordTest], car: Suspension, options: Mapping[str, Any], *, onsets: bool) -> Estimate:
    return fitted_car(tests, car, Asked(**options), onsets=onsets)


def _explained(found: Estimate) -> bool:
    """Return whether a car explains the records, or one car each of them."""
    each = (c.remark for c in found.verdict.checks if c.remark.code is EstimateCheck.NOT_ONE_CAR)
    return found.explains or any(remark.numbers["each"] for remark in each)


def _left(found: Estimate) -> float:
    """Return the share of a channel's power that an estimate leaves, where most is left."""
    pairs = [
        (as_signal(fit).values, as_signal(left).values) for fit, left in zip(found.fitted, found.residual, strict=True)
    ]
    return max(
        float(np.max(np.var(left, axis=1) / np.maximum(np.var(fit + left, axis=1), np.finfo(float).tiny)))
        for fit, left in pairs
    )
