"""The reports that judge the library: their bound, their truth, and that they run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from suspid import InputError, ModalSet, eigenmodes, free_decay, statespace
from validation.__main__ import FOLDER, main
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
