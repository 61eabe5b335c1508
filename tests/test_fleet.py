"""Fleets on one machine: every good record has its rows, every bad one its reason, and bytes do not depend on who."""

from __future__ import annotations

import json
import math
import os
import stat
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from fleets import CAR, content, make_fleet, own_process, time_limit, write_decay

from suspid import InputError, eigenmodes, free_decay
from suspid.analysis import CarSettings, Settings, analyse
from suspid.cli.main import main
from suspid.fleet.identify_many import identify_many
from suspid.fleet.parts import read_table
from suspid.fleet.run import FleetRun
from suspid.words import Defect, Failure

COUNT, CHUNK = 14, 4
KILLERS = """
import ctypes, os, signal, time
import suspid.fleet.rows

genuine = suspid.fleet.rows.analyse


def analyse(path, **settings):
    name = str(path)
    if "killed" in name:
        os.kill(os.getpid(), signal.SIGKILL)
    if "crash" in name:
        ctypes.string_at(0)
    if "memory" in name:
        raise MemoryError
    if "sleeps" in name:
        time.sleep(1000) if "python" not in name else [time.sleep(0.01) for _ in range(100_000)]
    return genuine(path, **settings)


suspid.fleet.rows.analyse = analyse
"""


@pytest.fixture(autouse=True)
def limited() -> Iterator[None]:
    with time_limit():
        yield


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_fleet(tmp_path_factory.mktemp("fleet") / "in", COUNT)


@pytest.fixture(scope="module")
def run(fleet: Path, tmp_path_factory: pytest.TempPathFactory) -> FleetRun:
    return identify_many(fleet, output=tmp_path_factory.mktemp("out"), car=CAR, workers=1, chunk=CHUNK)


def rows(run: FleetRun, table: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = getattr(run, table).to_pylist()
    return found


class TestWhatAnalyseSays:
    @pytest.mark.slow
    def test_rows_are_those_of_analyse_on_each_file(self, fleet: Path, run: FleetRun) -> None:
        assert (run.records, run.failed, run.kept) == (COUNT, 0, 0)
        table = rows(run, "modes")
        names = sorted(path.relative_to(fleet).as_posix() for path in fleet.rglob("*.csv"))
        assert list(dict.fromkeys(row["record"] for row in table)) == names
        for name in names:
            found = analyse(fleet / name, car=CAR)
            mine = [row for row in table if row["record"] == name]
            assert [row["mode"] for row in mine] == list(range(1, len(found.modes) + 1))
            # The same code on the same bytes; another number of threads may round otherwise.
            for key, value in (("wn_rad_per_s", found.modes.wn), ("zeta", found.modes.zeta)):
                np.testing.assert_allclose([row[key] for row in mine], value, rtol=1e-9)
            assert found.modes.wn_std is not None
            np.testing.assert_allclose([row["wn_std_rad_per_s"] for row in mine], found.modes.wn_std, rtol=1e-6)
            ends = found.modes.interval(0.95).zeta
            np.testing.assert_allclose([[row["zeta_low"], row["zeta_high"]] for row in mine], ends, rtol=1e-6)
            assert all(row["channels"] == ["chassis", "tire"] and row["samples"] == 300 for row in mine)
            assert {row["verdict"] for row in mine} == {found.verdict.level.label}
            assert all(row["doubts"] == [str(doubt.code) for doubt in found.verdict.doubts] for row in mine)
            assert all(row["doubts_in_words"] == [str(doubt) for doubt in found.verdict.doubts] for row in mine)

    def test_springs_are_those_of_the_car(self, run: FleetRun) -> None:
        table = rows(run, "springs")
        true = {f"{s.name}.{q}": getattr(s, q) for s in CAR.struts for q in ("stiffness", "damping")}
        assert len(table) == COUNT * len(true)
        for row in table:
            # Five standard deviations: one false alarm in a hundred thousand of these tests.
            assert abs(row["value"] - true[row["parameter"]]) < 5 * row["std"]
            assert row["low"] < row["value"] < row["high"]
            assert row["unit"] == ("N/m" if row["parameter"].endswith("stiffness") else "N s/m")

    def test_hash_and_version_stand_in_every_row(self, fleet: Path, run: FleetRun) -> None:
        import hashlib
        from importlib.metadata import version

        for row in rows(run, "modes") + rows(run, "springs"):
            assert row["sha256"] == hashlib.sha256((fleet / row["record"]).read_bytes()).hexdigest()
            assert row["suspid"] == version("suspid")


class TestSameBytes:
    @pytest.mark.slow
    def test_whatever_the_number_of_workers(self, fleet: Path, run: FleetRun, tmp_path: Path) -> None:
        again = identify_many(fleet, output=tmp_path / "out", car=CAR, workers=2, chunk=CHUNK)
        assert content(again.output) == content(run.output)

    def test_started_again_nothing_is_done_twice(self, fleet: Path, run: FleetRun) -> None:
        before = {path: path.stat().st_mtime_ns for path in run.output.rglob("part-*")}
        again = identify_many(fleet, output=run.output, car=CAR, workers=1, chunk=CHUNK)
        assert (again.records, again.kept) == (COUNT, COUNT)
        assert {path: path.stat().st_mtime_ns for path in run.output.rglob("part-*")} == before

    @pytest.mark.slow
    def test_a_broken_part_is_done_again(self, fleet: Path, run: FleetRun, tmp_path: Path) -> None:
        import shutil

        shutil.copytree(run.output, tmp_path / "out")
        part = tmp_path / "out" / "modes" / "part-000001.parquet"
        part.write_bytes(part.read_bytes()[:-7])
        (tmp_path / "out" / "modes" / ".part-000002.parquet.draft").write_bytes(b"PAR1")
        (tmp_path / "out" / "modes" / "part-000002.parquet").unlink()
        again = identify_many(fleet, output=tmp_path / "out", car=CAR, workers=1, chunk=CHUNK)
        assert again.kept == COUNT - 2 * CHUNK
        assert content(tmp_path / "out") == content(run.output)

    @pytest.mark.slow
    def test_a_stream_of_responses_goes_on_too(self, tmp_path: Path) -> None:
        def stream(count: int = 6, first: int = 0) -> Iterator[tuple[str, Any]]:
            for k in range(first, first + count):
                yield f"car {k}", free_decay(CAR, np.arange(200) / 100, initial_state={"v_tire": 1.0 + k})

        whole = identify_many(stream(), output=tmp_path / "whole", workers=1, chunk=2)
        assert (whole.records, whole.failed) == (6, 0)
        identify_many(stream(4), output=tmp_path / "parts", workers=1, chunk=2)
        again = identify_many(stream(), output=tmp_path / "parts", workers=1, chunk=2)
        assert (again.records, again.kept) == (6, 4)
        assert content(tmp_path / "parts") == content(tmp_path / "whole")
        with pytest.raises(InputError, match=r"'car 2' is not the one that stands in part 0"):
            identify_many(stream(first=1), output=tmp_path / "whole", workers=1, chunk=2)
        with pytest.raises(InputError, match=r"the records end before"):
            identify_many(stream(2), output=tmp_path / "whole", workers=1, chunk=2)


class TestKilledAtEveryMoment:
    """The process ends in the middle of the k-th write, for every k; the work itself is done in this process."""

    def test_the_same_in_the_end(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        class KilledError(BaseException):
            pass

        writes = [0, 0]  # so far, and which one is the last

        def fsync(handle: int) -> None:
            writes[0] += 1
            if writes[0] == writes[1]:
                if stat.S_ISREG(os.fstat(handle).st_mode):
                    os.ftruncate(handle, 10)
                raise KilledError

        make_fleet(tmp_path / "in", 3)
        (tmp_path / "in" / "bad.csv").write_text("")
        monkeypatch.setattr(sys.modules["suspid.fleet.identify_many"], "local_engine", own_process)
        whole = content(identify_many(tmp_path / "in", output=tmp_path / "whole", chunk=2).output)
        monkeypatch.setattr(os, "fsync", fsync)
        for last in range(1, 40):
            writes[:] = 0, last
            try:
                identify_many(tmp_path / "in", output=tmp_path / str(last), chunk=2)
            except KilledError:
                writes[:] = 0, 0
                identify_many(tmp_path / "in", output=tmp_path / str(last), chunk=2)
                assert content(tmp_path / str(last)) == whole
            else:
                break
        # Manifest, list, two parts and the failures of one, manifest: most of them with their folder.
        assert last > 10


class TestDamagedFiles:
    def damage(self, folder: Path) -> dict[str, str]:
        """Damage twenty files in ten ways; return the words that each one's reason must hold."""
        good = (folder / "run000.csv").read_text().splitlines()
        reasons: dict[str, str] = {}

        def bad(name: str, content: bytes | str, reason: str) -> None:
            for copy in ("a", "b"):
                path = folder / f"{copy} {name}"
                path.write_bytes(content if isinstance(content, bytes) else content.encode())
                reasons[path.name] = reason

        bad("empty.csv", b"", "is empty")
        bad("binary.csv", np.random.default_rng(1).bytes(3000), "")
        bad("header.csv", good[0] + "\n", "")
        bad("words.csv", "\n".join([good[0], *("lorem,ipsum,dolor" for _ in range(80))]) + "\n", "")
        bad("five.csv", "\n".join(good[:6]) + "\n", "samples")
        bad("nan.csv", "\n".join([good[0], *(f"{k / 100},nan,nan" for k in range(200))]) + "\n", "")
        bad("constant.csv", "\n".join([good[0], *(f"{k / 100},1.0,2.0" for k in range(200))]) + "\n", "constant")
        bad("matlab.mat", b"MATLAB 5.0 MAT-file" + bytes(300), "")
        bad("torn.parquet", b"PAR1" + np.random.default_rng(2).bytes(500), "")
        for copy in ("a", "b"):
            (folder / f"{copy} gone.csv").symlink_to(folder / "nowhere.csv")
            reasons[f"{copy} gone.csv"] = "no such file"
        return reasons

    def test_every_good_one_has_its_rows_and_every_bad_one_its_reason(self, tmp_path: Path) -> None:
        good = 20  # beside as many bad ones: more than the twentieth part that is asked
        make_fleet(tmp_path / "in", good)
        reasons = self.damage(tmp_path / "in")
        seen: list[tuple[int, int, int | None]] = []
        run = identify_many(
            tmp_path / "in", output=tmp_path / "out", workers=2, chunk=4, progress=lambda *now: seen.append(now)
        )
        assert (run.records, run.failed) == (good + len(reasons), len(reasons))
        assert seen[-1] == (run.records, run.failed, run.records)
        failures = {row["record"]: row for row in rows(run, "failures")}
        assert set(failures) == set(reasons)
        assert len(rows(run, "failures")) == len(reasons)
        for name, words in reasons.items():
            assert words in failures[name]["reason"]
            assert len(failures[name]["reason"]) > 5
            assert str(tmp_path) not in failures[name]["reason"]
        assert len({row["record"] for row in rows(run, "modes")}) == good

    @pytest.mark.slow
    def test_files_that_kill_their_process_are_failures(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (tmp_path / "hook").mkdir()
        (tmp_path / "hook" / "sitecustomize.py").write_text(KILLERS)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path / "hook"))
        make_fleet(tmp_path / "in", 4)
        for name in ("killed", "crash", "memory", "sleeps in C", "sleeps in python"):
            write_decay(tmp_path / "in" / f"{name}.csv", 1)
        run = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1, chunk=9, time_limit=3.0)
        failures = {row["record"]: row for row in rows(run, "failures")}
        assert len({row["record"] for row in rows(run, "modes")}) == 4
        assert {name: (row["step"], row["code"]) for name, row in failures.items()} == {
            "killed.csv": ("work", str(Failure.WORKER_DIED)),
            "crash.csv": ("work", str(Failure.WORKER_DIED)),
            "memory.csv": ("read", str(Failure.MEMORY)),
            "sleeps in C.csv": ("work", str(Failure.TIME_NATIVE)),
            "sleeps in python.csv": ("read", str(Failure.TIME)),
        }
        assert "signal 9" in failures["killed.csv"]["reason"]
        assert "signal 11" in failures["crash.csv"]["reason"]


class TestFindings:
    def test_what_was_repaired_stands_in_the_row(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 2)
        lines = (tmp_path / "in" / "run000.csv").read_text().splitlines()
        lines[40] = lines[40].partition(",")[0] + ",nan,nan"
        (tmp_path / "in" / "run000.csv").write_text("\n".join(lines) + "\n")
        run = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1)
        found = {row["record"]: row for row in rows(run, "modes")}
        assert found["north/run001.csv"]["findings"] == []
        assert found["run000.csv"]["findings"] == [str(Defect.MISSING)]
        for channel in ("chassis", "tire"):
            assert f"missing, channel '{channel}' at 0.39 s: 1 sample missing" in found["run000.csv"]["remarks"]
        assert str(tmp_path) not in found["run000.csv"]["remarks"]


class TestWhatIsRefused:
    def test_other_settings(self, fleet: Path, run: FleetRun) -> None:
        with pytest.raises(InputError, match=r": modes was not given, is 2; continue as it was begun, or"):
            identify_many(fleet, output=run.output, car=CAR, workers=1, chunk=CHUNK, settings=Settings(modes=2))

    def test_another_version(self, fleet: Path, run: FleetRun, monkeypatch: pytest.MonkeyPatch) -> None:
        import importlib.metadata

        genuine = importlib.metadata.version
        monkeypatch.setattr(importlib.metadata, "version", lambda name: "9.9" if name == "suspid" else genuine(name))
        with pytest.raises(InputError, match=r"suspid was '[^']+', is '9.9'"):
            identify_many(fleet, output=run.output, car=CAR, workers=1, chunk=CHUNK)

    def test_a_folder_of_something_else(self, fleet: Path, tmp_path: Path) -> None:
        (tmp_path / "thesis.txt").write_text("precious")
        with pytest.raises(InputError, match=r"contains 'thesis.txt', which is not a result of a fleet"):
            identify_many(fleet, output=tmp_path)

    @pytest.mark.slow
    def test_two_runs_into_one_folder(self, fleet: Path, tmp_path: Path) -> None:
        begun = threading.Event()

        def slow() -> Iterator[tuple[str, Any]]:
            yield "one", free_decay(CAR, np.arange(100) / 100, initial_state={"v_tire": 1.0})
            begun.set()
            time.sleep(1.0)

        other = threading.Thread(target=lambda: identify_many(slow(), output=tmp_path, workers=1))
        other.start()
        assert begun.wait(30)
        with pytest.raises(InputError, match="another run is writing"):
            identify_many(fleet, output=tmp_path)
        other.join(30)
        assert not other.is_alive()

    @pytest.mark.parametrize(
        ("settings", "message"),
        [
            ({"settings": Settings(springs=CarSettings(fixed=("tire",)))}, "needs a car"),
            ({"car": CAR, "settings": Settings(springs=CarSettings(fixed=("tyre.damping",)))}, "Did you mean"),
            ({"workers": 0}, "1 or more"),
            ({"workers": 1, "scheduler": "tcp://nowhere:1"}, "not both"),
            ({"chunk": 0}, "1 or more"),
        ],
    )
    def test_settings_at_once(self, fleet: Path, tmp_path: Path, settings: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            identify_many(fleet, output=tmp_path / "out", **settings)

    def test_nothing_to_do(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="there is no such folder or file"):
            identify_many(tmp_path / "nowhere", output=tmp_path / "out")
        (tmp_path / "in").mkdir()
        (tmp_path / "in" / "readme.md").write_text("no record")
        with pytest.raises(InputError, match=r"in: there is no record: only 1 \.md"):
            identify_many(tmp_path / "in", output=tmp_path / "out")
        # A run that never began does not hold its folder against the next one.
        assert not (tmp_path / "out").exists()
        with pytest.raises(InputError, match="stands 2 times"):
            identify_many(["a.csv", "a.csv"], output=tmp_path / "out")

    def test_no_results(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"there is no manifest.json"):
            read_table(tmp_path, "modes")


class TestWhereRecordsComeFrom:
    @pytest.mark.slow
    def test_folder_pattern_list_and_object_store_give_the_same_modes(self, fleet: Path, tmp_path: Path) -> None:
        import fsspec

        names = ["run000.csv", "run003.csv"]
        store = fsspec.filesystem("local")
        assert store.exists(str(fleet))
        sources: list[Any] = [
            str(fleet / "run00[03].csv"),
            [fleet / name for name in names],
            [f"file://{fleet / name}" for name in names],
            f"file://{fleet}/run00[03].csv",
        ]
        found = []
        for k, source in enumerate(sources):
            run = identify_many(source, output=tmp_path / str(k), workers=1)
            assert (run.records, run.failed) == (2, 0)
            found.append([(Path(r["record"]).name, r["sha256"], r["wn_rad_per_s"]) for r in rows(run, "modes")])
        assert all(one == found[0] for one in found[1:])

    @pytest.mark.slow
    def test_what_changes_after_it_was_listed_is_said(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 3)
        run = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1)
        before = content(run.output)
        write_decay(tmp_path / "in" / "new.csv", 99)
        again = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1)
        assert "3 records then, 4 now" in str(again)
        assert content(run.output) == before
        # Killed before any part was written, and then a file grows.
        (tmp_path / "out" / "modes" / "part-000000.parquet").unlink()
        with (tmp_path / "in" / "run000.csv").open("a") as stream:
            stream.write("3.00,0.0,0.0\n")
        last = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1)
        assert [row["record"] for row in rows(last, "failures")] == ["run000.csv"]
        assert rows(last, "failures")[0]["code"] == str(Failure.CHANGED)

    @pytest.mark.slow
    def test_any_name_of_a_file(self, tmp_path: Path) -> None:
        (tmp_path / "in").mkdir()
        for k, name in enumerate([b"caf\xe9.csv", b"new\nline.csv", "ümläut ×.csv".encode()]):
            write_decay(tmp_path / "in" / "x.csv", k)
            os.rename(tmp_path / "in" / "x.csv", os.fsencode(tmp_path / "in") + b"/" + name)
        run = identify_many(tmp_path / "in", output=tmp_path / "out", workers=1)
        assert run.failed == 0
        assert {row["record"] for row in rows(run, "modes")} == {"caf\\udce9.csv", "new\\nline.csv", "ümläut ×.csv"}

    @pytest.mark.slow
    def test_the_results_are_no_records(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 2)
        for _ in range(2):
            assert identify_many(tmp_path / "in", output=tmp_path / "in" / "results", workers=1).records == 2
        assert identify_many(tmp_path / "in", output=tmp_path / "others", workers=1).records == 2

    def test_one_record_is_enough(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 1)
        told = CliRunner().invoke(main, ["fleet", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--workers", "1"])
        assert told.exit_code == 0
        assert ": 1 record, 0 of them" in told.stdout


class TestManifest:
    def test_it_says_what_was_asked_and_what_came(self, run: FleetRun) -> None:
        manifest = json.loads((run.output / "manifest.json").read_text())
        assert manifest["complete"] == {"records": COUNT, "failed": 0, "parts": math.ceil(COUNT / CHUNK)}
        assert manifest["settings"]["method"] == "likelihood"
        assert "[[struts]]" in manifest["car"]
        listed = [json.loads(line) for line in (run.output / "records.jsonl").read_text().splitlines()]
        there = [(os.stat(path), size, changed) for path, _, size, changed in listed]
        assert all((file.st_size, str(file.st_mtime_ns)) == (size, changed) for file, size, changed in there)
        assert len(listed) == COUNT

    def test_truth_lies_in_the_intervals(self, run: FleetRun) -> None:
        """Of 28 intervals of 95 %, fewer than 22 hold the truth once in 3000 fleets."""
        true = eigenmodes(CAR)
        held = [
            row["wn_low_rad_per_s"] < true.wn[row["mode"] - 1] < row["wn_high_rad_per_s"] for row in rows(run, "modes")
        ]
        assert len(held) == 2 * COUNT
        assert sum(held) >= 22
