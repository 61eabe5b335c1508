"""A reconstruction as JSON, as ``suspid reconstruct --json`` writes it.

An object with

- ``format``: ``"suspid car 1"``;
- ``parameters``: those found, a list of objects with ``name`` (such as ``"tire.stiffness"``), ``value``, ``unit``
  (N/m, N s/m or kg), ``std``, ``lower`` and ``upper``, the last two the ends of the interval of ``level``; all three
  are null if the modes carry no covariance; ``nominal``, ``change`` (found over nominal less one [1]) and
  ``significant`` (whether the nominal value lies outside the interval), null where they are not known;
- ``level``: probability of the intervals [1];
- ``held``: the strut parameters held, a list of objects with ``name``, ``value`` and ``unit``;
- ``covariance``: joint covariance of the parameters, in their order and units, or null;
- ``chi_square`` (or null), ``freedom``, ``explains``, ``residual`` (worst pole, relative [1]), ``status``;
- ``remarks``: how it was found and its limits, a list of objects with ``code``, ``numbers`` and ``text``;
- ``verdict``: ``level``, ``headline`` (a remark) and ``checks``, a list of remarks with a ``level`` each;
- ``alternatives``: every other car that has the modes, a list of objects with ``parameters`` (value by name),
  ``distance`` (chi-square if the modes carry a covariance, else the worst pole, relative [1]) and ``told_apart``;
- ``suspid``: the version.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from suspid.errors import InputError
from suspid.levels import LEVEL
from suspid.model import FoundParameters
from suspid.reconstruction.results import Reconstruction
from suspid.reconstruction.unknowns import parameter_values, unit_of
from suspid.units import Ratio

FORMAT = "suspid car 1"


def reconstruction_to_dict(found: Reconstruction, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return what was found as plain lists and numbers, every bit kept.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car, reconstruct
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> reconstruction_to_dict(reconstruct(eigenmodes(car), car, fixed=["tire"]))["held"][0]
    {'name': 'tire.stiffness', 'value': 200000.0, 'unit': 'N/m'}
    """
    from importlib.metadata import version

    values = parameter_values(found.suspension)
    nominal = {} if found.nominal is None else parameter_values(found.nominal)
    stds: list[float | None] = [None] * len(found.parameters)
    ends: dict[str, tuple[float, float]] = {}
    apart: frozenset[str] = frozenset()
    if found.covariance is not None:
        stds = [float(variance) ** 0.5 for variance in found.covariance.diagonal()]
        ends, apart = found.interval(level), found.beyond_chance(level)
    return {
        "format": FORMAT,
        "parameters": [
            {
                "name": name,
                "value": values[name],
                "unit": unit_of(name),
                "std": std,
                "lower": ends[name][0] if name in ends else None,
                "upper": ends[name][1] if name in ends else None,
                "nominal": nominal.get(name),
                "change": values[name] / nominal[name] - 1 if nominal.get(name) else None,
                "significant": name in apart if name in ends and name in nominal else None,
            }
            for name, std in zip(found.parameters, stds, strict=True)
        ],
        "level": level,
        "held": [{"name": name, "value": values[name], "unit": unit_of(name)} for name in found.held],
        "covariance": None if found.covariance is None else found.covariance.tolist(),
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "explains": found.explains,
        "residual": found.residual,
        "status": found.status,
        "remarks": [remark.to_dict() for remark in found.remarks],
        "verdict": found.verdict.to_dict(),
        "alternatives": [
            {
                "parameters": {name: parameter_values(car)[name] for name in found.parameters},
                "distance": distance,
                "told_apart": apart,
            }
            for car, distance, apart in zip(found.alternatives, found.distances, found.told_apart, strict=True)
        ],
        "suspid": version("suspid"),
    }


def parameters_from_dict(content: Mapping[str, object]) -> FoundParameters:
    """Return the parameters and their standard deviations of what `reconstruction_to_dict` wrote.

    Raises
    ------
    InputError
        If it is not such a JSON, or its numbers are none.

    Examples
    --------
    >>> from suspid import eigenmodes, quarter_car, reconstruct
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> found = parameters_from_dict(reconstruction_to_dict(reconstruct(eigenmodes(car), car)))
    >>> round(found.values["tire.stiffness"]), found.stds
    (200000, None)
    """
    form, rows = content.get("format"), content.get("parameters")
    if form != FORMAT or not isinstance(rows, list):
        raise InputError(f"format {form!r} is not {FORMAT!r}; write the file with suspid reconstruct --json")
    values, stds = dict[str, float](), dict[str, float | None]()
    for row in rows:
        try:
            name, std = str(row["name"]), row["std"]
            values[name], stds[name] = float(row["value"]), None if std is None else float(std)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"its parameters are damaged: {error!r}; write it again with suspid reconstruct") from None
        if not math.isfinite(values[name]) or not math.isfinite(stds[name] or 0.0) or (stds[name] or 0.0) < 0:
            raise InputError(f"{name}: {values[name]:g} ± {stds[name]} is no value with a standard deviation")
    known = {name: std for name, std in stds.items() if std is not None}
    return FoundParameters(values=values, stds=known if len(known) == len(values) and known else None)
