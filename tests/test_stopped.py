"""Samples that are no measurement: those that a logger repeats, and what a sensor that has stopped leaves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import analyse, clean, read_recording
from suspid.recordings import RawChannel, Recording
from suspid.units import RealArray
from suspid.words import Defect, Level

POLE = -0.3 + 19j
TIME = np.arange(1500) / 100
SWING = np.where(TIME > 1, np.exp(POLE * (TIME - 1)).real, 1.0)


def noise(*shape: int) -> RealArray:
    return np.random.default_rng(7).standard_normal((*shape, TIME.size))


def recording(time: RealArray, **channels: RealArray) -> Recording:
    raw = (RawChannel(name=n, unit="mm", timepts=time, values=y, rate=None) for n, y in channels.items())
    return Recording(title="test", channels=tuple(raw))


class TestHeldSamples:
    @pytest.mark.parametrize("rows", [2, 3, 5])
    def test_one_of_each_is_used(self, rows: int, tmp_path: Path) -> None:
        """All of them gave as many modes as rows: images of the one there is, at multiples of its rate."""
        noisy = SWING + 0.003 * noise()
        time = np.arange(rows * TIME.size) / (100 * rows)
        table = np.column_stack([time, np.repeat(noisy, rows)])
        np.savetxt(tmp_path / "r.csv", table, "%.6g", ",", header="time [s],seat [mm]", comments="")
        found = analyse(tmp_path / "r.csv")
        assert len(found.modes) == 1
        assert found.modes.wn[0] == pytest.approx(abs(POLE), rel=1e-3)
        assert found.verdict.level is Level.SOUND
        assert any(f"stands in {rows} rows" in one.text for one in found.cleaned.findings)

    def test_a_channel_at_the_full_rate_keeps_all(self) -> None:
        noisy = SWING + 0.003 * noise(2)
        cleaned = clean(recording(TIME, seat=noisy[0], chassis=np.repeat(noisy[1, ::3], 3)))
        assert cleaned.record.time.size == TIME.size
        assert Defect.ONE_OF_EACH not in {one.kind for one in cleaned.findings}

    def test_one_that_is_slower_still_is_said(self) -> None:
        noisy = SWING + 0.003 * noise(2)
        held = clean(recording(TIME, seat=np.repeat(noisy[0, ::2], 2), chassis=np.repeat(noisy[1, ::4], 4)))
        assert held.record.time.size == TIME.size // 2
        said = [(one.channel, str(one.kind)) for one in held.findings]
        assert said == [("chassis", "held samples"), ("", "one of each")]

    def test_few_counts_of_an_encoder_are_kept(self) -> None:
        counts = np.repeat(np.arange(20.0), 10)
        cleaned = clean(recording(np.arange(200) / 100, seat=counts))
        assert cleaned.record.time.size == 200


class TestStoppedSensors:
    def test_the_record_ends_where_a_sensor_stops(self) -> None:
        noisy = SWING + 0.01 * noise(2)
        noisy[1, 900:] = noisy[1, 900]
        cleaned = clean(recording(TIME, seat=noisy[0], chassis=noisy[1]))
        (said,) = (one for one in cleaned.findings if one.kind is Defect.STOPPED)
        assert (said.channel, said.start, said.samples) == ("chassis", 9.0, 600)
        assert cleaned.record.time[-1] < 9.0

    @pytest.mark.parametrize("digits", [2, 6])
    def test_a_mass_that_friction_holds_has_not_stopped(self, digits: int) -> None:
        """Its motion had no noise before but that of the steps of its encoder."""
        held = np.where(TIME < 9, SWING, SWING[900]).round(digits)
        cleaned = clean(recording(TIME, seat=held))
        assert Defect.STOPPED not in {one.kind for one in cleaned.findings}
        assert cleaned.record.time.size == TIME.size


def test_a_column_is_no_magnitude_of_unknown_axes(tmp_path: Path) -> None:
    table = np.column_stack([TIME, SWING, np.full(TIME.size, np.nan), 0.5 * SWING, SWING - 0.1])
    np.savetxt(tmp_path / "r.csv", table, "%.6g", ",", header="time [s],ax,ay,az,strut", comments="")
    assert "strut" in read_recording(tmp_path / "r.csv").names
