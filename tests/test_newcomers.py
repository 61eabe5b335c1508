"""Mistakes of newcomers: none leaves them without the next step."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import suspid
from suspid import Limit, ModalSet, Settings, SuspidError
from suspid.cli import main
from suspid.cli.option_groups import GROUPS
from suspid.cli.option_names import ARGUMENTS_AS_OPTIONS

RECORD, CAR = "examples/quarter_car.csv", "examples/car.toml"
DECAY = np.exp(-0.5 * np.arange(0, 4, 0.01)) * np.cos(20 * np.arange(0, 4, 0.01))
# What a next step sounds like: a known name, the right form, a command, an option or a place to look.
STEP = re.compile(
    r"Did you mean|Known|known|such as|write |give |name |choose|install|see |use |take |read |must |lasts from|"
    r"Try |--|ask for|pass |is not one of|needs|leave|check|give|describe|remove|positive|as_record|eigenmodes|between|"
    r"call |widen |`suspid ",
)

QUARTER = suspid.quarter_car(
    chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=2e5, chassis_damping=1500
)
# Arguments and functions as they are written in Python.
IN_PYTHON = [name for name in (*ARGUMENTS_AS_OPTIONS, *suspid.__all__) if "_" in name and name.islower()]
PYTHON = re.compile(
    rf"\b[a-z_]+=[('\[]|\b[a-z_]+\['|(?<![\w./'-])({'|'.join(IN_PYTHON)})(?!\w)|\(({'|'.join(ARGUMENTS_AS_OPTIONS)})[,)]"
)

COMMANDS = [
    "identfy x.csv",
    "identify",
    "identify nowhere.csv",
    "identify examples",
    "identify README.md",
    f"identify {RECORD} --chanel seat",
    f"identify {RECORD} --channel seats",
    f"identify {RECORD} --channel seat,seat",
    f"identify {RECORD} --without seat,chassis,tire",
    f"identify {RECORD} --modes 0",
    f"identify {RECORD} --modes three",
    f"identify {RECORD} --method wavelet",
    f"identify {RECORD} --band 5 2",
    f"identify {RECORD} --band 5",
    f"identify {RECORD} --band 300 400",
    f"identify {RECORD} --from 50",
    f"identify {RECORD} --from 5 --to 2",
    f"identify {RECORD} --from abc",
    f"identify {RECORD} --fs 0",
    f"identify {RECORD} --fs 500Hz",
    f"identify {RECORD} --decay last",
    f"identify {RECORD} --decay all --method ridge",
    f"identify {RECORD} --rename seat",
    f"identify {RECORD} --scale seat=mm",
    f"identify {RECORD} --scale seat=0",
    f"identify {RECORD} --vertical x,y",
    f"identify {RECORD} --vertical x,y,z",
    f"identify {RECORD} --time clock",
    f"identify {RECORD} --test second",
    f"identify {RECORD} --plot page.doc",
    f"identify {RECORD} {RECORD}",
    f"report {RECORD}",
    f"report {RECORD} -o page.docx",
    f"report {RECORD} -o r.html --car {RECORD}",
    f"report {RECORD} -o r.html --car nominal.toml",
    f"report {RECORD} -o r.html --limits {CAR}",
    f"report {RECORD} -o r.html --format pdf",
    f"report {RECORD} -o r.html --level 95",
    f"report {RECORD} -o r.html --road C",
    f"reconstruct {RECORD} {CAR}",
    f"reconstruct modes.json {CAR}",
    f"modes {RECORD}",
    f"simulate {CAR} -o d.csv --fs 100 --duration 2 --initial v_wheel=1",
    f"simulate {CAR} -o d.csv --fs 100 --duration 2 --initial v_tire",
    f"estimate {RECORD}",
    f"estimate {RECORD} --car {CAR} --given rode",
    f"estimate {RECORD} --car {CAR} --fixed spring",
    "compare before.json",
    "channels nothing.mat",
    f"drive {RECORD} --car {RECORD}",
    f"identify {RECORD} --units mm",
    f"identify {RECORD} -o modes.json",
    f"identify {RECORD} --from 9.99",
    f"identify {RECORD} --channel seat --without seat",
    f"identify {RECORD} --rename seat=chassis",
    f"identify {RECORD} --modes 30",
    f"identify {CAR}",
    f"reconstruct {CAR} {RECORD}",
    f"report {RECORD} -o r.html --level 95%",
    f"estimate {RECORD} --car {CAR} --road C",
    f"estimate {RECORD} --car {CAR} --nominal-std 30%",
    f"estimate {RECORD} --car {CAR} --mount tyre",
    f"estimate {RECORD} --car {CAR} --bound seat.stiffness 5 1",
    f"ride {CAR}",
    f"ride {CAR} --road X --speed 20",
    f"ride {CAR} --road C --speed 72km/h",
    f"tune {CAR} --road C --speed 20 --objective comfort",
    f"tune {CAR} --road C --speed 20 --parameter damping",
    f"simulate {CAR} -o d.csv --snr 20",
    f"simulate {CAR} -o d.csv --road C --speed 20",
    f"simulate {CAR} -o d.xyz --impulse road",
    f"compare {RECORD} {CAR}",
    "fleet examples",
    "fleet nowhere -o results",
    "fleet --summary examples",
    "fleet examples -o results --table nothing.csv",
    "fleet examples -o results --vehicle-from (a",
    f"compare {CAR} {CAR}",
    f"simulate {CAR} -o d.csv --sweep 1 5",
    f"identify {RECORD} --scale seat=nan",
    f"identify {RECORD} --modes 2.5",
    "identify nothing.json",
    f"report {RECORD} --pdf r.pdf",
    f"report {CAR} -o r.html",
    f"simulate {CAR} -o d.csv --impulse road --snr 20dB",
    f"estimate {RECORD} --car {CAR} --fixed seat,chassis,tire",
    f"estimate {RECORD} --car {CAR} --std 0.1",
    "help",
    "-v",
    f"identify {RECORD} --channel time",
    f"channels {RECORD} --json x.json",
    f"estimate {RECORD} --car {CAR} --modes 3",
    f"identify {RECORD} --snr 20",
    f"reconstruct {CAR} modes.json",
    "fleet examples -o results --scheduler here",
    "compare - -",
    "identify -",
    "modes -",
    f"identify {RECORD} --plot -",
    f"report {RECORD} -o -",
    f"identify {RECORD} --band 2,20",
    f"identify {RECORD} --band 2Hz 20Hz",
    f"identify {RECORD} --from 0:02",
    f"identify {RECORD} --decay 0",
    f"identify {RECORD} --scale chassis=1e3mm",
    f"identify {RECORD},examples/other.csv",
    f"identify {RECORD} --channel Seat",
    f"identify {RECORD} --json /nowhere/x.json",
    f"identify {RECORD} --json modes.csv",
    f"analyse {RECORD}",
    f"show {RECORD}",
    f"eigenmodes {CAR}",
    "version",
    "reconstruct modes.json",
    f"identify {RECORD} --band 2-20",
    f"identify {RECORD} --csv modes.csv",
    f"identify {RECORD} --decay 7",
    f"report {RECORD} -o r",
    f"report {RECORD} -o r.html --speed 20",
    f"report {RECORD} -o r.html --limits examples/nominal_car.toml",
    f"estimate {RECORD} --car {CAR} --speed 20",
    f"tune {CAR} --road C --speed 20 -o car.json",
    "--modes 3",
    f"report {RECORD} -o r.html --car {CAR} --given whel",
    f"reconstruct {CAR}",
    f"modes {CAR} --impulse road",
    f"simulate {CAR} -o d.mat --impulse road",
    f"simulate {CAR} -o d.csv --impulse wheel",
    f"simulate {CAR} -o d.csv --initial v_tire=fast",
    f"simulate {CAR} -o d.csv --road J --speed 20 --seed 1",
    f"simulate {CAR} -o d.csv --impulse road --channel body",
    f"ride {CAR} --road C --speed 20 --weighting seat=Wz",
    f"ride {CAR} --road C --speed 20 --clearance seat",
    f"grip {RECORD}",
    f"grip {CAR} --load 400",
    f"tune {CAR} --road C --speed 20 --points 0",
    f"identify {RECORD} -- --modes 3",
]

CALLS: list[Callable[[], object]] = [
    lambda: suspid.identify(DECAY),
    lambda: suspid.identify(np.stack([DECAY, DECAY], axis=1), fs=100),
    lambda: suspid.as_record(DECAY, fs=-100),
    lambda: suspid.as_record(DECAY[:, None, None], fs=100),
    lambda: suspid.as_record(DECAY, fs=100, channels=["a", "b"]),
    lambda: suspid.cwt(list("abc")),
    lambda: suspid.analyse("examples/quarter_car.xls"),
    lambda: suspid.analyse(RECORD, car=CAR),  # type: ignore[arg-type]
    lambda: suspid.analyse(RECORD, settings={"modes": 3}),  # type: ignore[arg-type]
    lambda: Settings(band_hz=(20.0, 1.0)),
    lambda: Settings(method="era"),  # type: ignore[arg-type]
    lambda: suspid.compare(ModalSet.from_wn_zeta([1.0], [0.1]), [1.0]),  # type: ignore[arg-type]
    lambda: suspid.assert_modes_close([1.0], [1.0]),  # type: ignore[arg-type]
    lambda: suspid.eigenmodes(np.eye(2)),
    lambda: suspid.quarter_car(
        chassis_mass=-400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=2e5, chassis_damping=1500
    ),
    lambda: Limit(of="chassis", quantity="stiffnes", least=1.0),
    lambda: Limit(of=1, quantity="zeta"),
    lambda: suspid.read_car("examples/quarter_car.csv"),
    lambda: suspid.classify_road((np.arange(0, 30, 0.005), np.sin(5 * np.arange(0, 30, 0.005))), speed=20.0),
    lambda: suspid.wear(suspid.eigenmodes(QUARTER)),  # type: ignore[arg-type]
    lambda: suspid.compare(suspid.reconstruct(suspid.eigenmodes(QUARTER), QUARTER), suspid.eigenmodes(QUARTER)),
]


@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_that_is_wrong_names_the_next_step(line: str) -> None:
    result = CliRunner().invoke(main, line.split())
    assert result.exit_code in (1, 2), result.output
    assert "Traceback" not in result.output
    # A wrong command line comes with the command that helps.
    last = result.stderr if result.exit_code == 2 else result.stderr.strip().splitlines()[-1]
    assert STEP.search(last), last
    # On the command line arguments and functions of Python have no place.
    assert not PYTHON.search(last), last


@pytest.mark.parametrize("record", [RECORD, "late", "twice", "nameless"])
@pytest.mark.parametrize(
    "command", ["identify", "channels", pytest.param("identify --decay whole", marks=pytest.mark.slow)]
)
def test_a_command_speaks_of_its_options_alone(record: str, command: str, tmp_path: Path) -> None:
    path = tmp_path / f"{record}.csv"
    late = np.concatenate([1e-3 * np.sin(np.arange(150)), DECAY])
    kinds = {
        "late": ("time [s],seat [m]", np.arange(late.size) / 100),
        "twice": ("time [s],seat [m]", np.arange(late.size) // 2 / 50),
        "nameless": ("force,seat [m]", late),
    }
    if record in kinds:
        head, first = kinds[record]
        path.write_text("\n".join([head, *(f"{t},{y}" for t, y in zip(first, late, strict=True))]))
    first_word, *rest = command.split()
    result = CliRunner().invoke(main, [first_word, str(path) if record in kinds else record, *rest])
    assert result.exit_code in (0, 1), result.output
    found = [line for line in result.output.replace(str(path), "").splitlines() if PYTHON.search(line)]
    assert found == []


@pytest.mark.parametrize("call", CALLS)
def test_a_call_that_is_wrong_names_the_next_step(call: Callable[[], object]) -> None:
    with pytest.raises((SuspidError, TypeError)) as error:
        call()
    assert STEP.search(str(error.value)) or isinstance(error.value, TypeError), str(error.value)


def test_there_are_sixty() -> None:
    assert len(COMMANDS) + len(CALLS) >= 60


@pytest.mark.parametrize(
    ("line", "way"),
    [
        ("analyse x.csv", "Did you mean 'identify'?"),
        ("help identify", "Did you mean '--help'?"),
        (f"identify {RECORD} --chanel seat", "Did you mean '--channel'?"),
        (f"identify {RECORD} --order 3", "Did you mean '--modes'?"),
        (f"identify {RECORD} --car {CAR}", "Commands that have it: report"),
        ("reconstruct modes.json", "MODES and CAR are needed: suspid reconstruct modes.json car.toml"),
        (f"reconstruct {CAR}", f"MODES and CAR are needed: suspid reconstruct modes.json {CAR}"),
        (
            f"report {RECORD} -o r.html --car examples/hatchback.toml --given wheels",
            "fix one with --fixed …, state --nominal-std …",
        ),
    ],
)
def test_the_next_step_is_the_right_one(line: str, way: str) -> None:
    assert way in CliRunner().invoke(main, line.split()).stderr


class TestWhatIsMeant:
    def test_standard_input_is_a_record(self) -> None:
        result = CliRunner().invoke(main, ["channels", "-"], input=Path(RECORD).read_bytes())
        assert result.exit_code == 0, result.output
        assert "chassis" in result.stdout
        assert CliRunner().invoke(main, ["channels", "-"], input="").exit_code == 2

    def test_the_place_of_the_standard_input_is_not_shown(self, tmp_path: Path) -> None:
        content, path = Path(RECORD).read_bytes(), tmp_path / "modes.json"
        result = CliRunner().invoke(main, ["identify", "-", "--json", str(path)], input=content)
        assert result.output.startswith("standard input: 5000 samples")
        assert json.loads(path.read_text(encoding="utf-8"))["record"]["file"] == "standard input"
        wrong = CliRunner().invoke(main, ["identify", "-", "--channel", "nope"], input=content)
        assert wrong.stderr.startswith("suspid: error: standard input: there is no channel 'nope'")

    def test_a_column_that_counts_the_rows_is_no_time(self, tmp_path: Path) -> None:
        path = tmp_path / "bump.csv"
        path.write_text("index,seat\n" + "".join(f"{k},{value}\n" for k, value in enumerate(DECAY.tolist())))
        # A step of one is no millisecond here: --time cannot say what only --fs can.
        assert "give the sampling rate" in CliRunner().invoke(main, ["identify", str(path), "--time", "index"]).stderr
        timed = CliRunner().invoke(main, ["identify", str(path), "--time", "index", "--fs", "100"])
        assert "400 samples at 100 Hz" in timed.stdout
        assert "replaces" not in timed.output

    def test_channels_in_one_text_or_several(self) -> None:
        from suspid.cli.options import settings_of

        blank = {
            "test": None, "without": (), "renames": (), "scales": (), "vertical": None, "si": False, "time": None,
            "fs": None, "dbc": None, "start": None, "stop": None, "which": "auto", "modes": None,
            "method": "likelihood", "band": None,
        }  # fmt: skip
        one = settings_of(channels=("seat, tire",), **blank)  # type: ignore[arg-type]
        assert one == settings_of(channels=("seat", "tire"), **blank)  # type: ignore[arg-type]
        assert one.channels == ("seat", "tire")
        assert settings_of(channels=('"acc, z"',), **blank).channels == ("acc, z",)  # type: ignore[arg-type]

    def test_a_vertical_beside_chosen_channels(self) -> None:
        from suspid import analyse

        t = np.arange(0, 4, 0.01)
        up = 9.81 + DECAY
        tilted = np.array([0.6 * up, 0.0 * up, 0.8 * up, DECAY, 2 * DECAY])
        noise = 1e-4 * np.random.default_rng(1).normal(size=tilted.shape)
        record = suspid.as_record(tilted + noise, timepts=t, channels=["ax", "ay", "az", "seat", "other"])
        found = analyse(record, settings=Settings(channels=("seat",), vertical=("ax", "ay", "az"), modes=1))
        assert len(found.identification.explained) == 2

    def test_a_shell_can_complete(self) -> None:
        result = CliRunner().invoke(main, [], prog_name="suspid", env={"_SUSPID_COMPLETE": "bash_source"})
        assert "_suspid_completion" in result.output


@pytest.mark.parametrize(
    "name", [name for name in suspid.__all__ if name.startswith("plot_")] + ["report", "statespace"]
)
def test_a_file_given_where_a_result_is_needed(name: str) -> None:
    verb = getattr(suspid, name)
    parameters = list(inspect.signature(verb).parameters.values())[1:]
    needed = [one for one in parameters if one.default is inspect.Parameter.empty]
    named = {one.name: None for one in needed if one.kind is inspect.Parameter.KEYWORD_ONLY}
    unnamed = [None for one in needed if one.kind is not inspect.Parameter.KEYWORD_ONLY]
    with pytest.raises(SuspidError) as caught:
        verb(RECORD, *unnamed, **named)
    assert STEP.search(str(caught.value))


@pytest.mark.parametrize(
    ("call", "way"),
    [
        (lambda: suspid.identify(np.arange(400) / 100, DECAY), r"as one pair, identify\(\(t, y\)\)"),  # type: ignore[call-arg]
        (lambda: suspid.identify(DECAY, 100), "by name, such as fs="),  # type: ignore[call-arg]
        (lambda: suspid.identify(DECAY, fs=100, band=(1, 10)), "Did you mean 'band_hz'"),  # type: ignore[call-arg]
        (lambda: suspid.identify(DECAY, fs=100, order=4), "Did you mean 'modes'"),  # type: ignore[call-arg]
        (lambda: suspid.cwt(DECAY, fs=100, freqs=[1.0]), "Did you mean 'omega'"),  # type: ignore[call-arg]
        (lambda: suspid.quarter_car(400, 40), "by name, such as seat_mass="),  # type: ignore[call-arg]
        (lambda: suspid.report(suspid.identify(DECAY, fs=100), "r.html"), r"Path\('r.html'\).write_text\(report\(…"),  # type: ignore[call-arg]
    ],
)
def test_a_call_that_does_not_fit_the_signature_names_the_way(call: Callable[[], object], way: str) -> None:
    with pytest.raises(TypeError, match=way):
        call()


@pytest.mark.parametrize("given", ["C", ["C"] * 400, object()])
def test_a_class_of_a_road_is_no_heights(given: object) -> None:
    with pytest.raises(SuspidError, match=r"input 'road' is .*: give a number for each time .*road_profile\("):
        suspid.simulate(QUARTER, np.arange(400) / 100, {"road": given})  # type: ignore[dict-item]


def test_springs_follow_from_modes() -> None:
    with pytest.raises(SuspidError, match="there is no mode"):
        suspid.reconstruct(suspid.ModalSet(poles=np.empty(0, complex)), QUARTER)


def test_a_mapping_and_a_name_of_a_mode() -> None:
    with pytest.raises(SuspidError, match="channels=.*data"):
        suspid.identify({"seat": DECAY}, fs=100)
    with pytest.raises(SuspidError, match="attribute, such as .wn"):
        suspid.eigenmodes(QUARTER)["wn"]  # type: ignore[index]


def test_every_option_has_one_purpose_and_long_helps_show_it() -> None:
    named = [name for names in GROUPS.values() for name in names.split()]
    params = [one for command in main.commands.values() for one in command.params]
    assert len(named) == len(set(named))
    assert {f"--{name}" for name in named} == {one.opts[-1] for one in params if one.param_type_name == "option"}
    shown = CliRunner().invoke(main, ["fleet", "--help"]).stdout
    headings = ["Record:", "Part of the record:", "Modes:", "Car:", "Road and drive:", "Fleet:", "Output:", "Help:"]
    assert [line for line in shown.splitlines() if line.endswith(":") and not line.startswith(" ")] == headings
    assert "\nOptions:\n" in CliRunner().invoke(main, ["modes", "--help"]).stdout
