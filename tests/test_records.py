"""Records: what is read is what the file holds, and everything else is refused by name."""

from __future__ import annotations

import io
import os
import struct
import warnings
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from suspid import RecordError
from suspid.cleaning.read_record import read_record
from suspid.errors import RecordWarning
from suspid.io.formats import READERS
from suspid.io.read_recording import read_recording
from suspid.io.write_record import write_record
from suspid.records import as_response
from suspid.values import LARGEST_SIZE, SMALLEST_SIZE
from suspid.words import LeftOut

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
NAMES = st.text("abcXYZ019 _-,;\"'[]()µ²", min_size=1).map(str.strip).filter(lambda n: n and n not in ("0", "1", "9"))


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def warnings_ignored(path: Path, options: dict[str, Any]) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RecordWarning)
        return read_record(path, **options)


def matlab(**variables: object) -> bytes:
    stream = io.BytesIO()
    savemat(stream, variables)  # type: ignore[arg-type]  # the stubs know paths only
    return stream.getvalue()


class TestWrittenThenReadIsTheSame:
    @FUZZ
    @given(
        values=st.lists(st.tuples(*[st.floats(-LARGEST_SIZE, LARGEST_SIZE)] * 2), min_size=2, max_size=20),
        step=st.floats(1e-6, 1e3),
        start=st.floats(-1e3, 1e3),
    )
    def test_every_bit_of_samples_and_time(
        self, scratch: Path, values: list[tuple[float, float]], step: float, start: float
    ) -> None:
        time = np.asarray(start + step * np.arange(len(values)), float)
        if np.any(np.diff(time) < 0.999 * step):
            return  # the step drowns in the start: no uniform grid in double precision
        sizes = np.max(np.abs(values), axis=0)
        if np.any((sizes > 0) & (sizes < SMALLEST_SIZE)):
            return  # no record holds a channel as small
        record = as_response(time, np.array(values).T, ["seat", "tire"])
        for name in ("r.csv", "r.parquet"):
            write_record(record, scratch / name)
            back = read_recording(scratch / name)
            assert [channel.values.tobytes() for channel in back.channels] == [row.tobytes() for row in record.y]
            assert back.channels[0].timepts.tobytes() == time.tobytes()

    @FUZZ
    @given(names=st.lists(NAMES, min_size=1, max_size=4, unique=True))
    def test_names_of_channels_or_they_are_refused(self, scratch: Path, names: list[str]) -> None:
        record = as_response(np.arange(3.0), np.arange(3.0 * len(names)).reshape(len(names), 3), names)
        try:
            write_record(record, scratch / "r.csv")
        except RecordError as error:
            message = str(error)
        else:
            message = ""
        if message:
            assert "could not be read back" in message
            return
        assert list(read_recording(scratch / "r.csv").names) == names

    @pytest.mark.parametrize("digits", [1, 5, 17])
    def test_printed_digits(self, tmp_path: Path, digits: int) -> None:
        values = np.random.default_rng(3).standard_normal((1, 50)) * 1e-4
        write_record(as_response(np.arange(50) / 500, values, ["seat"]), tmp_path / "r.csv", digits=digits)
        printed = [float(f"{v:.{digits}g}") for v in values[0]]
        assert read_record(tmp_path / "r.csv").y[0].tolist() == printed

    @pytest.mark.parametrize("name", ["", "time [s]", " seat", "a\x1b[2Jb", "a\nb"])
    def test_names_that_would_not_come_back_are_refused(self, tmp_path: Path, name: str) -> None:
        with pytest.raises(RecordError, match="could not be read back"):
            write_record(as_response(np.arange(3.0), np.ones((2, 3)), ["seat", name]), tmp_path / "r.csv")
        assert list(tmp_path.iterdir()) == []

    def test_two_channels_of_one_name_are_refused(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="occurs twice"):
            write_record(as_response(np.arange(3.0), np.ones((2, 3)), ["seat", "seat"]), tmp_path / "r.csv")

    @pytest.mark.parametrize("name", ["r.csv", "r.parquet", "r.pq"])
    def test_units_and_title(self, tmp_path: Path, name: str) -> None:
        values = np.random.default_rng(3).standard_normal((2, 40))
        record = as_response(np.arange(40) / 8, values, ["seat", "tire"], title="bump 7")
        write_record(record, tmp_path / name, units=["m/s^2", ""])
        back = read_recording(tmp_path / name)
        assert [channel.unit for channel in back.channels] == ["m/s^2", ""]
        assert back.title == ("r" if name == "r.csv" else "bump 7")
        assert read_record(tmp_path / name).y.tobytes() == values.tobytes()

    def test_units_that_are_not_those_of_the_channels_are_refused(self, tmp_path: Path) -> None:
        record = as_response(np.arange(3.0), np.ones((2, 3)), ["seat", "tire"])
        with pytest.raises(RecordError, match="1 units for 2 channels"):
            write_record(record, tmp_path / "r.csv", units=["m"])

    def test_only_csv_and_parquet_are_written(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"written as \.csv, \.parquet"):
            write_record(as_response(np.arange(3.0), np.ones((1, 3)), ["seat"]), tmp_path / "r.mat")


class TestDialects:
    @pytest.mark.parametrize("delimiter", [",", ";", "\t"])
    @pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
    @pytest.mark.parametrize("bom", ["", "\ufeff"])
    @pytest.mark.parametrize("tail", ["", "\n", "\n\n \n"])
    def test_delimiter_line_end_byte_order_mark_and_last_line(
        self, tmp_path: Path, delimiter: str, end: str, bom: str, tail: str
    ) -> None:
        rows = [["t", "seat", '"a b"'], ["0", "1.5", "-2e-3"], ["0.5", " 2 ", '"3"'], ["1", ".5", "4."]]
        text = bom + "\n".join(delimiter.join(row) for row in rows) + tail
        path = written(tmp_path, "r.csv", text.replace("\n", end))
        # A last line without an end may have been longer.
        with nullcontext() if tail else pytest.warns(RecordWarning, match="line 4 does not end"):
            record = read_record(path)
        assert record.output_labels == ["seat", "a b"]
        assert record.time.tolist() == [0.0, 0.5, 1.0]
        assert record.y.tolist() == [[1.5, 2.0, 0.5], [-0.002, 3.0, 4.0]]

    def test_no_header_with_a_rate(self, tmp_path: Path) -> None:
        record = read_record(written(tmp_path, "r.txt", "1;2\n3;4\n5;6\n"), fs=4)
        assert record.output_labels == ["column 1", "column 2"]
        assert record.time.tolist() == [0.0, 0.25, 0.5]

    def test_no_header_with_a_column_of_time(self, tmp_path: Path) -> None:
        record = read_record(written(tmp_path, "r.tsv", "1\t2\n3\t4\n5\t6\n"), time="column 1")
        assert record.time.tolist() == [1.0, 3.0, 5.0]
        assert record.y.tolist() == [[2.0, 4.0, 6.0]]

    def test_one_column(self, tmp_path: Path) -> None:
        assert read_record(written(tmp_path, "r.txt", "x\n1\n2\n4\n"), fs=1).y.tolist() == [[1.0, 2.0, 4.0]]

    def test_header_written_by_numpy(self, tmp_path: Path) -> None:
        np.savetxt(tmp_path / "r.csv", [[0, 1], [1, 2], [2, 3]], delimiter=",", header="t,seat")
        assert read_record(tmp_path / "r.csv").output_labels == ["seat"]

    def test_text_in_a_column_not_asked_for_does_not_matter(self, tmp_path: Path) -> None:
        path = written(tmp_path, "r.csv", "t,seat,remark\n0,1,start\n1,2,\n")
        assert read_record(path, channels="seat").y.tolist() == [[1.0, 2.0]]

    def test_order_of_channels_is_that_asked_for(self, tmp_path: Path) -> None:
        path = written(tmp_path, "r.csv", "a,t,b\n0,1,2\n3,4,5\n")
        assert read_record(path, channels=["b", "a"]).y.tolist() == [[2.0, 5.0], [0.0, 3.0]]


class TestTimeColumn:
    @pytest.mark.parametrize(
        ("name", "seconds"),
        [
            ("t", 2),
            ("Time", 2),
            ("time [s]", 2),
            ("t_s", 2),
            ("Time (ms)", 2e-3),
            ("t_us", 2e-6),
            ("time/µs", 2e-6),
            ("seconds", 2),
            ("Milliseconds", 2e-3),
            ("timestamp, ns", 2e-9),
            ("elapsed time [min]", 120),
        ],
    )
    def test_names_and_units(self, tmp_path: Path, name: str, seconds: float) -> None:
        path = written(tmp_path, "r.csv", f'seat;"{name}"\n1;0\n2;2\n3;4\n')
        assert read_record(path).time == pytest.approx(
            [0, seconds, 2 * seconds], rel=1e-15, abs=0
        )  # a division, rounded

    @pytest.mark.parametrize("name", ["temperature", "T1", "tire", "s", "rate", "seat_ms"])
    def test_names_of_other_things(self, tmp_path: Path, name: str) -> None:
        with pytest.raises(RecordError, match=r"no column is named like a time: 'seat'.*fs"):
            read_record(written(tmp_path, "r.csv", f"seat,{name}\n1,0\n2,2\n"))

    def test_a_unit_that_is_none_of_time_is_named(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"unit of time in 'time \[samples\]' is not known; known: s, ms"):
            read_record(written(tmp_path, "r.csv", "seat,time [samples]\n1,0\n2,2\n"))

    def test_a_given_rate_replaces_that_of_the_file(self, tmp_path: Path) -> None:
        path = tmp_path / "r.mat"
        path.write_bytes(matlab(x=np.sin(np.arange(50.0)), Fs=10.0))
        recording = read_recording(path, fs=20)
        assert recording["x"].rate == 20
        assert any(remark.code is LeftOut.OTHER_RATE for _, remark in recording.left_out)

    def test_rounded_stamps_give_way_to_the_rate_that_they_round(self, tmp_path: Path) -> None:
        exact = np.arange(100) / 1280
        rows = "".join(f"{t:.4f},{np.cos(80 * t)}\n" for t in exact)
        path = written(tmp_path, "r.csv", "t,x\n" + rows)
        with pytest.warns(RecordWarning, match=r"r\.csv: time: rounded stamps: .*1280 Hz"):
            record = read_record(path, fs=1280)
        assert record.time.tolist() == exact.tolist()
        raw = read_recording(path, fs=1280)["x"]
        assert raw.timepts.tolist() == [float(f"{t:.4f}") for t in exact]
        assert raw.rate == 1280

    @pytest.mark.parametrize("fs", [499.0, 501.0, 500.1, 1000.0])
    def test_another_rate_replaces_the_column_and_says_so(self, tmp_path: Path, fs: float) -> None:
        rows = "".join(f"{k / 500},{k % 7}\n" for k in range(3000))
        with pytest.warns(RecordWarning, match=rf"rate of {fs:g} Hz replaces the time column, which states 500 Hz"):
            record = read_record(written(tmp_path, "r.csv", "t,x\n" + rows), fs=fs)
        assert record.time.tolist() == (np.arange(3000) / fs).tolist()

    def test_a_rate_beyond_all_clocks_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"500"):
            read_record(written(tmp_path, "r.csv", "t,x\n0,1\n0.002,2\n0.004,1\n"), fs=1e300)

    def test_stamps_keep_their_start_beside_a_rate(self, tmp_path: Path) -> None:
        assert read_record(written(tmp_path, "r.csv", "t,x\n5,1\n6,2\n7,1\n"), fs=1).time.tolist() == [5.0, 6.0, 7.0]


class TestMatlab:
    @pytest.mark.parametrize(("rate", "value"), [("Fs", 50.0), ("Sample_Rate", 50), ("dt", 0.02), ("Ts_ms", 20.0)])
    def test_a_scalar_states_the_rate(self, tmp_path: Path, rate: str, value: float) -> None:
        content = matlab(x=np.arange(4.0), y=np.arange(4.0)[:, None], note="bump", **{rate: value})
        record = read_record(written(tmp_path, "r.mat", content))
        assert record.output_labels == ["x", "y"]
        assert record.time == pytest.approx([0, 0.02, 0.04, 0.06], rel=1e-15)  # 1 / 0.02 is rounded

    def test_vectors_as_long_as_time_are_the_channels(self, tmp_path: Path) -> None:
        content = matlab(x=np.arange(4.0), t=np.arange(4.0), f=np.arange(9.0), M=np.eye(4), z=np.ones(4) * 1j)
        assert read_record(written(tmp_path, "r.mat", content)).output_labels == ["x"]

    def test_vectors_of_several_lengths_without_time_are_asked_about(self, tmp_path: Path) -> None:
        content = matlab(x=np.arange(4.0), f=np.arange(9.0))
        with pytest.raises(RecordError, match=r"differ in length \('x' 4, 'f' 9\)"):
            read_record(written(tmp_path, "r.mat", content), fs=1)
        assert read_record(tmp_path / "r.mat", fs=1, channels=["f"]).y.shape == (1, 9)

    def test_integers_and_single_precision_are_kept(self, tmp_path: Path) -> None:
        x = np.array([0.1, 0.2, 0.3], np.float32)
        record = read_record(written(tmp_path, "r.mat", matlab(x=x, n=np.array([1, -2, 3], np.int16))), fs=1)
        assert record.y.tolist() == [[float(v) for v in x], [1.0, -2.0, 3.0]]

    @pytest.mark.skipif(not DATA.exists(), reason="no shared data")
    def test_a_measured_record(self) -> None:
        with pytest.warns(RecordWarning, match="rounded stamps"):
            record = read_record(DATA / "vibtest_inout_mat" / "case1.mat", channels=["Time_chan_2"], fs=1280)
        assert record.y.shape == (1, 4096)
        assert record.time.tolist() == (np.arange(4096) / 1280).tolist()

    @pytest.mark.skipif(not DATA.exists(), reason="no shared data")
    def test_a_receptance_is_no_record(self) -> None:
        with pytest.raises(RecordError, match=r"mckiddat\.mat: no column is named like a time: 'Freq'"):
            read_record(DATA / "vibtest_inout_mat" / "mckiddat.mat")


GOOD = "t,seat,tire\n0,1,2\n1,2,3\n2,3,4\n"
X = np.arange(4.0)
REFUSED: list[tuple[str, str | bytes, dict[str, Any], str]] = [
    ("r.csv", "", {}, "is empty"),
    ("r.mat", b"", {}, "is empty"),
    ("r.csv", "\n\n", {}, "contains no row of numbers"),
    ("r.csv", "t,seat\n", {}, "contains no row of numbers"),
    ("r.csv", "once upon\na time\n", {"fs": 1}, "contains no row of numbers: 'a time' is none"),
    ("r.csv", "t,a\n0,1 %\n1,2 %\n2,3 %\n", {}, "'a' is text such as '1 %'"),
    (
        "r.csv",
        "date,a\n04.05.24 01:02:03,1\n04.05.24 01:02:04,2\n",
        {},
        "'date' is text such as '04.05.24 01:02:03', n",
    ),
    ("r.csv", "t,seat\n0,1\n", {}, "'seat': 1 number in 1 sample"),
    ("r.csv", b"\xe3\x81\x00\x02\x90\xff" * 99, {}, "is no text: .*export it as text"),
    ("r.csv", b"t,seat\n0,\x81\n", {}, "is neither UTF-8 nor Windows-1252 text: byte 0x81 on line 2"),
    ("r.csv", b"t,seat\n0,\0\n", {}, r"contains zero bytes \(line 2\)"),
    ("r.csv", b"t,seat\n0,\x1b[2J\n", {}, "contains the control byte 0x1b"),
    ("r.csv", b"t,seat\n0,1\x00\n1,2\n", {}, "contains zero bytes .*UTF-16"),
    ("r.csv", b"\xff\xfe\x00\xd8", {}, "is not UTF-16 text"),
    ("r.csv", matlab(x=X), {}, "contains zero bytes|control byte"),
    ("r.csv", "1" * 2_000_000, {}, "line 1 is longer than"),
    ("r.csv", "t,a\n0," + "1" * 300_000 + "\n1,2\n2,3\n", {}, "line 2 is longer than"),
    ("r.mat", GOOD, {}, "is not a MATLAB file"),
    ("r.mat", matlab(x=np.arange(400.0))[:-700], {}, "is damaged: it ends within a variable"),
    ("r.mat", matlab(s={"x": np.arange(400.0)})[:-700], {}, "is damaged: it ends within a variable"),
    ("r.mat", b"\x89HDF\r\n\x1a\n" + bytes(100), {}, "is damaged: OSError"),
    ("r.mat", b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + bytes(900), {}, r"damaged MATLAB v7\.3"),
    ("r.mat", matlab(s="text", c=1 + 2j, k=3.0), {}, r"contains no real vector: 's' is text, 'c' is complex"),
    ("r.mat", matlab(x=np.ones(3), t=np.arange(3.0), M=np.eye(3)), {"channels": ["M"]}, "'M' is a matrix of 3 x 3"),
    ("r.mat", matlab(x=X[:3], t=X[:3], f=X), {"channels": ["x", "f"]}, "'f' has 4 samples, time 't' has 3"),
    ("r.mat", matlab(t=X[:3], f=X), {}, "no channel is as long as time, 't': 3 samples"),
    ("r.mat", matlab(s={"x": X, "Fs": 10.0, "dt": 2.0}), {}, "states several sampling rates: 'Fs' 10 Hz, 'dt' 0.5 Hz"),
    ("r.mat", matlab(x=X, t=X, Fs=10.0), {}, "10"),
    ("r.mat", matlab(x=X, t=X, time=-X), {}, "'t', 'time' all read like a time"),
    ("r.csv", "t,seat\n0,1\n1,nan\n", {}, "'seat': 1 number in 2 samples"),
    ("r.csv", "t,seat\n0,nan\n1,nan\n2,nan\n", {}, "'seat': 0 numbers in 3 samples"),
    ("r.csv", "t,seat\n0,7\n1,7\n2,7\n", {}, "'seat': constant at 7"),
    ("r.csv", GOOD, {"channels": ["seet"]}, "no channel 'seet'. Did you mean 'seat'"),
    ("r.csv", GOOD, {"channels": ["seat", "seat"]}, "'seat' is requested twice"),
    ("r.csv", GOOD, {"channels": ["seat"], "time": "seat"}, "'seat' is requested twice"),
    ("r.csv", GOOD, {"time": "clock"}, "no time column 'clock'. Known: 't', 'seat', 'tire'"),
    ("r.csv", GOOD, {"fs": 0}, "fs = 0 must be a positive"),
    ("r.csv", GOOD, {"fs": -5.0}, "must be a positive"),
    ("r.csv", GOOD, {"fs": float("nan")}, "must be a positive"),
    ("r.csv", GOOD, {"dbc": "can.dbc"}, "only MDF files contain them"),
    ("r.csv", "a,b\n0,1\n1,2\n", {}, "no column is named like a time: 'a', 'b'"),
    ("r.csv", "a,b\n0,1\n1,2\n3,2\n", {}, "'a' increases like a time"),
    ("r.csv", "index,b\n0,1\n1,2\n2,1\n", {}, "'index' counts the rows and is not a time"),
    ("r.csv", "index,b\n0,1\n1,2\n2,1\n", {"time": "index"}, "'index' counts the rows, not time; give .*fs"),
    ("r.csv", "t [h:m],b\n0,1\n1,2\n", {"time": "t [h:m]"}, r"unit of time in 't \[h:m\]' is not known"),
    ("r.csv", "t,seat\n0,1\n1,ok\n", {}, "line 3, column 'seat': 'ok' is not a number"),
    ("r.csv", "t,seat\n0,1\n1,1_0\n2,2\n", {}, "line 3, column 'seat': '1_0' is not a number"),
    ("r.csv", "t;seat\n0;1.5\n1;2.5\n2;2,5\n", {}, "column 'seat': '2,5' is not a number; write decimals with a point"),
    ("r.csv", "t;seat\n0,5;1,5\n1,0;2,5\n1,5;2.500\n", {}, "'2.500' is not a number; decimals have a comma here"),
    ("r.csv", "t;seat\n0,5;1.234,5\n1,0;2.345,6\n", {}, "'1.234,5' are not numbers, .*between the thousands"),
    ("r.csv", 't,seat\n0,"1,234.5"\n1,"2,345.6"\n', {}, "'1,234.5' are not numbers, .*between the thousands"),
    ("r.csv", "t,seat\n0,5\n1,6\n2,1-2\n3,2-3\n4,3-4\n5,4-5\n", {}, "'1-2' are not .*; write one number in each cell"),
    ("r.txt", "0 1.5, 2\n1 2.5, 3\n", {"fs": 1}, "'1.5,' are not .* blanks and commas; .* alone between commas"),
    ("r.csv", "1,234\n1,235\n2,500\n", {"fs": 1}, "'1,234' may be one number or two"),
    (
        "r.csv",
        "t,x\n0,0,1,5\n0,5,2,5\n",
        {},
        "names 2 columns, but the rows have 4 cells .*decimals have a comma.*add them to line 1",
    ),
    ("r.csv", "t,seat\n0,1\n1,2,3\n", {}, r"line 3 has 3 cells, the rows above have 2 \(separated by commas\)"),
    ("r.csv", "t,seat\n0,1\n1\n2,3\n", {}, "line 3 has 1 cells, the rows above have 2"),
    ("r.csv", "seat\n1\n2\nseat\n1\n2\n", {"fs": 1}, "the names of the columns stand again, and no time tells"),
    ("r.csv", "t,seat\n0,1\n1,2\nt [s],seat [m]\n0,1\n1,2\n", {}, "the names of the columns stand again on line 4"),
    ("r.csv", 't,seat\n0,1\n1,"2,3\n', {}, "line 3"),
    ("r.csv", "t,time\n0,1\n1,7\n2,3\n", {}, "'t', 'time' all read like a time"),
    ("r.csv", "0,up\n1,2\n", {"fs": 1}, "line 1 is neither a header nor data: cell 2 is 'up'"),
    ("r.csv", "t\n0\n1\n", {}, "no channel is as long as time"),
    ("r.csv", "Time,x\n05/03/2024 23:59:59,1\n05/04/2024 00:00:00,2\n", {}, "day and month cannot be distinguished"),
    ("r.csv", "Time,x\n30.02.2024 23:59:59,1\n01.03.2024 00:00:00,2\n", {}, "there is no date '30.02.2024'"),
    ("r.doc", b"\x01\x02\x03", {}, r"type '.doc' are not known; known: .csv"),
    ("r", b"\x01\x02\x03", {}, "type '' are not known"),
]


class TestRefusals:
    @pytest.mark.parametrize(("name", "content", "options", "message"), REFUSED, ids=[row[3][:40] for row in REFUSED])
    def test_one_line_that_names_file_and_fault(
        self, tmp_path: Path, name: str, content: str | bytes, options: dict[str, Any], message: str
    ) -> None:
        path = written(tmp_path, name, content)
        with pytest.raises(RecordError, match=message) as refusal:
            warnings_ignored(path, options)
        assert str(refusal.value).startswith(f"{path}: ")
        assert str(refusal.value).isprintable()

    def test_missing_file(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"none\.csv: there is no such file"):
            read_record(tmp_path / "none.csv")

    def test_folder(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="is a folder"):
            read_record(tmp_path)

    def test_path_that_no_file_can_have(self) -> None:
        for path in ("a\0b.csv", "x" * 5000 + ".csv"):
            with pytest.raises(RecordError, match=r"no such file|cannot be read"):
                read_record(path)

    @pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="needs a file that exists and cannot be read")
    def test_unreadable_file(self, tmp_path: Path) -> None:
        os.symlink("/proc/self/mem", tmp_path / "r.csv")
        with pytest.raises(RecordError, match="cannot be read: "):
            read_record(tmp_path / "r.csv")

    def test_a_variable_that_stands_twice(self, tmp_path: Path) -> None:
        once = matlab(x=np.arange(4.0))
        with pytest.raises(RecordError, match="contains two variables named 'x'"):
            read_record(written(tmp_path, "r.mat", once + once[128:]), fs=1)


class TestAnyBytes:
    """Whatever stands in a file, it gives a record or a `RecordError`."""

    @FUZZ
    @given(content=st.binary(max_size=400), suffix=st.sampled_from([".csv", ".txt", ".tsv", ".mat"]))
    def test_random_bytes(self, scratch: Path, content: bytes, suffix: str) -> None:
        self.record_or_refusal(scratch, suffix, content)

    @FUZZ
    @given(text=st.text("0123456789.,;\t\n\r\"'-+ enaifxt_#µ\u2028", max_size=80))
    def test_random_text(self, scratch: Path, text: str) -> None:
        self.record_or_refusal(scratch, ".csv", text.encode())

    @FUZZ
    @given(data=st.data(), compressed=st.booleans())
    def test_damaged_matlab_files(self, scratch: Path, data: st.DataObject, compressed: bool) -> None:
        stream = io.BytesIO()
        content = {"t": np.arange(9.0), "x": np.ones(9), "s": {"a": [1, "b"]}, "c": np.array(["u", 2], object)}
        savemat(
            stream,  # type: ignore[arg-type]  # the stubs know paths only
            content,
            do_compression=compressed,
        )
        damaged = bytearray(stream.getvalue())
        for _ in range(data.draw(st.integers(1, 4))):
            damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
        self.record_or_refusal(scratch, ".mat", bytes(damaged))

    @FUZZ
    @given(content=st.binary(max_size=200))
    def test_random_bytes_behind_a_true_matlab_header(self, scratch: Path, content: bytes) -> None:
        header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
        self.record_or_refusal(scratch, ".mat", header + content)

    @pytest.mark.parametrize("suffix", sorted({*READERS} - {".mf4", ".mdf"}))
    @pytest.mark.parametrize("content", [b"\x93\x00rubbish\xff" * 40, b"\n", b"x", bytes(range(256)) * 8])
    def test_binary_rubbish_under_each_extension(self, tmp_path: Path, suffix: str, content: bytes) -> None:
        with pytest.raises(RecordError, match=rf"r\{suffix}: "):
            read_recording(written(tmp_path, f"r{suffix}", content))

    @staticmethod
    def record_or_refusal(folder: Path, suffix: str, content: bytes) -> None:
        path = written(folder, f"r{suffix}", content)
        try:
            channels, message = read_recording(path, fs=100.0).channels, ""
        except RecordError as error:
            message = str(error)
            channels = ()
        assert message.isprintable()
        assert all(channel.values.size == channel.timepts.size for channel in channels)


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_delimiters_at_the_end_of_single_rows_hold_nothing(mark: str, tmp_path: Path) -> None:
    rows = [f"{k / 100}{mark}{k * k}" + (mark * 2 if k in (3, 7) else "") for k in range(12)]
    (tmp_path / "r.csv").write_text("\n".join([f"t{mark}seat", *rows]) + "\n", encoding="utf-8")
    record = read_record(tmp_path / "r.csv")
    np.testing.assert_array_equal(record.y[0], np.arange(12.0) ** 2)
