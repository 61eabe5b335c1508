"""The command `compare`: two estimates or two sets of modes, its files and refusals."""

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import ModalSet, add_noise, estimate, free_decay, quarter_car
from suspid.cli.main import main
from suspid.identification import modes_to_dict, to_json
from suspid.reporting import estimate_to_dict, json_schema

NEW = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with estimates of a new car and of a worn one, and their modes."""
    folder = tmp_path_factory.mktemp("compare")
    for name, damping in (("new", 1300), ("worn", 800)):
        car = NEW.with_parameters(damping={"chassis": damping})
        decay = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
        found = estimate(add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1)), NEW, fixed=["tire.damping"])
        (folder / f"{name}.json").write_text(to_json(estimate_to_dict(found)), encoding="utf-8")
        (folder / f"{name}_modes.json").write_text(to_json(modes_to_dict(found.modes)), encoding="utf-8")
    return folder


def test_wear_from_two_estimates(files: Path, tmp_path: Path) -> None:
    result = run("compare", files / "new.json", files / "worn.json", "--json", tmp_path / "c.json", "--plot",
                 tmp_path / "g.png", "--nominal-std", 0.05)  # fmt: skip
    assert result.exit_code == 0, result.output
    assert "chassis worn" in result.output
    assert (tmp_path / "g.png").stat().st_size > 10_000
    content = json.loads((tmp_path / "c.json").read_text())
    jsonschema.validate(content, json_schema("compare"))
    (damper,) = content["dampers"]
    assert (damper["verdict"], damper["wheel"]) == ("worn", "tire")
    assert damper["loss"] == pytest.approx(1 - 800 / 1300, abs=0.02)
    assert damper["loss_lower"] < 1 - 800 / 1300 < damper["loss_upper"]


def test_the_same_estimate_twice_is_good(files: Path) -> None:
    assert "chassis good" in run("compare", files / "new.json", files / "new.json").output


def test_a_history(files: Path) -> None:
    result = run("compare", *[files / "new.json"] * 6, files / "worn.json")
    assert "chassis worn" in result.output
    assert "as these among themselves" in result.output
    assert run("compare", *[files / "new_modes.json"] * 2, files / "worn_modes.json").exit_code == 2


def test_the_scatter_of_drives_decides(files: Path) -> None:
    result = run("compare", files / "new.json", files / "worn.json", "--damper-std", 0.15)
    assert "chassis worn" not in result.output
    assert "dampers differ by 15%" in result.output


def test_modes(files: Path, tmp_path: Path) -> None:
    result = run("compare", files / "new_modes.json", files / "worn_modes.json", "--json", tmp_path / "c.json")
    assert result.exit_code == 0, result.output
    assert re.match(
        r"[1-9]\d* of \d+ values changed \(no change: within the 95 % interval of each difference\)", result.output
    )
    content = json.loads((tmp_path / "c.json").read_text())
    jsonschema.validate(content, json_schema("compare"))
    assert not content["passed"]
    by_hand = tmp_path / "hand.json"
    by_hand.write_text(to_json(modes_to_dict(ModalSet.from_wn_zeta([8.0], [0.3]))), encoding="utf-8")
    assert "new" in run("compare", by_hand, files / "new_modes.json").output
    assert "gone" in run("compare", files / "new_modes.json", by_hand).output
    same = run("compare", files / "new_modes.json", files / "new_modes.json").output
    assert same.startswith("no value changed")
    assert not re.search("pass|fail|expected|found", same)


@pytest.mark.parametrize("option", ["--damper-std", "--load-std", "--nominal-std"])
def test_options_of_springs_and_dampers_are_refused_beside_modes(files: Path, option: str) -> None:
    result = run("compare", files / "new_modes.json", files / "worn_modes.json", option, 0.1)
    assert result.exit_code == 2
    assert option in result.output


def test_refusals(files: Path, tmp_path: Path) -> None:
    mixed = run("compare", files / "new.json", files / "worn_modes.json")
    assert (mixed.exit_code, "results of one kind" in mixed.output) == (1, True)
    assert run("compare", files / "new.json", tmp_path / "none.json").exit_code == 1
    assert run("compare", files / "new.json", files / "worn.json", "--json", files / "new.json").exit_code == 2
    assert not (tmp_path / "g.png").exists()


@pytest.mark.parametrize(("form", "kind"), [("suspid car 1", "a reconstruction"), ("suspid ride 1", "a ride")])
def test_what_is_not_compared_is_named(files: Path, tmp_path: Path, form: str, kind: str) -> None:
    other = tmp_path / "other.json"
    other.write_text(json.dumps({"format": form}), encoding="utf-8")
    mixed = run("compare", other, files / "new.json")
    assert (mixed.exit_code, f"other.json holds {kind} and " in mixed.output) == (1, True)
    both = run("compare", other, other)
    assert both.exit_code == 1
    assert f"each hold {kind}; give results of suspid estimate" in both.output


def test_modes_of_what_is_no_car(files: Path, tmp_path: Path) -> None:
    record = tmp_path / "bump.csv"
    record.write_text("time,seat\n0,1\n1,2\n", encoding="utf-8")
    for file, hint in (
        (files / "new.json", "JSON of `suspid estimate`, whose option -o car.toml writes the car"),
        (files / "new_modes.json", "JSON with modes, which `suspid compare` and `suspid reconstruct` take"),
        (record, "is no description of a car (.toml, as examples/car.toml); `suspid identify` finds the modes of"),
    ):
        refused = run("modes", file)
        assert (refused.exit_code, hint in refused.output) == (1, True), refused.output
