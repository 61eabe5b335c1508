"""MATLAB files of both kinds and plain HDF5: structures become names, and damage becomes one line."""

from __future__ import annotations

import io
import os
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.io import loadmat, savemat

from suspid import RecordError
from suspid.io.read_recording import read_recording
from suspid.recordings import Recording
from suspid.words import LeftOut

h5py = pytest.importorskip("h5py")

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
T = np.arange(5) / 10
LONG = np.arange(20) / 10
X = np.array([1.0, -0.5, 0.25, -0.125, 0.0625])


def of_structures(fields: dict[str, list[Any]]) -> NDArray[np.void]:
    """Return an array of structures as savemat takes it."""
    size = len(next(iter(fields.values())))
    array = np.empty((1, size), dtype=[(name, "O") for name in fields])
    for name, values in fields.items():
        for k, value in enumerate(values):
            array[name][0, k] = value
    return array


def cells(*items: Any) -> NDArray[np.object_]:
    """Return a cell array."""
    found = np.empty((1, len(items)), object)
    found[0, :] = [None] * len(items)
    for k, item in enumerate(items):
        found[0, k] = item
    return found


def opaque(name: str, of_class: str) -> bytes:
    """Return a variable of a file of v5 that holds an object: flags, name, system, class, and a handle."""

    def element(kind: int, content: bytes) -> bytes:
        return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)

    texts = b"".join(element(1, one.encode()) for one in (name, "MCOS", of_class))
    handle = element(14, element(6, struct.pack("<II", 13, 0)) + element(5, struct.pack("<ii", 1, 1)) + element(1, b""))
    return element(14, element(6, struct.pack("<II", 17, 0)) + texts + handle)


def written_v5(path: Path, variables: dict[str, Any]) -> None:
    savemat(path, variables)


def written_v73(path: Path, variables: dict[str, Any]) -> None:
    """Write as MATLAB v7.3 does: transposed, structures as groups, their arrays as references, below a page of head."""
    with h5py.File(path, "w", userblock_size=512) as file:
        refs = file.create_group("#refs#")

        def put(group: Any, name: str, value: Any) -> None:
            if isinstance(value, dict):
                inner = group.create_group(name)
                inner.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, item in value.items():
                    put(inner, key, item)
            elif isinstance(value, np.ndarray) and value.dtype.names:
                inner = group.create_group(name)
                for key in value.dtype.names:
                    pointers = []
                    for item in value[key].ravel():
                        put(refs, f"r{len(refs)}", item)
                        pointers.append([refs[f"r{len(refs) - 1}"].ref])
                    inner.create_dataset(key, data=np.array(pointers, dtype=h5py.ref_dtype))
            elif isinstance(value, np.ndarray) and value.dtype == object:
                pointers = []
                for item in value.ravel():
                    put(refs, f"r{len(refs)}", item)
                    pointers.append([refs[f"r{len(refs) - 1}"].ref])
                data = group.create_dataset(name, data=np.array(pointers, dtype=h5py.ref_dtype))
                data.attrs["MATLAB_class"] = np.bytes_("cell")
            elif isinstance(value, str):
                data = group.create_dataset(name, data=np.array([[ord(c)] for c in value], np.uint16))
                data.attrs["MATLAB_class"] = np.bytes_("char")
            else:
                data = group.create_dataset(name, data=np.atleast_2d(value).T)
                data.attrs["MATLAB_class"] = np.bytes_("double")

        for name, value in variables.items():
            put(file, name, value)
    content = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + content[128:])


WRITERS = {"v5": written_v5, "v7.3": written_v73}
# Variables, and the channels that they hold: values, last stamp, rate.
LAYOUTS: dict[str, tuple[dict[str, Any], dict[str, tuple[list[float], float, float | None]]]] = {
    "vectors and time": ({"t": T, "seat": X}, {"seat": (X.tolist(), 0.4, None)}),
    "a rate": ({"Fs": 10.0, "seat": X}, {"seat": (X.tolist(), 0.4, 10)}),
    "a structure with a rate": (
        {"run1": {"seat": X, "Fs": 10.0, "note": "bump"}},
        {"run1.seat": (X.tolist(), 0.4, 10)},
    ),
    "a structure with a step": ({"run1": {"seat": X, "dt": 0.1}}, {"run1.seat": (X.tolist(), 0.4, 10)}),
    "structures within": (
        {"data": {"a": {"seat": X, "t": T}, "b": {"seat": X[:3]}, "Fs": 20.0}},
        {"data.a.seat": (X.tolist(), 0.4, None), "data.b.seat": (X[:3].tolist(), 0.1, 20)},
    ),
    "an array of structures": (
        {"run": of_structures({"seat": [X, X[:3]], "Fs": [10.0, 20.0]})},
        {"run[1].seat": (X.tolist(), 0.4, 10), "run[2].seat": (X[:3].tolist(), 0.1, 20)},
    ),
    "a matrix beside time": (
        {"t": T, "y": np.column_stack([X, 2 * X])},
        {"y[1]": (X.tolist(), 0.4, None), "y[2]": ((2 * X).tolist(), 0.4, None)},
    ),
    "a matrix with names": (
        {"t": T, "y": np.column_stack([X, 2 * X]), "names": cells("seat", "body"), "units": cells("m", "m")},
        {"seat": (X.tolist(), 0.4, None), "body": ((2 * X).tolist(), 0.4, None)},
    ),
    "a structure with time among the names": (
        {"run": {"y": np.column_stack([T, X]), "names": cells("t", "seat")}},
        {"run.seat": (X.tolist(), 0.4, None)},
    ),
    "names that fit two matrices": (
        {"Fs": 10.0, "y": np.column_stack([X, 2 * X]), "u": np.column_stack([X, X]), "names": cells("seat", "body")},
        {
            f"{name}[{k}]": ((f * X).tolist(), 0.4, 10)
            for name, k, f in (("y", 1, 1), ("y", 2, 2), ("u", 1, 1), ("u", 2, 1))
        },
    ),
    "a cell array of tests": (
        {"t": T, "c": cells(np.column_stack([X, 2 * X]), np.column_stack([3 * X, X]))},
        {
            f"c[{test}].data[{k}]": ((f * X).tolist(), 0.4, None)
            for test, k, f in ((1, 1, 1), (1, 2, 2), (2, 1, 3), (2, 2, 1))
        },
    ),
    "Simcenter Testlab's signals": (
        {
            f"Signal_{k}": {
                "x_values": {"start_value": 0.0, "increment": 0.1, "number_of_values": 5.0, "quantity": {"label": "s"}},
                "y_values": {"values": (k + 1) * X, "quantity": {"label": "m/s^2"}},
                "function_record": {"name": "seat"},
            }
            for k in (0, 1)
        },
        {"Signal_0": (X.tolist(), 0.4, 10), "Signal_1": ((2 * X).tolist(), 0.4, 10)},
    ),
    "a matrix on its side": (
        {"Fs": 10.0, "y": np.vstack([X, 2 * X])},
        {"y[1]": (X.tolist(), 0.4, 10), "y[2]": ((2 * X).tolist(), 0.4, 10)},
    ),
    "Simulink's structure with time": (
        {"out": {"time": T, "signals": {"values": np.column_stack([X, 3 * X]), "dimensions": 2.0, "label": "z"}}},
        {"out.z[1]": (X.tolist(), 0.4, None), "out.z[2]": ((3 * X).tolist(), 0.4, None)},
    ),
    "Simulink's signals": (
        {"out": {"time": T, "signals": of_structures({"values": [X, 3 * X], "label": ["seat", "body"]})}},
        {"out.seat": (X.tolist(), 0.4, None), "out.body": ((3 * X).tolist(), 0.4, None)},
    ),
}


def plain(folder: Path, fill: Callable[[Any], object]) -> Recording:
    with h5py.File(folder / "r.h5", "w") as file:
        fill(file)
    return read_recording(folder / "r.h5")


@pytest.mark.parametrize("version", WRITERS)
class TestBothVersionsSayTheSame:
    @pytest.mark.parametrize("name", LAYOUTS)
    def test_channels_with_their_times(self, tmp_path: Path, version: str, name: str) -> None:
        variables, expected = LAYOUTS[name]
        WRITERS[version](tmp_path / "r.mat", variables)
        recording = read_recording(tmp_path / "r.mat")
        assert set(recording.names) == set(expected)
        for channel in recording.channels:
            values, last, rate = expected[channel.name]
            assert channel.values.tolist() == values
            assert channel.timepts[-1] == pytest.approx(last, rel=1e-15)  # one division
            assert channel.rate == (None if rate is None else pytest.approx(rate, rel=1e-15))

    def test_what_is_no_channel_is_told(self, tmp_path: Path, version: str) -> None:
        WRITERS[version](tmp_path / "r.mat", {"run": {"t": T, "x": X, "note": "bump"}, "E": np.eye(3), "f": X[:2]})
        told = dict(read_recording(tmp_path / "r.mat").left_out)
        assert told["run.t"].code is LeftOut.GROUP_TIME
        assert told["run.note"].code is LeftOut.NOTE
        assert str(told["E"]) == "is a matrix of 3 x 3; save its columns as vectors"
        assert told["f"].code is LeftOut.NO_TIME

    def test_a_vector_of_another_length_than_the_time_of_its_group_is_left_out(
        self, tmp_path: Path, version: str
    ) -> None:
        WRITERS[version](tmp_path / "r.mat", {"run": {"Time": T, "x": X, "place": X[:2]}})
        recording = read_recording(tmp_path / "r.mat")
        assert recording.names == ("run.x",)
        assert str(dict(recording.left_out)["run.place"]) == "has 2 samples, time 'run.Time' has 5"

    def test_time_of_a_structure_can_be_named(self, tmp_path: Path, version: str) -> None:
        WRITERS[version](tmp_path / "r.mat", {"a": {"t": T, "x": X}, "b": {"t": T + 1, "y": X}})
        recording = read_recording(tmp_path / "r.mat", time="b.t")
        assert recording.names == ("b.y",)
        assert recording.channels[0].timepts[0] == 1

    def test_a_column_of_a_matrix_can_be_time(self, tmp_path: Path, version: str) -> None:
        WRITERS[version](tmp_path / "r.mat", {"data": np.column_stack([LONG, np.sin(LONG)])})
        recording = read_recording(tmp_path / "r.mat")
        assert recording.names == ("data[2]",)
        assert recording.channels[0].timepts.tolist() == LONG.tolist()
        assert dict(recording.left_out)["data[1]"].code is LeftOut.TAKEN_AS_TIME

    def test_matrices_with_times_of_their_own(self, tmp_path: Path, version: str) -> None:
        WRITERS[version](
            tmp_path / "r.mat",
            {name: np.column_stack([k * LONG, np.sin(LONG)]) for k, name in ((1, "a"), (2, "b"))} | {"c": X[:2]},
        )
        recording = read_recording(tmp_path / "r.mat")
        assert recording.names == ("a[2]", "b[2]")
        assert recording["a[2]"].timepts.tolist() == LONG.tolist()
        assert recording["b[2]"].timepts.tolist() == (2 * LONG).tolist()


class TestOwnReaderAgainstScipy:
    @pytest.mark.parametrize("dtype", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
    @pytest.mark.parametrize("compressed", [False, True])
    def test_numbers_of_every_type(self, tmp_path: Path, dtype: str, compressed: bool) -> None:
        values = np.arange(60).reshape(2, 30).astype(dtype)
        savemat(tmp_path / "r.mat", {"y": values}, do_compression=compressed)
        found = [channel.values for channel in read_recording(tmp_path / "r.mat", fs=1).channels]
        assert np.array_equal(found, loadmat(tmp_path / "r.mat")["y"])

    @pytest.mark.skipif(not DATA.exists(), reason="no shared data")
    def test_a_measured_record(self) -> None:
        path = DATA / "vibtest_inout_mat" / "case1.mat"
        expected = loadmat(path)
        recording = read_recording(path)
        assert recording.names == ("Time_chan_1", "Time_chan_2")
        for channel in recording.channels:
            assert np.array_equal(channel.values, expected[channel.name].ravel())
            assert np.array_equal(channel.timepts, expected["Time_domain"].ravel())
            assert channel.rate == 1280


class TestObjects:
    def test_a_cell_a_sparse_matrix_and_complex_numbers_are_told(self, tmp_path: Path) -> None:
        from scipy.sparse import eye

        content = {"x": X, "t": T, "c": np.array(["a", 1], object), "s": eye(3).tocsc(), "z": 1j * X}
        savemat(tmp_path / "r.mat", content)
        told = {name: why.code for name, why in read_recording(tmp_path / "r.mat").left_out}
        assert told == {"c": LeftOut.CELLS, "s": LeftOut.SPARSE, "z": LeftOut.COMPLEX}

    @pytest.mark.parametrize(
        ("of_class", "way"),
        [
            (
                "timetable",
                "is a timetable; in MATLAB: t = seconds(x.Properties.RowTimes - x.Properties.RowTimes(1)); y = ",
            ),
            ("duration", "is a duration; in MATLAB: x = seconds(x); save('record.mat', 'x')"),
            ("mine", "is an object of class 'mine'; save its contents as vectors"),
        ],
    )
    def test_an_object_is_named_with_the_lines_that_save_its_numbers(
        self, tmp_path: Path, of_class: str, way: str
    ) -> None:
        savemat(tmp_path / "r.mat", {})
        with (tmp_path / "r.mat").open("ab") as file:
            file.write(opaque("x", of_class))
        with pytest.raises(RecordError, match=re.escape(f"contains no real vector: 'x' {way}")):
            read_recording(tmp_path / "r.mat")

    def test_a_timeseries_has_a_way_out(self, tmp_path: Path) -> None:
        def fill(file: Any) -> None:
            file["ts"] = np.zeros((1, 6), np.uint32)
            file["ts"].attrs["MATLAB_class"] = np.bytes_("timeseries")
            file["ts"].attrs["MATLAB_object_decode"] = np.int32(3)

        way = "in MATLAB: t = ts.Time; y = squeeze(ts.Data); save('record.mat', 't', 'y')"
        with pytest.raises(RecordError, match=re.escape(f"'ts' is a timeseries; {way}")):
            plain(tmp_path, fill)


class TestPlainHdf5:
    def test_attributes_state_unit_and_rate(self, tmp_path: Path) -> None:
        def fill(file: Any) -> None:
            run = file.create_group("run")
            run["seat"] = X
            run["seat"].attrs["units"] = "mm"
            run.attrs["sample_rate"] = 10.0
            file["body"] = X
            file["body"].attrs["dt"] = 0.05

        recording = plain(tmp_path, fill)
        assert (recording["run.seat"].unit, recording["run.seat"].rate) == ("mm", 10)
        assert recording["body"].rate == 20

    def test_columns_of_a_table(self, tmp_path: Path) -> None:
        table = np.array(list(zip(T, X, strict=True)), dtype=[("time", "f8"), ("acc", "f8")])
        (channel,) = plain(tmp_path, lambda file: file.create_dataset("tab", data=table)).channels
        assert channel.name == "tab.acc"
        assert channel.timepts.tolist() == T.tolist()
        assert channel.values.tolist() == X.tolist()

    def test_other_files_are_not_opened(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "secret.h5", "w") as other:
            other["x"] = X

        def fill(file: Any) -> None:
            file["here"] = X
            file["Fs"] = 10.0
            file["link"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "/x")
            file["nothing"] = h5py.SoftLink("/nowhere")
            file.create_dataset("outside", (5,), "f8", external=[(str(tmp_path / "raw.bin"), 0, 40)])
            layout = h5py.VirtualLayout(shape=(5,), dtype="f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "x", shape=(5,))
            file.create_virtual_dataset("virtual", layout)

        recording = plain(tmp_path, fill)
        told = {name: why.code for name, why in recording.left_out}
        assert recording.names == ("here",)
        assert told["link"] is LeftOut.OTHER_FILE
        assert told["nothing"] is LeftOut.BROKEN_LINK
        assert told["outside"] is told["virtual"] is LeftOut.OTHER_FILES

    def test_a_group_within_itself_ends(self, tmp_path: Path) -> None:
        def fill(file: Any) -> None:
            file["x"] = X
            file["Fs"] = 10.0
            file.create_group("g")["again"] = file["/"]

        recording = plain(tmp_path, fill)
        assert recording.names == ("x",)
        assert dict(recording.left_out)["g.again"].code is LeftOut.LOOP

    def test_a_matrix_whose_shorter_axis_is_time_is_named(self, tmp_path: Path) -> None:
        def fill(file: Any) -> None:
            file["sample_times"] = LONG
            file["sweeps"] = np.zeros((LONG.size, 1, 60))
            file["note"] = "made by a radar"

        with pytest.raises(RecordError, match="'sweeps' is 20 x 60, with time along the shorter axis"):
            plain(tmp_path, fill)

    def test_a_size_that_nothing_fills_is_told(self, tmp_path: Path) -> None:
        def fill(file: Any) -> None:
            file["x"] = X
            file["Fs"] = 10.0
            file.create_dataset("huge", (1 << 40,), "f8", chunks=(1024,))

        assert dict(plain(tmp_path, fill).left_out)["huge"].code is LeftOut.UNFILLED


class TestOtherWriters:
    """Structures as programs of instruments write them: MATLAB reads the first, and scipy both."""

    def written(self, folder: Path, *changes: tuple[bytes, bytes]) -> Path:
        stream = io.BytesIO()
        content = {"run": {"t": T, "x": X, "flaga": X, "flagb": X}}
        savemat(stream, content)  # type: ignore[arg-type]  # the stubs know paths only
        written = stream.getvalue()
        for old, new in changes:
            assert written.count(old) == 1
            written = written.replace(old, new)
        (folder / "r.mat").write_bytes(written)
        return folder / "r.mat"

    # The tag and the value of the length of the names of fields, which ends the longest one.
    SIGNED, UNSIGNED = struct.pack("<HHI", 5, 4, 6), struct.pack("<HHI", 6, 4, 6)

    def test_a_length_of_names_without_a_sign(self, tmp_path: Path) -> None:
        recording = read_recording(self.written(tmp_path, (self.SIGNED, self.UNSIGNED)))
        assert recording.names == ("run.x", "run.flaga", "run.flagb")
        assert recording["run.x"].values.tolist() == X.tolist()

    def test_a_name_that_occurs_twice_is_numbered(self, tmp_path: Path) -> None:
        recording = read_recording(self.written(tmp_path, (b"flagb", b"flaga")))
        assert recording.names == ("run.x", "run.flaga", "run.flaga (2)")


class TestAnyDamage:
    """Whatever is damaged, it gives a recording or a `RecordError`, and the process goes on."""

    @FUZZ
    @given(data=st.data(), compressed=st.booleans())
    def test_structures_of_v5(self, scratch: Path, data: st.DataObject, compressed: bool) -> None:
        stream = io.BytesIO()
        content = {
            "run": {"t": T, "x": X, "in": {"y": X, "s": "text"}},
            "r": of_structures({"z": [X, X], "n": [1.0, "b"]}),
        }
        savemat(stream, content, do_compression=compressed)  # type: ignore[arg-type]  # the stubs know paths only
        self.recording_or_refusal(scratch / "r.mat", stream.getvalue(), data)

    @settings(FUZZ, max_examples=20)
    @given(data=st.data())
    def test_v73(self, scratch: Path, data: st.DataObject) -> None:
        sound = scratch / "s.mat"
        if not sound.exists():
            written_v73(sound, LAYOUTS["an array of structures"][0] | LAYOUTS["a structure with a rate"][0])
        self.recording_or_refusal(scratch / "r.mat", sound.read_bytes(), data)

    @staticmethod
    def recording_or_refusal(path: Path, content: bytes, data: st.DataObject) -> None:
        damaged = bytearray(content)
        for _ in range(data.draw(st.integers(1, 4))):
            damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
        path.write_bytes(damaged[: data.draw(st.integers(len(damaged) // 2, len(damaged)))])
        try:
            channels, message = read_recording(path, fs=100.0).channels, ""
        except RecordError as error:
            channels, message = (), str(error)
        assert message.isprintable()
        assert all(channel.values.size == channel.timepts.size for channel in channels)


def test_a_missing_library_is_named_with_the_line_that_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file["x"] = X
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(RecordError, match=r"r\.h5: .*pip install 'h5py[<>=.,\d]+'"):
        read_recording(tmp_path / "r.h5")
    assert os.listdir(tmp_path) == ["r.h5"]
