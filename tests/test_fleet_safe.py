"""A fleet's run whose worker hangs, whose files are damaged or change, or whose folder cannot be written."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from fleets import content, make_fleet, own_process

from suspid.errors import InputError, SuspidError
from suspid.fleet.children import Children, close, work_in_child
from suspid.fleet.fleet_summary import fleet_summary
from suspid.fleet.identify_many import identify_many
from suspid.fleet.job import Job
from suspid.fleet.listing import listing
from suspid.fleet.parts import Part, as_part, check_parts, part_counts, part_path, write_part
from suspid.fleet.records import Entry, read_list, write_list
from suspid.fleet.tables import DECAYS, Rows
from suspid.fleet.workers import dask_engine
from suspid.words import Failure

# A process that holds the interpreter while it sleeps, so that no thread of it runs.
HANGS = """
import ctypes, sys
if "fleet.children" in " ".join(sys.orig_argv):
    import numpy
    import suspid.io.formats as formats
    def hang(*_):
        ctypes.PyDLL(None).sleep(600)
    formats.Format.read = hang
"""


@pytest.mark.slow
def test_a_worker_that_holds_the_interpreter_is_ended_from_outside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(HANGS)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr("suspid.fleet.children.LATE_ANSWER", 1.0)
    (tmp_path / "r.csv").write_text("t,seat\n0,1\n1,2\n")
    children = Children()
    try:
        part = work_in_child(children, Job(time_limit=0.2), [Entry(name="r", path=str(tmp_path / "r.csv"))])
    finally:
        close(children)
    assert (part.records, part.failed) == (1, 1)
    assert any(str(Failure.TIME_NATIVE).encode() in content for content in part.files.values())


@pytest.mark.parametrize(
    ("failure", "said"),
    [(OSError("Timed out trying to connect"), "the cluster was lost"), (TimeoutError(), "the cluster has no worker")],
)
def test_a_scheduler_that_dies_while_workers_are_awaited(
    monkeypatch: pytest.MonkeyPatch, failure: OSError, said: str
) -> None:
    pytest.importorskip("distributed")

    class Dying:
        def wait_for_workers(self, *_: object, **__: object) -> None:
            raise failure

        def close(self) -> None:
            pass

    monkeypatch.setattr("suspid.fleet.workers._connected", lambda *_: Dying())
    with pytest.raises(SuspidError, match=said), dask_engine("tcp://127.0.0.1:9"):
        pass


class TestList:
    ENTRIES = (Entry(name="a", path="/a.csv", size=3), Entry(name="b", path="/b.csv"))

    def test_it_is_read_as_written(self, tmp_path: Path) -> None:
        assert write_list(tmp_path / "records.jsonl", self.ENTRIES) == 2
        read = [(e.name, e.path, e.size) for e in read_list(tmp_path / "records.jsonl")]
        assert read == [("a", "/a.csv", 3), ("b", "/b.csv", None)]

    @pytest.mark.parametrize("cut", [1, 5, 20])
    def test_damage_is_named_by_its_line(self, tmp_path: Path, cut: int) -> None:
        write_list(tmp_path / "records.jsonl", self.ENTRIES)
        content = (tmp_path / "records.jsonl").read_bytes()
        (tmp_path / "records.jsonl").write_bytes(content[:-cut])
        with pytest.raises(InputError, match=r"records\.jsonl: line 2 is damaged"):
            list(read_list(tmp_path / "records.jsonl"))

    def test_it_cannot_be_written(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"records\.jsonl: cannot be written"):
            write_list(tmp_path / "missing" / "records.jsonl", self.ENTRIES)


def a_part() -> Part:
    mode, failure = ({**dict.fromkeys(DECAYS.columns[name]), "record": "a"} for name in ("modes", "failures"))
    return as_part(Rows(modes=(mode,), failures=(failure,), records=2, failed=1))


class TestParts:
    def test_every_bit_counts(self, tmp_path: Path) -> None:
        """A bit that flips anywhere in a part, or a part that is cut, leaves no complete chunk."""
        for table in DECAYS.names:
            (tmp_path / table).mkdir()
        write_part(tmp_path, 0, a_part())
        assert part_counts(tmp_path, 0) == (2, 1)
        for table in ("modes", "failures"):
            path = part_path(tmp_path, table, 0)
            whole = path.read_bytes()
            for k in range(0, len(whole), 97):
                path.write_bytes(whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :])
                assert part_counts(tmp_path, 0) is None, f"{table}: byte {k} of {len(whole)}"
            path.write_bytes(whole[:-1])
            assert part_counts(tmp_path, 0) is None
            path.write_bytes(whole)
        assert part_counts(tmp_path, 0) == (2, 1)

    def test_missing_and_foreign_parts_are_named(self, tmp_path: Path) -> None:
        for table in DECAYS.names:
            (tmp_path / table).mkdir()
        part = a_part()
        for number in range(3):
            write_part(tmp_path, number, part)
        assert check_parts(tmp_path, DECAYS, 3) == [(2, 1)] * 3
        with pytest.raises(InputError, match=r"modes.part-000003\.parquet: is damaged or missing"):
            check_parts(tmp_path, DECAYS, 4)
        part_path(tmp_path, "springs", 1).write_bytes(part.files["failures"])
        part_path(tmp_path, "failures", 2).unlink()
        with pytest.raises(InputError, match=r"springs.part-000001\.parquet: is damaged.* 1 more chunk"):
            check_parts(tmp_path, DECAYS)


class TestAgain:
    @pytest.fixture(autouse=True, scope="class")
    @staticmethod
    def here() -> Iterator[None]:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys.modules["suspid.fleet.identify_many"], "local_engine", own_process)
            yield

    @pytest.fixture(scope="class")
    @staticmethod
    def fleet(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
        folder = tmp_path_factory.mktemp("again")
        make_fleet(folder / "in", 2)
        (folder / "in" / "bad.csv").write_text("nothing\n")
        identify_many(folder / "in", output=folder / "in" / "out", chunk=2)
        return folder / "in", folder / "in" / "out"

    def test_damaged_and_deleted_parts_are_made_again(self, fleet: tuple[Path, Path]) -> None:
        records, output = fleet
        before = content(output)
        path = part_path(output, "modes", 1)
        whole = path.read_bytes()
        path.write_bytes(whole[:200] + b"#" + whole[201:])
        next((output / "failures").iterdir()).unlink()
        with pytest.raises(InputError, match=r"failures.part-000000\.parquet: is damaged or missing"):
            fleet_summary(output)
        run = identify_many(records, output=output, chunk=2)
        assert run.kept == 0
        assert run.notes == ("2 damaged parts made again: number 0, 1",)
        assert content(output) == before
        assert fleet_summary(output).records == 3

    def test_a_part_that_is_a_copy_of_another_is_made_again(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 4)
        identify_many(tmp_path / "in", output=tmp_path / "out", chunk=2)
        before = content(tmp_path / "out")
        first, second = (part_path(tmp_path / "out", "modes", number) for number in (0, 1))
        second.write_bytes(first.read_bytes())
        run = identify_many(tmp_path / "in", output=tmp_path / "out", chunk=2)
        assert (run.kept, run.notes) == (2, ("1 damaged part made again: number 1",))
        assert content(tmp_path / "out") == before

    def test_a_file_of_equal_size_that_changed_is_named(self, fleet: tuple[Path, Path]) -> None:
        records, output = fleet
        path = records / "run000.csv"
        text = path.read_text()
        status = path.stat()
        try:
            os.utime(path, ns=(0, 10**18))
            assert identify_many(records, output=output, chunk=2).notes == ()
            path.write_text(text[:-2] + ("1" if text[-2] != "1" else "2") + text[-1])
            (note,) = identify_many(records, output=output, chunk=2).notes
        finally:
            path.write_text(text)
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
        assert note.startswith("1 file changed since the run began, run000.csv first")

    @pytest.mark.parametrize(
        "records", ["{0}", "{0}/**/*", "{0}/*/*/*.parquet", "file://{0}", "file://{0}/**/*.parquet"]
    )
    def test_results_are_no_records(self, fleet: tuple[Path, Path], tmp_path: Path, records: str) -> None:
        names = {entry.name for entry in listing(records.format(fleet[0]), output=tmp_path).entries}
        assert not any("part-" in name or "manifest" in name or "records.jsonl" in name for name in names)

    def test_a_table_that_cannot_be_made(self, tmp_path: Path, fleet: tuple[Path, Path]) -> None:
        output = tmp_path / "out"
        output.mkdir()
        (output / "manifest.json").write_bytes((fleet[1] / "manifest.json").read_bytes())
        (output / "springs").write_text("in the way")
        with pytest.raises(InputError, match="springs: cannot be written"):
            identify_many(fleet[0], output=output, chunk=2)
