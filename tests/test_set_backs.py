"""Clocks that were set back by a few samples while the samples went on: loggers that keep the time of a network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, RecordWarning, clean, read_record, read_recording
from suspid.cleaning.clocks import read_clock
from suspid.stamps import continued
from suspid.units import RealArray
from suspid.words import Defect

ROWS = np.arange(500)
STEP = 0.02
RNG = np.random.default_rng(4)
# A board that waits between two samples, in whole milliseconds.
JITTERING: RealArray = np.asarray(np.round(STEP * ROWS + RNG.uniform(0, 0.003, ROWS.size), 3), float)
MOTION: RealArray = np.asarray(np.exp(-0.1 * STEP * ROWS) * np.cos(7 * STEP * ROWS), float)[None]


def set_back(stamps: RealArray, *after: int, samples: float = 2.5) -> RealArray:
    """Return stamps that fall by some samples after each of these rows."""
    return np.asarray(stamps - np.round(samples * STEP, 3) * np.searchsorted(np.array(after), ROWS), float)


class TestOneThatRunsOn:
    @pytest.mark.parametrize("samples", [1.4, 2.5, 7.5])
    @pytest.mark.parametrize("stamps", [STEP * ROWS, JITTERING], ids=["even", "jittering"])
    def test_is_one_uniform_clock(self, stamps: RealArray, samples: float) -> None:
        clock = read_clock(set_back(stamps, 270, samples=samples), MOTION)
        first = clock.findings[0]
        assert first.kind is Defect.SET_BACK
        assert clock.timepts.size == ROWS.size
        assert clock.step == pytest.approx(STEP, rel=1e-3)
        np.testing.assert_allclose(clock.timepts, STEP * ROWS, atol=0.3 * STEP)
        assert first.remark.numbers["row"] == 271
        back = first.remark.numbers["back"]
        # A jitter of 3 ms, and the last digit.
        assert isinstance(back, float)
        assert back == pytest.approx(samples * STEP, abs=4e-3)

    def test_its_frequency_is_that_of_the_samples(self, tmp_path: Path) -> None:
        text = "t [s],seat\n" + "".join(
            f"{t:.3f},{y:.6f}\n" for t, y in zip(set_back(JITTERING, 270), MOTION[0], strict=True)
        )
        (tmp_path / "a.csv").write_text(text, encoding="utf-8")
        with pytest.warns(RecordWarning):
            record = read_record(tmp_path / "a.csv")
        spectrum = np.abs(np.fft.rfft(np.squeeze(record.outputs), 1 << 16))
        step = (record.time[-1] - record.time[0]) / (record.time.size - 1)
        assert np.argmax(spectrum) / (1 << 16) / step == pytest.approx(7 / (2 * np.pi), rel=5e-3)
        said = str(clean(read_recording(tmp_path / "a.csv")).findings[0])
        assert "was set back by 0.05" in said
        assert "after row 271 and runs on at the same pace" in said

    def test_beside_a_channel_without_samples(self) -> None:
        values = np.concatenate([MOTION, np.full_like(MOTION, np.nan), np.where(ROWS == 60, np.inf, MOTION)])
        assert read_clock(set_back(JITTERING, 270), values).findings[0].kind is Defect.SET_BACK

    def test_twice_in_five_hundred_rows(self) -> None:
        clock = read_clock(set_back(JITTERING, 100, 380), MOTION)
        assert "set back 2 times" in str(clock.findings[0])
        np.testing.assert_allclose(clock.timepts, STEP * ROWS, atol=0.4 * STEP)


class TestAnother:
    """What is no clock that was set back is refused."""

    @pytest.mark.parametrize(
        "stamps",
        [
            set_back(JITTERING, 270, samples=20),
            set_back(JITTERING, 270, samples=270),
            set_back(JITTERING, 10),
            set_back(JITTERING, 490),
            set_back(JITTERING, *range(50, 500, 60)),
            set_back(np.where(ROWS > 270, 0.9 * JITTERING, JITTERING) + 0.542 * (ROWS > 270), 270),
            set_back(JITTERING, 270) + 0.08 * (ROWS > 400),
            set_back(np.where(ROWS > 480, 2 * STEP * ROWS - 9.6, STEP * ROWS), 480, samples=5),
        ],
        ids=[
            "by twenty samples",
            "restart",
            "near the start",
            "near the end",
            "often",
            "other pace",
            "and ahead",
            "half the rate",
        ],
    )
    def test_by_its_stamps(self, stamps: RealArray) -> None:
        assert not continued(stamps)[1].size
        with pytest.raises(RecordError, match="runs backwards"):
            read_clock(stamps, MOTION)

    def test_by_its_samples(self) -> None:
        """Two recordings, the second of which begins a little before the end of the first: the motion jumps."""
        values = MOTION + 0.8 * (ROWS > 270)
        with pytest.raises(RecordError, match="runs backwards"):
            read_clock(set_back(JITTERING, 270), values)
