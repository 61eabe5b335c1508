"""A mount in series with the damper: b(s) = k + c s / (1 + rho s)."""

import math
import re

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm

from suspid import InputError, Strut, Suspension, eigenmodes, free_decay, quarter_car, reconstruct, statespace
from suspid.greybox.modal import mounted_car
from suspid.model import car_from_toml, car_to_toml
from suspid.units import RealArray

K, C, MOUNT, MASS = 20e3, 1500.0, 4e5, 350.0


def oscillator(mount: float | None) -> Suspension:
    strut = Strut(name="strut", stiffness=K, damping=C, mount_stiffness=mount, arms={"mass": 1.0, "road": -1.0})
    return Suspension(masses={"mass": MASS}, struts=[strut])


def car(chassis: float | None = MOUNT, tire: float | None = None, damping: float = C) -> Suspension:
    plain = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=damping,
        tire_damping=80,
    )  # fmt: skip
    mounts = {"chassis": chassis, "tire": tire}
    return plain.with_parameters(mount_stiffness={name: m for name, m in mounts.items() if m is not None})


class TestLaws:
    @pytest.mark.parametrize("f", [0.01, 1.3, 12.0, 300.0])
    @pytest.mark.parametrize("rate", [True, False])
    @pytest.mark.parametrize("tire", [None, 3e5])
    def test_the_transfer_function_is_that_of_the_formula(self, f: float, rate: bool, tire: float | None) -> None:
        one, s = car(tire=tire), 2j * np.pi * f
        b = [x.stiffness + x.damping * s / (1 + x.relaxation * s) for x in one.struts]
        arms, roads = one.arms(one.coordinates), one.arms(one.roads)
        stiffness = (one.M * s**2) + arms.T * b @ arms
        expected = np.linalg.solve(stiffness, -arms.T * b @ roads)[:, 0]
        found = np.asarray(statespace(one, road_rate=rate)(s, squeeze=False))
        found = found @ [1, s] if rate else found[:, 0]
        # Far above the modes the response is a small difference of large terms.
        np.testing.assert_allclose(found, expected, rtol=1e-8)

    def test_poles_are_the_roots_of_the_characteristic_polynomial(self) -> None:
        rho = C / MOUNT
        roots = np.roots([MASS * rho, MASS, K * rho + C, K])
        modes = eigenmodes(oscillator(MOUNT))
        assert modes.kinds == ("pair", "real")
        np.testing.assert_allclose(np.sort_complex(modes.poles), np.sort_complex(roots[roots.imag >= 0]), rtol=1e-12)

    def test_a_stiffening_mount_becomes_none_by_first_order(self) -> None:
        rigid = eigenmodes(oscillator(None)).poles[0]
        off = [abs(eigenmodes(oscillator(mount)).poles[0] - rigid) for mount in (1e8, 2e8)]
        # The shift is proportional to rho, up to terms of wn rho = 1e-4.
        np.testing.assert_allclose(off[0] / off[1], 2.0, rtol=1e-3)
        assert off[0] < 1e-3 * abs(rigid)

    def test_a_rigid_damper_leaves_the_mount_as_a_spring(self) -> None:
        found = eigenmodes(car(damping=1e12)).wn
        alone = eigenmodes(car(None, damping=0.0).with_parameters(stiffness={"chassis": 22e3 + MOUNT})).wn
        np.testing.assert_allclose(found[-2:], alone, rtol=1e-6)

    def test_a_mount_without_a_damper_does_nothing(self) -> None:
        np.testing.assert_array_equal(statespace(car(damping=0.0)).A, statespace(car(None, damping=0.0)).A)

    def test_energy_is_only_lost(self) -> None:
        one = car(tire=3e5)
        start = {"z_chassis": 0.02, "v_tire": 1.0, "d_chassis": -0.01}
        assert statespace(one).state_labels[-2:] == ["d_chassis", "d_tire"]
        states = _states(one, start)
        z, v, d = states[:2], states[2:4], states[4:]
        e = one.arms(one.coordinates) @ z
        mounts = np.array([s.mount_stiffness for s in one.struts], float)[:, None]
        springs = np.array([s.stiffness for s in one.struts])[:, None]
        masses = np.diag(one.M)[:, None]
        energy = np.sum(masses * v**2, axis=0) + np.sum(springs * e**2 + mounts * (e - d) ** 2, axis=0)
        assert np.all(np.diff(energy) <= 1e-12 * energy[0])
        assert energy[-1] < 1e-6 * energy[0]


def _states(one: Suspension, start: dict[str, float]) -> RealArray:
    system = statespace(one)
    first = np.array([start.get(label, 0.0) for label in system.state_labels])
    step, states = expm(system.A * 0.002), [first]
    for _ in range(1500):
        states.append(step @ states[-1])
    return np.transpose(states)


class TestUse:
    def test_free_decay_to_fifty_digits(self) -> None:
        system = statespace(car())
        start = {"v_tire": 1.0}
        found = free_decay(car(), 0.01 * np.arange(200), initial_state=start).y
        first = [start.get(label, 0.0) for label in system.state_labels]
        with mpmath.workdps(50):
            states = mpmath.expm(mpmath.matrix(system.A.tolist()) * mpmath.mpf(0.01 * 150)) * mpmath.matrix(first)
        np.testing.assert_allclose(found[:, 150], [float(x) for x in states[:2]], atol=1e-11)

    def test_toml_keeps_it(self) -> None:
        assert car_from_toml(car_to_toml(car())) == car()
        assert car().with_parameters(damping={"chassis": 3000}).struts[0].relaxation == math.ldexp(C / MOUNT, 1)

    @pytest.mark.parametrize("mount", [0.0, -1.0, math.inf, "1e6"])
    def test_wrong_mounts_are_refused(self, mount: float) -> None:
        with pytest.raises(InputError, match="strut 'strut': mount_stiffness = "):
            oscillator(mount)

    def test_refused_where_the_plain_strut_is_meant(self) -> None:
        message = re.escape("but the damper of strut 'chassis' is on a mount; remove mount_stiffness")
        with pytest.raises(InputError, match=f"reconstruct .*{message}"):
            reconstruct(eigenmodes(car(None)), car())
        with pytest.raises(InputError, match=message):
            _ = car().C


def test_a_mount_far_stiffer_than_a_record_tells_is_rigid() -> None:
    """Rounding of a simulation left 3e-8 s, known not to be zero: a mode of 5 MHz, and no intervals of the others."""
    names, found = ("chassis.relaxation", "chassis.damping"), np.array([3e-8, C])
    plain = mounted_car(car(), names, found, np.array([1e-9, 1.0]), 2e-3)
    assert next(strut for strut in plain.struts if strut.name == "chassis").mount_stiffness is None
    soft = mounted_car(car(), names, found * [1e3, 1.0], np.array([1e-9, 1.0]), 2e-3)
    assert next(strut for strut in soft.struts if strut.name == "chassis").mount_stiffness == pytest.approx(C / 3e-5)
