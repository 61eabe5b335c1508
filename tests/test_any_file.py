"""Any file of any suffix becomes a record or one line that says why not."""

from __future__ import annotations

import contextlib
import gc
import io
import struct
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat, wavfile

from suspid import read_record, write_record
from suspid.errors import RecordWarning, SuspidError
from suspid.io.formats import READERS
from suspid.records import as_response

FUZZ = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
KINDS = [".csv", ".mat", ".xlsx", ".npz", ".h5", ".parquet", ".uff", ".tdms", ".mf4", ".wav", ".npy"]


@cache
def true_file(suffix: str, folder: Path) -> bytes:
    """A small sound file of a kind: a decay of 64 samples; suffixes without a writer here give plain text."""
    t = np.arange(64) / 100
    y = np.exp(-t) * np.sin(20 * t)
    path = folder / f"true{suffix}"
    if suffix in (".csv", ".parquet"):
        write_record(as_response(t, y[None], ["seat"]), path, units=["m"])
    elif suffix == ".mat":
        savemat(path, {"t": t, "seat": y})
    elif suffix == ".npz":
        np.savez(path, t=t, seat=y)
    elif suffix == ".npy":
        np.save(path, np.column_stack([t, y]))
    elif suffix == ".h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            file["t"], file["seat"] = t, y
    elif suffix == ".xlsx":
        book = pytest.importorskip("openpyxl").Workbook()
        for row in (["t", "seat"], *zip(t.tolist(), y.tolist(), strict=True)):
            book.active.append(row)
        book.save(path)
    elif suffix == ".uff":
        uff = pytest.importorskip("pyuff")
        data = uff.prepare_58(
            binary=1, func_type=1, rsp_node=1, rsp_dir=3, ref_node=1, ref_dir=3, data=y, x=t, id1="seat",
            abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=0.01, num_pts=64, ord_data_type=4,
            abscissa_spec_data_type=17, orddenom_spec_data_type=0,
        )  # fmt: skip
        with warnings.catch_warnings():
            # The writer leaves files open.
            warnings.simplefilter("ignore")
            uff.UFF(str(path)).write_sets(data, mode="add")
            gc.collect()
    elif suffix == ".tdms":
        tdms = pytest.importorskip("nptdms")
        with tdms.TdmsWriter(str(path)) as writer:
            writer.write_segment([tdms.ChannelObject("g", "seat", y, {"wf_increment": 0.01, "wf_samples": 64})])
    elif suffix == ".mf4":
        mdf = pytest.importorskip("asammdf")
        with warnings.catch_warnings(), mdf.MDF(version="4.10") as file:
            warnings.simplefilter("ignore")
            file.append([mdf.Signal(y, t, name="seat", unit="m")])
            stream = io.BytesIO()
            file.save(stream)
            return stream.getvalue()
    else:
        wavfile.write(path, 100, y)
    return path.read_bytes()


def read(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", RecordWarning)
        with contextlib.suppress(SuspidError):
            read_record(path)
        gc.collect()


class TestSound:
    @pytest.mark.parametrize("suffix", KINDS)
    def test_each_is_read(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"r{suffix}"
        path.write_bytes(true_file(suffix, tmp_path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RecordWarning)
            assert read_record(path).y.size == 64

    @pytest.mark.parametrize("suffix", KINDS[4:])
    def test_an_unknown_name_is_read_by_its_mark(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / "r.data"
        path.write_bytes(true_file(suffix, tmp_path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RecordWarning)
            assert read_record(path).y.size == 64

    def test_a_wrong_name_is_told(self, tmp_path: Path) -> None:
        path = tmp_path / "r.csv"
        path.write_bytes(true_file(".parquet", tmp_path))
        with pytest.raises(SuspidError, match=r"looks like a Parquet file: name it \.parquet"):
            read_record(path)


@pytest.mark.slow
class TestDamaged:
    @FUZZ
    @given(suffix=st.sampled_from(sorted(READERS)), content=st.binary(max_size=300))
    def test_random_bytes(self, scratch: Path, suffix: str, content: bytes) -> None:
        path = scratch / f"r{suffix}"
        path.write_bytes(content)
        read(path)

    @FUZZ
    @given(kind=st.sampled_from(KINDS), data=st.data())
    def test_cut_flipped_or_misnamed(self, scratch: Path, kind: str, data: st.DataObject) -> None:
        content = bytearray(true_file(kind, scratch))
        how = data.draw(st.sampled_from(["cut", "flip", "name", "number"]))
        suffix = data.draw(st.sampled_from(sorted(READERS))) if how == "name" else kind
        place = data.draw(st.integers(0, len(content) - 1))
        if how == "cut":
            del content[place:]
        elif how == "flip":
            content[place] ^= 1 << data.draw(st.integers(0, 7))
        elif how == "number":
            content[place : place + 4] = struct.pack("<I", data.draw(st.sampled_from([0, 1, 0x7FFFFFFF, 0xFFFFFFFF])))
        path = scratch / f"r{suffix}"
        path.write_bytes(bytes(content))
        read(path)
