"""A fleet's run whose worker hangs, whose list of records is damaged, or whose folder cannot be written."""

from __future__ import annotations

from pathlib import Path

import pytest

from suspid.errors import InputError
from suspid.fleet.children import Children, close, work_in_child
from suspid.fleet.job import Job
from suspid.fleet.records import Entry, read_list, write_list
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
