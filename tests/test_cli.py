"""The command: its results, its exit codes, and what it leaves behind."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import eigenmodes
from suspid.cleaning.read_record import read_record
from suspid.cli.main import main
from suspid.model.car_files import read_car

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
EXAMPLES = ROOT / "examples"
CAR, NOMINAL, RECORD = EXAMPLES / "car.toml", EXAMPLES / "nominal_car.toml", EXAMPLES / "quarter_car.csv"
RECIPE = ["--fs", "500", "--duration", "10", "--initial", "v_tire=1", "--snr", "20", "--seed", "2011", "--digits", "5"]


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


class TestFromRecordToSprings:
    def test_the_committed_record_is_what_simulate_makes(self, tmp_path: Path) -> None:
        result = run("simulate", CAR, "-o", tmp_path / "r.csv", *RECIPE)
        assert result.exit_code == 0, result.output
        made, committed = read_record(tmp_path / "r.csv"), read_record(RECORD)
        # Other processors round the exponentials otherwise, in the last printed digit.
        np.testing.assert_allclose(made.y, committed.y, rtol=1.1e-4, atol=1e-12)
        assert made.time.tolist() == committed.time.tolist()
        assert RECORD.stat().st_size < 400_000

    def test_there_and_back(self, tmp_path: Path) -> None:
        found = run("identify", RECORD, "--modes", 3, "--json", tmp_path / "m.json", "--plot", tmp_path / "p.png")
        assert found.exit_code == 0, found.output
        for heading in ("f [Hz]", "wn [rad/s]", "zeta [1]", "±", "noise std", "5000 samples at 500 Hz"):
            assert heading in found.stdout
        assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
        content = json.loads((tmp_path / "m.json").read_text())
        truth = eigenmodes(read_car(CAR))
        for mode, wn, zeta in zip(content["modes"], truth.wn, truth.zeta, strict=True):
            # Five standard deviations: one false alarm in two million.
            assert abs(mode["wn_rad_per_s"] - wn) < 5 * mode["wn_std_rad_per_s"]
            assert abs(mode["zeta"] - zeta) < 5 * mode["zeta_std"]
        back = run("reconstruct", tmp_path / "m.json", NOMINAL, "-o", tmp_path / "car.toml")
        assert back.exit_code == 0, back.output
        assert "stiffness [N/m]" in back.stdout
        for strut, true in zip(read_car(tmp_path / "car.toml").struts, read_car(CAR).struts, strict=True):
            assert strut.stiffness == pytest.approx(true.stiffness, rel=0.01)  # the record has 20 dB of noise
        assert sorted(p.name for p in tmp_path.iterdir()) == ["car.toml", "m.json", "p.png"]

    def test_exact_modes_give_the_car_back(self, tmp_path: Path) -> None:
        assert run("modes", CAR, "--json", tmp_path / "m.json").exit_code == 0
        result = run("reconstruct", tmp_path / "m.json", NOMINAL, "-o", tmp_path / "car.toml")
        assert result.exit_code == 0, result.output
        for strut, true in zip(read_car(tmp_path / "car.toml").struts, read_car(CAR).struts, strict=True):
            assert strut.stiffness == pytest.approx(true.stiffness, rel=1e-5)  # what reconstruct promises
            assert strut.damping == pytest.approx(true.damping, rel=1e-5)

    def test_the_ridge_method_shows_its_windows(self) -> None:
        result = run("identify", RECORD, "--method", "ridge", "--modes", 3)
        assert result.exit_code == 0, result.output
        for heading in ("ridge [rad/s]", "from [s]", "to [s]"):
            assert heading in result.stdout

    def test_the_band_is_in_hertz(self, tmp_path: Path) -> None:
        result = run("identify", RECORD, "--band", 6, 10, "--modes", 1, "--json", tmp_path / "m.json")
        assert result.exit_code == 0, result.output
        (mode,) = json.loads((tmp_path / "m.json").read_text())["modes"]
        assert mode["frequency_hz"] == pytest.approx(eigenmodes(read_car(CAR)).wn[1] / (2 * np.pi), rel=0.01)  # noise

    @pytest.mark.skipif(not DATA.exists(), reason="no shared data")
    @pytest.mark.slow
    def test_a_measured_structure(self, tmp_path: Path) -> None:
        file = DATA / "vibtest_inout_mat" / "case1.mat"
        result = run("identify", file, "--channel", "Time_chan_2", "--fs", 1280, "--json", tmp_path / "m.json")
        assert result.exit_code == 0, result.output
        modes = json.loads((tmp_path / "m.json").read_text())["modes"]
        nearest = min(modes, key=lambda mode: abs(mode["frequency_hz"] - 212.1))
        assert abs(nearest["frequency_hz"] - 212.1) < 0.1  # five other methods scatter by 0.02 Hz
        assert 8e-4 < nearest["zeta"] < 1e-3

    def test_a_mode_above_half_the_rate_is_said(self, tmp_path: Path) -> None:
        result = run("simulate", CAR, "-o", tmp_path / "r.csv", "--fs", 20, "--impulse", "road")
        assert result.exit_code == 0
        assert "suspid: warning: a mode at 13.34 Hz lies above half the sampling rate" in result.stderr


class TestExitCodes:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (("identify", "none.csv"), "none.csv: there is no such file"),
            (("identify", EXAMPLES), "is a folder"),
            (("identify", CAR), "is a description, as of a car or of limits, and not a record"),
            (("identify", "none.json"), "none.json: there is no such file"),
            (("identify", "none.unknown"), "none.unknown: there is no such file"),
            (("identify", RECORD, "--channel", "seta"), "no channel 'seta'. Did you mean 'seat'"),
            (("identify", RECORD, "--time", "clock"), "no time column 'clock'"),
            (("identify", RECORD, "--fs", "1e-16"), "disagree"),
            (("identify", RECORD, "--band", "300", "400"), "band"),
            (("identify", RECORD, "--modes", "40"), "found|stand"),
            (("identify", RECORD, "--plot", "p.xyz"), "pictures of type '.xyz' are not known"),
            (("identify", RECORD, "--plot", "p"), "pictures of type '' are not known"),
            (("identify", RECORD, "--json", "none/m.json"), "m.json: cannot be written: there is no folder"),
            (("identify", RECORD, "--json", "."), "is a folder"),
            (("reconstruct", "none.json", CAR), "none.json: there is no such file"),
            (("reconstruct", RECORD, CAR), "is not JSON"),
            (("modes", RECORD), "is no description of a car"),
            (("simulate", CAR, "-o", "r.txt", "--impulse", "road"), "written as .csv"),
            (("simulate", CAR, "-o", "r.csv", "--impulse", "raod"), "no input 'raod'. Did you mean 'road'"),
            (("simulate", CAR, "-o", "r.csv", "--initial", "v_tyre=1"), "no state 'v_tyre'. Did you mean 'v_tire'"),
            (("simulate", CAR, "-o", "r.csv", "--impulse", "road", "--channel", "sead"), "no output 'sead'"),
        ],
    )
    def test_refused_with_one_line(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[object, ...], message: str
    ) -> None:
        monkeypatch.chdir(tmp_path)
        result = run(*arguments)
        assert result.exit_code == 1, result.output
        assert result.stdout == ""
        lines = result.stderr.splitlines()
        assert len(lines) == 1
        assert lines[0].startswith("suspid: error: ")
        assert any(part in lines[0] for part in message.split("|"))
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize(
        "arguments",
        [
            ("fly",),
            ("identify",),
            ("identify", RECORD, "--fs", "0"),
            ("identify", RECORD, "--fs", "nan"),
            ("identify", RECORD, "--fs", "fast"),
            ("identify", RECORD, "--modes", "0"),
            ("identify", RECORD, "--band", "5", "2"),
            ("identify", RECORD, "--method", "magic"),
            ("simulate", CAR, "-o", "r.csv"),
            ("simulate", CAR, "--impulse", "road"),
            ("simulate", CAR, "-o", "r.csv", "--impulse", "road", "--initial", "v_tire=1"),
            ("simulate", CAR, "-o", "r.csv", "--initial", "v_tire"),
            ("simulate", CAR, "-o", "r.csv", "--initial", "v_tire=fast"),
            ("simulate", CAR, "-o", "r.csv", "--initial", "v_tire=1", "--initial", "v_tire=2"),
            ("simulate", CAR, "-o", "r.csv", "--impulse", "road", "--snr", "20"),
            ("simulate", CAR, "-o", "r.csv", "--impulse", "road", "--duration", "1e12"),
        ],
    )
    def test_usage(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[object, ...]) -> None:
        monkeypatch.chdir(tmp_path)
        result = run(*arguments)
        assert result.exit_code == 2, result.output
        assert "Error:" in result.stderr
        assert list(tmp_path.iterdir()) == []


def write_test(path: Path, masses: dict[str, float], *, std: float | None = None, car: Path = CAR) -> Path:
    """Write the exact poles of the car with these masses, known to ``std`` (relative)."""
    modes = eigenmodes(read_car(car).with_parameters(masses=masses))
    entries = [
        {"wn_rad_per_s": wn, "zeta": zeta} for wn, zeta in zip(modes.wn.tolist(), modes.zeta.tolist(), strict=True)
    ]
    if std is not None:
        entries = [e | {"wn_std_rad_per_s": std * e["wn_rad_per_s"], "zeta_std": std * e["zeta"]} for e in entries]
    path.write_text(json.dumps({"modes": entries}))
    return path


class TestSeveralTestsGiveTheCar:
    def test_options_reach_reconstruct(self, tmp_path: Path) -> None:
        empty = write_test(tmp_path / "empty.json", {}, std=1e-4)
        loaded = write_test(tmp_path / "loaded.json", {"seat": 260.0}, std=1e-4)
        (tmp_path / "nominal.toml").write_text(NOMINAL.read_text().replace("seat = 200.0", "seat = 220.0"))
        result = run(
            *("reconstruct", empty, loaded, tmp_path / "nominal.toml", "--added", f"{loaded}:seat=60"),
            *("--free-mass", "seat", "--bound", "tire.stiffness", 6e5, 1.2e6, "--level", 0.9),
            *("--json", tmp_path / "found.json", "-o", tmp_path / "found.toml"),
        )
        assert result.exit_code == 0, result.output
        for heading in ("90 % interval", "lower", "upper", "tire.damping [N s/m]", "seat.mass [kg]"):
            assert heading in result.stdout
        true, found = read_car(CAR), read_car(tmp_path / "found.toml")
        assert found.masses["seat"] == pytest.approx(200.0, rel=1e-4)  # the modes are exact
        for strut, truth in zip(found.struts, true.struts, strict=True):
            assert strut.stiffness == pytest.approx(truth.stiffness, rel=1e-4)
        content = json.loads((tmp_path / "found.json").read_text())
        assert content["format"] == "suspid car 1"
        by_name = {entry["name"]: entry for entry in content["parameters"]}
        assert by_name["seat.mass"]["unit"] == "kg"
        assert by_name["tire.stiffness"]["unit"] == "N/m"
        assert content["explains"] is True
        assert content["level"] == 0.9
        assert content["freedom"] == 12 - 7  # two numbers of six poles; six of the struts and a mass
        variances = np.diag(content["covariance"])
        for entry, variance in zip(content["parameters"], variances, strict=True):
            assert entry["std"] == pytest.approx(variance**0.5, rel=1e-12)  # the same number
            # 1.6449: the 95 % point of the normal distribution.
            assert entry["upper"] - entry["value"] <= 1.6449 * entry["std"] * (1 + 1e-4)

    def test_what_is_fixed_and_tied_stays_so(self, tmp_path: Path) -> None:
        test = write_test(tmp_path / "m.json", {})
        nominal = NOMINAL.read_text().replace("damping = 80.0", "damping = 100.0")
        (tmp_path / "n.toml").write_text(nominal.replace("stiffness = 300e3", "stiffness = 390e3"))
        options = ("--fixed", "tire.damping", "--no-search", "--json", tmp_path / "f.json", "--tolerance", 0.5)
        result = run("reconstruct", test, tmp_path / "n.toml", *options, "--tie", "seat.damping=chassis.damping")
        assert result.exit_code == 0, result.output
        content = json.loads((tmp_path / "f.json").read_text())
        assert content["held"] == [{"name": "tire.damping", "value": 100.0, "unit": "N s/m"}]
        values = {entry["name"]: entry["value"] for entry in content["parameters"]}
        assert values["seat.damping"] == pytest.approx(values["chassis.damping"], rel=1e-12)  # one unknown
        assert content["covariance"] is None
        assert content["parameters"][0]["std"] is None

    def test_alternatives_are_written_with_their_distances(self, tmp_path: Path) -> None:
        test = write_test(tmp_path / "m.json", {}, std=1e-4, car=EXAMPLES / "hatchback.toml")
        result = run("reconstruct", test, EXAMPLES / "hatchback.toml", "--json", tmp_path / "f.json")
        assert result.exit_code == 0, result.output
        others = json.loads((tmp_path / "f.json").read_text())["alternatives"]
        assert len(others) == result.stdout.count("another suspension has these modes")
        assert others  # poles alone leave a chain of three masses open
        for other in others:
            assert other["distance"] >= 0
            assert set(other["parameters"]) >= {"seat.stiffness", "tire.damping"}

        alone = run("reconstruct", test, EXAMPLES / "hatchback.toml", "--no-search")
        assert alone.exit_code == 0, alone.output
        assert "another suspension" not in alone.stdout

    def test_a_bound_is_not_passed(self, tmp_path: Path) -> None:
        test, out = write_test(tmp_path / "m.json", {}), tmp_path / "f.json"
        options = ("--bound", "tire.stiffness", 9e5, "inf", "--tolerance", 0.5, "--no-search", "--json", out)
        result = run("reconstruct", test, NOMINAL, *options)
        assert result.exit_code == 0, result.output
        values = {entry["name"]: entry["value"] for entry in json.loads(out.read_text())["parameters"]}
        assert values["tire.stiffness"] >= 9e5 * (1 - 1e-6)  # the car has 8e5; 1e-6 is the solver's accuracy

    def test_a_wrong_mass_ends_with_3(self, tmp_path: Path) -> None:
        empty = write_test(tmp_path / "empty.json", {}, std=1e-4)
        loaded = write_test(tmp_path / "loaded.json", {"seat": 260.0}, std=1e-4)
        out = tmp_path / "f.json"
        result = run("reconstruct", empty, loaded, NOMINAL, "--added", f"{loaded}:seat=50", "--json", out)
        assert result.exit_code == 3, result.output
        assert result.stderr.count("suspid: warning: the car that was found does not explain these modes") == 1
        assert json.loads(out.read_text())["explains"] is False

    @pytest.mark.parametrize(
        ("options", "code", "message"),
        [
            (("--added", "m.json:sead=60"), 1, "there is no mass 'sead'. Did you mean 'seat'"),
            (("--added", "x.json:seat=60"), 2, "not one of the MODES"),
            (("--added", "m.json:seat"), 2, "write FILE:NAME=KG"),
            (("--added", "seat=1", "--added", "m.json:seat=2"), 2, "already"),
            (("--added", "seat=-1"), 1, "must be a finite mass"),
            (("--bound", "tire.stifness", 1, 2), 1, "no parameter 'tire.stifness'. Did you mean 'tire.stiffness'"),
            (("--bound", "tire.stiffness", 2, 1), 1, "low must be below high"),
            (("--tie", "seat.damping"), 2, "write A=B"),
            (("--tie", "seat.damping=tyre.damping"), 1, "no parameter 'tyre.damping'"),
            (("--fixed", "tyre"), 1, "no strut parameter 'tyre'"),
            (("--free-mass", "sead"), 1, "no mass 'sead'"),
            (("--nominal-std", 0), 2, "positive"),
            (("--level", 1), 2, "--level"),
            (("--level", 0.9, "--json", "f.json"), 1, "carried no covariance"),
            (("--json", "n.toml"), 2, "name it n.json"),
            (("--json", "m.json"), 2, "named twice"),
            (("-o", "n.toml"), 2, "named twice"),
            (("-o", "car.json"), 2, "a car is written as TOML; name it car.toml"),
        ],
    )
    def test_refused_clearly(
        self,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
        options: tuple[object, ...],
        code: int,
        message: str,
    ) -> None:
        monkeypatch.chdir(tmp_path)
        write_test(Path("m.json"), {})
        Path("n.toml").write_text(NOMINAL.read_text())
        before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
        result = run("reconstruct", "m.json", "n.toml", *options)
        assert result.exit_code == code, result.output
        assert message in " ".join(result.stderr.split())
        assert code == 2 or len(result.stderr.splitlines()) == 1
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


class TestNothingHalfWritten:
    def test_an_existing_file_survives_a_failure(self, tmp_path: Path) -> None:
        (tmp_path / "m.json").write_text("kept")
        assert run("identify", tmp_path / "none.csv", "--json", tmp_path / "m.json").exit_code == 1
        assert (tmp_path / "m.json").read_text() == "kept"
        assert [p.name for p in tmp_path.iterdir()] == ["m.json"]

    def test_an_output_that_cannot_be_written_is_found_before_the_record_is_read(self, tmp_path: Path) -> None:
        result = run("identify", tmp_path / "none.csv", "--json", tmp_path / "none" / "m.json")
        assert "m.json: cannot be written" in result.stderr

    def test_a_link_is_followed_and_a_device_is_written_to(self, tmp_path: Path) -> None:
        (tmp_path / "link.json").symlink_to(tmp_path / "m.json")
        assert run("modes", CAR, "--json", tmp_path / "link.json").exit_code == 0
        assert (tmp_path / "link.json").is_symlink()
        assert json.loads((tmp_path / "m.json").read_text())["format"] == "suspid modes 1"
        assert run("modes", CAR, "--json", os.devnull).exit_code == 0
        assert not Path(os.devnull).is_file()


class TestTextFromFiles:
    def test_escape_sequences_do_not_reach_the_terminal(self, tmp_path: Path) -> None:
        record = read_record(RECORD)
        rows = "".join(f"{t!r},{v!r}\n" for t, v in zip(record.time.tolist(), record.y[0].tolist(), strict=True))
        path = tmp_path / "r.csv"
        path.write_text("t,[2Jseat\u202e\n" + rows)
        result = run("identify", path)
        assert result.exit_code == 0, result.output
        assert "[2Jseat\\u202e" in result.stdout
        path.write_text("t,\x1b[2Jseat\n0,1\n1,up\n")
        refused = run("identify", path)
        for text in (result.stdout, refused.stderr):
            assert "\x1b" not in text
            assert "\u202e" not in text


class TestAsAProcess:
    def test_help_imports_none_of_the_heavy_libraries(self) -> None:
        code = (
            "import sys\nfrom suspid.cli import main\n"
            "try: main(['--help'])\n"
            "except SystemExit as end: assert end.code == 0\n"
            "heavy = {'control', 'cvxpy', 'matplotlib', 'pywt', 'scipy.signal', 'scipy.stats', 'scipy.io'}\n"
            "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=1800)
        assert done.returncode == 0, done.stderr
        assert "identify" in done.stdout

    def test_a_terminal_without_plus_minus_and_an_empty_home(self, tmp_path: Path) -> None:
        environment = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "PYTHONIOENCODING": "iso8859_5"}
        command = [sys.executable, "-c", "from suspid.cli import main; main()", "identify", str(RECORD)]
        done = subprocess.run(command, capture_output=True, env=environment, timeout=1800)
        assert done.returncode == 0, done.stderr
        assert b"\\xb1" in done.stdout
        assert done.stderr == b""


class TestNothingIsOverwritten:
    def test_an_input_is_no_output(self, tmp_path: Path) -> None:
        record = tmp_path / "my.json"
        record.write_text("time,seat\n" + "".join(f"{k / 100},{np.exp(-k / 50) * np.cos(k / 3)}\n" for k in range(300)))
        before = record.read_bytes()
        run = CliRunner().invoke(main, ["identify", str(record), "--json", str(record)])
        assert run.exit_code == 2
        assert "named twice" in run.output
        assert record.read_bytes() == before

    def test_from_and_to_cut_the_record(self, tmp_path: Path) -> None:
        record = tmp_path / "my.csv"
        record.write_text("time,seat\n" + "".join(f"{k / 100},{np.exp(-k / 50) * np.cos(k / 3)}\n" for k in range(300)))
        run = CliRunner().invoke(main, ["identify", str(record), "--from", "0.5", "--to", "2"])
        assert run.exit_code == 0
        assert "from t = 0.5 s" in run.output
        assert "151 samples" in run.output
