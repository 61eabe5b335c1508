"""Files of oscilloscopes: units above the names, channels that have numbers, a time that only a unit names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, clean, read_recording

TIMES = np.arange(400) / 8000 - 0.01
RINGING = np.exp(-60 * TIMES) * np.cos(900 * TIMES)


def saved(folder: Path, head: str, *, end: str = "") -> Path:
    path = folder / "scope.csv"
    rows = (f"{t:.6e},{y:.5e}{end}\n" for t, y in zip(TIMES, RINGING, strict=True))
    path.write_text(head + "".join(rows), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("head", "name", "unit"),
    [
        ("second,Volt\nx,1\n", "1", "Volt"),
        ("x-axis,1\nsecond,Volt\n", "1", "Volt"),
        ("second,Volt\nxaxis,y1\n", "y1", "Volt"),
        ("Model Number,SDS1202X\nSource,CH1\nSecond,Volt\n", "CH1", "Volt"),
        ("[s],CH1 [V]\n", "CH1 [V]", "V"),
    ],
)
def test_the_column_in_a_unit_of_time_is_the_time(tmp_path: Path, head: str, name: str, unit: str) -> None:
    (channel,) = read_recording(saved(tmp_path, head)).channels
    assert (channel.name, channel.unit) == (name, unit)
    assert np.allclose(channel.timepts, TIMES, rtol=0, atol=1e-9)
    assert np.allclose(channel.values, RINGING, rtol=0, atol=1e-5)


def test_a_title_above_the_first_of_two_columns_names_none(tmp_path: Path) -> None:
    """It stands alone in its line, where the name of a column has others beside it."""
    (channel,) = read_recording(saved(tmp_path, "Mode,Detail,\nWaveform Data,\n", end=",")).channels
    assert channel.name == "column 2"
    assert np.allclose(channel.timepts, TIMES, rtol=0, atol=1e-9)


def test_milliseconds_above_an_axis_are_milliseconds(tmp_path: Path) -> None:
    (channel,) = read_recording(saved(tmp_path, "ms,V\nx,1\n")).channels
    assert np.allclose(channel.timepts, TIMES / 1000, rtol=0, atol=1e-12)


def test_a_row_with_a_word_in_it_is_no_header(tmp_path: Path) -> None:
    """Numbers of channels rise; other numbers beside a word are a row that is damaged."""
    with pytest.raises(RecordError, match="line 2 is neither a header nor data"):
        read_recording(saved(tmp_path, "x,seat\nx,0.5\n"))


def test_what_is_in_a_unit_of_time_and_does_not_run_as_a_clock_is_no_time(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("s,V\ndelay,seat\n" + "".join(f"{y:.4f},{y:.3f}\n" for y in RINGING), encoding="utf-8")
    with pytest.raises(RecordError, match="no column is named like a time"):
        read_recording(path)


class TestStatedAxis:
    """Tektronix states unit and step of the horizontal axis, above the columns or beside their first rows."""

    STEP = 3.2e-4
    STAMPS = -0.32 + STEP * np.arange(2000)
    VALUES = np.exp(-3 * STAMPS) * np.cos(200 * STAMPS)

    def above(self, folder: Path, *, unit: str = "S", step: float = STEP, digits: int = 3) -> Path:
        """Stamps of so few digits that one step is a third longer than another."""
        path = folder / "scope.csv"
        head = f"Model,TBS1052C\nHorizontal Units,{unit}\nSample Interval,{step:g}\nRecord Length,2000\nTIME,CH1\n"
        rows = (f"{t:.{digits}e},{y:.4g}\n" for t, y in zip(self.STAMPS, self.VALUES, strict=True))
        path.write_text(head + "".join(rows), encoding="utf-8")
        return path

    def beside(self, folder: Path, unit: str) -> Path:
        path = folder / "scope.csv"
        settings = ["Record Length,400,", ",,", f"Horizontal Units,{unit},", "Vertical Units,V,", *[",,"] * 396]
        rows = (f"{cells},{t:.6f},{y:.5f},\n" for cells, t, y in zip(settings, TIMES + 0.01, RINGING, strict=True))
        path.write_text("".join(rows), encoding="utf-8")
        return path

    def test_its_step_is_more_exact_than_stamps_of_few_digits(self, tmp_path: Path) -> None:
        recording = read_recording(self.above(tmp_path))
        assert recording["CH1"].rate == pytest.approx(3125.0, rel=1e-12)
        assert not [what for what, _ in recording.left_out if what.startswith("unit of")]
        (finding,) = [one for one in clean(recording).findings if not one.channel]
        assert "off the stated 3125 Hz" in str(finding)

    def test_a_step_of_few_digits_yields_to_stamps_of_more(self, tmp_path: Path) -> None:
        """Steps of 316.5 µs are stated with two digits: after 2000 samples, 22 more would fit."""
        self.STAMPS = -0.32 + 3.165e-4 * np.arange(2000)
        assert read_recording(self.above(tmp_path, digits=6))["CH1"].rate is None

    def test_another_unit_is_that_of_the_stamps(self, tmp_path: Path) -> None:
        path = self.above(tmp_path, unit="ms", step=3.2e-7, digits=9)
        assert np.allclose(read_recording(path)["CH1"].timepts, self.STAMPS / 1e3, rtol=0, atol=1e-11)

    def test_where_the_stated_step_is_that_of_the_stamps_they_are_seconds(self, tmp_path: Path) -> None:
        path = self.above(tmp_path, unit="us", digits=9)
        assert np.allclose(read_recording(path)["CH1"].timepts, self.STAMPS, rtol=0, atol=1e-9)

    @pytest.mark.parametrize("unit", ["s/div", "Samples"])
    def test_what_is_no_unit_of_time_is_none(self, unit: str, tmp_path: Path) -> None:
        path = self.above(tmp_path, unit=unit, digits=9)
        path.write_text(path.read_text("utf-8").replace("Sample Interval", "Trigger"), encoding="utf-8")
        assert np.allclose(read_recording(path)["CH1"].timepts, self.STAMPS, rtol=0, atol=1e-9)

    def test_seconds_beside_the_rows(self, tmp_path: Path) -> None:
        recording = read_recording(self.beside(tmp_path, "s"))
        assert np.allclose(recording["column 5"].timepts, TIMES + 0.01, rtol=0, atol=1e-6)
        assert "unit of 'column 4'" not in dict(recording.left_out)

    def test_hertz_are_no_time(self, tmp_path: Path) -> None:
        path = self.beside(tmp_path, "Hz")
        for time in (None, "column 4"):
            with pytest.raises(RecordError, match="'column 4' holds frequencies"):
                read_recording(path, time=time)

    def test_channels_without_an_axis_have_none(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csv"
        rows = "".join(f"{y:.5f},{-y:.5f}\n" for y in RINGING)
        path.write_text(f"Horizontal Units,s\nSample Interval,2e-3\nCH1,CH2\n{rows}", encoding="utf-8")
        recording = read_recording(path)
        assert [(channel.name, channel.unit, channel.rate) for channel in recording.channels] == [
            ("CH1", "", 500.0),
            ("CH2", "", 500.0),
        ]
