"""Results do not hang on rounding: a record changed in its last digits has the same modes, verdict and decays."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from suspid import (
    Decays,
    Suspension,
    add_noise,
    analyse,
    clean,
    find_decays,
    free_decay,
    full_car,
    identify,
    read_recording,
    statespace,
)
from suspid.identification import identify_linear, resolution
from suspid.records import as_response
from suspid.signals import as_signal
from validation import cars, decays, rigs
from validation.speed import decay

if TYPE_CHECKING:
    import control

EXAMPLE = Path(__file__).parents[1] / "examples" / "quarter_car.csv"
# Rounding of a few operations in double precision, over each sample.
CHANGE = 1e-14


def changed(record: control.TimeResponseData, seed: int) -> control.TimeResponseData:
    """Return a record whose samples are changed in their last digits."""
    signal = as_signal(record)
    values = signal.values * (1 + CHANGE * np.random.default_rng(seed).standard_normal(signal.values.shape))
    return as_response(signal.timepts, values, signal.channels)


def released(
    car: Suspension, snr_db: float | None, *, duration: float = 6.0, channels: slice = slice(None), **start: float
) -> control.TimeResponseData:
    """Return a decay at 500 Hz from given velocities, with noise of its own seed."""
    system = statespace(car)
    speeds = [name for name in system.state_labels if name.startswith("v_")]
    state = start or dict(zip(speeds, (1.0, -0.4, 0.7, 0.2, -0.9, 0.5, 0.3), strict=False))
    response = free_decay(system, np.arange(int(500 * duration)) / 500, initial_state=state)
    if snr_db is not None:
        response = add_noise(response, snr_db=snr_db, rng=np.random.default_rng(int(snr_db)))
    signal = as_signal(response)
    return as_response(signal.timepts, signal.values[channels], signal.channels[channels])


def random_car(seed: int) -> control.TimeResponseData:
    return released(cars.random_car(np.random.default_rng(seed)), 30.0 + 5 * seed, v_tire=1.0)


def heavy_full_car(seed: int) -> control.TimeResponseData:
    """Return seven heavily damped modes in half a second to four: nearly equal poles, and some on the real axis."""
    rng = np.random.default_rng(seed)
    mass, front, rear = rng.uniform(1000, 1900), *rng.uniform(15e3, 35e3, 2)
    zeta = rng.uniform(0.2, 0.5)
    car = full_car(
        chassis_mass=mass,
        pitch_inertia=rng.uniform(1500, 3000),
        roll_inertia=rng.uniform(350, 700),
        front_tire_mass=rng.uniform(30, 55),
        rear_tire_mass=rng.uniform(30, 55),
        cg_to_front=rng.uniform(1, 1.5),
        cg_to_rear=rng.uniform(1.1, 1.7),
        front_track=1.5,
        rear_track=1.5,
        front_stiffness=front,
        rear_stiffness=rear,
        front_antiroll_stiffness=0,
        front_tire_stiffness=rng.uniform(15e4, 25e4),
        rear_tire_stiffness=rng.uniform(15e4, 25e4),
        front_damping=zeta * np.sqrt(front * mass),
        rear_damping=zeta * np.sqrt(rear * mass),
    )
    speeds = [name for name in statespace(car).state_labels if name.startswith("v_")]
    start = dict(zip(speeds, rng.standard_normal(7), strict=True))
    return released(car, float(rng.choice([20, 40, 60, 80])), duration=float(rng.uniform(0.5, 4)), **start)


def rig(kind: str, masses: int, *, held: bool = False) -> control.TimeResponseData:
    """Return a release as an encoder sees it; from a sample after it on, unless the rest before is ``held``."""
    found = rigs.release(kind, masses, seed=3)
    step = (found.stamps[-1] - found.stamps[0]) / (len(found.stamps) - 1)
    position = found.values[:, 0 if held else int(np.searchsorted(found.stamps, found.start)) + 1 :]
    return as_response(np.arange(position.shape[1]) * step, position, [f"x{k}" for k in range(masses)])


def long() -> control.TimeResponseData:
    times, values = decay(100_000, 500.0)
    return as_response(times, values, ("seat", "chassis", "tire"))


QUICK: dict[str, Callable[[], control.TimeResponseData]] = {
    "example": lambda: clean(read_recording(EXAMPLE)).record,
    "one channel": lambda: released(cars.PAPER, 20.0, duration=10.0, channels=slice(1), v_tire=1.0),
    "exact": lambda: released(cars.PAPER, None, duration=10.0, v_tire=1.0),
    "hatchback, 60 dB": lambda: released(cars.HATCHBACK, 60.0, v_tire=1.0),
    "saloon, 20 dB": lambda: released(cars.SALOON, 20.0, v_tire=1.0),
    "saloon, 60 dB": lambda: released(cars.SALOON, 60.0, v_tire=1.0),
    "van, 40 dB": lambda: released(cars.VAN, 40.0, v_tire=1.0),
    "half car, 20 dB": lambda: released(cars.TWO_AXLES, 20.0, v_front=1.0, v_rear=-0.5),
    "half car, 60 dB": lambda: released(cars.TWO_AXLES, 60.0, v_front=1.0, v_rear=-0.5),
    "full car, 20 dB": lambda: released(cars.FOUR_WHEELS, 20.0),
    "full car, 40 dB": lambda: released(cars.FOUR_WHEELS, 40.0),
    "random car 1": lambda: random_car(1),
    "random car 3": lambda: random_car(3),
    "random car 5": lambda: random_car(5),
    **{f"heavy full car {seed}": partial(heavy_full_car, seed) for seed in (3, 5, 22, 31, 44, 87)},
    "close modes": lambda: released(cars.close_pair(0.02), 30.0, v_left=1.0),
    "friction": lambda: rig("friction", 1),
    "bilinear": lambda: rig("bilinear", 1),
    "cubic": lambda: rig("cubic", 1),
}
SLOW: dict[str, Callable[[], control.TimeResponseData]] = {
    "full car, 60 dB": lambda: released(cars.FOUR_WHEELS, 60.0),
    "cubic, two masses": lambda: rig("cubic", 2),
    "bilinear, two masses": lambda: rig("bilinear", 2),
    "long": long,
    "random car 0": lambda: random_car(0),
    "random car 2": lambda: random_car(2),
    "random car 4": lambda: random_car(4),
    **{f"heavy full car {seed}": partial(heavy_full_car, seed) for seed in range(120, 160)},
}


@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)])
def test_modes(name: str) -> None:
    record = (QUICK | SLOW)[name]()
    before, after = identify(record), identify(changed(record, 1))
    assert before.modes.wn_std is not None
    assert before.modes.zeta_std is not None
    # What the change itself says of a pole, in its standard deviations: its size over that of the noise.
    values = as_signal(record).values
    noise = np.maximum(before.noise_std, resolution(values))
    bound = 1e-6 + 3 * CHANGE * np.sqrt(np.sum(values**2 / noise[:, None] ** 2))
    np.testing.assert_array_less(np.abs(after.modes.wn - before.modes.wn) / before.modes.wn_std, bound)
    np.testing.assert_array_less(np.abs(after.modes.zeta - before.modes.zeta) / before.modes.zeta_std, bound)
    assert after.modes.wn_std == pytest.approx(before.modes.wn_std, rel=1e-3)
    assert str(after.verdict) == str(before.verdict)
    assert after.forces == before.forces


def bumps(**case: object) -> Callable[[], control.TimeResponseData]:
    return lambda: decays.recording(decays.Case(**case), seed=len(case))[1]  # type: ignore[arg-type]


def hour() -> control.TimeResponseData:
    """Return an hour at 200 Hz in which the saloon is released sixty times."""
    rate, count = 200.0, 720_000
    once = np.asarray(free_decay(cars.SALOON, np.arange(1600) / rate, initial_state={"v_tire": 1.0}).y)
    values = 0.01 * np.std(once, axis=1)[:, None] * np.random.default_rng(0).standard_normal((len(once), count))
    for first in range(4000, 718_000, 12_000):
        values[:, first : first + 1600] += once
    return as_response(np.arange(count) / rate, values, [f"c{k}" for k in range(len(once))])


QUICK_RECORDINGS: dict[str, Callable[[], control.TimeResponseData]] = {
    "example": QUICK["example"],
    "friction, held": lambda: rig("friction", 1, held=True),
}
SLOW_RECORDINGS: dict[str, Callable[[], control.TimeResponseData]] = {
    "friction, two masses": lambda: rig("friction", 2, held=True),
    "bilinear, held": lambda: rig("bilinear", 1, held=True),
    "cubic, held": lambda: rig("cubic", 1, held=True),
    "cubic, two masses": lambda: rig("cubic", 2, held=True),
    "bumps at rest": bumps(quantity="displacement", rolling=0.0, snr_db=40.0),
    "many bumps": bumps(quantity="acceleration", rolling=0.0, snr_db=50.0, bumps=8),
    "an hour": hour,
}


@pytest.mark.parametrize(
    "name",
    [
        *(name for name in QUICK_RECORDINGS if name != "friction, held"),
        *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW_RECORDINGS),
    ],
)
def test_decays(name: str) -> None:
    record = (QUICK_RECORDINGS | SLOW_RECORDINGS)[name]()
    before, after = find_decays(record), find_decays(changed(record, 1))

    def told(decays: Decays) -> list[tuple[object, ...]]:
        return [(d.start, d.stop, d.kind, [doubt.code for doubt in d.doubts]) for d in decays]

    assert told(after) == told(before)
    for one, other in zip(before, after, strict=True):
        # Their own fit is rough: to a hundredth of a standard deviation, of records to 1e-3 or better.
        np.testing.assert_allclose(other.wn, one.wn, rtol=1e-5)


@pytest.mark.parametrize("seed", [1, 3])
def test_where_rounding_moves_the_start_the_intervals_hold_both(seed: int) -> None:
    """Linear fits of friction have several optima, and the start is one of two, ten milliseconds apart."""
    record = QUICK_RECORDINGS["friction, held"]()
    one, other = (analyse(each).modes for each in (record, changed(record, seed)))
    assert one.wn_std is not None
    assert other.wn_std is not None
    assert one.zeta_std is not None
    assert other.zeta_std is not None
    assert np.all(np.abs(one.wn - other.wn) < 1.96 * np.hypot(one.wn_std, other.wn_std))
    assert np.all(np.abs(one.zeta - other.zeta) < 1.96 * np.hypot(one.zeta_std, other.zeta_std))


def test_how_samples_stand_in_memory_does_not_matter() -> None:
    """Sums of samples in columns are taken in another order than sums of those in rows."""
    record = rig("friction", 2)
    signal = as_signal(record)
    rows, columns = (
        identify_linear(as_response(signal.timepts, np.array(signal.values, order=order), signal.channels)).modes.poles
        for order in ("C", "F")
    )
    assert rows.tolist() == columns.tolist()
