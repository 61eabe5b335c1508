"""Parquet files: numbers, times and units come back, and damage is refused."""

from __future__ import annotations

import contextlib
import datetime
import decimal
import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from suspid import SuspidError, read_record, write_record
from suspid.errors import RecordError
from suspid.io.parquet import read_parquet, write_parquet
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import LeftOut

FUZZ = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def put(folder: Path, columns: dict[str, Any], *, units: dict[str, str] | None = None) -> Path:
    arrays = {name: pa.array(cells) if isinstance(cells, list) else cells for name, cells in columns.items()}
    fields = [
        pa.field(name, a.type, metadata={"unit": units[name]} if units and name in units else None)
        for name, a in arrays.items()
    ]
    path = folder / "a.parquet"
    pq.write_table(pa.table(list(arrays.values()), schema=pa.schema(fields)), path)
    return path


class TestEveryBitComesBack:
    def test_of_time_and_channels(self, tmp_path: Path) -> None:
        rng = np.random.default_rng(0)
        timepts = np.linspace(1e-17, 0.999, 1000)
        values: RealArray = np.array(rng.normal(size=(2, 1000)), np.float64)
        values *= 10.0 ** rng.integers(-300, 300, size=(2, 1000))
        values[0, :4] = [5e-324, -0.0, np.nextafter(1, 2), np.nan]
        names = ["seat.z [m]", "Körper\x1b\n"]
        write_parquet(tmp_path / "a.parquet", timepts, values, names, units=["", "m/s²"], title="bump")
        table = read_parquet(tmp_path / "a.parquet")
        assert list(table.sizes) == ["time [s]", *names]
        back = np.array(table.columns(list(table.sizes)))
        assert back.tobytes() == np.array([timepts, *values]).tobytes()
        assert table.title == "bump"
        assert table.units == {"time [s]": "s", names[1]: "m/s²"}

    def test_as_a_record(self, tmp_path: Path) -> None:
        response = as_response(
            np.linspace(0, 0.49, 50), np.random.default_rng(5).normal(size=(3, 50)), "abc", title="bump"
        )
        write_record(response, tmp_path / "a.parquet")
        same = read_record(tmp_path / "a.parquet")
        assert np.array_equal(same.y, response.y)
        assert np.array_equal(same.time, response.time)
        assert list(same.output_labels) == ["a", "b", "c"]
        assert [path.name for path in tmp_path.iterdir()] == ["a.parquet"]

    def test_not_without_the_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "pyarrow", None)
        with pytest.raises(RecordError, match=r"^writing .parquet needs pyarrow: pip install 'pyarrow[<>=.,\d]+'$"):
            write_parquet(tmp_path / "a.parquet", np.arange(2.0), np.zeros((1, 2)), ["a"])
        assert not list(tmp_path.iterdir())


class TestNumbers:
    def test_of_each_type(self, tmp_path: Path) -> None:
        columns = {
            "f4": pa.array([0.1, 2.0], pa.float32()),
            "f2": pa.array(np.array([0.1, 2.0], np.float16)),
            "i1": pa.array([-128, 127], pa.int8()),
            "u8": pa.array([0, 2**63], pa.uint64()),
            "flag": pa.array([True, False]),
            "money": pa.array([decimal.Decimal("1.25"), decimal.Decimal("-3.50")]),
        }
        table = read_parquet(put(tmp_path, columns))
        expected = {
            "f4": [float(np.float32(0.1)), 2.0],
            "f2": [float(np.float16(0.1)), 2.0],
            "i1": [-128.0, 127.0],
            "u8": [0.0, 2.0**63],
            "flag": [1.0, 0.0],
            "money": [1.25, -3.5],
        }
        assert list(table.sizes) == list(expected)
        for name, values in zip(expected, table.columns(list(expected)), strict=True):
            assert values.tolist() == expected[name], name
            assert values.dtype == np.float64

    @pytest.mark.parametrize("kind", [pa.float64(), pa.int32(), pa.bool_()])
    def test_nulls_are_nan(self, tmp_path: Path, kind: Any) -> None:
        table = read_parquet(put(tmp_path, {"x": pa.array([1, None, 0], pa.int32()).cast(kind)}))
        assert np.array_equal(table.columns(["x"])[0], [1, np.nan, 0], equal_nan=True)

    def test_units_stand_in_the_fields(self, tmp_path: Path) -> None:
        table = read_parquet(put(tmp_path, {"z": [1.0], "v": [2.0]}, units={"v": "m/s"}))
        assert table.units == {"v": "m/s"}

    def test_others_are_left_out_with_the_reason(self, tmp_path: Path) -> None:
        columns = {
            "x": [1.0],
            "note": ["a"],
            "kind": pa.array(["a"]).dictionary_encode(),
            "list": [[1.0]],
            "raw": [b"a"],
            "x.y": [2.0],
            "s": [{"y": 3.0}],
        }
        table = read_parquet(put(tmp_path, columns))
        assert list(table.sizes) == ["x", "x.y"]
        assert list(table.unusable) == ["note", "kind", "list", "raw", "s"]
        assert table.unusable["note"].code is table.unusable["kind"].code is LeftOut.TEXT
        assert table.unusable["list"].code is LeftOut.NESTED
        assert table.columns(["x.y"])[0].tolist() == [2.0]

    def test_of_many_row_groups(self, tmp_path: Path) -> None:
        values = np.random.default_rng(2).normal(size=1000)
        pq.write_table(pa.table({"x": values}), tmp_path / "a.parquet", row_group_size=7)
        assert np.array_equal(read_parquet(tmp_path / "a.parquet").columns(["x"])[0], values)


class TestTime:
    def test_stamps_count_from_the_first_in_seconds(self, tmp_path: Path) -> None:
        epoch = 1_700_000_000_000_000_000
        stamps = pa.array([epoch + 3, epoch + 1_000_003, None, epoch + 2_000_004], pa.timestamp("ns", tz="UTC"))
        table = read_parquet(put(tmp_path, {"timestamp": stamps, "x": [1.0, 2.0, 3.0, 4.0]}))
        assert np.array_equal(table.columns(["timestamp"])[0], [0, 1e-3, np.nan, 2.000001e-3], equal_nan=True)
        assert list(table.sizes) == ["timestamp", "x"]
        assert not table.clocks

    @pytest.mark.parametrize("missing", [0, 1, 3])
    def test_the_first_stamp_that_is_there_is_zero(self, tmp_path: Path, missing: int) -> None:
        """Differences of integers are exact; of seconds since 1970 in double precision they would not be."""
        nanos = 1_700_000_000_000_000_000 + np.array([3, 1_000_004, 7_000_009])
        stamps = pa.array([None] * missing + nanos.tolist(), pa.timestamp("ns"))
        table = read_parquet(put(tmp_path, {"timestamp": stamps, "x": [1.0] * (missing + 3)}))
        expected = [np.nan] * missing + [int(n - nanos[0]) / 1e9 for n in nanos]
        assert np.array_equal(table.columns(["timestamp"])[0], expected, equal_nan=True)

    def test_durations_stand_as_they_are_in_the_unit_of_the_name(self, tmp_path: Path) -> None:
        lasted = pa.array([5, 7], pa.duration("us"))
        table = read_parquet(put(tmp_path, {"t [ms]": lasted, "elapsed": lasted, "x": [1.0, 2.0]}))
        assert [c.tolist() for c in table.columns(["t [ms]", "elapsed"])] == [[5e-3, 7e-3], [5e-6, 7e-6]]

    def test_the_only_dates_are_the_clock(self, tmp_path: Path) -> None:
        days = [datetime.date(2024, 2, 28), datetime.date(2024, 3, 1)]
        table = read_parquet(put(tmp_path, {"x": [1.0, 2.0], "measured": days, "y": [1.0, 2.0]}))
        assert list(table.sizes) == ["x", "measured", "y"]
        assert "measured" not in table.clocks
        clock = table.clocks["x"]
        assert clock is table.clocks["y"]
        assert clock.stamps is not None
        # 2024 is a leap year.
        assert clock.stamps().tolist() == [0.0, 2 * 86400.0]

    def test_times_of_day(self, tmp_path: Path) -> None:
        times = pa.array([datetime.time(8, 0, 0), datetime.time(8, 0, 0, 500)])
        table = read_parquet(put(tmp_path, {"time": times, "x": [1.0, 2.0]}))
        assert table.columns(["time"])[0].tolist() == [0.0, 5e-4]


@pytest.fixture(scope="module")
def content() -> bytes:
    stream = io.BytesIO()
    table = pa.table({"time": np.arange(40) / 8, "x": np.arange(40.0), "n": ["a"] * 40})
    pq.write_table(table, stream, write_page_checksum=True)
    return stream.getvalue()


class TestDamage:
    def test_every_truncation_is_refused(self, tmp_path: Path, content: bytes) -> None:
        path = tmp_path / "a.parquet"
        for length in [*range(60), *range(60, len(content), 7), len(content) - 1]:
            path.write_bytes(content[:length])
            with pytest.raises(RecordError):
                read_parquet(path)

    @FUZZ
    @given(data=st.data(), byte=st.integers(0, 255))
    def test_a_flipped_byte(self, scratch: Path, content: bytes, data: st.DataObject, byte: int) -> None:
        flipped = bytearray(content)
        flipped[data.draw(st.integers(0, len(content) - 1))] = byte
        (scratch / "a.parquet").write_bytes(flipped)
        with contextlib.suppress(SuspidError):
            table = read_parquet(scratch / "a.parquet")
            table.columns(list(table.sizes))

    def test_a_flipped_bit_of_a_sample_is_found(self, tmp_path: Path) -> None:
        values = np.random.default_rng(1).normal(size=500)
        write_parquet(tmp_path / "a.parquet", np.arange(500.0), values[None], ["x"])
        content = bytearray((tmp_path / "a.parquet").read_bytes())
        content[content.index(values[10].tobytes())] ^= 1
        (tmp_path / "a.parquet").write_bytes(content)
        with pytest.raises(RecordError, match="is damaged"):
            read_parquet(tmp_path / "a.parquet").columns(["x"])

    def test_absurd_numbers_of_equal_samples(self, tmp_path: Path) -> None:
        with pq.ParquetWriter(tmp_path / "a.parquet", pa.schema([("x", pa.null())])) as writer:
            for _ in range(5):
                writer.write_table(pa.table({"x": pa.nulls(1 << 26)}))
        with pytest.raises(RecordError, match="at most"):
            read_parquet(tmp_path / "a.parquet")

    def test_no_sample(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="contains no sample"):
            read_parquet(put(tmp_path, {"x": pa.array([], pa.float64())}))
        with pytest.raises(RecordError, match="'n' is text"):
            read_parquet(put(tmp_path, {"n": ["a"]}))

    def test_another_kind(self, tmp_path: Path) -> None:
        (tmp_path / "a.parquet").write_bytes(b"time,x\n0,1\n1,2\n")
        with pytest.raises(RecordError, match="is not a Parquet file"):
            read_parquet(tmp_path / "a.parquet")

    def test_a_missing_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes) -> None:
        (tmp_path / "a.parquet").write_bytes(content)
        monkeypatch.setitem(sys.modules, "pyarrow", None)
        with pytest.raises(RecordError, match=r"^reading .parquet needs pyarrow: pip install 'pyarrow[<>=.,\d]+'$"):
            read_parquet(tmp_path / "a.parquet")
