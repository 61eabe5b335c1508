"""Ride: weightings against the standard, variances against Lyapunov and time domain, derivatives, records."""

import re
from dataclasses import replace

import control
import numpy as np
import pytest

from suspid import (
    InputError,
    Sensor,
    Suspension,
    add_noise,
    estimate,
    free_decay,
    plot_ride,
    quarter_car,
    ride,
    road,
    simulate,
    statespace,
    weighting,
)
from suspid.model import output_rows
from suspid.performance.figure_plan import plan_of
from suspid.performance.ride import driven_road
from suspid.performance.road_response import Signals, grid_of, response
from suspid.performance.weightings import WEIGHTINGS, weighted
from suspid.reconstruction import parameter_names, parameter_values
from suspid.records import as_response
from suspid.words import Level
from suspid.words.ride import RideCheck
from validation.cars import FOUR_WHEELS, TWO_AXLES
from validation.human_vibration import BURSTS, FACTORS, SLOW_BURSTS, bursts, centres, slow_bursts

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
# A body that rings for 3000 cycles: its resonance is far narrower than panels that are the same over the whole band.
WEAK = CAR.with_parameters(damping={"chassis": 0.3, "tire": 0.0})
MOUNTED = TWO_AXLES.with_parameters(mount_stiffness={"front": 4e5})
ALL_WAVES = (1e-3, 1e6)


def changed(car: Suspension, name: str, value: float) -> Suspension:
    owner, _, quantity = name.rpartition(".")
    return car.with_parameters(**{"masses" if quantity == "mass" else quantity: {owner: value}})


class TestWeightings:
    @pytest.mark.parametrize("name", FACTORS)
    def test_every_band_of_the_standard(self, name: str) -> None:
        """ISO 8041-1:2017, tables B.1 to B.9, printed with four digits."""
        f, factors = centres(name)
        np.testing.assert_allclose(np.abs(weighting(name, f)), factors, rtol=6e-4)

    @pytest.mark.parametrize("name", WEIGHTINGS)
    def test_reference_frequency(self, name: str) -> None:
        """ISO 8041-1:2017, table 1."""
        expected = {
            "Wb": 0.8126,
            "Wc": 0.5145,
            "Wd": 0.1261,
            "We": 0.06287,
            "Wf": 0.3888,
            "Wj": 1.019,
            "Wk": 0.7718,
            "Wm": 0.3362,
        }
        hertz = (2.5 if name == "Wf" else 100.0) / (2 * np.pi)
        assert abs(weighting(name, hertz)) == pytest.approx(expected[name], rel=6e-4)

    @pytest.mark.parametrize("name", ["Wk", "Wd"])
    def test_tones_in_time(self, name: str) -> None:
        """A steady tone in each band, once the filter has settled."""
        f, factors = centres(name)
        t = np.arange(0, 60, 0.001)
        for hertz, factor in zip(f[5::6], factors[5::6], strict=True):
            felt = weighted(np.sin(2 * np.pi * hertz * t), 0.001, name)[30_000:]
            assert np.sqrt(2 * np.mean(felt[:20_000] ** 2)) == pytest.approx(factor, rel=0.01)

    @pytest.mark.parametrize("name", BURSTS)
    @pytest.mark.parametrize("cycles", [1, 4, 16])
    def test_bursts_of_the_standard(self, name: str, cycles: int) -> None:
        """ISO 8041-1:2017, table 8, printed with three digits: rms and VDV."""
        samples, rate = bursts(cycles)
        record = as_response(np.arange(len(samples)) / rate, samples[None], ["seat"])
        found = ride(record, weightings={"seat": name})
        expected_rms, expected_dose = BURSTS[name][cycles]
        # The standard allows 10 and 12 %.
        assert found[f"seat.{name}"] == pytest.approx(expected_rms, rel=0.005 if name == "Wk" else 0.025)
        assert found["seat.VDV"] == pytest.approx(expected_dose, rel=0.005 if name == "Wk" else 0.025)

    @pytest.mark.parametrize("cycles", [1, 8])
    def test_motion_sickness_dose(self, cycles: int) -> None:
        """ISO 8041-1:2017, table 9: rms and MSDV."""
        samples, rate = slow_bursts(cycles)
        found = ride(as_response(np.arange(len(samples)) / rate, samples[None], ["seat"]), weightings={"seat": "Wf"})
        np.testing.assert_allclose([found["seat.Wf"], found["seat.MSDV"]], SLOW_BURSTS[cycles], rtol=0.01)

    def test_unknown(self) -> None:
        with pytest.raises(InputError, match="there is no weighting 'Wz'"):
            weighting("Wz", 1.0)

    @pytest.mark.parametrize("hertz", [1j, None, np.nan, np.inf, 1e300, "1", True, [1.0, np.nan], [[1.0], [1.0, 2.0]]])
    def test_frequencies_that_are_none_are_refused(self, hertz: object) -> None:
        with pytest.raises(InputError, match="write a frequency in Hz such as 4.0"):
            weighting("Wk", hertz)  # type: ignore[arg-type]


class TestSpectra:
    def test_a_mode_without_damping_has_no_variance(self) -> None:
        """Its motion on a random road grows without end: refused, and not a large number."""
        with pytest.raises(InputError, match=r"the mode at 1.2 Hz has no damping"):
            ride(CAR.with_parameters(damping={"chassis": 0.0, "tire": 0.0}), road="C", speed=20.0)

    @pytest.mark.parametrize("car", [CAR, WEAK, MOUNTED], ids=["quarter", "hardly damped", "half on mounts"])
    def test_variances_are_those_of_lyapunov(self, car: Suspension) -> None:
        """White slopes: A P + P A' + B B' + the correlation of an axle that comes later, exp(A tau) B_1 B_2'."""
        from scipy.linalg import expm

        speed, struts = 20.0, [s.name for s in car.struts]
        system = statespace(car, outputs=[f"{s}_travel" for s in struts])
        A, B, C, D = (np.asarray(m, float) for m in (system.A, system.B, system.C, system.D))
        n, roads = len(A), len(car.roads)
        # The road is a state: its rate is the input. The mean height does not matter to travels, so it decays slowly.
        slow = 1e-7
        F = np.block([[A, B[:, :roads]], [np.zeros((roads, n)), -slow * np.eye(roads)]])
        G = np.vstack([B[:, roads:], np.eye(roads)])
        places = list(road("C", speed=speed, under=car).places.values())
        noise = G @ G.T
        if roads == 2:
            late = expm(F * (places[1][0] - places[0][0]) / speed) @ np.outer(G[:, 0], G[:, 1])
            noise = np.outer(G[:, 0], G[:, 0]) + np.outer(G[:, 1], G[:, 1]) + late + late.T
        # One-sided density of the slope in time, (2 pi n_0)^2 G_d v, is twice the two-sided one.
        P = control.lyap(F, noise * (2 * np.pi * 0.1) ** 2 * 256e-6 * speed / 2)
        expected = np.sqrt(np.diag(np.hstack([C, D[:, :roads]]) @ P @ np.hstack([C, D[:, :roads]]).T))
        found = ride(car, road=road("C", speed=speed, under=car, wavelengths=ALL_WAVES))
        for i, strut in enumerate(struts):
            if f"{strut}.travel" in found.figures:
                assert found[f"{strut}.travel"] == pytest.approx(expected[i], rel=1e-4)
        for wheel in ("tire",) if roads == 1 else ("front", "rear"):
            tire = car.struts[struts.index("tire" if roads == 1 else f"{wheel}_tire")]
            if not tire.damping:
                assert found[f"{wheel}.load"] == pytest.approx(
                    tire.stiffness * expected[struts.index(tire.name)], rel=1e-4
                )

    def test_weighted_acceleration_is_an_h2_norm(self) -> None:
        """The weighting as a system of python-control behind the car, its H2 norm under white slopes."""
        car = CAR.with_parameters(damping={"tire": 0.0})
        plant = statespace(car, outputs=["chassis_acceleration"], road_rate=False)
        s = control.tf("s")
        w1, w2, w4, w5, w6 = (2 * np.pi * f for f in (0.4, 100, 12.5, 2.37, 3.35))
        band = s**2 / (s**2 + np.sqrt(2) * w1 * s + w1**2) * 1 / (1 + np.sqrt(2) * s / w2 + (s / w2) ** 2)
        shape = (1 + s / w4) / (1 + s / (0.63 * w4) + (s / w4) ** 2)
        rise = (1 + s / (0.91 * w5) + (s / w5) ** 2) / (1 + s / (0.91 * w6) + (s / w6) ** 2) * (w5 / w6) ** 2
        # The road is the integral of its slope in time; one s of the band limiting cancels it.
        weigh = control.ss(control.minreal(band / s, verbose=False) * shape * rise)
        level = np.sqrt((2 * np.pi * 0.1) ** 2 * 64e-6 * 25.0 / 2)
        expected = level * control.system_norm(weigh * plant, 2)
        found = ride(car, road=road("B", speed=25.0, wavelengths=ALL_WAVES))
        assert found["chassis_acceleration.Wk"] == pytest.approx(expected, rel=1e-4)

    @pytest.mark.parametrize("car", [CAR, FOUR_WHEELS], ids=["quarter", "full"])
    def test_long_drives_scatter_about_them(self, car: Suspension) -> None:
        made = road("C", speed=20.0, under=car, wavelengths=(0.4, 50.0))
        t = np.arange(0, 400, 0.005)
        outputs = [f"{c}_acceleration" for c in ("chassis", "heave", "pitch", "roll") if c in car.coordinates]
        struts = [s for s in car.struts if not any(s.arms.get(r) for r in car.roads)]
        outputs += [f"{s.name}_travel" for s in struts]
        heights = made.heights(t, rng=np.random.default_rng(11))
        # Without the first seconds, in which the car begins to move; mean heights are no part of figures.
        record = simulate(car, t, heights, outputs=outputs, interpolation="cubic")
        late = as_response(t[1000:], np.asarray(record.y).reshape(len(outputs), -1)[:, 1000:], outputs)
        seen, expected = ride(late), ride(car, road=made, duration=late.time[-1] - late.time[0])
        for name, std in zip(seen.figures, seen.scatter, strict=True):
            if np.isfinite(std):
                assert abs(seen[name] - expected[name]) < 4.5 * std, name
            else:
                assert seen[name] == pytest.approx(expected[name], rel=0.25)

    def test_figures_scale_with_the_road(self) -> None:
        """Rms by the root of G_d; with exponent 2 by the root of speed where no band ends."""
        car = CAR.with_parameters(damping={"tire": 0.0})
        one = ride(car, road=road("B", speed=20.0, wavelengths=ALL_WAVES))
        rough = ride(car, road=road("D", speed=20.0, wavelengths=ALL_WAVES))
        fast = ride(car, road=road("B", speed=40.0, wavelengths=ALL_WAVES))
        for name in ("chassis_acceleration.Wk", "chassis_acceleration.VDV", "chassis.travel", "tire.load"):
            assert rough[name] == pytest.approx(4 * one[name], rel=1e-8)
            assert fast[name] == pytest.approx(np.sqrt(2) * one[name], rel=1e-3)

    def test_peaks_of_a_long_drive(self) -> None:
        """Rice: how often the load falls below a level; Davenport: the largest of many peaks."""
        rng = np.random.default_rng(4)
        expected = ride(CAR, road="C", speed=20.0, clearance={"chassis": 0.02}, duration=60.0)
        made = road("C", speed=20.0, under=CAR)
        t = np.arange(0, 900, 0.004)
        record = simulate(CAR, t, made.heights(t, rng=rng), outputs=["chassis_travel"], interpolation="cubic")
        travel = np.asarray(record.y).ravel()[400:]
        beyond = np.abs(travel - np.mean(travel)) > 0.02
        rate = np.sum(np.diff(beyond.astype(int)) == 1) / (len(travel) * 0.004)
        assert expected["chassis.stops"] == pytest.approx(rate, rel=0.15)
        peaks = [np.max(np.abs(piece)) for piece in np.array_split(travel - np.mean(travel), 15)]
        assert expected["chassis.peak_travel"] == pytest.approx(np.mean(peaks), rel=0.05)

    def test_wheel_load_of_a_quarter_car(self) -> None:
        """The contact force carries both masses: F = m_s a_s + m_u a_u."""
        made = road("C", speed=20.0, under=CAR)
        plan = plan_of(CAR, made, duration=1.0)
        f = np.geomspace(0.3, 150, 400)
        rows = output_rows(CAR, ["chassis_acceleration", "tire_acceleration"])
        y = response(CAR, Signals(rows=rows, weightings=(None, None), loads=1), f).signals[:, :, 0]
        np.testing.assert_allclose(y[:, 2], 350 * y[:, 0] + 50 * y[:, 1], rtol=1e-6)
        assert plan.signals.loads == 1


class TestDerivatives:
    @pytest.mark.parametrize("car", [CAR, MOUNTED, FOUR_WHEELS], ids=["quarter", "half on mounts", "full"])
    def test_equal_finite_differences(self, car: Suspension) -> None:
        names = [name for name in parameter_names(car) if parameter_values(car)[name]]
        clearance = {car.struts[0].name: (0.03, 0.04)}
        plan = plan_of(car, driven_road(car, "D", 20.0), duration=60.0, clearance=clearance)
        grid = grid_of(plan.signals, plan.road, 2)
        _, jacobian = plan.values(car, parameters=names, grid=grid)
        for p, name in enumerate(names):
            value = parameter_values(car)[name]
            ends = [plan.values(changed(car, name, value * (1 + h)), grid=grid)[0] for h in (-1e-5, 1e-5)]
            expected = (ends[1] - ends[0]) / (2e-5 * value)
            scale = np.abs(plan.values(car, grid=grid)[0] / value)
            np.testing.assert_allclose(jacobian[:, p] / scale, expected / scale, atol=2e-6, rtol=2e-6)

    @pytest.mark.parametrize("duration", [0.02, 0.3, 5.0])
    def test_peaks_of_a_short_time(self, duration: float) -> None:
        """Fewer peaks than Davenport's law has a value for count as e of them, whatever the car."""
        plan = plan_of(CAR, driven_road(CAR, "C", 20.0), duration=duration)
        plan = plan.only(["chassis_acceleration.crest", "chassis.peak_travel"])
        grid = grid_of(plan.signals, plan.road, 2)
        _, jacobian = plan.values(CAR, parameters=["chassis.stiffness"], grid=grid)
        ends = [plan.values(changed(CAR, "chassis.stiffness", 22e3 + h), grid=grid)[0] for h in (-0.2, 0.2)]
        np.testing.assert_allclose(jacobian[:, 0], (ends[1] - ends[0]) / 0.4, rtol=1e-5, atol=1e-12)

    def test_intervals_of_an_estimate(self) -> None:
        nominal = CAR.with_parameters(stiffness={"chassis": 18e3}, damping={"chassis": 1600})
        rng, held = np.random.default_rng(3), []
        truth = ride(CAR, road="C", speed=20.0)
        use = ["chassis_acceleration.Wk", "chassis.travel", "tire.load", "tire.lifts"]
        decay = free_decay(CAR, np.arange(0, 2, 0.005), initial_state={"v_tire": 1.0})
        for _ in range(12):
            found = ride(
                estimate(add_noise(decay, snr_db=20.0, rng=rng), nominal, fixed=["tire.damping"]), road="C", speed=20.0
            )
            ends = found.interval()
            held += [ends[name][0] < truth[name] < ends[name][1] for name in use]
        assert np.mean(held) > 0.87

    @pytest.mark.parametrize("std", [1e-20, 0.5, 1.0])
    def test_springs_that_are_hardly_known(self, std: float) -> None:
        """No car without springs is looked at, however wide the interval."""
        found = ride(CAR, road="C", speed=20.0, nominal_std={"chassis.stiffness": std, "chassis.damping": std})
        low, high = found.interval()["chassis_acceleration.Wk"]
        assert 0 <= low <= found["chassis_acceleration.Wk"] <= high

    def test_stated_uncertainty(self) -> None:
        found = ride(CAR, road="C", speed=20.0, nominal_std={"chassis.damping": 0.1})
        assert found.parameters == ("chassis.damping",)
        softer = ride(CAR.with_parameters(damping={"chassis": 1300 * 1.001}), road="C", speed=20.0)
        slope = (softer["chassis.travel"] - found["chassis.travel"]) / 0.001
        assert found.std[found.figures.index("chassis.travel")] == pytest.approx(abs(slope) * 0.1, rel=1e-2)


class TestVerdict:
    def codes(self, found: object) -> list[object]:
        return [check.remark.code for check in found.verdict.checks]  # type: ignore[attr-defined]

    def test_a_wheel_that_leaves_the_road(self) -> None:
        assert RideCheck.LIFTS in self.codes(ride(CAR, road="D", speed=30.0))
        smooth = ride(CAR, road="A", speed=20.0)
        assert RideCheck.LIFTS not in self.codes(smooth)
        assert smooth.verdict.level is Level.SOUND

    def test_stops(self) -> None:
        assert RideCheck.STOPS in self.codes(ride(CAR, road="C", speed=20.0, clearance={"chassis": (0.03, 0.05)}))

    def test_reactions_overlap(self) -> None:
        text = str(ride(CAR, road="B", speed=20.0))
        assert "a little uncomfortable to fairly uncomfortable (0.53 m/s2" in text

    def test_shocks(self) -> None:
        t = np.arange(0, 120, 0.002)
        samples = 0.05 * np.random.default_rng(1).standard_normal(len(t))
        samples[30_000:30_020] += 20.0
        found = ride(as_response(t, samples[None], ["seat_acceleration"]))
        assert {RideCheck.CREST, RideCheck.SHOCKS} <= set(self.codes(found))
        assert found["seat_acceleration.crest"] > 9

    def test_the_order_of_weightings_does_not_matter(self) -> None:
        t = np.arange(0, 60, 0.002)
        record = as_response(t, np.random.default_rng(2).standard_normal((1, len(t))), ["chassis_acceleration"])
        kinds = {"chassis_acceleration": ("Wk", "Wf")}, {"chassis_acceleration": ("Wf", "Wk")}
        for one, two in (
            [ride(record, weightings=each) for each in kinds],
            [ride(CAR, road="B", speed=20.0, weightings=each) for each in kinds],
        ):
            assert sorted(zip(one.figures, one.values, strict=True)) == sorted(
                zip(two.figures, two.values, strict=True)
            )
            assert self.codes(one) == self.codes(two)
            assert RideCheck.COMFORT in self.codes(two)

    def test_rare_lifts_are_those_of_rice(self) -> None:
        """How often and how long the load of a simulated drive is beyond the static one."""
        rng, made = np.random.default_rng(5), road("D", speed=20.0, under=CAR, wavelengths=(0.5, 100.0))
        t = np.arange(0, 300, 0.002)
        outputs = ["chassis_acceleration", "tire_acceleration"]
        record = simulate(CAR, t, made.heights(t, rng=rng), outputs=outputs, interpolation="cubic")
        load = np.array([350.0, 50.0]) @ np.asarray(record.y).reshape(2, -1)[:, 1000:]
        lifted = np.diff((load < -400 * 9.80665).astype(int)) == 1
        found = ride(CAR, road=made)
        assert found["tire.lift_rate"] == pytest.approx(np.sum(lifted) / (len(load) * 0.002), rel=0.15)
        assert found["tire.lifts"] == pytest.approx(np.mean(load < -400 * 9.80665), rel=0.15)

    def test_a_slow_record(self) -> None:
        t = np.arange(0, 20, 0.01)
        found = ride(as_response(t, np.sin(20 * t)[None], ["seat_acceleration"]))
        assert {RideCheck.HIGH, RideCheck.SHORT} <= set(self.codes(found))


class TestRequests:
    def test_sensors_and_coordinates_are_felt_but_no_wheels(self) -> None:
        car = replace(
            FOUR_WHEELS,
            sensors=[Sensor(name="driver", motion="acceleration", of={"heave": 1, "pitch": -0.2, "roll": 0.4})],
        )
        found = ride(car, road="B", speed=20.0)
        assert found.channels == ("heave_acceleration", "pitch_acceleration", "roll_acceleration", "driver")
        assert found.weightings["pitch_acceleration"] == ("We",)
        assert found.units[found.figures.index("roll_acceleration.We")] == "rad/s2"
        assert found["driver.Wk"] > found["heave_acceleration.Wk"]

    def test_a_road_in_another_order(self) -> None:
        made = road("B", speed=20.0, under={"road_rear": (2.5, 0.0), "road_front": (0.0, 0.0)})
        one, two = ride(TWO_AXLES, road=made), ride(TWO_AXLES, road="B", speed=20.0)
        np.testing.assert_allclose(one.values, two.values)

    def test_picture_of_pitch_has_its_unit(self) -> None:
        from matplotlib.figure import Figure

        page = plot_ride(ride(TWO_AXLES, road="B", speed=20.0), Figure())
        assert [ax.get_ylabel() for ax in page.axes] == ["gain [dB]", "PSD [(m/s²)²/Hz]", "PSD [(rad/s²)²/Hz]"]

    def test_table(self) -> None:
        found = ride(CAR, road="B", speed=20.0)
        table = found.to_pandas().set_index("figure")
        assert table.loc["tire.load", "unit"] == "N"
        assert table.loc["tire.load", "value"] == found["tire.load"]

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({}, "a car needs a road and a speed"),
            ({"road": "B"}, "a car needs a road and a speed"),
            ({"road": road("B", speed=20.0), "speed": 20.0}, "the road has a speed of its own"),
            ({"road": road("B", speed=20.0, under=TWO_AXLES)}, "the car has road"),
            ({"road": "B", "speed": 20.0, "clearance": {"chasis": 0.1}}, "Did you mean 'chassis'"),
            ({"road": "B", "speed": 20.0, "clearance": {"chassis": -0.1}}, "must be positive distances"),
            ({"road": "B", "speed": 20.0, "weightings": {"chassis_acceleration": "Wx"}}, "there is no weighting 'Wx'"),
            ({"road": "B", "speed": 20.0, "weightings": {"body_acceleration": "Wk"}}, "there is no output"),
            ({"road": "B", "speed": 20.0, "duration": 0.0}, "duration = 0 s must be positive"),
            ({"road": "B", "speed": 20.0, "duration": 1e-9}, "duration=1e-09 s is outside of 1 to 1e+09 s"),
            ({"road": "B", "speed": 20.0, "duration": 1e20}, "duration=1e+20 s is outside of 1 to 1e+09 s"),
            ({"road": "B", "speed": 20.0, "weightings": {}}, "weightings is empty; leave it out"),
            ({"road": "B", "speed": 20.0, "duration": "h"}, "duration = 'h' is not a number"),
            ({"road": True, "speed": 20.0}, "roughness=True must be G_d(n_0)"),
            ({"road": 1e300, "speed": 20.0}, "roughness=1e+300 must be G_d(n_0)"),
            ({"road": "B", "speed": 20.0, "clearance": {"chassis": "x"}}, "must be positive distances"),
            ({"road": "B", "speed": 20.0, "nominal_std": True}, "must be a relative standard deviation"),
            ({"road": "B", "speed": 20.0, "nominal_std": {"chassis.damping": 5.0}}, "means 500%"),
            ({"road": "B", "speed": 1e6}, "outside of 0.1 to 350 m/s"),
            ({"road": "B", "speed": 1e-20}, "outside of 0.1 to 350 m/s"),
            ({"road": "B", "speed": 20.0, "clearance": [0.03]}, "must map struts to distances"),
            ({"road": "B", "speed": 20.0, "clearance": {"chassis": 30.0}}, "more than any suspension has"),
            ({"road": "B", "speed": 20.0, "weightings": {"chassis_acceleration": 5}}, "must map channels"),
            ({"road": "B", "speed": 20.0, "weightings": {"chassis_velocity": "Wk"}}, "is not an acceleration"),
            ({"road": "B", "speed": 20.0, "weightings": {5: "Wk"}}, "5 is not the name of a channel"),
        ],
    )
    def test_wrong_requests_are_refused(self, given: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            ride(CAR, **given)  # type: ignore[arg-type]

    @pytest.mark.parametrize(("std", "doubted"), [(0.05, False), (0.9, True)])
    def test_intervals_that_say_nothing_are_doubted(self, std: float, doubted: bool) -> None:
        found = ride(CAR, road="C", speed=20.0, nominal_std=std)
        codes = [doubt.code for doubt in found.verdict.doubts]
        assert (RideCheck.EVENTS in codes, RideCheck.WIDE in codes) == (doubted, doubted)

    def test_a_road_beyond_all_classes_is_doubtful(self) -> None:
        """256 in place of 256e-6 m3; class H is a road."""
        rough, worst = ride(CAR, road=256.0, speed=20.0), ride(CAR, road="H", speed=20.0)
        assert RideCheck.TOO_ROUGH in [doubt.code for doubt in rough.verdict.doubts]
        assert RideCheck.TOO_ROUGH not in [doubt.code for doubt in worst.verdict.doubts]

    def test_a_car_that_is_not_linear_is_refused(self) -> None:
        struts = [replace(s, friction=30.0) if s.name == "chassis" else s for s in CAR.struts]
        with pytest.raises(InputError, match="the ride by spectra needs linear struts"):
            ride(replace(CAR, struts=struts), road="B", speed=20.0)

    def test_wrong_records_are_refused(self) -> None:
        record = as_response(np.arange(100) / 100, np.zeros((1, 100)), ["a"])
        with pytest.raises(InputError, match="no channel is named like an acceleration"):
            ride(record)
        with pytest.raises(InputError, match="there is no channel 'b'"):
            ride(record, weightings={"b": "Wk"})
        with pytest.raises(InputError, match="go with a car"):
            ride(record, road="B", speed=20.0)
        with pytest.raises(InputError, match="there is no figure"):
            ride(CAR, road="B", speed=20.0)["tire.laod"]
