"""Files as small loggers and LabVIEW write them: clocks without a name, steps of few digits, more than the motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, read_record, read_recording
from suspid.io.clock_numbers import runs_as_clock
from suspid.io.column_plan import ColumnPlan
from suspid.io.not_motions import counters_of, parts_of_seconds, repeated_times
from suspid.words import LeftOut

TIMES = np.arange(300) / 40
SEAT = np.exp(-0.4 * TIMES) * np.cos(9 * TIMES)
# A loop of an Arduino takes some milliseconds more or less.
JITTER = np.random.default_rng(5).integers(-3, 4, TIMES.size)


def table(path: Path, *columns: list[str], head: str = "") -> Path:
    path.write_text(head + "".join(",".join(row) + "\n" for row in zip(*columns, strict=True)), encoding="utf-8")
    return path


SAMPLES = [f"{500 * y:.0f}" for y in SEAT]
MILLIS = [f"{1000 * t + late:.0f}" for t, late in zip(TIMES, JITTER, strict=True)]


@pytest.mark.parametrize("columns", [(MILLIS, SAMPLES, SAMPLES[::-1]), (SAMPLES, SAMPLES[::-1], MILLIS)])
def test_milliseconds_that_jitter_are_a_time_without_a_name(tmp_path: Path, columns: tuple[list[str], ...]) -> None:
    """A count of rows and an axis go in even steps; small loggers write the time first or last."""
    first, second = read_recording(table(tmp_path / "a.txt", *columns)).channels
    assert np.array_equal(first.timepts, second.timepts)
    # Each of the 300 samples is up to 3 ms from its place.
    assert float(np.mean(np.diff(first.timepts))) == pytest.approx(1 / 40, abs=2 * 3e-3 / 299)


def test_a_displacement_that_ramps_evenly_is_no_time_without_a_name(tmp_path: Path) -> None:
    """A crosshead goes 0.05 mm a row: taken as the time, every frequency would be wrong, and nothing would tell."""
    path = table(tmp_path / "a.txt", SAMPLES, [f"{0.05 * k:.2f}" for k in range(TIMES.size)])
    with pytest.raises(RecordError, match="'column 2' increases like a time"):
        read_recording(path)


def test_stamps_of_a_log_of_python_are_the_time(tmp_path: Path) -> None:
    """Its milliseconds follow a comma, and a blank."""
    rows = [f"2021-12-27 18:06:{t:06.3f}, {y}, -0.05".replace(".", ",", 1) for t, y in zip(TIMES, SAMPLES, strict=True)]
    path = tmp_path / "a.log"
    path.write_text("\n".join(row.replace(", ", " ", 1) for row in rows), encoding="utf-8")
    recording = read_recording(path)
    np.testing.assert_allclose(recording.channels[0].timepts, TIMES, atol=1e-9)
    assert recording.channels[0].values.tolist() == [float(y) for y in SAMPLES]


@pytest.mark.parametrize(
    "steps", [np.ones(99), np.full(99, 10.0), 1 + np.arange(99) % 2, np.geomspace(4, 400, 99) // 1]
)
def test_rows_an_axis_and_lost_frames_are_no_clock(steps: np.ndarray) -> None:
    assert not runs_as_clock(np.concatenate([[0.0], np.cumsum(steps)]))


@pytest.mark.parametrize("back", [0, 47])
def test_the_column_that_increases_is_named_where_none_is_taken(tmp_path: Path, back: int) -> None:
    """The clock of a micro:bit steps back by some milliseconds once in a while."""
    even = [f"{10 * k - back * (k > 150)}" for k in range(TIMES.size)]
    with pytest.raises(RecordError, match="'column 3' increases like a time: if it is one, give time='column 3'"):
        read_recording(table(tmp_path / "a.txt", SAMPLES, SAMPLES[::-1], even))
    with pytest.raises(RecordError, match="give time='column 2'"):
        read_recording(table(tmp_path / "a.txt", SAMPLES, even, SAMPLES[::-1]))


def test_a_column_that_is_alone_is_no_time_to_be_named(tmp_path: Path) -> None:
    with pytest.raises(RecordError) as refused:
        read_recording(table(tmp_path / "a.txt", [f"{k}" for k in range(50)]))
    assert "'column 1'; give the sampling rate (fs); 'column 1' increases like a time, and no other" in str(
        refused.value
    )


# A clock that jitters by a tenth of its steps.
LATE = TIMES + np.random.default_rng(7).uniform(0.0, 2.5e-3, TIMES.size)


@pytest.mark.parametrize("place", [1, 2])
@pytest.mark.parametrize("back", [0.0, 0.09])
def test_a_clock_with_decimals_is_a_time_behind_samples(tmp_path: Path, place: int, back: float) -> None:
    """Of a board that was set back once, too."""
    stamps = LATE - back * (np.arange(TIMES.size) > 120)
    columns = [SAMPLES, SAMPLES[::-1]]
    columns.insert(place, [f"{t:.4f}" for t in stamps])
    recording = read_recording(table(tmp_path / "a.txt", *columns))
    assert dict(recording.left_out)[f"column {place + 1}"].code is LeftOut.TAKEN_AS_TIME
    np.testing.assert_allclose(recording.channels[0].timepts, stamps, atol=6e-5)


LOOP = [f"{np.sin(np.pi * t / TIMES[-1]) + 0.02 * np.cos(90 * t):.4f}" for t in TIMES]


@pytest.mark.parametrize(
    "columns",
    [
        (SAMPLES, SAMPLES[::-1], [f"{0.05 * k:.2f}" for k in range(TIMES.size)]),
        (SAMPLES, SAMPLES[::-1], [f"{k / 30:.3f}" for k in range(TIMES.size)]),
        (SAMPLES, [f"{3 * t:.4f}" for t in LATE], [f"{t:.4f}" for t in LATE]),
        (LOOP, LOOP, [f"{t:.4f}" for t in LATE]),
        (SAMPLES, [f"{k**2}" for k in range(TIMES.size)], [f"{t:.4f}" for t in LATE]),
    ],
    ids=["crosshead", "rounded crosshead", "two ways", "loop of force", "a way"],
)
def test_what_may_be_a_way_is_no_time_behind_samples(tmp_path: Path, columns: tuple[list[str], ...]) -> None:
    with pytest.raises(RecordError, match="no column is named like a time"):
        read_recording(table(tmp_path / "a.txt", *columns))


@pytest.mark.parametrize("step", [5, 10])
def test_whole_milliseconds_in_even_steps_are_a_time_before_samples(tmp_path: Path, step: int) -> None:
    stamps = [f"{step * k}" for k in range(TIMES.size)]
    recording = read_recording(table(tmp_path / "a.csv", stamps, SAMPLES, head="\ufeff"))
    said = {name: remark.code for name, remark in recording.left_out}
    assert said == {"column 1": LeftOut.TAKEN_AS_TIME, "unit of 'column 1'": LeftOut.FINER_UNIT}
    np.testing.assert_allclose(recording["column 2"].timepts, step / 1e3 * np.arange(TIMES.size))


# Three peaks over a floor.
SPECTRUM = [f"{1 + sum(9 / (1 + (k - at) ** 2 / 9) for at in (60, 130, 210)) + 0.1 * (k % 2):.4f}" for k in range(300)]


@pytest.mark.parametrize(
    ("first", "step", "samples"),
    [(0, 2, SAMPLES), (0, 3, SAMPLES), (300, 5, SAMPLES), (0, 10, LOOP), (0, 10, SPECTRUM)],
    ids=["every second row", "every third row", "wavelengths", "loop of force", "spectrum"],
)
def test_another_axis_of_whole_numbers_is_none(tmp_path: Path, first: int, step: int, samples: list[str]) -> None:
    axis = [f"{first + step * k}" for k in range(TIMES.size)]
    with pytest.raises(RecordError, match="'column 1' increases like a time"):
        read_recording(table(tmp_path / "a.txt", axis, samples))


def test_the_angles_of_a_turn_are_none(tmp_path: Path) -> None:
    angles = [f"{5 * k}" for k in range(72)]
    with pytest.raises(RecordError, match="'column 1' increases like a time"):
        read_recording(table(tmp_path / "a.txt", angles, SAMPLES[:72]))


@pytest.mark.parametrize(("names", "columns"), [("0", 1), ("0,1", 2)])
def test_an_index_of_time_under_the_header_of_pandas(tmp_path: Path, names: str, columns: int) -> None:
    """A series or a frame without names: the header is a blank and numbers."""
    stamps = [f"{t:.6f}" for t in TIMES]
    recording = read_recording(table(tmp_path / "a.csv", stamps, *[SAMPLES] * columns, head=f",{names}\n"))
    assert recording.names == tuple(names.split(","))
    assert dict(recording.left_out)["column 1"].code is LeftOut.TAKEN_AS_TIME
    np.testing.assert_allclose(recording.channels[0].timepts, TIMES, atol=1e-6)


def test_a_row_that_begins_with_a_blank_is_no_header(tmp_path: Path) -> None:
    stamps = ["", *[f"{t:.6f}" for t in TIMES[1:]]]
    assert read_recording(table(tmp_path / "a.csv", stamps, SAMPLES), fs=40.0)["column 2"].values.size == TIMES.size


def labview(path: Path, step: str, stamps: np.ndarray) -> Path:
    head = f"LabVIEW Measurement\t\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t1\nDelta_X\t{step}\n"
    rows = "".join(f"{t:.6f}\t{np.sin(0.3 * k):.6f}\n" for k, t in enumerate(stamps))
    path.write_text(f"{head}***End_of_Header***\t\t\nX_Value\tseat\n{rows}", encoding="utf-8")
    return path


def test_a_step_of_few_digits_yields_to_the_stamps_that_round_to_it(tmp_path: Path) -> None:
    """LabVIEW states 1/2048 s as 0.000488, which is 5e-4 off: two samples after 4096."""
    record = read_record(labview(tmp_path / "a.lvm", "0.000488", np.arange(4096) / 2048))
    assert (record.time[-1] - record.time[0]) / 4095 == pytest.approx(1 / 2048, rel=1e-6)


def test_a_step_beside_stamps_that_do_not_round_to_it_is_refused(tmp_path: Path) -> None:
    """Of 0.00048812 s five digits are known, and the stamps run 3e-4 beside it."""
    with pytest.raises(RecordError, match="disagree"):
        read_record(labview(tmp_path / "a.lvm", "0.00048812", np.arange(4096) / 2048))


class TestColumnsThatMeasureNothing:
    """What a sensor measures does not rise by one from row to row, nor is it the fraction of the second."""

    START = 1_406_729_720.491

    def test_counter_fraction_and_magnitude_of_dead_columns(self, tmp_path: Path) -> None:
        stamps = self.START + TIMES
        columns = {
            "Pt#": [f"{505_600 + k}" for k in range(TIMES.size)],
            "laser": [f"{y:.6f}" for y in SEAT],
            "D0": ["0"] * TIMES.size,
            "D1": ["0"] * TIMES.size,
            "DegC": ["999.0"] * TIMES.size,
            "DegF": ["999.0"] * TIMES.size,
            "Seconds": [f"{t:.6f}" for t in stamps],
            "FracSec": [f"{t % 1:.6f}" for t in stamps],
        }
        path = table(tmp_path / "a.csv", *columns.values(), head=",".join(columns) + "\n")
        recording = read_recording(path)
        left_out = {name: why.code for name, why in recording.left_out}
        assert left_out["Pt#"] is LeftOut.ROW_COUNTER
        assert left_out["FracSec"] is LeftOut.PARTS
        assert "DegF" not in left_out
        assert [channel.name for channel in recording.channels] == ["laser", "D0", "D1", "DegC", "DegF"]

    def test_a_time_for_each_test_is_no_channel(self, tmp_path: Path) -> None:
        stamps = [f"{t:.6f}" for t in TIMES]
        path = table(tmp_path / "a.csv", stamps, stamps, SAMPLES, head="Time_a,Tb,seat\n")
        recording = read_recording(path, time="Time_a")
        assert [channel.name for channel in recording.channels] == ["seat"]
        assert dict(recording.left_out)["Tb"].code is LeftOut.SAME_TIME

    @pytest.mark.parametrize(
        ("late", "said"),
        [
            (0.0, "is the same time as 'Time A'"),
            (0.0025, "runs +0.0025 s from 'Time A': one is used for both"),
            (3600.0, "is the same time as 'Time A'"),
        ],
    )
    def test_a_time_before_each_channel(self, tmp_path: Path, late: float, said: str) -> None:
        """Two sensors that are read in turn have times half a sample apart; the time of day runs from another start."""
        first, second = ([f"{t + shift:.6f}" for t in TIMES] for shift in (0.0, late))
        path = table(tmp_path / "a.csv", first, SAMPLES, second, SAMPLES[::-1], head="Time A,A,Time B,B\n")
        recording = read_recording(path)
        assert [channel.name for channel in recording.channels] == ["A", "B"]
        assert str(dict(recording.left_out)["Time B"]) == said

    def test_a_second_time_without_a_name_is_no_channel(self, tmp_path: Path) -> None:
        first, second, drift = (
            [f"{t * pace + late:.6f}" for t in TIMES] for pace, late in ((1, 0), (1, 0.012), (2, 0))
        )
        # The second sensor stops before the first.
        second = [*second[:-4], *[""] * 4]
        path = table(tmp_path / "a.csv", first, SAMPLES, second, SAMPLES[::-1], drift)
        recording = read_recording(path)
        assert [channel.name for channel in recording.channels] == ["column 2", "column 4"]
        left_out = dict(recording.left_out)
        assert (left_out["column 3"].code, left_out["column 5"].code) == (LeftOut.SAME_TIME, LeftOut.EVEN)

    def test_what_changes_evenly_with_the_time_is_no_channel(self, tmp_path: Path) -> None:
        """A telephone writes the time of day in milliseconds beside the seconds of a test; a table has an axis."""
        stamps, since = [f"{t:.6f}" for t in TIMES], [f"{1580245353250 + 1000 * t:.0f}" for t in TIMES]
        axis, slide = [f"{500 - 2 * t:.6f}" for t in TIMES], [f"{t + 0.05 * np.sin(3 * t):.6f}" for t in TIMES]
        path = table(tmp_path / "a.csv", since, stamps, axis, slide, SAMPLES, head="epoc,time (s),axis,slide,seat\n")
        recording = read_recording(path)
        assert [channel.name for channel in recording.channels] == ["slide", "seat"]
        left_out = {name: why.code for name, why in recording.left_out}
        assert (left_out["epoc"], left_out["axis"]) == (LeftOut.EVEN, LeftOut.EVEN)

    @pytest.mark.parametrize(
        ("name", "start", "motion", "is_clock"),
        [
            ("/joints/header/stamp", 1.7e9, 0.0, True),
            ("/joints/seq", 1.7e9, 0.0, True),
            ("/joints/header/stamp", 0.0, 0.0, True),
            ("/carriage/x", 0.0, 0.0, False),
            ("/carriage/x", 0.0, 0.05, False),
            ("/joints/header/stamp", 1.7e9, 2.0, False),
            ("/joints/header/stamp", 1.7e9, 0.3, False),
        ],
        ids=["epoch", "by its size", "by its name", "driven", "swings", "falls", "strays"],
    )
    @pytest.mark.parametrize("every", [1, 4], ids=["each row", "held"])
    def test_a_clock_that_jitters_or_is_held_is_no_channel(
        self, tmp_path: Path, name: str, start: float, motion: float, is_clock: bool, every: int
    ) -> None:
        """Messages of robots hold the time at which they were sent beside that at which they came."""
        sent = start + (TIMES + 0.001 * JITTER)[np.arange(TIMES.size) // every * every]
        sent += motion * (1 - np.cos(TIMES))
        stamps = [f"{1.7e9 + t:.6f}" for t in TIMES]
        path = table(tmp_path / "a.csv", stamps, [f"{t:.9f}" for t in sent], SAMPLES, head=f"__time,{name},seat\n")
        recording = read_recording(path)
        assert recording.names == ("seat",) if is_clock else recording.names == (name, "seat")
        assert (LeftOut.EVEN in [why.code for _, why in recording.left_out]) is is_clock

    def test_a_ramp_alone_is_a_channel(self, tmp_path: Path) -> None:
        path = table(tmp_path / "a.csv", [f"{t:.6f}" for t in TIMES], [f"{2 * t:.6f}" for t in TIMES], head="time,x\n")
        assert [channel.name for channel in read_recording(path).channels] == ["x"]

    def test_a_sensor_in_whole_numbers_is_a_channel(self, tmp_path: Path) -> None:
        path = table(tmp_path / "a.csv", [f"{t:.6f}" for t in TIMES], SAMPLES, head="time,seat\n")
        assert [channel.name for channel in read_recording(path).channels] == ["seat"]


class TestLimitsOfWhatMeasuresNothing:
    """A column that comes near to a counter, a part of a second or a time, and is none."""

    @staticmethod
    def plan(*names: str) -> ColumnPlan:
        return ColumnPlan(channels=("seat", *names), time="t", clocks={}, rate=None, left_out={})

    @pytest.mark.parametrize(("rows", "counts"), [(30, False), (60, True)])
    def test_rows_that_rise_by_one_and_that_repeat_the_time(self, rows: int, counts: bool) -> None:
        times = np.arange(rows) / 40
        columns = {"t": times, "seat": np.cos(times), "load": 7.0 + np.arange(rows), "again": times}
        assert counters_of(self.plan("load", "again"), columns) == ["load"] * counts
        assert list(repeated_times(self.plan("load", "again"), columns)) == ["again"] * counts

    @pytest.mark.parametrize(("step", "counts"), [(2.0, True), (250.0, True), (0.5, False), (-2.0, False)])
    def test_rows_that_rise_by_the_same_whole_number(self, step: float, counts: bool) -> None:
        times = np.cumsum(np.random.default_rng(1).uniform(0.02, 0.03, 60))
        columns = {"t": times, "seat": np.cos(times), "j": step * np.arange(60.0)}
        assert counters_of(self.plan("j"), columns) == ["j"] * counts

    def test_milliseconds_beside_the_time_are_a_clock(self, tmp_path: Path) -> None:
        """Of an even clock in another unit; alone, they are the time."""
        stamps = [f"{25 * k}" for k in range(TIMES.size)]
        path = table(tmp_path / "a.csv", [f"{t:.3f}" for t in TIMES], stamps, SAMPLES, head="t [s],ticks,seat\n")
        assert dict(read_recording(path).left_out)["ticks"].code is LeftOut.EVEN
        path = table(tmp_path / "b.csv", stamps, SAMPLES, head="t [ms],seat\n")
        np.testing.assert_allclose(read_recording(path)["seat"].timepts, TIMES)

    @pytest.mark.parametrize(
        ("late", "size", "seconds", "is_part"),
        [
            (0.0, 1.0, 5, True),
            (5e-3, 1.0, 5, False),
            (0.0, -1.0, 5, False),
            (0.0, 1.0, 0.6, False),
            (0.0, 1.0, 0, False),
        ],
        ids=["fraction", "fraction of another clock", "below zero", "of less than a second", "of few rows"],
    )
    def test_parts_of_a_second(self, late: float, size: float, seconds: float, is_part: bool) -> None:
        stamps = 1_405_617_736.2 + (np.arange(round(128 * seconds)) / 128 if seconds else np.arange(3) / 2)
        columns = {"seat": np.cos(stamps), "part": size * ((stamps + late) % 1)}
        assert list(parts_of_seconds(self.plan("part"), columns, stamps)) == ["part"] * is_part

    @pytest.mark.parametrize(
        ("pace", "held", "is_clock"), [(1.005, 1, True), (1.03, 1, False), (1.0, 2, True), (1.0, 5, False)]
    )
    def test_clocks_of_another_pace_and_that_are_held_long(self, pace: float, held: int, is_clock: bool) -> None:
        times = np.arange(400) / 50
        columns = {"t": times, "seat": np.cos(times), "stamp": np.floor(pace * times / held) * held}
        columns["stamp"] += 0 if held > 1 else pace * times % 1 + 0.001 * np.sin(40 * times)
        assert list(repeated_times(self.plan("stamp"), columns)) == ["stamp"] * is_clock

    def test_a_channel_that_is_alone_stays(self) -> None:
        stamps = np.arange(400) / 128
        plan = ColumnPlan(channels=("part",), time="t", clocks={}, rate=None, left_out={})
        assert parts_of_seconds(plan, {"part": stamps % 1}, stamps) == {}
        assert repeated_times(plan, {"t": stamps, "part": stamps}) == {}

    def test_a_rise_next_to_the_least_number_is_no_clock(self, tmp_path: Path) -> None:
        """Damaged files hold such numbers."""
        path = tmp_path / "a.csv"
        path.write_text("t,x,y\n" + "".join(f"{k},{k}e-320,{np.cos(k)}\n" for k in range(60)), encoding="utf-8")
        assert read_recording(path).names == ("x", "y")


@pytest.mark.parametrize(
    ("names", "is_clock"), [("C1,C2", True), ("Var1,Var2", True), ("p1,p2", False), ("C2,C3", False)]
)
def test_names_that_number_columns_are_none(tmp_path: Path, names: str, *, is_clock: bool) -> None:
    """As a spreadsheet, R or MATLAB names columns; two masses may be p1 and p2, and two sensors C2 and C3."""
    path = table(tmp_path / "a.csv", [f"{t:.3f}" for t in TIMES], [f"{y:.4f}" for y in SEAT], head=f"{names}\n")
    if not is_clock:
        with pytest.raises(RecordError, match="increases like a time"):
            read_recording(path)
        return
    (channel,) = read_recording(path).channels
    np.testing.assert_allclose(channel.timepts, TIMES, atol=1e-9)


@pytest.mark.parametrize("message", ["INFO  [logger] started: /fs/log.csv", "INFO [logger]\nstill on"])
def test_names_above_a_message_of_the_logger(tmp_path: Path, message: str) -> None:
    path = table(tmp_path / "a.csv", MILLIS, SAMPLES, head=f"timestamp_ms,seat\n{message}\n")
    assert [channel.name for channel in read_recording(path).channels] == ["seat"]


def test_names_above_another_row_are_of_that(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", MILLIS, SAMPLES, head="timestamp_ms,force\n100,ohm,3\n")
    assert [channel.name for channel in read_recording(path).channels] != ["force"]
