"""Where a decay contradicts the law of its forces, the bands over the amplitude contain what it shows."""

from dataclasses import replace

import numpy as np
import pytest

from suspid import as_record, identify
from suspid.analysis import means
from suspid.identification.nonlinear.dependence import AmplitudeDependence, with_tables
from suspid.identification.nonlinear.local import local_changes
from suspid.levels import NORMAL_95
from suspid.model import ModalSet
from suspid.records import as_response
from suspid.units import RealArray
from suspid.words import Level, ModeCheck

STEP = 0.02


def decay(seed: int) -> tuple[RealArray, RealArray, RealArray]:
    """Return samples, amplitude and phase of a mode at 1 Hz that is damped more above .6 and below .1: no law here."""
    wn, amplitude, phase, sizes, phases = 2 * np.pi, 1.0, 0.0, list[float](), list[float]()
    for _ in range(2000):
        sizes.append(amplitude)
        phases.append(phase)
        for _ in range(4):
            zeta = 0.004 + 0.05 * max(amplitude - 0.6, 0.0) + 0.01 * (amplitude < 0.1)
            turn = wn * (1 - 0.03 * amplitude**2) * STEP / 4
            amplitude *= np.exp(-zeta * turn)
            phase += turn
    noise = 0.004 * np.random.default_rng(seed).standard_normal(2000)
    return np.array(sizes) * np.cos(phases) + noise, np.array(sizes), np.array(phases)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_bands_contain_a_damping_that_follows_no_law_of_the_library(seed: int) -> None:
    """Without the residual's word most rows lie outside."""
    values, sizes, phases = decay(seed)
    (found,) = identify(as_record(values, timepts=STEP * np.arange(2000))).amplitude_dependence
    first, last = (np.round(np.array(found.spans) / STEP).astype(int)).T
    true = np.log(sizes[first] / sizes[last]) / (phases[last] - phases[first])
    away = np.abs(found.zeta - true) / (NORMAL_95 * found.zeta_std)
    assert np.max(away) < 1.2
    assert np.median(found.zeta_std / true) < 0.2


def test_a_mode_that_turns_too_fast_for_means_is_none_of_theirs() -> None:
    """Four samples a cycle show no harmonics: what forces do is another motion there."""
    time = np.arange(400.0)
    for turn, too_fast in ((1.5, True), (0.4, False)):
        record = as_response(time, np.exp(-0.01 * time) * np.cos(turn * time), ["body"])
        assert means._too_fast(identify(record), record) is too_fast


def test_one_row_that_is_known_badly_does_not_hide_that_the_others_differ() -> None:
    (found,) = identify(as_record(decay(0)[0], timepts=STEP * np.arange(2000))).amplitude_dependence
    bad = np.append(found.zeta_std[:-1], 1.0), np.append(found.wn_std[:-1], 100.0)
    assert replace(found, zeta_std=bad[0], wn_std=bad[1]).varies
    assert not replace(found, zeta_std=np.ones_like(bad[0]), wn_std=100 * np.ones_like(bad[1])).varies


@pytest.mark.parametrize(("rate", "seen"), [(1e-3, True), (1.0, False)])
def test_a_mode_that_is_not_seen_in_a_window_says_nothing_there(rate: float, *, seen: bool) -> None:
    """What is left is larger than the motion: a change of it would be other motion."""
    time = np.arange(200.0)
    state = 1e-3 * np.exp(0.5j * time)
    left = np.real(state * rate * (time - time.mean()))[None] + 1e-6 * np.random.default_rng(1).standard_normal(200)
    (change,) = local_changes(state, np.ones(1, complex), left, [(0, 199)])
    assert bool(change) is seen


@pytest.mark.parametrize(
    ("zeta", "beats"),
    [
        ([0.020, 0.012, 0.010, 0.012, 0.019], False),
        ([0.010, 0.012, 0.014, 0.016, 0.018], False),
        ([0.010, 0.014, 0.018, 0.014, 0.010], True),
        ([0.0100, 0.0112, 0.0118, 0.0112, 0.0100], False),
        ([0.010, 0.006, 0.002, -0.001, -0.003], True),
        ([0.010, 0.006, 0.002, 0.001, -0.001], False),
    ],
)
def test_damping_that_is_largest_between_two_amplitudes_or_feeds_the_motion_is_a_beat(
    zeta: list[float], beats: bool
) -> None:
    """Bands of half a thousandth: friction and drag together damp motions between them least."""
    (found,) = identify(as_record(decay(0)[0], timepts=STEP * np.arange(2000))).amplitude_dependence
    size = len(zeta)
    rows = {name: getattr(found, name)[:size] for name in ("amplitude", "wn", "wn_std", "spans")}
    one = replace(found, **rows, zeta=np.array(zeta), zeta_std=np.full(size, 5e-4))
    assert one.beats is beats
    alone = replace(identify(as_record(decay(0)[0], timepts=STEP * np.arange(2000))), amplitude_dependence=(one,))
    checks = [check.level for check in alone.verdict.checks if check.remark.code is ModeCheck.BEATS]
    assert checks == [Level.DOUBTFUL] * beats


def test_a_ripple_of_some_percent_is_no_beat() -> None:
    """Windows of a bilinear spring end at halves of cycles that differ; the bands are those of white noise."""
    (found,) = identify(as_record(decay(0)[0], timepts=STEP * np.arange(2000))).amplitude_dependence
    for ripple, beats in ((0.15, False), (0.25, True)):
        zeta = np.array([1 - ripple, 1, 1 - ripple, 1, 1 - ripple])
        rows = {name: getattr(found, name)[:5] for name in ("amplitude", "wn", "wn_std", "spans")}
        assert replace(found, **rows, zeta=0.02 * zeta, zeta_std=np.full(5, 1e-5)).beats is beats


@pytest.mark.parametrize(
    ("zeta", "last", "low"), [([0.01, 0.02, 0.03, -0.002], 0.02, 2), ([0.01, 0.02, 0.025, 0.03], 5e-4, 3)]
)
def test_the_note_tells_of_swings_whose_damping_is_known(zeta: list[float], last: float, low: int) -> None:
    """Of the last swings in the noise the damping is open: no note says that it is negative there."""
    found = identify(as_record(decay(0)[0], timepts=STEP * np.arange(2000)))
    (each,) = found.amplitude_dependence
    rows = {name: getattr(each, name)[:4] for name in ("amplitude", "wn", "wn_std", "spans")}
    one = replace(each, **rows, zeta=np.array(zeta), zeta_std=np.array([5e-4, 5e-4, 5e-4, last]))
    (note,) = (
        check.remark.numbers
        for check in replace(found, amplitude_dependence=(one,)).verdict.checks
        if check.remark.code is ModeCheck.AMPLITUDE
    )
    assert note["low_zeta"] == pytest.approx(0.03)
    assert note["low_within"] == pytest.approx(NORMAL_95 * one.zeta_std[low])
    assert note["low"] == pytest.approx(one.amplitude[low])


def test_a_mode_lies_within_its_interval_of_its_table() -> None:
    """The mean over a decay may be at no amplitude of it; the interval then reaches to where the table has it."""
    modes = ModalSet(poles=np.array([-0.1 + 5.0j]), channels=("y",), covariance=1e-8 * np.eye(2))
    amplitude = np.array([4.0, 1.0])
    table = AmplitudeDependence(
        spans=((0.0, 1.0), (1.0, 2.0)),
        channel="y",
        amplitude=amplitude,
        wn=np.array([5.2, 5.0]),
        zeta=np.array([0.02, 0.04]),
        wn_std=1e-3 * amplitude,
        zeta_std=1e-4 * amplitude,
        holds_at=2.0,
    )
    assert table.at(2.0) == pytest.approx((5.1, 0.03))
    (wide,), (sure,) = (each.wn_std for each in (with_tables(modes, (table,)), modes) if each.wn_std is not None)
    assert wide == pytest.approx(5.1 - abs(modes.poles[0]), rel=1e-2)
    assert sure < 1e-3


@pytest.mark.parametrize("seed", [0, 1])
def test_identify_is_as_sure_as_its_table(seed: int) -> None:
    """Of a damping that follows no law of the library, the mean lies four standard deviations of the fit off it."""
    found = identify(as_record(decay(seed)[0], timepts=STEP * np.arange(2000)))
    (each,) = found.amplitude_dependence
    wn, zeta = each.at(each.holds_at)
    assert found.modes.wn_std is not None
    assert found.modes.zeta_std is not None
    assert abs(wn - found.modes.wn[0]) <= found.modes.wn_std[0]
    assert abs(zeta - found.modes.zeta[0]) <= found.modes.zeta_std[0]
