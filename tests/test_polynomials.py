"""The sum over sets of struts is the determinant, and its derivatives are those of the determinant."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from suspid import ModalSet, Suspension, eigenmodes, full_car, half_car
from suspid.reconstruction.asked import unknowns_of
from suspid.reconstruction.equations import spectral
from suspid.reconstruction.observations import ModalTest, modal_tests, observe
from suspid.reconstruction.polynomials import characteristic, principal_minors
from suspid.reconstruction.unknowns import Unknowns
from validation.cars import HATCHBACK, PAPER
from validation.springs import nominal

HALF = half_car(
    chassis_mass=700, pitch_inertia=1100, front_tire_mass=40, rear_tire_mass=45, cg_to_front=1.2, cg_to_rear=1.5,
    front_stiffness=22e3, rear_stiffness=25e3, front_tire_stiffness=180e3, rear_tire_stiffness=190e3,
    front_damping=1500, rear_damping=1800, rear_tire_damping=50,
)  # fmt: skip
FULL = full_car(
    chassis_mass=1200, pitch_inertia=2000, roll_inertia=500, front_tire_mass=40, rear_tire_mass=45,
    cg_to_front=1.2, cg_to_rear=1.5, front_track=1.5, rear_track=1.5,
    front_stiffness=22e3, rear_stiffness=25e3, front_tire_stiffness=180e3, rear_tire_stiffness=190e3,
    front_damping=1500, rear_damping=1800, rear_tire_damping=50,
)  # fmt: skip
by_car = pytest.mark.parametrize(
    "car", [PAPER, HATCHBACK, HALF, FULL], ids=["paper", "hatchback", "half car", "full car"]
)


def unknowns(car: Suspension, **wishes: object) -> Unknowns:
    return unknowns_of(nominal(car), rate=20.0, **wishes)  # type: ignore[arg-type]


class TestCauchyAndBinet:
    def test_minors_one_by_one(self) -> None:
        G = np.random.default_rng(0).standard_normal((4, 4))
        minors = principal_minors(G)
        for size in range(1, 5):
            for chosen in itertools.combinations(range(4), size):
                number = sum(1 << i for i in chosen)
                expected = np.linalg.det(G[np.ix_(chosen, chosen)])
                assert minors[number] == pytest.approx(expected, rel=1e-12), chosen

    @by_car
    def test_the_sum_is_the_determinant(self, car: Suspension) -> None:
        """Against the determinant of the dynamic matrix, scaled as `Observed` says, with a mass added."""
        first = car.coordinates[0]
        test = ModalTest(modes=ModalSet(poles=eigenmodes(car).poles), added_masses={first: 30.0})
        seen, _ = observe(test, car)
        u = unknowns(car)
        polynomial = characteristic(seen, u)
        assert polynomial is not None
        for x in np.random.default_rng(1).uniform(0.2, 3.0, (5, len(u))):
            other = u.suspension(x)
            M = other.M + np.diag(seen.added)
            values = [np.linalg.det(np.linalg.solve(M, s**2 * M + s * other.C + other.K)) for s in seen.nodes]
            expected = (np.array(values) - seen.target) / seen.spacing
            (residual,), _ = polynomial(x[None])
            np.testing.assert_allclose(
                residual,
                np.concatenate([expected.real, expected.imag[~seen.real]]),
                rtol=1e-9,
                atol=1e-11 * np.max(np.abs(expected)),
                err_msg="two sums of up to 256 terms",
            )

    @by_car
    def test_its_derivatives_are_those_of_the_determinant(self, car: Suspension) -> None:
        (test,) = modal_tests(ModalSet(poles=eigenmodes(car).poles), car)
        seen, _ = observe(test, car)
        u = unknowns(car)
        polynomial = characteristic(seen, u)
        assert polynomial is not None
        x = np.random.default_rng(2).uniform(0.2, 3.0, (7, len(u)))
        residual, slope = polynomial(x)
        theirs, per_parameter = spectral(seen, u.arms, u.parameters(x))
        np.testing.assert_allclose(residual, theirs, rtol=0, atol=1e-10 * np.max(np.abs(theirs)))
        expected = per_parameter @ u.spread
        np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-10 * np.max(np.abs(expected)))


class TestUnknowns:
    def test_what_is_held_and_tied_counts(self) -> None:
        u = unknowns(HALF, fixed=["front_tire"], ties=[("front.damping", "rear.damping")])
        (test,) = modal_tests(ModalSet(poles=eigenmodes(HALF).poles), HALF)
        seen, _ = observe(test, HALF)
        polynomial = characteristic(seen, u)
        assert polynomial is not None
        x = np.random.default_rng(3).uniform(0.2, 3.0, (3, len(u)))
        residual, slope = polynomial(x)
        theirs, per_parameter = spectral(seen, u.arms, u.parameters(x))
        np.testing.assert_allclose(residual, theirs, rtol=0, atol=1e-11 * np.max(np.abs(theirs)))
        np.testing.assert_allclose(slope, per_parameter @ u.spread, rtol=0, atol=1e-11 * np.max(np.abs(slope)))

    def test_unknown_masses_have_none(self) -> None:
        (test,) = modal_tests(eigenmodes(PAPER), PAPER)
        seen, _ = observe(test, PAPER)
        assert characteristic(seen, unknowns(PAPER, free_masses=["seat"])) is None
