"""Estimates from records of another simulator, and from a car that the model leaves half out."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from suspid import Suspension, estimate, half_car, quarter_car
from suspid.records import as_response
from suspid.text_tables import text_table
from suspid.units import RealArray
from suspid.words import EstimateCheck
from validation.greybox_bounds import changed, value_of
from validation.motion import Drive, driven

DATA = Path(os.environ.get("SUSPID_DATA", Path(__file__).parents[2] / "shared" / "data")) / "rizoit_seat3dof_sim"
RECORDS = ("chirp", "step50mm", "release")
SIMULATED = quarter_car(
    seat_mass=88, chassis_mass=270, tire_mass=60, seat_stiffness=16e3, chassis_stiffness=27e3, tire_stiffness=200e3,
    seat_damping=500, chassis_damping=2000, tire_damping=0,
)  # fmt: skip


def simulator_table() -> str:
    """Return the errors from each record of the other simulator and from all three, where the data are at hand."""
    if not DATA.exists():
        return f"The records are not at hand: {DATA.name} in SUSPID_DATA."
    names = [f"{s.name}.{q}" for q in ("stiffness", "damping") for s in SIMULATED.struts if getattr(s, q)]
    nominal = SIMULATED
    for name, factor in zip(names, np.resize([0.7, 1.3], len(names)), strict=True):
        nominal = changed(nominal, name, value_of(SIMULATED, name) * float(factor))
    records = {}
    for name in RECORDS:
        table = np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)[::2]
        motions = {"seat": "z_seat_m", "chassis": "z_body_m", "tire": "z_wheel_m", "road": "z_road_m"}
        samples = np.array([table[column] for column in motions.values()])
        records[name] = as_response(table["t_s"], samples, tuple(motions))
    columns: dict[str, list[str]] = {"record": [], "k": [], "c": []}
    for label, used in {**{name: [name] for name in RECORDS}, "all three": list(RECORDS)}.items():
        found = estimate([records[name] for name in used], nominal, given=("road",), fixed=["tire.damping"])
        errors = {name: abs(value_of(found.suspension, name) / value_of(SIMULATED, name) - 1) for name in names}
        columns["record"].append(label)
        for cell, quantity in (("k", "stiffness"), ("c", "damping")):
            columns[cell].append(f"{max(e for name, e in errors.items() if name.endswith(quantity)):.1e}")
    return text_table(columns)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Corner:
    """What a quarter car found on the corner of a half car."""

    error: RealArray  # of k and c, relative
    half_width: RealArray  # of their 95 % intervals, relative to what was found
    holds: bool  # both intervals
    told: bool


def corner(axle: str, index: float, seed: int) -> Corner:
    """Return the estimate of a strut by a quarter car of the mass that the half car shows there."""
    ahead, behind, mass = 1.25, 1.35, 600.0
    struts = {"front": (22e3, 1350.0), "rear": (24e3, 1450.0)}
    car = half_car(
        chassis_mass=mass, pitch_inertia=mass * ahead * behind * index, front_tire_mass=40, rear_tire_mass=42,
        cg_to_front=ahead, cg_to_rear=behind, front_stiffness=struts["front"][0], rear_stiffness=struts["rear"][0],
        front_tire_stiffness=190e3, rear_tire_stiffness=200e3, front_damping=struts["front"][1],
        rear_damping=struts["rear"][1],
    )  # fmt: skip
    lever = ahead if axle == "front" else -behind
    true = np.array(struts[axle])
    model: Suspension = quarter_car(
        chassis_mass=1 / (1 / mass + lever**2 / car.masses["pitch"]), tire_mass=40, tire_stiffness=190e3,
        chassis_stiffness=0.7 * true[0], chassis_damping=1.3 * true[1],
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    clean, times = driven(car, Drive(), rng)
    above = clean["heave_acceleration"] - lever * clean["pitch_acceleration"]
    rows = np.array([above, clean[f"{axle}_acceleration"]])
    rows += np.array([[0.03], [0.1]]) * rng.standard_normal(rows.shape)
    found = estimate(
        as_response(times, rows, ("chassis_acceleration", "tire_acceleration")), model, given=("tire",)
    )  # fmt: skip
    values = np.array([found.suspension.struts[0].stiffness, found.suspension.struts[0].damping])
    ends = np.array([found.interval()[f"chassis.{name}"] for name in ("stiffness", "damping")])
    return Corner(
        error=values / true - 1,
        half_width=(ends[:, 1] - ends[:, 0]) / 2 / values,
        holds=bool(np.all((ends[:, 0] <= true) & (true <= ends[:, 1]))),
        told=any(check.remark.code is EstimateCheck.FOLLOWS for check in found.verdict.checks),
    )


def corner_table(*, seeds: int) -> str:
    """Return how often a quarter car on a half car is told to be wrong, by how much it is, and how much is stated."""
    columns: dict[str, list[str]] = {
        name: []
        for name in (
            "axle", "dynamic index", "draws", "told", "RMS error of k, c [%]", "stated, 95 % [%]", "both hold",
        )
    }  # fmt: skip
    for axle in ("front", "rear"):
        for index in (0.6, 0.71, 0.8, 0.87, 0.95, 1.0, 1.05, 1.1, 1.2):
            found = [corner(axle, index, seed) for seed in range(seeds)]
            rms = 100 * np.sqrt(np.mean([one.error**2 for one in found], axis=0))
            stated = 100 * np.median([one.half_width for one in found], axis=0)
            cells = (
                axle,
                f"{index:g}",
                str(seeds),
                f"{np.mean([one.told for one in found]):.0%}",
                f"{rms[0]:.2g}, {rms[1]:.2g}",
                f"{stated[0]:.2g}, {stated[1]:.2g}",
                f"{np.mean([one.holds for one in found]):.0%}",
            )
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    return text_table(columns)
