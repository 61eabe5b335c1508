"""The command `drive`: from recorded drives to springs and dampers, or to the frequencies of a body alone."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from asammdf import MDF, Signal
from click.testing import CliRunner, Result
from nptdms import ChannelObject, TdmsWriter

from suspid import (
    RawChannel,
    RecordError,
    Recording,
    Settings,
    Suspension,
    analyse_drive,
    quarter_car,
    read_car,
    road_profile,
    simulate,
    write_car,
)
from suspid.analysis.drive_dampers import curves_of
from suspid.cli.main import main
from suspid.records import as_response
from suspid.reporting import json_schema
from suspid.units import RealArray
from suspid.words import Remark
from suspid.words.drives import BodyCheck, DriveReason, DriveRemark
from validation.motion import Drive, driven

CAR = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300, tire_damping=60
)
NOMINAL = CAR.with_parameters(stiffness={"chassis": 28e3}, damping={"chassis": 900})
NOISE = {"chassis_acceleration": 0.03, "tire_acceleration": 0.1}
CSS = Path(__file__).resolve().parents[2] / "shared" / "data" / "css_canedge_car_mf4"
STOP = (30.0, 50.0)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@cache
def drive(seed: int = 1, duration: float = 100.0, car: Suspension = CAR) -> tuple[RealArray, Mapping[str, RealArray]]:
    """Return times and channels of a drive, as an independent simulator makes them, with a stop."""
    rng = np.random.default_rng(seed)
    motions, times = driven(car, Drive(duration=duration, noise=NOISE), rng)
    stands = (times >= STOP[0]) & (times < STOP[1])
    channels = {
        name: np.where(stands, 0.0, motions[name]) + std * rng.standard_normal(times.size)
        for name, std in NOISE.items()
    }
    return times, {**channels, "Vehicle speed": np.where(stands, 0.0, 72.0)}


def recorded(times: RealArray, channels: Mapping[str, RealArray]) -> Recording:
    """Return channels as a recording; accelerations in m/s2, speeds in km/h."""
    made = (
        RawChannel(name=n, unit="km/h" if "speed" in n else "m/s2", timepts=times, values=v, rate=None)
        for n, v in channels.items()
    )
    return Recording(title="drive", channels=tuple(made))


def write(path: Path, times: RealArray, channels: Mapping[str, RealArray]) -> Path:
    """Write a drive in the format that the name says, accelerations in g."""
    units = {name: "km/h" if "speed" in name else "g" for name in channels}
    scaled = {name: values if "speed" in name else values / 9.80665 for name, values in channels.items()}
    if path.suffix == ".mf4":
        with MDF(version="4.10") as file:
            file.append([Signal(samples=v, timestamps=times, name=n, unit=units[n]) for n, v in scaled.items()])
            file.save(path, overwrite=True)
    elif path.suffix == ".tdms":
        with TdmsWriter(str(path)) as writer:
            for name, values in scaled.items():
                more = {"unit_string": units[name], "wf_increment": float(times[1] - times[0]), "wf_start_offset": 0.0}
                writer.write_segment([ChannelObject("drive", name, values, properties=more)])
    else:
        head = ",".join(["time [s]", *(f"{name} [{units[name]}]" for name in channels)])
        table = np.column_stack([times, *scaled.values()])
        np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.6f")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_car(NOMINAL, tmp_path / "car.toml")
    return tmp_path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """Return a folder with everything that the command writes of one drive, and what it said."""
    folder = tmp_path_factory.mktemp("whole")
    write_car(NOMINAL, folder / "car.toml")
    write(folder / "drive.mf4", *drive())
    done = run("drive", folder / "drive.mf4", "--car", folder / "car.toml", "--json", folder / "out.json",
               "-o", folder / "found.toml", "--plot", folder / "out.png", "--level", 0.95)  # fmt: skip
    assert done.exit_code == 0, done.output
    return folder, done


def check_stretches(ends: list[tuple[float, float]]) -> None:
    """Check that a drive was taken before and after its stop, in blocks of a second."""
    assert len(ends) == 2
    assert [ends[0][0], ends[0][1], ends[1][0]] == pytest.approx([0.0, *STOP], abs=1.01)


class TestSprings:
    def test_springs_and_dampers_from_a_file(self, whole: tuple[Path, Result]) -> None:
        folder, done = whole
        content = json.loads((folder / "out.json").read_text(encoding="utf-8"))
        jsonschema.validate(content, json_schema("drive"))
        jsonschema.validate(content["estimate"], json_schema("estimate"))
        found = {p["name"]: p for p in content["estimate"]["parameters"]}
        for parameter, truth in (("chassis.stiffness", 22e3), ("chassis.damping", 1300.0)):
            # One false alarm in two million.
            assert abs(found[parameter]["value"] - truth) < 5 * found[parameter]["std"]
            assert found[parameter]["std"] < 0.01 * truth
        check_stretches([(one["start"], one["stop"]) for one in content["files"][0]["stretches"] if one["taken"]])
        assert read_car(folder / "found.toml").struts[0].stiffness == pytest.approx(22e3, rel=0.02)
        assert (folder / "out.png").stat().st_size > 10_000
        for text in ("slower than 3 m/s", "taken", "95 % interval", "Verdict"):
            assert text in done.output

    @pytest.mark.parametrize("name", ["drive.csv", "drive.tdms"])
    def test_other_formats_hold_the_same_drive(self, folder: Path, whole: tuple[Path, Result], name: str) -> None:
        found = analyse_drive(write(folder / name, *drive()), car=NOMINAL, curves=False)
        assert found.estimate is not None
        check_stretches([(one.start, one.stop) for one in found.drives[0].taken])
        content = json.loads((whole[0] / "out.json").read_text(encoding="utf-8"))
        same = {p["name"]: (p["value"], p["std"]) for p in content["estimate"]["parameters"]}
        for parameter, value in zip(found.estimate.parameters, found.estimate.values, strict=True):
            # The digits of the file differ by a thousandth of the noise.
            assert abs(value - same[parameter][0]) < 0.1 * same[parameter][1]

    def test_several_files_of_one_logger_share_its_gains(self, folder: Path) -> None:
        files = [write(folder / f"{seed}.csv", *drive(seed, 60.0)) for seed in (2, 3)]
        found = analyse_drive(files, car=NOMINAL, curves=False)
        assert found.estimate is not None
        assert found.estimate.parameters[-2:] == ("tire_acceleration.gain", "tire_acceleration.delay")
        assert len(found.estimate.residual) == 2  # What follows the stops is too short.
        low, high = found.estimate.interval(0.9999)["chassis.damping"]
        assert low < 1300 < high

    @pytest.mark.slow
    def test_a_car_that_lacks_something_ends_with_3(self, folder: Path) -> None:
        times, channels = drive(1, 45.0)
        other = 0.5 * np.roll(channels["tire_acceleration"], 26)
        wrong = {**channels, "chassis_acceleration": channels["chassis_acceleration"] + 0.1 * other}
        write(folder / "wrong.csv", times, wrong)
        done = run("drive", folder / "wrong.csv", "--car", folder / "car.toml")
        assert done.exit_code == 3, done.output


class TestRoad:
    @pytest.mark.slow
    def test_tires_and_road_from_stretches_of_one_logger(self, folder: Path) -> None:
        files = [write(folder / f"{seed}.csv", *drive(seed, duration)) for seed, duration in ((11, 150.0), (12, 60.0))]
        done = run("drive", *files, "--car", folder / "car.toml", "--road", "iso8608", "--json", folder / "out.json",
                   "--wheel-radius", 0.3)  # fmt: skip
        assert done.exit_code == 0, done.output
        content = json.loads((folder / "out.json").read_text(encoding="utf-8"))["estimate"]
        found = {p["name"]: p for p in content["parameters"]}["tire.stiffness"]
        assert abs(found["value"] - 210e3) < 4 * found["std"] < 0.2 * 210e3
        (road,) = content["road"]
        assert road["class"] == "B"
        assert {stretch["record"] for stretch in road["stretches"]} == {0, 1, 2}
        assert all(stretch["speed"] == pytest.approx(20.0, rel=0.05) for stretch in road["stretches"])

    def test_a_road_needs_the_motion_of_the_wheels(self, folder: Path) -> None:
        times, channels = drive()
        file = write(folder / "body.csv", times, {n: v for n, v in channels.items() if "tire" not in n})
        done = run("drive", file, "--car", folder / "car.toml", "--road", "iso8608")
        assert done.exit_code == 1
        assert "not shown: tire" in done.output


class TestDampers:
    def test_curve_wear_and_grip_of_each_damper(self, folder: Path) -> None:
        new, worn = CAR, CAR.with_parameters(damping={"chassis": 800.0})
        write_car(new, folder / "new.toml")
        for name, car, seed in (("new", new, 5), ("worn", worn, 6)):
            more = ["--before", folder / "new.json", "--page", folder / "worn.html"] if name == "worn" else []
            write(folder / f"{name}.mf4", *drive(seed, 60.0, car))
            done = run("drive", folder / f"{name}.mf4", "--car", folder / "new.toml", "--json", folder / f"{name}.json",
                       *more)  # fmt: skip
            assert done.exit_code == 0, done.output
            content = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
            jsonschema.validate(content, json_schema("drive"))
            (curve,) = content["curves"]
            jsonschema.validate(curve, json_schema("damper"))
            jsonschema.validate(content["wear"], json_schema("compare"))
            (damper,) = content["wear"]["dampers"]
            work = curve["equivalent_damping"]
            assert abs(work["value"] - car.struts[0].damping) < 5 * work["std"]
            assert curve["linear"]["accepted"]
            assert damper["verdict"] != "worn" if name == "new" else damper["verdict"] == "worn"
            assert content["wear"]["against"] == ("nominal" if name == "new" else "earlier")
            assert "least phase" in done.output
        compared = run("compare", folder / "new.json", folder / "worn.json")
        assert "chassis worn" in compared.output
        # The page has the state with its reason and error rates, and what is doubted of the drive.
        page = (folder / "worn.html").read_text(encoding="utf-8")
        for text in ('href="#curves"', 'href="#stretches"',
                     "Curves of dampers", "Wear of dampers", "<b>worn</b>", damper["checks"][0]["text"], "called worn",
                     "Neither lateral acceleration"):  # fmt: skip
            assert text in page

    @pytest.mark.slow
    def test_a_late_sensor_is_corrected_before_the_curve_is_found(self) -> None:
        times, channels = drive(7, 45.0)
        late = {**channels, "tire_acceleration": np.roll(channels["tire_acceleration"], 1)}
        found = analyse_drive(recorded(times, late), car=CAR)
        (curve,) = found.curves
        assert curve.explains
        assert curve.stiffness == pytest.approx(22e3, rel=0.02)
        assert DriveRemark.SENSORS in {check.remark.code for check in found.notes}

    def test_a_bent_damper_is_told_and_named(self) -> None:
        bent = CAR.with_parameters(curve={"chassis": ((-1.0, -650.0), (0.0, 0.0), (1.0, 1950.0))})
        t, rng = np.arange(0, 25, 0.005), np.random.default_rng(2)
        road = road_profile(20 * t, roughness="B", rng=rng, wavelengths=(0.5, 100.0))
        made = simulate(bent, t, {"road": road}, outputs=list(NOISE), interpolation="cubic")
        rows = made.outputs + np.array([[0.03], [0.1]]) * rng.standard_normal(made.outputs.shape)
        found = analyse_drive(recorded(t, dict(zip(NOISE, rows, strict=True))), car=CAR)
        (curve,) = found.curves
        assert curve.explains
        assert not curve.linear
        low, high = curve.interval(0.999)
        inside = (low <= np.where(curve.velocities > 0, 1950, 650) * curve.velocities) & (
            np.where(curve.velocities > 0, 1950, 650) * curve.velocities <= high
        )
        assert np.mean(inside) > 0.9
        assert "not a line" in str(found)
        assert DriveRemark.BENT in {check.remark.code for check in found.notes}
        # Where viscous dampers do not explain the drive, and the curve does, the curve is what holds.
        assert found.estimate is not None
        short = replace(found, estimate=replace(found.estimate, explains=False))
        assert short.explains
        assert DriveRemark.BY_CURVES in {check.remark.code for check in short.verdict.checks}
        assert not replace(short, curves=()).explains

    def test_a_damper_without_the_motion_of_its_wheel_has_no_curve(self) -> None:
        found, notes = curves_of(
            [as_response(np.arange(2000) / 200, np.ones((1, 2000)), ("chassis_acceleration",))],
            SimpleNamespace(suspension=CAR),  # type: ignore[arg-type]
            "drive",
        )
        assert found == ()
        assert notes[0].remark.code is DriveRemark.NO_CURVE


class TestVertical:
    @pytest.mark.slow
    def test_a_tilted_sensor_gives_what_an_upright_one_does(self, folder: Path) -> None:
        """The body's acceleration and gravity along an axis that is 30 degrees off z, and other motion across it."""
        times, channels = drive(4, 400.0)
        up = channels["chassis_acceleration"]
        across = 0.3 * np.random.default_rng(8).standard_normal(times.size)
        tilt = np.radians(30.0)
        axes = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
        tilted = dict(zip("xyz", axes @ np.array([across, across[::-1], 9.81 + up]), strict=True))
        speed = {"Vehicle speed": channels["Vehicle speed"]}
        one = run("drive", write(folder / "upright.csv", times, {"vertical": up, **speed}))
        done = run("drive", write(folder / "tilted.csv", times, {**tilted, **speed}), "--vertical", "x,y,z")
        assert done.exit_code == 0, done.output
        rows = [line.split() for out in (one, done) for line in out.output.splitlines() if " vertical " in line]
        assert len(rows) == 2
        assert float(rows[1][1]) == pytest.approx(float(rows[0][1]), rel=0.02)
        assert "by gravity; 30.00" in done.output.replace("29.99", "30.00").replace("30.01", "30.00")

    @pytest.mark.parametrize("gravity", [1.0, 9.81])
    def test_gravity_tells_the_unit(self, gravity: float) -> None:
        times, rng = np.arange(6000) / 100, np.random.default_rng(3)
        values = {n: gravity * ((n == "z") + 0.1 * rng.standard_normal(times.size)) for n in "xyz"}
        made = tuple(RawChannel(name=n, unit="", timepts=times, values=v, rate=None) for n, v in values.items())
        found = analyse_drive(Recording(title="box", channels=made), settings=Settings(vertical=("x", "y", "z")))
        (record,) = found.drives[0].records
        assert np.std(np.asarray(record.y)) == pytest.approx(0.981, rel=0.05)
        assert DriveRemark.NO_UNIT not in {check.remark.code for check in found.remarks}

    def test_axes_that_make_no_sensor_are_refused(self) -> None:
        times = np.arange(2000) / 100
        made = [RawChannel(name=n, unit=u, timepts=times + late, values=np.sin(times), rate=None)
                for n, u, late in (("x", "g", 0.0), ("y", "g", 0.0), ("z", "m", 0.0), ("w", "g", 0.005))]  # fmt: skip
        for axes, why in ((("x", "y", "z"), "different units"), (("x", "y", "w"), "different clocks")):
            with pytest.raises(RecordError, match=why):
                analyse_drive(Recording(title="box", channels=tuple(made)), settings=Settings(vertical=axes))


class TestBodyAlone:
    def test_no_damping_without_the_wheels(self, folder: Path) -> None:
        times, channels = drive(4, 400.0)
        body = {name: values for name, values in channels.items() if "tire" not in name}
        write(folder / "body.mf4", times, body)
        results = ["--json", folder / "out.json", "--page", folder / "page.html"]
        done = run("drive", folder / "body.mf4", "--car", folder / "car.toml", *results)
        assert done.exit_code == 0, done.output
        content = json.loads((folder / "out.json").read_text(encoding="utf-8"))
        jsonschema.validate(content, json_schema("drive"))
        assert content["estimate"] is None
        codes = {check["code"] for check in content["verdict"]["checks"]}
        assert {str(BodyCheck.NO_DAMPING), str(DriveRemark.NO_WHEELS)} <= codes
        assert "zeta" not in content["body"][0]
        done = run("compare", folder / "out.json", folder / "out.json")
        assert done.exit_code == 1
        assert "the drive has no springs and dampers" in done.output
        assert content["body"][0]["lower"] < 1.2105 < content["body"][0]["upper"]
        page = (folder / "page.html").read_text(encoding="utf-8")
        for text in ("Only frequencies of the body", f"{content['body'][0]['hertz']:.3g}", "not reported", "moving at"):
            assert text in page

    @pytest.mark.skipif(not CSS.is_dir(), reason="needs the measured drive in ../shared")
    def test_a_real_car(self, tmp_path: Path) -> None:
        files = sorted(CSS.glob("00000164*.MF4"))
        done = run("drive", *files, "--dbc", CSS / "canmod-gps.dbc", "--channel", "AccelerationX",
                   "--json", tmp_path / "out.json")  # fmt: skip
        assert done.exit_code == 0, done.output
        content = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
        (mode,) = content["body"]
        # The consensus of other methods.
        assert 1.35 < mode["hertz"] < 1.75
        assert mode["upper"] - mode["lower"] < 0.6
        assert content["estimate"] is None
        assert 0.6 < content["usable"] / sum(one["length"] for one in content["files"]) < 0.9

    @pytest.mark.skipif(not CSS.is_dir(), reason="needs the measured record in ../shared")
    def test_a_real_car_at_rest_tells_nothing(self) -> None:
        for more in ((), ("--speed", "none")):
            (file,) = CSS.glob("stationary*")
            done = run("drive", file, "--dbc", CSS / "canmod-gps.dbc", "--channel", "AccelerationX", *more)
            assert done.exit_code == 0
            assert "There is no result" in done.output


class TestRefusals:
    def test_what_makes_no_sense_is_a_wrong_command(self, folder: Path) -> None:
        file = write(folder / "drive.csv", *drive())
        for arguments in (
            [file, file],
            [file, "--output", folder / "found.toml"],
            [file, "--car", folder / "car.toml", "--added", "chassis=3"],
        ):
            assert run("drive", *arguments).exit_code == 2

    def test_a_unit_of_speed_is_asked_for_by_its_option(self, folder: Path) -> None:
        times, channels = drive()
        # Ten seconds are enough to be asked.
        early = times < 10
        file = write(folder / "v.csv", times[early], {name: values[early] for name, values in channels.items()})
        text = file.read_text(encoding="utf-8").replace("Vehicle speed [km/h]", "Vehicle speed")
        file.write_text(text, encoding="utf-8")
        assert "such as --speed-unit 'km/h'" in run("drive", file, "--car", folder / "car.toml").output
        done = run("drive", file, "--car", folder / "car.toml", "--speed", "Vehicle speed")
        assert "give it as --speed-unit" in done.output

    def test_no_usable_stretch_is_an_answer(self, folder: Path) -> None:
        times, channels = drive()
        file = write(folder / "parked.csv", times, {**channels, "Vehicle speed": np.zeros(times.size)})
        done = run("drive", file, "--car", folder / "car.toml")
        assert done.exit_code == 0
        assert "There is no result" in done.output

    @pytest.mark.parametrize(("every", "why"), [(1, "are too few for intervals"), (30, "Hz is too slow")])
    def test_usable_stretches_that_show_no_frequency_are_an_answer(self, folder: Path, every: int, why: str) -> None:
        times, channels = drive()
        body = {name: values[::every] for name, values in channels.items() if "tire" not in name}
        file = write(folder / "short.csv", times[::every], body)
        out = folder / "o.json"
        done = run("drive", file, "--car", folder / "car.toml", "--page", folder / "page.html", "--json", out)
        assert done.exit_code == 0, done.output
        for text in ("moving at", "no frequency of the body from", why, "There is no result"):
            assert text in done.output
        assert why in (folder / "page.html").read_text(encoding="utf-8")
        jsonschema.validate(json.loads(out.read_text(encoding="utf-8")), json_schema("drive"))

    def test_reasons_of_many_channels_fit_a_line(self) -> None:
        names = tuple(f"channel {i}" for i in range(12))
        said = str(Remark(DriveReason.CLIPPED, {"channels": names}))
        assert said == "'channel 0', 'channel 1', 'channel 2' and 9 others clipped"
        assert "others" not in str(Remark(DriveReason.CLIPPED, {"channels": names[:4]}))

    def test_limits_are_options(self, folder: Path) -> None:
        times, channels = drive()
        file = write(folder / "drive.csv", times, channels)
        done = run("drive", file, "--car", folder / "car.toml", "--least-speed", 30)
        assert "slower than 30 m/s" in done.output
        assert DriveReason.SLOW.value == "slow"


class TestNothingFound:
    def test_an_older_car_is_not_overwritten(self, folder: Path) -> None:
        file, car = write(folder / "drive.csv", *drive()), folder / "kept.toml"
        car.write_text("the car of yesterday", encoding="utf-8")
        done = run("drive", file, "--car", folder / "car.toml", "--shortest", 1e6, "-o", car,
                   "--page", folder / "none.html")  # fmt: skip
        assert done.exit_code == 0
        assert "There is no result" in (folder / "none.html").read_text(encoding="utf-8")
        assert "kept.toml: not written, because no springs and dampers were found" in done.output
        assert car.read_text(encoding="utf-8") == "the car of yesterday"
        assert sorted(path.name for path in folder.iterdir()) == ["car.toml", "drive.csv", "kept.toml", "none.html"]


class TestShort:
    def test_a_file_that_is_too_short_is_named(self, folder: Path) -> None:
        times, channels = drive()
        good = write(folder / "good.csv", times, channels)
        short = write(folder / "short.csv", times[:1], {name: row[:1] for name, row in channels.items()})
        done = run("drive", good, short, "--car", folder / "car.toml")
        assert done.exit_code == 1
        assert "short.csv: " in done.output
        assert "only 1 sample" in done.output

    @pytest.mark.parametrize("beside", [True, pytest.param(False, marks=pytest.mark.slow)])
    def test_one_that_cannot_be_judged_is_a_stretch_that_is_left(self, folder: Path, beside: bool) -> None:
        """It does not keep others from being used."""
        times, channels = drive()
        good = write(folder / "good.csv", times, channels)
        short = write(folder / "short.csv", times[:20], {name: row[:20] for name, row in channels.items()})
        done = run("drive", *([good] if beside else []), short, "--car", folder / "car.toml")
        assert done.exit_code == 0, done.output
        assert "too short for a drive" in done.output
        assert ("chassis.damping" in done.output) is beside
        assert ("There is no result" in done.output) is not beside

    def test_it_is_said_what_is_missing(self, folder: Path) -> None:
        times, channels = drive()
        inside = (times >= 60) & (times < 66)
        short = write(folder / "short.csv", times[inside], {name: row[inside] for name, row in channels.items()})
        done = run("drive", short, "--car", folder / "car.toml")
        assert done.exit_code == 0
        assert "The longest usable stretch has 6 s of the 10 s that one must have" in done.output
        assert "(--shortest)" in done.output

    @pytest.mark.slow
    def test_stretches_are_shown_where_no_car_can_be_estimated(self, folder: Path) -> None:
        """As with the sensor of the body logged under the name of the wheel."""
        times, channels = drive()
        twice = {**channels, "tire_acceleration": channels["chassis_acceleration"]}
        done = run("drive", write(folder / "drive.csv", times, twice), "--car", folder / "car.toml")
        assert done.exit_code == 0, done.output
        for text in ("moving at", "Springs and dampers were not found: ", "show the same motion"):
            assert text in done.output

    def test_a_stretch_outside_the_recording(self, folder: Path) -> None:
        done = run("drive", write(folder / "drive.csv", *drive()), "--from", 1e6)
        assert done.exit_code == 1
        assert "no samples between 1e+06 and inf s" in done.output


def test_the_json_of_drives_is_compared(folder: Path, whole: tuple[Path, Result]) -> None:
    file, found = write(folder / "drive.csv", *drive()), whole[0] / "out.json"
    nothing = folder / "nothing.json"
    done = run("drive", file, "--car", folder / "car.toml", "--json", nothing, "--shortest", 1e6)
    assert done.exit_code == 0
    compared = run("compare", found, found)
    assert compared.exit_code == 0, compared.output
    assert "chassis.damping" in compared.output
    refused = run("compare", nothing, found)
    assert refused.exit_code == 1
    assert "the drive has no" in refused.output


@pytest.mark.parametrize("turned", [False, True])
def test_files_with_other_sensors_are_named(folder: Path, turned: bool) -> None:
    times, channels = drive()
    both = write(folder / "both.csv", times, channels)
    body = write(folder / "body.csv", times, {n: row for n, row in channels.items() if n != "tire_acceleration"})
    done = run("drive", *([body, both] if turned else [both, body]), "--car", folder / "car.toml")
    assert done.exit_code == 1
    assert "body lacks a channel of the motion of 'tire', which both has" in done.output


def test_a_drive_may_come_from_the_standard_input() -> None:
    """An empty pipe is said as such, and no file of the name - is looked for."""
    result = CliRunner().invoke(main, ["drive", "-"], input=b"")
    assert result.exit_code == 2
    assert "- is the standard input, and it is empty" in result.stderr
