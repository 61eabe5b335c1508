"""Files of oscilloscopes: units above the names, channels that have numbers, a time that only a unit names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, read_recording

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
