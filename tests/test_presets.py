"""Quarter, half and full cars against mechanics: energies of a rigid body, limits, symmetry, known frequencies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from suspid import InputError, Suspension, eigenmodes, free_decay, full_car, half_car, quarter_car, statespace

RealArray = NDArray[np.float64]
ROUNDING = 1e-14  # sums of a few products

HALF: Mapping[str, float] = {
    "chassis_mass": 1150.0,
    "pitch_inertia": 1800.0,
    "front_tire_mass": 82.0,
    "rear_tire_mass": 91.0,
    "cg_to_front": 1.1,
    "cg_to_rear": 1.45,
    "front_stiffness": 41e3,
    "rear_stiffness": 37e3,
    "front_tire_stiffness": 390e3,
    "rear_tire_stiffness": 380e3,
    "front_damping": 2900.0,
    "rear_damping": 2700.0,
    "front_tire_damping": 110.0,
    "rear_tire_damping": 90.0,
}
HALF_SEAT = {"seat_mass": 78.0, "seat_stiffness": 15e3, "seat_damping": 480.0, "seat_ahead": -0.3}
FULL: Mapping[str, Any] = {
    **HALF,
    "roll_inertia": 520.0,
    "front_tire_mass": (41.0, 42.0),
    "rear_tire_mass": (45.0, 44.0),
    "front_track": 1.52,
    "rear_track": 1.47,
    "front_stiffness": (20e3, 21e3),
    "rear_stiffness": (18e3, 19.5e3),
    "front_tire_stiffness": (195e3, 190e3),
    "rear_tire_stiffness": (188e3, 192e3),
    "front_damping": (1400.0, 1500.0),
    "rear_damping": (1300.0, 1350.0),
    "front_tire_damping": (60.0, 50.0),
    "rear_tire_damping": (45.0, 40.0),
    "front_antiroll_stiffness": 9e3,
    "rear_antiroll_stiffness": 5e3,
}
FULL_SEAT = {**HALF_SEAT, "seat_left": 0.36}
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
CARS: dict[str, Suspension] = {
    "half": half_car(**HALF),
    "half with seat": half_car(**HALF, **HALF_SEAT),
    "full": full_car(**FULL),
    "full with seat": full_car(**FULL, **FULL_SEAT),
}
EVERY_CAR = pytest.mark.parametrize("car", CARS.values(), ids=CARS.keys())


def symmetric_full(**changes: Any) -> Suspension:
    """Return the full car whose sides are alike: the left ones."""
    sides = {name: value[0] if isinstance(value, tuple) else value for name, value in FULL.items()}
    return full_car(**{**sides, **changes})


def block(matrix: RealArray, car: Suspension, rows: tuple[str, ...], columns: tuple[str, ...]) -> RealArray:
    index = car.coordinates.index
    return matrix[np.ix_([index(c) for c in rows], [index(c) for c in columns])]


def embedding(car: Suspension, images: Mapping[str, Mapping[str, float]]) -> RealArray:
    """Return the matrix from a small car's coordinates to a large one's, (large, small)."""
    matrix = np.zeros((len(car.coordinates), len(images)))
    for column, image in enumerate(images.values()):
        for name, value in image.items():
            matrix[car.coordinates.index(name), column] = value
    return matrix


def pinched(names: tuple[str, ...]) -> dict[str, float]:
    return dict.fromkeys(names, 1.0)


class TestLagrange:
    """M, C and K are the Hessians, at rest, of the energies of a rigid body that truly rotates in space.

    Nothing is linearised by hand: attachment points are turned by rotation matrices about +y (pitch) and +x (roll) of
    axes x forward, y left, z up, and springs stand between their heights and those of wheels and roads.
    """

    STEP = mpmath.mpf(10) ** -12

    @staticmethod
    def position(q: Mapping[str, Any], point: tuple[float, float]) -> tuple[Any, Any, Any]:
        """Position of a point of the body at (x, y) on a vertical through the centre of gravity."""
        x, y = (mpmath.mpf(p) for p in point)
        theta, phi = q["pitch"], q.get("roll", mpmath.mpf(0))
        y, z = y * mpmath.cos(phi), y * mpmath.sin(phi)  # about +x
        x, z = x * mpmath.cos(theta) + z * mpmath.sin(theta), -x * mpmath.sin(theta) + z * mpmath.cos(theta)  # about +y
        return x, y, z + q["heave"]

    def height(self, q: Mapping[str, Any], x: float, y: float) -> Any:
        return self.position(q, (x, y))[2]

    def strut_energy(self, q: Mapping[str, Any], given: Mapping[str, Any], what: str) -> Any:
        """Half the sum of rate times elongation squared, with rates that end in ``what``."""
        total = mpmath.mpf(0)
        if "seat" in q:
            under = self.height(q, given["seat_ahead"], given.get("seat_left", 0.0))
            total += given[f"seat_{what}"] * (q["seat"] - under) ** 2
        for axle, x in (("front", given["cg_to_front"]), ("rear", -given["cg_to_rear"])):
            if "roll" not in q:
                total += given[f"{axle}_{what}"] * (self.height(q, x, 0.0) - q[axle]) ** 2
                total += given[f"{axle}_tire_{what}"] * (q[axle] - q[f"road_{axle}"]) ** 2
                continue
            travels = []
            for number, (side, sign) in enumerate((("left", 0.5), ("right", -0.5))):
                wheel = f"{axle}_{side}"
                travels.append(self.height(q, x, sign * given[f"{axle}_track"]) - q[wheel])
                total += given[f"{axle}_{what}"][number] * travels[-1] ** 2
                total += given[f"{axle}_tire_{what}"][number] * (q[wheel] - q[f"road_{wheel}"]) ** 2
            if what == "stiffness":
                total += given[f"{axle}_antiroll_stiffness"] * (travels[0] - travels[1]) ** 2
        return total / 2

    def kinetic_energy(self, rate: Mapping[str, Any], given: Mapping[str, Any]) -> Any:
        """Energy at rest position: a body of four point masses with the right mass and moments, and the wheels."""
        rolls = "roll" in rate
        a = float(np.sqrt(2 * given["pitch_inertia"] / given["chassis_mass"]))
        b = float(np.sqrt(2 * given["roll_inertia"] / given["chassis_mass"])) if rolls else 0.0
        total = mpmath.mpf(0)
        for point in ((a, 0.0), (-a, 0.0), (0.0, b), (0.0, -b)):
            ahead = self.position({name: self.STEP * v for name, v in rate.items()}, point)
            behind = self.position({name: -self.STEP * v for name, v in rate.items()}, point)
            velocity = [(f - g) / (2 * self.STEP) for f, g in zip(ahead, behind, strict=True)]
            total += given["chassis_mass"] / 4 * sum(v**2 for v in velocity)
        if "seat" in rate:
            total += given["seat_mass"] * rate["seat"] ** 2
        for axle in ("front", "rear"):
            if rolls:
                for number, side in enumerate(("left", "right")):
                    total += given[f"{axle}_tire_mass"][number] * rate[f"{axle}_{side}"] ** 2
            else:
                total += given[f"{axle}_tire_mass"] * rate[axle] ** 2
        return total / 2

    def hessian(self, energy: Callable[[Mapping[str, Any]], Any], names: tuple[str, ...]) -> RealArray:
        """Second derivatives at rest by central differences, in 60 digits."""
        h = self.STEP
        result = np.zeros((len(names), len(names)))
        for i, first in enumerate(names):
            for j, second in enumerate(names[: i + 1]):
                total = mpmath.mpf(0)
                for s in (1, -1):
                    for t in (1, -1):
                        q = dict.fromkeys(names, mpmath.mpf(0))
                        q[first] += s * h
                        q[second] += t * h
                        total += s * t * energy(q)
                result[i, j] = result[j, i] = float(total / (4 * h**2))
        return result

    @pytest.mark.parametrize("name", CARS)
    def test_matrices_are_hessians_of_energies(self, name: str) -> None:
        car = CARS[name]
        given: dict[str, Any] = dict(FULL if "full" in name else HALF) | (FULL_SEAT if "seat" in name else {})
        n, names = len(car.coordinates), (*car.coordinates, *car.roads)
        # Differences err by the step squared, 1e-24; what is left is the rounding of sums in car.K.
        with mpmath.workdps(60):
            K = self.hessian(lambda q: self.strut_energy(q, given, "stiffness"), names)
            C = self.hessian(lambda q: self.strut_energy(q, given, "damping"), names)
            M = self.hessian(lambda q: self.kinetic_energy(q, given), car.coordinates)
        for found, expected in (
            (car.M, M),
            (car.K, K[:n, :n]),
            (car.C, C[:n, :n]),
            (car.K_road, -K[:n, n:]),
            (car.C_road, -C[:n, n:]),
        ):
            np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING * np.max(np.abs(expected)))


class TestSigns:
    @EVERY_CAR
    def test_pitch_lowers_the_nose_and_roll_lifts_the_left_side(self, car: Suspension) -> None:
        """A strut's travel is extension: nose down closes the front struts, left side up opens the left ones."""
        travel = {s.name: s.arms for s in car.struts}
        for name, arms in travel.items():
            if name in {"front", "rear", *WHEELS}:
                assert np.sign(arms["pitch"]) == (-1 if name.startswith("front") else 1)
                assert "roll" not in arms or np.sign(arms["roll"]) == (1 if name.endswith("left") else -1)
        if "seat" in travel:
            assert travel["seat"]["pitch"] == HALF_SEAT["seat_ahead"]

    def test_more_weight_at_the_front_puts_the_nose_down(self) -> None:
        """A driver's 750 N ahead of and left of the centre: the body sinks, nose and left side first."""
        car = full_car(**FULL)
        load = embedding(car, {"all": {"heave": -750.0, "pitch": 750.0 * 0.8, "roll": -750.0 * 0.3}})[:, 0]
        sag = dict(zip(car.coordinates, np.linalg.solve(car.K, load), strict=True))
        assert sag["heave"] < 0 < sag["pitch"]
        assert sag["roll"] < 0


class TestRigidBody:
    """A road that is lifted or tilted as a plane carries the car with it: no strut is stretched."""

    @EVERY_CAR
    @pytest.mark.parametrize("plane", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], ids=["lift", "nod", "lean"])
    def test_the_car_follows_a_plane(self, car: Suspension, plane: tuple[float, float, float]) -> None:
        lift, pitch, roll = plane
        if "roll" not in car.coordinates:
            roll = 0.0
        where = {"front": (1.1, 0.0), "rear": (-1.45, 0.0), "seat": (-0.3, 0.36)}
        for wheel in WHEELS:
            x, track = (1.1, 1.52) if "front" in wheel else (-1.45, 1.47)
            where[wheel] = (x, track / 2 if "left" in wheel else -track / 2)

        def level(name: str) -> float:
            x, y = where[name.removeprefix("road_")]
            return lift - x * pitch + y * roll

        body = {"heave": lift, "pitch": pitch, "roll": roll}
        expected = [body[c] if c in body else level(c) for c in car.coordinates]
        roads = np.array([level(road) for road in car.roads])
        # The condition of K, about 1e3, times rounding.
        np.testing.assert_allclose(np.linalg.solve(car.K, car.K_road @ roads), expected, rtol=0, atol=1e-11)
        stretch = car.arms(car.coordinates) @ np.array(expected) + car.arms(car.roads) @ roads
        np.testing.assert_allclose(stretch, 0.0, rtol=0, atol=ROUNDING)

    @EVERY_CAR
    def test_every_wheel_has_a_road_of_its_own(self, car: Suspension) -> None:
        for road in car.roads:
            wheel = car.coordinates.index(road.removeprefix("road_"))
            column = car.K_road[:, car.roads.index(road)]
            assert np.flatnonzero(column).tolist() == [wheel]
        assert len(car.roads) == (4 if "roll" in car.coordinates else 2)
        assert statespace(car).input_labels == [*car.roads, *(f"{road}_rate" for road in car.roads)]


class TestSymmetry:
    def test_roll_does_not_mix_with_heave_and_pitch_when_sides_are_alike(self) -> None:
        car = symmetric_full()
        even = embedding(
            car,
            {
                "heave": {"heave": 1},
                "pitch": {"pitch": 1},
                "front": pinched(WHEELS[:2]),
                "rear": pinched(WHEELS[2:]),
            },
        )
        odd = embedding(
            car,
            {
                "roll": {"roll": 1},
                "front": {"front_left": 1, "front_right": -1},
                "rear": {"rear_left": 1, "rear_right": -1},
            },
        )
        for matrix in (car.M, car.C, car.K):
            np.testing.assert_allclose(even.T @ matrix @ odd, 0.0, atol=ROUNDING * np.max(np.abs(matrix)))
        assert np.any(even.T @ full_car(**FULL).K @ odd)

    def test_heave_and_pitch_part_where_both_ends_weigh_alike(self) -> None:
        """With la kf = lb kr, and the same of the dampers."""
        ratio = HALF["cg_to_front"] / HALF["cg_to_rear"]
        alike = {"rear_stiffness": ratio * HALF["front_stiffness"], "rear_damping": ratio * HALF["front_damping"]}
        car = half_car(**{**HALF, **alike})
        for matrix in (car.C, car.K):
            assert abs(block(matrix, car, ("heave",), ("pitch",))[0, 0]) <= ROUNDING * np.max(np.abs(matrix))
        assert block(half_car(**HALF).K, car, ("heave",), ("pitch",))[0, 0] != 0

    @EVERY_CAR
    def test_reciprocity(self, car: Suspension) -> None:
        """What a unit impulse at one coordinate does at another, the other's does at the one."""
        time = np.linspace(0, 1.5, 60)
        names = car.coordinates
        motion = np.array(
            [free_decay(car, time, initial_state={f"v_{c}": 1.0 / car.masses[c]}).y for c in names]
        )  # (struck, seen, sample)
        np.testing.assert_allclose(motion, motion.swapaxes(0, 1), rtol=0, atol=1e-11 * np.max(np.abs(motion)))


class TestLimits:
    def test_a_full_car_with_sides_in_phase_is_a_half_car(self) -> None:
        """Of the whole body and both wheels of each axle, through every matrix and every road."""
        full = symmetric_full()
        axle = {
            name: 2 * FULL[name][0] if isinstance(FULL[name], tuple) else HALF[name]
            for name in inspect.signature(half_car).parameters
            if name in HALF
        }
        half = half_car(**axle)
        images: dict[str, dict[str, float]] = {
            "heave": {"heave": 1},
            "pitch": {"pitch": 1},
            "front": pinched(WHEELS[:2]),
            "rear": pinched(WHEELS[2:]),
        }
        P = embedding(full, images)
        roads = np.kron(np.eye(2), [[1.0], [1.0]])
        for found, expected in (
            (P.T @ full.M @ P, half.M),
            (P.T @ full.C @ P, half.C),
            (P.T @ full.K @ P, half.K),
            (P.T @ full.C_road @ roads, half.C_road),
            (P.T @ full.K_road @ roads, half.K_road),
        ):
            np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING * np.max(np.abs(expected)))
        # Modes are ill-conditioned by about 1e3; the full car's include the half car's.
        nearest = np.min(np.abs(eigenmodes(full).poles[:, None] / eigenmodes(half).poles - 1), axis=0)
        assert np.max(nearest) < 1e-11

    def test_a_half_car_with_equal_ends_that_does_not_pitch_is_a_quarter_car(self) -> None:
        given = {name: HALF[name.replace("rear", "front").replace("cg_to_front", "cg_to_rear")] for name in HALF}
        half = half_car(**given, **{**HALF_SEAT, "seat_ahead": 0.0})
        quarter = quarter_car(
            seat_mass=HALF_SEAT["seat_mass"],
            chassis_mass=given["chassis_mass"],
            tire_mass=2 * given["front_tire_mass"],
            seat_stiffness=HALF_SEAT["seat_stiffness"],
            chassis_stiffness=2 * given["front_stiffness"],
            tire_stiffness=2 * given["front_tire_stiffness"],
            seat_damping=HALF_SEAT["seat_damping"],
            chassis_damping=2 * given["front_damping"],
            tire_damping=2 * given["front_tire_damping"],
        )
        P = embedding(half, {"seat": {"seat": 1}, "chassis": {"heave": 1}, "tire": pinched(("front", "rear"))})
        for matrix in ("M", "C", "K"):
            np.testing.assert_array_equal(P.T @ getattr(half, matrix) @ P, getattr(quarter, matrix))
            pitch = half.coordinates.index("pitch")
            np.testing.assert_array_equal((getattr(half, matrix) @ P)[pitch], 0.0)

    def test_a_seat_as_stiff_as_can_be_adds_its_mass_and_moment(self) -> None:
        """Its point follows the body: mass m at (x, y) adds m, m x^2, m y^2 and the products between them."""
        car = full_car(**FULL, **FULL_SEAT)
        x, y, m = FULL_SEAT["seat_ahead"], FULL_SEAT["seat_left"], FULL_SEAT["seat_mass"]
        images: dict[str, dict[str, float]] = {
            "heave": {"heave": 1, "seat": 1},
            "pitch": {"pitch": 1, "seat": -x},
            "roll": {"roll": 1, "seat": y},
        }
        P = embedding(car, images)
        lever = np.array([1.0, -x, y])
        bare = full_car(**FULL)
        np.testing.assert_allclose(
            P.T @ car.M @ P, block(bare.M, bare, tuple(images), tuple(images)) + m * np.outer(lever, lever), rtol=1e-13
        )
        expected = block(bare.K, bare, tuple(images), tuple(images))
        np.testing.assert_allclose(P.T @ car.K @ P, expected, rtol=0, atol=ROUNDING * np.max(np.abs(expected)))


class TestTextbookFrequencies:
    """Springs alone, ends that weigh alike, tires that do not yield."""

    STIFF = 1e8  # times a spring: a tire then changes a square of a frequency by 1e-8

    def car(self, **changes: Any) -> Suspension:
        k = FULL["front_stiffness"][0]
        rear = k * FULL["cg_to_front"] / FULL["cg_to_rear"]
        springs = {"front_stiffness": k, "rear_stiffness": rear, "front_damping": 0.0, "rear_damping": 0.0}
        tires = {f"{axle}_tire_{what}": rate for axle in ("front", "rear") for what, rate in self.tires(k).items()}
        return symmetric_full(**{**springs, **tires, **changes})

    def tires(self, k: float) -> dict[str, float]:
        return {"stiffness": self.STIFF * k, "damping": 0.0}

    def test_heave_pitch_and_roll(self) -> None:
        kf, a, b = FULL["front_stiffness"][0], FULL["cg_to_front"], FULL["cg_to_rear"]
        kr = kf * a / b
        tf, tr = FULL["front_track"], FULL["rear_track"]
        bars = FULL["front_antiroll_stiffness"] * tf**2 + FULL["rear_antiroll_stiffness"] * tr**2
        heave = np.sqrt(2 * (kf + kr) / FULL["chassis_mass"])
        pitch = np.sqrt(2 * (kf * a**2 + kr * b**2) / FULL["pitch_inertia"])
        roll = np.sqrt(((kf * tf**2 + kr * tr**2) / 2 + bars) / FULL["roll_inertia"])
        found = eigenmodes(self.car())
        np.testing.assert_allclose(found.wn[:3], sorted([heave, pitch, roll]), rtol=1e-7)
        np.testing.assert_allclose(found.zeta, 0.0, atol=1e-5)  # rounding of poles 1e4 times as large

    def test_wheel_hop(self) -> None:
        """A body that cannot move leaves each wheel between spring and tire."""
        fixed = {"chassis_mass": 1e12, "pitch_inertia": 1e12, "roll_inertia": 1e12}
        bars = {"front_antiroll_stiffness": None, "rear_antiroll_stiffness": None}
        car = full_car(**{**FULL, **fixed, **bars})
        k, kt, m = (
            np.array([*FULL[f"front_{what}"], *FULL[f"rear_{what}"]])
            for what in ("stiffness", "tire_stiffness", "tire_mass")
        )
        np.testing.assert_allclose(eigenmodes(car).wn[3:], np.sort(np.sqrt((k + kt) / m)), rtol=1e-7)

    def test_bars_resist_roll_and_single_wheels_alone(self) -> None:
        bare = full_car(**{**FULL, "front_antiroll_stiffness": None, "rear_antiroll_stiffness": None})
        car = full_car(**FULL)
        assert [s.name for s in car.struts if s not in bare.struts] == ["front_antiroll", "rear_antiroll"]
        difference = car.K - bare.K
        even = embedding(car, {"heave": {"heave": 1}, "pitch": {"pitch": 1}, "axle": pinched(WHEELS[:2])})
        np.testing.assert_allclose(difference @ even, 0.0, atol=ROUNDING * np.max(np.abs(car.K)))
        expected = sum(FULL[f"{a}_antiroll_stiffness"] * FULL[f"{a}_track"] ** 2 for a in ("front", "rear"))
        assert block(difference, car, ("roll",), ("roll",))[0, 0] == pytest.approx(expected, rel=1e-12)


class TestEnergy:
    @staticmethod
    def energy(car: Suspension, rng: np.random.Generator) -> RealArray:
        n = len(car.coordinates)
        names = [*car.coordinates, *(f"{c}_velocity" for c in car.coordinates)]
        start = rng.standard_normal(2 * n) * np.repeat([0.01, 0.2], n)
        response = free_decay(statespace(car, outputs=names), np.linspace(0, 3, 400), initial_state=start)
        q, v = response.y[:n], response.y[n:]
        return np.asarray((np.sum(q * (car.K @ q), axis=0) + np.sum(v * (car.M @ v), axis=0)) / 2)

    @EVERY_CAR
    def test_without_dampers_it_stays(self, car: Suspension) -> None:
        bare = car.with_parameters(damping={s.name: 0.0 for s in car.struts})
        energy = self.energy(bare, np.random.default_rng(3))
        np.testing.assert_allclose(energy, energy[0], rtol=1e-10)  # rounding over some 50 periods

    @EVERY_CAR
    def test_with_dampers_it_only_falls(self, car: Suspension) -> None:
        energy = self.energy(car, np.random.default_rng(4))
        assert np.all(np.diff(energy) <= 1e-12 * energy[0])
        assert np.all(eigenmodes(car).poles.real < 0)


class TestOutputs:
    def test_travel_of_every_strut_is_upper_end_less_lower(self) -> None:
        car = full_car(**FULL, **FULL_SEAT)
        time = np.linspace(0, 0.5, 20)
        names = [
            "seat",
            "heave",
            "pitch",
            "roll",
            "rear_right",
            "rear_right_travel",
            "seat_travel",
            "rear_right_tire_travel",
        ]
        start = {"v_pitch": 0.3, "v_roll": -0.2, "v_heave": 0.1, "v_front_left": 1.0}
        found = dict(zip(names, free_decay(statespace(car, outputs=names), time, initial_state=start).y, strict=True))
        right = found["heave"] + 1.45 * found["pitch"] - 1.47 / 2 * found["roll"]
        seat = found["heave"] + 0.3 * found["pitch"] + 0.36 * found["roll"]
        for name, expected in (
            ("rear_right_travel", right - found["rear_right"]),
            ("seat_travel", found["seat"] - seat),
            ("rear_right_tire_travel", found["rear_right"]),
        ):
            np.testing.assert_allclose(found[name], expected, rtol=0, atol=ROUNDING)

    def test_names(self) -> None:
        assert CARS["half with seat"].coordinates == ("seat", "heave", "pitch", "front", "rear")
        assert CARS["half"].roads == ("road_front", "road_rear")
        assert CARS["full with seat"].coordinates == ("seat", "heave", "pitch", "roll", *WHEELS)
        assert CARS["full"].roads == tuple(f"road_{wheel}" for wheel in WHEELS)
        tires = tuple(f"{wheel}_tire" for wheel in WHEELS)
        bars = ("front_antiroll", "rear_antiroll")
        assert tuple(s.name for s in CARS["full with seat"].struts) == ("seat", *WHEELS, *tires, *bars)

    @pytest.mark.parametrize("make", [tuple, list, np.array])
    def test_one_value_stands_for_both_sides(self, make: Callable[[Any], Any]) -> None:
        one = full_car(**{**FULL, "rear_damping": 1300.0})
        assert full_car(**{**FULL, "rear_damping": make([1300.0, 1300.0])}) == one
        assert full_car(**FULL) != one


REFUSED: dict[str, tuple[Callable[..., Suspension], dict[str, Any], str]] = {
    "behind": (half_car, {"cg_to_front": -1.2}, r"cg_to_front = -1.2 m must be positive"),
    "no length": (half_car, {"cg_to_rear": 0.0}, r"cg_to_rear = 0 m must be positive"),
    "not a length": (half_car, {"cg_to_rear": "1"}, r"cg_to_rear = '1' is not a number; give it in m"),
    "infinite": (half_car, {"pitch_inertia": np.inf}, r"pitch_inertia = inf kg m2 is not finite"),
    "mass": (half_car, {"chassis_mass": -3.0}, r"chassis_mass = -3 kg must be positive"),
    "pair": (half_car, {"front_stiffness": (1.0, 2.0)}, r"stiffness = \(1.0, 2.0\) is not a number"),
    "wheel": (half_car, {"front_tire_mass": 0.0}, r"mass 'front' = 0 kg must be positive"),
    "seat": (half_car, {"seat_mass": 80.0}, r"also needs seat_stiffness, seat_damping, seat_ahead"),
    "seat nowhere": (half_car, {**HALF_SEAT, "seat_ahead": None}, r"also needs seat_ahead"),
    "seat at nan": (half_car, {**HALF_SEAT, "seat_ahead": np.nan}, r"seat_ahead = nan m is not finite"),
    "seat on no side": (full_car, HALF_SEAT, r"a car with a seat also needs seat_left"),
    "track": (full_car, {"front_track": -1.5}, r"front_track = -1.5 m must be positive"),
    "roll": (full_car, {"roll_inertia": 0}, r"roll_inertia = 0 kg m2 must be positive"),
    "three sides": (full_car, {"rear_damping": (1.0, 2.0, 3.0)}, r"rear_damping = \(1.0, 2.0, 3.0\): give one value"),
    "side": (full_car, {"rear_damping": (1.0, -2.0)}, r"strut 'rear_right': damping = -2 N s/m is negative"),
    "no side": (full_car, {"rear_damping": (1.0, None)}, r"rear_damping = None is not a number; give it in N s/m"),
    "text": (full_car, {"front_tire_mass": "40"}, r"front_tire_mass = '40' is not a number; give it in kg"),
    "bar": (full_car, {"front_antiroll_stiffness": -1.0}, r"strut 'front_antiroll': stiffness = -1 N/m is negative"),
}


class TestRefusals:
    @pytest.mark.parametrize(("make", "changes", "message"), REFUSED.values(), ids=REFUSED.keys())
    def test_refused_with_name_value_and_unit(
        self, make: Callable[..., Suspension], changes: dict[str, Any], message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            make(**{**(FULL if make is full_car else HALF), **changes})


@pytest.mark.parametrize("name", ["cg_to_front", "cg_to_rear", "front_track", "rear_track"])
def test_lengths_in_millimetres_are_refused_with_the_unit(name: str) -> None:
    make, numbers = (half_car, HALF) if name in HALF else (full_car, FULL)
    in_mm = {**numbers, name: 1000 * float(numbers[name])}
    with pytest.raises(InputError, match=f"{name} = .*if it was given in mm"):
        make(**in_mm)
