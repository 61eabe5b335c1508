"""Sensors by name, and forces as inputs of the state space."""

import dataclasses
import re

import control
import numpy as np
import pytest

from suspid import InputError, Sensor, Suspension, half_car, quarter_car, statespace
from suspid.model import car_from_toml, car_to_toml, force_weights, output_rows
from suspid.model.sensor import Motion
from suspid.units import ComplexArray

# Products and sums of a few floats.
ROUNDING = 1e-12


def car() -> Suspension:
    return half_car(
        chassis_mass=1200,
        pitch_inertia=1800,
        front_tire_mass=80,
        rear_tire_mass=90,
        cg_to_front=1.2,
        cg_to_rear=1.5,
        front_stiffness=40e3,
        rear_stiffness=36e3,
        front_tire_stiffness=400e3,
        rear_tire_stiffness=410e3,
        front_damping=3000,
        rear_damping=2800,
        front_tire_damping=60,
    )


def with_sensors(*sensors: Sensor) -> Suspension:
    return dataclasses.replace(car(), sensors=sensors)


def response(system: control.StateSpace, f: float = 2.3) -> ComplexArray:
    return np.asarray(system(2j * np.pi * f, squeeze=False))


CORNER = {"heave": 1.0, "pitch": -1.2}


class TestSensors:
    def test_a_point_of_the_body_moves_as_a_rigid_body_does(self) -> None:
        seen = with_sensors(Sensor(name="az", motion="acceleration", of=CORNER))
        parts = response(statespace(car(), outputs=["heave_acceleration", "pitch_acceleration"]))
        np.testing.assert_allclose(
            response(statespace(seen, outputs=["az"])), [parts[0] - 1.2 * parts[1]], rtol=ROUNDING
        )

    @pytest.mark.parametrize(("motion", "order"), [("displacement", 0), ("velocity", 1), ("acceleration", 2)])
    def test_each_derivative_multiplies_by_s(self, motion: Motion, order: int) -> None:
        seen = with_sensors(
            Sensor(name="y", motion=motion, of=CORNER), Sensor(name="x", motion="displacement", of=CORNER)
        )
        s = 2j * np.pi * 2.3
        y, x = response(statespace(seen, outputs=["y", "x"], forces=["pitch"], roads=[]))
        np.testing.assert_allclose(y, s**order * x, rtol=1e-9)
        assert output_rows(seen, ["y"]).orders.tolist() == [order]

    def test_travel_is_that_of_the_strut(self) -> None:
        seen = with_sensors(Sensor(name="pot", motion="travel", of="front"))
        both = response(statespace(seen, outputs=["pot", "front_travel"]))
        np.testing.assert_array_equal(both[0], both[1])

    def test_a_platform_is_seen_as_it_moves(self) -> None:
        seen = with_sensors(Sensor(name="gap", motion="displacement", of={"front": 1, "road_front": -1}))
        for rate in (True, False):
            system = statespace(seen, outputs=["gap", "front_tire_travel", "road_front"], road_rate=rate)
            gap, travel, road = response(system)
            np.testing.assert_array_equal(gap, travel)
            assert road[0] == 1
            np.testing.assert_array_equal(road[1:], 0)

    def test_rows_are_those_of_the_channels(self) -> None:
        seen = with_sensors(Sensor(name="rate", motion="velocity", of="pitch"))
        rows = output_rows(seen, ["rate", "rear", "road_rear_rate", "road_front_acceleration", "rear_tire_travel"])
        assert rows.orders.tolist() == [1, 0, 1, 2, 0]
        assert rows.coordinates.tolist() == [[0, 1, 0, 0], [0, 0, 0, 1], [0] * 4, [0] * 4, [0, 0, 0, 1]]
        assert rows.roads.tolist() == [[0, 0], [0, 0], [0, 1], [1, 0], [0, -1]]
        assert output_rows(seen, []).coordinates.shape == (0, 4)

    @pytest.mark.parametrize(
        ("sensor", "message"),
        [
            (Sensor(name="a", motion="velocity", of="heav"), "sensor 'a': there is no coordinate 'heav'. Did you mean"),
            (Sensor(name="a", motion="travel", of="heave"), "sensor 'a': there is no strut 'heave'. Known: 'front'"),
            (Sensor(name="front", motion="velocity", of="front"), "sensor 'front' has the name of an input or output"),
            (Sensor(name="front_travel", motion="travel", of="front"), "has the name of an input or output"),
        ],
    )
    def test_sensors_of_nothing_are_refused(self, sensor: Sensor, message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            with_sensors(sensor)

    def test_a_name_twice_and_no_sensor_are_refused(self) -> None:
        one = Sensor(name="a", motion="velocity", of="heave")
        with pytest.raises(InputError, match="sensor name 'a' is used twice"):
            with_sensors(one, one)
        with pytest.raises(InputError, match="every item must be a Sensor"):
            with_sensors("a")  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"motion": "speed", "of": "heave"}, "motion = 'speed' is not one of displacement, velocity"),
            ({"motion": "travel", "of": {"heave": 1}}, "a travel is of one strut"),
            ({"motion": "velocity", "of": 3}, "must be a coordinate, or map coordinates to arms"),
            ({"motion": "velocity", "of": {"heave": 0}}, "has no nonzero arm"),
            ({"motion": "velocity", "of": {"heave": np.nan}}, "arm 'heave' = nan 1 or m is not finite"),
        ],
    )
    def test_wrong_sensors_are_refused(self, given: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=message):
            Sensor(name="a", **given)  # type: ignore[arg-type]

    def test_an_acceleration_of_the_road_is_no_output(self) -> None:
        with pytest.raises(InputError, match="'road_front_acceleration' depends on the acceleration of a road"):
            statespace(car(), outputs=["road_front_acceleration"])
        with pytest.raises(InputError, match="'road_front_rate' depends on the rate of a road"):
            statespace(car(), outputs=["road_front_rate"], road_rate=False)


class TestCarFiles:
    SENSORS = """
[sensors]
az = { acceleration = "heave", ahead = 1.2 }
corner = { velocity = "heave", ahead = -0.5, left = 0.7 }
rate = { velocity = "roll" }
lift = { displacement = { front_left = 0.5, front_right = 0.5 } }
pot = { travel = "front_left" }
"""
    CAR = """
[full_car]
chassis_mass = 1200
pitch_inertia = 1800
roll_inertia = 500
front_tire_mass = 40
rear_tire_mass = 40
cg_to_front = 1.2
cg_to_rear = 1.5
front_track = 1.5
rear_track = 1.5
front_stiffness = 20e3
rear_stiffness = 18e3
front_tire_stiffness = 200e3
rear_tire_stiffness = 200e3
front_damping = 1500
rear_damping = 1400
"""

    def test_sensors_and_mounts_stand_beside_a_preset(self) -> None:
        found = car_from_toml(f"{self.CAR}[mounts]\nfront_left = 1e6\n{self.SENSORS}")
        of = {s.name: (s.motion, s.of) for s in found.sensors}
        assert of == {
            "az": ("acceleration", {"heave": 1.0, "pitch": -1.2}),
            "corner": ("velocity", {"heave": 1.0, "pitch": 0.5, "roll": 0.7}),
            "rate": ("velocity", {"roll": 1.0}),
            "lift": ("displacement", {"front_left": 0.5, "front_right": 0.5}),
            "pot": ("travel", "front_left"),
        }
        assert [s.mount_stiffness for s in found.struts][:2] == [1e6, None]
        assert car_from_toml(car_to_toml(found)) == found

    @pytest.mark.parametrize(
        ("line", "message"),
        [
            ('a = { speed = "heave" }', "[sensors] 'a' has an unknown key 'speed'"),
            ('a = { velocity = "heave", travel = "front_left" }', "[sensors] 'a' must have one of displacement"),
            ('a = { velocity = "pitch", ahead = 1 }', "they go with 'heave' alone"),
            ("a = { velocity = 3 }", "velocity = 3 must be a name, or a table of arms"),
            ('a = { velocity = { heave = "x" } }', "heave = 'x' must be a number in 1 or m"),
            ('a = "heave"', "[sensors] 'a' must be a table"),
        ],
    )
    def test_wrong_sensors_are_refused(self, line: str, message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            car_from_toml(f"{self.CAR}[sensors]\n{line}\n")

    def test_a_mount_of_nothing_is_refused(self) -> None:
        with pytest.raises(InputError, match="there is no strut 'front_lft'. Did you mean 'front_left'"):
            car_from_toml(f"{self.CAR}[mounts]\nfront_lft = 1e6\n")


class TestForces:
    FORCES = ("heave", "pitch", "front_travel", "rear")

    def test_reciprocity_of_maxwell_and_betti(self) -> None:
        mounted = car().with_parameters(mount_stiffness={"front": 1e6})
        for one in (car(), mounted):
            flexibility = response(statespace(one, outputs=self.FORCES, forces=self.FORCES, roads=[]))
            np.testing.assert_allclose(flexibility, flexibility.T, rtol=1e-9, atol=1e-12 * np.abs(flexibility).max())

    def test_a_constant_force_is_carried_by_the_springs(self) -> None:
        system = statespace(car(), forces=["rear"], roads=[])
        np.testing.assert_allclose(car().K @ system.dcgain()[:, 0], [0, 0, 0, 1], atol=1e-9)

    def test_an_actuator_pushes_the_ends_apart_and_moves_no_common_centre(self) -> None:
        one = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
        )
        system = statespace(
            one, outputs=["chassis_acceleration", "tire_acceleration"], forces=["chassis_travel"], roads=[]
        )
        np.testing.assert_allclose(system.D, [[1 / 400], [-1 / 40]])
        np.testing.assert_array_equal(force_weights(one, "chassis_travel"), [1, -1])

    def test_lqr_acts_by_the_forces_alone(self) -> None:
        system = statespace(car(), forces=["front_travel", "rear_travel"])
        assert system.input_labels == ["front_travel_force", "rear_travel_force"]
        gain, _, poles = control.lqr(system, np.eye(8), 1e-6 * np.eye(2))
        assert gain.shape == (2, 8)
        assert np.all(np.real(poles) < 0)

    @pytest.mark.parametrize("rate", [True, False])
    def test_roads_come_first_and_are_as_without_forces(self, rate: bool) -> None:
        plain, pushed = (statespace(car(), forces=f, roads=car().roads, road_rate=rate) for f in ((), ("heave",)))
        assert pushed.input_labels == [*plain.input_labels, "heave_force"]
        np.testing.assert_array_equal(pushed.B[:, :-1], plain.B)
        one = statespace(car(), roads=["road_rear"], road_rate=rate)
        columns = [plain.input_labels.index(label) for label in one.input_labels]
        np.testing.assert_array_equal(one.B, plain.B[:, columns])

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ({"forces": "heave"}, "forces='heave' is one string"),
            ({"forces": ["heave", "heave_force"]}, "force 'heave' is given 2 times"),
            (
                {"forces": ["heav"]},
                "force 'heav' pushes nothing of the car; a force is named by a mass, or by the travel of the strut "
                "whose ends it pushes apart. Did you mean 'heave'",
            ),
            ({"forces": ["front_tire"]}, "Forces between the ends of that strut: 'front_tire_travel'."),
            ({"forces": ["heave_velocity"]}, "'heave_velocity' is not a displacement of a mass"),
            ({"forces": ["road_front"]}, "'road_front' is not a displacement of a mass"),
            ({"roads": ["road"]}, "there is no road 'road'. Did you mean 'road_"),
        ],
    )
    def test_wrong_inputs_are_refused(self, given: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=re.escape(message)):
            statespace(car(), **given)  # type: ignore[arg-type]


def test_a_full_car_with_every_sensor_has_a_state_space() -> None:
    found = car_from_toml(TestCarFiles.CAR + TestCarFiles.SENSORS)
    assert statespace(found, outputs=[s.name for s in found.sensors]).output_labels == [s.name for s in found.sensors]
