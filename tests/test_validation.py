"""The reports that judge the library: their bound, their truth, and that they run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from suspid import InputError, ModalSet, eigenmodes, free_decay, statespace
from validation import speed_ratios
from validation.__main__ import FOLDER, RATIOS, main
from validation.bounds import cramer_rao, decay_amplitudes
from validation.paper import report
from validation.paper_pictures import draw_responses, save
from validation.paper_tables import best_step, damping_rows, trapezoidal_poles, truth_rows
from validation.study import RATE, START, Study, bound, case_record, clean_record, matched, paper_car
from validation.table2 import ACTUAL_WN, ACTUAL_ZETA, CASES


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


class TestCramerRaoBound:
    @pytest.mark.parametrize(
        ("snr_db", "wn_std"),
        # Published with the method, to the digits given.
        [(20.0, (0.0006, 0.016, 0.090)), (2.0, (0.005, 0.129, 0.716))],
    )
    def test_seat_alone_is_as_published(self, snr_db: float, wn_std: tuple[float, ...]) -> None:
        digits = (4, 3, 3) if snr_db == 20.0 else (3, 3, 3)
        found = bound(snr_db, ("seat",)).wn_std
        assert [round(float(s), d) for s, d in zip(found, digits, strict=True)] == list(wn_std)

    def test_seat_at_2_db_hides_the_fastest_mode_in_noise(self) -> None:
        _, amplitudes = decay_amplitudes(statespace(paper_car()), [0, 0, 0, 0, 0, 1.0])
        std = np.sqrt(np.mean(np.asarray(clean_record().y)[0] ** 2) * 10**-0.2)
        assert abs(amplitudes[0, 2]) / std == pytest.approx(0.38, abs=0.005)

    def test_equals_the_inverse_of_the_whole_information_matrix(self) -> None:
        # Every parameter by central differences of the record, nothing projected out.
        time, sigma = np.linspace(0.0, 4.0, 400, dtype=np.float64), np.array([0.02, 0.05])
        poles, amplitudes = np.array([-0.3 + 9j, -2.0 + 17j]), np.array([[1.0 + 0.5j, 0.4j], [-0.2, 0.8 - 0.1j]])

        def record(wn_zeta_ab: np.ndarray) -> np.ndarray:
            wn, zeta, rest = wn_zeta_ab[:2], wn_zeta_ab[2:4], wn_zeta_ab[4:].reshape(2, 2, 2)
            lam = -zeta * wn + 1j * wn * np.sqrt(1 - zeta**2)
            values = (rest[0] + 1j * rest[1]) @ np.exp(np.outer(lam, time))
            return np.asarray((values.real / sigma[:, None]).ravel())

        at = np.concatenate(
            [np.abs(poles), -poles.real / np.abs(poles), amplitudes.real.ravel(), amplitudes.imag.ravel()]
        )
        steps = 1e-6 * np.eye(len(at))
        J = np.stack([(record(at + h) - record(at - h)) / 2e-6 for h in steps], axis=1)
        expected = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
        found = cramer_rao(poles, amplitudes, time, noise_std=sigma)
        # Central differences are good to about the square of the step, over rounding.
        np.testing.assert_allclose(found.wn_std, expected[:2], rtol=1e-6)
        np.testing.assert_allclose(found.zeta_std, expected[2:4], rtol=1e-6)

    def test_is_proportional_to_noise(self) -> None:
        ratio = bound(2.0, ("tire",)).zeta_std / bound(20.0, ("tire",)).zeta_std
        np.testing.assert_allclose(ratio, 10 ** (18 / 20), rtol=1e-12)

    def test_more_channels_never_loosen_it(self) -> None:
        together = bound(20.0, ("seat", "chassis", "tire"))
        for channel in ("seat", "chassis", "tire"):
            alone = bound(20.0, (channel,))
            assert np.all(together.wn_std < alone.wn_std)
            assert np.all(together.zeta_std < alone.zeta_std)

    def test_unknown_offset_loosens_it(self) -> None:
        poles, amplitudes, time = np.array([-1.0 + 2j]), np.array([[1.0]]), np.arange(0, 3, 0.01)
        with_offset = cramer_rao(poles, amplitudes, time, noise_std=0.1, offset=True)
        assert np.all(with_offset.wn_std > cramer_rao(poles, amplitudes, time, noise_std=0.1).wn_std)

    @pytest.mark.parametrize(
        ("poles", "amplitudes", "noise_std", "match"),
        [
            ([-1.0 + 0j], [[1.0]], 0.1, "above the real axis"),
            ([-1.0 + 5j], [[1.0, 2.0]], 0.1, r"expected \(channel, 1\)"),
            ([-1.0 + 5j], [[1.0]], 0.0, "must be positive"),
        ],
    )
    def test_refusals(self, poles: list[complex], amplitudes: list[list[float]], noise_std: float, match: str) -> None:
        with pytest.raises(InputError, match=match):
            cramer_rao(np.array(poles), np.array(amplitudes), np.arange(10.0), noise_std=noise_std)


class TestDecayAmplitudes:
    def test_sum_of_modes_is_the_free_decay(self) -> None:
        poles, amplitudes = decay_amplitudes(statespace(paper_car()), [0, 0, 0, 0, 0, 1.0])
        record = clean_record()
        rebuilt = (amplitudes @ np.exp(np.outer(poles, np.asarray(record.time)))).real
        # Two orders of summation of the same three modes.
        np.testing.assert_allclose(rebuilt, record.y, rtol=0, atol=1e-12 * np.max(np.abs(record.y)))


class TestTrapezoidalPoles:
    def test_tend_to_the_exact_ones_with_the_square_of_the_step(self) -> None:
        A, exact = np.asarray(statespace(paper_car()).A), eigenmodes(paper_car()).wn
        error = [np.max(np.abs(np.sort(np.abs(trapezoidal_poles(A, h))) - exact)) for h in (1e-3, 5e-4)]
        # Second order; the next term of the series is 1e-3 of this one.
        assert error[0] / error[1] == pytest.approx(4.0, rel=5e-3)

    def test_one_step_multiplies_the_state_as_the_rule_says(self) -> None:
        # The rule by its definition: x1 - x0 = h (A x0 + A x1) / 2, on an oscillator.
        A, h = np.array([[0.0, 1.0], [-900.0, -3.0]]), 0.004
        (pole,) = trapezoidal_poles(A, h)
        factor = np.exp(pole * h)
        lam = (factor - 1) / (h * (factor + 1) / 2)
        vector = np.array([1.0, lam])
        np.testing.assert_allclose(A @ vector, lam * vector, rtol=1e-10)


class TestTableTwo:
    def test_damping_of_the_three_readings_is_as_published(self) -> None:
        rows = [[float(cell) for cell in row[1:]] for row in damping_rows()]
        np.testing.assert_allclose(rows[2], [83.8691, 0.1565, 50.1345, 0.2532, 21.2719, 0.0789], atol=1e-4)
        np.testing.assert_allclose(rows[3], [83.8549, 1.5648, 50.1386, 2.5331, 21.2737, 0.7886], atol=1e-4)
        np.testing.assert_allclose(rows[4], [83.659, 1.5575, 50.097, 2.5289, 21.271, 0.7883], atol=6e-4)

    def test_trapezoidal_step_is_about_2_ms(self) -> None:
        assert best_step() == pytest.approx(2e-3, rel=0.05)

    def test_printed_mean_errors_of_frequency_follow_from_the_printed_modes(self) -> None:
        for case in CASES:
            # Printed to three digits.
            assert np.mean(np.abs(np.subtract(case.wn, ACTUAL_WN))) == pytest.approx(case.mae[0], rel=5e-3)
        assert np.mean(np.abs(np.subtract(CASES[0].zeta, ACTUAL_ZETA))) == pytest.approx(CASES[0].mae[1], rel=5e-3)

    def test_noise_has_the_stated_ratio_and_is_common_to_all_channel_sets(self) -> None:
        case = CASES[1]
        noisy, clean = case_record(case, ("tire",), seed=3), clean_record()
        noise = np.asarray(noisy.y).ravel() - np.asarray(clean.y)[2]
        # 5000 samples give their own power to 2 %, that is 0.09 dB; four of these.
        power = 10 * np.log10(np.mean(np.asarray(clean.y)[2] ** 2) / np.mean(noise**2))
        assert power == pytest.approx(case.snr_db, abs=0.35)
        three = np.asarray(case_record(case, ("seat", "chassis", "tire"), seed=3).y)
        np.testing.assert_array_equal(three[2], np.asarray(noisy.y).ravel())

    def test_record_is_the_stated_one(self) -> None:
        record = clean_record()
        assert np.asarray(record.y).shape == (3, 5000)
        expected = free_decay(paper_car(), np.asarray(record.time), initial_state=START)
        np.testing.assert_array_equal(record.y, expected.y)
        assert np.diff(record.time) == pytest.approx(1 / RATE)


class TestStudy:
    def test_counts_lost_modes(self) -> None:
        nan = np.nan
        wn = np.array([[21.0, 50.0, 84.0], [21.0, nan, 84.0], [nan, nan, nan]])
        study = Study(bandwidth=22.0, wn=wn, zeta=wn)
        assert study.found.sum(axis=0).tolist() == [2, 1, 2]
        assert study.complete.tolist() == [True, False, False]

    def test_a_mode_is_found_by_its_pole_not_by_its_frequency_alone(self) -> None:
        truth = eigenmodes(paper_car())
        # The second has the right frequency and far too much damping.
        estimate = ModalSet.from_wn_zeta(truth.wn * [1.04, 1.0, 1.0], truth.zeta + np.array([0.0, 0.2, 0.04]))
        wn, zeta = matched(estimate, truth)
        np.testing.assert_array_equal(np.isfinite(wn), [True, False, True])
        assert zeta[2] - truth.zeta[2] == pytest.approx(0.04)
        assert np.all(np.isnan(matched(None, truth)))


class TestReport:
    def test_writes_what_is_asked_for_where_it_is_asked_for(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        monkeypatch.setattr("validation.free_decay.report", lambda: "# Decay\n")
        out = tmp_path / "new" / "folder"
        assert main(["free_decay", "--out", str(out)]) == 0
        assert (out / "free_decay.md").read_text(encoding="utf-8") == "# Decay\n"
        assert capsys.readouterr().out.split() == [str(out / "free_decay.md")]

    @pytest.mark.slow
    def test_paper_runs_on_few_draws(self) -> None:
        text = report(seeds=3, workers=1, channel_sets=(("tire",),), candidates=(25.0, 50.0))
        lines = text.splitlines()
        assert [line for line in lines if line.startswith("## Table 2")] == ["## Table 2, from the tire alone"]
        for case in CASES:
            assert f"**{case.name}**" in text
            assert any(cells(line)[1:6:2] == [f"{w:.4f}" for w in case.wn] for line in lines)
        for label in ("bound", "ridge, found of 3", "ridge, RMSE / bound"):
            assert sum(cells(line)[0] == label for line in lines) >= 1, label

    def test_same_picture_twice(self, tmp_path: Path) -> None:
        first, second = (save(draw_responses(), tmp_path / name).read_bytes() for name in ("a.png", "b.png"))
        assert first == second

    def test_unknown_report_is_refused_by_name(self, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
        with pytest.raises(SystemExit) as refusal:
            main(["papers", "--out", str(tmp_path)])
        assert refusal.value.code == 2
        assert "no report 'papers'; choose from paper" in capsys.readouterr().err

    def test_committed_truth_equals_the_truth(self) -> None:
        text = (FOLDER / "paper.md").read_text(encoding="utf-8")
        rows = [cells(line) for line in text.splitlines() if line.startswith("|")]
        for row in damping_rows():
            assert row in rows, row
        for row in truth_rows():
            # Once for the seat, the tire and all three.
            assert rows.count(row) == 3, row

    def test_committed_bounds_equal_the_bounds(self) -> None:
        text = (FOLDER / "paper.md").read_text(encoding="utf-8")
        printed = [
            [float(cell) for cell in cells(line)[1:7]] for line in text.splitlines() if re.match(r"\| bound ", line)
        ]
        expected = [
            bound(snr, channels)
            for channels in (("seat",), ("tire",), ("seat", "chassis", "tire"))
            for snr in (20.0, 2.0, 20.0, 2.0)
        ]
        assert len(printed) == len(expected)
        for row, least in zip(printed, expected, strict=True):
            # Printed to two digits.
            np.testing.assert_allclose(row[0::2], least.wn_std[::-1], rtol=0.05)
            np.testing.assert_allclose(row[1::2], 100 * least.zeta_std[::-1], rtol=0.05)

    def test_committed_pictures_are_there(self) -> None:
        text = (FOLDER / "paper.md").read_text(encoding="utf-8")
        names = re.findall(r"\]\((\S+\.png)\)", text)
        assert len(names) == 2 + len(CASES)
        for name in names:
            assert (FOLDER / name).read_bytes()[:4] == b"\x89PNG"


class TestSpeedRatios:
    """The comparison of a run with the committed ratios, on numbers of known distribution."""

    @staticmethod
    def runs(rng: np.random.Generator, factor: float = 1.0, *, scatter: float = 0.05) -> list[float]:
        return [float(x) for x in 3.0 * factor * np.exp(scatter * rng.standard_normal(speed_ratios.PROCESSES))]

    def test_false_alarms_stay_below_the_level(self) -> None:
        rng, alarms, trials = np.random.default_rng(5), 0, 1000
        for _ in range(trials):
            before = {name: self.runs(rng, scatter=0.3) for name in "abcdefgh"}
            now = {name: self.runs(rng, scatter=0.3) for name in "abcdefgh"}
            alarms += any(change.slower for change in speed_ratios.changes(before, now))
        # Three standard deviations of the count above what the level allows.
        assert alarms <= trials * speed_ratios.LEVEL + 3 * (trials * speed_ratios.LEVEL) ** 0.5

    def test_one_call_twice_as_slow_is_named_with_its_factor(self) -> None:
        rng = np.random.default_rng(6)
        before = {name: self.runs(rng) for name in "abcdefgh"}
        now = {name: self.runs(rng, 2.0 if name == "c" else 1.0) for name in "abcdefgh"}
        found = speed_ratios.changes(before, now)
        assert [change.name for change in found if change.slower] == ["c"]
        slow = next(change for change in found if change.slower)
        assert slow.before
        assert slow.now
        # Two means of five values with 5 % scatter: 3 standard deviations of their quotient.
        assert slow.now / slow.before == pytest.approx(2.0, rel=3 * 0.05 * (2 / 5) ** 0.5)
        assert "c: " in speed_ratios.comparison_text(found)

    def test_a_faster_call_is_no_alarm(self) -> None:
        rng = np.random.default_rng(7)
        before, now = {"a": self.runs(rng, 2.0), "b": self.runs(rng)}, {"a": self.runs(rng), "b": self.runs(rng)}
        assert "No call got slower." in speed_ratios.comparison_text(speed_ratios.changes(before, now))

    @pytest.mark.parametrize(("factor", "slower"), [(1.05, False), (1.2, True)])
    def test_without_scatter_only_the_least_slowdown_worth_telling_counts(self, factor: float, slower: bool) -> None:
        (change,) = speed_ratios.changes({"a": [2.0, 2.0]}, {"a": [2.0 * factor, 2.0 * factor]})
        assert change.slower is slower

    def test_the_p_value_is_that_of_scipys_welch_test(self) -> None:
        from scipy.stats import ttest_ind

        rng = np.random.default_rng(8)
        before, now = self.runs(rng), [*self.runs(rng, 1.1), 3.3]
        (change,) = speed_ratios.changes({"a": before}, {"a": now})
        expected = ttest_ind(np.log(now), np.log(before), equal_var=False, alternative="greater").pvalue
        assert change.p_value == pytest.approx(expected, rel=1e-9)

    def test_calls_in_one_run_only_are_listed_and_not_judged(self) -> None:
        found = speed_ratios.changes({"old": [1.0, 1.1]}, {"new": [9.0, 9.1]})
        text = speed_ratios.comparison_text(found)
        assert not any(change.slower for change in found)
        assert "not measured before" in text
        assert "no longer measured" in text

    def test_ratios_are_least_durations_over_that_of_the_yardstick(self, monkeypatch: pytest.MonkeyPatch) -> None:
        # A clock that moves only as the calls say: the first round is slow, the yardstick takes 2 s.
        clock, durations = [0.0], iter([50.0, 6.0, 5.0, 7.0])

        def advance(seconds: float) -> None:
            clock[0] += seconds

        monkeypatch.setattr("time.process_time", lambda: clock[0])
        monkeypatch.setattr(speed_ratios, "yardstick", lambda: advance(2.0))
        found = speed_ratios.ratios({"call": lambda: advance(next(durations))}, rounds=3)
        assert found == {"call": 2.5}

    def test_written_ratios_are_read_again(self, tmp_path: Path) -> None:
        speed_ratios.write_ratios(tmp_path / "speed.json", {"a": [1.5, 2.25]})
        assert speed_ratios.read_ratios(tmp_path / "speed.json") == {"a": [1.5, 2.25]}

    @pytest.mark.parametrize("content", ["", "[]", '{"ratios": 3}', '{"ratios": {"a": ["x"]}}'])
    def test_a_file_of_another_kind_is_refused(self, tmp_path: Path, content: str) -> None:
        (tmp_path / "speed.json").write_text(content)
        with pytest.raises(InputError, match="no ratios to compare with"):
            speed_ratios.read_ratios(tmp_path / "speed.json")

    @pytest.mark.parametrize("values", [[1.0], [1.0, 0.0], [1.0, float("nan")]])
    def test_too_few_or_impossible_ratios_are_refused(self, values: list[float]) -> None:
        with pytest.raises(InputError, match="at least two positive numbers"):
            speed_ratios.changes({"a": [1.0, 2.0]}, {"a": values})

    @pytest.mark.parametrize(("factor", "code"), [(1.0, 0), (2.0, 1)])
    def test_the_exit_code_says_whether_a_call_got_slower(
        self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, factor: float, code: int
    ) -> None:
        monkeypatch.setattr(speed_ratios, "measured", lambda: {"a": [2.0 * factor, 2.1 * factor, 2.2 * factor]})
        speed_ratios.write_ratios(tmp_path / "speed.json", {"a": [2.0, 2.1, 2.2]})
        assert main(["speed", "--against", str(tmp_path / "speed.json")]) == code

    def test_against_belongs_to_speed_alone(self) -> None:
        with pytest.raises(SystemExit):
            main(["paper", "--against"])

    def test_the_committed_ratios_are_of_the_calls_measured_today(self) -> None:
        assert set(speed_ratios.read_ratios(RATIOS)) == set(speed_ratios.calls())
