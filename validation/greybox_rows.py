"""The cases of the report on estimates: cars, what moved them, and how well any estimator could do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from suspid import Suspension, full_car, half_car, quarter_car
from suspid.records import as_response
from suspid.units import RealArray, Second
from validation.greybox_bounds import given_bound, noisy_bound, time_bound, transfer_of
from validation.motion import LEVELS, STEP, Drive, driven, integrated, record_of

if TYPE_CHECKING:
    import control

QUARTER = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
SEATED = quarter_car(
    seat_mass=80, chassis_mass=320, tire_mass=40,
    seat_stiffness=20e3, chassis_stiffness=22e3, tire_stiffness=190e3,
    seat_damping=900, chassis_damping=1600, tire_damping=50,
)  # fmt: skip


def half(share: float) -> Suspension:
    """Return a half car whose axles differ so that its body modes and its wheel modes are near each other."""
    return half_car(
        chassis_mass=600, pitch_inertia=900 * (1 - share), front_tire_mass=40, rear_tire_mass=40,
        cg_to_front=1.25, cg_to_rear=1.25,
        front_stiffness=21e3, rear_stiffness=21e3 * (1 + share), front_tire_stiffness=190e3,
        rear_tire_stiffness=190e3 * (1 + share), front_damping=1350, rear_damping=1350 * (1 + share),
        front_tire_damping=60, rear_tire_damping=60,
    )  # fmt: skip


FULL = full_car(
    chassis_mass=1200, pitch_inertia=1800, roll_inertia=500, front_tire_mass=40, rear_tire_mass=42,
    cg_to_front=1.2, cg_to_rear=1.5, front_track=1.5, rear_track=1.48,
    front_stiffness=(20e3, 20.5e3), rear_stiffness=(18e3, 18.5e3), front_antiroll_stiffness=8e3,
    front_tire_stiffness=200e3, rear_tire_stiffness=205e3, front_damping=1500, rear_damping=1400,
    front_tire_damping=60, rear_tire_damping=60,
)  # fmt: skip
FORCES = 20  # drives over which the power of a force is averaged
NOISE = {"chassis_acceleration": 0.03, "tire_acceleration": 0.1}


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Row:
    """A case of the report: how to make a record, and what is asked of it."""

    name: str
    car: Suspension
    names: tuple[str, ...]  # parameters that are judged
    record: Callable[[np.random.Generator], control.TimeResponseData]
    bound: Callable[[], RealArray] | None  # least standard deviation of each
    given: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def nominal(self) -> Suspension:
        """The car with the parameters that are judged 30 % off, up and down in turn."""
        from validation.greybox_bounds import changed, value_of

        car = self.car
        for name, factor in zip(self.names, np.resize([0.7, 1.3], len(self.names)), strict=True):
            car = changed(car, name, value_of(self.car, name) * float(factor))
        return car


def parameters(car: Suspension, *, without: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of all k, then all c, that are positive."""
    names = [f"{s.name}.{q}" for q in ("stiffness", "damping") for s in car.struts if getattr(s, q)]
    return tuple(name for name in names if name not in without)


def decay_row(
    name: str, car: Suspension, start: Mapping[str, float], snr_db: float, *, fs: float, length: float
) -> Row:
    """Return a free decay seen at all displacements; dampers of tyres are held, and those that are not there."""
    held = tuple(f"{s.name}.damping" for s in car.struts if "tire" in s.name or not s.damping)
    n, keep = len(car.masses), round(1 / (fs * STEP))
    steps = round(length / STEP)
    labels = [f"{kind}_{c}" for kind in ("z", "v") for c in car.masses]
    first = np.array([start.get(label, 0.0) for label in labels])
    still = np.zeros((2 * len(car.roads) + n, 2 * steps + 1))

    @cache
    def clean() -> tuple[RealArray, RealArray]:
        y = integrated(car, still, first, keep=keep)[0]
        return y, np.sqrt(np.mean(y**2, axis=1) * 10 ** (-snr_db / 10))

    def record(rng: np.random.Generator) -> control.TimeResponseData:
        y, std = clean()
        return as_response(
            np.arange(y.shape[1]) / fs, y + std[:, None] * rng.standard_normal(y.shape), list(car.masses)
        )

    names = parameters(car, without=held)

    def bound() -> RealArray:
        units = np.array([integrated(car, still, unit, keep=keep)[0] for unit in np.eye(2 * n)])
        return time_bound(
            lambda one: integrated(one, still, first, keep=keep)[0], car, names, std=clean()[1], nuisance=units
        )

    return Row(name=name, car=car, names=names, record=record, bound=bound, fixed=held)


def rig_row(
    name: str,
    channel: str,
    shape: RealArray,
    *,
    std: Mapping[str, float],
    car: Suspension = QUARTER,
    sensor: tuple[float, Second] | None = None,
    input_noise: float = 0.0,
    options: Mapping[str, Any] | None = None,
) -> Row:
    """Return a quarter car on a known road, or pushed by a known force; ``shape`` stands at half steps.

    ``sensor`` is the gain and the delay of that of the wheel, which the bound does not know either. The input is
    measured with noise of a share of its own standard deviation.
    """
    keep, fs = 10, 200.0
    index = 0 if channel == "road" else 2 + list(car.masses).index(channel.removesuffix("_force"))
    inputs = np.zeros((4, len(shape)))
    inputs[index] = shape
    if channel == "road":
        inputs[1] = np.gradient(shape, STEP / 2)
    names = parameters(car)
    gain, late = (1.0, 0.0) if sensor is None else sensor

    def outputs(
        one: Suspension, *, high: float = gain, delay: Second = late, start: RealArray | None = None
    ) -> RealArray:
        pushed = inputs if start is None else 0 * inputs
        body, wheel = integrated(one, pushed, np.zeros(4) if start is None else start, keep=1)[1]
        wheel = np.concatenate([np.full(round(delay / STEP), wheel[0]), high * wheel])[: len(body)]
        return np.stack([body, wheel])[:, ::keep]

    spread = np.array([std[f"{c}_acceleration"] for c in car.masses])
    noise_of_input = input_noise * float(np.std(shape))

    @cache
    def clean() -> RealArray:
        return outputs(car)

    def record(rng: np.random.Generator) -> control.TimeResponseData:
        y = clean() + spread[:, None] * rng.standard_normal(clean().shape)
        times = np.arange(y.shape[1]) / fs
        known = shape[:: 2 * keep]
        if noise_of_input:
            known = known + noise_of_input * rng.standard_normal(len(known))
        return as_response(times, y, [f"{c}_acceleration" for c in car.masses], inputs={channel: known})

    def bound() -> RealArray:
        unknown = [outputs(car, start=unit) for unit in np.eye(4)]
        if sensor is not None:
            unknown += [outputs(car, high=gain + 1) - clean(), outputs(car, delay=late + STEP) - clean()]
        nuisance = np.array(unknown)
        if noise_of_input:
            return noisy_bound(
                outputs, car, names, std=spread, nuisance=nuisance, rate=fs,
                input_std=noise_of_input, input_of=index,
            )  # fmt: skip
        return time_bound(outputs, car, names, std=spread, nuisance=nuisance)

    return Row(name=name, car=car, names=names, record=record, bound=bound, given=(channel,), options=options or {})


def given_row(name: str, drive: Drive, *, car: Suspension = QUARTER, options: Mapping[str, Any] | None = None) -> Row:
    """Return a drive of which the motion of the wheels and of the body is measured."""
    coordinates = list(car.masses)
    wheels = [c for c in coordinates if c not in ("chassis", "heave", "pitch", "roll")]
    body = [c for c in coordinates if c not in wheels]
    channels = tuple(f"{c}_acceleration" for c in (*body, *wheels))
    names = parameters(
        car, without=[f"{s.name}.{q}" for s in car.struts for q in ("stiffness", "damping") if "tire" in s.name]
    )
    stds = {n: drive.noise.get(n, 0.03 if n.removesuffix("_acceleration") in body else 0.1) for n in channels}
    drive = replace(drive, noise=stds)

    def record(rng: np.random.Generator) -> control.TimeResponseData:
        clean, times = driven(car, drive, rng)
        return record_of(clean, times, channels, drive, rng)

    def moved(road: str, seed: int) -> tuple[RealArray, RealArray]:
        clean, _ = driven(car, replace(drive, road=road, delay={}), np.random.default_rng(seed))
        parts = [np.array([clean[f"{c}_acceleration"] for c in part]) for part in (body, wheels)]
        return parts[0], parts[1]

    def bound() -> RealArray:
        return given_bound(
            transfer_of(
                np.eye(len(body)).tolist(), [coordinates.index(c) for c in body], [coordinates.index(c) for c in wheels]
            ),
            car,
            names,
            wheels=moved(drive.road, 0)[1],
            rate=drive.rate,
            std_body=np.array([stds[f"{c}_acceleration"] for c in body]),
            std_wheels=np.array([stds[f"{c}_acceleration"] for c in wheels]),
            unknown=[kind for kind in KNOWN if kind not in (options or {})],
            pushed=[moved("level", seed) for seed in range(FORCES if drive.body_force or drive.engine else 0)],
        )

    return Row(
        name=name,
        car=car,
        names=names,
        record=record,
        bound=bound,
        given=tuple(wheels),
        fixed=tuple(f"{s.name}.damping" for s in car.struts if not s.damping),
        options=options or {},
    )


def swept(length: float = 20.0) -> RealArray:
    """Return a sweep of 3 mm from 0.5 to 20 Hz, at half steps."""
    t = STEP / 2 * np.arange(round(length / STEP) * 2 + 1)
    return np.asarray(0.003 * np.sin(2 * np.pi * (0.5 * t + 19.5 * t**2 / (2 * length))))


def smooth_road(length: float = 20.0) -> RealArray:
    """Return a random road of class B at 15 m/s without anything above 40 Hz, at half steps."""
    t = STEP / 2 * np.arange(round(length / STEP) * 2 + 1)
    f = np.arange(0.2, 40, 0.05)
    rng = np.random.default_rng(77)
    amplitude = np.sqrt(2 * LEVELS["B"] * 0.1**2 * 15 * f**-2.0 * 0.05)
    return np.asarray(
        sum(a * np.sin(2 * np.pi * (one * t + p)) for a, one, p in zip(amplitude, f, rng.random(len(f)), strict=True))
    )


KNOCK = {"z_heave": 0.02, "v_pitch": 0.2, "v_front": 1.0, "v_rear": -0.5}
SEAT_KNOCK = {"v_tire": 1.0}
FULL_KNOCK = {
    "z_heave": 0.02, "v_pitch": 0.2, "v_roll": 0.4,
    "v_front_left": 1.0, "v_front_right": -0.4, "v_rear_left": 0.3, "v_rear_right": -0.8,
}  # fmt: skip
KNOWN: Mapping[str, Any] = {"gains": (), "delays": (), "mounts": ()}


WHEEL_SENSOR: Mapping[str, Any] = {"gains": ("tire_acceleration",), "delays": ("tire_acceleration",)}


def only(free: str) -> Mapping[str, Any]:
    """Return options that leave one of gains, delays and mounts unknown."""
    return {kind: () for kind in KNOWN if kind != free}


MOUNTED = QUARTER.with_parameters(mount_stiffness={"chassis": 1e6})
SOFT = QUARTER.with_parameters(mount_stiffness={"chassis": 4e5})


def free_decays() -> list[Row]:
    """Return the cases without inputs."""
    return [
        decay_row("quarter car, 20 dB", QUARTER, SEAT_KNOCK, 20, fs=200, length=5),
        decay_row("quarter car with a seat, 20 dB", SEATED, SEAT_KNOCK, 20, fs=200, length=5),
        *(
            decay_row(f"half car, modes {share:.0%} apart, {snr} dB", half(share), KNOCK, snr, fs=200, length=5)
            for share in (0.1, 0.02)
            for snr in (20, 40)
        ),
        decay_row("full car, 40 dB", FULL, FULL_KNOCK, 40, fs=200, length=5),
    ]


def rows() -> dict[str, list[Row]]:
    """Return all cases by section of the report."""
    return {
        "Free decays": free_decays(),
        "Rigs and actuators": [
            rig_row("swept road, 20 s", "road", swept(), std=NOISE),
            rig_row("random road, 20 s", "road", smooth_road(), std=NOISE),
            rig_row(
                "force on the body, 20 s", "chassis_force", 1e5 * swept(), std={**NOISE, "tire_acceleration": 0.03}
            ),
            *(
                rig_row(
                    f"{what}, wheel sensor 2 % high, 2 ms late{told}",
                    "road",
                    shape,
                    std=NOISE,
                    sensor=(1.02, 0.002),
                    options=WHEEL_SENSOR if told else {},
                )
                for what, shape in (("swept road", swept()), ("random road", smooth_road()))
                for told in (", told", "")
            ),
            *(
                rig_row(f"{what}, known to {share:.0%}", channel, shape, std=std, input_noise=share)
                for what, channel, shape, std in (
                    ("swept road", "road", swept(), NOISE),
                    ("random road", "road", smooth_road(), NOISE),
                    ("force on the body", "chassis_force", 1e5 * swept(), {**NOISE, "tire_acceleration": 0.03}),
                )
                for share in (0.01, 0.02, 0.05)
            ),
            rig_row(
                "swept road, known to 2 %, wheel sensor 2 % high, 2 ms late",
                "road",
                swept(),
                std=NOISE,
                sensor=(1.02, 0.002),
                input_noise=0.02,
            ),
        ],
        "Everyday driving, wheels given": [
            given_row("class B, 60 s, gain, delay, mount known", Drive(), options=KNOWN),
            *(given_row(f"class B, {t:g} s", Drive(duration=t)) for t in (10, 60, 300, 1200)),
            *(given_row(f"class {road}, 60 s", Drive(road=road)) for road in "ACD"),
            given_row("class B, speed ±40 %", Drive(spread=0.4)),
            given_row("class A with six bumps", Drive(road="A", bumps=6)),
            given_row("force on the body 0.1 m/s2", Drive(body_force=0.1)),
            given_row("engine 0.1 m/s2", Drive(engine=0.1)),
            given_row(
                "sensors of 0.1 and 0.5 m/s2",
                Drive(noise={"chassis_acceleration": 0.1, "tire_acceleration": 0.5}),
            ),
            given_row("wheel sensor 2 % high", Drive(gain={"tire_acceleration": 1.02})),
            given_row("wheel sensor 2 ms late", Drive(delay={"tire_acceleration": 0.002})),
            given_row("mount 1e6 N/m", Drive(), car=MOUNTED),
            given_row("mount 4e5 N/m", Drive(), car=SOFT),
            *(
                given_row(f"{name}, {free} alone unknown", drive, car=car, options=only(f"{free}s"))
                for name, free, drive, car in (
                    ("wheel sensor 2 % high", "gain", Drive(gain={"tire_acceleration": 1.02}), QUARTER),
                    ("wheel sensor 2 ms late", "delay", Drive(delay={"tire_acceleration": 0.002}), QUARTER),
                    ("mount 1e6 N/m", "mount", Drive(), MOUNTED),
                )
            ),
            given_row("half car, 60 s", Drive(), car=half(0.1)),
            given_row("half car, 60 s, gain, delay, mount known", Drive(), car=half(0.1), options=KNOWN),
            given_row("full car, 60 s at 100 Hz", Drive(rate=100.0), car=FULL),
            given_row("full car, 60 s at 100 Hz, gain, delay, mount known", Drive(rate=100.0), car=FULL, options=KNOWN),
        ],
    }
