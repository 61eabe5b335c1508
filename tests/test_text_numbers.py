"""Numbers of text files, by each of the readers of numbers."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from suspid import RecordError, read_recording
from suspid.io.text.dialects import DIALECTS, shapes


def told_with(monkeypatch: pytest.MonkeyPatch, limit: str, path: Path) -> list[object]:
    """Return what a file holds, or why it is refused, with one limit of `numbers` at nothing and without any."""
    told: list[object] = []
    for size in (0, 1 << 62):
        monkeypatch.setattr(f"suspid.io.text.numbers.{limit}", size)
        try:
            found = read_recording(path)
            told.append((found.left_out, [channel.values.tobytes() for channel in found.channels]))
        except RecordError as error:
            told.append(str(error))
    return told


class TestNumbers:
    """Every number is the double next to it, which Python's own reading of a float is, whichever reader took it."""

    @staticmethod
    def text(mark: str, decimal: str) -> tuple[str, list[list[float]]]:
        rng = np.random.default_rng(3)
        mantissas, powers = rng.uniform(-10, 10, (6000, 3)), rng.integers(-320, 300, (6000, 3))
        cells = [
            [f"{m:.{digits}f}e{p}" for m, p, digits in zip(ms, ps, (17, 3, 9), strict=True)]
            for ms, ps in zip(mantissas.tolist(), powers.tolist(), strict=True)
        ]
        rows = "".join(mark.join([str(k), *row]).replace(".", decimal) + "\n" for k, row in enumerate(cells))
        return mark.join(["t", "a", "b", "c"]) + "\n" + rows, [[float(cell) for cell in row] for row in cells]

    @pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
    @pytest.mark.parametrize("worth", [0, 1 << 62])
    def test_readers_agree(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mark: str, decimal: str, worth: int
    ) -> None:
        pytest.importorskip("pyarrow")
        monkeypatch.setattr("suspid.io.text.numbers.WORTH_ARROW", worth)
        text, expected = self.text(mark, decimal)
        (tmp_path / "r.csv").write_text(text)
        found = read_recording(tmp_path / "r.csv")
        assert np.array_equal(np.array([found[name].values for name in "abc"]).T, expected)

    @pytest.mark.parametrize("odd", ["", "nan", "1e", "+5", "abc", "1_0", '"7"', "#5"])
    def test_what_one_reader_refuses_is_read_as_before(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, odd: str
    ) -> None:
        pytest.importorskip("pyarrow")
        rows = [f"{k / 10},{k % 7},{k % 3}\n" for k in range(50)]
        rows[30] = f"3.0,{odd},0\n"
        (tmp_path / "r.csv").write_text("".join(["t,a,b\n", *rows]))
        told = told_with(monkeypatch, "WORTH_ARROW", tmp_path / "r.csv")
        assert told[0] == told[1]

    @pytest.mark.parametrize("odd", ["", ",,", "nan,nan,nan", "# cold", "1,,2", "end", "3.0", '3.0,"7",1'])
    @pytest.mark.parametrize("end", ["\n", "", "\n\n", "1\nend of file\n"])
    def test_rows_are_the_same_with_and_without_their_numbers(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, odd: str, end: str
    ) -> None:
        pytest.importorskip("pyarrow.csv")
        monkeypatch.setattr("suspid.io.text.numbers.WORTH_ARROW", 0)
        rows = [f"{k / 10},{k % 7:.3f},{k % 3:.3f}" for k in range(50)]
        rows[30] = odd
        (tmp_path / "r.csv").write_text("\n".join(["t,a,b", *rows]) + end)
        told = told_with(monkeypatch, "HELD_TWICE", tmp_path / "r.csv")
        assert told[0] == told[1]

    @pytest.mark.parametrize("minus", ["-1.5", "\N{MINUS SIGN}1.5"])
    def test_the_minus_of_spreadsheets(self, tmp_path: Path, minus: str) -> None:
        rows = "".join(f"{k / 10},{minus if k % 2 else '1.5'}\n" for k in range(50))
        (tmp_path / "r.csv").write_text(f"t [s],a\n{rows}", encoding="utf-8")
        assert read_recording(tmp_path / "r.csv")["a"].values[:2].tolist() == [1.5, -1.5]


class TestThousands:
    """Marks between thousands are refused where they would be read as decimal signs; decimals never are."""

    @staticmethod
    def read(path: Path, cells: list[str], mark: str = ";") -> list[float]:
        rows = "".join(f"{k}{mark}{cell}\n" for k, cell in enumerate(cells))
        path.write_text(f"time [ms]{mark}a\n{rows}", encoding="utf-8")
        return [float(value) for value in read_recording(path)["a"].values]

    @pytest.mark.parametrize("sign", [".", ","])
    def test_integers_with_marks(self, tmp_path: Path, sign: str) -> None:
        cells = [f"{k:,}".replace(",", sign) for k in range(-1500, 1500, 7)]
        with pytest.raises(RecordError, match=r"'a' contains '-1[.,]500' beside '-\d+'"):
            self.read(tmp_path / "r.csv", cells)

    @pytest.mark.parametrize(
        "cells",
        [
            [f"{k / 8:g}" for k in range(80, 400)],
            [f"{k / 1000:.3f}" for k in range(-1500, 1500, 7)],
            [f"{k / 1000:.6g}" for k in range(1000, 4000, 7)],
            ["0" if k < 20 else f"{k / 7:.3f}" for k in range(300)],
            ["-999" if k % 50 == 3 else f"{1 + k / 7:.3f}" for k in range(300)],
        ],
        ids=["eighths", "three digits", "shortest", "nought", "sentinel"],
    )
    @pytest.mark.parametrize("sign", [".", ","])
    def test_decimals(self, tmp_path: Path, cells: list[str], sign: str) -> None:
        found = self.read(tmp_path / "r.csv", [cell.replace(".", sign) for cell in cells])
        assert found == [float(cell) for cell in cells]

    @pytest.mark.parametrize("mark", [",", "\N{NARROW NO-BREAK SPACE}", "\N{RIGHT SINGLE QUOTATION MARK}"])
    def test_decimals_with_marks_show_the_cell(self, tmp_path: Path, mark: str) -> None:
        cells = [f"{k / 8:,.3f}".replace(",", mark) for k in range(-16000, 16000, 70)]
        with pytest.raises(RecordError, match=r"cells such as '-2.+000\.000' are not numbers"):
            self.read(tmp_path / "r.csv", cells)

    @pytest.mark.parametrize("mark", [" +- ", "+-"])
    def test_values_with_their_uncertainty_are_told(self, tmp_path: Path, mark: str) -> None:
        """Written by hand in a laboratory; there is no mark between thousands in them."""
        with pytest.raises(RecordError, match="hold a value and its uncertainty; write the uncertainty in a column of"):
            self.read(tmp_path / "r.csv", [f"{k}{mark}4" for k in range(60, 400, 7)])


@pytest.mark.parametrize("start", [b"\x1f\x8b\x08\x00", b"PK\x03\x04"])
def test_other_files_under_the_name_of_text_are_told(tmp_path: Path, start: bytes) -> None:
    (tmp_path / "r.csv").write_bytes(start + bytes(range(256)))
    with pytest.raises(RecordError, match=r"it looks like .*\((unpack it|name a spreadsheet .*)\)"):
        read_recording(tmp_path / "r.csv")


@pytest.mark.parametrize("start", ["<Document>\n  <Version>3.8</Version>", '\ufeff<?xml version="1.0"?><cassylab>'])
def test_documents_of_other_programs_are_told(tmp_path: Path, start: str) -> None:
    path = tmp_path / "r.cmbl"
    path.write_text(start + "\n1 2 3\n" * 100, encoding="utf-8")
    with pytest.raises(RecordError, match=r"it looks like a document of another program, in XML \(export its table"):
        read_recording(path)


def test_a_name_that_no_file_can_have_is_told() -> None:
    with pytest.raises(RecordError, match="there is no such file"):
        read_recording("x" * 5000)


@given(st.text("0123456789.,;+-eE\t |", min_size=1, max_size=24))
def test_the_shape_of_a_line_has_the_kinds_of_the_line(line: str) -> None:
    (shape,) = shapes([line])
    for dialect in DIALECTS:
        assert dialect.kinds(shape) == dialect.kinds(line)
