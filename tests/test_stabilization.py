"""Stabilisation: poles that stay are the modes of the car, poles that wander are noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from suspid import InputError, add_noise, eigenmodes, free_decay, identify, plot_stabilization, stabilization
from suspid.records import as_response
from validation import cars

TIMES = np.arange(0, 10, 0.005)


def stays(wn: float, found: object) -> int:
    """Return at how many orders a stable pole stands within 1 % of a frequency."""
    return sum(
        bool(np.any(zeta & (np.abs(np.abs(poles) / wn - 1) < 0.01)))
        for poles, zeta in zip(found.poles, found.stable_zeta, strict=True)  # type: ignore[attr-defined]
    )


class TestPoles:
    def test_without_noise_every_order_from_that_of_the_car_on_has_its_modes(self) -> None:
        exact = eigenmodes(cars.PAPER)
        found = stabilization(free_decay(cars.PAPER, TIMES, initial_state={"v_tire": 1.0}), most=8)
        poles = found.poles[found.orders.index(6)]
        assert np.abs(poles) == pytest.approx(exact.wn, rel=1e-4)
        assert -poles.real / np.abs(poles) == pytest.approx(exact.zeta, rel=1e-2)

    def test_in_noise_the_modes_stay_and_the_rest_wanders(self) -> None:
        exact = eigenmodes(cars.PAPER)
        record = free_decay(cars.PAPER, TIMES, initial_state={"v_tire": 1.0})
        found = stabilization(add_noise(record, snr_db=20.0, rng=np.random.default_rng(3)), most=30)
        for wn in exact.wn:
            assert stays(float(wn), found) >= 10
        far = [wn for wn in np.geomspace(5.0, 500.0, 40) if np.min(np.abs(np.log(wn / exact.wn))) > 0.05]
        assert np.median([stays(float(wn), found) for wn in far]) == 0

    def test_thinning_keeps_the_modes(self) -> None:
        record = free_decay(cars.PAPER, np.arange(0, 10, 0.001), initial_state={"v_tire": 1.0})
        found = stabilization(record, most=8, highest_hz=40.0)
        assert np.abs(found.poles[-1][found.stable_zeta[-1]])[:3] == pytest.approx(eigenmodes(cars.PAPER).wn, rel=1e-3)

    def test_too_short_a_record_is_refused(self) -> None:
        with pytest.raises(InputError, match="at most=2"):
            stabilization(as_response(TIMES, np.exp(-TIMES)[None], ["y"]), most=2)


class TestPicture:
    def test_the_spectrum_behind_a_diagram_peaks_at_the_modes(self) -> None:
        exact = eigenmodes(cars.PAPER)
        found = stabilization(free_decay(cars.PAPER, TIMES, initial_state={"v_tire": 1.0}), most=6, highest_hz=20.0)
        inner = found.decibel[1:-1]
        peaks = found.hertz[1:-1][(inner > found.decibel[:-2]) & (inner > found.decibel[2:]) & (inner > -40)]
        line = 1 / (TIMES[-1] + TIMES[1])
        assert peaks == pytest.approx(exact.wn * np.sqrt(1 - exact.zeta**2) / (2 * np.pi), abs=line)
        assert found.hertz[-1] <= 20.0
        assert found.decibel.max() == 0

    def test_damping_stands_below_the_diagram_on_the_same_frequencies(self) -> None:
        found = stabilization(free_decay(cars.PAPER, TIMES, initial_state={"v_tire": 1.0}), most=8)
        axes = found.plot().figure.axes
        lower = next(ax for ax in axes if ax.get_ylabel() == "damping ratio [1]")
        assert lower.get_xlim() == axes[0].get_xlim()
        drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in lower.lines])
        assert np.min(np.abs(drawn[:, None] - eigenmodes(cars.PAPER).zeta), axis=0) == pytest.approx(0, abs=1e-4)

    def test_a_line_marks_each_mode_and_the_numbers_are_those_of_the_poles(self) -> None:
        record = add_noise(
            free_decay(cars.PAPER, TIMES, initial_state={"v_tire": 1.0}), snr_db=30.0, rng=np.random.default_rng(1)
        )
        found = identify(record)
        ax = plot_stabilization(found, Figure().subplots(), most=10)
        lines = {line.get_label(): np.asarray(line.get_xdata(), float) for line in ax.lines}
        marks = sorted(float(line.get_xdata()[0]) for line in ax.lines if len(line.get_xdata()) == 2)  # type: ignore
        assert marks == pytest.approx(found.modes.wn / (2 * np.pi))
        stable = np.unique(np.round(lines["and damping"], 1))
        assert set(np.round(marks, 1)) <= set(stable)
        assert plot_stabilization(stabilization(record, most=6), Figure().subplots()).get_ylim()[1] == 8


@pytest.mark.parametrize(
    "setting", [{"highest_hz": 0}, {"highest_hz": -1.0}, {"highest_hz": np.nan}, {"highest_hz": "3"}, {"most": None}]
)
def test_settings_that_are_no_such_numbers_are_refused(setting: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(setting))):
        stabilization(
            as_response(
                np.asarray(np.arange(100) / 100, float), np.asarray([np.cos(np.arange(100.0))], float), ["seat"]
            ),
            **setting,
        )


@pytest.mark.filterwarnings("error")
def test_real_roots_are_no_poles() -> None:
    found = stabilization(
        as_response(
            np.asarray(np.arange(100) / 100, float), np.asarray([[(-1.0) ** k for k in range(100)]], float), ["seat"]
        )
    )
    assert not any(len(poles) for poles in found.poles)
