"""Clocks that begin anew, have long breaks, or roll over, in files."""

from pathlib import Path

import numpy as np
import pytest

import suspid
from suspid.units import RealArray

RATE, TURN, ZETA = 200.0, 2 * np.pi * 3.0, 0.05
COUNTS = (600, 560, 520)


def decay(count: int, *, seed: int) -> tuple[RealArray, RealArray]:
    """Return times and a motion that is held for half a second and let go, with noise of a thousandth."""
    t = np.arange(count) / RATE
    after = np.maximum(t - 0.5, 0.0)
    motion = np.exp(-ZETA * TURN * after) * np.cos(TURN * np.sqrt(1 - ZETA**2) * after)
    return t, motion + 1e-3 * np.random.default_rng(seed).standard_normal(count)


def written(path: Path, *starts: float) -> Path:
    """Write three decays below each other, of which each has its clock begin at a start [s]."""
    rows = ["t,z (mm)"]
    for k, (start, count) in enumerate(zip(starts, COUNTS, strict=True)):
        rows += [f"{start + t:.3f},{z:.5f}" for t, z in zip(*decay(count, seed=k), strict=True)]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(
    ("starts", "said"),
    [
        ((0.0, 0.0, 0.0), "begins anew after row 600, the first of 2: what follows each is a test of its own"),
        ((5.1, 5.0, 5.2), "begins anew after row 600, the first of 2: what follows each is a test of its own"),
        ((0.0, 100.0, 250.0), "has a long break after row 600, the first of 2: what follows each is a test of its own"),
    ],
)
def test_recordings_in_the_same_columns_are_tests(tmp_path: Path, starts: tuple[float, ...], said: str) -> None:
    path = written(tmp_path / "r.csv", *starts)
    recording = suspid.read_recording(path)
    assert recording.tests == ("Run 1", "Run 2", "Run 3")
    assert [str(remark) for name, remark in recording.left_out if name == "'t'"] == [said]
    for k, (channel, start) in enumerate(zip(recording.channels, starts, strict=True)):
        t, z = decay(COUNTS[k], seed=k)
        np.testing.assert_allclose(channel.timepts, start + t, atol=1e-9)
        np.testing.assert_allclose(channel.values, z, atol=1e-5)
    found = suspid.analyse(path, settings=suspid.Settings(test="Run 2"))
    np.testing.assert_allclose(found.modes.wn, TURN, rtol=2e-3)
    np.testing.assert_allclose(found.modes.zeta, ZETA, rtol=2e-2)


@pytest.mark.parametrize("starts", [(0.0, 1.0, 2.0), (0.0, 4.0, 8.0), (0.0, 0.0, 1.0)])
def test_what_neither_begins_anew_nor_breaks_for_long_is_one_record(tmp_path: Path, starts: tuple[float, ...]) -> None:
    assert suspid.read_recording(written(tmp_path / "r.csv", *starts)).tests == ()


def test_few_rows_are_no_test(tmp_path: Path) -> None:
    rows = [f"{t:.3f},{z:.5f}" for t, z in zip(*decay(600, seed=0), strict=True)]
    path = tmp_path / "r.csv"
    path.write_text("t,z\n" + "\n".join([*rows, *rows[:15]]) + "\n")
    assert suspid.read_recording(path).tests == ()


@pytest.mark.parametrize(("bits", "before"), [(32, 1_000_000), (16, 1_000)])
def test_a_counter_that_rolls_over_is_counted_on(tmp_path: Path, bits: int, before: int) -> None:
    t, z = decay(600, seed=0)
    per_second = 1_000_000 if bits == 32 else 1000
    counts = (np.round(t * per_second).astype(np.int64) + 2**bits - before) % 2**bits
    path = tmp_path / "r.csv"
    name = "time (us)" if bits == 32 else "time (ms)"
    path.write_text(f"{name},z\n" + "\n".join(f"{c},{v:.5f}" for c, v in zip(counts, z, strict=True)) + "\n")
    recording = suspid.read_recording(path)
    np.testing.assert_allclose(recording["z"].timepts - recording["z"].timepts[0], t, atol=1e-9)
    assert f"rolls over at {2**bits}: it is counted on from there" in [str(said) for _, said in recording.left_out]
