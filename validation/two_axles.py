"""Tires and wheel masses of a half car whose axles roll over one track, from drives of five minutes.

The rear wheel rolls beside the front's track: an isotropic road has the coherence ``(x K_1(x))^2`` between two parallel
tracks, with x = 2 pi n times their distance, where its spectrum falls with the square of wave number (K. Dodds and
J. Robson, J. Sound Vib. 31 (1973) 175-183). Its spectrum is the same on both.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import CubicSpline
from scipy.special import k1

from suspid import Suspension, SuspidError, estimate
from suspid.levels import NORMAL_95
from suspid.records import as_response
from suspid.text_tables import text_table
from suspid.units import Metre, Ratio, RealArray, Second
from validation.cars import TWO_AXLES
from validation.motion import CORNER, FINE, GRID, LEVELS, PATCH, RADIUS, STEP, _logged, integrated

if TYPE_CHECKING:
    import control

SEEDS = int(os.environ.get("SUSPID_SEEDS", "50"))
FIRST_SEED = 760_000  # the method was developed on lower ones
RATE, SPEED, WHEELBASE = 200.0, 20.0, 2.5
CHANNELS = ("heave_acceleration", "pitch_acceleration", "front_acceleration", "rear_acceleration")
BODY_NOISE, WHEEL_NOISE = 0.03, 0.1  # of sensors on the body above each axle, and on the wheels [m/s2]
NAMES = ("front_tire.stiffness", "rear_tire.stiffness", "front.mass", "rear.mass")
HEAD = """## Two axles on one track

A half car, told that its rear road is its front road 2.5 m later. The distance of the rear wheel's track from the
front's is stated; the speed ripples by 5 % within 6 s besides. Tires and wheel masses of both axles; 'alone' is RMSE
without being told. Draws were not used in development."""


@dataclass(frozen=True, kw_only=True, slots=True)
class AxleRow:
    """A drive of two axles."""

    name: str
    aside: Metre = 0.0  # of the rear wheel from the front's track
    ripple: Ratio = 0.0  # of the speed, in 6 s
    order: float = 0.0  # force of unbalanced wheels [N]
    duration: Second = 300.0


ROWS = (
    AxleRow(name="one track"),
    AxleRow(name="1 cm aside, ripple", aside=0.01, ripple=0.05),
    AxleRow(name="3 cm aside, ripple", aside=0.03, ripple=0.05),
    AxleRow(name="unbalance 80 N", order=80.0),
)


def heights(distance: RealArray, aside: Metre, rng: np.random.Generator) -> RealArray:
    """Return the heights under both wheels."""
    low = float(np.min(distance)) - WHEELBASE - 1
    count = next_fast_len(int(np.ceil((float(np.max(distance)) - low + 1 / CORNER) / GRID)) + 4, real=True)
    n = np.fft.rfftfreq(count, GRID)[1:]
    patch = np.hanning(PATCH + 2)[1:-1]
    seen = np.cos(2 * np.pi * n[:, None] * GRID * (np.arange(PATCH) - PATCH // 2)) @ (patch / np.sum(patch))
    size = np.sqrt(LEVELS["B"] * (n / 0.1) ** -2.0 * (n > CORNER) / (4 * count * GRID)) * count * seen
    lines = rng.standard_normal((4, len(n)))
    front, own = size * (lines[0] + 1j * lines[1]), size * (lines[2] + 1j * lines[3])
    shared = np.clip(2 * np.pi * n * aside * k1(2 * np.pi * n * aside), 0, 1) if aside else np.ones_like(n)
    rear = shared * front + np.sqrt(1 - shared**2) * own
    places = GRID * np.arange(count)
    profiles = [CubicSpline(places, np.fft.irfft(np.concatenate([[0.0], row]), count)) for row in (front, rear)]
    return np.stack([profiles[0](distance - low), profiles[1](distance - WHEELBASE - low)])


def draw(row: AxleRow, seed: int) -> tuple[control.TimeResponseData, RealArray, Suspension]:
    """Return a record, the speed at its samples, and the car."""
    rng = np.random.default_rng(seed)
    damping = np.abs(60 + 30 * rng.standard_normal(2))
    car = TWO_AXLES.with_parameters(damping={"front_tire": float(damping[0]), "rear_tire": float(damping[1])})
    lead: Second = 2.0
    t = STEP / 2 * np.arange(round((row.duration + 2 * lead) / STEP) * 2 + 1)
    swing = 0.15 * np.sin(2 * np.pi * t / 30 + rng.uniform(0, 2 * np.pi))
    swing += row.ripple * np.sin(2 * np.pi * t / 6 + rng.uniform(0, 2 * np.pi))
    distance = np.cumsum(SPEED * (1 + swing)) * STEP / 2
    inputs = np.zeros((8, len(t)))
    inputs[:2] = heights(distance, row.aside, rng)
    inputs[2:4] = np.gradient(inputs[:2], STEP / 2, axis=1)
    for i in range(2):
        # Tires of one kind differ by some parts in a thousand.
        turned = distance / RADIUS * (1 + 0.003 * i) + rng.uniform(0, 2 * np.pi)
        inputs[6 + i] = row.order * (1 + swing) ** 2 * np.sin(turned)
    accelerations = integrated(car, inputs, np.zeros(8))[1]
    first, count = round(lead * RATE), round(row.duration * RATE)
    clean = np.array([_logged(one, RATE)[first : first + count] for one in accelerations])
    above = np.array([[1.0, -1.1], [1.0, 1.4]])  # heave and pitch, above front and rear axle
    sensors = above @ clean[:2] + BODY_NOISE * rng.standard_normal((2, count))
    rows = np.vstack([np.linalg.solve(above, sensors), clean[2:] + WHEEL_NOISE * rng.standard_normal((2, count))])
    speed = _logged(SPEED * (1 + swing[:: 2 * FINE]), RATE)[first : first + count]
    return as_response(np.arange(count) / RATE, rows, CHANNELS), speed, car


def table(rows: tuple[AxleRow, ...] = ROWS, *, seeds: int = SEEDS) -> str:
    """Return the table of some cases."""
    columns: dict[str, list[str]] = {}
    true = np.array([190e3, 200e3, 40.0, 45.0])
    for row in rows:
        errors, holds, alone, spent, failed = [], [], [], [], 0
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            record, speed, car = draw(row, seed)
            up = 1.2 if seed % 2 else 0.8
            nominal = car.with_parameters(
                stiffness={"front": up * 21e3, "rear": 24e3 / up, "front_tire": 190e3 / up, "rear_tire": up * 200e3},
                masses={"front": up * 40, "rear": 45 / up}, damping={"front_tire": 60, "rear_tire": 60},
            )  # fmt: skip
            both = []
            for behind in (None, {"road_rear": ("road_front", WHEELBASE)}):
                start = time.process_time()
                try:
                    found = estimate(
                        record, nominal, given=("wheels",), free_masses=("front", "rear"), road="iso8608",
                        speed=speed, wheel_radius=RADIUS, behind=behind,
                    )  # fmt: skip
                except SuspidError:
                    failed += behind is not None
                    break
                at = [found.parameters.index(name) for name in NAMES]
                both.append((found.values[at] - true, np.sqrt(np.diag(found.covariance))[at]))
                spent += [time.process_time() - start] if behind else []
            if len(both) == 2:
                alone.append(both[0][0] / true)
                errors.append(both[1][0] / true)
                holds.append(np.abs(both[1][0]) <= NORMAL_95 * both[1][1])
        line = {"drive": row.name, "draws": str(seeds), "failed": str(failed)}
        for label, part in (("kt", slice(0, 2)), ("mu", slice(2, 4))):
            own, single = 100 * np.array(errors)[:, part], 100 * np.array(alone)[:, part]
            line[f"{label} bias"] = f"{np.mean(own):+.2f}"
            line[f"{label} RMSE"] = f"{np.sqrt(np.mean(own**2)):.2f}"
            line[f"{label} alone"] = f"{np.sqrt(np.mean(single**2)):.2f}"
            line[f"{label} cover"] = f"{100 * np.mean(np.array(holds)[:, part]):.0f}"
        line["time [s]"] = f"{np.median(spent):.2f}"
        for name, cell in line.items():
            columns.setdefault(name, []).append(cell)
    return text_table(columns)


def section(*, seeds: int = SEEDS) -> str:
    """Return the section of the report."""
    return f"{HEAD}\n\n```\n{table(seeds=seeds)}\n```"


if __name__ == "__main__":
    import sys

    sys.stdout.write(f"{section()}\n")
