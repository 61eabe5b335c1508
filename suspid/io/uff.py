"""Universal files: the time histories of data sets 58, ASCII and binary."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from suspid.errors import RecordError
from suspid.files import printable, read_bytes
from suspid.io.foreign import sheltered
from suspid.io.names import PER_SECOND
from suspid.io.tables import Table, TimeBase
from suspid.units import RealArray
from suspid.values import frozen_real
from suspid.words import LeftOut, Remark

# A line that begins or ends a data set, as pyuff recognises it.
DELIMITER = re.compile(rb"    -1(?=[\r\n]|\Z| {74})")
FUNCTIONS = {
    2: "an auto spectrum",
    3: "a cross spectrum",
    4: "a frequency response",
    5: "a transmissibility",
    6: "a coherence",
    7: "an auto correlation",
    8: "a cross correlation",
    9: "a power spectral density",
    12: "a spectrum",
}
DIRECTIONS = ("", "X", "Y", "Z", "RX", "RY", "RZ")
# Units of length and force by the code of data set 164.
SYSTEMS = {
    1: ("m", "N"),
    2: ("ft", "lbf"),
    3: ("m", "kgf"),
    4: ("ft", "pdl"),
    5: ("mm", "mN"),
    6: ("cm", "cN"),
    7: ("in", "lbf"),
    8: ("mm", "kgf"),
    10: ("mm", "N"),
}


def read_uff(path: Path) -> Table:
    """Return the table of a universal file: a column for each real time history of its data sets 58.

    A column is named by node and direction (``12+Z``), else by the label of its axis, else by its first
    line of text; a name that is taken is followed by that text. Units are those of the label, else
    they follow from data set 164.
    """
    content = read_bytes(path, error=RecordError)
    if re.match(rb"[\r\n]*    -1[\r\n ]", content) is None:
        raise RecordError("is not a universal file: it does not begin with a line '    -1'")
    if len(DELIMITER.findall(content)) % 2 or not content.rstrip(b"\0\x1a \r\n\t").endswith(b"    -1"):
        raise RecordError("is cut off: its last data set does not end")
    del content
    numbered = sheltered(lambda: _data_sets(path), extra="uff", suffix=path.suffix)
    system = next((s["units_code"] for _, s in numbered if s["type"] == 164), None)
    values: dict[str, RealArray] = {}
    clocks: dict[str, TimeBase] = {}
    units: dict[str, str] = {}
    unusable: dict[str, Remark] = {}
    for number, dataset in numbered:
        if dataset["type"] != 58:
            continue
        name = _name(dataset, number, {*values, *unusable})
        reason = _why_not(dataset)
        if reason is not None:
            unusable[name] = reason
            continue
        samples = _samples(dataset, number)
        clocks[name] = _clock(dataset, number, clocks, values)
        values[name] = samples
        units[name] = _label(dataset["ordinate_axis_units_lab"]) or _unit(dataset["ordinate_spec_data_type"], system)
    if not values:
        listed = ", ".join(f"{name!r} {why}" for name, why in unusable.items())
        raise RecordError(f"contains no time history: {listed or 'no data set 58'}")

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return [values[name] for name in wanted]

    return Table(
        sizes={name: v.size for name, v in values.items()},
        columns=columns,
        unusable=unusable,
        units={name: unit for name, unit in units.items() if unit},
        clocks=clocks,
        title=next((t for _, s in numbered if s["type"] == 151 and (t := _label(s["model_name"]))), ""),
    )


def _data_sets(path: Path) -> list[tuple[int, dict[str, Any]]]:
    """Return the data sets 58, 151 and 164, and the number of each in the file from 1."""
    import pyuff

    file = pyuff.UFF(str(path))
    types = [int(kind) for kind in file.get_set_types()]
    if not all(types):
        raise RecordError(f"is damaged: data set {types.index(0) + 1} does not state its type")
    return [(k + 1, file.read_sets(k)) for k, kind in enumerate(types) if kind in (58, 151, 164)]


def _why_not(dataset: Mapping[str, Any]) -> Remark | None:
    """Return why a data set is not a time history, None if it is one."""
    function, abscissa = dataset["func_type"], dataset["abscissa_spec_data_type"]
    if dataset["ord_data_type"] in (5, 6):
        name = FUNCTIONS.get(function, f"function {function}")
        return Remark(LeftOut.COMPLEX_FUNCTION, {"function": name})
    if function in FUNCTIONS:
        return Remark(LeftOut.FUNCTION, {"function": FUNCTIONS[function]})
    # Abscissa 17 is time; 0 is unknown, and function 1 is a response over time.
    if abscissa != 17 and not (abscissa == 0 and function == 1):
        return Remark(LeftOut.ABSCISSA, {"type": abscissa})
    unit = _label(dataset["abscissa_axis_units_lab"])
    if unit and unit.lower() not in PER_SECOND:
        return Remark(LeftOut.TIME_UNIT, {"unit": unit})
    return None if dataset["num_pts"] else Remark(LeftOut.EMPTY)


def _clock(
    dataset: Mapping[str, Any], number: int, clocks: Mapping[str, TimeBase], values: Mapping[str, RealArray]
) -> TimeBase:
    """Return the time base of a data set; data sets with equal stamps share one."""
    per_second = PER_SECOND[_label(dataset["abscissa_axis_units_lab"]).lower() or "s"]
    if dataset["abscissa_spacing"] == 0:
        stamps = frozen_real(dataset["x"] / per_second)
        for name, known in clocks.items():
            if known.stamps is not None and values[name].size == stamps.size and np.array_equal(known.stamps(), stamps):
                return known
        return TimeBase(name=f"data set {number}", stamps=lambda: stamps)
    start, step = dataset["abscissa_min"] / per_second, dataset["abscissa_inc"] / per_second
    if not (math.isfinite(start) and math.isfinite(step) and step > 0):
        raise RecordError(f"is damaged: data set {number} starts at {start:g} s and steps by {step:g} s")
    for known in clocks.values():
        if known.stamps is None and (known.start, known.rate) == (start, 1 / step):
            return known
    return TimeBase(name=f"data set {number}", start=start, rate=1 / step)


def _samples(dataset: Mapping[str, Any], number: int) -> RealArray:
    """Return the samples of a data set, whose number must be the stated one; binary samples may be padded to a line."""
    found, stated = len(dataset["data"]), dataset["num_pts"]
    # A line of 80 characters of single precision may be padded.
    if not stated <= found <= stated + (20 if dataset["binary"] and dataset["abscissa_spacing"] else 0):
        raise RecordError(f"is damaged: data set {number} states {stated} samples and contains {found}")
    return frozen_real(dataset["data"][:stated])


def _name(dataset: Mapping[str, Any], number: int, taken: Collection[str]) -> str:
    node, direction, entity = dataset["rsp_node"], dataset["rsp_dir"], _label(dataset["rsp_ent_name"])
    title = _label(dataset["id1"])
    point = ""
    if node or direction:
        axis = DIRECTIONS[abs(direction)] if abs(direction) < len(DIRECTIONS) else str(direction)
        point = f"{node}{'-' if direction < 0 else '+'}{axis}" if axis else str(node)
    if entity and entity != point:
        point = f"{entity} {point}".rstrip()
    name = point or _label(dataset["ordinate_axis_lab"]) or title or f"data set {number}"
    for candidate in (name, f"{name} ({title})" if title else name, f"{name} (data set {number})"):
        if candidate not in taken:
            return candidate
    raise RecordError(f"contains two data sets named {name!r}")


def _label(text: str) -> str:
    """Return a label without blanks; ``NONE`` means no label."""
    stripped = printable(text.strip())
    return "" if stripped.upper() == "NONE" else stripped


def _unit(kind: int, system: int | None) -> str:
    """Return the unit of a quantity in the system of units that data set 164 states; empty if it is not known."""
    if system not in SYSTEMS:
        return ""
    length, force = SYSTEMS[system]
    # Displacement, velocity and acceleration; force of reaction and of excitation.
    return {8: length, 11: f"{length}/s", 12: f"{length}/s^2", 9: force, 13: force}.get(kind, "")
