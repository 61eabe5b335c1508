"""From files as they come to modes and reports, on the command line; and every way in which a file can be wrong."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import Settings, Suspension, add_noise, analyse, eigenmodes, free_decay, quarter_car, statespace
from suspid.cleaning import Finding
from suspid.cli.main import main
from suspid.cli.measured import said_of
from suspid.io.formats import READERS
from suspid.io.write_record import write_record
from suspid.model.car_files import write_car
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.words import LeftOut, Remark

pytestmark = pytest.mark.usefixtures("words_alone")

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
RECORD = ROOT / "examples" / "quarter_car.csv"
RATE = 100.0


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def car() -> Suspension:
    return quarter_car(
        chassis_mass=320, tire_mass=38, chassis_stiffness=18e3, tire_stiffness=190e3, chassis_damping=1300
    )


def acceleration(car: Suspension, seconds: float, starts: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return times and the chassis' acceleration, released at each start from 35 mm down."""
    times = np.arange(round(seconds * RATE)) / RATE
    system = statespace(car, outputs=["chassis_acceleration"])
    values = np.zeros(times.size)
    for start in starts:
        after = times >= start - 1e-9
        released = free_decay(system, np.arange(after.sum()) / RATE, initial_state={"z_chassis": -0.035})
        values[after] += np.ravel(released.y)
    return times, values


def modes_in(path: Path) -> list[dict[str, float]]:
    modes: list[dict[str, float]] = json.loads(path.read_text(encoding="utf-8"))["modes"]
    return modes


def holds(car: Suspension, modes: list[dict[str, float]], which: tuple[int, ...]) -> None:
    """Check that each mode lies within five standard deviations of the car's."""
    truth = eigenmodes(car)
    assert len(modes) == len(which)
    for mode, k in zip(modes, which, strict=True):
        assert abs(mode["wn_rad_per_s"] - truth.wn[k]) < 5 * mode["wn_std_rad_per_s"]
        assert abs(mode["zeta"] - truth.zeta[k]) < 5 * mode["zeta_std"]


class TestFilesAsTheyCome:
    def test_a_dirty_file(self, car: Suspension, tmp_path: Path) -> None:
        """Banner, units in brackets, rounded stamps, a missing cell, a sentinel: told, mended, and within intervals."""
        times = np.arange(600) / 240.0
        system = statespace(car, outputs=["chassis", "tire"])
        clean = free_decay(system, times, initial_state={"v_tire": 1.0})
        noisy = as_signal(add_noise(clean, snr_db=40, rng=np.random.default_rng(3))).values * 1e3
        lines = ["Logger 7.2;serial 00412", "", "time [s];chassis [mm];tire [mm]"]
        rows = [[f"{t:.3f}", f"{a:.5f}", f"{b:.5f}"] for t, a, b in zip(times, *noisy, strict=True)]
        rows[200][1], rows[300][2] = "", "-9999"
        path = tmp_path / "dirty.csv"
        path.write_text("\n".join([*lines, *(";".join(row).replace(".", ",") for row in rows)]) + "\n")
        result = run("identify", path, "--json", tmp_path / "m.json")
        assert result.exit_code == 0, result.output
        holds(car, modes_in(tmp_path / "m.json"), (0, 1))
        for said in ("rounded stamps", "missing", "sentinel", "Logger"):
            assert said in result.stderr, result.stderr

    @pytest.mark.slow
    def test_a_phone_on_a_pushed_car(self, car: Suspension, tmp_path: Path) -> None:
        """Tilted by 12 degrees, gravity in it, stamps to a millisecond, half a minute before the first release."""
        times, motion = acceleration(car, 70.0, (31.2, 52.7))
        rng = np.random.default_rng(4)
        up = np.array([np.sin(0.21), 0.0, np.cos(0.21)])
        three = up[:, None] * (9.81 + motion) + 0.015 * rng.standard_normal((3, times.size))
        stamps = np.round(times + rng.normal(0, 2e-4, times.size), 3)
        path = tmp_path / "phone.csv"
        header = '"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)"\n'
        rows = (f"{t:.3f},{x:.6E},{y:.6E},{z:.6E}\n" for t, x, y, z in zip(stamps, *three, strict=True))
        path.write_text(header + "".join(rows))
        page, modes = tmp_path / "r.html", tmp_path / "r.json"
        axes = "Acceleration x,Acceleration y,Acceleration z"
        result = run("report", path, "-o", page, "--json", modes, "--vertical", axes, "--date", "2026-01-01")
        assert result.exit_code == 0, result.output
        assert "largest motion" in result.stderr
        content = json.loads(modes.read_text(encoding="utf-8"))
        assert content["channels"] == ["vertical"]
        assert any(decay["used"] for decay in content["decays"])
        body = min(content["modes"], key=lambda mode: mode["wn_rad_per_s"])
        truth = eigenmodes(car)
        assert abs(body["wn_rad_per_s"] - truth.wn[0]) < 5 * body["wn_std_rad_per_s"]
        assert abs(body["zeta"] - truth.zeta[0]) < 5 * body["zeta_std"]
        assert "suspid report" in page.read_text(encoding="utf-8")

    def test_a_car_gives_springs(self, car: Suspension, tmp_path: Path) -> None:
        times = np.arange(800) / 200.0
        clean = free_decay(statespace(car, outputs=["chassis", "tire"]), times, initial_state={"v_tire": 1.0})
        record = add_noise(clean, snr_db=40, rng=np.random.default_rng(5))
        signal = as_signal(record)
        write_record(as_response(times, 1e3 * signal.values, ["z_c", "z_t"]), tmp_path / "r.parquet")
        write_car(car, tmp_path / "car.toml")
        wanted = ["--rename", "z_c=chassis", "--rename", "z_t=tire", "--scale", "z_c=0.001", "--scale", "z_t=0.001"]
        result = run("report", tmp_path / "r.parquet", "-o", tmp_path / "r.html", "--car", tmp_path / "car.toml",
                     "--json", tmp_path / "r.json", *wanted)  # fmt: skip
        assert result.exit_code == 0, result.output
        found = json.loads((tmp_path / "r.json").read_text())["reconstruction"]
        assert found is not None
        assert "Springs and dampers" in (tmp_path / "r.html").read_text(encoding="utf-8")

    def test_two_names_cannot_be_one(self) -> None:
        result = run("identify", RECORD, "--rename", "seat=tire")
        assert result.exit_code == 1
        assert "two channels of the same name" in result.stderr

    def test_a_channel_can_be_left_out(self) -> None:
        result = run("identify", RECORD, "--without", "seat")
        assert "2 channels: chassis, tire" in result.stdout
        refused = run("identify", RECORD, "--without", "saet")
        assert refused.exit_code == 1
        assert "'seat'" in refused.stderr


class TestChannels:
    def test_names_units_rates_lengths_and_gaps(self, tmp_path: Path) -> None:
        path = tmp_path / "r.csv"
        path.write_text("t [ms];seat [mm];note\n0;1;a\n10;2;b\n30;3;c\n40;4;d\n")
        result = run("channels", path)
        assert result.exit_code == 0, result.output
        row = next(line.split() for line in result.stdout.splitlines() if "seat" in line)
        assert row == ["seat", "[mm]", "mm", "100", "4", "0.04", "1"]
        assert "note" in result.stdout


def nothing(path: Path) -> None:
    assert not path.exists()


def folder(path: Path) -> None:
    path.mkdir()


def unreadable(path: Path) -> None:
    path.write_text("t,a\n0,1\n1,2\n")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")


def written(content: bytes) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_bytes(content)

    return write


def rows(*lines: str, count: int = 200) -> Callable[[Path], None]:
    """Write a header and for each sample k a line: ``{t}`` is k / 100, ``{back}`` falls and rises, ``{y}`` decays."""

    def write(path: Path) -> None:
        values = np.exp(-np.arange(count) / 60) * np.cos(np.arange(count) / 3)
        body = [
            lines[1].format(t=k / 100, y=round(float(y), 9), back=abs(count // 2 - k) / 100)
            for k, y in enumerate(values)
        ]
        path.write_text("\n".join([lines[0], *body]) + "\n")

    return write


RUBBISH = bytes(np.random.default_rng(1).integers(0, 256, 4096, dtype=np.uint8))
BAD: dict[str, tuple[str, Callable[[Path], None], list[object], str]] = {
    "empty": ("r.csv", written(b""), [], "is empty"),
    "one line": ("r.csv", written(b"t,seat\n"), [], "line"),
    "constant": ("r.csv", rows("t,seat", "{t},3.5"), [], "constant"),
    "all not a number": ("r.csv", rows("t,seat", "{t},nan"), [], "seat"),
    "time backwards": ("r.csv", rows("t,seat", "{back},{y}"), [], "time"),
    "time stands still": ("r.csv", rows("t,seat", "1.0,{y}"), [], "stamps"),
    "unknown channel": ("r.csv", rows("t,seat,tire", "{t},{y},{y}"), ["--channel", "saet"], "'seat'"),
    "no rate": ("r.csv", rows("seat,tire", "{y},{y}"), [], "rate"),
    "folder": ("r.csv", folder, [], "folder"),
    "unreadable": ("r.csv", unreadable, [], "cannot be read"),
    "not there": ("r.csv", nothing, [], "no such file"),
    "unknown type": ("r.xyz", written(b"\x01\x02\x03"), [], "known"),
    "no text": ("r.csv", written(b"t,seat\n\x00\x01\x02\n" * 20), [], "text"),
    **{f"rubbish{suffix}": (f"r{suffix}", written(RUBBISH), [], "r") for suffix in READERS},
    **{f"empty{suffix}": (f"r{suffix}", written(b""), [], "is empty") for suffix in READERS},
    **{f"text as{suffix}": (f"r{suffix}", written(b"t,seat\n0,1\n1,2\n" * 40), [], "r") for suffix in READERS
       if suffix not in (".csv", ".txt", ".tsv", ".dat")},
}  # fmt: skip


class TestBadInput:
    @pytest.mark.parametrize("name", BAD)
    def test_one_clear_line_and_nothing_written(self, name: str, tmp_path: Path) -> None:
        file, make, options, said = BAD[name]
        path = tmp_path / "in" / file
        path.parent.mkdir()
        make(path)
        out = tmp_path / "out"
        out.mkdir()
        for command in (["identify", path], ["report", path, "-o", out / "r.html", "--json", out / "r.json"]):
            result = run(*command, *options)
            errors = [line for line in result.stderr.splitlines() if not line.startswith("suspid: warning: ")]
            assert result.exit_code == 1, result.output
            assert len(errors) == 1, errors
            assert errors[0].startswith("suspid: error: ")
            assert said in errors[0]
            assert "Traceback" not in result.output
            assert not list(out.iterdir())

    def test_a_rate_of_zero(self) -> None:
        result = run("identify", RECORD, "--fs", "0")
        assert result.exit_code == 2
        assert "positive" in result.stderr

    def test_an_output_that_cannot_be_written(self, tmp_path: Path) -> None:
        result = run("report", RECORD, "-o", tmp_path / "no folder" / "r.html")
        assert result.exit_code == 1
        assert "cannot be written" in result.stderr

    def test_an_output_of_another_kind(self, tmp_path: Path) -> None:
        result = run("report", RECORD, "-o", tmp_path / "r.docx")
        assert result.exit_code == 1
        assert ".html" in result.stderr

    def test_the_input_is_never_overwritten(self) -> None:
        assert run("report", RECORD, "-o", "r.html", "--json", RECORD).exit_code == 2


@pytest.mark.skipif(not DATA.is_dir(), reason="needs records made by others")
@pytest.mark.slow
class TestRecordsOfOthers:
    def test_a_measured_ring_down(self, tmp_path: Path) -> None:
        path = DATA / "vibtest_inout_mat" / "case1.mat"
        assert run("identify", path, "--json", tmp_path / "m.json").exit_code == 0
        modes = modes_in(tmp_path / "m.json")
        # Five established methods say 212.08 to 212.12 Hz and 8.5e-4 to 9.3e-4.
        assert modes[0]["frequency_hz"] == pytest.approx(212.10, abs=0.02)
        assert modes[0]["zeta"] == pytest.approx(8.9e-4, abs=4e-5)
        assert modes[1]["frequency_hz"] == pytest.approx(579.0, abs=0.1)

    def test_a_simulated_seat(self, tmp_path: Path) -> None:
        path = DATA / "rizoit_seat3dof_sim" / "release.csv"
        assert run("identify", path, "--json", tmp_path / "m.json").exit_code == 0
        found = [mode["frequency_hz"] for mode in modes_in(tmp_path / "m.json")]
        assert found == pytest.approx([1.2521928521, 2.6343486141, 9.5142367929], rel=1e-4)

    @pytest.mark.slow
    def test_a_car_at_rest_has_no_mode_beyond_doubt(self) -> None:
        # Between 31 and 42 s something moves the body, at 3.3 Hz: whether it is a mode, nobody measured.
        data = DATA / "css_canedge_car_mf4"
        path = next(data.glob("stationary*.MF4"))
        axes = [f"Acceleration{axis}" for axis in "XYZ"]
        result = run("identify", path, "--dbc", data / "canmod-gps.dbc", *(x for a in axes for x in ("--channel", a)))
        assert result.exit_code == 0, result.output
        assert "no mode" in result.stdout or "doubtful. Do not use it" in result.stdout

    def test_a_running_machine_has_a_line_and_it_is_no_mode(self, tmp_path: Path) -> None:
        path = next((DATA / "pyuff_uff58_mps").glob("MPSTD*.uff"))
        result = run("identify", path, "--json", tmp_path / "m.json", "--from", 0, "--to", 8)
        assert result.exit_code == 0, result.output
        assert "tone" in result.stdout
        if "no mode" not in result.stdout:
            assert all(abs(mode["frequency_hz"] - 181.74) > 1.0 for mode in modes_in(tmp_path / "m.json"))


class TestMessages:
    def test_errors_about_a_file_begin_with_its_name(self, tmp_path: Path) -> None:
        path = tmp_path / "two.csv"
        path.write_text("t,seat\n0,1\n0.01,2\n", encoding="utf-8")
        result = run("identify", path)
        assert result.exit_code == 1
        assert result.stderr.startswith(f"suspid: error: {path}: the record has 2 samples")

    @pytest.mark.parametrize("wrong", [("--from", "nan"), ("--to", "inf"), ("--from", "3", "--to", "2")])
    def test_times_that_cannot_be_meant_are_usage_errors(self, wrong: tuple[str, ...]) -> None:
        result = run("identify", RECORD, *wrong)
        assert result.exit_code == 2
        assert wrong[0] in result.stderr

    def test_a_file_without_time_names_the_options(self, tmp_path: Path) -> None:
        path = tmp_path / "r.csv"
        path.write_text("seat,tire\n" + "1,2\n3,5\n" * 40, encoding="utf-8")
        result = run("channels", path)
        assert result.exit_code == 1
        assert "--time" in result.stderr
        assert "--fs" in result.stderr

    def test_long_lists_of_names_are_cut_and_have_no_time(self, tmp_path: Path) -> None:
        path = tmp_path / "r.csv"
        names = [f"ch{k:03d}" for k in range(300)]
        rows = [",".join(f"{np.sin(i + k):.3f}" for i in range(301)) for k in range(3)]
        path.write_text("\n".join([",".join(["t", *names]), *rows]), encoding="utf-8")
        result = run("identify", path, "--channel", "nope")
        assert "'ch009' and 290 others" in result.stderr
        assert "'t'" not in result.stderr
        assert "'ch010'" not in result.stderr

    def test_a_band_beyond_half_the_rate_is_said_in_hertz(self) -> None:
        assert "the band 3000 … 4000 Hz" in run("identify", RECORD, "--band", "3000", "4000").stderr

    def test_few_findings_are_warned_of_and_the_others_counted(self) -> None:
        found = analyse(RECORD)
        things = tuple((f"row {k}", Remark(LeftOut.EMPTY)) for k in range(9))
        assert found.recording is not None
        one = Finding(remark=Remark(LeftOut.EMPTY), channel="seat", start=0.0, stop=1.0, samples=2, repaired=True)
        findings = (one,) * 9
        many = replace(
            found,
            recording=replace(found.recording, left_out=things),
            cleaned=replace(found.cleaned, findings=findings),
        )
        brief = said_of(many, most_left_out=3, most_findings=5)
        assert len(brief) == 3 + 1 + 5 + 1
        assert "6 more" in brief[3]
        assert brief[9] == "4 further findings; `suspid report` lists all"
        assert len(said_of(many)) == 18
        chosen = replace(many, settings=Settings(channels=("seat",)))
        assert len(said_of(chosen)) == 9

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
    def test_an_output_that_is_full_is_one_line(self) -> None:
        with open("/dev/full", "w", encoding="utf-8") as full:
            told = subprocess.run(
                [sys.executable, "-m", "suspid", "channels", str(RECORD)],
                stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        assert told.returncode == 1
        assert told.stderr.startswith("suspid: error: the output cannot be written")
        assert told.stderr.count("\n") == 1

    def test_no_summary_of_a_command_is_cut(self) -> None:
        shown = run("--help").stdout
        assert "..." not in shown.split("Commands:")[1]
        assert "Exit codes" in shown


def test_the_standard_input_is_called_so_everywhere(tmp_path: Path) -> None:
    """It is kept in a file while the command runs, whose name and place nobody needs."""
    page, plain = tmp_path / "r.html", tmp_path / "r.json"
    content = RECORD.read_bytes()
    shown = CliRunner().invoke(main, ["report", "-", "-o", str(page), "--json", str(plain)], input=content)
    assert shown.exit_code == 0, shown.output
    for text in (shown.output, page.read_text(encoding="utf-8"), plain.read_text(encoding="utf-8")):
        assert "standard input" in text
        assert "standard input." not in text.replace("standard input. ", "")
        assert "suspid-" not in text


def test_frequencies_are_no_time(tmp_path: Path) -> None:
    file = tmp_path / "frf.csv"
    rows = "".join(f"{k / 10},{(k * 7) % 11},{(k * 5) % 13}\n" for k in range(1, 300))
    file.write_text(f"Freq,mag,phase\n{rows}", encoding="utf-8")
    for options in ([], ["--time", "Freq"]):
        refused = CliRunner().invoke(main, ["identify", str(file), *options])
        assert refused.exit_code == 1
        assert "'Freq' holds frequencies" in refused.output
        assert "export the time histories" in refused.output


def test_temperatures_are_not_called_angles(tmp_path: Path) -> None:
    file = tmp_path / "warm.csv"
    rows = "".join(f"{k / 100},{np.exp(-k / 100) * np.cos(k / 5)},{60 + (k % 7) / 10}\n" for k in range(400))
    file.write_text(f"time [s],seat [mm],oil [°C]\n{rows}", encoding="utf-8")
    channels = ["--channel", "seat", "--channel", "oil"]
    said = CliRunner().invoke(main, ["identify", str(file), "--si", *channels]).stderr
    assert "the unit '°C' is one of temperature" in said
    assert "Did you mean '°'" not in said


def test_without_a_mode_the_record_that_is_needed_is_said(tmp_path: Path) -> None:
    """Noise has no mode: the last line says what to record. A decay has one, and nothing of the kind is said."""
    times = np.arange(400) / RATE
    noise = np.random.default_rng(3).standard_normal(times.size)
    for name, values, needed in [("noise", noise, True), ("decay", np.exp(-times) * np.cos(20 * times), False)]:
        path = tmp_path / f"{name}.csv"
        rows = "\n".join(f"{t:.2f},{y:.6f}" for t, y in zip(times, values + 1e-3 * noise, strict=True))
        path.write_text(f"time [s],seat [mm]\n{rows}\n", encoding="utf-8")
        result = run("identify", path)
        assert result.exit_code == 0
        assert ("Next: Record a free decay" in result.stdout.splitlines()[-1]) == needed
