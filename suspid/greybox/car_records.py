"""Records in the terms of a car: channels named as it names them, in SI units where the names state units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.cleaning import RecordLike, as_record, si_unit, to_si
from suspid.errors import InputError
from suspid.io import bare_name, bracketed_unit
from suspid.model import FORCE, Suspension, names_channel
from suspid.records import inputs_of, like
from suspid.signals import as_signal
from suspid.wording import AtCommandLine

if TYPE_CHECKING:
    import control

# What follows the name of a coordinate where the unit of a channel says what it measures.
MEANT = {"m/s": "_velocity", "m/s2": "_acceleration", "N": FORCE}


def record_of_car(record: RecordLike, car: Suspension) -> control.TimeResponseData:
    """Return a record whose channels have the names of the car's, without the units behind them, in SI.

    A file's ``"chassis_force [kN]"`` is the force ``"chassis_force"`` in newtons. A unit that is not known leaves the
    channel as it is.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> record = as_record([[1.0, 2.0], [3.0, 4.0]], fs=10, channels=["chassis_force [kN]", "T [degC]"])
    >>> made = record_of_car(record, car)
    >>> made.output_labels, made.y[0]
    (['chassis_force', 'T [degC]'], array([1000., 2000.]))
    """
    made = as_record(record)
    signal = as_signal(made)
    short = [bare_name(name) for name in signal.channels]
    names, factors = list(signal.channels), np.ones(len(signal.channels))
    for i, (name, own) in enumerate(zip(signal.channels, short, strict=True)):
        unit = bracketed_unit(name)
        if unit and own not in signal.channels and short.count(own) == 1 and names_channel(car, own):
            try:
                factors[i] = float(to_si(1.0, unit)[0])
            except InputError:
                continue
            names[i] = own
    if tuple(names) == signal.channels:
        return made
    title = str(getattr(made, "title", None) or "")
    values = signal.values * factors[:, None]
    return like(made, signal.timepts, values, names, title=title, inputs=inputs_of(made))


def example(channels: Sequence[str], coordinates: Sequence[str]) -> str:
    """Return how a channel may be renamed: one whose name holds that of a coordinate, or else the first.

    A unit in brackets tells what is measured.

    Examples
    --------
    >>> example(["t", "z_seat_m"], ["seat", "chassis"]), example(["a1"], ["seat"])
    ('z_seat_m=seat', 'a1=seat')
    >>> example(["Force [N]", "acc body [g]"], ["chassis"])
    "'Force [N]'=chassis_force"
    """
    alike = [(channel, name) for name in coordinates for channel in channels if name in channel]
    channel, name = alike[0] if alike else (channels[0], coordinates[0])
    return renaming(channel, name + MEANT.get(si_unit(bracketed_unit(channel)), ""))


def _how(channel: str, name: str) -> AtCommandLine:
    return AtCommandLine("rename", renaming(channel, name))


def renaming(channel: str, name: str) -> str:
    """Return a channel and its new name as the option --rename takes them."""
    return f"'{channel}'={name}" if " " in channel else f"{channel}={name}"


def nameless_forces(units: Mapping[str, str], car: Suspension) -> list[str]:
    """Return what is to be said of channels of force, by name and unit, whose names do not say what they push.

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3,
    ...                   tire_stiffness=200e3, chassis_damping=1500)
    >>> nameless_forces({"shaker": "N", "chassis_acceleration": "m/s2"}, car)[0][:48]
    "channel 'shaker' is a force and was not used; if"
    """
    on_mass, in_strut = force_names(car)
    return [
        f"channel {name!r} is a force and was not used; if it moved the car, name it by what it pushes: one mass "
        f"{on_mass!r}{_how(name, on_mass)}, or the ends of a strut apart, {in_strut!r}{_how(name, in_strut)}"
        for name, unit in units.items()
        if si_unit(unit) == "N" and not names_channel(car, name)
    ]


def force_names(car: Suspension) -> tuple[str, str]:
    """Return how a force on a mass, and one between the ends of a strut, are named: those of the first."""
    return f"{car.coordinates[0]}{FORCE}", f"{car.struts[0].name}_travel{FORCE}"
