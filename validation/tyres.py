"""Tires, wheel masses and modes of the whole car from drives of five minutes, with a model of the road.

Records come from the independent motion of `validation.motion`; the library starts 30 % off in all that it looks for.
"""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from suspid import Estimate, Suspension, SuspidError, eigenmodes, estimate
from suspid.levels import NORMAL_95
from suspid.signals import as_signal
from suspid.text_tables import text_table
from suspid.units import RealArray
from validation.greybox_peers import ssi_poles
from validation.greybox_rows import NOISE, QUARTER
from validation.motion import LEVELS, RADIUS, Drive, driven, record_of
from validation.two_axles import section
from validation.tyre_bounds import Asked, tire_bound

if TYPE_CHECKING:
    import control

SEEDS = int(os.environ.get("SUSPID_SEEDS", "50"))
FIRST_SEED = 730_000  # the method was developed on lower ones
PEER_SEEDS = min(SEEDS, 20)
CHANNELS = ("chassis_acceleration", "tire_acceleration")
NAMES = ("kt/mu", "kt", "mu", "f1", "zeta1", "f2", "zeta2")
DAMPING = (60.0, 30.0)  # of the tires of all draws [N s/m]: mean and standard deviation, cut at 0
UP, DOWN = (1.5, 2.5), (2.5, 1.5)
UNBALANCE = 80.0

HEAD = """# Tires, wheel masses and modes of the whole car from a drive

A quarter car (350 and 50 kg, 22 and 210 kN/m, 1300 N s/m) drives for five minutes at 20 m/s ±15 %, sampled at 200 Hz by
accelerometers on body and wheel (noise 0.03 and 0.1 m/s2), on roads of class B unless another is named. Records come
from an independent integrator (`validation/motion.py`). Springs, dampers and the wheel's mass start 30 % off, up and
down in turn; the body's mass is known. The tire's damping differs in every draw, 60 ± 30 N s/m, and `estimate` knows
so much of it, as it does by default. Speed and rolling radius are known unless the row says otherwise. Roads are
straight power laws, or bent at 0.17 cycle/m, in the middle of the band.

Bias and RMSE are in % of the truth. Coverage is how many of the 95 % intervals hold. G is the road's mean roughness
G_d(0.1 cycle/m), where the road is straight. Time is processor time of `estimate` on this machine.

'bound' is the Cramér-Rao bound (`validation/tyre_bounds.py`) with all that is unknown: spring, damper, gain, delay and
mount, the level of every stretch, the exponent, the tire's damping, and a smooth departure of 30 % from the power law.
The errors of kt and of the wheel's mass are alike, and their ratio is known much better. kt alone to 2 % is out of
reach for one axle in five minutes: even on a road that is exactly a power law, with a tire whose damping is known, the
bound is 2.5 %. kt/mu to 2 % is at the bound, and so is kt where the wheel's mass is known: weigh it. The bound is that
of the mean over all roads that depart so from a power law; on a straight one errors can be smaller.
`SUSPID_SEEDS=50 python -m validation tyres` writes this page."""
HARM = """## What is left out

The same drives, of which `estimate` is not told something. The verdict names what it does not know."""
PEERS = """## Beside SSI

RMSE of modes in % on the same records. pyOMA_2's SSI-cov takes the excitation for white noise and gives no springs and
masses. It works at 50 Hz with 30 block rows; at the order of the car, 4, it misses the body's mode, so its order is 20
and the poles that are nearest to the true ones are taken, which only a simulation tells. Errors of more than half
the truth count as failed."""
SLOWER = 4  # how many samples SSI takes as one
SSI_ORDER = 20
FAILED = 0.5


@dataclass(frozen=True, kw_only=True, slots=True)
class TireRow:
    """A drive, and what `estimate` is told of it."""

    name: str
    drive: Drive
    radius: float | None = RADIUS
    speed_known: bool = True
    speed_factor: float = 1.0  # of the speed that is told, such as of a speedometer
    mass_known: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)


def rows() -> dict[str, list[TireRow]]:
    """Return all cases by section of the report."""
    base = Drive(duration=300.0, noise=NOISE)

    def row(name: str, *, told: Mapping[str, Any] | None = None, **drive: Any) -> TireRow:
        return TireRow(name=name, drive=replace(base, **drive), **(told or {}))

    return {
        "Five minutes": [
            row("exponent 2"),
            row("exponent 1.5", exponents=(1.5, 1.5)),
            row("exponent 2.5", exponents=(2.5, 2.5)),
            row("bent, 1.5 to 2.5", exponents=UP),
            row("bent, 2.5 to 1.5", exponents=DOWN),
            row("speed ±40 %", spread=0.4),
            row("unbalance 80 N", order=UNBALANCE),
            row("unbalance 80 N, speed ±40 %", order=UNBALANCE, spread=0.4),
            row("unbalance, ±40 %, bent 1.5 to 2.5", order=UNBALANCE, spread=0.4, exponents=UP),
            row("unbalance, ±40 %, bent 2.5 to 1.5", order=UNBALANCE, spread=0.4, exponents=DOWN),
            row("class A", road="A"),
        ],
        "Other lengths and knowledge": [
            row("60 s", duration=60.0),
            row("wheel's mass known", told={"mass_known": True}),
            row("unbalance, speed told 2 % high", order=UNBALANCE, told={"speed_factor": 1.02}),
        ],
        "Left out": [
            row("speed not told", told={"speed_known": False, "radius": None}),
            row("speed not told, bent 1.5 to 2.5", exponents=UP, told={"speed_known": False, "radius": None}),
            row("unbalance 80 N, radius not told", order=UNBALANCE, told={"radius": None}),
        ],
    }


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class TireTally:
    """What became of the draws of a case; the last axis is `NAMES`."""

    failed: int
    error: RealArray  # (draw, name): relative
    holds: RealArray  # (draw, name)
    roughness: RealArray  # (draw,): whether the interval of the road's roughness holds
    seconds: float


def draw(row: TireRow, seed: int) -> tuple[control.TimeResponseData, RealArray, Suspension]:
    """Return a record, the speed at its samples, and the car."""
    rng = np.random.default_rng(seed)
    damping = abs(DAMPING[0] + DAMPING[1] * float(rng.standard_normal()))
    car = QUARTER.with_parameters(damping={"tire": damping})
    clean, times = driven(car, row.drive, rng)
    return record_of(clean, times, CHANNELS, row.drive, rng), clean["speed"], car


def found_in(row: TireRow, record: control.TimeResponseData, speed: RealArray) -> Estimate:
    """Return the estimate from 30 % off."""
    nominal = QUARTER.with_parameters(
        stiffness={"chassis": 0.7 * 22e3, "tire": 1.3 * 210e3},
        damping={"chassis": 1.3 * 1300, "tire": DAMPING[0]},
        masses={} if row.mass_known else {"tire": 0.7 * 50},
    )
    return estimate(
        record, nominal, given=("tire",), free_masses=() if row.mass_known else ("tire",), road="iso8608",
        speed=row.speed_factor * speed if row.speed_known else None, wheel_radius=row.radius, **row.options,
    )  # fmt: skip


def compared(found: Estimate, car: Suspension) -> tuple[RealArray, RealArray]:
    """Return relative errors of what `NAMES` names, and their standard deviations."""
    k, m = (found.parameters.index(n) if n in found.parameters else None for n in ("tire.stiffness", "tire.mass"))
    assert k is not None
    strut, mass = next(s for s in found.suspension.struts if s.name == "tire"), found.suspension.masses["tire"]
    scale = np.where(found.values == 0, 1.0, found.values)
    relative = found.covariance / np.outer(scale, scale)
    of_k = float(relative[k, k])
    of_m, both = (0.0, 0.0) if m is None else (float(relative[m, m]), float(relative[k, m]))
    stiffness, true = strut.stiffness / 210e3, mass / 50.0
    errors, stds = [stiffness / true - 1, stiffness - 1, true - 1], [of_k + of_m - 2 * both, of_k, of_m]
    # Where a mount is found, by chance, there is a real pole too.
    modes, exact = found.modes[found.modes.zeta < 1], eigenmodes(car)
    assert modes.wn_std is not None
    assert modes.zeta_std is not None
    ratios = (modes.wn / exact.wn - 1, modes.zeta / exact.zeta - 1)
    spreads = (modes.wn_std / modes.wn, modes.zeta_std / modes.zeta)
    order = [(0, 0), (1, 0), (0, 1), (1, 1)]
    errors += [float(ratios[i][j]) for i, j in order]
    return np.array(errors), np.append(np.sqrt(stds), [float(spreads[i][j]) for i, j in order])


def tally(row: TireRow, *, seeds: int = SEEDS) -> TireTally:
    """Return errors and coverage of a case over many draws."""
    errors, holds, rough, spent, failed = [], [], [], [], 0
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        record, speed, car = draw(row, seed)
        start = time.process_time()
        try:
            found = found_in(row, record, speed)
        except SuspidError:
            failed += 1
            continue
        spent.append(time.process_time() - start)
        error, std = compared(found, car)
        errors.append(error)
        holds.append(np.abs(np.log1p(error)) <= NORMAL_95 * std)
        ends = found.road[0].interval()
        rough.append(np.nan if ends is None else float(ends[0] < LEVELS[row.drive.road] < ends[1]))
    straight = len(set(row.drive.exponents)) == 1 and row.speed_factor == 1
    return TireTally(
        failed=failed,
        error=np.array(errors),
        holds=np.array(holds, float),
        roughness=np.array(rough if straight else [np.nan]),
        seconds=float(np.median(spent)),
    )


def asked_of(row: TireRow) -> Asked:
    """Return the drive of a case as the bound takes it; bent roads have a mean exponent."""
    return Asked(
        duration=row.drive.duration,
        speed=row.drive.speed,
        spread=row.drive.spread,
        exponent=float(np.mean(row.drive.exponents)),
        roughness=LEVELS[row.drive.road],
        tire_damper_std=DAMPING[1],
        wheel_known=row.mass_known,
    )


def cells_of(row: TireRow, done: TireTally) -> dict[str, str]:
    """Return a line of the table."""
    bias, rmse = 100 * np.mean(done.error, axis=0), 100 * np.sqrt(np.mean(done.error**2, axis=0))
    held = 100 * np.mean(done.holds, axis=0)
    cells = {"drive": row.name, "draws": str(done.failed + len(done.error)), "failed": str(done.failed)}
    bound = tire_bound(asked_of(row))
    for i, name in enumerate(NAMES[:3]):
        known = row.mass_known and name == "mu"
        cells[f"{name} bias"] = "known" if known else f"{bias[i]:+.1f}"
        cells[f"{name} RMSE"] = "" if known else f"{rmse[i]:.2f}"
        cells[f"{name} bound"] = "" if known else f"{100 * bound[name]:.2f}"
        cells[f"{name} cover"] = "" if known else f"{held[i]:.0f}"
    for i, name in enumerate(NAMES[3:], 3):
        cells[f"{name} RMSE"] = f"{rmse[i]:.2f}"
        cells[f"{name} bound"] = f"{100 * bound[name]:.2f}"
    cells["modes cover"] = f"{np.mean(held[3:]):.1f}"
    cells["G cover"] = "" if np.all(np.isnan(done.roughness)) else f"{100 * np.mean(done.roughness):.0f}"
    cells["time [s]"] = f"{done.seconds:.2f}"
    return cells


def table(cases: list[TireRow], *, seeds: int = SEEDS) -> str:
    """Return the table of some cases."""
    lines = [cells_of(row, tally(row, seeds=seeds)) for row in cases]
    return text_table({name: [line[name] for line in lines] for name in lines[0]})


def peers_table(*, seeds: int = PEER_SEEDS) -> str:
    """Return the table of modes beside pyOMA_2's, where it is installed."""
    if not importlib.util.find_spec("pyoma2"):
        return "pyOMA_2 is not installed."
    columns: dict[str, list[str]] = {name: [] for name in ("drive", "method", "failed", *NAMES[3:])}
    every = {row.name: row for row in rows()["Five minutes"]}
    for name in ("exponent 2", "bent, 1.5 to 2.5", "unbalance 80 N"):
        ours, theirs, failed = [], [], 0
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            record, speed, car = draw(every[name], seed)
            ours.append(compared(found_in(every[name], record, speed), car)[0][3:])
            try:
                one = _by_ssi(record, car)
            except ValueError:
                one = np.full(4, np.inf)
            failed += bool(np.any(np.abs(one) > FAILED))
            theirs += [one] if np.all(np.abs(one) <= FAILED) else []
        for method, errors, lost in (("suspid, estimate", ours, 0), ("pyOMA_2 SSI-cov, nearest poles", theirs, failed)):
            rmse = 100 * np.sqrt(np.mean(np.square(errors), axis=0)) if errors else np.full(4, np.nan)
            cells = (name, method, f"{lost}/{seeds}", *(f"{value:.2f}" for value in rmse))
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    return text_table(columns)


def _by_ssi(record: control.TimeResponseData, car: Suspension) -> RealArray:
    """Return the errors of the poles that are nearest to the true ones.

    Raises
    ------
    ValueError
        If there are none.
    """
    from scipy.signal import decimate

    signal, exact = as_signal(record), eigenmodes(car)
    slow = np.asarray(decimate(signal.values, SLOWER, axis=1, zero_phase=True), float)
    poles = ssi_poles(slow, SLOWER * signal.step, SSI_ORDER)[0]
    nearest = poles[np.argmin(np.abs(poles - exact.poles[:, None]), axis=1)]
    wn, zeta = np.abs(nearest), -nearest.real / np.abs(nearest)
    return np.column_stack([wn / exact.wn - 1, zeta / exact.zeta - 1]).ravel()


def report() -> str:
    """Return the tables of all cases."""
    sections = rows()
    parts = [HEAD]
    parts += [f"## {name}\n\n```\n{table(sections[name])}\n```" for name in list(sections)[:2]]
    parts.append(section())
    parts += [f"{HARM}\n\n```\n{table(sections['Left out'])}\n```", f"{PEERS}\n\n```\n{peers_table()}\n```"]
    return "\n\n".join(parts) + "\n"
