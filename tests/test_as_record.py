"""Arrays and tables become records: same samples, same time, or an error with the line to write."""

from __future__ import annotations

import contextlib
import io
import logging
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from scipy.io import wavfile

from suspid import (
    InputError,
    ModalSet,
    RecordError,
    RecordWarning,
    Settings,
    SuspidError,
    add_noise,
    analyse,
    as_record,
    best_bandwidth,
    body_modes,
    classify_road,
    cwt,
    damper_curve,
    denoise,
    eigenmodes,
    estimate,
    find_decays,
    find_drives,
    find_ridges,
    fit_ridges,
    free_decay,
    identify,
    identify_repeats,
    quarter_car,
    read_record,
    ride,
    road_profile,
    simulate,
    stabilization,
    statespace,
)
from suspid.greybox.trials import records_of
from validation import cars

FS = 200.0
TIME = np.arange(1000) / FS
RECORD = add_noise(
    free_decay(cars.HATCHBACK, TIME, initial_state={"v_tire": 1.0}), snr_db=40.0, rng=np.random.default_rng(1)
)
VALUES, NAMES = np.asarray(RECORD.y), list(RECORD.output_labels)
pd: Any = pytest.importorskip("pandas")


def table(**index: Any) -> Any:
    return pd.DataFrame(dict(zip(NAMES, VALUES, strict=True)), **index)


FORMS: dict[str, Any] = {
    "response": RECORD,
    "pair": (TIME, VALUES),
    "index of time": table(index=pd.Index(TIME)),
    "named index in ms": table(index=pd.Index(1e3 * TIME, name="time [ms]")),
    "column of time": table().assign(time=TIME),
    "dates": table(index=pd.Timestamp("2026-03-29 01:59:58", tz="Europe/Berlin") + pd.to_timedelta(TIME, unit="s")),
    "durations": table(index=pd.to_timedelta(TIME, unit="s")),
    "column of dates": table().assign(when=pd.Timestamp("2026-01-01") + pd.to_timedelta(TIME, unit="s")),
}


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_every_form_gives_the_same_record_and_modes(form: str) -> None:
    record = as_record(FORMS[form])
    assert np.array_equal(record.y, VALUES)
    np.testing.assert_allclose(np.asarray(record.time) - record.time[0], TIME, rtol=0, atol=1e-9)
    if form != "pair":
        assert list(record.output_labels) == NAMES
    found = identify(FORMS[form]).modes
    np.testing.assert_allclose(found.poles, identify(RECORD).modes.poles, rtol=1e-6)


def test_durations_keep_their_zero_and_dates_begin_at_the_first_sample() -> None:
    late = pd.to_timedelta(TIME + 2.5, unit="s")
    np.testing.assert_allclose(as_record(table(index=late)).time, TIME + 2.5, rtol=0, atol=1e-9)
    dates = table(index=pd.Timestamp("2026-01-01") + late)
    np.testing.assert_allclose(as_record(dates).time, TIME, rtol=0, atol=1e-9)


def test_a_response_is_not_copied() -> None:
    assert as_record(RECORD) is RECORD


def test_arrays_need_a_rate_and_take_names_and_units() -> None:
    record = as_record(1e3 * VALUES, fs=FS, channels=NAMES, units={NAMES[0]: "mm"})
    np.testing.assert_allclose(record.y[0], VALUES[0], rtol=1e-12)
    np.testing.assert_allclose(record.y[1], 1e3 * VALUES[1], rtol=1e-15)
    assert list(record.output_labels) == NAMES
    assert as_record(VALUES[0].tolist(), fs=FS).y.shape == (1, 1000)
    assert np.array_equal(as_record(table(), timepts=TIME + 3.0).time, TIME + 3.0)


def test_xarray() -> None:
    xr: Any = pytest.importorskip("xarray")
    array = xr.DataArray(VALUES.T, dims=("time", "channel"), coords={"time": TIME, "channel": NAMES})
    for data in (array, array.to_dataset(dim="channel")):
        record = as_record(data)
        assert np.array_equal(record.y, VALUES)
        assert list(record.output_labels) == NAMES


def test_units_and_times_of_xarray() -> None:
    xr: Any = pytest.importorskip("xarray")
    array = xr.DataArray(VALUES, dims=("channel", "time"), coords={"channel": NAMES}, attrs={"units": "mm"})
    for made in (as_record(array, fs=FS), as_record(array.T, timepts=TIME)):
        np.testing.assert_allclose(made.y, 1e-3 * VALUES, rtol=1e-15)
        np.testing.assert_allclose(made.time, TIME, rtol=1e-12)
    assert np.array_equal(as_record(array, fs=FS, units=["m", "m", "m"]).y, VALUES)
    assert np.array_equal(as_record(array.assign_attrs(units="counts"), fs=FS).y, VALUES)
    stamped = array.assign_coords(time=("time", 1e3 * TIME, {"units": "ms"}))
    np.testing.assert_allclose(as_record(stamped).time, TIME, rtol=1e-12)
    with pytest.raises(RecordError, match="fs="):
        as_record(array)
    with pytest.raises(RecordError, match="not known"):
        as_record(array.assign_coords(time=("time", TIME, {"units": "furlong"})))
    with pytest.raises(RecordError, match="a dimension called time"):
        as_record(xr.DataArray(VALUES))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: as_record(VALUES), r"write as_record\(data, fs="),
        (lambda: identify(VALUES), r"write as_record\(data, fs="),
        (lambda: as_record(VALUES.T, fs=FS), r"\.T"),
        (lambda: as_record(table()), "no time"),
        (lambda: as_record(VALUES + 1j, fs=FS), "is complex"),
        (lambda: as_record(np.ma.masked_greater(VALUES, 0.0), fs=FS), "samples are masked"),
        (lambda: as_record([[1.0, 2.0], [1.0]], fs=FS), "different lengths"),
        (lambda: as_record(["a", "b"], fs=FS), "no numbers"),
        (lambda: as_record(table().assign(note="x"), fs=FS), r"'note'.*data.drop"),
        (lambda: as_record((TIME[:-1], VALUES)), "999 time points, but 1000 samples"),
        (lambda: as_record((TIME**2, VALUES)), "irregular"),
        (lambda: as_record((TIME + 3600 * (TIME > 1), VALUES)), "gap: after t = 1 s the next stamp is 3600.* s later"),
        (lambda: identify(np.where(TIME > 1, np.inf, VALUES), fs=FS), "not finite"),
        (lambda: cwt(VALUES[:, :3], fs=FS), "3 samples, too few for a transform"),
        (lambda: as_record(VALUES, fs=0.0), "must be a positive"),
        (lambda: as_record(VALUES, fs=True), "fs = True must be a positive"),
        (lambda: as_record(VALUES, fs=FS, timepts=TIME), "one of them"),
        (lambda: as_record(VALUES, fs=FS, channels=["a"]), "must name 3 channels"),
        (lambda: as_record(VALUES, fs=FS, units=["mm"]), "unit of each of 3 channels"),
        (lambda: as_record(VALUES, fs=FS, units={"z": "mm"}), "no such channel"),
        (lambda: as_record("decay.csv"), "read it with read_record"),
        (lambda: as_record(VALUES.astype(object), fs=FS), r"np.asarray\(data, float\)"),
        (lambda: as_record(control.TimeResponseList(2 * [RECORD])), "2 responses: .* identify_repeats"),
        (lambda: add_noise(VALUES, snr_db=20.0, rng=np.random.default_rng(1)), r"write as_record\(data, fs="),
        (lambda: as_record(table().assign(**{"time [furlong]": TIME})), "not known"),
    ],
)
def test_what_is_missing_is_said_with_the_next_step(make: Any, message: str) -> None:
    with pytest.raises(RecordError, match=message):
        make()


def test_every_verb_takes_a_table() -> None:
    data = FORMS["index of time"]
    assert np.array_equal(denoise(data).y, denoise(RECORD).y)
    mine, theirs = (cwt(form, omega=[70.0], bandwidth=4.0).rows[0] for form in (data, RECORD))
    assert np.array_equal(mine, theirs)
    assert [d.start for d in find_decays(data)] == [d.start for d in find_decays(RECORD)]
    assert np.array_equal(analyse(data).modes.poles, analyse(RECORD).modes.poles)
    assert np.array_equal(identify_repeats([data, data]).modes.poles, identify_repeats([RECORD, RECORD]).modes.poles)
    given = estimate(data, cars.HATCHBACK, fixed=["tire.damping"])
    assert np.array_equal(given.values, estimate(RECORD, cars.HATCHBACK, fixed=["tire.damping"]).values)
    assert len(analyse((TIME, VALUES)).modes) == 3


def test_the_transform_has_defaults_and_its_ridges_are_the_modes() -> None:
    decay = free_decay(cars.PAPER, np.arange(0, 10, 0.005), initial_state={"v_tire": 1.0})
    scalogram = cwt(decay)
    assert scalogram.wavelet.bandwidth == best_bandwidth(decay).best
    modes = fit_ridges(find_ridges(decay))
    np.testing.assert_allclose(modes.wn, eigenmodes(cars.PAPER).wn, rtol=1e-3)


def test_impulse_responses_of_several_inputs_are_one_record_with_the_systems_poles() -> None:
    system = statespace(cars.HATCHBACK)
    response = control.impulse_response(system, TIME)
    record = as_record(response)
    outputs, inputs = response.y.shape[:2]
    assert record.y.shape == (outputs * inputs, TIME.size)
    assert record.output_labels[1] == f"{system.output_labels[0]}_from_{system.input_labels[1]}"
    assert np.array_equal(record.y[1], response.y[0, 1])


@pytest.mark.parametrize("count", [1, 2])
def test_channels_are_named_after_inputs_where_there_are_several(count: int) -> None:
    system = statespace(cars.HATCHBACK)[:, :count]
    labels = as_record(control.impulse_response(system, TIME)).output_labels
    of_each = [f"{y}_from_{u}" for y in system.output_labels for u in system.input_labels]
    assert labels == (list(system.output_labels) if count == 1 else of_each)


def test_an_input_that_moves_nothing_is_no_trace() -> None:
    """Without damping in the tire the rate of the road moves nothing."""
    car = cars.HATCHBACK.with_parameters(damping={"tire": 0.0})
    found = identify(control.impulse_response(statespace(car), TIME))
    np.testing.assert_allclose(found.modes.wn, eigenmodes(car).wn, rtol=1e-6)


def test_columns_are_turned_where_that_is_clear() -> None:
    row, three = VALUES[:1], np.vstack([VALUES[0], 2 * VALUES[0], -VALUES[0]])
    # As scipy.io.loadmat returns a vector.
    assert np.array_equal(as_record(row.T, fs=FS).y, row)
    assert np.array_equal(as_record((TIME, three.T)).y, three)
    assert np.array_equal(as_record(three.T, timepts=TIME).y, three)
    with pytest.raises(RecordError, match="rows are channels"):
        as_record(three.T, fs=FS)
    # However near to a square they are.
    with pytest.raises(RecordError, match="rows are channels"):
        as_record(three[:, :2], fs=FS)


def test_plain_vectors_are_taken_with_their_rate() -> None:
    record = as_record(VALUES[0], fs=FS)
    assert np.array_equal(identify(VALUES[0], fs=FS).modes.poles, identify(record).modes.poles)
    assert np.array_equal(denoise(VALUES[0], fs=FS).y, denoise(record).y)
    assert np.array_equal(cwt(VALUES[0], fs=FS).omega, cwt(record).omega)
    assert best_bandwidth(VALUES[0], fs=FS).best == best_bandwidth(record).best
    assert [one.omega for one in find_ridges(VALUES[0], fs=FS)] == [one.omega for one in find_ridges(record)]
    assert [one.start for one in find_decays(VALUES[0], fs=FS)] == [one.start for one in find_decays(record)]
    assert np.array_equal(stabilization(VALUES[0], fs=FS).poles[0], stabilization(record).poles[0])
    whole = analyse(VALUES[0], settings=Settings(fs=FS))
    assert np.array_equal(whole.modes.poles, analyse(record).modes.poles)
    with pytest.raises(InputError, match="a clock already"):
        analyse(record, settings=Settings(fs=FS))


def test_a_response_without_a_title_is_described_by_its_samples() -> None:
    found = identify(control.initial_response(control.tf2ss([1.0], [1.0, 2.0, 400.0]), TIME, [1.0, 0.0]), modes=1)
    assert repr(found).endswith("1 channel: y[0]>")
    assert "object at" not in repr(found)


def test_frequency_responses_have_none() -> None:
    with pytest.raises(InputError, match=r"control\.TransferFunction"):
        eigenmodes(control.frd([1], [1.0]))


def test_transfer_functions_have_modes() -> None:
    system = control.tf([1.0], [1.0, 0.4, 25.0])
    np.testing.assert_allclose(eigenmodes(system).poles, [-0.2 + 1j * np.sqrt(25 - 0.04)], rtol=1e-12)


@pytest.mark.parametrize("modes", [0, -1, 1.5, True, "two"])
def test_a_number_of_modes_is_whole(modes: Any) -> None:
    with pytest.raises(InputError, match="whole number from 1 on"):
        identify(RECORD, modes=modes)


class TestModesOneByOne:
    def test_a_mode_keeps_pole_shape_and_covariance(self) -> None:
        whole = identify(RECORD).modes
        assert whole.covariance is not None
        assert whole.shapes is not None
        for k, mode in enumerate(whole):
            assert (len(mode), mode.poles[0]) == (1, whole.poles[k])
            assert mode.shapes is not None
            assert np.array_equal(mode.shapes[:, 0], whole.shapes[:, k])
            np.testing.assert_array_equal(mode.interval(0.9).wn[0], whole.interval(0.9).wn[k])
            np.testing.assert_array_equal(mode.interval(0.9).zeta[0], whole.interval(0.9).zeta[k])
        swapped = whole[[2, 0, 1]]
        assert swapped.covariance is not None
        assert np.array_equal(swapped.covariance, whole.covariance)

    def test_slices_and_masks(self) -> None:
        modes = ModalSet.from_wn_zeta([1.0, 2.0, 3.0], [0.1, 0.2, 0.3])
        assert modes[1:].wn.tolist() == [2.0, 3.0]
        assert modes[-1].zeta.tolist() == pytest.approx([0.3])
        assert modes[modes.zeta > 0.15].wn.tolist() == pytest.approx([2.0, 3.0])
        with pytest.raises(IndexError, match="no mode 3"):
            modes[3]


def test_reading_in_threads_leaves_the_host_as_it_was(tmp_path: Path) -> None:
    for k in range(8):
        wavfile.write(tmp_path / f"{k}.wav", 800, (1e4 * VALUES[0] / np.max(np.abs(VALUES[0]))).astype(np.int16))
    stdout, stderr, hook, level = sys.stdout, sys.stderr, sys.unraisablehook, logging.root.manager.disable
    shown = io.StringIO()
    written = 0

    def read(path: Path) -> None:
        with contextlib.suppress(SuspidError), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read_record(path)

    with contextlib.redirect_stdout(shown), ThreadPoolExecutor(4) as pool:
        done = [pool.submit(read, path) for path in sorted(tmp_path.glob("*.wav")) * 5]
        while not all(one.done() for one in done):
            sys.stdout.write("x")
            written += 1
    assert [one.result() for one in done] == [None] * 40
    assert (sys.stdout, sys.stderr, sys.unraisablehook) == (stdout, stderr, hook)
    assert logging.root.manager.disable == level
    assert shown.getvalue().count("x") == written > 0


class TestDrives:
    CAR = quarter_car(
        chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=1500
    )
    SHOWN = ("chassis_acceleration", "tire_acceleration")

    def driven(self, duration: float, step: float) -> tuple[Any, Any, Any]:
        """Return motions as a response and as a table, and the heights of the road as a table."""
        pandas = pytest.importorskip("pandas")
        t = np.arange(0, duration, step)
        heights = road_profile(20.0 * t, roughness="B", rng=np.random.default_rng(3))
        response = simulate(self.CAR, t, {"road": heights}, outputs=self.SHOWN)
        table = pd.DataFrame({"time": t, **dict(zip(self.SHOWN, response.outputs, strict=True))})
        return response, table, pandas.Series(heights, index=pandas.Index(t, name="time"), name="road")

    def test_every_verb_of_drives_takes_a_table(self) -> None:
        response, table, heights = self.driven(60, 0.01)
        assert ride(table).values == pytest.approx(ride(response).values, rel=1e-12)
        assert classify_road(heights, speed=20).name == "B"
        assert find_drives(table).usable == find_drives(response).usable > 50
        mine, theirs = (damper_curve(given, self.CAR, strut="chassis", nodes=4) for given in (table, [response]))
        np.testing.assert_array_equal(mine.forces, theirs.forces)

    def test_a_body_in_a_table(self) -> None:
        response, table, _ = self.driven(240, 0.02)
        mine, theirs = (
            body_modes(given, channels=self.SHOWN[:1], rng=np.random.default_rng(1)) for given in (table, [response])
        )
        assert mine[0].hertz == theirs[0].hertz


@pytest.mark.parametrize("wrong", [{"fs": "fast"}, {"fs": [100]}, {"timepts": "abcd"}])
def test_rates_and_times_that_are_no_numbers(wrong: dict[str, Any]) -> None:
    with pytest.raises(RecordError, match="number"):
        as_record(np.ones((2, 4)), **wrong)


def test_units_in_order_hold_for_channels_of_one_name() -> None:
    record = as_record(np.ones((2, 5)), fs=1, channels=["seat", "seat"], units=["m", "mm"])
    assert np.array_equal(record.y[:, 0], [1.0, 1e-3])


@pytest.mark.parametrize("columns", [[], ["seat"]])
def test_a_table_without_rows(columns: list[str]) -> None:
    table = pytest.importorskip("pandas").DataFrame(columns=columns, dtype=float)
    table.index = table.index.astype("datetime64[ns]")
    with pytest.raises(RecordError, match="contains no samples"):
        as_record(table)


class TestUnitsInNames:
    """What is converted once is not converted again by what a name says."""

    NOISE = np.random.default_rng(0).standard_normal(4000)

    def test_a_converted_channel_states_the_unit_it_has(self) -> None:
        pd = pytest.importorskip("pandas")
        stated = as_record(self.NOISE, fs=200, channels=["seat_acceleration [g]"], units=["g"])
        table = pd.DataFrame({"seat_acceleration [g]": self.NOISE}, index=pd.Index(np.arange(4000) / 200, name="t [s]"))
        by_name = as_record(table, units={"seat_acceleration [g]": "g"})
        for record in (stated, by_name):
            assert record.output_labels == ["seat_acceleration [m/s2]"]
        # The same samples without a unit are in g by their name: both are the same ride.
        left = as_record(self.NOISE, fs=200, channels=["seat_acceleration [g]"])
        one, other = (ride(record).values for record in (stated, left))
        np.testing.assert_allclose(one, other)

    def test_a_unit_against_the_name_is_refused(self) -> None:
        with pytest.raises(RecordError, match=r"'mm' by units, and one of m/s2 by its name"):
            as_record(self.NOISE, fs=200, channels=["seat [g]"], units=["mm"])

    def test_of_xarray(self) -> None:
        xr = pytest.importorskip("xarray")
        coords = {"time": np.arange(4000) / 200}
        array = xr.DataArray(self.NOISE, dims="time", coords=coords, name="acc [g]", attrs={"units": "g"})
        record = as_record(array)
        assert record.output_labels == ["acc [m/s2]"]
        assert np.std(record.y) == pytest.approx(9.80665 * np.std(self.NOISE))
        both = {"a": ("time", self.NOISE, {"units": "mm"}), "b": ("time", self.NOISE, {"units": "weird"})}
        with pytest.raises(RecordError, match=r"the unit of 'b' is not known"):
            as_record(xr.Dataset(both, coords=coords))
        other = xr.DataArray(self.NOISE, dims="time", coords=coords, name="acc [g]", attrs={"units": "mm"})
        with pytest.raises(RecordError, match=r"'mm' by units, and one of m/s2 by its name"):
            as_record(other)


@pytest.mark.parametrize("place", [0, 6, 199])
def test_a_date_that_is_none_is_no_time(place: int) -> None:
    pd = pytest.importorskip("pandas")
    stamps = pd.Series(pd.to_datetime(np.arange(200) * 1e7))
    stamps[place] = pd.NaT
    with pytest.raises(RecordError, match=f"1 of 200 time stamps are not finite, the first is number {place + 1}"):
        as_record(pd.DataFrame({"y": np.arange(200.0)}, index=pd.DatetimeIndex(stamps)))


class TestTimesOfDay:
    """Clocks as text, as `pandas.read_csv` leaves them: the time of the record, as in a file."""

    STAMPS = pd.date_range("2024-05-01 23:59:59", periods=200, freq="10ms")
    SAMPLES = np.exp(-np.arange(200) / 100)

    @pytest.mark.parametrize(
        "form", ["%H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f", "%H:%M:%S,%f", "%I:%M:%S.%f %p"]
    )
    @pytest.mark.parametrize("where", ["column", "strings", "index", "pair", "timepts", "unnamed"])
    def test_they_are_the_time(self, form: str, where: str) -> None:
        texts = [stamp.strftime(form) for stamp in self.STAMPS]
        frame = pd.DataFrame({"time": texts, "seat": self.SAMPLES})
        record = {
            "column": lambda: as_record(frame),
            "strings": lambda: as_record(frame.astype({"time": "string"})),
            "index": lambda: as_record(frame.set_index("time")),
            "pair": lambda: as_record((texts, self.SAMPLES)),
            "timepts": lambda: as_record(self.SAMPLES, timepts=texts),
            "unnamed": lambda: as_record(frame.rename(columns={"time": "column 1"})),
        }[where]()
        np.testing.assert_allclose(record.time, np.arange(200) / 100, atol=1e-9)
        assert len(record.output_labels) == 1

    def test_objects_of_python(self) -> None:
        for times in (
            [s.time() for s in self.STAMPS],
            [s.to_pydatetime() for s in self.STAMPS],
            self.STAMPS.to_numpy(),
        ):
            np.testing.assert_allclose(as_record((times, self.SAMPLES)).time, np.arange(200) / 100, atol=1e-9)

    def test_texts_that_are_none_name_the_way(self) -> None:
        frame = pd.DataFrame({"time": [str(k) for k in range(200)], "seat": self.SAMPLES})
        with pytest.raises(RecordError, match=r"data\['time'\] = pandas.to_numeric"):
            as_record(frame)
        frame = pd.DataFrame({"time": self.STAMPS, "seat": ["0,5"] * 200})
        with pytest.raises(RecordError, match=r"pandas.to_numeric\(data\['seat'\].str.replace"):
            as_record(frame)
        with pytest.raises(RecordError, match=r"leave them out, as in data.drop\(columns=\['gear'\]\)"):
            as_record(pd.DataFrame({"time": self.STAMPS, "seat": self.SAMPLES, "gear": ["N"] * 200}))

    def test_numbers_that_are_objects_need_no_text_function(self) -> None:
        frame = pd.DataFrame({"time": self.STAMPS, "seat": np.array(self.SAMPLES, object)})
        with pytest.raises(RecordError, match=r"as in pandas.to_numeric\(data\['seat'\]\), or"):
            as_record(frame)


def test_a_table_of_arrow_is_one_of_pandas() -> None:
    arrow = pytest.importorskip("pyarrow").table({"time": TIME, "seat": VALUES[0]})
    record = as_record(arrow)
    assert record.output_labels == ["seat"]
    np.testing.assert_array_equal(record.time, TIME)


class TestTablesOfSeveralLevels:
    def test_columns_are_named_by_all_levels(self) -> None:
        assert as_record(pd.DataFrame({("imu", "z"): TIME}, index=TIME)).output_labels == ["imu_z"]

    def test_one_record_of_an_index_is_chosen(self) -> None:
        index = pd.MultiIndex.from_product([["left", "right"], TIME], names=["side", "time"])
        runs = pd.DataFrame({"seat": np.concatenate([VALUES[0], VALUES[1]])}, index=index)
        with pytest.raises(RecordError, match=r"2 levels.*data.xs\('left'\)"):
            as_record(runs)
        np.testing.assert_array_equal(as_record(runs.xs("left")).y, VALUES[:1])

    def test_the_time_in_another_unit_is_no_channel(self) -> None:
        frame = pd.DataFrame({"time": TIME, "t_ms": 1e3 * TIME, "seat": VALUES[0], "timestamp": 1e3 * TIME})
        record = as_record(frame)
        assert record.output_labels == ["seat"]
        np.testing.assert_array_equal(record.time, TIME)


def test_milliseconds_without_a_name_are_warned_of() -> None:
    for data, given in ((VALUES, {"timepts": 1e3 * TIME}), ((1e3 * TIME, VALUES), {}), (VALUES, {"fs": 1 / FS})):
        with pytest.warns(RecordWarning, match="too slow for a suspension: times are in s") as said:
            as_record(data, **given)
        assert said[0].filename == __file__


def test_minutes_without_a_name_are_warned_of() -> None:
    """At 2400 Hz and more such a table may be meant in seconds, so it is taken."""
    minutes = TIME / 60 / 12
    for table in (
        pd.DataFrame({"time": minutes, "seat": VALUES[0]}),
        pd.DataFrame({"seat": VALUES[0]}, index=minutes),
        pd.Series(VALUES[0], index=pd.Index(minutes, name="time")),
    ):
        with pytest.warns(RecordWarning, match=r"taken as s: .* or 'time \[min\]' if it is in minutes") as said:
            as_record(table)
        assert said[0].filename == __file__
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            as_record(
                table.rename_axis("time [min]") if "time" not in table else table.rename(columns={"time": "t [s]"})
            )


def test_seconds_that_a_column_states_are_believed() -> None:
    """However slow the steps are; a bare number of them is warned of."""
    slow = {"t [s]": 5.0 * np.arange(40), "level": np.cos(np.arange(40))}
    assert as_record(pd.DataFrame(slow)).time[1] == 5.0
    with pytest.warns(RecordWarning, match="steps of 5 s are too slow"):
        as_record(tuple(slow.values()))


def test_a_pair_is_one_record_where_several_are_taken() -> None:
    assert records_of((TIME, VALUES)) == [(TIME, VALUES)]
    with pytest.raises(SuspidError, match="no channel of the record measures the suspension: 'y"):
        estimate((TIME, VALUES), cars.PAPER)


def test_traces_of_one_name_are_numbered() -> None:
    system = control.ss([[0, 1], [-100, -2]], [[0], [1]], [[1, 0]], 0)
    runs = [control.initial_response(system, TIME, start) for start in ([1, 0], [0, 1])]
    one, other = as_record(control.combine_time_responses(runs)).output_labels
    assert one.endswith(" 1")
    assert other == f"{one[:-1]}2"
