"""Universal files: time histories, clocks and units come back, and damage is refused."""

from __future__ import annotations

import contextlib
import gc
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from suspid import SuspidError
from suspid.errors import RecordError
from suspid.io.uff import read_uff
from suspid.units import RealArray

FUZZ = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "pyuff_uff58_mps"
BLANK = " " * 74
# Codes of data set 164 with the units of length in a metre and of force in a newton, as the standard gives them.
SYSTEMS = [
    (1, 1.0, 1.0),
    (2, 3.28084, 0.224809),
    (3, 1.0, 0.101972),
    (4, 3.28084, 7.23301),
    (5, 1000.0, 1000.0),
    (6, 100.0, 100.0),
    (7, 39.3701, 0.224809),
    (8, 1000.0, 0.101972),
]
# In SI.
LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 1e-3, "ft": 0.3048, "in": 0.0254}
FORCES = {"N": 1.0, "cN": 0.01, "mN": 1e-3, "lbf": 4.4482216, "kgf": 9.80665, "pdl": 0.138254954}


def dataset(values: Sequence[float] | Sequence[complex] | RealArray, **fields: Any) -> dict[str, Any]:
    step = fields.pop("step", 0.25)
    plain = {
        "func_type": 1,
        "rsp_node": 1,
        "rsp_dir": 3,
        "ref_dir": 0,
        "ref_node": 0,
        "data": np.array(values),
        "x": np.arange(len(values)) * step,
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": 17,
        "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 0,
        "binary": 0,
    }
    return {"type": 58, **plain, **fields}


def put(folder: Path, *sets: dict[str, Any], force_double: bool = True) -> Path:
    path = folder / "a.uff"
    path.unlink(missing_ok=True)
    with warnings.catch_warnings():
        # The writer leaves files open.
        warnings.simplefilter("ignore", ResourceWarning)
        pyuff.UFF(str(path)).write_sets([dict(s) for s in sets], mode="add", force_double=force_double)
        gc.collect(0)
    return path


def ascii_set(*, rows: Sequence[str], samples: int, kind: int = 2, even: int = 1, step: float = 0.25) -> str:
    """One data set 58 as the standard lays it out, with unpadded lines of data."""
    axis = f"{17:10d}{0:5d}{0:5d}{0:5d} {'Time':<20} {'s':<20}"
    ordinate = f"{8:10d}{0:5d}{0:5d}{0:5d} {'Travel':<20} {'mm':<20}"
    none = f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}"
    head = [
        f"    -1{BLANK}",
        f"    58{BLANK}",
        *["NONE"] * 5,
        f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{7:10d}{-2:4d} {'NONE':<10}{0:10d}{0:4d}",
        f"{kind:10d}{samples:10d}{even:10d}{0.0:13.5E}{step if even else 0.0:13.5E}{0.0:13.5E}",
        axis,
        ordinate,
        none,
        none,
    ]
    return "\n".join([*head, *rows, f"    -1{BLANK}", ""])


class TestNumbersComeBack:
    def test_of_a_binary_file_to_the_last_bit(self, tmp_path: Path) -> None:
        values = np.random.default_rng(0).normal(size=(2, 101))
        path = put(tmp_path, dataset(values[0], binary=1), dataset(values[1], binary=1, rsp_node=2))
        table = read_uff(path)
        assert table.sizes == {"1+Z": 101, "2+Z": 101}
        second, first = table.columns(["2+Z", "1+Z"])
        assert np.array_equal(first, values[0])
        assert np.array_equal(second, values[1])
        assert not first.flags.writeable

    @pytest.mark.parametrize("size", [2, 4, 5, 13])
    def test_of_an_ascii_file_to_its_digits(self, tmp_path: Path, size: int) -> None:
        values = np.random.default_rng(1).normal(size=size)
        (double,) = read_uff(put(tmp_path, dataset(values))).columns(["1+Z"])
        assert np.array_equal(double, [float(f"{v:.11e}") for v in values])
        path = put(tmp_path, dataset(values, ord_data_type=2), force_double=False)
        (single,) = read_uff(path).columns(["1+Z"])
        assert np.array_equal(single, [float(f"{v:.5e}") for v in values])

    def test_of_lines_as_the_standard_lays_them_out(self, tmp_path: Path) -> None:
        rows = ["".join(f"{v:13.5E}" for v in (1, -2.5, 3, 4, 5, 6)), f"{-7.25:13.5E}"]
        (tmp_path / "a.uff").write_text(ascii_set(rows=rows, samples=7))
        table = read_uff(tmp_path / "a.uff")
        assert table.columns(["7-Y"])[0].tolist() == [1, -2.5, 3, 4, 5, 6, -7.25]
        assert table.units == {"7-Y": "mm"}
        assert table.clocks["7-Y"].rate == 4.0

    @pytest.mark.parametrize(("binary", "digits"), [(0, 5), (1, 17)])
    def test_of_uneven_stamps(self, tmp_path: Path, binary: int, digits: int) -> None:
        stamps, values = np.array([0.0, 0.1, 0.35, 0.7, 1.11]), np.array([1.0, 2, 3, 4, 5])
        sets = [dataset(values, x=stamps, abscissa_spacing=0, binary=binary, rsp_node=n) for n in (1, 2)]
        table = read_uff(put(tmp_path, *sets))
        clock = table.clocks["1+Z"]
        assert clock.rate is None
        assert clock.stamps is not None
        assert np.array_equal(clock.stamps(), [float(f"{t:.{digits}e}") for t in stamps])
        assert clock is table.clocks["2+Z"]
        assert [c.tolist() for c in table.columns(["2+Z"])] == [values.tolist()]


class TestClocks:
    def test_those_of_one_step_are_one(self, tmp_path: Path) -> None:
        sets = [dataset([1.0, 2, 3], rsp_node=1), dataset([1.0, 2], rsp_node=2), dataset([1.0, 2], rsp_node=3, step=1)]
        clocks = read_uff(put(tmp_path, *sets)).clocks
        assert clocks["1+Z"] is clocks["2+Z"]
        assert (clocks["1+Z"].rate, clocks["3+Z"].rate) == (4.0, 1.0)

    def test_milliseconds_are_obeyed(self, tmp_path: Path) -> None:
        x = np.array([500.0, 502.0, 504.0])
        sets = [dataset([1.0, 2, 3], x=x, abscissa_axis_units_lab="ms", abscissa_spacing=even) for even in (0, 1)]
        uneven, even = read_uff(put(tmp_path, *sets)).clocks.values()
        assert (even.start, even.rate) == (0.5, 500.0)
        assert uneven.stamps is not None
        assert uneven.stamps().tolist() == [0.5, 0.502, 0.504]


class TestNames:
    def test_node_and_direction(self, tmp_path: Path) -> None:
        points = [(12, 3), (12, -1), (4, 5), (4, 0)]
        sets = [dataset([1.0, 2], rsp_node=n, rsp_dir=d) for n, d in points]
        assert list(read_uff(put(tmp_path, *sets)).sizes) == ["12+Z", "12-X", "4+RY", "4"]

    def test_without_a_node_the_label_or_the_text(self, tmp_path: Path) -> None:
        bare = {"rsp_node": 0, "rsp_dir": 0}
        sets = [
            dataset([1.0, 2], **bare, ordinate_axis_lab="seat", id1="run"),
            dataset([1.0, 2], **bare, id1="chassis"),
            dataset([1.0, 2], **bare),
            dataset([1.0, 2], rsp_ent_name="car", rsp_node=3),
        ]
        assert list(read_uff(put(tmp_path, *sets)).sizes) == ["seat", "chassis", "data set 3", "car 3+Z"]

    def test_that_come_again_are_told_apart(self, tmp_path: Path) -> None:
        sets = [dataset([k, 0.0], id1=text) for k, text in enumerate(["a", "b", "b", "b"])]
        table = read_uff(put(tmp_path, *sets[:3]))
        assert list(table.sizes) == ["1+Z", "1+Z (b)", "1+Z (data set 3)"]
        assert [c[0] for c in table.columns(list(table.sizes))] == [0.0, 1.0, 2.0]


class TestUnits:
    def test_the_label_goes_first(self, tmp_path: Path) -> None:
        sets = [dataset([1.0, 2], ordinate_axis_units_lab="g"), dataset([1.0, 2], rsp_node=2)]
        assert read_uff(put(tmp_path, *sets)).units == {"1+Z": "g"}

    @pytest.mark.parametrize(("code", "unit"), [(1, "m/s^2"), (7, "in/s^2"), (9, "")])
    def test_else_they_follow_from_data_set_164(self, tmp_path: Path, code: int, unit: str) -> None:
        system = pyuff.prepare_164(
            units_code=code, units_description="", temp_mode=1, length=1.0, force=1.0, temp=1.0, temp_offset=0.0
        )
        table = read_uff(put(tmp_path, system, dataset([1.0, 2])))
        assert table.units == ({"1+Z": unit} if unit else {})

    @pytest.mark.parametrize(("code", "length", "force"), SYSTEMS)
    def test_a_system_has_as_many_of_its_units_in_one_of_si_as_its_data_set_states(
        self, tmp_path: Path, code: int, length: float, force: float
    ) -> None:
        system = pyuff.prepare_164(
            units_code=code, units_description="", temp_mode=1, length=length, force=force, temp=1.0, temp_offset=0.0
        )
        sets = [dataset([1.0, 2], rsp_node=k, ordinate_spec_data_type=kind) for k, kind in ((1, 12), (2, 13), (3, 8))]
        units = read_uff(put(tmp_path, system, *sets)).units
        # The factors of the standard have six digits.
        assert length * LENGTHS[units["1+Z"].removesuffix("/s^2")] == pytest.approx(1.0, rel=1e-5)
        assert length * LENGTHS[units["3+Z"]] == pytest.approx(1.0, rel=1e-5)
        assert force * FORCES[units["2+Z"]] == pytest.approx(1.0, rel=1e-5)

    def test_the_title_is_that_of_data_set_151(self, tmp_path: Path) -> None:
        head = pyuff.prepare_151(
            model_name="Car 7",
            description="",
            db_app="",
            date_db_created="",
            time_db_created="",
            version_db1=0,
            version_db2=0,
            file_type=0,
            date_db_saved="",
            time_db_saved="",
            program="",
            date_db_written="",
            time_db_written="",
        )
        assert read_uff(put(tmp_path, head, dataset([1.0, 2]))).title == "Car 7"


class TestLeftOut:
    def test_with_the_reason(self, tmp_path: Path) -> None:
        sets = [
            dataset([1.0, 2]),
            dataset([1.0 + 1j, 2], func_type=4, abscissa_spec_data_type=18, rsp_node=2),
            dataset([1.0, 2], func_type=9, abscissa_spec_data_type=18, rsp_node=3),
            dataset([1.0, 2], func_type=0, abscissa_spec_data_type=19, rsp_node=4),
            dataset([1.0, 2], abscissa_axis_units_lab="rev", rsp_node=5),
        ]
        table = read_uff(put(tmp_path, *sets))
        assert list(table.sizes) == ["1+Z"]
        assert {name: str(why) for name, why in table.unusable.items()} == {
            "2+Z": "is complex (a frequency response); a record is real",
            "3+Z": "is a power spectral density, not a time history",
            "4+Z": "is not sampled over time (abscissa type 19)",
            "5+Z": "has its time in 'rev'; known: s, ms, us, ns, min, h, days",
        }

    def test_all_of_it_is_an_error(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="contains no time history: '1\\+Z' is a spectrum|a frequency response"):
            read_uff(put(tmp_path, dataset([1.0, 2], func_type=4, abscissa_spec_data_type=18)))


@pytest.mark.skipif(not DATA.is_dir(), reason="needs the shared data")
class TestRecordsOfOthers:
    def test_the_machine(self) -> None:
        table = read_uff(next(DATA.glob("MPSTD*.uff")))
        assert list(table.sizes.values()) == [222400] * 4
        assert list(table.sizes) == ["1+Z", "2+Z", "3+Z", "1+Z (MPS set1 Dof4)"]
        assert {clock.rate for clock in table.clocks.values()} == {3200.0}
        assert set(table.units.values()) == {"m/s2"}
        for values in table.columns(list(table.sizes)):
            # The rotating line that every channel has; one bin of the periodogram is 3200 / 222400 Hz wide.
            power = np.abs(np.fft.rfft(values - values.mean())) ** 2
            line = np.fft.rfftfreq(values.size, 1 / 3200)
            near = (line > 150) & (line < 220)
            assert line[near][np.argmax(power[near])] == pytest.approx(181.74, abs=0.1)

    def test_a_last_line_that_is_not_full(self) -> None:
        table = read_uff(DATA / "time-history-not-all-columns-filled.uff")
        (values,) = table.columns(["1x"])
        assert values.tolist()[:2] == [-3.81956, -3.56616]
        assert values.tolist()[-2:] == [-3.46046, -5.84096]
        assert (values.size, table.clocks["1x"].rate, table.units["1x"]) == (13, 20000.0, "m/s²")


@pytest.fixture(scope="module", params=[0, 1], ids=["ascii", "binary"])
def content(scratch: Path, request: pytest.FixtureRequest) -> bytes:
    values = np.random.default_rng(3).normal(size=(2, 30))
    sets = [dataset(values[k], binary=request.param, rsp_node=k + 1) for k in range(2)]
    return put(scratch, *sets).read_bytes()


class TestDamage:
    def test_every_truncation_is_refused_or_ends_a_data_set(self, tmp_path: Path, content: bytes) -> None:
        (tmp_path / "b.uff").write_bytes(content)
        whole = read_uff(tmp_path / "b.uff")
        first = content.index(b"    -1\n", 10) + 6
        for length in range(0, len(content) - 1, 5):
            (tmp_path / "b.uff").write_bytes(content[:length])
            with contextlib.suppress(RecordError):
                table = read_uff(tmp_path / "b.uff")
                # Blanks may follow.
                assert first <= length <= first + 5, length
                assert np.array_equal(table.columns(["1+Z"]), whole.columns(["1+Z"]))

    @FUZZ
    @given(data=st.data(), byte=st.integers(0, 255))
    def test_a_flipped_byte(self, scratch: Path, content: bytes, data: st.DataObject, byte: int) -> None:
        flipped = bytearray(content)
        flipped[data.draw(st.integers(0, len(content) - 1))] = byte
        (scratch / "b.uff").write_bytes(flipped)
        with contextlib.suppress(SuspidError):
            table = read_uff(scratch / "b.uff")
            assert set(table.sizes.values()) == {30}

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"samples": 8}, "states 8 samples and contains 7"),
            ({"samples": 6}, "states 6 samples and contains 7"),
            ({"step": 0.0}, "steps by 0 s"),
        ],
    )
    def test_a_head_that_is_at_odds_with_the_data(self, tmp_path: Path, change: dict[str, Any], message: str) -> None:
        rows = ["".join(f"{v:13.5E}" for v in range(6)), f"{7:13.5E}"]
        (tmp_path / "a.uff").write_text(ascii_set(**{"rows": rows, "samples": 7, **change}))
        with pytest.raises(RecordError, match=message):
            read_uff(tmp_path / "a.uff")

    def test_a_cell_that_is_no_number(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        (tmp_path / "a.uff").write_text(ascii_set(rows=[f"{'seat':>13}"], samples=1))
        with pytest.raises(RecordError, match="is damaged"):
            read_uff(tmp_path / "a.uff")
        assert capsys.readouterr() == ("", "")

    def test_another_kind(self, tmp_path: Path) -> None:
        (tmp_path / "a.uff").write_bytes(b"time,x\n0,1\n1,2\n")
        with pytest.raises(RecordError, match="is not a universal file"):
            read_uff(tmp_path / "a.uff")

    def test_a_missing_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        path = put(tmp_path, dataset([1.0, 2]))
        monkeypatch.setitem(sys.modules, "pyuff", None)
        with pytest.raises(RecordError, match=r"^reading .uff needs pyuff: pip install 'pyuff[<>=.,\d]+'$"):
            read_uff(path)
