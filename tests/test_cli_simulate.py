"""Driven records on the command line: what is written is what `simulate` and `road_profile` give."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import read_car, read_record, road_profile, simulate
from suspid.cli.main import main
from suspid.signals import as_signal

CAR = Path(__file__).resolve().parents[1] / "examples" / "hatchback.toml"
HALF = """
[half_car]
chassis_mass = 1200
pitch_inertia = 1800
front_tire_mass = 80
rear_tire_mass = 80
cg_to_front = 1.2
cg_to_rear = 1.5
front_stiffness = 40e3
rear_stiffness = 36e3
front_tire_stiffness = 400e3
rear_tire_stiffness = 400e3
front_damping = 3000
rear_damping = 2800
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_a_road_is_driven_and_written(tmp_path: Path) -> None:
    options = ["--road", "C", "--speed", 15, "--seed", 3, "--fs", 200, "--channel", "chassis_acceleration"]
    result = run("simulate", CAR, "-o", tmp_path / "drive.csv", *options)
    assert result.exit_code == 0, result.output
    found = as_signal(read_record(tmp_path / "drive.csv"))
    assert found.channels == ("chassis_acceleration", "road")
    t = np.arange(2000) / 200
    road = road_profile(15 * t, roughness="C", rng=np.random.default_rng(3), wavelengths=(0.15, 100.0))
    np.testing.assert_array_equal(found.values[1], road - road[0])
    again = simulate(
        read_car(CAR), t, {"road": found.values[1]}, outputs=["chassis_acceleration"], interpolation="cubic"
    )
    np.testing.assert_array_equal(found.values[0], again.y[0])


def test_a_speed_that_changes_meets_the_same_road(tmp_path: Path) -> None:
    """From 10 to 20 m/s in 5 s, and back: ``s = 10 t + t^2`` up to there; the speed is a channel."""
    options = [
        "--road",
        "C",
        "--speed",
        "0:10,5:20,10:10",
        "--seed",
        3,
        "--fs",
        200,
        "--channel",
        "chassis_acceleration",
    ]
    result = run("simulate", CAR, "-o", tmp_path / "drive.csv", *options)
    assert result.exit_code == 0, result.output
    found = np.genfromtxt(tmp_path / "drive.csv", delimiter=",", skip_header=1).T
    assert (tmp_path / "drive.csv").read_text().splitlines()[0].endswith("chassis_acceleration,road,speed [m/s]")
    t = np.arange(2000) / 200
    speed, waves = 20 - 2 * abs(t - 5), (2 * 20 / 200, 100.0)
    where = np.where(t < 5, 10 * t + t**2, 75 + 20 * (t - 5) - (t - 5) ** 2)
    road = road_profile(where, roughness="C", rng=np.random.default_rng(3), wavelengths=waves)
    np.testing.assert_allclose(found[2], road - road[0], atol=1e-9)
    np.testing.assert_allclose(found[3], speed, rtol=1e-9)


def test_the_rear_axle_meets_what_the_front_has_met(tmp_path: Path) -> None:
    (tmp_path / "half.toml").write_text(HALF)
    options = ["--road", "B", "--speed", 20, "--seed", 1, "--fs", 200, "--behind", "road_rear=road_front:2.7"]
    result = run("simulate", tmp_path / "half.toml", "-o", tmp_path / "drive.csv", *options)
    assert result.exit_code == 0, result.output
    found = as_signal(read_record(tmp_path / "drive.csv"))
    front, rear = (found.values[found.channels.index(f"road_{axle}")] for axle in ("front", "rear"))
    np.testing.assert_allclose(np.diff(rear)[27:], np.diff(front)[:-27], atol=1e-12)


@pytest.mark.parametrize(
    ("options", "last"),
    [
        (["--step", "0.05"], 0.05),
        (["--step", "0.05", "--input", "road"], 0.05),
        (["--sweep", "0.5", "5", "0.01"], None),
    ],
)
def test_steps_and_sweeps(tmp_path: Path, options: list[str], last: float | None) -> None:
    result = run("simulate", CAR, "-o", tmp_path / "r.csv", *options)
    assert result.exit_code == 0, result.output
    found = as_signal(read_record(tmp_path / "r.csv"))
    assert found.channels[-1] == "road"
    assert found.values[-1, 0] == pytest.approx(0, abs=1e-15)
    assert np.max(np.abs(found.values[-1])) == pytest.approx(last or 0.01, rel=1e-3)
    if last:
        np.testing.assert_allclose(found.values[:, -1], last, rtol=1e-4)


def test_a_force_is_swept(tmp_path: Path) -> None:
    options = ["--sweep", "0.5", "20", "200", "--input", "chassis_travel_force", "--channel", "chassis_acceleration"]
    result = run("simulate", CAR, "-o", tmp_path / "r.csv", *options)
    assert result.exit_code == 0, result.output
    assert as_signal(read_record(tmp_path / "r.csv")).channels == ("chassis_acceleration", "chassis_travel_force")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "Give one of --impulse, --initial, --road, --sweep and --step."),
        (["--step", "1", "--impulse", "road"], "Give one of"),
        (["--step", "1", "--sweep", "1", "2", "1"], "Give one of"),
        (["--road", "A", "--seed", "1"], "--road needs --speed"),
        (["--step", "1", "--speed", "3"], "--road needs --speed"),
        (["--road", "A", "--speed", "5:20,2:10", "--seed", "1"], "must ascend"),
        (["--road", "A", "--speed", "0:20,9:fast", "--seed", "1"], "'fast' is not a number"),
        (["--road", "A", "--speed", "20"], "--snr and --road need --seed"),
        (["--impulse", "chassis", "--seed", "1"], "--seed goes with --snr or --road"),
        (["--impulse", "road", "--input", "road"], "--input goes with --sweep or --step"),
        (["--road", "A", "--speed", "20", "--seed", "1", "--behind", "road=rod:1"], "write ROAD=OTHER:METRES"),
    ],
)
def test_wrong_requests_are_usage_errors(tmp_path: Path, options: list[str], message: str) -> None:
    result = run("simulate", CAR, "-o", tmp_path / "r.csv", *options)
    assert result.exit_code == 2
    assert message in result.output
    assert not list(tmp_path.iterdir())


def test_unknown_inputs_are_refused(tmp_path: Path) -> None:
    result = run("simulate", CAR, "-o", tmp_path / "r.csv", "--step", "1", "--input", "rod")
    assert result.exit_code == 1
    assert "there is no input 'rod'" in result.output


@pytest.mark.parametrize("channels", [(), ("chassis_acceleration", "chassis_travel")])
def test_friction_and_curves_of_the_car_file(tmp_path: Path, channels: tuple[str, ...]) -> None:
    """A decay with friction comes to rest; with its channels asked for, it is the motion of `simulate`."""
    rough = CAR.read_text(encoding="utf-8") + "\n[friction]\nchassis = 60.0\n"
    rough += "\n[curves]\nchassis = [[-1.0, -700.0], [0.0, 0.0], [1.0, 2000.0]]\n"
    (tmp_path / "rough.toml").write_text(rough, encoding="utf-8")
    named = [part for name in channels for part in ("--channel", name)]
    options = ["-o", tmp_path / "decay.csv", "--initial", "v_tire=1", "--duration", 2, *named]
    result = run("simulate", tmp_path / "rough.toml", *options)
    assert result.exit_code == 0, result.output
    found = as_signal(read_record(tmp_path / "decay.csv"))
    car, start = read_car(tmp_path / "rough.toml"), {"v_tire": 1.0}
    expected = simulate(car, found.timepts, {}, outputs=channels or None, initial_state=start)
    np.testing.assert_allclose(found.values, expected.y[: len(found.values)], atol=1e-12)
    linear = simulate(car.linearised(), found.timepts, {}, outputs=channels or None, initial_state=start)
    assert np.max(np.abs(expected.y - linear.y)) > 0.05 * np.max(np.abs(linear.y))
    refused = run("simulate", tmp_path / "rough.toml", "-o", tmp_path / "b.csv", "--impulse", "road")
    assert refused.exit_code == 1
    assert "not in proportion to an impulse" in refused.output
