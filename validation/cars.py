"""Cars of the reports: the paper's, heavily damped ones, two close modes, random ones."""

from __future__ import annotations

import numpy as np

from suspid import Strut, Suspension, full_car, half_car, quarter_car

PAPER = quarter_car(
    seat_mass=200, chassis_mass=200, tire_mass=200,
    seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    seat_damping=300, chassis_damping=200, tire_damping=100,
)  # fmt: skip
HATCHBACK = quarter_car(
    seat_mass=80, chassis_mass=320, tire_mass=40,
    seat_stiffness=20e3, chassis_stiffness=22e3, tire_stiffness=190e3,
    seat_damping=900, chassis_damping=1600, tire_damping=50,
)  # fmt: skip
SALOON = quarter_car(
    seat_mass=60, chassis_mass=350, tire_mass=45,
    seat_stiffness=12e3, chassis_stiffness=25e3, tire_stiffness=180e3,
    seat_damping=650, chassis_damping=1200, tire_damping=0,
)  # fmt: skip
VAN = quarter_car(
    seat_mass=75, chassis_mass=520, tire_mass=55,
    seat_stiffness=9e3, chassis_stiffness=38e3, tire_stiffness=240e3,
    seat_damping=380, chassis_damping=2600, tire_damping=80,
)  # fmt: skip


def close_pair(separation: float, zeta: float = 0.01) -> Suspension:
    """Return two equal masses, weakly coupled, with two modes whose frequencies differ by ``separation``."""
    stiffness, mass = 100e3, 100.0
    tie = stiffness * ((1 + separation) ** 2 - 1) / 2
    damping = 2 * zeta * np.sqrt(stiffness * mass)
    return Suspension(
        masses={"left": mass, "right": mass},
        struts=(
            Strut(name="left", stiffness=stiffness, damping=damping, arms={"left": 1, "ground": -1}),
            Strut(name="right", stiffness=stiffness, damping=damping, arms={"right": 1, "ground": -1}),
            Strut(name="tie", stiffness=tie, damping=0.0, arms={"left": 1, "right": -1}),
        ),
    )


def random_car(rng: np.random.Generator) -> Suspension:
    """Return a quarter car with a seat, its parameters drawn from the ranges of passenger cars."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    return quarter_car(
        seat_mass=between(50, 110), chassis_mass=between(250, 500), tire_mass=between(30, 60),
        seat_stiffness=between(8e3, 25e3), chassis_stiffness=between(15e3, 40e3), tire_stiffness=between(150e3, 280e3),
        seat_damping=between(200, 900), chassis_damping=between(700, 2500), tire_damping=between(10, 100),
    )  # fmt: skip


FOUR_WHEELS = full_car(
    chassis_mass=1200, pitch_inertia=1800, roll_inertia=500, front_tire_mass=40, rear_tire_mass=40, cg_to_front=1.2,
    cg_to_rear=1.5, front_track=1.5, rear_track=1.5, front_stiffness=20e3, rear_stiffness=18e3,
    front_antiroll_stiffness=8e3, front_tire_stiffness=200e3, rear_tire_stiffness=200e3, front_damping=1500,
    rear_damping=1400,
)  # fmt: skip
TWO_AXLES = half_car(
    chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=45, cg_to_front=1.1, cg_to_rear=1.4,
    front_stiffness=21e3, rear_stiffness=24e3, front_tire_stiffness=190e3, rear_tire_stiffness=200e3,
    front_damping=1350, rear_damping=1100,
)  # fmt: skip
