"""Pictures on narrow Axes: titles are broken over lines, keys and numbers stand apart."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from matplotlib.transforms import BboxBase

from suspid import (
    ModalSet,
    add_noise,
    cwt,
    damper_curve,
    eigenmodes,
    estimate,
    free_decay,
    grip,
    identify,
    plot_damper_curve,
    plot_estimate,
    plot_grip,
    plot_identification,
    plot_ride,
    plot_scalogram,
    plot_sensitivities,
    plot_shapes,
    quarter_car,
    ride,
    road_profile,
    sensitivities,
    simulate,
)
from suspid.reporting import PAGE
from suspid.reporting.axes import entitle, label_within
from suspid.results import NOTEBOOK
from validation import cars

pytestmark = pytest.mark.slow

# Width and height of a picture on a phone, and of one on a slide of 16:9 [inch].
PHONE, SLIDE = (3.9, 3.0), (13.33, 7.5)
RECORD = free_decay(cars.PAPER, np.arange(0, 3, 0.01), initial_state={"v_tire": 1.0})


def drawn(size: tuple[float, float]) -> Axes:
    return Figure(figsize=size, layout="constrained").subplots()


def figure_of(ax: Axes) -> Figure:
    figure = ax.figure
    assert isinstance(figure, Figure)
    return figure


def box(part: object, ax: Axes) -> BboxBase:
    figure_of(ax).draw_without_rendering()
    found = part.get_window_extent()  # type: ignore[attr-defined]
    assert isinstance(found, BboxBase)
    return found


def title_of(ax: Axes) -> Text:
    """Return the title at the left."""
    texts = (part for part in ax.get_children() if isinstance(part, Text) and not isinstance(part, Annotation))
    return next(text for text in texts if text.get_text() == ax.get_title(loc="left"))


class TestTitles:
    def test_a_long_one_stays_in_the_figure(self) -> None:
        ax = drawn(PHONE)
        entitle(ax, "springs and dampers with 95 % intervals; grey: no significant change")
        ax.set_yticks([0.0], ["chassis.stiffness"])
        title = next(text for text in ax.findobj(lambda one: getattr(one, "get_text", str)().startswith("springs")))
        assert box(title, ax).x1 <= ax.figure.bbox.width

    def test_a_long_one_stays_beside_that_of_the_next_axes(self) -> None:
        figure = Figure(figsize=(10.0, 7.0), layout="constrained")
        grid = figure.subplots(2, 2)
        estimate(add_noise(RECORD, snr_db=30.0, rng=np.random.default_rng(1)), cars.PAPER).plot(ax=grid[1, 0])
        grip(cars.HATCHBACK).plot(ax=grid[1, 1])
        figure.draw_without_rendering()
        left, right = (title_of(ax) for ax in grid[1])
        assert not left.get_window_extent().overlaps(right.get_window_extent())
        key = grid[1, 1].get_legend()
        assert key is not None
        assert not key.get_window_extent().overlaps(right.get_window_extent())


class TestLabels:
    def test_those_of_neighbours_stay_below_their_own_axes(self) -> None:
        figure = Figure(figsize=PHONE, layout="constrained")
        grid = figure.subplots(1, 2)
        for ax, name in zip(grid, "xy", strict=True):
            label_within(ax, f"amplitude in Acceleration {name} …")
            ax.set_ylabel("damping ratio [1]")
        left, right = (box(ax.xaxis.label, ax) for ax in grid)
        assert not left.overlaps(right)
        assert right.x1 <= figure.bbox.width


class TestScalogram:
    def test_the_key_stands_apart(self) -> None:
        modes = ModalSet.from_wn_zeta([20.0, 21.0, 22.0, 60.0], [0.01] * 4)
        scalogram = cwt(RECORD, omega=np.geomspace(8, 120, 40), bandwidth=8.0)
        for size in (PHONE, SLIDE):
            ax = plot_scalogram(scalogram, ax=drawn(size), modes=modes)
            key = ax.get_legend()
            assert key is not None
            assert not box(key, ax).overlaps(box(ax.xaxis.label, ax))
            assert not box(key, ax).padded(-1.0).overlaps(box(ax, ax))
            assert box(ax, ax).width > 0.4 * ax.figure.bbox.width

    def test_numbers_of_close_modes_do_not_hide_each_other(self) -> None:
        modes = ModalSet.from_wn_zeta([20.0, 21.0, 22.0, 60.0], [0.01] * 4)
        ax = plot_scalogram(cwt(RECORD, omega=np.geomspace(8, 120, 40), bandwidth=8.0), ax=drawn(PHONE), modes=modes)
        figure_of(ax).draw_without_rendering()
        boxes = [one.get_window_extent() for one in ax.texts if isinstance(one, Annotation)]
        assert len(boxes) == 4
        assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])


def test_names_of_parameters_stand_upright_in_narrow_columns() -> None:
    found = sensitivities(cars.HATCHBACK)
    for size, upright in ((PHONE, True), (SLIDE, False)):
        ax = plot_sensitivities(found, drawn(size))
        figure_of(ax).draw_without_rendering()
        labels = ax.get_xticklabels()
        assert {label.get_rotation() for label in labels} == {90.0 if upright else 0.0}
        boxes = [label.get_window_extent() for label in labels]
        assert not any(one.overlaps(other) for one, other in pairwise(boxes))


def texts_of(figure: Figure) -> list[Text]:
    """Return titles, labels, notes and the numbers at ticks in view."""
    found: list[Text] = []
    for ax in figure.axes:
        found += [part for part in ax.get_children() if isinstance(part, Text)]
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            found += [axis.label, *(label for tick in ticks for label in (tick.label1, tick.label2))]
    return [text for text in found if text.get_visible() and text.get_text().strip()]


def overlaps(figure: Figure) -> list[tuple[str, str]]:
    """Return pairs of texts that are drawn over each other, and those that leave the figure."""
    figure.draw_without_rendering()
    # The box of a text has room around the letters.
    inside = [(text.get_text(), text.get_window_extent().padded(-2.0)) for text in texts_of(figure)]
    apart = [(a, b) for i, (a, one) in enumerate(inside) for b, other in inside[i + 1 :] if one.overlaps(other)]
    edge = figure.bbox.padded(1.0)
    beyond = [a for a, one in inside if not (edge.contains(one.x0, one.y0) and edge.contains(one.x1, one.y1))]
    return apart + [(a, "edge") for a in beyond]


CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)


class TestKeys:
    def test_of_a_spectrum_alone(self) -> None:
        """In a notebook the panel of the weightings, whose key it is on a page, is not there."""
        ax = drawn(NOTEBOOK)
        ride(CAR, road="C", speed=20.0).plot(ax)
        key = ax.get_legend()
        assert key is not None
        assert [text.get_text() for text in key.get_texts()] == ["not weighted", "Wk", "Wf"]

    def test_wheels_with_one_curve_are_both_seen(self) -> None:
        ax = drawn(NOTEBOOK)
        grip(cars.FOUR_WHEELS).plot(ax)
        assert [line.get_linestyle() for line in ax.lines[:4]] == ["-", "--", "-", "--"]

    def test_numbers_of_many_modes_stand_apart(self) -> None:
        ax = plot_shapes(eigenmodes(cars.FOUR_WHEELS), ax=drawn(PHONE))
        figure_of(ax).draw_without_rendering()
        boxes = [label.get_window_extent() for label in ax.get_xticklabels()]
        # A point of room between two numbers.
        assert all(one.x1 + 1 < other.x0 for one, other in pairwise(boxes))


class TestPages:
    """Pages of several panels in every size: no text over another, none beyond the edge."""

    @pytest.mark.parametrize("size", [PHONE, (3.6, 5.0), SLIDE, PAGE], ids=["card", "phone", "slide", "A4"])
    def test_of_grip(self, size: tuple[float, float]) -> None:
        assert overlaps(plot_grip(grip(CAR, nominal_std=0.05), Figure(figsize=size))) == []

    @pytest.mark.parametrize("size", [PHONE, (3.6, 5.0), SLIDE, PAGE], ids=["card", "phone", "slide", "A4"])
    def test_of_ride(self, size: tuple[float, float]) -> None:
        assert overlaps(plot_ride(ride(CAR, road="C", speed=20.0, nominal_std=0.05), Figure(figsize=size))) == []

    @pytest.mark.parametrize("size", [PHONE, (3.6, 5.0), SLIDE, PAGE], ids=["card", "phone", "slide", "A4"])
    def test_of_the_ride_of_a_full_car(self, size: tuple[float, float]) -> None:
        assert overlaps(plot_ride(ride(cars.FOUR_WHEELS, road="C", speed=20.0), Figure(figsize=size))) == []

    @pytest.mark.parametrize("size", [(3.6, 5.0), SLIDE, PAGE], ids=["phone", "slide", "A4"])
    def test_of_many_sensitivities(self, size: tuple[float, float]) -> None:
        figure = Figure(figsize=size, layout="constrained")
        plot_sensitivities(sensitivities(cars.FOUR_WHEELS), figure.subplots())
        assert overlaps(figure) == []

    def test_of_a_damper(self) -> None:
        t = np.arange(0, 12, 0.005)
        road = road_profile(20 * t, roughness="B", rng=np.random.default_rng(1), wavelengths=(0.5, 100.0))
        sensors = ["chassis_acceleration", "tire_acceleration"]
        record = simulate(CAR, t, {"road": road}, outputs=sensors, interpolation="cubic")
        ax = plot_damper_curve(damper_curve(record, CAR, strut="chassis", nodes=8), drawn(PHONE))
        assert overlaps(figure_of(ax)) == []

    @pytest.mark.parametrize("size", [PHONE, (3.6, 5.0), SLIDE, PAGE], ids=["card", "phone", "slide", "A4"])
    def test_of_an_estimate(self, size: tuple[float, float]) -> None:
        decay = free_decay(CAR, np.arange(0, 2, 0.005), initial_state={"v_tire": 1.0})
        noisy = add_noise(decay, snr_db=30.0, rng=np.random.default_rng(1))
        found = estimate(noisy, CAR, fixed=["tire.damping"])
        assert overlaps(plot_estimate(found, Figure(figsize=size))) == []

    @pytest.mark.parametrize("size", [PHONE, (3.6, 5.0), SLIDE, PAGE], ids=["card", "phone", "slide", "A4"])
    def test_of_an_identification(self, size: tuple[float, float]) -> None:
        assert overlaps(plot_identification(identify(RECORD), Figure(figsize=size))) == []

    @pytest.mark.parametrize("count", [5, 20, 60])
    def test_of_many_channels(self, count: int) -> None:
        """Names of channels take no room from the panels, and the time stands below both columns of the fit."""
        rng = np.random.default_rng(0)
        motion = rng.standard_normal((count, 3)) @ np.asarray(RECORD.outputs)
        noise = 1e-3 * np.std(motion, axis=1, keepdims=True) * rng.standard_normal(motion.shape)
        figure = plot_identification(identify(motion + noise, fs=100.0), Figure(figsize=PAGE))
        assert overlaps(figure) == []
        lowest = [ax for ax in figure.axes if ax.axison and "explained" in ax.get_title(loc="left") and ax.get_xlabel()]
        assert len(lowest) == 2
        assert all(any(label.get_visible() for label in ax.get_xticklabels()) for ax in lowest)
