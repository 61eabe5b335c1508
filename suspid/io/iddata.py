"""Data of MATLAB's System Identification Toolbox (`iddata`): outputs and inputs of experiments, each on its clock."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from suspid.errors import RecordError
from suspid.io.foreign import unique_names
from suspid.io.labels import Clocked, Group, Text, Texts, Value, Variable
from suspid.io.names import PER_SECOND
from suspid.io.tables import TimeBase
from suspid.units import RealArray
from suspid.words import LeftOut, Remark

# Names of experiments that stay one part of the name of a channel.
ONE_PART = re.compile(r"[\w -]+")


def of_iddata(fields: Group) -> Value:
    """Return the experiments of an `iddata` by its fields: their outputs and inputs by name, and their clocks.

    Examples
    --------
    >>> y = Variable(shape=(3, 1), read=lambda: np.ones((3, 1)))
    >>> step = Variable(shape=(1, 1), read=lambda: np.array([[20.0]]))
    >>> fields = {"OutputData": y, "OutputName": Texts(texts=("seat",)), "Ts": step, "TimeUnit": Text(text="ms")}
    >>> found = of_iddata(fields)
    >>> list(found.vectors), found.clock.rate
    (['seat'], 50.0)
    """
    if (domain := _text(fields, "Domain").lower()) not in ("", "time"):
        return Remark(LeftOut.NOT_OVER_TIME, {"axis": domain})
    unit = _text(fields, "TimeUnit").lower() or "s"
    if unit not in PER_SECOND:
        return Remark(LeftOut.TIME_UNIT, {"unit": unit})
    outputs, inputs = _experiments(fields, "OutputData"), _experiments(fields, "InputData")
    if not outputs:
        return Remark(LeftOut.NO_VALUES)
    found: list[Value] = []
    for k, output in enumerate(outputs):
        rows = output.shape[0]
        columns = [
            *_columns(fields, "Output", output),
            *(_columns(fields, "Input", inputs[k]) if k < len(inputs) else ()),
        ]
        if any(vector.size != rows for _, _, vector in columns):
            raise RecordError(f"is damaged: an experiment has outputs of {rows} samples, and inputs of another length")
        names = unique_names([(of, name) for of, name, _ in columns])
        vectors = {name: vector for name, (_, _, vector) in zip(names, columns, strict=True)}
        found.append(Clocked(vectors=vectors, clock=_clock(fields, k, rows, PER_SECOND[unit])))
    if len(found) == 1:
        return found[0]
    stated = _texts(fields, "ExperimentName")
    whole = len({*stated}) == len(found) == len(stated) and all(map(ONE_PART.fullmatch, stated))
    return {f"[{name}]": one for name, one in zip(stated if whole else range(1, len(found) + 1), found, strict=True)}


def _text(fields: Group, name: str) -> str:
    value = fields.get(name)
    return value.text.strip() if isinstance(value, Text) else ""


def _texts(fields: Group, name: str) -> tuple[str, ...]:
    value = fields.get(name)
    return value.texts if isinstance(value, Texts) else ()


def _experiments(fields: Group, name: str) -> list[Variable]:
    """Return the arrays of a field, one for each experiment; none if it holds anything else."""
    value = fields.get(name)
    if isinstance(value, Variable):
        return [value]
    cells = list(value.values()) if isinstance(value, Mapping) else []
    arrays = [cell.get("data") if isinstance(cell, Mapping) else cell for cell in cells]
    found = [array for array in arrays if isinstance(array, Variable)]
    return found if len(found) == len(arrays) else []


def _columns(fields: Group, kind: str, array: Variable) -> list[tuple[str, str, Variable]]:
    """Return the columns of an array of outputs or inputs, each with its kind and its name."""
    rows, count = array.shape[0], math.prod(array.shape[1:])
    names, units = _texts(fields, f"{kind}Name"), _texts(fields, f"{kind}Unit")
    names = names if len(names) == count else ("",) * count
    units = units if len(units) == count else ("",) * count

    def column(k: int) -> Callable[[], RealArray]:
        return lambda: np.asarray(np.reshape(array.read(), (rows, count), order="F")[:, k], float)

    # What MATLAB calls those without a name.
    letter = "y" if kind == "Output" else "u"
    return [
        (kind.lower(), names[k] or f"{letter}{k + 1}", Variable(shape=(rows,), read=column(k), unit=units[k]))
        for k in range(count)
    ]


def _clock(fields: Group, number: int, rows: int, per_second: float) -> TimeBase | None:
    """Return the clock of an experiment, by its step or its stamps; None if there is neither."""
    stamps, step, start = (
        arrays[number] if number < len(arrays := _experiments(fields, name)) else None
        for name in ("SamplingInstants", "Ts", "Tstart")
    )
    if stamps is not None and stamps.size == rows:
        return TimeBase(name="", stamps=partial(_seconds, stamps, per_second))
    if step is None or step.size != 1:
        return None
    seconds = float(_seconds(step, per_second)[0])
    first = float(_seconds(start, per_second)[0]) if start is not None and start.size == 1 else 0.0
    return TimeBase(name="", start=first, rate=1 / seconds) if math.isfinite(seconds) and seconds > 0 else None


def _seconds(times: Variable, per_second: float) -> RealArray:
    return np.asarray(np.ravel(times.read()), float) / per_second
