"""Wear of dampers: error rates of the rule by draws, what cancels, and verdicts."""

import re
from dataclasses import replace

import numpy as np
import pytest

from suspid import DamperState, Estimate, InputError, WearRule, add_noise, estimate, free_decay, grip, quarter_car, wear
from suspid.performance import Rates, loss_of
from suspid.performance.grips import PHASE_LIMIT
from suspid.words import Check, EstimateCheck, Level, Remark, WearCheck

NEW = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
)  # fmt: skip


@pytest.fixture(scope="module")
def fresh() -> Estimate:
    decay = free_decay(NEW, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    noisy = add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1))
    return estimate(noisy, NEW, fixed=["tire.damping"])


def scaled(found: Estimate, factor: float, *, spring: float = 1.0) -> Estimate:
    """Return an estimate with another damper and spring between body and wheel, and errors that scale with them."""
    scale = np.array([{"chassis.damping": factor, "chassis.stiffness": spring}.get(n, 1.0) for n in found.parameters])
    old = next(s for s in found.suspension.struts if s.name == "chassis")
    car = found.suspension.with_parameters(
        damping={"chassis": old.damping * factor}, stiffness={"chassis": old.stiffness * spring}
    )
    covariance = found.covariance * np.outer(scale, scale)
    return replace(found, suspension=car, values=found.values * scale, covariance=covariance)


def draws(
    remaining: float, rule: WearRule, *, count: int, nominal: bool = False, history: int = 1, load: float | None = None
) -> list[DamperState]:
    """Return what the rule says of dampers with so much of their damping left, drive by drive."""
    rng = np.random.default_rng(7)
    errors = np.array([[8e-6, 2e-6], [2e-6, 16e-6]])  # of a drive of 60 s
    said = []
    for _ in range(count):
        new = 22e3 * np.exp(rule.nominal_std * rng.standard_normal(2)) if nominal else np.array([22e3, 22e3])

        def drive(left: float, new: np.ndarray = new) -> Rates:
            own = rng.multivariate_normal(np.zeros(2), errors)
            mass = (rule.load_std if load is None else load) * rng.standard_normal()
            c = new[0] * left * np.exp(rule.damper_std * rng.standard_normal() - mass + own[0])
            k = new[1] * np.exp(rule.spring_std * rng.standard_normal() - mass + own[1])
            return Rates(damping=c, stiffness=k, covariance=errors * np.outer([c, k], [c, k]))

        before = [drive(1.0) for _ in range(history)]
        if nominal:
            before = [Rates(damping=22e3, stiffness=22e3, covariance=np.zeros((2, 2)))]
        loss = loss_of(drive(remaining), before, rule, nominal=nominal)
        said.append(rule.state(loss.low, loss.high))
    return said


def share(states: list[DamperState], state: DamperState) -> float:
    return float(np.mean([one is state for one in states]))


class TestErrorRates:
    """The rates that are stated, with the drives as assumed; on the edge of what is asked the rate is met, not zero."""

    @pytest.mark.parametrize(
        "setting",
        [
            {},
            pytest.param({"nominal": True}, marks=pytest.mark.slow),
            pytest.param({"history": 3}, marks=pytest.mark.slow),
            pytest.param({"history": 8}, marks=pytest.mark.slow),
        ],
    )
    def test_at_the_edge_of_worn_and_of_good(self, setting: dict[str, bool | int]) -> None:
        # A large rate, so that few draws tell whether it is met: half of it is for the loss, half for the phase.
        rule, count = WearRule(rate=0.1), 2000
        worn = share(draws(1 - rule.small, rule, count=count, **setting), DamperState.WORN)  # type: ignore[arg-type]
        good = share(draws(1 - rule.large, rule, count=count, **setting), DamperState.GOOD)  # type: ignore[arg-type]
        # 2000 draws tell 5 % to half a percent; changes that are ratios, not sums, make it a little less.
        assert 0.025 < worn < 0.065
        assert good < 0.065

    @pytest.mark.parametrize(
        ("errors", "spring", "load"),
        [
            ([[0.01, 0.0024], [0.0024, 9e-4]], 0.01, 0.1),
            ([[0.01, -0.0024], [-0.0024, 9e-4]], 0.01, 0.1),
            ([[4e-4, 8e-4], [8e-4, 6.4e-3]], 0.01, 0.2),
            ([[8e-6, 2e-6], [2e-6, 16e-6]], 0.05, 0.2),
        ],
        ids=["coarse, errors alike", "coarse, errors opposed", "coarse spring", "spring of the day"],
    )
    def test_each_cause_of_scatter_is_allowed_for(self, errors: list[list[float]], spring: float, load: float) -> None:
        """Where one cause is the largest, each end of the interval still misses half the rate of the rule."""
        rule, count, rng = WearRule(rate=0.1, spring_std=spring, load_std=load), 1500, np.random.default_rng(8)

        def drive(left: float) -> Rates:
            own = np.array([rule.damper_std, rule.spring_std]) * rng.standard_normal(2) - load * rng.standard_normal()
            true = np.array([1300 * left, 22e3]) * np.exp(own)
            c, k = true * (1 + rng.multivariate_normal(np.zeros(2), errors))
            return Rates(damping=c, stiffness=k, covariance=np.array(errors) * np.outer(true, true))

        found = [loss_of(drive(0.8), [drive(1.0)], rule) for _ in range(count)]
        low, high = np.mean([one.low > 0.2 for one in found]), np.mean([one.high < 0.2 for one in found])
        # 1500 draws tell 5 % to 0.6 %; a change of the spring that is its own is no ratio, which adds as much.
        assert 0.03 < low < 0.068
        assert 0.03 < high < 0.068

    def test_a_healthy_damper_is_not_called_worn(self) -> None:
        assert share(draws(1.0, WearRule(), count=2000), DamperState.WORN) == 0

    def test_a_loss_of_30_percent_is_told(self) -> None:
        assert share(draws(0.7, WearRule(), count=2000), DamperState.WORN) > 0.985

    def test_a_dead_damper_is_told(self) -> None:
        old = Rates(damping=1300.0, stiffness=22e3, covariance=np.diag([25.0, 3600.0]))
        dead = Rates(damping=5.0, stiffness=22e3, covariance=np.diag([100.0, 3600.0]))
        loss = loss_of(dead, [old], WearRule())
        assert loss.low > 0.95
        assert loss.high == 1.0


class TestLoad:
    def test_mass_that_is_not_described_cancels(self, fresh: Estimate) -> None:
        loaded = wear(scaled(fresh, 0.87, spring=0.87), before=fresh)
        assert loaded.states["chassis"] is DamperState.GOOD
        assert loaded.dampers[0].loss.value == pytest.approx(0, abs=0.01)

    def test_without_load_the_damper_is_compared_alone(self, fresh: Estimate) -> None:
        rule = WearRule(load_std=0.0)
        assert wear(scaled(fresh, 0.87, spring=0.87), before=fresh, rule=rule).dampers[0].loss.value == pytest.approx(
            0.13, abs=0.005
        )

    def test_a_broken_spring_leaves_the_cause_open(self, fresh: Estimate) -> None:
        broken = wear(scaled(fresh, 0.75, spring=0.5), before=fresh)
        assert broken.states["chassis"] is DamperState.CANNOT_TELL
        # Either cause leaves this damper as it was or better.
        assert wear(scaled(fresh, 1.0, spring=0.5), before=fresh).states["chassis"] is DamperState.GOOD
        assert WearCheck.SPRING in [check.remark.code for check in broken.verdict.checks]


class TestVerdicts:
    @pytest.mark.parametrize(
        ("factor", "state"),
        [(1.0, DamperState.GOOD), (0.85, DamperState.WATCH), (0.6, DamperState.WORN), (1.5, DamperState.WATCH)],
    )
    def test_by_loss(self, fresh: Estimate, factor: float, state: DamperState) -> None:
        found = wear(scaled(fresh, factor), before=fresh)
        assert found.states == {"chassis": state}
        assert f"chassis {state}" in str(found)

    def test_by_phase(self, fresh: Estimate) -> None:
        # Where drives differ by 20 % a loss of 30 % is not certain, but the wheel's phase has crossed the limit.
        weak = scaled(fresh, 0.5)
        careless = WearRule(damper_std=0.2)
        found = wear(scaled(fresh, 0.35), before=weak, rule=careless)
        assert found.states["chassis"] is DamperState.WORN
        assert WearCheck.PHASE_FAILS in [check.remark.code for check in found.verdict.checks]

    @pytest.mark.parametrize(
        ("away", "code"), [(3.0, WearCheck.PHASE_FAILS), (2.6, WearCheck.PHASE_NEAR), (1.5, WearCheck.PHASE_NEAR)]
    )
    def test_a_phase_is_certain_at_the_rate_of_the_rule(self, fresh: Estimate, away: float, code: WearCheck) -> None:
        """Half of 0.5 % of a normal error is beyond 2.81 standard deviations."""
        now = scaled(fresh, 0.35)
        seen = grip(now)
        wider = (PHASE_LIMIT - seen.phase[0]) / seen.phase_std[0] / away
        unsure = replace(now, covariance=now.covariance * wider**2)
        found = wear(unsure, before=scaled(fresh, 0.5), rule=WearRule(damper_std=0.2))
        assert code in [check.remark.code for check in found.verdict.checks]

    def test_a_phase_that_was_low_before_is_no_wear(self, fresh: Estimate) -> None:
        found = wear(scaled(fresh, 0.4), before=scaled(fresh, 0.4))
        assert found.states["chassis"] is DamperState.WATCH
        assert WearCheck.PHASE_AS_BEFORE in [check.remark.code for check in found.verdict.checks]

    def test_an_interval_that_is_too_wide(self, fresh: Estimate) -> None:
        found = wear(scaled(fresh, 0.9), rule=WearRule(nominal_std=0.2))
        assert found.states["chassis"] is DamperState.CANNOT_TELL
        assert "too uncertain" in str(found)

    def test_nominal_values_without_an_earlier_estimate(self, fresh: Estimate) -> None:
        assert wear(fresh).states["chassis"] is DamperState.GOOD
        assert wear(fresh).against == "nominal"

    def test_a_history_has_its_own_scatter(self, fresh: Estimate) -> None:
        rng = np.random.default_rng(3)
        calm = [scaled(fresh, float(np.exp(0.005 * e))) for e in rng.standard_normal(8)]
        found = wear(scaled(fresh, 0.85), before=calm)
        assert found.against == "history"
        assert found.states["chassis"] is DamperState.WORN

    def test_an_estimate_that_is_doubtful_cannot_tell(self, fresh: Estimate) -> None:
        verdict = replace(fresh.verdict, checks=(Check(Remark(EstimateCheck.ROUNDING), Level.DOUBTFUL),))
        found = wear(replace(scaled(fresh, 0.5), verdict=verdict), before=fresh)
        assert found.states["chassis"] is DamperState.CANNOT_TELL
        assert found.verdict.level is Level.DOUBTFUL


def test_a_car_without_a_load_on_its_wheels_is_judged_by_the_loss(fresh: Estimate) -> None:
    bare = replace(fresh, suspension=fresh.suspension.with_parameters(stiffness={"chassis": 0.0}))
    found = wear(bare, before=bare)
    assert found.after is None
    assert found.states["chassis"] is DamperState.GOOD


class TestChanges:
    def test_no_share_is_shown_of_what_may_be_zero(self, fresh: Estimate) -> None:
        found = wear(scaled(fresh, 0.9), before=fresh)
        row = found.changes[0]
        near_zero = replace(row, name="chassis.relaxation", unit="s", before=1e-5, after=2e-4, low=-4e3, high=4e3)
        assert row.in_percent
        assert not near_zero.in_percent
        line = next(text for text in str(replace(found, changes=(near_zero,))).splitlines() if "relaxation" in text)
        assert "%" not in line

    def test_intervals_of_changes(self, fresh: Estimate) -> None:
        found = {one.name: one for one in wear(scaled(fresh, 0.9), before=fresh).changes}
        change = found["chassis.damping"]
        assert change.change == pytest.approx(-0.1)
        assert change.significant
        both = np.hypot(1, 0.9 / 0.9) * 0.9 * fresh.std[fresh.parameters.index("chassis.damping")] / change.before
        assert (change.high - change.low) / 2 == pytest.approx(1.96 * both, rel=1e-3)
        assert not found["chassis.stiffness"].significant

    def test_the_rates_are_those_of_the_rule(self, fresh: Estimate) -> None:
        """Small ones are not rounded to none."""
        note = str(wear(fresh, before=fresh, rule=WearRule(rate=0.0125)).verdict.notes[-1])
        assert "no more than 10% is called worn, and one that lost 30% or more good, in at most 1.25% of" in note

    def test_numbers_are_those_of_the_page(self, fresh: Estimate) -> None:
        """A spring of 1e6 N/m is written out, and an angle that is known to hundredths has its hundredths."""
        found = wear(fresh, before=fresh)
        stiff = replace(found.changes[0], name="tire.stiffness", unit="N/m", before=1e6, after=1e6)
        assert "1000000  1000000" in str(replace(found, changes=(stiff,)))
        assert found.after is not None
        (wheel,) = [line for line in str(found).splitlines() if line.split()[:1] == ["tire"]][-1:]
        std = np.degrees(found.after.phase_std[0])
        (shown,) = re.findall(r"± (\S+)$", wheel)
        # Two digits.
        assert float(shown) == pytest.approx(std, rel=0.05)


class TestRefusals:
    def test_types_and_cars(self, fresh: Estimate) -> None:
        with pytest.raises(InputError, match="not Suspension"):
            wear(fresh.suspension)  # type: ignore[arg-type]
        with pytest.raises(InputError, match="before: .*str"):
            wear(fresh, before="old.json")  # type: ignore[arg-type]
        other = replace(fresh, suspension=quarter_car(
            seat_mass=80, chassis_mass=350, tire_mass=50, seat_stiffness=1e4, chassis_stiffness=22e3,
            tire_stiffness=210e3, seat_damping=300, chassis_damping=1300,
        ))  # fmt: skip
        with pytest.raises(InputError, match="different cars"):
            wear(fresh, before=other)

    def test_no_damper(self, fresh: Estimate) -> None:
        keep = [i for i, name in enumerate(fresh.parameters) if not name.endswith("damping")]
        bare = replace(
            fresh, parameters=tuple(fresh.parameters[i] for i in keep), values=fresh.values[keep],
            covariance=fresh.covariance[np.ix_(keep, keep)], ranges=fresh.ranges[keep],
        )  # fmt: skip
        with pytest.raises(InputError, match="no damper"):
            wear(bare)

    @pytest.mark.parametrize("values", [{"rate": 0.0}, {"small": 0.4}, {"damper_std": -0.1}, {"load_std": 3}])
    def test_rules(self, values: dict[str, float]) -> None:
        with pytest.raises(InputError):
            WearRule(**values)
