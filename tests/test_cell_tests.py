"""Cell arrays of MATLAB that hold a test a cell, beside those of their times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.io
from numpy.typing import NDArray

from suspid import read_recording
from suspid.io.cell_tests import with_paired_cells
from suspid.io.labels import Value, Variable


def cells(*arrays: NDArray[np.float64]) -> NDArray[np.object_]:
    out = np.empty((len(arrays), 1), object)
    out[:, 0] = arrays
    return out


def times(*counts: int) -> NDArray[np.object_]:
    return cells(*(np.arange(count)[:, None] / 100 + 3 * k for k, count in enumerate(counts)))


def matrices(*counts: int) -> NDArray[np.object_]:
    return cells(*(np.sin(np.arange(2 * count).reshape(2, count) + k) for k, count in enumerate(counts)))


def variable(size: int) -> Variable:
    return Variable(shape=(size, 1), read=lambda: np.zeros((size, 1)))


def numbered(*cells: Variable) -> dict[str, Variable]:
    return {f"[{k + 1}]": cell for k, cell in enumerate(cells)}


class TestPairedCells:
    def test_each_is_a_test_with_its_own_time(self, tmp_path: Path) -> None:
        held = {
            "T_id": times(90, 80, 70),
            "Y_id": matrices(90, 80, 70),
            "T_vad": times(60, 50),
            "Y_vad": matrices(60, 50),
        }
        scipy.io.savemat(tmp_path / "t.mat", held)
        found = read_recording(tmp_path / "t.mat")
        assert found.tests == ("Y_id[1]", "Y_id[2]", "Y_id[3]", "Y_vad[1]", "Y_vad[2]")
        assert found.of_test("Y_id[2]").names == ("Y_id[2].data[1]", "Y_id[2].data[2]")
        second = found["Y_id[2].data[1]"]
        np.testing.assert_allclose(second.timepts, 3 + np.arange(80) / 100, atol=1e-12)
        np.testing.assert_allclose(second.values, np.sin(np.arange(80) + 1), atol=1e-12)

    def test_several_arrays_share_a_time(self, tmp_path: Path) -> None:
        held = {"time": times(90, 80), "front": matrices(90, 80), "rear": matrices(90, 80)}
        scipy.io.savemat(tmp_path / "t.mat", held)
        found = read_recording(tmp_path / "t.mat")
        assert found.tests == ("time[1]", "time[2]")
        assert found.of_test("time[1]").names == tuple(
            f"time[1].{name}[{k}]" for name in ("front", "rear") for k in (1, 2)
        )

    def test_the_name_of_the_time_states_its_unit(self, tmp_path: Path) -> None:
        stamps = cells(*(1e3 * each for each in times(90, 80).ravel()))
        scipy.io.savemat(tmp_path / "t.mat", {"Time_ms": stamps, "Y": matrices(90, 80)})
        found = read_recording(tmp_path / "t.mat")
        np.testing.assert_allclose(found["Y[2].data[1]"].timepts, 3 + np.arange(80) / 100, atol=1e-9)

    def test_times_as_long_as_there_are_channels_are_none(self) -> None:
        wide = Variable(shape=(600, 2), read=lambda: np.zeros((600, 2)))
        group = {"run_time": numbered(variable(2), variable(2)), "Y": numbered(wide, wide)}
        assert with_paired_cells(group) == group

    def test_what_fits_two_times_stays_as_it_is(self) -> None:
        one = variable(90)
        group = {"t_1": numbered(one, one), "t_2": numbered(one, one), "y": numbered(one, one)}
        assert with_paired_cells(group) == group

    def test_so_does_what_is_longer_than_its_time(self) -> None:
        group = {"t": numbered(variable(90), variable(80)), "y": numbered(variable(91), variable(80))}
        assert with_paired_cells(group) == group

    def test_so_do_other_cells_beside_those_that_fit(self) -> None:
        fit = numbered(variable(90), variable(80))
        group: dict[str, Value] = {"gains": numbered(variable(3), variable(3)), "rate": variable(2), "t": fit, "y": fit}
        assert list(with_paired_cells(group)) == ["gains", "rate", "y[1]", "y[2]"]
