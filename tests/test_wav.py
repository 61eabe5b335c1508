"""WAV files: fractions of full scale come back, and damage is refused."""

from __future__ import annotations

import contextlib
import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import wavfile

from suspid import SuspidError
from suspid.errors import RecordError
from suspid.io.wav import read_wav

FUZZ = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def wav(samples: np.ndarray, *, rate: int = 800) -> bytes:
    stream = io.BytesIO()
    wavfile.write(stream, rate, samples)
    return stream.getvalue()


def pcm24(samples: list[int], *, rate: int = 800, channels: int = 1) -> bytes:
    """Three bytes a sample by hand: scipy does not write them."""
    data = b"".join(struct.pack("<i", s)[:3] for s in samples)
    head = struct.pack("<HHIIHH", 1, channels, rate, rate * 3 * channels, 3 * channels, 24)
    body = b"WAVEfmt " + struct.pack("<I", 16) + head + b"data" + struct.pack("<I", len(data)) + data
    return b"RIFF" + struct.pack("<I", len(body)) + body


def put(folder: Path, content: bytes) -> Path:
    path = folder / "a.wav"
    path.write_bytes(content)
    return path


class TestFullScaleIsOne:
    @pytest.mark.parametrize(
        ("dtype", "raw", "expected"),
        [
            (np.uint8, [0, 64, 128, 192], [-1.0, -0.5, 0.0, 0.5]),
            (np.int16, [-32768, -16384, 0, 8192], [-1.0, -0.5, 0.0, 0.25]),
            (np.int32, [-(2**31), -(2**30), 0, 2**29], [-1.0, -0.5, 0.0, 0.25]),
            (np.float32, [-1.5, 0.1, 0.0, 3.0], [-1.5, float(np.float32(0.1)), 0.0, 3.0]),
            (np.float64, [-1.5, 0.1, 0.0, 3.0], [-1.5, 0.1, 0.0, 3.0]),
        ],
    )
    def test_each_type(self, tmp_path: Path, dtype: type, raw: list[float], expected: list[float]) -> None:
        table = read_wav(put(tmp_path, wav(np.array(raw, dtype))))
        (values,) = table.columns(["channel 1"])
        assert values.tolist() == expected
        assert values.dtype == np.float64
        assert not values.flags.writeable
        assert table.units == {"channel 1": "full scale"}

    def test_24_bits(self, tmp_path: Path) -> None:
        table = read_wav(put(tmp_path, pcm24([-(2**23), -(2**22), 0, 2**21, 1])))
        assert table.columns(["channel 1"])[0].tolist() == [-1.0, -0.5, 0.0, 0.25, 2.0**-23]


class TestChannels:
    def test_stand_apart_on_one_clock(self, tmp_path: Path) -> None:
        samples = np.random.default_rng(1).normal(size=(50, 3))
        table = read_wav(put(tmp_path, wav(samples, rate=12345)))
        assert table.sizes == {"channel 1": 50, "channel 2": 50, "channel 3": 50}
        second, first = table.columns(["channel 2", "channel 1"])
        assert np.array_equal(first, samples[:, 0])
        assert np.array_equal(second, samples[:, 1])
        assert table.clocks["channel 1"] is table.clocks["channel 3"]
        assert table.clocks["channel 1"].rate == 12345.0

    def test_foreign_chunks_are_passed_over(self, tmp_path: Path) -> None:
        content = wav(np.arange(5, dtype=np.int16))
        bext = b"bext" + struct.pack("<I", 3) + b"abc\0"
        table = read_wav(put(tmp_path, content[:12] + bext + content[12:] + bext))
        assert (table.columns(["channel 1"])[0] * 32768).tolist() == [0, 1, 2, 3, 4]

    def test_big_endian(self, tmp_path: Path) -> None:
        data = np.array([1, -2, 3], ">i2").tobytes()
        head = struct.pack(">HHIIHH", 1, 1, 100, 200, 2, 16)
        body = b"WAVEfmt " + struct.pack(">I", 16) + head + b"data" + struct.pack(">I", len(data)) + data
        table = read_wav(put(tmp_path, b"RIFX" + struct.pack(">I", len(body)) + body))
        assert (table.columns(["channel 1"])[0] * 32768).tolist() == [1, -2, 3]


class TestDamage:
    def test_every_truncation_is_refused(self, tmp_path: Path) -> None:
        content = wav(np.arange(20, dtype=np.int16))
        for length in range(len(content)):
            with pytest.raises(RecordError):
                read_wav(put(tmp_path, content[:length]))

    @FUZZ
    @given(place=st.integers(0, 43), byte=st.integers(0, 255))
    def test_a_flipped_byte_of_the_head(self, scratch: Path, place: int, byte: int) -> None:
        content = bytearray(wav(np.arange(40, dtype=np.int16).reshape(-1, 2)))
        content[place] = byte
        with contextlib.suppress(SuspidError):
            table = read_wav(put(scratch, bytes(content)))
            table.columns(list(table.sizes))

    @FUZZ
    @given(content=st.binary(max_size=80))
    def test_rubbish(self, scratch: Path, content: bytes) -> None:
        with pytest.raises(SuspidError):
            read_wav(put(scratch, b"RIFF" + content))

    @pytest.mark.parametrize("more", [2, 50])
    def test_a_head_that_states_more_than_there_is_loses_no_sample(self, tmp_path: Path, more: int) -> None:
        """Editors drop a chunk of notes and leave the size of the file: the chunk of the samples tells their number."""
        whole = wav(np.arange(20, dtype=np.int16))
        table = read_wav(put(tmp_path, b"RIFF" + struct.pack("<I", len(whole) - 8 + more) + whole[8:]))
        assert (table.columns(["channel 1"])[0] * 32768).tolist() == list(range(20))
        (said,) = table.unusable.items()
        assert " ".join(map(str, said)) == f"end of the file lacks {more} bytes that the file states, but no sample"

    def test_a_head_that_does_not_know_the_size_of_the_file_lacks_nothing(self, tmp_path: Path) -> None:
        """Programs that write to a pipe fill in the size of the samples alone."""
        whole = wav(np.arange(20, dtype=np.int16))
        table = read_wav(put(tmp_path, b"RIFF" + b"\xff" * 4 + whole[8:]))
        assert (table.sizes, table.unusable) == ({"channel 1": 20}, {})

    def test_samples_that_are_cut_off_are_refused_whatever_the_head_states(self, tmp_path: Path) -> None:
        whole = wav(np.arange(20, dtype=np.int16))
        with pytest.raises(RecordError, match="its chunk 'data' should have 40 bytes, there are 38"):
            read_wav(put(tmp_path, b"RIFF" + struct.pack("<I", len(whole) + 42) + whole[8:-2]))

    def test_a_byte_of_padding_that_was_counted_and_not_written(self, tmp_path: Path) -> None:
        """As drum machines' samples have it: the samples are complete."""
        content = bytearray(wav(np.arange(-4, 4, dtype=np.int16)))
        content[4:8] = (len(content) - 8 + 1).to_bytes(4, "little")
        assert read_wav(put(tmp_path, bytes(content))).sizes == {"channel 1": 8}

    @pytest.mark.parametrize("end", [b"\n", b"\0" * 7, b"\0" * 40, b"TAGbump" + b" " * 121])
    def test_what_follows_the_stated_end_holds_no_sample(self, tmp_path: Path, end: bytes) -> None:
        """An editor adds a line feed, a player a tag."""
        table = read_wav(put(tmp_path, wav(np.arange(-4, 4, dtype=np.int16)) + end))
        assert table.sizes == {"channel 1": 8}
        assert (table.columns(["channel 1"])[0] * 32768).tolist() == list(range(-4, 4))
        (said,) = table.unusable.items()
        bytes_ = "1 byte" if len(end) == 1 else f"{len(end)} bytes"
        assert " ".join(map(str, said)) == f"end of the file holds {bytes_} behind its last chunk, and no sample"

    @pytest.mark.parametrize("end", [b"\n", b"\0" * 6])
    def test_less_than_the_head_of_a_chunk_holds_no_sample_where_it_is_counted(
        self, tmp_path: Path, end: bytes
    ) -> None:
        content = bytearray(wav(np.arange(8, dtype=np.int16)) + end)
        content[4:8] = (len(content) - 8).to_bytes(4, "little")
        assert read_wav(put(tmp_path, bytes(content))).sizes == {"channel 1": 8}

    @pytest.mark.parametrize("more", [b"\xff" * 40, b"LIST\x90\0\0\0abcd"])
    def test_what_the_file_counts_is_no_end(self, tmp_path: Path, more: bytes) -> None:
        content = bytearray(wav(np.arange(8, dtype=np.int16)) + more)
        content[4:8] = (len(content) - 8).to_bytes(4, "little")
        with pytest.raises(RecordError, match="there should be a chunk|is cut off: its chunk 'LIST'"):
            read_wav(put(tmp_path, bytes(content)))

    def test_samples_behind_the_stated_end_are_not_lost(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="is cut off: its chunk 'data'"):
            read_wav(put(tmp_path, wav(np.arange(8, dtype=np.int16)) + b"data" + struct.pack("<I", 8) + b"\0\0"))

    def test_no_sample(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="contains no sample"):
            read_wav(put(tmp_path, wav(np.zeros(0, np.int16))))

    def test_a_rate_of_zero(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="0 Hz"):
            read_wav(put(tmp_path, wav(np.zeros(9, np.int16), rate=0)))

    def test_a_stream_that_was_not_closed(self, tmp_path: Path) -> None:
        content = bytearray(wav(np.arange(9, dtype=np.int16)))
        content[40:44] = b"\xff" * 4
        with pytest.raises(RecordError, match="was not closed"):
            read_wav(put(tmp_path, bytes(content)))

    def test_another_kind(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="is not a WAV file"):
            read_wav(put(tmp_path, b"time,x\n0,1\n"))

    def test_compressed(self, tmp_path: Path) -> None:
        content = bytearray(wav(np.arange(9, dtype=np.int16)))
        content[20:22] = struct.pack("<H", 0x11)
        with pytest.raises(RecordError, match="ADPCM"):
            read_wav(put(tmp_path, bytes(content)))
