"""Every example runs as a user runs it, says what it should, and writes nothing beside itself."""

import contextlib
import io
import json
import os
import re
import runpy
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
PNG = b"\x89PNG\r\n\x1a\n"
# Guards against hanging alone: the longest takes some 5 s where nothing else runs.
HANGS = 1800


def run(script: str, folder: Path, *arguments: str) -> str:
    """Return what an example prints, run in a folder of its own without a display."""
    settings = {"MPLBACKEND": "Agg", "PYTHONWARNINGS": "error", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / script), *arguments],
        cwd=folder,
        env=os.environ | settings | {"TMPDIR": str(folder)},
        capture_output=True,
        text=True,
        timeout=HANGS,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def run_here(script: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return what an example prints in this process, which has the library already; warnings are errors in it too."""
    import matplotlib.pyplot as plt

    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [str(script)])
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        runpy.run_path(str(script), run_name="__main__")
    plt.close("all")
    return said.getvalue()


def finds_the_modes_within_two_percent(said: str) -> None:
    assert "all 6 values pass" in said


def draws_to_the_temporary_folder(said: str) -> None:
    picture = re.search(r"drawn to (\S+)", said)
    assert picture
    assert Path(picture[1]).read_bytes().startswith(PNG)


def raises_the_damping_of_the_mode_that_dies_first(said: str) -> None:
    rows = {row[0]: row for row in (line.split() for line in said.splitlines()[2:])}
    second_mode, scatter = ({name: float(row[at]) for name, row in rows.items()} for at in (4, 6))
    # Three standard deviations of a mean of ten: what noise alone does less than once in 300 runs.
    assert abs(second_mode["raw"]) < 3 * scatter["raw"] / 10**0.5
    assert second_mode["denoised"] > 3 * scatter["denoised"] / 10**0.5


def sees_the_worn_damper(said: str) -> None:
    assert "chassis.damping falls" in said


def finds_three_drops_that_agree(said: str) -> None:
    _, _, rows = said.partition("\n----")
    starts = sorted(float(line.split()[1]) for line in rows.splitlines()[1:4])
    # Where the car was dropped, within a tenth of a second: nothing else moves it.
    assert starts == pytest.approx([6.0, 15.0, 25.0], abs=0.1)
    # Three drops of one car with linear springs agree.
    assert "Verdict: 2 modes found: sound." in said
    page = re.search(r"page written to (\S+)", said)
    assert page
    assert Path(page[1]).read_text(encoding="utf-8").startswith("<!doctype html>")


def finds_springs_and_dampers_from_a_drive(said: str) -> None:
    # 99.9 % intervals of two parameters, twice.
    assert said.count("both intervals hold") == said.count(": True") == 2
    draws_to_the_temporary_folder(said)


def has_errors_of_the_size_that_is_stated(said: str) -> None:
    size = re.search(r"160 errors, of size (\S+);", said)
    assert size
    # The root mean square of 160 normal errors has a standard deviation of 6 %; four per record share a noise.
    assert float(size[1]) == pytest.approx(1.0, abs=0.25)


def finds_the_damper_on_both_roads(said: str) -> None:
    ends = re.findall(r"road \w: c between (\d+) and (\d+)", said)
    assert len(ends) == 2
    assert all(float(low) <= 1300 <= float(high) for low, high in ends)


# What an example must say or write, beyond running; each runs once, for some take seconds.
SHOWS: dict[str, Callable[[str], None]] = {
    "quickstart": finds_the_modes_within_two_percent,
    "paper_steps": draws_to_the_temporary_folder,
    "measured_file": draws_to_the_temporary_folder,
    "seat_controller": draws_to_the_temporary_folder,
    "denoising": raises_the_damping_of_the_mode_that_dies_first,
    "fleet": sees_the_worn_damper,
    "driven_car": finds_springs_and_dampers_from_a_drive,
    "how_the_likelihood_works": has_errors_of_the_size_that_is_stated,
    "how_the_road_cancels": finds_the_damper_on_both_roads,
    "long_recording": finds_three_drops_that_agree,
}


class TestEveryExample:
    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_runs_shows_its_point_and_leaves_the_examples_as_they_are(
        self, script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        if script.stem == "fleet":
            pytest.importorskip("pyarrow")
        before = {path: path.stat().st_mtime_ns for path in EXAMPLES.iterdir()}
        # Workers of a fleet import the script again; the first one is run as a user runs it.
        own = script.stem in ("fleet", "quickstart")
        said = run(script.name, tmp_path) if own else run_here(script, tmp_path, monkeypatch)
        assert said
        assert {path: path.stat().st_mtime_ns for path in EXAMPLES.iterdir()} == before
        if script.stem in SHOWS:
            SHOWS[script.stem](said)

    @pytest.mark.slow
    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_runs_by_itself(self, script: Path, tmp_path: Path) -> None:
        if script.stem == "fleet":
            pytest.importorskip("pyarrow")
        assert run(script.name, tmp_path)

    def test_names_what_only_examples_that_are_there_show(self) -> None:
        assert set(SHOWS) <= {path.stem for path in SCRIPTS}

    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_is_short(self, script: Path) -> None:
        _, _, code = script.read_text(encoding="utf-8").split('"""', 2)
        assert len(code.splitlines()) < 60

    @pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
    def test_uses_what_is_public(self, script: Path) -> None:
        imports = [line for line in script.read_text(encoding="utf-8").splitlines() if line.startswith("from suspid")]
        assert imports
        assert {line.split()[1] for line in imports} <= {"suspid"}


class TestNotebooks:
    @pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
    def test_every_cell_runs(
        self, notebook: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.chdir(EXAMPLES.parent)
        content = json.loads(notebook.read_text(encoding="utf-8"))
        cells = ["".join(cell["source"]) for cell in content["cells"] if cell["cell_type"] == "code"]
        names: dict[str, object] = {}
        for cell in cells:
            exec(compile(cell, notebook.name, "exec"), names)
        assert "Verdict" in capsys.readouterr().out
        # What a cell printed is not kept: it would age.
        assert not any(cell.get("outputs") for cell in content["cells"])


class TestPicture:
    @pytest.mark.slow
    def test_goes_where_the_command_line_says(self, tmp_path: Path) -> None:
        run("measured_file.py", tmp_path, str(EXAMPLES / "quarter_car.csv"), "page.png")
        assert [path.name for path in tmp_path.iterdir()] == ["page.png"]
