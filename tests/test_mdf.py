"""ASAM MDF files: numbers, clocks and CAN frames come back, and damage is refused."""

from __future__ import annotations

import contextlib
import inspect
import struct
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asammdf import MDF, Signal
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from suspid import SuspidError
from suspid.errors import RecordError
from suspid.io.mdf.channels import _payloads
from suspid.io.mdf.mdf import read_mdf
from suspid.words import LeftOut, Remark

FUZZ = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "css_canedge_car_mf4"
T = np.array([0.0, 0.125, 0.25, 0.5, 1.0])
WORDS = {"val_0": 0, "text_0": b"off", "val_1": 1, "text_1": b"on", "default": b"?"}
DBC = """VERSION ""
BU_: A
BO_ 291 Body: 8 A
 SG_ travel : 0|16@1- (0.5,10) [0|0] "mm" A
 SG_ speed : 16|8@1+ (1,0) [0|0] "m/s" A
 SG_ state : 24|8@1+ (1,0) [0|0] "" A
VAL_ 291 state 0 "off" 1 "on" ;
"""


def signal(name: str, samples: Any, timepts: Any = T, **more: Any) -> Signal:
    return Signal(np.asarray(samples), np.asarray(timepts), name=name, **more)


def mdf(*groups: Sequence[Signal], version: str = "4.10", compression: int = 0, **options: Any) -> bytes:
    """A file of one channel group for each sequence of signals, named group a, group b, …."""
    with tempfile.TemporaryDirectory() as folder, MDF(version=version, **options) as file:
        for letter, signals in zip("abcdef", groups, strict=False):
            file.append(list(signals), acq_name=f"group {letter}", common_timebase=True)
        return Path(file.save(Path(folder, "a.mf4"), compression=compression)).read_bytes()  # type: ignore[arg-type]


def put(folder: Path, content: bytes) -> Path:
    path = folder / "a.mf4"
    path.write_bytes(content)
    return path


def stamps(table: Any, name: str) -> list[float]:
    clock = table.clocks[name]
    assert clock.rate is None
    return [float(t) for t in clock.stamps()]


def can(ids: Sequence[int], payloads: Sequence[bytes], *, bus: int = 1) -> bytes:
    """A file of raw CAN frames as bus loggers write them."""
    from asammdf.blocks import v4_constants as v4
    from asammdf.blocks.source_utils import Source

    dtype = [
        ("CAN_DataFrame.BusChannel", "<u1"),
        ("CAN_DataFrame.ID", "<u4"),
        ("CAN_DataFrame.IDE", "<u1"),
        ("CAN_DataFrame.DLC", "<u1"),
        ("CAN_DataFrame.DataLength", "<u1"),
        ("CAN_DataFrame.DataBytes", "(8,)u1"),
    ]
    frames = np.zeros(len(ids), dtype)
    frames["CAN_DataFrame.BusChannel"], frames["CAN_DataFrame.ID"] = bus, ids
    frames["CAN_DataFrame.DLC"] = frames["CAN_DataFrame.DataLength"] = 8
    frames["CAN_DataFrame.DataBytes"] = [list(p.ljust(8, b"\0")) for p in payloads]
    source = Source(source_type=v4.SOURCE_BUS, bus_type=v4.BUS_TYPE_CAN, name="CAN", path="CAN", comment="")
    flags = v4.FLAG_CG_BUS_EVENT | v4.FLAG_CG_PLAIN_BUS_EVENT
    with tempfile.TemporaryDirectory() as folder, MDF(version="4.10") as file:
        file.append(
            [signal("CAN_DataFrame", frames, np.arange(len(ids)) / 8, source=source)],
            acq_source=source,
            acq_name="CAN",
        )
        file.groups[-1].channel_group.flags = flags  # type: ignore[union-attr]
        return Path(file.save(Path(folder, "a.mf4"))).read_bytes()


class TestNumbersComeBack:
    @pytest.mark.parametrize("version", ["2.14", "3.30", "4.00", "4.10", "4.20"])
    @pytest.mark.parametrize("compression", [0, 1, 2])
    def test_of_each_version(self, tmp_path: Path, version: str, compression: int) -> None:
        fast = [signal("x", np.sin(T), unit="m"), signal("n", np.array([-3, 7, 0, 32767, -32768], np.int16))]
        slow = [signal("y", np.cos([0.0, 2]), [0.5, 3.0])]
        table = read_mdf(put(tmp_path, mdf(fast, slow, version=version, compression=compression)))
        assert table.sizes == {"x": 5, "n": 5, "y": 2}
        y, x, n = table.columns(["y", "x", "n"])
        assert np.array_equal(x, np.sin(T))
        assert np.array_equal(y, np.cos([0.0, 2]))
        assert n.tolist() == [-3, 7, 0, 32767, -32768]
        assert n.dtype == np.float64
        assert not n.flags.writeable
        assert stamps(table, "x") == T.tolist()
        assert stamps(table, "y") == [0.5, 3.0]
        assert table.clocks["x"] is table.clocks["n"]
        assert table.clocks["x"] is not table.clocks["y"]
        assert table.units == {"x": "m"}

    def test_of_a_file_in_columns(self, tmp_path: Path) -> None:
        content = mdf([signal("x", np.sin(T)), signal("y", np.cos(T))], version="4.20", column_storage=True)
        table = read_mdf(put(tmp_path, content))
        assert np.array_equal(table.columns(["y"])[0], np.cos(T))
        assert stamps(table, "y") == T.tolist()

    def test_scaled_as_the_file_says(self, tmp_path: Path) -> None:
        raw = np.array([0, 1, 2, -4, 100], np.int16)
        table = read_mdf(put(tmp_path, mdf([signal("x", raw, conversion={"a": 0.5, "b": 3.0})])))
        assert table.columns(["x"])[0].tolist() == [3.0, 3.5, 4.0, 1.0, 53.0]

    def test_samples_that_are_marked_as_invalid_are_nan(self, tmp_path: Path) -> None:
        marked = signal("x", [1.0, 2, 3, 4, 5], invalidation_bits=np.array([0, 1, 0, 0, 1], bool))
        table = read_mdf(put(tmp_path, mdf([marked, signal("y", T)])))
        x, y = table.columns(["x", "y"])
        assert np.array_equal(x, [1, np.nan, 3, 4, np.nan], equal_nan=True)
        assert y.tolist() == T.tolist()
        assert stamps(table, "x") == T.tolist()

    def test_names_of_two_groups_are_told_apart(self, tmp_path: Path) -> None:
        content = mdf([signal("z", T), signal("v", T)], [signal("z", -T)])
        table = read_mdf(put(tmp_path, content))
        assert list(table.sizes) == ["group a/z", "v", "group b/z"]
        assert table.columns(["group b/z"])[0].tolist() == (-T).tolist()


class TestLeftOut:
    def test_with_the_reason(self, tmp_path: Path) -> None:
        odd = [
            signal("x", T),
            signal("text", np.array([b"a", b"b", b"c", b"d", b"e"]), encoding="utf-8"),
            signal("words", np.array([0, 1, 0, 1, 0], np.uint8), conversion=WORDS),
            signal("array", np.ones(5, [("array", "<f8", (2,))])),
            signal("formula", np.array([0, 1, 2, 3, 4], np.uint8), conversion={"formula": "X1 + 2"}),
        ]
        table = read_mdf(put(tmp_path, mdf(odd)))
        assert list(table.sizes) == ["x"]
        assert table.unusable["text"].code is LeftOut.TEXT_OR_BYTES
        assert table.unusable["words"].code is LeftOut.ENUMERATION
        assert table.unusable["array"].code is LeftOut.STRUCTURE
        assert table.unusable["formula"].code is LeftOut.FORMULA

    def test_all_of_it_is_an_error(self, tmp_path: Path) -> None:
        content = mdf([signal("text", np.array([b"a", b"b", b"c", b"d", b"e"]), encoding="utf-8")])
        with pytest.raises(RecordError, match="contains no channel of numbers: 'text' is text or bytes"):
            read_mdf(put(tmp_path, content))


class TestCanFrames:
    IDS = (0x123, 0x7E8, 0x123, 0x123)
    PAYLOADS = tuple(struct.pack("<hBB", *numbers) for numbers in ((4, 7, 1), (0, 0, 0), (-6, 255, 0), (300, 0, 1)))

    @pytest.fixture
    def dbc(self, tmp_path: Path) -> Path:
        path = tmp_path / "body.dbc"
        path.write_text(DBC)
        return path

    def test_are_decoded(self, tmp_path: Path, dbc: Path) -> None:
        table = read_mdf(put(tmp_path, can(self.IDS, self.PAYLOADS)), dbc=dbc)
        assert table.sizes == {"travel": 3, "speed": 3}
        # The database says 0.5 mm a count, from 10 mm.
        assert [c.tolist() for c in table.columns(["travel", "speed"])] == [[12.0, 7.0, 160.0], [7, 255, 0]]
        assert stamps(table, "travel") == [0.0, 0.25, 0.375]
        assert table.units == {"travel": "mm", "speed": "m/s"}
        assert table.unusable["state"].code is LeftOut.ENUMERATION
        assert table.unusable["CAN_DataFrame"] == Remark(LeftOut.UNKNOWN_FRAMES, {"ids": "bus 1: 0x7E8"})

    def test_without_a_database_their_ids_are_listed(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"raw CAN frames \(bus 3: 0x123, 0x7E8\); decode them with dbc="):
            read_mdf(put(tmp_path, can(self.IDS, self.PAYLOADS, bus=3)))

    def test_a_database_that_knows_none(self, tmp_path: Path, dbc: Path) -> None:
        with pytest.raises(RecordError, match=r"no CAN frame that body.dbc knows; there are bus 1: 0x5, 0x6"):
            read_mdf(put(tmp_path, can([5, 6], [b"", b""])), dbc=dbc)

    @pytest.mark.parametrize(
        "words", ["", "BO_ rubbish", "\0\xff\xfe", "BO_ 1 a: 8 b\n SG_ x : 0|999999999@1- (0,0) [|] "]
    )
    def test_a_damaged_database(self, tmp_path: Path, dbc: Path, words: str) -> None:
        dbc.write_text(words, encoding="latin1")
        with pytest.raises(RecordError):
            read_mdf(put(tmp_path, can(self.IDS, self.PAYLOADS)), dbc=dbc)

    def test_a_database_of_another_kind(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match=r"give a \.dbc file"):
            read_mdf(put(tmp_path, can(self.IDS, self.PAYLOADS)), dbc=tmp_path / "a.yaml")

    def test_a_database_for_no_frames_is_said(self, tmp_path: Path, dbc: Path) -> None:
        table = read_mdf(put(tmp_path, mdf([signal("x", T)])), dbc=str(dbc))
        assert table.unusable == {"body.dbc": Remark(LeftOut.NO_FRAMES)}


class TestThePrivatePartOfAsammdf:
    """The payloads of CAN frames are reached by one private method, which another release may lack."""

    def test_is_there(self) -> None:
        with MDF(version="4.10") as file:
            load = getattr(getattr(file, "_mdf", None), "_load_signal_data", None)
            assert load is not None, "asammdf has changed: mend suspid.io.mdf.channels._payloads"
            assert {"group", "index"} <= set(inspect.signature(load).parameters)

    def test_is_named_where_it_is_missing(self) -> None:
        with pytest.raises(RecordError, match=r"MDF4\._load_signal_data is missing\); install asammdf"):
            _payloads(object(), 0, 0)


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the shared data")
class TestRecordsOfOthers:
    @pytest.mark.parametrize(
        ("name", "samples", "rate", "up", "invalid"),
        [
            ("00000164_00000001-60FE3F04.MF4", 53524, 101.3, 9.6, 1),
            ("00000164_00000002-60FE415D.MF4", 60750, 101.3, 9.6, 1),
            ("stationary_2F6913DB_00000004_00000001.MF4", 4724, 97.6, None, 0),
        ],
    )
    def test_the_car(self, name: str, samples: int, rate: float, up: float | None, invalid: int) -> None:
        table = read_mdf(DATA / name, dbc=DATA / "canmod-gps.dbc")
        assert table.sizes["AccelerationX"] == samples
        assert table.units["AccelerationX"] == "m/s^2"
        timepts = np.array(stamps(table, "AccelerationX"))
        assert np.all(np.diff(timepts) > 0)
        # The logger stamps frames to 50 us; the figures of the readme have three digits.
        assert (samples - 1) / (timepts[-1] - timepts[0]) == pytest.approx(rate, rel=2e-3)
        speed = stamps(table, "Speed")
        assert (len(speed) - 1) / (speed[-1] - speed[0]) == pytest.approx(1.0, rel=0.12)
        (vertical,) = table.columns(["AccelerationX"])
        assert np.sum(vertical == -64) == invalid
        if up is not None:
            assert np.median(vertical) == pytest.approx(up, abs=0.1)

    def test_needs_its_database(self) -> None:
        with pytest.raises(RecordError, match="0x7E8.*0x17F00010.*dbc="):
            read_mdf(DATA / "00000164_00000001-60FE3F04.MF4")


class TestDamage:
    WHOLE = mdf([signal("x", np.sin(T), unit="m"), signal("n", np.arange(5, dtype=np.int16))], [signal("y", -T)])
    ZIPPED = mdf(
        [signal("x", np.sin(np.arange(90.0)), np.arange(90.0)), signal("y", np.arange(90.0), np.arange(90.0))],
        compression=2,
    )
    OLD = mdf([signal("x", np.sin(T), unit="m")], [signal("y", -T)], version="3.30")

    @pytest.mark.parametrize("content", [WHOLE, ZIPPED, OLD], ids=["4", "zipped", "3"])
    def test_every_truncation_is_refused(self, tmp_path: Path, content: bytes) -> None:
        for length in [*range(0, len(content), 23), len(content) - 8]:
            with pytest.raises(RecordError):
                read_mdf(put(tmp_path, content[:length]))

    @pytest.mark.parametrize("content", [WHOLE, ZIPPED, OLD], ids=["4", "zipped", "3"])
    @FUZZ
    @given(data=st.data(), byte=st.integers(0, 255))
    def test_a_flipped_byte(self, scratch: Path, content: bytes, data: st.DataObject, byte: int) -> None:
        flipped = bytearray(content)
        flipped[data.draw(st.integers(0, len(content) - 1))] = byte
        with contextlib.suppress(SuspidError):
            table = read_mdf(put(scratch, bytes(flipped)))
            table.columns(list(table.sizes))

    def test_a_flipped_byte_of_compressed_samples_is_found(self, tmp_path: Path) -> None:
        place = self.ZIPPED.index(b"##DZ") + 100
        flipped = self.ZIPPED[:place] + bytes([self.ZIPPED[place] ^ 1]) + self.ZIPPED[place + 1 :]
        with pytest.raises(RecordError, match="cannot be decompressed"):
            read_mdf(put(tmp_path, flipped))

    @pytest.mark.parametrize("kind", [b"##DG", b"##CG", b"##CN", b"##FH"])
    def test_blocks_in_a_circle(self, tmp_path: Path, kind: bytes) -> None:
        place = self.WHOLE.rindex(kind)
        content = bytearray(self.WHOLE)
        struct.pack_into("<Q", content, place + 24, place)
        with pytest.raises(RecordError, match="in a circle"):
            read_mdf(put(tmp_path, bytes(content)))

    @pytest.mark.parametrize("cycles", [6, 1 << 40, (1 << 64) - 1])
    def test_absurd_numbers_of_records(self, tmp_path: Path, cycles: int) -> None:
        place = self.WHOLE.index(b"##CG")
        content = bytearray(self.WHOLE)
        links = struct.unpack_from("<Q", content, place + 16)[0]
        struct.pack_into("<Q", content, place + 24 + 8 * links + 8, cycles)
        with pytest.raises(RecordError, match="states .* bytes of samples and contains"):
            read_mdf(put(tmp_path, bytes(content)))

    def test_samples_beyond_the_record(self, tmp_path: Path) -> None:
        place = self.WHOLE.rindex(b"##CN")
        content = bytearray(self.WHOLE)
        links = struct.unpack_from("<Q", content, place + 16)[0]
        struct.pack_into("<I", content, place + 24 + 8 * links + 4, 1 << 30)
        with pytest.raises(RecordError, match="of a record of"):
            read_mdf(put(tmp_path, bytes(content)))

    def test_another_kind(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="is not an MDF file"):
            read_mdf(put(tmp_path, b"time,x\n0,1\n1,2\n"))

    def test_nothing_is_said_or_left_behind(
        self, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "scratch").mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
        table = read_mdf(put(tmp_path, self.WHOLE))
        table.columns(["x"])
        for place in range(200, len(self.WHOLE), 97):
            with contextlib.suppress(RecordError):
                read_mdf(put(tmp_path, self.WHOLE[:place] + b"\xff\xff" + self.WHOLE[place + 2 :]))
        assert not list((tmp_path / "scratch").iterdir())
        assert capfd.readouterr() == ("", "")

    def test_a_missing_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "asammdf", None)
        with pytest.raises(RecordError, match=r"^reading .mf4 needs asammdf: pip install 'asammdf[<>=.,\d]+'$"):
            read_mdf(put(tmp_path, self.WHOLE))
