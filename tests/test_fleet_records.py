"""Example records: a row of `suspid fleet` says what `suspid identify` says of the same file."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fleets import time_limit

from suspid import Settings
from suspid.cli.fleet import fleet_command
from suspid.cli.main import main
from suspid.fleet.job import Job
from suspid.fleet.parts import read_table
from suspid.fleet.records import Entry
from suspid.fleet.rows import record_rows
from suspid.identification.modes_json import modes_from_dict

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
SHARED = [
    "rizoit_seat3dof_sim/release.csv",
    "rizoit_seat3dof_sim/step50mm.csv",
    "rizoit_seat3dof_sim/chirp.csv",
    "vibtest_inout_mat/case1.mat",
    "vibtest_inout_mat/mckiddat.mat",
    "pyuff_uff58_mps/time-history-not-all-columns-filled.uff",
    "bicycle_pendulum_mat/BrowserForkCompoundFirst1.mat",
    "css_canedge_car_mf4/stationary_2F6913DB_00000004_00000001.MF4",
]


@pytest.fixture(autouse=True)
def limited() -> Iterator[None]:
    with time_limit():
        yield


def check_same(files: list[Path], folder: Path) -> None:
    """Compare modes and verdict of the command `identify` on each file with the rows of one fleet of all."""
    (folder / "in").mkdir()
    for file in files:
        shutil.copy(file, folder / "in" / file.name)
    found = CliRunner().invoke(fleet_command, [str(folder / "in"), "-o", str(folder / "out"), "--workers", "1"])
    assert found.exception is None or isinstance(found.exception, SystemExit), found.output
    modes = read_table(folder / "out", "modes").to_pylist()
    failures = {row["record"]: row for row in read_table(folder / "out", "failures").to_pylist()}
    for file in files:
        said = folder / f"{file.name}.json"
        shown = CliRunner().invoke(main, ["identify", str(folder / "in" / file.name), "--json", str(said)])
        mine = [row for row in modes if row["record"] == file.name]
        if shown.exit_code:
            # Refused by both, in the same words; what to do about it follows, by the names of arguments or options.
            assert not mine
            assert failures[file.name]["code"] in ("unusable record", "not identified", "refused")
            assert failures[file.name]["reason"].partition(";")[0] in shown.stderr
            continue
        content = json.loads(said.read_text())
        if not content["modes"]:
            assert not mine
            assert content["verdict"]["level"] == "none"
            assert (failures[file.name]["step"], failures[file.name]["code"]) == ("identify", "no mode")
            continue
        alone = modes_from_dict(content)
        # Two processes may sum in another order; beyond rounding the modes are the same.
        np.testing.assert_allclose([row["wn_rad_per_s"] for row in mine], alone.wn, rtol=1e-6)
        np.testing.assert_allclose([row["zeta"] for row in mine], alone.zeta, rtol=1e-6)
        assert {row["verdict"] for row in mine} == {content["verdict"]["level"]}
        against = {one["code"] for one in content["verdict"]["checks"] if one["level"] in ("doubtful", "care")}
        assert set(mine[0]["doubts"]) == against


@pytest.mark.slow
def test_the_example(tmp_path: Path) -> None:
    check_same([ROOT / "examples" / "quarter_car.csv"], tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not DATA.exists(), reason="no shared data")
def test_measured_records(tmp_path: Path) -> None:
    check_same([DATA / name for name in SHARED], tmp_path)


@pytest.mark.parametrize("suffix", [".csv", ".h5", ".mat", ".mf4", ".npz", ".parquet", ".tdms", ".uff", ".wav"])
@pytest.mark.parametrize("content", [b"", b"PK\x03\x04damaged", b"\x89HDF\r\n\x1a\ndamaged", b"TDSm\x0e", None])
def test_the_reason_does_not_depend_on_where_the_file_lies(tmp_path: Path, suffix: str, content: bytes | None) -> None:
    said = []
    for folder in (tmp_path / "here", tmp_path / "over there"):
        folder.mkdir()
        path = folder / f"bump{suffix}"
        if content is None:
            path.mkdir()
        else:
            path.write_bytes(content)
        (row,) = record_rows(Job(settings=Settings()), Entry(name=path.name, path=str(path)), lambda _: None).failures
        said.append(row)
    assert said[0] == said[1]
    assert str(tmp_path) not in str(said[0])
