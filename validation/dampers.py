"""Curves of dampers from drives: a simulator of its own, and how near `damper_curve` comes.

Quarter cars are integrated by the Runge-Kutta method of fourth order in steps of a quarter of a millisecond, all runs
of a row side by side, over the roads of `validation.motion`; friction is full above 0.15 mm/s. Loggers sample behind a
zero-phase filter against aliasing.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, resample_poly, sosfiltfilt

from suspid import DamperCurve, Suspension, SuspidError, damper_curve, quarter_car, read_record
from suspid.levels import NORMAL_95
from suspid.text_tables import text_table
from suspid.units import Hertz, RealArray, Second
from validation.motion import LEVELS, road_heights

RUNS = int(os.environ.get("SUSPID_SEEDS", "50"))
FIRST_SEED = 730_000  # the method was developed on lower ones
STEP: Second = 0.00025
CREEP = 1.5e-4  # m/s: friction is a straight rise below; RK4 is stable down to 1e-4 at this step
MASS, WHEEL, STIFFNESS, TIRE, TIRE_DAMPING = 350.0, 50.0, 22e3, 210e3, 60.0
NOISE = {"chassis_acceleration": 0.03, "tire_acceleration": 0.1, "chassis_travel": 2e-5}
ACCELEROMETERS = ("chassis_acceleration", "tire_acceleration")
# 30 % off in stiffness and damping.
NOMINAL = quarter_car(
    chassis_mass=MASS, tire_mass=WHEEL, chassis_stiffness=0.7 * STIFFNESS, tire_stiffness=TIRE, chassis_damping=1690,
    tire_damping=TIRE_DAMPING,
)  # fmt: skip


@dataclass(frozen=True)
class Law:
    """Force of a damper: a rate, and changes of rate at some velocities [N s/m, m/s]."""

    rate: float
    kinks: tuple[tuple[float, float], ...] = ()

    def force(self, velocity: RealArray) -> RealArray:
        """Return the force without friction [N]."""
        total = self.rate * velocity
        for at, change in self.kinks:
            total = total + change * (np.maximum(velocity - at, 0.0) - max(-at, 0.0))
        return np.asarray(total)


# 1:3 in compression and rebound; digressive: the same with a quarter to a third of the rate beyond 0.1 m/s.
LAWS = {
    "linear": Law(1300.0),
    "bilinear": Law(650.0, ((0.0, 1300.0),)),
    "digressive": Law(350.0, ((-0.1, 550.0), (0.0, 1800.0), (0.1, -1650.0))),
}


@dataclass(frozen=True)
class Damper:
    """A law with Coulomb friction [N]."""

    law: Law
    friction: float = 0.0


@dataclass(frozen=True)
class Days:
    """What each drive has of its own, as factors: forces of the damper, spring, and mass of the body."""

    damper: RealArray | float = 1.0
    spring: RealArray | float = 1.0
    mass: RealArray | float = 1.0


Push = Callable[[RealArray, int], RealArray]  # a force on the body [N] at times [s], of the drive with a seed


def engine(t: RealArray, seed: int) -> RealArray:
    """Return the force of an engine on the body: 30 N at 25 Hz, and half as much at each of two harmonics."""
    phases = np.random.default_rng([22, seed]).uniform(0, 2 * np.pi, 3)
    parts = [30.0 / 2**k * np.sin(2 * np.pi * 25.0 * (k + 1) * t + phase) for k, phase in enumerate(phases)]
    return np.asarray(np.sum(parts, axis=0))


def engine_of_varying_speed(t: RealArray, seed: int) -> RealArray:
    """Return the same of an engine whose speed swings by a fifth in 13 s."""
    *phases, start = np.random.default_rng([24, seed]).uniform(0, 2 * np.pi, 4)
    angle = 2 * np.pi * np.cumsum(25.0 * (1 + 0.2 * np.sin(2 * np.pi * t / 13 + start))) * (t[1] - t[0])
    parts = [30.0 / 2**k * np.sin((k + 1) * angle + phase) for k, phase in enumerate(phases)]
    return np.asarray(np.sum(parts, axis=0))


def slow(t: RealArray, seed: int) -> RealArray:
    """Return a random force on the body from 1 to 3 Hz, of 30 N root mean square."""
    step = 0.01
    coarse = np.arange(t[0], t[-1] + step, step)
    noise = np.random.default_rng([23, seed]).standard_normal(len(coarse))
    made = sosfiltfilt(butter(4, [1.0, 3.0], "bandpass", fs=1 / step, output="sos"), noise)
    return np.asarray(np.interp(t, coarse, 30.0 * made / np.std(made)))


PUSHES: dict[str, Push | None] = {
    "": None,
    "engine": engine,
    "engine of varying speed": engine_of_varying_speed,
    "force at 1-3 Hz": slow,
}


def drives(
    dampers: Sequence[Damper],
    road: str,
    seeds: Sequence[int],
    *,
    seconds: Second = 60.0,
    rate: Hertz = 200.0,
    speed: float = 20.0,
    days: Days = Days(),
    push: Push | None = None,
) -> list[dict[str, RealArray]]:
    """Return the clean channels of some drives by name, (drive, sample), for each damper; the roads are the same.

    ``push`` is a force on the body that is no part of the car.
    """
    lead, h = 2.0, STEP
    steps = 2 * round((seconds + 2 * lead) / h / 2)
    t = h / 2 * np.arange(2 * steps + 1)
    heights = np.empty((len(t), len(seeds)))
    for i, seed in enumerate(seeds):
        rng = np.random.default_rng([20, seed])
        pace = speed * (1 + 0.15 * np.sin(2 * np.pi * t / 30 + rng.uniform(0, 2 * np.pi)))
        heights[:, i] = road_heights(np.cumsum(pace)[None] * h / 2, LEVELS[road], rng)[0]
    rates = np.gradient(heights, h / 2, axis=0)
    pushes = (
        np.zeros(heights.shape)
        if push is None
        else np.stack([push(np.asarray(t, float), seed) for seed in seeds], axis=1)
    )
    state = np.zeros((4, len(dampers), len(seeds)))
    kept = np.empty((steps // 2, 3, len(dampers), len(seeds)), np.float32)

    def slope(s: RealArray, z: RealArray, v: RealArray, f: RealArray) -> RealArray:
        travel, velocity = s[0] - s[1], s[2] - s[3]
        own = [
            days.damper * one.law.force(w) + one.friction * np.clip(w / CREEP, -1, 1)
            for one, w in zip(dampers, velocity, strict=True)
        ]
        strut = days.spring * STIFFNESS * travel + np.array(own)
        tire = TIRE * (s[1] - z) + TIRE_DAMPING * (s[3] - v)
        return np.array([s[2], s[3], (f - strut) / (days.mass * MASS), (strut - tire) / WHEEL])

    for k in range(steps):
        (z0, z1, z2), (v0, v1, v2) = heights[2 * k : 2 * k + 3], rates[2 * k : 2 * k + 3]
        f0, f1, f2 = pushes[2 * k : 2 * k + 3]
        first = slope(state, z0, v0, f0)
        if k % 2 == 0:
            kept[k // 2] = first[2], first[3], state[0] - state[1]
        second = slope(state + h / 2 * first, z1, v1, f1)
        third = slope(state + h / 2 * second, z1, v1, f1)
        last = slope(state + h * third, z2, v2, f2)
        state = state + h / 6 * (first + 2 * second + 2 * third + last)
    begin, count = round(lead * rate), round(seconds * rate)
    made = []
    for i in range(len(dampers)):
        logged = resample_poly(
            kept[:, :, i].astype(float), 1, round(1 / (2 * h * rate)), axis=0, window=("kaiser", 8.0)
        )
        rows = logged[begin : begin + count].transpose(1, 2, 0)
        made.append(dict(zip((*ACCELEROMETERS, "chassis_travel"), rows, strict=True)))
    return made


def write_test_drives(path: Path) -> None:
    """Write the drives of tests/test_damper_curve.py: 20 s on class B, without noise."""
    kinds = (("linear", 0.0), ("bilinear", 0.0), ("digressive", 30.0))
    made = drives([Damper(LAWS[law], friction) for law, friction in kinds], "B", [5], seconds=20.0)
    content = {
        f"{law}_{friction:g}_{name}": values[0].astype(np.float32)
        for (law, friction), clean in zip(kinds, made, strict=True)
        for name, values in clean.items()
    }
    np.savez_compressed(path, **content)


@dataclass(frozen=True, kw_only=True)
class Row:
    """A row of the report."""

    law: str
    friction: float
    road: str
    channels: tuple[str, ...] = ACCELEROMETERS
    push: str = ""  # what pushes the body

    @property
    def name(self) -> str:
        """What the row is called."""
        friction = f", {self.friction:g} N" if self.friction else ""
        by = ", travel" if "chassis_travel" in self.channels else ""
        return f"{self.law}{friction}, class {self.road}{by}{self.push and f', {self.push}'}"


def as_file(clean: Mapping[str, RealArray], channels: Sequence[str], seed: int, path: Path) -> None:
    """Write what the sensors give as text, with six digits as loggers do."""
    rng = np.random.default_rng([21, seed])
    rows = [clean[name] + NOISE[name] * rng.standard_normal(len(clean[name])) for name in channels]
    t = np.arange(len(rows[0])) / 200.0
    header = ",".join(["time", *channels])
    np.savetxt(
        path,
        np.column_stack([t, *rows]),
        fmt=["%.3f", *["%.6g"] * len(rows)],
        delimiter=",",
        header=header,
        comments="",
    )


def rows() -> list[Row]:
    """Return all rows."""
    made = [
        Row(law=law, friction=friction, road=road)
        for law, friction in (
            ("linear", 0.0),
            ("bilinear", 0.0),
            ("bilinear", 30.0),
            ("digressive", 0.0),
            ("digressive", 30.0),
            ("digressive", 60.0),
        )
        for road in "BC"
    ]
    by_travel = [
        Row(law=law, friction=friction, road=road, channels=("chassis_acceleration", "chassis_travel"))
        for law, friction in (("linear", 0.0), ("bilinear", 30.0), ("digressive", 30.0), ("digressive", 60.0))
        for road in "BC"
    ]
    pushed = [
        Row(law=law, friction=friction, road=road, push=push)
        for push in ("force at 1-3 Hz", "engine", "engine of varying speed")
        for law, friction in (("linear", 0.0), ("bilinear", 30.0))
        for road in "BC"
        if law == "bilinear" or road == "B"
    ]
    return [*made, *by_travel, *pushed]


@dataclass(frozen=True, kw_only=True, eq=False)
class Tally:
    """What became of the runs of a row; nodes are those of each run."""

    failed: int
    error: RealArray  # (run, node) [N]
    allowed: RealArray  # (run, node): 2 % or 5 N, the larger
    holds: NDArray[np.bool_]  # (run, node)
    stiffness: RealArray  # (run,): relative error
    stiffness_holds: NDArray[np.bool_]
    friction: RealArray  # (run,): error [N]
    friction_holds: NDArray[np.bool_]
    lines: float  # share of runs in which a line is not rejected
    doubts: float  # share of runs with a doubt
    seconds: float


def tally(row: Row, clean: Mapping[str, RealArray], *, runs: int, nominal: Suspension = NOMINAL) -> Tally:
    """Return errors and coverage of a row; ``clean`` are its channels, (run, sample)."""
    law, found, spent = LAWS[row.law], list[DamperCurve](), list[float]()
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):
            path = Path(folder) / f"drive_{run}.csv"
            as_file({name: values[run] for name, values in clean.items()}, row.channels, FIRST_SEED + run, path)
            record = read_record(path)
            start = time.process_time()
            try:
                found.append(damper_curve(record, nominal, strut="chassis"))
            except SuspidError:
                continue
            spent.append(time.process_time() - start)
    true = [law.force(one.velocities) for one in found]
    moving = [one.velocities != 0 for one in found]
    errors = np.array([(one.forces - f)[use] for one, f, use in zip(found, true, moving, strict=True)])
    stds = np.array([one.std[use] for one, use in zip(found, moving, strict=True)])
    sizes = np.array([np.abs(f[use]) for f, use in zip(true, moving, strict=True)])
    k, k_std = (np.array([getattr(one, a) for one in found]) for a in ("stiffness", "stiffness_std"))
    mu, mu_std = (np.array([getattr(one, a) for one in found]) for a in ("friction", "friction_std"))
    return Tally(
        failed=runs - len(found),
        error=errors,
        allowed=np.maximum(0.02 * sizes, 5.0),
        holds=np.abs(errors) <= NORMAL_95 * stds,
        stiffness=k / STIFFNESS - 1,
        stiffness_holds=np.abs(k - STIFFNESS) <= NORMAL_95 * k_std,
        friction=mu - row.friction,
        friction_holds=np.abs(mu - row.friction) <= NORMAL_95 * mu_std,
        lines=float(np.mean([bool(one.linear) for one in found])),
        doubts=float(np.mean([bool(one.verdict.doubts) for one in found])),
        seconds=float(np.median(spent)),
    )


HEAD = """# Curves of dampers from drives

Quarter car (350 and 50 kg, 22 kN/m, 210 kN/m), 20 m/s, 60 s at 200 Hz, accelerometers with 0.03 (body) and 0.1 m/s2
(wheel) of noise, or the travel with 0.02 mm instead of the wheel. Records are text files of a simulator of its
own (`validation/dampers.py`). Dampers: 1300 N s/m; 650 in compression and 1950 in rebound; the same kind with a third
of the rate or less beyond 0.1 m/s (digressive); some with 30 or 60 N of friction. The nominal car is 30 % off. An
engine pushes the body with 30 N at 25 Hz, 15 N at 50 Hz and 7.5 N at 75 Hz; where its speed varies, by a fifth in 13 s.
A force at 1-3 Hz is random, of 30 N root mean square.

RMSE of nodes is over all nodes and runs; 'over limit' is the root mean square of the error over 2 % of the force or
5 N, whichever is larger, of the worst node. Coverage is the share of 95 % intervals that hold, of all nodes and of the
worst one. 'line' is the share of runs in which the damper is not told from a viscous one, at a level of 1 %.
`SUSPID_SEEDS=50 python -m validation dampers` writes this."""


COLUMNS = (
    "damper, road", "runs", "failed", "RMSE of nodes [N]", "over limit", "nodes that hold", "worst node",
    "k bias, RMSE [%]", "k holds", "friction bias, RMSE [N]", "friction holds", "line", "doubts", "time [s]",
)  # fmt: skip


def table(cases: Sequence[Row], *, runs: int = RUNS) -> str:
    """Return the table of some rows."""
    columns: dict[str, list[str]] = {name: [] for name in COLUMNS}
    clean = _driven(cases, runs)
    for row in cases:
        made = tally(row, clean[row.law, row.friction, row.road, row.push], runs=runs)
        for column, cell in zip(columns.values(), cells_of(row, made), strict=True):
            column.append(cell)
    return text_table(columns)


def cells_of(row: Row, made: Tally) -> tuple[str, ...]:
    """Return the line of the table of a row."""
    worst = np.sqrt(np.mean((made.error / made.allowed) ** 2, axis=0))
    return (
        row.name,
        str(made.failed + len(made.error)),
        str(made.failed),
        f"{np.sqrt(np.mean(made.error**2)):.2f}",
        f"{np.max(worst):.2f}",
        f"{np.mean(made.holds):.1%}",
        f"{np.min(np.mean(made.holds, axis=0)):.0%}",
        f"{100 * np.mean(made.stiffness):+.3f}, {100 * np.sqrt(np.mean(made.stiffness**2)):.3f}",
        f"{np.mean(made.stiffness_holds):.0%}",
        f"{np.mean(made.friction):+.2f}, {np.sqrt(np.mean(made.friction**2)):.2f}",
        f"{np.mean(made.friction_holds):.0%}",
        f"{made.lines:.0%}",
        f"{made.doubts:.0%}",
        f"{made.seconds:.2f}",
    )


def _driven(cases: Sequence[Row], runs: int) -> dict[tuple[str, float, str, str], dict[str, RealArray]]:
    """Return the channels of all dampers, roads and forces on the body of some rows."""
    made: dict[tuple[str, float, str, str], dict[str, RealArray]] = {}
    for road, push in sorted({(row.road, row.push) for row in cases}):
        kinds = sorted({(row.law, row.friction) for row in cases if (row.road, row.push) == (road, push)})
        dampers = [Damper(LAWS[law], friction) for law, friction in kinds]
        found = drives(dampers, road, range(FIRST_SEED, FIRST_SEED + runs), push=PUSHES[push])
        made |= {(*kind, road, push): clean for kind, clean in zip(kinds, found, strict=True)}
    return made


def report() -> str:
    """Return the report."""
    return f"{HEAD}\n\n```\n{table(rows())}\n```\n"
