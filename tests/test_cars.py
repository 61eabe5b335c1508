"""Car descriptions and modes as files: what is written comes back, and what is wrong is named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from suspid import InputError, ModalSet, Sensor, Strut, Suspension, full_car, half_car, quarter_car
from suspid.identification.modes_json import modes_from_dict, modes_to_dict, read_modes, to_json
from suspid.model import car_from_toml, car_to_toml, output_rows, read_car, write_car

NAMES = st.text(st.characters(codec="utf-8"), min_size=1, max_size=8).filter(lambda n: "." not in n)
RATES = st.floats(0, 1e300)
MASSES = st.floats(1e-300, 1e300, exclude_min=True)
EXAMPLES = Path(__file__).resolve().parents[1] / "examples"

MASSES_TABLE = "[masses]\nbody = 10\n"
STRUT = '[[struts]]\nname = "leg"\nstiffness = 1e3\ndamping = 2\narms = { body = 1, road = -1 }\n'
SHORT = "[quarter_car]\nchassis_mass = 4\ntire_mass = 1\nchassis_stiffness = 2e3\ntire_stiffness = 2e4\n"
HALF = (
    "[half_car]\nchassis_mass = 1200\npitch_inertia = 1800\nfront_tire_mass = 80\nrear_tire_mass = 90\n"
    "cg_to_front = 1.2\ncg_to_rear = 1.5\nfront_stiffness = 40e3\nrear_stiffness = 36e3\n"
    "front_tire_stiffness = 400e3\nrear_tire_stiffness = 380e3\nfront_damping = 3e3\n"
)
FULL = (
    HALF.replace("half", "full").replace("rear_stiffness = 36e3", "rear_stiffness = [17e3, 19e3]")
    + "rear_damping = 1400\nroll_inertia = 500\nfront_track = 1.5\nrear_track = 1.48\n"
)


class TestWrittenThenReadIsTheSame:
    @settings(deadline=None)
    @given(
        names=st.lists(NAMES, min_size=2, max_size=3, unique=True),
        mass=MASSES,
        stiffness=st.floats(1e-300, 1e300),
        damping=RATES,
        arm=st.floats(-1e300, 1e300),
    )
    def test_any_names_and_numbers(
        self, names: list[str], mass: float, stiffness: float, damping: float, arm: float
    ) -> None:
        arms = {names[0]: 1.0, names[1]: arm}
        masses = dict.fromkeys(names[:1], mass)
        try:
            car = Suspension(
                masses=masses, struts=[Strut(name=names[-1], stiffness=stiffness, damping=damping, arms=arms)]
            )
        except InputError:
            return  # two names that could be a slip
        assert car_from_toml(car_to_toml(car)) == car

    def test_through_a_file(self, tmp_path: Path) -> None:
        car = read_car(EXAMPLES / "car.toml")
        write_car(car, tmp_path / "car.toml")
        assert read_car(tmp_path / "car.toml") == car
        assert [p.name for p in tmp_path.iterdir()] == ["car.toml"]


class TestShortForm:
    def test_it_is_quarter_car(self) -> None:
        expected = quarter_car(
            chassis_mass=4, tire_mass=1, chassis_stiffness=2e3, tire_stiffness=2e4, chassis_damping=30
        )
        assert car_from_toml(SHORT + "chassis_damping = 30\n") == expected

    def test_it_is_half_car(self) -> None:
        expected = half_car(
            chassis_mass=1200,
            pitch_inertia=1800,
            front_tire_mass=80,
            rear_tire_mass=90,
            cg_to_front=1.2,
            cg_to_rear=1.5,
            front_stiffness=40e3,
            rear_stiffness=36e3,
            front_tire_stiffness=400e3,
            rear_tire_stiffness=380e3,
            front_damping=3e3,
            rear_damping=2800,
            seat_mass=80,
            seat_stiffness=16e3,
            seat_damping=500,
            seat_ahead=-0.2,
        )
        seat = "seat_mass = 80\nseat_stiffness = 16e3\nseat_damping = 500\nseat_ahead = -0.2\n"
        car = car_from_toml(HALF + "rear_damping = 2800\n" + seat)
        assert car == expected
        assert car_from_toml(car_to_toml(car)) == car

    def test_it_is_full_car_with_a_pair_for_two_sides(self) -> None:
        expected = full_car(
            chassis_mass=1200,
            pitch_inertia=1800,
            roll_inertia=500,
            front_tire_mass=80,
            rear_tire_mass=90,
            cg_to_front=1.2,
            cg_to_rear=1.5,
            front_track=1.5,
            rear_track=1.48,
            front_stiffness=40e3,
            rear_stiffness=(17e3, 19e3),
            front_tire_stiffness=400e3,
            rear_tire_stiffness=380e3,
            front_antiroll_stiffness=5e3,
            front_damping=3e3,
            rear_damping=1400,
        )
        car = car_from_toml(FULL + "front_antiroll_stiffness = 5e3\n")
        assert car == expected
        assert car_from_toml(car_to_toml(car)) == car


REFUSED = [
    ("\n", r"there is no \[masses\]"),
    ("masses = ", "is not TOML: Invalid value"),
    ("x = " + "1" * 5000, "is not TOML"),
    ("x = " + "[" * 5000, "is not TOML"),
    (MASSES_TABLE, r"there is no \[\[struts\]\]"),
    (STRUT, r"there is no \[masses\]"),
    (MASSES_TABLE + STRUT + "[mases]\na = 1\n", "has an unknown key 'mases'. Did you mean 'masses'"),
    ("masses = 3\n" + STRUT, r"\[masses\] must be a table, not 3"),
    ("struts = 3\n" + MASSES_TABLE, r"\[struts\] must be a list"),
    ("struts = [3]\n" + MASSES_TABLE, r"\[\[struts\]\] number 1 must be a table"),
    (MASSES_TABLE.replace("10", '"10"') + STRUT, r"\[masses\]: body = '10' must be a number in kg"),
    (MASSES_TABLE.replace("10", "true") + STRUT, "body = True must be a number in kg"),
    (MASSES_TABLE.replace("10", "-1") + STRUT, "mass 'body' = -1 kg must be positive"),
    (MASSES_TABLE.replace("10", "nan") + STRUT, "not finite"),
    (MASSES_TABLE.replace("10", "1" + "0" * 400) + STRUT, "body is too large"),
    (MASSES_TABLE + STRUT.replace("damping", "damper"), "'leg' has an unknown key 'damper'. Did you mean 'damping'"),
    (MASSES_TABLE + STRUT.replace("damping = 2\n", ""), r"\[\[struts\]\] 'leg': damping is missing"),
    (MASSES_TABLE + STRUT.replace('name = "leg"\n', ""), r"\[\[struts\]\] number 1: name is missing"),
    (MASSES_TABLE + STRUT.replace('"leg"', "5"), "name = 5 must be text"),
    (MASSES_TABLE + STRUT.replace("1e3", '"1e3"'), "'leg': stiffness = '1e3' must be a number in N/m"),
    (MASSES_TABLE + STRUT.replace("1e3", "-1e3"), "stiffness = -1000 N/m is negative"),
    (MASSES_TABLE + STRUT.replace("body = 1", 'body = "up"'), "'leg': arms: body = 'up' must be a number"),
    (MASSES_TABLE + STRUT.replace("{ body = 1, road = -1 }", "[1, -1]"), "arms must be a table"),
    (MASSES_TABLE + STRUT.replace("body = 1", "bodyy = 1"), "close to 'body'"),
    (MASSES_TABLE + STRUT + STRUT, "strut name 'leg' is used 2 times"),
    (SHORT, r"\[quarter_car\]: chassis_damping is missing"),
    (
        SHORT + "chasis_damping = 3\n",
        r"\[quarter_car\] has an unknown key 'chasis_damping'. Did you mean 'chassis_damping'",
    ),
    (SHORT + "chassis_damping = 3\nseat_mass = 1\n", "a car with a seat also needs seat_stiffness, seat_damping"),
    (SHORT + "chassis_damping = 3\n" + MASSES_TABLE, "describes the whole car"),
    (HALF, r"\[half_car\]: rear_damping is missing"),
    (HALF + "rear_damping = 3\nseat_left = 3\n", r"\[half_car\] has an unknown key 'seat_left'"),
    (HALF + "rear_damping = [3, 4]\n", r"\[half_car\]: rear_damping = \[3, 4\] must be a number in N s/m"),
    (HALF.replace("1800", '"a"') + "rear_damping = 3\n", "pitch_inertia = 'a' must be a number in kg m2"),
    (HALF.replace("1.2", '"a"') + "rear_damping = 3\n", "cg_to_front = 'a' must be a number in m"),
    (HALF.replace("1.2", "-1.2") + "rear_damping = 3\n", r"\[half_car\]: cg_to_front = -1.2 m must be positive"),
    (HALF + "rear_damping = 3\n" + FULL, r"\[half_car\] describes the whole car; remove \[full_car\]"),
    (FULL.replace("17e3, 19e3", "1, 2, 3"), r"rear_stiffness = \(1.0, 2.0, 3.0\): give one value \[N/m\] for both"),
    (FULL.replace("17e3", "true"), "rear_stiffness = True must be a number in N/m"),
    (FULL.replace("= 1.5\nrear_track", "= [1, 2]\nrear_track"), r"front_track = \(1.0, 2.0\) is not a number"),
    (FULL + "seat_mass = 80\n", "a car with a seat also needs seat_stiffness, seat_damping, seat_ahead, seat_left"),
    ("quarter_car = 4\n", r"\[quarter_car\] must be a table"),
]


class TestRefusals:
    @pytest.mark.parametrize(("text", "message"), REFUSED, ids=[message[:40] for _, message in REFUSED])
    def test_one_line_that_names_file_table_and_key(self, tmp_path: Path, text: str, message: str) -> None:
        path = tmp_path / "car.toml"
        path.write_text(text)
        with pytest.raises(InputError, match=message) as refusal:
            read_car(path)
        assert str(refusal.value).startswith(f"{path}: ")
        assert len(str(refusal.value).splitlines()) == 1

    @settings(deadline=None)
    @given(text=st.text('[]{}="\n#.,_ masestrudb0123-eEinfx', max_size=60))
    def test_any_text_gives_a_car_or_a_refusal(self, text: str) -> None:
        try:
            car = car_from_toml(text)
        except InputError:
            return
        assert car.masses


class TestModesAsJson:
    @settings(deadline=None)
    @given(
        poles=st.lists(st.builds(complex, st.floats(-1e3, 1e3), st.floats(1e-3, 1e3)), min_size=1, max_size=3),
        channels=st.lists(st.text(max_size=5), min_size=1, max_size=2),
        seed=st.integers(0, 99),
    )
    def test_every_bit_comes_back(self, poles: list[complex], channels: list[str], seed: int) -> None:
        rng = np.random.default_rng(seed)
        count = 2 * len(poles) * (1 + len(channels))
        modes = ModalSet(
            poles=np.array(poles),
            shapes=np.asarray(rng.standard_normal((len(channels), len(poles))) * (1 + 0.1j), complex),
            channels=channels,
            covariance=np.cov(rng.standard_normal((count, 2 * count))),
        )
        back = modes_from_dict(json.loads(to_json(modes_to_dict(modes))))
        assert back.channels == modes.channels
        assert back.poles.tobytes() == modes.poles.tobytes()
        assert back.shapes is not None
        assert modes.shapes is not None
        assert back.shapes.tobytes() == modes.shapes.tobytes()
        assert back.covariance is not None
        assert modes.covariance is not None
        assert back.covariance.tobytes() == modes.covariance.tobytes()

    @pytest.mark.parametrize("suffix", [".toml", ".json"])
    def test_written_by_hand_in_any_order(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"modes{suffix}"
        path.write_text(
            "[[modes]]\nwn_rad_per_s = 70\nzeta = 0.2\nwn_std_rad_per_s = 0.5\nzeta_std = 0.02\n"
            "[[modes]]\nwn_rad_per_s = 10\nzeta = 0.3\nwn_std_rad_per_s = 0.1\nzeta_std = 0.01\n"
            if suffix == ".toml"
            else '{"modes": [{"wn_rad_per_s": 70, "zeta": 0.2, "wn_std_rad_per_s": 0.5, "zeta_std": 0.02},'
            '{"wn_rad_per_s": 10, "zeta": 0.3, "wn_std_rad_per_s": 0.1, "zeta_std": 0.01}]}'
        )
        modes = read_modes(path)
        # Tolerances: wn and zeta go through the pole and back.
        assert modes.wn == pytest.approx([10, 70], rel=1e-14)
        assert modes.zeta == pytest.approx([0.3, 0.2], rel=1e-14)
        assert modes.wn_std == pytest.approx([0.1, 0.5], rel=1e-12)
        assert modes.zeta_std == pytest.approx([0.01, 0.02], rel=1e-12)

    def test_hertz(self) -> None:
        modes = modes_from_dict({"modes": [{"frequency_hz": 2, "zeta": 0}]})
        assert modes.wn == pytest.approx([4 * np.pi], rel=1e-15)  # one multiplication

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("[", "is not JSON"),
            ("[" * 100000, "is not JSON"),
            ("[]", "must contain a JSON object"),
            ("{}", "modes is missing"),
            ('{"modes": []}', "no mode was found in this record"),
            ('{"modes": [3]}', "mode 1 must be an object"),
            ('{"format": "other", "modes": [{}]}', "format 'other' is not known"),
            ('{"modes": [{"zeta": 0.1}]}', "mode 1 needs zeta, and wn_rad_per_s or frequency_hz"),
            ('{"modes": [{"wn": 1, "zeta": 0.1}]}', "mode 1 has the unknown key 'wn'"),
            ('{"modes": [{"frequency_hz": "2", "zeta": 0.1}]}', "mode 1: frequency_hz = '2' must be a number"),
            ('{"modes": [{"frequency_hz": NaN, "zeta": 0.1}]}', "must be finite"),
            ('{"modes": [{"frequency_hz": 2, "zeta": 1.5}]}', "zeta = 1.5 between -1 and 1"),
            ('{"modes": [{"frequency_hz": 2, "wn_rad_per_s": 2, "zeta": 0}]}', "frequency_hz = 2 contradicts"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8], "zeta": 0.5}]}', "zeta = 0.5 contradicts the other keys.* 0.6"),
            ('{"modes": [{"pole_rad_per_s": [1]}]}', "must be a real and an imaginary part"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8], "zeta_std": 1}]}', "give both wn_std_rad_per_s and zeta_std"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8], "shape": []}]}', "shape must be a list"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8]}], "covariance": [[1, 2]]}', "square list"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8]}], "covariance": [[1]]}', "covariance has shape"),
            ('{"modes": [{"pole_rad_per_s": [-6, 8]}], "channels": 4}', "must be a list of names"),
        ],
    )
    def test_refusals(self, tmp_path: Path, text: str, message: str) -> None:
        path = tmp_path / "modes.json"
        path.write_text(text)
        with pytest.raises(InputError, match=message) as refusal:
            read_modes(path)
        assert str(refusal.value).startswith(f"{path}: ")


def test_a_gyroscope_is_named_by_a_rate() -> None:
    """The rate of a coordinate is its velocity; a sensor of that name in the car file has its own meaning."""
    car = half_car(
        chassis_mass=1200, pitch_inertia=1800, front_tire_mass=80, rear_tire_mass=90, cg_to_front=1.2, cg_to_rear=1.5,
        front_stiffness=40e3, rear_stiffness=44e3, front_tire_stiffness=400e3, rear_tire_stiffness=400e3,
        front_damping=3e3, rear_damping=3e3,
    )  # fmt: skip
    rate, velocity, bounce = (output_rows(car, [name]) for name in ("pitch_rate", "pitch_velocity", "heave_velocity"))
    assert rate.orders == velocity.orders == 1
    assert rate.coordinates.tolist() == velocity.coordinates.tolist() != bounce.coordinates.tolist()
    own = replace(car, sensors=[Sensor(name="pitch_rate", motion="velocity", of="heave")])
    assert output_rows(own, ["pitch_rate"]).coordinates.tolist() == bounce.coordinates.tolist()
