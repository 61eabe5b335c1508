"""One recipe: the library, the commands and the report find the same modes and verdict in the same record."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click
import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import (
    Analysis,
    CarSettings,
    IdentificationError,
    InputError,
    Level,
    RecordError,
    Settings,
    add_noise,
    analyse,
    free_decay,
    identify,
    read_recording,
    report,
    report_to_dict,
    write_record,
)
from suspid.cli.main import main
from suspid.cli.option_names import in_options
from suspid.errors import SuspidError
from suspid.fleet.job import Job
from suspid.fleet.records import Entry
from suspid.fleet.rows import record_rows
from suspid.model import read_car
from suspid.records import as_response
from suspid.reporting import json_schema
from suspid.signals import as_signal
from suspid.words import Note, RecordCheck, next_steps
from validation import cars
from validation.greybox_bounds import value_of
from validation.greybox_rows import free_decays

pytestmark = pytest.mark.usefixtures("words_alone")

ROOT = Path(__file__).parents[1]
DATA = ROOT.parent / "shared" / "data"
EXAMPLE = ROOT / "examples" / "quarter_car.csv"
RECORDS = [
    EXAMPLE,
    *[
        pytest.param(DATA / name, marks=pytest.mark.slow)
        for name in (
            "vibtest_inout_mat/case1.mat",
            "bicycle_pendulum_mat/BrowserForkCompoundFirst1.mat",
            "rizoit_seat3dof_sim/chirp.csv",
            "rizoit_seat3dof_sim/step50mm.csv",
            "rizoit_seat3dof_sim/release.csv",
            "css_canedge_car_mf4/00000164_00000001-60FE3F04.MF4",
            "css_canedge_car_mf4/00000164_00000002-60FE415D.MF4",
            "css_canedge_car_mf4/stationary_2F6913DB_00000004_00000001.MF4",
            "pyuff_uff58_mps/MPSTD#Set001_2024_10_08_10_27_07.uff",
        )
    ],
]


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], catch_exceptions=False)


def late_bump(path: Path) -> Path:
    """Write half a minute of quiet noise with a decay after ten seconds."""
    noise = np.random.default_rng(3).standard_normal((3, 6000))
    values = 1e-4 * noise
    decay = free_decay(cars.HATCHBACK, np.arange(4000) / 200, initial_state={"v_tire": 1.0})
    values[:, 2000:] += decay.y
    write_record(as_response(np.arange(6000) / 200, values, as_signal(decay).channels), path)
    return path


@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.name)
def test_library_commands_report_and_fleet_agree(path: Path, tmp_path: Path) -> None:
    if not path.exists():
        pytest.skip("the shared records are not here")
    for suffix, library in ((".MF4", "asammdf"), (".uff", "pyuff")):
        if path.suffix == suffix:
            pytest.importorskip(library)
    agree(path, tmp_path)


@pytest.mark.slow
def test_they_agree_on_a_decay_late_in_a_recording(tmp_path: Path) -> None:
    assert len(agree(late_bump(tmp_path / "bump.csv"), tmp_path)) == 3


def agree(path: Path, folder: Path) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    dbc = path.parent / "canmod-gps.dbc"
    options = ["--dbc", dbc] if dbc.exists() else []
    settings = Settings(dbc=dbc if dbc.exists() else None)
    found = analyse(path, settings=settings)
    # What to do next is named as on the command line.
    with in_options(main.get_command(click.Context(main), "identify")):
        verdict = found.verdict.to_dict()
    again = identify(found.identification.response)
    assert np.array_equal(again.modes.poles, found.identification.modes.poles)
    row_of_fleet(path, settings, found)
    assert run("identify", path, "--json", folder / "modes.json", *options).exit_code == 0
    told = run("report", path, "-o", folder / "page.html", "--json", folder / "page.json", *options)
    assert told.exit_code == 0
    for name in ("modes.json", "page.json"):
        content = json.loads((folder / name).read_text(encoding="utf-8"))
        assert [mode["wn_rad_per_s"] for mode in content["modes"]] == found.modes.wn.tolist()
        assert [mode["zeta"] for mode in content["modes"]] == found.modes.zeta.tolist()
        assert content["verdict"] == verdict
    return np.asarray(found.modes.wn)


def row_of_fleet(path: Path, settings: Settings, found: Analysis) -> None:
    """Compare the rows that a worker of `suspid fleet` makes of a file."""
    rows = record_rows(Job(settings=settings), Entry(name=path.name, path=str(path)), lambda _: None)
    assert [row["wn_rad_per_s"] for row in rows.modes] == found.modes.wn.tolist()
    assert [row["zeta"] for row in rows.modes] == found.modes.zeta.tolist()
    assert {row["verdict"] for row in rows.modes} <= {found.verdict.level.label}
    # A record without a mode is a row among the failures, with the doubts of its verdict.
    assert [row["code"] for row in rows.failures] == ([] if len(found.modes) else ["no mode"])
    doubts = {str(one.code) for one in found.verdict.doubts}
    for row in rows.modes:
        assert set(row["doubts"]) == doubts  # type: ignore[call-overload]
    for row in rows.failures:
        assert doubts <= set(row["checks"])  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("name", "library"),
    [
        ("pyuff_uff58_mps/time-history-not-all-columns-filled.uff", "pyuff"),
        ("vibtest_inout_mat/mckiddat.mat", "scipy"),
    ],
)
def test_what_cannot_be_used_is_refused_in_the_same_words(name: str, library: str) -> None:
    pytest.importorskip(library)
    path = DATA / name
    if not path.exists():
        pytest.skip("the shared records are not here")
    with pytest.raises(RecordError) as refused:
        analyse(path)
    (row,) = record_rows(Job(settings=Settings()), Entry(name=path.name, path=str(path)), lambda _: None).failures
    assert row["reason"] == refused.value.message
    for command in (["identify", path], ["report", path, "-o", "none.html"]):
        told = run(*command)
        assert told.exit_code == 1
        # Arguments are options there.
        with in_options(main.get_command(click.Context(main), str(command[0]))), pytest.raises(RecordError) as again:
            analyse(path)
        assert told.output.strip() == f"suspid: error: {again.value}"


def test_a_recording_is_its_file() -> None:
    found = analyse(read_recording(EXAMPLE))
    assert np.array_equal(found.modes.poles, analyse(EXAMPLE).modes.poles)


class TestSettings:
    def test_channels_by_their_bare_names_and_left_out(self, tmp_path: Path) -> None:
        path = tmp_path / "r.csv"
        record = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        write_record(record, path, units=["m", "m", "m"])
        found = analyse(path, settings=Settings(without=("chassis",), scale={"seat": -2.0}, rename={"tire": "wheel"}))
        assert as_signal(found.record).channels == ("seat", "wheel")
        assert np.array_equal(as_signal(found.record).values[0], -2.0 * as_signal(record).values[0])

    def test_a_channel_is_chosen_by_its_name_before(self, tmp_path: Path) -> None:
        path = tmp_path / "decay.csv"
        record = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        write_record(record, path)
        for source in (path, record):
            with pytest.raises(RecordError, match="chosen before they are renamed: choose 'tire' instead of 'wheel'"):
                analyse(source, settings=Settings(channels=("seat", "wheel"), rename={"tire": "wheel"}))
            found = analyse(
                source, settings=Settings(channels=("seat", "tire"), rename={"tire": "seat", "seat": "tire"})
            )
            assert as_signal(found.record).channels == ("tire", "seat")

    def test_a_channel_that_stood_still_may_be_renamed(self, tmp_path: Path) -> None:
        """The same names serve a rig and a release beside it, whose road does not move."""
        path = tmp_path / "release.csv"
        record = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        rows = np.vstack([as_signal(record).values, np.zeros(2500)])
        write_record(as_response(np.arange(0, 5, 0.002), rows, ("seat", "chassis", "tire", "z0")), path)
        found = analyse(path, settings=Settings(rename={"z0": "road", "tire": "wheel"}))
        assert as_signal(found.record).channels == ("seat", "chassis", "wheel")
        with pytest.raises(SuspidError, match="there is no channel 'z1'"):
            analyse(path, settings=Settings(rename={"z1": "road"}))

    def test_a_record_is_taken_as_it_is(self) -> None:
        record = free_decay(cars.PAPER, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        found = analyse(record)
        assert found.record is record
        assert found.recording is None

    def test_a_stretch_is_cut(self, tmp_path: Path) -> None:
        found = analyse(late_bump(tmp_path / "bump.csv"), settings=Settings(start=12.0, stop=20.0))
        assert np.isclose(as_signal(found.identification.response).start, 12.0)
        assert not found.decays

    @pytest.mark.parametrize(
        "wrong",
        [
            {"decay": "al"},
            {"decay": 0},
            {"decay": "all", "start": 1.0},
            {"level": 1.0},
            {"decay": "all", "method": "ridge"},
        ],
    )
    def test_contradictions_are_refused(self, wrong: dict[str, object]) -> None:
        with pytest.raises(InputError):
            Settings(**wrong)  # type: ignore[arg-type]

    def test_settings_come_back_from_json(self) -> None:
        settings = Settings(
            channels=("seat",), rename={"seat": "s"}, band_hz=(1.0, 2.0), springs=CarSettings(fixed=("a",))
        )
        assert json.loads(json.dumps(settings.to_dict()))["springs"]["fixed"] == ["a"]

    @pytest.mark.parametrize(
        ("start", "stop", "said"),
        [(-3.0, 1.0, True), (0.1, 20.0, True), (-0.001, 1.99, False), (0.1, 2.001, False), (None, 20.0, True)],
    )
    def test_times_outside_the_record_are_said(self, start: float | None, stop: float, said: bool) -> None:
        t = np.arange(400) / 200
        found = analyse((t, np.exp(-t) * np.cos(20 * t)), settings=Settings(start=start, stop=stop, modes=1))
        outside = [str(note) for note in found.notes if note.code is Note.OUTSIDE]
        assert outside == ["the record lasts from 0 to 1.995 s; start or stop is outside of it"] * said

    def test_a_rank_that_is_not_there(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="no decay of rank 7"):
            analyse(late_bump(tmp_path / "bump.csv"), settings=Settings(decay=7))


class TestVerdict:
    def test_springs_enter(self) -> None:
        record = free_decay(cars.PAPER, np.arange(0, 10, 0.002), initial_state={"v_tire": 1.0})
        noisy = add_noise(record, snr_db=40.0, rng=np.random.default_rng(5))
        right = analyse(noisy, car=cars.PAPER)
        assert right.verdict.level is Level.SOUND
        stiff = replace(cars.PAPER, masses={**cars.PAPER.masses, "seat": 400.0})
        assert analyse(noisy, car=stiff).verdict.level < Level.SOUND

    @pytest.mark.parametrize("held", [pytest.param(True, marks=pytest.mark.slow), False])
    def test_defects_left_alone_call_for_care(self, held: bool, tmp_path: Path) -> None:
        decay = free_decay(cars.PAPER, np.arange(4000) / 400, initial_state={"v_tire": 1.0})
        signal = as_signal(add_noise(decay, snr_db=40.0, rng=np.random.default_rng(5)))
        values = signal.values.copy()
        if held:
            # A converter that passes on each sample four times, beside others.
            values[0] = np.repeat(values[0, ::4], 4)
        write_record(as_response(signal.timepts, values, signal.channels), tmp_path / "r.csv")
        found = analyse(tmp_path / "r.csv")
        defects = [check for check in found.verdict.checks if check.remark.code is RecordCheck.DEFECTS]
        assert [check.level for check in defects] == [Level.CARE] * held
        assert (found.verdict.level is Level.SOUND) is not held

    def test_a_rate_that_contradicts_the_stamps_is_a_doubt(self, tmp_path: Path) -> None:
        decay = free_decay(cars.PAPER, np.arange(2000) / 400, initial_state={"v_tire": 1.0})
        write_record(add_noise(decay, snr_db=40.0, rng=np.random.default_rng(5)), tmp_path / "r.csv")
        found = analyse(tmp_path / "r.csv", settings=Settings(fs=500.0))
        assert found.verdict.level is Level.CARE
        assert any("400 Hz" in str(doubt) for doubt in found.verdict.doubts)
        assert analyse(tmp_path / "r.csv", settings=Settings(fs=400.0)).verdict.level is Level.SOUND


@pytest.mark.parametrize("settings", [Settings(modes=9), Settings(decay=7), Settings(start=1e3), Settings(test="x")])
def test_every_error_names_the_file_and_keeps_what_it_carries(settings: Settings) -> None:
    path = ROOT / "examples" / "quarter_car.csv"
    with pytest.raises(SuspidError) as refusal:
        analyse(path, settings=settings)
    assert str(refusal.value).startswith(f"{path}: ")
    assert str(refusal.value).count(path.name) == 1
    if settings.modes:
        assert isinstance(refusal.value, IdentificationError)
        assert refusal.value.found is not None


class TestSpringsFromTheRecord:
    """Where modes do not settle springs and dampers, the record itself does."""

    ROW = next(row for row in free_decays() if row.name == "half car, modes 2% apart, 40 dB")

    def found(self, *constraints: str) -> Analysis:
        springs = CarSettings(fixed=self.ROW.fixed, constraints=constraints)
        record = self.ROW.record(np.random.default_rng(5))
        return analyse(record, car=self.ROW.nominal, settings=Settings(springs=springs))

    @pytest.mark.slow
    def test_close_modes_are_estimated(self) -> None:
        found = self.found()
        assert found.estimate is not None
        for name, value, std in zip(found.estimate.parameters, found.estimate.values, found.estimate.std, strict=True):
            # Five standard deviations: one false alarm in two million.
            assert abs(value - value_of(self.ROW.car, name)) < 5 * std, name
        assert found.verdict.level is Level.SOUND
        assert "significant" in str(found)
        page, content = report(found), report_to_dict(found)
        assert page.index('id="springs"') < page.index('id="modes"')
        assert "Assumed masses" in page
        jsonschema.validate(content, json_schema("report"))
        estimated = content["estimate"]
        assert isinstance(estimated, dict)
        assert [p["name"] for p in estimated["parameters"]] == list(found.estimate.parameters)

    def test_settled_modes_are_not(self) -> None:
        record = free_decay(cars.HATCHBACK, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        noisy = add_noise(record, snr_db=40.0, rng=np.random.default_rng(1))
        found = analyse(noisy, car=cars.HATCHBACK)
        assert found.reconstruction is not None
        assert found.estimate is None
        assert report_to_dict(found)["estimate"] is None

    def test_constraints_are_those_of_the_modes_alone(self) -> None:
        assert self.found("front.stiffness >= 1e3").estimate is None

    def test_a_record_that_measures_nothing_is_said(self) -> None:
        record = free_decay(cars.HATCHBACK, np.arange(0, 5, 0.002), initial_state={"v_tire": 1.0})
        noisy = as_signal(add_noise(record, snr_db=40.0, rng=np.random.default_rng(1)))
        found = analyse(as_response(noisy.timepts, noisy.values, ["a", "b", "c"]), car=cars.SALOON)
        assert found.estimate is None
        assert Note.NO_ESTIMATE in [note.code for note in found.notes] or found.reconstruction is not None


class TestCommandsAreNoMotion:
    def test_a_force_that_is_switched_is_left_out(self, tmp_path: Path) -> None:
        # A rig of one mass is pushed by a constant force from 1 s on; the file has the force beside the position.
        times = np.arange(4000) / 500
        since = np.maximum(times - 1.0, 0.0)
        moved = 1 - np.exp(-1.2 * since) * (np.cos(15.0 * since) + 1.2 / 15.0 * np.sin(15.0 * since))
        noise = 1e-4 * np.random.default_rng(0).standard_normal(times.size)
        file = tmp_path / "step.csv"
        table = np.column_stack([times, moved + noise, np.where(times >= 1.0, 40.0, 0.0)])
        np.savetxt(file, table, delimiter=",", header="time,position,effort", comments="", fmt="%.6g")
        found = analyse(file)
        assert any(note.code is Note.HELD_CHANNEL for note in found.notes)
        # The start of a step may leave a pole that dies within two samples; it is never called sound.
        first, *others = found.identification.modes.poles
        assert first == pytest.approx(-1.2 + 15.0j, rel=1e-3)
        assert not others or found.verdict.level < Level.SOUND


def test_what_is_said_of_springs_is_printed_once() -> None:
    """The one verdict of an analysis has the checks of its springs and dampers, each of them once."""
    root = Path(__file__).resolve().parents[1] / "examples"
    lines = str(analyse(root / "quarter_car.csv", car=read_car(root / "nominal_car.toml"))).splitlines()
    notes = [line for line in lines if line.startswith(("Verdict", "note", "- "))]
    assert len(notes) == len(set(notes))
    assert sum(line.startswith("Verdict") for line in notes) == 1
    assert any("Significantly different from nominal" in line for line in notes)


def test_names_that_the_car_does_not_know_come_before_further_sensors(tmp_path: Path) -> None:
    """Three sensors that are there, under other names, say more than a further one would."""
    root = Path(__file__).resolve().parents[1] / "examples"
    _, _, rows = (root / "quarter_car.csv").read_text(encoding="utf-8").partition("\n")
    for names, codes in (("z1,z2,z3", ["rename"]), ("seat,chassis,tire", ["use"])):
        (tmp_path / "r.csv").write_text(f"time [s],{names}\n{rows}", encoding="utf-8")
        found = analyse(tmp_path / "r.csv", car=read_car(root / "nominal_car.toml"))
        steps = [str(step.code) for step in next_steps(found.verdict, car=True)]
        assert [step for step in steps if step in ("rename", "add mass", "use")] == codes
