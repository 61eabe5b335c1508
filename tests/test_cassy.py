"""Files of CASSY Lab: quantities stated line by line above a table, spectra and fits below it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from suspid import read_recording
from suspid.words import LeftOut

STEP, ROWS, BINS = 0.01, 300, 64
TIMES = np.arange(ROWS) * STEP
VOLTS = np.exp(-0.3 * TIMES) * np.cos(12 * TIMES)
# The line below each unit is about the axis of a plot.
AXIS = "-3 3 1 0 3 0 0 0 0 1 1 0 0 0.5 1 1"
MEASURED, COMPUTED, SPECTRUM = "0 1 0 1", "10 1 -1 2*U_A1", "10 4 0 0"
BY_SENSOR = "1 0 0 0 1 0 3 0 0 0 0 0 0 0 0 2500 0 0 0 1 344 55 297 140 0.5 0 0 1 0"


def lab(
    quantities: Sequence[tuple[str, str, str, str]],
    columns: Sequence[np.ndarray],
    *,
    unit: str = "s",
    below: str = "1 0\n1 0 0\n-1\n0\n",
    times: np.ndarray = TIMES,
) -> str:
    """A file with these quantities: how each is measured, its name, symbol and unit."""
    always = [("Index", "n", ""), ("Zeit", "t", unit), ("Frequenz", "f", "Hz")]
    head = "".join(f"{name}\n{symbol}\n{of}\n{AXIS}\n" for name, symbol, of in always)
    stated = "".join(f"{how}\n{BY_SENSOR}\n{name}\n{symbol}\n{of}\n{AXIS}\n" for how, name, symbol, of in quantities)
    rows = (
        "\t".join([str(k + 1), f"{t:.6g}", *(f"{values[k]:.6g}" for values in columns)]) + "\t\n"
        for k, t in enumerate(times)
    )
    return (
        f"CL4\n180 0.1\n{head}{len(quantities)} 1\n{stated}{2 + len(columns)} {len(times)}\n{''.join(rows)}{below}"
    ).replace("\n", "\r\n")


def saved(folder: Path, text: str) -> Path:
    path = folder / "swing.lab"
    path.write_bytes(text.encode("cp1252"))
    return path


VOLTAGE = (MEASURED, "Spannung", "U_A1", "V")


class TestNames:
    def test_they_are_the_symbols_of_the_header_with_its_units(self, tmp_path: Path) -> None:
        computed = (COMPUTED, "neue Größe", "d", "Torr")
        recording = read_recording(saved(tmp_path, lab([VOLTAGE, computed], [VOLTS, 2 * VOLTS])))
        assert [(channel.name, channel.unit) for channel in recording.channels] == [("U_A1", "V"), ("d", "Torr")]
        assert recording["d"].values == pytest.approx(2 * VOLTS, abs=1e-5)
        assert recording["U_A1"].timepts == pytest.approx(TIMES)

    @pytest.mark.parametrize("unit", ["s", "ms", "min"])
    def test_times_are_stored_in_seconds_whatever_the_display_shows(self, tmp_path: Path, unit: str) -> None:
        recording = read_recording(saved(tmp_path, lab([VOLTAGE], [VOLTS], unit=unit)))
        assert recording["U_A1"].timepts == pytest.approx(TIMES)
        assert dict(recording.left_out).keys() == {"n"}

    def test_a_temperature_is_no_time(self, tmp_path: Path) -> None:
        """Beside the samples stands how often each of some temperatures occurred."""
        temperature = (COMPUTED, "Temperatur", "T_B1", "K")
        steps = np.where(np.arange(ROWS) < 3, 297 + np.arange(ROWS) / 2, np.nan)
        recording = read_recording(saved(tmp_path, lab([VOLTAGE, temperature], [VOLTS, steps])))
        assert recording.names[0] == "U_A1"
        assert LeftOut.LIKE_TIME not in [why.code for _, why in recording.left_out]

    def test_slow_records_are_no_milliseconds(self, tmp_path: Path) -> None:
        recording = read_recording(saved(tmp_path, lab([VOLTAGE], [VOLTS], unit="min", times=100 * TIMES)))
        assert recording["U_A1"].mean_rate == pytest.approx(1)

    def test_a_header_that_does_not_fit_the_table_names_nothing(self, tmp_path: Path) -> None:
        text = lab([VOLTAGE, VOLTAGE], [VOLTS])
        recording = read_recording(saved(tmp_path, text), time="column 2")
        assert recording.names == ("column 3",)

    def test_another_text_that_begins_so_is_read_as_it_was(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csv"
        path.write_text("CL4\nt,seat\n" + "".join(f"{t:.2f},{y:.4f}\n" for t, y in zip(TIMES, VOLTS, strict=True)))
        assert read_recording(path).names == ("seat",)

    @pytest.mark.parametrize("counts", ["3 " + 5000 * "9", "0 300", "300", "x"])
    def test_damaged_counts_are_no_crash(self, tmp_path: Path, counts: str) -> None:
        text = lab([VOLTAGE], [VOLTS]).replace(f"\r\n3 {ROWS}\r\n", f"\r\n{counts}\r\n")
        assert read_recording(saved(tmp_path, text), time="column 2")["column 3"].values.size == ROWS


class TestTables:
    """Spectra have no column in the table of samples, but a table of their own behind it."""

    SPECTRUM = "".join(f"{k / 6:.6f}\t{1 / (1 + (k - 40) ** 2):.6f}\t\n" for k in range(BINS))

    @pytest.mark.parametrize("end", ["1 0 0\n-1\n0\n", "1 0 0\n-1\n0 1 C0 -1 -1 0.35", ""])
    def test_a_spectrum_is_left_out_and_named(self, tmp_path: Path, end: str) -> None:
        quantities = [VOLTAGE, (SPECTRUM, "neue Größe", "f_1", "V")]
        text = lab(quantities, [VOLTS], below=f"2 {BINS}\n{self.SPECTRUM}{end}")
        recording = read_recording(saved(tmp_path, text))
        assert recording.names == ("U_A1",)
        assert recording["U_A1"].values.size == ROWS
        first = text.count("\r\n", 0, text.index(f"\n2 {BINS}\r")) + 2
        (why,) = (each for name, each in recording.left_out if name == f"lines {first} to {first + BINS}")
        assert (why.code, why.numbers["lines"]) == (LeftOut.OTHER_TABLE, BINS + 1)
        assert dict(recording.left_out).keys() == {"n", "encoding", f"lines {first} to {first + BINS}"}

    def test_a_spectrum_before_other_quantities_takes_no_name_of_theirs(self, tmp_path: Path) -> None:
        quantities = [(SPECTRUM, "FFT", "F", "V"), VOLTAGE]
        recording = read_recording(saved(tmp_path, lab(quantities, [VOLTS])))
        assert recording.names == ("U_A1",)

    def test_rows_that_are_missing_are_said(self, tmp_path: Path) -> None:
        text = lab([VOLTAGE], [VOLTS])
        cut = text[: text.index("\n251\t") + 1]
        recording = read_recording(saved(tmp_path, cut))
        assert recording["U_A1"].values.size == 250
        assert "has 250 of the 300 rows" in str(dict(recording.left_out)["table"])

    def test_errors_name_the_line_of_the_file(self, tmp_path: Path) -> None:
        text = lab([VOLTAGE], [VOLTS]).replace("\r\n100\t0.99\t", "\r\n100\t0.99\tx\t")
        number = text.count("\n", 0, text.index("\tx\t")) + 1
        with pytest.raises(Exception, match=f"line {number} has "):
            read_recording(saved(tmp_path, text))
