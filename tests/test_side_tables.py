"""A table that stands beside the record in the same rows, as a spectrum does in exports of laboratory software."""

from pathlib import Path

import numpy as np

from suspid import read_recording

ROWS, BINS = 60, 33


def written(path: Path, *, bins: int, frequency: np.ndarray) -> Path:
    time = np.arange(ROWS) / 10
    angle = np.exp(-0.3 * time) * np.cos(3 * time)
    spectrum = np.abs(np.fft.rfft(angle, 2 * BINS - 2))
    lines = ["t / s;f / Hz;angle / rad;FFT / rad"]
    for k in range(ROWS):
        beside = (f"{frequency[k]:.9g}", f"{spectrum[k]:.9g}") if k < bins else ("", "")
        lines.append(f"{time[k]:.6f};{beside[0]};{angle[k]:.9f};{beside[1]}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_spectrum_beside_the_record_is_no_channel(tmp_path: Path) -> None:
    found = read_recording(written(tmp_path / "a.csv", bins=BINS, frequency=np.arange(BINS) * 5 / (BINS - 1)))
    assert [channel.name for channel in found.channels] == ["angle / rad"]
    assert [str(why) for name, why in found.left_out if "FFT" in name] == ["ends with 'f / Hz', which is no time"]


def test_a_sensor_that_stops_early_is_a_channel(tmp_path: Path) -> None:
    rough = np.cumsum(0.15 + 0.01 * np.sin(np.arange(BINS)))
    found = read_recording(written(tmp_path / "a.csv", bins=BINS, frequency=rough))
    assert len(found.channels) == 3
