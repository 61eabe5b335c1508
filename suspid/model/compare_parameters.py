"""Compare springs, dampers and masses of two results."""

from __future__ import annotations

import numpy as np

from suspid.errors import InputError
from suspid.levels import EXACT, ROUNDING
from suspid.model.comparison import ComparedValue, Comparison, mean_errors
from suspid.model.found_parameters import FoundParameters
from suspid.units import UNITS, Ratio


def compare_parameters(
    found: FoundParameters, expected: FoundParameters, *, rtol: Ratio | None, sigmas: float, rule: str
) -> Comparison:
    """Compare the parameters that both have; what is allowed follows from the errors of both, unless ``rtol`` says it.

    Raises
    ------
    InputError
        If they have no parameter in common.

    Examples
    --------
    >>> old = FoundParameters(values={"chassis.damping": 1500.0}, stds={"chassis.damping": 10.0})
    >>> new = FoundParameters(values={"chassis.damping": 1400.0}, stds={"chassis.damping": 10.0})
    >>> rows = compare_parameters(new, old, rtol=None, sigmas=1.96, rule="").table
    >>> [(row.item, row.quantity, row.verdict) for row in rows]
    [('chassis', 'damping', 'off')]
    """
    common = [name for name in expected.values if name in found.values]
    if not common:
        raise InputError(
            f"no parameter was found in both: {', '.join(found.values) or 'none'} in one, "
            f"{', '.join(expected.values) or 'none'} in the other; compare results of one car"
        )
    rows = []
    for name in common:
        item, _, quantity = name.rpartition(".")
        truth = expected.values[name]
        known = [side.stds[name] for side in (found, expected) if side.stds is not None]
        exact = ROUNDING * abs(truth)
        allowed = (EXACT if rtol is None else rtol) * abs(truth)
        if rtol is None and known:
            allowed = sigmas * float(np.linalg.norm(known))
        rows.append(
            ComparedValue(
                item=item, quantity=quantity, unit=UNITS[quantity], found=found.values[name], expected=truth,
                allowed=max(allowed, exact),
            )
        )  # fmt: skip
    quantities = tuple(dict.fromkeys(row.quantity for row in rows))
    return Comparison(table=tuple(rows), mae=mean_errors(rows, quantities), mac=None, rule=f"allowed: {rule}")
