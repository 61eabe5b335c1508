"""Notes and doubts of ride, tune and road at their thresholds, and the bands of spectra."""

import re
from typing import ClassVar

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.stats import norm

from suspid import InputError, Suspension, plot_ride, quarter_car, ride, road, tune
from suspid.performance import plausibility
from suspid.performance.contact import contact, contact_by_hertz, wheels_of
from suspid.performance.felt import Felt
from suspid.performance.plausibility import plausible
from suspid.performance.record_checks import rest_share
from suspid.performance.tune_active import _held
from suspid.performance.tune_damper import _at_ends
from suspid.performance.tuning_checks import idle_limits
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words.active import ActiveCheck
from suspid.words.plausibility import PlausibilityCheck
from suspid.words.ride import RideCheck
from suspid.words.tuning import TuningCheck
from validation.cars import TWO_AXLES

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
WEAK = CAR.with_parameters(damping={"chassis": 250.0})
STEP = 0.005


class TestContact:
    @pytest.mark.parametrize("relaxation", [0.0, 0.004, 0.02])
    def test_the_derivative_by_the_frequency_is_a_difference(self, relaxation: float) -> None:
        """With ``db/ds = c / (1 + rho s)^2`` of a damper on a mount."""
        given = {"chassis": relaxation} if relaxation else {}
        wheels, hertz, step = wheels_of(CAR, given), 9.0, 1e-4
        low, high = contact(wheels, np.array([hertz - step, hertz + step]))[0][0]
        assert contact_by_hertz(wheels, hertz)[0] == pytest.approx((high - low) / (2 * step), rel=1e-6)


class TestThresholds:
    @pytest.mark.parametrize(("share", "said"), [(0.9, False), (1.1, True)])
    @pytest.mark.parametrize("code", [RideCheck.LIFTS, RideCheck.STOPS])
    def test_an_event_counts_from_one_in_the_time(self, code: RideCheck, share: float, said: bool) -> None:
        gap = {"clearance": {"chassis": 0.06}} if code is RideCheck.STOPS else {}
        name = "chassis.stops" if gap else "tire.lift_rate"
        rate = ride(CAR, road="C", speed=20.0, **gap)[name]  # type: ignore[arg-type]
        found = ride(CAR, road="C", speed=20.0, duration=share / rate, **gap)  # type: ignore[arg-type]
        assert (code in [one.remark.code for one in found.verdict.checks]) is said

    @pytest.mark.parametrize(("hertz", "said"), [(0.079, False), (0.081, True)])
    def test_waves_are_missed_below_the_corner_of_wf(self, hertz: float, said: bool) -> None:
        made = road("C", speed=20.0, under=CAR, wavelengths=(0.1, 20.0 / hertz))
        codes = [one.remark.code for one in ride(CAR, road=made).verdict.checks]
        assert (RideCheck.LONG_WAVES in codes) is said

    def test_the_best_damped_mode_tells_whether_anything_damps(self) -> None:
        """One mode of rubber and joints is enough: a half car whose rear has no damper is none without damping."""
        half = TWO_AXLES.with_parameters(damping={"rear": 0.0, "rear_tire": 0.0})
        assert PlausibilityCheck.UNDAMPED not in [check.remark.code for check in plausible(half)]
        none = CAR.with_parameters(damping={"chassis": 1.0, "tire": 0.0})
        assert PlausibilityCheck.UNDAMPED in [check.remark.code for check in plausible(none)]

    def test_springs_that_hardly_carry_are_not_judged(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The tire carries 3923 N and the strut 3432 N; one that carries less than the share of the largest is none."""
        soft = CAR.with_parameters(stiffness={"chassis": 1000.0})
        assert [check.remark.numbers["part"] for check in plausible(soft)] == ["chassis"]
        monkeypatch.setattr(plausibility, "CARRIES", 3433 / 3922)
        assert [*plausible(soft)] == []
        monkeypatch.setattr(plausibility, "CARRIES", 3432 / 3924)
        assert len([*plausible(soft)]) == 1

    def test_a_probability_ends_at_one(self) -> None:
        found = ride(CAR, road="D", speed=30.0, nominal_std=0.9)
        assert found.interval(0.999)["tire.lifts"][1] == 1.0
        assert found.interval(0.999)["tire.load_share"][1] > found["tire.load_share"]


class TestRecords:
    def test_figures_are_about_the_mean(self) -> None:
        t = np.arange(0, 60, STEP)
        rng = np.random.default_rng(1)
        values = np.array([rng.standard_normal(len(t)), 0.01 * rng.standard_normal(len(t))])
        names = ["seat_acceleration", "front_travel"]
        plain, moved = (
            ride(as_response(t, values + level, names)) for level in (np.zeros((2, 1)), np.array([[3.0], [0.3]]))
        )
        np.testing.assert_allclose(moved.values, plain.values, rtol=1e-9)

    @pytest.mark.parametrize(("rms", "resting"), [(0.8, True), (1.25, False)])
    def test_drift_within_a_block_is_no_vibration(self, rms: float, resting: bool) -> None:
        """A slow drift leaks past a window of no shape; a tone of the limit's rms in the band is at the limit."""
        from suspid.greybox import DriveLimits

        limits = DriveLimits()
        t = np.arange(0, 30, STEP)
        tone = 2**0.5 * rms * limits.least_vibration * np.sin(2 * np.pi * float(np.mean(limits.band_hz)) * t)
        drift = 4 * limits.least_vibration * np.sin(2 * np.pi * 0.2 * t)
        samples = tone + drift
        signal = as_signal(as_response(t, samples[None], ["a"]))
        felt = [Felt(name="a", samples=samples, turn="m", kinds=("Wk",), unit="")]
        assert (rest_share(signal, felt) > 0.5) is resting

    def test_a_travel_without_its_name_is_said(self) -> None:
        t = np.arange(0, 60, STEP)
        values = np.random.default_rng(1).standard_normal((4, len(t)))
        found = ride(as_response(t, values, ["seat_acceleration", "front_travel_mm", "rear_travel [mm]", "speed"]))
        said = {note.code: note.numbers for note in found.verdict.notes}
        assert said[RideCheck.NO_FIGURES]["names"] == ("front_travel_mm",)

    def test_segments_that_share_half_their_samples(self) -> None:
        """The scatter of a density over records is that of the band; of Hann windows by halves, 1 + 2 / 36 over n."""
        t, rng = np.arange(0, 40, STEP), np.random.default_rng(2)
        found = [ride(as_response(t, rng.standard_normal((1, len(t))), ["a_acceleration"])) for _ in range(40)]
        scatter = np.std([one.density[0, 5:-5] for one in found], axis=0, ddof=1)
        band = np.mean([one.density_band[0, 5:-5] for one in found], axis=0)
        assert np.sqrt(np.mean(scatter**2) / np.mean(band**2)) == pytest.approx(1.0, abs=0.02)

    def test_the_band_that_is_drawn_holds_the_expected_density(self) -> None:
        """White noise has one density everywhere; lines that are averaged are neighbours, which windows join."""
        t, rng, held = np.arange(0, 60, STEP), np.random.default_rng(2), []
        for _ in range(40):
            page = plot_ride(ride(as_response(t, rng.standard_normal((1, len(t))), ["a_acceleration"])), Figure())
            corners = np.asarray(page.axes[1].collections[0].get_paths()[0].vertices)
            hertz = np.unique(corners[:, 0])
            # Where bands of an octave hold many lines: there the means of independent ones would hold 89 %.
            ends = [np.sort(corners[corners[:, 0] == one, 1])[[0, -1]] for one in hertz[(hertz > 10) & (hertz < 80)]]
            held += [low <= 2 * STEP <= high for low, high in ends]
        assert np.mean(held) == pytest.approx(0.95, abs=0.015)


class TestBands:
    """Law: at each frequency the band holds the density of the true car with the probability that it states."""

    STD: ClassVar = {"chassis.stiffness": 0.05, "chassis.damping": 0.1, "tire.stiffness": 0.03}

    def drawn(self, count: int) -> list[Suspension]:
        shares = 1 + np.array(list(self.STD.values())) * np.random.default_rng(1).standard_normal((count, 3))
        return [
            WEAK.with_parameters(stiffness={"chassis": 22e3 * k, "tire": 210e3 * kt}, damping={"chassis": 250 * c})
            for k, c, kt in shares.tolist()
        ]

    def test_are_those_of_the_interval(self) -> None:
        found = ride(CAR, road="C", speed=20.0, nominal_std=0.1)
        page = plot_ride(found, Figure(), level=0.8)
        corners = np.asarray(page.axes[1].collections[0].get_paths()[0].vertices)
        low, high = found.density_interval(0.8)
        for at in (300, 500, 700):
            ends = np.sort(corners[np.isclose(corners[:, 0], found.hertz[at], rtol=1e-9), 1])
            assert (ends[0], ends[-1]) == pytest.approx((low[0, at], high[0, at]))

    def test_hold_cars_drawn_from_the_covariance(self) -> None:
        """At the peaks of the resonances too, where the density does not change to first order."""
        found = ride(WEAK, road="C", speed=20.0, nominal_std=self.STD)
        low, high = found.density_interval(0.95)
        near = (found.hertz > 0.7) & (found.hertz < 16)
        density = [ride(car, road=found.road).density[0] for car in self.drawn(200)]
        held = np.mean([(low[0] <= one) & (one <= high[0]) for one in density], axis=0)[near]
        # Of 200 draws the share varies by 1.5 %: the least of all frequencies is 3 standard deviations below.
        assert held.min() > 0.95 - 3 * 0.0154
        assert held.mean() == pytest.approx(0.95, abs=0.02)

    @pytest.mark.slow
    def test_hold_the_true_car(self) -> None:
        """Found with its errors, a car has bands that hold the spectrum of the true one."""
        true = ride(WEAK, road="C", speed=20.0)
        held: list[RealArray] = []
        for car in self.drawn(60):
            low, high = ride(car, road="C", speed=20.0, nominal_std=self.STD).density_interval(0.95)
            held.append((low[0] <= true.density[0]) & (true.density[0] <= high[0]))
        near = (true.hertz > 0.7) & (true.hertz < 16)
        # Of 60 draws the share varies by 2.8 %.
        assert np.mean(held, axis=0)[near].min() > 0.95 - 3 * 0.028
        assert np.mean(held, axis=0)[near].mean() == pytest.approx(0.95, abs=0.03)

    def test_of_one_damper_are_the_spectra_at_its_ends(self) -> None:
        """A damper alone moves each density one way nearly everywhere: the ends are those of two cars."""
        std = 0.05
        found = ride(CAR, road="C", speed=20.0, nominal_std={"chassis.damping": std})
        low, high = found.density_interval(0.95)
        rates = 1300 * (1 + norm.isf(0.025) * std * np.array([-1, 1]))
        ends = [ride(CAR.with_parameters(damping={"chassis": c}), road=found.road).density[0] for c in rates.tolist()]
        apart = np.abs(np.log(ends[1] / ends[0])) > 0.01
        assert np.mean(apart) > 0.8
        for side, expected in ((low, np.minimum(*ends)), (high, np.maximum(*ends))):
            # 512 cars drawn know their ends of 95 % to a hundredth of the standard deviation of the logarithm.
            np.testing.assert_allclose(side[0, apart], expected[apart], rtol=0.01)

    def test_of_a_known_car_there_are_none(self) -> None:
        found = ride(CAR, road="C", speed=20.0)
        for side in found.density_interval():
            np.testing.assert_array_equal(side, found.density)


class TestLimits:
    @pytest.mark.parametrize(
        ("limit", "idle"), [({"a.travel": 0.03}, True), ({"a.travel": 0.02}, False), ({"a.phase": 0.5}, True)]
    )
    def test_that_do_not_bind_are_said(self, limit: dict[str, float], idle: bool) -> None:
        values = {"a.travel": np.array([0.01, 0.02]), "a.phase": np.array([0.6, 0.9])}
        found = [*idle_limits(limit, values)]
        assert [check.remark.code for check in found] == [TuningCheck.IDLE] * idle
        if idle:
            assert found[0].remark.numbers["value"] == (0.6 if "a.phase" in limit else 0.02)

    def test_a_travel_in_mm_is_refused(self) -> None:
        with pytest.raises(InputError, match=re.escape("chassis.peak_travel <= 30 m is more than any suspension")):
            tune(CAR, road="C", speed=20.0, constraints={"chassis.peak_travel": 30.0})

    def test_a_road_of_changing_speed_says_what_to_call(self) -> None:
        profile: object = np.array([20.0, 21.0])
        with pytest.raises(InputError, match=re.escape("the profile to .heights(timepts, rng=…, speed=profile)")):
            road("C", speed=profile)  # type: ignore[arg-type]


@pytest.mark.parametrize(("hertz", "codes"), [(299.0, []), (301.0, [ActiveCheck.FAST])])
def test_a_loop_is_fast_from_300_hz_on(hertz: float, codes: list[ActiveCheck]) -> None:
    closed = np.diag([-2 * np.pi * hertz, -1.0])
    assert [check.remark.code for check in _held(np.ones(1), closed)] == codes


@pytest.mark.parametrize(("off", "count"), [(0.0005, 1), (0.002, 0)])
def test_a_bound_is_reached_to_a_thousandth(off: float, count: int) -> None:
    found = [*_at_ends(np.array([650.0 * (1 + off), 1300.0]), (650.0, 5200.0), stated=True)]
    assert [check.remark.numbers["count"] for check in found] == [1] * count
