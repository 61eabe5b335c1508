"""The road under a wheel as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from suspid.greybox import RoadEstimate
from suspid.units import RealArray
from suspid.values import frozen_real


def road_to_dict(road: RoadEstimate) -> dict[str, object]:
    """Return the road under one wheel as plain lists and numbers."""
    columns = (_column(road, part) for part in (road.speeds, road.roughness, road.roughness_std))
    rows = zip(road.records, road.times.tolist(), *columns, strict=True)
    names = ("record", "time_s", "speed", "roughness", "roughness_std")
    return {
        "wheel": road.wheel,
        "exponent": road.exponent,
        "exponent_std": road.exponent_std,
        "class": road.road_class,
        "mean_roughness": road.mean_roughness,
        "mean_roughness_std": road.mean_roughness_std,
        "stretches": [dict(zip(names, row, strict=True)) for row in rows],
    }


def road_from_dict(content: Mapping[str, Any]) -> RoadEstimate:
    """Return the road from what `road_to_dict` returned."""
    rows, mean, std = content["stretches"], content["mean_roughness"], content["mean_roughness_std"]
    return RoadEstimate(
        wheel=str(content["wheel"]),
        records=tuple(int(row["record"]) for row in rows),
        times=frozen_real([row["time_s"] for row in rows]),
        exponent=float(content["exponent"]),
        exponent_std=float(content["exponent_std"]),
        speeds=_array(rows, "speed"),
        roughness=_array(rows, "roughness"),
        roughness_std=_array(rows, "roughness_std"),
        mean_roughness=None if mean is None else float(mean),
        mean_roughness_std=None if std is None else float(std),
    )


def _column(road: RoadEstimate, part: RealArray | None) -> list[float | None]:
    return [None] * len(road.times) if part is None else part.tolist()


def _array(rows: Sequence[Mapping[str, Any]], name: str) -> RealArray | None:
    return None if any(row[name] is None for row in rows) else frozen_real([row[name] for row in rows])
