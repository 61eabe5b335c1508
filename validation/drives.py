"""Drives as loggers store them: which stretches are taken, and what springs and dampers come out of them."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from suspid import DriveAnalysis, SuspidError, analyse_drive, body_modes, eigenmodes, quarter_car
from suspid.text_tables import text_table
from suspid.units import Hertz, RealArray
from validation.drive_worlds import RATE, Habits, World, world, written
from validation.motion import Drive, driven, record_of

SEEDS = int(os.environ.get("SUSPID_SEEDS", "50"))
BODY_SEEDS = int(os.environ.get("SUSPID_BODY_SEEDS", str(SEEDS)))
DURATION = 400.0
CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
NOMINAL = CAR.with_parameters(stiffness={"chassis": 15.4e3}, damping={"chassis": 1690.0})
TRUTH = {"chassis.stiffness": 22e3, "chassis.damping": 1300.0}
# What nobody would argue about: clearly usable, and clearly not. In between either is right.
CLEAR_SPEED, CLEAR_ACCELERATION = (2.0, 4.0), (1.2, 2.0)
FEWEST_BLOCKS_IN_A_ROW = 13  # of a clearly usable stretch: 10 s and its ends

LOGGERS = {
    "CSV, speed in km/h, lateral acceleration": Habits(),
    "speed swings by 40 %": Habits(swing=0.4),
    "MDF4, g, CAN speed in mph at 10 Hz, yaw rate": Habits(
        suffix=".mf4", speed="mph", speed_rate=10.0, speed_step=0.5, across="yaw", unit="g"
    ),
    "MDF4, GPS speed in kn at 1 Hz, lateral": Habits(suffix=".mf4", speed="kn", speed_rate=1.0, unit="g"),
    "TDMS, no speed, tilted accelerometers": Habits(suffix=".tdms", speed=None, along=True, tilt=0.9),
    "CSV, neither speed nor accelerations": Habits(speed=None, across=None),
    "CSV, three times the faults": Habits(faults=6),
}
HEAD = """# Drives as loggers store them

Quarter cars are driven for {duration:.0f} s: they stand, gather speed, cruise, corner and brake, as drawn from wide
distributions, on roads of class A to C. Braking and cornering push the body by the height of its centre of gravity.
Sensors stick, lose samples, send marks, are knocked beyond their range; the file is what a logger makes of it. Nothing
of this knows the limits of `DriveLimits`. `SUSPID_SEEDS=50 python -m validation drives` prints these tables; {seeds}
drives a row.

*Found* is the share of clearly usable time that was taken: at {fast:g} m/s or more, with less than {mild:g} m/s2 along
and across, all sensors right, in stretches of {row} s at least. *Wrongly taken* is the share of clearly unusable time
that was taken: below {slow:g} m/s, above {hard:g} m/s2, or with a fault of a sensor in that second; the seconds by
reason stand beside it. k and c are estimated over all stretches taken, with gain and delay of the wheel's sensor and
the mount of the damper unknown, from 30 % off. *Failed*: no estimate.
"""
BODY = """## The body alone

One accelerometer on the body, {minutes:.0f} min at 20 m/s ±15 %, roads with one exponent or two
(`SUSPID_BODY_SEEDS` sets how many drives a row, which were not used during development). *Covered*: share of
drives whose 95 % interval holds the natural frequency; *width*: median width of the interval over the frequency;
*refused*: no frequency. Damping is never reported; the last column has the range of the damping ratios by the models,
over the true one."""
HOUR = """## One hour

A half car, from an MDF4 file of one hour, eight channels at 200 Hz (accelerations at both ends of the body and of both
wheels in g, speed in km/h, lateral and longitudinal acceleration, engine speed; 29 MB): `suspid drive hour.mf4 --car
half.toml --json hour.json`, stretches, springs, dampers, their curves, wear and grip. The nominal car is the true one.
Measured once.

```
  drives    usable    k, c found / true - 1    processor time    memory
--------  --------  -----------------------  ----------------  --------
       1    2794 s         -0.08 … +0.07 %              16 s  0.53 GiB
```"""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Judged:
    """Seconds of one drive: clearly usable and found, clearly unusable and taken, by reason."""

    usable: int
    found: int
    unusable: int
    taken: int
    slow: int
    hard: int
    faulty: int


def truth_of(drive: World) -> dict[str, NDArray[np.bool_]]:
    """Return what is clear of each second of a drive."""
    size = round(RATE)
    count = len(drive.times) // size

    def each(values: RealArray) -> RealArray:
        return np.asarray(values[: count * size].reshape(count, size))

    speed, fault = each(drive.way.speed), each(drive.faulty.astype(float))
    hard = np.maximum(np.abs(each(drive.way.along)), np.abs(each(drive.way.across)))
    # Brief peaks at the ends of braking are not what is meant: half a second counts.
    harder = np.quantile(hard, 0.5, axis=1)
    bad_sensor = np.sum(fault, axis=1) > 0.1 * size
    slow = np.max(speed, axis=1) < CLEAR_SPEED[0]
    fine = (np.min(speed, axis=1) > CLEAR_SPEED[1]) & (np.max(hard, axis=1) < CLEAR_ACCELERATION[0])
    fine &= np.sum(fault, axis=1) == 0
    long = np.zeros(count, bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], fine.astype(int), [0]])))
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        long[first:after] = after - first >= FEWEST_BLOCKS_IN_A_ROW
    return {"usable": long, "slow": slow, "hard": (harder > CLEAR_ACCELERATION[1]) & ~slow, "faulty": bad_sensor}


def judged(drive: World, found: DriveAnalysis) -> Judged:
    """Return how the stretches that were taken compare with the truth."""
    truth = truth_of(drive)
    middle = np.arange(len(truth["usable"])) + 0.5
    taken = np.zeros(len(middle), bool)
    for one in found.drives[0].taken:
        taken |= (middle > one.start) & (middle < one.stop)
    unusable = truth["slow"] | truth["hard"] | truth["faulty"]
    return Judged(
        usable=int(np.sum(truth["usable"])),
        found=int(np.sum(truth["usable"] & taken)),
        unusable=int(np.sum(unusable)),
        taken=int(np.sum(unusable & taken)),
        slow=int(np.sum(truth["slow"] & taken)),
        hard=int(np.sum(truth["hard"] & taken)),
        faulty=int(np.sum(truth["faulty"] & taken)),
    )


def drives_table(seeds: int = SEEDS) -> str:
    """Return the table of all loggers."""
    heads = ("logger", "found", "wrongly taken", "slow / hard / faulty [s]", "failed", "explained", "k, c RMSE [%]",
             "k, c bias [%]", "k, c coverage [%]", "s a drive")  # fmt: skip
    columns: dict[str, list[str]] = {head: [] for head in heads}
    for name, habits in LOGGERS.items():
        seconds, errors, holds, explained, spent = [], [], [], 0, []
        for seed in range(seeds):
            rng = np.random.default_rng(seed)
            made = world(CAR, habits, DURATION, rng)
            with tempfile.TemporaryDirectory() as folder:
                path = written(Path(folder, f"drive{habits.suffix}"), made, habits, rng)
                start = time.process_time()
                try:
                    found = analyse_drive(path, car=NOMINAL, curves=False)
                except SuspidError:
                    continue
                spent.append(time.process_time() - start)
            seconds.append(judged(made, found))
            if found.estimate is None:
                continue
            ends, names = found.estimate.interval(0.95), found.estimate.parameters
            explained += found.explains
            errors.append([found.estimate.values[names.index(p)] / true - 1 for p, true in TRUTH.items()])
            holds.append([ends[p][0] <= true <= ends[p][1] for p, true in TRUTH.items()])
        sums = {part: sum(getattr(one, part) for one in seconds) for part in Judged.__slots__}
        error = np.array(errors).reshape(-1, 2)
        cells = (
            name,
            f"{sums['found'] / max(sums['usable'], 1):.1%}",
            f"{sums['taken'] / max(sums['unusable'], 1):.2%}",
            f"{sums['slow']} / {sums['hard']} / {sums['faulty']}",
            f"{seeds - len(errors)}/{seeds}",
            f"{explained}/{len(errors)}",
            _pair(100 * np.sqrt(np.mean(error**2, axis=0)), "{:.2f}"),
            _pair(100 * np.mean(error, axis=0), "{:+.2f}"),
            _pair(100 * np.mean(np.array(holds).reshape(-1, 2), axis=0), "{:.0f}"),
            f"{np.median(spent):.1f}",
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)
    return text_table(columns)


BODY_SECONDS = 600.0
BODY_FIRST_SEED = 730_000  # the method was developed on lower ones
ROADS = {
    "2": (2.0, 2.0),
    "1.6, then 2.4": (1.6, 2.4),
    "2.4, then 1.6": (2.4, 1.6),
}
DAMPERS = (900.0, 2100.0)


def body_line(damping: float, road: str, seeds: int = BODY_SEEDS) -> dict[str, str]:
    """Return the line of the table of frequencies from one accelerometer on the body."""
    car = CAR.with_parameters(damping={"chassis": damping})
    modes = eigenmodes(car)
    true: Hertz = float(modes.wn[0] / (2 * np.pi))
    covered, widths, refused, zetas = [], [], 0, []
    for seed in range(BODY_FIRST_SEED, BODY_FIRST_SEED + seeds):
        rng = np.random.default_rng(seed)
        drive = Drive(duration=BODY_SECONDS, rate=100.0, exponents=ROADS[road], noise={"chassis_acceleration": 0.03})
        record = record_of(*driven(car, drive, rng), ("chassis_acceleration",), drive, rng)
        (mode,) = body_modes([record])
        if not mode.models:
            refused += 1
            continue
        low, high = mode.interval(0.95)
        covered.append(low <= true <= high)
        widths.append((high - low) / true)
        zetas += [zeta / float(modes.zeta[0]) for zeta in mode.zetas]
    return {
        "damper, zeta": f"{damping:.0f} N s/m, {float(modes.zeta[0]):.2f}",
        "exponents": road,
        "drives": str(seeds),
        "covered": f"{np.mean(covered):.0%}" if covered else "",
        "width": f"{np.median(widths):.0%}" if widths else "",
        "refused": f"{refused}/{seeds}",
        "zeta by model / true": f"{min(zetas):.2f} … {max(zetas):.2f}" if zetas else "",
    }


def body_table(lines: Sequence[Mapping[str, str]]) -> str:
    """Return the table of frequencies from one accelerometer on the body."""
    return text_table({name: [line[name] for line in lines] for name in lines[0]})


def _pair(values: RealArray, form: str) -> str:
    return ", ".join(form.format(value) for value in values)


def report() -> str:
    """Return both tables, or that of drives alone where the other is to have no draws."""
    head = HEAD.format(
        duration=DURATION, seeds=SEEDS, fast=CLEAR_SPEED[1], slow=CLEAR_SPEED[0], mild=CLEAR_ACCELERATION[0],
        hard=CLEAR_ACCELERATION[1], row=FEWEST_BLOCKS_IN_A_ROW,
    )  # fmt: skip
    drives = f"{head}\n```\n{drives_table()}\n```\n"
    if not BODY_SEEDS:
        return drives
    lines = [body_line(damping, road) for damping in DAMPERS for road in ROADS]
    body = f"{BODY.format(minutes=BODY_SECONDS / 60)}\n\n```\n{body_table(lines)}\n```"
    return f"{drives}\n{body}\n\n{HOUR}\n"
