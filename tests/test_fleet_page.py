"""The page of a fleet and its tables as CSV."""

from __future__ import annotations

import csv
import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fleets import CAR, write_decay

from suspid import InputError, eigenmodes, fleet_summary, report
from suspid.cli.commands import Commands
from suspid.cli.fleet import fleet_command
from suspid.fleet import write_csv
from suspid.fleet.distributions import EDGES, MOST_BARS, distribution
from suspid.fleet.manifest import FLEET_FORMAT, environment
from suspid.fleet.parts import as_part, read_table, write_part
from suspid.fleet.tables import DECAYS, TABLE_COLUMNS, Rows
from suspid.model import car_to_toml
from suspid.words import DamperState, FleetCheck, Level

PATTERN = r"(?P<vehicle>[^/]+)/(?P<date>\d{4}-\d{2}-\d{2})"
NAUGHTY = "V<script>alert(1)</script>"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two vehicles, four records each, as a run leaves them; one damper loses 40 %; one file is no record."""
    folder, rng = tmp_path_factory.mktemp("fleet"), np.random.default_rng(1)
    for table in TABLE_COLUMNS:
        (folder / table).mkdir()
    manifest = {"format": FLEET_FORMAT, "environment": environment(), "car": car_to_toml(CAR), "complete": {"parts": 1}}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    modes, springs = [], []
    for (vehicle, loss), k in itertools.product((("sound", 0.0), ("worn", 0.4)), range(4)):
        name = {"record": f"{vehicle}/2024-{2 * k + 1:02d}-01.csv"}
        share = (1 - loss * k / 3) * (1 + 0.002 * rng.standard_normal())
        car = CAR.with_parameters(damping={"chassis": 1500 * share})
        for m, (wn, zeta) in enumerate(
            zip(*(getattr(eigenmodes(car), q).tolist() for q in ("wn", "zeta")), strict=True)
        ):
            values = {"mode": m + 1, "f_hz": wn / (2 * np.pi), "wn_std_rad_per_s": 0.001 * wn, "zeta": zeta}
            more = {"zeta_std": 0.003 * zeta, "verdict": "sound", "doubts": [], "channels": ["chassis", "tire"]}
            modes.append({**dict.fromkeys(TABLE_COLUMNS["modes"]), **name, **values, **more})
        for parameter, unit, value in (("chassis.damping", "N s/m", 1500 * share), ("chassis.stiffness", "N/m", 2e4)):
            row = {"parameter": parameter, "unit": unit, "value": value, "std": 0.002 * value, "held": False}
            springs.append({**dict.fromkeys(TABLE_COLUMNS["springs"]), **name, **row})
    failure = {"record": "no <b>record.csv", "step": "read", "code": "unusable record", "reason": "contains no numbers"}
    failures = ({**dict.fromkeys(TABLE_COLUMNS["failures"]), **failure},)
    rows = Rows(modes=tuple(modes), springs=tuple(springs), failures=failures, records=9, failed=1)
    write_part(folder, 0, as_part(rows))
    return folder


class TestPage:
    def test_it_has_what_the_summary_says(self, results: Path) -> None:
        summary = fleet_summary(results, pattern=PATTERN)
        page = report(summary)
        assert "Results of 8 of 9 records" in page
        for said in ("unusable record", "worn: chassis", "worn: chassis.damping", "mode 2 zeta", "Outliers"):
            assert said in page
        assert page.count("Histogram of ") == len(summary.distributions)
        assert summary.dampers is not None
        assert [str(one.state) for one in summary.dampers.trends] == ["worn", "good"]

    def test_nothing_in_it_runs_or_is_fetched(self, results: Path) -> None:
        page = report(fleet_summary(results, pattern=rf"(?P<vehicle>[^/]+)/(?P<date>\d{{4}}-\d{{2}})|{NAUGHTY}"))
        assert "<script" not in page
        assert "<b>record" not in page
        assert "no &lt;b&gt;record" in page
        assert "default-src 'none'" in page

    def test_verdict(self, results: Path) -> None:
        verdict = fleet_summary(results, pattern=PATTERN).verdict
        assert verdict.level is Level.CARE
        codes = {remark.code: remark.numbers for remark in (*verdict.doubts, *verdict.notes)}
        assert codes[FleetCheck.FAILED]["failed"] == 1
        assert codes[FleetCheck.DAMPERS] == {"worn": 1, "dampers": 2}
        assert str(DamperState.WORN) in str(verdict)

    def test_too_few_records_are_not_said_to_be_alike(self, results: Path) -> None:
        page = report(replace(fleet_summary(results), distributions=(), outliers=(), others=6))
        assert "Fewer than 8 records are too few to find outliers." in page
        assert "6 modes in too few records to be compared" in page

    def test_without_a_result_it_is_a_page_as_well(self, tmp_path: Path) -> None:
        (tmp_path / "manifest.json").write_text(json.dumps({"format": FLEET_FORMAT, "environment": environment()}))
        summary = fleet_summary(tmp_path)
        assert summary.verdict.level is Level.NONE
        assert "No record gave a result." in report(summary)


class TestHistogram:
    @pytest.mark.parametrize("count", [1, 2, 3, 24, 1000])
    def test_every_record_is_in_one_bar(self, count: int) -> None:
        values = np.random.default_rng(count).standard_normal(count)
        found = distribution("f", "Hz", values, np.full(count, np.nan))
        assert sum(found.bars) == count
        assert len(found.edges) == len(found.bars) + 1
        assert len(found.bars) <= MOST_BARS

    def test_one_value_far_off_does_not_hide_the_others(self) -> None:
        values = np.append(np.random.default_rng(1).standard_normal(999), 1e6)
        found = distribution("f", "Hz", values, np.full(1000, np.nan))
        assert found.edges[-1] <= np.quantile(values, EDGES[1], method="higher") < 4
        assert sum(1 for bar in found.bars if bar) > 10

    def test_equal_values_are_one_bar(self) -> None:
        assert distribution("f", "Hz", np.full(9, 2.0), np.full(9, np.nan)).bars == (9,)


class TestCsv:
    def test_csv_has_the_rows_of_all_parts(self, tmp_path: Path) -> None:
        """Records come in chunks, each with a part of its own."""
        for table in TABLE_COLUMNS:
            (tmp_path / table).mkdir()
        manifest = {"format": FLEET_FORMAT, "environment": environment(), "complete": {"parts": 2}}
        (tmp_path / "manifest.json").write_text(json.dumps(manifest))
        for number in range(2):
            row = dict.fromkeys(TABLE_COLUMNS["modes"]) | {"record": f"r{number}", "mode": 1, "zeta": 0.1 + number}
            write_part(tmp_path, number, as_part(Rows(modes=(row,))))
        with write_csv(tmp_path)[-1].open(encoding="utf-8") as stream:
            found = [(row["record"], float(row["zeta"])) for row in csv.DictReader(stream)]
        assert found == [("r0", 0.1), ("r1", 1.1)]

    def test_it_holds_the_tables(self, results: Path) -> None:
        files = write_csv(results)
        assert [file.name for file in files] == ["failures.csv", "springs.csv", "modes.csv"]
        for file, table in zip(files, DECAYS.names, strict=True):
            expected = read_table(results, table)
            with file.open(encoding="utf-8", newline="") as stream:
                rows = list(csv.DictReader(stream))
            assert list(rows[0]) == expected.column_names
            assert [row["record"] for row in rows] == expected["record"].to_pylist()
        # Every digit of a number is there.
        assert [float(row["zeta"]) for row in rows] == expected["zeta"].to_pylist()
        assert [row["channels"].split(";") for row in rows] == expected["channels"].to_pylist()

    def test_what_holds_no_results_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(InputError):
            write_csv(tmp_path)


class TestCommand:
    def test_summary_writes_the_page_and_the_tables(self, results: Path, tmp_path: Path) -> None:
        page = tmp_path / "fleet.html"
        commands = Commands("suspid", commands={"fleet": fleet_command})
        asked = ["fleet", "--summary", str(results), "--page", str(page), "--csv", "--vehicle-from", PATTERN]
        done = CliRunner().invoke(commands, asked)
        assert done.exit_code == 0, done.output
        assert "worn: chassis" in page.read_text(encoding="utf-8")
        assert (results / "modes.csv").exists()

    def test_a_page_that_cannot_be_written_is_refused_before_the_run(self, tmp_path: Path) -> None:
        write_decay(tmp_path / "a.csv", 1)
        commands = Commands("suspid", commands={"fleet": fleet_command})
        asked = ["fleet", str(tmp_path / "a.csv"), "-o", str(tmp_path / "out"), "--page", str(tmp_path / "fleet.txt")]
        done = CliRunner().invoke(commands, asked)
        assert done.exit_code == 1
        assert not (tmp_path / "out").exists()
