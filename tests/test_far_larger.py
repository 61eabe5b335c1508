"""A decay beside which the record moves far more: it is said."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from suspid import Identification, ModalSet, Settings, analyse, find_decays, identify
from suspid.analysis.far_larger import (
    _larger_are_unlike,
    _unlike,
    larger_elsewhere,
    only_the_end,
    shows_the_same,
)
from suspid.analysis.used import Used
from suspid.records import as_response, cut
from suspid.units import RealArray
from suspid.words import Check, Level, ModeCheck, Note, RecordCheck, Remark

TIME = np.arange(3000) / 100
KNOCK = np.where(TIME >= 20, np.exp(-1.5 * (TIME - 20)) * np.sin(30 * (TIME - 20)), 0.0)
SWING = np.exp(-0.4 * TIME) * np.sin(9 * TIME)


def notes(values: RealArray, *, start: float = 20.0, stop: float = 24.0) -> list[float]:
    record = as_response(TIME, np.atleast_2d(values), [f"y{k}" for k in range(len(np.atleast_2d(values)))])
    stretch = Used(record=cut(record, start=start, stop=stop), decays=(), used=(), notes=())
    return [float(str(note.numbers["times"])) for note in larger_elsewhere(record, stretch)]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_by_the_root_of_the_mean_square_of_a_part_as_long(scale: float) -> None:
    """Of the swing the first four seconds are the largest part, and 401 samples long as the knock's."""
    size = 0.02
    expected = np.std(SWING[:401]) / np.std(size * KNOCK[2000:2401])
    assert notes(scale * (SWING + size * KNOCK)) == [pytest.approx(expected, rel=0.05)]


def test_not_what_is_as_large_or_is_held_aside() -> None:
    assert notes(SWING + 0.5 * KNOCK) == []
    assert notes(0.5 * KNOCK + np.where(TIME < 10, 100.0, 0.0), start=20, stop=24) != []  # the step is motion
    held = np.where(TIME < 20, 100.0, 0.0)
    assert notes(held + KNOCK) == []


def test_every_channel_moves_more() -> None:
    assert notes(np.stack([SWING + 0.02 * KNOCK, KNOCK])) == []
    assert len(notes(np.stack([SWING + 0.02 * KNOCK, 2 * SWING + 0.02 * KNOCK]))) == 1


def test_a_tenth_of_the_amplitude_is_where_it_begins() -> None:
    ratio = np.std(SWING[:401]) / np.std(KNOCK[2000:2401])
    sizes = [ratio / 10 * share for share in (0.8, 1.2)]
    assert [len(notes(SWING + size * KNOCK)) for size in sizes] == [1, 0]


@pytest.mark.parametrize("code", [ModeCheck.LITTLE_EXPLAINED, ModeCheck.HARDLY_EXPLAINED])
def test_a_fit_that_leaves_much_of_a_longer_motion_does_not_come_before_its_end(code: ModeCheck) -> None:
    """The whole has another damping than its end: without the rest that it leaves, it would tell more."""
    time = TIME[:2000]
    bent = np.where(time < 8, np.exp(-0.1 * time), np.exp(-0.8 - 0.3 * (time - 8))) * np.sin(9 * time)
    noise = 1e-4 * np.random.default_rng(3).standard_normal(time.size)
    record = as_response(time, (bent + noise)[None], ["y"])
    whole, end = identify(record), identify(cut(record, start=9.0))
    assert only_the_end(whole, end)
    left = Check(Remark(code, {"most": 0.7}), Level.CARE)
    much = SimpleNamespace(
        modes=whole.modes,
        forces=whole.forces,
        fitted=whole.fitted,
        verdict=replace(whole.verdict, checks=(*whole.verdict.checks, left)),
    )
    assert not only_the_end(cast("Identification", much), end)


def followed(values: RealArray, *, start: float, stop: float) -> list[bool]:
    record = as_response(TIME, values, [f"y{k}" for k in range(len(values))])
    stretch = Used(record=cut(record, start=start, stop=stop), decays=(), used=(), notes=())
    return [bool(note.numbers["follows"]) for note in larger_elsewhere(record, stretch)]


@pytest.mark.parametrize(("ends", "follows"), [(20.0, [True]), (19.6, [True]), (18.4, []), (8.0, [])])
def test_the_end_of_a_larger_motion_need_not_be_its_end_in_every_channel(ends: float, follows: list[bool]) -> None:
    """Parts of a second that end up to half of one before the decay are followed by it at once, others are not."""
    large = np.where((ends - 4 < TIME) & (ends > TIME), 30 * np.sin(9 * TIME), 0.0)
    assert followed(np.stack([large + KNOCK, KNOCK]), start=20.0, stop=24.0) == follows


@pytest.mark.parametrize(("start", "follows"), [(4.0, [True]), (1.0, [])])
def test_where_there_is_no_room_a_quarter_of_the_decay_is_compared(start: float, follows: list[bool]) -> None:
    """A decay of twelve seconds after four of other motion, or after one: a shorter part is not compared."""
    time = TIME - start
    ring = np.where(time >= 0, np.exp(-0.1 * time) * np.sin(30 * time), 30 * np.sin(9 * TIME))
    values = np.stack([ring, np.where(time >= 0, ring, 0.0)])[:, : round(100 * (start + 12)) + 1]
    record = as_response(TIME[: values.shape[1]], values, ["a", "b"])
    stretch = Used(record=cut(record, start=start), decays=(), used=(), notes=())
    assert [bool(note.numbers["follows"]) for note in larger_elsewhere(record, stretch)] == follows


@pytest.mark.slow
def test_a_car_that_rides_on_its_tires_once_friction_holds_its_struts_is_doubted() -> None:
    """The body swings once and stops; then it goes on, on the tires alone, at a 25th of that size."""
    time = np.arange(0, 9, 0.005)
    since, after = time - 1.4, time - 3.2
    pushed = np.where((since > 0) & (after < 0), np.sin(2 * np.pi * since / 1.2) * np.minimum(since, 0.6), 0.0)
    rides = np.where(after > 0, np.exp(-0.065 * after) * np.sin(21.9 * after), 0.0)
    noise = 1e-3 * np.random.default_rng(1).standard_normal((2, time.size))
    values = np.stack([pushed + 0.025 * rides, 0.1 * pushed + 0.02 * rides]) + noise
    found = analyse(as_response(time, values, ["rear", "front"]))
    assert found.modes.wn == pytest.approx([21.9], rel=0.01)
    (said,) = [check for check in found.verdict.checks if check.remark.code is RecordCheck.LARGER_ELSEWHERE]
    assert said.level is Level.DOUBTFUL
    assert "is the end of another motion" in str(said)


def test_it_is_said_unless_the_part_was_chosen() -> None:
    noise = 1e-5 * np.random.default_rng(1).standard_normal(TIME.size)
    # Driven at first by what no decay explains, and knocked at later.
    record = as_response(
        TIME, (np.where(TIME < 12, np.sin(7 * TIME + 3 * np.sin(TIME)), 0) + 0.02 * KNOCK + noise)[None], ["y"]
    )
    found = analyse(record)
    assert [note.code for note in found.notes].count(Note.LARGER_ELSEWHERE) == 1
    (said,) = [check for check in found.verdict.checks if check.remark.code is RecordCheck.LARGER_ELSEWHERE]
    assert said.level is Level.CARE
    chosen = analyse(record, settings=Settings(start=20.0))
    assert Note.LARGER_ELSEWHERE not in {note.code for note in chosen.notes}


@pytest.mark.parametrize(("wn", "same"), [(20.5, True), (20.4, True), (21.4, False), (20.1, False)])
def test_a_decay_about_a_time_shows_the_same_modes(wn: float, same: bool) -> None:
    """Modes that differ by more than a hundredth are unlike; before and after the decay there is none."""
    noise = 1e-3 * np.random.default_rng(1).standard_normal(TIME.size)
    late = TIME - 5
    motion = np.where(late >= 0, np.exp(-0.6 * late) * np.cos(20.5 * late), 0.0)
    decays = find_decays(as_response(TIME, (motion + noise)[None], ["y"]))
    modes = ModalSet(poles=np.array([complex(-0.3, wn)]))
    assert [shows_the_same(decays, time, modes) for time in (2.0, 6.0, 29.0)] == [False, same, False]


@pytest.mark.slow
@pytest.mark.parametrize(("wn", "level"), [(20.5, Level.SOUND), (21.4, Level.CARE)])
def test_a_larger_release_answers_it_with_the_same_mode_alone(wn: float, level: Level) -> None:
    """A second release is a twentieth of the first, of the same mode or of one that is 4 % slower."""
    time = np.arange(0.0, 18.6, 0.01)
    first, late = time - 0.6, time - 9.6
    motion = np.where((first >= 0) & (late < 0), np.exp(-0.286 * first) * np.cos(wn * first), 0.0)
    motion += 0.05 * np.where(late >= 0, np.exp(-0.286 * late) * np.cos(20.5 * late), 0.0)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = analyse(as_response(time, (motion + noise)[None], ["y"]))
    assert found.used[0].start == pytest.approx(9.6, abs=0.1)
    assert Note.LARGER_ELSEWHERE in {note.code for note in found.notes}
    assert found.verdict.level is level


def pendulum(*, zeta: float, friction: float) -> RealArray:
    """Return a pendulum in counts at 20 Hz, held for a second and let go, that friction of its pivot stops.

    ``q'' + 2 zeta wn q' + .0015 |q'| q' / wn + friction sign(q') + wn^2 (q - q^3 / 900^2) = 0``, in steps of .5 ms.
    """
    wn, step, largest = 4.44, 1 / 2000, 210.0
    q, v, out = largest, 0.0, []
    for k in range(int(141 / step)):
        if k % 100 == 0:
            out.append(q)
        pull = -2 * zeta * wn * v - 0.0015 * abs(v) * v / wn - wn**2 * q * (1 - (q / 900) ** 2)
        v += step * pull
        v = v - np.sign(v) * friction * step if abs(v) > friction * step else 0.0
        q += step * v
    return np.asarray(np.round(439 + np.concatenate([np.full(20, largest), out])[: len(out)]))


@pytest.mark.parametrize(
    ("zeta", "friction"),
    [(0.0035, 1.2), *(pytest.param(*case, marks=pytest.mark.slow) for case in [(0.0035, 3.0), (0.002, 2.0)])],
)
def test_the_last_swings_are_not_used_for_all(zeta: float, friction: float, tmp_path: Path) -> None:
    """The end alone fits a line down to the noise, with the damping that friction gives to small swings."""
    values, path = pendulum(zeta=zeta, friction=friction), tmp_path / "pendulum.csv"
    time = np.arange(values.size) / 20
    np.savetxt(path, np.column_stack([time, values]), fmt="%.6g", delimiter=",", header="t [s],Pos", comments="")
    found = analyse(path)
    assert len(found.modes) == 1
    assert found.used[0].start < 2.0
    (dependence,) = found.identification.amplitude_dependence
    assert dependence.amplitude[0] > 100
    # Of one cycle: what the drag takes, and the friction, by equivalent linearisation.
    a = dependence.amplitude
    law = zeta + 4 / (3 * np.pi) * 0.0015 * a / 4.44 + 2 * friction / (np.pi * 4.44**2 * a)
    seen = (a > 20) & (a < 150)
    assert np.max(np.abs(dependence.zeta / law - 1)[seen]) < 0.2


@pytest.mark.parametrize("still", [0, 1])
@pytest.mark.parametrize(("zeta", "size", "end"), [(0.02, 10.0, True), (0.048, 10.0, False), (0.02, 1.5, False)])
def test_an_end_that_is_damped_otherwise_is_only_the_end(zeta: float, size: float, end: bool, still: int) -> None:
    """A tenth of the amplitude and 2.5 times the damping; the same damping, or a similar amplitude, is not."""
    noise = 1e-3 * np.random.default_rng(1).standard_normal((2, 1000))
    time = np.arange(1000) / 100
    # A sensor that hardly moves does not tell.
    rest = 1e-3 * np.random.default_rng(2).standard_normal((2, still, 1000))
    whole, part = (
        identify(
            as_response(
                time, np.vstack([s * np.exp(-z * 9 * time) * np.sin(9 * time) + e, r]), ["seat", "floor"][: 1 + still]
            )
        )
        for s, z, e, r in ((size, zeta, noise[0], rest[0]), (1.0, 0.05, noise[1], rest[1]))
    )
    assert only_the_end(whole, part) is end
    assert not only_the_end(whole, None)


@pytest.mark.parametrize(("bend", "end"), [(0.12, True), (0.01, False), (0.0, False)])
def test_a_linear_end_of_swings_of_another_frequency_is_only_the_end(bend: float, end: bool) -> None:
    """A spring that stiffens in proportion to the deflection: at the first swings by 5 %, .4 %, and not at all."""
    wn, zeta, time = 10.2, 0.006, np.arange(0.0, 37.0, 0.02)
    motion = solve_ivp(
        lambda _, x: [x[1], -(wn**2) * x[0] * (1 + bend * abs(x[0])) - 2 * zeta * wn * x[1]],
        (0.0, 37.0), [0.0, wn], t_eval=time, rtol=1e-9, atol=1e-11,
    ).y[:1]  # fmt: skip
    record = as_response(time, motion + 0.01 * np.random.default_rng(1).standard_normal(motion.shape), ["mass"])
    whole, part = identify(record), identify(cut(record, start=27.2))
    assert part.verdict.level is Level.SOUND
    assert only_the_end(whole, part) is end


def test_unlike_is_beyond_chance_and_by_a_share() -> None:
    """Of 10.0 +- .01: by half a hundredth, by 5 % where 1.96 sd are 5.9 % and where they are 2 %."""
    unlike = _unlike(np.array([10.05, 10.5, 10.5]), np.array([0.001, 0.3, 0.1]), 10.0, 0.01, 0.01)
    assert unlike.tolist() == [False, False, True]


@pytest.mark.parametrize(("drag", "unlike"), [(0.05, True), (0.0, False)])
def test_larger_swings_with_other_damping_are_unlike(drag: float, unlike: bool) -> None:
    """Of the same frequency: drag doubles the damping of the first swings, ``4 drag a / 3 pi`` beside .006."""
    wn, zeta, time = 10.2, 0.006, np.arange(0.0, 37.0, 0.02)
    motion = solve_ivp(
        lambda _, x: [x[1], -(wn**2) * x[0] - (2 * zeta * wn + drag * abs(x[1]) / wn) * x[1]],
        (0.0, 37.0), [0.0, wn * (10.0 if drag else 1.0)], t_eval=time, rtol=1e-9, atol=1e-11,
    ).y[:1]  # fmt: skip
    record = as_response(time, motion + 0.01 * np.random.default_rng(1).standard_normal(motion.shape), ["mass"])
    assert _larger_are_unlike(identify(record), identify(cut(record, start=20.0)).modes) is unlike


def test_one_decay_about_a_time_shows_all_of_the_modes() -> None:
    noise = 1e-3 * np.random.default_rng(1).standard_normal(TIME.size)
    late = TIME - 5
    motion = np.where(late >= 0, np.exp(-0.6 * late) * np.cos(20.5 * late), 0.0)
    (decay,) = find_decays(as_response(TIME, (motion + noise)[None], ["y"]))
    other = replace(decay, wn=np.array([7.0]))
    one, two = (ModalSet(poles=np.array(poles)) for poles in ([-0.3 + 20.5j], [-0.3 + 20.5j, -0.4 + 33.0j]))
    assert shows_the_same([other, decay], 6.0, one)
    assert not shows_the_same([decay], 6.0, two)
    assert not shows_the_same([other], 6.0, one)
