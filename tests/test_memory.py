"""What a file may take is limited by its size: small files that stand for gigabytes are refused at once."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from suspid import RecordError, read_record, read_recording
from suspid.io.limits import TIMES_SIZE

# Rows and columns of the bombs, and the limit for them [bytes]: as the true limit, but made in a fraction of a second.
ROWS, COLUMNS, LIMIT = 1 << 20, 16, 1 << 24


def parquet(path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    zeros = pa.array(np.zeros(ROWS))
    pq.write_table(pa.table({f"a{k}": zeros for k in range(COLUMNS)}), path, compression="zstd")


def mat(path: Path) -> None:
    savemat(path, {f"a{k}": np.zeros(ROWS * 4, np.uint8) for k in range(COLUMNS)}, do_compression=True)


def bytes_of_mat(path: Path) -> None:
    """Write bytes, each of which becomes a number of eight: inflated they are within the limit, as numbers not."""
    savemat(path, {f"a{k}": np.zeros(ROWS // 2, np.uint8) for k in range(COLUMNS)}, do_compression=True)


def npz(path: Path) -> None:
    np.savez_compressed(path, a=np.zeros((ROWS // 4, COLUMNS)), b=np.zeros(ROWS // 4))


def unfilled(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for k in range(COLUMNS):
            file.create_dataset(f"a{k}", (ROWS, 3), "f4", chunks=(1 << 14, 3))


def packed(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for k in range(COLUMNS):
            file.create_dataset(f"a{k}", data=np.zeros(ROWS // 2), chunks=(ROWS // 2,), compression="gzip")


def one_chunk(path: Path) -> None:
    """Write a single number in a chunk of many."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("fs", data=np.ones(1), chunks=(1 << 23,), maxshape=(None,), compression="gzip")


BOMBS = {
    "parquet": parquet, "mat": mat, "bytes.mat": bytes_of_mat, "npz": npz, "unfilled.h5": unfilled, "packed.h5": packed,
    "chunk.h5": one_chunk,
}  # fmt: skip


@pytest.mark.parametrize("kind", BOMBS)
def test_a_bomb_is_refused_before_its_memory_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    path = tmp_path / f"bomb.{kind}"
    BOMBS[kind](path)
    monkeypatch.setattr("suspid.io.limits.ANY_FILE", LIMIT)
    size = path.stat().st_size
    tracemalloc.start()
    try:
        with pytest.raises(RecordError, match=r"GiB of memory|but no data"):
            read_record(path, fs=100)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 3 * max(LIMIT, TIMES_SIZE * size)


def test_channels_of_a_large_file_may_be_chosen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet(tmp_path / "bomb.parquet")
    monkeypatch.setattr("suspid.io.limits.ANY_FILE", LIMIT)
    chosen = read_recording(tmp_path / "bomb.parquet", channels=["a3"], fs=100)
    assert chosen["a3"].values.size == ROWS


def test_many_columns_are_read_in_groups(tmp_path: Path) -> None:
    """Every column keeps its samples and its place, names with points beside a structure of that name too."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    names = [f"c{k}" for k in range(300)]
    columns = {name: np.arange(5.0) + k for k, name in enumerate(names)}
    nested = pa.array([{"b": float(k)} for k in range(5)])
    pq.write_table(pa.table({**columns, "a": nested, "a.b": np.arange(5.0) - 7}), tmp_path / "wide.parquet")
    recording = read_recording(tmp_path / "wide.parquet", fs=10)
    assert recording.names == (*names, "a.b")
    assert all(np.array_equal(recording[name].values, column) for name, column in columns.items())
    assert np.array_equal(recording["a.b"].values, np.arange(5.0) - 7)
