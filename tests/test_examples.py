"""Every example runs as a user runs it, says what it should, and writes nothing beside itself."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
PNG = b"\x89PNG\r\n\x1a\n"


def run(script: str, folder: Path, *arguments: str) -> str:
    """Return what an example prints, run in a folder of its own without a display."""
    settings = {"MPLBACKEND": "Agg", "PYTHONWARNINGS": "error", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / script), *arguments],
        cwd=folder,
        env=os.environ | settings | {"TMPDIR": str(folder)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class TestEveryExample:
    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_runs_and_leaves_the_examples_as_they_are(self, script: Path, tmp_path: Path) -> None:
        before = {path: path.stat().st_mtime_ns for path in EXAMPLES.iterdir()}
        assert run(script.name, tmp_path)
        assert {path: path.stat().st_mtime_ns for path in EXAMPLES.iterdir()} == before

    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_is_short(self, script: Path) -> None:
        assert len(script.read_text(encoding="utf-8").splitlines()) < 60

    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_uses_what_is_public(self, script: Path) -> None:
        imports = [line for line in script.read_text(encoding="utf-8").splitlines() if line.startswith("from suspid")]
        assert imports
        assert {line.split()[1] for line in imports} <= {"suspid"}


class TestWhatTheyShow:
    def test_quickstart_finds_the_modes_within_two_percent(self, tmp_path: Path) -> None:
        assert "all 6 values pass" in run("quickstart.py", tmp_path)

    @pytest.mark.parametrize("script", ["paper_steps.py", "measured_file.py"])
    def test_without_a_name_the_picture_goes_to_the_temporary_folder(self, script: str, tmp_path: Path) -> None:
        said = run(script, tmp_path)
        (picture,) = tmp_path.glob("*/*.png")
        assert f"drawn to {picture}" in said
        assert picture.read_bytes().startswith(PNG)

    def test_the_picture_goes_where_the_command_line_says(self, tmp_path: Path) -> None:
        run("paper_steps.py", tmp_path, "steps.png")
        run("measured_file.py", tmp_path, str(EXAMPLES / "quarter_car.csv"), "page.png")
        assert sorted(path.name for path in tmp_path.iterdir()) == ["page.png", "steps.png"]

    def test_denoising_raises_the_damping_of_the_mode_that_dies_first(self, tmp_path: Path) -> None:
        rows = [line.split() for line in run("denoising.py", tmp_path).splitlines()[2:]]
        second_mode = {(int(row[0]), row[2]): float(row[6]) for row in rows}
        scatter = {(int(row[0]), row[2]): float(row[8]) for row in rows}
        for snr in (20, 12):
            # Three standard deviations of a mean of ten: what noise alone does less than once in 300 runs.
            assert abs(second_mode[snr, "raw"]) < 3 * scatter[snr, "raw"] / 10**0.5
            assert second_mode[snr, "denoised"] > 3 * scatter[snr, "denoised"] / 10**0.5

    def test_a_worn_damper_is_seen(self, tmp_path: Path) -> None:
        pytest.importorskip("pyarrow")
        assert "chassis.damping falls" in run("fleet.py", tmp_path)

    def test_three_drops_are_found_and_agree(self, tmp_path: Path) -> None:
        said = run("long_recording.py", tmp_path, "page.html")
        starts = sorted(float(line.split()[1]) for line in said.splitlines()[2:5])
        # Where the car was dropped, within a tenth of a second: forcing there is none.
        assert starts == pytest.approx([6.0, 15.0, 25.0], abs=0.1)
        assert "disagree" not in said
        assert (tmp_path / "page.html").read_text(encoding="utf-8").startswith("<!doctype html>")
