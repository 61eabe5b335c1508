"""Whole drives as loggers store them: stops, braking, cornering, faults of sensors, and the habits of loggers.

How a car is driven, and what its sensors do wrong, is drawn from wide distributions that know no threshold of the
library. The motion is that of `validation.motion`; braking and cornering push the body as they do, by the height of its
centre of gravity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from suspid import Suspension
from suspid.units import Hertz, RealArray, Second
from validation.motion import LEVELS, STEP, _logged, integrated, road_heights

RATE: Hertz = 200.0
LEVERS = (0.2, 0.35)  # height of the centre of gravity over wheelbase, and over track
NOISE = {"chassis_acceleration": 0.03, "tire_acceleration": 0.1}
GRAVITY = 9.80665


@dataclass(frozen=True, kw_only=True, slots=True)
class Habits:
    """What a logger does, and how often its sensors fail."""

    suffix: str = ".csv"
    speed: str | None = "km/h"  # unit of the speed; None: not recorded
    speed_rate: Hertz = RATE  # at which the speed comes: held between, or on a clock of its own in MDF
    speed_step: float = 0.0  # of its converter, in its unit
    across: str | None = "lateral"  # "lateral", "yaw" or None
    along: bool = False  # whether longitudinal acceleration is recorded
    tilt: float = 0.0  # largest offset of these, a part of gravity [m/s2]
    unit: str = "m/s^2"  # of the accelerometers
    faults: int = 2  # of each kind in a drive, on average
    idle: float = 0.05  # largest amplitude of an idling engine [m/s2]
    swing: float = 0.15  # of the speed while cruising


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Way:
    """How the car goes, at the steps of the integration."""

    speed: RealArray
    along: RealArray
    across: RealArray


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class World:
    """A recorded drive, and what is true of it at every sample."""

    times: RealArray
    channels: Mapping[str, RealArray]
    way: Way  # at the samples
    faulty: NDArray[np.bool_]


def way_of(duration: Second, swing: float, rng: np.random.Generator) -> Way:
    """Return a drive of phases: standing, gathering speed, cruising, corners, braking."""
    speed, across = [0.0], [0.0]
    h = 0.05

    def go(seconds: float, to: float, side: float = 0.0) -> None:
        count = max(1, round(seconds / h))
        start = speed[-1]
        speed.extend((start + (to - start) * np.arange(1, count + 1) / count).tolist())
        across.extend((side * np.sqrt(np.maximum(np.sin(np.pi * np.arange(1, count + 1) / count), 0))).tolist())

    while h * len(speed) < duration + 5:
        cruise = float(rng.uniform(5, 33))
        go(cruise / rng.uniform(0.4, 3.5), cruise)
        for _ in range(rng.integers(1, 5)):
            seconds = float(rng.exponential(35) + 5)
            phase, count = rng.uniform(0, 2 * np.pi), round(seconds / h)
            swung = cruise * (1 + swing * np.sin(2 * np.pi * h * np.arange(count) / 30 + phase))
            go(2.0, float(swung[0]))
            speed.extend(swung.tolist())
            across.extend([0.0] * count)
            kind = rng.integers(0, 3)
            if kind == 0:
                side = float(rng.choice([-1, 1]) * rng.uniform(0.3, 5))
                go(float(rng.uniform(3, 15)), speed[-1], side)
            elif kind == 1:
                slower = max(3.5, speed[-1] * float(rng.uniform(0.4, 0.9)))
                go((speed[-1] - slower) / float(rng.uniform(0.3, 6)), slower)
                cruise = slower
        go(speed[-1] / float(rng.uniform(0.4, 6)), 0.0)
        go(float(rng.uniform(3, 40)), 0.0)
    coarse = h * np.arange(len(speed))
    fine = np.arange(round(duration / STEP) * 2 + 1) * STEP / 2
    smooth = gaussian_filter1d(np.array(speed), 0.15 / h)
    return Way(
        speed=np.interp(fine, coarse, smooth),
        along=np.interp(fine, coarse, np.gradient(smooth, h)),
        across=np.interp(fine, coarse, gaussian_filter1d(np.array(across), 0.15 / h)),
    )


def world(car: Suspension, habits: Habits, duration: Second, rng: np.random.Generator) -> World:
    """Return a drive of a quarter car, and what its logger has of it."""
    way = way_of(duration, habits.swing, rng)
    distance = np.cumsum(np.maximum(way.speed, 0)) * STEP / 2
    road = road_heights(distance, LEVELS[str(rng.choice(["A", "B", "C"]))], rng)
    inputs = np.zeros((4, len(distance)))
    inputs[0], inputs[1] = road, np.gradient(road, STEP / 2)
    body = list(car.masses).index("chassis")
    inputs[2 + body] = list(car.masses.values())[body] * (LEVERS[0] * way.along + LEVERS[1] * way.across)
    acceleration = integrated(car, inputs, np.zeros(4))[1]
    count = round(duration * RATE)
    keep = slice(None, 2 * round(1 / (RATE * STEP)) * count, 2 * round(1 / (RATE * STEP)))
    at = Way(speed=way.speed[keep], along=way.along[keep], across=way.across[keep])
    times = np.arange(count) / RATE
    channels = {}
    for i, name in enumerate(f"{c}_acceleration" for c in car.masses):
        row = _logged(acceleration[i], RATE)[:count]
        channels[name] = row + NOISE[name] * rng.standard_normal(count)
    stands = at.speed < 0.05
    tone = rng.uniform(0, habits.idle) * np.sin(2 * np.pi * rng.uniform(22, 30) * times + rng.uniform(0, 6))
    channels["chassis_acceleration"] = channels["chassis_acceleration"] + tone * stands
    faulty = spoil(channels, habits.faults, rng)
    return World(times=times, channels=channels, way=at, faulty=faulty)


def spoil(channels: dict[str, RealArray], most: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Let sensors fail, in place; return at which samples they do."""
    count = len(channels["tire_acceleration"])
    faulty = np.zeros(count, bool)
    for name, values in channels.items():
        values = channels[name] = values.copy()
        for kind in ("stuck", "missing", "sentinel", "knock"):
            for _ in range(rng.poisson(most / 2)):
                first = int(rng.integers(0, count - 10))
                size = round(RATE * float(np.exp(rng.uniform(np.log(0.02), np.log(8)))))
                where = slice(first, min(first + size, count))
                if kind == "stuck":
                    values[where] = values[first]
                elif kind == "missing":
                    values[where] = np.nan
                elif kind == "sentinel":
                    values[where] = -9999.0
                else:
                    # A knock on the sensor, which rings beyond its range.
                    t = np.arange(min(60, count - first)) / RATE
                    where = slice(first, first + len(t))
                    values[where] += 400 * np.exp(-12 * t) * np.cos(2 * np.pi * rng.uniform(8, 20) * t)
                # One sample can be filled.
                faulty[where] |= size > 2 or kind == "knock"
        rail = 100.0 if "tire" in name else 30.0
        over = np.abs(values) > rail
        marks = values == -9999.0
        faulty |= over & ~marks
        channels[name] = np.where(marks, values, np.clip(values, -rail, rail))
    return faulty


def written(path: Path, drive: World, habits: Habits, rng: np.random.Generator) -> Path:
    """Write a drive as its logger does; return the file."""
    factor = 1 / GRAVITY if habits.unit == "g" else 1.0
    columns = {name: np.where(v == -9999.0, v, factor * v) for name, v in drive.channels.items()}
    units = dict.fromkeys(columns, habits.unit)
    tilt = rng.uniform(-habits.tilt, habits.tilt, 2)
    noise = rng.standard_normal((2, len(drive.times)))
    if habits.across == "lateral":
        columns["lateral"] = factor * (drive.way.across + tilt[0] + 0.4 * noise[0])
        units["lateral"] = habits.unit
    elif habits.across == "yaw":
        rate = np.degrees(drive.way.across / np.maximum(drive.way.speed, 1.0))
        columns["yaw_rate"], units["yaw_rate"] = rate + 0.3 * noise[0], "deg/s"
    if habits.along:
        columns["longitudinal"] = factor * (drive.way.along + tilt[1] + 0.4 * noise[1])
        units["longitudinal"] = habits.unit
    slow = round(RATE / habits.speed_rate)
    speed = None
    if habits.speed is not None:
        per = {"km/h": 3.6, "m/s": 1.0, "mph": 1 / 0.44704, "kn": 3600 / 1852}[habits.speed]
        speed = per * drive.way.speed[::slow]
        speed = np.round(speed / habits.speed_step) * habits.speed_step if habits.speed_step else speed
    if path.suffix == ".mf4":
        _mdf(path, drive.times, columns, units, drive.times[::slow], speed, habits.speed or "")
    else:
        if speed is not None:
            columns["Speed"] = np.repeat(speed, slow)[: len(drive.times)]
            units["Speed"] = habits.speed or ""
        (_tdms if path.suffix == ".tdms" else _csv)(path, drive.times, columns, units)
    return path


def _csv(path: Path, times: RealArray, columns: Mapping[str, RealArray], units: Mapping[str, str]) -> None:
    head = ",".join(["time [s]", *(f"{name} [{units[name]}]" for name in columns)])
    np.savetxt(path, np.column_stack([times, *columns.values()]), delimiter=",", header=head, comments="", fmt="%.5g")


def _tdms(path: Path, times: RealArray, columns: Mapping[str, RealArray], units: Mapping[str, str]) -> None:
    from nptdms import ChannelObject, TdmsWriter

    timing = {"wf_increment": float(times[1] - times[0]), "wf_start_offset": 0.0}
    with TdmsWriter(str(path)) as writer:
        for name, values in columns.items():
            more = {"unit_string": units[name], **timing}
            writer.write_segment([ChannelObject("drive", name, values, properties=more)])


def _mdf(
    path: Path,
    times: RealArray,
    columns: Mapping[str, RealArray],
    units: Mapping[str, str],
    slow: RealArray,
    speed: RealArray | None,
    unit: str,
) -> None:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append(
            [Signal(samples=v.astype("f4"), timestamps=times, name=n, unit=units[n]) for n, v in columns.items()]
        )
        if speed is not None:
            file.append([Signal(samples=speed, timestamps=slow + 0.003, name="VehicleSpeed", unit=unit)])
        file.save(path, overwrite=True)
