"""Modes in files: what was written is read again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from suspid import InputError, ModalSet, eigenmodes, quarter_car, read_modes, write_modes


def test_every_bit_comes_back(tmp_path: Path) -> None:
    car = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    )
    exact = eigenmodes(car)
    modes = ModalSet(
        poles=exact.poles, shapes=exact.shapes, channels=exact.channels, covariance=np.diag([1e-4, 2e-4, 3e-4, 0.1 / 3])
    )
    write_modes(modes, tmp_path / "modes.json")
    again = read_modes(tmp_path / "modes.json")
    assert np.array_equal(again.poles, modes.poles)
    assert again.shapes is not None
    assert modes.shapes is not None
    assert np.array_equal(again.shapes, modes.shapes)
    assert again.channels == modes.channels
    assert again.covariance is not None
    assert modes.covariance is not None
    assert np.array_equal(again.covariance, modes.covariance)


def test_modes_are_not_written_as_toml(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"written as JSON; name the file .json"):
        write_modes(ModalSet.from_wn_zeta([10.0], [0.6]), tmp_path / "modes.toml")
    assert not list(tmp_path.iterdir())
