"""Text files: each dialect gives the same numbers, whatever stands around them is told, and nothing is guessed."""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from suspid import RecordError, SuspidError
from suspid.cleaning.conversions import FACTORS
from suspid.io.names import bracketed_unit, stated_rate
from suspid.io.read_recording import read_recording
from suspid.io.text.columns import UNIT
from suspid.io.text.delimited import read_delimited
from suspid.levels import SEVEN_DIGITS
from suspid.recordings import Recording
from suspid.words import DAMAGE, LeftOut, Remark

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FUZZ = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])

TIME = [0.0, 0.5, 1.0, 1.5]
SEAT = [1.5, -2.25, 0.125, 4.0]
PLAIN = "t,seat\n0,1.5\n0.5,-2.25\n1,0.125\n1.5,4\n"
COMMA = PLAIN.replace(",", ";").replace(".", ",")
# What writes so, the text, the unit of the seat, and what must be told.
DIALECTS: dict[str, tuple[str | bytes, str, tuple[str, ...]]] = {
    "comma": (PLAIN, "", ()),
    "semicolon": (PLAIN.replace(",", ";"), "", ()),
    "tab": (PLAIN.replace(",", "\t"), "", ()),
    "blanks": (PLAIN.replace(",", "    "), "", ()),
    "one blank": (PLAIN.replace(",", " "), "", ()),
    "columns of blanks": ("  t      seat\n 0.0     1.5\n 0.5   -2.25\n 1.0   0.125\n 1.5    4.00\n", "", ()),
    "decimal comma, semicolon": (COMMA, "", ()),
    "decimal comma, tab": (COMMA.replace(";", "\t"), "", ()),
    "decimal comma, blanks": (COMMA.replace(";", "   "), "", ()),
    "decimal comma, quoted": ('"t","seat"\n"0,0","1,5"\n"0,5","-2,25"\n"1,0","0,125"\n"1,5","4,0"\n', "", ()),
    "quoted": ('"t","seat"\n"0","1.5"\n"0.5","-2.25"\n"1","0.125"\n"1.5","4"\n', "", ()),
    "delimiters at the end": (PLAIN.replace("\n", ",\n"), "", ()),
    "delimiters at the end of rows": (PLAIN.replace("\n", ",\n").replace("seat,", "seat"), "", ()),
    "delimiter at the end of the header": (PLAIN.replace("seat", "seat,"), "", ()),
    "UTF-8 with a mark": (b"\xef\xbb\xbf" + PLAIN.encode(), "", ()),
    "UTF-16": (PLAIN.encode("utf-16"), "", ("encoding",)),
    "UTF-16, big end first": (b"\xfe\xff" + PLAIN.encode("utf-16-be"), "", ("encoding",)),
    "Windows-1252": (PLAIN.replace("seat", "seat [µm]").encode("cp1252"), "µm", ("encoding",)),
    "brackets": (PLAIN.replace("seat", "seat [mm]"), "mm", ()),
    "parentheses": (PLAIN.replace("t,seat", '"Time (s)","Seat (m/s^2)"'), "m/s^2", ()),
    "a unit as part of the name": (PLAIN.replace("seat", "a_seat_m/s2"), "m/s2", ()),
    "a word that may be a unit": (PLAIN.replace("seat", "seat_m"), "", ()),
    "row of units": (PLAIN.replace("seat\n", "seat\ns,m/s²\n"), "m/s²", ()),
    "row of units in brackets": (PLAIN.replace("seat\n", "seat\n[s],[mm]\n"), "mm", ()),
    "row of units, two of them no units": (
        "t,seat,State at A,State at B\ns,mm,State,State\n\n0,1.5,a,b\n0.5,-2.25,b,b\n1,0.125,b,a\n1.5,4,a,a\n",
        "mm",
        ("State at A", "State at B"),
    ),
    "commas behind names": ("# t, \t seat,\n0\t1.5\n0.5\t-2.25\n1\t0.125\n1.5\t4\n", "", ()),
    "banner": (f"Logger 3000\nSerial: 12345\nOperator, A. N. Other\n\n{PLAIN}", "", ("line 1", "line 2", "line 3")),
    "comments": ("# made by hand\n" + PLAIN.replace("1,0.125", "% bump\n1,0.125"), "", ("line 1", "line 5")),
    "header as a comment": ("# " + PLAIN, "", ()),
    "many lines above": ("note\n" * 30 + PLAIN, "", ("lines 1 to 30",)),
    "two rows of names": ("group,first\n" + PLAIN, "", ("line 1",)),
    "footer": (PLAIN + "End of data\nSamples: 4\n\n", "", ("line 6", "line 7")),
    "blank lines": (PLAIN.replace("\n", "\n\n") + "\n \n", "", ("line 4",)),
    "cut short": (PLAIN + "2", "", ("line 6",)),
    "rows counted": (",t,seat\n0,0,1.5\n1,0.5,-2.25\n2,1,0.125\n3,1.5,4\n", "", ("column 1",)),
    "remarks": ("t,seat,note\n0,1.5,go\n0.5,-2.25,\n1,0.125,\n1.5,4,end\n", "", ("note",)),
    "milliseconds": ("millis,seat\n0,1.5\n500,-2.25\n1000,0.125\n1500,4\n", "", ()),
    "Fortran": ("t seat\n0.0D0 1.5D0\n5.0D-1 -2.25D+00\n1.0D0 1.25d-01\n0.15D1 4D0\n", "", ()),
    "ISO 8601": (
        "Timestamp,seat\n2024-05-03T23:59:59.250Z,1.5\n2024-05-03T23:59:59.750Z,-2.25\n"
        "2024-05-04T00:00:00.250Z,0.125\n2024-05-04T00:00:00.750Z,4\n",
        "",
        ("Timestamp",),
    ),
    "German date": (
        "Datum/Zeit;seat\n03.05.2024 12:34:56,123;1,5\n03.05.2024 12:34:56,623;-2,25\n"
        "03.05.2024 12:34:57,123;0,125\n03.05.2024 12:34:57,623;4\n",
        "",
        ("Datum/Zeit",),
    ),
    "date and time apart, over midnight": (
        "Date,Time,seat\n03.05.2024,23:59:59.250,1.5\n03.05.2024,23:59:59.750,-2.25\n"
        "04.05.2024,00:00:00.250,0.125\n04.05.2024,00:00:00.750,4\n",
        "",
        ("Date", "Time"),
    ),
    "a date between apostrophes": (
        "time\tseat\n'12-Dec-2022 14:40:03.041'\t1.5\n'12-Dec-2022 14:40:03.541'\t-2.25\n"
        "'12-Dec-2022 14:40:04.041'\t0.125\n'12-Dec-2022 14:40:04.541'\t4\n",
        "",
        ("time",),
    ),
    "a header of its own kind": (
        "# Simple Text Format\n# Sampling Rate (Hz):= 2.00\n# Labels:= seat\tnote\n"
        "1.5\tgo\n-2.25\tgo\n0.125\tgo\n4\tgo\n",
        "",
        ("line 1", "line 2", "note"),
    ),
    "months first": (
        "time,seat\n5/13/2024 11:59:59 PM,1.5\n5/13/2024 11:59:59.5 PM,-2.25\n"
        "5/14/2024 12:00:00 AM,0.125\n5/14/2024 12:00:00.5 AM,4\n",
        "",
        ("time",),
    ),
    "Arduino": (
        "12:34:56.250 -> 1.5\n12:34:56.750 -> -2.25\n12:34:57.250 -> 0.125\n12:34:57.750 -> 4\n",
        "",
        ("column 1",),
    ),
    "phyphox": (
        '"Time (s)","Acceleration x (m/s^2)"\n0.0E0,1.500000000E0\n5.0E-1,-2.250000000E0\n1.0E0,1.25E-1\n1.5E0,4.0E0\n',
        "m/s^2",
        (),
    ),
    "Sensor Logger": (
        "time,seconds_elapsed,seat\n1714732496000000000,0.0,1.5\n1714732496500000000,0.5,-2.25\n"
        "1714732497000000000,1.0,0.125\n1714732497500000000,1.5,4\n",
        "",
        ("time",),
    ),
    "matrix": ("[ 0 1.5;\n 0.5 -2.25;\n 1 0.125;\n 1.5 4 ]\n".replace("[", "t seat\n\n["), "", ()),
    "matrix with a name": ("% t seat\ndata = [\n0 1.5;\n0.5 -2.25;\n1 0.125;\n1.5 4;\n];\n", "", ()),
    "raw export of a controller": (
        "\n\nController 5\n\n\n Sample   Time  Seat\n\n\n"
        "[ 0  0.0 1.5;\n  1  0.5 -2.25;\n  2  1.0 0.125;\n  3  1.5 4;\n]\n",
        "",
        ("line 3", "Sample"),
    ),
    "LabVIEW": (
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nX_Value\tseat\tComment\n"
        + PLAIN.split("\n", 1)[1].replace(",", "\t"),
        "",
        ("line 1", "line 2", "line 3"),
    ),
}


def read(folder: Path, content: str | bytes, **options: object) -> Recording:
    path = folder / "r.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_recording(path, **options)  # type: ignore[arg-type]  # whatever the test gives


class TestEveryDialectSaysTheSame:
    @pytest.mark.parametrize("name", DIALECTS)
    def test_numbers_unit_and_what_is_told(self, tmp_path: Path, name: str) -> None:
        content, unit, told = DIALECTS[name]
        recording = read(tmp_path, content)
        (seat,) = recording.channels
        assert seat.values.tolist() == SEAT
        assert seat.timepts.tolist() == TIME
        assert seat.unit == unit
        assert tuple(what for what, _ in recording.left_out) == told

    @FUZZ
    @given(
        rows=st.lists(st.tuples(*[st.floats(allow_infinity=False)] * 3), min_size=2, max_size=8),
        delimiter=st.sampled_from(["\t", ";", ",", "  "]),
        comma=st.booleans(),
        missing=st.sampled_from(["nan", "-nan", "NaN", "#N/A", "---", "-1.#IND"]),
        units=st.booleans(),
        end=st.sampled_from(["\n", "\r\n", "\r"]),
    )
    def test_any_numbers(
        self,
        scratch: Path,
        rows: list[tuple[float, ...]],
        delimiter: str,
        comma: bool,
        missing: str,
        units: bool,
        end: str,
    ) -> None:
        cells = [[missing if value != value else repr(value) for value in row] for row in rows]
        if comma and delimiter == ",":
            return  # no file: what parts the cells cannot be told from what stands before decimals
        lines = [[cell.replace(".", ",") if comma and cell != missing else cell for cell in row] for row in cells]
        head = [["x", "y", "z"], *([["m", "m/s", "g"]] if units else [])]
        if all(value != value for row in rows for value in row):
            return  # no row of numbers
        recording = read(scratch, end.join(delimiter.join(line) for line in [*head, *lines]), fs=10)
        assert recording.names == ("x", "y", "z")
        np.testing.assert_array_equal([channel.values for channel in recording.channels], np.array(rows).T)

    @pytest.mark.skipif(not DATA.exists(), reason="no shared data")
    @pytest.mark.parametrize("name", ["release", "step50mm", "chirp"])
    def test_a_simulated_car_as_numpy_reads_it(self, name: str) -> None:
        path = DATA / "rizoit_seat3dof_sim" / f"{name}.csv"
        recording = read_recording(path)
        expected = np.loadtxt(path, delimiter=",", skiprows=1)
        assert recording.names == ("z_seat_m", "z_body_m", "z_wheel_m", "a_seat", "a_body", "a_wheel", "z_road_m")
        assert np.array_equal(np.array([channel.values for channel in recording.channels]).T, expected[:, 1:])
        assert np.array_equal(recording.channels[0].timepts, expected[:, 0])


class TestNamesOfSeveralWords:
    def test_over_columns_of_fixed_width(self, tmp_path: Path) -> None:
        text = (
            " Sample   Time Commanded Pos Encoder 1 Pos\n"
            "      0  0.000             0             2\n"
            "      1  0.009             5            13\n"
            "      2  0.018             7            -4\n"
        )
        recording = read(tmp_path, text)
        assert recording.names == ("Commanded Pos", "Encoder 1 Pos")
        assert recording["Encoder 1 Pos"].values.tolist() == [2, 13, -4]
        assert recording["Encoder 1 Pos"].timepts.tolist() == [0, 0.009, 0.018]
        assert dict(recording.left_out)["Sample"].code is LeftOut.ROW_COUNTER

    @pytest.mark.parametrize("name", ["Unnamed: 0", "index"])
    def test_the_index_of_rows_that_were_picked_is_no_channel(self, tmp_path: Path, name: str) -> None:
        rows = "".join(f"{1 + 3 * k},{k / 60:.9f},{np.exp(-k / 30) * np.cos(k):.9f}\n" for k in range(60))
        path = tmp_path / "a.csv"
        path.write_text(f"{name},time,x\n{rows}", encoding="utf-8")
        recording = read_recording(path)
        assert [channel.name for channel in recording.channels] == ["x"]
        assert dict(recording.left_out)[name].code is LeftOut.ROW_COUNTER

    def test_parted_by_several_blanks(self, tmp_path: Path) -> None:
        assert read(tmp_path, "Time  Encoder 1 Pos\n0 2\n1 3\n2 5\n").names == ("Encoder 1 Pos",)


class TestWithoutNames:
    """Where nothing is named, the first column is time if it rises evenly and does not count the rows."""

    @pytest.mark.parametrize("digits", [3, 4, 9])
    @pytest.mark.parametrize("rate", [100.0, 113.1, 887.14])
    def test_the_first_column_is_time(self, tmp_path: Path, rate: float, digits: int) -> None:
        text = "".join(f"{k / rate:.{digits}f} {np.sin(k):.6f}\n" for k in range(300))
        (channel,) = read(tmp_path, text).channels
        assert channel.name == "column 2"
        assert channel.timepts.tolist() == [float(f"{k / rate:.{digits}f}") for k in range(300)]

    @pytest.mark.parametrize("first", ["{k}", "{x}"], ids=["counts", "random"])
    def test_another_one_is_not(self, tmp_path: Path, first: str) -> None:
        rng = np.random.default_rng(5)
        rows = [first.format(k=k, x=rng.random()) for k in range(200)]
        with pytest.raises(RecordError, match="no column is named like a time"):
            read(tmp_path, "".join(f"{row} {rng.random()}\n" for row in rows))
        # A counter is no channel either.
        names = ("column 2",) if first == "{k}" else ("column 1", "column 2")
        assert read(tmp_path, "".join(f"{row} {rng.random()}\n" for row in rows), fs=10).names == names

    def test_an_uneven_first_column_is_time_beside_one_that_swings(self, tmp_path: Path) -> None:
        """As a tracked video is written; beside a loop of force it may be the displacement."""
        steps = np.tile([1.0, 0.5, 1.0, 1.5], 50)
        steps[::40] = 0.35
        stamps = np.cumsum(steps)
        text = "".join(f"{t:.2f} {np.sin(0.5 * t):.6f}\n" for t in stamps)
        recording = read(tmp_path, text)
        assert recording.names == ("column 2",)
        assert str(dict(recording.left_out)["column 1"]) == "increases like a clock: taken as the time"
        with pytest.raises(RecordError, match="no column is named like a time"):
            read(tmp_path, "".join(f"{t:.2f} {np.sin(0.01 * t):.6f}\n" for t in stamps))
        with pytest.raises(RecordError, match="no column is named like a time"):
            read(tmp_path, "".join(f"{t:.2f} {np.sin(0.5 * t):.6f} {t**2}\n" for t in stamps))
        # The way of a car that rolls to a stop, and a counter of what comes by chance.
        way = 10 * (1 - np.exp(-np.arange(200) / 100))
        chance = np.cumsum(np.random.default_rng(1).exponential(1.0, 200))
        for rising in (way, chance):
            with pytest.raises(RecordError, match="no column is named like a time"):
                read(tmp_path, "".join(f"{x:.5f} {np.sin(0.5 * k):.6f}\n" for k, x in enumerate(rising)))

    def test_a_word_in_a_slow_channel_is_no_setting(self, tmp_path: Path) -> None:
        rows = [
            f"{0.05 * k:.2f},{np.sin(k):.5f},{'FAULT' if k == 40 else f'{k:.1f}' if not k % 20 else ''}"
            for k in range(400)
        ]
        with pytest.raises(RecordError, match="FAULT"):
            read(tmp_path, "t,seat,temp\n" + "\n".join(rows) + "\n")

    def test_settings_beside_the_first_rows_are_no_channels(self, tmp_path: Path) -> None:
        """As Tektronix writes them, beside the time and the samples."""
        settings = ["Record Length,200,", "Sample Interval,0.05,", ",,", "Source,CH1,", "Vertical Units,V,"]
        rows = [f"{cells},{0.05 * k:.6f},{np.sin(k):.5f},\n" for k, cells in enumerate(settings + [",,"] * 195)]
        recording = read(tmp_path, "".join(rows))
        assert recording.names == ("column 5",)
        assert np.allclose(recording.channels[0].timepts, 0.05 * np.arange(200))
        assert set(dict(recording.left_out)) == {"column 1", "column 2", "column 3", "column 4"}

    def test_a_clock_that_waits_between_two_samples(self, tmp_path: Path) -> None:
        stamps = np.cumsum(np.random.default_rng(6).uniform(0.1, 0.104, 200))
        text = "".join(f"{t:.6f}, {np.sin(t):.6f}\n" for t in stamps)
        recording = read(tmp_path, text)
        assert recording.names == ("column 2",)
        assert np.allclose(recording.channels[0].timepts, stamps, atol=1e-6)
        assert str(dict(recording.left_out)["column 1"]) == "increases like a clock: taken as the time"


class TestBlanksAmongTabs:
    """An editor, or a hand, has put blanks where the other rows have tabs."""

    LINES = tuple(f"{20 * k}\t{round(100 * np.cos(k))}" for k in range(40))

    def lines(self, *blank: int) -> list[str]:
        return [line.replace("\t", "  ") if k in blank else line for k, line in enumerate(self.LINES)]

    @pytest.mark.parametrize("blank", [(0,), (17,), (39,), (0, 17, 18, 39)])
    @pytest.mark.parametrize("head", ["", "# a swing\n", "t [ms]\tseat\n"])
    def test_are_rows(self, tmp_path: Path, head: str, blank: tuple[int, ...]) -> None:
        recording = read(
            tmp_path, head + "\n".join(self.lines(*blank)) + "\n", time="t [ms]" if "seat" in head else "column 1"
        )
        (channel,) = recording.channels
        assert channel.values.tolist() == [round(100 * np.cos(k)) for k in range(40)]
        np.testing.assert_allclose(channel.timepts, 0.02 * np.arange(40))

    def test_counts_above_and_below_are_none(self, tmp_path: Path) -> None:
        recording = read(tmp_path, "\n".join(["50 2", *self.LINES, "40 2"]) + "\n", time="column 1")
        assert recording["column 2"].values.size == 40
        assert {"line 1", "line 42"} <= set(dict(recording.left_out))

    @pytest.mark.parametrize("odd", ["340", "340 1 2", "340 x"])
    def test_lines_of_other_cells_are_refused(self, tmp_path: Path, odd: str) -> None:
        lines = self.lines()
        lines[17] = odd
        with pytest.raises(RecordError, match="line 18 has 1 cells"):
            read(tmp_path, "\n".join(lines) + "\n", time="column 1")


class TestExports:
    def test_a_rule_below_the_header(self, tmp_path: Path) -> None:
        recording = read(tmp_path, "Time(s), Angle(deg)\n-------------------\n0.0, 1.5\n0.5, 2.5\n1.0, 3\n")
        assert recording.names == ("Angle(deg)",)

    def test_lines_of_empty_quotes_below_the_header(self, tmp_path: Path) -> None:
        rows = "".join(f"{t},{y},{-y}\n" for t, y in zip(TIME, SEAT, strict=True))
        (tmp_path / "a.csv").write_text('Time,AccX,AccY\n""\n""\n' + rows, encoding="utf-8")
        assert [channel.name for channel in read_recording(tmp_path / "a.csv").channels] == ["AccX", "AccY"]

    def test_a_time_before_each_channel(self, tmp_path: Path) -> None:
        rows = "".join(f"{k / 4},{k},{k / 4},{-k},{k / 2},{2 * k}\n" for k in range(9))
        head = '"Time - Road (m)","Road (m)","Time - Body (m)","Body (m)","Time - Hub (m)","Hub (m)"\n'
        recording = read(tmp_path, head + rows)
        assert recording.names == ("Road (m)", "Body (m)", "Hub (m)")
        assert recording["Body (m)"].timepts.tolist() == [k / 4 for k in range(9)]
        assert recording["Hub (m)"].timepts.tolist() == [k / 2 for k in range(9)]

    def test_a_step_beside_the_columns(self, tmp_path: Path) -> None:
        head = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-3e-07,2.0e-03\n"
        recording = read(tmp_path, head + "".join(f"{k},{k * k},{-k},\n" for k in range(9)))
        assert recording.names == ("CH1", "CH2")
        assert recording["CH1"].unit == "Volt"
        assert recording["CH1"].mean_rate == 500
        assert recording["CH1"].timepts == pytest.approx(-3e-7 + np.arange(9) / 500, rel=1e-12)

    @pytest.mark.parametrize("rows", ["{0},{1},\n", "{0},{1}\n"])
    def test_names_of_settings_without_values_name_no_column(self, tmp_path: Path, rows: str) -> None:
        text = "CH1,CH2,Start,Increment,\n" + "".join(rows.format(k * k / 8, -k / 8) for k in range(30))
        recording = read(tmp_path, text, fs=500)
        assert recording.names == ("CH1", "CH2")
        assert recording["CH2"].values.tolist() == [-k / 8 for k in range(30)]

    @pytest.mark.parametrize("mark", [".", ","])
    def test_a_step_for_each_channel_and_no_times(self, tmp_path: Path, mark: str) -> None:
        head = "LabVIEW Measurement\t\nX_Columns\tNo\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
        head += "Delta_X\t2.0E-3\t2.0E-3\t\n***End_of_Header***\t\t\t\nX_Value\tseat\ttire\tComment\n"
        rows = "".join(f"\t{k * k / 8}\t{-k / 8}\n" for k in range(30))
        recording = read(tmp_path, (head + rows).replace(".", mark))
        assert recording.names == ("seat", "tire")
        assert recording["seat"].mean_rate == 500
        assert dict(recording.left_out)["X_Value"].code is LeftOut.NO_NUMBERS

    @pytest.mark.parametrize("between", [", ", "\t", ";", "|"])
    @pytest.mark.parametrize("first", [-90.36, 5.0])
    def test_settings_above_a_single_column(self, tmp_path: Path, first: float, between: str) -> None:
        rows = "".join(f"{first + k * k / 8:.3f}\n" for k in range(40))
        head = "trigger_start_deg, sample_rate, duration_sec\n90, 1000, 5 \n".replace(", ", between)
        recording = read(tmp_path, head + rows)
        assert recording.names == ("column 1",)
        assert recording["column 1"].mean_rate == 1000
        assert recording["column 1"].values[0] == first

    def test_lines_that_begin_with_a_tab_have_no_empty_column(self, tmp_path: Path) -> None:
        rows = "".join(f"\t{np.sin(k):.6f}\n" for k in range(40))
        assert dict(read(tmp_path, rows, fs=500).left_out) == {}
        named = read(tmp_path, "force\tseat\n" + rows, fs=500)
        assert dict(named.left_out)["force"].code is LeftOut.NO_NUMBERS

    def test_the_label_of_units_is_not_that_of_time(self, tmp_path: Path) -> None:
        head = "LabVIEW Measurement,\nSeparator,Comma\n***End_of_Header***,\n,\nY_Unit_Label,g,\nX_Dimension,Time,\n"
        rows = "".join(f"{k / 500:.6f},{np.sin(k):.6f}\n" for k in range(40))
        recording = read(tmp_path, head + "***End_of_Header***,,\nX_Value,Acceleration,Comment\n" + rows)
        assert recording.names == ("Acceleration",)
        assert recording["Acceleration"].unit == "g"
        assert recording["Acceleration"].mean_rate == pytest.approx(500)

    def test_a_comment_behind_the_first_row_is_no_cell_of_the_others(self, tmp_path: Path) -> None:
        head = "LabVIEW Measurement\t\nX_Columns\tOne\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
        head += "Delta_X\t0.002\t0.002\t\n***End_of_Header***\t\t\t\nX_Value\tseat\ttire\tComment\n"
        rows = [f"{k / 500:.6f}\t{k * k / 8}\t{-k / 8}" for k in range(30)]
        rows[0] += "\tName of acquisition vi: C:\\\\drop test, 3.vi"
        recording = read(tmp_path, head + "\n".join(rows) + "\n")
        assert recording.names == ("seat", "tire")
        assert [channel.values.size for channel in recording.channels] == [30, 30]
        assert dict(recording.left_out)["Comment"].code is LeftOut.TEXT

    @pytest.mark.parametrize(
        "events", [{0: ", DAQ Start", 29: ", DAQ Pause, DAQ Stop"}, {29: ", DAQ Stop"}, {0: ", DAQ Start"}]
    )
    def test_events_behind_some_rows_are_cells_of_a_last_column(self, tmp_path: Path, events: dict[int, str]) -> None:
        head = "Header Size:  7\nSampling Rate:  1000\nSample Number, Date/Time, CHANNEL0, CHANNEL1, Events\n"
        rows = [
            f"    {k + 1},   06/29/2022 04:05:36.{674 + k} PM, {-k * k / 8}, {k / 8}{events.get(k, '')}"
            for k in range(30)
        ]
        recording = read(tmp_path, (head + "\n".join(rows) + "\n").replace("\n", "\r\n"))
        assert recording.names == ("CHANNEL0", "CHANNEL1")
        assert recording["CHANNEL0"].values.tolist() == [-k * k / 8 for k in range(30)]
        said = {name: remark.code for name, remark in recording.left_out}
        assert said["Events"] is LeftOut.TEXT
        assert said["Sample Number"] is LeftOut.ROW_COUNTER

    def test_a_number_in_the_first_row_alone_is_no_channel(self, tmp_path: Path) -> None:
        rows = "".join(f"{k / 500},{k % 7},{'500' if not k else ''},{k % 3}\n" for k in range(40))
        recording = read(tmp_path, "t,seat,fs,tire\n" + rows)
        assert recording.names == ("seat", "tire")
        assert dict(recording.left_out)["fs"].code is LeftOut.NUMBER

    def test_raw_can_frames_are_named(self, tmp_path: Path) -> None:
        frames = "".join(f"(1631416514.{717133 + k}) can0 {0xD2 + k:03X}#0000FFFF1000{k:04X}\n" for k in range(30))
        with pytest.raises(RecordError, match="is a log of raw CAN frames; .*dbc="):
            read(tmp_path, frames)

    def test_a_name_too_many_is_no_column_of_events(self, tmp_path: Path) -> None:
        rows = "\n".join(f"{k / 100},{k % 7},{k % 3}" for k in range(60))
        with pytest.raises(RecordError, match="names 4 columns, but the rows have 3 cells"):
            read(tmp_path, f"time,seat,front,left\n{rows}\n")

    @pytest.mark.parametrize("odd", ["degC", "kWh", "U/min", "hPa", "widgets", "l/h"])
    def test_an_unknown_unit_beside_known_ones_is_a_unit(self, tmp_path: Path, odd: str) -> None:
        path = tmp_path / "a.csv"
        rows = "\n".join(f"{k / 100},{k % 7},{k % 3},{20 + k % 2}" for k in range(60))
        path.write_text(f"Time,Body,Wheel,Oil\ns,m/s^2,g,{odd}\n{rows}\n", encoding="utf-8")
        # A temperature is used where it is asked for.
        found = read_recording(path, channels=["Body", "Wheel", "Oil"] if odd == "degC" else None)
        assert found.names == ("Body", "Wheel", "Oil")
        assert [channel.unit for channel in found.channels] == ["m/s^2", "g", odd]
        # A single row of such words holds names.
        path.write_text(f"s,m/s^2,g,{odd}\n{rows}\n", encoding="utf-8")
        assert read_recording(path, time="s").names == ("m/s^2", "g", odd)

    def test_a_row_of_brackets_holds_units(self, tmp_path: Path) -> None:
        recording = read(tmp_path, "Time,Extension,Load\n(s),(mm),(kgf)\n0,1,2\n1,2,3\n2,3,4\n")
        assert [(channel.name, channel.unit) for channel in recording.channels] == [
            ("Extension", "mm"),
            ("Load", "kgf"),
        ]

    def test_the_magnitude_of_three_axes_is_left_out(self, tmp_path: Path) -> None:
        xyz = np.random.default_rng(8).standard_normal((50, 3))
        rows = "".join(f"{k / 8},{x:.6f},{y:.6f},{z:.6f},{np.sqrt(x * x + y * y + z * z):.6f}\n"
                       for k, (x, y, z) in enumerate(xyz))  # fmt: skip
        recording = read(tmp_path, "Time (s),ax,ay,az,Absolute\n" + rows)
        assert recording.names == ("ax", "ay", "az")
        assert str(dict(recording.left_out)["Absolute"]).startswith("is the magnitude of 'ax', 'ay', 'az'")
        assert read(tmp_path, "Time (s),ax,ay,az,Absolute\n" + rows, channels=["Absolute"]).names == ("Absolute",)

    def test_text_of_any_name_is_read(self, tmp_path: Path) -> None:
        (tmp_path / "r.out").write_text("t,seat\n0,1\n1,2\n", encoding="utf-8")
        assert read_recording(tmp_path / "r.out").names == ("seat",)


class TestMissingCells:
    @pytest.mark.parametrize("cell", ["", "nan", "-nan", "NaN", "#N/A", "---", "N/A", "null", "1.#QNAN", "-nan(ind)"])
    def test_are_not_a_number(self, tmp_path: Path, cell: str) -> None:
        seat = read(tmp_path, f"t,seat,tire\n0,1,2\n1,{cell},3\n2,3,4\n")["seat"]
        assert np.array_equal(seat.values, [1, np.nan, 3], equal_nan=True)

    def test_a_first_row_of_them_is_no_header(self, tmp_path: Path) -> None:
        for head in ("", "t,seat\n"):
            recording = read(tmp_path, f"{head}nan,nan\nnan,nan\n1,2\n2,4\n", fs=1)
            assert np.array_equal(recording.channels[-1].values, [np.nan, np.nan, 2, 4], equal_nan=True)

    def test_a_piece_with_many_is_read_as_one_with_none(self, tmp_path: Path) -> None:
        rng = np.random.default_rng(7)
        values = rng.standard_normal((30_000, 3))
        values[rng.random(values.shape) < 0.01] = np.nan
        rows = "\n".join(",".join("" if v != v else repr(v) for v in row) for row in values.tolist())
        recording = read(tmp_path, f"a,b,c\n{rows}\n", fs=10)
        assert np.array_equal(np.array([c.values for c in recording.channels]).T, values, equal_nan=True)


class TestLateColumns:
    """A sensor that starts late leaves its cells blank at first: its column has missing samples."""

    ROWS = 1500

    def path(self, folder: Path, head: str) -> Path:
        rows = (
            f"{k / 100:.2f},{np.sin(k / 9):.4f},{'' if k < 1400 else f'{np.cos(k / 7):.4f}'}" for k in range(self.ROWS)
        )
        path = folder / "late.csv"
        path.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
        return path

    @pytest.mark.parametrize(
        ("head", "name"),
        [
            ("t,seat,wind\n", "wind"),
            ("# of a buoy\nt,seat,wind\n# wind is blank for 14 s, and then filled\n", "wind"),
            ("t,seat,\n", "column 3"),
        ],
    )
    def test_they_are_columns(self, tmp_path: Path, head: str, name: str) -> None:
        recording = read_recording(self.path(tmp_path, head))
        assert recording.names == ("seat", name)
        late = recording[name]
        assert np.flatnonzero(np.isfinite(late.values)) == pytest.approx(np.arange(1400, self.ROWS))
        assert late.values[-1] == pytest.approx(np.cos((self.ROWS - 1) / 7), abs=1e-4)

    @pytest.mark.parametrize("last", ["NaN", ""])
    def test_a_last_column_without_numbers_is_no_such_delimiter(self, tmp_path: Path, last: str) -> None:
        rows = [f"23/10/2016,08:21:{k / 10:06.3f},{np.sin(k / 9):.4f},{last if k == 0 else 'NaN'}" for k in range(300)]
        recording = read_recording(write_text(tmp_path, "\r\n" + "\r\n".join(rows)))
        assert recording["column 3"].values.size == 300

    def test_a_delimiter_that_ends_each_row_is_none(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csv"
        path.write_text("t,seat,\n" + "".join(f"{k / 100:.2f},{np.sin(k / 9):.4f},\n" for k in range(1500)))
        assert read_recording(path).names == ("seat",)


class TestTablesBelow:
    """Laboratory programs write the spectrum of a record below it, as a table of its own."""

    def text(self, below: str) -> str:
        rows = "".join(f"{k}\t{k / 50:.2f}\t{np.cos(k / 9):.4f}\n" for k in range(300))
        return f"n\tt\tangle\n{rows}{below}"

    def test_they_are_left_out_and_named(self, tmp_path: Path) -> None:
        spectrum = "2 150\n" + "".join(f"{k / 6:.6f}\t{1 / (1 + (k - 40) ** 2):.6f}\n" for k in range(150))
        recording = read(tmp_path, self.text(spectrum))
        assert recording.names == ("angle",)
        assert recording["angle"].values.size == 300
        why = dict(recording.left_out)["lines 302 to 452"]
        assert (why.code, why.numbers["lines"]) == (LeftOut.OTHER_TABLE, 151)
        assert why.code in DAMAGE

    def test_lines_that_are_no_table_are_refused(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="the rows end at line 301, but 60 lines follow"):
            read(tmp_path, self.text("".join(f"event {k}: none\n" for k in range(60))))


class TestOneNumberOrTwo:
    """A comma between digits is never guessed at."""

    def test_as_many_names_as_cells(self, tmp_path: Path) -> None:
        assert read(tmp_path, "t,x\n1,234\n2,235\n")["x"].values.tolist() == [234, 235]

    def test_one_name(self, tmp_path: Path) -> None:
        assert read(tmp_path, "x\n1,234\n2,235\n", fs=1)["x"].values.tolist() == [1.234, 2.235]

    def test_a_zero_behind_the_comma(self, tmp_path: Path) -> None:
        assert read(tmp_path, "1,034\n2,235\n", fs=1).channels[0].values.tolist() == [1.034, 2.235]

    def test_a_sign_or_a_point_behind_the_comma(self, tmp_path: Path) -> None:
        assert len(read(tmp_path, "1,-234\n2,235\n", fs=1).channels) == 2
        assert len(read(tmp_path, "1,2.5\n2,235\n", fs=1).channels) == 2

    def test_neither(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="may be one number or two.*header"):
            read(tmp_path, "1,234\n2,235\n", fs=1)


class TestHeader:
    @pytest.mark.parametrize(
        ("line", "rate"),
        [("Sample rate: 500 Hz", 500), ("fs=500", 500), ("dt;0.002", 500), ("Sampling interval (ms): 2", 500)],
    )
    def test_states_the_rate(self, tmp_path: Path, line: str, rate: float) -> None:
        channel = read(tmp_path, f"{line}\nseat\n1.5\n2.5\n4.5\n").channels[0]
        assert channel.rate == pytest.approx(rate, rel=SEVEN_DIGITS)
        assert channel.timepts[2] == pytest.approx(2 / rate, rel=1e-15)  # one division

    def test_a_rate_with_a_mark_between_thousands_is_not_read(self, tmp_path: Path) -> None:
        assert read(tmp_path, "Sample rate: 1,000 Hz\nt,seat\n0,1.5\n1,2.5\n")["seat"].rate is None

    def test_names_that_stand_twice_are_numbered_and_told(self, tmp_path: Path) -> None:
        recording = read(tmp_path, "t,acc,acc\n0,1,2\n1,2,3\n")
        assert recording.names == ("acc", "acc (2)")
        assert recording.left_out == (
            ("name of column 3", Remark(LeftOut.NAME_TWICE, {"name": "acc", "new": "acc (2)"})),
        )

    def test_a_name_without_its_unit_is_enough(self, tmp_path: Path) -> None:
        assert read(tmp_path, "t,seat [mm]\n0,1\n1,2\n").names == ("seat [mm]",)
        assert read(tmp_path, "t,seat [mm]\n0,1\n1,2\n", channels="seat").names == ("seat [mm]",)

    @pytest.mark.parametrize(
        "unit", ["mm", "m/s^2", "m/s²", "m/s2", "kN", "µm/m", "°", "rad/s", "-", "%", "N·s/m", "g"]
    )
    def test_units_are_known_as_such(self, unit: str) -> None:
        assert UNIT.fullmatch(unit)
        assert bracketed_unit(f"a seat [{unit}]") == unit

    def test_every_unit_that_is_converted_is_known_below_the_names(self, tmp_path: Path) -> None:
        usual = {"n": "N", "kn_force": "kN", "pa": "Pa", "kpa": "kPa", "mpa": "MPa", "v": "V", "mv": "mV"}
        units = [usual.get(unit, unit) for unit in FACTORS]
        names = [f"channel {k}" for k in range(len(units))]
        rows = [",".join([f"{0.01 * k:.2f}", *["1.5"] * len(units)]) for k in range(3)]
        found = read(tmp_path, "\n".join([",".join(["time", *names]), ",".join(["", *units]), *rows, ""]))
        assert [channel.unit for channel in found.channels] == units
        assert found.names == tuple(names)

    @pytest.mark.parametrize("name", ["seat", "acc1", "body z", "left_m", "Channel 3"])
    def test_names_are_no_units(self, name: str) -> None:
        assert not UNIT.fullmatch(name)

    def test_a_number_in_brackets_is_no_unit(self) -> None:
        assert bracketed_unit("data[1]") == ""

    def test_steps_and_rates_are_each_others_inverse(self) -> None:
        assert stated_rate("dt [ms]", 2.0) == stated_rate("Sample_Rate", 0.5, "kHz") == 500


class TestAnyText:
    """Whatever stands in a text, it gives a table or a `RecordError`."""

    @pytest.mark.parametrize("line", [f"0.1,{'1' * 9999}x", f"0.1,{'1:' * 9999}"])
    def test_an_error_quotes_the_beginning_of_a_long_cell(self, scratch: Path, line: str) -> None:
        for lines in (["t,seat", "0.0,1", "0.05,2", line, "0.15,4"], ["t,seat", line, "0.2,1", "0.3,2"]):
            with pytest.raises(RecordError) as refusal:
                read(scratch, "\n".join(lines))
            assert len(str(refusal.value)) < 300 + len(str(scratch))

    @pytest.mark.parametrize("text", ['fs: 10\n""\t:\n', "1 2\n- \x85\n"])
    def test_quotes_and_odd_blanks_between_blanks(self, scratch: Path, text: str) -> None:
        path = scratch / "q.txt"
        path.write_text(text, encoding="utf-8")
        table = read_delimited(path)
        assert {column.size for column in table.columns(list(table.sizes))} == {1}

    @FUZZ
    @given(
        lines=st.lists(
            st.one_of(
                st.sampled_from(
                    ["t,seat", "0,1", "1;2,5", "s;mm", "# note", "", "1 2", "12:34:56.7,1", "fs: 10", '"a","b"']
                ),
                st.text("0123456789.,;:\t\"'-+ enaifxt_#µ[]()\u2028\x85", max_size=12),
            ),
            max_size=12,
        ),
        end=st.sampled_from(["\n", "\r\n", "\r", "\n\n"]),
        encoding=st.sampled_from(["utf-8", "utf-16", "utf-8-sig", "cp1252"]),
    )
    def test_lines_of_all_kinds(self, scratch: Path, lines: list[str], end: str, encoding: str) -> None:
        path = scratch / "r.txt"
        path.write_bytes(end.join(lines).encode(encoding, errors="replace"))
        columns: list[int] = []
        try:
            table = read_delimited(path)
            columns = [column.size for column in table.columns(list(table.sizes))]
            columns += [clock.stamps().size for clock in table.clocks.values() if clock.stamps is not None]
        except RecordError as error:
            message = str(error)
        else:
            message = ""
            assert set(columns) <= set(table.sizes.values())
        assert message.isprintable()


FS = 100.0
SINE = np.round(np.sin(np.arange(200) / 7), 4)


def logged(times: Sequence[str], *, head: str = "time,seat") -> str:
    return f"{head}\n" + "".join(f"{time},{value}\n" for time, value in zip(times, SINE, strict=False))


def clock_times(form: str) -> list[str]:
    began = datetime.datetime(2024, 5, 13, 23, 59, 59)
    return [(began + datetime.timedelta(milliseconds=10 * k)).strftime(form) for k in range(200)]


# Stamps of 200 rows at 100 Hz as programs write them.
STAMPS = {
    "months by name": clock_times("%d-%b-%Y %H:%M:%S.%f"),
    "a colon before the milliseconds": [text[:-3] for text in clock_times("%H:%M:%S:%f")],
    "days since 1900": [f"{45425.5 + k / FS / 86400:.11f}" for k in range(200)],
    "days since the year 0": [f"{739385.5 + k / FS / 86400:.10f}" for k in range(200)],
    "us since 1970": [f"{1715600000000000 + 10000 * k}" for k in range(200)],
}


class TestOddExports:
    @pytest.mark.parametrize("name", STAMPS)
    def test_stamps(self, tmp_path: Path, name: str) -> None:
        (channel,) = read(tmp_path, logged(STAMPS[name])).channels
        assert channel.values.tolist() == SINE.tolist()
        assert channel.mean_rate == pytest.approx(FS, rel=2e-3)

    @pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-16"])
    def test_utf_16_with_and_without_a_mark(self, tmp_path: Path, encoding: str) -> None:
        recording = read(tmp_path, logged([f"{k / FS}" for k in range(200)], head="time,Dämpfer").encode(encoding))
        assert recording.names == ("Dämpfer",)

    @pytest.mark.parametrize("before", ["", "x = ", "% t seat\n"])
    def test_a_matrix_on_one_line(self, tmp_path: Path, before: str) -> None:
        rows = "; ".join(f"{k / FS}, {value}" for k, value in enumerate(SINE))
        (channel,) = read(tmp_path, f"{before}[{rows}]").channels
        assert channel.values.tolist() == SINE.tolist()
        assert channel.mean_rate == pytest.approx(FS)

    def test_columns_of_two_lengths_with_times_of_their_own(self, tmp_path: Path) -> None:
        rows = "".join(f"{k / FS},{SINE[k]}," + (f"{k / 50},{-SINE[k]}" if k < 100 else ",") + "\n" for k in range(200))
        recording = read(tmp_path, "t1,seat,t2,tire\n" + rows)
        assert [channel.values.size for channel in recording.channels] == [200, 100]
        assert [round(channel.mean_rate) for channel in recording.channels] == [100, 50]

    @pytest.mark.parametrize("labels", [("acc", "disp"), ("1", "2")])
    def test_channels_one_below_the_other_are_refused(self, tmp_path: Path, labels: tuple[str, str]) -> None:
        rows = "".join(f"{k // 2 / FS},{labels[k % 2]},{SINE[k]}\n" for k in range(200))
        with pytest.raises(RecordError, match="several channels one below the other: 'id' is"):
            read(tmp_path, "time,id,value\n" + rows)

    def test_channels_in_lines_are_refused(self, tmp_path: Path) -> None:
        rows = [",".join([name, *map(str, SINE)]) for name in ("time", "seat", "tire")]
        with pytest.raises(RecordError, match="3 rows of 201 cells.*transpose it"):
            read(tmp_path, "\n".join(rows))

    def test_a_time_that_is_text_is_shown(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="'time' is text such as '0x00', neither a number nor a time"):
            read(tmp_path, logged([f"0x{k:02X}" for k in range(200)]))

    def test_a_separator_of_bars_and_a_rate_in_samples_per_second(self, tmp_path: Path) -> None:
        recording = read(tmp_path, "Sample rate: 100 S/s\nseat|tire\n" + "".join(f"{v}|{-v}\n" for v in SINE))
        assert recording.names == ("seat", "tire")
        assert recording["seat"].mean_rate == FS


@pytest.mark.parametrize(
    "text",
    ["a" + " " * 20000 + "[" + " " * 20000 + "x", "[ " * 20000, "k" * 20000 + " : " + "1" * 20000, "1" * 20000 + "x",
     "a_ /" * 20000, "-" * 20000 + "x", "a: 1," * 20000 + "\n" + "a: 1," * 20000],
    ids=["blanks", "brackets", "key", "digits", "units", "rule", "labels"],
)  # fmt: skip
@pytest.mark.parametrize("top", [True, False], ids=["header", "cell"])
def test_no_pattern_takes_a_power_of_the_length(text: str, top: bool, tmp_path: Path) -> None:
    rows = "\n".join(f"{k / 100},{k % 7}" for k in range(300))
    path = tmp_path / "long.csv"
    path.write_text(f"{text},b\n{rows}" if top else f"t,b\n{rows}\n3.0,{text}\n")
    before = time.process_time()
    with contextlib.suppress(SuspidError):
        read_recording(path)
    # A quadratic pattern takes 20 s, one of fourth power longer than a life.
    assert time.process_time() - before < 5


class TestStepsInPlaceOfTheTime:
    """Telephones write the time from each sample to the next beside the channels, without names."""

    STEPS = (0, 20, 20, 21, 20, 19, 20, 20, 21, 20, 20, 19)

    def text(self, mark: str, *, header: str = "") -> str:
        rows = (f"{np.cos(k):.3f}{mark}{np.sin(k):.3f}{mark}{step}\n" for k, step in enumerate(self.STEPS))
        return header + "".join(rows)

    @pytest.mark.parametrize("mark", [" ", ";", "\t", ","])
    @pytest.mark.parametrize("header", ["", "# Accelerometer\n# X Y time_from_previous_sample(ms)\n\n# units: m/s^2\n"])
    def test_their_sums_are_the_time(self, tmp_path: Path, mark: str, header: str) -> None:
        recording = read(tmp_path, self.text(mark, header=header))
        # The words of the comment are names where the cells are separated as they are.
        named = mark == " " and bool(header)
        assert recording.names == (("X", "Y") if named else ("column 1", "column 2"))
        np.testing.assert_allclose(recording.channels[0].timepts, np.cumsum(self.STEPS) / 1e3, rtol=0, atol=1e-12)
        steps = "time_from_previous_sample(ms)" if named else "column 3"
        assert dict(recording.left_out)[steps].code is LeftOut.STEP_CLOCK

    def test_a_later_comment_of_as_many_words_is_no_header(self, tmp_path: Path) -> None:
        said = "# X Y time_from_previous_sample(ms)\n# units set to: m/s^2\n# gravity filtered out\n"
        assert read(tmp_path, self.text(" ", header=said)).names == ("X", "Y")

    @pytest.mark.parametrize(
        "said",
        ["# time,date,author", "# Elapsed time,operator,shift", "# dt,is,constant", "# Date, Start time, Operator"],
    )
    def test_settings_with_a_word_for_time_are_no_header(self, tmp_path: Path, said: str) -> None:
        rows = "".join(f"{np.cos(k / 9):.3f},{np.sin(k / 9):.3f},{np.cos(k / 7):.3f}\n" for k in range(60))
        (tmp_path / "a.csv").write_text(f"{said}\n# seat,tire,hub\n{rows}", encoding="utf-8")
        assert read_recording(tmp_path / "a.csv", fs=100.0).names == ("seat", "tire", "hub")

    def test_a_given_rate_replaces_them(self, tmp_path: Path) -> None:
        (tmp_path / "a.txt").write_text(self.text(" "), encoding="utf-8")
        given = read_recording(tmp_path / "a.txt", fs=50.0)
        assert given.channels[0].rate == 50.0
        assert given.names == ("column 1", "column 2")

    def test_a_stated_time_stands_before_them(self, tmp_path: Path) -> None:
        rows = "".join(f"{0.02 * k:.2f},{np.cos(k):.3f},{step}\n" for k, step in enumerate(self.STEPS))
        assert read(tmp_path, f"time,seat,dt\n{rows}")["seat"].timepts[1] == 0.02

    @pytest.mark.parametrize("column", [(0, *[20] * 11), (0, 20, 20, 21, 0, 19, 20, 20, 21, 20, 20, 19)])
    def test_a_channel_that_rests_is_none(self, tmp_path: Path, column: Sequence[int]) -> None:
        rows = "".join(f"{np.cos(k):.3f} {value}\n" for k, value in enumerate(column))
        with pytest.raises(RecordError, match="no column is named like a time"):
            read(tmp_path, rows)


def write_text(folder: Path, text: str) -> Path:
    path = folder / "a.csv"
    path.write_bytes(text.encode())
    return path


class TestNamesInCells:
    """Programs for microcontrollers print a label before each number."""

    @staticmethod
    def rows(mark: str = ",", colon: str = ": ") -> list[str]:
        cells = [
            (f"34:{k / 10:04.1f}", f"Gyro{colon}{np.cos(k):.3f}", f" Set point{colon}{k * k % 17}") for k in range(99)
        ]
        return [mark.join(row) for row in cells]

    @pytest.mark.parametrize("mark", [",", ";", "\t"])
    @pytest.mark.parametrize("colon", [": ", ":", " = "])
    @pytest.mark.parametrize("above", ["", "started\n\n"])
    def test_are_those_of_the_columns(self, tmp_path: Path, mark: str, colon: str, above: str) -> None:
        recording = read_recording(write_text(tmp_path, above + "\n".join(self.rows(mark, colon))))
        assert recording.names == ("Gyro", "Set point")
        assert recording["Gyro"].values == pytest.approx(np.round(np.cos(np.arange(99)), 3))
        assert recording["Gyro"].timepts[-1] == pytest.approx(9.8)

    def test_a_last_row_that_is_cut_off_is_told(self, tmp_path: Path) -> None:
        recording = read_recording(write_text(tmp_path, "\n".join(self.rows())[:-18]))
        assert recording["Gyro"].values.size in (97, 98)
        assert [what for what, _ in recording.left_out if what.startswith("line ")] == ["line 99"]

    @pytest.mark.parametrize("above", ["", "started\n\n"])
    def test_messages_name_the_lines_of_the_file(self, tmp_path: Path, above: str) -> None:
        rows = self.rows()
        rows.insert(40, "")
        recording = read_recording(write_text(tmp_path, above + "\n".join(rows)))
        assert [what for what, why in recording.left_out if why.code is LeftOut.BLANK] == [
            f"line {41 + above.count(chr(10))}"
        ]

    def test_others_in_one_row_are_refused(self, tmp_path: Path) -> None:
        rows = self.rows()
        rows[50] = rows[50].replace("Gyro", "Gyra")
        with pytest.raises(RecordError, match="names in a line above"):
            read_recording(write_text(tmp_path, "\n".join(rows)))


class TestNamesBetweenOtherMarks:
    """Programs whose decimals have a comma separate the cells by tabs, and some leave commas between the names."""

    def test_commas_between_names_and_tabs_between_cells(self, tmp_path: Path) -> None:
        rows = "".join(f"{0.02 * k:.3f}\t{np.cos(k):.3f}\t{np.sin(k):.3f}\n" for k in range(9)).replace(".", ",")
        recording = read(tmp_path, f"--- Torsion ---\nTempo,Force,Angle\n{rows}")
        assert recording.names == ("Force", "Angle")
        assert recording["Angle"].timepts[1] == 0.02

    @pytest.mark.parametrize(("line", "names"), [("x y", ("y",)), ("Free decay", ("column 2",))])
    def test_blanks_between_names_and_tabs_between_cells(self, tmp_path: Path, line: str, names: tuple[str]) -> None:
        rows = "".join(f"{0.02 * k:.2f}\t{np.cos(k):.3f}\n" for k in range(90))
        assert read_recording(write_text(tmp_path, f"{line}\n{rows}")).names == names

    def test_a_sentence_is_no_header(self, tmp_path: Path) -> None:
        rows = "".join(f"{0.02 * k:.2f}\t{np.cos(k):.3f}\t{np.sin(k):.3f}\n" for k in range(9))
        assert read(tmp_path, f"a test, of two days\n{rows}").names == ("column 2", "column 3")
