"""Wear of dampers that are not viscous: curves are compared at one amplitude, or it is said why they cannot be."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from suspid import (
    DamperCurve,
    DamperState,
    DamperWear,
    Estimate,
    InputError,
    RawChannel,
    Recording,
    analyse_drive,
    wear,
)  # fmt: skip
from suspid.analysis import DriveAnalysis
from suspid.performance.curve_wear import rates_at
from suspid.reporting import drive_to_dict, read_curves
from suspid.words import Check, Level, Remark, WearCheck
from validation.dampers import ACCELEROMETERS, LAWS, NOISE, NOMINAL

DRIVES = Path(__file__).parent / "damper_drives.npz"


@pytest.fixture(scope="module")
def drive() -> DriveAnalysis:
    """Analyse a drive of 20 s of a simulator apart from the library, with a damper of 1:3."""
    rng = np.random.default_rng(3)
    with np.load(DRIVES) as file:
        rows = {name: np.asarray(file[f"bilinear_0_{name}"], float) for name in ACCELEROMETERS}
    times = 0.005 * np.arange(len(rows[ACCELEROMETERS[0]]), dtype=np.float64)
    channels = (
        RawChannel(name=n, unit="m/s2", timepts=times, rate=None, values=v + NOISE[n] * rng.standard_normal(v.size))
        for n, v in rows.items()
    )
    return analyse_drive(Recording(title="drive", channels=tuple(channels)), car=NOMINAL)


def parts(drive: DriveAnalysis) -> tuple[Estimate, DamperCurve]:
    assert drive.estimate is not None
    (curve,) = drive.curves
    return drive.estimate, curve


def left(curve: DamperCurve, share: float) -> DamperCurve:
    """Return a curve of which a share remains at every velocity, as a gentler drive would show it."""
    scale = np.append(1.0, np.full(len(curve.forces) + 1, share))
    return replace(
        curve,
        forces=share * curve.forces,
        friction=share * curve.friction,
        covariance=curve.covariance * np.outer(scale, scale),
        velocity_std=0.8 * curve.velocity_std,
    )


class TestCurvesCompared:
    @pytest.mark.parametrize(
        ("share", "state"), [(1.0, DamperState.GOOD), (0.7, DamperState.WORN), (0.02, DamperState.WORN)]
    )
    def test_what_is_lost_of_every_force_is_lost_of_the_damping(
        self, drive: DriveAnalysis, share: float, state: DamperState
    ) -> None:
        estimate, curve = parts(drive)
        (one,) = wear(estimate, before=estimate, curves=[left(curve, share)], curves_before=[[curve]]).dampers
        assert one.loss.value == pytest.approx(1 - share, abs=1e-9)
        assert one.state is state
        assert WearCheck.BY_CURVE in {check.remark.code for check in one.checks}

    def test_work_is_that_of_the_law_at_the_stated_amplitude(self, drive: DriveAnalysis) -> None:
        # By hand: of 1:3 the damping of equal work is the mean of both rates at any amplitude.
        assert (LAWS["bilinear"].force(np.array([-0.2, 0.2])) == [-130.0, 390.0]).all()
        _, curve = parts(drive)
        for amplitude in (0.15, 0.25):
            rates = rates_at(curve, amplitude)
            assert abs(rates.damping - 1300) < 5 * np.sqrt(rates.covariance[0, 0]) < 0.1 * 1300
            assert abs(rates.stiffness - 22e3) < 5 * np.sqrt(rates.covariance[1, 1])

    def test_estimates_that_are_not_used_are_no_doubt(self, drive: DriveAnalysis) -> None:
        """A car of viscous dampers does not explain a drive with bent ones; their curves are compared all the same."""
        estimate, curve = parts(drive)
        doubtful = replace(
            estimate,
            verdict=replace(
                estimate.verdict,
                checks=(
                    *estimate.verdict.checks,
                    Check(Remark(WearCheck.SPRING, {"damper": "", "change": 0}), Level.DOUBTFUL),
                ),
            ),
        )
        found = wear(doubtful, before=doubtful, curves=[left(curve, 0.7)], curves_before=[[curve]])
        assert found.verdict.level is Level.CARE
        assert WearCheck.NOT_USED in {check.remark.code for check in found.verdict.checks}
        without = wear(doubtful, before=doubtful)
        assert without.verdict.level is Level.DOUBTFUL
        assert without.states["chassis"] is DamperState.CANNOT_TELL

    def test_a_residual_that_follows_little_widens_the_interval(self, drive: DriveAnalysis) -> None:
        """What is missing in a curve counts as an error of its damping; more than a third of the scatter is refused."""
        estimate, curve = parts(drive)

        def told(followed: float) -> DamperWear:
            now = replace(left(curve, 0.7), explains=False, followed=followed)
            (one,) = wear(estimate, before=estimate, curves=[now], curves_before=[[curve]]).dampers
            return one

        said = {share: {check.remark.code for check in told(share).checks} for share in (0.005, 0.02)}
        assert told(0.005).state is DamperState.WORN
        assert said[0.005] >= {WearCheck.FOLLOWS_LITTLE, WearCheck.BY_CURVE}
        assert WearCheck.BY_CURVE not in said[0.02]
        widths = [told(share).loss.high - told(share).loss.low for share in (0.0, 0.005, 0.01)]
        assert widths == sorted(widths)
        assert widths[2] > widths[0]
        own, wider = rates_at(curve, 0.2), rates_at(replace(curve, explains=False, followed=0.01), 0.2)
        added = wider.covariance - own.covariance
        assert np.sqrt(added[0, 0]) == pytest.approx(0.01 * own.damping, rel=1e-6)

    def test_without_an_earlier_curve_it_is_said_why(self, drive: DriveAnalysis) -> None:
        assert drive.wear is not None
        (one,) = drive.wear.dampers
        assert one.state is DamperState.CANNOT_TELL
        (check,) = one.checks
        assert check.remark.code is WearCheck.BENT
        assert "not viscous" in str(drive.wear)


class TestFiles:
    def test_curves_are_read_back(self, drive: DriveAnalysis, tmp_path: Path) -> None:
        estimate, curve = parts(drive)
        (tmp_path / "drive.json").write_text(json.dumps(drive_to_dict(drive)), encoding="utf-8")
        (read,) = read_curves(tmp_path / "drive.json")
        np.testing.assert_array_equal(read.covariance, curve.covariance)
        assert read.equivalent_damping(0.2) == curve.equivalent_damping(0.2)
        assert (read.linear, str(read.verdict.headline)) == (curve.linear, str(curve.verdict.headline))
        assert wear(estimate, before=estimate, curves=[curve], curves_before=[[read]]).states == {
            "chassis": DamperState.GOOD
        }

    def test_an_incomplete_curve_is_refused(self, drive: DriveAnalysis, tmp_path: Path) -> None:
        content = json.loads(json.dumps(drive_to_dict(drive)))
        del content["curves"][0]["nodes"]
        (tmp_path / "drive.json").write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(InputError, match="no complete curve of a damper"):
            read_curves(tmp_path / "drive.json")
        (tmp_path / "other.json").write_text("{}", encoding="utf-8")
        assert read_curves(tmp_path / "other.json") == ()
