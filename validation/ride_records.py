"""Figures of records: intervals that hold, over drives of an independent integrator.

The car stands on a weak, a middle and a strong damper, so that its body has resonances from narrow to wide.
"""

from __future__ import annotations

import os

import numpy as np

from suspid import quarter_car, ride
from suspid.records import as_response
from suspid.text_tables import text_table
from suspid.units import RealArray, Second
from validation.motion import Drive, driven

SEEDS = int(os.environ.get("SUSPID_SEEDS", "30"))
FIRST_SEED = 970_000
DAMPERS = (250.0, 650.0, 1300.0)
LENGTHS: tuple[Second, ...] = (20.0, 60.0, 300.0)
LEAD: Second = 20.0  # of a drive before the record: the weakest damper leaves e^-7 of the start
FIGURES = {
    "body.rms": "body_acceleration.rms",
    "Wk": "body_acceleration.Wk",
    "VDV": "body_acceleration.VDV",
    "travel": "strut.travel",
}
TONES = ((0.3, 60.0), (1.0, 20.0), (1.0, 60.0), (3.0, 20.0), (30.0, 60.0))  # rms over that of the noise, seconds


def drive_of(damping: float, seconds: Second, seed: int) -> tuple[RealArray, RealArray]:
    """Return the acceleration of the body and the travel of a quarter car at 200 Hz, on a road of class C."""
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=damping
    )
    drive = Drive(duration=seconds + LEAD, rate=200.0, road="C", speed=20.0, spread=0.0)
    clean, times = driven(car, drive, np.random.default_rng([FIRST_SEED, seed]))
    used = times >= LEAD
    return clean["chassis_acceleration"][used], (clean["chassis"] - clean["tire"])[used]


def held(records: list[tuple[RealArray, RealArray]]) -> tuple[dict[str, str], dict[str, float]]:
    """Return how often the 95 % interval of each figure holds its expected value, and how wide it is."""
    found = [
        ride(as_response(np.arange(len(a)) / 200.0, np.array([a, x]), ["body_acceleration", "strut_travel"]))
        for a, x in records
    ]
    shares: dict[str, str] = {}
    widths: dict[str, float] = {}
    for short, name in FIGURES.items():
        power = 4 if short == "VDV" else 2
        truth = float(np.mean([one[name] ** power for one in found])) ** (1 / power)
        ends = np.array([one.interval()[name] for one in found])
        above, below = float(np.mean(ends[:, 0] > truth)), float(np.mean(ends[:, 1] < truth))
        shares[short] = f"{100 * (1 - above - below):.1f} ({100 * above:.1f}, {100 * below:.1f})"
        widths[short] = float(np.median(ends[:, 1] / ends[:, 0]))
    return shares, widths


def car_table(seeds: int) -> str:
    """Return the table of intervals over drives of a car."""
    rows: dict[str, list[str]] = {
        "c [N s/m]": [], "length [s]": [], "records": [], **{name: [] for name in FIGURES}, "ratio": [],
    }  # fmt: skip
    for damping in DAMPERS:
        for seconds in LENGTHS:
            # Of long records a quarter, which take as long.
            count = seeds if seconds < LENGTHS[-1] else seeds // 4
            shares, widths = held([drive_of(damping, seconds, seed) for seed in range(count)])
            cells = [f"{damping:.0f}", f"{seconds:.0f}", str(count), *shares.values(), f"{widths['travel']:.2f}"]
            for column, cell in zip(rows.values(), cells, strict=True):
                column.append(cell)
    return text_table(rows)


def tone_table(seeds: int) -> str:
    """Return the table of intervals of a steady tone of 13.7 Hz in white noise."""
    rows: dict[str, list[str]] = {"tone / noise": [], "length [s]": [], "body.rms": [], "Wk": [], "VDV": []}
    for ratio, seconds in TONES:
        t = np.arange(round(200 * seconds)) / 200.0
        records = []
        for seed in range(seeds):
            rng = np.random.default_rng([FIRST_SEED, 1, seed])
            sine = 2**0.5 * ratio * np.sin(2 * np.pi * 13.7 * t + rng.uniform(0, 2 * np.pi))
            records.append((rng.standard_normal(len(t)) + sine, rng.standard_normal(len(t)) / 100))
        shares, _ = held(records)
        cells = [f"{ratio:g}", f"{seconds:.0f}", *(shares[name] for name in ("body.rms", "Wk", "VDV"))]
        for column, cell in zip(rows.values(), cells, strict=True):
            column.append(cell)
    return text_table(rows)


def report() -> str:
    """Return the report as markdown."""
    return "\n\n".join([
        "# Intervals of figures of records",
        f"Of {SEEDS} records, where no other number is stated, the percentage whose 95 % interval holds the expected "
        f"figure, and in brackets those "
        f"whose interval is above and below it. The expected figure is that of the mean over all these records.",
        "## A car on a road",
        "Quarter car, 350 / 50 kg on 22 / 210 kN/m, class C at 20 m/s, 200 Hz, integrated by `validation/motion.py`. "
        "With c = 250 N s/m the body's damping ratio is 0.05. Ratio: upper over lower end of the interval of travel.",
        f"```\n{car_table(SEEDS)}\n```",
        "## A steady tone in noise",
        "A tone of 13.7 Hz and white noise, sampled at 200 Hz; its level is the ratio of the rms of both.",
        f"```\n{tone_table(SEEDS)}\n```",
    ]) + "\n"  # fmt: skip
