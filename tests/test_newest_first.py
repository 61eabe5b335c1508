"""Files whose newest row stands first, as data bases list them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, clean, read_record, read_recording
from suspid.words import LeftOut

TIMES = np.arange(400) / 40
SEAT = np.exp(-0.3 * TIMES) * np.cos(9 * TIMES)
EPOCH = [f"{1492553604772 + 1000 * t:.0f}" for t in TIMES]
DATES = [f"2021-12-27 18:06:{t:06.3f}" for t in TIMES]


def write(path: Path, stamps: list[str], values: list[float], *, head: str = "time") -> Path:
    rows = [f"{t},{y:.6f}" for t, y in zip(stamps, values, strict=True)]
    path.write_text(f"{head},seat\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("stamps", [EPOCH, DATES, [f"{t:.3f}" for t in TIMES], [f"{1000 * t:.0f}" for t in TIMES]])
def test_they_are_turned_round(tmp_path: Path, stamps: list[str]) -> None:
    path = write(tmp_path / "a.csv", stamps[::-1], [*SEAT[::-1]])
    recording = read_recording(path)
    (seat,) = recording.channels
    np.testing.assert_allclose(seat.timepts - seat.timepts[0], TIMES, atol=1e-6)
    np.testing.assert_allclose(seat.values, SEAT, atol=1e-6)
    assert dict(recording.left_out)["order of 'time'"].code is LeftOut.NEWEST_FIRST
    assert clean(recording).record.time.size == TIMES.size


def test_of_two_recordings_the_longer_is_told(tmp_path: Path) -> None:
    stamps = [*EPOCH[::-1], *[f"{int(t) + 60_000}" for t in EPOCH[99::-1]]]
    path = write(tmp_path / "a.csv", stamps, [*SEAT[::-1], *SEAT[99::-1]])
    with pytest.raises(RecordError, match=r"backwards at 1 of 500 rows.*is rows 101 to 500.*take it with"):
        read_record(path)


@pytest.mark.parametrize(
    ("stamps", "head"),
    [(EPOCH[::-1], "time left"), (EPOCH, "time"), ([*EPOCH[:200], *EPOCH[:200:-1], "0"], "time")],
    ids=["until the end", "oldest first", "to and fro"],
)
def test_others_are_left(tmp_path: Path, stamps: list[str], head: str) -> None:
    path = write(tmp_path / "a.csv", stamps, [*SEAT], head=head)
    recording = read_recording(path, time=head)
    np.testing.assert_allclose(recording["seat"].values, SEAT, atol=1e-6)
    assert LeftOut.NEWEST_FIRST not in [why.code for _, why in recording.left_out]


def test_a_time_of_another_name_is_told(tmp_path: Path) -> None:
    """A data base writes the number of each row before it."""
    rows = [f"{900 - k},{t}" for k, t in enumerate(EPOCH[::-1])]
    path = write(tmp_path / "a.csv", rows, [*SEAT[::-1]], head="ID,TM")
    with pytest.raises(RecordError, match="'TM' falls like a time, newest first: if it is one, give time='TM'"):
        read_recording(path)
    assert read_recording(path, time="TM").names == ("seat",)
