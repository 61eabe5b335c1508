"""Variables: named arrays in nested groups, as in MATLAB and HDF5, as the columns of a table."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from suspid.errors import RecordError
from suspid.io.cell_tests import with_paired_cells
from suspid.io.labels import Clocked, Group, Text, Texts, Variable, labelled
from suspid.io.names import PER_SECOND, is_time, split_unit, stated_rate
from suspid.io.tables import Table, TimeBase
from suspid.io.time_units import epoch_unit
from suspid.units import Hertz, RealArray
from suspid.values import frozen_real
from suspid.words import LeftOut, Number, Remark

# Limit of a record; damaged files state deeper structures.
DEEPEST = 16


@dataclass(frozen=True, kw_only=True, slots=True)
class _Found:
    sizes: dict[str, int] = field(default_factory=dict)
    readers: dict[str, Callable[[], RealArray]] = field(default_factory=dict)
    unusable: dict[str, Remark] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, TimeBase] = field(default_factory=dict)


def as_table(variables: Group) -> Table:
    """Return every vector and every column of a matrix as a column of a table.

    A variable in a group is named ``group.name``; the columns of a matrix are ``name[1]``, ``name[2]`` …, its
    longer side being time; a list of as many names beside it names them. A vector of time, or a number that
    states the rate, holds for all in its group and in the groups below it; a group ``time`` and ``signals.values``
    is what Simulink writes, one with ``x_values`` and ``y_values`` what Simcenter Testlab writes.

    Examples
    --------
    >>> seat = Variable(shape=(3, 1), read=lambda: np.ones((3, 1)))
    >>> table = as_table({"run1": {"seat": seat, "Fs": Variable(shape=(1, 1), read=lambda: np.array([[50.0]]))}})
    >>> table.sizes, table.clocks["run1.seat"].rate
    ({'run1.seat': 3}, 50.0)
    """
    found = _Found()
    variables = with_paired_cells(variables)
    top = _stated(variables)
    _collect(variables, "", None, found)
    if not found.sizes:
        listed = ", ".join(f"{name!r} {why}" for name, why in list(found.unusable.items())[:12])
        raise RecordError(f"contains no real vector: {listed or 'nothing at all'}")

    def columns(wanted: Sequence[str]) -> list[RealArray]:
        return [found.readers[name]() for name in wanted]

    return Table(
        sizes=found.sizes, columns=columns, unusable=found.unusable, rates=top, units=found.units, clocks=found.clocks
    )


def joined(prefix: str, name: str) -> str:
    """Return the name of a variable in a group; elements of an array of groups are named by their number alone.

    Examples
    --------
    >>> joined("run", "seat"), joined("run", "[2]"), joined("", "run")
    ('run.seat', 'run[2]', 'run')
    """
    return f"{prefix}{'' if not prefix or name.startswith('[') else '.'}{name}"


def _collect(group: Group, prefix: str, above: TimeBase | None, found: _Found) -> None:
    """Add what a group holds; ``above`` is the time base of the group around it."""
    group = labelled(group)
    clock = _clock(group, prefix, above) if prefix else None
    time = _time(group)
    for name, value in group.items():
        full = joined(prefix, name)
        if isinstance(value, Remark):
            found.unusable[full] = value
        elif isinstance(value, Text | Texts):
            found.unusable[full] = Remark(LeftOut.NOTE)
        elif isinstance(value, Variable):
            if prefix and time is not None and name == time[0]:
                found.unusable[full] = Remark(LeftOut.GROUP_TIME)
            else:
                _add(full, value, clock, time, found)
        elif isinstance(value, Clocked):
            own = None if value.clock is None else replace(value.clock, name=full)
            for short, vector in value.vectors.items():
                _add(joined(full, short), vector, own, None, found)
        elif _signals(value):
            _add_simulink(full, value, found)
        elif _is_testlab(value):
            _add_testlab(full, value, found)
        else:
            _collect(value, full, clock, found)


def _clock(group: Group, prefix: str, above: TimeBase | None) -> TimeBase | None:
    """Return the clock of a group: its own vector of time or rate, else that of the group around it."""
    rates, time = _stated(group), _time(group)
    if len(set(rates.values())) > 1:
        listed = ", ".join(f"{name!r} {rate:g} Hz" for name, rate in rates.items())
        raise RecordError(f"{prefix!r} states several sampling rates: {listed}; correct one of them")
    rate = next(iter(rates.values()), None)
    if time is None:
        return above if rate is None else TimeBase(name=prefix, rate=rate)
    return TimeBase(name=f"{prefix}.{time[0]}", rate=rate, stamps=_stamps(*time))


def _stamps(name: str, time: Variable) -> Callable[[], RealArray]:
    unit = time.unit.strip().lower() or split_unit(name)[1]

    def in_seconds() -> RealArray:
        stamps = np.ravel(time.read()).astype(float)
        return frozen_real(stamps / PER_SECOND.get(unit or epoch_unit(stamps), 1.0))

    return in_seconds


def _time(group: Group) -> tuple[str, Variable] | None:
    """Return the name and the vector of time of a group, if there is one and no other."""
    vectors = {name: v for name, v in group.items() if isinstance(v, Variable) and v.is_vector and is_time(name)}
    times = [(name, v) for name, v in vectors.items() if not v.unit or v.unit.strip().lower() in PER_SECOND]
    return times[0] if len(times) == 1 else None


def _stated(group: Group) -> dict[str, Hertz]:
    rates: dict[str, Hertz] = {}
    for name, value in group.items():
        if isinstance(value, Variable) and value.size == 1 and stated_rate(name, 1.0, value.unit) is not None:
            rate = stated_rate(name, float(np.ravel(value.read())[0]), value.unit)
            if rate is not None:
                rates[name] = rate
    return rates


def _add(name: str, value: Variable, clock: TimeBase | None, time: tuple[str, Variable] | None, found: _Found) -> None:
    """Add the columns of an array."""
    shape = tuple(n for n in value.shape if n > 1)
    if not value.size:
        found.unusable[name] = Remark(LeftOut.EMPTY)
    elif not shape:
        found.unusable[name] = Remark(LeftOut.NUMBER)
    elif len(shape) > 2:
        found.unusable[name] = Remark(LeftOut.ARRAY, {"shape": " x ".join(map(str, value.shape))})
    elif time is not None and time[1].size not in shape:
        # A vector of another length beside the time of its group belongs to something else.
        numbers: dict[str, Number] = {
            "samples": max(shape),
            "time": clock.name if clock else time[0],
            "stamps": time[1].size,
        }
        found.unusable[name] = Remark(LeftOut.SIZE, numbers)
    elif len(shape) == 1:
        _add_column(name, value, lambda: np.ravel(value.read()), value.size, clock, found)
    else:
        _add_matrix(name, value, shape, clock, None if time is None else time[1].size, found)


def _add_matrix(
    name: str, value: Variable, shape: Sequence[int], clock: TimeBase | None, stamps: int | None, found: _Found
) -> None:
    matching = [axis for axis in (0, 1) if shape[axis] == stamps]
    along = matching[0] if len(matching) == 1 else int(np.argmax(shape))
    # A matrix with more columns is not a set of channels (it may be a spectrogram).
    if (shape[0] == shape[1] and len(matching) != 1) or shape[1 - along] > 256:
        found.unusable[name] = Remark(LeftOut.MATRIX, {"shape": " x ".join(map(str, value.shape))})
        return
    whole = functools.cache(lambda: np.reshape(value.read(), shape))
    for k in range(shape[1 - along]):
        read = lambda k=k: np.take(whole(), k, axis=1 - along)  # noqa: E731
        _add_column(f"{name}[{k + 1}]", value, read, shape[along], clock, found)


def _add_column(
    name: str,
    value: Variable,
    read: Callable[[], NDArray[Any]],
    size: int,
    clock: TimeBase | None,
    found: _Found,
) -> None:
    found.sizes[name] = size
    found.readers[name] = lambda: frozen_real(read())
    if value.unit:
        found.units[name] = value.unit
    own = next(iter(value.rates.values()), None)
    if own is not None:
        found.clocks[name] = TimeBase(name=name, rate=own)
    elif clock is not None:
        found.clocks[name] = clock


def _signals(group: Group) -> dict[str, Group]:
    """Return the signals of a structure with time, as Simulink writes it; none if it is not one."""
    signals = group.get("signals")
    if "time" not in group or not isinstance(signals, Mapping):
        return {}
    several = {f"signals{name}": one for name, one in signals.items() if name.startswith("[")} or {"signals": signals}
    return {name: one for name, one in several.items() if isinstance(one, Mapping) and "values" in one}


def _add_simulink(prefix: str, group: Group, found: _Found) -> None:
    """Add the signals of a structure with time by their labels."""
    time = group["time"]
    vector = time if isinstance(time, Variable) and time.is_vector else None
    clock = None if vector is None else TimeBase(name=f"{prefix}.time", stamps=_stamps("time", vector))
    for name, signal in _signals(group).items():
        label, values = signal.get("label"), signal["values"]
        full = f"{prefix}.{label.text.strip() if isinstance(label, Text) and label.text.strip() else name}"
        full = f"{prefix}.{name}" if full in found.sizes or f"{full}[1]" in found.sizes else full
        if isinstance(values, Variable):
            _add(full, values, clock, None if vector is None else ("time", vector), found)
        else:
            found.unusable[full] = Remark(LeftOut.NO_VALUES)


def _is_testlab(group: Group) -> bool:
    """Whether a group is a signal as Simcenter Testlab writes it, sampled evenly over time in seconds."""
    abscissa, ordinate = group.get("x_values"), group.get("y_values")
    if not isinstance(abscissa, Mapping) or not isinstance(ordinate, Mapping):
        return False
    values = isinstance(ordinate.get("values"), Variable)
    return values and _quantity(abscissa).lower() == "s" and bool(_stated(abscissa))


def _quantity(group: Group) -> str:
    """Return the unit that a group of Simcenter Testlab states."""
    quantity = group.get("quantity")
    label = quantity.get("label") if isinstance(quantity, Mapping) else None
    return label.text.strip() if isinstance(label, Text) else ""


def _add_testlab(name: str, group: Group, found: _Found) -> None:
    """Add a signal of Simcenter Testlab by the name of its structure."""
    abscissa, ordinate = group["x_values"], group["y_values"]
    assert isinstance(abscissa, Mapping)
    assert isinstance(ordinate, Mapping)
    values, start = ordinate["values"], abscissa.get("start_value")
    assert isinstance(values, Variable)
    first = float(np.ravel(start.read())[0]) if isinstance(start, Variable) and start.size == 1 else 0.0
    clock = TimeBase(name=name, start=first, rate=next(iter(_stated(abscissa).values())))
    _add(name, replace(values, unit=_quantity(ordinate)), clock, None, found)
