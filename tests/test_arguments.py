"""Every public function, called with what it cannot take: the error names the argument, and never is a raw one."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.typing import ArrayLike

import suspid
from suspid import InputError, ModalSet, SuspidError
from suspid.arguments import explained, fits, hints

VERBS = [name for name in suspid.__all__ if inspect.isfunction(getattr(suspid, name))]
# Calls that are right in spite of it: cars of springs of 5 N/m, a road of 5 m3, trends of no drives.
RIGHT = {"quarter_car", "half_car", "full_car", "road", "damper_trends"}


class Stranger:
    """What no function takes."""


def senseless() -> list[object]:
    """Return values of the types that are given by mistake; pandas is there where fleets are used."""
    values: list[object] = [None, 5, -1, float("nan"), "x", b"x", [], {}, object(), Stranger(), [Stranger()]]
    try:
        import pandas as pd
    except ImportError:
        return values
    return [*values, pd.DataFrame({"a": ["x", "y"]})]


def called(verb: Callable[..., object], value: object) -> None:
    """Call a function with the value in the place of all that it needs."""
    parameters = list(inspect.signature(verb).parameters.values())
    needed = [one for one in parameters if one.default is one.empty]
    named = {one.name: value for one in needed if one.kind is one.KEYWORD_ONLY}
    verb(*[value for one in needed if one.kind is not one.KEYWORD_ONLY], **named)


@pytest.mark.parametrize("name", VERBS)
def test_no_function_fails_with_a_raw_error(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    refused = 0
    for value in senseless():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                called(getattr(suspid, name), value)
            except SuspidError:
                refused += 1
            else:
                assert name in RIGHT, f"{name} takes {value!r:.60}"
    assert refused > len(senseless()) / 2


@pytest.mark.parametrize("name", VERBS)
def test_every_function_explains_its_arguments(name: str) -> None:
    verb = getattr(suspid, name)
    assert inspect.unwrap(verb) is not verb, f"{name} is not @explained"
    known = hints(verb)
    parameters = inspect.signature(verb).parameters
    assert set(parameters) <= set(known)
    # What is given by default is of the annotated type: no annotation is misread.
    for parameter in parameters.values():
        if parameter.default is not parameter.empty:
            assert fits(parameter.default, known[parameter.name]), f"{name}: {parameter}"


CAR = suspid.quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
)
DECAY = suspid.free_decay(CAR, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
MODES = suspid.eigenmodes(CAR)


@pytest.mark.parametrize(
    ("verb", "given", "named", "message"),
    [
        ("statespace", [CAR], {"outputs": 5}, "outputs=5 is an int where"),
        ("simulate", [CAR, [0, 1], {}], {"initial_state": "x"}, "initial_state='x' is a str where"),
        ("reconstruct", [MODES, CAR], {"bounds": 5}, "bounds=5 is an int where"),
        ("reconstruct", [MODES, CAR], {"penalty": "x"}, "penalty='x' is a str where"),
        ("estimate", [DECAY, CAR], {"fixed": [5]}, r"fixed=\[5\] is a list where"),
        ("identify", [DECAY], {"candidates": None}, "candidates=None is a NoneType where iterable of float is"),
        ("cwt", [DECAY], {"omega": [Stranger()]}, "omega=… is a list where"),
        ("cwt", [DECAY], {"normalization": "x"}, "must be one of 'paper', 'amplitude'"),
        ("scaled", [DECAY, 5], {}, "factors=5 is an int where mapping of str to float is"),
        ("read_car", [5], {}, "path=5 is an int where"),
        ("to_si", [[1.0], None], {}, "unit=None is a NoneType where str is"),
        ("weighting", [5, [1.0]], {}, "name=5 is an int where str is"),
        ("find_decays", [DECAY], {"given": 5}, "given=5 is an int where"),
        ("find_drives", [DECAY], {"channels": []}, "channels is empty"),
        ("damper_trends", [["x"]], {}, r"drives=\['x'\] is a list where iterable of"),
    ],
)  # fmt: skip
def test_an_argument_is_named_with_what_is_needed(
    verb: str, given: Sequence[object], named: Mapping[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        getattr(suspid, verb)(*given, **named)


class TestExplained:
    def test_an_error_of_its_own_is_left_alone(self) -> None:
        @explained
        def half(value: float, names: Sequence[str] = ()) -> float:
            raise ZeroDivisionError(value, names)

        with pytest.raises(ZeroDivisionError):
            half(1.0)
        with pytest.raises(InputError, match="names=5 is an int"):
            half(1.0, names=5)  # type: ignore[arg-type]

    def test_what_works_is_never_refused(self) -> None:
        @explained
        def same(value: float) -> float:
            return value

        assert same("x") == "x"  # type: ignore[arg-type, comparison-overlap]

    def test_a_method_explains_its_arguments(self) -> None:
        with pytest.raises(InputError, match="wn='x' is a str where"):
            ModalSet.from_wn_zeta("x", [0.1])  # type: ignore[arg-type]

    def test_a_call_of_another_form_is_told_by_python(self) -> None:
        with pytest.raises(TypeError, match="missing 1 required positional argument"):
            suspid.eigenmodes()  # type: ignore[call-arg]
        with pytest.raises(TypeError, match="unexpected keyword argument 'chanel'"):
            suspid.identify([0.0], chanel="seat")  # type: ignore[call-arg]

    def test_types(self) -> None:
        assert fits(np.float64(1), float)
        assert fits(np.int64(1), int)
        assert not fits(True, float)
        assert not fits(1.5, int)
        assert fits("a", Literal["a", "b"])
        assert not fits(np.ones(2), Literal["a", "b"])
        assert fits([[1.0], [2.0]], ArrayLike)
        assert not fits([Stranger()], ArrayLike | None)
        assert fits((1.0, 2.0), tuple[float, float])
        assert not fits((1.0,), tuple[float, float])
        assert fits({"a": 1}, Mapping[str, float])
        assert not fits({"a": "b"}, Mapping[str, float])
        assert fits(iter(["a"]), Sequence[str] | object)


def test_an_unknown_argument_is_refused_with_the_name_of_the_function() -> None:
    with pytest.raises(TypeError, match=r"free_decay\(\) got an unexpected keyword argument 'outputs'"):
        suspid.free_decay(outputs=["seat"])  # type: ignore[call-arg]
