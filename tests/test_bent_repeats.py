"""Decays that depend on their amplitude are joined at amplitudes that they have in common."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from suspid import IdentificationError, InputError, Repeats, as_record, identify, identify_repeats
from suspid.cli.main import main
from suspid.identification import described_from_dict, identification_to_dict, to_json
from suspid.identification.by_amplitude import joined
from suspid.reporting import content_of, json_schema, report, report_to_dict
from suspid.words import Level, ModeCheck

Real = NDArray[np.float64]
WN, ZETA, SLIP = 2 * np.pi * 2.0, 0.02, 0.01
T = np.arange(0, 5, 0.01)


def rubbed(release: float, *, slip: float = SLIP, timepts: Real = T) -> Real:
    """Return the exact motion after a release under dry friction, ``x'' + 2 zeta wn x' + wn^2 (x + slip sign x') = 0``.

    Each half swing is that of the linear system about a middle that friction moves by the slip.
    """
    out, start, at, turning = np.empty_like(timepts), 0.0, release, WN * np.sqrt(1 - ZETA**2)
    while abs(at) > slip and start <= timepts[-1]:
        inside = (start - 1e-12 <= timepts) & (start + np.pi / turning > timepts)
        after, middle = timepts[inside] - start, slip * np.sign(at)
        out[inside] = middle + (at - middle) * np.exp(-ZETA * WN * after) * (
            np.cos(turning * after) + ZETA * WN / turning * np.sin(turning * after)
        )
        at = middle - (at - middle) * np.exp(-ZETA * WN * np.pi / turning)
        start += np.pi / turning
    out[start - 1e-12 <= timepts] = at
    return out


def records(*releases: float, slips: tuple[float, ...] = ()) -> list[tuple[Real, Real]]:
    rng = np.random.default_rng(5)
    each = slips or (SLIP,) * len(releases)
    return [
        (T, rubbed(x, slip=slip) + 1e-3 * rng.standard_normal(T.size)) for x, slip in zip(releases, each, strict=True)
    ]


@pytest.fixture(scope="module")
def found() -> Repeats:
    return identify_repeats([as_record(one) for one in records(1.0, -0.6, 0.5)], names=("A", "B", "C"))


def equivalent_zeta(size: float) -> float:
    """Return the damping ratio with which a cycle falls as much: energy lost to friction is 4 times force and size."""
    return ZETA + 2 * SLIP / (np.pi * size)


def codes(found: Repeats, *levels: Level) -> set[object]:
    return {check.remark.code for check in found.verdict.checks if not levels or check.level in levels}


def test_one_mode_at_an_amplitude_that_all_met(found: Repeats) -> None:
    """Poles common to all were between amplitudes, and a second mode stood for what they missed."""
    assert len(found.modes) == 1
    (table,) = found.amplitude_dependence
    assert table is not None
    assert all(
        one.amplitude_dependence[0].amplitude.min() <= table.holds_at <= one.amplitude_dependence[0].amplitude.max()
        for one in found.each
    )
    assert found.modes.wn_std is not None
    assert found.modes.zeta_std is not None
    assert found.modes.zeta[0] == pytest.approx(equivalent_zeta(table.holds_at), rel=0.02)
    assert found.modes.wn[0] == pytest.approx(WN, rel=0.002)
    # The mean over the cycles of each, which a fit of common poles is between, is elsewhere.
    assert min(abs(one.modes.zeta[0] / found.modes.zeta[0] - 1) for one in found.each) > 0.05


def test_frequencies_over_amplitude_are_those_of_the_exact_motion() -> None:
    """Friction turns round where the motion turns: straight lines between samples put that late, the more the later."""
    t = np.arange(0, 3, 0.02)
    motion = rubbed(1.0, slip=0.02, timepts=t) + 1e-4 * np.random.default_rng(1).standard_normal(t.size)
    (table,) = identify(as_record((t, motion))).amplitude_dependence
    exact = WN * np.sqrt((1 - ZETA**2) / (1 - table.zeta**2))
    np.testing.assert_allclose(table.wn, exact, rtol=1.5e-4)


def test_they_are_compared_there(found: Repeats) -> None:
    assert found.consistency[0].held == (0, 1, 2)
    assert found.consistency[0].widening == 1
    assert ModeCheck.REPEATS_AGREE in codes(found, Level.SOUND)
    assert ModeCheck.AT_COMMON_AMPLITUDES in codes(found, Level.NOTE)
    assert "mode 1: at an amplitude of " in str(found)


def test_more_friction_in_one_is_said() -> None:
    other = identify_repeats([as_record(one) for one in records(1.0, 0.8, 0.9, slips=(SLIP, SLIP, 1.5 * SLIP))])
    assert ModeCheck.REPEATS_DISAGREE in codes(other, Level.CARE)
    assert other.consistency[0].odd == 2
    assert "on amplitude, or" not in str(other.verdict)


def test_pictures_show_each_decay_and_the_joint_mode(found: Repeats) -> None:
    upper, lower = found.plot().axes.ravel()
    (diamond,) = [line for line in lower.lines if line.get_marker() == "D"]
    (table,) = found.amplitude_dependence
    assert table is not None
    assert diamond.get_xydata().tolist() == [[table.holds_at, found.modes.zeta[0]]]
    assert [text.get_text() for text in lower.get_legend().get_texts()] == ["joint", "A", "B", "C"]
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("frequency [Hz]", "damping ratio [1]")
    low, high = lower.get_ylim()
    assert low < min(one.amplitude_dependence[0].zeta.min() for one in found.each)
    assert high > max(one.amplitude_dependence[0].known.zeta.max() for one in found.each)


def test_the_report_says_at_which_amplitude(found: Repeats) -> None:
    content = content_of(found.each[0], repeats=found)
    page = report(content)
    assert "Each mode is that of the single decays at the middle of the amplitudes that all of them met" in page
    assert "Poles common to all decays" not in page
    jsonschema.validate(report_to_dict(content), json_schema("report"))


def test_errors_are_not_averaged_out(found: Repeats) -> None:
    """What a fit misses is alike in all decays: three of them are not known better than the best."""
    assert found.modes.zeta_std is not None
    (table,) = found.amplitude_dependence
    assert table is not None
    least = min(one.amplitude_dependence[0].stds_at(table.holds_at)[1] for one in found.each)
    assert found.modes.zeta_std[0] >= least


def test_without_a_common_amplitude_it_is_the_mean_of_the_cycles(found: Repeats) -> None:
    first, last = found.each[0], found.each[2]
    table = last.amplitude_dependence[0]
    small = replace(last, amplitude_dependence=(replace(table, amplitude=1e-3 * table.amplitude),))
    both = joined([first, small])
    assert both.amplitude_dependence == (None,)
    low, high = sorted([first.modes.zeta[0], last.modes.zeta[0]])
    assert low <= both.modes.zeta[0] <= high
    repeats = replace(
        found,
        each=(first, small),
        modes=both.modes,
        consistency=both.consistency,
        amplitude_dependence=both.amplitude_dependence,
        names=("A", "B"),
        spans=found.spans[:2],
    )
    assert ModeCheck.NO_COMMON_AMPLITUDE in codes(repeats, Level.CARE)


def test_a_doubt_of_one_decay_is_milder(found: Repeats) -> None:
    """Two of three decays have no such doubt."""
    plain = replace(found, each=(found.each[0], *(replace(one, forces=()) for one in found.each[1:])))
    of = {check.remark.of: check.level for check in plain.verdict.checks if check.remark.code is ModeCheck.NONLINEAR}
    assert of == {"A": Level.NOTE}
    # That a check is passed is said where all pass it.
    passed = [check.remark.of for check in plain.verdict.checks if check.level is Level.SOUND and check.remark.of]
    assert passed
    assert all(names == "A and 2 others" for names in passed)
    of = {check.remark.of: check.level for check in found.verdict.checks if check.remark.code is ModeCheck.NONLINEAR}
    assert of == {"A and 2 others": Level.CARE}


def test_more_modes_than_there_are() -> None:
    with pytest.raises(IdentificationError, match="2 modes were requested, 1 could be found in 3 repeats"):
        identify_repeats([as_record(one) for one in records(1.0, -0.6)][:1] * 3, modes=2)


def test_files_are_joined_at_a_common_amplitude(tmp_path: Path) -> None:
    files = [str(tmp_path / f"{name}.csv") for name in "ab"]
    for file, (t, x) in zip(files, records(1.0, 0.6), strict=True):
        np.savetxt(file, np.stack([t, x], axis=1), delimiter=",", header="time [s],travel [mm]", comments="")
    out = CliRunner().invoke(main, ["identify", *files, "--json", str(tmp_path / "found.json")])
    assert out.exit_code == 0, out.output
    content = json.loads((tmp_path / "found.json").read_text())
    (table,) = content["amplitude_dependence"]
    assert content["modes"][0]["zeta"] == pytest.approx(equivalent_zeta(table["holds_at"]), rel=0.03)
    assert "a.csv and 1 other: The decay is not linear" in " ".join(out.output.split())


def test_results_are_compared_at_a_common_amplitude(tmp_path: Path) -> None:
    """Means over the cycles of decays from 1.0 and from 0.5 differ by far more than their intervals."""
    files = [str(tmp_path / f"{name}.json") for name in "ab"]
    for file, one in zip(files, records(1.0, 0.5), strict=True):
        found = identify(as_record(one))
        Path(file).write_text(to_json(identification_to_dict(found, file="", warnings=())))
    out = CliRunner().invoke(main, ["compare", *files, "--json", str(tmp_path / "compared.json")])
    assert out.exit_code == 0, out.output
    content = json.loads((tmp_path / "compared.json").read_text())
    jsonschema.validate(content, json_schema("compare"))
    (remark,) = content["remarks"]
    zeta = next(row for row in content["values"] if row["quantity"] == "zeta")
    assert content["passed"], out.output
    assert zeta["before"] == pytest.approx(equivalent_zeta(remark["numbers"]["amplitude"]), rel=0.03)
    assert "Mode 1 depends on its amplitude: compared at" in out.output
    one = json.loads(Path(files[0]).read_text())
    del one["amplitude_dependence"]
    Path(files[0]).write_text(json.dumps(one))
    out = CliRunner().invoke(main, ["compare", *files])
    assert "a difference may be that of amplitudes" in " ".join(out.output.split())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"zeta": None}, "must be lists of one length"),
        ({"zeta": []}, "must be lists of one length"),
        ({"amplitude": [-1.0, 1.0]}, "amplitudes and wn above 0"),
        ({"stop_s": [0.1, 0.1]}, "each with its stop after its start"),
        ({"stop_s": [1e30, 1e30]}, "a window last at most"),
        ({"wn_rad_per_s": [12.0, 120.0]}, "within half and twice that of its mode"),
        ({"zeta": [0.1, 5.0]}, "zeta between -1 and 1"),
        ({"channel": None}, "channel must be a name"),
        ({"holds_at": "x"}, "holds_at = 'x' must be a number"),
        ({"wn_rad_per_s": [1.0, "x"]}, "must be a number"),
        ({"wn_rad_per_s": [None, None]}, "a window at least"),
    ],
)
def test_damaged_tables_are_refused(change: dict[str, object], said: str) -> None:
    table: dict[str, object] = {"channel": "x", "holds_at": 1.0}
    names = ("start_s", "stop_s", "amplitude", "wn_rad_per_s", "wn_std_rad_per_s", "zeta", "zeta_std")
    table |= {name: [0.1, 0.2] for name in names} | {"wn_rad_per_s": [12.0, 13.0], "stop_s": [0.3, 0.4]}
    modes = [{"frequency_hz": 2.0, "zeta": 0.3}]
    assert described_from_dict({"modes": modes, "amplitude_dependence": [table]}).tables[0] is not None
    with pytest.raises(InputError, match=said):
        described_from_dict({"modes": modes, "amplitude_dependence": [{**table, **change}]})
    with pytest.raises(InputError, match="for each of 1 modes"):
        described_from_dict({"modes": modes, "amplitude_dependence": [table, table]})
