"""The README holds: its script runs, its commands are those that CI calls, its figures are those of the reports."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import suspid
from suspid import read_car
from suspid.cli import main

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block_after(marker: str) -> str:
    found = re.search(rf"<!-- {marker} -->\n```\w+\n(.*?)```", README, flags=re.S)
    assert found, marker
    return found[1]


def test_the_row_of_simulate_runs(tmp_path: Path) -> None:
    """What a table of the README shows as a command runs as it stands, with files in place of the capitals."""
    row = re.search(r"`(suspid simulate CAR -o FILE[^`]*)`", README)
    assert row
    words = row[1].replace("CAR", str(ROOT / "examples/car.toml")).replace("FILE", str(tmp_path / "r.csv")).split()
    made = CliRunner().invoke(main, words[1:])
    assert made.exit_code == 0, made.output
    assert (tmp_path / "r.csv").stat().st_size > 10_000


class TestScript:
    def test_nine_lines(self) -> None:
        # A call that is broken over two lines for reading counts as one.
        statements = [line for line in block_after("script").splitlines() if not line.startswith(" ")]
        assert len(statements) == 8
        assert len(block_after("script").splitlines()) == 9

    def test_runs_and_finds_the_car(self) -> None:
        run = subprocess.run(
            [sys.executable, "-W", "error", "-c", block_after("script")], capture_output=True, text=True, check=True
        )
        assert "21.27" in run.stdout
        assert "seat" in run.stdout

    def test_from_arrays_it_finds_the_same_car(self) -> None:
        assert len(block_after("from arrays").splitlines()) <= 9
        run = subprocess.run(
            [sys.executable, "-W", "error", "-c", block_after("from arrays")],
            capture_output=True, text=True, check=True, cwd=ROOT,
        )  # fmt: skip
        truth = read_car(ROOT / "examples/car.toml")
        rows = dict(re.findall(r"^ *(\w+) +([\d.]+) +[\d.]+ +[\d.]+ +[\d.]+$", run.stdout, flags=re.M))
        for strut in truth.struts:
            # Six of the standard deviations that the table states: 47, 200 and 510 N/m.
            assert float(rows[strut.name]) == pytest.approx(strut.stiffness, rel=0.004)


class TestMatlab:
    """Who knows a verb of MATLAB finds ours by its name, in the table of the README or the longer one of the manual."""

    ROWS = re.findall(
        r"^\| (`.*?) \| (.*) \|$",
        README[README.index("## Coming from MATLAB") :] + (ROOT / ".manual/more_of_matlab.inc").read_text("utf-8"),
        flags=re.M,
    )

    @pytest.mark.parametrize(
        "verb",
        [
            "modalfit",
            "modalsd",
            "modalfrf",
            "greyest",
            "idgrey",
            "wdenoise",
            "cwt",
            "compare",
            "resid",
            "present",
            "tfest",
            "damp",
            "bode",
            "lsim",
        ],
    )
    def test_a_verb_has_its_row(self, verb: str) -> None:
        assert [row for row, _ in self.ROWS if re.search(rf"`{verb}\b", row)]

    def test_what_stands_there_is_public(self) -> None:
        names = {name for _, here in self.ROWS for name in re.findall(r"(?<![.\w])`([a-z_]+)[`(]", here)}
        assert {"identify", "estimate", "statespace"} <= names
        assert names <= {*suspid.__all__, "print"}


class TestCommands:
    def test_the_main_job_is_on_a_record_of_the_project(self) -> None:
        record = re.search(r"suspid identify (\S+)", block_after("main job"))
        assert record
        assert (ROOT / record[1]).is_file()

    def test_ci_reads_the_test_command(self) -> None:
        assert "pytest" in block_after("tests")
        assert "README.md" in (ROOT / ".ci/run").read_text(encoding="utf-8")


class TestFigures:
    def test_accuracy_rows_are_those_of_the_report(self) -> None:
        report = (ROOT / "validation/report/accuracy.md").read_text(encoding="utf-8")
        rows = [line for line in README.splitlines() if re.match(r"\| (paper's car|hatchback|saloon|van)", line)]
        assert len(rows) == 6
        for row in rows:
            name, right, largest, coverage = (cell.strip() for cell in row.strip("|").split("|"))
            bare = re.sub(r" \(zeta [^)]*\)", "", name)
            theirs = next(line for line in report.splitlines() if line.startswith(f"| {bare} "))
            cells = [cell.strip() for cell in theirs.strip("|").split("|")]
            assert [right, largest, coverage] == [cells[2], cells[3], cells[5]]

    def test_linked_files_are_there(self) -> None:
        for target in re.findall(r"\]\(([^)#]+)\)", README):
            if not target.startswith("http"):
                assert (ROOT / target).exists(), target

    def test_the_springs_are_those_of_the_report(self) -> None:
        report = (ROOT / "validation/report/springs.md").read_text(encoding="utf-8")
        rows = re.findall(r"\s(\d\.\d\d)\s+(\d+)%\n", report)
        assert len(rows) == 18
        said = re.search(r"at most (\d\.\d\d) for every k and c, (\d+) to (\d+) %", README.replace("\n", " "))
        assert said
        assert float(said[1]) == max(float(ratio) for ratio, _ in rows)
        assert [int(said[2]), int(said[3])] == [f([int(share) for _, share in rows]) for f in (min, max)]

    def test_the_estimates_are_those_of_the_report(self) -> None:
        report = (ROOT / "validation/report/greybox.md").read_text(encoding="utf-8")
        start = README.index("| record | RMSE | RMSE/bound |")
        rows = README[start : README.index("\n\n", start)].splitlines()[2:]
        assert len(rows) == 10
        for row in rows:
            name, *figures = (cell.strip() for cell in row.strip("|").split("|"))
            theirs = next(line for line in report.splitlines() if line.strip().startswith(f"{name}  "))
            _, draws, failed, _, _, error, ratio, coverage, *_ = re.split(r"\s{2,}", theirs.strip())
            largest = [max(re.split(r", | to ", cell), key=float) for cell in (error, ratio)]
            assert int(draws) >= 100
            assert failed == "0"
            assert figures == [f"{largest[0]} %", largest[1], coverage.replace("%", " %")]

    def test_the_peers_are_those_of_the_report(self) -> None:
        report = (ROOT / "validation/report/peers.md").read_text(encoding="utf-8")
        theirs = [
            [cell.strip() for cell in line.strip("|").split("|")] for line in report.splitlines() if line[:1] == "|"
        ]
        start = README.index("| method | given |")
        rows = README[start : README.index("\n\n", start)].splitlines()[2:]
        assert len(rows) == 7
        for row in rows:
            _, given, *figures = (cell.strip() for cell in row.strip("|").split("|"))
            assert [given, *figures] in [[cells[1], *cells[3:]] for cells in theirs if len(cells) == 7], row

    def test_the_time_is_that_of_the_report(self) -> None:
        report = (ROOT / "validation/report/speed.md").read_text(encoding="utf-8")
        theirs = re.search(r"`identify\(record\)` takes ([\d.]+) times .*? and ([\d.]+) times what it takes", report)
        said = re.search(
            r"takes ([\d.]+) times as long as mwdi .*? and ([\d.]+) times as long as", README.replace("\n", " ")
        )
        assert theirs
        assert said
        assert [float(x) for x in said.groups()] == [round(float(x), 1) for x in theirs.groups()]
