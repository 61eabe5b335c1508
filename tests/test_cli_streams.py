"""Pipes: ``-`` is the standard input of every command that reads, and the standard output of those that write data."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from suspid import eigenmodes, read_car, write_modes
from suspid.cli import main

RECORD, CAR = Path("examples/quarter_car.csv"), Path("examples/car.toml")


def run(line: str, given: bytes | None = None) -> Result:
    return CliRunner().invoke(main, line.split(), input=given)


@pytest.fixture(scope="module")
def modes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("modes") / "modes.json"
    write_modes(eigenmodes(read_car(CAR)), path)
    return path


class TestInput:
    @pytest.mark.parametrize("command", ["modes {}", "grip {}", "ride {} --road C --speed 20"])
    def test_a_car_that_is_piped_gives_what_its_file_gives(self, command: str) -> None:
        piped = run(command.format("-"), CAR.read_bytes())
        assert piped.exit_code == 0, piped.output
        assert piped.stdout == run(command.format(CAR)).stdout

    def test_modes_or_a_car_may_be_piped(self, modes: Path) -> None:
        expected = run(f"reconstruct {modes} {CAR}").stdout
        assert run(f"reconstruct - {CAR}", modes.read_bytes()).stdout == expected
        assert run(f"reconstruct {modes} -", CAR.read_bytes()).stdout == expected
        assert "no value changed" in run(f"compare - {modes}", modes.read_bytes()).stdout

    @pytest.mark.usefixtures("words_alone")
    def test_a_car_beside_a_record(self, tmp_path: Path) -> None:
        written = run(f"report {RECORD} --car - --modes 3 -o {tmp_path / 'page.html'}", CAR.read_bytes())
        assert written.exit_code == 0, written.output

    def test_there_is_one_standard_input(self, modes: Path) -> None:
        twice = run("compare - -", modes.read_bytes())
        assert twice.exit_code == 2
        assert "read once" in twice.stderr

    def test_messages_name_the_standard_input(self) -> None:
        assert run("modes -", RECORD.read_bytes()).stderr.startswith("suspid: error: standard input: is not TOML")
        assert "standard input: is a description" in run("identify -", CAR.read_bytes()).stderr
        assert "standard input is a car" in run("ride -", CAR.read_bytes()).stderr

    def test_without_room_for_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def full(*_: object) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(Path, "write_bytes", full)
        told = run("modes -", CAR.read_bytes())
        assert told.exit_code == 1
        assert "the standard input cannot be kept in a temporary file: No space left on device" in told.stderr


class TestOutput:
    def test_json_stands_alone(self) -> None:
        found = run(f"modes {CAR} --json -")
        assert json.loads(found.stdout)["format"] == "suspid modes 1"
        assert "zeta" in found.stderr

    def test_a_record_and_a_car(self, modes: Path) -> None:
        record = run(f"simulate {CAR} -o - --initial v_tire=1 --duration 1")
        assert record.stdout.startswith("time")
        assert "500 samples" in run("channels -", record.stdout_bytes).stdout.replace("      ", " ") + record.stderr
        assert "[masses]" in run(f"reconstruct {modes} {CAR} -o -").stdout

    def test_nothing_is_written_after_an_error(self) -> None:
        assert run("modes nowhere.toml --json -").stdout == ""

    def test_pages_and_pictures_have_a_name(self) -> None:
        assert "choose such a name" in run(f"report {RECORD} -o -").stderr
        assert "known: " in run(f"identify {RECORD} --plot -").stderr

    @pytest.mark.skipif(not os.path.exists("/dev/stdout"), reason="the system has no such name")
    def test_the_name_of_the_standard_output_behind_a_pipe(self) -> None:
        line = [sys.executable, "-m", "suspid", "modes", str(CAR), "--json", "/dev/stdout"]
        found = subprocess.run(line, capture_output=True, check=False)
        assert found.returncode == 0, found.stderr
        assert found.stdout.startswith(b"{")


class TestClosed:
    """Streams that were closed before the start, as by `>&-`, cost no file and end in no traceback."""

    COMMAND = f"{sys.executable} -m suspid modes {CAR}"

    def test_output(self, tmp_path: Path) -> None:
        file = tmp_path / "modes.json"
        shell = f"{self.COMMAND} --json {file} >&-"
        told = subprocess.run(shell, shell=True, stderr=subprocess.PIPE, text=True, check=False)
        assert (told.returncode, told.stderr) == (0, "")
        assert len(json.loads(file.read_text())["modes"]) == 3

    def test_input(self) -> None:
        shell = f"{sys.executable} -m suspid identify - <&-"
        told = subprocess.run(shell, shell=True, stderr=subprocess.PIPE, text=True, check=False)
        assert told.returncode == 2
        assert "is empty: pipe a file into it, or name a file" in told.stderr


@pytest.mark.slow
def test_a_backend_of_matplotlib_that_does_not_exist_draws_files(tmp_path: Path) -> None:
    picture = tmp_path / "modes.png"
    command = [sys.executable, "-m", "suspid", "identify", str(RECORD), "--to", "3", "--plot", str(picture)]
    subprocess.run(command, env=os.environ | {"MPLBACKEND": "nosuch"}, capture_output=True, check=True)
    assert picture.stat().st_size > 0
