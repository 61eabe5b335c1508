"""Estimates as JSON, read back."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from suspid import Estimate, InputError, add_noise, estimate, free_decay, grip, quarter_car, read_estimate, ride
from suspid.identification import to_json
from suspid.reporting import content_of, estimate_from_dict, estimate_to_dict, json_schema, report_to_dict
from suspid.words import EstimateCheck


@pytest.fixture(scope="module")
def found() -> Estimate:
    car = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    ).with_parameters(mount_stiffness={"chassis": 5e5})
    decay = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    noisy = add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1))
    return estimate(
        noisy, car.with_parameters(damping={"chassis": 1300}), fixed=["tire.damping"], mounts=["chassis"],
        bounds={"chassis.damping": (100, 5000)}, nominal_std={"tire.stiffness": 0.1},
    )  # fmt: skip


@pytest.fixture
def content(found: Estimate) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(to_json(estimate_to_dict(found)))
    return plain


class TestRoundTrip:
    def test_every_bit_but_the_records(self, found: Estimate, content: dict[str, Any], tmp_path: Path) -> None:
        path = tmp_path / "found.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        back = read_estimate(path)
        assert (back.suspension, back.nominal, back.parameters) == (found.suspension, found.nominal, found.parameters)
        for name in ("values", "covariance", "ranges"):
            np.testing.assert_array_equal(getattr(back, name), getattr(found, name))
        np.testing.assert_array_equal(back.modes.poles, found.modes.poles)
        assert back.verdict.to_dict() == found.verdict.to_dict()
        assert str(back) == str(found)
        assert back.interval(0.9) == found.interval(0.9)
        again = estimate_to_dict(back)
        assert again.pop("records") == []
        content.pop("records")
        assert json.loads(to_json(again)) == content

    @pytest.mark.parametrize("level", [0.3, 0.5, 0.99, 0.9999])
    def test_intervals_and_significance_are_those_of_the_level(self, found: Estimate, level: float) -> None:
        rows: Any = estimate_to_dict(found, level=level)["parameters"]
        ends = json.loads(to_json({"ends": found.interval(level)}))["ends"]
        assert {row["name"]: [row["lower"], row["upper"]] for row in rows} == ends
        assert {row["name"] for row in rows if row["significant"]} == found.beyond_chance(level)

    def test_within_a_report(self, found: Estimate, content: dict[str, Any]) -> None:
        report = {"format": "suspid modes 1", "report": "suspid report 3"}
        assert estimate_from_dict({**report, "estimate": content}).suspension == found.suspension
        with pytest.raises(InputError, match="no springs and dampers that were fitted"):
            estimate_from_dict({**report, "estimate": None})

    def test_what_the_page_shows_of_the_car(self, found: Estimate) -> None:
        """The JSON of a page is that of the estimate, with grip, ride and what moves them, and is read back."""
        driven = ride(found, road="C", speed=20.0)
        content = report_to_dict(content_of(found, ride=driven))
        jsonschema.validate(content, json_schema("estimate"))
        assert content["grip"]["wheels"][0]["phase_rad"] == grip(found).phase[0]  # type: ignore[index]
        assert content["ride"]["figures"][0]["value"] == driven.values[0]  # type: ignore[index]
        assert "tire.phase" in content["sensitivities"]["names"]  # type: ignore[index]
        assert estimate_from_dict(content).suspension == found.suspension

    def test_details_of_an_estimate_without_records(self, content: dict[str, Any]) -> None:
        assert "lag-1" in estimate_from_dict(content).details()

    def test_codes_of_another_version_keep_their_sentence(self, content: dict[str, Any]) -> None:
        content["verdict"]["checks"][0] |= {"code": "of 2031", "text": "A sentence of 2031."}
        check = estimate_from_dict(content).verdict.checks[0]
        assert (check.remark.code, str(check)) == (EstimateCheck.SAID, "A sentence of 2031.")


class TestRefusals:
    def test_files(self, tmp_path: Path) -> None:
        path = tmp_path / "found.json"
        for text, words in (("[]", "JSON object"), ("{", "is not JSON"), ("{}", "format None")):
            path.write_text(text, encoding="utf-8")
            with pytest.raises(InputError, match=f"found.json: .*{words}"):
                read_estimate(path)
        with pytest.raises(InputError, match="no such file"):
            read_estimate(tmp_path / "none.json")

    @pytest.mark.parametrize("name", ["parameters", "covariance", "car", "held", "modes", "verdict", "alternatives"])
    def test_what_is_missing_or_of_another_kind(self, content: dict[str, Any], name: str) -> None:
        for broken in ({k: v for k, v in content.items() if k != name}, {**content, name: 7}):
            with pytest.raises(InputError):
                estimate_from_dict(broken)

    def test_a_car_that_was_edited(self, content: dict[str, Any]) -> None:
        content["car"]["nominal"] = content["car"]["nominal"].replace("1300.0", "1400.0")
        with pytest.raises(InputError, match="SHA-256"):
            estimate_from_dict(content)

    def test_parameters_that_are_not_those_of_the_car(self, content: dict[str, Any]) -> None:
        content["parameters"][0]["value"] *= 1.01
        with pytest.raises(InputError, match="in the car"):
            estimate_from_dict(content)

    def test_a_covariance_with_holes(self, content: dict[str, Any]) -> None:
        content["covariance"][0][0] = None
        with pytest.raises(InputError, match="covariance"):
            estimate_from_dict(content)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (lambda c: c["covariance"][0].__setitem__(0, -1.0), "negative variance"),
            (lambda c: c["covariance"][0].__setitem__(1, 1e9), "not symmetric"),
            (lambda c: c.__setitem__("covariance", [c["covariance"][0]]), "the shape"),
            (lambda c: c["parameters"][0].__setitem__("std", -1.0), "standard deviation"),
            (lambda c: c["parameters"][-1].__setitem__("value", -5.0), "bounds"),
            (lambda c: c["parameters"][-1].__setitem__("value", None), "bounds"),
            (lambda c: c["parameters"][1].__setitem__("name", c["parameters"][0]["name"]), "twice"),
            (lambda c: c["car"].__setitem__("found", c["car"]["found"].replace("40.0", "41.0")), "not estimated"),
            (lambda c: c.__setitem__("freedom", float("inf")), "infinity"),
            (lambda c: c.__setitem__("freedom", -5), "freedom = -5 must be 0 or more"),
            (lambda c: c.__setitem__("chi_square", -5.0), "chi_square = -5.0 must be 0 or more"),
            (lambda c: c.__setitem__("explains", "no"), "true or false"),
        ],
    )
    def test_parts_that_were_changed_by_hand(self, content: dict[str, Any], change: Any, words: str) -> None:
        change(content)
        with pytest.raises(InputError, match=words):
            estimate_from_dict(content)

    def test_a_covariance_that_is_none(self, content: dict[str, Any]) -> None:
        stds = np.array([row["std"] for row in content["parameters"]])
        content["covariance"] = (np.outer(stds, stds) * (2 - np.eye(len(stds)))).tolist()
        with pytest.raises(InputError, match="not positive"):
            estimate_from_dict(content)
