"""Files whose units, stamps or rows mislead: ticks, packed numbers, rows that count, columns that are no motion."""

import time
from pathlib import Path

import numpy as np
import pytest

import suspid
from suspid import Level

TIME = np.arange(1000) / 200
SEAT = np.exp(-0.05 * 9.4 * TIME) * np.cos(9.4 * TIME) + 1e-3 * np.random.default_rng(1).standard_normal(1000)


def table(path: Path, time: list[str], *, names: str = "Time,seat", above: str = "") -> Path:
    rows = [f"{t},{y:.5f}" for t, y in zip(time, SEAT, strict=True)]
    path.write_text(above + "\n".join([names, *rows]) + "\n")
    return path


@pytest.mark.parametrize("start", [638_400_000_000_000_000, 133_500_000_000_000_000])
def test_ticks_of_100_ns_since_1_or_1601(tmp_path: Path, start: int) -> None:
    path = table(tmp_path / "r.csv", [str(start + round(t * 1e7)) for t in TIME])
    recording = suspid.read_recording(path)
    np.testing.assert_allclose(np.diff(recording["seat"].timepts), 0.005, atol=3e-5)
    said = "is not stated; stamps of this size are ticks of 100 ns, as Windows counts them"
    assert said in [str(remark) for _, remark in recording.left_out]


def test_julian_days(tmp_path: Path) -> None:
    path = table(tmp_path / "r.csv", [f"{2460310.5 + t / 86400:.10f}" for t in TIME], names="JD,seat")
    np.testing.assert_allclose(np.diff(suspid.read_recording(path)["seat"].timepts), 0.005, atol=1e-4)


def test_stamps_called_ts_are_not_added_up(tmp_path: Path) -> None:
    path = table(tmp_path / "r.csv", [str(1_706_782_272_000 + round(1000 * t)) for t in TIME], names="ts,seat")
    with pytest.raises(suspid.RecordError, match="give time='ts'"):
        suspid.read_recording(path)
    recording = suspid.read_recording(path, time="ts")
    np.testing.assert_allclose(recording["seat"].timepts, TIME, atol=1e-9)


def test_a_column_in_metres_is_no_time(tmp_path: Path) -> None:
    path = table(tmp_path / "r.csv", [f"{20 * t:.3f}" for t in TIME], names="Distance [m],seat")
    with pytest.raises(suspid.RecordError) as refusal:
        suspid.read_recording(path)
    assert "increases like a time" not in str(refusal.value)
    with pytest.raises(suspid.RecordError, match="is in 'm', which is no unit of time"):
        suspid.read_recording(path, time="Distance [m]")


def test_a_doubted_unit_of_time_reaches_the_verdict(tmp_path: Path) -> None:
    path = table(tmp_path / "r.csv", [f"{t:.3f}" for t in TIME], names="time,seat\nms,mm")
    found = suspid.analyse(path)
    assert found.verdict.level is Level.CARE
    assert "no logger of a suspension is so fast" in str(found.verdict)


def test_a_row_that_numbers_the_columns_is_no_sample(tmp_path: Path) -> None:
    path = table(tmp_path / "r.csv", [f"{t:.3f}" for t in TIME], names='Time,seat\ns,mm\n"1","2"\n')
    recording = suspid.read_recording(path)
    assert (recording["seat"].values.size, recording["seat"].unit) == (1000, "mm")


def test_rows_that_say_the_same_of_each_column_are_no_samples(tmp_path: Path) -> None:
    rows = [f"\t{t:.3f}\t{y:.5f}" for t, y in zip(TIME, SEAT, strict=True)]
    above = ["Test.Lab", "", "\tTime\tseat", "Unit\ts\tg", "Number of values\t1000\t1000", "Increment\t0.005\t0.005"]
    path = tmp_path / "r.txt"
    path.write_text("\n".join([*above, *rows]) + "\n")
    recording = suspid.read_recording(path)
    assert (recording["seat"].values.size, recording["seat"].timepts[1]) == (1000, 0.005)


def test_a_temperature_is_no_motion(tmp_path: Path) -> None:
    rows = [f"{t:.3f},{y:.5f},{23 + 0.01 * k // 100}" for k, (t, y) in enumerate(zip(TIME, SEAT, strict=True))]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(["t,seat [mm],oil [degC]", *rows]) + "\n")
    assert suspid.read_recording(path).names == ("seat [mm]",)
    assert suspid.read_recording(path, channels=["oil [degC]"]).names == ("oil [degC]",)


def test_packed_numbers_of_netcdf(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        packed = np.round((SEAT - 2.0) / 1e-3).astype(np.int16)
        packed[10] = -32768
        file["seat"] = packed
        file["seat"].attrs.update({"scale_factor": 1e-3, "add_offset": 2.0, "_FillValue": np.int16(-32768)})
    seat = suspid.read_recording(path)["seat"].values
    assert np.isnan(seat[10])
    np.testing.assert_allclose(np.delete(seat, 10), np.delete(SEAT, 10), atol=6e-4)


def test_durations_without_a_unit_are_refused() -> None:
    with pytest.raises(suspid.RecordError, match="durations have no unit"):
        suspid.as_record(SEAT, timepts=np.arange(1000).astype("m8"))


def test_arrays_of_pandas_with_missing_numbers() -> None:
    pandas = pytest.importorskip("pandas")
    numbers = pandas.array(SEAT, dtype="Float64")
    np.testing.assert_allclose(suspid.as_record(numbers, fs=200).y[0], SEAT)
    with pytest.raises(suspid.RecordError, match="has no numbers"):
        suspid.as_record(pandas.Categorical(["a", "b"] * 500), fs=200)


def test_text_that_is_named_as_a_spreadsheet(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    path = table(tmp_path / "r.xls", [f"{t:.3f}" for t in TIME])
    with pytest.raises(suspid.RecordError, match=r"it looks like text: name it .csv"):
        suspid.read_recording(path)


def test_a_link_to_itself_is_said(tmp_path: Path) -> None:
    path = tmp_path / "loop.csv"
    path.symlink_to(path)
    with pytest.raises(suspid.RecordError, match="a link to nothing, or to itself"):
        suspid.read_recording(path)


def test_cells_that_are_formulas_of_their_text(tmp_path: Path) -> None:
    rows = [f'="{t:.3f}",="{y:.5f}"' for t, y in zip(TIME, SEAT, strict=True)]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(["time,seat", *rows]) + "\n")
    np.testing.assert_allclose(suspid.read_recording(path)["seat"].values, SEAT, atol=1e-5)


def test_a_unit_in_each_cell_is_said(tmp_path: Path) -> None:
    rows = [f'"2024-01-01 10:11:{t + 10:.3f}","{y:.5f} m/s²"' for t, y in zip(TIME, SEAT, strict=True)]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(['"Time","seat"', *rows]) + "\n", encoding="utf-8")
    with pytest.raises(suspid.RecordError, match="m/s²' has its unit behind it: write numbers alone"):
        suspid.read_recording(path)


@pytest.mark.parametrize("run", [" ", "[", "(", "7", "/", "-1", "_"])
def test_a_long_name_takes_no_longer_than_its_length(tmp_path: Path, run: str) -> None:
    """An expression that tries each place of a name with each end takes minutes."""
    path = table(tmp_path / "r.csv", [f"{t:.3f}" for t in TIME], names=f"Time,a{run * 100_000}b [m]")
    started = time.process_time()
    assert len(suspid.read_recording(path).channels) == 1
    assert time.process_time() - started < 5


def test_a_last_number_cut_behind_its_decimal_comma_is_said(tmp_path: Path) -> None:
    rows = "".join(f"{t:.3f};{y:.5f}\n".replace(".", ",") for t, y in zip(TIME, SEAT, strict=True))
    (tmp_path / "r.csv").write_text(f"Time;seat\n{rows}5,")
    ((where, remark),) = suspid.read_recording(tmp_path / "r.csv").left_out
    assert (where, str(remark)) == ("line 1002", "is cut short: it has 1 of 2 cells")


def test_of_many_channels_that_stand_still_ten_are_named(tmp_path: Path) -> None:
    rows = "".join(f"{t:.3f}{',0.1' * 40}\n" for t in TIME)
    (tmp_path / "r.csv").write_text(f"Time,{','.join(f'c{k}' for k in range(40))}\n{rows}")
    with pytest.raises(suspid.RecordError, match=r"'c9': constant at 0\.1; and 30 more$"):
        suspid.read_record(tmp_path / "r.csv")
