"""An estimate as JSON: ``suspid estimate --json`` writes it and ``suspid compare`` reads it.

Every field is described with its unit in ``suspid/reporting/schemas/estimate.schema.json`` (JSON Schema, draft
2020-12), which `json_schema` returns. The modes in it are those of `suspid identify`. `read_estimate` reads it back
bit for bit, but for the records: of these the file holds what was left of each, not the samples.
"""

from __future__ import annotations

import hashlib
import json
import os
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from suspid.analysis import CheckedLimits
from suspid.arguments import explained
from suspid.errors import InputError
from suspid.files import naming, parsed_json, printable, read_text
from suspid.greybox import Estimate, parameter_unit
from suspid.identification import modes_from_dict, modes_to_dict, to_json
from suspid.levels import LEVEL
from suspid.model import Suspension, car_from_toml, car_to_toml, value_in
from suspid.reconstruction import parameter_values, with_values
from suspid.reporting.estimate_checks import check_cars, check_judgement, check_parameters, checked_covariance
from suspid.reporting.limits_json import limits_to_dict
from suspid.reporting.road_json import road_from_dict, road_to_dict
from suspid.signals import as_signal
from suspid.units import Ratio
from suspid.values import frozen_real
from suspid.words import Check, Code, EstimateCheck, EstimateHeadline, Level, Remark, Verdict

ESTIMATE_FORMAT = "suspid estimate 1"
DRIVE_FORMAT = "suspid drive 1"


def estimate_to_dict(
    found: Estimate, *, level: Ratio = LEVEL, limits: CheckedLimits | None = None
) -> dict[str, object]:
    """Return an estimate as plain lists and numbers, every bit kept; numbers that are not finite are None.

    ``limits`` are those that it was judged by, see `check_limits`.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import add_noise, estimate, free_decay, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> found = estimate(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"])
    >>> estimate_to_dict(found)["masses"]
    [{'name': 'chassis', 'value': 400.0, 'unit': 'kg'}, {'name': 'tire', 'value': 40.0, 'unit': 'kg'}]
    """
    from importlib.metadata import version

    fields = {
        "format": ESTIMATE_FORMAT,
        "verdict": found.verdict.to_dict(),
        "level": level,
        "parameters": _parameters(found, level),
        "covariance": found.covariance.tolist(),
        "held": [{"name": n, "value": value_in(found.nominal, n), "unit": parameter_unit(n)} for n in found.held],
        "masses": [{"name": name, "value": mass, "unit": "kg"} for name, mass in found.suspension.masses.items()],
        "car": {
            "found": car_to_toml(found.suspension),
            "nominal": car_to_toml(found.nominal),
            "sha256": _digest(car_to_toml(found.nominal)),
        },
        "modes": modes_to_dict(found.modes),
        "records": _records(found),
        "chi_square": found.chi_square,
        "freedom": found.freedom,
        "explains": found.explains,
        "alternatives": [_values(found, car) for car in found.alternatives],
        "road": [road_to_dict(road) for road in found.road],
        "limits": limits_to_dict(limits),
        "suspid": version("suspid"),
    }
    plain: dict[str, object] = json.loads(to_json(fields))
    return plain


def estimate_from_dict(content: Mapping[str, object]) -> Estimate:
    """Return an estimate without its records from what `estimate_to_dict` returned, alone or in a drive or report.

    Raises
    ------
    InputError
        If it is none, or its parts contradict each other.
    """
    if content.get("format") == DRIVE_FORMAT:
        within = content.get("estimate")
        if not isinstance(within, dict):
            raise InputError("the drive has no springs and dampers: no motion of wheels, or nothing usable")
        content = within
    if "report" in content:
        within = content.get("estimate")
        if not isinstance(within, dict):
            raise InputError("the report has no springs and dampers that were fitted to the record: give it a car")
        content = within
    if content.get("format") == "suspid car 1":
        raise InputError(
            "contains a result of reconstruct; write the car with suspid reconstruct -o car.toml, and use that"
        )
    if content.get("format") != ESTIMATE_FORMAT:
        raise InputError(
            f"format {reprlib.repr(content.get('format'))} is not {ESTIMATE_FORMAT!r}; write the file with "
            f"suspid estimate --json"
        )
    try:
        return _estimate(content)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        reason = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else str(error)
        raise InputError(
            f"is not a complete estimate: {printable(reason)}; write it again with suspid estimate --json"
        ) from None


@explained
def read_estimate(path: str | os.PathLike[str]) -> Estimate:
    """Return the estimate that ``suspid estimate``, ``drive`` or ``report`` wrote with ``--json``, without its records.

    Parameters
    ----------
    path : path
        The JSON file.

    Returns
    -------
    Estimate
        The estimate without the records: ``fitted``, ``residual``, ``noise_std`` and ``road`` are empty.

    Raises
    ------
    InputError
        If the file cannot be read, is not such a JSON, or its car was changed.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> import numpy as np
    >>> from suspid import estimate, free_decay, quarter_car
    >>> from suspid.reporting import estimate_to_dict
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> found = estimate(record, car, fixed=["tire.damping"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "found.json"
    ...     _ = path.write_text(json.dumps(estimate_to_dict(found)))
    ...     read_estimate(path).suspension == found.suspension
    True
    """
    with naming(path):
        return estimate_from_dict(parsed_json(read_text(Path(path))))


def _estimate(content: Mapping[str, Any]) -> Estimate:
    rows, texts = content["parameters"], content["car"]
    if _digest(texts["nominal"]) != texts["sha256"]:
        raise ValueError("the car was changed after it was written: its SHA-256 differs")
    found, nominal = car_from_toml(texts["found"]), car_from_toml(texts["nominal"])
    names, values = tuple(str(row["name"]) for row in rows), np.array([row["value"] for row in rows], float)
    covariance = checked_covariance(content["covariance"], rows)
    ends = [[-np.inf if row["least"] is None else row["least"], np.inf if row["most"] is None else row["most"]]
            for row in rows]  # fmt: skip
    ranges = np.array(ends, float).reshape(len(names), 2)
    check_parameters(rows, values, ranges)
    check_cars(names, values, found, nominal)
    check_judgement(content)
    return Estimate(
        suspension=found,
        nominal=nominal,
        parameters=names,
        values=frozen_real(values),
        covariance=frozen_real(covariance),
        unbounded=frozen_real([row.get("unbounded", row["value"]) for row in rows]),
        ranges=frozen_real(ranges),
        held=tuple(str(row["name"]) for row in content["held"]),
        modes=modes_from_dict(content["modes"]),
        fitted=(),
        residual=(),
        noise_std=(),
        chi_square=float("nan") if content["chi_square"] is None else float(content["chi_square"]),
        freedom=int(content["freedom"]),
        explains=content["explains"],
        alternatives=tuple(with_values(nominal, values) for values in content["alternatives"]),
        verdict=_verdict(content["verdict"]),
        road=tuple(road_from_dict(road) for road in content.get("road", ())),
    )


def _verdict(content: Mapping[str, Any]) -> Verdict:
    checks = [Check(_remark(one, EstimateCheck), Level[one["level"].upper()]) for one in content["checks"]]
    return Verdict(_remark(content["headline"], EstimateHeadline), tuple(checks))


def _remark(content: Mapping[str, Any], codes: type[Code]) -> Remark:
    """Return a remark; what another version of suspid says keeps its sentence."""
    if content["code"] not in [code.value for code in codes]:
        return Remark(EstimateCheck.SAID, {"text": content["text"]})
    numbers = {name: tuple(n) if isinstance(n, list) else n for name, n in content["numbers"].items()}
    return Remark(codes(content["code"]), numbers)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _parameters(found: Estimate, level: Ratio) -> list[dict[str, object]]:
    ends, apart, rows = found.interval(level), found.beyond_chance(level), list[dict[str, object]]()
    columns = (found.values, found.std, found.unbounded, found.ranges)
    for name, value, std, unbounded, (least, most) in zip(
        found.parameters, *(column.tolist() for column in columns), strict=True
    ):
        nominal = value_in(found.nominal, name)
        low, high = ends[name]
        rows.append(
            {
                "name": name,
                "value": value,
                "unit": parameter_unit(name),
                "std": std,
                "lower": low,
                "upper": high,
                "unbounded": unbounded,
                "least": least,
                "most": most,
                "nominal": nominal,
                "change": value / nominal - 1 if nominal else None,
                "significant": None if nominal is None else name in apart,
            }
        )
    return rows


def _records(found: Estimate) -> list[dict[str, object]]:
    rows = []
    for residual, noise, white in zip(found.residual, found.noise_std, found.whiteness, strict=True):
        signal = as_signal(residual)
        rows.append(
            {
                "samples": signal.values.shape[1],
                "step_s": signal.step,
                "start_s": signal.start,
                "channels": [
                    {"name": name, "noise_std": std, "lag_1_correlation": correlation}
                    for name, std, correlation in zip(signal.channels, noise.tolist(), white.tolist(), strict=True)
                ],
            }
        )
    return rows


def _values(found: Estimate, car: Suspension) -> dict[str, float]:
    values = parameter_values(car)
    return {name: values[name] for name in found.parameters if name in values}
