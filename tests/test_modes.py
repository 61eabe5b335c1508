import dataclasses
import pickle
from collections.abc import Callable
from typing import Any

import control
import mpmath
import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from suspid import InputError, ModalSet, Strut, Suspension, eigenmodes, quarter_car, statespace
from suspid.model import scaled_shapes

EXACT = 1e-9


def paper_car(seat: float = 300.0, chassis: float = 200.0, tire: float = 100.0) -> Suspension:
    return quarter_car(
        seat_mass=200,
        chassis_mass=200,
        tire_mass=200,
        seat_stiffness=200e3,
        chassis_stiffness=400e3,
        tire_stiffness=800e3,
        seat_damping=seat,
        chassis_damping=chassis,
        tire_damping=tire,
    )


def heavy_car(factor: float = 1.0) -> Suspension:
    return quarter_car(
        seat_mass=80,
        chassis_mass=400,
        tire_mass=40,
        seat_stiffness=16e3,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        seat_damping=500 * factor,
        chassis_damping=1500 * factor,
        tire_damping=50,
    )


def oscillator(*, mass: float, stiffness: float, damping: float) -> Suspension:
    strut = Strut(name="strut", stiffness=stiffness, damping=damping, arms={"mass": 1.0, "road": -1.0})
    return Suspension(masses={"mass": mass}, struts=[strut])


def characteristic_roots(car: Suspension) -> NDArray[np.complex128]:
    """Roots in the upper half plane of det(s^2 M + s C + K), expanded and solved with 60 digits."""

    def times(a: list[Any], b: list[Any]) -> list[Any]:
        product = [mpmath.mpf(0)] * (len(a) + len(b) - 1)
        for i, x in enumerate(a):
            for j, y in enumerate(b):
                product[i + j] += x * y
        return product

    def determinant(rows: list[list[list[Any]]]) -> list[Any]:
        """Laplace expansion of a matrix of polynomials, highest power first, all of one degree."""
        if len(rows) == 1:
            return rows[0][0]
        total: list[Any] = []
        for column, entry in enumerate(rows[0]):
            minor = [[*row[:column], *row[column + 1 :]] for row in rows[1:]]
            term = [(-1) ** column * x for x in times(entry, determinant(minor))]
            total = [x + y for x, y in zip(total, term, strict=True)] if total else term
        return total

    with mpmath.workdps(60):
        n = len(car.coordinates)
        entry = [
            [[mpmath.mpf(float(matrix[i, j])) for matrix in (car.M, car.C, car.K)] for j in range(n)] for i in range(n)
        ]
        lead, *rest = determinant(entry)
        companion = mpmath.zeros(2 * n)
        for k, coefficient in enumerate(rest):
            companion[0, k] = -coefficient / lead
            if k:
                companion[k, k - 1] = 1
        roots = mpmath.eig(companion, left=False, right=False)
        # A real root comes with an imaginary part of the last digits.
        found = [complex(r) if abs(r.imag) > abs(r) * mpmath.mpf(10) ** -40 else complex(r.real) for r in roots]
    return np.array(sorted((r for r in found if r.imag >= 0), key=abs))


def generalized_companion(car: Suspension) -> NDArray[np.complex128]:
    """The quadratic eigenproblem as A x = lambda B x, without inverting the mass matrix."""
    n = len(car.coordinates)
    zero, eye = np.zeros((n, n)), np.eye(n)
    A = np.block([[zero, eye], [-car.K, -car.C]])
    B = np.block([[eye, zero], [zero, car.M]])
    poles = np.asarray(scipy.linalg.eigvals(A, B), complex)
    return np.array(sorted(poles[poles.imag >= 0], key=abs))


CARS = {
    "Table 1 as printed": paper_car(30, 20, 10),
    "Table 1, ten times the damping": paper_car(),
    "undamped": paper_car(0, 0, 0),
    "heavily damped": heavy_car(),
    "overdamped": heavy_car(8.0),
    "very overdamped": heavy_car(50.0),
}


class TestQuadraticEigenproblem:
    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_the_poles_are_roots_of_the_characteristic_polynomial(self, car: Suspension) -> None:
        expected = characteristic_roots(car)
        found = eigenmodes(car)
        assert len(found) == len(expected)
        assert np.max(np.abs(found.poles - expected) / np.abs(expected)) < EXACT
        np.testing.assert_allclose(found.wn, np.abs(expected), rtol=EXACT, atol=0)
        # A damping ratio is known to the rounding of its pole, not of itself.
        np.testing.assert_allclose(found.zeta, -expected.real / np.abs(expected), rtol=EXACT, atol=1e-15)

    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_the_generalized_companion_agrees(self, car: Suspension) -> None:
        expected = generalized_companion(car)
        assert np.max(np.abs(eigenmodes(car).poles - expected) / np.abs(expected)) < EXACT

    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_poles_and_shapes_leave_no_residual_force(self, car: Suspension) -> None:
        modes = eigenmodes(car)
        assert modes.shapes is not None
        for pole, shape in zip(modes.poles, modes.shapes.T, strict=True):
            terms = np.stack([pole**2 * car.M @ shape, pole * car.C @ shape, car.K @ shape])
            assert np.max(np.abs(terms.sum(axis=0))) < EXACT * np.max(np.abs(terms))
            assert np.max(np.abs(shape)) == pytest.approx(1.0, rel=1e-15)

    @pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())
    def test_poles_sum_to_the_trace_and_multiply_to_the_determinant(self, car: Suspension) -> None:
        modes = eigenmodes(car)
        pairs = np.array([kind == "pair" for kind in modes.kinds])
        total = np.sum(np.where(pairs, 2 * modes.poles.real, modes.poles.real))
        trace = -np.sum(np.diag(car.C) / np.diag(car.M))
        np.testing.assert_allclose(total, trace, rtol=EXACT, atol=1e-11 * np.sum(modes.wn))
        product = np.prod(np.where(pairs, modes.wn**2, modes.wn))
        np.testing.assert_allclose(product, np.linalg.det(car.K) / np.linalg.det(car.M), rtol=EXACT, atol=0)

    def test_the_kinds_are_those_of_the_roots(self) -> None:
        assert eigenmodes(heavy_car()).kinds == ("pair",) * 3
        expected = characteristic_roots(heavy_car(8.0))
        kinds = eigenmodes(heavy_car(8.0)).kinds
        assert kinds == tuple("pair" if root.imag else "real" for root in expected)
        assert "real" in kinds
        assert "one real pole" in str(eigenmodes(heavy_car(8.0)))

    def test_heavy_means_heavy(self) -> None:
        zeta = eigenmodes(heavy_car()).zeta
        assert np.min(zeta) > 0.1
        assert np.max(zeta) < 0.5


class TestPrintedFigures:
    """The exact eigenvalues of Table 1, as published with both readings of its damping."""

    def test_damping_as_printed(self) -> None:
        modes = eigenmodes(paper_car(30, 20, 10))
        np.testing.assert_allclose(modes.wn, [21.2719, 50.1345, 83.8691], rtol=0, atol=0.5e-4)
        np.testing.assert_allclose(100 * modes.zeta, [0.0789, 0.2532, 0.1565], rtol=0, atol=0.5e-4)

    def test_ten_times_the_damping(self) -> None:
        modes = eigenmodes(paper_car())
        np.testing.assert_allclose(modes.wn, [21.2737, 50.1386, 83.8549], rtol=0, atol=0.5e-4)
        np.testing.assert_allclose(100 * modes.zeta, [0.7886, 2.5331, 1.5648], rtol=0, atol=0.5e-4)

    def test_the_trapezoidal_rule_at_two_milliseconds_moves_them(self) -> None:
        # Tustin's map sends a pole s to z = (1 + s h / 2) / (1 - s h / 2).
        sampled = control.sample_system(statespace(paper_car()), 0.002, method="bilinear")
        modes = eigenmodes(sampled)
        np.testing.assert_allclose(modes.wn, [21.271, 50.097, 83.659], rtol=0, atol=0.5e-3)
        np.testing.assert_allclose(100 * modes.zeta, [0.7883, 2.5289, 1.5575], rtol=0, atol=0.5e-4)

    def test_a_second_chain_shares_the_spectrum(self) -> None:
        twin_k = [240.4e3, 485.2e3, 548.6e3]
        M = np.diag([200.0] * 3)

        def chain(a: float, b: float, c: float) -> NDArray[np.float64]:
            return np.array([[a, -a, 0], [-a, a + b, -b], [0, -b, b + c]])

        wn = np.sqrt(scipy.linalg.eigvalsh(chain(*twin_k), M))
        # Rates printed to 0.1 kN/m.
        np.testing.assert_allclose(wn, eigenmodes(paper_car(0, 0, 0)).wn, rtol=3e-4, atol=0)


class TestOneMass:
    @pytest.mark.parametrize("zeta", [0.0, 1e-3, 0.2, 0.99])
    def test_an_oscillator_has_its_textbook_pole(self, zeta: float) -> None:
        modes = eigenmodes(oscillator(mass=3.0, stiffness=3.0 * 49, damping=2 * 3 * 7 * zeta))
        np.testing.assert_allclose(modes.poles, [7 * (-zeta + 1j * np.sqrt(1 - zeta**2))], rtol=1e-12, atol=0)
        assert modes.kinds == ("pair",)

    def test_overdamped_poles_are_both_there(self) -> None:
        modes = eigenmodes(oscillator(mass=1.0, stiffness=100.0, damping=29.0))
        np.testing.assert_allclose(modes.poles, [-4.0, -25.0], rtol=1e-13, atol=0)
        assert modes.kinds == ("real", "real")
        np.testing.assert_array_equal(modes.zeta, [1.0, 1.0])

    def test_critical_damping_is_found_to_the_square_root_of_rounding(self) -> None:
        modes = eigenmodes(oscillator(mass=1.0, stiffness=100.0, damping=20.0))
        # A double root: rounding e moves it by its square root.
        assert np.max(np.abs(modes.poles + 10.0)) < 10 * 1e-7
        assert np.all(np.isfinite(modes.zeta))

    @pytest.mark.parametrize("ratio", [1e-6, 1e-9])
    def test_a_slow_pole_is_not_taken_for_a_rigid_body(self, ratio: float) -> None:
        # s^2 + s + ratio: the slow root is -ratio (1 + ratio + …).
        modes = eigenmodes(oscillator(mass=1.0, stiffness=ratio, damping=1.0))
        assert modes.kinds == ("real", "real")
        # Rounding of the fast pole, over the slow one.
        np.testing.assert_allclose(modes.wn[0], ratio * (1 + ratio), rtol=4e-16 / ratio, atol=0)


class TestRigidBodies:
    def free_pair(self, damping: float = 10.0) -> Suspension:
        strut = Strut(name="link", stiffness=1e4, damping=damping, arms={"a": 1.0, "b": -1.0})
        return Suspension(masses={"a": 1.0, "b": 2.0}, struts=[strut])

    def test_a_free_pair_has_two_poles_at_zero(self) -> None:
        modes = eigenmodes(self.free_pair())
        assert modes.kinds == ("rigid", "rigid", "pair")
        np.testing.assert_array_equal(modes.poles[:2], [0, 0])
        np.testing.assert_array_equal(modes.zeta[:2], [0, 0])
        wn = np.sqrt(1e4 * (1 / 1.0 + 1 / 2.0))
        np.testing.assert_allclose(modes.wn[2], wn, rtol=1e-12, atol=0)
        assert modes.shapes is not None
        np.testing.assert_allclose(modes.shapes[:, :2], np.ones((2, 2)), rtol=0, atol=1e-6)
        assert str(modes).count("pole at zero") == 2

    def test_a_damper_to_the_road_leaves_one(self) -> None:
        modes = eigenmodes(oscillator(mass=2.0, stiffness=0.0, damping=6.0))
        assert modes.kinds == ("rigid", "real")
        np.testing.assert_allclose(modes.poles, [0.0, -3.0], rtol=1e-14, atol=0)

    def test_what_follows_from_the_kind_of_a_pole_has_no_deviation_in_the_table(self) -> None:
        modes = ModalSet(poles=np.array([0.0, -3 + 4j, -16.0]), covariance=1e-2 * np.eye(6))
        cells = [line.split() for line in str(modes).split("\n")[2:]]
        assert [(row[3], row[4], row[5]) for row in cells] == [
            ("–", "0", "–"),
            ("0.10", "0.600", "0.016"),
            ("0.10", "1", "–"),
        ]

    def test_sampled_integrators_are_rigid_too(self) -> None:
        sampled = control.sample_system(control.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0), 0.01)
        assert eigenmodes(sampled).kinds == ("rigid", "rigid")


class TestStateSpaces:
    @pytest.mark.parametrize("car", [paper_car(), heavy_car(), heavy_car(8.0)], ids=["paper", "heavy", "overdamped"])
    @pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2])
    def test_sampling_keeps_the_modes(self, car: Suspension, step: float) -> None:
        system = statespace(car)
        expected, found = eigenmodes(car), eigenmodes(control.sample_system(system, step))
        # log(z) / h takes the rounding of z near 1 through the division by h, and that of a small z by 1 / z.
        slack = 1e-14 / (step * np.exp(expected.poles.real * step))
        assert np.all(np.abs(found.poles - expected.poles) < EXACT * expected.wn + slack)
        assert found.kinds == expected.kinds

    def test_the_frequencies_are_those_of_control_damp(self) -> None:
        system = statespace(heavy_car(8.0))
        wn, zeta, poles = control.damp(system, doprint=False)
        keep = poles.imag >= 0
        order = np.argsort(wn[keep])
        modes = eigenmodes(system)
        np.testing.assert_allclose(modes.wn, wn[keep][order], rtol=1e-11, atol=0)
        np.testing.assert_allclose(modes.zeta, zeta[keep][order], rtol=1e-11, atol=0)

    def test_other_coordinates_of_the_state_change_nothing(self) -> None:
        system = statespace(heavy_car())
        T = np.random.default_rng(5).standard_normal((6, 6))
        turned = control.ss(T @ system.A @ np.linalg.inv(T), T @ system.B, system.C @ np.linalg.inv(T), system.D)
        expected, found = eigenmodes(system), eigenmodes(turned)
        np.testing.assert_allclose(found.poles, expected.poles, rtol=1e-10, atol=0)
        assert expected.shapes is not None
        assert found.shapes is not None
        np.testing.assert_allclose(found.shapes, expected.shapes, rtol=0, atol=1e-9)

    def test_velocities_have_the_shapes_of_displacements(self) -> None:
        car = heavy_car()
        names = [f"{name}_velocity" for name in car.coordinates]
        found, expected = eigenmodes(statespace(car, outputs=names)), eigenmodes(car)
        assert found.channels == tuple(names)
        assert found.shapes is not None
        assert expected.shapes is not None
        np.testing.assert_allclose(found.shapes, expected.shapes, rtol=0, atol=1e-12)

    def test_an_unseen_mode_has_no_shape(self) -> None:
        # Twin masses on twin struts: their sum moves in phase alone, their difference out of phase alone.
        struts = [
            Strut(name="left", stiffness=1.0, damping=0.1, arms={"a": 1.0, "road": -1.0}),
            Strut(name="right", stiffness=1.0, damping=0.1, arms={"b": 1.0, "road": -1.0}),
            Strut(name="link", stiffness=3.3, damping=0.2, arms={"a": 1.0, "b": -1.0}),
        ]
        system = statespace(Suspension(masses={"a": 1.0, "b": 1.0}, struts=struts))
        C = np.array([[0.3, 0.3, 0, 0]])
        seen = control.ss(system.A, system.B, C, np.zeros((1, 2)))
        modes = eigenmodes(seen)
        np.testing.assert_array_equal(modes.shapes, [[1.0, 0.0]])
        assert len(modes) == 2

    def test_a_system_without_states_has_no_modes(self) -> None:
        modes = eigenmodes(control.ss([], [], [], [[1.0]]))
        assert len(modes) == 0
        assert modes.kinds == ()
        assert "wn [rad/s]" in str(modes)

    def test_an_unstable_pole_has_negative_damping(self) -> None:
        modes = eigenmodes(control.ss([[0.3, 4.0], [-4.0, 0.3]], [[0], [1]], [[1, 0]], 0))
        np.testing.assert_allclose(modes.zeta, -0.3 / np.hypot(0.3, 4.0), rtol=1e-14, atol=0)

    @pytest.mark.parametrize(
        ("system", "message"),
        [
            (control.ss([[0.5]], [[1]], [[1]], 0, dt=True), "give dt in seconds"),
            (control.ss([[0.0]], [[1]], [[1]], 0, dt=0.1), "pure delays"),
        ],
    )
    def test_refused(self, system: control.StateSpace, message: str) -> None:
        with pytest.raises(InputError, match=message):
            eigenmodes(system)


class TestFromWnZeta:
    WN, ZETA = np.array([21.0, 50.0, 84.0]), np.array([0.3, -0.01, 0.0])

    def test_round_trip(self) -> None:
        modes = ModalSet.from_wn_zeta(self.WN, self.ZETA)
        np.testing.assert_allclose(modes.wn, self.WN, rtol=1e-15, atol=0)
        np.testing.assert_allclose(modes.zeta, self.ZETA, rtol=1e-14, atol=1e-16)
        assert modes.wn_std is None
        assert modes.zeta_std is None
        assert modes.wn_zeta_covariance is None

    def test_round_trip_of_the_standard_deviations(self) -> None:
        wn_std, zeta_std = np.array([0.1, 0.2, 0.3]), np.array([1e-3, 2e-3, 3e-3])
        modes = ModalSet.from_wn_zeta(self.WN, self.ZETA, wn_std=wn_std, zeta_std=zeta_std)
        assert modes.wn_std is not None
        assert modes.zeta_std is not None
        np.testing.assert_allclose(modes.wn_std, wn_std, rtol=1e-12, atol=0)
        np.testing.assert_allclose(modes.zeta_std, zeta_std, rtol=1e-12, atol=0)
        covariance = modes.wn_zeta_covariance
        assert covariance is not None
        scale = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose(covariance / np.outer(scale, scale), np.eye(6), rtol=0, atol=1e-12)

    def test_falling_order_is_turned_with_everything(self) -> None:
        up = ModalSet.from_wn_zeta([3.0, 7.0], [0.1, 0.2], wn_std=[0.3, 0.7], zeta_std=[0.01, 0.02], shapes=np.eye(2))
        down = ModalSet.from_wn_zeta(
            [7.0, 3.0], [0.2, 0.1], wn_std=[0.7, 0.3], zeta_std=[0.02, 0.01], shapes=np.eye(2)[:, ::-1]
        )
        np.testing.assert_array_equal(down.poles, up.poles)
        np.testing.assert_array_equal(down.shapes, up.shapes)
        np.testing.assert_array_equal(down.covariance, up.covariance)


class TestCovariance:
    def test_the_map_to_wn_and_zeta_against_random_poles(self) -> None:
        rng = np.random.default_rng(11)
        poles = np.array([-2.0 + 20.0j, -15.0 + 40.0j])
        root = 1e-3 * rng.standard_normal((4, 4))
        covariance = root @ root.T
        drawn = rng.multivariate_normal(np.zeros(4), covariance, size=400_000)
        scattered = poles + drawn[:, 0::2] + 1j * drawn[:, 1::2]
        wn = np.abs(scattered)
        sample = np.cov(
            np.stack([wn[:, 0], -scattered[:, 0].real / wn[:, 0], wn[:, 1], -scattered[:, 1].real / wn[:, 1]])
        )
        found = ModalSet(poles=poles, covariance=covariance).wn_zeta_covariance
        assert found is not None
        scale = np.sqrt(np.diag(found))
        # A sample covariance scatters by sqrt(2 / n) of the variances: five of these.
        np.testing.assert_allclose(
            sample / np.outer(scale, scale), found / np.outer(scale, scale), rtol=0, atol=5 * np.sqrt(2 / 400_000)
        )

    def test_sorting_moves_the_covariance_of_poles_and_shapes(self) -> None:
        # Variances that tell their owner: pole m at 10 m + part, shape component (m, c) at 100 m + 10 c + part.
        poles = np.array([-1 + 30j, -1 + 10j, -1 + 20j])
        channels = 2
        owner = [10.0 * m + part for m in range(3) for part in (1, 2)]
        owner += [100.0 * (m + 1) + 10 * c + part for m in range(3) for c in range(channels) for part in (1, 2)]
        root = np.random.default_rng(2).standard_normal((18, 18))
        correlated = root @ root.T + np.diag(np.square(owner))
        shapes = np.arange(6.0).reshape(2, 3).astype(complex)
        modes = ModalSet(poles=poles, shapes=shapes, channels=("a", "b"), covariance=correlated)
        np.testing.assert_array_equal(modes.poles, poles[[1, 2, 0]])
        np.testing.assert_array_equal(modes.shapes, shapes[:, [1, 2, 0]])
        index = [2, 3, 4, 5, 0, 1, *range(10, 14), *range(14, 18), *range(6, 10)]
        np.testing.assert_array_equal(modes.covariance, correlated[np.ix_(index, index)])
        # The leading part alone, the poles, is ordered alike.
        leading = ModalSet(poles=poles, shapes=shapes, channels=("a", "b"), covariance=correlated[:6, :6])
        np.testing.assert_array_equal(leading.covariance, correlated[np.ix_(index[:6], index[:6])])
        np.testing.assert_array_equal(leading.wn_std, modes.wn_std)

    @pytest.mark.parametrize("level", [0.5, 0.68, 0.95, 0.99])
    def test_the_interval_covers_at_its_level(self, level: float) -> None:
        n, per_set = 4000, 100
        rng = np.random.default_rng(8)
        covered = np.zeros(2)
        for _ in range(n // per_set):
            wn, zeta = rng.normal(10.0, 0.1, per_set), rng.normal(0.3, 0.01, per_set)
            stds = np.full((2, per_set), [[0.1], [0.01]])
            interval = ModalSet.from_wn_zeta(wn, zeta, wn_std=stds[0], zeta_std=stds[1]).interval(level)
            for i, (bounds, true) in enumerate(((interval.wn, 10.0), (interval.zeta, 0.3))):
                covered[i] += np.sum((bounds[:, 0] <= true) & (true <= bounds[:, 1]))
        # Binomial scatter of the share covered: five of its standard deviations.
        np.testing.assert_allclose(covered / n, [level, level], rtol=0, atol=5 * np.sqrt(level * (1 - level) / n))

    def test_a_real_pole_is_uncertain_in_frequency_alone(self) -> None:
        modes = ModalSet(poles=np.array([-4.0 + 0j]), covariance=np.diag([0.04, 0.0]))
        assert modes.wn_std is not None
        np.testing.assert_allclose(modes.wn_std, np.array([0.2]), rtol=1e-15, atol=0)
        np.testing.assert_array_equal(modes.zeta_std, [0.0])
        assert "0.20" in str(modes)

    def test_a_rigid_pole_divides_by_nothing(self) -> None:
        modes = ModalSet(poles=np.array([0j]), covariance=np.eye(2))
        np.testing.assert_array_equal(modes.wn_std, [0.0])
        assert "pole at zero" in str(modes)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "nan pole": (lambda: ModalSet(poles=np.array([np.nan + 0j])), "finite vector"),
    "matrix of poles": (lambda: ModalSet(poles=np.ones((2, 2), complex)), r"shape \(2, 2\)"),
    "lower half plane": (lambda: ModalSet(poles=np.array([-1 - 2j])), "-1-2j rad/s lies in the lower half plane"),
    "shapes of other modes": (
        lambda: ModalSet(poles=np.array([1j]), shapes=np.ones((3, 2), complex)),
        r"got \(3, 2\) for 0 channels and 1 modes",
    ),
    "nan shape": (lambda: ModalSet(poles=np.array([1j]), shapes=np.array([[np.nan]])), "1 of 1 components"),
    "too few channels": (
        lambda: ModalSet(poles=np.array([1j]), shapes=np.ones((3, 1), complex), channels=("a",)),
        "1 channels",
    ),
    "small covariance": (lambda: ModalSet(poles=np.array([1j]), covariance=np.eye(1)), r"shape \(1, 1\); .* \[2"),
    "nan covariance": (lambda: ModalSet(poles=np.array([1j]), covariance=np.full((2, 2), np.nan)), "must be finite"),
    "negative variance": (lambda: ModalSet(poles=np.array([1j]), covariance=-np.eye(2)), "variances >= 0"),
    "percent": (lambda: ModalSet.from_wn_zeta([10.0], [1.55]), "not percent"),
    "zero wn": (lambda: ModalSet.from_wn_zeta([0.0], [0.1]), "must be positive"),
    "lengths": (lambda: ModalSet.from_wn_zeta([1.0, 2.0], [0.1]), r"\(2,\) and \(1,\)"),
    "one std": (lambda: ModalSet.from_wn_zeta([1.0], [0.1], wn_std=[0.1]), "both wn_std and zeta_std"),
    "negative std": (lambda: ModalSet.from_wn_zeta([1.0], [0.1], wn_std=[-0.1], zeta_std=[0.1]), ">= 0"),
    "interval of exact modes": (lambda: ModalSet(poles=np.array([1j])).interval(), "carry no uncertainty"),
    "level in percent": (
        lambda: ModalSet.from_wn_zeta([1.0], [0.1], wn_std=[0.1], zeta_std=[0.1]).interval(95),
        "level=95 must lie between 0 and 1",
    ),
}


class TestValues:
    @pytest.mark.parametrize(("make", "message"), REFUSED.values(), ids=REFUSED.keys())
    def test_refused(self, make: Callable[[], object], message: str) -> None:
        with pytest.raises(InputError, match=message):
            make()

    def test_arrays_refuse_writing_and_hold_no_callers_array(self) -> None:
        poles = np.array([-1 + 2j])
        modes = ModalSet(poles=poles, shapes=np.ones((1, 1), complex), covariance=np.eye(2))
        poles[0] = 5j
        assert modes.poles[0] == -1 + 2j
        for array in (modes.poles, modes.shapes, modes.covariance):
            assert array is not None
            assert not array.flags.writeable
        with pytest.raises(dataclasses.FrozenInstanceError):
            modes.poles = poles  # type: ignore[misc]

    def test_modes_survive_pickling(self) -> None:
        modes = eigenmodes(paper_car())
        again = pickle.loads(pickle.dumps(modes))
        np.testing.assert_array_equal(again.poles, modes.poles)
        np.testing.assert_array_equal(again.shapes, modes.shapes)
        assert again.channels == modes.channels

    def test_channels_without_names_are_numbered(self) -> None:
        modes = ModalSet(poles=np.array([1j]), shapes=np.ones((2, 1), complex))
        assert modes.channels == ("channel 1", "channel 2")

    def test_scaling_a_shape_changes_only_its_factor(self) -> None:
        shapes = np.array([[1 + 2j, 0.5], [3 - 1j, -2.0]])
        scaled = scaled_shapes(shapes)
        np.testing.assert_allclose(scaled[1], [1.0, 1.0], rtol=1e-15, atol=0)
        np.testing.assert_allclose(scaled[0], shapes[0] / shapes[1], rtol=1e-15, atol=0)
        np.testing.assert_allclose(scaled_shapes((2 - 3j) * shapes), scaled, rtol=1e-15, atol=1e-16)
        assert scaled_shapes(np.zeros((0, 2), complex)).shape == (0, 2)

    def test_the_table_shows_units_and_every_mode(self) -> None:
        table = str(eigenmodes(paper_car())).splitlines()
        assert all(unit in table[0] for unit in ("[Hz]", "[rad/s]", "[1]"))
        assert len(table) == 2 + 3
