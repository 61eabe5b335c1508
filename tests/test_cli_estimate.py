"""The command `estimate`: from records to springs and dampers, its files, exit codes and refusals."""

from __future__ import annotations

import json
from pathlib import Path

import control
import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import (
    add_noise,
    analyse,
    free_decay,
    half_car,
    quarter_car,
    read_car,
    simulate,
    statespace,
    write_car,
    write_record,
)
from suspid.cli.main import main
from suspid.reporting import json_schema

pytestmark = pytest.mark.usefixtures("words_alone")

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=40
)
NOMINAL = CAR.with_parameters(stiffness={"chassis": 16e3, "tire": 250e3}, damping={"chassis": 1700})
TRUTH = {"chassis.stiffness": 22e3, "tire.stiffness": 210e3, "chassis.damping": 1300.0, "tire.damping": 40.0}
TIMES = np.arange(0, 4, 0.005)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """A folder with a decay, a decay with 100 kg more, a rig, and the nominal car."""
    write_car(NOMINAL, tmp_path / "car.toml")
    for seed, (name, mass) in enumerate((("decay", 350), ("loaded", 450))):
        loaded = CAR.with_parameters(masses={"chassis": mass})
        record = free_decay(loaded, TIMES, initial_state={"v_tire": 1.0, "z_chassis": 0.02})
        write_record(add_noise(record, snr_db=30, rng=np.random.default_rng(seed)), tmp_path / f"{name}.csv")
    swept = 0.005 * np.sin(2 * np.pi * (0.5 + 2 * TIMES) * TIMES)
    record = simulate(
        CAR, TIMES, {"road": swept}, outputs=["chassis_acceleration", "chassis_travel"], interpolation="cubic"
    )
    write_record(add_noise(record, snr_db=30, rng=np.random.default_rng(3)), tmp_path / "rig.csv")
    return tmp_path


def holds(content: dict[str, list[dict[str, object]]], reach: float = 5.0) -> bool:
    """Return whether every parameter is true to five standard deviations: one false alarm in two million."""
    return all(abs(p["value"] - TRUTH[str(p["name"])]) < reach * p["std"] for p in content["parameters"])  # type: ignore[operator]


@pytest.mark.parametrize(
    "arguments",
    [
        ["decay.csv"],
        ["decay.csv", "loaded.csv", "--added", "loaded.csv:chassis=100"],
        ["rig.csv", "--given", "road"],
    ],
    ids=["free decay", "two tests", "rig"],
)
def test_springs_and_dampers_from_files(files: Path, arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    outputs = ["--json", "e.json", "--plot", "e.png", "--page", "e.html", "-o", "found.toml", "--level", "0.9"]
    result = run("estimate", *arguments, "--car", "car.toml", *outputs)
    assert result.exit_code == 0, result.output
    content = json.loads((files / "e.json").read_text())
    jsonschema.validate(content, json_schema("estimate"))
    assert holds(content)
    assert content["level"] == 0.9
    by_name = {p["name"]: p for p in content["parameters"]}
    assert by_name["chassis.stiffness"]["significant"]
    assert by_name["chassis.stiffness"]["change"] == pytest.approx(22 / 16 - 1, abs=0.02)
    assert len(content["records"]) == sum(a.endswith(".csv") for a in arguments)
    assert (files / "e.png").read_bytes().startswith(b"\x89PNG")
    found = read_car(files / "found.toml")
    assert found.struts[0].stiffness == by_name["chassis.stiffness"]["value"]
    page = (files / "e.html").read_text(encoding="utf-8")
    shown = [content["verdict"]["headline"]["text"], "90 %", "chassis.stiffness", "<svg", *arguments[:1]]
    assert not [text for text in shown if text.lower() not in page.lower()]
    assert page.index("Springs and dampers</h2>") < page.index("Modes</h2>") < page.index("fit and residual</h2>")
    for text in ("nominal", "significant", "90 % interval", "f [Hz]", "Verdict"):
        assert text in result.stdout


def test_a_free_mass_in_two_tests_is_found(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    result = run(
        "estimate", "decay.csv", "loaded.csv", "--added", "loaded.csv:chassis=100", "--car", "car.toml",
        "--free-mass", "chassis", "--free-mass", "tire", "--json", "e.json",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    masses = {p["name"]: p for p in json.loads((files / "e.json").read_text())["parameters"] if p["unit"] == "kg"}
    assert abs(masses["chassis.mass"]["value"] - 350) < 5 * masses["chassis.mass"]["std"]
    assert masses["chassis.mass"]["std"] < 10


def test_names_of_the_file_are_mapped(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    text = (files / "rig.csv").read_text().replace("chassis_acceleration", "az [m/s2]", 1)
    (files / "rig.csv").write_text(text)
    options = ["--rename", "az=chassis_acceleration", "--json", "e.json"]
    result = run("estimate", "rig.csv", "--given", "road", "--car", "car.toml", *options)
    assert result.exit_code == 0, result.output
    assert holds(json.loads((files / "e.json").read_text()))


@pytest.fixture
def rested(files: Path) -> Path:
    """A folder with a decay in millimetres that begins after a second of rest."""
    record = free_decay(CAR, TIMES, initial_state={"v_tire": 1.0, "z_chassis": 0.02})
    rows = np.concatenate([np.zeros((2, 200)), record.outputs], axis=1)
    rows = 1e3 * rows + 0.2 * np.random.default_rng(5).standard_normal(rows.shape)
    table = np.column_stack([0.005 * np.arange(rows.shape[1]), *rows])
    np.savetxt(files / "rested.csv", table, delimiter=",", header="time [s],chassis [mm],tire (mm)", comments="")
    return files


class TestUnitsAndRest:
    def test_names_with_units_are_read_in_si_and_the_rest_is_left_out(
        self, rested: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(rested)
        result = run("estimate", "rested.csv", "--car", "car.toml", "--json", "e.json")
        assert result.exit_code == 0, result.output
        assert "channel 'tire' was converted from mm to m" in result.stderr
        assert "used from 1 s on" in result.stdout
        assert holds(json.loads((rested / "e.json").read_text()))

    def test_a_report_takes_the_same_names(self, rested: Path) -> None:
        found = analyse(rested / "rested.csv", car=NOMINAL)
        assert set(found.modes.channels) == {"chassis", "tire"}
        best = found.estimate or found.reconstruction
        assert best is not None
        assert best.explains
        errors = {s.name: s.stiffness / TRUTH[f"{s.name}.stiffness"] - 1 for s in best.suspension.struts}
        assert all(abs(error) < 0.02 for error in errors.values()), errors

    @pytest.mark.slow
    def test_a_unit_that_is_not_stated_is_a_doubt(self, files: Path) -> None:
        """Road in mm, motion in m/s2: the springs that would be needed are a thousand times softer."""
        options = ["--given", "road", "--scale", "road=1000", "--car", files / "car.toml"]
        result = run("estimate", files / "rig.csv", *options)
        assert "care." in result.stdout or "doubtful." in result.stdout, result.output
        assert "More than 3 times larger or smaller than nominal" in result.stdout

    def test_a_channel_of_force_is_a_cause(self, files: Path) -> None:
        push = 300 * np.sin(2 * np.pi * (0.5 + 2 * TIMES) * TIMES)
        outputs = ["chassis_acceleration", "tire_acceleration"]
        model = statespace(CAR, outputs=outputs, forces=["chassis"])
        moved = control.forced_response(model, TIMES, push).outputs
        moved = moved + 0.02 * np.random.default_rng(2).standard_normal(moved.shape)
        table = np.column_stack([TIMES, push, *moved])
        header = "time [s],chassis_force [N],chassis_acceleration [m/s2],tire_acceleration [m/s2]"
        np.savetxt(files / "pushed.csv", table, delimiter=",", header=header, comments="")
        result = run("estimate", files / "pushed.csv", "--car", files / "car.toml", "--json", files / "e.json")
        assert result.exit_code == 0, result.output
        assert "chassis_force was taken as the cause, as --given chassis_force does" in result.stderr
        assert "motion of chassis_force" not in result.stderr
        assert holds(json.loads((files / "e.json").read_text()))

    def test_a_force_of_another_name_is_told_how_to_be_named(self, files: Path) -> None:
        table = np.column_stack([TIMES, np.sin(TIMES), np.cos(TIMES), np.sin(9 * TIMES)])
        header = "time [s],shaker [kN],chassis_acceleration [m/s2],tire_acceleration [m/s2]"
        np.savetxt(files / "pushed.csv", table, delimiter=",", header=header, comments="")
        result = run("estimate", files / "pushed.csv", "--car", files / "car.toml", "--given", "shaker")
        assert result.exit_code == 1
        assert "channel 'shaker [kN]' is a force and was not used" in result.stderr
        assert "'chassis_force' one mass, 'chassis_travel_force' the ends of a strut apart" in result.stderr
        assert "--rename 'shaker [kN]'=chassis_force" in result.stderr


def test_a_car_that_does_not_explain_ends_with_three(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    # The tyre's mass is five times what the nominal car has.
    write_car(NOMINAL.with_parameters(masses={"tire": 10}), files / "wrong.toml")
    result = run("estimate", "rig.csv", "--given", "road", "--car", "wrong.toml", "-o", "found.toml")
    assert result.exit_code == 3, result.output
    assert "does not explain these records" in result.stderr
    assert (files / "found.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["decay.csv", "decay.csv"], 2, "named twice"),
        (["decay.csv", "--json", "decay.csv"], 2, "name it decay.json"),
        (["rig.csv", "--given", "rod"], 1, "--given: 'rod' is no road ('road')"),
        (["decay.csv", "--fixed", "tyre"], 1, "--fixed: there is no strut parameter"),
        (
            ["decay.csv", "--free-mass", "chassis", "--free-mass", "tire"],
            1,
            "fix one with --fixed …, state --nominal-std",
        ),
        (["decay.csv", "--given", "road"], 1, "the record has no input or channel 'road'"),
        (["decay.csv", "--plot", "e.xyz"], 1, "pictures of type '.xyz' are not known"),
        (["decay.csv", "--page", "e.doc"], 1, "reports are written as .html"),
        (["decay.csv", "--added", "other.csv:chassis=1"], 2, "is not one of the MODES"),
        (["missing.csv"], 1, "there is no such file"),
    ],
)
def test_wrong_requests_leave_nothing(
    files: Path, arguments: list[str], code: int, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(files)
    before = sorted(path.name for path in files.iterdir())
    result = run("estimate", *arguments, "--car", "car.toml")
    assert result.exit_code == code, result.output
    assert message in result.output
    assert sorted(path.name for path in files.iterdir()) == before


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a drive, the same with its wheel's sensor upside down, with names exchanged, and with it dead."""
    folder = tmp_path_factory.mktemp("drive")
    write_car(NOMINAL, folder / "car.toml")
    times, rng = np.arange(0, 10, 0.005), np.random.default_rng(1)
    # Nothing above 40 Hz: samples at 200 Hz hold it all.
    rough = np.convolve(0.003 * np.cumsum(rng.standard_normal(times.size)), np.hanning(13) / 6, "same")
    names = ["chassis_acceleration", "tire_acceleration"]
    record = simulate(CAR, times, {"road": rough}, outputs=names, interpolation="cubic")
    rows = add_noise(record, snr_db=40, rng=rng).outputs
    for name, body, wheel in (
        ("drive", rows[0], rows[1]), ("reversed", rows[0], -rows[1]), ("exchanged", rows[1], rows[0]),
        ("dead", rows[0], 0 * rows[1]),
    ):  # fmt: skip
        table = np.column_stack([times, body, wheel])
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(["time [s]", *names]), comments="")
    return folder


class TestDrive:
    @pytest.mark.parametrize("options", [[], ["--given", "wheels"], ["--given", "tire"]])
    def test_the_first_command_works(self, drive: Path, options: list[str]) -> None:
        done = run("estimate", drive / "drive.csv", "--car", drive / "car.toml", "--json", drive / "e.json", *options)
        assert done.exit_code == 0, done.output
        assert holds({"parameters": self.struts(drive)})
        assert ("as --given tire does" in done.stderr) is (not options)

    @staticmethod
    def struts(drive: Path) -> list[dict[str, object]]:
        every = json.loads((drive / "e.json").read_text())["parameters"]
        return [one for one in every if one["name"] in TRUTH]

    def test_the_report_shows_springs_and_dampers(self, drive: Path) -> None:
        options = ["--car", drive / "car.toml", "-o", drive / "page.html", "--json", drive / "e.json"]
        done = run("report", drive / "drive.csv", *options)
        assert done.exit_code == 0, done.output
        assert "springs, dampers and 1 mode" in done.output
        assert "chassis.stiffness" in (drive / "page.html").read_text()
        assert holds({"parameters": self.struts(drive)})

    def test_what_is_known_of_the_sensors_is_held(self, drive: Path) -> None:
        known = [word for option in ("--gain", "--delay", "--mount") for word in (option, "none")]
        done = run("estimate", drive / "drive.csv", "--car", drive / "car.toml", *known, "--json", drive / "e.json")
        names = [one["name"] for one in json.loads((drive / "e.json").read_text())["parameters"]]
        assert names == ["chassis.stiffness", "chassis.damping"], done.output

    @pytest.mark.parametrize(
        ("name", "said"),
        [
            ("reversed", "With the sign of tire_acceleration reversed the car explains the records"),
            pytest.param("exchanged", "acceleration exchanged the car explains the records", marks=pytest.mark.slow),
            ("dead", "channel 'tire_acceleration' from 0 to 9.995 s: constant at 0"),
        ],
    )
    def test_what_is_wrong_with_a_sensor_is_said(self, drive: Path, name: str, said: str) -> None:
        done = run("estimate", drive / f"{name}.csv", "--car", drive / "car.toml", "--given", "wheels")
        assert done.exit_code == 1, done.output
        assert said in done.output
        # Of options, not of arguments of functions.
        assert "=…" not in done.output

    def test_a_drive_that_is_taken_for_a_decay_is_told(self, drive: Path) -> None:
        done = run("estimate", drive / "drive.csv", "--car", drive / "car.toml", "--given", "none")
        assert done.exit_code == 3, done.output
        assert "The motion does not decay" in done.output
        assert "doubtful." in done.output
        assert "(--given …)" in done.output


def test_a_wheel_without_a_tire(tmp_path: Path) -> None:
    write_car(NOMINAL.with_parameters(stiffness={"tire": 0.0}), tmp_path / "car.toml")
    rough = 0.01 * np.cumsum(np.random.default_rng(1).standard_normal(TIMES.size))
    record = simulate(CAR, TIMES, {"road": rough}, outputs=["chassis_acceleration", "tire_acceleration"])
    write_record(add_noise(record, snr_db=40, rng=np.random.default_rng(2)), tmp_path / "drive.csv")
    done = run("estimate", tmp_path / "drive.csv", "--car", tmp_path / "car.toml", "--given", "tire")
    assert "chassis.damping" in done.output, done.output


def test_a_channel_in_another_unit_is_named(tmp_path: Path) -> None:
    write_car(NOMINAL, tmp_path / "car.toml")
    rough = 0.002 * np.cumsum(np.random.default_rng(1).standard_normal(TIMES.size))
    record = simulate(CAR, TIMES, {"road": rough}, outputs=["chassis_acceleration", "tire_acceleration"])
    write_record(add_noise(record, snr_db=40, rng=np.random.default_rng(2)), tmp_path / "drive.csv")
    options = ["--car", tmp_path / "car.toml", "--given", "tire"]
    done = run("estimate", tmp_path / "drive.csv", *options, "--scale", "tire_acceleration=0.2")
    assert "Gains far from 1: tire_acceleration.gain = 0." in done.output
    assert "Gains far" not in run("estimate", tmp_path / "drive.csv", *options).output


def test_limits_are_judged_and_stand_on_the_page(files: Path) -> None:
    """The truth is 22 N/mm and 1300 N s/m: one limit holds it, the other does not."""
    (files / "limits.toml").write_text(
        '[struts.chassis]\nstiffness = { min = 20, max = 24, unit = "N/mm" }\ndamping = { min = 1400 }\n'
    )
    page = files / "page.html"
    result = run("estimate", files / "decay.csv", "--car", files / "car.toml", "--limits", files / "limits.toml",
                 "--page", page, "--json", files / "judged.json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    plain = json.loads((files / "judged.json").read_text(encoding="utf-8"))
    jsonschema.validate(plain, json_schema("estimate"))
    assert [(one["name"], one["unit"], one["most"], one["state"]) for one in plain["limits"]] == [
        ("chassis.stiffness", "N/m", 24e3, "met"), ("chassis.damping", "N s/m", None, "not met"),
    ]  # fmt: skip
    assert "1 of 2 limits met, 1 not met" in result.stdout
    assert "1 of 2 limits met, 1 not met" in page.read_text(encoding="utf-8")


def test_a_report_of_two_cars_does_not_call_their_decays_driven(files: Path) -> None:
    """A third of the damping is lost between two tests: no car has both, and no motion of a wheel caused them."""
    names = []
    for name, share in (("before", 1.0), ("after", 2 / 3)):
        car = CAR.with_parameters(damping={"chassis": 900.0 * share})
        record = free_decay(car, np.arange(0, 4, 0.005), initial_state={"v_chassis": 0.6, "v_tire": -1.0})
        noisy = add_noise(record, snr_db=40, rng=np.random.default_rng(len(name)))
        write_record(noisy, files / f"{name}.csv")
        names.append(files / f"{name}.csv")
    result = run("report", *names, "--car", files / "car.toml", "-o", files / "p.html")
    assert result.exit_code == 0, result.output
    assert "taken as the cause" not in result.stderr
    assert "something changed between them" in (files / "p.html").read_text(encoding="utf-8")
    found = run("estimate", *names, "--car", files / "car.toml")
    assert "taken as the cause" not in found.stderr
    assert "The records are not of one car" in found.stdout


@pytest.mark.slow
def test_a_report_of_a_drive_that_comes_to_a_halt_leads_with_springs_and_dampers(files: Path) -> None:
    """A drive that dies down may be a decay; its bursts are poor ones, and the measured cause explains it all."""
    times = np.arange(0, 16, 0.01)
    slowing = np.clip((15 - times) / 8, 0, 1)
    heights = 0.004 * np.cumsum(np.random.default_rng(3).standard_normal(len(times))) * 0.2
    heights = slowing * (heights - np.convolve(heights, np.full(200, 1 / 200), "same"))
    record = simulate(CAR, times, {"road": heights}, outputs=["chassis_acceleration", "tire_acceleration"])
    noise = 0.05 * np.random.default_rng(4).standard_normal((2, len(times)))
    header = "time [s],chassis_acceleration [m/s2],tire_acceleration [m/s2]"
    table = np.column_stack([times, *(np.asarray(record.y) + noise)])
    np.savetxt(files / "halt.csv", table, delimiter=",", header=header, comments="")
    result = run(
        "report", files / "halt.csv", "--car", files / "car.toml", "-o", files / "p.html", "--json", files / "e.json"
    )
    assert result.exit_code == 0, result.output
    assert "no clear free decay was found: the motion of tire was taken as the cause" in result.stderr
    assert holds({"parameters": json.loads((files / "e.json").read_text())["parameters"][:1]})


def test_the_sensors_that_the_help_describes_can_be_read(tmp_path: Path) -> None:
    said = run("estimate", "--help").output
    lines = [line.strip() for line in said.splitlines()]
    first = lines.index("[sensors]")
    car = half_car(
        chassis_mass=600, pitch_inertia=900, front_tire_mass=40, rear_tire_mass=40, cg_to_front=1.25, cg_to_rear=1.25,
        front_stiffness=21e3, rear_stiffness=22e3, front_tire_stiffness=190e3, rear_tire_stiffness=190e3,
        front_damping=1350, rear_damping=1350,
    )  # fmt: skip
    write_car(car, tmp_path / "car.toml")
    lines.append("")
    example = "\n".join(lines[first : lines.index("", first)]).replace(", left = 0.4", "")
    (tmp_path / "car.toml").write_text((tmp_path / "car.toml").read_text() + "\n" + example + "\n")
    sensors = {sensor.name: sensor for sensor in read_car(tmp_path / "car.toml").sensors}
    assert set(sensors) == {"az_seat", "damper_pot", "lift"}
    manual = (Path(__file__).parents[1] / ".manual/tasks.md").read_text(encoding="utf-8")
    assert all(line in manual for line in lines[first + 1 : lines.index("", first)])


def test_a_channel_of_the_car_on_a_slower_clock_is_interpolated(files: Path) -> None:
    """Two columns of time: the body's logger has 200 Hz, that of the wheel 250 Hz."""
    fine = np.arange(0, 4, 0.001)
    road = 0.005 * np.sin(2 * np.pi * (0.5 + 2 * fine) * fine)
    names = ["chassis_acceleration", "tire_acceleration"]
    body, wheel = np.asarray(simulate(CAR, fine, {"road": road}, outputs=names).outputs)
    rng, rows = np.random.default_rng(1), len(fine[::4])
    table = np.full((rows, 4), np.nan)
    for column, (values, step, std) in enumerate(((body, 5, 0.03), (wheel, 4, 0.1))):
        shown = values[::step] + std * rng.standard_normal(len(values[::step]))
        table[: len(shown), 2 * column], table[: len(shown), 2 * column + 1] = fine[::step], shown
    cells = [",".join("" if np.isnan(x) else f"{x:.6g}" for x in row) for row in table]
    head = "time_a [s],chassis_acceleration,time_b [s],tire_acceleration"
    (files / "two.csv").write_text("\n".join([head, *cells]) + "\n")
    done = run(
        "estimate", files / "two.csv", "--car", files / "car.toml", "--given", "wheels", "--json", files / "e.json"
    )
    assert "interpolated onto 250 Hz" in done.output
    found = {one["name"]: one for one in json.loads((files / "e.json").read_text())["parameters"]}
    assert found["chassis.stiffness"]["value"] == pytest.approx(22e3, rel=0.1)
