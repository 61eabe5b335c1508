"""Sensors: a known rotation comes back, whatever it is, with the spread that is stated."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from suspid.cleaning import scaled, to_si, vertical
from suspid.errors import InputError, RecordError
from suspid.records import as_response
from suspid.units import RealArray

T = np.arange(4000) / 200
BOUNCE = 3 * np.exp(-0.5 * T) * np.sin(2 * np.pi * 1.5 * T)
NAMES = ["x", "y", "z"]


def still(gravity: float, sway: float = 0.1) -> RealArray:
    """Accelerations in the axes of the car, z up."""
    side = sway * np.exp(-0.5 * T) * np.sin(2 * np.pi * 2.5 * T)
    return np.array([side, 0.5 * side, gravity + BOUNCE])


def between(one: RealArray, other: RealArray) -> float:
    return float(np.degrees(np.arccos(np.clip(one @ other, -1, 1))))


class TestRotation:
    @pytest.mark.parametrize("seed", range(20))
    @pytest.mark.parametrize(("gravity", "unit"), [(9.80665, "m/s2"), (1.0, "g")])
    def test_any_orientation_gives_the_same_vertical_motion(self, seed: int, gravity: float, unit: str) -> None:
        turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
        scale = gravity / 9.80665
        record, found = vertical(as_response(T, turn @ (still(9.80665) * scale), NAMES))
        assert found.gravity_unit == unit
        # The side motion is not of mean zero over the record: 0.1 of it in 20 s is below 0.02 degrees.
        assert between(found.up, turn[:, 2]) < 0.02
        # 0.02 degrees of 0.1 m/s2 aside, and the mean of the bounce, which is taken away with gravity.
        about = BOUNCE - BOUNCE.mean()
        assert record.y[0] == pytest.approx(scale * about, abs=1e-3 * scale)
        assert found.agree

    @pytest.mark.parametrize("seed", range(20))
    def test_gravity_length_and_shares_do_not_depend_on_it(self, seed: int) -> None:
        turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
        plain, turned = (vertical(as_response(T, m @ still(9.81), NAMES))[1] for m in (np.eye(3), turn))
        for name in ("gravity", "explained", "principal_explained", "apart_deg", "std_deg", "principal_std_deg"):
            assert getattr(turned, name) == pytest.approx(getattr(plain, name), rel=1e-6, abs=1e-6)

    @pytest.mark.parametrize("angle", [0.0, 5.0, 30.0, 44.0])
    def test_tilt(self, angle: float) -> None:
        turn = Rotation.from_euler("x", angle, degrees=True).as_matrix()
        _, found = vertical(as_response(T, turn @ still(9.81, sway=0.0), NAMES))
        assert found.tilt_deg == pytest.approx(angle, abs=1e-6)
        assert found.nearest_axis == "z"


class TestSpread:
    @pytest.mark.parametrize("by", ["gravity", "motion"])
    def test_error_is_of_the_size_stated(self, by: str) -> None:
        rng = np.random.default_rng(1)
        apart = []
        for _ in range(200):
            turn = Rotation.random(rng=rng).as_matrix()
            values = turn @ (still(9.80665, sway=0.0) + 0.3 * rng.standard_normal((3, T.size)))
            _, found = vertical(as_response(T, values, NAMES), by="gravity" if by == "gravity" else "motion")
            std = found.std_deg
            apart.append(between(found.up, turn[:, 2]) ** 2 / (2 * std**2))
        # Two planes, 200 records: the mean of 400 squares spreads by 0.07 (about 1.05: the std is an estimate too).
        assert np.mean(apart) == pytest.approx(1.05, abs=0.3)


class TestGravity:
    def test_up_is_positive_where_it_is_measured(self) -> None:
        for sign in (1, -1):
            record, found = vertical(as_response(T, sign * still(9.81), NAMES))
            # At rest an accelerometer reads +g along up: turned over, up is -z of the sensor.
            assert found.up[2] == pytest.approx(sign, abs=1e-3)
            assert record.y[0] == pytest.approx(BOUNCE - BOUNCE.mean(), abs=1e-3)

    def test_without_it_the_largest_motion_is_taken(self) -> None:
        _, found = vertical(as_response(T, still(0.0), NAMES))
        assert (found.by, found.gravity_unit) == ("motion", "")
        assert "not measured" in str(found)
        with pytest.raises(RecordError, match="gravity is not measured"):
            vertical(as_response(T, still(0.0), NAMES), by="gravity")

    def test_sideways_motion_does_not_agree(self) -> None:
        _, found = vertical(as_response(T, np.array([BOUNCE, 0 * T, 9.81 + 0.1 * BOUNCE]), NAMES))
        assert found.by == "gravity"
        assert not found.agree
        # tan of the angle of the motion is 10; gravity itself leans by the mean of the bounce.
        assert found.apart_deg == pytest.approx(np.degrees(np.arctan(10)), abs=1.0)
        assert "do not agree" in str(found)

    def test_share_is_that_of_the_variance(self) -> None:
        side = 0.5 * np.roll(BOUNCE, 50)
        _, found = vertical(as_response(T, np.array([side, 0 * T, 9.81 + BOUNCE]), NAMES), by="gravity")
        assert found.explained == pytest.approx(np.var(BOUNCE) / (np.var(BOUNCE) + np.var(side)), abs=2e-3)


class TestAxes:
    def test_three_of_more_are_named(self) -> None:
        values = np.concatenate([still(9.81), [T]])
        record, found = vertical(as_response(T, values, [*NAMES, "t"]), axes=NAMES, name="up")
        assert record.output_labels == ["up"]
        assert found.axes == tuple(NAMES)

    def test_others_are_refused(self) -> None:
        with pytest.raises(RecordError, match="not 2 channels"):
            vertical(as_response(T, still(9.81)[:2], NAMES[:2]))
        with pytest.raises(RecordError, match="no channel 'w'"):
            vertical(as_response(T, still(9.81), NAMES), axes=["x", "y", "w"])
        with pytest.raises(RecordError, match="nothing moves"):
            vertical(as_response(T, np.ones((3, T.size)), NAMES))


class TestScales:
    def test_factors_and_their_inverses_cancel(self) -> None:
        record = as_response(T, still(9.81), NAMES)
        there = scaled(record, {"x": -4.0, "z": 0.25})
        assert scaled(there, {"x": -0.25, "z": 4.0}).y.tobytes() == record.y.tobytes()

    @pytest.mark.parametrize("factor", [0.0, np.nan, np.inf])
    def test_factors_that_lose_the_channel(self, factor: float) -> None:
        with pytest.raises(InputError, match="'x'"):
            scaled(as_response(T, still(9.81), NAMES), {"x": factor})
        with pytest.raises(InputError, match="no channel 'w'"):
            scaled(as_response(T, still(9.81), NAMES), {"w": 1.0})

    @pytest.mark.parametrize(
        ("value", "unit", "expected", "si"),
        [
            (25.4, "mm", 0.0254, "m"), (1, "in", 0.0254, "m"), (1, "g", 9.80665, "m/s2"), (1, "[g]", 9.80665, "m/s2"),
            (2, "m/s^2", 2, "m/s2"), (2, "m/s²", 2, "m/s2"), (2, "m/s/s", 2, "m/s2"), (2, "m s-2", 2, "m/s2"),
            (36, "km/h", 10, "m/s"), (180, "deg", np.pi, "rad"), (180, "°/s", np.pi, "rad/s"),
            (60, "rpm", 2 * np.pi, "rad/s"),
            (250, "µε", 2.5e-4, "strain"), (250, "ue", 2.5e-4, "strain"), (250, "um/m", 2.5e-4, "strain"),
            # From the definitions: pound 0.45359237 kg, inch 25.4 mm, standard gravity 9.80665 m/s2, mile 1609.344 m.
            (1, "psi", 0.45359237 * 9.80665 / 0.0254**2, "Pa"), (1, "lbf", 0.45359237 * 9.80665, "N"),
            (1, "kgf", 9.80665, "N"), (1, "ft", 12 * 0.0254, "m"), (1, "mil", 2.54e-5, "m"), (1, "ips", 0.0254, "m/s"),
            (1, "ft/s", 12 * 0.0254, "m/s"), (1, "in/s2", 0.0254, "m/s2"), (1, "ft/s2", 12 * 0.0254, "m/s2"),
            (1, "mph", 1609.344 / 3600, "m/s"), (1, "Gal", 0.01, "m/s2"), (1, "mg", 9.80665e-3, "m/s2"),
            (1, "bar", 1e5, "Pa"), (1, "kPa", 1e3, "Pa"), (1, "mV", 1e-3, "V"), (1, "dps", np.pi / 180, "rad/s"),
            (1, "mrad", 1e-3, "rad"), (1, "mm/m", 1e-3, "strain"), (1, "cm", 0.01, "m"), (1, "dm", 0.1, "m"),
            (1, "nm", 1e-9, "m"), (1, "um", 1e-6, "m"), (1, "mm/s", 1e-3, "m/s"), (1, "cm/s^2", 0.01, "m/s2"),
            (2, "kN", 2000, "N"), (1, "kn", 1852 / 3600, "m/s"), (3, "N", 3, "N"),
            (1, "milli-g", 9.80665e-3, "m/s2"), (1, "milli g", 9.80665e-3, "m/s2"), (1, "mG", 9.80665e-3, "m/s2"),
            (1, "mGal", 1e-5, "m/s2"), (1, "cm/s²", 0.01, "m/s2"), (1, "ft/s^2", 12 * 0.0254, "m/s2"),
            (1, "g-force", 9.80665, "m/s2"), (1, "Millimeters", 1e-3, "m"), (1, "inches", 0.0254, "m"),
        ],
    )  # fmt: skip
    def test_units(self, value: float, unit: str, expected: float, si: str) -> None:
        values, to = to_si([value], unit)
        assert float(values[0]) == pytest.approx(expected, rel=1e-12)
        assert to == si

    def test_unknown_units_are_said(self) -> None:
        with pytest.raises(InputError, match="'furlong' is not known"):
            to_si(1.0, "furlong")
