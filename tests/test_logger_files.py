"""What loggers and spreadsheets write that is no plain table: clocks in digits, overloads, a tail of zero bytes."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, analyse, clean, read_record, read_recording
from suspid.identification.nonlinear import choice

TIME = np.arange(1000) / 200
SWING = 20 * np.exp((-0.6 + 12j) * TIME).real


def digits(seconds: float) -> str:
    whole = int(seconds) % 86400
    return f"{whole // 3600:02d}{whole // 60 % 60:02d}{whole % 60 + seconds % 1:06.3f}"


def written(path: Path, rows: list[str], header: str = "time,seat") -> Path:
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


class TestClocksInDigits:
    @pytest.mark.parametrize("start", [12 * 3600 + 34 * 60 + 58, 13 * 3600 - 2, 24 * 3600 - 2])
    def test_end_of_a_minute_an_hour_and_a_day(self, start: int, tmp_path: Path) -> None:
        """They were gaps of 40 s, gaps of 4040 s, and time that runs backwards."""
        rows = [f"{digits(start + round(t, 3))},{y:.5f}" for t, y in zip(TIME, SWING, strict=True)]
        record = read_record(written(tmp_path / "r.csv", rows))
        np.testing.assert_allclose(record.time - record.time[0], TIME, atol=1e-6)
        left = dict(read_recording(tmp_path / "r.csv").left_out)
        assert "hours, minutes and seconds" in str(left["unit of 'time'"])

    def test_a_gap_is_still_one(self, tmp_path: Path) -> None:
        rows = [f"{125958 + t + 40 * (t > 3):.3f},{y:.5f}" for t, y in zip(TIME, SWING, strict=True)]
        with pytest.raises(RecordError, match="missing"):
            clean(read_recording(written(tmp_path / "r.csv", rows)))


class TestText:
    @pytest.mark.parametrize("word", ["OVL", "-OVER", "Overload", "1.#INF"])
    def test_an_overload_is_a_missing_sample(self, word: str, tmp_path: Path) -> None:
        rows = [f"{t:.3f},{word if k == 400 else f'{y:.5f}'}" for k, (t, y) in enumerate(zip(TIME, SWING, strict=True))]
        recording = read_recording(written(tmp_path / "r.csv", rows))
        assert np.flatnonzero(np.isnan(recording["seat"].values)).tolist() == [400]

    def test_zero_bytes_behind_the_last_row_are_none_of_it(self, tmp_path: Path) -> None:
        path = written(tmp_path / "r.csv", [f"{t:.3f},{y:.5f}" for t, y in zip(TIME, SWING, strict=True)])
        before = read_record(path)
        path.write_bytes(path.read_bytes() + bytes(4096))
        assert np.array_equal(read_record(path).y, before.y)

    @pytest.mark.parametrize("mark", [" ", "\u00a0", "\u202f"])
    def test_thousands_marked_by_blanks_are_not_cut_in_two(self, mark: str, tmp_path: Path) -> None:
        """Thousands and the rest were two channels."""
        numbers = [f"{120000 + y:.1f}".replace(".", ",") for y in SWING]
        rows = [f"{t:.3f}\t".replace(".", ",") + f"{n[:3]}{mark}{n[3:]}" for t, n in zip(TIME, numbers, strict=True)]
        with pytest.raises(RecordError, match="without a mark between the thousands"):
            read_recording(written(tmp_path / "r.csv", rows, "time (s)\tseat (µm)"))


def test_a_stamp_at_midnight_is_kept(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    book = openpyxl.Workbook()
    book.active.append(["time", "seat"])
    first = datetime(2024, 3, 9, 23, 59, 58)
    for t, y in zip(TIME, SWING, strict=True):
        book.active.append([first + timedelta(seconds=float(t)), float(y)])
    book.save(tmp_path / "r.xlsx")
    record = read_record(tmp_path / "r.xlsx")
    assert record.time.size == TIME.size
    np.testing.assert_allclose(record.y[0], SWING, rtol=1e-12)


def test_the_rate_advised_is_that_of_the_clock(tmp_path: Path) -> None:
    """It was that of the rows that are there: 8 % lower than that of the clock."""
    kept = np.delete(np.arange(1000), np.arange(30, 990, 12))
    rows = [f"{5004 * k},{SWING[k]:.5f}" for k in kept]
    left = dict(read_recording(written(tmp_path / "r.csv", rows)).left_out)
    assert f"fs={1e6 / 5004:.6g} if it is us" in str(left["unit of 'time'"])


def test_a_decay_of_filtered_accelerometers_beside_hum(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their filter rings for some samples, and they are AC-coupled; the mains hum throughout.

    The decay was doubtful, and took a minute, most of it to look for friction; the hum was said to begin with it.
    """
    from scipy.signal import butter, lfilter, sosfilt

    monkeypatch.setattr(choice, "by_equations", lambda *_, **__: pytest.fail("friction was sought"))

    rng = np.random.default_rng(3)
    fine = np.arange(0, 6, 1 / 4000)
    moved = np.zeros((2, fine.size))
    after = fine[fine >= 1] - 1
    slow, fast = np.exp((-1.2 + 28j) * after), np.exp((-5 + 61j) * after)
    moved[:, fine >= 1] = np.stack([slow.real + 0.4 * fast.real, 0.6 * slow.real - 1.1 * fast.real])
    coupled = lfilter(*butter(1, 0.7, "high", fs=4000), moved, axis=1)
    felt = sosfilt(butter(4, 100, fs=4000, output="sos"), coupled, axis=1)[:, ::16]
    time = np.arange(felt.shape[1]) / 250
    felt = felt + 0.03 * np.cos(2 * np.pi * 50.02 * time) + 0.003 * rng.standard_normal(felt.shape)
    np.savetxt(
        tmp_path / "r.csv", np.column_stack([time, felt.T]), "%.6g", ",", header="time [s],a [g],b [g]", comments=""
    )
    found = analyse(tmp_path / "r.csv")
    pairs = found.modes.poles[found.modes.poles.imag > 0]
    np.testing.assert_allclose(sorted(pairs, key=abs), [-1.2 + 28j, -5 + 61j], rtol=0.003)
    assert found.verdict.level.label in ("care", "sound")
    assert "50.02 Hz begins" not in str(found.verdict)
