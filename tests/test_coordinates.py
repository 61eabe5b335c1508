"""Cells of several numbers in brackets, as programs that track a point in a film write its coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from suspid import Recording, analyse, read_recording
from suspid.io.text.coordinates import with_coordinates
from suspid.words import LeftOut

TIMES = np.arange(400) / 30
SWING = np.round(900 + 400 * np.exp(-0.02 * TIMES) * np.cos(3.5 * TIMES)).astype(int)


def saved(folder: Path, names: str, cells: Sequence[str], *, end: str = "\n") -> Path:
    path = folder / "a.csv"
    rows = (f'"{cell}",{t:.3f}{end}' for cell, t in zip(cells, TIMES, strict=True))
    path.write_text(f"{names}{end}{''.join(rows)}", encoding="utf-8", newline="")
    return path


def read(folder: Path, names: str, cells: Sequence[str]) -> Recording:
    return read_recording(saved(folder, names, cells))


@pytest.mark.parametrize("brackets", ["()", "[]"])
@pytest.mark.parametrize("size", [2, 3])
def test_each_coordinate_is_a_channel(tmp_path: Path, brackets: str, size: int) -> None:
    cells = [f"{brackets[0]}{', '.join(map(str, (x, -1.5e-3, 7)[:size]))}{brackets[1]}" for x in SWING]
    recording = read(tmp_path, "point,time [s]", cells)
    assert recording.names == tuple(f"point[{k + 1}]" for k in range(size))
    assert recording["point[1]"].values.tolist() == SWING.tolist()
    assert set(recording["point[2]"].values) == {-1.5e-3}
    assert np.allclose(recording["point[1]"].timepts, TIMES, rtol=0, atol=1e-3)


def test_an_empty_line_behind_each_changes_nothing(tmp_path: Path) -> None:
    """As Python writes them on Windows."""
    path = saved(tmp_path, "point,time", [f"({x}, 685)" for x in SWING], end="\r\r\n")
    assert read_recording(path).names == ("point[1]", "point[2]")
    assert analyse(path).modes.wn == pytest.approx([3.5], rel=1e-3)


@pytest.mark.parametrize(
    "row",
    ['"",4', '"(1, 2, 3)",4', '"(1, 2)",4,"(1, 2)"', '"lost",4', '"(1, 2)",4,5', '"(1, 2)","late"'],
)
def test_a_row_without_them_leaves_them_text(row: str) -> None:
    text = "\n".join(["point,time", '"(1, 2)",3', row, ""]).encode()
    assert with_coordinates(text, within=1000) == text


def test_rows_that_make_up_for_each_other_leave_them_text() -> None:
    """As many numbers in all, but not in their places."""
    text = b'a,b\n"(1, 2)","(1, 2, 3)"\n"(1, 2, 3)","(1, 2)"\n'
    assert with_coordinates(text, within=1000) == text


@pytest.mark.parametrize("names", ["", "point\n", "point,time,x\n", f'"{200_000 * "x"}",time\n'])
def test_a_name_for_each_column_is_needed(names: str) -> None:
    text = f'{names}"(1, 2)",3\n"(1, 2)",4\n'.encode()
    assert with_coordinates(text, within=len(text)) == text


def test_words_in_brackets_are_text(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text('note,time,seat\n"(a, b)",0,1\n"(a, b)",1,2\n"(a, b)",3,4\n', encoding="utf-8")
    assert dict(read_recording(path).left_out)["note"].code is LeftOut.TEXT
