"""Two loggers write into one table: each channel is what its own rows say, as if it stood in a file of its own."""

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, clean, identify, read_recording
from suspid.units import RealArray

DECAY = (3.0, 0.05)


def motion(times: RealArray, size: float, seed: int) -> RealArray:
    frequency, zeta = DECAY
    wn = 2 * np.pi * frequency
    swing = np.exp(-zeta * wn * times) * np.cos(wn * (1 - zeta**2) ** 0.5 * times)
    return np.asarray(size * swing + 1e-3 * np.random.default_rng(seed).standard_normal(times.size))


def written(path: Path, rows: dict[str, dict[float, float]]) -> Path:
    """Write a table of all times with what each channel has at each."""
    times = sorted(set().union(*rows.values()))
    cells = ([f"{rows[name][t]:.6g}" if t in rows[name] else "" for name in rows] for t in times)
    lines = [",".join([f"{t:.6g}", *row]) for t, row in zip(times, cells, strict=True)]
    path.write_text("\n".join([",".join(["time [s]", *rows]), *lines]) + "\n")
    return path


def logged(step: float, first: float, size: float, seed: int) -> dict[float, float]:
    times = np.round(first + step * np.arange(int(6 / step)), 6)
    return dict(zip(times.tolist(), motion(times, size, seed).tolist(), strict=True))


@pytest.mark.parametrize(("steps", "firsts"), [((0.01, 0.01), (0.0, 0.005)), ((0.01, 0.0125), (0.0, 0.003))])
def test_each_channel_has_its_own_rows(steps: tuple[float, float], firsts: tuple[float, float], tmp_path: Path) -> None:
    rows = {
        name: logged(*how) for name, how in zip("ab", zip(steps, firsts, (1.0, 0.5), (1, 2), strict=True), strict=True)
    }
    recording = read_recording(written(tmp_path / "two.csv", rows))
    for name in "ab":
        assert recording[name].timepts == pytest.approx(list(rows[name]), abs=1e-9)
        assert recording[name].values == pytest.approx(list(rows[name].values()), rel=1e-5)
    cleaned = clean(recording, channels=["a", "b"])
    found = identify(cleaned.record)
    assert found.modes.wn_std is not None
    assert abs(found.modes.wn[0] - 2 * np.pi * DECAY[0]) < 4 * found.modes.wn_std[0]


def test_rows_lost_at_random_are_gaps(tmp_path: Path) -> None:
    """They keep the clock of the table, and half of them missing is too much."""
    lost, kept = logged(0.01, 0.0, 1.0, 1), logged(0.01, 0.0, 0.5, 2)
    rng = np.random.default_rng(3)
    rows = {"a": kept, "b": {t: v for t, v in lost.items() if rng.random() < 0.5}}
    recording = read_recording(written(tmp_path / "lost.csv", rows))
    assert recording["b"].timepts.size == recording["a"].timepts.size
    with pytest.raises(RecordError, match="298 numbers in 600 samples"):
        clean(recording, channels=["b"])
