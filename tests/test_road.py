"""Roads of ISO 8608 under a car: class limits, axles, tracks, speeds."""

import re

import numpy as np
import pytest

from suspid import InputError, add_noise, classify_road, quarter_car, road, road_profile, simulate
from suspid.performance import ROAD_LIMITS
from suspid.performance.road_lines import MOST_FOLDING, _folding, line_of
from suspid.records import as_response
from suspid.simulation import ROUGHNESS, Road, track_coherence
from suspid.words import Level
from suspid.words.ride import RoadCheck
from validation.cars import FOUR_WHEELS, TWO_AXLES


class TestSpectrum:
    def test_density_in_time(self) -> None:
        """G_d(n_0) n_0^w v^(w - 1) f^-w."""
        made = road(5e-5, speed=17.0, exponent=2.5)
        f = np.array([0.3, 2.0, 40.0])
        np.testing.assert_allclose(made.spectrum(f), 5e-5 * 0.1**2.5 * 17**1.5 * f**-2.5, rtol=1e-12)

    def test_nothing_beyond_the_wavelengths(self) -> None:
        made = road("A", speed=10.0, wavelengths=(0.5, 50.0))
        assert made.band == (0.2, 20.0)
        np.testing.assert_array_equal(made.spectrum([0.19, 20.1]), 0.0)
        assert np.all(made.spectrum([0.2, 20.0]) > 0)

    def test_the_car_meets_the_road_where_its_struts_are(self) -> None:
        assert dict(road("B", speed=20.0, under=FOUR_WHEELS).places) == {
            "road_front_left": (0.0, 0.75),
            "road_front_right": (0.0, -0.75),
            "road_rear_left": (2.7, 0.75),
            "road_rear_right": (2.7, -0.75),
        }

    def test_an_axle_shares_the_road_of_the_one_before_and_tracks_share_long_waves(self) -> None:
        shares = road("B", speed=20.0, under=FOUR_WHEELS).shares(np.array([0.5, 30.0]))
        np.testing.assert_allclose(shares, shares.conj().transpose(0, 2, 1))
        np.testing.assert_allclose(np.abs(shares[:, 0, 2]), 1.0)
        np.testing.assert_allclose(np.angle(shares[0, 2, 0]), -2 * np.pi * 0.5 * 2.7 / 20)
        assert abs(shares[0, 0, 1]) > 0.9 > 0.01 > abs(shares[1, 0, 1])

    @pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
    def test_isotropy(self, exponent: float) -> None:
        """A surface whose spectrum depends on the length of the wavenumber alone, summed across the road."""
        n, apart = 0.2, 0.8
        across = np.linspace(0, 400, 4_000_001)
        surface = (n**2 + across**2) ** (-(exponent + 1) / 2)
        expected = np.trapezoid(surface * np.cos(2 * np.pi * across * apart), across) / np.trapezoid(surface, across)
        found = track_coherence(np.array([n]), np.array([0.0, apart]), exponent=exponent)[0, 0, 1]
        assert found == pytest.approx(expected, rel=1e-4)


class TestHeights:
    T = np.arange(0, 40, 0.005)

    def drawn(self, made: Road, **speed: object) -> dict[str, np.ndarray]:
        return made.heights(self.T, rng=np.random.default_rng(3), **speed)  # type: ignore[arg-type]

    def test_same_seed_same_road(self) -> None:
        made = road("C", speed=20.0, under=FOUR_WHEELS)
        one, two = self.drawn(made), self.drawn(made)
        for name in made.places:
            np.testing.assert_array_equal(one[name], two[name])

    def test_the_rear_axle_follows(self) -> None:
        found = self.drawn(road("C", speed=25.0, under=TWO_AXLES))
        late = round(2.5 / 25 / 0.005)
        front, rear = found["road_front"], found["road_rear"]
        np.testing.assert_allclose(np.diff(rear)[late:], np.diff(front)[:-late], atol=1e-9)

    def test_a_slower_drive_meets_the_same_bumps_later(self) -> None:
        made = road("B", speed=20.0, wavelengths=(1.0, 100.0))
        fast = self.drawn(made)["road"]
        ramp = np.linspace(10, 20, len(self.T))
        slow = made.heights(self.T, rng=np.random.default_rng(3), speed=ramp)["road"]
        distance = 10 * self.T + self.T**2 / 8
        assert np.std(slow) > 0
        # Other lengths are other grids, so other draws: the spectrum over distance is the same.
        even = np.interp(np.arange(0, 590, 0.2), distance, slow)
        power = [np.mean(np.diff(row) ** 2) for row in (even, np.interp(np.arange(0, 790, 0.2), 20 * self.T, fast))]
        assert power[0] == pytest.approx(power[1], rel=0.15)

    def test_coherence_of_tracks(self) -> None:
        from scipy.signal import csd, welch

        made = road("C", speed=20.0, under=FOUR_WHEELS)
        t = np.arange(0, 1500, 0.02)
        found = made.heights(t, rng=np.random.default_rng(8))
        left, right = (np.diff(found[f"road_front_{side}"]) for side in ("left", "right"))
        f, cross = csd(left, right, 50, nperseg=512)
        _, own = welch(left, 50, nperseg=512)
        _, other = welch(right, 50, nperseg=512)
        use = (f > 0.5) & (f < 4)
        coherence = np.real(cross[use]) / np.sqrt(own[use] * other[use])
        expected = np.real(made.shares(f[use])[:, 0, 1])
        # Some 290 averages: a standard deviation of at most 0.06 at one frequency, 0.01 of the mean over 35.
        assert abs(np.mean(coherence - expected)) < 0.02
        assert np.max(np.abs(coherence - expected)) < 0.15

    def test_given_coherence(self) -> None:
        both = self.drawn(road("C", speed=20.0, under=FOUR_WHEELS, coherence=1.0))
        np.testing.assert_allclose(both["road_front_left"], both["road_front_right"], atol=1e-9)

    def test_it_drives_a_car(self) -> None:
        made = road("C", speed=20.0, under=TWO_AXLES)
        record = simulate(TWO_AXLES, self.T, self.drawn(made), interpolation="cubic")
        assert record.input_labels == ["road_front", "road_rear"]
        assert made.record(self.T, rng=np.random.default_rng(3)).output_labels == ["road_front", "road_rear"]

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"roughness": "J"}, "is not a class of ISO 8608"),
            ({"speed": 0.0}, "speed = 0 m/s must be positive"),
            ({"coherence": 1.2}, "must lie between 0 and 1"),
            ({"under": {"road": (np.nan, 0.0)}}, "a place is not finite"),
            ({"coherence": "x"}, "must lie between 0 and 1"),
            ({"under": 5}, "under is a int"),
            ({"wavelengths": (1.0,)}, "must be the shortest and the longest"),
            ({"wavelengths": "ab"}, "must be the shortest and the longest"),
            ({"wavelengths": (100.0, 0.1)}, "the wavelengths ascend from 0"),
            ({"exponent": 0.0}, "the exponent positive and at most 6"),
            ({"exponent": 50.0}, "the exponent positive and at most 6"),
        ],
    )
    def test_wrong_roads_are_refused(self, given: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            road(**{"roughness": "B", "speed": 20.0, **given})  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("speed", "message"), [(-1.0, "not negative"), (2e4, "resolve no wavelength"), (0.0, "not all zero")]
    )
    def test_wrong_speeds_are_refused(self, speed: float, message: str) -> None:
        with pytest.raises(InputError, match=message):
            self.drawn(road("B", speed=20.0), speed=speed)


class TestClass:
    def test_limits(self) -> None:
        """ISO 8608, table C.1: upper limits in 1e-6 m3, each class four times the one before."""
        limits = [32, 128, 512, 2048, 8192, 32768, 131072]
        np.testing.assert_allclose([ROAD_LIMITS[c] * 1e6 for c in "ABCDEFG"], limits)
        for name, mean in ROUGHNESS.items():
            assert mean == pytest.approx(ROAD_LIMITS[name] / 2) or name == "H"

    @pytest.mark.parametrize("name", ["A", "C", "F"])
    def test_a_generated_road_has_its_class(self, name: str) -> None:
        t = np.arange(0, 60, 0.005)
        made = road(name, speed=20.0, exponent=2.2)
        found = classify_road(made.record(t, rng=np.random.default_rng(4)), speed=20.0)
        assert found.name == name
        low, high = found.interval()["roughness"]
        assert low < made.roughness < high
        low, high = found.interval()["exponent"]
        assert low < 2.2 < high

    def test_intervals_cover(self) -> None:
        rng, held = np.random.default_rng(6), []
        made = road(100e-6, speed=15.0, wavelengths=(0.2, 100.0))
        t = np.arange(0, 40, 0.005)
        for _ in range(60):
            ends = classify_road(made.record(t, rng=rng), speed=15.0).interval()
            held.append(
                [ends["roughness"][0] < 100e-6 < ends["roughness"][1], ends["exponent"][0] < 2 < ends["exponent"][1]]
            )
        # 120 of which 114 are expected: six is 2.4 standard deviations.
        assert np.sum(held) >= 108

    def test_a_bent_spectrum_is_known_less_well(self) -> None:
        """Waves of one length on a road: the line does not hold, which is said, and its errors grow with the misfit."""
        t = np.arange(0, 60, 0.005)
        heights = road("B", speed=20.0).heights(t, rng=np.random.default_rng(4))["road"]
        waves = 0.02 * np.sin(2 * np.pi * 20 * t / 3.0)
        plain, bent = (
            classify_road(as_response(t, one[None], ["road"]), speed=20.0) for one in (heights, heights + waves)
        )
        assert RoadCheck.BENT not in [check.remark.code for check in plain.verdict.checks]
        assert RoadCheck.BENT in [check.remark.code for check in bent.verdict.checks]
        assert bent.covariance[0, 0] > 10 * plain.covariance[0, 0]

    def test_near_a_limit_it_says_so(self) -> None:
        t = np.arange(0, 10, 0.005)
        found = classify_road(road(32e-6, speed=20.0).record(t, rng=np.random.default_rng(2)), speed=20.0)
        assert found.verdict.level is Level.CARE
        assert sum(found.shares.values()) == pytest.approx(1.0)

    def test_speed_of_the_drive(self) -> None:
        t = np.arange(0, 60, 0.002)
        pace = 15 + 5 * np.sin(t / 5)
        record = road("B", speed=20.0, wavelengths=(0.2, 100.0)).record(t, rng=np.random.default_rng(5), speed=pace)
        assert classify_road(record, speed=pace).name == "B"
        noisy = add_noise(record, snr_db=60, rng=np.random.default_rng(1))
        assert classify_road(noisy, speed=pace, channel="road").name == "B"

    def test_wrong_requests_are_refused(self) -> None:
        record = road("B", speed=20.0).record(np.arange(0, 0.1, 0.005), rng=np.random.default_rng(1))
        with pytest.raises(InputError, match="too short"):
            classify_road(record, speed=20.0)
        with pytest.raises(InputError, match="there is no channel"):
            classify_road(record, speed=20.0, channel="raod")

    def test_heights_without_their_time_are_refused_with_what_to_pass(self) -> None:
        times = np.arange(0, 10, 0.005)
        heights = road("B", speed=20.0).heights(times, rng=np.random.default_rng(1))
        with pytest.raises(InputError, match=r"as in \(timepts, heights\['road'\]\)"):
            classify_road(heights, speed=20.0)
        assert classify_road((times, heights["road"]), speed=20.0).name == "B"

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"speed": "fast"}, "speed must be positive"),
            ({"speed": True}, "speed must be positive"),
            ({"speed": 1e9}, "samples are too far apart"),
            ({"wavelengths": (0.0, 100.0)}, "must ascend from 0"),
            ({"wavelengths": 5}, "must be the shortest and the longest"),
        ],
    )
    def test_what_is_no_drive_is_refused(self, given: dict[str, object], message: str) -> None:
        record = road("B", speed=20.0).record(np.arange(0, 30, 0.005), rng=np.random.default_rng(1))
        with pytest.raises(InputError, match=message):
            classify_road(record, **{"speed": 20.0, **given})  # type: ignore[arg-type]

    def test_heights_have_their_unit(self) -> None:
        """Millimetres taken as metres are no road, nor are heights that are none."""
        t = np.arange(0, 30, 0.005)
        heights = np.asarray(road("B", speed=20.0).record(t, rng=np.random.default_rng(1)).y).reshape(1, -1)
        stated = classify_road(as_response(t, 1000 * heights, ["road [mm]"]), speed=20.0)
        assert (stated.name, stated.verdict.level) == ("B", Level.SOUND)
        wrong = classify_road(as_response(t, 1000 * heights, ["road"]), speed=20.0)
        assert RoadCheck.NO_ROAD in [doubt.code for doubt in wrong.verdict.doubts]
        noise = np.random.default_rng(2).standard_normal((1, len(t)))
        white = classify_road(as_response(t, 1e-3 * noise, ["road"]), speed=20.0)
        assert RoadCheck.NO_POWER_LAW in [doubt.code for doubt in white.verdict.doubts]
        for name, values in (("road [m/s2]", heights), ("road", 0 * heights)):
            with pytest.raises(InputError, match="not a unit of length|shows no road"):
                classify_road(as_response(t, values, [name]), speed=20.0)

    def test_a_class_in_lower_case(self) -> None:
        assert road("c", speed=20.0) == road("C", speed=20.0)

    def test_a_quarter_car_meets_one_road(self) -> None:
        car = quarter_car(
            chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=9e2
        )
        assert dict(road("B", speed=20.0, under=car).places) == {"road": (0.0, 0.0)}


class TestFolding:
    def test_waves_shorter_than_two_samples_do_not_move_the_exponent(self) -> None:
        """Heights are points: waves of 0.1 to 0.3 m fold into those that samples every 0.15 m hold.

        Of a density ``n^-2`` they add ``(u / (2 - u))^2`` at the share u of half the sampling rate, which flattens the
        spectrum there. The mean error of the exponent stays below its standard deviation.
        """
        t = np.arange(0, 60, 0.005)
        errors = []
        for seed in range(30):
            heights = road_profile(30 * t, roughness="C", rng=np.random.default_rng(seed))
            found = classify_road((t, heights), speed=30.0)
            errors.append((found.exponent - 2) / np.sqrt(found.covariance[1, 1]))
        assert abs(np.mean(errors)) < 1
        # Over 30 roads: three standard errors about one.
        assert np.std(errors) == pytest.approx(1.0, abs=3 / np.sqrt(2 * 30))

    @pytest.mark.parametrize("exponent", [1.6, 2.0, 3.0])
    @pytest.mark.parametrize("metres", [300.0, 3000.0, 9000.0])
    def test_as_many_waves_are_used_as_folding_leaves(self, exponent: float, metres: float) -> None:
        """Of the expected spectrum of points, with all waves that fold added up, the line is that of the road.

        It is off by no more than is allowed, however long the road is; a fixed share of the lines would be off by more
        and more, at a quarter by 0.6 standard deviations over nine kilometres.
        """
        spacing = 0.15
        n = np.arange(1, metres / spacing / 2) / metres
        n = n[(n >= 0.01) & (n <= 0.5 / spacing)]
        folds = np.arange(1, 200)[:, None] / spacing
        rest = 2 * spacing**exponent * 199.5 ** (1 - exponent) / (exponent - 1)
        everything = n**-exponent + np.sum((folds - n) ** -exponent + (folds + n) ** -exponent, axis=0) + rest
        held = 4 * np.sin(np.pi * n * spacing) ** 2
        used, (level, found, covariance, *_) = line_of(n, everything * held, held, spacing)
        off = np.array([level - exponent * np.log(10.0), found - exponent]) / np.sqrt(np.diag(covariance))
        assert np.all(np.abs(off) < 1.1 * MOST_FOLDING)
        np.testing.assert_allclose(
            _folding(used, spacing, exponent), [level - exponent * np.log(10.0), found - exponent], rtol=0.1
        )
        # Nearly as many as this: the next share would be off by more, unless all are used.
        assert len(used) == np.sum(n <= 0.25 / spacing) or np.max(np.abs(off)) > 0.4 * MOST_FOLDING
