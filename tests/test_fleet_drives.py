"""Fleets of drives: a row for each vehicle and drive, a reason for each that fails, and a fading damper is told."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from fleets import content, time_limit

from suspid import (
    DamperState,
    DriveLimits,
    InputError,
    Suspension,
    analyse_drive,
    estimate_many,
    fleet_summary,
    identify_many,
    quarter_car,
    write_car,
)
from suspid.analysis import CarSettings, Settings
from suspid.cli.main import main
from suspid.fleet import FleetRun
from suspid.fleet.vehicles import vehicle_in_name
from suspid.records import as_response
from suspid.units import RealArray
from validation.motion import Drive, driven

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
NOISE = {"chassis_acceleration": 0.03, "tire_acceleration": 0.1}
FADES, HOLDS = "VAN 7", "north/VAN 8"
DRIVES = 4  # of each of the two
LOST = 0.4
HOSTILE = "\x1b[31m VAN, '9';\n../\x7f"
UNDATED = "no date.csv"


@pytest.fixture(autouse=True)
def limited() -> Iterator[None]:
    with time_limit():
        yield


def damping(vehicle: str, k: int) -> float:
    """Return the damping of a vehicle in its k-th drive; from drive to drive it differs by 1 %."""
    share = LOST * k / (DRIVES - 1) if vehicle == FADES else 0.0
    return 1300 * (1 - share) * (1.01 if k % 2 else 0.99)


def channels_of(car: Suspension, seed: int, duration: float = 25.0) -> tuple[RealArray, dict[str, RealArray]]:
    """Return times and channels of a drive by a simulator that is apart from the library."""
    rng = np.random.default_rng(seed)
    motions, times = driven(car, Drive(duration=duration, noise=NOISE), rng)
    return times, {n: motions[n] + std * rng.standard_normal(times.size) for n, std in NOISE.items()}


def write(path: Path, times: RealArray, channels: dict[str, RealArray], speed: float = 72.0) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    head = ",".join(["time [s]", *(f"{name} [m/s^2]" for name in channels), "speed [km/h]"])
    columns = np.column_stack([times, *channels.values(), np.full(times.size, speed)])
    np.savetxt(path, columns, delimiter=",", header=head, comments="", fmt="%.5g")


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a folder of two vehicles, and of files that no drive can be found in."""
    folder = tmp_path_factory.mktemp("fleet") / "in"
    for seed, vehicle in enumerate((FADES, HOLDS)):
        for k in range(DRIVES):
            car = CAR.with_parameters(damping={"chassis": damping(vehicle, k)})
            write(folder / vehicle / f"2024-{3 * k + 1:02d}-15.csv", *channels_of(car, 10 * seed + k))
    times, channels = channels_of(CAR, 99)
    (folder / HOLDS / "2024-02-01.mf4").write_bytes(bytes(range(256)) * 20)
    write(folder / HOSTILE / "2024-02-01.csv", times[:3], {n: row[:3] for n, row in channels.items()})
    write(folder / UNDATED, times, {n: 1e-3 * row for n, row in channels.items()}, speed=0.0)
    write_car(CAR, folder.parent / "car.toml")
    return folder


@pytest.fixture(scope="module")
def run(fleet: Path, tmp_path_factory: pytest.TempPathFactory) -> FleetRun:
    return estimate_many(fleet, output=tmp_path_factory.mktemp("out"), car=CAR, workers=1, chunk=1)


@pytest.fixture(scope="module")
def rows(run: FleetRun) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = run.drives.to_pylist()
    return found


def command(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["fleet", *map(str, arguments)])


class TestRows:
    def test_one_for_each_vehicle_and_drive(self, run: FleetRun, rows: list[dict[str, Any]]) -> None:
        good = [row for row in rows if row["verdict"] != "none"]
        assert [(row["vehicle"], round(12 * (row["time"] - 2024))) for row in good] == [
            (vehicle, 3 * k) for vehicle in (FADES, HOLDS) for k in range(DRIVES)
        ]
        assert run.records == 2 * DRIVES + 3
        assert run.failed == 3

    def test_truth_lies_in_the_intervals(self, rows: list[dict[str, Any]]) -> None:
        good = [row for row in rows if row["verdict"] != "none"]
        for i, row in enumerate(good):
            # One false alarm in two million of these tests.
            assert abs(row["chassis.stiffness"] - 22e3) < 5 * row["chassis.stiffness_std"] < 0.05 * 22e3
            truth = damping(row["vehicle"], i % DRIVES)
            # The Cramér-Rao bound of c is 0.93 % from 60 s of class B, so 1.43 % from 25 s; roads differ by a half.
            assert abs(row["chassis.damping"] - truth) < 5 * row["chassis.damping_std"] < 5 * 1.5 * 0.0143 * truth
            assert row["tire.stiffness"] == 210e3
            assert row["tire.stiffness_std"] is None
            assert (row["stretches"], row["explains"]) == (1, True)
            assert 10 <= row["used_s"] <= row["length_s"] == pytest.approx(25, abs=0.1)
            assert row["speed_m_per_s"] == pytest.approx(20, rel=1e-3)

    def test_they_are_those_of_one_drive_alone(self, fleet: Path, rows: list[dict[str, Any]]) -> None:
        row = next(row for row in rows if row["verdict"] != "none")
        found = analyse_drive(fleet / row["record"], car=CAR, curves=False)
        assert found.estimate is not None
        assert found.wear is not None
        assert row["verdict"] == found.verdict.level.label
        assert row["doubts"] == [str(doubt.code) for doubt in found.verdict.doubts]
        assert row["doubts_in_words"] == [str(doubt) for doubt in found.verdict.doubts]
        values = dict(zip(found.estimate.parameters, found.estimate.values, strict=True))
        # Another number of threads may round otherwise.
        assert row["chassis.damping"] == pytest.approx(values["chassis.damping"], rel=1e-6)
        (one,) = found.wear.dampers
        assert (row["chassis.wear"], row["chassis.lost"]) == (str(one.state), pytest.approx(one.loss.value, abs=1e-5))

    def test_springs_have_a_row_for_each_parameter(self, run: FleetRun) -> None:
        table = [row for row in run.springs.to_pylist() if row["parameter"] == "chassis.damping"]
        assert len(table) == 2 * DRIVES
        assert all(row["low"] < row["value"] < row["high"] and row["unit"] == "N s/m" for row in table)

    def test_other_tables_are_refused(self, run: FleetRun) -> None:
        with pytest.raises(InputError, match="no table of modes: their records have rows of drives"):
            _ = run.modes


class TestFailures:
    def test_each_has_its_reason(self, run: FleetRun, rows: list[dict[str, Any]]) -> None:
        failures = {row["record"]: row for row in run.failures.to_pylist()}
        assert failures[f"{HOLDS}/2024-02-01.mf4"]["code"] == "unusable record"
        (hostile,) = [name for name in failures if "VAN, '9'" in name]
        assert "too short for a drive" in failures[hostile]["reason"]
        assert hostile.isprintable()
        parked = failures[UNDATED]
        assert (parked["step"], parked["code"]) == ("find stretches", "no stretch")
        (row,) = [row for row in rows if row["record"] == UNDATED]
        assert (row["verdict"], row["stretches"], row["vehicle"], row["time"]) == ("none", 0, None, None)


class TestTrends:
    def test_the_damper_that_fades_is_told_and_the_other_is_not(self, run: FleetRun) -> None:
        summary = fleet_summary(run.output)
        assert summary.dampers is not None
        states = {one.vehicle: one.state for one in summary.dampers.trends}
        assert states == {FADES: DamperState.WORN, HOLDS: DamperState.GOOD}
        (worn,) = summary.dampers.doubtful.trends
        assert worn.loss.low < LOST < worn.loss.high
        changing = [(one.vehicle, one.quantity) for one in summary.trends if one.changes]
        assert changing == [(FADES, "chassis.damping")]
        assert sum(summary.wear["chassis"].values()) == 2 * DRIVES
        assert summary.unplaced == 1

    def test_vehicles_may_come_from_a_table(self, run: FleetRun, rows: list[dict[str, Any]], tmp_path: Path) -> None:
        lines = [f'"{row["record"]}",all,{k}' for k, row in enumerate(rows) if row["verdict"] != "none"]
        (tmp_path / "vehicles.csv").write_text("\n".join(["record,vehicle,date", *lines]))
        told = command("--summary", run.output, "--table", tmp_path / "vehicles.csv")
        assert told.exit_code == 0, told.output
        assert "1 damper over their records" in told.stdout

    def test_drives_that_no_trend_can_be_drawn_from_are_counted(self, run: FleetRun) -> None:
        summary = fleet_summary(run.output)
        assert summary.dampers is not None
        assert summary.untrusted == 0
        none = replace(summary, dampers=replace(summary.dampers, trends=()), untrusted=3)
        assert "at least four drives" in str(none)
        assert "3 drives are in no trend of a damper" in str(none)
        assert "1 drive is in no trend of a damper" in str(replace(summary, untrusted=1))


class TestResumed:
    @pytest.mark.slow
    def test_what_is_missing_is_done_again(self, fleet: Path, run: FleetRun, tmp_path: Path) -> None:
        # A run that was killed: some parts are there, of one the last table is not, and a draft is left.
        expected = content(run.output)
        kept = 2 * DRIVES
        for name, data in expected.items():
            number = int(name[-14:-8]) if name.endswith(".parquet") else -1
            if number < kept or (number == kept and not name.startswith("drives")):
                (tmp_path / name).parent.mkdir(exist_ok=True)
                (tmp_path / name).write_bytes(data)
        manifest = json.loads(expected["manifest.json"])
        del manifest["complete"]
        (tmp_path / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
        (tmp_path / "drives" / ".part-000009.parquet.draft").write_bytes(b"half")
        again = estimate_many(fleet, output=tmp_path, car=CAR, workers=1, chunk=1)
        assert (again.records, again.failed, again.kept) == (run.records, run.failed, kept)
        assert content(tmp_path) == expected

    def test_other_limits_are_another_run(self, fleet: Path, run: FleetRun) -> None:
        with pytest.raises(InputError, match="least_speed was 3.0, is 5.0"):
            estimate_many(fleet, output=run.output, car=CAR, chunk=1, limits=DriveLimits(least_speed=5.0))
        with pytest.raises(InputError, match="begun with other settings"):
            identify_many(fleet, output=run.output, car=CAR, chunk=1)

    @pytest.mark.slow
    def test_killed_half_way_by_two_workers(self, fleet: Path, run: FleetRun, tmp_path: Path) -> None:
        arguments = [str(fleet), "--drives", "--car", str(fleet.parent / "car.toml"), "--chunk", "1", "--workers", "2"]
        called = [sys.executable, "-m", "suspid", "fleet", *arguments, "-o", str(tmp_path)]
        process = subprocess.Popen(called, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def done() -> int:
            return len(list((tmp_path / "drives").glob("part-*.parquet")))

        while done() < 3:
            assert process.poll() is None
            time.sleep(0.01)
        os.kill(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        kept = done()
        assert kept < run.records
        again = estimate_many(fleet, output=tmp_path, car=CAR, workers=2, chunk=1)
        assert (again.records, again.kept) == (run.records, kept)
        assert content(tmp_path) == content(run.output)


class TestOtherSources:
    @pytest.mark.slow
    def test_samples_in_memory_and_the_body_alone(self, tmp_path: Path) -> None:
        times, channels = channels_of(CAR, 5, 230.0)
        body = as_response(times, channels["chassis_acceleration"][None], ("chassis_acceleration",))
        run = estimate_many([("A/2024-01-01", body), ("not one", 0)], output=tmp_path, workers=1)
        (row,) = run.drives.to_pylist()
        assert (row["vehicle"], row["body_channels"]) == ("A", ["chassis_acceleration"])
        # The body's mode above a wheel held still: 1.26 Hz, 1.21 Hz on its tire.
        assert row["body_low_hz"][0] < 1.21 < row["body_high_hz"][0]
        assert "chassis.damping" not in row
        assert run.failures.to_pylist()[0]["code"] == "not a response"
        assert [one.quantity for one in fleet_summary(tmp_path).distributions] == ["chassis_acceleration f"]


class TestVehicles:
    @pytest.mark.parametrize(
        ("name", "vehicle", "year"),
        [
            ("V7/2024-07-01.mf4", "V7", 2024.498),
            ("V7/2024-07-01/00001.mf4", "V7", 2024.498),
            ("V7_20240701T1200.csv", "V7", 2024.5),
            ("V7/20240701-20231399.csv", "V7", 2024.498),
            ("V7/202407011.csv", "V7", None),
            ("2024-07-01.csv", None, 2024.498),
            ("V7/2024-02-30.csv", "V7", None),
            ("", None, None),
        ],
    )
    def test_are_found_in_names(self, name: str, vehicle: str | None, year: float | None) -> None:
        assert vehicle_in_name(name) == (vehicle, None if year is None else pytest.approx(year, abs=2e-3))


class TestCommand:
    def test_the_first_command(self, fleet: Path, run: FleetRun) -> None:
        # Nothing is left to do: it continues the run, and shows what the results say.
        told = command(fleet, "--drives", "--car", fleet.parent / "car.toml", "-o", run.output, "--chunk", 1)
        assert told.exit_code == 0, told.output
        for text in (
            "2 dampers over their records: 1 good, 1 worn",
            "drives by wear against nominal",
            "unusable record",
        ):
            assert text in told.stdout

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (["--speed", "none"], "--speed is for drives: give --drives too"),
            (["--drives", "--modes", "2"], "--modes is for decays: leave --drives out"),
            (["--drives", "--added", "chassis=3"], "--added is for single tests"),
        ],
    )
    def test_options_of_the_other_kind(self, tmp_path: Path, arguments: list[str], words: str) -> None:
        told = command(tmp_path, "-o", tmp_path / "out", *arguments)
        assert told.exit_code == 2
        assert words in told.output

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"wheel_radius": 0.3}, "model of the road"),
            ({"road": "iso8608", "car": None}, "needs a car"),
            ({"settings": Settings(modes=2)}, "settings.modes does not apply"),
            ({"settings": Settings(springs=CarSettings(tolerance=0.1))}, "springs.tolerance does not apply"),
            ({"table": "a.csv", "pattern": "b"}, "not both"),
            ({"pattern": "(?P<vehicle>.)"}, "no group"),
            ({"chunk": 0}, "1 or more"),
        ],
    )
    def test_what_cannot_be_meant_is_refused_before_any_drive(
        self, tmp_path: Path, given: dict[str, Any], words: str
    ) -> None:
        with pytest.raises(InputError, match=words):
            estimate_many([], output=tmp_path / "out", **{"car": CAR, **given})
        assert not (tmp_path / "out").exists()
