"""What moved the car, where nobody says it: one decision for `estimate`, `analyse` and the commands."""

from __future__ import annotations

import json
from pathlib import Path

import control
import numpy as np
import pytest
from click.testing import CliRunner, Result
from scipy.integrate import solve_ivp

from suspid import Level, RecordTest, Suspension, analyse, estimate, grip, quarter_car, ride, write_car
from suspid.cli.main import main
from suspid.greybox import estimate_by_cause, likely_causes
from suspid.greybox.problem import Problem
from suspid.greybox.search import search
from suspid.greybox.trials import trials_of
from suspid.reconstruction import unknowns_of
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import EstimateCheck, Note
from suspid.words.grip import GripCheck
from suspid.words.ride import RideCheck

pytestmark = pytest.mark.usefixtures("words_alone")

M, MU, K, C, KT = 330.0, 38.0, 19e3, 1450.0, 185e3
NOMINAL = quarter_car(
    chassis_mass=M, tire_mass=MU, chassis_stiffness=1.4 * K, tire_stiffness=0.75 * KT, chassis_damping=0.7 * C
)
TIMES: RealArray = np.arange(0, 5, 0.005)
FASTER = 4.0  # sweep of the rig [Hz per s]


def motion(road: bool, *, start: tuple[float, float, float, float] = (0, 0, 0, 0)) -> tuple[RealArray, RealArray]:
    """Return displacements of road, wheel and body on a swept road, or after a release, and accelerations of both."""

    def height(t: RealArray | float) -> RealArray:
        return np.asarray(0.004 * np.sin(2 * np.pi * (0.4 * t + FASTER * np.square(t) / 2)) if road else 0.0 * t)

    def rates(t: float, x: RealArray) -> list[float]:
        force = K * (x[1] - x[0]) + C * (x[3] - x[2])
        return [x[2], x[3], force / M, (-force - KT * (x[1] - float(height(t)))) / MU]

    y = solve_ivp(rates, (0, TIMES[-1]), start, t_eval=TIMES, rtol=1e-9, atol=1e-12).y
    force = K * (y[1] - y[0]) + C * (y[3] - y[2])
    h = height(TIMES)
    return np.array([h, y[1], y[0]]), np.array([force / M, (-force - KT * (y[1] - h)) / MU])


def record_of(road: bool, *, seed: int = 1, **options: tuple[float, float, float, float]) -> control.TimeResponseData:
    """Return a logger's record: road and wheel by height, the body by acceleration, all rounded, with offsets."""
    heights, felt = motion(road, **options)
    rng = np.random.default_rng(seed)
    rows = np.array([heights[0], heights[1] + 0.01, felt[0] + 0.3])
    rows[1:] += np.array([[2e-5], [0.02]]) * rng.standard_normal((2, len(TIMES)))
    return as_response(TIMES, np.round(rows, 6), ("road", "tire", "chassis_acceleration"))


def error_of(car: Suspension) -> float:
    """Return the largest relative error of the springs and of the damper."""
    body, tire = car.struts[0], car.struts[1]
    return max(abs(body.stiffness / K - 1), abs(body.damping / C - 1), abs(tire.stiffness / KT - 1))


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of a rig whose body moves less and less, and the nominal car."""
    folder = tmp_path_factory.mktemp("rig")
    write_car(NOMINAL, folder / "car.toml")
    record = record_of(True)
    header = "t [s],road [m],tire [m],chassis_acceleration [m/s2]"
    table = np.column_stack([TIMES, np.asarray(record.y).T])
    np.savetxt(folder / "rig.csv", table, fmt="%.6f", delimiter=",", header=header, comments="")
    return folder


class TestOrder:
    def test_a_road_that_moves_comes_before_a_free_decay(self) -> None:
        assert likely_causes([RecordTest(record=record_of(True))], NOMINAL)[0] == ("road",)

    def test_a_road_that_stands_still_is_no_cause(self) -> None:
        release = RecordTest(record=record_of(False, start=(0.03, 0.01, 0, 0)))
        assert likely_causes([release], NOMINAL) == [(), ("tire",)]

    def test_noise_of_a_road_sensor_is_no_road(self) -> None:
        release = record_of(False, start=(0.03, 0.01, 0, 0))
        rows = np.asarray(release.y).copy()
        rows[0] = 1e-4 * np.random.default_rng(2).standard_normal(len(TIMES))
        noisy = as_response(TIMES, rows, release.output_labels)
        assert likely_causes([RecordTest(record=noisy)], NOMINAL)[0] == ()

    def test_a_road_may_be_an_input(self) -> None:
        record = record_of(True)
        rows = np.asarray(record.y)
        inputs = {"road": rows[0]}
        driven = as_response(TIMES, rows[1:], record.output_labels[1:], inputs=inputs)
        assert likely_causes([RecordTest(record=driven)], NOMINAL)[0] == ("road",)

    def test_a_release_beside_a_rig_is_a_free_decay(self) -> None:
        """Of the release no road was kept, as it stood still."""
        release = record_of(False, start=(0.03, 0.01, 0, 0))
        alone = as_response(TIMES, np.asarray(release.y)[1:], release.output_labels[1:])
        tests = [RecordTest(record=record_of(True)), RecordTest(record=alone)]
        assert likely_causes(tests, NOMINAL)[0] == ("road",)
        found, cause = estimate_by_cause(tests, NOMINAL, options={"fixed": ["tire.damping"]})
        assert (cause, found.causes, found.explains) == (("road",), (("road",), ()), True)
        assert error_of(found.suspension) < 0.02

    def test_of_causes_that_explain_nothing_the_best_is_taken(self) -> None:
        """No car makes what is added to the wheel; under the road little else is left, of a free decay all."""
        record = record_of(True)
        rows = np.asarray(record.y).copy()
        rows[1] += 2e-4 * np.sin(40 * TIMES) * np.sin(TIMES)
        spoilt = RecordTest(record=as_response(TIMES, rows, record.output_labels))
        found, cause = estimate_by_cause([spoilt], NOMINAL, causes=[(), ("road",)], options={"fixed": ["tire.damping"]})
        assert (cause, found.explains) == (("road",), False)
        assert error_of(found.suspension) < 0.05


class TestCommands:
    def test_estimate_and_report_take_the_same_cause(self, rig: Path) -> None:
        files = rig / "rig.csv", "--car", rig / "car.toml"
        one = run("estimate", *files, "--json", rig / "e.json")
        two = run("report", *files, "--json", rig / "r.json", "-o", rig / "r.html", "--road", "C", "--speed", "20")
        assert (one.exit_code, two.exit_code) == (0, 0), one.output + two.output
        for result in (one, two):
            assert "the motion of road was taken as the cause" in result.stderr
        first, second = (json.loads((rig / f"{name}.json").read_text())["parameters"] for name in "er")
        assert {p["name"]: p["value"] for p in first} == {p["name"]: p["value"] for p in second}
        assert "tire.stiffness" in {p["name"] for p in first}

    @pytest.mark.slow
    def test_so_does_analyse(self, rig: Path) -> None:
        found = analyse(rig / "rig.csv", car=NOMINAL)
        assert found.estimate is not None
        assert Note.MOVED in [note.code for note in found.notes]
        assert error_of(found.estimate.suspension) < 0.02


class TestWhatWasNotFound:
    def test_grip_and_ride_of_a_nominal_tire_say_so(self) -> None:
        found = estimate(record_of(True), NOMINAL, given=("tire",))
        tested, driven = grip(found), ride(found, road="C", speed=20.0)
        for verdict, code in ((tested.verdict, GripCheck.STAYED_NOMINAL), (driven.verdict, RideCheck.STAYED_NOMINAL)):
            (check,) = [check for check in verdict.checks if check.remark.code is code]
            assert check.remark.numbers["names"] == ("tire.stiffness",)
            assert verdict.level <= Level.CARE
        stated = grip(found, nominal_std={"tire.stiffness": 0.1})
        assert GripCheck.STAYED_NOMINAL not in [check.remark.code for check in stated.verdict.checks]
        assert stated.phase_std[0] > tested.phase_std[0]

    def test_a_tire_that_was_found_is_none(self) -> None:
        found = estimate(record_of(True), NOMINAL, given=("road",), fixed=["tire.damping"])
        assert GripCheck.STAYED_NOMINAL not in [check.remark.code for check in grip(found).verdict.checks]


class TestResidual:
    @pytest.mark.parametrize(("size", "code"), [(1e-5, "nearly exact"), (1e-2, "unexplained")])
    def test_what_no_sensor_resolves_says_nothing_against_a_car(self, size: float, code: str) -> None:
        heights, _ = motion(False, start=(0.03, 0.01, 0, 0))
        rows = heights[1:] + size * np.std(heights[1:], axis=1, keepdims=True) * np.sin(30 * TIMES)
        found = estimate(as_response(TIMES, rows, ("tire", "chassis")), NOMINAL, fixed=["tire.damping"])
        assert found.explains is (code == "nearly exact")
        assert EstimateCheck(code) in [check.remark.code for check in found.verdict.checks]

    def test_motion_that_is_no_decay_ends_the_search_early(self) -> None:
        """A swept road that nobody recorded: what no start explains needs no rounds of noise levels."""
        heights, felt = motion(True)
        rows = np.vstack([heights[1:], felt])
        names = ("tire", "chassis", "chassis_acceleration", "tire_acceleration")
        (trial,) = trials_of(as_response(TIMES, rows, names), NOMINAL, ())
        unknowns = unknowns_of(NOMINAL, rate=60.0, fixed=["tire.damping"])
        best, ends = search(Problem(trials=(trial,), holds=("cubic",), unknowns=unknowns))
        assert best.lost
        assert len(ends) == 2


def test_a_decay_within_a_record_that_swells_is_looked_for_at_last(monkeypatch: pytest.MonkeyPatch) -> None:
    # Accelerations on a swept rig whose road was not recorded: the body's dies down, the wheel's swells.
    heights, felt = motion(True)
    swelling = as_response(TIMES, np.array([heights[2], felt[1]]), ("chassis", "tire_acceleration"))
    test = [RecordTest(record=swelling)]
    assert likely_causes(test, NOMINAL) == [(), ("tire",)]

    def searched(_: object) -> None:
        raise AssertionError("the search of decays takes longer than all else")

    monkeypatch.setattr("suspid.greybox.fitted_in_time.from_onset", searched)
    found, cause = estimate_by_cause(test, NOMINAL, options={"fixed": ["tire.damping"]})
    assert cause == ("tire",)
    assert found.explains
    assert found.suspension.struts[0].stiffness == pytest.approx(K, rel=1e-3)


def test_a_decay_of_the_body_alone_is_found_behind_a_rest_that_determines_nothing() -> None:
    """From its first sample on, at rest and then let go, the record determines no damper."""
    _, felt = motion(False, start=(0.05, 0.05, 0, 0))
    rest = 600
    times: RealArray = np.arange(rest + len(TIMES), dtype=float) * 0.005
    values = np.append(np.zeros(rest), felt[0]) + 0.02 * np.random.default_rng(1).standard_normal(len(times))
    record = as_response(times, values[None], ("chassis_acceleration",))
    nominal = NOMINAL.with_parameters(stiffness={"chassis": 0.75 * K, "tire": 1.2 * KT}, damping={"chassis": 1.3 * C})
    found = estimate(record, nominal, fixed=["tire.damping"])
    onset = next(c.remark for c in found.verdict.checks if c.remark.code is EstimateCheck.ONSET)
    assert float(str(onset.numbers["starts"])) == pytest.approx(rest * 0.005, abs=0.05)
    for name, true in (("chassis.stiffness", K), ("chassis.damping", C), ("tire.stiffness", KT)):
        low, high = found.interval(0.9999)[name]
        assert low < true < high
