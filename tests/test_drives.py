"""Usable stretches of drives: expected from how the drive was made."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from suspid import DriveLimits, Drives, InputError, RawChannel, RecordError, Recording, find_drives, quarter_car
from suspid.cleaning import clipped_times, stuck_times, to_si
from suspid.greybox import nothing_usable, stretch_table
from suspid.greybox.blocks import vibration
from suspid.records import as_response
from suspid.signals import as_signal
from suspid.text_tables import TERMINAL
from suspid.units import RealArray
from suspid.wording import called
from suspid.words import Level
from suspid.words.drives import DriveReason, DriveRemark

RATE = 100.0
TIME = np.arange(12000) / RATE


def channel(name: str, values: RealArray, unit: str = "m/s2", times: RealArray = TIME) -> RawChannel:
    return RawChannel(name=name, unit=unit, timepts=times, values=np.array(values, float), rate=None)


def body(seed: int = 1, rms: float = 0.5) -> RealArray:
    return rms * np.random.default_rng(seed).standard_normal(TIME.size)


def ride(*channels: RawChannel) -> Recording:
    return Recording(title="ride", channels=channels)


def ends(drives: Drives) -> list[tuple[float, float]]:
    return [(round(one.start, 2), round(one.stop, 2)) for one in drives.taken]


def why(drives: Drives, time: float) -> set[DriveReason]:
    """Return the reasons of the stretch at a time."""
    return {one_reason.code for one in drives if one.start <= time < one.stop for one_reason in one.reasons}  # type: ignore[misc]


def constant(value: float) -> RealArray:
    return np.full(TIME.size, value)


class TestSpeed:
    @pytest.mark.parametrize(
        ("unit", "per"), [("m/s", 1.0), ("km/h", 3.6), ("mph", 1 / 0.44704), ("kn", 3600 / 1852), ("Km/h", 3.6)]
    )
    def test_units_do_not_matter(self, unit: str, per: float) -> None:
        speed = np.where(TIME < 40, 2.5, 15.0)
        found = find_drives(ride(channel("az", body()), channel("Vehicle Speed", per * speed, unit)))
        assert ends(found) == [(41.0, 120.0)]
        assert DriveReason.SLOW in why(found, 20.0)
        assert found.taken[0].speed == pytest.approx(15.0)

    def test_a_unit_may_stand_in_the_name_or_be_given(self) -> None:
        speed = np.where(TIME < 40, 2.5, 15.0)
        named = find_drives(ride(channel("az", body()), channel("speed_kmh", 3.6 * speed, "")))
        given = find_drives(ride(channel("az", body()), channel("v", 3.6 * speed, "")), speed="v", speed_unit="km/h")
        assert ends(named) == ends(given) == [(41.0, 120.0)]

    def test_a_named_channel_without_a_unit_is_refused(self) -> None:
        with pytest.raises(InputError, match="speed_unit"):
            find_drives(ride(channel("az", body()), channel("v", constant(15.0), "")), speed="v")

    def test_a_speed_without_a_unit_is_named(self) -> None:
        found = find_drives(ride(channel("az", body()), channel("speed", constant(15.0), "")))
        said = [str(check) for check in found.remarks]
        assert any("'speed' looks like the speed of the car, but was not used: no unit" in one for one in said)
        assert not any("not used" in str(c) for c in find_drives(ride(channel("az", body()))).remarks)

    @pytest.mark.parametrize("value", [np.nan, -20.0, 655.35])
    def test_a_channel_that_never_holds_a_speed(self, value: float) -> None:
        """Nothing can be told of braking, and it is said, as where there is no channel."""
        recording = ride(channel("az", body()), channel("speed", constant(value), "m/s"))
        codes = [check.remark.code for check in find_drives(recording).remarks]
        assert {DriveRemark.SPEED_UNUSED, DriveRemark.NO_SPEED, DriveRemark.BRAKING_UNKNOWN} <= set(codes)
        with pytest.raises(InputError, match="is not a speed"):
            find_drives(recording, speed="speed")

    def test_a_unit_that_is_none_or_of_nothing_is_refused(self) -> None:
        with pytest.raises(InputError, match="not a unit of speed"):
            find_drives(ride(channel("az", body()), channel("speed", constant(15.0), "m/s")), speed_unit="parsec")
        with pytest.raises(InputError, match="none was found"):
            find_drives(ride(channel("az", body())), speed_unit="km/h")

    def test_of_a_car_that_stands_it_is_said_what_else_takes_the_record(self) -> None:
        still = find_drives(ride(channel("az", 1e-4 * body())))
        assert DriveRemark.STANDS in {note.code for note in still.verdict.notes}
        slow = find_drives(ride(channel("az", body()), channel("speed", constant(2.0), "m/s")))
        assert not slow.taken
        assert DriveRemark.STANDS not in {note.code for note in slow.verdict.notes}

    def test_values_of_a_bus_for_no_speed_are_no_speed(self) -> None:
        """Where the speed is not known, the vibration says that the car moves."""
        speed = np.where((TIME > 30) & (TIME < 60), 655.35, 15.0)
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert ends(found) == [(0.0, 120.0)]

    def test_a_sign_is_a_direction(self) -> None:
        """A sensor that counts backwards, and a car that backs out: the speed is the size of what they show."""
        speed = np.where(TIME < 40, 0.0, np.clip(1.2 * (TIME - 40), 0, 15))
        backwards = find_drives(ride(channel("az", body()), channel("speed", -speed, "m/s")))
        assert ends(backwards) == ends(find_drives(ride(channel("az", body()), channel("speed", speed, "m/s"))))
        assert DriveRemark.SPEED_UNUSED not in {check.remark.code for check in backwards.remarks}
        backing = np.where(TIME < 40, -1.5 * np.sin(2 * np.pi * TIME / 80) ** 2, np.clip(1.2 * (TIME - 40), 0, 15))
        found = find_drives(ride(channel("az", body()), channel("speed", backing, "m/s")))
        assert why(found, 20.0) == {DriveReason.SLOW}

    @pytest.mark.parametrize("unknown", [-1.0, -9.0])
    def test_a_value_below_zero_that_is_jumped_to_is_no_speed(self, unknown: float) -> None:
        """No car comes from 15 m/s to a standstill within a sample; where it is not known, the vibration tells."""
        speed = np.where((TIME > 30) & (TIME < 60), unknown, 15.0)
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert ends(found) == [(0.0, 120.0)]
        assert np.isnan(found.course[45, 1])

    def test_a_slow_clock_of_the_speed(self) -> None:
        slow = np.arange(121.0)
        speed = channel("speed", np.where(slow < 50, 0.0, 20.0), "m/s", slow)
        (start, stop), *others = ends(find_drives(ride(channel("az", body()), speed)))
        assert 50 <= start <= 52
        assert stop == 120.0
        assert not others

    @pytest.mark.parametrize("unit", ["km/h", "mph", "kn"])
    def test_a_unit_of_road_speed_is_enough(self, unit: str) -> None:
        """Nothing but a vehicle moves in km/h; two of them are not sure, nor is a velocity in m/s of any name."""
        per = {"km/h": 3.6, "mph": 1 / 0.44704, "kn": 3600 / 1852}[unit]
        moving = channel("v", per * np.where(TIME < 40, 2.5, 15.0), unit)
        found = find_drives(ride(channel("az", body()), moving))
        assert ends(found) == [(41.0, 120.0)]
        assert DriveRemark.SPEED_BY_UNIT in {check.remark.code for check in found.remarks}
        other = channel("w", constant(5.0) + body(), unit)
        assert ends(find_drives(ride(channel("az", body()), moving, other), channels=["az"])) == [(0.0, 120.0)]
        told = find_drives(ride(channel("az", body()), moving, other), channels=["az"])
        assert any(
            "'v' looks like the speed of the car, but was not used: 'w' may be" in str(one) for one in told.remarks
        )
        assert "choose one, such as speed='v'" in str(told)
        with called({"speed": "--speed"}):
            assert "choose one, such as --speed 'v'" in str(told)
        wind = channel("wind", constant(0.0), unit)
        assert ends(find_drives(ride(channel("az", body()), moving, wind), channels=["az"])) == [(41.0, 120.0)]
        for name, values in (("axle_force_kN", constant(30.0) + body()), ("cruise (km/h)", constant(120.0) + body())):
            alone = find_drives(ride(channel("az", body()), channel(name, values, "")), channels=["az"])
            assert DriveRemark.NO_SPEED in {check.remark.code for check in alone.remarks}
        in_si = channel("v", constant(0.0), "m/s")
        assert ends(find_drives(ride(channel("az", body()), in_si), channels=["az"])) == [(0.0, 120.0)]

    def test_channels_about_a_speed_are_not_the_speed(self) -> None:
        found = find_drives(
            ride(channel("az", body()), channel("SpeedAccuracy", constant(0.1), "m/s")), channels=["az"]
        )
        assert DriveRemark.NO_SPEED in {note.code for note in found.verdict.notes}


class TestUnitsInNames:
    @pytest.mark.parametrize("name", ["Lateral Gs", "Lateral G's", "Lateral (Gs)", "LatAcc_g", "lateral [G's]"])
    def test_accelerations_in_g(self, name: str) -> None:
        across = channel(name, np.where((TIME > 50) & (TIME < 60), 0.3, 0.0), "")
        found = find_drives(ride(channel("az", body()), across), channels=["az"])
        assert ends(found) == [(0.0, 50.0), (60.0, 120.0)]

    @pytest.mark.parametrize(
        ("name", "factor"),
        [("AccelZ_g", 9.80665), ("accel_z_ms2", 1.0), ("Accel Z m/s2", 1.0), ("Accel Z milli g", 9.80665e-3),
         ("accel_z_milli-g", 9.80665e-3), ("accel_z_mg", 9.80665e-3), ("AccelZ_cm_s2", 0.01), ("accel_z_gal", 0.01),
         ("accel_z_ft/s^2", 0.3048)],
    )  # fmt: skip
    def test_a_suffix_tells_what_is_measured(self, name: str, factor: float) -> None:
        """From the least vibration of a car that moves on."""
        level = DriveLimits().least_vibration / np.sqrt(14 / (RATE / 2))
        for by, moves in ((0.5, False), (2.0, True)):
            found = find_drives(ride(channel(name, body(1, by * level / factor), "")))
            assert bool(found.taken) is moves
            assert DriveRemark.NO_UNIT not in {note.code for note in found.verdict.notes}

    @pytest.mark.parametrize("name", ["load_g", "x_m"])
    def test_a_suffix_that_may_mean_something_else_is_no_unit(self, name: str) -> None:
        found = find_drives(ride(channel(name, body(), "")))
        assert DriveRemark.NO_UNIT in {note.code for note in found.verdict.notes}

    @pytest.mark.parametrize("unit", ["Nm", "N m", "N·m", "kNm"])
    def test_a_newton_metre_is_no_nanometre(self, unit: str) -> None:
        with pytest.raises(InputError, match="torque"):
            to_si(1.0, unit)
        assert to_si(1.0, "nm")[1] == "m"

    def test_rates_and_axes_behind_which_units_stand(self) -> None:
        turning = np.degrees(np.where((TIME > 50) & (TIME < 60), 15.0 / 100.0, 0.0))
        along = [channel(f"Acc{a}_g", (body(i) + 9.7 * (a == "Z")) / 9.80665, "") for i, a in enumerate("XYZ")]
        about = [channel(f"Gyro{a}_degps", turning * (a == "Z") + body(i, 0.1), "") for i, a in enumerate("XYZ")]
        found = find_drives(ride(*along, *about, channel("speed", constant(15.0), "m/s")))
        assert DriveReason.CORNERING in why(found, 55.0)
        assert DriveRemark.YAW_BY_GRAVITY in {check.remark.code for check in found.remarks}


class TestBraking:
    @pytest.mark.parametrize(("rate", "usable"), [(1.2, True), (2.0, False)])
    def test_by_the_speed(self, rate: float, usable: bool) -> None:
        speed = 25 - rate * np.clip(TIME - 50, 0, 8)
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert (DriveReason.BRAKING in why(found, 54.0)) is not usable

    @pytest.mark.parametrize("lateral", [True, False])
    def test_an_acceleration_beside_a_lateral_one_is_that_along_the_car(self, lateral: bool) -> None:
        """Racing loggers write "Acceleration Gs" and "Lateral Gs"; alone, the first may be any."""
        along = channel("Acceleration Gs", np.where((TIME > 50) & (TIME < 60), 0.3, 0.0), "G")
        across = [channel("Lateral Gs", 0.0 * TIME, "G")] if lateral else []
        found = find_drives(ride(channel("az", body()), along, *across), channels=["az"])
        assert ends(found) == ([(0.0, 50.0), (60.0, 120.0)] if lateral else [(0.0, 120.0)])

    @pytest.mark.parametrize("name", ["Inline Acceleration", "Längsbeschleunigung", "G Force Long"])
    def test_by_names_of_other_loggers(self, name: str) -> None:
        along = channel(name, np.where((TIME > 50) & (TIME < 60), 0.3, 0.0), "g")
        found = find_drives(ride(channel("az", body()), along), channels=["az"])
        assert ends(found) == [(0.0, 50.0), (60.0, 120.0)]

    @pytest.mark.parametrize("name", ["longitudinal", "LongAcc"])
    def test_by_an_accelerometer_that_is_tilted(self, name: str) -> None:
        along = 0.9 + np.where((TIME > 50) & (TIME < 55), -3.0, 0.0) + body(2)
        found = find_drives(ride(channel("az", body()), channel(name, along)))
        assert ends(found) == [(0.0, 50.0), (55.0, 120.0)]
        assert why(found, 52.0) == {DriveReason.BRAKING}

    @pytest.mark.parametrize(("name", "seen"), [("ax", True), ("acc_x", True), ("ax_wheel", False), ("max", False)])
    def test_by_the_axis_of_a_sensor_in_the_body(self, name: str, seen: bool) -> None:
        along = channel(name, 0.2 + np.where((TIME > 50) & (TIME < 55), -3.0, 0.0) + body(2))
        found = find_drives(ride(channel("az_body", body()), along), channels=["az_body"])
        assert ends(found) == ([(0.0, 50.0), (55.0, 120.0)] if seen else [(0.0, 120.0)])
        assert (DriveRemark.BY_AXIS in {check.remark.code for check in found.remarks}) is seen
        off = find_drives(ride(channel("az_body", body()), along), channels=["az_body"], longitudinal="none")
        assert ends(off) == [(0.0, 120.0)]

    def test_a_sensor_at_the_wheel_is_not_asked(self) -> None:
        box = [channel(f"hub_{a}", 20 * body(i) + 9.8 * (a == "z")) for i, a in enumerate("xyz")]
        mine = [channel(f"imu_{a}", body(i) + 9.8 * (a == "z")) for i, a in enumerate("xyz")]
        found = find_drives(ride(channel("az", body()), *box, *mine), channels=["az"])
        assert ends(found) == [(0.0, 120.0)]
        (said,) = [check for check in found.remarks if check.remark.code is DriveRemark.BY_AXIS]
        assert said.remark.numbers["channels"] == ("imu_x", "imu_y")

    def test_what_a_phone_computes_of_gravity_is_no_second_sensor(self) -> None:
        hard = np.where((TIME > 50) & (TIME < 55), -3.0, 0.0)
        box = [channel(f"Acc{a}", body(i) + 9.8 * (a == "z") + hard * (a == "x")) for i, a in enumerate("xyz")]
        slow = [channel(f"motionGravity{a.upper()}", 9.8 * (a == "z") + body(i, 0.01)) for i, a in enumerate("xyz")]
        assert ends(find_drives(ride(*box, *slow), channels=["Accz"])) == [(0.0, 50.0), (55.0, 120.0)]

    @pytest.mark.parametrize("up", ["x", "y", "z"])
    def test_by_the_axes_that_are_level(self, up: str) -> None:
        """A box with three axes mounted any way round: gravity shows the vertical one."""
        hard = np.where((TIME > 50) & (TIME < 55), -3.0, 0.0)
        level = [axis for axis in "xyz" if axis != up]
        for braked in level:
            box = [channel(f"Box {a}", body(i) + 9.8 * (a == up) + hard * (a == braked)) for i, a in enumerate("xyz")]
            found = find_drives(ride(*box), channels=[f"Box {up}"])
            assert ends(found) == [(0.0, 50.0), (55.0, 120.0)]
            assert not found.verdict.doubts

    def test_what_was_not_measured_is_said(self) -> None:
        found = find_drives(ride(channel("az", body())))
        codes = {doubt.code for doubt in found.verdict.doubts}
        assert codes == {DriveRemark.BRAKING_UNKNOWN, DriveRemark.CORNERING_UNKNOWN}


class TestCornering:
    @pytest.mark.parametrize(("radius", "usable"), [(250.0, True), (100.0, False)])
    def test_by_yaw_rate_and_speed(self, radius: float, usable: bool) -> None:
        """The lateral acceleration is v^2 / R."""
        yaw = np.degrees(np.where((TIME > 50) & (TIME < 60), 15.0 / radius, 0.0))
        found = find_drives(
            ride(channel("az", body()), channel("speed", constant(54.0), "km/h"), channel("yaw rate", yaw, "deg/s"))
        )
        assert (DriveReason.CORNERING in why(found, 55.0)) is not usable

    def test_by_an_accelerometer(self) -> None:
        across = np.where((TIME > 50) & (TIME < 60), 0.3, 0.0)
        found = find_drives(ride(channel("az", body()), channel("ay", across, "g")), lateral="ay", channels=["az"])
        assert ends(found) == [(0.0, 50.0), (60.0, 120.0)]

    @pytest.mark.parametrize(("up", "rates"), [("X", "XYZ"), ("Z", "XYZ"), ("Z", "XY"), ("", "XYZ")])
    def test_the_rate_about_the_axis_of_gravity_is_the_yaw_rate(self, up: str, rates: str) -> None:
        """A unit of three axes mounted any way round; not sure without gravity, or without all three rates."""
        turning = np.where((TIME > 50) & (TIME < 60), 15.0 / 100.0, 0.0)
        along = [channel(f"Acc{a}", body(i) + 9.7 * (a == up)) for i, a in enumerate("XYZ")]
        about = [channel(f"Rate{a}", turning if a == up else body(i, 0.01), "rad/s") for i, a in enumerate(rates)]
        found = find_drives(ride(*along, *about, channel("speed", constant(15.0), "m/s")))
        sure = bool(up) and up in rates
        assert (DriveReason.CORNERING in why(found, 55.0)) is sure
        codes = {check.remark.code for check in found.remarks}
        assert (DriveRemark.YAW_BY_GRAVITY in codes) is sure
        # Where gravity shows the vertical axis, the others tell cornering as well.
        assert (DriveRemark.CORNERING_UNKNOWN in codes) is not bool(up)


class TestSensors:
    @pytest.mark.parametrize(("stop", "again"), [(53.0, 54.0), (52.8, 54.0), (52.3, 53.0)])
    def test_clipped(self, stop: float, again: float) -> None:
        """A sensor is given half a second to recover."""
        motion = body(3)
        burst = (TIME > 50) & (stop > TIME)
        # Motion of the wheels, slow beside the rate, is cut off for many samples at a time.
        motion[burst] = np.clip(30 * np.sin(2 * np.pi * 6 * TIME[burst]), -16, 16)
        found = find_drives(ride(channel("az", motion)))
        assert ends(found) == [(0.0, 50.0), (again, 120.0)]
        assert DriveReason.CLIPPED in why(found, 51.0)

    @pytest.mark.parametrize("step", [0.0, 0.01, 0.1])
    def test_large_motion_is_not_clipped(self, step: float) -> None:
        """Crests of sines and of noise, also as a coarse converter gives them."""
        rng = np.random.default_rng(4)
        smooth = np.convolve(rng.standard_normal(TIME.size + 20), np.hanning(21), "valid")
        for values in (smooth, np.sin(2 * np.pi * 1.3 * TIME) * (1 + 0.2 * np.sin(TIME)), body()):
            some = np.round(values / step) * step if step else values
            assert clipped_times(channel("az", some)).size == 0

    def test_a_sample_that_is_no_motion_is_missing_and_said(self) -> None:
        motion = body()
        motion[5000] = 1e4
        found = find_drives(ride(channel("az", motion)))
        assert np.max(np.abs(as_signal(found.records[0]).values)) < 5
        assert "were treated as missing: 1 in 'az', first at 50 s" in str(found)

    def test_stuck(self) -> None:
        motion = body(5)
        motion[5000:5500] = motion[5000]
        found = find_drives(ride(channel("az", motion), channel("wheel", body(6))))
        assert ends(found) == [(0.0, 50.0), (55.0, 120.0)]
        assert DriveReason.STUCK in why(found, 52.0) or DriveReason.MISSING in why(found, 52.0)

    @pytest.mark.parametrize(("seconds", "stuck"), [(0.3, False), (0.8, True)])
    def test_values_that_are_held_are_stuck_from_half_a_period_of_the_slowest_body_on(
        self, seconds: float, stuck: bool
    ) -> None:
        """A bus holds each value for four samples: the time alone decides."""
        held = np.repeat(body(5)[::4], 4)
        held[5000 : 5000 + round(seconds * RATE)] = held[5000]
        assert bool(stuck_times(channel("az", held), DriveLimits().stuck).size) is stuck

    @pytest.mark.parametrize("samples", [5, 12, 40])
    def test_stuck_for_a_moment_without_a_jump(self, samples: int) -> None:
        """The motion is back at the value where it stuck when it goes on."""
        motion = np.sin(2 * np.pi * 1.5 * TIME) + 0.3 * np.sin(2 * np.pi * 9.1 * TIME + 1) + 0.01 * body(5)
        motion[5000 : 5000 + samples] = motion[5000 + samples]
        assert stuck_times(channel("az", motion), 0.5).size == samples + 1
        held = np.repeat(motion[::4], 4)
        assert stuck_times(channel("az", held), 0.5).size == 0

    def test_coarse_steps_are_not_stuck(self) -> None:
        """Noise of two steps of the converter repeats a value by chance; so does a car at rest."""
        assert stuck_times(channel("az", np.round(body(6, rms=0.05) / 0.05) * 0.05), 0.5).size == 0

    def test_missing_rows_and_samples(self) -> None:
        motion, keep = body(7), np.ones(TIME.size, bool)
        keep[3000:3200] = False
        motion[7000:7100] = np.nan
        found = find_drives(ride(channel("az", motion[keep], times=TIME[keep])))
        assert ends(found) == [(0.0, 30.0), (32.0, 70.0), (71.0, 120.0)]
        assert why(found, 31.0) == why(found, 70.5) == {DriveReason.MISSING}

    def test_a_channel_that_is_not_needed_may_be_missing(self) -> None:
        both = ride(channel("az", body()), channel("other", np.where(TIME > 60, np.nan, body())))
        assert ends(find_drives(both, channels=["az"])) == [(0.0, 120.0)]
        assert ends(find_drives(both)) == [(0.0, 60.0)]

    def test_slow_channels_are_not_needed_unless_they_are_named(self) -> None:
        """A channel of a tenth of the rate that ends early: alone it would part the drive."""
        slow = channel("oil", 90 + body()[:600], "°C", times=TIME[:6000:10])
        found = find_drives(ride(channel("az", body()), channel("bz", body(2)), slow))
        assert ends(found) == [(0.0, 120.0)]
        assert as_signal(found.records[0]).channels == ("az", "bz")

    @pytest.mark.parametrize("rate", [1.0, 2.4])
    def test_a_rate_that_passes_no_vibration_is_refused(self, rate: float) -> None:
        slow = np.arange(300) / rate
        with pytest.raises(RecordError, match=r"too slow for a drive: .* needs 2.5 Hz"):
            find_drives(ride(channel("az", body()[:300], times=slow)))

    def test_a_pause_parts_the_recording(self) -> None:
        late = np.where(TIME < 60, TIME, TIME + 1000.0)
        found = find_drives(ride(channel("az", body(), times=late)))
        assert ends(found) == [(0.0, 60.0), (1060.0, 1120.0)]


class TestVibration:
    def test_the_level_of_white_noise_is_its_share_of_the_power(self) -> None:
        limits = DriveLimits()
        values = body(8, rms=1.0)
        expected = np.sqrt((limits.band_hz[1] - limits.band_hz[0]) / (RATE / 2))
        assert np.mean(vibration(values, 1 / RATE, 2, 100, limits) ** 2) ** 0.5 == pytest.approx(expected, rel=0.1)

    def test_the_same_motion_as_displacement_and_acceleration(self) -> None:
        """A sum of sines at the centres of the lines."""
        limits, f = DriveLimits(), np.arange(1.0, 16.0)
        t = np.arange(1000) / 1000
        phase = np.random.default_rng(9).uniform(0, 6, f.size)[:, None]
        waves = np.sin(2 * np.pi * f[:, None] * t + phase) / (2 * np.pi * f[:, None]) ** 2
        z, a = np.sum(waves, axis=0), np.sum(-waves * (2 * np.pi * f[:, None]) ** 2, axis=0)
        levels = [vibration(values, 1e-3, order, 1000, limits)[0] for values, order in ((z, 0), (a, 2))]
        assert levels[0] == pytest.approx(levels[1], rel=0.2)

    @pytest.mark.parametrize(("level", "moving"), [(0.02, False), (0.1, True)])
    def test_a_car_moves_from_a_level_between_those_of_rest_and_of_a_very_good_road(
        self, level: float, moving: bool
    ) -> None:
        """Motion in the band alone, from 1 to 15 Hz."""
        hertz = np.fft.rfftfreq(TIME.size, 1 / RATE)
        inside = (hertz > 0.9) & (hertz < 15.1)
        motion = np.fft.irfft(np.where(inside, np.fft.rfft(body(8)), 0.0), TIME.size)
        found = find_drives(ride(channel("az", level * motion / np.std(motion))))
        assert ends(found) == ([(0.0, 120.0)] if moving else [])

    def test_an_idling_engine_does_not_move_the_car(self) -> None:
        """Lines of 0.3 m/s2 at 6.5, 13 and 26 Hz over the noise of a sensor."""
        idle = 0.3 * sum(np.sin(2 * np.pi * f * TIME) for f in (6.5, 13.0, 26.0)) + body(10, rms=0.01)
        found = find_drives(ride(channel("az", idle)))
        assert not found.taken
        assert why(found, 50.0) == {DriveReason.STANDING}

    def test_displacements_in_any_unit(self) -> None:
        moving = np.cumsum(np.cumsum(body())) / RATE**2
        moving -= np.polyval(np.polyfit(TIME, moving, 7), TIME)
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
        )
        for unit, per in (("mm", 1e3), ("m", 1.0)):
            assert ends(find_drives(ride(channel("chassis", per * moving, unit)), car=car)) == [(0.0, 120.0)]
            assert not find_drives(ride(channel("chassis", per * moving / 100, unit)), car=car).taken

    def test_each_channel_is_judged_as_what_it_measures(self) -> None:
        """A displacement of millimetres is no acceleration of as many m/s2; a temperature, a force are no motion."""
        f, lines = np.fft.rfftfreq(TIME.size, 1 / RATE), np.fft.rfft(body())
        moving = np.fft.irfft(np.where(f > 0.8, lines / (2 * np.pi * np.maximum(f, 0.8)) ** 2, 0.0), TIME.size)
        assert np.std(moving) < DriveLimits().least_vibration
        for name, unit in (("body_displacement", ""), ("body", "m")):
            assert ends(find_drives(ride(channel(name, moving, unit)))) == [(0.0, 120.0)]
            still = find_drives(ride(channel(name, moving / 100, unit)))
            assert why(still, 50.0) == {DriveReason.STANDING}
        slow = 0.01 * np.sin(TIME)
        for name, unit in (("oil", "°C"), ("rack", "N"), ("pitch", "rad/s")):
            assert ends(find_drives(ride(channel("az", body()), channel(name, slow, unit)))) == [(0.0, 120.0)]

    def test_what_nothing_says_is_said(self) -> None:
        """Without units and telling names, channels are taken for accelerations, unless the speed tells all."""
        unknown = [channel("p", body(), ""), channel("q", body(2), "V")]
        speed = channel("speed", constant(15.0) + body(3, rms=0.1), "m/s")
        assert "Nothing says what 'p', 'q' measure:" in str(find_drives(ride(*unknown)))
        assert "Nothing says what 'p' measures: " in str(find_drives(ride(unknown[0])))
        assert DriveRemark.NO_UNIT not in {check.remark.code for check in find_drives(ride(*unknown, speed)).remarks}

    @pytest.mark.parametrize(
        ("name", "unit", "words"),
        [
            ("body_acceleration", "counts", "states the unit 'counts', which is not known: the samples were taken as"),
            ("chassis_acceleration", "mm", "states a unit of mm, which is none of m/s2"),
            ("body_acceleration", "mV", "states a unit of mV, which is none of m/s2"),
            ("body_acceleration", "g", ""),
            ("body_acceleration", "-", ""),
            ("body_travel", "mm", ""),
        ],
    )
    def test_a_unit_that_is_not_one_of_the_motion_is_said(self, name: str, unit: str, words: str) -> None:
        """Samples in a unit that is not known are taken as SI; the remark says it, and how to state the unit."""
        moving = body(rms=30.0) if unit in ("mm", "mV") else body()
        car = quarter_car(
            chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
        )
        of_car = car if name.startswith("chassis") else None
        speed = channel("speed", constant(15.0), "m/s")
        said = find_drives(ride(channel(name, moving, unit), speed), car=of_car).remarks
        found = [one for one in said if one.remark.code is DriveRemark.UNKNOWN_UNIT]
        assert bool(found) == bool(words)
        assert all(words in str(one) and one.level is Level.CARE for one in found)

    @pytest.mark.parametrize("speed", [4.0, 25.0])
    def test_a_roller_bench_is_no_road(self, speed: float) -> None:
        """The wheels turn and shake, the body hardly moves."""
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
        )
        turning, still = channel("speed", constant(speed) + body(3, rms=0.05), "m/s"), body(2, rms=0.01)
        both = ride(channel("chassis_acceleration", still), channel("tire_acceleration", body()), turning)
        assert why(find_drives(both, car=car), 50.0) == {DriveReason.ROLLING}
        assert "roller bench" in str(find_drives(both, car=car)[0])
        alone = find_drives(ride(channel("az", still), turning))
        assert why(alone, 50.0) == {DriveReason.ROLLING}
        assert find_drives(ride(channel("az", body(2, rms=0.3)), turning)).taken

    @pytest.mark.parametrize("units", ["m/s2", ""])
    def test_a_quiet_channel_does_not_make_the_car_stand(self, units: str) -> None:
        """An axis across the car, or a rate that nothing calls one: the loudest channel tells that the car moves."""
        quiet = [channel("p", body(2, rms=0.01), units), channel("q", body(3, rms=0.001), units)]
        assert ends(find_drives(ride(channel("r", body(), units), *quiet))) == [(0.0, 120.0)]
        assert why(find_drives(ride(*quiet)), 50.0) == {DriveReason.STANDING}

    def test_noise_of_a_displacement_is_no_vibration_beside_an_acceleration(self) -> None:
        """To 0.1 mm, twice differentiated, 1 m/s2 of noise; the accelerometer shows that the car stands."""
        travel = channel("damper", body(2, rms=1e-4), "m")
        assert find_drives(ride(travel)).taken
        found = find_drives(ride(travel, channel("az", body(rms=0.01))))
        assert why(found, 50.0) == {DriveReason.STANDING}

    @pytest.mark.parametrize(("value", "reason"), [(40.0, DriveReason.QUIET), (5.0, DriveReason.STANDING)])
    def test_what_may_be_a_speed_speaks_against_standing(self, value: float, reason: DriveReason) -> None:
        """In any unit 40 is faster than 3 m/s; 5 km/h is not."""
        found = find_drives(ride(channel("az", body(rms=0.01)), channel("speed", value + body(2, rms=0.1), "")))
        assert why(found, 50.0) == {reason}
        assert ("stands" in str(found)) is (reason is DriveReason.STANDING)

    @pytest.mark.parametrize(("name", "judged"), [("az", True), ("Lateral Gs", False), ("Acceleration Gs", False)])
    def test_a_roller_bench_is_told_by_vertical_motion_alone(self, name: str, judged: bool) -> None:
        quiet = channel(name, body(2, rms=0.001), "" if "Gs" in name else "m/s2")
        found = find_drives(ride(quiet, channel("speed", constant(15.0), "m/s")), channels=[name])
        assert (why(found, 50.0) == {DriveReason.ROLLING}) is judged


class TestChannelsOfALogger:
    """Columns of satellites and of the engine beside an accelerometer, on its clock."""

    HELD = np.round(np.random.default_rng(9).standard_normal(120).cumsum()[(TIME // 1).astype(int)], 1)

    @pytest.mark.parametrize(
        ("name", "unit", "values"),
        [
            ("locationLatitude", "WGS84", 30.0 + 1e-4 * HELD),
            ("locationAltitude", "m", 200.0 + HELD),
            ("locationCourse", "°", np.clip(180 + 40 * HELD, 0, 300)),
            ("height", "m", 200.0 + HELD),
            ("Coolant Temp", "C", np.minimum(TIME, 80.0)),
            ("Accel Position", "%", np.clip(100 * body(4), 0, 100)),
            ("RPM", "rpm", np.where(TIME < 60, 2000 + 100 * body(5), np.nan)),
            ("Req Torque", "Nm", 100 * body(7)),
            ("Engine RPM", "rad/s", 200 + 20 * body(7)),
            ("Gear", "", np.round(3 + body(6))),
        ],
    )
    def test_they_do_not_decide(self, name: str, unit: str, values: RealArray) -> None:
        found = find_drives(ride(channel("az", body()), channel(name, values, unit)))
        assert ends(found) == [(0.0, 120.0)]
        assert as_signal(found.records[0]).channels == ("az",)
        assert f"Left out, because not known to show vibration of the car: '{name}'" in str(found)

    @pytest.mark.parametrize("name", ["Accel Position", "accel_pedal", "AccelPos"])
    def test_the_pedal_of_a_car_is_no_acceleration(self, name: str) -> None:
        found = find_drives(ride(channel("az", body()), channel(name, 50 + 30 * np.sin(TIME), "")))
        assert found.records[0].output_labels == ["az"]

    def test_a_speed_that_is_held_among_the_channels_is_the_speed(self) -> None:
        """Satellites say it once a second; a steady one stays at its largest value for long."""
        speed = channel("locationSpeed", np.where(TIME < 40, 1.0, np.minimum(20 + self.HELD, 21)), "m/s")
        limits = DriveLimits(longitudinal=1e3)
        found = find_drives(ride(channel("az", body()), speed), channels=["az", "locationSpeed"], limits=limits)
        assert why(found, 20.0) == {DriveReason.SLOW}
        assert found.taken[-1].stop == 120.0
        assert found.usable > 75

    def test_a_channel_that_is_stuck_is_no_slow_one(self) -> None:
        motion = body(5)
        motion[2000:] = motion[2000]
        found = find_drives(ride(channel("az", motion), channel("bz", body(6))))
        assert ends(found) == [(0.0, 20.0)]

    def test_without_any_motion_it_is_refused(self) -> None:
        with (
            called({"channels": "--channel"}),
            pytest.raises(InputError, match=r"known to measure motion of the car: 'oil'.* in --channel"),
        ):
            find_drives(ride(channel("oil", 90 + body(), "°C"), channel("speed", constant(15.0), "m/s")))


class TestStretches:
    def test_they_cover_the_recording_in_order(self) -> None:
        speed = 12 + 12 * np.sin(2 * np.pi * TIME / 37)
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert len(found) > 4
        assert found[0].start == 0.0
        assert found[-1].stop == pytest.approx(120.0)
        assert all(a.stop == pytest.approx(b.start) for a, b in pairwise(found))
        assert all(one.length >= 10 - 1e-9 for one in found.taken)
        assert found.length == pytest.approx(found.usable + sum(one.length for one in found.left))

    def test_records_are_the_samples_of_the_file(self) -> None:
        motion = body()
        speed = channel("speed", np.where(TIME < 40, 0.0, 15.0), "m/s")
        (record,) = find_drives(ride(channel("az", motion), speed)).records
        signal = as_signal(record)
        assert signal.channels == ("az",)
        np.testing.assert_array_equal(signal.values[0], motion[np.searchsorted(TIME, signal.start) :])

    def test_short_ones_are_left(self) -> None:
        speed = channel("speed", np.where(TIME % 20 < 12, 15.0, 0.0), "m/s")
        quick = DriveLimits(shortest=5.0, longitudinal=1e3)
        assert len(find_drives(ride(channel("az", body()), speed), limits=quick).taken) == 6
        long = find_drives(ride(channel("az", body()), speed), limits=DriveLimits(shortest=15.0, longitudinal=1e3))
        assert not long.taken
        assert why(long, 5.0) == {DriveReason.SHORT}
        assert long.verdict.level.label == "none"

    @pytest.mark.parametrize(("seconds", "taken"), [(8, 0), (15, 4)])
    def test_eight_periods_of_a_body_are_long_enough(self, seconds: int, taken: int) -> None:
        speed = channel("speed", np.where(seconds > TIME % 30, 15.0, 0.0), "m/s")
        found = find_drives(ride(channel("az", body()), speed), limits=DriveLimits(longitudinal=1e3))
        assert len(found.taken) == taken

    def test_the_course_is_that_of_the_drive(self) -> None:
        speed = np.clip(0.5 * (TIME - 20), 0, 15)
        found = find_drives(ride(channel("az", body()), channel("speed", 3.6 * speed, "km/h")))
        times, shown, vibration = found.course.T
        np.testing.assert_allclose(times, np.arange(120) + 0.5, atol=1e-9)
        np.testing.assert_allclose(shown, np.clip(0.5 * (times - 20), 0, 15), atol=0.1)
        assert np.all(np.isfinite(vibration))

    def test_no_usable_stretch_says_why(self) -> None:
        speed = np.where(TIME < 80, 0.0, 15.0 + 8 * np.sin(TIME))
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert not found.taken
        assert "80 s slow, 40 s braking" in str(found.verdict.headline)

    def test_a_response_is_a_recording(self) -> None:
        found = find_drives(as_response(TIME, body()[None], ["az"]))
        assert ends(found) == [(0.0, 120.0)]
        assert DriveRemark.NO_UNIT in {note.code for note in found.verdict.notes}

    def test_a_car_says_which_channels_are_needed(self) -> None:
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
        )
        both = ride(channel("chassis_acceleration", body()), channel("temperature", np.full(TIME.size, np.nan), "°C"))
        assert ends(find_drives(both, car=car)) == [(0.0, 120.0)]
        with (
            called({"rename": "--rename"}),
            pytest.raises(InputError, match=r"measures the car: 'az'; .* \(--rename az=chassis_acceleration\)"),
        ):
            find_drives(ride(channel("az", body())), car=car)

    def test_the_tables_give_what_was_taken_first_and_reasons_by_how_long_they_held(self) -> None:
        """Two stops of 15 s and one of 5 s in which a sensor is missing; a clock that begins at -3.2 µs."""
        late = TIME - 3.2e-6
        motion, still = body(), (TIME < 15) | (TIME >= 105)
        motion[6000:6500] = np.nan
        speed = channel("speed", np.where(still, 0.0, 15.0), "m/s", times=late)
        found = find_drives(ride(channel("az", motion, times=late), speed), limits=DriveLimits(longitudinal=1e3))
        words = [line.split()[:3] for line in str(found).split("\n\n")[0].splitlines()[2:5]]
        assert words == [["2", "85", "taken"], ["2", "30", "left"], ["1", "5", "left"]]
        assert "usable: 30 s slow, 5 s missing" in str(nothing_usable(found, ()))
        assert stretch_table(found).splitlines()[2].split()[:2] == ["0", "15"]

    def test_text_fits_a_screen(self) -> None:
        speed = 12 + 12 * np.sin(2 * np.pi * TIME / 7)
        found = find_drives(ride(channel("az", body()), channel("speed", speed, "m/s")))
        assert len(str(found).splitlines()) < 25
        assert max(map(len, stretch_table(found).splitlines())) <= TERMINAL


@pytest.mark.parametrize(
    "wrong", [{"block": 0.0}, {"band_hz": (5.0, 1.0)}, {"band_hz": (0.0, 5.0)}, {"lateral": -1.0}, {"stuck": 0.0}]
)
def test_limits_that_make_no_sense(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError):
        DriveLimits(**wrong)  # type: ignore[arg-type]
