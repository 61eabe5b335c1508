"""Tables of text: they fit a terminal, and numbers have the digits that their uncertainty leaves."""

import numpy as np
import pytest

from suspid import grip, quarter_car, ride, sensitivities, tune
from suspid.records import as_response
from suspid.text_tables import TERMINAL, figures_of, rounded, spread, text_table, value_columns
from suspid.units import in_print
from validation.cars import FOUR_WHEELS, TWO_AXLES

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)


def table_of(result: object) -> list[str]:
    return str(result).partition("\nVerdict")[0].split("\n")


class TestWidth:
    def test_tables_of_cars_fit_a_terminal(self) -> None:
        shown = [
            ride(TWO_AXLES, road="C", speed=20.0),
            grip(TWO_AXLES, nominal_std=1e-4),
            sensitivities(FOUR_WHEELS),
            tune(CAR, road="C", speed=20.0, points=2),
        ]
        for one in shown:
            assert max(map(len, table_of(one))) <= TERMINAL

    def test_every_cell_is_kept(self) -> None:
        """What is cut into parts holds every cell, and the first column in every part."""
        columns = {"car": ["1", "2"]} | {f"{'abc'[k % 3]}.damping{k}": [f"x{k}", f"y{k}"] for k in range(12)}
        text = text_table(columns, widest=40)
        parts = text.split("\n\n")
        assert len(parts) > 1
        assert all([line.split()[0] for line in part.split("\n")[-2:]] == ["1", "2"] for part in parts)
        given = [cell for name, cells in columns.items() if name != "car" for cell in cells]
        heads = [word for k in range(12) for word in (f"{'abc'[k % 3]}.", f"damping{k}")]
        words = [word for word in text.split() if set(word) != {"-"}]
        assert sorted(words) == sorted([*given, *heads, *["1", "2", "car"] * len(parts)])

    def test_a_narrow_table_is_as_it_was(self) -> None:
        columns = {"car": ["1"], "seat.damping [N s/m]": ["900"]}
        assert text_table(columns, widest=TERMINAL) == text_table(columns)

    def test_a_margin_stands_in_the_heading(self) -> None:
        given = {"parameters": ["chassis.damping"], "road": "C", "speed": 20.0, "points": 2}
        found = tune(CAR, **given, robust=1.5, nominal_std=0.05)  # type: ignore[arg-type]
        assert "mean + 1.5 sd" in str(found)
        assert "mean" not in str(tune(CAR, **given)).partition("\nVerdict")[0]  # type: ignore[arg-type]


class TestNumbers:
    @pytest.mark.parametrize(
        ("value", "std", "shown"),
        [
            (8.2e-9, 1.1e-8, ("8e-09", "1.1e-08")),
            (3.2e-9, 1.1e-11, ("3.200e-09", "1.1e-11")),
            (0.61049, 0.0123, ("0.610", "0.012")),
            (66.0683, 5e-5, ("66.068300", "5.0e-05")),
            (26.18, 0.0, ("26.18", "0")),
            (4.724, np.nan, ("4.724", "–")),
            (np.nan, np.nan, ("–", "–")),
            (1234.5, 35.0, ("1234", "35")),
        ],
    )
    def test_value_and_spread(self, value: float, std: float, shown: tuple[str, str]) -> None:
        beside = value_columns(np.array([value, 1.0]), np.array([std, 1.0]))
        assert (beside["value"][0], beside["±"][0]) == shown

    def test_spread_has_the_digits_of_the_value(self) -> None:
        """The last digit of a value is that of the second digit of its spread, whatever the size."""
        for exponent in range(-12, 4):
            value, std = 3.2222222 * 10.0**exponent, 1.4e-3 * 10.0**exponent
            text = rounded(np.array([value]), np.array([std]))[0]
            assert abs(float(text) - value) <= 0.5001e-4 * 10.0**exponent
            assert float(spread(std)) == pytest.approx(std, rel=0.05)

    def test_no_exponent_near_one(self) -> None:
        assert [figures_of(x) for x in (50000.0, 1.198e5, 0.00123, -3.0)] == ["50000", "119800", "0.00123", "-3"]

    def test_units_in_print(self) -> None:
        assert in_print("a [m/s2] 2.5 m/s1.5; rad/s2") == "a [m/s²] 2.5 m/s¹·⁵; rad/s²"
        assert in_print("256e-6 m3, 1800 kg m2, ISO 8608") == "256e-6 m³, 1800 kg m², ISO 8608"


class TestBands:
    def test_bands_of_spectra_equal_finite_differences(self) -> None:
        stds = {"chassis.damping": 0.05, "tire.stiffness": 0.03}
        found = ride(CAR, road="C", speed=20.0, nominal_std=stds)
        variance = np.zeros_like(found.density)
        for name, std in stds.items():
            owner, _, quantity = name.rpartition(".")
            value, h = getattr(next(s for s in CAR.struts if s.name == owner), quantity), 1e-4
            ends = [
                ride(CAR.with_parameters(**{quantity: {owner: value * f}}), road="C", speed=20.0).density
                for f in (1 - h, 1 + h)
            ]
            variance = variance + ((ends[1] - ends[0]) / (2 * h) * std) ** 2
        np.testing.assert_allclose(found.density_band, np.sqrt(variance), rtol=1e-4)
        assert not np.any(ride(CAR, road="C", speed=20.0).density_band)

    def test_bands_of_a_record_are_its_scatter(self) -> None:
        """Of white noise: the scatter over records is what one record states."""
        t, rng = np.arange(0, 20, 0.005), np.random.default_rng(1)
        drawn = [ride(as_response(t, rng.normal(size=(1, t.size)), ["seat_acceleration"])) for _ in range(60)]
        density = np.array([one.density[0, 2:-2] for one in drawn])
        stated = np.mean([one.density_band[0, 2:-2] for one in drawn], axis=0)
        ratio = np.sqrt(np.mean(np.var(density, axis=0, ddof=1)) / np.mean(stated**2))
        # 60 records of some hundred nearly independent lines know it to two per cent.
        assert ratio == pytest.approx(1.0, abs=0.06)
