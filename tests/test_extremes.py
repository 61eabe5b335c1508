"""Numbers of any size and files of any damage end in an answer or in one line."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from suspid import (
    InputError,
    ModalSet,
    RecordError,
    Suspension,
    analyse,
    as_record,
    clean,
    cwt,
    denoise,
    eigenmodes,
    find_decays,
    free_decay,
    grip,
    identify,
    quarter_car,
    read_record,
    ride,
)
from suspid.identification import modes_from_dict, modes_to_dict, read_modes
from suspid.model import check_definite
from validation.fuzz import counted, files_of_cars, files_of_modes, outcome, use_car, use_modes

FS = 100.0
TIME = np.arange(300) / FS
MOTION = np.exp(-TIME) * np.sin(40 * TIME) + 1e-3 * np.random.default_rng(1).standard_normal(TIME.size)
SIZES = (5e-324, 1e-320, 1e-300, 1e-150, 1e150, 1e300)


def car(**changed: float) -> Suspension:
    usual = {
        "chassis_mass": 400, "tire_mass": 40, "chassis_stiffness": 20e3, "tire_stiffness": 200e3,
        "chassis_damping": 1500, "tire_damping": 50,
    }  # fmt: skip
    return quarter_car(**{**usual, **changed})


@pytest.mark.parametrize("verb", [identify, find_decays, denoise, analyse, cwt])
@pytest.mark.parametrize("scale", [1e-320, 1e-150, 1e150, 1e300])
def test_samples_of_any_size(verb: Callable[[object], object], scale: float) -> None:
    """The error says which channel, how large, and where; half of it is a shift of the record."""
    with pytest.raises(RecordError, match=r"'y\[1\]' reaches .* change the unit"):
        verb(as_record(np.array([MOTION, scale * MOTION]), fs=FS))
    spiked = MOTION.copy()
    spiked[50] = 1e160
    with pytest.raises(RecordError, match=r"reaches 1e\+160 at t = 0.5 s"):
        verb(as_record(spiked, fs=FS))


def test_ridge_of_tiny_samples() -> None:
    with pytest.raises(RecordError, match="reaches"):
        identify(as_record(1e-300 * MOTION, fs=FS), method="ridge")


@pytest.mark.parametrize("scale", [1e-20, 1e20])
def test_modes_do_not_depend_on_the_unit(scale: float) -> None:
    usual, scaled = (identify(as_record(s * MOTION, fs=FS)).modes for s in (1.0, scale))
    assert scaled.poles == pytest.approx(usual.poles, rel=1e-6)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", ["chassis_mass", "tire_mass", "chassis_stiffness", "tire_damping"])
def test_cars_of_any_size(name: str, size: float) -> None:
    def made_and_used(use: Callable[[Suspension], object], name: str, size: float) -> object:
        return use(car(**{name: size}))

    uses: tuple[Callable[[Suspension], object], ...] = (
        eigenmodes,
        lambda one: free_decay(one, TIME, initial_state={"v_tire": 1.0}),
        grip,
        lambda one: ride(one, road="C", speed=20),
    )
    for use in uses:
        assert outcome(partial(made_and_used, use, name, size)) in ("answer", "refused")


@pytest.mark.parametrize("mass", [5e-324, 1e-300, 1e300, math.nan, 10**400])
def test_masses_that_are_none_are_named(mass: float) -> None:
    with pytest.raises(InputError, match=r"mass '?chassis|chassis_mass"):
        car(chassis_mass=mass)


class TestCovariance:
    def modes(self) -> ModalSet:
        return ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2], wn_std=[0.1, 0.5], zeta_std=[0.01, 0.01])

    def test_an_indefinite_one_in_a_file_is_refused(self, tmp_path: Path) -> None:
        content = modes_to_dict(self.modes())
        covariance = np.array(content["covariance"])
        covariance[0, 2] = covariance[2, 0] = 2 * np.sqrt(covariance[0, 0] * covariance[2, 2])
        (tmp_path / "modes.json").write_text(json.dumps({**content, "covariance": covariance.tolist()}))
        with pytest.raises(InputError, match=r"modes\.json: .*not positive semidefinite: a correlation in it is 2"):
            read_modes(tmp_path / "modes.json")

    def test_three_variables_whose_pairs_are_possible(self) -> None:
        """Correlations of -0.9 between each of three: their sum would have a variance of 3 - 6 x 0.9."""
        with pytest.raises(InputError, match="eigenvalue -0.8"):
            check_definite(np.where(np.eye(3) > 0, 1.0, -0.9))

    @pytest.mark.parametrize("seed", range(5))
    def test_any_of_samples_is_accepted_whatever_the_units(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        samples = rng.standard_normal((3, 8)) * 10.0 ** rng.uniform(-6, 6, 8)
        check_definite(samples.T @ samples)

    def test_digits_of_a_file_do_not_make_it_indefinite(self) -> None:
        content = modes_to_dict(self.modes())
        rounded = [[float(f"{x:.8g}") for x in row] for row in np.array(content["covariance"]).tolist()]
        assert modes_from_dict({**content, "covariance": rounded}).covariance is not None


def test_mutated_files_end_in_an_answer_or_a_line() -> None:
    """Few of the files that ``python -m validation fuzz`` makes."""
    found = counted(files_of_modes(), use_modes, 80) + counted(files_of_cars(), use_car, 160)
    assert set(found) == {"answer", "refused"}
    # Sound files are accepted: what is refused is refused for its damage.
    assert found["answer"] > 20


def test_sound_files_are_answered(tmp_path: Path) -> None:
    for kind, use in ((files_of_modes(), use_modes), (files_of_cars(), use_car)):
        for k, (suffix, text) in enumerate(kind):
            path = tmp_path / f"file{suffix}"
            path.write_text(text)
            assert outcome(partial(use, path, k)) == "answer"


def test_a_record_of_the_smallest_size_has_a_residual() -> None:
    found = identify(as_record(1e-29 * MOTION, fs=FS))
    assert "Hz" in str(found)
    with pytest.raises(RecordError, match="used from 1e-30"):
        as_record(1e-31 * MOTION, fs=FS)


@pytest.mark.parametrize("band_hz", [(1.0, 1e308), (1.0, np.nan), ("a", 1.0), (1.0,), 5.0, (1.0, 2.0, 3.0)])
def test_a_band_of_no_frequencies(band_hz: Any) -> None:
    with pytest.raises(InputError, match="two frequencies in Hz"):
        identify(as_record(MOTION, fs=FS), band_hz=band_hz)


@pytest.mark.parametrize("wrong", [{"channels": []}, {"channels": [1]}, {"channels": 5}, {"time": 5}, {"time": []}])
def test_names_that_are_none(wrong: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "bump.csv"
    path.write_text("time,seat\n0,0\n0.01,1\n0.02,0\n")
    with pytest.raises(RecordError, match="bump.csv: (channels|time)="):
        read_record(path, **wrong)


def test_a_verdict_as_a_dictionary() -> None:
    verdict = identify(as_record(MOTION, fs=FS)).verdict
    assert dataclasses.asdict(verdict)["headline"]["numbers"] == verdict.headline.numbers


def test_a_record_needs_no_cleaning() -> None:
    with pytest.raises(RecordError, match="clean takes a recording"):
        clean(as_record(MOTION, fs=FS))
