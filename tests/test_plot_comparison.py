"""Before against after: what is drawn are the values and intervals of the two results."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

from suspid import InputError, ModalSet, add_noise, estimate, free_decay, plot_comparison, quarter_car, write_modes
from suspid.cli.main import main
from suspid.reporting.plot_comparison import _parameters

OLD = ModalSet.from_wn_zeta([10.0, 50.0], [0.3, 0.2], wn_std=[0.1, 1.0], zeta_std=[0.01, 0.02])
NEW = ModalSet.from_wn_zeta([10.1, 49.0], [0.2, 0.19], wn_std=[0.2, 1.0], zeta_std=[0.01, 0.02])


def drawn(figure: Figure, panel: int) -> list[tuple[float, ...]]:
    """Return the ends of the intervals, in the order in which they are drawn."""
    every = [tuple(np.asarray(line.get_xdata(), float).tolist()) for line in figure.axes[panel].lines]
    return [ends for ends in every if len(set(ends)) == 2]


def test_modes_with_the_intervals_of_both() -> None:
    figure = Figure()
    plot_comparison(OLD, NEW, figure)
    frequency, damping = drawn(figure, 0), drawn(figure, 1)
    # Normal intervals of 95 %: 1.96 standard deviations, in percent of the value before.
    assert frequency[0] == pytest.approx((-1.96, 1.96), abs=1e-3)
    assert frequency[2] == pytest.approx((1 - 3.92, 1 + 3.92), abs=1e-3)
    assert damping[2] == pytest.approx((-100 / 3 - 6.533, -100 / 3 + 6.533), abs=1e-3)


def test_modes_of_one_damping_ratio_keep_their_own_intervals() -> None:
    alike = ModalSet.from_wn_zeta([10.0, 40.0], [0.3, 0.3], wn_std=[0.1, 1.0], zeta_std=[0.01, 0.05])
    figure = Figure()
    plot_comparison(alike, alike, figure)
    widths = [high - low for low, high in drawn(figure, 1)]
    # Twice 1.96 standard deviations, in percent of the value: of modes 1 and 2 before, then after.
    assert widths == pytest.approx([13.07, 65.33] * 2, abs=0.01)


def test_exact_modes_are_points_and_modes_without_a_partner_left_out() -> None:
    figure = Figure()
    plot_comparison(ModalSet.from_wn_zeta([10.0], [0.3]), NEW, figure)
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["mode 1"]
    assert len(drawn(figure, 0)) == 1


def test_parameters_of_two_estimates() -> None:
    car = quarter_car(
        chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
    )
    found = []
    for damping in (1300, 800):
        worn = car.with_parameters(damping={"chassis": damping})
        decay = free_decay(worn, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
        found.append(estimate(add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1)), car, fixed=["tire.damping"]))
    figure = Figure()
    plot_comparison(found[0], found[1], figure)
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    # A share of what was not known from zero says nothing, and would hide the others.
    loose = replace(
        found[0], covariance=found[0].covariance * np.outer(*[np.where(found[0].values > 1e4, 1.0, 1e4)] * 2)
    )
    assert "chassis.damping" not in {row.name for row in _parameters(loose, found[1], 0.95)}
    low, high = drawn(figure, 0)[len(names) + names.index("chassis.damping")]
    assert low < 100 * (800 / 1300 - 1) < high
    # An interval ends where the bound of an estimate does.
    at = found[0].parameters.index("chassis.damping")
    ranges = found[0].ranges.copy()
    ranges[at, 1] = found[0].values[at] + 0.1 * found[0].std[at]
    bound = replace(found[0], ranges=ranges)
    (row,) = (row for row in _parameters(bound, bound, 0.95) if row.name == "chassis.damping")
    assert row.before[2] == bound.interval(0.95)["chassis.damping"][1] == ranges[at, 1]
    with pytest.raises(InputError, match="not Estimate and ModalSet"):
        plot_comparison(found[0], found[1].modes, Figure())


def test_the_command_draws_modes(tmp_path: Path) -> None:
    write_modes(OLD, tmp_path / "old.json")
    write_modes(NEW, tmp_path / "new.json")
    asked = ["compare", str(tmp_path / "old.json"), str(tmp_path / "new.json"), "--plot", str(tmp_path / "p.svg")]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 0, done.output
    assert (tmp_path / "p.svg").stat().st_size > 5000
