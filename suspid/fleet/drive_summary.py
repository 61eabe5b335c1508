"""Summary of drives: frequencies of bodies, and the loss of each damper of each vehicle."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from suspid.fleet.damper_trends import DamperTrends, trends_of_rates
from suspid.fleet.parts import read_table
from suspid.fleet.tables import dampers_named
from suspid.model import Suspension
from suspid.performance import Rates, WearRule, parallel_spring
from suspid.units import RealArray
from suspid.words import Level

# Estimates of this level do not tell of wear, as in `wear`.
UNTRUSTED = (Level.DOUBTFUL.label, Level.NONE.label)


def placed_drives(folder: Path) -> tuple[list[str], dict[str, tuple[str, float]]]:
    """Return the names of the drives, and vehicle and time of those that have both."""
    table = read_table(folder, "drives", columns=["record", "vehicle", "time"]).to_pydict()
    rows = zip(table["record"], table["vehicle"], table["time"], strict=True)
    return table["record"], {name: (who, when) for name, who, when in rows if who is not None and when is not None}


def body_quantities(folder: Path) -> Iterator[tuple[str, str, list[str], RealArray, RealArray]]:
    """Yield name, unit, drives, values and standard deviations of the frequency of the body in each channel.

    Their intervals are over models of the road and not those of a normal law: no standard deviations are stated.
    """
    table = read_table(folder, "drives", columns=["record", "body_channels", "body_hz"]).to_pydict()
    found: dict[str, list[tuple[str, float]]] = {}
    for name, channels, hertz in zip(*table.values(), strict=True):
        for channel, value in zip(channels or (), hertz or (), strict=True):
            found.setdefault(channel, []).append((name, value))
    for channel, rows in found.items():
        names, values = [name for name, _ in rows], np.array([value for _, value in rows])
        yield f"{channel} f", "Hz", names, values, np.full(len(rows), np.nan)


def wear_counts(folder: Path, car: Suspension) -> dict[str, dict[str, int]]:
    """Return in how many drives each damper has each state of wear against its nominal value."""
    names = dampers_named(car)
    table = read_table(folder, "drives", columns=[f"{name}.wear" for name in names]).to_pydict() if names else {}
    counts = {name: Counter(state for state in table[f"{name}.wear"] if state is not None) for name in names}
    return {name: dict(sorted(states.items())) for name, states in counts.items() if states}


def untrusted_drives(folder: Path) -> int:
    """Return how many drives have an estimate that cannot be built upon."""
    table = read_table(folder, "drives", columns=["verdict", "explains"]).to_pydict()
    rows = zip(table["verdict"], table["explains"], strict=True)
    return sum(1 for verdict, explains in rows if explains is not None and verdict in UNTRUSTED)


def drive_dampers(
    folder: Path, vehicles: Mapping[str, tuple[str, float]], car: Suspension, rule: WearRule | None
) -> DamperTrends:
    """Return the trends of the dampers of a car over the drives of each vehicle whose estimates can be built upon."""
    rows = ((vehicles[name], damper, rates) for name, damper, rates in _rates(folder, car) if name in vehicles)
    every = ((vehicle, damper, when, rates) for (vehicle, when), damper, rates in rows)
    return trends_of_rates(every, WearRule() if rule is None else rule)


def _rates(folder: Path, car: Suspension) -> Iterator[tuple[str, str, Rates]]:
    """Yield drive, damper, and its rates with their covariance."""
    for damper in dampers_named(car):
        names = [f"{damper}.damping", f"{damper}.damping_std", f"{damper}.correlation"]
        spring = parallel_spring(car, damper)
        springs = [] if spring is None else [f"{spring}.stiffness", f"{spring}.stiffness_std"]
        table = read_table(folder, "drives", columns=["record", "verdict", *names, *springs]).to_pydict()
        nothing = itertools.repeat(None, len(table["record"]))
        k, k_std = ([table[name] for name in springs]) or (nothing, nothing)
        columns = [table["record"], table["verdict"], *(table[name] for name in names), k, k_std]
        for record, verdict, c, c_std, correlation, stiffness, spread in zip(*columns, strict=True):
            if c_std is None or verdict in UNTRUSTED:
                continue
            # A spring that was held has no error, and says nothing of the load.
            known = stiffness is not None and spread is not None
            std = np.array([c_std, spread if known else 0.0])
            covariance = np.outer(std, std) * np.array([[1.0, correlation or 0.0], [correlation or 0.0, 1.0]])
            yield record, damper, Rates(damping=c, stiffness=stiffness if known else 0.0, covariance=covariance)
