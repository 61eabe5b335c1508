"""Tests side by side in one table, each with its own clock and length: they are told apart, and chosen or joined."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, Settings, analyse, read_recording
from suspid.units import RealArray

ROWS = (900, 700, 800)


def clock(rows: int, seed: int) -> RealArray:
    """A logger that writes about each 50 ms, in hundredths of a second, and now and then twice in one."""
    late = np.cumsum(np.random.default_rng(seed).integers(-2, 3, rows)) % 3
    return np.asarray(np.round(0.05 * np.arange(rows) + 0.01 * late - 0.01 * late[0], 2))


def release(times: RealArray) -> RealArray:
    """A pendulum of 0.5 Hz, zeta 0.02."""
    return np.asarray(np.exp(-0.02 * np.pi * times) * np.cos(np.pi * times))


def table(path: Path, columns: dict[str, list[str]], mark: str) -> Path:
    most = max(map(len, columns.values()))
    filled = [[*column, *[""] * (most - len(column))] for column in columns.values()]
    rows = [mark.join(columns), *map(mark.join, zip(*filled, strict=True))]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def numbered(folder: Path, ends: tuple[int, ...] = ROWS) -> Path:
    columns: dict[str, list[str]] = {}
    noise = np.random.default_rng(9)
    for k, rows in enumerate(ends, start=1):
        times = clock(rows, k)
        samples = release(times) + 0.005 * noise.standard_normal(rows)
        columns |= {f"T{k}": [f"{t:.2f}" for t in times], f"S{k}": [f"{y:.4f}" for y in samples]}
    return table(folder / "pohl.csv", columns, ";")


def test_numbered_times_before_numbered_channels_are_tests(tmp_path: Path) -> None:
    recording = read_recording(numbered(tmp_path))
    assert recording.tests == ("1", "2", "3")
    for k, rows in enumerate(ROWS, start=1):
        (channel,) = recording.of_test(str(k)).channels
        assert channel.name == f"S{k}"
        assert channel.timepts == pytest.approx(clock(rows, k))


@pytest.mark.parametrize("test", ["2", "all"])
def test_one_of_them_or_all_give_the_mode(tmp_path: Path, test: str) -> None:
    found = analyse(numbered(tmp_path), settings=Settings(test=test))
    assert found.modes.wn == pytest.approx([np.pi], rel=0.01)
    assert found.modes.zeta == pytest.approx([0.02], rel=0.1)
    # The joint result has the name that they share.
    assert found.modes.channels == (("S",) if test == "all" else ("S2",))


def test_sensors_of_one_test_end_together(tmp_path: Path) -> None:
    """Each sensor has a clock of its own, and their rates differ; all are recorded at once."""
    assert not read_recording(numbered(tmp_path, (900, 900, 897))).tests


def test_temperatures_are_no_times(tmp_path: Path) -> None:
    """T may be a temperature: of an oven it rises, and bends."""
    warm = 20 + 60 * (1 - np.exp(-np.arange(900) / 300))
    columns = {f"{name}{k}": [f"{y:.2f}" for y in warm + k] for k in (1, 2) for name in ("T", "S")}
    with pytest.raises(RecordError, match="no column is named like a time"):
        read_recording(table(tmp_path / "oven.csv", columns, ";"))


class TestRunsOfCapstone:
    """Capstone numbers the runs behind name and unit, and writes the time of each before its channels."""

    # Decimals after a comma; three of them, but numbers below 0.001 have an exponent. The rate is 5 kHz.
    TIMES = np.arange(3000) / 5000

    def path(self, folder: Path, unit: str = "s") -> Path:
        factor = {"s": 1.0, "ms": 1e3}[unit]
        columns: dict[str, list[str]] = {}
        for k, rows in enumerate((3000, 2600), start=1):
            times = self.TIMES[:rows]
            ringing = np.exp(-20 * times) * np.cos(2000 * times)
            written = [f"{factor * t:.3E}" if 0 < t < 1e-3 else f"{factor * t + 1e-9:.3f}" for t in times]
            columns[f"Time ({unit}) Run #{k}"] = [t.replace(".", ",") for t in written]
            columns[f"Force (N) Run #{k}"] = [f"{y:.5f}".replace(".", ",") for y in ringing]
        return table(folder / "sound.csv", columns, ";")

    @pytest.mark.parametrize("unit", ["s", "ms"])
    def test_they_are_tests_on_their_own_times(self, tmp_path: Path, unit: str) -> None:
        recording = read_recording(self.path(tmp_path, unit))
        assert recording.tests == ("Run #1", "Run #2")
        assert [channel.unit for channel in recording.channels] == ["N", "N"]
        assert [channel.values.size for channel in recording.channels] == [3000, 2600]
        # The stamps are rounded to a millisecond.
        assert recording.channels[1].timepts == pytest.approx(self.TIMES[:2600], abs=0.6e-3)

    def test_all_of_them_give_the_mode(self, tmp_path: Path) -> None:
        found = analyse(self.path(tmp_path), settings=Settings(test="all"))
        assert found.modes.wn == pytest.approx([np.hypot(2000, 20)], rel=1e-3)
        assert found.modes.channels == ("Force (N)",)
