"""NumPy files: arrays come back, pickles are not opened, damage is refused."""

from __future__ import annotations

import contextlib
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError
from suspid.errors import SuspidError
from suspid.io import read_recording
from suspid.io.npz import read_npz
from suspid.words import LeftOut

T = np.arange(40) / 8
X = np.sin(T)


class TestArraysComeBack:
    def test_of_an_archive(self, tmp_path: Path) -> None:
        np.savez_compressed(tmp_path / "r.npz", t=T, seat=X.astype(np.float32), note="bump", z=1j * X)
        recording = read_recording(tmp_path / "r.npz")
        assert recording.names == ("seat",)
        assert recording["seat"].values.tolist() == X.astype(np.float32).astype(float).tolist()
        assert recording["seat"].timepts.tolist() == T.tolist()
        assert {name: why.code for name, why in recording.left_out} == {"note": LeftOut.TEXT, "z": LeftOut.COMPLEX}

    @pytest.mark.parametrize("turned", [False, True])
    def test_of_one_matrix_whose_first_column_is_time(self, tmp_path: Path, turned: bool) -> None:
        matrix = np.column_stack([T, X])
        np.save(tmp_path / "r.npy", matrix.T if turned else matrix)
        recording = read_recording(tmp_path / "r.npy")
        assert recording.names == ("column 2",)
        assert recording["column 2"].values.tolist() == X.tolist()
        assert recording["column 2"].timepts.tolist() == T.tolist()

    def test_of_a_vector_with_a_rate(self, tmp_path: Path) -> None:
        np.save(tmp_path / "r.npy", X)
        assert read_recording(tmp_path / "r.npy", fs=8)["column 1"].timepts.tolist() == T.tolist()

    def test_of_named_fields(self, tmp_path: Path) -> None:
        fields = np.zeros(40, [("time", "f8"), ("seat", "f4")])
        fields["time"], fields["seat"] = T, 2.5
        np.save(tmp_path / "r.npy", fields)
        assert read_recording(tmp_path / "r.npy").names == ("seat",)


class TestRefusals:
    def test_a_pickle_is_not_opened(self, tmp_path: Path) -> None:
        class Trap:
            def __reduce__(self) -> tuple[object, ...]:
                return Path.touch, (tmp_path / "opened",)

        np.savez(tmp_path / "r.npz", t=T, seat=X, trap=np.array([Trap()], object))
        recording = read_recording(tmp_path / "r.npz")
        assert dict(recording.left_out)["trap"].code is LeftOut.PICKLE
        assert not (tmp_path / "opened").exists()

    def test_every_truncation(self, tmp_path: Path) -> None:
        np.save(tmp_path / "r.npy", X)
        content = (tmp_path / "r.npy").read_bytes()
        for length in (*range(1, 160, 13), *range(160, len(content), 907)):
            (tmp_path / "cut.npy").write_bytes(content[:length])
            with pytest.raises(RecordError):
                read_npz(tmp_path / "cut.npy")

    def test_a_size_that_nothing_fills(self, tmp_path: Path) -> None:
        stream = io.BytesIO()
        np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (1 << 50,)})
        (tmp_path / "r.npy").write_bytes(stream.getvalue())
        with pytest.raises(RecordError, match="is cut off"):
            read_npz(tmp_path / "r.npy")

    def test_an_archive_that_would_unpack_to_too_much(self, tmp_path: Path) -> None:
        with zipfile.ZipFile(tmp_path / "r.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("x.npy", bytes(1000))
        content = (tmp_path / "r.npz").read_bytes()
        huge = content.replace((1000).to_bytes(4, "little"), (0xFFFFFFF0).to_bytes(4, "little"))
        (tmp_path / "r.npz").write_bytes(huge)
        with pytest.raises(RecordError, match="would take 4 GiB of memory"):
            read_npz(tmp_path / "r.npz")

    def test_another_kind(self, tmp_path: Path) -> None:
        (tmp_path / "r.npz").write_text("t,x\n0,1\n")
        with pytest.raises(RecordError, match="is not a NumPy file"):
            read_npz(tmp_path / "r.npz")

    def test_a_flipped_byte(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "r.npz", t=T, seat=X)
        content = (tmp_path / "r.npz").read_bytes()
        rng = np.random.default_rng(3)
        for place in rng.integers(0, len(content), 10):
            flipped = bytearray(content)
            flipped[place] ^= 1 << int(rng.integers(8))
            (tmp_path / "f.npz").write_bytes(bytes(flipped))
            with contextlib.suppress(SuspidError):
                read_npz(tmp_path / "f.npz")
