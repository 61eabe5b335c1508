"""Two axles on one track: tires and wheel masses from the road that both wheels meet."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from click.testing import CliRunner

from suspid import (
    Estimate,
    InputError,
    Level,
    Settings,
    estimate,
    estimate_many,
    full_car,
    half_car,
    statespace,
    write_car,
    write_record,
)
from suspid.analysis import CarSettings
from suspid.cli import main
from suspid.greybox.axle_data import Lag, axle_record, behind_of, cross_power
from suspid.greybox.axle_model import LATE_STD, AxleModel, axle_model
from suspid.greybox.measured_causes import first_levels
from suspid.greybox.road_maps import MapProblem
from suspid.greybox.road_model import road_model
from suspid.greybox.trials import trials_of
from suspid.greybox.wheel_power import MOMENTS, tracks_of
from suspid.greybox.wheel_problem import wheel_problem
from suspid.greybox.whole_car import _part, _parts
from suspid.reconstruction import unknowns_of
from suspid.records import as_response
from suspid.units import ComplexArray, RealArray
from suspid.words import EstimateCheck
from validation.motion import RADIUS, Drive, driven, record_of

HALF = half_car(
    chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=45, cg_to_front=1.1, cg_to_rear=1.4,
    front_stiffness=21e3, rear_stiffness=24e3, front_tire_stiffness=190e3, rear_tire_stiffness=200e3,
    front_damping=1350, rear_damping=1100, front_tire_damping=60, rear_tire_damping=60,
)  # fmt: skip
SIDES = {"road_front": "road_left", "road_rear": "road_right"}
NOMINAL = HALF.with_parameters(
    stiffness={"front": 17e3, "rear": 28e3, "front_tire": 225e3, "rear_tire": 170e3}, masses={"front": 33, "rear": 52}
)
# `validation.motion` gives left and right roads heights of their own.
APART = replace(
    HALF,
    struts=[replace(s, arms={SIDES.get(name, name): arm for name, arm in s.arms.items()}) for s in HALF.struts],
)
CHANNELS = ("heave_acceleration", "pitch_acceleration", "front_acceleration", "rear_acceleration")
NOISE = {"heave_acceleration": 0.02, "pitch_acceleration": 0.02, "front_acceleration": 0.1, "rear_acceleration": 0.1}
LAG = 2.7
BEHIND = {"road_rear": ("road_front", LAG)}
FOUND = ("front_tire.stiffness", "rear_tire.stiffness", "front.mass", "rear.mass")
TRUE = np.array([190e3, 200e3, 40.0, 45.0])
BAND = (0.5, 27.0)


@cache
def drive(seed: int = 3, *, noise: bool = True) -> tuple[control.TimeResponseData, RealArray]:
    asked = Drive(duration=120.0, wheelbase=LAG, noise=NOISE if noise else {})
    rng = np.random.default_rng(seed)
    clean, times = driven(HALF, asked, rng)
    return record_of(clean, times, CHANNELS, asked, rng), clean["speed"]


def asked_of(record: control.TimeResponseData, speed: RealArray, **options: Any) -> Estimate:
    told: Mapping[str, Any] = {"given": ("wheels",), "free_masses": ("front", "rear"), "road": "iso8608"}
    return estimate(record, NOMINAL, speed=speed, **{**told, **options})


@cache
def found(behind: bool) -> Estimate:
    return asked_of(*drive(), behind=BEHIND if behind else None)


def stds(one: Estimate) -> RealArray:
    at = [one.parameters.index(name) for name in FOUND]
    return np.asarray(np.sqrt(np.diag(one.covariance))[at])


def values(one: Estimate) -> RealArray:
    return np.asarray(one.values[[one.parameters.index(name) for name in FOUND]])


@cache
def model() -> tuple[AxleModel, RealArray, RealArray]:
    """Return the model of a drive without noise, and all unknowns at the truth."""
    record, speed = drive(noise=False)
    trials = trials_of(record, HALF, ("wheels",))
    unknowns = unknowns_of(HALF, rate=10.0, free_masses=("front", "rear"))
    first, second = _parts(unknowns, trials, ("front_tire", "rear_tire"))
    suspension, tires = _part(unknowns, first), _part(unknowns, second)
    problem = wheel_problem(
        HALF, trials, suspension, gains=None, delays=None, mounts=None, band=None, stretch=None
    )  # fmt: skip
    extras = problem.extras
    relaxations = len(extras.mounts)
    z = np.concatenate([suspension.nominal, np.where(np.arange(len(extras.names)) < relaxations, 0.0, extras.start)])
    levels = first_levels(problem.sources[0])
    pair = behind_of(BEHIND, HALF)[0]
    maps = MapProblem(problem=problem, number=0, tires=tires, roads=(0, 1))
    own = axle_record(problem, z, 0, levels, trials[0], speed=speed, band=BAND, slowest=5.0)
    track = tracks_of(problem, z, 0, levels, trials, speeds=(speed,), band=BAND)[0]
    moments = ((np.arange(MOMENTS) + 0.5) / MOMENTS * track.samples).astype(int)
    speeds = np.array([speed[a : a + track.samples] for a in own.starts])[:, moments]
    shaped = replace(track, power=np.zeros((len(speeds), len(track.hertz))), speeds=speeds)
    return axle_model(pair, maps, z, levels, [own], road_model(shaped, radius=RADIUS)), z, tires.nominal


class TestMaps:
    def test_the_car_turned_round_gives_its_roads(self) -> None:
        """Roads through the transfer of the state space, and back through the map, are the roads."""
        made, z, x = model()
        system = statespace(HALF, outputs=list(CHANNELS))
        s = np.asarray(2j * np.pi * np.array([0.7, 1.4, 5.0, 11.0, 24.0]), complex)
        shown = np.array([system(one) for one in s])
        at = [[system.input_labels.index(road + rate) for road in HALF.roads] for rate in ("", "_rate")]
        shown = shown[:, :, at[0]] + s[:, None, None] * shown[:, :, at[1]]
        maps = made.maps.maps(s, z, x)
        wheels, bodies = shown[:, 2:], shown[:, :2]
        # Rounding of two inversions.
        np.testing.assert_allclose(maps.roads @ wheels, np.broadcast_to(np.eye(2), (5, 2, 2)), atol=1e-8)
        np.testing.assert_allclose(maps.outputs @ wheels, bodies, rtol=1e-8)

    def test_both_wheels_meet_one_road(self) -> None:
        """Without noise the slopes are one, whatever the speed does; with a wrong tire or place they are two."""
        made, z, x = model()
        record = made.records[0]
        inside = slice(record.starts[0], record.starts[-1])

        def apart(x: RealArray, lag: float, late: float = 0.0) -> float:
            # From 0.5 Hz on: what the ends of a record leave lies below.
            front, rear = record.slopes(made.maps, z, x, Lag(lag, late))[:, inside]
            power = cross_power(
                [np.stack([front - rear, rear])], [range(0, len(rear) - 1600, 1600)], 1600, np.arange(8, 200)
            )
            return float(np.sqrt(np.mean(power[..., 0, 0].real / power[..., 1, 1].real)))

        stiffer = x * np.where(np.arange(len(x)) == 0, 1.02, 1.0)
        exact = apart(x, LAG)
        # The integrator's derivative of the road, and splines, are off by 1e-3 at the highest lines.
        assert exact < 3e-3
        assert apart(stiffer, LAG) > 5 * exact
        assert apart(x, 1.01 * LAG) > 5 * exact
        assert apart(x, LAG, 0.001) > 5 * exact


class TestDerivatives:
    def test_by_own_and_lag(self) -> None:
        made, z, x = model()
        here = made.maps.maps(made.s, z, x)
        own = made.prior.mean + 0.1
        levels = np.linspace(-9, -8, made.stretches)
        expected = made.expected(here, own, levels, Lag(LAG))
        step = 1e-5
        for i, column in enumerate(made.by_own(here, own, expected)):
            one, other = (made.expected(here, own + h * (np.arange(len(own)) == i), levels, Lag(LAG)).whole
                          for h in (step, -step))  # fmt: skip
            scale = np.abs(column).max()
            # Growth and radius of orders are differences of one side, to 1e-4 of rotations on straight lines.
            loose = 0.05 if i >= len(own) - 2 else 1e-5
            np.testing.assert_allclose(column, (one - other) / (2 * step), atol=loose * scale)

    def test_by_lag(self) -> None:
        """Behind a longer lag the front's slope is later by the difference: what is expected moves the other way."""
        made, z, x = model()
        expected = made.expected(made.maps.maps(made.s, z, x), made.prior.mean + 0.1, np.full(made.stretches, -8.0),
                                 Lag(LAG))  # fmt: skip
        speed, step = made.road.track.log_speed, 1e-5

        def seen(lag: Lag) -> ComplexArray:
            late = np.ones((made.stretches, len(made.s), 2), complex)
            late[..., 0] = np.exp(-made.s * (lag.delays(speed) - LAG / np.exp(speed))[:, None])
            return late[..., :, None] * (expected.road + expected.orders) * late.conj()[..., None, :]

        ends = [(Lag(LAG * (1 - step)), Lag(LAG * (1 + step)))]
        ends += [(Lag(LAG, -step * LATE_STD), Lag(LAG, step * LATE_STD))]
        for column, (shorter, longer) in zip(made.by_lag(expected, Lag(LAG)), ends, strict=True):
            less, more = seen(shorter), seen(longer)
            np.testing.assert_allclose(column, (less - more) / (2 * step), atol=1e-6 * np.abs(column).max())

    def test_by_car(self) -> None:
        """The frame of a changed car, with the road unchanged in it, seen from the first car."""
        made, z, x = model()
        here = made.maps.maps(made.s, z, x)
        own, levels = made.prior.mean, np.full(made.stretches, -8.0)
        expected = made.expected(here, own, levels, Lag(LAG))
        direction = np.where(np.arange(len(x)) == 1, x, 0.0)
        column = made.by_car(here, expected, z, x, [(np.zeros(len(z)), direction)])[0]
        step = 1e-4
        ends = []
        for h in (step, -step):
            there = made.maps.maps(made.s, z, x + h * direction)
            seen = here.roads @ np.linalg.inv(there.roads)
            seen = expected.late[..., :, None] * seen * expected.late.conj()[..., None, :]
            ends.append(seen @ expected.road @ seen.conj().swapaxes(2, 3))
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / (2 * step), atol=1e-5 * np.abs(column).max())


class TestEstimate:
    def test_holds_and_is_much_narrower(self) -> None:
        one, both = found(False), found(True)
        assert np.all(np.abs(values(both) - TRUE) < 3 * stds(both))
        # Bounds: 5 % in five minutes from one axle, 0.7 % from two.
        assert np.all(stds(both) < stds(one) / 2.5)

    def test_smoothed_speed(self) -> None:
        """Means over 3 s take 1.6 % of swings of 30 s: to the lag they are what a longer way and a delay are."""
        record, speed = drive()
        smooth = np.convolve(np.pad(speed, 300, mode="edge"), np.ones(601) / 601, mode="valid")
        both = asked_of(record, smooth, behind=BEHIND)
        assert np.all(np.abs(values(both) - TRUE) < 3 * stds(both))
        assert np.all(np.abs(values(both) - values(found(True))) < stds(both))
        # Way and time are wrong alone; at the usual speed they make the way.
        self.says_the_way(both)

    def test_says_what_decided(self) -> None:
        self.says_the_way(found(True))

    def says_the_way(self, one: Estimate) -> None:
        checks = [check.remark for check in one.verdict.checks if check.remark.code is EstimateCheck.BEHIND]
        assert len(checks) == 1
        lag, std = (float(checks[0].numbers[name]) for name in ("lag", "std"))  # type: ignore[arg-type]
        assert abs(lag - LAG) < 4 * std < 0.01 * LAG
        assert float(checks[0].numbers["coherence"]) > 0.99  # type: ignore[arg-type]

    def test_suspension_stays(self) -> None:
        """What the first step found is not changed."""
        for name in ("front.stiffness", "rear.damping"):
            at = found(True).parameters.index(name)
            assert found(True).values[at] == found(False).values[at]

    def test_covariance_is_one(self) -> None:
        """Of all parameters together: no combination has less than no variance."""
        scale = np.sqrt(np.diag(found(True).covariance))
        assert np.min(np.linalg.eigvalsh(found(True).covariance / np.outer(scale, scale))) > -1e-9

    def test_two_roads_are_told(self) -> None:
        """Where each wheel has a road of its own, each axle says what it says by itself."""
        asked = Drive(duration=120.0, noise=NOISE)
        rng = np.random.default_rng(8)
        clean, times = driven(APART, asked, rng)
        record = record_of(clean, times, CHANNELS, asked, rng)
        behind = {"road_right": ("road_left", LAG)}
        told = {"given": ("wheels",), "free_masses": ("front", "rear"), "road": "iso8608", "speed": clean["speed"]}
        one, two = (estimate(record, APART, **told, behind=b) for b in (None, behind))  # type: ignore[arg-type]
        np.testing.assert_array_equal(one.values, two.values)
        np.testing.assert_array_equal(one.covariance, two.covariance)
        checks = [check for check in two.verdict.checks if check.remark.code is EstimateCheck.NOT_BEHIND]
        assert [check.level for check in checks] == [Level.CARE]

    def test_few_stretches_are_told(self) -> None:
        record, speed = drive()
        short = as_response(np.asarray(record.time)[:6000], np.asarray(record.outputs)[:, :6000], CHANNELS)
        one = asked_of(short, speed[:6000], behind=BEHIND)
        checks = [check for check in one.verdict.checks if check.remark.code is EstimateCheck.FEW_BEHIND]
        assert [check.level for check in checks] == [Level.CARE]


FULL = full_car(
    chassis_mass=1200, pitch_inertia=1800, roll_inertia=500, front_tire_mass=40, rear_tire_mass=45, cg_to_front=1.2,
    cg_to_rear=1.5, front_track=1.5, rear_track=1.48, front_stiffness=20e3, rear_stiffness=18e3,
    front_antiroll_stiffness=8e3, rear_antiroll_stiffness=5e3, front_tire_stiffness=200e3,
    rear_tire_stiffness=(210e3, 190e3), front_damping=1500, rear_damping=1400, front_tire_damping=60,
    rear_tire_damping=60,
)  # fmt: skip
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
SENSORS = ("heave_acceleration", "pitch_acceleration", "roll_acceleration", *(f"{w}_acceleration" for w in WHEELS))
OF_FOUR = {f"road_rear_{side}": (f"road_front_{side}", LAG) for side in ("left", "right")}


@cache
def of_four(behind: bool) -> tuple[RealArray, RealArray, Estimate]:
    """Return errors and standard deviations of tires and wheel masses, as shares of the truth."""
    asked = Drive(duration=60.0, rate=100.0, wheelbase=LAG, noise=dict.fromkeys(SENSORS, 0.05))
    rng = np.random.default_rng(31)
    clean, times = driven(FULL, asked, rng)
    record = record_of(clean, times, SENSORS, asked, rng)
    stiffness = {f"{w}_tire": 200e3 for w in WHEELS}
    masses = {"front_left": 35, "front_right": 46, "rear_left": 50, "rear_right": 40}
    one = estimate(
        record, FULL.with_parameters(stiffness=stiffness, masses=masses), given=("wheels",), free_masses=WHEELS,
        road="iso8608", speed=clean["speed"], behind=OF_FOUR if behind else None, mounts=(),
    )  # fmt: skip
    true = np.array([200e3, 200e3, 210e3, 190e3, 40, 40, 45, 45])
    at = [one.parameters.index(n) for n in (*(f"{w}_tire.stiffness" for w in WHEELS), *(f"{w}.mass" for w in WHEELS))]
    return one.values[at] / true - 1, np.sqrt(np.diag(one.covariance))[at] / true, one


class TestFourWheels:
    @pytest.mark.slow
    def test_holds_and_is_much_narrower(self) -> None:
        (_, alone, _), (errors, stds, both) = of_four(False), of_four(True)
        assert np.all(np.abs(errors) < 3.5 * stds)
        assert np.all(stds < alone / 2.5)
        checks = [c.remark for c in both.verdict.checks if c.remark.code is EstimateCheck.BEHIND]
        assert [(one.numbers["rear"], one.numbers["front"]) for one in checks] == [
            (rear, front) for rear, (front, _) in OF_FOUR.items()
        ]

    def test_the_car_turned_round_gives_four_roads(self) -> None:
        """Through the transfer of the state space and back, each road is itself and none of the others."""
        record = as_response(np.arange(4000) / 100, np.random.default_rng(1).standard_normal((7, 4000)), SENSORS)
        trials = trials_of(record, FULL, ("wheels",))
        unknowns = unknowns_of(FULL, rate=10.0, free_masses=WHEELS)
        first, second = _parts(unknowns, trials, tuple(f"{w}_tire" for w in WHEELS))
        problem = wheel_problem(
            FULL, trials, _part(unknowns, first), gains=(), delays=(), mounts=(), band=None, stretch=None
        )
        order = (2, 0, 3, 1)
        maps = MapProblem(problem=problem, number=0, tires=_part(unknowns, second), roads=order)
        system = statespace(FULL, outputs=list(SENSORS))
        s = np.asarray(2j * np.pi * np.array([0.7, 5.0, 11.0, 24.0]), complex)
        shown = np.array([system(one) for one in s])
        at = [[system.input_labels.index(FULL.roads[i] + rate) for i in order] for rate in ("", "_rate")]
        shown = shown[:, :, at[0]] + s[:, None, None] * shown[:, :, at[1]]
        made = maps.maps(s, maps.problem.unknowns.nominal, maps.tires.nominal)
        causes = list(problem.sources[0].layout.causes)
        np.testing.assert_allclose(made.roads @ shown[:, causes], np.broadcast_to(np.eye(4), (4, 4, 4)), atol=1e-8)

    @pytest.mark.parametrize(
        "behind",
        [
            {"road_rear_left": ("road_front_left", LAG)},
            {**OF_FOUR, "road_front_left": ("road_front_right", LAG)},
            {f"road_rear_{side}": ("road_front_left", LAG) for side in ("left", "right")},
        ],
    )
    def test_every_road_is_named_once(self, behind: dict[str, tuple[str, float]]) -> None:
        with pytest.raises(InputError, match="every road of the car once"):
            behind_of(behind, FULL)


class TestDrives:
    @pytest.mark.slow
    def test_a_recording_of_a_drive(self, tmp_path: Path) -> None:
        """`suspid drive` finds what `estimate` finds; without a speed it says that nothing follows from the track."""
        record, speed = drive()
        rows = np.vstack([np.asarray(record.outputs), speed])
        names = (*(f"{name} [m/s2]" for name in CHANNELS), "speed [m/s]")
        write_record(as_response(np.asarray(record.time), rows, names), tmp_path / "drive.csv")
        write_car(NOMINAL, tmp_path / "car.toml")
        words = ["drive", str(tmp_path / "drive.csv"), "--car", str(tmp_path / "car.toml"), "--road", "iso8608"]
        words += ["--free-mass", "front,rear", "--behind", f"road_rear=road_front:{LAG}"]
        pages = ["--json", str(tmp_path / "out.json"), "--page", str(tmp_path / "out.html")]
        done = CliRunner().invoke(main, [*words, *pages])
        assert done.exit_code == 0, done.output
        assert "The road under road_rear is that under road_front" in " ".join(done.output.split())
        content = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
        told = {one["name"]: one for one in content["estimate"]["parameters"]}
        for name, true, std in zip(FOUND, TRUE, stds(found(True)), strict=True):
            assert abs(told[name]["value"] - true) < 4 * told[name]["std"]
            # The drive is cut at its ends.
            assert told[name]["std"] == pytest.approx(std, rel=0.3)
        assert "The road under road_rear is that under road_front" in (tmp_path / "out.html").read_text("utf-8")
        unknown = CliRunner().invoke(main, [*words, "--without", "speed"])
        assert "neither is the delay between the axles" in " ".join(unknown.output.split())

    def test_drives_of_a_fleet(self, tmp_path: Path) -> None:
        """Rows hold what a drive says, and the same call takes up where it was."""
        record, speed = drive()
        rows = np.vstack([np.asarray(record.outputs), speed])
        ride = as_response(np.asarray(record.time), rows, (*CHANNELS, "speed [m/s]"))
        for _ in range(2):
            run = estimate_many(
                [("VAN/2024-05-31", ride)], output=tmp_path / "out", car=NOMINAL, workers=1, road="iso8608",
                behind=BEHIND, settings=Settings(springs=CarSettings(free_masses=("front", "rear"))),
            )  # fmt: skip
            (row,) = run.drives.to_pylist()
            assert str(EstimateCheck.BEHIND) in row["notes"]
            assert row["front_tire.stiffness_std"] == pytest.approx(stds(found(True))[0], rel=0.3)

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"behind": BEHIND}, "belongs to a model of the road"),
            ({"behind": {"road_rear": ("road", 2.7)}, "road": "iso8608"}, "no road 'road'"),
        ],
    )
    def test_a_fleet_refuses_at_once(self, tmp_path: Path, options: dict[str, Any], words: str) -> None:
        with pytest.raises(InputError, match=words):
            estimate_many([], output=tmp_path / "out", car=NOMINAL, **options)


class TestRefused:
    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"behind": {"road_rear": ("road_front", -1.0)}}, "'road_rear' needs .* the distance.* not -1.0"),
            ({"behind": {"road_rear": "road_front"}}, "'road_rear' needs .* the distance.* not 'road_front'"),
            ({"behind": {"rear": ("front", 2.7)}}, "no road 'rear'; it has 'road_front', 'road_rear'"),
            ({"behind": {"road_rear": ("road_rear", 2.7)}}, "'road_front' 0 times, 'road_rear' 2 times"),
            ({"behind": BEHIND, "speed": None}, "speed"),
            ({"behind": BEHIND, "road": None, "speed": None}, "^behind belongs to a model of the road"),
            ({"behind": None, "road": None}, "^speed belongs to a model of the road"),
        ],
    )
    def test_says_why(self, options: dict[str, Any], words: str) -> None:
        record, speed = drive()
        with pytest.raises(InputError, match=words):
            asked_of(record, **{"speed": speed, **options})


def test_command(tmp_path: Any) -> None:
    """The command says what the function finds."""
    record, speed = drive()
    rows = np.vstack([np.asarray(record.outputs), speed])
    write_record(as_response(np.asarray(record.time), rows, (*CHANNELS, "speed")), tmp_path / "drive.csv")
    write_car(NOMINAL, tmp_path / "car.toml")
    words = ["estimate", str(tmp_path / "drive.csv"), "--car", str(tmp_path / "car.toml"), "--given", "wheels"]
    words += ["--free-mass", "front,rear", "--road", "iso8608", "--speed", "speed"]
    done = CliRunner().invoke(main, [*words, "--behind", f"road_rear=road_front:{LAG}"])
    assert done.exit_code == 0, done.output
    assert "The road under road_rear is that under road_front" in " ".join(done.output.split())
    wrong = CliRunner().invoke(main, [*words, "--behind", "road_rear=road_front"])
    assert wrong.exit_code == 2
    assert "ROAD=OTHER:METRES" in wrong.output
