"""Every result shows itself: text, table, picture, notebook cell."""

from __future__ import annotations

import base64
import re
from typing import Any

import control
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import suspid
from suspid import (
    BodyMode,
    BodyModes,
    Limit,
    ModalSet,
    RawChannel,
    Recording,
    Strut,
    Suspension,
    add_noise,
    analyse,
    analyse_drive,
    as_record,
    best_bandwidth,
    check_limits,
    classify_road,
    clean,
    compare,
    cwt,
    damper_curve,
    damper_trends,
    eigenmodes,
    estimate,
    find_decays,
    find_drives,
    find_ridges,
    free_decay,
    grip,
    identify,
    identify_repeats,
    reconstruct,
    ride,
    road,
    road_profile,
    sensitivities,
    simulate,
    stabilization,
    tune,
    tune_active,
    tune_damper,
    wear,
)
from suspid.errors import InputError
from suspid.records import as_response
from suspid.results import Result
from suspid.text_tables import TERMINAL
from validation import cars

mpl.use("Agg")
pytest.importorskip("pandas")
pyplot: Any = pytest.importorskip("matplotlib.pyplot")
RECORD = add_noise(
    free_decay(cars.PAPER, np.arange(0, 5, 0.005), initial_state={"v_tire": 1.0}),
    snr_db=30.0,
    rng=np.random.default_rng(1),
)
DRAWN = {
    "modes",
    "poles",
    "identification",
    "repeats",
    "analysis",
    "estimate",
    "grip",
    "ride",
    "sensitivities",
    "tuning",
    "damper",
    "scalogram",
    "bandwidths",
    "curve",
    "drive",
    "comparison",
    "reconstruction",
    "stabilization",
    "wear",
    "trends",
    "decays",
    "cleaned",
    "stretches",
    "active",
    "body",
    "limits",
    "raw",
    "ridge",
    "road",
}


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    found = identify(RECORD)
    t = np.arange(0, 30, 0.01)
    heights = road_profile(20.0 * t, roughness="B", rng=np.random.default_rng(1))
    shown = ["seat_acceleration", "chassis_acceleration", "tire_acceleration"]
    driven = simulate(cars.HATCHBACK, t, {"road": heights}, outputs=shown)
    driven = add_noise(driven, snr_db=40.0, rng=np.random.default_rng(2))
    recording = Recording(
        title="drive",
        channels=tuple(
            RawChannel(name=name, unit="m/s2", timepts=t, values=row, rate=None)
            for name, row in zip(shown, driven.outputs, strict=True)
        ),
    )
    springs = estimate(RECORD, cars.PAPER)
    return {
        "modes": found.modes,
        "poles": ModalSet.from_wn_zeta([10.0, 70.0], [0.3, 0.2], wn_std=[0.1, 0.5], zeta_std=[0.01, 0.01]),
        "identification": found,
        "repeats": identify_repeats([RECORD, RECORD]),
        "analysis": analyse(RECORD),
        "decays": find_decays(RECORD),
        "decay": find_decays(RECORD)[0],
        "raw": recording,
        "ridge": find_ridges(RECORD)[0],
        "limits": check_limits(
            springs,
            [
                Limit(of=1, quantity="zeta", least=0.5, unit="%"),
                Limit(of=2, quantity="wn", least=7.0 * 2 * np.pi, most=7.9 * 2 * np.pi, unit="Hz"),
                Limit(of="tire", quantity="damping", least=100.0),
            ],
        ),
        "cleaned": clean(recording),
        "stretches": find_drives(recording),
        "body": BodyModes(
            modes=(BodyMode(channel="seat", hertz=1.2, models=((1.15, 0.02), (1.25, 0.02)), zetas=(0.2, 0.4)),),
            seconds=300.0,
        ),
        "comparison": compare(found.modes, eigenmodes(cars.PAPER), rtol=0.05),
        "reconstruction": reconstruct(found.modes, cars.PAPER),
        "estimate": springs,
        "stabilization": stabilization(RECORD, most=8),
        "wear": wear(springs),
        "trends": damper_trends([("van", float(day), springs) for day in range(5)]),
        "grip": grip(cars.HATCHBACK),
        "ride": ride(cars.HATCHBACK, road="C", speed=20.0),
        "sensitivities": sensitivities(cars.HATCHBACK),
        "tuning": tune(cars.HATCHBACK, parameters=["chassis.damping"], objective="tire.load", road="C", speed=20.0),
        "damper": tune_damper(
            cars.HATCHBACK, strut="chassis", roads=[("B", 20.0), ("C", 20.0)], objective="chassis_acceleration.Wk"
        ),
        "active": tune_active(
            cars.HATCHBACK,
            actuator="chassis_travel",
            objective={"chassis_acceleration": 1.0},
            road="C",
            speed=20.0,
            limits={"chassis_travel": 0.02},
        ),
        "road": classify_road(
            road("C", speed=20.0).record(np.arange(0, 20, 0.01), rng=np.random.default_rng(1)), speed=20.0
        ),
        "scalogram": cwt(RECORD, omega=np.geomspace(10, 100, 40), bandwidth=8.0),
        "bandwidths": best_bandwidth(RECORD, omega=np.geomspace(10, 100, 40), candidates=[1, 4, 16]),
        "curve": damper_curve(driven, cars.HATCHBACK, strut="chassis", nodes=4),
        "drive": analyse_drive(recording, car=cars.HATCHBACK),
    }


def test_all_results_are_tried(results: dict[str, Any]) -> None:
    public = {
        one for name in suspid.__all__ if isinstance(one := getattr(suspid, name), type) and issubclass(one, Result)
    }
    # Fleets have tests of their own.
    assert {one.__name__ for one in public} - {type(one).__name__ for one in results.values()} <= {
        "FleetSummary",
    }


def test_a_notebook_cell_has_text_and_picture(results: dict[str, Any]) -> None:
    for name, result in results.items():
        cell = result._repr_html_()
        assert cell.startswith("<pre ")
        pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', cell)
        assert len(pictures) == (name in DRAWN), name
        for picture in pictures:
            assert base64.b64decode(picture).startswith(b"\x89PNG")
            assert len(picture) < 200_000


def test_names_stay_text_in_a_notebook() -> None:
    record = as_response(RECORD.time, np.asarray(RECORD.y), ["<script>", "b", "c"])
    cell = identify(record)._repr_html_()
    assert "<script>" not in cell
    assert isinstance(cell, str)


def test_sentences_are_broken_in_a_notebook_and_tables_are_not(results: dict[str, Any]) -> None:
    lines = results["estimate"]._repr_html_().split("\n")
    assert all(line.startswith('<span style="white-space: pre-wrap">') for line in lines if "note:" in line)
    assert not any("<span" in line for line in lines if "seat.stiffness" in line or "wn [rad/s]" in line)


def test_plots_are_those_of_python_control(results: dict[str, Any]) -> None:
    for name in sorted(DRAWN):
        plot = results[name].plot()
        assert isinstance(plot, control.ControlPlot)
        assert plot.figure.axes
        assert any(ax.get_xlabel() for ax in plot.figure.axes)
        for index, one in np.ndenumerate(plot.axes):
            assert list(plot.lines[index]) == list(one.lines), name
        assert {id(one) for one in plot.axes.flat} == {id(one) for one in plot.figure.axes}, name
        pyplot.close(plot.figure)
        ax = Figure().subplots()
        alone = results[name].plot(ax=ax)
        assert alone.axes[0, 0] is ax
        assert alone.figure is ax.figure
    with pytest.raises(InputError, match="no picture"):
        results["decay"].plot()


def test_text_fits_a_screen(results: dict[str, Any]) -> None:
    for name, found in results.items():
        text = str(found)
        assert len(text.splitlines()) <= 60, name
        assert "array(" not in text, name
        # Columns of tables stand two spaces apart; sentences are broken by the terminal.
        wide = [line for line in text.splitlines() if "  " in line.strip() and len(line) > TERMINAL]
        assert not wide, (name, wide)


def test_long_names_and_reasons_fit_a_terminal() -> None:
    """Friction: the frequency of the mode depends on its amplitude, and its overtones are rejected."""
    t = np.arange(0, 12, 0.02)
    swing, speed, rows = 1.0, 0.0, []
    for _ in t:
        rows.append(swing)
        for _ in range(20):
            speed -= 1e-3 * (22.0 * swing + 2.0 * speed * abs(speed) / 10 + 3.0 * swing**3)
            swing += 1e-3 * speed
    noisy = np.array(rows) + 1e-3 * np.random.default_rng(2).standard_normal(t.size)
    found = identify(as_record(noisy, timepts=t, channels=["Linear Acceleration of the body (m/s^2)"]))
    text = str(found)
    title, heads, *_ = text.partition("mode 1: amplitude in")[2].split("\n")
    assert title == " Linear Acceleration of the body (m/s^2)"
    assert heads.split() == ["amplitude", "f", "[Hz]", "±", "zeta", "[1]", "±"]
    names = tuple(f"Linear Acceleration {axis} (m/s^2)" for axis in "xyz")
    raw = (RawChannel(name=name, unit="m/s^2", timepts=t, values=noisy, rate=100.055) for name in names)
    for said in (text, str(Recording(title="phone", channels=tuple(raw)))):
        assert [line for line in said.splitlines() if "  " in line.strip() and len(line) > TERMINAL] == []
    assert found.considered
    assert all(one.reason in " ".join(text.split()) for one in found.considered[:1])


def test_tables_hold_the_numbers(results: dict[str, Any]) -> None:
    found = results["identification"]
    table = found.to_pandas()
    assert np.array_equal(table["wn_rad_per_s"], found.modes.wn)
    assert np.array_equal(table["zeta"], found.modes.zeta)
    np.testing.assert_allclose(table["f_hz"], found.modes.wn / (2 * np.pi), rtol=1e-15)
    reach = found.modes.interval(0.95).wn[:, 1] - found.modes.wn
    np.testing.assert_allclose(1.959964 * table["wn_std_rad_per_s"], reach, rtol=1e-3)
    reach = found.modes.interval(0.95).zeta[:, 1] - found.modes.zeta
    np.testing.assert_allclose(1.959964 * table["zeta_std"], reach, rtol=1e-3)
    springs = results["estimate"].to_pandas().set_index("parameter")
    assert springs["value"].to_dict() == dict(
        zip(results["estimate"].parameters, results["estimate"].values, strict=True)
    )
    assert (springs["lower"] < springs["value"]).all()
    assert springs.loc["tire.stiffness", "nominal"] == 800e3
    again = results["reconstruction"].to_pandas()
    assert again["value"].tolist() == [
        getattr(next(s for s in results["reconstruction"].suspension.struts if s.name == owner), what)
        for owner, what in (name.split(".") for name in again["parameter"])
    ]
    assert results["comparison"].to_pandas()["verdict"].eq("ok").all()
    assert len(results["decays"].to_pandas()) == len(results["decays"])
    assert results["grip"].to_pandas()["wheel"].tolist() == ["tire"]
    curve = results["curve"].to_pandas()
    assert np.array_equal(curve["velocity_m_per_s"], results["curve"].velocities)
    assert np.array_equal(curve["force_n"], results["curve"].totals)
    assert results["drive"].to_pandas().equals(results["drive"].estimate.to_pandas())
    (row,) = results["body"].to_pandas().to_dict("records")
    assert (row["channel"], row["hertz"]) == ("seat", 1.2)
    assert row["low_hz"] == pytest.approx(1.15 - 1.959964 * 0.02)
    assert len(results["cleaned"].to_pandas()) == len(results["cleaned"].findings)


def test_columns_name_their_units(results: dict[str, Any]) -> None:
    """A number has its unit in the name of its column or in a column of units, unless it is a ratio or a count."""
    units = re.compile(r"_(hz|s|db|n|nat|m3|rad|m_per_s|n_s_per_m|rad_per_s|std_rad_per_s|std_n|lower_rad|upper_rad)$")
    pure = {
        "zeta", "zeta_std", "rank", "cycles", "samples", "gaps", "order", "drives", "loss", "loss_lower", "loss_upper",
        "scatter", "adhesion", "adhesion_lower", "adhesion_upper", "bandwidth",
    }  # fmt: skip
    of_channels = {"hertz", "seat modulus", "chassis modulus", "tire modulus"}
    of_channels |= {f"{name} largest" for name in ("seat", "chassis", "tire")}
    for name, found in results.items():
        # Figures and parameters have the names under which they were asked for.
        if name not in {"tuning", "damper"}:
            table = found.to_pandas()
            numbers = set(table.select_dtypes("number").columns) if len(table) else set()
            bare = {one for one in numbers if not units.search(one)} - pure - of_channels
            assert not bare or "unit" in table, (name, bare)


def test_a_scalogram_is_the_table_of_its_rows(results: dict[str, Any]) -> None:
    """A sine's modulus is largest at its frequency; each row lasts its number of samples times its step."""
    t = np.arange(0, 20, 0.01)
    table = cwt(np.cos(30 * t), fs=100.0, omega=[20.0, 30.0, 45.0], bandwidth=16.0).to_pandas()
    assert table.iloc[:, -1].idxmax() == 1
    np.testing.assert_allclose(table["omega_rad_per_s"] * table["scale_s"], 2 * np.pi)
    found = results["scalogram"]
    lengths = [row.shape[1] * step for row, step in zip(found.rows, found.to_pandas()["step_s"], strict=True)]
    np.testing.assert_allclose(lengths, 5.0, atol=float(found.to_pandas()["step_s"].max()))


def test_a_ridge_decays_as_its_mode_does() -> None:
    """The logarithm of the modulus falls by ``zeta wn`` in a second."""
    t = np.arange(0, 12, 0.01)
    record = as_record(np.exp(-0.5 * t) * np.cos(30 * t), timepts=t, channels=["seat"])
    table = find_ridges(record)[0].to_pandas()
    inside = table[table["trusted"]]
    slope = np.polyfit(inside["time_s"], np.log(inside["seat modulus"]), 1)[0]
    assert slope == pytest.approx(-0.5, rel=1e-3)


def test_limits_are_drawn_beside_what_was_found(results: dict[str, Any]) -> None:
    """100 % is the nearer limit; of a mode of 7.98 Hz that may have 7 to 7.9 Hz, the interval lies above it."""
    ((ax,),) = results["limits"].plot().axes
    states = [text.get_text().rpartition(": ")[2] for text in ax.get_yticklabels()]
    assert states == ["not met", "not met", "cannot tell"]
    points = [line.get_xdata()[0] for line in ax.lines if line.get_marker() == "o"]
    rows = results["limits"].rows
    expected = [rows[0].value / 0.5, rows[1].value / (7.9 * 2 * np.pi), rows[2].value / 100.0]
    np.testing.assert_allclose(points, 100 * np.array(expected))
    pyplot.close(ax.figure)


def test_a_road_is_drawn_among_its_classes(results: dict[str, Any]) -> None:
    """At 0.1 cycle/m the fitted line has the roughness found, and that of each class is four times that before it."""
    ((ax,),) = results["road"].plot().axes
    at = [np.exp(np.interp(np.log(0.1), np.log(line.get_xdata()), np.log(line.get_ydata()))) for line in ax.lines]
    np.testing.assert_allclose(at[-1], results["road"].roughness, rtol=1e-6)
    np.testing.assert_allclose(np.array(at[1:-1]) / at[:-2], 4.0, rtol=1e-6)
    pyplot.close(ax.figure)


def test_feedback_is_drawn_over_no_feedback(results: dict[str, Any]) -> None:
    found = results["active"]
    ((ax,),) = found.plot().axes
    expected = [100 * found.rms[name] / rms for name, rms in found.passive.items() if rms]
    np.testing.assert_allclose([bar.get_width() for bar in ax.patches], expected)
    pyplot.close(ax.figure)


def test_columns_stand_below_each_other_in_a_notebook(results: dict[str, Any]) -> None:
    """Notebooks give HTML a proportional font and break words anywhere, unless the cell says otherwise."""
    style = re.match(r'<pre style="([^"]+)"', results["modes"]._repr_html_())
    assert style is not None
    assert {"font-family: monospace", "word-break: normal"} <= set(style[1].split("; "))


def test_details_say_no_less(results: dict[str, Any]) -> None:
    for result in results.values():
        assert len(result.details()) >= len(str(result))


def test_lists_and_failing_tests_show_a_line_of_each(results: dict[str, Any]) -> None:
    for name, found in results.items():
        line = repr(found)
        assert line.startswith(f"<{type(found).__name__} "), name
        assert len(line) <= 300, name
        assert "\n" not in line, name
        assert "array(" not in line, name
    assert "2 modes, wn = 10, 70 rad/s, zeta = 0.3, 0.2" in repr(results["poles"])
    wrong = compare(results["poles"], ModalSet.from_wn_zeta([10.0, 71.0], [0.3, 0.2]), rtol=0.01)
    assert repr(wrong) == "<Comparison 1 of 4 values fail (allowed: 0.01 relative): mode 2 wn 70 for 71>"
    assert repr(results["estimate"].verdict).startswith("<Verdict sound: 6 parameters")
    channel = RawChannel(name="seat", unit="m", timepts=np.arange(9.0), values=np.arange(9.0), rate=1.0)
    assert repr(channel) == "RawChannel(name='seat', unit='m', rate=1.0, test='')"


class TestHostileNames:
    """Names from files reach a terminal by `print`, a notebook and a debugger: none is a command there."""

    HOSTILE = ("\x1b[31mseat\x1b[0m", "chas\u202esis\nb", "<b>$ti_re$</b>" + "x" * 300)

    @pytest.fixture(scope="class")
    @classmethod
    def found(cls) -> tuple[object, ...]:
        seat, chassis, tire = cls.HOSTILE
        car = Suspension(
            masses=dict.fromkeys(cls.HOSTILE, 200.0),
            struts=(
                Strut(name=seat, stiffness=200e3, damping=300, arms={seat: 1, chassis: -1}),
                Strut(name=chassis, stiffness=400e3, damping=200, arms={chassis: 1, tire: -1}),
                Strut(name=tire, stiffness=800e3, damping=100, arms={tire: 1, "road": -1}),
            ),
        )
        record = free_decay(car, np.arange(0, 3, 0.005), initial_state={f"v_{tire}": 1.0})
        identified = identify(add_noise(record, snr_db=30.0, rng=np.random.default_rng(1)), modes=3)
        return identified, reconstruct(identified.modes, car), grip(car), ride(car, road="C", speed=20.0)

    def test_they_are_printed_escaped(self, found: tuple[object, ...]) -> None:
        for one in found:
            for text in (str(one), repr(one), one.details(), one._repr_html_()):  # type: ignore[attr-defined]
                assert all(line.isprintable() for line in text.split("\n"))
                assert "<b>" not in text or not text.startswith("<pre")
            assert "\n" not in repr(one)

    def test_long_ones_leave_room_for_the_numbers(self, found: tuple[object, ...]) -> None:
        tables = [line for one in found for line in str(one).split("\n") if "…" in line and "  " in line]
        assert tables
        assert max(map(len, tables)) <= 140
        assert max(len(repr(one)) for one in found) <= 340
