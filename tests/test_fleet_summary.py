"""What a fleet's results say: families of modes, outliers, and the damper that wears out."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from fleets import CAR, make_fleet, time_limit, write_decay
from matplotlib.figure import Figure

from suspid import InputError, ModalSet, eigenmodes, quarter_car
from suspid.analysis import CarSettings, Settings
from suspid.cli.commands import Commands
from suspid.cli.fleet import fleet_command
from suspid.fleet.distributions import QUANTILES, Distribution, distribution
from suspid.fleet.families import OTHERS, families_by_density, families_of_car
from suspid.fleet.fleet_summary import fleet_summary
from suspid.fleet.identify_many import identify_many
from suspid.fleet.manifest import FLEET_FORMAT, environment
from suspid.fleet.parts import as_part, read_table, write_part
from suspid.fleet.summary import FleetSummary
from suspid.fleet.summary_text import distribution_table, with_examples
from suspid.fleet.tables import TABLE_COLUMNS, Rows
from suspid.fleet.trends import trends_of
from suspid.fleet.vehicles import read_vehicles, vehicles_from_names
from suspid.model.car_files import write_car
from suspid.reporting.plot_fleet import draw_distribution
from suspid.text_tables import TERMINAL
from suspid.units import RealArray
from suspid.words import DamperState, Failure, FleetCheck, Step


@pytest.fixture(autouse=True)
def limited() -> Iterator[None]:
    with time_limit():
        yield


def results(
    folder: Path, f: RealArray, zeta: RealArray, *, names: Sequence[str], std: RealArray | float = 0.01
) -> Path:
    """Write results as a run leaves them: one row per record and mode, (record, mode) arrays."""
    for table in TABLE_COLUMNS:
        (folder / table).mkdir(parents=True)
    (folder / "manifest.json").write_text(json.dumps({"format": FLEET_FORMAT, "environment": environment()}))
    share = np.broadcast_to(std, len(names))
    blank = dict.fromkeys(TABLE_COLUMNS["modes"])
    modes = [
        blank
        | {"record": name, "mode": k + 1, "f_hz": f[r, k], "zeta": zeta[r, k]}
        | {"wn_std_rad_per_s": 2 * np.pi * share[r] * f[r, k], "zeta_std": share[r] * zeta[r, k]}
        for r, name in enumerate(names)
        for k in range(f.shape[1])
        if np.isfinite(f[r, k])
    ]
    write_part(folder, 0, as_part(Rows(modes=tuple(modes), records=len(names))))
    return folder


def found(summary: FleetSummary, quantity: str) -> dict[str, float]:
    (one,) = [d for d in summary.distributions if d.quantity == quantity]
    return {"count": one.count, "median": one.median, "scatter": one.scatter, "stated": one.stated}


class TestFamilies:
    @pytest.mark.parametrize("seed", range(5))
    def test_modes_of_a_mixed_fleet_find_each_other(self, seed: int) -> None:
        """Three modes that scatter by 5 %: as many families, and no mode in a wrong one; spurious ones apart."""
        rng = np.random.default_rng(seed)
        count = 200
        f = np.exp(np.log([1.2, 3.0, 11.0]) + 0.05 * rng.standard_normal((count, 3)))
        zeta = np.array([0.3, 0.2, 0.1]) * np.exp(0.3 * rng.standard_normal((count, 3)))
        record = np.repeat(np.arange(count), 3)
        label = families_by_density(np.append(f.ravel(), 40.0), np.append(zeta.ravel(), 0.01), np.append(record, 7))
        assert np.all(label[:-1].reshape(count, 3) == [0, 1, 2])
        assert label[-1] == OTHERS

    @pytest.mark.parametrize(("spread_f", "spread_zeta"), [(0.01, 0.2), (0.05, 0.05)])
    def test_two_modes_in_one_peak(self, spread_f: float, spread_zeta: float) -> None:
        """Bounce and pitch 6 % apart: parted by frequency where that is sharp, else by damping."""
        rng = np.random.default_rng(1)
        f = np.exp(np.log([1.0, 1.06]) + spread_f * rng.standard_normal((100, 2)) * 0.5)
        zeta = np.exp(np.log([0.30, 0.15]) + spread_zeta * rng.standard_normal((100, 2)))
        label = families_by_density(f.ravel(), zeta.ravel(), np.repeat(np.arange(100), 2)).reshape(100, 2)
        assert set(label.ravel().tolist()) == {0, 1}
        assert np.mean(label[:, 0] == np.bincount(label[:, 0]).argmax()) > 0.98

    def test_each_mode_of_the_car_takes_one(self) -> None:
        car = ModalSet.from_wn_zeta(2 * np.pi * np.array([1.0, 1.2, 10.0]), [0.3, 0.05, 0.2])
        # Close in frequency, told apart by damping; a second one near 10 Hz; one far off.
        f, zeta = np.array([1.1, 1.1, 9.0, 10.5, 90.0]), np.array([0.31, 0.05, 0.2, 0.2, 0.2])
        assert families_of_car(f, zeta, np.zeros(5, int), car).tolist() == [0, 1, OTHERS, 2, OTHERS]

    def test_a_record_is_counted_once(self) -> None:
        """One record of twenty has two modes in the peak of the body: the nearer one is that of the body."""
        f = np.append(np.linspace(1.0, 1.04, 20), 1.08)
        label = families_by_density(f, np.full(21, 0.3), np.append(np.arange(20), 19))
        assert label[:20].tolist() == [0] * 20
        assert label[20] == OTHERS

    def test_a_third_mode_beside_a_pair_is_no_second_one(self) -> None:
        f, record = np.tile([1.0, 1.1], 20), np.repeat(np.arange(20), 2)
        label = families_by_density(np.append(f, 1.12), np.full(41, 0.3), np.append(record, 3))
        assert label[:40].tolist() == [0, 1] * 20
        assert label[40] == OTHERS


class TestDistributionsAndOutliers:
    def test_what_is_not_stated_is_empty(self) -> None:
        """Frequencies of bodies have intervals and no standard deviation."""
        one = Distribution(
            quantity="f", unit="Hz", count=1, median=1.2, quantiles=(1.2,) * len(QUANTILES), scatter=0.0, stated=np.nan
        )
        assert "nan" not in distribution_table([one])

    @pytest.mark.parametrize("count", [8, 40])
    def test_tables_fit_a_terminal_and_have_no_empty_column(self, count: int) -> None:
        """Forty records have one beyond the ends of 95 %; eight have none, and no column for it."""
        values = np.random.default_rng(1).normal(1.0, 0.01, size=count)
        some = [distribution(name, "N s/m", values, values) for name in ("chassis_front.damping", "tire.damping")]
        heading, _, *rows = distribution_table(some).splitlines()
        assert max(map(len, [heading, *rows])) <= TERMINAL
        assert ("2.5 %" in heading) == (count == 40)

    @pytest.mark.parametrize("count", [3, 16, 300])
    def test_two_groups_are_more_than_two_bars(self, count: int) -> None:
        """The middle half of two groups is as wide as all; Sturges' number of bars does not depend on it."""
        values = np.concatenate([np.linspace(0.0, 0.1, count), np.linspace(1.0, 1.1, count)])
        found = distribution("f", "Hz", values, values)
        assert len(found.bars) >= np.log2(2 * count) + 1
        assert sum(found.bars) == 2 * count
        assert 0 in found.bars

    def test_values_that_differ_in_the_last_digits_are_written_in_full(self) -> None:
        one = Distribution(
            quantity="seat.stiffness", unit="N/m", count=2, median=199973.0, quantiles=(199973.0,) * len(QUANTILES),
            scatter=8.0, stated=9.0, edges=(199965.0, 199973.0, 199982.0), bars=(1, 1),
        )  # fmt: skip
        ax = Figure(figsize=(3.6, 1.4), layout="constrained").subplots()
        draw_distribution(one, ax)
        ax.figure.draw_without_rendering()  # type: ignore[union-attr]
        assert ax.xaxis.get_offset_text().get_text() == ""
        assert all(float(tick.get_text()) > 199900 for tick in ax.get_xticklabels())
        assert [line.get_label() for line in ax.lines] == ["median 199970"]

    def test_scatter_beside_what_is_stated(self, tmp_path: Path) -> None:
        """1000 normal values: median and robust scatter within five of their standard deviations."""
        rng = np.random.default_rng(3)
        count, spread = 1000, 0.05
        f = 2.0 * (1 + spread * rng.standard_normal((count, 1)))
        summary = fleet_summary(results(tmp_path, f, 0.2 + 0 * f, names=[f"r{k}" for k in range(count)], std=0.01))
        one = found(summary, "mode 1 f")
        assert one["count"] == count
        # Variances of median and MAD of normal values: pi/2 and 1.36 times those of mean and standard deviation.
        assert one["median"] == pytest.approx(2.0, abs=5 * 1.2533 * 0.1 / np.sqrt(count))
        assert one["scatter"] == pytest.approx(0.1, abs=5 * 1.167 * 0.1 / np.sqrt(count))
        assert one["stated"] == pytest.approx(0.02, rel=0.01)
        assert "no outlier" in str(summary) or len(summary.outliers) <= 2

    def test_an_outlier_is_one_unless_it_knows_that_it_is_uncertain(self, tmp_path: Path) -> None:
        rng = np.random.default_rng(4)
        names = [f"r{k:02d}" for k in range(60)]
        zeta = 0.2 + 0.01 * rng.standard_normal((60, 1))
        zeta[7] = 0.3
        summary = fleet_summary(results(tmp_path / "a", np.full((60, 1), 2.0), zeta, names=names, std=0.01))
        assert [(one.record, one.quantity) for one in summary.outliers] == [("r07", "mode 1 zeta")]
        unsure = np.where(np.arange(60) == 7, 0.25, 0.01)
        vague = fleet_summary(results(tmp_path / "b", np.full((60, 1), 2.0), zeta, names=names, std=unsure))
        assert not vague.outliers


class TestCounts:
    def test_failures_by_code_and_verdicts_by_level(self, tmp_path: Path) -> None:
        """Counts are those of the rows, whatever their words say; a record with two modes has one verdict."""
        one = dict.fromkeys(TABLE_COLUMNS["failures"])
        failures = [
            one | {"record": f"f{k}", "step": str(Step.READ), "code": str(code), "reason": f"words {k}"}
            for k, code in enumerate([Failure.UNUSABLE, Failure.MEMORY, Failure.UNUSABLE])
        ]
        blank = dict.fromkeys(TABLE_COLUMNS["modes"]) | {"f_hz": 1.0, "zeta": 0.1}
        modes = [
            blank | {"record": f"r{k}", "mode": mode, "verdict": verdict, "doubts": doubts, "doubts_in_words": said}
            for k, (verdict, doubts, said) in enumerate(
                [("care", ["a", "b"], ["A; or not.", "B of 0."]), ("sound", [], []), ("care", ["b"], ["B of 2."])]
            )
            for mode in (1, 2)
        ]
        results(tmp_path, np.ones((1, 1)), np.ones((1, 1)), names=["x"])
        write_part(tmp_path, 0, as_part(Rows(modes=tuple(modes), failures=tuple(failures), records=6, failed=3)))
        summary = fleet_summary(tmp_path)
        assert [(f.step, f.code, f.count, f.example) for f in summary.failures] == [
            (Step.READ, Failure.UNUSABLE, 2, "f0: words 0"),
            (Step.READ, Failure.MEMORY, 1, "f1: words 1"),
        ]
        assert summary.verdicts == {"care": 2, "sound": 1}
        said = {check.remark.code: check.remark.numbers for check in summary.verdict.checks}
        assert said[FleetCheck.CARE] == {"care": 2}
        assert summary.doubts == {"b": 2, "a": 1}
        assert summary.said == {"a": "A; or not.", "b": "B of 0."}
        assert "B of 0." in str(summary)

    def test_tables_with_sentences_fit_a_terminal(self) -> None:
        """The longest step and reason there are leave the sentence what is left of a line."""
        names = [f"{max(map(str, Step), key=len)}: {max(map(str, Failure), key=len)}", "read: memory"]
        text = with_examples({"failed at": names, "records": ["12000", "1"]}, ["a/long/name.csv: " + "word " * 50, ""])
        assert max(map(len, text.split("\n"))) <= 80


class TestTrends:
    """Of 20 vehicles with 8 tests each."""

    def measured(
        self, seed: int, *, shared: float, fall: float = 0.0, vehicles: int = 20
    ) -> dict[str, tuple[RealArray, RealArray, RealArray]]:
        rng = np.random.default_rng(seed)
        made = {}
        for k in range(vehicles):
            time, std = np.sort(rng.uniform(0, 3, 8)), rng.uniform(10, 40, 8)
            noise = std * rng.standard_normal(8) + shared * rng.standard_normal(8)
            made[f"car {k}"] = time, 1500 - (fall * time if k == 13 else 0.0) + noise, std
        return made

    @pytest.mark.slow
    @pytest.mark.parametrize("shared", [0.0, 20.0, 100.0])
    def test_false_alarms(self, shared: float) -> None:
        """Where nothing changes, at most 5 % of the single intervals miss zero: of 2000, 5 sd above is 7.4 %."""
        every = [t for seed in range(100) for t in trends_of("c", self.measured(seed, shared=shared))]
        missed = np.mean([not t.change[0] <= 0 <= t.change[1] for t in every])
        assert 0.005 < missed < 0.05 + 5 * np.sqrt(0.05 * 0.95 / len(every))

    @pytest.mark.slow
    def test_coverage_of_a_change(self) -> None:
        found = [t for seed in range(100) for t in trends_of("c", self.measured(seed, shared=50.0, fall=120.0))]
        worn = [t for t in found if t.vehicle == "car 13"]
        held = np.mean([t.change[0] <= -120.0 * t.span <= t.change[1] for t in worn])
        # Of 100 intervals of 95 %, 84 or fewer hold once in a hundred thousand times.
        assert held > 0.84
        assert np.mean([t.end - t.start for t in worn]) == pytest.approx(
            -120.0 * np.mean([t.span for t in worn]), rel=0.1
        )

    def with_a_noisy_one(self, seed: int) -> dict[str, tuple[RealArray, RealArray, RealArray]]:
        """Add a vehicle that scatters ten times as much as it states, and as the others do; nothing changes."""
        rng = np.random.default_rng((seed, 1))
        return self.measured(seed, shared=0.0, vehicles=6) | {
            "noisy": (np.arange(8.0), 1500 + 300 * rng.standard_normal(8), np.full(8, 30.0))
        }

    @pytest.mark.slow
    def test_a_noisy_vehicle_raises_no_false_trend(self) -> None:
        """Its interval is that of its own scatter, with its own 6 degrees of freedom: one in 20 misses zero."""
        found = [t for seed in range(1000) for t in trends_of("c", self.with_a_noisy_one(seed)) if t.vehicle == "noisy"]
        missed = np.mean([not t.change[0] <= 0 <= t.change[1] for t in found])
        # Normal limits or pooled degrees of freedom would miss 9.5 % of them.
        assert missed == pytest.approx(0.05, abs=5 * np.sqrt(0.05 * 0.95 / len(found)))

    def test_a_noisy_vehicle_has_the_interval_of_its_own_line(self) -> None:
        from scipy import stats

        tests = self.with_a_noisy_one(1)
        time, values, _ = tests["noisy"]
        (found,) = (t for t in trends_of("c", tests | {"noisy": (time, values, 0 * time)}) if t.vehicle == "noisy")
        line = stats.linregress(time, values)
        change = 7 * (line.slope + np.array([-1.0, 1.0]) * stats.t.ppf(0.975, 6) * line.stderr)
        np.testing.assert_allclose(found.change, change, rtol=1e-5)
        assert found.p == pytest.approx(line.pvalue, rel=1e-5)

    def test_a_noisy_vehicle_does_not_hide_the_others(self) -> None:
        """The intervals of the others are as wide as they are without it."""
        for seed in range(10):
            alone = trends_of("c", self.measured(seed, shared=0.0, vehicles=6))
            beside = {t.vehicle: t for t in trends_of("c", self.with_a_noisy_one(seed))}
            for one in alone:
                assert np.ptp(beside[one.vehicle].change) == pytest.approx(np.ptp(one.change), rel=0.02)

    def test_the_interval_is_that_of_weighted_least_squares(self) -> None:
        """Where every test states the same and scatters more, it is the textbook's line: scipy.stats.linregress."""
        from scipy import stats

        rng = np.random.default_rng(8)
        time = np.arange(10.0)
        values = 5.0 - 0.3 * time + rng.standard_normal(10)
        (mine,) = trends_of("c", {"A": (time, values, np.full(10, 0.01))})
        textbook = stats.linregress(time, values)
        assert mine.end - mine.start == pytest.approx(9 * textbook.slope, rel=1e-9)
        assert mine.p == pytest.approx(textbook.pvalue, rel=1e-5)
        half = stats.t.ppf(0.975, 8) * textbook.stderr * 9
        assert (mine.change[1] - mine.change[0]) / 2 == pytest.approx(half, rel=1e-5)

    def test_too_few_tests_say_nothing(self) -> None:
        time = np.array([0.0, 1.0, 2.0, 3.0])
        assert not trends_of("c", {"A": (time[:3], time[:3], time[:3])})
        assert not trends_of("c", {"A": (0 * time, time, time)})
        assert not trends_of("c", {"A": (time, np.array([1.0, np.nan, 1.0, 1.0]), time)})
        assert trends_of("c", {"A": (time, 0 * time, 0 * time)})[0].p == 1.0


class TestAWornDamper:
    @pytest.fixture(scope="class")
    @staticmethod
    def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
        """Make six tests of three cars over five years; the damper of one loses a fourth."""
        folder = tmp_path_factory.mktemp("worn")
        lines = ["record,vehicle,date"]
        for v, vehicle in enumerate(("V1", "V2", "V3")):
            (folder / "in" / vehicle).mkdir(parents=True)
            for year in range(6):
                left = 1500.0 * (1 - 0.05 * year * (vehicle == "V2"))
                car = CAR.with_parameters(damping={"chassis": left})
                name = f"{vehicle}/{2018 + year}-03-01.csv"
                write_decay(folder / "in" / name, 10 * v + year, car=car)
                lines.append(f"{name},{vehicle},{2018 + year}-03-01")
        (folder / "vehicles.csv").write_text("\n".join(lines) + "\n")
        write_car(CAR, folder / "car.toml")
        settings = Settings(springs=CarSettings(fixed=("tire.damping",)))
        identify_many(folder / "in", output=folder / "out", car=CAR, workers=2, settings=settings)
        return folder

    @pytest.mark.slow
    def test_it_is_found_and_no_other(self, fleet: Path) -> None:
        summary = fleet_summary(fleet / "out", table=fleet / "vehicles.csv")
        falling = [t for t in summary.trends if t.changes and t.quantity.endswith("damping")]
        assert [(t.vehicle, t.quantity, t.direction) for t in falling] == [("V2", "chassis.damping", "falls")]
        (worn,) = falling
        assert worn.change[0] < -375.0 < worn.change[1] < 0
        assert all(t.vehicle == "V2" for t in summary.trends if t.changes)
        springs = {t.quantity for t in summary.trends if t.quantity.endswith("stiffness") and t.changes}
        assert not springs
        assert "chassis.damping falls" in str(summary)
        assert summary.dampers is not None
        states = {one.vehicle: one.state for one in summary.dampers.trends}
        assert states == {"V1": DamperState.GOOD, "V2": DamperState.WORN, "V3": DamperState.GOOD}
        assert "2 good, 1 worn" in str(summary)

    @pytest.mark.slow
    def test_names_do_as_well_as_a_table(self, fleet: Path) -> None:
        by_name = fleet_summary(fleet / "out", pattern=r"(?P<vehicle>\w+)/(?P<date>\d{4}-\d{2}-\d{2})")
        assert str(by_name) == str(fleet_summary(fleet / "out", table=fleet / "vehicles.csv"))

    @pytest.mark.slow
    def test_families_are_the_car_s_modes(self, fleet: Path) -> None:
        summary = fleet_summary(fleet / "out")
        truth = eigenmodes(CAR)
        for k in range(2):
            one = found(summary, f"mode {k + 1} f")
            assert one["count"] == 18
            assert one["median"] == pytest.approx(truth.wn[k] / (2 * np.pi), rel=0.05)

    def test_the_command(self, fleet: Path) -> None:
        shown = run("--summary", fleet / "out", "--table", fleet / "vehicles.csv")
        assert shown.exit_code == 0, shown.output
        assert "chassis.damping falls" in shown.stdout
        assert shown.stdout.rstrip() == str(fleet_summary(fleet / "out", table=fleet / "vehicles.csv")).rstrip()


class TestVehicles:
    def test_numbers_are_mileages(self, tmp_path: Path) -> None:
        (tmp_path / "v.csv").write_text(" record , vehicle,date,driver\na.csv,V1,12000,Ann\nb.csv,V1,2.5e4,Bob\n")
        assert read_vehicles(tmp_path / "v.csv") == {"a.csv": ("V1", 12000.0), "b.csv": ("V1", 25000.0)}

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("record,car,date\n", "there is no column 'vehicle'"),
            ("record,vehicle,date\na,V,yesterday\n", "line 2: 'yesterday' is neither a date"),
            ("record,vehicle,date\na,V,1\na,V,2\n", "line 3: record 'a' stands there twice"),
            ("record,vehicle,date\na,V,1\nb,V,2024-01-01\n", "write all of them in one way"),
            ("record,vehicle,date\na,V,inf\n", "neither a date"),
        ],
    )
    def test_what_is_refused(self, tmp_path: Path, text: str, message: str) -> None:
        (tmp_path / "v.csv").write_text(text)
        with pytest.raises(InputError, match=message):
            read_vehicles(tmp_path / "v.csv")

    def test_patterns_that_are_refused(self) -> None:
        with pytest.raises(InputError, match="not a regular expression"):
            vehicles_from_names([], "(")
        with pytest.raises(InputError, match=r"has no group \(\?P<vehicle>"):
            vehicles_from_names([], "(?P<date>x)")


def run(*arguments: object) -> Result:
    command = Commands(commands={"fleet": fleet_command})
    return CliRunner().invoke(command, ["fleet", *(str(argument) for argument in arguments)])


class TestCommand:
    def test_run_and_go_on(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 6)
        (tmp_path / "in" / "bad\x1b[31m.csv").write_text("time,seat\n")
        (tmp_path / "in" / "notes.md").write_text("no record")
        first = run(tmp_path / "in", "-o", tmp_path / "out", "--workers", 1)
        assert first.exit_code == 0, first.output
        assert "7 records, 1 of them with a failure" in first.stdout
        assert "mode 1 f [Hz]" in first.stdout
        assert "warning: left out, since such files are not records: 1 .md" in first.stderr
        assert "\x1b" not in first.output
        assert run(tmp_path / "in", "-o", tmp_path / "out", "--workers", 1).stdout == first.stdout
        other = run(tmp_path / "in", "-o", tmp_path / "out", "--modes", 1)
        assert other.exit_code == 1
        assert "begun with other settings: --modes was not given, is 1" in other.stderr

    def test_another_car_is_named_by_the_line_that_differs(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 1)
        for name, damping in (("one", 1500), ("other", 1400)):
            car = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3,
                              chassis_damping=damping)  # fmt: skip
            write_car(car, tmp_path / f"{name}.toml")
        fleet = (tmp_path / "in", "-o", tmp_path / "out", "--workers", 1, "--car")
        assert run(*fleet, tmp_path / "one.toml").exit_code == 0
        refused = run(*fleet, tmp_path / "other.toml")
        assert refused.exit_code == 1
        assert "car had 'damping = 1500.0  # N s/m', has 'damping = 1400.0  # N s/m'; continue" in refused.stderr

    @pytest.mark.slow
    def test_reasons_of_failures_name_the_options_of_the_command(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 1)
        (tmp_path / "in" / "untimed.csv").write_text("seat,tire\n" + "1,2\n3,1\n" * 50, encoding="utf-8")
        shown = run(tmp_path / "in", "-o", tmp_path / "out", "--workers", 1)
        assert shown.exit_code == 0, shown.stderr
        (row,) = read_table(tmp_path / "out", "failures", columns=["reason"]).to_pylist()
        assert "name one (--time), or give the sampling rate (--fs)" in row["reason"]
        identify_many(tmp_path / "in", output=tmp_path / "by_python", workers=1)
        (row,) = read_table(tmp_path / "by_python", "failures", columns=["reason"]).to_pylist()
        assert "name one (time), or give the sampling rate (fs)" in row["reason"]

    def test_nothing_could_be_identified(self, tmp_path: Path) -> None:
        (tmp_path / "in").mkdir()
        (tmp_path / "in" / "bad.csv").write_text("time,seat\n")
        result = run(tmp_path / "in", "-o", tmp_path / "out", "--workers", 1)
        assert result.exit_code == 1
        assert "no record could be identified" in result.stderr
        assert "failed at" in result.stdout

    @pytest.mark.parametrize(
        "arguments",
        [
            ["in"],
            ["in", "-o", "out", "--workers", "1", "--scheduler", "tcp://x:1"],
            ["in", "-o", "out", "--summary"],
            ["in", "-o", "out", "--band", "5", "2"],
            ["out", "--summary", "--table", "a.csv", "--vehicle-from", "x"],
        ],
    )
    def test_usage(self, arguments: list[str]) -> None:
        assert run(*arguments).exit_code == 2

    @pytest.mark.skipif(sys.platform == "win32", reason="there are no terminals of this kind")
    @pytest.mark.slow
    def test_progress_on_a_terminal_alone(self, tmp_path: Path) -> None:
        make_fleet(tmp_path / "in", 4)
        (tmp_path / "in" / "bad.csv").write_text("")
        import fcntl
        import termios

        ours, theirs = os.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 120, 0, 0))
        command = [sys.executable, "-c", "from suspid.cli.fleet import fleet_command; fleet_command()"]
        command += [str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--workers", "1", "--chunk", "1"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs)
        os.close(theirs)
        shown = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:
                break
            if not piece:
                break
            shown += piece
        os.close(ours)
        output, _ = process.communicate(timeout=1800)
        assert process.returncode == 0
        assert b"5/5" in shown
        assert b"failed=1" in shown
        assert b"5 records, 1 of them" in output
