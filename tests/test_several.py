"""Several recordings of one test: joined where they belong together, refused or doubted by name where they do not."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner, Result

from suspid import (
    InputError,
    Level,
    RecordError,
    Settings,
    Suspension,
    add_noise,
    analyse,
    free_decay,
    quarter_car,
    read_recording,
    write_record,
)
from suspid.analysis.analysis import Analysis
from suspid.cli.main import main
from suspid.model import eigenmodes
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import Note, RecordCheck

Write = Callable[..., Path]
CAR = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=800)
OTHER = quarter_car(chassis_mass=300, tire_mass=30, chassis_stiffness=25e3, tire_stiffness=160e3, chassis_damping=800)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], catch_exceptions=False)


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(name: str, car: Suspension = CAR, *, fs: float = 200, turned: bool = False, only: int = 2) -> Path:
        record = free_decay(car, np.arange(0, 4, 1 / fs), initial_state={"v_tire": 1.0, "v_chassis": 0.5})
        signal = as_signal(add_noise(record, snr_db=40.0, rng=np.random.default_rng(sum(map(ord, name)))))
        order = [1, 0] if turned else [0, 1][:only]
        channels = [signal.channels[k] for k in order]
        path = tmp_path / f"{name}.csv"
        write_record(as_response(signal.timepts, signal.values[order], channels), path, digits=8)
        return path

    return written


def std_of(found: Analysis) -> RealArray:
    """Return the standard deviations of the frequencies [rad/s]."""
    ends = found.modes.interval(0.6827)
    assert ends is not None
    return np.asarray(np.ptp(ends.wn, axis=1) / 2)


def codes(found: Analysis) -> set[object]:
    return {check.remark.code for check in found.verdict.checks}


class TestOfOneStructure:
    def test_modes_are_joint_and_better_known(self, write: Write) -> None:
        paths = [write("a"), write("b", turned=True), write("c")]
        joint, alone = analyse(paths), [analyse(path) for path in paths]
        exact = eigenmodes(CAR)
        assert {joint.verdict.level, *(one.verdict.level for one in alone)} == {Level.SOUND}
        assert joint.repeats is not None
        assert joint.repeats.names == ("a.csv", "b.csv", "c.csv") == tuple(joint.tests)
        # Three records of the same length: a third of the variance. One of them may leave a further mode open by
        # chance, which widens its own interval.
        usual = np.median([std_of(one) for one in alone], axis=0)
        assert np.allclose(std_of(joint), usual / np.sqrt(3), rtol=0.3)
        assert np.all(np.abs(joint.modes.wn - exact.wn) < 4 * std_of(joint))

    def test_a_clock_that_strays_is_resampled(self, write: Write) -> None:
        found = analyse([write("a"), write("b", fs=200.2)])
        assert [note.code.name for note in found.notes] == ["RESAMPLED"]
        assert np.all(np.abs(found.modes.wn - eigenmodes(CAR).wn) < 4 * std_of(found))

    def test_rates_that_differ_as_clocks_of_one_kind_do_are_equal(self, write: Write) -> None:
        """Stamps of a phone: 0.02 ms in 4 s apart; a difference that is said can be seen in its numbers."""
        found = analyse([write("a"), write("b", fs=200 * (1 + 5e-6))])
        assert found.notes == ()
        assert np.all(np.abs(found.modes.wn - eigenmodes(CAR).wn) < 4 * std_of(found))
        (note,) = analyse([write("a"), write("c", fs=200 * (1 + 2e-5))]).notes
        assert "from 200.004 to 200 Hz" in str(note)

    def test_the_command_prints_and_writes_them(self, write: Write, tmp_path: Path) -> None:
        paths = [write("a"), write("b")]
        done = run("identify", *paths, "--json", tmp_path / "m.json")
        assert done.exit_code == 0
        assert "a.csv  0 … 3.995 s" in done.stdout
        content = json.loads((tmp_path / "m.json").read_text())
        assert [test["record"]["file"] for test in content["tests"]] == [str(path) for path in paths]
        assert [mode["wn_rad_per_s"] for mode in content["modes"]] == analyse(paths).modes.wn.tolist()


class TestOfDifferentStructures:
    def test_the_one_that_differs_is_named(self, write: Write) -> None:
        found = analyse([write("a"), write("b"), write("d", OTHER)])
        assert found.verdict.level is Level.DOUBTFUL
        (check,) = (c for c in found.verdict.checks if c.remark.code is RecordCheck.SHARES_NO_MODE)
        assert check.remark.numbers["test"] == "d.csv"
        # Nor is each mode said on which a test disagrees that shares none.
        odd = [c.remark.numbers["test"] for c in found.verdict.checks if c.remark.code is RecordCheck.ODD_TEST]
        assert "d.csv" not in odd

    def test_of_two_both_are(self, write: Write) -> None:
        found = analyse([write("a"), write("d", OTHER)])
        assert found.verdict.level is Level.DOUBTFUL
        assert RecordCheck.NO_SHARED_MODE in codes(found)


class TestRefusals:
    def test_other_channels(self, write: Write) -> None:
        with pytest.raises(InputError, match=r"b\.csv does not belong to a\.csv: it has the channels 'chassis'"):
            analyse([write("a"), write("b", only=1)])
        assert len(analyse([write("a"), write("b", only=1)], settings=Settings(channels=("chassis",))).modes)

    def test_another_rate(self, write: Write) -> None:
        with pytest.raises(InputError, match=r"b\.csv is sampled at 100 Hz, a\.csv at 200 Hz"):
            analyse([write("a"), write("b", fs=100)])

    def test_a_copy_under_another_name(self, write: Write, tmp_path: Path) -> None:
        one = write("one")
        copy = tmp_path / "copy.csv"
        copy.write_bytes(Path(one).read_bytes())
        with pytest.raises(InputError, match="copy.csv has the samples of .*leave one out"):
            analyse([one, copy])

    def test_one_file_twice(self, write: Write) -> None:
        done = run("identify", write("a"), write("a"))
        assert done.exit_code == 1
        assert "is named twice" in done.stderr

    def test_a_method_for_single_decays(self, write: Write) -> None:
        with pytest.raises(InputError, match="takes one at a time"):
            analyse([write("a"), write("b")], settings=Settings(method="ridge"))

    def test_a_picture(self, write: Write, tmp_path: Path) -> None:
        done = run("identify", write("a"), write("b"), "--plot", tmp_path / "p.png")
        assert done.exit_code == 2


def two_in_one(folder: Path, first: Suspension = CAR, second: Suspension = CAR) -> Path:
    """Write a file of two tests, each with its own time, as structures of MATLAB."""
    tests: dict[str, object] = {}
    for name, car in (("Fe", first), ("Al", second)):
        record = free_decay(car, np.arange(800) / 200, initial_state={"v_tire": 1.0, "v_chassis": 0.5})
        signal = as_signal(add_noise(record, snr_db=40.0, rng=np.random.default_rng(len(tests))))
        tests[name] = {"Out": {"Time": signal.timepts, "Acc": signal.values}}
    scipy.io.savemat(folder / "r.mat", tests)
    return folder / "r.mat"


class TestSeveralInOneFile:
    def test_are_listed_and_the_first_is_used_with_a_doubt(self, tmp_path: Path) -> None:
        path = two_in_one(tmp_path)
        recording = read_recording(path)
        assert recording.tests == ("Fe", "Al")
        assert recording.of_test("Al").names == ("Al.Out.Acc[1]", "Al.Out.Acc[2]")
        assert "Choose one, such as test='Fe'; test='all' joins them." in str(recording)
        assert "Choose one, such as --test 'Fe'" in CliRunner().invoke(main, ["channels", str(path)]).output
        found = analyse(path)
        assert as_signal(found.record).channels == ("Fe.Out.Acc[1]", "Fe.Out.Acc[2]")
        assert RecordCheck.ONE_OF_TESTS in codes(found)
        assert found.verdict.level is Level.CARE

    def test_the_first_that_moves_is_used(self, tmp_path: Path) -> None:
        times, clock = np.arange(800) / 200, np.arange(300) / 100
        moved = {"time": times, "signal": np.exp(-times) * np.sin(30 * times)}
        held = {"time": clock, "signal": np.ones(clock.size)}
        scipy.io.savemat(tmp_path / "s.mat", {"step": {"input": held, "output": moved}})
        found = analyse(tmp_path / "s.mat")
        assert as_signal(found.record).channels == ("step.output.signal",)
        (said,) = (note for note in found.notes if note.code is Note.ONE_OF_TESTS)
        assert said.numbers["used"] == "output"
        scipy.io.savemat(tmp_path / "n.mat", {"step": {"input": held, "output": {**moved, "signal": np.zeros(800)}}})
        with pytest.raises(RecordError, match="no channel moves: 'step.input.signal': constant at 1"):
            analyse(tmp_path / "n.mat")

    def test_one_is_chosen(self, tmp_path: Path) -> None:
        found = analyse(two_in_one(tmp_path, CAR, OTHER), settings=Settings(test="Al"))
        assert found.verdict.level is Level.SOUND
        assert np.all(np.abs(found.modes.wn - eigenmodes(OTHER).wn) < 4 * std_of(found))
        with pytest.raises(RecordError, match=r"r\.mat: there is no test 'Cu': it contains 'Fe', 'Al'"):
            analyse(two_in_one(tmp_path), settings=Settings(test="Cu"))

    def test_all_are_joined(self, tmp_path: Path) -> None:
        found = analyse(two_in_one(tmp_path), settings=Settings(test="all"))
        assert tuple(found.tests) == ("Fe", "Al")
        assert found.modes.channels == ("Out.Acc[1]", "Out.Acc[2]")

    def test_one_that_is_refused_leaves_the_others(self, tmp_path: Path) -> None:
        times, clock = np.arange(800) / 200, np.arange(300) / 100
        moved = {"time": times, "signal": np.exp(-times) * np.sin(30 * times)}
        held = {"time": clock, "signal": np.ones(clock.size)}
        scipy.io.savemat(tmp_path / "s.mat", {"step": {"input": held, "output": moved}})
        said = CliRunner().invoke(main, ["identify", str(tmp_path / "s.mat")])
        assert said.exit_code == 0
        assert "s.mat: 2 tests, one after the other; --test chooses one" in said.stdout
        assert "1 mode found" in said.stdout
        assert "test 'input':" in said.stdout
        assert "no channel moves: 'step.input.signal': constant at 1" in said.stdout

    def test_what_is_repaired_in_each_is_said(self, tmp_path: Path) -> None:
        times = np.arange(800) / 200
        first, second = (np.exp(-times) * np.sin(wn * times) for wn in (30, 35))
        second[300] = -9999.0
        tests = {"a": {"time": times, "z": first}, "b": {"time": times[:-90], "z": second[:-90]}}
        scipy.io.savemat(tmp_path / "s.mat", tests)
        said = CliRunner().invoke(main, ["identify", str(tmp_path / "s.mat")])
        assert said.stdout.count("1 mode found") == 2
        assert "sentinel, channel 'b.z'" in said.stderr
        refused = CliRunner().invoke(main, ["identify", str(tmp_path / "s.mat"), "--json", str(tmp_path / "m.json")])
        assert "such as --test a, or join them" in refused.stderr

    def test_the_command_prints_each(self, tmp_path: Path) -> None:
        path = two_in_one(tmp_path, CAR, OTHER)
        done = run("identify", path)
        assert done.exit_code == 0
        assert done.stdout.count("Verdict: 2 modes found: sound") == 2
        refused = run("identify", path, "--json", tmp_path / "m.json")
        assert refused.exit_code == 1
        assert "contains 2 tests: choose one with --test" in refused.stderr
        assert run("identify", path, "--test", "all", "--json", tmp_path / "m.json").exit_code == 0

    def test_channels_of_one_clock_are_one_test(self, tmp_path: Path) -> None:
        t = np.arange(20) / 10
        scipy.io.savemat(tmp_path / "r.mat", {"t": t, "front": {"z": np.sin(t)}, "rear": {"z": np.cos(t)}})
        assert read_recording(tmp_path / "r.mat").tests == ()

    @pytest.mark.parametrize(("rows", "tests"), [(60, ("free", "damped")), (95, ())])
    def test_tables_of_one_unit_beside_each_other(self, rows: int, tests: tuple[str, ...], tmp_path: Path) -> None:
        """Each with its own time from 0 on; two loggers of one test end together."""
        lines = [f"{k / 20},{k % 7},,{k / 20 + 0.003},{k % 5}" for k in range(rows)]
        lines += [f"{k / 20},{k % 7},,," for k in range(rows, 100)]
        (tmp_path / "r.csv").write_text("\n".join(["Timed,free (m),,Timed,damped (m)", *lines, ""]))
        assert read_recording(tmp_path / "r.csv").tests == tests

    def test_numbered_runs_beside_each_other(self, tmp_path: Path) -> None:
        head = "Run 1: Time (s)\tRun 1: z (m)\tRun 2: Time (s)\tRun 2: z (m)\n"
        rows = "".join(f"{k / 8}\t{k * k}\t{k / 8}\t{-k}\n" for k in range(20))
        (tmp_path / "r.txt").write_text(head + rows)
        assert read_recording(tmp_path / "r.txt").tests == ("Run 1", "Run 2")
