"""The command `compare`: two estimates or two sets of modes, its files and refusals."""

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.figure import Figure

from suspid import (
    InputError,
    ModalSet,
    Strut,
    Suspension,
    add_noise,
    compare,
    eigenmodes,
    estimate,
    free_decay,
    plot_comparison,
    quarter_car,
    reconstruct,
)
from suspid.cli.main import main
from suspid.identification import modes_to_dict, to_json
from suspid.reconstruction import parameters_from_dict, reconstruction_to_dict
from suspid.reporting import estimate_to_dict, json_schema
from suspid.text_tables import TERMINAL

NEW = quarter_car(chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300)

OTHER = Strut(name="other", stiffness=1e3, damping=1.0, arms={"other": 1, "ground": -1})


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


@pytest.fixture(scope="module")
def cars(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with reconstructions of a new car and of a worn one, with and without standard deviations."""
    folder = tmp_path_factory.mktemp("cars")
    for name, damping in (("new", 1300), ("worn", 800)):
        exact = eigenmodes(NEW.with_parameters(damping={"chassis": damping}))
        known = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
        for what, modes in (("", known), ("_exact", exact)):
            found = reconstruct(modes, NEW, fixed=["tire.damping"])
            (folder / f"{name}{what}.json").write_text(to_json(reconstruction_to_dict(found)), encoding="utf-8")
    return folder


class TestReconstructions:
    def test_what_changed_is_named(self, cars: Path, tmp_path: Path) -> None:
        result = run("compare", cars / "new.json", cars / "worn.json", "--json", tmp_path / "c.json", "--plot",
                     tmp_path / "c.png")  # fmt: skip
        assert result.exit_code == 0, result.output
        assert result.output.startswith("1 of 3 values changed")
        content = json.loads((tmp_path / "c.json").read_text())
        jsonschema.validate(content, json_schema("compare"))
        assert [(row["item"], row["quantity"]) for row in content["values"] if row["verdict"] == "off"] == [
            ("chassis", "damping")
        ]
        assert (tmp_path / "c.png").stat().st_size > 10_000

    def test_the_allowed_difference_is_that_of_two_independent_errors(self, cars: Path) -> None:
        one, two = (parameters_from_dict(json.loads((cars / f"{name}.json").read_text())) for name in ("new", "worn"))
        assert one.stds is not None
        assert two.stds is not None
        (row,) = [row for row in compare(two, one).table if row.item == "tire" and row.quantity == "stiffness"]
        expected = 1.959964 * np.hypot(one.stds["tire.stiffness"], two.stds["tire.stiffness"])
        assert row.allowed == pytest.approx(expected, rel=1e-6)

    def test_without_standard_deviations(self, cars: Path) -> None:
        result = run("compare", cars / "new_exact.json", cars / "worn_exact.json", "--plot", cars / "c.png")
        assert "within 1e-09 relative" in result.output

    def test_beside_an_estimate(self, cars: Path, files: Path) -> None:
        assert "no value changed" in run("compare", cars / "new.json", files / "new.json").output
        assert "chassis  damping" in run("compare", files / "new.json", cars / "worn.json").output

    def test_a_damaged_one_is_refused(self, cars: Path, tmp_path: Path) -> None:
        content = json.loads((cars / "new.json").read_text())
        content["parameters"][0]["std"] = -1.0
        (tmp_path / "wrong.json").write_text(json.dumps(content))
        assert "no value with a standard deviation" in run("compare", tmp_path / "wrong.json", cars / "new.json").output
        del content["parameters"][0]["std"]
        (tmp_path / "wrong.json").write_text(json.dumps(content))
        assert "damaged" in run("compare", tmp_path / "wrong.json", cars / "new.json").output
        assert "leave out" in run("compare", cars / "new.json", cars / "new.json", "--load-std", 0.1).output


def test_reports_are_compared_with_their_springs(cars: Path, tmp_path: Path) -> None:
    """The JSON of a report has modes, and springs from the modes or from the record."""
    exact = eigenmodes(NEW)
    modes = modes_to_dict(
        ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
    )
    for name in ("new", "worn"):
        springs = json.loads((cars / f"{name}.json").read_text())
        content = {**modes, "report": 3, "estimate": None, "reconstruction": springs}
        (tmp_path / f"{name}.json").write_text(to_json(content), encoding="utf-8")
    result = run("compare", tmp_path / "new.json", tmp_path / "worn.json", "--json", tmp_path / "c.json")
    assert result.exit_code == 0, result.output
    assert re.search(r"chassis +damping \[N s/m\] .* yes", result.output)
    jsonschema.validate(json.loads((tmp_path / "c.json").read_text()), json_schema("compare"))


def test_results_are_compared_in_python() -> None:
    exact = eigenmodes(NEW)
    modes = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
    found = reconstruct(modes, NEW, fixed=["tire.damping"])
    assert compare(found, NEW).passed
    assert not compare(found, NEW.with_parameters(damping={"chassis": 800})).passed
    assert compare(found, found, rtol=0.0).passed
    assert compare(found, found).to_pandas()["item"].tolist() == ["chassis", "tire", "chassis"]
    assert plot_comparison(found, found, Figure()).axes
    with pytest.raises(InputError, match="rtol by quantity is for modes"):
        compare(found, NEW, rtol={"wn": 0.1})
    with pytest.raises(InputError, match="no parameter was found in both"):
        compare(found, Suspension(masses={"other": 1.0}, struts=(OTHER,)))


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
    measured = tmp_path / "measured.json"
    modes = ModalSet.from_wn_zeta([14.261931], [0.0030972717], wn_std=[0.018], zeta_std=[7e-4])
    measured.write_text(to_json(modes_to_dict(modes)), encoding="utf-8")
    table = run("compare", measured, measured).output.splitlines()[1:5]
    assert table[0].endswith("changed")
    assert max(map(len, table)) <= TERMINAL
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


@pytest.mark.parametrize(("form", "kind"), [("suspid grip 1", "a grip"), ("suspid ride 1", "a ride")])
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
