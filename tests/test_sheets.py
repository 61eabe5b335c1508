"""Spreadsheets: the sheet with the most numbers is the record."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from suspid import RecordError, read_record, read_recording

openpyxl = pytest.importorskip("openpyxl")
pytest.importorskip("python_calamine")

T = np.arange(60) / 50
ROWS: list[list[Any]] = [["time [s]", "seat [mm]"], *([float(t), 3.0 * float(np.exp(-t) * np.cos(20 * t))] for t in T)]


def written(path: Path, sheets: Mapping[str, Sequence[Sequence[Any]]], *, above: int = 0, hidden: str = "") -> Path:
    """A workbook with these sheets, each below some blank rows."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for k, row in enumerate(rows):
            for c, value in enumerate(row):
                sheet.cell(above + k + 1, c + 1, value)
        sheet.sheet_state = "hidden" if name == hidden else "visible"
    book.save(path)
    return path


class TestSheets:
    def test_numbers_units_and_time_are_those_of_the_cells(self, tmp_path: Path) -> None:
        record = read_record(written(tmp_path / "r.xlsx", {"data": ROWS}))
        assert np.array_equal(record.time, T)
        # The writer keeps 16 digits.
        assert np.allclose(record.y[0], [row[1] for row in ROWS[1:]], rtol=1e-15, atol=0)

    def test_the_largest_sheet_is_read_and_others_are_named(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.xlsx", {"about": [["rig", "A"], ["mass [kg]", 12.0]], "run 1": ROWS})
        recording = read_recording(path)
        assert [c.name for c in recording.channels] == ["seat [mm]"]
        assert "another sheet, of 2 rows" in str(dict(recording.left_out)["sheet about"])

    def test_numbers_may_be_text_with_decimal_commas(self, tmp_path: Path) -> None:
        rows = [ROWS[0], *([f"{t:.2f}".replace(".", ","), f"{y:.6f}".replace(".", ",")] for t, y in ROWS[1:])]
        recording = read_recording(written(tmp_path / "r.xlsx", {"run": rows}))
        assert np.allclose(recording["seat [mm]"].values, [row[1] for row in ROWS[1:]], rtol=0, atol=1e-6)

    def test_hidden_sheets_are_not_read(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.xlsx", {"secret": ROWS + ROWS[1:], "run": ROWS}, hidden="secret")
        recording = read_recording(path)
        assert len(recording["seat [mm]"].values) == len(T)
        assert "sheet secret" not in dict(recording.left_out)

    def test_lines_are_numbered_as_rows_are(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.xlsx", {"run": [["Logger 7"], *ROWS]}, above=3)
        assert "line 4" in dict(read_recording(path).left_out)

    def test_dates_and_durations_are_times(self, tmp_path: Path) -> None:
        first = datetime(2024, 3, 1, 12, 0, 0)
        for stamps in ([first + timedelta(seconds=k) for k in range(60)], [timedelta(seconds=k) for k in range(60)]):
            rows = [["time", "seat"], *([stamp, row[1]] for stamp, row in zip(stamps, ROWS[1:], strict=True))]
            record = read_record(written(tmp_path / "r.xlsx", {"run": rows}))
            assert np.allclose(np.diff(record.time), 1.0)

    def test_markup_stays_text(self, tmp_path: Path) -> None:
        rows = [["time [s]", "<b>=1+1"], *ROWS[1:]]
        path = written(tmp_path / "r.xlsx", {"run": rows})
        assert [c.name for c in read_recording(path).channels] == ["<b>=1+1"]

    def test_what_holds_no_numbers_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="has no sheet with numbers"):
            read_recording(written(tmp_path / "r.xlsx", {"run": [["a", "b"], ["c", "d"]], "empty": []}))

    def test_what_is_no_workbook_is_damaged(self, tmp_path: Path) -> None:
        for content in (b"", b"PK\x03\x04 cut off", b"time,seat\n0,1\n"):
            (tmp_path / "r.xlsx").write_bytes(content)
            with pytest.raises(RecordError, match=r"r\.xlsx: is (damaged|empty)"):
                read_recording(tmp_path / "r.xlsx")

    @pytest.mark.parametrize(("row", "column", "gib"), [(1_048_576, 16_384, "512"), (20_000, 16_384, "9.77")])
    def test_a_cell_far_from_the_others_is_refused(self, row: int, column: int, gib: str, tmp_path: Path) -> None:
        """All cells between would be made: the library that reads them ends the program if there is no memory."""
        path = written(tmp_path / "r.xlsx", {"run": ROWS})
        book = openpyxl.load_workbook(path)
        book["run"].cell(row, column, 1.0)
        book.save(path)
        with pytest.raises(RecordError, match=rf"lie {row} rows and {column} columns apart: .* {gib}.* GiB.*delete"):
            read_recording(path)

    def test_columns_far_to_the_right_are_read(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.xlsx", {"run": [[*[None] * 200, *row] for row in ROWS]})
        assert read_record(path).y.shape == (1, 60)

    def test_a_bomb_is_refused_before_it_is_unpacked(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.xlsx", {"run": ROWS})
        content = io.BytesIO(path.read_bytes())
        with zipfile.ZipFile(content, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("xl/bomb.xml", "w") as stream:
            for _ in range(600):
                stream.write(bytes(1 << 20))
        path.write_bytes(content.getvalue())
        with pytest.raises(RecordError, match="GiB of memory"):
            read_recording(path)
