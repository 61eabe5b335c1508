"""Labels above text: pairs of label and value over each channel, and a unit of time among names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, Recording, read_recording
from suspid.io.text.cells import Kind
from suspid.io.text.columns import Columns
from suspid.io.text.dialects import COMMAS, Dialect
from suspid.io.text.label_columns import named_above, without_labels
from suspid.words import LeftOut

STEP = 0.0005
TIMES = STEP * np.arange(400)
RINGING = np.exp(-20 * TIMES) * np.cos(300 * TIMES)
PAIRS = (
    "Timestamp,2020-03-16 17:04:51,Timestamp,2020-03-16 17:04:51\n"
    "Interval,{a},Interval,{b}\n"
    'Channel name,"Force, front",Channel name,"Input 1"\n'
    'Unit,"kN",Unit,"V"\n'
)
DRIVE = (
    "Axis1\nNumber of sampling data,400\nSampling time interval(ms),0.5\n"
    "Time,Analog 1,Analog 2\nms,Servo motor speed,Torque\n"
)


def read(folder: Path, head: str, *columns: np.ndarray) -> Recording:
    path = folder / "a.csv"
    rows = (",".join(f"{x:.7g}" for x in row) for row in np.column_stack(columns))
    path.write_text(head + "".join(f"{row}\n" for row in rows), encoding="utf-8")
    return read_recording(path)


class TestPairs:
    def test_names_and_units_are_behind_their_labels(self, tmp_path: Path) -> None:
        recording = read(tmp_path, PAIRS.format(a=STEP, b=STEP), TIMES, RINGING, TIMES, -RINGING)
        assert recording.names == ("Force, front", "Input 1")
        assert [channel.unit for channel in recording.channels] == ["kN", "V"]
        assert [channel.rate for channel in recording.channels] == [pytest.approx(2000)] * 2
        assert np.allclose(recording["Input 1"].values, -RINGING, rtol=0, atol=1e-6)
        left = dict(recording.left_out)
        assert left["Time (2)"].code is LeftOut.SAME_TIME
        assert "name of column 3" not in left

    def test_quotes_within_a_name_stay(self, tmp_path: Path) -> None:
        (channel,) = read(tmp_path, 'Interval,0.0005\nName,"Force ""a"", front"\nUnit,N\n', TIMES, RINGING).channels
        assert (channel.name, channel.unit) == ('Force "a", front', "N")

    def test_each_channel_has_its_time(self, tmp_path: Path) -> None:
        recording = read(tmp_path, PAIRS.format(a=STEP, b=2 * STEP), TIMES, RINGING, 2 * TIMES, -RINGING)
        assert [channel.mean_rate for channel in recording.channels] == [pytest.approx(2000), pytest.approx(1000)]

    def test_a_step_that_the_stamps_do_not_keep_is_told(self, tmp_path: Path) -> None:
        recording = read(tmp_path, PAIRS.format(a=1.0, b=1.0), TIMES, RINGING, TIMES, -RINGING)
        assert recording["Input 1"].mean_rate == pytest.approx(2000)
        assert dict(recording.left_out)["rate 'Interval'"].code is LeftOut.OUTVOTED

    def test_without_a_step_the_column_has_no_name_and_runs_as_a_clock(self, tmp_path: Path) -> None:
        (channel,) = read(tmp_path, "Signal,Force\nUnit,N\n", TIMES, RINGING).channels
        assert (channel.name, channel.unit) == ("Force", "N")
        with pytest.raises(RecordError, match="'column 1', 'Force'"):
            read(tmp_path, "Signal,Force\nUnit,N\n", RINGING, RINGING)

    @pytest.mark.parametrize("head", ["Time,Force\nUnit,N\n", "Time,Force\ns,N\n"])
    def test_a_name_is_no_label(self, tmp_path: Path, head: str) -> None:
        """Logger programs write the word for unit where they know none."""
        path = tmp_path / "a.csv"
        path.write_text(head + "0,1\n1,2\n5,2.5\n9,3.5\n", encoding="utf-8")
        assert read_recording(path)["Force"].timepts.tolist() == [0, 1, 5, 9]

    @pytest.mark.parametrize("steps", ["Interval,0.5,Interval,0.25", "Interval,0.5,Interval,-", "Delay,0.5,Delay,0.5"])
    def test_steps_that_differ_state_no_rate(self, steps: str) -> None:
        lines = [steps, "Name,Force,Name,Travel", "Unit,N,Unit,mm"]
        assert without_labels(lines, Columns(COMMAS, ("number",) * 4))[1] == {}

    @pytest.mark.parametrize(
        ("names", "units"),
        [
            ("Name,Force,Name,Travel", "Unity,N,Unity,mm"),
            ("Name,Force,Signal,Travel", "Unit,N,Unit,mm"),
            ("Name,Force,Name", "Unit,N,Unit"),
            ("Name Force Name Travel", "Unit N Unit mm"),
        ],
    )
    def test_other_lines_stay(self, names: str, units: str) -> None:
        """Blanks would part a name without a label as well."""
        dialect = COMMAS if "," in names else Dialect(delimiter=" ", comma=False)
        kinds: list[Kind] = ["number"] * len(dialect.cells(names))
        assert without_labels([names, units], Columns(dialect, tuple(kinds))) == ([names, units], {})


class TestUnitOfTimeAmongNames:
    def test_the_name_of_the_time_is_above(self, tmp_path: Path) -> None:
        recording = read(tmp_path, DRIVE, 1000 * TIMES, RINGING, -RINGING)
        assert recording.names == ("Servo motor speed", "Torque")
        assert np.allclose(recording["Torque"].timepts, TIMES, rtol=0, atol=1e-9)
        assert recording["Torque"].rate == pytest.approx(2000)

    @pytest.mark.parametrize("above", ["Time,Analog 1", "Group,Analog 1,Analog 2", ""])
    def test_what_is_no_time_above_names_none(self, tmp_path: Path, above: str) -> None:
        head = f"{above}\nms,Servo motor speed,Torque\n"
        with pytest.raises(RecordError, match="no column is named like a time: 'ms', 'Servo motor speed'"):
            read(tmp_path, head, 1000 * TIMES, RINGING, -RINGING)

    def test_a_unit_below_another_name_is_a_name(self, tmp_path: Path) -> None:
        """Such as s for a way."""
        recording = read(tmp_path, "Time,Analog 1,Analog 2\nms,s,Servo torque\n", 1000 * TIMES, RINGING, -RINGING)
        assert recording.names == ("s", "Servo torque")

    def test_a_name_that_another_column_has_is_not_taken(self) -> None:
        assert named_above(["Number,Time"], ["Time", "ms"], Columns(COMMAS, ("number",) * 2)) is None
