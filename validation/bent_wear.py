"""Wear of dampers that are not viscous: drives of the simulator of `validation.dampers`, judged by their curves."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from suspid import DamperCurve, DamperState, Estimate, SuspidError, WearRule, damper_curve, estimate, wear
from suspid.records import as_response
from suspid.text_tables import text_table
from suspid.units import RealArray
from validation.dampers import ACCELEROMETERS, LAWS, NOISE, NOMINAL, Damper, Days, drives

RUNS = int(os.environ.get("SUSPID_SEEDS", "50"))
FIRST_SEED = 740_000  # the method was developed on lower ones
KINDS = (("bilinear", 0.0), ("digressive", 30.0))
LOST = (0.0, 0.3)
RULE = WearRule()
HEAD = """## Dampers that are not viscous

Drives of 60 s on roads of class B by the simulator of dampers.md; each day has a damper, a spring and a load of its own
as above. Bilinear 1:3; the same digressive, with 30 N of friction that wear leaves as it is. A drive is judged against
one earlier drive of the new damper, curve by curve. Told: watch or worn. Draws that were not used in development."""
Made = Callable[..., Sequence[Mapping[str, RealArray]]]


def days_of(count: int, remaining: float, rng: np.random.Generator) -> Days:
    """Return so many days on which a share of the damping is left."""
    damper, spring, mass = np.exp(
        np.array([[RULE.damper_std], [RULE.spring_std], [RULE.load_std]]) * rng.standard_normal((3, count))
    )
    return Days(damper=remaining * damper, spring=spring, mass=mass)


def judged(law: str, friction: float, lost: float, runs: int = RUNS, made: Made = drives) -> list[DamperState]:
    """Return the states that drives with a loss are given, each against an earlier drive without."""
    rng = np.random.default_rng([FIRST_SEED, round(100 * lost)])
    found = []
    for remaining, first in ((1.0, FIRST_SEED), (1.0 - lost, FIRST_SEED + 1000 * round(1 + 10 * lost))):
        seeds = range(first, first + runs)
        clean = made([Damper(LAWS[law], friction)], "B", seeds, days=days_of(runs, remaining, rng))[0]
        found.append([drive_of(clean, i, rng) for i in range(runs)])
    states = []
    for before, now in zip(*found, strict=True):
        if before is None or now is None:
            states.append(DamperState.CANNOT_TELL)
            continue
        told = wear(now[0], before=before[0], curves=[now[1]], curves_before=[[before[1]]])
        states.append(told.states["chassis"])
    return states


def drive_of(clean: Mapping[str, RealArray], run: int, rng: np.random.Generator) -> tuple[Estimate, DamperCurve] | None:
    """Return what is found in a drive; None if nothing is."""
    rows = [clean[name][run] + NOISE[name] * rng.standard_normal(len(clean[name][run])) for name in ACCELEROMETERS]
    record = as_response(0.005 * np.arange(len(rows[0]), dtype=float), np.array(rows, float), list(ACCELEROMETERS))
    try:
        return estimate(record, NOMINAL, given=("tire",)), damper_curve(record, NOMINAL, strut="chassis")
    except SuspidError:
        return None


def cells_of(law: str, friction: float, lost: float, states: Sequence[DamperState]) -> dict[str, str]:
    """Return a line of the table."""
    count = Counter(states)
    told = count[DamperState.WATCH] + count[DamperState.WORN]
    return {
        "damper": f"{law}{f', {friction:g} N' if friction else ''}",
        "lost": f"{lost:.0%}",
        "runs": str(len(states)),
        "told": f"{told / len(states):.0%}",
        **{str(state): f"{count[state] / len(states):.0%}" for state in DamperState},
    }


def bent_section(lines: Sequence[Mapping[str, str]] | None = None) -> str:
    """Return the section of the report."""
    if lines is None:
        lines = [cells_of(*kind, lost, judged(*kind, lost)) for kind in KINDS for lost in LOST]
    return f"{HEAD}\n\n```\n{text_table({name: [line[name] for line in lines] for name in lines[0]})}\n```"
