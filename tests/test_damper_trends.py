"""Trends of dampers over drives: rates of errors, what tells, and what cancels."""

import numpy as np
import pytest

from suspid import DamperState, InputError, Level, WearRule, damper_trends
from suspid.fleet.damper_trends import trends_of_rates
from suspid.performance import Rates

ERRORS = np.array([[8e-6, 2e-6], [2e-6, 16e-6]])  # of a drive of 60 s, relative


def drives(
    rng: np.random.Generator, lost: dict[str, float], *, count: int = 10, damper: float = 0.02, load: float = 0.1
) -> list[tuple[str, str, float, Rates]]:
    """Return drives of vehicles with two dampers each, whose losses grow evenly to those given by vehicle."""
    rows = []
    for vehicle, share in lost.items():
        for k in range(count):
            mass = load * rng.standard_normal()
            for strut, part in (("front", share), ("rear", 0.0)):
                own = rng.multivariate_normal(np.zeros(2), ERRORS)
                left = 1 - part * k / (count - 1)
                c = 1300 * left * np.exp(damper * rng.standard_normal() - mass + own[0])
                stiffness = 22e3 * np.exp(-mass + own[1])
                covariance = ERRORS * np.outer([c, stiffness], [c, stiffness])
                rates = Rates(damping=c, stiffness=stiffness, covariance=covariance)
                rows.append((vehicle, strut, float(k), rates))
    return rows


class TestRates:
    def test_ten_percent_lost_are_told_by_ten_drives(self) -> None:
        told = []
        for seed in range(60):
            found = trends_of_rates(drives(np.random.default_rng(seed), {"V 1.5": 0.1, "V 2": 0.0}), WearRule())
            told += [one.state for one in found.trends if (one.vehicle, one.damper) == ("V 1.5", "front")]
        assert np.mean([state in (DamperState.WATCH, DamperState.WORN) for state in told]) > 0.93
        assert np.mean([state is DamperState.WORN for state in told]) < 0.05

    def test_sound_dampers_are_good(self) -> None:
        states = [
            one.state
            for seed in range(60)
            for one in trends_of_rates(drives(np.random.default_rng(seed), {"A": 0.0, "B": 0.0}), WearRule()).trends
        ]
        assert np.mean([state is DamperState.GOOD for state in states]) > 0.97
        assert DamperState.WORN not in states

    @pytest.mark.slow
    def test_at_the_edge_of_worn_the_rate_is_met(self) -> None:
        worn = []
        for seed in range(150):
            found = trends_of_rates(drives(np.random.default_rng(seed), {"A": 0.1, "B": 0.1}), WearRule(rate=0.1))
            worn += [one.state is DamperState.WORN for one in found.trends if one.damper == "front"]
        # 300 draws tell 10 % to 1.7 %.
        assert 0.05 < np.mean(worn) < 0.15


def test_a_load_cancels_and_the_gravest_comes_first() -> None:
    found = trends_of_rates(drives(np.random.default_rng(1), {"A": 0.4, "B": 0.0}, load=0.3), WearRule())
    assert found.trends[0].vehicle == "A"
    assert found.trends[0].state is DamperState.WORN
    assert found.trends[0].loss.value == pytest.approx(0.4, abs=0.06)
    assert found.trends[0].scatter < 0.05
    assert "worn" in str(found)
    table = found.to_pandas()
    assert list(table["verdict"]) == [str(one.state) for one in found.trends]


def test_the_verdict_names_the_dampers_in_each_state_once() -> None:
    found = trends_of_rates(drives(np.random.default_rng(1), {"A": 0.4, "B": 0.0}), WearRule())
    named = {str(c.remark.code): c.remark.numbers["names"] for c in found.verdict.checks}
    assert named == {"worn": ("A front",), "good": ("B front", "B rear", "A rear")}
    assert found.verdict.level.label == "care"
    assert str(found).count("Verdict: 4 dampers followed over time: care") == 1


def test_too_few_drives_have_no_trend() -> None:
    found = trends_of_rates(drives(np.random.default_rng(1), {"A": 0.4}, count=3), WearRule())
    assert not found.trends
    assert "four drives" in str(found)
    assert found.verdict.level is Level.NONE


def test_other_types_are_refused() -> None:
    with pytest.raises(InputError, match="Estimate"):
        damper_trends([("A", 0.0, "drive.json")])  # type: ignore[list-item]
