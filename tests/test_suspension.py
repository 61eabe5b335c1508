import copy
import dataclasses
import pickle
from collections.abc import Callable, Mapping
from typing import Any

import control
import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import InputError, Strut, Suspension, free_decay, quarter_car, statespace
from suspid.values import FrozenMapping, frozen_complex, frozen_real, nearest_names

# Sums of at most four products: a few units in the last place.
ROUNDING = 1e-14


def paper_car(seat: float = 300, chassis: float = 200, tire: float = 100) -> Suspension:
    return quarter_car(
        seat_mass=200,
        chassis_mass=210,
        tire_mass=220,
        seat_stiffness=200e3,
        chassis_stiffness=400e3,
        tire_stiffness=800e3,
        seat_damping=seat,
        chassis_damping=chassis,
        tire_damping=tire,
    )


def half_car() -> Suspension:
    """Bounce and pitch of a body on two wheels, each on a road of its own."""
    return Suspension(
        masses={"bounce": 500.0, "pitch": 800.0, "front": 40.0, "rear": 45.0},
        struts=[
            Strut(name="fs", stiffness=18e3, damping=1200.0, arms={"bounce": 1, "pitch": -1.2, "front": -1}),
            Strut(name="rs", stiffness=22e3, damping=1400.0, arms={"bounce": 1, "pitch": 1.5, "rear": -1}),
            Strut(name="ft", stiffness=180e3, damping=60.0, arms={"front": 1, "road_front": -1}),
            Strut(name="rt", stiffness=190e3, damping=70.0, arms={"rear": 1, "road_rear": -1}),
        ],
    )


def heavy_car() -> Suspension:
    return quarter_car(
        seat_mass=80,
        chassis_mass=400,
        tire_mass=40,
        seat_stiffness=16e3,
        chassis_stiffness=20e3,
        tire_stiffness=200e3,
        seat_damping=500,
        chassis_damping=1500,
        tire_damping=50,
    )


def second_derivatives(energy: Callable[[NDArray[np.float64]], float], size: int) -> NDArray[np.float64]:
    """Hessian of a quadratic form by its second differences, which are exact for it."""
    e = np.eye(size)
    return np.array([[energy(e[i] + e[j]) - energy(e[i]) - energy(e[j]) for j in range(size)] for i in range(size)])


def figure_2(car: Suspension) -> control.StateSpace:
    """Summing points, gains and integrators of Figure 2, wired by name."""
    blocks: list[Any] = []

    def gain(value: float, source: str, target: str) -> None:
        blocks.append(control.ss([], [], [], [[value]], inputs=[source], outputs=[target], name=f"gain_{target}"))

    def integrator(source: str, target: str) -> None:
        blocks.append(control.ss([[0]], [[1]], [[1]], [[0]], inputs=[source], outputs=[target], name=f"int_{target}"))

    def total(sources: list[str], target: str) -> None:
        blocks.append(control.summing_junction(inputs=sources, output=target, name=f"sum_{target}"))

    links = [("s", "c"), ("c", "t"), ("t", "r")]
    for strut, (upper, lower) in zip(car.struts, links, strict=True):
        total([f"z{upper}", f"-z{lower}"], f"e{upper}")
        total([f"v{upper}", f"-v{lower}"], f"d{upper}")
        gain(strut.stiffness, f"e{upper}", f"spring{upper}")
        gain(strut.damping, f"d{upper}", f"damper{upper}")
    forces = {
        "s": ["-springs", "-dampers"],
        "c": ["springs", "dampers", "-springc", "-damperc"],
        "t": ["springc", "damperc", "-springt", "-dampert"],
    }
    for mass, (body, terms) in zip(car.masses.values(), forces.items(), strict=True):
        total(terms, f"f{body}")
        gain(1 / mass, f"f{body}", f"a{body}")
        integrator(f"a{body}", f"v{body}")
        integrator(f"v{body}", f"z{body}")
    return control.interconnect(blocks, inputs=["zr", "vr"], outputs=["zs", "zc", "zt"])


class TestEquations6And7:
    def test_the_matrices_are_those_written_out_by_hand(self) -> None:
        ms, mc, mt, ks, kc, kt, cs, cc, ct = 200.0, 210.0, 220.0, 200e3, 400e3, 800e3, 300.0, 200.0, 100.0
        A: NDArray[np.float64] = np.array(
            [
                [0, 0, 0, 1, 0, 0],
                [0, 0, 0, 0, 1, 0],
                [0, 0, 0, 0, 0, 1],
                [-ks / ms, ks / ms, 0, -cs / ms, cs / ms, 0],
                [ks / mc, -(ks + kc) / mc, kc / mc, cs / mc, -(cs + cc) / mc, cc / mc],
                [0, kc / mt, -(kc + kt) / mt, 0, cc / mt, -(cc + ct) / mt],
            ]
        )
        B = np.array([[0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [kt / mt, ct / mt]])
        system = statespace(paper_car())
        np.testing.assert_allclose(system.A, A, rtol=ROUNDING, atol=0)
        np.testing.assert_allclose(system.B, B, rtol=ROUNDING, atol=0)
        np.testing.assert_array_equal(system.C, np.eye(3, 6))
        np.testing.assert_array_equal(system.D, np.zeros((3, 2)))

    def test_the_names_are_those_of_the_text(self) -> None:
        system = statespace(paper_car())
        assert system.state_labels == ["z_seat", "z_chassis", "z_tire", "v_seat", "v_chassis", "v_tire"]
        assert system.input_labels == ["road", "road_rate"]
        assert system.output_labels == ["seat", "chassis", "tire"]
        assert statespace(half_car()).input_labels == ["road_front", "road_rear", "road_front_rate", "road_rear_rate"]
        assert statespace(half_car(), road_rate=False).input_labels == ["road_front", "road_rear"]

    def test_two_masses_are_the_chain_without_its_seat(self) -> None:
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=2e4, tire_stiffness=2e5, chassis_damping=1500
        )
        np.testing.assert_array_equal(car.M, [[400, 0], [0, 40]])
        np.testing.assert_array_equal(car.K, [[2e4, -2e4], [-2e4, 2.2e5]])
        np.testing.assert_array_equal(car.C, [[1500, -1500], [-1500, 1500]])
        np.testing.assert_array_equal(car.K_road, [[0], [2e5]])
        np.testing.assert_array_equal(car.C_road, [[0], [0]])


class TestLagrange:
    """M, C, K and the road's forces are second derivatives of energies written by hand."""

    @staticmethod
    def spring_energy(rates: list[float]) -> Callable[[NDArray[np.float64]], float]:
        def energy(x: NDArray[np.float64]) -> float:
            z, theta, front, rear, road_front, road_rear = x
            stretch = [z - 1.2 * theta - front, z + 1.5 * theta - rear, front - road_front, rear - road_rear]
            return float(sum(0.5 * k * e * e for k, e in zip(rates, stretch, strict=True)))

        return energy

    def test_half_car(self) -> None:
        car = half_car()
        stiffness = second_derivatives(self.spring_energy([18e3, 22e3, 180e3, 190e3]), 6)
        damping = second_derivatives(self.spring_energy([1200.0, 1400.0, 60.0, 70.0]), 6)
        inertia = second_derivatives(
            lambda v: 0.5 * (500 * v[0] ** 2 + 800 * v[1] ** 2 + 40 * v[2] ** 2 + 45 * v[3] ** 2), 4
        )
        atol = 1e-9  # differences of energies near 1e5 N m lose ten units in their last place
        np.testing.assert_allclose(car.M, inertia, rtol=0, atol=atol)
        np.testing.assert_allclose(car.K, stiffness[:4, :4], rtol=0, atol=atol)
        np.testing.assert_allclose(car.C, damping[:4, :4], rtol=0, atol=atol)
        np.testing.assert_allclose(car.K_road, -stiffness[:4, 4:], rtol=0, atol=atol)
        np.testing.assert_allclose(car.C_road, -damping[:4, 4:], rtol=0, atol=atol)

    @pytest.mark.parametrize("car", [paper_car(), heavy_car()], ids=["paper", "heavy"])
    def test_a_car_lifted_with_its_road_feels_no_force(self, car: Suspension) -> None:
        largest = np.max(np.abs(car.K))
        np.testing.assert_allclose(car.K.sum(axis=1), car.K_road.sum(axis=1), rtol=0, atol=ROUNDING * largest)
        np.testing.assert_allclose(car.C.sum(axis=1), car.C_road.sum(axis=1), rtol=0, atol=ROUNDING * largest)

    def test_the_matrices_are_symmetric_and_dissipate(self) -> None:
        car = half_car()
        for matrix in (car.M, car.C, car.K):
            np.testing.assert_array_equal(matrix, matrix.T)
            assert np.min(np.linalg.eigvalsh(matrix)) >= 0


class TestTransferFunctions:
    # From far below the first mode to far above the last.
    OMEGA = np.geomspace(0.01, 1e4, 301)

    def paper_response(self, car: Suspension) -> NDArray[np.complex128]:
        """Responses to (road, road rate), the rate being j omega road: one column in all."""
        response = statespace(car)(1j * self.OMEGA, squeeze=False)
        roads = len(car.roads)
        return np.asarray(response[:, :roads] + 1j * self.OMEGA * response[:, roads:])

    @staticmethod
    def assert_same(found: NDArray[np.complex128], expected: NDArray[np.complex128]) -> None:
        largest = np.max(np.abs(expected), axis=(0, 1))
        assert np.max(np.abs(found - expected) / largest) < 1e-9

    @pytest.mark.parametrize("car", [paper_car(), heavy_car(), half_car()], ids=["paper", "heavy", "half"])
    def test_both_input_forms_are_one_system(self, car: Suspension) -> None:
        proper = statespace(car, road_rate=False)(1j * self.OMEGA, squeeze=False)
        self.assert_same(proper, self.paper_response(car))

    @pytest.mark.parametrize("car", [paper_car(), heavy_car()], ids=["paper", "heavy"])
    def test_figure_2_is_the_same_system(self, car: Suspension) -> None:
        expected = figure_2(car)(1j * self.OMEGA, squeeze=False)
        found = statespace(car)(1j * self.OMEGA, squeeze=False)
        for column in range(2):
            self.assert_same(found[:, [column]], expected[:, [column]])

    @pytest.mark.parametrize("car", [paper_car(), half_car()], ids=["paper", "half"])
    def test_dynamic_stiffness_inverted_at_each_frequency_agrees(self, car: Suspension) -> None:
        expected = np.stack(
            [
                np.linalg.solve(-(w**2) * car.M + 1j * w * car.C + car.K, car.K_road + 1j * w * car.C_road)
                for w in self.OMEGA
            ],
            axis=-1,
        )
        self.assert_same(self.paper_response(car), expected)

    def test_outputs_are_derivatives_and_elongations(self) -> None:
        s = 1j * self.OMEGA
        car = half_car()
        names = ["front", "front_velocity", "front_acceleration", "bounce", "pitch", "fs_travel", "ft_travel"]
        response = statespace(car, outputs=names)(s, squeeze=False)
        response = response[:, :2] + s * response[:, 2:]
        front, velocity, acceleration, bounce, pitch, travel, tire_travel = response
        road = np.array([[1.0], [0.0]])
        pairs = [
            (velocity, s * front),
            (acceleration, s**2 * front),
            (travel, bounce - 1.2 * pitch - front),
            (tire_travel, front - road),
        ]
        for found, expected in pairs:
            # At low frequency an elongation is the small difference of displacements of the road's size.
            assert np.max(np.abs(found - expected) / np.maximum(np.abs(expected), 1.0)) < 1e-9

    def test_the_proper_form_gives_the_same_velocity_acceleration_and_travel(self) -> None:
        s = 1j * self.OMEGA
        car = paper_car()
        names = ["tire_velocity", "seat_acceleration", "chassis_velocity", "tire_travel", "seat_travel"]
        proper = statespace(car, outputs=names, road_rate=False)(s, squeeze=False)
        full = statespace(car, outputs=names)(s, squeeze=False)
        full = full[:, :1] + s * full[:, 1:]
        assert np.max(np.abs(proper - full) / np.max(np.abs(full), axis=-1, keepdims=True)) < 1e-9


class TestOutputsInTime:
    def test_velocity_and_acceleration_are_slopes_of_displacement(self) -> None:
        step = 1e-4
        system = statespace(heavy_car(), outputs=["tire", "tire_velocity", "tire_acceleration"])
        z, v, a = free_decay(system, np.arange(0, 0.2, step), initial_state={"z_seat": 0.01, "v_tire": 1.0}).y
        # Central differences err by step^2 / 6 of the third derivative, here up to (600 rad/s)^2 of the peak.
        atol = step**2 / 6 * 600**2
        assert np.max(np.abs((z[2:] - z[:-2]) / (2 * step) - v[1:-1])) < atol * np.max(np.abs(v))
        assert np.max(np.abs((v[2:] - v[:-2]) / (2 * step) - a[1:-1])) < atol * np.max(np.abs(a))

    def test_travel_is_the_elongation(self) -> None:
        system = statespace(heavy_car(), outputs=["seat", "chassis", "seat_travel"])
        seat, chassis, travel = free_decay(system, [0, 0.1, 0.2], initial_state={"z_seat": 0.01, "v_tire": 1.0}).y
        np.testing.assert_allclose(travel, seat - chassis, rtol=0, atol=ROUNDING)


def strut(**changes: Any) -> Strut:
    return Strut(**{"name": "a", "stiffness": 1.0, "damping": 0.0, "arms": {"x": 1.0, "road": -1.0}, **changes})


def with_mass(mass: Any) -> Suspension:
    return Suspension(masses={"x": mass}, struts=[strut()])


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "negative mass": (lambda: with_mass(-3.0), r"mass 'x' = -3 kg must be positive"),
    "zero mass": (lambda: with_mass(0.0), r"mass 'x' = 0 kg must be positive"),
    "nan mass": (lambda: with_mass(float("nan")), r"mass 'x' = nan kg is not finite"),
    "boolean mass": (lambda: with_mass(True), r"mass 'x' = True is not a number; give it in kg"),
    "text as mass": (lambda: with_mass("80"), r"mass 'x' = '80' is not a number"),
    "no mass": (lambda: Suspension(masses={}, struts=[strut()]), r"at least one mass"),
    "list of masses": (lambda: Suspension(masses=[1.0], struts=[]), r"must map coordinates"),  # type: ignore[arg-type]
    "no strut type": (lambda: Suspension(masses={"x": 1.0}, struts=["a"]), r"must be a Strut"),  # type: ignore[list-item]
    "negative stiffness": (lambda: strut(stiffness=-2.0), r"strut 'a': stiffness = -2 N/m is negative"),
    "infinite stiffness": (lambda: strut(stiffness=float("inf")), r"strut 'a': stiffness = inf N/m is not finite"),
    "negative damping": (lambda: strut(damping=-2.0), r"strut 'a': damping = -2 N s/m is negative"),
    "boolean damping": (lambda: strut(damping=False), r"strut 'a': damping = False is not a number"),
    "numpy boolean": (lambda: strut(damping=np.True_), r"strut 'a': damping = .*True.* is not a number"),
    "nan arm": (lambda: strut(arms={"x": float("nan")}), r"strut 'a': arm 'x' = nan .* is not finite"),
    "zero arms": (lambda: strut(arms={"x": 0.0}), r"strut 'a' has no nonzero arm"),
    "no arms": (lambda: strut(arms={}), r"strut 'a' has no nonzero arm"),
    "list of arms": (lambda: strut(arms=["x"]), r"must map coordinates to arms"),
    "dot in a strut": (lambda: strut(name="a.b"), r"a strut is named 'a\.b'.*without '\.'"),
    "dot in an arm": (lambda: strut(arms={"x.y": 1.0}), r"a coordinate is named 'x\.y'"),
    "dot in a mass": (lambda: Suspension(masses={"x.y": 1.0}, struts=[strut()]), r"a mass is named 'x\.y'"),
    "empty name": (lambda: strut(name=""), r"a strut is named ''"),
    "duplicate struts": (
        lambda: Suspension(masses={"x": 1.0}, struts=[strut(), strut()]),
        r"strut name 'a' is used 2 times",
    ),
    "mass tied to nothing": (
        lambda: Suspension(masses={"x": 1.0, "lone": 7.0}, struts=[strut()]),
        r"mass 'lone' = 7 kg is not connected",
    ),
    "mass tied by an empty strut": (
        lambda: Suspension(masses={"x": 1.0}, struts=[strut(stiffness=0.0)]),
        r"mass 'x' = 1 kg is not connected",
    ),
    "misspelled coordinate": (
        lambda: Suspension(masses={"chassis": 1.0}, struts=[strut(arms={"chassis": 1.0, "chasis": -1.0})]),
        r"'chasis' is used in an arm but has no mass, and is close to 'chassis'",
    ),
    "other case": (
        lambda: Suspension(masses={"seat": 1.0}, struts=[strut(arms={"seat": 1.0, "Seat": -1.0})]),
        r"'Seat' .* close to 'seat'",
    ),
    "coordinate named as a velocity": (
        lambda: Suspension(masses={"x": 1.0, "x_velocity": 1.0}, struts=[strut(arms={"x": 1.0, "x_velocity": -1.0})]),
        r"'x_velocity' has the name of an input or output",
    ),
    "road named as a rate": (
        lambda: Suspension(masses={"x": 1.0}, struts=[strut(), strut(name="b", arms={"x": 1.0, "road_rate": -1.0})]),
        r"'road_rate' has the name of an input or output",
    ),
    "half a seat": (
        lambda: quarter_car(
            seat_mass=80,
            chassis_mass=1,
            tire_mass=1,
            chassis_stiffness=1,
            tire_stiffness=1,
            chassis_damping=1,
        ),
        r"a car with a seat also needs seat_stiffness, seat_damping",
    ),
    "unknown output": (
        lambda: statespace(paper_car(), outputs=["chasis_velocity"]),
        r"no output 'chasis_velocity'.*'chassis_velocity'",
    ),
    "far output": (lambda: statespace(paper_car(), outputs=["qqq"]), r"no output 'qqq'\. Known: 'seat', 'chassis'"),
    "output twice": (lambda: statespace(paper_car(), outputs=["seat", "seat"]), r"output 'seat' is given 2 times"),
    "one string": (lambda: statespace(paper_car(), outputs="seat"), r"is one string"),
    "acceleration through a road damper": (
        lambda: statespace(paper_car(), outputs=["tire_acceleration"], road_rate=False),
        r"'tire_acceleration' depends on the rate of a road input; use road_rate=True",
    ),
    "unknown strut": (
        lambda: paper_car().with_parameters(stiffness={"tyre": 1.0}),
        r"no strut 'tyre'\. Did you mean 'tire'",
    ),
    "unknown mass": (lambda: paper_car().with_parameters(masses={"seet": 1.0}), r"no mass 'seet'\. .*'seat'"),
    "refused copy": (lambda: paper_car().with_parameters(damping={"seat": -1.0}), r"damping = -1 N s/m is negative"),
}


class TestRefusals:
    @pytest.mark.parametrize(("make", "message"), REFUSED.values(), ids=REFUSED.keys())
    def test_refused_with_name_value_and_unit(self, make: Callable[[], object], message: str) -> None:
        with pytest.raises(InputError, match=message):
            make()

    def test_names_that_differ_only_in_digits_are_no_slip(self) -> None:
        car = Suspension(masses={"m1": 1.0}, struts=[strut(arms={"m1": 1.0, "m0": -1.0})])
        assert car.roads == ("m0",)


class TestValues:
    def test_equal_cars_are_equal_and_hash_alike(self) -> None:
        assert paper_car() == paper_car()
        assert hash(paper_car()) == hash(paper_car())
        assert paper_car() != paper_car(seat=301)
        assert len({paper_car(), paper_car(), heavy_car()}) == 2

    @pytest.mark.parametrize(
        "again", [lambda car: pickle.loads(pickle.dumps(car)), copy.deepcopy], ids=["pickle", "copy"]
    )
    def test_a_car_survives_the_way_to_another_process(self, again: Callable[[Suspension], Suspension]) -> None:
        car = half_car()
        found = again(car)
        assert found == car
        assert hash(found) == hash(car)
        np.testing.assert_array_equal(found.K, car.K)

    def test_nothing_can_be_assigned(self) -> None:
        car = paper_car()
        with pytest.raises(dataclasses.FrozenInstanceError):
            car.masses = {}  # type: ignore[misc]
        with pytest.raises(dataclasses.FrozenInstanceError):
            car.struts[0].stiffness = 1.0  # type: ignore[misc]
        with pytest.raises(TypeError):
            car.masses["seat"] = 1.0  # type: ignore[index]

    def test_a_car_keeps_no_hold_on_what_it_was_made_from(self) -> None:
        masses, arms = {"x": 1.0}, {"x": 1.0, "road": -1.0}
        struts = [strut(arms=arms)]
        car = Suspension(masses=masses, struts=struts)
        masses["x"] = arms["x"] = 5.0
        struts.clear()
        assert car == with_mass(1.0)
        car.K[:] = 0.0
        assert car.K[0, 0] == 1.0

    def test_with_parameters_changes_what_it_names_alone(self) -> None:
        car = paper_car()
        other = car.with_parameters(stiffness={"seat": 1.0}, damping={"tire": 2.0}, masses={"chassis": 3.0})
        assert car == paper_car()
        assert [s.stiffness for s in other.struts] == [1.0, 400e3, 800e3]
        assert [s.damping for s in other.struts] == [300.0, 200.0, 2.0]
        assert dict(other.masses) == {"seat": 200.0, "chassis": 3.0, "tire": 220.0}

    def test_whole_numbers_become_floats(self) -> None:
        car = Suspension(masses={"x": 2}, struts=[strut(stiffness=3, arms={"x": 1, "road": -1})])
        assert isinstance(car.masses["x"], float)
        assert isinstance(car.struts[0].stiffness, float)
        assert isinstance(car.struts[0].arms["x"], float)


class TestFrozenPieces:
    def test_mapping_order_counts_for_it_is_that_of_the_matrices(self) -> None:
        assert FrozenMapping({"a": 1.0, "b": 2.0}) == {"a": 1.0, "b": 2.0}
        assert FrozenMapping({"a": 1.0, "b": 2.0}) != FrozenMapping({"b": 2.0, "a": 1.0})
        assert isinstance(FrozenMapping({}), Mapping)
        assert FrozenMapping({"a": 1.0}) != 1.0

    def test_arrays_are_copies_that_refuse_writing(self) -> None:
        source = np.zeros(2)
        real, complex_ = frozen_real(source), frozen_complex(source)
        source[0] = 1.0
        assert real[0] == 0.0
        for array in (real, complex_):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 2.0

    def test_a_near_name_is_offered(self) -> None:
        assert nearest_names("chasis", ["seat", "chassis"]) == " Did you mean 'chassis'?"
        assert nearest_names("zzz", ["seat", "chassis"]) == " Known: 'seat', 'chassis'."
        assert nearest_names("zzz", []) == ""
