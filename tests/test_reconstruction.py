"""From modes back to springs and dampers: exact modes in, exact parameters out; the rest is refused or said."""

from __future__ import annotations

import itertools
import threading
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from suspid import InputError, ModalSet, ReconstructionError, Strut, Suspension, eigenmodes, quarter_car
from suspid.model import pole_distances
from suspid.reconstruction import problem, programs
from suspid.reconstruction.cones import Cone, cone_of, optimality
from suspid.reconstruction.descent import descend
from suspid.reconstruction.programs import Limits, Optimum, Program, compiled, least_squares, solve
from suspid.reconstruction.reconstruct import Reconstruction, reconstruct
from suspid.reconstruction.unknowns import parameter_vector
from suspid.units import RealArray
from suspid.wording import called

CHANGES = (0.7, 1.3)


def paper_car(*, damping: Sequence[float] = (300, 200, 100), k: Sequence[float] = (200e3, 400e3, 800e3)) -> Suspension:
    return quarter_car(
        seat_mass=200,
        chassis_mass=200,
        tire_mass=200,
        seat_stiffness=k[0],
        chassis_stiffness=k[1],
        tire_stiffness=k[2],
        seat_damping=damping[0],
        chassis_damping=damping[1],
        tire_damping=damping[2],
    )


def heavy_car() -> Suspension:
    """A seat in a road car: zeta 0.22 to 0.27, and no damper in the tire."""
    return quarter_car(
        seat_mass=80,
        chassis_mass=320,
        tire_mass=40,
        seat_stiffness=16e3,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        seat_damping=500,
        chassis_damping=1500,
    )


def two_mass_car(*, chassis_damping: float = 2300.0, tire_damping: float = 0.0) -> Suspension:
    return quarter_car(
        chassis_mass=400,
        tire_mass=40,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        chassis_damping=chassis_damping,
        tire_damping=tire_damping,
    )


CARS = {
    "Table 1, ten times its damping": paper_car(),
    "Table 1 as printed": paper_car(damping=(30, 20, 10)),
    "heavy, three masses": heavy_car(),
    "two masses, zeta 0.4": two_mass_car(),
    "two masses, light": two_mass_car(chassis_damping=20.0, tire_damping=5.0),
    "two masses, overdamped": two_mass_car(chassis_damping=9000.0, tire_damping=100.0),
}
by_name = pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())


def parameters(car: Suspension) -> RealArray:
    return np.array([s.stiffness for s in car.struts] + [s.damping for s in car.struts])


def changed(car: Suspension, factors: Sequence[float] | RealArray) -> Suspension:
    values = parameters(car) * np.asarray(factors)
    names = [s.name for s in car.struts]
    return car.with_parameters(
        stiffness=dict(zip(names, values, strict=False)),
        damping=dict(zip(names, values[len(names) :], strict=True)),
    )


def error(found: Suspension, car: Suspension) -> float:
    """Return the worst error, relative; of a damper that is not there, relative to the strongest."""
    truth = parameters(car)
    strongest = max(s.damping for s in car.struts)
    return float(np.max(np.abs(parameters(found) - truth) / np.where(truth > 0, truth, strongest)))


def without_shapes(modes: ModalSet) -> ModalSet:
    n = 2 * len(modes)
    return ModalSet(poles=modes.poles, covariance=None if modes.covariance is None else modes.covariance[:n, :n])


def seen_at(modes: ModalSet, channels: Sequence[str]) -> ModalSet:
    assert modes.shapes is not None
    rows = [modes.channels.index(c) for c in channels]
    return ModalSet(poles=modes.poles, shapes=modes.shapes[rows], channels=channels)


def characteristic(car: Suspension, poles: Sequence[complex]) -> RealArray:
    """Return |det(lambda^2 M + lambda C + K)|, over the sum of the sizes of its terms in a chain of three."""
    values = []
    for pole in poles:
        matrix = pole**2 * car.M + pole * car.C + car.K
        values.append(abs(np.linalg.det(matrix)) / np.prod(np.linalg.norm(matrix, axis=1)))
    return np.array(values)


class TestExactModesGiveExactParameters:
    @by_name
    @pytest.mark.parametrize("shapes", [True, False], ids=["shapes", "poles alone"])
    def test_from_thirty_percent_off(self, car: Suspension, shapes: bool) -> None:
        modes = eigenmodes(car) if shapes else without_shapes(eigenmodes(car))
        for factors in itertools.islice(itertools.product(CHANGES, repeat=2 * len(car.struts)), 0, None, 7):
            answer = reconstruct(modes, changed(car, factors))
            # Poles carry 15 digits; light damping and close twins cost up to four of them.
            assert error(answer.suspension, car) < 1e-10, (factors, answer)
            assert answer.residual < 1e-12

    @by_name
    def test_from_up_to_fifty_percent_off_by_poles_alone(self, car: Suspension) -> None:
        modes, rng = without_shapes(eigenmodes(car)), np.random.default_rng(1)
        for factors in rng.uniform(0.5, 1.5, (15, 2 * len(car.struts))):
            assert error(reconstruct(modes, changed(car, factors)).suspension, car) < 1e-10, factors

    @settings(max_examples=40, deadline=None)
    @given(
        masses=st.tuples(*[st.floats(20, 500)] * 3),
        k=st.tuples(*[st.floats(3.5, 6)] * 3),
        c=st.tuples(*[st.one_of(st.just(0.0), st.floats(1e-3, 1.5))] * 3),
        off=st.tuples(*[st.sampled_from(CHANGES)] * 6),
    )
    def test_any_chain(
        self,
        masses: tuple[float, ...],
        k: tuple[float, ...],
        c: tuple[float, ...],
        off: tuple[float, ...],
    ) -> None:
        struts = [
            Strut(name=name, stiffness=10**rate, damping=2 * ratio * (10**rate * mass) ** 0.5, arms=arms)
            for name, mass, rate, ratio, arms in zip(
                "abc", masses, k, c, [{"a": 1, "b": -1}, {"b": 1, "c": -1}, {"c": 1, "road": -1}], strict=True
            )
        ]
        car = Suspension(masses=dict(zip("abc", masses, strict=True)), struts=struts)
        modes = eigenmodes(car)
        answer = reconstruct(modes, changed(car, off))
        truth = parameters(car)
        scale = np.where(truth > 1e-3 * np.max(truth[3:]), truth, np.max(truth[3:]) or 1.0)
        assert np.max(np.abs(parameters(answer.suspension) - truth) / scale) < 1e-6, answer
        # By poles alone it may be another car, but one with these poles, and passive.
        other = reconstruct(without_shapes(modes), changed(car, off))
        assert other.residual < 1e-6
        assert np.all(parameters(other.suspension) >= 0)

    def test_a_half_car_by_its_shapes(self) -> None:
        """Lever arms, two road inputs, four modes: the program is linear for any topology."""
        car = Suspension(
            masses={"heave": 700.0, "pitch": 1100.0, "front": 40.0, "rear": 45.0},
            struts=[
                Strut(name="sf", stiffness=22e3, damping=1500, arms={"heave": 1, "pitch": -1.2, "front": -1}),
                Strut(name="sr", stiffness=25e3, damping=1800, arms={"heave": 1, "pitch": 1.5, "rear": -1}),
                Strut(name="tf", stiffness=180e3, damping=0, arms={"front": 1, "road_f": -1}),
                Strut(name="tr", stiffness=190e3, damping=50, arms={"rear": 1, "road_r": -1}),
            ],
        )
        assert error(reconstruct(eigenmodes(car), changed(car, [0.7, 1.3] * 4)).suspension, car) < 1e-10

    @pytest.mark.parametrize("channels", [("seat", "tire"), ("chassis", "seat")])
    def test_shapes_at_two_of_three_coordinates(self, channels: tuple[str, ...]) -> None:
        car = paper_car()
        answer = reconstruct(seen_at(eigenmodes(car), channels), changed(car, [1.3, 0.7] * 3))
        assert error(answer.suspension, car) < 1e-10

    def test_one_mode_with_its_shape_is_enough(self) -> None:
        """Three complex equations for three complex strut forces."""
        car, modes = paper_car(), eigenmodes(paper_car())
        assert modes.shapes is not None
        one = ModalSet(poles=modes.poles[1:2], shapes=modes.shapes[:, 1:2], channels=modes.channels)
        assert error(reconstruct(one, changed(car, [1.3, 0.7] * 3)).suspension, car) < 1e-10

    def test_two_modes_when_a_strut_is_known(self) -> None:
        car = heavy_car()
        nominal = changed(car, [0.7, 1.3, 1.0, 1.3, 0.7, 1.0])
        two = ModalSet(poles=eigenmodes(car).poles[:2])
        answer = reconstruct(two, nominal, fixed=["tire"])
        assert error(answer.suspension, car) < 1e-10
        assert answer.held == ("tire.stiffness", "tire.damping")
        assert "stiffness, damping" in str(answer)


class TestInvariance:
    @given(st.floats(1e-3, 1e3))
    @settings(max_examples=15, deadline=None)
    def test_scaling_masses_and_rates_together(self, s: float) -> None:
        """M, C and K times s have the same modes, and come back times s."""
        car = heavy_car()
        scaled = changed(car, [s] * 6).with_parameters(masses={n: s * m for n, m in car.masses.items()})
        for modes in (eigenmodes(car), without_shapes(eigenmodes(car))):
            assert error(reconstruct(modes, changed(scaled, [0.7, 1.3] * 3)).suspension, scaled) < 1e-10

    @given(st.floats(1e-2, 1e2))
    @settings(max_examples=15, deadline=None)
    def test_another_unit_of_time(self, s: float) -> None:
        """Poles times s belong to k times s^2 and c times s."""
        car = paper_car()
        faster = changed(car, [s**2] * 3 + [s] * 3)
        modes = ModalSet(poles=s * eigenmodes(car).poles)
        assert error(reconstruct(modes, changed(faster, [0.8, 1.2] * 3)).suspension, faster) < 1e-9

    def test_order_of_modes_and_channels_and_complex_scale_of_shapes(self) -> None:
        car, modes, rng = heavy_car(), eigenmodes(heavy_car()), np.random.default_rng(2)
        assert modes.shapes is not None
        turned = modes.shapes * (rng.standard_normal(3) + 1j * rng.standard_normal(3))
        mixed = ModalSet(poles=modes.poles[[2, 0, 1]], shapes=turned[::-1, [2, 0, 1]], channels=modes.channels[::-1])
        assert error(reconstruct(mixed, changed(car, [0.7, 1.3] * 3)).suspension, car) < 1e-10


class TestTwin:
    """From w and zeta alone two chains have the spectrum of Table 1; only c >= 0 tells them apart."""

    def twin(self) -> tuple[Suspension, RealArray]:
        from scipy.optimize import root

        car = paper_car()
        poles = eigenmodes(car).poles

        def off(x: RealArray) -> list[float]:
            k, c = x[:3] * 1e5, x[3:] * 1e2
            arms = car.arms(car.coordinates)
            C, K = arms.T * c @ arms, arms.T * k @ arms
            values = [np.linalg.det((p**2 * car.M + p * C + K) / (200 * abs(p) ** 2)) for p in poles]
            return [part for v in values for part in (v.real, v.imag)]

        solution = root(off, [2.4, 4.85, 5.49, 2.1, -0.06, 6.8], tol=1e-13)
        return car, np.asarray(solution.x * np.repeat([1e5, 1e2], 3))

    def test_it_has_the_spectrum_and_one_negative_damper(self) -> None:
        car, x = self.twin()
        np.testing.assert_allclose(x[:3], [240.4e3, 485.2e3, 548.6e3], rtol=2e-4, err_msg="printed to 4 digits")
        np.testing.assert_allclose(x[3:], [214.9, -6.05, 682.4], rtol=1e-3, err_msg="printed to 3 digits")
        arms = car.arms(car.coordinates)
        C, K = arms.T * x[3:] @ arms, arms.T * x[:3] @ arms
        A = np.block([[np.zeros((3, 3)), np.eye(3)], [-K / 200, -C / 200]])
        poles = np.linalg.eigvals(A)
        distance = np.min(pole_distances(eigenmodes(car).poles, poles), axis=1)
        np.testing.assert_allclose(distance, 0, atol=1e-9, err_msg="the same spectrum, to the root's tolerance")

    def test_started_at_the_twin_the_passive_car_is_found(self) -> None:
        car, x = self.twin()
        nominal = changed(car, np.maximum(x, 0) / parameters(car))
        assert error(reconstruct(without_shapes(eigenmodes(car)), nominal).suspension, car) < 1e-10

    def test_when_zeta_is_known_to_one_percent_the_twin_stands(self) -> None:
        car, x = self.twin()
        modes = eigenmodes(car)
        measured = ModalSet.from_wn_zeta(modes.wn, modes.zeta, wn_std=1e-4 * modes.wn, zeta_std=0.01 * modes.zeta)
        answer = reconstruct(measured, changed(car, np.maximum(x, 0) / parameters(car)))
        assert answer.suspension.struts[1].damping == 0.0
        assert "at its bound: chassis.damping" in answer.status


class TestSecondMethod:
    def test_least_squares_on_the_characteristic_polynomial(self) -> None:
        """SciPy's solver on the polynomial's coefficients ends at the same car from the same start."""
        from scipy.optimize import least_squares

        car = heavy_car()
        modes = without_shapes(eigenmodes(car))
        target = np.poly(np.concatenate([modes.poles, modes.poles.conj()])).real[1:]
        nominal = changed(car, [1.2, 0.8, 1.1, 0.9, 1.2, 1.0]).with_parameters(damping={"tire": 20.0})

        def off(factors: RealArray) -> RealArray:
            trial = changed(nominal, factors)
            A = np.linalg.solve(trial.M, np.hstack([trial.K, trial.C]))
            matrix = np.block([[np.zeros((3, 3)), np.eye(3)], [-A[:, :3], -A[:, 3:]]])
            return np.asarray(np.poly(matrix).real[1:] / target - 1)

        theirs = least_squares(off, np.ones(6), bounds=(0, np.inf), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        ours = reconstruct(modes, nominal)
        # The bound at c_tire = 0 keeps SciPy's interior method at a distance.
        assert error(changed(nominal, theirs.x), ours.suspension) < 1e-4
        assert np.max(characteristic(ours.suspension, list(modes.poles))) < 1e-13


class TestUncertainty:
    def noisy(self, car: Suspension, rng: np.random.Generator, *, rel: float = 1e-4) -> ModalSet:
        modes = eigenmodes(car)
        assert modes.shapes is not None
        std = np.concatenate([np.repeat(np.abs(modes.poles) * rel, 2), np.full(2 * modes.shapes.size, 3 * rel)])
        noise = std * rng.standard_normal(len(std))
        n = len(modes)
        shapes = (noise[2 * n :: 2] + 1j * noise[2 * n + 1 :: 2]).reshape(n, -1).T
        return ModalSet(
            poles=modes.poles + noise[0 : 2 * n : 2] + 1j * noise[1 : 2 * n : 2],
            shapes=modes.shapes + shapes,
            channels=modes.channels,
            covariance=np.diag(std**2),
        )

    @pytest.mark.parametrize("alone", [False, True], ids=["shapes weighed", "poles weighed alone"])
    def test_standard_deviations_are_those_of_the_errors(self, alone: bool) -> None:
        car, rng = two_mass_car(chassis_damping=1500.0, tire_damping=200.0), np.random.default_rng(3)
        scores = []
        for _ in range(60):
            modes = self.noisy(car, rng)
            answer = reconstruct(without_shapes(modes) if alone else modes, changed(car, [0.7, 1.3] * 2))
            assert answer.stiffness_std is not None
            assert answer.damping_std is not None
            std = [*answer.stiffness_std.values(), *answer.damping_std.values()]
            scores.append((parameters(answer.suspension) - parameters(car)) / std)
        rms = np.sqrt(np.mean(np.square(scores), axis=0))
        # The rms of 60 standard normal numbers has a standard deviation of 0.09: four of them.
        np.testing.assert_allclose(rms, 1.0, atol=0.37, err_msg="errors over their predicted standard deviation")

    @pytest.mark.slow
    def test_weights_beat_no_weights(self) -> None:
        """One shape 100 times worse than the others: only the covariance tells."""
        car, rng = heavy_car(), np.random.default_rng(4)
        errors: dict[bool, list[float]] = {True: [], False: []}
        for _ in range(10):
            modes = eigenmodes(car)
            assert modes.shapes is not None
            std = np.full(2 * 3 + 2 * 9, 1e-5)
            std[6:12] = 1e-2
            noise = std * rng.standard_normal(24)
            shapes = modes.shapes + (noise[6::2] + 1j * noise[7::2]).reshape(3, 3).T
            for weighted, found in errors.items():
                seen = ModalSet(
                    poles=modes.poles,
                    shapes=shapes,
                    channels=modes.channels,
                    covariance=np.diag(std**2) if weighted else None,
                )
                found.append(error(reconstruct(seen, car).suspension, car))
        assert np.median(errors[True]) < 0.1 * np.median(errors[False])

    def test_a_complex_scale_of_shapes_and_their_covariance_changes_nothing(self) -> None:
        """Real and imaginary parts of the shapes differ in certainty, so their turning must be followed."""
        car, modes = heavy_car(), self.noisy(heavy_car(), np.random.default_rng(7))
        assert modes.shapes is not None
        assert modes.covariance is not None
        uneven = np.diag(modes.covariance) * np.tile([1.0, 100.0], 12)
        factors = np.array([2.0j, -0.3 + 0.4j, 1.0 - 5.0j])
        turn = np.eye(24)
        for row, g in enumerate(np.repeat(factors, 3)):
            turn[6 + 2 * row : 8 + 2 * row, 6 + 2 * row : 8 + 2 * row] = [[g.real, -g.imag], [g.imag, g.real]]
        plain, turned = (
            reconstruct(ModalSet(poles=modes.poles, shapes=shapes, channels=modes.channels, covariance=c), car)
            for shapes, c in ((modes.shapes, np.diag(uneven)), (modes.shapes * factors, turn * uneven @ turn.T))
        )
        # To first order alone: which coordinate is the reference may change.
        assert error(turned.suspension, plain.suspension) < 1e-6
        assert turned.stiffness_std is not None
        assert plain.stiffness_std is not None
        assert list(turned.stiffness_std.values()) == pytest.approx(list(plain.stiffness_std.values()), rel=1e-3)

    def test_exact_modes_have_none(self) -> None:
        answer = reconstruct(eigenmodes(heavy_car()), heavy_car())
        assert answer.stiffness_std is None
        assert answer.damping_std is None
        assert answer.alternatives == ()

    def test_what_is_held_has_no_spread(self) -> None:
        modes = self.noisy(heavy_car(), np.random.default_rng(5))
        answer = reconstruct(modes, heavy_car(), fixed=("tire.damping",))
        assert answer.damping_std is not None
        assert answer.damping_std["tire"] == 0.0
        assert answer.damping_std["chassis"] > 0.0


class TestPublishedModes:
    def test_table_2_gives_passive_springs_with_its_modes(self) -> None:
        """The paper's noise-free row: 0.2 % off in w, which the near twin magnifies ten times in k."""
        modes = ModalSet.from_wn_zeta([83.6732, 50.0925, 21.2686], [0.015568, 0.025293, 0.007905])
        answer = reconstruct(modes, paper_car())
        k = [s.stiffness for s in answer.suspension.struts]
        np.testing.assert_allclose(k, [200e3, 400e3, 800e3], rtol=0.03, err_msg="the printed modes are 0.2 % off")
        assert answer.residual < 1e-9


class TestRefusals:
    def test_fewer_equations_than_unknowns(self) -> None:
        modes = ModalSet(poles=eigenmodes(paper_car()).poles[:2])
        with pytest.raises(
            ReconstructionError, match=r"6 unknowns .* 4 equations from 2 modes.*fix at least 2"
        ) as said:
            reconstruct(modes, paper_car())
        assert "such as fixed=['chassis.damping', 'tire.damping']" in str(said.value)
        with called({"fixed": "--fixed"}):
            assert "such as --fixed chassis.damping,tire.damping" in str(said.value)

    @pytest.mark.parametrize("shapes", [True, False], ids=["shapes", "poles alone"])
    def test_two_struts_side_by_side_cannot_be_told_apart(self, shapes: bool) -> None:
        first, second, third = paper_car().struts
        twice = Strut(name="helper", stiffness=5e4, damping=50, arms=first.arms)
        car = Suspension(masses=paper_car().masses, struts=[first, twice, second, third])
        modes = eigenmodes(car) if shapes else without_shapes(eigenmodes(car))
        fixed = () if shapes else ("tire",)
        with pytest.raises(ReconstructionError, match=r"do not determine seat.stiffness, helper.stiffness, ") as caught:
            reconstruct(modes, car, fixed=fixed)
        assert "tire" not in str(caught.value).split(":")[0]
        assert isinstance(caught.value.best, Suspension)

    def test_modes_of_another_car(self) -> None:
        """A tenth of the mass below a spring cannot share its frequency."""
        modes = ModalSet.from_wn_zeta([10.0, 10.5], [0.1, 0.1])
        with pytest.raises(ReconstructionError, match=r"no suspension .* is off by") as caught:
            reconstruct(modes, two_mass_car())
        assert isinstance(caught.value.best, Suspension)

    def test_active_poles(self) -> None:
        with pytest.raises(ReconstructionError, match="c >= 0"):
            reconstruct(ModalSet.from_wn_zeta([7.0, 74.0], [-0.1, 0.2]), two_mass_car())

    def test_swapped_channels(self) -> None:
        modes = eigenmodes(paper_car())
        swapped = ModalSet(poles=modes.poles, shapes=modes.shapes, channels=("tire", "chassis", "seat"))
        with pytest.raises(ReconstructionError, match=r"MAC|pole error|off by"):
            reconstruct(swapped, paper_car())

    def test_right_poles_with_the_shapes_of_other_modes(self) -> None:
        """Where the poles alone are weighed, they can be met whatever the shapes are."""
        modes = eigenmodes(heavy_car())
        assert modes.shapes is not None
        measured = ModalSet(
            poles=modes.poles,
            shapes=modes.shapes[:, [0, 2, 1]],
            channels=modes.channels,
            covariance=1e-4 * np.eye(6),
        )
        with pytest.raises(ReconstructionError, match="MAC"):
            reconstruct(measured, heavy_car())

    @pytest.mark.parametrize("name", ["tyre.damping", "tire.dampin", "wheel"])
    def test_an_unknown_name_is_told_its_nearest(self, name: str) -> None:
        with pytest.raises(InputError, match=r"Did you mean|Known"):
            reconstruct(eigenmodes(heavy_car()), heavy_car(), fixed=[name])

    def test_nothing_left_to_find(self) -> None:
        with pytest.raises(InputError, match="fixed contains every parameter"):
            reconstruct(eigenmodes(heavy_car()), heavy_car(), fixed=["seat", "chassis", "tire"])

    def test_more_poles_than_the_suspension_has(self) -> None:
        with pytest.raises(InputError, match="6 poles"):
            reconstruct(eigenmodes(paper_car()), two_mass_car())

    def test_wrong_types(self) -> None:
        with pytest.raises(InputError, match="ModalSet"):
            reconstruct(heavy_car(), heavy_car())  # type: ignore[arg-type]

    def test_a_shape_of_zeros(self) -> None:
        modes = ModalSet(
            poles=eigenmodes(two_mass_car()).poles, shapes=np.zeros((2, 2), complex), channels=("chassis", "tire")
        )
        with pytest.raises(InputError, match="shape"):
            reconstruct(modes, two_mass_car())


class TestWhatIsSaid:
    def test_channels_that_are_no_coordinates(self) -> None:
        car, modes = heavy_car(), eigenmodes(heavy_car())
        strange = ModalSet(poles=modes.poles, shapes=modes.shapes, channels=("a", "b", "c"))
        answer = reconstruct(strange, changed(car, [0.8, 1.2] * 3))
        assert error(answer.suspension, car) < 1e-10
        assert "shapes not used: channel 'a'" in str(answer)

    def test_a_free_body_is_checked_and_not_asked(self) -> None:
        """Two masses and one strut on ice: the pole at zero says nothing, the other pair k and c."""
        strut = Strut(name="s", stiffness=1e4, damping=50.0, arms={"a": 1, "b": -1})
        car = Suspension(masses={"a": 10.0, "b": 30.0}, struts=[strut])
        answer = reconstruct(eigenmodes(car), changed(car, [0.7, 1.3]))
        # A double pole at zero is known to the root of the rounding error only.
        assert error(answer.suspension, car) < 1e-6
        mass = 1 / (1 / 10 + 1 / 30)
        assert eigenmodes(answer.suspension).wn[-1] == pytest.approx((1e4 / mass) ** 0.5, rel=1e-6)

    @pytest.mark.parametrize("shapes", [True, False], ids=["shapes", "poles alone"])
    def test_critical_damping(self, shapes: bool) -> None:
        """Two real poles meet, and their shapes with them: the poles around them still say all."""
        struts = [
            Strut(name="critical", stiffness=1e4, damping=2e3, arms={"a": 1, "road": -1}),
            Strut(name="light", stiffness=3e4, damping=100.0, arms={"b": 1, "rail": -1}),
        ]
        car = Suspension(masses={"a": 100.0, "b": 50.0}, struts=struts)
        modes = eigenmodes(car) if shapes else without_shapes(eigenmodes(car))
        answer = reconstruct(modes, changed(car, [0.8, 1.2, 1.2, 0.8]))
        # A double eigenvalue is known to the root of the rounding error, 1e-8; sum and product to more.
        assert error(answer.suspension, car) < 1e-7, answer

    def test_a_strut_without_spring_stays_a_damper(self) -> None:
        struts = [*two_mass_car().struts, Strut(name="sky", stiffness=0, damping=700, arms={"chassis": 1, "sky": -1})]
        car = Suspension(masses={"chassis": 400, "tire": 40}, struts=struts)
        answer = reconstruct(eigenmodes(car), changed(car, [0.7, 1.3, 1, 0.7, 1.3, 0.7]))
        assert error(answer.suspension, car) < 1e-10
        assert "sky.stiffness" in answer.held

    def test_the_table_has_units(self) -> None:
        text = str(reconstruct(eigenmodes(heavy_car()), heavy_car()))
        assert "stiffness [N/m]" in text
        assert "damping [N s/m]" in text


class TestProgram:
    def test_bounds_against_scipy(self) -> None:
        """The sharpened optimum is that of SciPy's active-set method, at any size of the data and of the columns."""
        from scipy.optimize import lsq_linear

        rng = np.random.default_rng(6)
        for size, unknowns in itertools.product((1e-9, 1e-5, 1.0, 1e5), (2, 4, 8, 16)):
            A = rng.standard_normal((2 * unknowns, unknowns)) * 10 ** rng.uniform(-3, 0, unknowns)
            b = size * rng.standard_normal(2 * unknowns)
            low, high = np.full(unknowns, -0.1 * size), np.full(unknowns, 0.2 * size)
            expected = lsq_linear(A, b / size, (low / size, high / size), method="bvls", tol=1e-15).x * size
            found = least_squares(A, b, Limits(low=low, high=high), smallest=1e-9 * size)
            np.testing.assert_allclose(found.x, expected, rtol=0, atol=1e-11 * size, err_msg=f"{size=}")
            inside = (expected > low + 1e-9 * size) & (expected < high - 1e-9 * size)
            assert found.free == np.sum(inside), "what no bound stops is free"

    def test_a_point_that_is_no_optimum_is_refused(self) -> None:
        """Stationarity, equalities, signs and complementarity are computed here, not taken from the solver."""
        program = compiled(2, threading.get_ident())
        A, b = np.array([[2.0, 1.0], [0.0, 1.0]]), np.array([3.0, -1.0])
        found = solve(program, {"A": A, "b": b, "low": np.zeros(2), "high": np.full(2, 1.0)})
        np.testing.assert_allclose(found.x, [1.0, 0.0], atol=1e-12, err_msg="by hand: both on a bound")
        data, chain, _ = program.problem.get_problem_data("CLARABEL", solver_opts={})
        raw = chain.solver.solve_via_data(data, warm_start=False, verbose=False, solver_opts={})
        cone, primal, dual = cone_of(data), np.array(raw.x), np.array(raw.z)
        assert optimality(cone, primal, dual) < 1e-6
        for i in range(len(primal)):
            assert optimality(cone, primal + 0.01 * np.eye(len(primal))[i], dual) > 1e-4, "another point"
        for i in range(len(dual)):
            assert optimality(cone, primal, dual - 0.01 * np.eye(len(dual))[i]) > 1e-4, "another multiplier"
        assert optimality(cone, np.full(len(primal), np.nan), dual) == np.inf

    @pytest.mark.parametrize(
        ("rows", "limits", "equations", "y", "dual"),
        [
            ([-1, 1], [0, 5], 0, 3, [0, 0]),  # not stationary
            ([1], [5], 1, 2, [0]),  # y == 5 is violated
            ([-1, 1], [0, 1], 0, 2, [0, 0]),  # y <= 1 is violated
            ([-1, 1], [0, 5], 0, 0, [-4, 0]),  # the bound y >= 0 would have to pull
            ([-1, 1], [0, 5], 0, 3, [2, 0]),  # a force of a bound that is not reached
        ],
    )
    def test_each_condition_of_an_optimum_counts_alone(
        self, rows: list[float], limits: list[float], equations: int, y: float, dual: list[float]
    ) -> None:
        """Least (y - 2)^2: each point violates one condition of Karush, Kuhn and Tucker and meets the other four."""
        cone = Cone(
            P=np.array([[2.0]]),
            c=np.array([-4.0]),
            A=np.array(rows, float)[:, None],
            b=np.array(limits, float),
            zero=equations,
            nonneg=len(rows) - equations,
        )
        assert optimality(cone, np.array([float(y)]), np.array(dual, float)) > 0.1

    @pytest.mark.parametrize("condition", [1e2, 1e4, 1e6])
    def test_its_error_is_that_of_the_data_times_their_condition(self, condition: float) -> None:
        """The optimality conditions hold the square of the condition number; refinement takes that back."""
        rng = np.random.default_rng(0)
        U, V = (np.linalg.qr(rng.normal(size=(n, 5)))[0] for n in (12, 5))
        A, x = U @ np.diag(np.geomspace(1, 1 / condition, 5)) @ V, rng.normal(size=5)
        found = least_squares(A, A @ x, Limits(low=np.full(5, -10.0), high=np.full(5, 10.0))).x
        np.testing.assert_allclose(found, x, rtol=0, atol=100 * np.finfo(float).eps * condition)

    def test_the_answer_is_that_of_a_program_of_cvxpy(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The suspension that is returned comes out of a program; the condition of its optimum is met."""
        asked: list[Optimum] = []

        def counted(program: Program, numbers: Mapping[str, RealArray | float]) -> Optimum:
            asked.append(solve(program, numbers))
            return asked[-1]

        monkeypatch.setattr(programs, "solve", counted)
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)
        for modes in (eigenmodes(car), without_shapes(eigenmodes(car))):
            asked.clear()
            reconstruct(modes, changed(car, [0.7, 1.3] * 2))
            assert asked
            assert all(one.left < 1e-9 for one in asked)

    @pytest.mark.parametrize(("weighted", "short_by", "rtol"), [(False, 1e-2, 1e-9), (True, 3e-5, 1e-6)])
    def test_the_program_and_not_the_search_ends_at_the_optimum(
        self, monkeypatch: pytest.MonkeyPatch, *, weighted: bool, short_by: float, rtol: float
    ) -> None:
        """With searches that end off the minimum, the answer is the same."""
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)
        exact, nominal = eigenmodes(car), changed(car, [0.9, 1.1] * 2)
        modes = without_shapes(exact)
        if weighted:
            off = ([1.0001, 0.9999], [0.995, 1.01])
            modes = ModalSet.from_wn_zeta(
                exact.wn * off[0], exact.zeta * off[1], wn_std=1e-4 * exact.wn, zeta_std=1e-2 * exact.zeta
            )
        expected = parameter_vector(reconstruct(modes, nominal, search=False).suspension)

        def short(*args: Any, **options: Any) -> RealArray:
            x = descend(*args, **options)
            return np.clip(
                x * np.where(np.arange(len(x)) % 2, 1 + short_by, 1 - short_by), options["lower"], options["upper"]
            )

        monkeypatch.setattr(problem, "descend", short)
        found = parameter_vector(reconstruct(modes, nominal, search=False).suspension)
        np.testing.assert_allclose(found, expected, rtol=rtol)

    def test_a_program_alone_solves_linear_equations(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Of shapes and poles that are exact, cvxpy alone makes the answer: twice its solution is twice the springs."""
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)

        def doubled(*args: Any, **options: Any) -> Optimum:
            found = least_squares(*args, **options)
            return replace(found, x=2 * found.x)

        monkeypatch.setattr(problem, "least_squares", doubled)
        with pytest.raises(ReconstructionError) as caught:
            reconstruct(eigenmodes(car), changed(car, [0.7, 1.3] * 2))
        assert caught.value.best is not None
        twice = 2 * parameter_vector(car)[:4]  # the masses are given
        np.testing.assert_allclose(parameter_vector(caught.value.best)[:4], twice, rtol=1e-9)

    def test_a_program_ends_where_an_alternative_is(self) -> None:
        """Alternatives have no program of their own; one that starts there stays there."""
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)
        exact, nominal = eigenmodes(car), changed(car, [0.7, 1.3] * 2)
        modes = ModalSet.from_wn_zeta(
            exact.wn * [1.0001, 0.9999], exact.zeta * [0.995, 1.01], wn_std=1e-4 * exact.wn, zeta_std=1e-2 * exact.zeta
        )
        alternatives = reconstruct(modes, nominal).alternatives
        assert alternatives
        for other in alternatives:
            again = reconstruct(modes, other, search=False).suspension
            # A descent ends where a step gains 1e-8 of chi-square: 1e-4 of standard deviations of 1 % and less.
            np.testing.assert_allclose(parameter_vector(again), parameter_vector(other), rtol=1e-6)

    def test_what_was_solved_before_does_not_matter(self) -> None:
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)
        one, other = eigenmodes(car), eigenmodes(changed(car, [1.2] * 4))

        def found(modes: ModalSet) -> bytes:
            answer = reconstruct(without_shapes(modes), changed(car, [0.7, 1.3] * 2))
            return b"".join(parameter_vector(s).tobytes() for s in (answer.suspension, *answer.alternatives))

        compiled.cache_clear()
        fresh = found(one)
        found(other)
        assert found(one) == fresh, "to the last bit: rows of a fleet do not depend on their order"

    def test_it_is_compiled_once(self) -> None:
        car = two_mass_car(chassis_damping=1500.0, tire_damping=30.0)
        reconstruct(eigenmodes(car), car)
        before = compiled.cache_info()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            answers = [reconstruct(eigenmodes(car), changed(car, [f] * 4)) for f in (0.7, 1.3)]
        assert compiled.cache_info().misses == before.misses
        assert compiled.cache_info().hits >= before.hits + 2, "and is solved each time"
        assert all(isinstance(a, Reconstruction) for a in answers)
