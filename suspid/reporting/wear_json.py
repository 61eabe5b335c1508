"""Grip and wear as JSON: what ``suspid compare --json`` writes.

Every field is described with its unit in ``suspid/reporting/schemas/compare.schema.json`` (JSON Schema, draft 2020-12),
which `json_schema` returns.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from suspid.levels import LEVEL
from suspid.model import Comparison
from suspid.reporting.json_schema import as_plain
from suspid.units import Ratio

if TYPE_CHECKING:
    from suspid.performance import DamperWear, Grip, Wear

COMPARE_FORMAT = "suspid compare 1"


def wear_to_dict(found: Wear) -> dict[str, object]:
    """Return changes, grip and verdicts as plain lists and numbers; numbers that are not finite are None.

    Examples
    --------
    >>> import numpy as np
    >>> from suspid import estimate, free_decay, quarter_car, wear
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    >>> wear_to_dict(wear(estimate(record, car, fixed=["tire.damping"])))["dampers"][0]["verdict"]
    'good'
    """
    return as_plain(
        COMPARE_FORMAT,
        {
            "kind": "estimates",
            "verdict": found.verdict.to_dict(),
            "against": found.against,
            "level": LEVEL,
            "rule": asdict(found.rule),
            "dampers": [_damper(one) for one in found.dampers],
            "changes": [
                {
                    "name": one.name, "unit": one.unit, "before": one.before, "after": one.after,
                    "change": one.change, "lower": one.low, "upper": one.high, "significant": one.significant,
                }
                for one in found.changes
            ],
            "grip_before": None if found.before is None else grip_to_dict(found.before),
            "grip_after": None if found.after is None else grip_to_dict(found.after),
        },
    )  # fmt: skip


def grip_to_dict(found: Grip, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return the figures of a grip as plain numbers.

    Examples
    --------
    >>> from suspid import grip, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> grip_to_dict(grip(car))["wheels"][0]["class"]
    'excellent'
    """
    ends = found.interval(level)
    rows = [
        {
            "wheel": wheel,
            "load_n": float(found.load[i]),
            "adhesion": float(found.adhesion[i]),
            "adhesion_std": float(found.adhesion_std[i]),
            "adhesion_lower": ends[f"{wheel}.adhesion"][0],
            "adhesion_upper": ends[f"{wheel}.adhesion"][1],
            "adhesion_hz": float(found.adhesion_hertz[i]),
            "class": found.classes[i],
            "phase_rad": float(found.phase[i]),
            "phase_std_rad": float(found.phase_std[i]),
            "phase_lower_rad": ends[f"{wheel}.phase"][0],
            "phase_upper_rad": ends[f"{wheel}.phase"][1],
            "phase_hz": float(found.phase_hertz[i]),
        }
        for i, wheel in enumerate(found.wheels)
    ]
    return {"wheels": rows, "amplitude_m": found.amplitude, "verdict": found.verdict.to_dict()}


def grip_result(found: Grip, *, level: Ratio = LEVEL) -> dict[str, object]:
    """Return what ``suspid grip --json`` writes: `grip_to_dict` with its format, as ``grip.schema.json`` describes it.

    Examples
    --------
    >>> from suspid import grip, quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> grip_result(grip(car))["format"]
    'suspid grip 1'
    """
    return as_plain("suspid grip 1", {"level": level, **grip_to_dict(found, level=level)})


def comparison_to_dict(found: Comparison) -> dict[str, object]:
    """Return a comparison of modes or cars as plain lists and numbers.

    Examples
    --------
    >>> from suspid import ModalSet, compare
    >>> modes = ModalSet.from_wn_zeta([10.0], [0.6])
    >>> comparison_to_dict(compare(modes, modes))["passed"]
    True
    """
    rows = [
        {
            "item": row.item, "quantity": row.quantity, "unit": row.unit, "before": row.expected, "after": row.found,
            "difference": row.error, "allowed": row.allowed, "verdict": row.verdict,
        }
        for row in found.table
    ]  # fmt: skip
    kind = "modes" if any(row.quantity in ("wn", "zeta") for row in found.table) else "springs"
    remarks = [remark.to_dict() for remark in found.remarks]
    fields = {"kind": kind, "passed": found.passed, "rule": found.rule, "values": rows, "remarks": remarks}
    return as_plain(COMPARE_FORMAT, fields)


def _damper(one: DamperWear) -> dict[str, object]:
    return {
        "damper": one.damper,
        "verdict": str(one.state),
        "damping": one.damping,
        "reference": one.reference,
        "loss": one.loss.value,
        "loss_lower": one.loss.low,
        "loss_upper": one.loss.high,
        "spring_changed": one.loss.spring,
        "wheel": one.wheel,
        "checks": [{**check.remark.to_dict(), "level": check.level.label} for check in one.checks],
    }
