"""Figures of records: units, clipping, rest, rates and lengths, and what is refused."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from suspid import InputError, Level, Ride, as_record, ride
from suspid.cli import main
from suspid.performance import weightings
from suspid.performance.weightings import weighted
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words.ride import RideCheck

STEP = 0.005
T = np.arange(0, 60, STEP)
NOISE = np.random.default_rng(1).standard_normal(len(T))


def of(samples: RealArray, name: str = "seat_acceleration", step: float = STEP) -> Ride:
    return ride(as_response(np.arange(len(samples), dtype=float) * step, samples[None], [name]))


def doubts(found: Ride) -> list[object]:
    return [doubt.code for doubt in found.verdict.doubts]


def run(*arguments: object, text: str | None = None) -> Result:
    return CliRunner().invoke(main, [str(one) for one in arguments], input=text)


def written(path: Path, name: str, samples: RealArray = NOISE, step: float = STEP, time: str = "time [s]") -> Path:
    rows = "\n".join(f"{step * i:.6f},{value:.9g}" for i, value in enumerate(samples))
    path.write_text(f"{time},{name}\n{rows}\n", encoding="utf-8")
    return path


class TestUnits:
    @pytest.mark.parametrize(
        ("unit", "factor"), [("g", 9.80665), ("mm/s²", 1e-3), ("m/s^2", 1.0), ("cm/s2", 0.01), ("mg", 9.80665e-3)]
    )
    def test_the_unit_in_a_name_is_obeyed(self, unit: str, factor: float) -> None:
        plain, stated = of(NOISE), of(NOISE / factor, f"seat_acceleration [{unit}]")
        assert stated.figures == plain.figures
        np.testing.assert_allclose(stated.values, plain.values, rtol=1e-9)
        record = as_response(T, NOISE[None] / factor, [f"a ({unit})"])
        for name in ("a", f"a ({unit})"):
            np.testing.assert_allclose(ride(record, weightings={name: "Wk"})["a.Wk"], plain["seat_acceleration.Wk"])

    def test_turns_and_travels_too(self) -> None:
        names = ["pitch_acceleration [deg/s2]", "front_travel [mm]", "rear_travel [%]"]
        found = ride(as_response(T, np.array([NOISE, NOISE, NOISE]), names))
        plain = of(NOISE, "pitch_acceleration")
        assert found["pitch_acceleration.We"] == pytest.approx(np.radians(plain["pitch_acceleration.We"]))
        assert found["front.travel"] == pytest.approx(1e-3 * np.std(NOISE))
        assert "rear.travel" not in found.figures
        codes = [note.code for note in found.verdict.notes]
        assert RideCheck.NO_LENGTH in codes
        assert RideCheck.CONVERTED in codes

    @pytest.mark.parametrize("unit", ["V", "m", "furlong"])
    def test_what_is_no_unit_of_acceleration_is_refused(self, unit: str) -> None:
        record = as_response(T, NOISE[None], [f"seat_acceleration [{unit}]"])
        for wanted in (None, {"seat_acceleration": "Wk"}):
            with pytest.raises(InputError, match=f"{unit} is not a known unit of acceleration; give it in m/s2"):
                ride(record, weightings=wanted)

    def test_on_the_command_line(self, tmp_path: Path) -> None:
        plain = run("ride", written(tmp_path / "a.csv", "seat_acceleration", 9.80665 * NOISE))
        rows = plain.output.partition("Verdict")[0]
        stated = written(tmp_path / "b.csv", "seat_acceleration [g]")
        for options in ([], ["--si"], ["--weighting", "seat_acceleration=Wk,Wf"]):
            assert run("ride", stated, *options).output.partition("Verdict")[0].endswith(rows), options
        assert run("ride", "-", text=stated.read_text()).output.startswith(rows)
        # A second row that states units.
        lines = stated.read_text().replace("time [s],seat_acceleration [g]", "time,seat_acceleration\ns,g")
        (tmp_path / "c.csv").write_text(lines, encoding="utf-8")
        assert run("ride", tmp_path / "c.csv").output.partition("Verdict")[0] == rows
        twice = run("ride", stated, "--scale", "seat_acceleration=-9.81")
        assert (twice.exit_code, "is converted from g to m/s2 already" in twice.output) == (1, True)
        turned = run("ride", stated, "--scale", "seat_acceleration=-1")
        assert turned.output.partition("Verdict")[0] == rows
        volts = written(tmp_path / "d.csv", "seat_acceleration [V]")
        assert "not a known unit of acceleration" in run("ride", volts).output
        assert run("ride", volts, "--scale", "seat_acceleration=9.80665").output.partition("Verdict")[0] == rows

    def test_a_factor_is_no_second_conversion(self, tmp_path: Path) -> None:
        stated = written(tmp_path / "a.csv", "seat_acceleration [g]")
        for options in ([], ["--si"]):
            for factor in ("9.81", "9.5", "0.1"):
                twice = run("ride", stated, *options, "--scale", f"seat_acceleration={factor}")
                assert (twice.exit_code, "from g to m/s2 already" in twice.output) == (1, True), (options, factor)
            assert run("ride", stated, *options, "--scale", "seat_acceleration=-1").exit_code == 0

    @pytest.mark.parametrize("unit", ["deg/s2", "rad/s2"])
    def test_rotation_has_its_own_weighting(self, unit: str) -> None:
        record = as_response(T, NOISE[None], [f"yaw_acceleration [{unit}]"])
        assert ride(record).weightings["yaw_acceleration"] == ("We",)
        with pytest.raises(InputError, match="give it We"):
            ride(record, weightings={"yaw_acceleration": "Wk"})

    @pytest.mark.parametrize(
        ("name", "wanted"),
        [
            ("seat_acceleration_g", "seat_acceleration [g]"),
            ("AccelZ_mg", "AccelZ [mg]"),
            ("AccelZ_mm/s2", "AccelZ [mm/s2]"),
            ("Gyro_X_degps", "Gyro_X [deg/s]"),
        ],
    )
    def test_a_unit_without_brackets_is_refused(self, name: str, wanted: str) -> None:
        with pytest.raises(InputError, match=re.escape(f"name it '{wanted}'")):
            ride(as_response(T, NOISE[None], [name]), weightings={name: "Wk"})

    def test_other_motions_are_no_acceleration(self) -> None:
        record = as_response(T, np.array([NOISE, NOISE]), ["GyroX", "damper_position_1"])
        with pytest.raises(InputError, match=re.escape("accelerations") + "|no channel") as refused:
            ride(record)
        assert "such as" not in str(refused.value)
        for name in ("GyroX", "damper_position_1"):
            with pytest.raises(InputError, match="not named like an acceleration"):
                ride(record, weightings={name: "Wk"})

    @pytest.mark.parametrize(("every", "level"), [(20, "care"), (400, "sound")])
    def test_repairs_that_matter_are_in_the_verdict(self, tmp_path: Path, every: int, level: str) -> None:
        smooth = np.convolve(NOISE, np.hanning(20), "same")
        path = written(tmp_path / "a.csv", "seat_acceleration", smooth)
        lines = path.read_text(encoding="utf-8").splitlines()
        lines[101::every] = [f"{line.partition(',')[0]}," for line in lines[101::every]]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        verdict = run("ride", path, "--weighting", "seat_acceleration=Wk").output.partition("Verdict")[2]
        assert verdict.splitlines()[0].partition(" s: ")[2].startswith(level), verdict


class TestVerdict:
    def test_clipping(self) -> None:
        smooth = np.convolve(np.random.default_rng(2).standard_normal(len(T)), np.hanning(40), "same")
        limit = 2 * np.std(smooth)
        assert RideCheck.CLIPPED not in doubts(of(smooth))
        cut_off = of(np.clip(smooth, -limit, limit))
        assert RideCheck.CLIPPED in doubts(cut_off)
        assert cut_off.verdict.level is Level.CARE

    @pytest.mark.parametrize(("seconds", "level"), [(2.0, Level.DOUBTFUL), (40.0, Level.CARE), (60.0, Level.SOUND)])
    def test_a_short_record(self, seconds: float, level: Level) -> None:
        """Twenty periods of 0.4 Hz are 50 s; of less than one period nothing can be said."""
        samples = NOISE[: round(seconds / STEP)]
        record = as_response(np.arange(len(samples), dtype=float) * STEP, samples[None], ["a"])
        assert ride(record, weightings={"a": "Wk"}).verdict.level is level

    def test_a_slow_record(self) -> None:
        samples = np.random.default_rng(3).standard_normal(6000)
        assert RideCheck.HIGH in doubts(of(samples, step=0.01))
        assert RideCheck.HIGH not in doubts(of(samples, step=0.004))

    @pytest.mark.parametrize(("share", "said"), [(0.15, True), (0.17, False)])
    def test_the_limit_of_the_dose_is_1_75(self, share: float, said: bool) -> None:
        """A sine in a share p of the time has a VDV of (1.5 / p)^(1/4) times rms and fourth root: 1.75 at p = 0.16."""
        t = np.arange(0, 100, 0.002)
        found = of(np.sin(20 * np.pi * t) * (t < share * 100), step=0.002)
        ratio = found["seat_acceleration.VDV"] / (found["seat_acceleration.Wk"] * 100**0.25)
        assert ratio == pytest.approx((1.5 / share) ** 0.25, rel=5e-3)
        assert (RideCheck.SHOCKS in doubts(found)) is said

    @pytest.mark.parametrize(("standing", "share"), [(0.0, 0.0), (0.5, 0.5), (0.8, 0.8)])
    def test_time_at_rest(self, standing: float, share: float) -> None:
        level = np.where(np.arange(len(T)) < standing * len(T), 0.01, 1.0)
        found = of(level * NOISE)
        said = {note.code: note.numbers for note in found.verdict.notes}
        assert (RideCheck.REST in said) is (share > 0)
        if share:
            assert said[RideCheck.REST]["share"] == pytest.approx(share, abs=0.02)
            assert float(str(said[RideCheck.REST]["factor"])) * found["seat_acceleration.rms"] == pytest.approx(
                float(np.std(NOISE)), rel=0.03
            )

    @pytest.mark.parametrize("level", [0.0, 0.5, -3.0])
    def test_rest_has_a_level_of_its_own(self, level: float) -> None:
        found = of(np.where(T < 20, level, NOISE))
        said = {note.code: note.numbers for note in found.verdict.notes}
        assert said[RideCheck.REST]["share"] == pytest.approx(1 / 3, abs=0.02)

    def test_a_parked_car_has_no_ride(self) -> None:
        assert of(0.01 * NOISE).verdict.level is Level.DOUBTFUL


class TestSizes:
    """What no ride has is doubted, with the unit that explains it."""

    @pytest.mark.parametrize(
        ("factor", "level", "units"),
        [(1000.0, 0.0, ("mg", "mm/s2", "cm/s2")), (1e9, 0.0, ()), (20.0, 0.0, None), (1.0, 0.3, None)],
    )
    def test_accelerations(self, factor: float, level: float, units: tuple[str, ...] | None) -> None:
        found = of(factor * NOISE + level)
        said = {doubt.code: doubt.numbers for doubt in found.verdict.doubts}
        if units is None:
            assert doubts(found) == [RideCheck.SHORT]
        else:
            assert said[RideCheck.TOO_LARGE]["units"] == units
            assert found.verdict.level is Level.DOUBTFUL

    @pytest.mark.parametrize(("unit", "one"), [("g", 1.0), ("mg", 1000.0), ("cm/s2", 980.665), ("mm/s2", 9806.65)])
    def test_gravity_tells_the_unit(self, unit: str, one: float) -> None:
        samples = one * (-1.02 + 0.1 * NOISE)
        found = of(samples)
        assert RideCheck.GRAVITY_IN in doubts(found)
        # A hundredth of an m/s2 and a thousandth of g are the same to two per cent.
        said = next(doubt.numbers["units"] for doubt in found.verdict.doubts if doubt.code is RideCheck.GRAVITY_IN)
        assert said == (("mg", "cm/s2") if unit in ("mg", "cm/s2") else (unit,))
        stated = of(samples, f"seat_acceleration [{unit}]")
        assert doubts(stated) == [RideCheck.SHORT]
        assert RideCheck.GRAVITY in [note.code for note in stated.verdict.notes]

    def test_nothing_and_travels(self) -> None:
        assert {RideCheck.TOO_SMALL, RideCheck.REST} <= set(doubts(of(1e-5 * NOISE)))
        found = ride(as_response(T, np.array([NOISE, 30 * NOISE]), ["seat_acceleration", "front_travel"]))
        assert doubts(found) == [RideCheck.TOO_FAR, RideCheck.SHORT]
        assert "in mm or cm" not in str(found)
        assert "most likely it is in mm;" in str(found)


class TestRates:
    @pytest.mark.parametrize("kind", ["Wk", "Wf"])
    def test_long_records_are_weighted_at_a_lower_rate(self, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
        """What is left beyond forty times the upper corner is less than a thousandth."""
        samples = np.convolve(np.random.default_rng(4).standard_normal(200_000), np.ones(50) / 50, "same")
        whole = weighted(samples, 1e-4, kind)
        monkeypatch.setattr(weightings, "MOST_AT_ONCE", 1000)
        slow = weighted(samples, 1e-4, kind)
        assert len(slow) < len(whole)
        for power in (2, 4):
            assert np.mean(np.abs(slow) ** power) == pytest.approx(np.mean(np.abs(whole) ** power), rel=2e-3)

    def test_records_that_show_nothing(self) -> None:
        with pytest.raises(
            InputError, match=r"contains nothing in the band of Wk, 0.4 to 100 Hz; check the sampling rate"
        ):
            of(NOISE, step=1e-9)
        short = of(NOISE, step=1e-4)
        assert "seat_acceleration.Wf" not in short.figures
        assert RideCheck.HIDDEN in [note.code for note in short.verdict.notes]
        record = as_response(T * 1e-4 / STEP, NOISE[None], ["a"])
        with pytest.raises(InputError, match="contains nothing in the band of Wf"):
            ride(record, weightings={"a": "Wf"})

    def test_a_unit_of_time_that_is_guessed_is_said(self, tmp_path: Path) -> None:
        path = written(tmp_path / "a.csv", "seat_acceleration", NOISE[:4000], step=5.0, time="time")
        assert "is not stated; taken as ms" in run("ride", path).output
        assert "is not stated; taken as ms" in run("identify", path, "--channel", "seat_acceleration").output

    def test_huge_samples_have_their_reason(self, tmp_path: Path) -> None:
        path = written(tmp_path / "a.csv", "seat_acceleration", 1e200 * NOISE[:400])
        assert "400 of 400 samples exceed 1e+30" in run("ride", path).output


NUMBER: Any = {"seat_acceleration": 5}
LISTED: Any = ["Wk"]
RECORD = as_response(T, NOISE[None], ["seat_acceleration"])


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (lambda: ride("x.toml"), "not the path 'x.toml': ride(read_car('x.toml'), road="),
        (lambda: ride(Path("x.csv")), "ride(read_record('x.csv')) for a record"),
        (lambda: ride(None), "ride takes a car or a record, not NoneType"),
        (lambda: ride({"a": 1.0}), "not dict"),
        (lambda: ride(RECORD, weightings=NUMBER), "'seat_acceleration' has 5; it must map channels"),
        (lambda: ride(RECORD, weightings=LISTED), "weightings=['Wk'] must map channels"),
        (lambda: ride(RECORD, weightings={"seat_acceleration": ["Wk", "Wk"]}), "has a weighting twice"),
        (lambda: ride(RECORD, weightings={"seat": "Wk"}), "there is no channel 'seat'"),
    ],
)
def test_wrong_requests_say_what_to_write(request_: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        request_()


class TestRounding:
    """A sensor of coarse steps adds the variance q^2 / 12, white, to what it measures."""

    @staticmethod
    def of_steps(step: float) -> tuple[Ride, float]:
        """Return the ride over a noise of 0.1 m/s2 up to 100 Hz in steps, and its exact weighted rms."""
        from scipy.signal import butter, sosfilt

        rng = np.random.default_rng(5)
        smooth = sosfilt(butter(4, 100.0, fs=400.0, output="sos"), rng.standard_normal(400 * 120))
        smooth *= 0.1 / np.std(smooth)
        exact = ride(as_record(smooth, fs=400, channels=["seat_acceleration"]))["seat_acceleration.Wk"]
        rounded = step * np.round(smooth / step) if step else smooth
        return ride(as_record(rounded, fs=400, channels=["seat_acceleration"])), exact

    def test_its_share_is_that_of_white_noise(self) -> None:
        found, exact = self.of_steps(0.2)
        (said,) = [one for one in found.verdict.doubts if one.code is RideCheck.ROUNDED and
                   one.numbers["weighting"] == "Wk"]  # fmt: skip
        share = 1 - (exact / found["seat_acceleration.Wk"]) ** 2
        assert float(str(said.numbers["share"])) == pytest.approx(share, rel=0.25)
        assert float(str(said.numbers["step"])) == pytest.approx(0.2)

    @pytest.mark.parametrize("step", [0.0, 0.001])
    def test_fine_steps_are_not_mentioned(self, step: float) -> None:
        found, _ = self.of_steps(step)
        assert RideCheck.ROUNDED not in {one.code for one in found.verdict.doubts}


@pytest.mark.parametrize(("rate", "cut_off"), [(200 * (1 - 1e-4), False), (200.0, False), (180.0, True)])
def test_a_rate_that_is_off_by_rounded_stamps_cuts_nothing_off(rate: float, cut_off: bool) -> None:
    samples = np.random.default_rng(1).standard_normal(20_000)
    found = ride(as_record(samples, fs=rate, channels=["seat_acceleration"]), weightings={"seat_acceleration": "Wk"})
    assert (RideCheck.HIGH in {one.code for one in found.verdict.doubts}) == cut_off
