"""Struts with friction and curves: their description, and their motion against exact solutions and integrators."""

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline

from suspid import (
    InputError,
    Strut,
    Suspension,
    compare,
    eigenmodes,
    estimate,
    free_decay,
    quarter_car,
    reconstruct,
    road_profile,
    simulate,
    statespace,
    write_car,
)  # fmt: skip
from suspid.cli.main import main
from suspid.model import car_from_toml, car_to_toml
from suspid.model.force_curves import equal_work, piecewise
from suspid.units import RealArray

CURVE = ((-1.0, -700.0), (-0.1, -130.0), (0.0, 0.0), (0.08, 300.0), (1.0, 1700.0))
MASS, K, FRICTION = 10.0, 4000.0, 20.0
OUTPUTS = ["chassis_acceleration", "tire_acceleration", "chassis_travel", "tire_velocity", "road"]


def oscillator(**changes: Any) -> Suspension:
    given = {"damping": 0.0, "friction": FRICTION, **changes}
    arms = {"mass": 1.0, "ground": -1.0}
    return Suspension(masses={"mass": MASS}, struts=[Strut(name="s", stiffness=K, arms=arms, **given)])


def car(**changes: Any) -> Suspension:
    plain = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300,
        tire_damping=60,
    )  # fmt: skip
    return plain.with_parameters(**changes)


def straight(damping: float) -> tuple[tuple[float, float], ...]:
    """Return the curve of a viscous damper, with points that mean nothing."""
    return tuple((v, damping * v) for v in (-1.0, -0.1, -0.01, 0.0, 0.05, 1.0))


def road(seconds: float = 4.0) -> tuple[RealArray, RealArray]:
    t = np.arange(0, seconds, 0.005)
    return t, road_profile(20 * t, roughness="B", rng=np.random.default_rng(3))


class TestDescription:
    def test_a_curve_is_kept_as_floats_and_equal_struts_are_equal(self) -> None:
        one = oscillator(curve=[[-1, -700], [0, 0], [1, 1300]]).struts[0]
        assert one.curve == ((-1.0, -700.0), (0.0, 0.0), (1.0, 1300.0))
        assert one == oscillator(curve=np.array(one.curve)).struts[0]
        assert hash(one) == hash(oscillator(curve=one.curve).struts[0])
        assert one != oscillator(curve=((-1, -700), (0, 0), (1, 1301))).struts[0]

    @pytest.mark.parametrize(
        ("changes", "message"),
        [
            ({"friction": -1.0}, "friction = -1 N is negative"),
            ({"curve": ((0.0, 0.0),)}, "two or more points"),
            ({"curve": 1300.0}, "two or more points"),
            ({"curve": ((0.0, 0.0), 3.0)}, "point 2 = 3.0 must be a pair"),
            ({"curve": ((0.0, 0.0), (np.inf, 1.0))}, "is not finite"),
            ({"curve": ((0.0, 0.0), (0.0, 1.0))}, "does not exceed 0 m/s"),
            ({"curve": ((-1.0, -5.0), (0.0, 0.0), (1.0, -1.0))}, "the force falls from 0 to -1 N"),
            ({"curve": ((-1.0, -5.0), (1.0, 15.0))}, "the force at rest is 5 N"),
            ({"mount_stiffness": 1e6}, "needs damping > 0 or a curve"),
            ({"mount_stiffness": 1e6, "curve": ((0.0, 0.0), (0.1, 9.0), (1.0, 9.0))}, "strictly"),
        ],
    )
    def test_what_is_no_damper_is_refused(self, changes: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            oscillator(**changes)

    @pytest.mark.parametrize(
        "verb",
        [
            statespace,
            eigenmodes,
            lambda one: one.C,
            lambda one: reconstruct(eigenmodes(one.linearised()), one),
            lambda one: estimate(free_decay(one, np.arange(0, 2, 0.01), initial_state={"z_mass": 0.05}), one),
        ],
    )
    @pytest.mark.parametrize("one", [oscillator(), oscillator(curve=CURVE, friction=0.0, damping=1500.0)])
    def test_linear_verbs_refuse_it_and_name_the_way_out(
        self, verb: Callable[[Suspension], object], one: Suspension
    ) -> None:
        with pytest.raises(InputError, match=r"linear struts, but strut 's' has .*car.linearised\(amplitude="):
            verb(one)
        assert eigenmodes(one.linearised(amplitude=0.2)).zeta[0] > 0

    def test_the_command_names_its_option(self, tmp_path: Path) -> None:
        one = oscillator()
        write_car(one, tmp_path / "car.toml")
        refused = CliRunner().invoke(main, ["modes", str(tmp_path / "car.toml")])
        assert refused.exit_code == 1
        assert "give --linearise" in refused.stderr
        assert "car.linearised" not in refused.stderr
        shown = CliRunner().invoke(main, ["modes", str(tmp_path / "car.toml"), "--linearise", "0.2"])
        assert shown.exit_code == 0
        assert shown.stdout.strip() == str(eigenmodes(one.linearised(amplitude=0.2))).strip()

    def test_friction_that_holds_a_mass_fast_is_no_damper(self, tmp_path: Path) -> None:
        """Of a mass on a spring ``4 F / (pi V) = 20 (k m)^(1/2)`` is the limit."""
        one = oscillator()
        strut = one.struts[0]
        least = 4 * strut.friction / (np.pi * 20 * np.sqrt(strut.stiffness * one.masses["mass"]))
        assert one.linearised(1.001 * least).linear
        with pytest.raises(InputError, match=f"^amplitude=.* is too small.*and at least {least:.2g} m/s$"):
            one.linearised(0.999 * least)
        write_car(one, tmp_path / "car.toml")
        refused = CliRunner().invoke(main, ["modes", str(tmp_path / "car.toml"), "--linearise", "1e-9"])
        assert refused.exit_code == 1
        assert "--linearise 1e-09 m/s is too small" in refused.stderr

    def test_of_a_curve_alone_every_amplitude_has_a_damper(self) -> None:
        """A piecewise linear curve has its slopes at zero: half their sum."""
        one = oscillator(curve=((-1.0, -500.0), (0.0, 0.0), (1.0, 1500.0)), friction=0.0)
        assert one.linearised(1e-9).struts[0].damping == pytest.approx(1000.0)

    def test_toml_returns_the_same_car(self) -> None:
        one = car(curve={"chassis": CURVE}, friction={"chassis": 30.0, "tire": 0.1}, mount_stiffness={"chassis": 1e6})
        assert car_from_toml(car_to_toml(one)) == one
        assert car_from_toml(car_to_toml(one)) != car(friction={"chassis": 30.0})

    @pytest.mark.parametrize("points", ["1.0", "[1.0, 2.0]", "[[0.0, 0.0], [1.0]]", "[[0.0, 0.0], [1.0, 'x']]"])
    def test_toml_that_is_no_curve_names_the_place(self, points: str) -> None:
        with pytest.raises(InputError, match=r"\[curves\]: "):
            car_from_toml(f"{car_to_toml(car())}\n[curves]\nchassis = {points}\n")

    def test_compare_sees_friction_and_curves(self) -> None:
        one = car(curve={"chassis": CURVE}, friction={"chassis": 30.0})
        assert compare(one, one).passed
        assert not compare(one, car()).passed
        weaker = tuple((v, 0.9 * f) for v, f in CURVE)
        assert not compare(car(curve={"chassis": weaker}, friction={"chassis": 30.0}), one, rtol=0.05).passed
        assert compare(car(curve={"chassis": straight(1300.0)}), car(), rtol=1e-9).passed


class TestEqualWork:
    @pytest.mark.parametrize("amplitude", [0.005, 0.08, 0.3, 2.0])
    @pytest.mark.parametrize("friction", [0.0, 30.0])
    def test_it_is_the_work_over_a_cycle(self, amplitude: float, friction: float) -> None:
        def power(angle: float) -> float:
            v = amplitude * np.cos(angle)
            return float((piecewise(CURVE, np.array([v]))[0] + friction * np.sign(v)) * v)

        bends = [np.arccos(v / amplitude) for v, _ in CURVE if abs(v) < amplitude]
        ends = np.unique([0.0, *bends, np.pi])
        work = 2 * sum(quad(power, a, b)[0] for a, b in pairwise(ends))
        # A viscous damper takes pi c V^2 per radian of phase and cycle.
        assert equal_work(CURVE, friction, amplitude) == pytest.approx(work / (np.pi * amplitude**2), rel=1e-9)

    def test_friction_alone(self) -> None:
        assert oscillator().struts[0].equivalent_damping(0.5) == pytest.approx(4 * FRICTION / (np.pi * 0.5))

    def test_no_amplitude(self) -> None:
        with pytest.raises(InputError, match="must be positive"):
            oscillator().struts[0].equivalent_damping(0.0)


class TestExactSolutions:
    def test_a_coulomb_oscillator_swings_in_half_cosines_about_the_ends_of_friction(self) -> None:
        t, start = np.arange(0, 4, 0.004), 0.0517
        found = free_decay(oscillator(), t, initial_state={"z_mass": start}).y.ravel()
        wn, stuck = np.sqrt(K / MASS), FRICTION / K
        expected, turn, half = np.empty_like(t), start, 0
        for i, now in enumerate(t):
            while abs(turn) > stuck and now > (half + 1) * np.pi / wn:
                turn, half = 2 * np.sign(turn) * stuck - turn, half + 1
            middle = np.sign(turn) * stuck
            moves = abs(turn) > stuck
            expected[i] = middle + (turn - middle) * np.cos(wn * (now - half * np.pi / wn)) if moves else turn
        # Friction creeps by 1 nm/s.
        np.testing.assert_allclose(found, expected, atol=1e-8 + 1e-9 * t[-1])

    def test_a_bilinear_damper_changes_at_each_turn(self) -> None:
        slow, fast = 20.0, 60.0
        t = np.arange(0, 4, 0.004)
        one = oscillator(friction=0.0, curve=((-1.0, -slow), (0.0, 0.0), (1.0, fast)))
        found = free_decay(one, t, initial_state={"z_mass": 0.05}).y.ravel()
        expected, begun, amplitude = np.empty_like(t), 0.0, 0.05
        wn = np.sqrt(K / MASS)
        for i, now in enumerate(t):
            while True:
                c = slow if amplitude > 0 else fast  # it moves down from above
                decay = c / (2 * MASS)
                wd = np.sqrt(wn**2 - decay**2)
                if now <= begun + np.pi / wd:
                    break
                begun, amplitude = begun + np.pi / wd, -amplitude * np.exp(-decay * np.pi / wd)
            s = now - begun
            expected[i] = amplitude * np.exp(-decay * s) * (np.cos(wd * s) + decay / wd * np.sin(wd * s))
        np.testing.assert_allclose(found, expected, atol=1e-12)

    def test_sticking_holds_a_displaced_mass(self) -> None:
        found = free_decay(oscillator(), np.arange(0, 10, 0.01), initial_state={"z_mass": 0.9 * FRICTION / K}).y
        np.testing.assert_allclose(found, 0.9 * FRICTION / K, atol=1e-9 * 10)

    @pytest.mark.parametrize("interpolation", ["linear", "cubic"])
    @pytest.mark.parametrize("mount", [None, 4e5])
    def test_a_straight_curve_is_a_viscous_damper(self, interpolation: str, mount: float | None) -> None:
        t, heights = road(2.0)
        changes = {} if mount is None else {"mount_stiffness": {"chassis": mount}}
        inputs = {"road": heights, "chassis_force": 100 * np.sin(9 * t)}
        start = {"z_chassis": 0.01, "v_tire": -0.3}
        made = [
            simulate(one, t, inputs, outputs=OUTPUTS, interpolation=interpolation, initial_state=start).y  # type: ignore[arg-type]
            for one in (car(**changes, curve={"chassis": straight(1300.0)}), car(**changes))
        ]
        np.testing.assert_allclose(made[0], made[1], rtol=0, atol=1e-10 * np.max(np.abs(made[1])))

    def test_a_straight_curve_between_wheel_and_road_and_a_given_rate(self) -> None:
        t, heights = road(2.0)
        inputs = {"road": heights, "road_rate": np.gradient(heights, t)}
        made = [simulate(one, t, inputs).y for one in (car(curve={"tire": straight(60.0)}), car())]
        np.testing.assert_allclose(made[0], made[1], rtol=0, atol=1e-10 * np.max(np.abs(made[1])))

    def test_uneven_times(self) -> None:
        even = np.arange(0, 1, 0.01)
        times, start = np.delete(even, [3, 4, 30]), {"z_mass": 0.05}
        whole = free_decay(oscillator(), even, initial_state=start).y.ravel()
        np.testing.assert_allclose(
            free_decay(oscillator(), times, initial_state=start).y.ravel(), np.delete(whole, [3, 4, 30]), atol=1e-9
        )


class TestIntegrators:
    """A second method: LSODA on the equations written out, with friction that is full above 1e-5 m/s."""

    @pytest.mark.parametrize("mount", [None, 2e5])
    @pytest.mark.slow
    def test_a_curve_with_friction_over_a_road(self, mount: float | None) -> None:
        t, heights = road(2.0)
        changes = {} if mount is None else {"mount_stiffness": {"chassis": mount}}
        one = car(curve={"chassis": CURVE}, friction={"chassis": 30.0}, **changes)
        found = simulate(one, t, {"road": heights}, outputs=["chassis", "tire"], interpolation="cubic").y
        height = CubicSpline(t, heights)
        rate = height.derivative()
        forces = [f + 30.0 * np.sign(v) for v, f in CURVE if v]
        backwards = [*zip(forces[:2], (-1.0, -0.1), strict=True), (-30.0, 0.0), (30.0, 0.0)]
        backwards += list(zip(forces[2:], (0.08, 1.0), strict=True))

        def slope(now: float, s: RealArray) -> list[float]:
            z, v = s[:2], s[2:4]
            if mount is None:
                speed = v[0] - v[1]
                damper = piecewise(CURVE, np.array([speed]))[0] + 30.0 * np.clip(speed / 1e-5, -1, 1)
                own = 0.0
            else:
                damper = mount * (z[0] - z[1] - s[4])
                own = piecewise(backwards, np.array([damper]))[0]
            strut = 22e3 * (z[0] - z[1]) + damper
            tire = 210e3 * (z[1] - height(now)) + 60 * (v[1] - rate(now))
            return [v[0], v[1], -strut / 350, (strut - tire) / 50, own]

        made = solve_ivp(slope, (0, t[-1]), np.zeros(5), t_eval=t, method="LSODA", rtol=1e-9, atol=1e-12)
        # The integrator's friction creeps by 1e-5 m/s.
        np.testing.assert_allclose(found, made.y[:2], atol=3e-6)

    def test_a_point_of_a_curve_that_is_passed_twice_within_a_step(self) -> None:
        """The velocity peaks beyond the point at 0.08 m/s between two samples, and is below at both."""
        points = ((-1.0, -20.0), (0.0, 0.0), (0.08, 1.6), (1.0, 1841.6))

        def law(velocity: float) -> float:
            return 20 * velocity + 1980 * max(velocity - 0.08, 0.0)

        t, start = np.arange(0, 1, 0.05), -0.0046
        found = free_decay(oscillator(friction=0.0, curve=points), t, initial_state={"z_mass": start}).y.ravel()
        made = solve_ivp(
            lambda _, s: [s[1], -(K * s[0] + law(s[1])) / MASS], (0, t[-1]), [start, 0.0], t_eval=t, max_step=1e-3,
            rtol=1e-11, atol=1e-14, dense_output=True,
        )  # fmt: skip
        assert np.all(made.y[1] < 0.08)
        dense: Any = made.sol
        assert np.max(dense(np.linspace(0, 0.2, 400))[1]) > 0.081
        np.testing.assert_allclose(found, made.y[0], rtol=0, atol=1e-9)

    def test_two_dampers_that_stick(self) -> None:
        """Two masses in a chain, both with friction: they come to rest where friction holds both."""
        struts = [
            Strut(name="low", stiffness=3e3, damping=5.0, friction=8.0, arms={"a": 1.0, "ground": -1.0}),
            Strut(name="high", stiffness=2e3, damping=5.0, friction=6.0, arms={"b": 1.0, "a": -1.0}),
        ]
        one = Suspension(masses={"a": 5.0, "b": 3.0}, struts=struts)
        t = np.arange(0, 3, 0.005)
        found = free_decay(one, t, initial_state={"z_a": 0.03, "v_b": 1.0}).y

        def slope(_: float, s: RealArray) -> list[float]:
            low = 3e3 * s[0] + 5 * s[2] + 8 * np.clip(s[2] / 1e-6, -1, 1)
            high = 2e3 * (s[1] - s[0]) + 5 * (s[3] - s[2]) + 6 * np.clip((s[3] - s[2]) / 1e-6, -1, 1)
            return [s[2], s[3], (high - low) / 5, -high / 3]

        made = solve_ivp(slope, (0, t[-1]), [0.03, 0, 0, 1.0], t_eval=t, method="LSODA", rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(found, made.y[:2], atol=6e-6)
        still = found[:, -1]
        assert abs(2e3 * (still[1] - still[0])) <= 6.0
        assert abs(3e3 * still[0] - 2e3 * (still[1] - still[0])) <= 8.0
        assert np.max(np.abs(found[:, -1] - found[:, -20])) < 1e-8


class TestRefusals:
    def test_impulse(self) -> None:
        with pytest.raises(InputError, match="give the state after it: initial_state"):
            free_decay(oscillator(), np.arange(0, 1, 0.1), impulse="ground")

    def test_unknown_names(self) -> None:
        t, heights = road(1.0)
        with pytest.raises(InputError, match="there is no input 'rod'"):
            simulate(car(friction={"chassis": 9.0}), t, {"rod": heights})
        with pytest.raises(InputError, match="there is no state 'v_seat'"):
            free_decay(oscillator(), t, initial_state={"v_seat": 1.0})
        with pytest.raises(InputError, match="depends on the acceleration of a road"):
            simulate(car(friction={"chassis": 9.0}), t, {"road": heights}, outputs=["road_acceleration"])
