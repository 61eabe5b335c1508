"""`suspid ride` and `suspid tune`: what is printed is what the library gives."""

import json
import re
from pathlib import Path
from typing import Literal

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import (
    InputError,
    add_noise,
    cut,
    estimate,
    free_decay,
    grip,
    quarter_car,
    read_car,
    read_record,
    ride,
    road,
    simulate,
    tune,
    write_car,
    write_record,
)
from suspid.cli import main
from suspid.identification import to_json
from suspid.reporting import estimate_to_dict, json_schema

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
DRIVE = ["--road", "C", "--speed", "20"]


@pytest.fixture
def car(tmp_path: Path) -> Path:
    write_car(CAR, tmp_path / "car.toml")
    return tmp_path / "car.toml"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(one) for one in arguments])


def test_a_car(car: Path) -> None:
    shown = run("ride", car, *DRIVE, "--clearance", "chassis=0.03", "--plot", car.with_suffix(".png"))
    assert shown.exit_code == 0, shown.output
    assert str(ride(read_car(car), road="C", speed=20.0, clearance={"chassis": 0.03})) in shown.output
    assert car.with_suffix(".png").stat().st_size > 10_000


def test_a_number_is_a_roughness(car: Path) -> None:
    shown = run("ride", car, "--road", "256e-6", "--speed", "20", "--level", "0.9", "--nominal-std", "0.05")
    assert shown.output.startswith(str(ride(read_car(car), road="C", speed=20.0, nominal_std=0.05)))
    assert "90 % interval" in shown.output


def test_grip_of_a_car(car: Path) -> None:
    shown = run(
        "grip", car, "--nominal-std", "0.05", "--level", "0.9", "--load", "tire=4000", "--plot",
        car.with_suffix(".png"), "--json", car.with_suffix(".json"),
    )  # fmt: skip
    assert shown.exit_code == 0, shown.output
    found = grip(read_car(car), nominal_std=0.05, loads={"tire": 4000.0})
    assert shown.output.startswith(str(found))
    assert car.with_suffix(".png").stat().st_size > 10_000
    content = json.loads(car.with_suffix(".json").read_text(encoding="utf-8"))
    jsonschema.validate(content, json_schema("grip"))
    wheel = content["wheels"][0]
    assert (wheel["phase_lower_rad"], wheel["phase_upper_rad"]) == pytest.approx(found.interval(0.9)["tire.phase"])
    low, high = np.degrees(found.interval(0.9)["tire.phase"])
    assert re.search(rf"tire.phase \[deg\] +{low:.1f} +{high:.1f}", shown.output)


@pytest.mark.parametrize("command", [("grip",), ("ride", *DRIVE)])
def test_no_interval_of_a_car_without_uncertainty(car: Path, command: tuple[str, ...]) -> None:
    shown = run(command[0], car, *command[1:], "--level", "0.9")
    assert shown.exit_code == 2
    assert "--nominal-std" in shown.output


def test_an_estimate(car: Path) -> None:
    decay = free_decay(CAR, np.arange(0, 2, 0.005), initial_state={"v_tire": 1.0})
    found = estimate(add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1)), CAR, fixed=["tire.damping"])
    path = car.with_name("estimate.json")
    path.write_text(to_json(estimate_to_dict(found)), encoding="utf-8")
    shown = run("ride", path, *DRIVE)
    assert shown.exit_code == 0, shown.output
    assert "±" in shown.output


def test_a_record(car: Path) -> None:
    t = np.arange(0, 20, 0.005)
    heights = road("C", speed=20.0).heights(t, rng=np.random.default_rng(1))
    path = car.with_name("drive.csv")
    write_record(simulate(CAR, t, heights, outputs=["chassis_acceleration", "chassis_travel"]), path)
    shown = run("ride", path)
    assert shown.exit_code == 0, shown.output
    assert "chassis_acceleration.VDV" in shown.output
    assert "chassis.peak_travel" in shown.output
    renamed = car.with_name("other.csv")
    renamed.write_text(path.read_text().replace("chassis_acceleration", "az"), encoding="utf-8")
    options = ["--channel", "az", "--rename", "az=chassis_acceleration", "--scale"]
    turned = run("ride", renamed, *options, "az=-1", "--from", "10")
    assert turned.exit_code == 0, turned.output
    assert "chassis.peak_travel" not in turned.output
    half = cut(read_record(path), start=10.0)
    assert f"{ride(half)['chassis_acceleration.VDV']:.3g}" in turned.output
    assert run("ride", car, *DRIVE, "--fs", "100").exit_code == 2
    only = run("ride", path, "--weighting", "chassis_acceleration=Wd")
    assert "chassis_acceleration.Wd" in only.output
    assert "MSDV" not in only.output


def test_sensitivities(car: Path) -> None:
    shown = run("ride", car, *DRIVE, "--sensitivities", "--plot", car.with_suffix(".svg"))
    assert "mode 1.zeta" in shown.output
    assert car.with_suffix(".svg").exists()


def test_tuning(car: Path) -> None:
    shown = run(
        "tune", car, *DRIVE, "--parameter", "chassis.damping", "--points", "3", "--limit", "chassis.travel=0.02",
        "--bound", "chassis.damping", "500", "4000", "-o", car.with_name("knee.toml"), "--plot", car.with_name("a.png"),
    )  # fmt: skip
    assert shown.exit_code == 0, shown.output
    assert "2 (knee)" in shown.output
    knee = read_car(car.with_name("knee.toml"))
    assert 500 < knee.struts[0].damping < 4000
    assert car.with_name("a.png").exists()


def test_tuning_by_default(car: Path) -> None:
    shown = run("tune", car, *DRIVE, "--points", "3")
    assert "chassis_acceleration.Wk" in shown.output
    assert "tire.load" in shown.output


@pytest.mark.parametrize(
    ("given", "code", "message"),
    [
        (["ride", "{car}"], 2, "A car needs --road and --speed"),
        (["grip", "{car}", "--load", "tyre=4000"], 1, "there is no wheel 'tyre'"),
        (["tune", "{car}"], 2, "A car needs --road and --speed"),
        (["ride", "{car}", "--road", "J", "--speed", "20"], 1, "is not a class of ISO 8608"),
        (["tune", "{car}", *DRIVE, "--objective", "tire.laod"], 1, "there is no figure 'tire.laod'"),
        (["ride", "{car}", *DRIVE, "--clearance", "chassis"], 2, "write STRUT=METRES, each name once"),
    ],
)
def test_wrong_commands(car: Path, given: list[str], code: int, message: str) -> None:
    shown = run(*(one.format(car=car) for one in given))
    assert shown.exit_code == code
    assert message in shown.output


def test_numbers_out_of_range_are_one_line(car: Path) -> None:
    flat = run("ride", car, "--road", "0", "--speed", "20")
    assert flat.exit_code == 1
    assert "nothing moves" in flat.output
    car.write_text(car.read_text(encoding="utf-8").replace("chassis = 350.0", "chassis = 1e300"), encoding="utf-8")
    huge = run("ride", car, *DRIVE)
    assert (huge.exit_code, huge.output.count("\n")) == (1, 1)
    assert "check its unit" in huge.output


def test_json_has_what_is_printed(car: Path) -> None:
    written = car.with_name("ride.json")
    assert run("ride", car, *DRIVE, "--nominal-std", "0.05", "--json", written).exit_code == 0
    content = json.loads(written.read_text(encoding="utf-8"))
    jsonschema.validate(content, json_schema("ride"))
    found = ride(read_car(car), road="C", speed=20.0, nominal_std=0.05)
    assert {one["figure"]: one["value"] for one in content["figures"]} == dict(
        zip(found.figures, found.values.tolist(), strict=True)
    )
    assert [one["lower"] for one in content["figures"]] == [low for low, _ in found.interval().values()]


def test_json_of_a_tuning_has_the_cars(car: Path) -> None:
    written = car.with_name("tune.json")
    shown = run("tune", car, *DRIVE, "--parameter", "chassis.damping", "--points", "3", "--json", written)
    content = json.loads(written.read_text(encoding="utf-8"))
    jsonschema.validate(content, json_schema("tune"))
    assert content["now"]["parameters"] == {"chassis.damping": 1300.0}
    assert "1300" in next(line for line in shown.output.splitlines() if line.strip().startswith("now"))
    for one in content["cars"]:
        made = car.with_name("made.toml")
        made.write_text(one["toml"], encoding="utf-8")
        again = ride(read_car(made), road="C", speed=20.0)
        for name, value in one["figures"].items():
            assert again[name] == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["ride", "CAR", *DRIVE, "--road", "D"], "'--road': given twice"),
        (["ride", "CAR", *DRIVE, "--speed=30"], "'--speed': given twice"),
        (["tune", "CAR", *DRIVE, *2 * ["--bound", "chassis.damping", "500", "4000"]], "already has bounds"),
        (["ride", "CAR", *DRIVE, "--duration", "1e20"], "--duration 1e+20 s is outside of 1 to 1e+09 s"),
    ],
)
def test_an_option_that_would_count_for_nothing_is_refused(car: Path, words: list[str], message: str) -> None:
    shown = run(*(car if word == "CAR" else word for word in words))
    assert shown.exit_code in (1, 2)
    assert message in shown.output


@pytest.mark.parametrize(("command", "kind"), [(("ride", *DRIVE), "ride"), (("grip",), "grip")])
def test_friction_is_replaced_by_dampers_of_equal_work_and_it_is_said(
    car: Path, command: tuple[str, ...], kind: Literal["ride", "grip"]
) -> None:
    """Work per cycle: c pi V^2/w = (c0 pi V^2 + 4 F V)/w, so c = c0 + 4 F / (pi V)."""
    write_car(CAR.with_parameters(friction={"chassis": 60.0}), car)
    refused = run(command[0], car, *command[1:])
    assert refused.exit_code == 1
    assert "give --linearise, the amplitude" in refused.stderr
    page = car.with_suffix(".json")
    shown = run(command[0], car, *command[1:], "--linearise", "0.2", "--json", page)
    assert shown.exit_code == 0, shown.stderr
    rate = 1300 + 4 * 60 / (np.pi * 0.2)
    equal = CAR.with_parameters(damping={"chassis": rate})
    table = str(ride(equal, road="C", speed=20.0) if kind == "ride" else grip(equal)).partition("\nVerdict")[0]
    assert shown.stdout.startswith(table)
    said = "Linearised at an amplitude of velocity of 0.2 m/s: dampers of equal work in place of friction and curves,"
    assert f"{said} chassis {rate:.0f} N s/m." in shown.stdout
    content = json.loads(page.read_text(encoding="utf-8"))
    jsonschema.validate(content, json_schema(kind))
    (check,) = [one for one in content["verdict"]["checks"] if one["code"] == "linearised"]
    assert check["numbers"]["damping"] == pytest.approx([rate])


def test_a_tuning_starts_from_dampers_of_equal_work(car: Path) -> None:
    write_car(CAR.with_parameters(friction={"chassis": 60.0}), car)
    words = ("tune", car, *DRIVE, "--parameter", "chassis.damping", "--points", "3")
    refused = run(*words)
    assert refused.exit_code == 1
    assert "give --linearise, the amplitude" in refused.stderr
    best = car.with_name("best.toml")
    shown = run(*words, "--linearise", "0.2", "-o", best)
    assert shown.exit_code == 0, shown.stderr
    rate = 1300 + 4 * 60 / (np.pi * 0.2)
    assert f"dampers of equal work in place of friction and curves, chassis {rate:.0f} N s/m." in shown.stdout
    equal = tune(CAR.with_parameters(damping={"chassis": rate}), parameters=["chassis.damping"], road="C", speed=20.0,
                 points=3)  # fmt: skip
    assert shown.stdout.startswith(str(equal).partition("\nVerdict")[0])
    assert read_car(best).linear


def test_a_reconstruction_takes_dampers_of_equal_work(car: Path) -> None:
    """The modes of the car with the damper of equal work return that damper, whatever stood for it in the file."""
    write_car(CAR.with_parameters(friction={"chassis": 60.0}), car)
    modes, result = car.with_name("modes.json"), car.with_name("found.toml")
    assert run("modes", car, "--linearise", "0.2", "--json", modes).exit_code == 0
    refused = run("reconstruct", modes, car)
    assert refused.exit_code == 1
    assert "give --linearise, the amplitude" in refused.stderr
    shown = run("reconstruct", modes, car, "--linearise", "0.3", "-o", result)
    assert shown.exit_code == 0, shown.stderr
    rate = 1300 + 4 * 60 / (np.pi * 0.3)
    assert f"dampers of equal work in place of friction and curves, chassis {rate:.0f} N s/m." in shown.stderr
    assert read_car(result).struts[0].damping == pytest.approx(1300 + 4 * 60 / (np.pi * 0.2), rel=1e-6)


def test_linearise_is_said_to_have_no_use(car: Path) -> None:
    for command in (("ride", *DRIVE), ("grip",), ("tune", *DRIVE, "--points", "2"), ("modes",)):
        shown = run(command[0], car, *command[1:], "--linearise", "0.2")
        assert shown.exit_code == 0, shown.stderr
        assert "--linearise has no use: the car has neither friction nor curves" in shown.stderr


def test_the_form_of_a_weighting_is_shown(tmp_path: Path) -> None:
    file = tmp_path / "drive.csv"
    rows = "".join(f"{k / 100},{np.sin(k / 3)}\n" for k in range(3000))
    file.write_text(f"time [s],a body\n{rows}", encoding="utf-8")
    refused = run("ride", file)
    assert refused.exit_code == 1
    assert "state the weighting of those that are (--weighting 'a body'=Wk)" in refused.output
    assert "write CHANNEL=Wk,…, each name once" in run("ride", file, "--weighting", "Wk").output
    with pytest.raises(InputError, match=r"with weightings as in \{'a body': 'Wk'\}"):
        ride(read_record(file))
