"""Texts that hold several recordings one below the other, and texts whose pages repeat the names of the columns."""

from pathlib import Path

import numpy as np
import pytest

import suspid
from suspid.units import RealArray

RATE, TURN, ZETA = 200.0, 2 * np.pi * 3.0, 0.05
COUNTS = (600, 560, 520)


def decay(count: int, *, size: float, seed: int) -> tuple[RealArray, RealArray]:
    """Return times and a motion that is held for half a second and let go, with noise of a thousandth."""
    t = np.arange(count) / RATE
    after = np.maximum(t - 0.5, 0.0)
    motion = size * np.exp(-ZETA * TURN * after) * np.cos(TURN * np.sqrt(1 - ZETA**2) * after)
    return t, motion + 1e-3 * np.random.default_rng(seed).standard_normal(count)


def lines(count: int, *, seed: int, delimiter: str = ",") -> list[str]:
    t, z = decay(count, size=1 + 0.1 * seed, seed=seed)
    return [f"{a:.3f}{delimiter}{b:.5f}" for a, b in zip(t, z, strict=True)]


def runs(tmp_path: Path, *, more: str = "") -> Path:
    """Write three runs below each other, each with a title and names, and perhaps ``more``."""
    blocks = [
        f"Run {k + 1}\nTime (s),z (mm)\n" + "\n".join(lines(count, seed=k)) + "\n\n" for k, count in enumerate(COUNTS)
    ]
    path = tmp_path / "runs.csv"
    path.write_text("Logger X\nSerial 12\n" + "".join(blocks) + more)
    return path


def test_recordings_one_below_the_other_are_tests(tmp_path: Path) -> None:
    recording = suspid.read_recording(runs(tmp_path))
    assert recording.tests == ("Run 1", "Run 2", "Run 3")
    assert recording.names == ("Run 1: z (mm)", "Run 2: z (mm)", "Run 3: z (mm)")
    for k, (channel, count) in enumerate(zip(recording.channels, COUNTS, strict=True)):
        t, z = decay(count, size=1 + 0.1 * k, seed=k)
        assert channel.unit == "mm"
        np.testing.assert_allclose(channel.timepts, t)
        np.testing.assert_allclose(channel.values, z, atol=1e-5)


def test_each_test_has_its_mode(tmp_path: Path) -> None:
    path = runs(tmp_path)
    for test in ("Run 1", "Run 2", "Run 3"):
        found = suspid.analyse(path, settings=suspid.Settings(test=test))
        assert len(found.modes) == 1
        np.testing.assert_allclose(found.modes.wn, TURN, rtol=2e-3)
        np.testing.assert_allclose(found.modes.zeta, ZETA, rtol=2e-2)


def test_lines_are_counted_through_all_sections(tmp_path: Path) -> None:
    recording = suspid.read_recording(runs(tmp_path, more="Run 4\nTime (s),z (mm)\n"))
    said = {name: str(remark) for name, remark in recording.left_out}
    rows = runs(tmp_path).read_text().split("\n")
    names = [k + 1 for k, line in enumerate(rows) if line == "Time (s),z (mm)"]
    assert said[f"line {names[1]}"] == "has the names of the columns again, the first of 3 lines"
    assert said[f"line {names[2] - 1}"] == "is above the data: 'Run 3'"
    assert said[f"line {len(rows) + 1}"] == "has names of columns, and no row below them"


def test_channels_are_named_with_their_test_or_without(tmp_path: Path) -> None:
    path = runs(tmp_path)
    assert suspid.read_recording(path, channels=["z (mm)"]).tests == ("Run 1", "Run 2", "Run 3")
    assert suspid.read_recording(path, channels=["Run 2: z (mm)"]).names == ("Run 2: z (mm)",)
    with pytest.raises(suspid.RecordError, match="there is no channel 'w'"):
        suspid.read_recording(path, channels=["w"])


def test_pages_of_one_record_are_joined(tmp_path: Path) -> None:
    rows = lines(600, seed=1, delimiter="\t")
    pages = ["t\tz\ns\tmm\n" + "\n".join(rows[k : k + 50]) for k in range(0, 600, 50)]
    path = tmp_path / "pages.txt"
    path.write_text("\n".join(pages) + "\n")
    recording = suspid.read_recording(path)
    assert (recording.tests, recording.names, recording["z"].unit) == ((), ("z",), "mm")
    np.testing.assert_allclose(recording["z"].timepts, np.arange(600) / RATE)


def test_segments_of_labview_are_tests(tmp_path: Path) -> None:
    head = ["LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t.", "***End_of_Header***\t", "\t"]
    text = "\n".join(head) + "\n"
    for k, count in enumerate(COUNTS):
        text += f"Channels\t1\t\nSamples\t{count}\t\nX_Dimension\tTime\t\nX0\t0.0000000000000000E+0\t\n"
        text += "Delta_X\t0.005000\t\n***End_of_Header***\t\t\nX_Value\tVoltage\tComment\n"
        text += "\n".join(lines(count, seed=k, delimiter="\t")) + "\n\n"
    path = tmp_path / "segments.lvm"
    path.write_text(text)
    recording = suspid.read_recording(path)
    assert recording.tests == ("Run 1", "Run 2", "Run 3")
    assert [channel.values.size for channel in recording.channels] == list(COUNTS)


@pytest.mark.parametrize("rate", ["", "Sample rate: 200 Hz\n"])
def test_rows_without_a_time_may_be_pages_or_tests(tmp_path: Path, rate: str) -> None:
    path = tmp_path / "rows.csv"
    path.write_text(rate + 2 * ("z\n" + "\n".join(row.split(",")[1] for row in lines(90, seed=0)) + "\n"))
    with pytest.raises(suspid.RecordError, match="no time tells whether the file holds several recordings"):
        suspid.read_recording(path, fs=RATE)


def test_a_rate_above_the_first_section_holds_for_all(tmp_path: Path) -> None:
    path = runs(tmp_path)
    path.write_text("Sample rate: 200 Hz\n" + path.read_text())
    assert [channel.rate for channel in suspid.read_recording(path).channels] == [RATE] * 3


def test_a_section_of_one_row_leaves_the_others(tmp_path: Path) -> None:
    recording = suspid.read_recording(runs(tmp_path, more="Run 4\nTime (s),z (mm)\n0.000,1.0\n"))
    assert [channel.values.size for channel in recording.channels] == [*COUNTS, 1]


def test_more_sections_than_any_file_has_are_refused(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("t,z\n0,1\n" * 5001)
    with pytest.raises(suspid.RecordError, match="has 5001 times the names of the columns, .* at most 5000 recordings"):
        suspid.read_recording(tmp_path / "r.csv")
