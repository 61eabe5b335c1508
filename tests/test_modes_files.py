"""Modes in files: what was written is read again."""

from __future__ import annotations

import json
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


def test_standard_deviations_are_those_of_each_mode(tmp_path: Path) -> None:
    """A file that others wrote has no covariance: modes do not vary together, nor wn with zeta."""
    rows = [
        {"wn_rad_per_s": 10.0, "zeta": 0.1, "wn_std_rad_per_s": 0.02, "zeta_std": 0.003},
        {"wn_rad_per_s": 60.0, "zeta": 0.3, "wn_std_rad_per_s": 0.5, "zeta_std": 0.01},
    ]
    (tmp_path / "modes.json").write_text(json.dumps({"modes": rows}))
    modes = read_modes(tmp_path / "modes.json")
    for values, key in zip((modes.wn, modes.zeta, modes.wn_std, modes.zeta_std), rows[0], strict=True):
        assert values is not None
        assert np.allclose(values, [row[key] for row in rows], rtol=1e-12)
    assert modes.covariance is not None
    assert not np.any(modes.covariance[:2, 2:])
    assert np.allclose(modes.covariance, modes.covariance.T, rtol=1e-12)


def test_modes_of_a_newer_version_say_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "modes.json"
    path.write_text('{"format": "suspid modes 2", "modes": []}')
    with pytest.raises(InputError, match="'suspid modes 2' is not known.*update suspid, or write the modes again"):
        read_modes(path)
