"""TDMS files: scaled channels and waveform clocks come back, and damage is refused."""

from __future__ import annotations

import contextlib
import io
import struct
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter

from suspid import SuspidError
from suspid.errors import RecordError
from suspid.io.read_recording import read_recording
from suspid.io.tdms import read_tdms
from suspid.words import LeftOut

FUZZ = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
RNG = np.random.default_rng(0)


def channel(group: str, name: str, data: Any, **properties: Any) -> ChannelObject:
    return ChannelObject(group, name, np.asarray(data), properties=properties)


def tdms(*segments: Sequence[ChannelObject]) -> bytes:
    stream = io.BytesIO()
    with TdmsWriter(stream) as writer:
        for segment in segments:
            writer.write_segment(list(segment))
    return stream.getvalue()


def put(folder: Path, *segments: Sequence[ChannelObject]) -> Path:
    path = folder / "a.tdms"
    path.write_bytes(tdms(*segments))
    return path


def text(words: str) -> bytes:
    return struct.pack("<I", len(words)) + words.encode()


def daqmx(samples: Sequence[int], *, slope: float, intercept: float) -> bytes:
    """A file of raw 16-bit DAQmx samples and a linear scale, byte by byte."""
    names = [text("/"), text("/'G'"), text("/'G'/'z'")]
    nothing = struct.pack("<II", 0xFFFFFFFF, 0)
    scaler = struct.pack("<IIIII", 3, 0, 0, 0, 0)
    index = struct.pack("<IIIQ", 0x00001269, 0xFFFFFFFF, 1, len(samples))
    index += struct.pack("<I", 1) + scaler + struct.pack("<II", 1, 2)
    scales = {
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 2,
        "NI_Scale[1]_Scale_Type": "Linear",
        "NI_Scale[1]_Linear_Slope": slope,
        "NI_Scale[1]_Linear_Y_Intercept": intercept,
        "NI_Scale[1]_Linear_Input_Source": 0,
        "wf_increment": 0.5,
    }
    properties = b""
    for name, value in scales.items():
        if isinstance(value, str):
            properties += text(name) + struct.pack("<I", 0x20) + text(value)
        elif isinstance(value, int):
            properties += text(name) + struct.pack("<II", 7, value)
        else:
            properties += text(name) + struct.pack("<Id", 10, value)
    head = struct.pack("<I", 3) + names[0] + nothing + names[1] + nothing
    head += names[2] + index + struct.pack("<I", len(scales)) + properties
    data = struct.pack(f"<{len(samples)}h", *samples)
    toc = (1 << 1) | (1 << 2) | (1 << 3) | (1 << 7)
    return b"TDSm" + struct.pack("<IIQQ", toc, 4713, len(head) + len(data), len(head)) + head + data


VALUES = RNG.normal(size=(2, 12))
WHOLE = tdms(*[[channel("g", n, VALUES[k, i : i + 6], wf_increment=0.1) for k, n in enumerate("ab")] for i in (0, 6)])


class TestNumbersComeBack:
    @pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u2", "i4", "u8", "?"])
    def test_of_each_type(self, tmp_path: Path, kind: str) -> None:
        values = np.array([0, 1, 100, 3], kind)
        (read,) = read_tdms(put(tmp_path, [channel("g", "x", values, wf_increment=1.0)])).columns(["x"])
        assert np.array_equal(read, values.astype(float))
        assert read.dtype == np.float64
        assert not read.flags.writeable

    def test_of_many_segments(self, tmp_path: Path) -> None:
        values = RNG.normal(size=(2, 30))
        parts = [[channel("g", n, values[k, i : i + 10]) for k, n in enumerate("ab")] for i in range(0, 30, 10)]
        table = read_tdms(put(tmp_path, *parts))
        assert table.sizes == {"a": 30, "b": 30}
        assert np.array_equal(table.columns(["b", "a"]), values[::-1])

    def test_scaled_as_the_file_says(self, tmp_path: Path) -> None:
        scale = {
            "NI_Number_Of_Scales": 1,
            "NI_Scale[0]_Scale_Type": "Polynomial",
            "NI_Scale[0]_Polynomial_Coefficients_Size": 3,
            "NI_Scale[0]_Polynomial_Coefficients[0]": 1.0,
            "NI_Scale[0]_Polynomial_Coefficients[1]": 0.5,
            "NI_Scale[0]_Polynomial_Coefficients[2]": 0.25,
            "NI_Scale[0]_Polynomial_Input_Source": 0xFFFFFFFF,
        }
        table = read_tdms(put(tmp_path, [channel("g", "x", np.array([0, 2, -4], np.int16), **scale)]))
        assert table.columns(["x"])[0].tolist() == [1.0, 3.0, 3.0]

    def test_of_raw_daqmx(self, tmp_path: Path) -> None:
        (tmp_path / "a.tdms").write_bytes(daqmx([1, -2, 300], slope=0.5, intercept=10.0))
        table = read_tdms(tmp_path / "a.tdms")
        assert table.columns(["z"])[0].tolist() == [10.5, 9.0, 160.0]
        assert table.clocks["z"].rate == 2.0


class TestNames:
    def test_of_two_groups_are_told_apart(self, tmp_path: Path) -> None:
        path = put(
            tmp_path, [channel("front", "z", [1.0, 2]), channel("rear", "z", [3.0]), channel("rear", "v", [4.0])]
        )
        table = read_tdms(path)
        assert table.sizes == {"front/z": 2, "rear/z": 1, "v": 1}
        assert [c.tolist() for c in table.columns(["rear/z", "v", "front/z"])] == [[3], [4], [1, 2]]

    def test_cannot_command_a_terminal(self, tmp_path: Path) -> None:
        table = read_tdms(put(tmp_path, [channel("g", "a\x1b[2J", [1.0, 2.0])]))
        assert list(table.sizes) == ["a\\x1b[2J"]
        assert table.columns(["a\\x1b[2J"])[0].tolist() == [1.0, 2.0]

    def test_units(self, tmp_path: Path) -> None:
        path = put(tmp_path, [channel("g", "a", [1.0], unit_string="m/s^2"), channel("g", "b", [1.0])])
        assert read_tdms(path).units == {"a": "m/s^2"}


class TestClocks:
    def test_of_waveforms(self, tmp_path: Path) -> None:
        fast = {"wf_increment": 0.25, "wf_start_offset": 2.0}
        channels = [channel("g", "a", [1.0, 2], **fast), channel("g", "b", [3.0, 4], **fast)]
        clocks = read_tdms(put(tmp_path, [*channels, channel("g", "c", [5.0], wf_increment=10.0)])).clocks
        assert clocks["a"] is clocks["b"]
        assert (clocks["a"].start, clocks["a"].rate) == (2.0, 4.0)
        assert (clocks["c"].start, clocks["c"].rate) == (0.0, 0.1)

    def test_that_began_apart(self, tmp_path: Path) -> None:
        began = [np.datetime64("2024-01-01T00:00:03.5"), np.datetime64("2024-01-01T00:00:01")]
        channels = [
            channel("g", n, [1.0, 2], wf_increment=0.1, wf_start_offset=0.25, wf_start_time=t)
            for n, t in zip("ab", began, strict=True)
        ]
        clocks = read_tdms(put(tmp_path, channels)).clocks
        # A stamp is stored in units of 2^-64 s.
        assert clocks["a"].start == pytest.approx(2.75, abs=1e-12)
        assert clocks["b"].start == 0.25

    def test_of_a_group_with_a_column_of_time(self, tmp_path: Path) -> None:
        groups = [
            [channel(g, "Time", t, unit_string=u), channel(g, "z", [1.0, 2, 3]), channel(g, "short", [1.0])]
            for g, t, u in (("front", [0.0, 2, 5], "ms"), ("rear", [1.0, 2, 4], ""))
        ]
        table = read_tdms(put(tmp_path, [*groups[0], *groups[1]]))
        assert sorted(table.clocks) == ["front/z", "rear/z"]
        stamps = [table.clocks[n].stamps for n in ("front/z", "rear/z")]
        assert [s().tolist() for s in stamps if s is not None] == [[0.0, 0.002, 0.005], [1.0, 2.0, 4.0]]

    def test_of_a_group_with_dates(self, tmp_path: Path) -> None:
        dates = np.array(["2024-02-28T23:59:59.5", "2024-02-29T00:00:00", "2024-02-29T00:00:02.25"], "datetime64[us]")
        table = read_tdms(put(tmp_path, [channel("g", "when", dates), channel("g", "z", [1.0, 2, 3])]))
        stamps = table.clocks["z"].stamps
        assert stamps is not None
        assert stamps() == pytest.approx([0.0, 0.5, 2.75], abs=1e-12)

    def test_there_may_be_none(self, tmp_path: Path) -> None:
        assert not read_tdms(put(tmp_path, [channel("g", "z", [1.0, 2], wf_increment=0.0)])).clocks

    def test_dates_in_names_of_groups_are_not_cut(self, tmp_path: Path) -> None:
        groups = ("07/09/2012 06:58:23 PM - all", "07/09/2012 06:58:23 PM - means")
        parts = [channel(g, "z", RNG.standard_normal(9), wf_increment=0.5 * (k + 1)) for k, g in enumerate(groups)]
        assert read_recording(put(tmp_path, parts)).tests == groups


class TestLeftOut:
    def test_with_the_reason(self, tmp_path: Path) -> None:
        odd = [channel("g", "note", ["a", "b"]), channel("g", "c", np.array([1j, 2])), channel("g", "x", [1.0, 2])]
        table = read_tdms(put(tmp_path, odd))
        assert list(table.sizes) == ["x"]
        assert {name: why.code for name, why in table.unusable.items()} == {"note": LeftOut.TEXT, "c": LeftOut.COMPLEX}

    def test_all_of_it_is_an_error(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="contains no channel of numbers: 'note' is text"):
            read_tdms(put(tmp_path, [channel("g", "note", ["a", "b"])]))


class TestDamage:
    def test_every_truncation_is_refused_or_ends_a_segment(self, tmp_path: Path) -> None:
        second = WHOLE.index(b"TDSm", 4)
        for length in range(len(WHOLE)):
            (tmp_path / "a.tdms").write_bytes(WHOLE[:length])
            with contextlib.suppress(RecordError):
                table = read_tdms(tmp_path / "a.tdms")
                assert length == second
                assert np.array_equal(table.columns(["a", "b"]), VALUES[:, :6])

    @FUZZ
    @given(data=st.data(), byte=st.integers(0, 255))
    def test_a_flipped_byte(self, scratch: Path, data: st.DataObject, byte: int) -> None:
        flipped = bytearray(WHOLE)
        flipped[data.draw(st.integers(0, len(WHOLE) - 1))] = byte
        (scratch / "a.tdms").write_bytes(flipped)
        with contextlib.suppress(SuspidError):
            table = read_tdms(scratch / "a.tdms")
            table.columns(list(table.sizes))

    @pytest.mark.parametrize("count", [1 << 20, 1 << 40, (1 << 64) - 1])
    def test_absurd_numbers_of_samples(self, tmp_path: Path, count: int) -> None:
        head = struct.pack("<IIQ", 10, 1, 6)
        assert WHOLE.count(head) >= 1
        (tmp_path / "a.tdms").write_bytes(WHOLE.replace(head, struct.pack("<IIQ", 10, 1, count)))
        with pytest.raises(RecordError, match="is damaged"):
            read_tdms(tmp_path / "a.tdms")

    @pytest.mark.parametrize("key", ["NI_Number_Of_Scales", "NI_Scale[0]_Polynomial_Coefficients_Size"])
    def test_absurd_numbers_of_scales(self, tmp_path: Path, key: str) -> None:
        with pytest.raises(RecordError, match="is damaged: it states NI_"):
            read_tdms(put(tmp_path, [channel("g", "x", [1.0], **{key: 1 << 30})]))

    def test_a_crash_of_the_writer(self, tmp_path: Path) -> None:
        second = WHOLE.index(b"TDSm", 4)
        crashed = WHOLE[: second + 12] + b"\xff" * 8 + WHOLE[second + 20 :]
        (tmp_path / "a.tdms").write_bytes(crashed)
        with pytest.raises(RecordError, match="is cut off"):
            read_tdms(tmp_path / "a.tdms")

    @pytest.mark.parametrize(("rubbish", "message"), [(b"TDSh" + bytes(40), "is the index"), (b"time,x\n0,1", "TDMS")])
    def test_another_kind(self, tmp_path: Path, rubbish: bytes, message: str) -> None:
        (tmp_path / "a.tdms").write_bytes(rubbish)
        with pytest.raises(RecordError, match=message):
            read_tdms(tmp_path / "a.tdms")

    def test_a_missing_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (tmp_path / "a.tdms").write_bytes(WHOLE)
        monkeypatch.setitem(sys.modules, "nptdms", None)
        with pytest.raises(RecordError, match=r"^reading .tdms needs nptdms: pip install '(?i:nptdms)[<>=.,\d]+'$"):
            read_tdms(tmp_path / "a.tdms")


def test_the_unit_of_a_step_is_the_one_that_is_stated(tmp_path: Path) -> None:
    seat = channel("G", "seat", np.arange(9.0), wf_increment=5.0, wf_start_offset=20.0, wf_xunit_string="ms")
    found = read_recording(put(tmp_path, [seat]))
    np.testing.assert_allclose(found.channels[0].timepts, 0.02 + 0.005 * np.arange(9))
