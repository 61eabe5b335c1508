"""Comparisons: pairs by nearness, limits as documented, and a text that explains itself."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from suspid import (
    InputError,
    ModalSet,
    Suspension,
    assert_modes_close,
    eigenmodes,
    quarter_car,
    reconstruct,
    statespace,
)
from suspid.model.compare import compare
from suspid.model.found_parameters import found_parameters
from suspid.model.matching import modal_assurance


def car(*, chassis_damping: float = 1500.0, tire_damping: float = 0.0) -> Suspension:
    return quarter_car(
        chassis_mass=400,
        tire_mass=40,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        chassis_damping=chassis_damping,
        tire_damping=tire_damping,
    )


class TestPairing:
    def test_a_missing_first_mode_does_not_shift_the_others(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0, 50.0, 80.0], [0.1, 0.1, 0.1])
        c = compare(ModalSet.from_wn_zeta([50.0, 80.0], [0.1, 0.1]), expected)
        assert not c.passed
        assert [row.verdict for row in c.table] == ["missing", "missing", "ok", "ok", "ok", "ok"]
        assert c.mae["wn"] == 0.0
        assert "missing" in str(c)

    def test_an_extra_mode_fails(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0, 80.0], [0.1, 0.1])
        c = compare(ModalSet.from_wn_zeta([10.0, 50.0, 80.0], [0.1, 0.1, 0.1]), expected, rtol=0.99)
        assert not c.passed
        assert [(row.item, row.found) for row in c.table if row.verdict == "extra"] == [
            ("found 2", 50.0),
            ("found 2", 0.1),
        ]

    def test_strangers_are_not_paired(self) -> None:
        c = compare(ModalSet.from_wn_zeta([10.0], [0.1]), ModalSet.from_wn_zeta([80.0], [0.1]), rtol=0.1)
        assert {row.verdict for row in c.table} == {"missing", "extra"}
        assert np.isnan(c.mae["wn"])

    def test_a_missing_mode_and_a_new_one_do_not_shift_the_others(self) -> None:
        found, expected = (ModalSet.from_wn_zeta(wn, [0.02] * 3) for wn in ([35, 51, 70], [20, 35, 51]))
        c = compare(found, expected, rtol=0.01)
        assert [row.verdict for row in c.table] == ["missing"] * 2 + ["ok"] * 4 + ["extra"] * 2

    def test_shapes_decide_between_crossed_close_modes(self) -> None:
        shapes = np.eye(2)
        expected = ModalSet.from_wn_zeta([10.0, 10.1], [0.02, 0.02], shapes=shapes, channels=["a", "b"])
        # The estimate's frequencies have crossed: by poles alone mode 1 would be taken for mode 2.
        found = ModalSet.from_wn_zeta([10.02, 10.08], [0.02, 0.02], shapes=shapes[:, ::-1], channels=["a", "b"])
        c = compare(found, expected)
        assert [row.found for row in c.table if row.quantity == "wn"] == pytest.approx([10.08, 10.02], rel=1e-12)
        assert c.mac is not None
        np.testing.assert_allclose(c.mac, [1.0, 1.0], atol=1e-15, err_msg="each shape beside itself")

    @given(st.permutations(range(4)))
    def test_the_order_of_the_entries_says_nothing(self, order: list[int]) -> None:
        poles = np.array([-1 + 10j, -20.0, -2 + 50j, -1 + 51j])
        assert compare(ModalSet(poles=poles[order]), ModalSet(poles=poles)).passed


class TestMeanAbsoluteError:
    def test_equation_22_on_table_2(self) -> None:
        """The paper's first row: MAE 4.77e-3 rad/s and 5.53e-3 %."""
        actual = ModalSet.from_wn_zeta([83.67, 50.09, 21.26], [0.0155, 0.0252, 0.0079])
        original = ModalSet.from_wn_zeta([83.6732, 50.0925, 21.2686], [0.015568, 0.025293, 0.007905])
        c = compare(original, actual, rtol=1e-2)
        assert c.passed, c
        # The table prints three digits.
        assert c.mae["wn"] == pytest.approx(4.77e-3, abs=0.5e-5)
        assert c.mae["zeta"] == pytest.approx(5.53e-5, abs=0.5e-7)

    def test_errors_of_both_signs_do_not_cancel(self) -> None:
        """An error is found less expected; its mean is one of moduli."""
        c = compare(ModalSet.from_wn_zeta([11.0, 49.0], [0.1, 0.1]), ModalSet.from_wn_zeta([10.0, 50.0], [0.1, 0.1]))
        assert [row.error for row in c.table if row.quantity == "wn"] == pytest.approx([1.0, -1.0])
        assert c.mae["wn"] == pytest.approx(1.0)


class TestLimits:
    def test_just_inside_and_just_outside_rtol(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0], [0.1])
        assert compare(ModalSet.from_wn_zeta([10.0099], [0.1]), expected, rtol=1e-3).passed
        c = compare(ModalSet.from_wn_zeta([10.0101], [0.1]), expected, rtol=1e-3)
        assert [row.verdict for row in c.table] == ["off", "ok"]
        assert "off" in str(c)
        assert "1 of 2 values fail" in str(c)

    def test_without_rtol_the_interval_of_the_estimate_decides(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0], [0.1])
        # 1.96 standard deviations: 0.0196 rad/s and 0.00196.
        inside = ModalSet.from_wn_zeta([10.0195], [0.1019], wn_std=[0.01], zeta_std=[0.001])
        assert compare(inside, expected).passed
        outside = ModalSet.from_wn_zeta([10.0197], [0.1021], wn_std=[0.01], zeta_std=[0.001])
        assert [row.verdict for row in compare(outside, expected).table] == ["off", "off"]

    def test_sigmas_widen_the_intervals(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0], [0.1])
        found = ModalSet.from_wn_zeta([10.029], [0.1031], wn_std=[0.01], zeta_std=[0.001])
        assert [row.verdict for row in compare(found, expected, sigmas=3).table] == ["ok", "off"]
        assert "3 standard deviations" in str(compare(found, expected, sigmas=3))

    def test_each_quantity_has_a_limit_of_its_own(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0], [0.1])
        found = ModalSet.from_wn_zeta([10.02], [0.104], wn_std=[0.01], zeta_std=[0.001])
        c = compare(found, expected, rtol={"zeta": 0.05})
        assert [row.verdict for row in c.table] == ["off", "ok"]
        assert compare(found, expected, rtol={"zeta": 0.05}, sigmas=2.5)
        with pytest.raises(InputError, match="mac"):
            compare(found, expected, rtol={"mac": 0.9})

    def test_sigmas_need_standard_deviations(self) -> None:
        modes = ModalSet.from_wn_zeta([10.0], [0.1])
        with pytest.raises(InputError, match="give rtol"):
            compare(modes, modes, sigmas=3)

    def test_two_estimates_differ_by_both_their_spreads(self) -> None:
        a = ModalSet.from_wn_zeta([10.0], [0.1], wn_std=[0.03], zeta_std=[0.01])
        b = ModalSet.from_wn_zeta([10.0], [0.1], wn_std=[0.04], zeta_std=[0.01])
        wn = compare(a, b).table[0]
        assert wn.allowed == pytest.approx(1.959964 * 0.05, rel=1e-6)

    def test_each_mode_is_judged_by_its_own_spread(self) -> None:
        """Also where a mode that the other set lacks shifts the numbers: the spread goes with the mode."""
        a = ModalSet.from_wn_zeta([10.0, 50.0], [0.1, 0.2], wn_std=[0.03, 0.5], zeta_std=[0.01, 0.03])
        b = ModalSet.from_wn_zeta([50.0], [0.2], wn_std=[1.2], zeta_std=[0.04])
        both = 1.959964 * np.array([1.3, 0.05])
        for found, expected in ((a, b), (b, a)):
            shared = [row.allowed for row in compare(found, expected).table if row.error is not None]
            np.testing.assert_allclose(shared, both, rtol=1e-6, err_msg="five, twelve, thirteen; three, four, five")

    def test_exact_modes_must_agree_to_nine_digits(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0], [0.1])
        assert compare(ModalSet.from_wn_zeta([10.0 * (1 + 5e-10)], [0.1]), expected).passed
        assert not compare(ModalSet.from_wn_zeta([10.0 * (1 + 5e-9)], [0.1]), expected).passed

    def test_an_expected_zero_is_judged_against_the_largest_of_its_kind(self) -> None:
        expected = ModalSet.from_wn_zeta([10.0, 50.0], [0.0, 0.2])
        assert compare(ModalSet.from_wn_zeta([10.0, 50.0], [0.0019, 0.2]), expected, rtol=1e-2).passed
        assert not compare(ModalSet.from_wn_zeta([10.0, 50.0], [0.0021, 0.2]), expected, rtol=1e-2).passed

    def test_a_missing_damper_is_judged_against_the_strongest(self) -> None:
        assert compare(car(tire_damping=1.4), car(), rtol=1e-3).passed
        assert not compare(car(tire_damping=1.6), car(), rtol=1e-3).passed

    @pytest.mark.parametrize("split", [[6e-7j], [-1e-6, 1e-6]])
    def test_a_double_pole_at_zero_that_rounding_splits_is_one(self, split: list[complex]) -> None:
        """A free mass has it; of its split the square is rounding, so that the parts are 1e-8 of the largest pole."""
        expected = ModalSet(poles=np.array([0.0, 0.0, -1 + 50j]))
        found = ModalSet(poles=np.array([*split, -1 + 50j]))
        assert compare(found, expected, rtol=1e-6), compare(found, expected, rtol=1e-6)
        assert not compare(found, expected)
        assert not compare(found[1:], expected, rtol=1e-6)
        assert not compare(found, expected[1:], rtol=1e-9)

    def test_dampers_of_an_undamped_car_are_judged_against_critical_damping(self) -> None:
        """Two times the root of the stiffest spring, 200e3 N/m, and the largest mass, 400 kg: 17889 N s/m."""
        undamped = car(chassis_damping=0.0)
        assert compare(car(chassis_damping=17.8), undamped, rtol=1e-3)
        assert not compare(car(chassis_damping=18.0), undamped, rtol=1e-3)

    def test_modes_that_the_limit_reaches_are_paired(self) -> None:
        """As far apart as 0.6 of the larger one."""
        found, expected = (ModalSet.from_wn_zeta([wn], [0.1]) for wn in (10.0, 25.0))
        assert compare(found, expected, rtol=0.7)
        assert {row.verdict for row in compare(found, expected, rtol=0.4).table} == {"missing", "extra"}

    def test_rounding_of_undamped_modes_passes(self) -> None:
        expected = ModalSet(poles=np.array([1e-16 + 10j, -3e-17 + 50j]))
        assert compare(ModalSet(poles=np.array([10j, 50j])), expected).passed


class TestSuspensions:
    def test_every_parameter_has_a_row_with_its_unit(self) -> None:
        c = compare(car(chassis_damping=1530.0), car(), rtol=1e-3)
        assert [(row.item, row.quantity, row.unit) for row in c.table if row.verdict == "off"] == [
            ("chassis", "damping", "N s/m")
        ]
        assert len(c.table) == 6
        assert c.mae["damping"] == 15.0
        assert c.mae["stiffness"] == 0.0
        assert "[N s/m]" in str(c)

    def test_masses_count(self) -> None:
        assert not compare(car().with_parameters(masses={"tire": 41.0}), car(), rtol=1e-3).passed

    def test_mounts_count(self) -> None:
        mounted, softer = (car().with_parameters(mount_stiffness={"chassis": k}) for k in (1e6, 0.9e6))
        assert compare(mounted, mounted).passed
        assert {row.quantity for row in compare(car(), car()).table} == {"stiffness", "damping", "mass"}
        for found, expected, verdict in (
            (softer, mounted, "off"), (car(), mounted, "missing"), (mounted, car(), "extra"),
        ):  # fmt: skip
            c = compare(found, expected, rtol=0.05)
            assert [row.verdict for row in c.table if row.quantity == "mount_stiffness"] == [verdict]
            assert not c.passed
            assert "mount_stiffness [N/m]" in str(c)

    def test_friction_and_curves_count(self) -> None:
        """Forces of found and expected, each on its side, in both directions of motion."""
        curve = [(-0.5, -400.0), (0.0, 0.0), (0.5, 800.0)]
        first, tire = car().struts
        bent = Suspension(masses=car().masses, struts=[replace(first, damping=0.0, curve=curve, friction=30.0), tire])
        rows = [row for row in compare(bent, car(), rtol=0.05).table if row.quantity in ("friction", "force")]
        # 1500 N s/m at half a metre a second.
        assert [(row.found, row.expected) for row in rows] == [(30.0, 0.0), (-400.0, -750.0), (800.0, 750.0)]
        assert [row.item for row in rows] == ["chassis", "chassis at -0.5 m/s", "chassis at 0.5 m/s"]
        assert compare(bent, bent)

    def test_what_a_reconstruction_allows_is_its_interval(self) -> None:
        """Far from bounds it is symmetric, and as wide as the standard deviations at every level."""
        modes = eigenmodes(car(tire_damping=100.0))
        rough = ModalSet.from_wn_zeta(modes.wn, modes.zeta, wn_std=1e-4 * modes.wn, zeta_std=1e-3 * modes.zeta)
        found = reconstruct(rough, car(tire_damping=100.0), fixed=["tire.damping"])
        for sigmas, level in ((None, 0.95), (2.5758293, 0.99)):
            half = {name: (high - low) / 2 for name, (low, high) in found.interval(level).items()}
            rows = compare(found, car(tire_damping=100.0), sigmas=sigmas).table
            shown = {f"{row.item}.{row.quantity}": row.allowed for row in rows}
            assert shown == pytest.approx(half, rel=1e-6)
            ends = found_parameters(found).interval(level)
            assert {name: (high - low) / 2 for name, (low, high) in ends.items()} == pytest.approx(half, rel=1e-6)

    def test_another_topology_is_refused_by_name(self) -> None:
        with_seat = quarter_car(
            seat_mass=80,
            chassis_mass=400,
            tire_mass=40,
            seat_stiffness=10e3,
            chassis_stiffness=20e3,
            tire_stiffness=200e3,
            seat_damping=500,
            chassis_damping=1500,
        )
        with pytest.raises(InputError, match="seat"):
            compare(car(), with_seat)

    def test_other_arms_are_refused(self) -> None:
        first, second = car().struts
        other = Suspension(masses=car().masses, struts=[replace(first, arms={"chassis": 1.0, "tire": -1.2}), second])
        with pytest.raises(InputError, match="arms"):
            compare(other, car())


class TestModalAssurance:
    @given(st.complex_numbers(min_magnitude=1e-3, max_magnitude=1e3), st.integers(0, 10**6))
    def test_a_complex_factor_changes_nothing(self, factor: complex, seed: int) -> None:
        rng = np.random.default_rng(seed)
        a = rng.standard_normal((3, 2)) + 1j * rng.standard_normal((3, 2))
        b = rng.standard_normal((3, 2)) + 1j * rng.standard_normal((3, 2))
        mac = modal_assurance(a, b)
        np.testing.assert_allclose(modal_assurance(a, factor * b), mac, atol=1e-12, err_msg="rounding alone")
        np.testing.assert_allclose(np.diag(modal_assurance(a, a)), 1.0, atol=1e-12, err_msg="a shape beside itself")
        assert np.all(mac <= 1 + 1e-12)  # Cauchy and Schwarz

    def test_orthogonal_shapes_and_a_zero_shape(self) -> None:
        a = np.array([[1.0, 0.0], [1j, 0.0]])
        # The conjugate matters: without it these two would give 1.
        np.testing.assert_array_equal(modal_assurance(a, np.array([[1.0], [-1j]])), [[0.0], [0.0]])

    def test_common_channels_in_any_order(self) -> None:
        modes = eigenmodes(car())
        assert modes.shapes is not None
        turned = ModalSet(poles=modes.poles, shapes=modes.shapes[::-1] * 2j, channels=modes.channels[::-1])
        mac = compare(turned, modes).mac
        assert mac is not None
        np.testing.assert_allclose(mac, 1.0, atol=1e-12, err_msg="the same shapes, rounding alone")


class TestRefusals:
    def test_mixed_types(self) -> None:
        with pytest.raises(InputError, match=r"ModalSet and Suspension"):
            compare(eigenmodes(car()), car())

    @pytest.mark.parametrize("rtol", [-1e-3, float("nan"), float("inf")])
    def test_rtol(self, rtol: float) -> None:
        with pytest.raises(InputError, match="rtol"):
            compare(car(), car(), rtol=rtol)


class TestTruth:
    def test_a_failed_comparison_is_false(self) -> None:
        one, other = ModalSet.from_wn_zeta([10.0], [0.1]), ModalSet.from_wn_zeta([12.0], [0.1])
        assert compare(one, one)
        assert not compare(one, other)


class TestAssertion:
    def test_it_fails_with_the_table_and_takes_what_has_modes(self) -> None:
        modes = eigenmodes(car())
        near = ModalSet.from_wn_zeta(modes.wn * 1.001, modes.zeta * 0.98)
        assert_modes_close(near, car(), rtol_wn=0.0011, rtol_zeta=0.021)
        with pytest.raises(AssertionError, match="2 of 4 values fail") as failed:
            assert_modes_close(near, car(), rtol_wn=0.0011, rtol_zeta=0.019)
        assert str(failed.value) == str(compare(near, modes, rtol={"wn": 0.0011, "zeta": 0.019}))

    def test_a_missing_mode_fails_however_wide_the_limits(self) -> None:
        modes = eigenmodes(car())
        with pytest.raises(AssertionError, match="missing"):
            assert_modes_close(ModalSet(poles=modes.poles[:1]), modes, rtol_wn=0.4, rtol_zeta=0.99)

    def test_what_has_no_modes_is_named(self) -> None:
        with pytest.raises(InputError, match=r"found is a list.*python-control.*identify\(record\)"):
            assert_modes_close([1.0], car())  # type: ignore[arg-type]

    def test_systems_and_cars_that_were_found_have_modes(self) -> None:
        modes = eigenmodes(car())
        found = reconstruct(modes, car())
        for one in (statespace(car()), found, found.suspension):
            assert_modes_close(one, modes, rtol_wn=1e-6, rtol_zeta=1e-6)
            with pytest.raises(AssertionError, match="values fail"):
                assert_modes_close(one, ModalSet.from_wn_zeta(1.1 * modes.wn, modes.zeta), rtol_wn=0.01)

    @pytest.mark.parametrize("rtol", [1.0, 5.0, -0.1, float("nan")])
    def test_compare_and_assertion_take_the_same_ratios(self, rtol: float) -> None:
        said = set()
        for name, call in (
            ("rtol", lambda: compare(car(), car(), rtol=rtol)),
            ("rtol", lambda: compare(eigenmodes(car()), eigenmodes(car()), rtol=rtol)),
            ("rtol['zeta']", lambda: compare(eigenmodes(car()), eigenmodes(car()), rtol={"zeta": rtol})),
            ("rtol_wn", lambda: assert_modes_close(car(), car(), rtol_wn=rtol)),
        ):
            with pytest.raises(InputError) as refused:
                call()
            before, _, rule = str(refused.value).partition("=")
            assert before == name
            said.add(rule)
        assert len(said) == 1

    def test_percents_are_no_ratios(self) -> None:
        with pytest.raises(InputError, match=r"rtol_wn=1 allows an error of 100%: .* 1 % is 0\.01"):
            assert_modes_close(car(), car(), rtol_wn=1.0)
        with pytest.raises(InputError, match="rtol_zeta=5 allows an error of 500%"):
            assert_modes_close(car(), car(), rtol_zeta=5.0)

    def test_a_failing_test_shows_no_line_of_the_library(self, tmp_path: Path) -> None:
        """In a run of pytest by itself: the table stands below the line of the test."""
        path = tmp_path / "test_modes.py"
        path.write_text(
            "from suspid import ModalSet, assert_modes_close\n"
            "def test_modes():\n"
            "    assert_modes_close(ModalSet.from_wn_zeta([10.0], [0.1]), ModalSet.from_wn_zeta([12.0], [0.1]))\n"
        )
        command = [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider", str(path)]
        said = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False).stdout
        assert re.search(r"E +mode 1 +wn \[rad/s\] +10 +12 ", said)
        assert "arguments.py" not in said
        assert "assert_modes_close.py" not in said


def test_what_has_no_modes_on_either_side_is_not_judged() -> None:
    nothing = ModalSet.from_wn_zeta([], [])
    with pytest.raises(InputError, match="nothing to compare"):
        assert_modes_close(nothing, nothing)
