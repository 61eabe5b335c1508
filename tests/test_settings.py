"""Settings refuse at once what cannot be meant, and stay frozen values."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from suspid import CarSettings, InputError, Settings, analyse, free_decay, write_record
from suspid.records import as_response
from validation import cars

NAN, INF = float("nan"), float("inf")
WRONG: list[dict[str, Any]] = [
    {"channels": (1,)},
    {"channels": "seat"},
    {"channels": ()},
    {"channels": ("seat", "seat")},
    {"channels": {"seat"}},
    {"without": None},
    {"without": "seat"},
    {"rename": {"seat": 1}},
    {"rename": "seat"},
    {"rename": None},
    {"rename": (("seat", "a"), ("seat", "b"))},
    {"scale": None},
    {"scale": {"seat": "2"}},
    {"scale": {"seat": 2j}},
    {"scale": {"seat": 0.0}},
    {"scale": {"seat": NAN}},
    {"scale": (("seat", 1.0), ("seat", 2.0))},
    {"vertical": "xyz"},
    {"vertical": ("x", "y")},
    {"vertical": ("x", "y", "y")},
    {"si": "no"},
    {"time": 1},
    {"fs": "200"},
    {"fs": 0},
    {"fs": -1},
    {"fs": NAN},
    {"fs": True},
    {"dbc": 3},
    {"start": "1"},
    {"start": 1j},
    {"start": NAN},
    {"stop": INF},
    {"start": 2.0, "stop": 2.0},
    {"start": 3.0, "stop": 2.0},
    {"decay": True},
    {"decay": "al"},
    {"decay": 0},
    {"decay": 1.5},
    {"decay": "all", "start": 1.0},
    {"decay": "all", "method": "ridge"},
    {"modes": 2.5},
    {"modes": "2"},
    {"modes": True},
    {"modes": 0},
    {"method": "magic"},
    {"method": ["ridge"]},
    {"band_hz": (1.0,)},
    {"band_hz": (1.0, 2.0, 3.0)},
    {"band_hz": (5.0, 2.0)},
    {"band_hz": ()},
    {"band_hz": "ab"},
    {"band_hz": ("1", "2")},
    {"bandwidth": 0.0},
    {"candidates": "12"},
    {"candidates": ()},
    {"candidates": (1.0, -2.0)},
    {"level": "x"},
    {"level": None},
    {"level": 1.0},
    {"springs": None},
    {"springs": {"fixed": ("seat",)}},
]
WRONG_SPRINGS: list[dict[str, Any]] = [
    {"fixed": "seat"},
    {"fixed": (1,)},
    {"fixed": ("seat", "seat")},
    {"bounds": None},
    {"bounds": {"tire.stiffness": 1.0}},
    {"bounds": {"tire.stiffness": (2.0, 1.0)}},
    {"bounds": {"tire.stiffness": (INF, None)}},
    {"bounds": {"tire.stiffness": ("1", "2")}},
    {"ties": ("front.stiffness", "rear.stiffness")},
    {"ties": (("front.stiffness",),)},
    {"nominal_std": -1},
    {"nominal_std": {"tire.stiffness": 0.0}},
    {"free_masses": "seat"},
    {"added_masses": {"seat": -1.0}},
    {"added_masses": None},
    {"tolerance": -1},
    {"tolerance": NAN},
    {"search": "no"},
    {"constraints": "tire.stiffness >= 1"},
    {"constraints": (1,)},
]


def label(wrong: dict[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in wrong.items())


@pytest.mark.parametrize("wrong", WRONG, ids=label)
def test_what_cannot_be_meant_is_refused_by_name(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        Settings(**wrong)


@pytest.mark.parametrize("wrong", WRONG_SPRINGS, ids=label)
def test_of_springs_as_well(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        CarSettings(**wrong)


def test_numbers_of_numpy_and_lists_are_taken() -> None:
    given = Settings(
        channels=["seat"],  # type: ignore[arg-type]
        scale={"seat": np.float32(2)},  # type: ignore[dict-item]
        decay=int(np.int64(1)),
        modes=np.int64(2),  # type: ignore[arg-type]
        band_hz=np.array([1.0, 2.0]),  # type: ignore[arg-type]
        si=np.bool_(False),  # type: ignore[arg-type]
        candidates=range(1, 4),  # type: ignore[arg-type]
    )
    same = Settings(channels=("seat",), scale={"seat": 2.0}, decay=1, modes=2, band_hz=(1, 2), candidates=(1, 2, 3))
    assert given == same
    assert hash(given) == hash(same)
    assert Settings(decay=np.int64(1)) == Settings(decay=1)  # type: ignore[arg-type]


def test_they_are_values() -> None:
    springs = CarSettings(bounds={"tire.stiffness": (None, INF)}, nominal_std={"tire.mass": 0.1}, ties=[["a", "b"]])  # type: ignore[arg-type]
    given = Settings(rename=(("a", "b"),), scale={"b": 2}, springs=springs)
    assert len({given, pickle.loads(pickle.dumps(given)), Settings()}) == 2
    assert dict(given.rename) == {"a": "b"}
    plain = json.loads(json.dumps(given.to_dict()))
    assert plain["scale"] == {"b": 2.0}
    assert plain["springs"]["bounds"] == {"tire.stiffness": [None, None]}
    with pytest.raises(TypeError):
        given.scale["b"] = 3.0  # type: ignore[index]


def test_a_mapping_is_no_settings() -> None:
    record = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
    with pytest.raises(InputError, match=r"Settings\(modes=1\)"):
        analyse(record, settings={"modes": 1})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="car"):
        analyse(record, car="car.toml")  # type: ignore[arg-type]


class TestOnAResponse:
    RECORD = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})

    @pytest.mark.parametrize("clock", [{"fs": 100.0}, {"time": "t"}, {"dbc": "a.dbc"}], ids=label)
    def test_its_clock_is_its_own(self, clock: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=f"a response has .*; leave {next(iter(clock))} out"):
            analyse(self.RECORD, settings=Settings(**clock))

    def test_one_channel_by_two_names_is_refused(self) -> None:
        record = as_response(np.arange(100) / 10, np.ones((2, 100)), ["seat [mm]", "tire"])
        with pytest.raises(InputError, match="requested twice"):
            analyse(record, settings=Settings(channels=("seat", "seat [mm]")))

    def test_leaving_out_every_channel(self) -> None:
        with pytest.raises(InputError, match="leaves no channel; keep at least one of 'chassis'"):
            analyse(self.RECORD, settings=Settings(channels=("chassis",), without=("chassis",)))

    def test_an_imaginary_part_is_not_lost(self) -> None:
        made = control.TimeResponseData(
            time=np.arange(100) / 10, outputs=np.full((1, 100), 1j), output_labels=["a"], issiso=True
        )
        with pytest.raises(InputError, match="complex"):
            analyse(made)


@pytest.mark.parametrize(
    ("springs", "message"),
    [
        (CarSettings(fixed=("nope",)), "no strut parameter 'nope'"),
        (CarSettings(free_masses=("nope",)), "no mass 'nope'"),
        (CarSettings(added_masses={"nope": 1.0}), "no mass 'nope'"),
        (CarSettings(bounds={"nope.stiffness": (1.0, 2.0)}), "no parameter 'nope.stiffness'"),
        (CarSettings(fixed=("tire",), bounds={"tire.stiffness": (1.0, 2.0)}), "is fixed"),
        (CarSettings(ties=(("tire.stiffness", "tire.damping"),)), "of one kind"),
    ],
)
def test_mistakes_about_the_car_come_before_the_record_is_read(springs: CarSettings, message: str) -> None:
    with pytest.raises(InputError, match=message):
        analyse("no such file.csv", car=cars.PAPER, settings=Settings(springs=springs))


def test_a_stretch_beyond_the_end_names_the_end(tmp_path: Path) -> None:
    write_record(TestOnAResponse.RECORD, tmp_path / "r.csv")
    for source in (tmp_path / "r.csv", TestOnAResponse.RECORD):
        with pytest.raises(InputError, match=r"0 samples from 20 s on; it lasts from 0 to 4\.998 s"):
            analyse(source, settings=Settings(start=20.0))
