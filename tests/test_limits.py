"""Limits: met, not met or cannot tell by whole intervals, and files that a person writes."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from suspid import (
    InputError,
    Limit,
    ModalSet,
    Reconstruction,
    check_limits,
    eigenmodes,
    quarter_car,
    read_limits,
    reconstruct,
)
from suspid.analysis.limits import limits_from_toml
from suspid.cli import main
from suspid.reporting.limit_rows import limit_rows
from suspid.text_tables import TERMINAL
from suspid.words import Check, Level, Remark, Verdict
from suspid.words.limits import LimitReason

CAR = quarter_car(chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500)


@pytest.fixture(scope="module")
def found() -> Reconstruction:
    exact = eigenmodes(CAR)
    rough = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=1e-3 * exact.wn, zeta_std=1e-2 * exact.zeta)
    return reconstruct(rough, CAR.with_parameters(stiffness={"chassis": 22e3}), fixed=["tire.damping"])


def state(found: Reconstruction, *, least: float = -math.inf, most: float = math.inf) -> str:
    (row,) = check_limits(found, [Limit(of="chassis", quantity="damping", least=least, most=most)]).rows
    return str(row.state)


class TestIntervals:
    def test_the_whole_interval_decides(self, found: Reconstruction) -> None:
        low, high = found.interval(0.95)["chassis.damping"]
        step = 1e-3 * (high - low)
        assert state(found, least=low - step) == "met"
        assert state(found, least=low + step) == "cannot tell"
        assert state(found, least=high - step) == "cannot tell"
        assert state(found, least=high + step) == "not met"
        assert state(found, most=high + step) == "met"
        assert state(found, most=low - step) == "not met"
        assert state(found, most=low + step) == "cannot tell"
        assert state(found, most=high - step) == "cannot tell"
        assert state(found, least=low - step, most=high + step) == "met"
        assert state(found, least=low + step, most=high + step) == "cannot tell"

    def test_the_text_writes_out_what_decides(self, found: Reconstruction) -> None:
        """Ends are told apart and have no exponent: in N/m, and within a millionth of the limit."""
        checked = check_limits(found, [Limit(of="tire", quantity="stiffness", least=1.9e5)])
        (row,) = checked.rows
        close = replace(row, value=123456.7, lower=123456.6, upper=123456.8)
        for one in (row, close):
            line = next(text for text in str(replace(checked, rows=(one,))).splitlines() if "at least" in text)
            value, low, _, high = line.partition("190000")[2].split()[:4]
            assert "e" not in value + low + high
            half = (one.upper - one.lower) / 2
            shown = [float(text) for text in (value, low, high)]
            # Two digits of half the interval are within 5 in 100 of it.
            assert shown == pytest.approx([one.value, one.lower, one.upper], abs=0.05 * half + 0.5 * (half > 10))

    def test_so_many_tests_joined_would_tell(self, found: Reconstruction) -> None:
        low, high = found.interval(0.95)["chassis.damping"]
        value, reach = (low + high) / 2, (high - low) / 2
        # The interval of n tests is shorter by the root of n: a limit at 0.45 of the reach takes five.
        (row,) = check_limits(found, [Limit(of="chassis", quantity="damping", least=value - 0.45 * reach)]).rows
        assert row.why is not None
        assert row.why.numbers["tests"] == 5
        assert "about 5 such tests" in str(row.why)

    def test_the_table_fits_a_terminal(self, found: Reconstruction) -> None:
        limits = limits_from_toml(
            "[struts.chassis]\nstiffness = { min = 10000.5, max = 30000.25 }\n"
            f"damping = {{ min = {sum(found.interval(0.95)['chassis.damping']) / 2:.2f} }}\n"
        )
        lines = str(check_limits(found, limits)).splitlines()
        assert any(line.endswith("cannot tell") for line in lines)
        assert max(len(line) for line in lines if "  " in line.strip()) <= TERMINAL

    def test_each_state_has_its_own_mark_on_the_page(self, found: Reconstruction) -> None:
        low, high = found.interval(0.95)["chassis.damping"]
        limits = [
            Limit(of="chassis", quantity="damping", least=least) for least in (0.5 * low, 2 * high, (low + high) / 2)
        ]
        rows = limit_rows(check_limits(found, limits))
        assert [(row.state, row.style) for row in rows] == [
            ("met", "met"), ("not met", "missed"), ("cannot tell", "open"),
        ]  # fmt: skip

    def test_the_page_has_the_unit_of_the_limit(self, found: Reconstruction) -> None:
        """Value and half of the interval in N/mm are a thousandth of those in N/m."""
        asked = [Limit(of="tire", quantity="stiffness", least=1.9e5, unit=unit) for unit in ("N/m", "N/mm")]
        low, high = found.interval(0.95)["tire.stiffness"]
        for row, scale in zip(limit_rows(check_limits(found, asked)), (1.0, 1e3), strict=True):
            half = (high - low) / 2 / scale
            assert float(row.value.reach) == pytest.approx(half, rel=0.05)
            assert float(row.value.value) == pytest.approx((high + low) / 2 / scale, abs=0.05 * half)
            assert row.asked == f"at least {1.9e5 / scale:.0f}"

    def test_what_was_held_or_does_not_explain_is_not_judged(self, found: Reconstruction) -> None:
        (held,) = check_limits(found, [Limit(of="tire", quantity="damping", least=-1.0)]).rows
        assert held.why is not None
        assert held.why.code is LimitReason.HELD
        (bad,) = check_limits(replace(found, explains=False), [Limit(of="chassis", quantity="damping", least=1.0)]).rows
        assert bad.why is not None
        assert bad.why.code is LimitReason.UNEXPLAINED

    @pytest.mark.parametrize("level", [Level.NONE, Level.DOUBTFUL, Level.CARE])
    def test_a_result_that_is_not_to_be_used_meets_no_limit(
        self, found: Reconstruction, level: Level, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        said = Remark(LimitReason.DOUBTFUL)
        monkeypatch.setattr(Reconstruction, "verdict", Verdict(said, (Check(said, level),)))
        usable = level > Level.DOUBTFUL
        assert state(found, least=1.0) == ("met" if usable else "cannot tell")
        assert state(found, most=1.0) == ("not met" if usable else "cannot tell")

    def test_another_car_with_the_same_modes_must_meet_it_too(self, found: Reconstruction) -> None:
        other = CAR.with_parameters(damping={"chassis": 900.0})
        twins = replace(found, alternatives=(other,), distances=(1.0,), told_apart=("",))
        assert state(twins, least=1200.0) == "cannot tell"
        assert state(twins, least=600.0) == "met"

    def test_a_strut_that_is_not_there_is_named(self, found: Reconstruction) -> None:
        with pytest.raises(InputError, match=r"chasis.*chassis"):
            check_limits(found, [Limit(of="chasis", quantity="damping", least=1.0)])


class TestFiles:
    def test_units_are_converted(self) -> None:
        text = """
        [modes.1]
        wn = { min = 1.0, max = 1.5, unit = "Hz" }
        zeta = { min = 20, unit = "%" }
        [modes.hop]
        near_hz = 11
        zeta = { max = 0.4 }
        [struts.chassis]
        stiffness = { min = 18, max = 22, unit = "N/mm" }
        damping = { min = 1200 }
        """
        wn, zeta, hop, stiffness, damping = limits_from_toml(text)
        assert (wn.least, wn.most) == pytest.approx((2 * np.pi, 3 * np.pi))
        assert zeta == Limit(of=1, quantity="zeta", least=0.2, unit="%")
        assert (hop.of, hop.near, hop.most) == ("hop", 11.0, 0.4)
        assert (stiffness.least, stiffness.most) == (18e3, 22e3)
        assert (damping.least, damping.most, damping.unit) == (1200.0, math.inf, "N s/m")
        assert str(stiffness) == "18 to 22"

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            ("", "is empty"),
            ("[modes.1]", "there is no limit"),
            ("a = 1", "unknown key 'a'"),
            ("[modes.first]\nzeta = { min = 1 }", "must have a number, as .modes.1., or near_hz"),
            ("[modes.0]\nzeta = { min = 1 }", "must have a number"),
            ("[modes.1]\nzetta = { min = 1 }", "unknown key 'zetta'. Did you mean 'zeta'"),
            ("[modes.1]\nzeta = 0.2", "must be a table"),
            ("[modes.1]\nzeta = { least = 0.2 }", "unknown key 'least'"),
            ("[modes.1]\nzeta = {}", "give min, max or both"),
            ("[modes.1]\nzeta = { min = 0.3, max = 0.2 }", "min below max"),
            ("[modes.1]\nwn = { min = 1, unit = 'kHz' }", "one of rad/s, Hz"),
            ("[struts.a]\nmass = { min = 1 }", "unknown key 'mass'"),
            ("[struts.a]\ndamping = { min = 'x' }", "must be a number in N s/m"),
            ("struts = 1", "must be a table"),
            ("[modes", "is not TOML"),
        ],
    )
    def test_mistakes_are_named(self, text: str, said: str, tmp_path: Path) -> None:
        path = tmp_path / "limits.toml"
        path.write_text(text)
        with pytest.raises(InputError, match=said) as error:
            read_limits(path)
        assert str(path) in str(error.value)


@pytest.mark.usefixtures("words_alone")
class TestReport:
    def test_page_json_and_terminal_agree(self, tmp_path: Path) -> None:
        import json

        from jsonschema import Draft202012Validator

        from suspid.reporting import json_schema

        page, plain = tmp_path / "r.html", tmp_path / "r.json"
        options = ["--car", "examples/nominal_car.toml", "--limits", "examples/limits.toml", "--json", str(plain)]
        result = CliRunner().invoke(main, ["report", "examples/quarter_car.csv", "-o", str(page), *options])
        assert result.exit_code == 0, result.output
        assert "3 of 4 limits met, 1 undecided" in result.stdout
        written = page.read_text(encoding="utf-8")
        assert "Limits: 3 of 4 limits met, 1 undecided." in written
        # The frame has the colour of what is worse, the sentence on the measurement its own.
        assert '<section class="verdict care"' in written
        assert '<p class="said sound">Modes, springs and dampers: sound.' in written
        # One verdict on the whole; that of another part is called so.
        assert written.count('<section class="verdict') == 1
        assert "This part by itself: grip of tire: " in written
        content = json.loads(plain.read_text(encoding="utf-8"))
        Draft202012Validator(json_schema("report")).validate(content)
        assert [row["state"] for row in content["limits"]] == ["met", "met", "met", "cannot tell"]
        assert [step["code"] for step in content["next_steps"]][:2] == ["limits open", "poor grip"]

    def test_without_a_browser_a_pdf_is_refused_with_the_way_out(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PATH", "")
        result = CliRunner().invoke(main, ["report", "examples/quarter_car.csv", "-o", "r.pdf"])
        assert result.exit_code == 1
        assert "install Chromium, or write .html" in result.stderr

    def test_kind_and_name_must_agree(self) -> None:
        result = CliRunner().invoke(main, ["report", "examples/quarter_car.csv", "-o", "r.html", "--format", "pdf"])
        assert result.exit_code == 1
        assert "name it .pdf" in result.stderr


@pytest.mark.parametrize("near", ["0", "-3.0", "nan", "inf"])
def test_a_frequency_of_a_mode_is_positive(near: str) -> None:
    with pytest.raises(InputError, match="near_hz"):
        limits_from_toml(f"[modes.hop]\nnear_hz = {near}\nwn = {{ min = 1.0 }}")


@pytest.mark.parametrize("of", [0, -1, 1.5, True, "x", "1"])
def test_modes_are_numbered_from_one(of: Any) -> None:
    with pytest.raises(InputError, match="from 1 on"):
        Limit(of=of, quantity="wn", least=1.0)


def test_a_number_of_a_mode_that_python_does_not_read() -> None:
    with pytest.raises(InputError, match="must have a number"):
        limits_from_toml(f"[modes.{'1' * 5000}]\nwn = {{ min = 1.0 }}")
