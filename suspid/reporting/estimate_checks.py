"""Consistency checks of an estimate read from a file, which may have been edited by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from suspid.levels import EXACT, SEVEN_DIGITS
from suspid.model import Suspension
from suspid.reconstruction import parameter_values
from suspid.units import RealArray


def check_parameters(rows: Sequence[Mapping[str, Any]], values: RealArray, ranges: RealArray) -> None:
    """Refuse parameters that are named twice, or lie outside their bounds.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    names = [str(row["name"]) for row in rows]
    for name, value, (least, most) in zip(names, values.tolist(), ranges.tolist(), strict=True):
        if names.count(name) > 1:
            raise ValueError(f"parameter {name!r} occurs twice")
        slack = EXACT * max(abs(value), abs(least) if np.isfinite(least) else 0.0)
        if not least - slack <= value <= most + slack:
            raise ValueError(f"{name} = {value:g} is not between its bounds {least:g} and {most:g}")


def check_cars(names: Sequence[str], values: RealArray, found: Suspension, nominal: Suspension) -> None:
    """Refuse a car that has other values than the parameters, or where nothing was found, than the nominal car.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    now, before = parameter_values(found), parameter_values(nominal)
    for name, value in zip(names, values.tolist(), strict=True):
        if name in now and not np.isclose(value, now[name], rtol=EXACT, atol=0.0):
            raise ValueError(f"{name} is {value:g} among the parameters and {now[name]:g} in the car")
    if list(now) != list(before):
        raise ValueError("the car that was found has other struts or masses than the nominal one")
    for name in now:
        if name not in names and not np.isclose(now[name], before[name], rtol=EXACT, atol=0.0):
            raise ValueError(
                f"{name} was not estimated, but is {now[name]:g} in the car found and {before[name]:g} in the nominal"
            )


def check_judgement(content: Mapping[str, Any]) -> None:
    """Refuse a misfit, a number of degrees of freedom, or a yes or no that no fit has.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    for name in ("chi_square", "freedom"):
        if content[name] is not None and not float(content[name]) >= 0:
            raise ValueError(f"{name} = {content[name]} must be 0 or more")
    if not isinstance(content["explains"], bool):
        raise ValueError(f"explains = {content['explains']!r} must be true or false")


def checked_covariance(given: object, rows: Sequence[Mapping[str, Any]]) -> RealArray:
    """Return a covariance, or refuse one of the wrong size, or that is none, or has other deviations than the rows.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    covariance = np.array(given, float)
    if not rows and not covariance.size:
        return np.zeros((0, 0))
    if covariance.shape != (len(rows), len(rows)):
        raise ValueError(f"the covariance has the shape {covariance.shape}, but there are {len(rows)} parameters")
    if not np.all(np.isfinite(covariance)):
        raise ValueError("the covariance is not finite")
    if np.any(np.diag(covariance) < 0):
        raise ValueError("the covariance has a negative variance")
    stds = np.sqrt(np.diag(covariance))
    for row, std in zip(rows, stds.tolist(), strict=True):
        if not np.isclose(row["std"], std, rtol=SEVEN_DIGITS, atol=0.0):
            raise ValueError(f"the standard deviation of {row['name']} is {row['std']:g}, in the covariance {std:g}")
    scale = np.where(stds > 0, stds, 1.0)
    correlation = covariance / scale[:, None] / scale
    if np.any(np.abs(correlation - correlation.T) > SEVEN_DIGITS):
        raise ValueError("the covariance is not symmetric")
    if np.linalg.eigvalsh(correlation)[0] < -SEVEN_DIGITS * len(rows):
        raise ValueError("the covariance is not positive: some sum of parameters has a negative variance")
    return covariance
