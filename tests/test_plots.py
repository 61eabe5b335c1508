"""What is drawn is the data, with units, whatever names a file holds."""

import re
import warnings
from collections.abc import Iterator
from dataclasses import replace

import control
import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from suspid import (
    BandwidthSearch,
    Identification,
    InputError,
    ModalSet,
    Scalogram,
    add_noise,
    as_record,
    cwt,
    find_ridges,
    free_decay,
    identify,
)
from suspid.records import as_response
from suspid.reporting import (
    PAGE,
    drawing_of,
    plot_entropy,
    plot_fit,
    plot_identification,
    plot_recording,
    plot_scalogram,
    plot_shapes,
    plot_skeletons,
)
from suspid.reporting.axes import PIECES_AN_INCH, decade_ticks, unit_ticks
from suspid.reporting.plot_shapes import FULL_BAR
from suspid.reporting.thinning import first_cycles
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.wavelets import ABOVE_NOISE, fit_skeleton
from suspid.words import Check, Headline, Level, ModeCheck, Remark, Verdict
from validation import cars

HOSTILE = ("$x^2$", "$\\undefined{$", "_hidden", "\x1b[2Jq\n", "座席", "a" * 500, "")
UNITS = ("s", "Hz", "rad/s", "dB", "1", "nat", "rad", "√s × unit", "unit")


@pytest.fixture(scope="module")
def record() -> control.TimeResponseData:
    car = cars.PAPER
    decay = free_decay(car, np.arange(5, 11, 0.005), initial_state={"v_tire": 1.0})
    return add_noise(decay, snr_db=20.0, rng=np.random.default_rng(3))


@pytest.fixture(scope="module")
def scalogram(record: control.TimeResponseData) -> Scalogram:
    return cwt(record, omega=np.geomspace(10, 150, 90), bandwidth=6.0)


@pytest.fixture(scope="module")
def identification(record: control.TimeResponseData) -> Identification:
    return identify(record, modes=3, candidates=[4.0, 8.0])


def one_axes() -> Axes:
    return Figure().subplots()


def coordinates(line: Line2D) -> tuple[RealArray, RealArray]:
    return np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)


def is_drawn(ax: Axes, x: RealArray, y: RealArray) -> bool:
    """Return whether one of the lines is just this one."""
    lines = (coordinates(line) for line in ax.get_lines())
    # Rounding of sums in another order is all that may differ.
    return any(
        a.shape == x.shape and np.allclose(a, x, rtol=1e-12, atol=0) and np.allclose(b, y, rtol=1e-12, atol=1e-15)
        for a, b in lines
    )


def mesh(ax: Axes) -> QuadMesh:
    (found,) = [c for c in ax.collections if isinstance(c, QuadMesh)]
    return found


def corners(ax: Axes) -> RealArray:
    """Return the corners of the mesh, (row, column, 2)."""
    return np.array(mesh(ax).get_coordinates(), np.float64)


def labels(figure: Figure) -> Iterator[str]:
    for ax in figure.axes:
        for each in (ax, *ax.child_axes):
            if each.axison:
                yield from (text for text in (each.get_xlabel(), each.get_ylabel()) if text)


class TestScalogram:
    @pytest.mark.parametrize("full_rate", [True, False])
    def test_colours_are_the_modulus_in_decibels(self, record: control.TimeResponseData, full_rate: bool) -> None:
        signal = as_signal(record)
        short = as_response(signal.timepts[:400], signal.values[:, :400], signal.channels)
        scalogram = cwt(short, omega=np.geomspace(10, 150, 20), bandwidth=6.0, full_rate=full_rate)
        ax = plot_scalogram(scalogram, ax=one_axes(), channel="tire", decibels=80.0, colorbar=False)
        modulus = scalogram.modulus(signal.timepts[:400])[2]
        decibels = np.maximum(20 * np.log10(modulus / modulus.max()), -80)
        # Both are the same numbers: rounding of times between the samples of a row, and of decibels.
        assert np.allclose(np.asarray(mesh(ax).get_array(), float), decibels, rtol=0, atol=1e-6)

    def test_all_channels_count_by_their_effective_values(self, record: control.TimeResponseData) -> None:
        signal = as_signal(record)
        scaled = as_response(signal.timepts, signal.values * np.array([[1.0], [1e6], [1e-6]]), signal.channels)
        one, other = (
            mesh(plot_scalogram(cwt(r, omega=[20.0, 50.0, 80.0], bandwidth=6.0), ax=one_axes())).get_array()
            for r in (record, scaled)
        )
        # No channel's unit matters.
        assert np.allclose(np.asarray(one, float), np.asarray(other, float), rtol=0, atol=1e-6)

    def test_rows_stand_at_their_frequencies_in_any_order(self, record: control.TimeResponseData) -> None:
        ax = plot_scalogram(cwt(record, omega=[40.0, 10.0, 20.0], bandwidth=2.0), ax=one_axes())
        edges = corners(ax)[:, 0, 1] * 2 * np.pi
        # Midway in the logarithm between 10, 20 and 40.
        assert edges == pytest.approx([10 / 2**0.5, 10 * 2**0.5, 20 * 2**0.5, 40 * 2**0.5])

    def test_the_cone_is_that_of_the_scalogram(self, scalogram: Scalogram) -> None:
        ax = plot_scalogram(scalogram, ax=one_axes())
        hertz = np.asarray(scalogram.omega) / (2 * np.pi)
        assert is_drawn(ax, 5 + np.asarray(scalogram.cone), hertz)
        assert is_drawn(ax, 11 - np.asarray(scalogram.cone), hertz)

    def test_ridges_stand_at_their_frequencies_over_their_windows(self, scalogram: Scalogram) -> None:
        ridges = find_ridges(scalogram, count=3)
        ax = plot_scalogram(scalogram, ax=one_axes(), ridges=ridges)
        for ridge in ridges:
            at = ridge.omega / (2 * np.pi)
            assert is_drawn(ax, np.array([ridge.window.start, ridge.window.stop]), np.array([at, at]))

    def test_traces_are_those_of_the_ridges(self, scalogram: Scalogram) -> None:
        ridges = find_ridges(scalogram, count=3)
        ax = plot_scalogram(scalogram, ax=one_axes(), ridges=ridges)
        for ridge in ridges:
            (trace,) = [
                y
                for x, y in map(coordinates, ax.get_lines())
                if np.array_equal(x, ridge.timepts) and near(y, ridge.omega)
            ]
            shown = ~np.isnan(trace)
            assert np.any(shown)
            assert np.allclose(2 * np.pi * trace[shown], ridge.trace[shown], rtol=1e-12)
            assert np.all(ridge.timepts[shown] <= ridge.window.stop)

    def test_a_click_in_a_long_record_is_seen(self) -> None:
        values = np.zeros((1, 400_000))
        values[0, 123_456] = 1.0
        scalogram = cwt(
            as_response(np.linspace(0, 399.999, 400_000), values, ["y"]), omega=[500.0, 2000.0], bandwidth=2.0
        )
        ax = plot_scalogram(scalogram, ax=one_axes(), channel="y")
        level, edges = np.asarray(mesh(ax).get_array(), float), corners(ax)[0, :, 0]
        assert level.shape[1] <= 1000
        for row in level:
            loudest = int(np.argmax(row))
            # Half a sample of the row, by which a column may miss the middle of the click.
            assert edges[loudest] - 0.01 <= 123.456 <= edges[loudest + 1] + 0.01

    def test_the_other_axis_is_the_angular_frequency(self, scalogram: Scalogram) -> None:
        figure = Figure()
        ax = plot_scalogram(scalogram, ax=figure.subplots())
        figure.draw_without_rendering()
        (right,) = ax.child_axes
        assert right.get_ylabel() == "angular frequency [rad/s]"
        assert right.get_ylim() == pytest.approx(2 * np.pi * np.array(ax.get_ylim()))

    def test_an_unknown_channel_is_named(self, scalogram: Scalogram) -> None:
        with pytest.raises(InputError, match="no channel 'seet'. Did you mean 'seat'"):
            plot_scalogram(scalogram, ax=one_axes(), channel="seet")

    @pytest.mark.parametrize("size", [(7.0, 3.2), (10.0, 5.0), (8.27, 6.0)])
    def test_the_key_stays_in_the_picture_and_off_the_title(
        self, identification: Identification, size: tuple[float, float]
    ) -> None:
        figure = Figure(figsize=size, layout="constrained")
        drawing = drawing_of(identification)
        assert drawing is not None
        drawing.alone(ax := figure.subplots())
        figure.draw_without_rendering()
        legend = ax.get_legend()
        assert legend is not None
        titles = [one for one in ax.get_children() if isinstance(one, Text) and one.get_text() == "all channels"]
        key, title = legend.get_window_extent(), titles[0].get_window_extent()
        assert key.x0 >= 0
        assert key.y0 >= 0
        assert key.x1 <= figure.bbox.x1
        assert not key.overlaps(title)
        assert not key.overlaps(ax.xaxis.label.get_window_extent())


def near(hertz: RealArray, omega: float) -> bool:
    return bool(np.nanmax(np.abs(np.log(2 * np.pi * hertz / omega)), initial=0.0) < 0.5)


class TestSkeletons:
    def test_modulus_and_phase_are_those_of_the_skeleton_and_its_lines(self, scalogram: Scalogram) -> None:
        ridges = find_ridges(scalogram, count=3)
        axes = Figure().subplots(2, 3)
        plot_skeletons(ridges, axes=axes)
        for k, ridge in enumerate(ridges):
            fit = fit_skeleton(ridge)
            turning = (fit.pole.imag - ridge.omega) * (fit.timepts - ridge.onset)
            assert is_drawn(axes[1, k], fit.timepts, turning)
            for channel, modulus in enumerate(np.abs(ridge.skeleton)):
                assert is_drawn(axes[0, k], np.asarray(ridge.timepts), modulus)
                assert is_drawn(axes[0, k], fit.timepts, np.exp(fit.lines[channel].real))
            phases = [y for x, y in map(coordinates, axes[1, k].get_lines()) if len(x) == len(ridge.timepts)]
            for channel, phase in enumerate(phases[:3]):
                left = fit.logarithm[channel].imag - fit.lines[channel].imag
                # Phases of a thousand radians are taken off each other; 1e-9 is far above that rounding.
                assert np.allclose(phase[ridge.trusted] - turning, left, rtol=0, atol=1e-9)

    def test_phases_of_noise_are_not_drawn_outside_the_window(self, scalogram: Scalogram) -> None:
        ridges = find_ridges(scalogram, count=3)
        axes = Figure().subplots(2, 3)
        plot_skeletons(ridges, axes=axes)
        hidden = 0
        for k, ridge in enumerate(ridges):
            noise = np.abs(ridge.skeleton) <= ABOVE_NOISE * np.asarray(ridge.floor)[:, np.newaxis]
            phases = [y for x, y in map(coordinates, axes[1, k].get_lines()) if len(x) == len(ridge.timepts)]
            for channel in range(3):
                left = noise[channel] & ~ridge.trusted
                assert np.array_equal(np.isnan(phases[channel]), left)
                hidden += int(left.sum())
        assert hidden > 0

    def test_turns_of_the_phase_outside_the_window_do_not_shift_what_is_inside(self, scalogram: Scalogram) -> None:
        (ridge,) = find_ridges(scalogram, count=1)
        before = np.clip((ridge.window.start - ridge.timepts) / (ridge.window.start - ridge.timepts[0]), 0, 1)
        turned = replace(ridge, skeleton=ridge.skeleton * np.exp(4j * np.pi * before))
        axes = Figure().subplots(2, 2)
        plot_skeletons([ridge, turned], axes=axes)
        for plain, other in zip(axes[1, 0].get_lines(), axes[1, 1].get_lines(), strict=True):
            (x, y), (_, z) = coordinates(plain), coordinates(other)
            # A turn is 6.28; whatever rounding the exponential adds is far below 1e-9.
            assert np.allclose(y[x >= ridge.window.start], z[x >= ridge.window.start], rtol=0, atol=1e-9)

    def test_the_noise_level_is_where_trust_ends(self, scalogram: Scalogram) -> None:
        (ridge,) = find_ridges(scalogram, count=1)
        axes = Figure().subplots(2, 1, squeeze=False)
        plot_skeletons([ridge], axes=axes)
        for floor in ridge.floor:
            assert is_drawn(axes[0, 0], np.array([0.0, 1.0]), np.full(2, ABOVE_NOISE * floor))

    def test_the_trusted_window_is_shaded(self, scalogram: Scalogram) -> None:
        (ridge,) = find_ridges(scalogram, count=1)
        axes = Figure().subplots(2, 1, squeeze=False)
        plot_skeletons([ridge], axes=axes)
        for ax in axes[:, 0]:
            (shade,) = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
            assert shade.get_x() == pytest.approx(ridge.window.start)
            assert shade.get_x() + shade.get_width() == pytest.approx(ridge.window.stop)

    def test_axes_that_do_not_fit_are_refused(self, scalogram: Scalogram) -> None:
        with pytest.raises(InputError, match=r"2 x 3 Axes; got the shape \(2,\)"):
            plot_skeletons(find_ridges(scalogram, count=3), axes=Figure().subplots(2))


class TestEntropy:
    def test_the_curve_and_its_minimum(self) -> None:
        search = BandwidthSearch(candidates=np.array([8.0, 4.0, 2.0]), entropy=np.array([3.0, 1.0, 2.5]))
        ax = plot_entropy(search, ax=one_axes())
        assert is_drawn(ax, np.array([2.0, 4.0, 8.0]), np.array([2.5, 1.0, 3.0]))
        assert is_drawn(ax, np.array([4.0]), np.array([1.0]))
        assert ax.get_title(loc="left") == "least entropy at N = 4"

    def test_a_minimum_at_the_end_is_told(self) -> None:
        search = BandwidthSearch(candidates=np.array([2.0, 4.0]), entropy=np.array([3.0, 2.5]))
        assert "the end of the range" in plot_entropy(search, ax=one_axes()).get_title(loc="left")


class TestFit:
    def test_record_fit_and_residual_are_drawn_as_they_are(self, identification: Identification) -> None:
        axes = Figure().subplots(3)
        plot_fit(identification, axes=axes)
        for response in (identification.response, identification.fitted, identification.residual):
            signal = as_signal(response)
            for ax, samples in zip(axes, signal.values, strict=True):
                assert is_drawn(ax, signal.timepts, np.asarray(samples))

    def test_a_span_of_one_channel(self, identification: Identification) -> None:
        (ax,) = axes = [one_axes()]
        plot_fit(identification, axes=axes, channels=["tire"], span=(6.0, 7.0))
        signal = as_signal(identification.response)
        kept = (signal.timepts >= 6) & (signal.timepts <= 7)
        assert is_drawn(ax, signal.timepts[kept], signal.values[2, kept])

    @pytest.mark.parametrize(("hertz", "enlarged"), [((1.0, 10.0), 0.6), ((2.0, 10.0), 3.0), ((1.0, 1.1), None)])
    def test_the_cycles_enlarged_are_of_the_slowest_mode_that_leaves_most_of_the_record_out(
        self, hertz: tuple[float, float], enlarged: float | None
    ) -> None:
        """Six cycles of 1 Hz are all of six seconds: where there is no faster mode, nothing is drawn twice."""
        t = np.arange(0, 6, 0.01)
        waves = [np.exp(-0.4 * t) * np.sin(2 * np.pi * f * t + k) for k, f in enumerate(hertz)]
        noise = 0.01 * np.random.default_rng(1).normal(size=(2, len(t)))
        channels = np.array([[1.0, 1.0], [1.0, -2.0]]) @ waves + noise
        found = identify(as_record(channels, timepts=t), modes=2)
        span = first_cycles(found)
        # The frequencies found are off by far less than 1 %.
        assert span is None if enlarged is None else span == pytest.approx((0.0, enlarged), rel=0.01)
        page = plot_identification(found, Figure(figsize=PAGE))
        assert ("beginning, enlarged" in [ax.get_title(loc="left") for ax in page.axes]) == (enlarged is not None)

    def test_a_long_record_keeps_every_extreme(self) -> None:
        rng = np.random.default_rng(5)
        time = np.linspace(0, 999.999, 1_000_000)
        values = rng.normal(size=(1, time.size))
        values[0, 654_321] = 50.0
        small = as_response(time[:1000], np.exp(-time[:1000]) * np.cos(60 * time[:1000])[None], ["y"])
        found = identify(small, modes=1, candidates=[4.0])
        long = as_response(time, values, ["y"])
        whole = replace(found, response=long, fitted=long, residual=long)
        ax = one_axes()
        plot_fit(whole, axes=[ax])
        x, y = coordinates(ax.get_lines()[0])
        assert len(x) <= 2 * PIECES_AN_INCH * Figure().get_figwidth() + 2
        assert (y.max(), y.min()) == (50.0, values.min())
        assert x[np.argmax(y)] == pytest.approx(654.321)
        # What is drawn are samples of the record at their own times.
        assert np.array_equal(values[0, np.round(x * 1e3).astype(int)], y)
        assert np.all(np.diff(x) > 0)

    @pytest.mark.parametrize(("low", "high"), [(-9.1, 5.2), (-0.55, 1.3), (-70.0, 50.0), (0.0, 4e-6), (-4.0, 9.7)])
    @pytest.mark.parametrize("height", [0.7, 1.75, 4.8])
    def test_three_ticks_or_more_stand_in_a_panel_with_room(self, low: float, high: float, height: float) -> None:
        ax = Figure(figsize=(7.0, height), layout="constrained").subplots()
        ax.plot([0.0, 1.0], [low, high])
        unit_ticks(ax, "m")
        bottom, top = ax.get_ylim()
        ticks = [tick for tick in ax.get_yticks() if bottom <= tick <= top]
        # A tick has a line of type, 0.14 inch, and as much again below it; a very low panel has two.
        assert 2 + (height > 1) <= len(ticks) <= max(4, height / 0.28)

    @pytest.mark.parametrize("largest", [3e-7, 0.02, 0.5, 40.0, 3e5])
    def test_a_tick_times_the_power_in_the_label_is_its_place(self, largest: float) -> None:
        ax = one_axes()
        ax.plot([0.0, 1.0], [-largest, largest])
        unit_ticks(ax, "m")
        power = re.fullmatch(r"\[(?:10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) )?m\]", ax.get_ylabel())
        assert power is not None
        exponent = int((power[1] or "0").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))
        low, high = ax.get_ylim()
        places = [place for place in ax.get_yticks() if low <= place <= high]
        assert len(places) >= 2
        for place, text in zip(places, ax.yaxis.get_major_formatter().format_ticks(places), strict=True):
            assert len(text) <= 5
            assert float(text.replace("−", "-")) * 10.0**exponent == pytest.approx(place, rel=1e-9)


class TestRecording:
    def test_decays_are_shaded_and_numbered_where_they_are(self, record: control.TimeResponseData) -> None:
        stretches = [(5.5, 6.5), (6.0, 8.0), (9.0, 10.0)]
        ax = plot_recording(record, ax=one_axes(), channel="tire", stretches=stretches, used=1, unit="mm")
        shades = [(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches if isinstance(p, Rectangle)]
        assert np.allclose(sorted(shades), stretches, rtol=1e-12)
        assert [text.get_text() for text in ax.texts] == ["1", "2", "3"]
        signal = as_signal(record)
        assert is_drawn(ax, signal.timepts, np.asarray(signal.values[2]))
        assert ax.get_ylabel().endswith("mm]")

    def test_numbers_of_decays_do_not_overlap(self, record: control.TimeResponseData) -> None:
        stretches = [(5 + 0.1 * k, 5.05 + 0.1 * k) for k in range(4)]
        figure = Figure()
        ax = plot_recording(record, ax=figure.subplots(), channel="tire", stretches=stretches)
        figure.draw_without_rendering()
        boxes = [text.get_window_extent() for text in ax.texts]
        assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


class TestTicks:
    @pytest.mark.parametrize("ends", [(1e-3, 10.0), (0.2, 9.0), (3e-9, 2.0)])
    def test_ticks_of_a_logarithmic_axis_say_their_place(self, ends: tuple[float, float]) -> None:
        ax = one_axes()
        ax.set(yscale="log", ylim=ends)
        decade_ticks(ax.yaxis, ends[1] / ends[0])
        places = [place for place in ax.get_yticks() if ends[0] <= place <= ends[1]]
        assert 2 <= len(places) <= 6
        for place, text in zip(places, ax.yaxis.get_major_formatter().format_ticks(places), strict=True):
            digits = text[2:].translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
            value = 10.0 ** int(digits) if re.match("10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]", text) else float(text)
            assert value == pytest.approx(place, rel=1e-9)


class TestShapes:
    def test_bars_are_real_parts_of_the_components_relative_to_the_largest(self) -> None:
        shapes = np.array([[2.0, 0.6 - 0.8j], [-1.0, 2.0]])
        modes = ModalSet.from_wn_zeta([10.0, 20.0], [0.1, 0.1], shapes=shapes, channels=["a", "b"])
        ax = plot_shapes(modes, ax=one_axes())
        widths = {round(p.get_width() / FULL_BAR, 12) for p in ax.patches if isinstance(p, Rectangle)}
        # Mode 1: 1 and -1/2. Mode 2: (0.6 - 0.8j) / 2 has the real part 0.3 and the modulus 0.5; and 1.
        assert widths == {1.0, -0.5, 0.3, 0.5}
        assert [text.get_text() for text in ax.texts] == ["−53°"]

    def test_poles_alone_are_refused(self) -> None:
        with pytest.raises(InputError, match="no shapes"):
            plot_shapes(ModalSet.from_wn_zeta([10.0], [0.1]), ax=one_axes())


class TestPage:
    def test_every_axis_has_a_unit(self, identification: Identification) -> None:
        figure = plot_identification(identification, Figure(figsize=PAGE))
        found = list(labels(figure))
        assert len(found) > 10
        units = [re.sub("^10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ ", "", text.rpartition("[")[2][:-1]).split(" of ")[0] for text in found]
        assert units.count("unit") == 3
        assert set(units) <= set(UNITS)
        assert all(text.endswith("]") for text in found)

    def test_the_verdict_is_on_it(self, identification: Identification) -> None:
        """Whoever has the picture alone has the doubts as well, the gravest first; of a file, its name."""
        remark = Remark(ModeCheck.NOTHING_DECAYS)
        checks = [Check(remark, Level.CARE)] * 12 + [Check(Remark(ModeCheck.RESIDUAL_WHITE), Level.DOUBTFUL)]
        verdict = Verdict(Remark(Headline.MODES, {"modes": 3}), tuple(checks))
        figure = plot_identification(identification, Figure(figsize=PAGE), title="run_7.csv", verdict=verdict)
        figure.draw_without_rendering()
        words = "\n".join(text.get_text() for text in figure.axes[0].texts)
        assert "Verdict: 3 modes found: doubtful." in words
        assert 0 < words.index(str(Remark(ModeCheck.RESIDUAL_WHITE))) < words.index(str(remark)[:40])
        assert "… and 6 more doubts" in words
        assert figure.axes[0].get_title(loc="left") == "run_7.csv — method likelihood"
        own = plot_identification(identification, Figure(figsize=PAGE)).axes[0].texts
        assert any(str(identification.verdict).split("\n")[0] in text.get_text() for text in own)

    @pytest.mark.parametrize("size", [(8.27, 5.8), (4.0, 12.0), (8.27, 8.0), PAGE])
    @pytest.mark.parametrize("words", [20, 400])
    def test_a_long_verdict_leaves_the_panels_room(
        self, identification: Identification, size: tuple[float, float], words: int
    ) -> None:
        """Layouts that collapse warn, and warnings are errors."""
        doubt = Remark(ModeCheck.CHANNELS_UNEXPLAINED, {"channels": "seat " * words})
        verdict = Verdict(Remark(Headline.MODES, {"modes": 3}), (Check(doubt, Level.CARE),) * 5)
        none = replace(identification, modes=identification.modes[[]])
        for found in (identification, none):
            plot_identification(found, Figure(figsize=size), verdict=verdict).draw_without_rendering()

    @pytest.mark.parametrize("size", [PAGE, (12.0, 9.0)])
    def test_nothing_is_changed_by_drawing(self, identification: Identification, size: tuple[float, float]) -> None:
        before = [np.copy(r.y) for r in (identification.response, identification.fitted, identification.residual)]
        skeletons = [np.copy(ridge.skeleton) for ridge in identification.ridges]
        settings = dict(matplotlib.rcParams)
        plot_identification(identification, Figure(figsize=size)).draw_without_rendering()
        after = [r.y for r in (identification.response, identification.fitted, identification.residual)]
        assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
        assert all(np.array_equal(a, r.skeleton) for a, r in zip(skeletons, identification.ridges, strict=True))
        assert dict(matplotlib.rcParams) == settings

    def test_no_titles_overlap(self, identification: Identification) -> None:
        figure = plot_identification(identification, Figure(figsize=PAGE))
        figure.draw_without_rendering()
        boxes = [ax.get_tightbbox() for ax in figure.axes if ax.axison]
        for i, box in enumerate(boxes):
            assert box is not None
            for other in boxes[:i]:
                assert other is not None
                overlap = min(box.x1, other.x1) - max(box.x0, other.x0), min(box.y1, other.y1) - max(box.y0, other.y0)
                assert min(overlap) < 1.0, f"{box} and {other} share {overlap} pixels"

    @pytest.mark.parametrize("count", [1, 7])
    def test_hostile_names_are_shown_as_they_are(self, record: control.TimeResponseData, count: int) -> None:
        signal = as_signal(record)
        values = np.stack([signal.values[i % 3] for i in range(count)])
        hostile = as_response(signal.timepts, values, HOSTILE[:count], title="$\\frac$ \x07")
        found = identify(hostile, modes=3, method="ridge", candidates=[4.0])
        # A character that no font has would be a warning, and warnings are errors here.
        plot_identification(found, Figure(figsize=PAGE)).draw_without_rendering()

    def test_a_dollar_is_a_dollar(self, record: control.TimeResponseData) -> None:
        signal = as_signal(record)
        named = as_response(signal.timepts, signal.values[:1], ["$a$\x1b"])
        ax = plot_scalogram(cwt(named, omega=[20.0, 30.0], bandwidth=2.0), ax=one_axes(), channel="$a$\x1b")
        assert ax.get_title(loc="left") == r"\$a\$\x1b"

    def test_a_silent_channel(self, record: control.TimeResponseData) -> None:
        signal = as_signal(record)
        values = np.stack([signal.values[2], 0 * signal.values[2]])
        silent = as_response(signal.timepts, values, ["tire", "dead"])
        scalogram = cwt(silent, omega=np.geomspace(10, 150, 90), bandwidth=6.0)
        ridges = find_ridges(scalogram, count=1)
        figure = Figure()
        axes = figure.subplots(2, 2)
        plot_skeletons(ridges, axes=axes[:, :1])
        plot_scalogram(scalogram, ax=axes[0, 1], channel="dead")
        figure.draw_without_rendering()

    def test_a_record_without_a_mode(self) -> None:
        noise = np.random.default_rng(0).normal(size=(1, 2000))
        found = identify(as_response(np.linspace(0, 3.998, 2000), noise, ["y"]), candidates=[4.0, 8.0])
        assert not len(found.modes)
        plot_identification(found, Figure(figsize=PAGE)).draw_without_rendering()

    def test_bandwidth_given_leaves_the_entropy_out(self, record: control.TimeResponseData) -> None:
        found = identify(record, modes=3, bandwidth=6.0)
        figure = plot_identification(found, Figure(figsize=PAGE))
        assert "wavelet entropy [nat]" not in list(labels(figure))

    @pytest.mark.slow
    def test_eight_modes_in_eight_channels(self) -> None:
        rng = np.random.default_rng(0)
        time, omega = np.linspace(0, 9.999, 10_000), 2 * np.pi * np.geomspace(4, 150, 8)
        motion = np.exp(-0.005 * omega[:, None] * time) * np.cos(omega[:, None] * time)
        record = as_response(time, rng.normal(size=(8, 8)) @ motion, [f"channel {i}" for i in range(8)])
        found = identify(record, modes=8, method="ridge", bandwidth=8.0)
        figure = plot_identification(found, Figure(figsize=PAGE))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            figure.draw_without_rendering()
        assert sum(ax.get_title(loc="left").startswith("ridge at") for ax in figure.axes) == 8
        assert sum("explained" in ax.get_title(loc="left") for ax in figure.axes) == 8


def test_a_channel_far_from_zero_is_drawn_about_its_mean() -> None:
    """Else the residual, at zero, is a line as flat as the motion."""
    t = np.arange(600) / 100
    motion = np.exp(-0.3 * t) * np.cos(20 * t) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    for level, less in ((10.0, ", less 10"), (0.0, "")):
        ax = Figure().subplots()
        plot_fit(identify(as_record(level + motion, timepts=t)), axes=[ax])
        drawn = [np.asarray(line.get_ydata(), float) for line in ax.get_lines()]
        assert all(np.max(np.abs(values)) < 1.1 for values in drawn)
        assert ax.get_title(loc="left").endswith(f"% explained{less}")
